//! Three manoeuvres of the DLR ATTAS (VFW 614), from the raw recordings to the published derivatives.
//!
//! Constants, biases and answers: R. V. Jategaonkar, "Flight Vehicle System Identification", 2nd edition (AIAA, doi
//! 10.2514/4.102790), supplement. The published chain smooths airspeed and flow angles (after moving them to the centre
//! of gravity) by Spencer's formula, and differentiates the smoothed rates by the central difference of order 16; its own
//! regression table shows both to the last digit.

use std::collections::BTreeMap;

use doublet_core::airframe::{InertiaTensor, MassHistory, MassProperties, ReferenceGeometry};
use doublet_core::estimate::{PooledFit, PooledWindow, pooled};
use doublet_core::load::read_all;
use doublet_core::model::{
    AeroData, Coefficient, CoefficientSettings, Coefficients, Engine, Position, Structure, Term, ThrustTreatment,
    Variable, Variables, coefficients, regressors, variables,
};
use doublet_core::prep::{
    Differentiation, FlowVane, Smoothing, acceleration_at_cg, differentiate, flow_angles_at_cg, smooth,
};
use doublet_core::quantity::Role;
use doublet_core::series::Recording;

use super::shipped_map;
use crate::shared::shared;

/// Recordings, one manoeuvre each.
const RECORDINGS: [&str; 3] = ["fAttasElv1", "fAttasAil1", "fAttasRud1"];
/// Biases of ax ay az (m/s²) and p q r (rad/s) the published regression subtracts.
const BIASES: [f64; 6] = [6.76242e-3, -1.50664e-3, 8.39892e-2, 1.02555e-3, 3.40891e-3, 9.96192e-4];
/// Accelerometers from the centre of gravity, m.
const ACCELEROMETERS: [f64; 3] = [-1.010, 0.886, 0.103];
/// Nose boom from the centre of gravity, m.
const NOSE_BOOM: [f64; 3] = [13.080, -0.010, -0.027];
/// Aerodynamic centre, the moment reference, from the centre of gravity, m.
const AERODYNAMIC_CENTRE: [f64; 3] = [-0.02, -0.01, -0.12];
/// Left engine from the centre of gravity, m; the right one is its mirror image.
const LEFT_ENGINE: [f64; 3] = [-1.343, -2.990, -0.652];

/// Samples at each end where the published formulas for the ends reach.
const ENDS: usize = 16;

/// Coefficient, terms, published derivatives.
type Published = (Coefficient, &'static [&'static str], &'static [f64]);
const PUBLISHED: [Published; 6] = [
    (Coefficient::CD, &["1", "alpha"], &[0.0398479, 0.260400]),
    (Coefficient::CL, &["1", "alpha"], &[0.234957, 5.22568]),
    (Coefficient::Cm, &["1", "alpha", "qc/V", "delta_e"], &[0.0803194, -0.877620, -5.81993, -0.984060]),
    (Coefficient::CY, &["1", "beta"], &[-0.00491145, -1.00403]),
    (
        Coefficient::Cl,
        &["1", "beta", "pb/2V", "rb/2V", "delta_a"],
        &[1.83918e-4, -0.102680, -0.759763, 0.237672, -0.192475],
    ),
    (
        Coefficient::Cn,
        &["1", "beta", "pb/2V", "rb/2V", "delta_r"],
        &[0.00280780, 0.254494, -0.0444249, -0.134247, -0.143862],
    ),
];

/// How signals are treated before the coefficients are formed.
#[derive(Clone, Copy)]
struct Treatment {
    /// Smoothing of airspeed and flow angles.
    flow: Option<Smoothing>,
    /// Smoothing of the rates before differentiation.
    rates: Option<Smoothing>,
    /// Differentiation of the rates.
    differentiation: Differentiation,
}

