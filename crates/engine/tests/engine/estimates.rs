//! Properties every estimate of the engine keeps: the order of terms, the order of windows and the number of threads do not matter.

use crate::flight;
use std::sync::Arc;

use doublet_core::estimate::{Constraint, Fit, FitQuality, Origin};
use doublet_core::model::{AeroData, Coefficient, Structure, Term, regressors};
use doublet_core::quantity::Role;
use doublet_core::series::TimeRange;
use doublet_engine::session::{
    Estimation, InstrumentAccuracy, Manoeuvre, PooledConstants, PredictionParameters, ResidualWeights, Surface,
    TermConstraint, WindowFlags, WindowRole,
};
use doublet_engine::stage::{
    AeroWindow, AirDensity, CoefficientFit, PooledFits, Prediction, WindowAero, condition_samples, control_delays,
    errors, measure_condition, pooled_fits, window_fits,
};
use nalgebra::DVector;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Largest relative change of an estimate: rounding times the condition number of the regressors, about a hundred.
const REORDERING: f64 = 1e-12;
/// Windows.
const WINDOWS: usize = 5;

/// Windows of a known flight, each with a little noise of its own so that no model fits exactly.
fn windows() -> Vec<(Manoeuvre, Arc<WindowAero>)> {
    let samples = 400;
    let (data, settings, _) = flight::window(samples);
    let (replay, start) = flight::replay(samples).unwrap();
    let window = |index: usize| {
        let mut begin = start;
        begin.rates_rad_s[0] = 0.02 * index as f64;
        begin.air_velocity_body_m_s[1] = 0.5 * index as f64 - 1.0;
        let flown = replay.fly(&flight::truth(), &begin).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(index as u64);
        let mut shaken = |column: &Vec<f64>, by: f64| -> Vec<f64> {
            column.iter().map(|value| value + by * rng.random_range(-1.0..1.0)).collect()
        };
        let data = AeroData {
            airspeed_m_s: flown.airspeed_m_s.clone().into(),
            alpha_rad: flown.alpha_rad.clone().into(),
            beta_rad: flown.beta_rad.clone().into(),
            rates_rad_s: flown.rates_rad_s.clone(),
            specific_force_m_s2: flown.specific_force_m_s2.each_ref().map(|column| shaken(column, 0.02)),
            angular_acceleration_rad_s2: Some(
                flown.angular_acceleration_rad_s2.each_ref().map(|column| shaken(column, 0.01)),
            ),
            ..data.clone()
        };
        let manoeuvre = Manoeuvre {
            name: format!("w{index}"),
            flight: "f".to_owned(),
            window: TimeRange { start_s: 0.0, end_s: 8.0 },
            role: WindowRole::Identification,
            also: None,
            surface: None,
            kind: String::new(),
            note: String::new(),
            flags: WindowFlags::default(),
            excluded: Vec::new(),
        };
        (manoeuvre, Arc::new(WindowAero::form(data, settings.clone(), AirDensity::Recorded).unwrap()))
    };
    (0..WINDOWS).map(window).collect()
}

