//! Intervals, root loci, responses and measured modes.

use doublet_core::airframe::{InertiaTensor, MassProperties, ReferenceGeometry};
use doublet_core::model::Position;
use doublet_core::model::{Axes, Coefficient, Derivatives, Term, ThrustTreatment};
use doublet_dynamics::linear::{
    Condition, FlightModel, LinearError, Method, Part, SteadyFlight, ThrustLine, UncertainModel, linearise,
};
use doublet_dynamics::modes::{Figure, LocusParameter, fit_free_response, locus, mode_study, modes, phasors};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// A light aircraft of linear derivatives, and level flight.
fn aircraft() -> (UncertainModel, Condition) {
    use Coefficient::{CX, CY, CZ, Cl, Cm, Cn};
    let rows = [
        (CX, "1", -0.035),
        (CX, "alpha", 0.25),
        (CZ, "1", -0.3),
        (CZ, "alpha", -4.9),
        (CZ, "delta_e", -0.4),
        (CZ, "qc/V", -3.0),
        (Cm, "1", 0.03),
        (Cm, "alpha", -0.7),
        (Cm, "qc/V", -12.0),
        (Cm, "delta_e", -1.2),
        (CY, "beta", -0.5),
        (CY, "delta_r", 0.15),
        (Cl, "beta", -0.08),
        (Cl, "pb/2V", -0.5),
        (Cl, "rb/2V", 0.12),
        (Cl, "delta_a", -0.15),
        (Cl, "delta_r", 0.01),
        (Cn, "beta", 0.07),
        (Cn, "pb/2V", -0.04),
        (Cn, "rb/2V", -0.11),
        (Cn, "delta_a", 0.005),
        (Cn, "delta_r", -0.07),
    ];
    let derivatives: Derivatives =
        rows.iter().map(|&(coefficient, term, value)| (coefficient, Term::parse(term).unwrap(), value)).collect();
    let model = FlightModel {
        derivatives,
        reference: ReferenceGeometry::conventional(16.2, 10.9, 1.5),
        axes: Axes::Body,
        moment_reference: None,
        thrust: ThrustTreatment::Removed,
        engines: vec![ThrustLine {
            position: Position::BodyFromCg([2.0, 0.0, 0.0]),
            direction_body: [1.0, 0.0, 0.0],
            share: 1.0,
        }],
    };
    let mass = MassProperties {
        mass_kg: 1100.0,
        cg_from_datum_m: [2.0, 0.0, 0.0],
        inertia: InertiaTensor { xz: 60.0, ..InertiaTensor::diagonal(1300.0, 1800.0, 2700.0) },
    };
    let condition = Condition {
        airspeed_m_s: 55.0,
        altitude_m: 1000.0,
        density_kg_m3: 1.112,
        speed_of_sound_m_s: 336.0,
        gravity_m_s2: 9.80665,
        gamma_rad: Some(0.0),
        flight: SteadyFlight::Straight,
        mass,
        thrust_slope_n_s_m: -15.0,
        pressure_rise_pa: 0.0,
        rotor_momentum_n_m_s: 0.0,
        recorded: Default::default(),
    };
    let mut uncertain = UncertainModel::exact(model);
    let values = uncertain.values();
    // Errors of two per cent, correlated along the derivatives of a coefficient.
    let entries = uncertain.model.derivatives.entries().to_vec();
    uncertain.covariance = DMatrix::from_fn(values.len(), values.len(), |i, j| {
        let correlation = if i == j {
            1.0
        } else if entries[i].coefficient == entries[j].coefficient {
            0.3
        } else {
            0.0
        };
        correlation * 4e-4 * (values[i] * values[j]).abs()
    });
    (uncertain, condition)
}

