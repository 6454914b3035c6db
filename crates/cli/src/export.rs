//! `doublet export`: the identified model for other simulators.

use std::path::PathBuf;

use clap::Args;
use doublet_core::model::ThrustTreatment;
use doublet_engine::export::{Format, IdentifiedModel, write};

use crate::output_path::output_path;
use crate::run::computed;
use crate::text;

#[derive(Debug, Args)]
pub struct ExportArguments {
    /// Session file.
    pub session: PathBuf,
    /// Formats: jsbsim, daveml.
    #[arg(long, value_delimiter = ',', default_value = "jsbsim,daveml")]
    pub format: Vec<String>,
    /// Folder for the files; only files of an earlier export are replaced.
    #[arg(long, value_parser = output_path())]
    pub out: PathBuf,
}

/// Computes the session and writes its model.
///
/// # Errors
/// One line per thing that is wrong; nothing is written then.
pub fn export(arguments: &ExportArguments) -> Result<(), String> {
    let formats = arguments.format.iter().map(|name| format(name)).collect::<Result<Vec<_>, _>>()?;
    let (session, snapshot) = computed(&arguments.session, &[])?;
    let model = IdentifiedModel::new(&session, &snapshot).map_err(|error| error.to_string())?;
    let put = write(&model, &formats, &arguments.out).map_err(|error| error.to_string())?;
    if model.thrust != ThrustTreatment::Removed {
        text::line("coefficients include thrust: valid only at the power flown");
    }
    put.notes().for_each(|note| text::line(&note));
    put.files.iter().for_each(|file| text::line(&file.display().to_string()));
    Ok(())
}

fn format(name: &str) -> Result<Format, String> {
    let known = || Format::ALL.map(Format::name).join(", ");
    Format::from_name(name.trim()).ok_or_else(|| format!("'{name}' is not a format: choose among {}", known()))
}
