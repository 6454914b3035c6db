//! Initial conditions of a record, from its data.

use std::f64::consts::TAU;

use doublet_core::quantity::Dimension;
use doublet_core::reconstruct::Measurement;
use doublet_core::validate::{Histories, Signal};

use super::units::shown;
use crate::notation::significant;
use crate::session::{Manoeuvre, Surface};
use crate::snapshot::Snapshot;
use crate::stage::{WindowAero, WindowPath, deflection};

/// What is said of what is missing.
pub(crate) const NOT_GIVEN: &str = "not given";

/// Speed, height, attitude, loading, power and configuration at the first sample.
pub fn initial(
    (window, path): (&Manoeuvre, &WindowPath),
    aero: &WindowAero,
    measured: &Histories,
    snapshot: &Snapshot,
    configuration: Option<&str>,
) -> Vec<(String, String)> {
    let first = |signal: Signal| measured.get(signal).first().copied();
    let stated_signal = |signal: Signal| stated(first(signal), signal.dimension());
    let altitude = aero.data.altitude_m.as_ref().and_then(|altitude| altitude.first().copied());
    let deflections = Surface::ALL.map(|surface| {
        let value = deflection(surface, aero).and_then(|values| values.first().copied());
        format!("{} {}", surface.name(), stated(value, Dimension::Angle))
    });
    let thrust: Option<f64> = match aero.data.engines.as_slice() {
        [] => None,
        engines => engines.iter().map(|engine| engine.thrust_n.first().copied()).sum(),
    };
    let mass = aero.data.mass.first();
    let flown = snapshot.flown.get(&window.flight).and_then(|slot| slot.ready());
    let chord = flown.and_then(|flown| flown.windows.iter().find(|(name, _)| *name == window.name));
    let chord = chord.and_then(|(_, state)| state.state.mean_chord_fraction);
    let chord = chord.map(|part| format!(", {} % of the mean chord", significant(100.0 * part, 3))).unwrap_or_default();
    let turned = first(Signal::HeadingAngle).map(|psi| psi.rem_euclid(TAU));
    let facts = [
        ("Airspeed", format!("{} (true)", stated_signal(Signal::Airspeed))),
        ("Pressure altitude", stated(altitude, Dimension::Length)),
        (
            "Attitude",
            format!(
                "bank {}, pitch {}, heading {}",
                stated_signal(Signal::BankAngle),
                stated_signal(Signal::PitchAngle),
                stated(turned, Dimension::Angle)
            ),
        ),
        ("Angle of attack", stated_signal(Signal::AngleOfAttack) + source(path, Measurement::AngleOfAttack)),
        ("Sideslip", stated_signal(Signal::Sideslip) + source(path, Measurement::Sideslip)),
        ("Controls", deflections.join(", ")),
        ("Mass", mass.map_or(NOT_GIVEN.to_owned(), |mass| format!("{} kg", significant(mass.mass_kg, 5)))),
        (
            "Centre of gravity",
            mass.map_or(NOT_GIVEN.to_owned(), |mass| {
                format!("{} m aft of the datum{chord}", significant(mass.cg_from_datum_m[0], 4))
            }),
        ),
        ("Thrust", stated(thrust, Dimension::Force)),
        ("Configuration", configuration.unwrap_or(NOT_GIVEN).to_owned()),
    ];
    facts.map(|(name, text)| (name.to_owned(), text)).into()
}

/// That a flow angle is reconstructed, where no vane measured it.
fn source(path: &WindowPath, vane: Measurement) -> &'static str {
    if path.missing.contains(&vane) { " (reconstructed, not measured)" } else { "" }
}

/// A number in the unit of the pages, or that it is not given.
pub fn stated(value: Option<f64>, dimension: Dimension) -> String {
    value.filter(|value| value.is_finite()).map_or(NOT_GIVEN.to_owned(), |value| shown(value, dimension))
}
