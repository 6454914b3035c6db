//! A flight of a twin of 2,100 kg with the thesis's derivatives, flown by the replay from a 3-2-1-1 of elevator, aileron and rudder.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::airframe::{InertiaTensor, MassHistory, MassProperties, ReferenceGeometry};
use doublet_core::model::{AeroData, Coefficient, CoefficientSettings, Derivatives, Term};
use doublet_core::quantity::Role;
use doublet_core::replay::{Replay, Start};

/// Step, s.
pub const STEP_S: f64 = 0.02;
/// Gravity, m/s².
pub const GRAVITY_M_S2: f64 = 9.80665;

/// Derivatives by coefficient and term.
pub const TRUTH: [(Coefficient, &str, f64); 26] = [
    (Coefficient::CX, "1", 0.0),
    (Coefficient::CX, "alpha", 0.6),
    (Coefficient::CX, "qc/V", 0.25),
    (Coefficient::CX, "delta_e", 0.126),
    (Coefficient::CZ, "1", -0.521),
    (Coefficient::CZ, "alpha", -3.868),
    (Coefficient::CZ, "qc/V", -3.36),
    (Coefficient::CZ, "delta_e", -0.264),
    (Coefficient::Cm, "1", 0.06),
    (Coefficient::Cm, "alpha", -0.843),
    (Coefficient::Cm, "qc/V", -5.15),
    (Coefficient::Cm, "delta_e", -0.608),
    (Coefficient::CY, "beta", -0.515),
    (Coefficient::CY, "pb/2V", -0.08),
    (Coefficient::CY, "rb/2V", 0.38),
    (Coefficient::CY, "delta_a", 0.046),
    (Coefficient::CY, "delta_r", 0.169),
    (Coefficient::Cl, "beta", -0.106),
    (Coefficient::Cl, "pb/2V", -0.45),
    (Coefficient::Cl, "rb/2V", 0.24),
    (Coefficient::Cl, "delta_a", -0.172),
    (Coefficient::Cn, "beta", 0.042),
    (Coefficient::Cn, "pb/2V", -0.1),
    (Coefficient::Cn, "rb/2V", -0.113),
    (Coefficient::Cn, "delta_a", -0.01),
    (Coefficient::Cn, "delta_r", -0.078),
];

/// The truth as a model.
pub fn truth() -> Derivatives {
    TRUTH
        .iter()
        .filter_map(|(coefficient, term, value)| Some((*coefficient, Term::parse(term).ok()?, *value)))
        .collect()
}

/// A 3-2-1-1 of steps of half a second that begins at `start` s.
fn multistep(time_s: f64, start: f64, amplitude: f64) -> f64 {
    match time_s - start {
        t if (0.0..1.5).contains(&t) || (2.5..3.0).contains(&t) => amplitude,
        t if (1.5..2.5).contains(&t) || (3.0..3.5).contains(&t) => -amplitude,
        _ => 0.0,
    }
}

/// Window of `samples` with all three controls moved, and where it starts.
pub fn window(samples: usize) -> (AeroData, CoefficientSettings, Start) {
    let time_s: Vec<f64> = (0..samples).map(|k| STEP_S * k as f64).collect();
    let control = |start: f64, trim: f64, amplitude: f64| -> Arc<[f64]> {
        time_s.iter().map(|&t| trim + multistep(t, start, amplitude)).collect()
    };
    let column = |value: f64| vec![value; samples];
    let (alpha, elevator, airspeed) = (0.0866_f64, -0.0214, 46.0);
    let data = AeroData {
        airspeed_m_s: column(airspeed).into(),
        alpha_rad: column(alpha).into(),
        beta_rad: column(0.0).into(),
        rates_rad_s: [column(0.0), column(0.0), column(0.0)],
        specific_force_m_s2: [column(0.0), column(0.0), column(-GRAVITY_M_S2)],
        accelerometer: None,
        angular_acceleration_rad_s2: None,
        density_kg_m3: column(1.09).into(),
        controls: BTreeMap::from([
            (Role::Elevator, control(1.0, elevator, 0.03)),
            (Role::Aileron, control(0.5, 0.0, 0.05)),
            (Role::Rudder, control(5.0, 0.0, 0.05)),
        ]),
        mass: MassHistory::Constant(MassProperties {
            mass_kg: 2010.0,
            inertia: InertiaTensor { xz: 311.0, ..InertiaTensor::diagonal(5493.0, 5411.0, 9689.0) },
            cg_from_datum_m: [3.53, 0.0, 1.68],
        }),
        engines: Vec::new(),
        propeller_pressure: None,
        altitude_m: Some(column(1219.0).into()),
        mach: None,
        time_s: time_s.into(),
    };
    let settings = CoefficientSettings::new(ReferenceGeometry::conventional(18.7, 11.68, 1.68));
    let start = Start {
        position_ned_m: [0.0, 0.0, -1219.0],
        air_velocity_body_m_s: [airspeed * alpha.cos(), 0.0, airspeed * alpha.sin()],
        euler_rad: [0.0, alpha, 0.3],
        rates_rad_s: [0.0; 3],
    };
    (data, settings, start)
}

/// The window made ready to be flown in still air.
pub fn replay(samples: usize) -> Option<(Replay, Start)> {
    let (data, settings, start) = window(samples);
    let still = std::array::from_fn(|_| vec![0.0; samples]);
    Some((Replay::new(&data, &settings, &still, GRAVITY_M_S2).ok()?, start))
}