#[test]
fn delta_method_and_sampling_agree() {
    let (model, condition) = aircraft();
    let study = mode_study(&model, &condition, 4000, 7).unwrap();
    let names: Vec<_> = study.modes.iter().map(|estimate| estimate.mode.name).collect();
    assert_eq!(names.len(), 5);
    for name in ["short period", "phugoid", "Dutch roll", "roll subsidence", "spiral"] {
        assert!(names.contains(&name), "{names:?}");
    }
    assert_eq!((study.samples.len(), study.without_trim), (4000, 0));
    for estimate in &study.modes {
        for figure in [Figure::Real, Figure::Imaginary, Figure::Frequency, Figure::Damping, Figure::Period] {
            let Some(found) = estimate.figure(figure) else { continue };
            let (Some(delta), Some(sampled)) = (found.delta, found.sampled) else {
                assert!(!estimate.mode.oscillates() && figure != Figure::Real);
                continue;
            };
            let ratio = sampled.standard_error / delta.standard_error;
            let (low, high) =
                ((sampled.low - delta.low) / delta.standard_error, (sampled.high - delta.high) / delta.standard_error);
            println!("{} {figure:?} {ratio:.3} {low:+.3} {high:+.3}", estimate.mode.name);
            // Scatter of 4000 samples: 1.1 % of the error, 4 % of it at the quantiles; curvature the rest.
            assert!((ratio - 1.0).abs() < 0.06, "{} {figure:?}: {ratio}", estimate.mode.name);
            assert!(low.abs() < 0.25 && high.abs() < 0.25, "{} {figure:?}: {low} {high}", estimate.mode.name);
        }
    }
    // The same seed, the same numbers; another one, others.
    let again = mode_study(&model, &condition, 50, 7).unwrap();
    assert_eq!(again.samples[..], study.samples[..50]);
    assert_ne!(mode_study(&model, &condition, 50, 8).unwrap().samples[0], again.samples[0]);
}

#[test]
fn covariance_of_the_matrices_is_that_of_samples() {
    let (model, condition) = aircraft();
    let sensitivities = model.sensitivities(&condition).unwrap();
    let covariance = sensitivities.covariance(&model, Part::Longitudinal);
    assert_eq!(covariance.shape(), (24, 24));
    let samples: Vec<Vec<f64>> = model
        .samples(3000, 3)
        .iter()
        .map(|values| {
            let part =
                linearise(&model.with_values(values), &condition, Method::Analytic).unwrap().part(Part::Longitudinal);
            part.a.iter().chain(part.b.iter()).copied().collect()
        })
        .collect();
    let mut compared = 0;
    for entry in 0..24 {
        let mean = samples.iter().map(|row| row[entry]).sum::<f64>() / 3000.0;
        let error = (samples.iter().map(|row| (row[entry] - mean).powi(2)).sum::<f64>() / 2999.0).sqrt();
        let stated = covariance[(entry, entry)].sqrt();
        if stated > 1e-9 {
            assert!((error / stated - 1.0).abs() < 0.06, "entry {entry}: {error} {stated}");
            compared += 1;
        }
    }
    assert!(compared >= 12, "{compared}");
    // q' by elevator is q S c Cm_delta_e / Iyy: two per cent of it.
    let part = sensitivities.nominal.part(Part::Longitudinal);
    let place = 16 + 2;
    assert!((covariance[(place, place)].sqrt() / (0.02 * part.b[(2, 0)].abs()) - 1.0).abs() < 1e-6);
}

#[test]
fn root_locus_follows_the_parameter() {
    let (model, condition) = aircraft();
    let parameter = LocusParameter::parse("Cm_alpha");
    let points = locus(&model, &condition, &parameter, &[-1.2, -0.7, 0.05]).unwrap();
    let short = |index: usize| {
        let modes = points[index].modes.as_ref().unwrap();
        modes.iter().find(|mode| mode.name == "short period").map(|mode| mode.frequency_rad_s())
    };
    assert!(short(0).unwrap() > short(1).unwrap());
    let names: Vec<_> = points[2].modes.as_ref().unwrap().iter().map(|mode| mode.name).collect();
    assert!(names.contains(&"aperiodic short period"), "{names:?}");
    // Moving the centre of gravity aft by dx adds CZ_alpha dx / c to Cm_alpha where the moments are about a fixed point.
    let mut fixed = model.clone();
    fixed.model.moment_reference = Some(Position::Datum([2.0, 0.0, 0.0]));
    let points = locus(&fixed, &condition, &LocusParameter::parse("cg"), &[1.9, 2.0, 2.1]).unwrap();
    let frequency = |index: usize| {
        points[index].modes.as_ref().unwrap().iter().find(|mode| mode.name == "short period").unwrap().frequency_rad_s()
    };
    assert!(frequency(0) > frequency(1) && frequency(1) > frequency(2));
    let unknown = locus(&model, &condition, &LocusParameter::parse("Cm_gamma"), &[0.0]).unwrap_err();
    assert_eq!(unknown, LinearError::NoDerivative { name: "Cm_gamma".into() });
}