/// Pooled fits over the windows in `order` with the terms of every coefficient turned by `turn`, on `threads` threads.
fn estimate(all: &[(Manoeuvre, Arc<WindowAero>)], order: &[usize], turn: usize, threads: usize) -> PooledFits {
    let windows: Vec<AeroWindow<'_>> = order.iter().map(|&index| (&all[index].0, Arc::clone(&all[index].1))).collect();
    let mut structure = Structure::thesis();
    for (_, terms) in &mut structure.models {
        let turn = turn % terms.len();
        terms.rotate_left(turn);
    }
    let estimation = Estimation { by_surface: false, ..Estimation::default() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| pooled_fits(&windows, &structure, &estimation))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn estimate_does_not_depend_on_orders_or_threads(
        order in Just((0..WINDOWS).collect::<Vec<_>>()).prop_shuffle(), turn in 0_usize..6, threads in 1_usize..5
    ) {
        let all = windows();
        let plain = estimate(&all, &(0..WINDOWS).collect::<Vec<_>>(), 0, 1);
        let other = estimate(&all, &order, turn, threads);
        prop_assert_eq!(plain.fits.len(), 6);
        for (plain, other) in plain.fits.iter().zip(&other.fits) {
            let (fit, again) = (plain.fit.as_ref().unwrap(), other.fit.as_ref().unwrap());
            prop_assert_eq!(fit.parameters(), again.parameters());
            for (index, name) in fit.names.iter().enumerate() {
                let (a, s_a) = fit.parameter(name).unwrap();
                let (b, s_b) = again.parameter(name).unwrap();
                // An estimate near zero is known to its standard error, not to a part of itself.
                prop_assert!((a - b).abs() <= REORDERING * a.abs().max(s_a), "{}: {} {}", name, a, b);
                prop_assert!((s_a - s_b).abs() <= REORDERING * s_a, "{}: {} {}", name, s_a, s_b);
                let place = again.names.iter().position(|other| other == name).unwrap();
                let (c_a, c_b) = (plain.corrected_errors[index], other.corrected_errors[place]);
                // Transforms, a ratio of spectra and a quadratic form between two inverses: more roundings, a hundred times larger.
                prop_assert!((c_a - c_b).abs() <= 1000.0 * REORDERING * c_a, "{}: {} {}", name, c_a, c_b);
            }
        }
    }

    #[test]
    fn threads_alone_change_not_one_bit(threads in 2_usize..6) {
        let all = windows();
        let order: Vec<usize> = (0..WINDOWS).collect();
        let (plain, other) = (estimate(&all, &order, 0, 1), estimate(&all, &order, 0, threads));
        for (plain, other) in plain.fits.iter().zip(&other.fits) {
            prop_assert_eq!(plain.fit.as_ref().unwrap(), other.fit.as_ref().unwrap());
            prop_assert_eq!(&plain.corrected_errors, &other.corrected_errors);
        }
    }
}

/// What is known of one derivative, windows not told apart by their surface unless `by_surface`.
fn knowing(coefficient: Coefficient, term: &str, known: Constraint, by_surface: bool) -> Estimation {
    let term = Term::parse(term).unwrap();
    let constraints = vec![TermConstraint { coefficient, term, known }];
    Estimation { by_surface, constraints, ..Estimation::default() }
}

fn of(fits: &[CoefficientFit], coefficient: Coefficient) -> &CoefficientFit {
    fits.iter().find(|fit| fit.coefficient == coefficient).unwrap()
}

/// Value of a derivative of the flights.
fn truth(name: &str) -> f64 {
    let named = flight::truth();
    named.entries().iter().find(|entry| entry.term.derivative_name(entry.coefficient) == name).unwrap().value
}

#[test]
fn fixed_derivative_is_honoured_in_pooled_and_single_fits() {
    let all = windows();
    let used: Vec<AeroWindow<'_>> = all.iter().map(|(manoeuvre, aero)| (manoeuvre, Arc::clone(aero))).collect();
    let structure = Structure::thesis();
    let fixed = knowing(Coefficient::Cn, "pb/2V", Constraint::Fixed(truth("Cn_p")), false);
    let free = Estimation { by_surface: false, ..Estimation::default() };
    let place =
        |fit: &CoefficientFit, name: &str| fit.fit.as_ref().unwrap().names.iter().position(|n| n == name).unwrap();
    let pairs = [
        (pooled_fits(&used, &structure, &fixed).fits, pooled_fits(&used, &structure, &free).fits),
        (
            window_fits(&all[0].0, &all[0].1, &structure, &fixed).fits,
            window_fits(&all[0].0, &all[0].1, &structure, &free).fits,
        ),
    ];
    for (fixed, free) in pairs {
        let (held, plain) = (of(&fixed, Coefficient::Cn), of(&free, Coefficient::Cn));
        let (fit, other) = (held.fit.as_ref().unwrap(), plain.fit.as_ref().unwrap());
        let at = place(held, "Cn_p");
        assert_eq!((fit.estimates[at], fit.origins[at]), (truth("Cn_p"), Origin::Fixed));
        let none = errors(fit, &held.corrected_errors, at);
        assert!(none.0.is_nan() && none.1.is_nan(), "{none:?}");
        for name in ["Cn_beta", "Cn_r", "Cn_delta_r"] {
            let (a, b) = (place(held, name), place(plain, name));
            let (own, before) = (errors(fit, &held.corrected_errors, a), errors(other, &plain.corrected_errors, b));
            assert!(own.0 < before.0, "{name}: {own:?} {before:?}");
            let scale = truth(name).abs().max(0.01);
            assert!((fit.estimates[a] - truth(name)).abs() < 5.0 * own.1.max(1e-3 * scale), "{name}");
        }
        // What is known of one coefficient changes no other.
        let (cm, same) = (of(&fixed, Coefficient::Cm), of(&free, Coefficient::Cm));
        assert_eq!(cm.fit.as_ref().unwrap(), same.fit.as_ref().unwrap());
    }
}

