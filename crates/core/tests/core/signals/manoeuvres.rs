//! Manoeuvres found in hand-flown, drifting, noisy controls.

use doublet_core::prep::{Manoeuvre, ManoeuvreSettings, ManoeuvreShape, PassedOver, PrepError, find_manoeuvres};
use doublet_core::quantity::Role;
use doublet_core::series::{Series, TimeRange};
use doublet_core::simulate::{Hand, InputKind, InputSignal};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const ALWAYS: [TimeRange; 1] = [TimeRange { start_s: f64::NEG_INFINITY, end_s: f64::INFINITY }];
const SURFACES: [Role; 3] = [Role::Aileron, Role::Elevator, Role::Rudder];
/// Time from one input to the next, s.
const EVERY_S: f64 = 40.0;

/// Inputs flown one after the other, each on one surface, at 60 Hz over trims that drift, with sensor noise.
struct Flown {
    controls: [Series; 3],
    inputs: Vec<(usize, InputKind, f64, f64)>,
}

fn flown(count: usize, hand: Hand, kinds: &[InputKind], seed: u64) -> Flown {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut inputs = Vec::new();
    let mut signals = Vec::new();
    for k in 0..count {
        let kind = kinds[rng.random_range(0..kinds.len())];
        let base = rng.random_range(0.5..1.2);
        let amplitude: f64 = rng.random_range(1.5f64..5.0).to_radians() * if rng.random() { 1.0 } else { -1.0 };
        let onset = 20.0 + EVERY_S * k as f64 + rng.random_range(0.0..5.0);
        signals.push(InputSignal::new(kind, base, amplitude, hand, &mut rng));
        inputs.push((k % 3, kind, onset, amplitude));
    }
    let time: Vec<f64> = (0..(60.0 * (EVERY_S * count as f64 + 20.0)) as usize).map(|k| k as f64 / 60.0).collect();
    let controls = [0usize, 1, 2].map(|surface| {
        let (trim, drift) = (0.02 * surface as f64 - 0.03, 0.012 + 0.004 * surface as f64);
        let values = time.iter().map(|&t| {
            let index = ((t - 20.0) / EVERY_S).floor().clamp(0.0, count as f64 - 1.0) as usize;
            let (on, _, onset, _) = inputs[index];
            let input = if on == surface { signals[index].at(t - onset) } else { 0.0 };
            let noise = 8e-4 * rng.sample::<f64, _>(StandardNormal);
            trim + drift * (t / 50.0 + surface as f64).sin() + input + noise
        });
        Series { values: values.collect(), time_s: time.clone().into() }
    });
    Flown { controls, inputs }
}

fn find(flown: &Flown, settings: &ManoeuvreSettings) -> Vec<Manoeuvre> {
    let controls: Vec<(Role, &Series)> = SURFACES.into_iter().zip(&flown.controls).collect();
    find_manoeuvres(&controls, &[], &ALWAYS, settings).unwrap().found
}

fn shape_of(kind: InputKind) -> ManoeuvreShape {
    match kind {
        InputKind::Doublet => ManoeuvreShape::Doublet,
        InputKind::ThreeTwoOneOne => ManoeuvreShape::ThreeTwoOneOne,
        InputKind::Pulse => ManoeuvreShape::Pulse,
        _ => ManoeuvreShape::Step,
    }
}

#[test]
fn hand_flown_manoeuvres_are_found_with_surface_shape_and_onset() {
    /// Time in which a half cosine leaves the noise, s.
    const ONSET_S: f64 = 0.12;
    let kinds = [InputKind::Doublet, InputKind::ThreeTwoOneOne, InputKind::Pulse];
    let (mut all, mut right) = (0, 0);
    for seed in 0..4 {
        let flown = flown(30, Hand::PILOT, &kinds, seed);
        let found = find(&flown, &ManoeuvreSettings::default());
        assert_eq!(found.len(), flown.inputs.len(), "seed {seed}");
        for (manoeuvre, (surface, kind, onset, amplitude)) in found.iter().zip(&flown.inputs) {
            assert_eq!(manoeuvre.surfaces, [SURFACES[*surface]]);
            assert!((manoeuvre.onset_s - onset).abs() < ONSET_S, "{} for {onset}", manoeuvre.onset_s);
            assert!((manoeuvre.amplitude_rad / amplitude - 1.0).abs() < 0.25, "{manoeuvre:?} {amplitude}");
            assert!(manoeuvre.window.start_s < manoeuvre.onset_s && manoeuvre.input_end_s < manoeuvre.window.end_s);
            all += 1;
            right += usize::from(manoeuvre.shape == shape_of(*kind));
        }
    }
    println!("{right} of {all} shapes right");
    assert!(right as f64 > 0.98 * all as f64, "{right} of {all}");
}