#[test]
fn phasors_satisfy_the_equations_of_the_motion() {
    let (model, condition) = aircraft();
    let lateral = linearise(&model.model, &condition, Method::Analytic).unwrap().part(Part::LateralAir);
    let found = modes(&lateral);
    let dutch = found.iter().find(|mode| mode.name == "Dutch roll").unwrap();
    let phasor = phasors(dutch, lateral.state("beta").unwrap());
    let (p, r, phi) = (phasor[1], phasor[2], phasor[3]);
    // Level trim: phi' = p + tan(theta) r, as phasors s phi = p + tan(theta) r.
    let tan = lateral.a[(3, 2)];
    assert!((dutch.eigenvalue() * phi - (p + r * tan)).norm() < 1e-9);
    assert!((phasor[0].re - 1.0).abs() < 1e-12 && phasor[0].im.abs() < 1e-12);
    assert!((dutch.participation.iter().sum::<f64>() - 1.0).abs() < 1e-12);
}

#[test]
fn free_response_gives_its_modes_within_their_errors() {
    // Dutch roll and roll mode in two signals of 20 Hz over 12 s with white noise, 200 times over.
    let truth = [(-0.20_f64, 1.40_f64), (-2.5, 0.0)];
    let step_s = 0.05;
    let clean = |amplitudes: [f64; 3], t: f64| {
        let [(a, b), (c, _)] = truth;
        0.3 + (a * t).exp() * (amplitudes[0] * (b * t).cos() + amplitudes[1] * (b * t).sin())
            + amplitudes[2] * (c * t).exp()
    };
    let (mut held, mut off, mut all) = ([0; 3], [0.0; 3], 0);
    for seed in 0..200 {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut signal = |amplitudes: [f64; 3]| -> Vec<f64> {
            (0..240)
                .map(|k| {
                    let noise: f64 = StandardNormal.sample(&mut random);
                    clean(amplitudes, f64::from(k) * step_s) + 0.01 * noise
                })
                .collect()
        };
        let signals = [signal([1.0, 0.2, -0.6]), signal([0.1, -0.8, 0.5])];
        let found = fit_free_response(&[&signals[0], &signals[1]], step_s, 3);
        let found = found.unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert_eq!(found.modes.len(), 2, "seed {seed}");
        let (dutch, roll) = (
            found.modes.iter().find(|mode| mode.imaginary_rad_s > 0.0),
            found.modes.iter().find(|mode| mode.imaginary_rad_s == 0.0),
        );
        let (dutch, roll) = (dutch.unwrap(), roll.unwrap());
        let errors = [
            (dutch.real_1_s - truth[0].0, dutch.real_error),
            (dutch.imaginary_rad_s - truth[0].1, dutch.imaginary_error),
            (roll.real_1_s - truth[1].0, roll.real_error),
        ];
        for (index, (error, stated)) in errors.into_iter().enumerate() {
            held[index] += usize::from(error.abs() < 1.96 * stated);
            off[index] += error / stated;
        }
        all += 1;
    }
    println!("95 % intervals hold the truth in {held:?} of {all}, mean error over error {off:?}");
    for index in 0..3 {
        // 95 % of 200, three standard deviations of a binomial.
        assert!((181..=199).contains(&held[index]), "{held:?}");
        assert!((off[index] / 200.0).abs() < 0.3, "{off:?}");
    }
    let exact: Vec<f64> = (0..240).map(|k| clean([1.0, 0.2, -0.6], f64::from(k) * step_s)).collect();
    let found = fit_free_response(&[&exact], step_s, 3).unwrap();
    assert!(
        (found.modes[1].real_1_s + 0.20).abs() < 1e-6 && (found.modes[1].imaginary_rad_s - 1.40).abs() < 1e-6,
        "{found:?}"
    );
    assert!(fit_free_response(&[&exact[..10]], step_s, 3).unwrap_err().to_string().contains("too few"));
}