/// The published treatment.
const AS_PUBLISHED: Treatment = Treatment {
    flow: Some(Smoothing::Spencer15),
    rates: Some(Smoothing::Spencer15),
    differentiation: Differentiation::Central { half_width: 8 },
};
/// Nothing smoothed but what the local slope needs.
const LOCAL_CUBIC: Treatment = Treatment {
    flow: None,
    rates: None,
    differentiation: Differentiation::LocalPolynomial { degree: 3, half_width: 5 },
};
/// Nothing smoothed at all, thesis Eq. D.1.
const PLAIN: Treatment = Treatment { flow: None, rates: None, differentiation: Differentiation::Central4 };

/// Samples of `role`, SI.
fn column(recording: &Recording, role: Role) -> Vec<f64> {
    recording.role(role).unwrap().series.values.to_vec()
}

/// Input columns of one recording, biases subtracted, moved to the centre of gravity and treated.
fn aero_data(recording: &Recording, treatment: Treatment) -> AeroData {
    let time_s = recording.role(Role::PitchRate).unwrap().series.time_s.to_vec();
    let unbiased = |role, bias: f64| -> Vec<f64> { column(recording, role).iter().map(|value| value - bias).collect() };
    let [ax, ay, az, p, q, r] = [
        Role::SpecificForceX,
        Role::SpecificForceY,
        Role::SpecificForceZ,
        Role::RollRate,
        Role::PitchRate,
        Role::YawRate,
    ]
    .into_iter()
    .zip(BIASES)
    .map(|(role, bias)| unbiased(role, bias))
    .collect::<Vec<_>>()
    .try_into()
    .unwrap();
    let treated = |values: &[f64], method: Option<Smoothing>| match method {
        Some(method) => smooth(&time_s, values, method).unwrap(),
        None => values.to_vec(),
    };
    let angular = [&p, &q, &r]
        .map(|rate| differentiate(&time_s, &treated(rate, treatment.rates), treatment.differentiation).unwrap());
    let rates_at = |k: usize| [p[k], q[k], r[k]];
    let mut force: [Vec<f64>; 3] = Default::default();
    for k in 0..time_s.len() {
        let moved = acceleration_at_cg(
            ACCELEROMETERS,
            [ax[k], ay[k], az[k]],
            rates_at(k),
            [angular[0][k], angular[1][k], angular[2][k]],
        );
        for (column, value) in force.iter_mut().zip(moved) {
            column.push(value);
        }
    }
    let vane = FlowVane::at(NOSE_BOOM);
    let [speed, alpha, beta] =
        [Role::TrueAirspeed, Role::AngleOfAttack, Role::Sideslip].map(|role| column(recording, role));
    let mut flow: [Vec<f64>; 3] = Default::default();
    for k in 0..time_s.len() {
        let (speed, alpha, beta) = flow_angles_at_cg(&vane, speed[k], alpha[k], beta[k], rates_at(k));
        for (column, value) in flow.iter_mut().zip([speed, alpha, beta]) {
            column.push(value);
        }
    }
    let [airspeed_m_s, alpha_rad, beta_rad] = flow.map(|values| treated(&values, treatment.flow));
    let engine = |role, side: f64| Engine {
        thrust_n: column(recording, role).into(),
        position: Position::BodyFromCg([LEFT_ENGINE[0], side * LEFT_ENGINE[1], LEFT_ENGINE[2]]),
        direction_body: [1.0, 0.0, 0.0],
        rotor_inertia_kg_m2: 0.0,
        speed_rad_s: Vec::new().into(),
    };
    AeroData {
        airspeed_m_s: airspeed_m_s.into(),
        alpha_rad: alpha_rad.into(),
        beta_rad: beta_rad.into(),
        rates_rad_s: [p, q, r],
        specific_force_m_s2: force,
        accelerometer: None,
        angular_acceleration_rad_s2: Some(angular),
        density_kg_m3: column(recording, Role::AirDensity).into(),
        controls: [Role::Aileron, Role::Elevator, Role::Rudder]
            .into_iter()
            .map(|role| (role, column(recording, role).into()))
            .collect(),
        mass: MassHistory::Constant(MassProperties {
            mass_kg: 17_631.0,
            inertia: InertiaTensor { xz: 11_442.0, ..InertiaTensor::diagonal(133_367.0, 252_687.0, 359_593.0) },
            cg_from_datum_m: [0.0; 3],
        }),
        engines: vec![engine(Role::Thrust1, 1.0), engine(Role::Thrust2, -1.0)],
        propeller_pressure: None,
        altitude_m: None,
        mach: None,
        time_s: time_s.into(),
    }
}

