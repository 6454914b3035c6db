//! Under what conditions the manoeuvres were flown, for the first page: loading, configuration, weather, and what kind of altitude is meant.

use doublet_core::quantity::Role;
use doublet_core::statistics::extent;

use super::{Contents, mass};
use crate::notation::significant;
use crate::report::MapRow;
use crate::session::WindowRole;

/// Loading, configuration and weather in a line each.
pub(super) fn conditions<'a>(contents: &Contents<'_>) -> Vec<(&'a str, String)> {
    let loading = loading(contents).map(|text| ("Loading", text));
    let known = [("Configuration", configuration(contents)), ("Weather", weather(contents))];
    loading.into_iter().chain(known).collect()
}

/// Mass, centre of gravity, and how the fuel is known.
fn loading(contents: &Contents<'_>) -> Option<String> {
    let mass = mass::mass_range(contents)?;
    let cg = mass::cg_range(contents).map_or_else(|| ", CG not known".to_owned(), |cg| format!(", CG {cg}"));
    let fuel = mass::fuel_basis(contents).map_or_else(String::new, |basis| format!(", fuel {basis}"));
    Some(format!("{mass}{cg}{fuel}"))
}

/// Flap deflection in the manoeuvres where it is recorded.
fn configuration(contents: &Contents<'_>) -> String {
    let aero = contents.session.active_windows().filter_map(|window| {
        let aero = contents.snapshot.windows.get(&window.name)?.aero.ready()?;
        extent(aero.data.controls.get(&Role::Flap)?.iter())
    });
    let ends: Vec<f64> = aero.flatten().filter(|end| end.is_finite()).collect();
    let flap = extent(&ends).map(|ends| ends.map(|end| significant(end.to_degrees(), 2)));
    match flap {
        Some([low, high]) if low == high => format!("flap {low}°; gear not recorded"),
        Some([low, high]) => format!("flap {low}° to {high}°; gear not recorded"),
        None => "flap and gear not recorded".to_owned(),
    }
}

/// Wind, gusts and the source of the air density.
fn weather(contents: &Contents<'_>) -> String {
    let results = contents.results;
    let flown = |row: &&MapRow| !row.is_candidate() && row.role != WindowRole::Ignored.name();
    let range = |value: &dyn Fn(&MapRow) -> Option<f64>| {
        let values: Vec<f64> = results.manoeuvre_map.iter().filter(flown).filter_map(value).collect();
        extent(&values).map(|ends| ends.map(|end| significant(end, 2)))
    };
    let wind = range(&|row| row.wind_m_s).map(|[low, high]| format!("wind {low} to {high} m/s"));
    let gusts = results.gusts.as_ref().map(|gusts| format!("gusts {}", gusts.summary()));
    let varying =
        || range(&|row| row.wind_deviation_m_s).map(|[_, high]| format!("wind varies by {high} m/s rms at most"));
    let mut densities: Vec<&str> = results.windows.iter().filter_map(|window| window.air_density).collect();
    densities.sort_unstable();
    densities.dedup();
    let density = (!densities.is_empty()).then(|| format!("air density: {}", densities.join("; ")));
    let known: Vec<String> = [wind, gusts.or_else(varying), density].into_iter().flatten().collect();
    if known.is_empty() { "not known".to_owned() } else { known.join("; ") }
}

/// What altitudes are: of the static pressure, of the satellites, or of the flight path.
pub(super) fn altitude_kind(contents: &Contents<'_>) -> &'static str {
    let is_recorded = |role: Role| {
        let mut channels = contents.results.flights.iter().flat_map(|flight| &flight.channels);
        channels.any(|row| row.role == role.name())
    };
    match (is_recorded(Role::Altitude), is_recorded(Role::GpsAltitude)) {
        (true, _) => "pressure altitude",
        (false, true) => "GPS altitude",
        (false, false) => "altitude of the flight path",
    }
}