#[test]
fn a_perfect_hand_gives_its_base_time_and_full_confidence() {
    let flown = flown(6, Hand::PERFECT, &[InputKind::ThreeTwoOneOne], 8);
    for manoeuvre in find(&flown, &ManoeuvreSettings::default()) {
        assert!(manoeuvre.confidence > 0.9, "{manoeuvre:?}");
        let length = manoeuvre.pulses[3].end_s - manoeuvre.pulses[0].start_s;
        // Seven base times to two samples at 60 Hz.
        assert!((length - 7.0 * manoeuvre.base_time_s).abs() < 2.0 / 60.0 * 7.0, "{manoeuvre:?}");
    }
}

#[test]
fn nothing_is_invented_in_trim_drift_and_noise() {
    let mut quiet = flown(20, Hand::PILOT, &[InputKind::Doublet], 3);
    let trim = |k: usize, t: f64| 0.02 * (t / 60.0 + k as f64).sin();
    let mut rng = ChaCha8Rng::seed_from_u64(77);
    for (k, series) in quiet.controls.iter_mut().enumerate() {
        let values = series.time_s.iter().map(|&t| trim(k, t) + 1.5e-3 * rng.sample::<f64, _>(StandardNormal));
        series.values = values.collect();
    }
    assert_eq!(find(&quiet, &ManoeuvreSettings::default()), []);
}

#[test]
fn step_is_told_from_pulse_and_coupled_inputs_lose_confidence() {
    let time: Vec<f64> = (0..1200).map(|k| f64::from(k) / 60.0).collect();
    let series =
        |f: &dyn Fn(f64) -> f64| Series { values: time.iter().map(|&t| f(t)).collect(), time_s: time.clone().into() };
    let step = series(&|t| if t > 12.0 { 0.03 } else { 0.0 });
    let still = series(&|_| 0.0);
    let settings = ManoeuvreSettings::default();
    let found =
        find_manoeuvres(&[(Role::Elevator, &step), (Role::Rudder, &still)], &[], &ALWAYS, &settings).unwrap().found;
    assert_eq!((found.len(), found[0].shape, found[0].surfaces[0]), (1, ManoeuvreShape::Step, Role::Elevator));
    let doublet = |t: f64, size: f64| {
        if (8.0..9.0).contains(&t) {
            size
        } else if (9.0..10.0).contains(&t) {
            -size
        } else {
            0.0
        }
    };
    let (large, small) = (series(&|t| doublet(t, 0.05)), series(&|t| doublet(t, 0.02)));
    let found =
        find_manoeuvres(&[(Role::Aileron, &large), (Role::Rudder, &small)], &[], &ALWAYS, &settings).unwrap().found;
    assert_eq!((found.len(), found[0].surfaces[0], found[0].shape), (1, Role::Aileron, ManoeuvreShape::Doublet));
    // 0.02 of 0.05 on the other surface: 1 / (1 + (0.4/0.5)^2).
    assert!((found[0].confidence - 0.61).abs() < 0.02, "{}", found[0].confidence);
}

#[test]
fn free_response_ends_where_the_rate_has_died_down() {
    let time: Vec<f64> = (0..1800).map(|k| f64::from(k) / 60.0).collect();
    let doublet = |t: f64| {
        if (8.0..9.0).contains(&t) {
            0.05
        } else if (9.0..10.0).contains(&t) {
            -0.05
        } else {
            0.0
        }
    };
    // A rate that falls to a tenth of its greatest 4.6 s after the input: exp(-0.5 t).
    let rate = |t: f64| if t < 8.0 { 0.01 } else { 0.01 + 0.2 * (-0.5 * (t - 10.0).max(0.0)).exp() };
    let make =
        |f: &dyn Fn(f64) -> f64| Series { values: time.iter().map(|&t| f(t)).collect(), time_s: time.clone().into() };
    let (control, response) = (make(&doublet), make(&rate));
    let settings = ManoeuvreSettings::default();
    let found = find_manoeuvres(&[(Role::Elevator, &control)], &[(Role::PitchRate, &response)], &ALWAYS, &settings)
        .unwrap()
        .found;
    assert!((found[0].window.end_s - (10.0 + 10f64.ln() / 0.5)).abs() < 0.03, "{:?}", found[0].window);
    assert!((found[0].window.start_s - 5.0).abs() < 0.03);
    let without = find_manoeuvres(&[(Role::Elevator, &control)], &[], &ALWAYS, &settings).unwrap().found;
    assert!((without[0].window.end_s - 20.0).abs() < 0.05);
    let bad = ManoeuvreSettings { resting_s: 0.0, ..settings };
    assert!(matches!(find_manoeuvres(&[], &[], &ALWAYS, &bad), Err(PrepError::Setting { setting: "resting_s", .. })));
    let uneven = Series { time_s: [1.0, 0.0].into(), values: [0.0, 0.0].into() };
    assert!(find_manoeuvres(&[(Role::Elevator, &uneven)], &[], &ALWAYS, &settings).is_err());
}

