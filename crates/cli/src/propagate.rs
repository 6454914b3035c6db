//! `doublet propagate`: a function of the derivatives with its interval.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use doublet_dynamics::propagate::Interval;
use doublet_engine::study::dynamics::{Named, named_values, propagate_expression};
use doublet_engine::study::{DynamicsRequest, Study};
use serde_json::json;

use crate::run::computed;
use crate::text::{self, number};

#[derive(Debug, Args)]
pub struct PropagateArguments {
    /// Session file.
    pub session: PathBuf,
    /// Expression, e.g. "-Cm_alpha/CZ_alpha": derivatives, S, b, c, V, rho, qbar, mass, Ixx..Ixz.
    #[arg(allow_hyphen_values = true)]
    pub expression: String,
    /// Random draws of the derivatives.
    #[arg(long, default_value_t = 2000, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    pub samples: u32,
    /// Random seed.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// Computes the session and prints the function.
pub fn propagate(arguments: &PropagateArguments) -> Result<(), String> {
    let request = DynamicsRequest { samples: 2, ..DynamicsRequest::default() };
    let (_, snapshot) = computed(&arguments.session, &[Study::Dynamics(request)])?;
    let study = snapshot.studies.dynamics.ready();
    let study = study.ok_or("no model: the session needs an aircraft and an identification manoeuvre")?;
    let Named { result, names } =
        propagate_expression(study, &arguments.expression, arguments.samples as usize, arguments.seed)
            .map_err(|error| error.to_string())?;
    let shares: Vec<_> = result.shares.iter().map(|(index, share)| (names[*index].clone(), *share)).collect();
    let interval = |interval: Interval| json!({ "standard_error": interval.standard_error, "low": interval.low, "high": interval.high });
    text::json(&json!({
        "expression": arguments.expression,
        "value": result.value,
        "delta": result.delta.map(interval),
        "sampled": result.sampled.map(interval),
        "shares": shares.iter().map(|(name, share)| json!({ "derivative": name, "share": share })).collect::<Vec<_>>(),
        "condition": named_values(study).into_iter().collect::<BTreeMap<_, _>>(),
        "samples": arguments.samples,
        "seed": arguments.seed,
    }))?;
    text::line(&format!("{} = {}", arguments.expression, number(result.value, 6)));
    for (way, interval) in [("by slopes", result.delta), ("by samples", result.sampled)] {
        if let Some(interval) = interval {
            let [error, low, high] =
                [interval.standard_error, interval.low, interval.high].map(|value| number(value, 4));
            text::line(&format!("{way}: standard error {error}, 95 % from {low} to {high}"));
        }
    }
    let largest = shares.iter().take(5).map(|(name, share)| format!("{name} {:.0} %", 100.0 * share));
    text::line(&format!("share of the variance: {}", largest.collect::<Vec<_>>().join(", ")));
    Ok(())
}