/// Settings of the published regression: semispan as the reference length of roll and yaw, `p* = p b / V`.
fn settings() -> CoefficientSettings {
    let reference =
        ReferenceGeometry { lateral_rate_length_m: 10.75, ..ReferenceGeometry::conventional(64.0, 10.75, 3.159) };
    CoefficientSettings {
        moment_reference: Some(Position::BodyFromCg(AERODYNAMIC_CENTRE)),
        thrust: ThrustTreatment::Removed,
        ..CoefficientSettings::new(reference)
    }
}

/// Structure of the published regression.
fn structure() -> Structure {
    let terms = |names: &[&str]| names.iter().map(|name| Term::parse(name).unwrap()).collect();
    Structure { models: PUBLISHED.iter().map(|(coefficient, names, _)| (*coefficient, terms(names))).collect() }
}

/// Coefficients and variables of each recording; `None` where the recordings are absent.
fn windows(treatment: Treatment) -> Option<Vec<(&'static str, Coefficients, Variables)>> {
    let map = shipped_map("attas");
    let settings = settings();
    let mut windows = Vec::new();
    for name in RECORDINGS {
        let recording = read_all(&[shared(&format!("data/attas/{name}.mat"))?], &map).unwrap();
        let data = aero_data(&recording, treatment);
        windows.push((name, coefficients(&data, &settings).unwrap(), variables(&data, &settings).unwrap()));
    }
    Some(windows)
}

/// The pooled fit of every coefficient, constants shared as published, without `ends` samples at both ends of each
/// recording.
fn fits(treatment: Treatment, ends: usize) -> Option<BTreeMap<Coefficient, PooledFit>> {
    let windows = windows(treatment)?;
    let fit = |(coefficient, terms): &(Coefficient, Vec<Term>)| {
        let names: Vec<String> = terms.iter().map(|term| term.derivative_name(*coefficient)).collect();
        let windows: Vec<PooledWindow> = windows
            .iter()
            .map(|(label, coefficients, variables)| {
                let kept = ends..variables.rows() - ends;
                let x = regressors(terms, variables).unwrap().rows(kept.start, kept.len()).into_owned();
                PooledWindow { label: (*label).to_owned(), x, z: coefficients.get(*coefficient)[kept].to_vec() }
            })
            .collect();
        (*coefficient, pooled(&names, &vec![false; names.len()], &windows).unwrap())
    };
    Some(structure().models.iter().map(fit).collect())
}

/// Differences from the published derivatives in per cent, by name, constants left out; prints the table.
#[expect(clippy::print_stdout, reason = "states the differences")]
fn differences(what: &str, fits: &BTreeMap<Coefficient, PooledFit>) -> BTreeMap<String, f64> {
    let mut differences = BTreeMap::new();
    println!("{what}: derivative, found, standard error, published, difference in per cent");
    for (coefficient, _, published) in PUBLISHED {
        let fit = &fits[&coefficient].fit;
        for (index, name) in fit.names.iter().enumerate() {
            let difference = 100.0 * (fit.estimates[index] / published[index] - 1.0);
            println!(
                "  {name:12} {:12.6} {:10.6} {:12.6} {difference:8.3}",
                fit.estimates[index], fit.standard_errors[index], published[index]
            );
            if !name.ends_with("_0") {
                differences.insert(name.clone(), difference);
            }
        }
        println!("  R2 of {} {:.6}", coefficient.name(), fit.quality.r_squared);
    }
    differences
}