/// A doublet of 2 x 1 s from `onset` on, rad.
fn doublet(t: f64, onset: f64, amplitude: f64) -> f64 {
    match t - onset {
        t if (0.0..1.0).contains(&t) => amplitude,
        t if (1.0..2.0).contains(&t) => -amplitude,
        _ => 0.0,
    }
}

/// A deflection at 50 Hz from 0 to `end` s.
fn deflection(end: f64, value: impl Fn(f64) -> f64) -> Series {
    let time: Vec<f64> = (0..=(50.0 * end) as usize).map(|k| k as f64 / 50.0).collect();
    Series { values: time.iter().map(|t| value(*t)).collect(), time_s: time.into() }
}

#[test]
fn a_cut_that_begins_and_ends_close_to_the_manoeuvre_is_found() {
    // 0.3 s before, 0.8 s after: 3.1 s in all.
    let control = deflection(3.1, |t| doublet(t, 0.3, 0.35));
    let found = find_manoeuvres(&[(Role::Elevator, &control)], &[], &ALWAYS, &ManoeuvreSettings::default()).unwrap();
    assert_eq!(found.passed_over, []);
    assert_eq!((found.found.len(), found.found[0].shape), (1, ManoeuvreShape::Doublet));
    let TimeRange { start_s, end_s } = found.found[0].window;
    assert!(start_s == 0.0 && end_s <= 3.1, "{:?}", found.found[0].window);
    // Cuts laid end to end give a window each, none over the pause.
    let pause = |t: &f64| !(3.1..13.1).contains(t);
    let two = deflection(16.2, |t| doublet(t, 0.3, 0.35) + doublet(t, 13.4, -0.35));
    let pairs = two.time_s.iter().zip(&*two.values).filter(|(t, _)| pause(t));
    let (time, values): (Vec<f64>, Vec<f64>) = pairs.map(|(t, value)| (*t, *value)).unzip();
    let two = Series { time_s: time.into(), values: values.into() };
    let found = find_manoeuvres(&[(Role::Elevator, &two)], &[], &ALWAYS, &ManoeuvreSettings::default()).unwrap().found;
    assert_eq!(found.len(), 2);
    assert!(
        found[0].window.end_s <= 3.1 && found[1].window.start_s >= 13.1,
        "{:?} {:?}",
        found[0].window,
        found[1].window
    );
}

#[test]
fn two_surfaces_at_one_time_are_one_manoeuvre() {
    let aileron = deflection(100.0, |t| doublet(t, 50.0, 0.05));
    let rudder = deflection(100.0, |t| doublet(t, 50.5, -0.06));
    let controls = [(Role::Aileron, &aileron), (Role::Rudder, &rudder)];
    let found = find_manoeuvres(&controls, &[], &ALWAYS, &ManoeuvreSettings::default()).unwrap();
    assert_eq!((found.found.len(), found.passed_over.len()), (1, 0));
    let one = &found.found[0];
    assert_eq!(one.surfaces, [Role::Rudder, Role::Aileron]);
    assert!(
        (one.onset_s - 50.0).abs() < 0.05 && (one.input_end_s - 52.5).abs() < 0.05 && one.confidence > 0.9,
        "{one:?}"
    );
}

#[test]
fn inputs_that_are_no_manoeuvre_are_told_with_their_reason() {
    let input =
        |t: f64| doublet(t, 20.0, 0.05) + doublet(t, 60.0, 0.006) + doublet(t, 100.0, 0.05) + doublet(t, 102.7, 0.05);
    let control = deflection(200.0, input);
    let flown = [TimeRange { start_s: 40.0, end_s: 200.0 }];
    let found = find_manoeuvres(&[(Role::Elevator, &control)], &[], &flown, &ManoeuvreSettings::default()).unwrap();
    let told: Vec<(i64, PassedOver)> =
        found.passed_over.iter().map(|(_, at, _, why)| (at.round() as i64, *why)).collect();
    assert_eq!(told, [(20, PassedOver::OnGround), (60, PassedOver::Small), (103, PassedOver::NotRested)]);
    assert_eq!(found.found.iter().map(|one| one.onset_s.round() as i64).collect::<Vec<_>>(), [100]);
}

