//! `doublet swing`: moments of inertia from an aircraft swung as a pendulum.

use std::path::PathBuf;

use clap::Args;
use doublet_engine::ground_tests::{SwingFile, Swung};

use crate::text::{self, number};

#[derive(Debug, Args)]
pub struct SwingArguments {
    /// Swing file (TOML): mass, lengths and times of each swing.
    pub swing: PathBuf,
}

/// Evaluates swings.
pub fn swing(arguments: &SwingArguments) -> Result<(), String> {
    let path = &arguments.swing;
    let found = SwingFile::open(path)?.evaluate().map_err(|error| format!("{}: {error}", path.display()))?;
    text::json(&found)?;
    print(&found);
    Ok(())
}

fn print(found: &Swung) {
    let header = ["swing", "period, s", "inertia about its axis, kg m²", "largest contribution, kg m²"];
    text::table(&header, &found.swings.iter().map(describe_swing).collect::<Vec<_>>());
    if found.tensor.is_empty() {
        text::line("these axes do not determine the tensor: add a swing about another axis");
        return;
    }
    let header = ["element", "value, kg m²", "95 % interval, kg m²"];
    text::table(&header, &found.tensor.iter().map(describe_element).collect::<Vec<_>>());
    if let Some(chi_squared) = found.chi_squared {
        let degrees = found.degrees_of_freedom;
        text::line(&format!("chi squared {} with {degrees} degrees of freedom", number(chi_squared, 3)));
    }
}

fn describe_swing(own: &doublet_engine::ground_tests::SwungRow) -> Vec<String> {
    let largest = own.contributions_kg_m2.iter().max_by(|a, b| a.1.total_cmp(b.1));
    vec![
        own.name.clone(),
        format!("{} ± {}", number(own.period_s, 5), number(own.period_error_s, 2)),
        format!("{} ± {}", number(own.inertia_kg_m2, 5), number(own.standard_error_kg_m2, 2)),
        largest.map_or_else(String::new, |(name, change)| format!("{name}, {}", number(*change, 2))),
    ]
}

fn describe_element(own: &doublet_engine::ground_tests::InertiaRow) -> Vec<String> {
    let [low, high] = own.interval_kg_m2;
    vec![
        own.name.to_owned(),
        format!("{} ± {}", number(own.value_kg_m2, 5), number(own.standard_error_kg_m2, 2)),
        format!("{} to {}", number(low, 5), number(high, 5)),
    ]
}
