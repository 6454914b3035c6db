//! Equivalent systems of records whose system is known: intervals of right forms, and the verdict on wrong ones.

use std::f64::consts::TAU;
use std::fmt::Write;

use doublet_dynamics::frequency::{Delay, Form, Section, TransferFunction};
use doublet_dynamics::qualities::{Airplane, Measure, Measures};
use doublet_engine::report::{QualitiesRow, equivalent_levels};
use doublet_engine::study::dynamics::limits;
use doublet_engine::study::{EquivalentStudy, ResponseRequest, equivalent_study, table_responses};
use doublet_engine::verdict::Level;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

const SEEDS: u64 = 200;
/// Interval of the records, s, and steps of the simulation in it.
const STEP_S: f64 = 0.02;
const PARTS: usize = 10;
/// Frequencies of the sweep, Hz.
const SWEEP_HZ: [f64; 2] = [0.03, 2.0];
/// Noise over the deviation of the output, and its correlation from sample to sample.
const NOISE: f64 = 0.03;
const CORRELATION: f64 = 0.8;

/// A system: polynomials in descending powers, the denominator monic.
struct System {
    numerator: Vec<f64>,
    denominator: Vec<f64>,
    delay_s: f64,
    /// Parameters of the form that is fitted, where it is the right one.
    truth: Vec<(&'static str, f64)>,
    form: Form,
}

fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        b.iter().enumerate().for_each(|(j, y)| product[i + j] += x * y);
    }
    product
}

fn system(seed: u64, random: &mut ChaCha8Rng) -> System {
    let delay_s = random.random_range(0.02..0.15);
    let pair = |omega: f64, zeta: f64| vec![1.0, 2.0 * zeta * omega, omega * omega];
    if seed.is_multiple_of(2) {
        let (omega, zeta) = (random.random_range(1.5..4.0), random.random_range(0.35..0.9));
        let (gain, lead) = (-random.random_range(2.0..8.0), random.random_range(0.6..1.5));
        let truth = vec![("K", gain), ("inv_Ttheta2", lead), ("zeta", zeta), ("omega", omega), ("tau", delay_s)];
        let numerator = vec![gain, gain * lead];
        return System { numerator, denominator: pair(omega, zeta), delay_s, truth, form: Form::ShortPeriod };
    }
    let (gain, rate) = (random.random_range(2.0..10.0), random.random_range(1.0..5.0));
    if seed % 4 == 1 {
        let truth = vec![("K", gain), ("inv_TR", rate), ("tau", delay_s)];
        return System { numerator: vec![gain], denominator: vec![1.0, rate], delay_s, truth, form: Form::Roll };
    }
    // The Dutch roll shows in the roll rate: a single pole is the wrong form.
    let (omega, zeta) = (random.random_range(1.5..3.0), random.random_range(0.08..0.25));
    let beside = if random.random_bool(0.5) { random.random_range(0.6..0.85) } else { random.random_range(1.2..1.5) };
    System {
        numerator: times(&[gain], &pair(omega * beside, zeta)),
        denominator: times(&[1.0, rate], &pair(omega, zeta)),
        delay_s,
        truth: Vec::new(),
        form: Form::Roll,
    }
}

/// A sine sweep whose frequency rises exponentially over `length_s`.
fn sweep(t: f64, length_s: f64) -> f64 {
    let rise = (SWEEP_HZ[1] / SWEEP_HZ[0]).ln();
    if t < 0.0 { 0.0 } else { (TAU * SWEEP_HZ[0] * length_s / rise * ((rise * t / length_s).exp() - 1.0)).sin() }
}

/// Output of a system at rest at first, by the classical Runge-Kutta method in controllable form.
fn output(system: &System, length_s: f64, samples: usize) -> Vec<f64> {
    let order = system.denominator.len() - 1;
    let slope = |t: f64, x: &[f64]| -> Vec<f64> {
        let mut slope: Vec<f64> = x[1..].to_vec();
        let back: f64 = (0..order).map(|k| system.denominator[order - k] * x[k]).sum();
        slope.push(sweep(t - system.delay_s, length_s) - back);
        slope
    };
    let step_s = STEP_S / PARTS as f64;
    let moved =
        |x: &[f64], slope: &[f64], by: f64| -> Vec<f64> { x.iter().zip(slope).map(|(x, s)| x + by * s).collect() };
    let mut x = vec![0.0; order];
    let mut y = Vec::with_capacity(samples);
    for sample in 0..samples {
        let last = system.numerator.len() - 1;
        y.push(system.numerator.iter().enumerate().map(|(k, b)| b * x[last - k]).sum());
        for part in 0..PARTS {
            let t = STEP_S * sample as f64 + step_s * part as f64;
            let first = slope(t, &x);
            let second = slope(t + 0.5 * step_s, &moved(&x, &first, 0.5 * step_s));
            let third = slope(t + 0.5 * step_s, &moved(&x, &second, 0.5 * step_s));
            let fourth = slope(t + step_s, &moved(&x, &third, step_s));
            for (k, x) in x.iter_mut().enumerate() {
                *x += step_s / 6.0 * (first[k] + 2.0 * second[k] + 2.0 * third[k] + fourth[k]);
            }
        }
    }
    y
}