#[test]
fn resting_surface_keeps_a_derivative_that_is_known() {
    let all = windows();
    let manoeuvre = Manoeuvre { surface: Some(Surface::Aileron), ..all[0].0.clone() };
    let known = knowing(Coefficient::Cn, "delta_r", Constraint::Fixed(-0.07), true);
    let mut data = all[0].1.data.clone();
    let resting = data.controls.get_mut(&Role::Rudder).unwrap();
    *resting = vec![0.01; resting.len()].into();
    let resting = Arc::new(WindowAero::form(data, all[0].1.settings.clone(), AirDensity::Recorded).unwrap());
    let fits = window_fits(&manoeuvre, &resting, &Structure::thesis(), &known).fits;
    assert_eq!(of(&fits, Coefficient::Cn).fit.as_ref().unwrap().parameter("Cn_delta_r"), Some((-0.07, 0.0)));
    assert_eq!(of(&fits, Coefficient::Cl).dropped.len(), 1, "of Cl nothing is known of the rudder");
}

#[test]
fn fixed_constant_is_one_for_all_windows_and_predicts() {
    let all = windows();
    let used: Vec<AeroWindow<'_>> = all.iter().map(|(manoeuvre, aero)| (manoeuvre, Arc::clone(aero))).collect();
    let known = knowing(Coefficient::Cm, "1", Constraint::Fixed(0.03), false);
    let found = pooled_fits(&used, &Structure::thesis(), &known);
    let fit = of(&found.fits, Coefficient::Cm).fit.as_ref().unwrap();
    assert_eq!(fit.parameter("Cm_0"), Some((0.03, 0.0)));
    assert_eq!(fit.parameters(), 4);
    let residual = &fit.residuals[used[..2].iter().map(|(_, aero)| aero.coefficients.time_s.len()).sum()..];
    let prediction = found.predictions.iter().filter(|p| p.coefficient == Coefficient::Cm).nth(2).unwrap();
    for (a, b) in residual.iter().zip(prediction.residual().values.iter()) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

#[test]
fn derivative_by_half_the_pitch_rate_is_exactly_twice_the_other() {
    let all = windows();
    let used: Vec<AeroWindow<'_>> = all.iter().map(|(manoeuvre, aero)| (manoeuvre, Arc::clone(aero))).collect();
    let estimation = Estimation { by_surface: false, ..Estimation::default() };
    let with = |text: &str| {
        let terms = ["1", "alpha", text, "delta_e"].map(|text| Term::parse(text).unwrap()).to_vec();
        let found = pooled_fits(&used, &Structure { models: vec![(Coefficient::Cm, terms)] }, &estimation);
        found.fits.into_iter().next().unwrap()
    };
    let (whole, half) = (with("qc/V"), with("qc/2V"));
    let (a, b) = (whole.fit.as_ref().unwrap(), half.fit.as_ref().unwrap());
    assert_eq!(b.names[1], "Cm_qhat");
    // A regressor halved is a bit of its exponent: not one digit of the estimate differs.
    assert_eq!(2.0 * a.estimates[1], b.estimates[1]);
    assert_eq!(2.0 * a.standard_errors[1], b.standard_errors[1]);
    assert!((2.0 * whole.corrected_errors[1] / half.corrected_errors[1] - 1.0).abs() < REORDERING);
    assert_eq!((a.estimates[0], &a.residuals), (b.estimates[0], &b.residuals));
}

/// R2 of the prediction of a window by these values of the terms of the thesis.
fn r_squared(aero: &WindowAero, coefficient: Coefficient, values: &[f64]) -> f64 {
    let structure = Structure::thesis();
    let x = regressors(structure.terms(coefficient).unwrap(), &aero.variables).unwrap();
    let z = DVector::from_column_slice(aero.coefficients.get(coefficient));
    let left = &z - x * DVector::from_column_slice(values);
    1.0 - left.norm_squared() / z.add_scalar(-z.mean()).norm_squared()
}

#[test]
fn constants_of_the_identification_and_the_windows_own_are_told_apart() {
    const CM: Coefficient = Coefficient::Cm;
    let mut all = windows();
    let (validation, aero) = all.last_mut().unwrap();
    validation.role = WindowRole::Validation;
    // Another trim than the windows that are identified with.
    let mut other = WindowAero::clone(aero);
    Arc::make_mut(&mut other.coefficients.columns[CM as usize]).iter_mut().for_each(|value| *value += 0.004);
    *aero = Arc::new(other);
    let aero = Arc::clone(aero);
    let used: Vec<AeroWindow<'_>> = all.iter().map(|(manoeuvre, aero)| (manoeuvre, Arc::clone(aero))).collect();
    let structure = Structure::thesis();
    let names: Vec<String> = structure.derivative_names(CM);
    let last = used.len() - 1;
    let predicted = |estimation: &Estimation| {
        let found = pooled_fits(&used, &structure, estimation);
        let prediction = found.predictions.iter().filter(|p| p.coefficient == CM).nth(last).unwrap().clone();
        (of(&found.fits, CM).fit.as_ref().unwrap().clone(), prediction)
    };
    let check = |what: &str, prediction: &Prediction, values: &[f64]| {
        let identified = r_squared(&aero, CM, values);
        // The constant that leaves no mean residual.
        let x = regressors(structure.terms(CM).unwrap(), &aero.variables).unwrap();
        let left = DVector::from_column_slice(aero.coefficients.get(CM)) - x * DVector::from_column_slice(values);
        let mut moved = values.to_vec();
        moved[0] += left.mean();
        let own = r_squared(&aero, CM, &moved);
        println!("{what}: R2 {identified:.4}, with the manoeuvre's own constant {own:.4}");
        assert!((prediction.quality_identified.r_squared - identified).abs() < 1e-10, "{what}: {identified}");
        assert!((prediction.quality_own_constant.r_squared - own).abs() < 1e-10, "{what}: {own}");
        assert!(own - identified > 0.1, "{what}: another trim must show");
    };
    let per_window = Estimation { by_surface: false, ..Estimation::default() };
    let (fit, prediction) = predicted(&per_window);
    let constants: Vec<f64> =
        used[..last].iter().map(|(window, _)| fit.parameter(&format!("Cm_0[{}]", window.name)).unwrap().0).collect();
    let shared = |name: &String| fit.parameter(name).unwrap().0;
    let mean = constants.iter().sum::<f64>() / constants.len() as f64;
    check("per manoeuvre", &prediction, &[&[mean], &names[1..].iter().map(shared).collect::<Vec<_>>()[..]].concat());

    let (fit, prediction) = predicted(&Estimation { constants: PooledConstants::Common, ..per_window.clone() });
    check("common", &prediction, &names.iter().map(|name| fit.parameter(name).unwrap().0).collect::<Vec<_>>());

    let means = Estimation { predict_with: PredictionParameters::ManoeuvreMeans, ..per_window.clone() };
    let singles: Vec<_> =
        used[..last].iter().map(|(window, aero)| window_fits(window, aero, &structure, &per_window)).collect();
    let mean = |name: &String| {
        let values = singles.iter().map(|fits| of(&fits.fits, CM).fit.as_ref().unwrap().parameter(name).unwrap().0);
        values.sum::<f64>() / singles.len() as f64
    };
    let (_, prediction) = predicted(&means);
    check("means of single manoeuvres", &prediction, &names.iter().map(mean).collect::<Vec<_>>());
}

#[test]
fn residuals_of_a_fit_with_weights_are_those_of_the_measurement() {
    let all = windows();
    let used: Vec<AeroWindow<'_>> = all.iter().map(|(manoeuvre, aero)| (manoeuvre, Arc::clone(aero))).collect();
    let equal = Estimation { by_surface: false, ..Estimation::default() };
    let with = |weights| Estimation { weights, ..equal.clone() };
    let [huber, whitened] = [ResidualWeights::Huber, ResidualWeights::Autoregression(2)].map(with);
    let found = |estimation: &Estimation| pooled_fits(&used, &Structure::thesis(), estimation).fits;
    let (equal, others) = (found(&equal), [found(&huber), found(&whitened)]);
    for (equal, huber) in others.iter().flat_map(|other| equal.iter().zip(other)) {
        let measured: Vec<f64> =
            used.iter().flat_map(|(_, aero)| aero.coefficients.get(equal.coefficient)).copied().collect();
        let [equal, huber] = [equal, huber].map(|found| found.fit.as_ref().unwrap());
        assert_ne!(equal.estimates, huber.estimates);
        // Least squares has the smallest sum of squares of all; that of another fit is larger by what it moved.
        let square = |fit: &Fit| fit.residuals.iter().map(|v| v * v).sum::<f64>();
        assert!(square(huber) >= square(equal));
        let fitted: Vec<f64> = measured.iter().zip(huber.residuals.iter()).map(|(z, v)| z - v).collect();
        assert_eq!(huber.quality, FitQuality::compare(&measured, &fitted));
        assert_eq!(huber.names, equal.names);
    }
}

/// Aileron recorded a sample late: the residuals say so, and the errors of the derivatives hold what it does to them.
#[test]
fn late_deflection_is_found_by_the_residuals_and_is_in_the_errors() {
    let late = |(manoeuvre, aero): &(Manoeuvre, Arc<WindowAero>)| {
        let mut data = aero.data.clone();
        let aileron = data.controls.get_mut(&Role::Aileron).unwrap();
        *aileron = std::iter::once(aileron[0]).chain(aileron.iter().copied()).take(aileron.len()).collect();
        (manoeuvre.clone(), Arc::new(WindowAero::form(data, aero.settings.clone(), AirDensity::Recorded).unwrap()))
    };
    let all: Vec<_> = windows().iter().map(late).collect();
    let windows: Vec<AeroWindow<'_>> = all.iter().map(|(manoeuvre, aero)| (manoeuvre, Arc::clone(aero))).collect();
    let estimation = Estimation { by_surface: false, ..Estimation::default() };
    let found = control_delays(&windows, (&Structure::thesis(), &estimation), &InstrumentAccuracy::default());
    let fits = pooled_fits(&windows, &Structure::thesis(), &estimation).fits;
    let roll = fits.iter().find(|fit| fit.coefficient == Coefficient::Cl).unwrap();
    for delay in &found {
        let expected_s = if delay.surface == Surface::Aileron { flight::STEP_S } else { 0.0 };
        let error_s = delay.delay_s - expected_s;
        assert!(error_s.abs() < (4.0 * delay.standard_error_s).max(2e-3), "{delay:?}");
        assert!(delay.standard_error_s < 5e-3, "{delay:?}");
    }
    assert_eq!(found.len(), 3);
    let fit = roll.fit.as_ref().unwrap();
    let place = fit.names.iter().position(|name| name == "Cl_delta_a").unwrap();
    let (error, corrected) = ((fit.estimates[place] - -0.172).abs(), roll.corrected_errors[place]);
    let added: f64 = found.iter().map(|delay| delay.mean_square("Cl_delta_a")).sum();
    assert!(error > corrected && added.sqrt() > 0.5 * error, "{error} {corrected} {added}: the delay does not show");
    assert!(error < 2.0 * (corrected * corrected + added).sqrt(), "{error} {corrected} {added}");
}

#[test]
fn condition_is_the_mean_before_the_input_or_of_a_manoeuvre_without_one() {
    const INPUT_S: f64 = 3.0;
    let (data, settings, _) = flight::window(400);
    let start_s = data.time_s[0];
    let after = |value: f64| -> Arc<[f64]> {
        data.time_s.iter().map(|time| if time - start_s < INPUT_S { 0.0 } else { value }).collect()
    };
    let form = |elevator: Arc<[f64]>| {
        let data = AeroData {
            airspeed_m_s: after(10.0).iter().map(|change| 50.0 + change).collect(),
            alpha_rad: after(0.02).iter().map(|change| 0.1 + change).collect(),
            density_kg_m3: data.time_s.iter().map(|_| 1.2).collect(),
            controls: [(Role::Elevator, elevator), (Role::Aileron, after(0.0)), (Role::Rudder, after(0.0))].into(),
            ..data.clone()
        };
        WindowAero::form(data, settings.clone(), AirDensity::Recorded).unwrap()
    };
    let steered = form(after(0.05));
    let samples = condition_samples(&steered);
    let last_s = data.time_s[samples.end - 1] - start_s;
    assert!(samples.start == 0 && (INPUT_S - 0.2..INPUT_S).contains(&last_s), "{last_s}");
    let found = measure_condition(&steered).unwrap();
    assert!((found.airspeed_m_s - 50.0).abs() < 1e-9 && (found.alpha_rad - 0.1).abs() < 1e-12, "{found:?}");
    assert!((found.dynamic_pressure_pa - 1500.0).abs() < 1e-6, "{found:?}");
    let still = form(after(0.0));
    assert_eq!(condition_samples(&still), 0..400);
    assert!(measure_condition(&still).unwrap().airspeed_m_s > 55.0);
}
