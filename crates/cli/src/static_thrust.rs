//! `doublet static-thrust`: the pull of the engines at rest beside their models.

use std::path::PathBuf;

use clap::Args;
use doublet_engine::graph::Context;
use doublet_engine::ground_tests::{Pulled, StaticThrustFile};
use doublet_engine::stage::load_aircraft;

use crate::text::{self, number};

#[derive(Debug, Args)]
pub struct StaticThrustArguments {
    /// Static thrust file (TOML): pull, engine settings and air.
    pub test: PathBuf,
}

/// Evaluates a static thrust test.
pub fn static_thrust(arguments: &StaticThrustArguments) -> Result<(), String> {
    let path = &arguments.test;
    let named = |error: String| format!("{}: {error}", path.display());
    let file = StaticThrustFile::open(path)?;
    let folder = path.parent().map(PathBuf::from).unwrap_or_default();
    let loaded = load_aircraft(&Context::new(&folder), &file.aircraft).map_err(|error| named(error.to_string()))?;
    let found = file.evaluate(&loaded.powerplant).map_err(named)?;
    text::json(&found)?;
    print(&found);
    Ok(())
}

fn print(found: &Pulled) {
    let header = ["thrust, N", "of the models, N", "ratio", "CT", "density, kg/m³"];
    text::table(&header, &found.readings.iter().map(describe_reading).collect::<Vec<_>>());
    let beyond =
        found.readings.iter().enumerate().flat_map(|(place, own)| own.off_range.iter().map(move |text| (place, text)));
    beyond.for_each(|(place, own)| text::line(&format!("reading {}: {own}", place + 1)));
    let [low, high] = found.factor_interval;
    text::line(&format!(
        "measured thrust is {} ± {} times that of the models (95 % interval {} to {}); residual {} N, friction {} N",
        number(found.factor, 4),
        number(found.factor_error, 2),
        number(low, 4),
        number(high, 4),
        number(found.residual_n, 2),
        number(found.friction_error_n, 2)
    ));
    text::line(if found.model_agrees {
        "the models agree with the pull within its error"
    } else {
        "the models differ from the pull by more than its error"
    });
}

fn describe_reading(own: &doublet_engine::ground_tests::PulledReading) -> Vec<String> {
    vec![
        format!("{} ± {}", number(own.thrust_n, 5), number(own.standard_error_n, 2)),
        number(own.model_n, 5),
        number(own.ratio, 4),
        number(own.thrust_coefficient, 4),
        number(own.density_kg_m3, 4),
    ]
}
