//! `doublet weigh`: mass and centre of gravity of the empty aircraft from a weighing on scales.

use std::path::PathBuf;

use clap::Args;
use doublet_engine::graph::Context;
use doublet_engine::keep::Lock;
use doublet_engine::session;
use doublet_engine::stage::load_aircraft;
use doublet_engine::weigh::{Weighed, WeighingFile};

use crate::text::{self, number};

#[derive(Debug, Args)]
pub struct WeighArguments {
    /// Weighing file (TOML): scale readings, fuel and items on board.
    pub weighing: PathBuf,
    /// Session to which the empty mass and centre of gravity are written.
    #[arg(long, value_name = "FILE")]
    session: Option<PathBuf>,
}

/// Evaluates a weighing, and sets the empty aircraft of a session by it.
pub fn weigh(arguments: &WeighArguments) -> Result<(), String> {
    let path = &arguments.weighing;
    let named = |error: String| format!("{}: {error}", path.display());
    let file = WeighingFile::open(path)?;
    let folder = path.parent().map(PathBuf::from).unwrap_or_default();
    let context = Context::new(&folder);
    let loaded = load_aircraft(&context, &file.aircraft).map_err(|error| named(error.to_string()))?;
    let found = file.evaluate(&loaded.aircraft).map_err(named)?;
    if let Some(place) = &arguments.session {
        let _lock = Lock::lock_for_writing(place)?;
        let opened = session::open(place).map_err(|error| format!("{}: {error}", place.display()))?;
        let mut changed = opened.session.clone();
        found.apply(&mut changed.aircraft_changes);
        session::save(&changed, place).map_err(|error| error.to_string())?;
    }
    text::json(&found)?;
    print(&found);
    if let Some(place) = &arguments.session {
        text::line(&format!("empty mass and centre of gravity saved in {}", place.display()));
    }
    Ok(())
}

fn print(found: &Weighed) {
    let cells = [
        describe_mass("as weighed", found.mass_kg, found.cg_datum_m, [found.x_error_m, found.z_error_m]),
        describe_mass("empty", found.empty_mass_kg, found.empty_cg_datum_m, [None; 2]),
        describe_mass("aircraft file", found.stated_mass_kg, found.stated_cg_datum_m, [None; 2]),
    ];
    text::table(&["", "mass, kg", "x, m", "y, m", "z, m"], &cells);
    text::line(&format!(
        "{} attitudes, totals within {} kg, R2 {}, struts {} deg; {} kg taken off",
        found.attitudes,
        number(found.mass_spread_kg, 2),
        number(found.r_squared, 3),
        number(found.strut_pitch_rad.to_degrees(), 2),
        number(found.taken_off_kg, 4)
    ));
}

fn describe_mass(name: &str, mass: f64, [x, y, z]: [f64; 3], errors: [Option<f64>; 2]) -> Vec<String> {
    let error = |error: Option<f64>| error.map_or_else(String::new, |error| format!(" ± {}", number(error, 2)));
    vec![
        name.to_owned(),
        number(mass, 5),
        format!("{}{}", number(x, 4), error(errors[0])),
        number(y, 2),
        format!("{}{}", number(z, 4), error(errors[1])),
    ]
}