#[test]
fn coefficients_match_the_published_regression_table_sample_by_sample() {
    /// Largest difference of a coefficient, without dimension: rounding of numbers near one, and of the 15 printed digits.
    const ROUNDING: f64 = 1e-12;
    let Some(path) = shared("data/attas/regression_table.csv") else { return };
    let Some(windows) = windows(AS_PUBLISHED) else { return };
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let table: Vec<Vec<f64>> = lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let mut start = 0;
    for (name, coefficients, variables) in &windows {
        for k in ENDS..variables.rows() - ENDS {
            let row = &table[start + k];
            let printed = |column: &str| row[header.iter().position(|other| *other == column).unwrap()];
            for coefficient in
                [Coefficient::CD, Coefficient::CL, Coefficient::CY, Coefficient::Cl, Coefficient::Cm, Coefficient::Cn]
            {
                let difference = coefficients.get(coefficient)[k] - printed(coefficient.name());
                assert!(
                    difference.abs() < ROUNDING,
                    "{name} sample {k}: {} differs by {difference:e}",
                    coefficient.name()
                );
            }
            for (variable, column) in [
                (Variable::Alpha, "alpha_rad"),
                (Variable::Beta, "beta_rad"),
                (Variable::Aileron, "da_rad"),
                (Variable::Elevator, "de_rad"),
                (Variable::Rudder, "dr_rad"),
            ] {
                let difference = variables.get(variable).unwrap()[k] - printed(column);
                assert!(difference.abs() < ROUNDING, "{name} sample {k}: {column} differs by {difference:e}");
            }
        }
        start += variables.rows();
    }
    assert_eq!(start, table.len());
}

#[test]
fn derivatives_match_published_attas_with_its_treatment() {
    /// Largest difference of the derivatives that large motions determine, per cent. The ends of each recording, 96 of
    /// 2,128 samples, are left out here and are part of the published fit.
    const STRONG_PERCENT: f64 = 0.3;
    let Some(fits) = fits(AS_PUBLISHED, ENDS) else { return };
    let differences = differences("as published", &fits);
    for name in ["CL_alpha", "Cm_alpha", "CY_beta", "Cl_p", "Cn_beta", "Cl_beta", "Cl_r", "Cl_delta_a"] {
        assert!(differences[name].abs() < STRONG_PERCENT, "{name} differs by {:.3} %", differences[name]);
    }
    for (coefficient, _, published) in PUBLISHED {
        let fit = &fits[&coefficient].fit;
        for index in 1..fit.names.len() {
            let difference = (fit.estimates[index] - published[index]).abs() / fit.standard_errors[index];
            assert!(difference < 1.0, "{} differs by {difference:.2} standard errors", fit.names[index]);
        }
    }
}

#[test]
fn derivatives_match_published_attas_with_local_polynomials() {
    /// Largest difference of any derivative, per cent.
    const LIMIT_PERCENT: f64 = 3.0;
    let Some(fits) = fits(LOCAL_CUBIC, 0) else { return };
    for (name, difference) in differences("local cubic over 11 samples, nothing else smoothed", &fits) {
        assert!(difference.abs() < LIMIT_PERCENT, "{name} differs by {difference:.3} %");
    }
}

#[test]
fn named_derivatives_match_published_attas_without_any_smoothing() {
    /// Largest difference of the derivatives that matter most, per cent.
    const LIMIT_PERCENT: f64 = 3.0;
    let Some(fits) = fits(PLAIN, 0) else { return };
    let differences = differences("nothing smoothed, central difference of order four", &fits);
    for name in ["CL_alpha", "Cm_alpha", "CY_beta", "Cl_p", "Cn_beta"] {
        assert!(differences[name].abs() < LIMIT_PERCENT, "{name} differs by {:.3} %", differences[name]);
    }
}
