//! `doublet variants`: the pooled derivatives by other forms of least squares beside the ordinary one; nothing is changed.

use std::path::PathBuf;

use clap::Args;
use doublet_core::estimate::Constraint;
use doublet_engine::report::form_table;
use doublet_engine::study::{FormEstimates, FormRequest, least_squares_forms};

use crate::run::{self, computed};
use crate::text;

#[derive(Debug, Args)]
pub struct VariantArguments {
    /// Session file.
    pub session: PathBuf,
    /// Known value, range or prior: Cm_q=-5, Cm_q=-8..-4, Cl_p=-0.45~0.05.
    #[arg(long, value_name = "NAME=KNOWN", value_parser = knowledge, allow_hyphen_values = true)]
    pub know: Vec<(String, Constraint)>,
    /// Noise of a regressor, standard deviation: Cm_alpha=5e-4.
    #[arg(long, value_name = "NAME=STD", value_parser = deviation)]
    pub noise: Vec<(String, f64)>,
    /// Autoregression order of the residuals in the generalised fit.
    #[arg(long, default_value_t = 2)]
    pub order: usize,
}

fn value(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| format!("'{text}' is not a number"))
}

fn knowledge(text: &str) -> Result<(String, Constraint), String> {
    let (name, known) = text.split_once('=').ok_or("write it as NAME=VALUE, NAME=LOWER..UPPER or NAME=MEAN~STD")?;
    let constraint = match (known.split_once(".."), known.split_once('~')) {
        (Some((lower, upper)), _) => Constraint::Bounds { lower: value(lower)?, upper: value(upper)? },
        (None, Some((mean, deviation))) => Constraint::Prior { mean: value(mean)?, deviation: value(deviation)? },
        (None, None) => Constraint::Fixed(value(known)?),
    };
    Ok((name.trim().to_owned(), constraint))
}

fn deviation(text: &str) -> Result<(String, f64), String> {
    let (name, deviation) = text.split_once('=').ok_or("write it as NAME=STD, for example Cm_alpha=5e-4")?;
    Ok((name.trim().to_owned(), value(deviation)?))
}

/// Prints every derivative by every form.
pub fn variants(arguments: &VariantArguments) -> Result<(), String> {
    let (session, snapshot) = computed(&arguments.session, &[])?;
    let request = FormRequest { known: arguments.know.clone(), noise: arguments.noise.clone(), order: arguments.order };
    let windows = snapshot.aero(&session);
    let found = least_squares_forms(&windows, &session, &request).map_err(|error| error.to_string())?;
    let mut done = 0;
    for coefficient in found {
        let Ok(coefficient) = coefficient.inspect_err(|error| run::print_error(&error.to_string())) else { continue };
        done += 1;
        for FormEstimates { form, found } in &coefficient.forms {
            if let Err(error) = found {
                text::line(&format!("{form}: {error}"));
            }
        }
        text::show(&form_table(&coefficient));
        text::line("");
    }
    run::some_done(done)
}