/// Sum of twelve sines of 15 s from `onset` on, of about the given amplitude, rad.
fn multisine(t: f64, onset: f64, amplitude: f64) -> f64 {
    let t = t - onset;
    if !(0.0..15.0).contains(&t) {
        return 0.0;
    }
    let phase = |k: f64| std::f64::consts::PI * k * k / 12.0;
    let sines = (1..=12).map(|k| (std::f64::consts::TAU * f64::from(k) * t / 15.0 + phase(f64::from(k))).sin());
    amplitude * sines.sum::<f64>() / 3.2
}

/// Motion of a stabilised control in gusts, rad.
fn stabilised(t: f64, amplitude: f64) -> f64 {
    amplitude * ((1.9 * t).sin() + (3.1 * t + 1.0).sin() + (0.83 * t).cos()) / 2.0
}

fn onsets(found: &[Manoeuvre]) -> Vec<i64> {
    found.iter().map(|one| one.onset_s.round() as i64).collect()
}

#[test]
fn a_control_that_never_rests_still_shows_its_manoeuvres() {
    // 1 deg of stabilisation throughout, doublets of 5 deg, a multisine of 4 deg.
    let input = |t: f64| doublet(t, 40.0, 0.087) + doublet(t, 80.0, -0.087) + multisine(t, 120.0, 0.07);
    let rudder = deflection(180.0, |t| input(t) + stabilised(t, 0.012));
    let found = find_manoeuvres(&[(Role::Rudder, &rudder)], &[], &ALWAYS, &ManoeuvreSettings::default()).unwrap();
    let at = onsets(&found.found);
    assert_eq!(at.len(), 3, "{at:?} {:?}", found.passed_over);
    for (onset, flown) in found.found.iter().map(|one| one.onset_s).zip([40.0, 80.0, 120.0]) {
        assert!((onset - flown).abs() < 1.5, "{at:?}");
    }
    assert!(found.found[2].input_end_s > 132.0, "{}", found.found[2].input_end_s);
}

#[test]
fn another_surface_is_still_by_its_own_inputs() {
    // Ailerons hold the wings level with 1.4 deg in gusts, which is little beside their own 12 deg and much beside 1.7 deg of elevator.
    let aileron = deflection(240.0, |t| doublet(t, 40.0, 0.2) + doublet(t, 80.0, -0.2) + stabilised(t, 0.018));
    let elevator = deflection(240.0, |t| multisine(t, 120.0, 0.024));
    let controls = [(Role::Aileron, &aileron), (Role::Elevator, &elevator)];
    let found = find_manoeuvres(&controls, &[], &ALWAYS, &ManoeuvreSettings::default()).unwrap();
    assert_eq!(onsets(&found.found), [40, 80, 120], "{:?}", found.passed_over);
    assert_eq!(found.found[2].surfaces, [Role::Elevator]);
}

#[test]
fn surfaces_of_unequal_travel_at_one_time_are_one_manoeuvre() {
    // The rudder's multisine is as high as its doublets and 0.4 of the aileron's.
    let aileron = deflection(200.0, |t| multisine(t, 120.0, 0.15));
    let rudder = deflection(200.0, |t| doublet(t, 40.0, 0.06) + doublet(t, 80.0, -0.06) + multisine(t, 120.4, -0.06));
    let controls = [(Role::Aileron, &aileron), (Role::Rudder, &rudder)];
    let found = find_manoeuvres(&controls, &[], &ALWAYS, &ManoeuvreSettings::default()).unwrap();
    assert_eq!(onsets(&found.found), [40, 80, 120], "{:?}", found.passed_over);
    assert_eq!(found.found[2].surfaces, [Role::Aileron, Role::Rudder]);
}

#[test]
fn corrections_beside_large_manoeuvres_are_passed_over_as_small() {
    let input = |t: f64| doublet(t, 40.0, 0.2) + doublet(t, 120.0, -0.2);
    // A correction of 0.7 deg and 1.2 s that has the shape of a pulse.
    let control = deflection(160.0, |t| input(t) + if (80.0..81.2).contains(&t) { 0.012 } else { 0.0 });
    let found = find_manoeuvres(&[(Role::Aileron, &control)], &[], &ALWAYS, &ManoeuvreSettings::default()).unwrap();
    assert_eq!(onsets(&found.found), [40, 120]);
    let passed: Vec<(i64, PassedOver)> =
        found.passed_over.iter().map(|(_, at, _, why)| (at.round() as i64, *why)).collect();
    assert_eq!(passed, [(80, PassedOver::Small)]);
}