/// Adds noise of a first-order autoregression.
fn disturb(y: &mut [f64], random: &mut ChaCha8Rng) {
    let deviation = (y.iter().map(|y| y * y).sum::<f64>() / y.len() as f64).sqrt();
    let fresh = NOISE * deviation * (1.0 - CORRELATION * CORRELATION).sqrt();
    let mut noise = 0.0;
    for y in y {
        // Twelve uniform numbers have the variance of one normal number.
        let normal: f64 = (0..12).map(|_| random.random_range(-0.5..0.5)).sum();
        noise = CORRELATION * noise + fresh * normal;
        *y += noise;
    }
}

/// A system and what was found of it; none where its form cannot be told.
fn identify(seed: u64) -> (System, Option<EquivalentStudy>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let system = system(seed, &mut random);
    let found = identify_system(&system, &mut random);
    (system, found)
}

/// What a noisy record of a system gives.
fn identify_system(system: &System, random: &mut ChaCha8Rng) -> Option<EquivalentStudy> {
    let length_s = random.random_range(60.0..120.0);
    let samples = (length_s / STEP_S) as usize;
    let mut y = output(system, length_s, samples);
    disturb(&mut y, random);
    let mut text = "time,d,y\n".to_owned();
    for (sample, y) in y.iter().enumerate() {
        let t = STEP_S * sample as f64;
        writeln!(text, "{t:.2},{:.9},{y:.9}", sweep(t, length_s)).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("records.csv");
    std::fs::write(&path, text).unwrap();
    let request =
        ResponseRequest { inputs: vec!["d".to_owned()], output: "y".to_owned(), ..ResponseRequest::default() };
    let study = table_responses(&path, None, &request, true).unwrap();
    equivalent_study(&study, 0, (system.form, Delay::Free), None).ok()
}

/// A short period of zeta 0.6 and 2.5 rad/s with `T_theta2` 1 s, whose only doubtful figure is its delay.
fn levels_with_delay(delay_s: f64, seed: u64) -> QualitiesRow {
    let (numerator, denominator) = (vec![-5.0, -5.0], vec![1.0, 3.0, 6.25]);
    let system = System { numerator, denominator, delay_s, truth: Vec::new(), form: Form::ShortPeriod };
    let found = identify_system(&system, &mut ChaCha8Rng::seed_from_u64(seed)).unwrap();
    let airplane = Airplane::new("III", "B").unwrap();
    equivalent_levels(&found, "q", &limits("mil_std_1797a_class_iii").unwrap(), &airplane)
}

#[test]
fn levels_of_an_equivalent_system_are_those_of_its_truth_and_their_probabilities_mean_what_they_say() {
    // MIL-STD-1797A: a delay of up to 0.1 s is Level 1, of up to 0.2 s Level 2.
    let delay =
        |row: &QualitiesRow| row.criteria.iter().find(|row| row.criterion == "equivalent delay").unwrap().clone();
    for (delay_s, level) in [(0.05, "Level 1"), (0.15, "Level 2")] {
        let found = levels_with_delay(delay_s, 1);
        assert_eq!((found.level, delay(&found).level), (Some(level), level));
        let place = usize::from(level == "Level 2");
        assert!(found.probabilities.unwrap()[place] > 0.95, "{:?}", found.probabilities);
        let criteria: Vec<&str> = found.criteria.iter().map(|row| row.criterion.as_str()).collect();
        assert_eq!(criteria, ["equivalent system damping", "equivalent delay", "equivalent attitude lead"]);
    }
    // At the limit itself the probability of Level 1 lies anywhere between 0 and 1 from flight to flight, with the mean one half and the
    // deviation of a uniform number, 0.29.
    const FLIGHTS: u64 = 60;
    let found: Vec<f64> = (0..FLIGHTS)
        .into_par_iter()
        .map(|seed| delay(&levels_with_delay(0.1, 100 + seed)).probabilities.unwrap()[0])
        .collect();
    let mean = found.iter().sum::<f64>() / FLIGHTS as f64;
    let deviation = (found.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / FLIGHTS as f64).sqrt();
    println!("probability of Level 1 at the limit: {mean:.2}, deviation {deviation:.2}");
    assert!((0.35..0.65).contains(&mean) && (0.2..0.4).contains(&deviation), "{mean} {deviation}");
}

#[test]
fn pitch_criteria_of_an_equivalent_system_hold_the_truth_in_their_intervals() {
    // The same system with 0.12 s of delay; the truth by the same measures of the exact transfer function.
    let (numerator, denominator) = (vec![-5.0, -5.0], vec![1.0, 3.0, 6.25]);
    let system = System { numerator, denominator, delay_s: 0.12, truth: Vec::new(), form: Form::ShortPeriod };
    let airplane = Airplane::new("I", "A").unwrap();
    let limits = limits("mil_std_1797a").unwrap().with(limits("gibson").unwrap());
    let exact = TransferFunction {
        gain: 5.0,
        numerator: vec![Section::First(1.0)],
        denominator: vec![Section::Second { c1: 3.0, c0: 6.25 }],
        delay_s: 0.12,
    };
    let mut truth = Measures::default();
    truth.add_pitch_rate(&exact, Some(0.12), limits.pilot_task(&airplane).as_ref());
    truth.add_short_period(0.6, 2.5, None);
    truth.set(Measure::EquivalentDelay, 0.12);
    let (mut held, mut all) = (0, 0);
    for seed in 0..8 {
        let study = identify_system(&system, &mut ChaCha8Rng::seed_from_u64(300 + seed)).unwrap();
        let found = equivalent_levels(&study, "q", &limits, &airplane);
        assert_eq!(found.criteria.len(), 7, "floor, damping, delay, bandwidth, pilot, dropback, phase rate");
        for row in &found.criteria {
            assert!((row.probabilities.unwrap().iter().sum::<f64>() - 1.0).abs() < 1e-9 && row.needed.is_none());
            for (key, interval) in &row.intervals {
                let measure = Measure::ALL.iter().find(|measure| measure.key() == *key).unwrap();
                let exact = truth.get(*measure).unwrap();
                held += usize::from(interval.low <= exact && exact <= interval.high);
                all += 1;
            }
        }
    }
    println!("{held} of {all} intervals hold the truth");
    assert_eq!(all, 88);
    // 95 % of them on average; those of one flight hang on five parameters, so the share scatters.
    assert!(held * 100 >= all * 80, "{held} of {all}");
}

/// A roll mode of 0.4 s beside a Dutch roll of 1.45 rad/s and this damping ratio, with zeros of the roll rate beside its poles.
fn roll_beside_dutch_roll(form: Form, damping: f64, zeros: [f64; 2]) -> System {
    let pair = |omega: f64, zeta: f64| [1.0, 2.0 * zeta * omega, omega * omega];
    System {
        numerator: times(&[6.0], &pair(zeros[0], zeros[1])),
        denominator: times(&[1.0, 2.5], &pair(1.45, damping)),
        delay_s: 0.06,
        truth: Vec::new(),
        form,
    }
}

#[test]
fn roll_and_dutch_roll_of_a_form_of_free_orders_have_levels_and_a_bad_system_has_none() {
    let limits = limits("mil_f_8785c").unwrap();
    let airplane = Airplane::new("I", "B").unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let found =
        identify_system(&roll_beside_dutch_roll(Form::parse("2/3").unwrap(), 0.3, [1.2, 0.35]), &mut random).unwrap();
    assert_ne!(found.verdict.level, Level::Bad);
    let levels = equivalent_levels(&found, "p", &limits, &airplane);
    let value = |key: &str| levels.criteria.iter().find_map(|row| row.values.get(key).copied()).flatten().unwrap();
    for (key, truth, tolerance) in
        [("roll_time_constant", 0.4, 0.04), ("dutch_roll_frequency", 1.45, 0.03), ("dutch_roll_damping", 0.3, 0.03)]
    {
        assert!((value(key) - truth).abs() < tolerance, "{key}: {} for {truth}", value(key));
    }
    // MIL-F-8785C, class I, category B: T_R up to 1.4 s, damping from 0.08 and frequency from 0.4 rad/s are Level 1.
    assert_eq!(levels.level, Some("Level 1"));
    // Of the yaw rate the real pole has no name.
    let yaw = equivalent_levels(&found, "r", &limits, &airplane);
    assert!(yaw.criteria.iter().all(|row| !row.values.contains_key("roll_time_constant")));
    assert!(yaw.criteria.iter().any(|row| row.values.contains_key("dutch_roll_damping")));
    // A single pole is the wrong form: its criterion is listed and not judged.
    let bad = identify_system(&roll_beside_dutch_roll(Form::Roll, 0.14, [1.0, 0.2]), &mut random).unwrap();
    assert_eq!(bad.verdict.level, Level::Bad);
    let none = equivalent_levels(&bad, "p", &limits, &airplane);
    assert_eq!((none.level, none.probabilities), (None, None));
    assert!(!none.criteria.is_empty() && none.extent().starts_with("0 of "), "{}", none.extent());
    for row in &none.criteria {
        assert_eq!((row.level, row.probabilities, row.is_judged()), ("not judged", None, false));
        assert!(row.needed.as_deref().unwrap().contains("verdict on this one is bad: "));
    }
}

#[test]
fn a_right_form_of_a_lightly_damped_dutch_roll_is_not_bad() {
    const FLIGHTS: u64 = 24;
    // The windows, up to a quarter of 60 to 120 s, are shorter than the decay of 1 / (zeta omega) = 8 to 38 s.
    let identify = |seed: u64| {
        let mut random = ChaCha8Rng::seed_from_u64(4000 + seed);
        let (omega, damping) = (random.random_range(1.3..2.4), random.random_range(0.02..0.05));
        let (gain, lead) = (-random.random_range(2.0..5.0), random.random_range(0.4..1.2));
        let truth = vec![("zeta", damping), ("omega", omega)];
        let (numerator, denominator) = (vec![gain, gain * lead], vec![1.0, 2.0 * damping * omega, omega * omega]);
        let delay_s = random.random_range(0.02..0.1);
        let system = System { numerator, denominator, delay_s, truth, form: Form::Yaw };
        let found = identify_system(&system, &mut random).unwrap();
        (system, found)
    };
    let all: Vec<(System, EquivalentStudy)> = (0..FLIGHTS).into_par_iter().map(identify).collect();
    let level = |level: Level| all.iter().filter(|(_, found)| found.verdict.level == level).count();
    let unresolved = all.iter().filter(|(_, found)| found.mismatch.unresolved > 0).count();
    println!("{} good, {} bad, {unresolved} with points omitted", level(Level::Good), level(Level::Bad));
    assert_eq!(level(Level::Bad), 0);
    assert!(level(Level::Good) * 4 >= all.len() * 3 && unresolved * 2 >= all.len());
    for (system, found) in &all {
        for (name, truth) in &system.truth {
            let value = found.fit.parameter(name).unwrap().value;
            assert!((value / truth - 1.0).abs() < 0.05, "{name} {value} for {truth}");
        }
    }
}

#[test]
fn intervals_under_good_hold_the_truth_and_wrong_forms_are_not_good() {
    let all: Vec<(System, Option<EquivalentStudy>)> = (0..SEEDS).into_par_iter().map(identify).collect();
    let (right, wrong): (Vec<_>, Vec<_>) = all.into_iter().partition(|(system, _)| !system.truth.is_empty());
    let is_good = |found: &EquivalentStudy| found.verdict.level == Level::Good;
    let good: Vec<_> = right
        .iter()
        .filter_map(|(system, found)| Some((system, found.as_ref().filter(|found| is_good(found))?)))
        .collect();
    assert!(good.len() * 10 >= right.len() * 9, "{} of {} right forms are good", good.len(), right.len());
    let (mut intervals, mut held) = (0, 0);
    for (system, found) in good {
        for (name, truth) in &system.truth {
            let parameter = found.fit.parameter(name).unwrap();
            intervals += 1;
            held += usize::from((parameter.low..=parameter.high).contains(truth));
        }
    }
    let part = f64::from(held as u32) / f64::from(intervals as u32);
    println!("{held} of {intervals} intervals hold the truth");
    assert!((0.93..=0.97).contains(&part), "{held} of {intervals}");
    let caught = wrong.iter().filter(|(_, found)| !found.as_ref().is_some_and(is_good)).count();
    println!("{caught} of {} wrong forms are not good", wrong.len());
    assert!(caught * 20 >= wrong.len() * 19, "{caught} of {}", wrong.len());
}
