//! The aircraft as the analysis uses it: reference geometry, mass properties, places of sensors and engines.

use doublet_core::airframe::{Aircraft, Loading};
use doublet_core::model::{Inertia, Position, RateNormalisation, ReferenceGeometry};

/// What the later stages need of an aircraft and its loading.
#[derive(Clone, Debug, PartialEq)]
pub struct AircraftData {
    /// Reference area, lengths and normalisation of rates.
    pub reference: ReferenceGeometry,
    /// Mass properties of the loading.
    pub inertia: Inertia,
    /// Place of the accelerometers.
    pub accelerometer: Option<Position>,
    /// Place of the flow vanes.
    pub vane: Option<Position>,
    /// Point the moment coefficients are about; the centre of gravity when there is none.
    pub moment_reference: Option<Position>,
    /// Place and thrust direction (unit vector, body axes) of each engine.
    pub engines: Vec<(Position, [f64; 3])>,
}

/// What the analysis uses of `aircraft` with `loading` on board.
///
/// # Errors
/// One line when a reference length has no counterpart in the model's normalisation.
pub fn aircraft_data(aircraft: &Aircraft, loading: &Loading) -> Result<AircraftData, String> {
    let mass = loading.mass_properties(aircraft);
    let engines = aircraft.engines.iter().map(|engine| {
        let (sin, cos) = engine.incidence_rad.sin_cos();
        (Position::Datum(engine.position_from_datum_m), [cos, 0.0, -sin])
    });
    let vanes = aircraft.sensors;
    Ok(AircraftData {
        reference: reference(&aircraft.reference)?,
        inertia: Inertia {
            mass_kg: mass.mass_kg,
            ixx_kg_m2: mass.inertia.xx,
            iyy_kg_m2: mass.inertia.yy,
            izz_kg_m2: mass.inertia.zz,
            ixz_kg_m2: mass.inertia.xz,
            cg_datum_m: mass.cg_from_datum_m,
        },
        accelerometer: vanes.accelerometer_from_datum_m.map(Position::Datum),
        vane: vanes.alpha_vane_from_datum_m.or(vanes.beta_vane_from_datum_m).map(Position::Datum),
        moment_reference: aircraft.moment_reference_from_datum_m.map(Position::Datum),
        engines: engines.collect(),
    })
}

/// Largest relative difference of two lengths that count as one: the rounding of printed lengths.
const SAME_LENGTH: f64 = 1e-6;

fn reference(stated: &doublet_core::airframe::ReferenceGeometry) -> Result<ReferenceGeometry, String> {
    let same = |a: f64, b: f64| (a - b).abs() <= SAME_LENGTH * b.abs();
    let lateral = stated.lateral_moment_length_m;
    let mut reference = ReferenceGeometry::new(stated.area_m2, lateral, stated.chord_m);
    reference.lateral_rates = if same(2.0 * stated.lateral_rate_length_m, lateral) {
        RateNormalisation::LengthOver2V
    } else if same(stated.lateral_rate_length_m, lateral) {
        RateNormalisation::LengthOverV
    } else {
        return Err(format!(
            "reference length {} m of roll and yaw rate: it must be {lateral} m or half of it, as in the moments",
            stated.lateral_rate_length_m
        ));
    };
    reference.beta_dot = reference.lateral_rates;
    reference.pitch_rate = if same(stated.pitch_rate_length_m, stated.chord_m) {
        RateNormalisation::LengthOverV
    } else if same(2.0 * stated.pitch_rate_length_m, stated.chord_m) {
        RateNormalisation::LengthOver2V
    } else {
        return Err(format!(
            "reference length {} m of pitch rate: it must be {} m or half of it, as in the moment",
            stated.pitch_rate_length_m, stated.chord_m
        ));
    };
    reference.alpha_dot = reference.pitch_rate;
    Ok(reference)
}
