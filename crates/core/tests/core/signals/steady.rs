//! Steady parts: where there are data, little motion and white noise.

use doublet_core::prep::{SteadySearch, SteadySettings, SteadySignal, find_steady};
use doublet_core::series::{Series, TimeRange};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const WHOLE: [TimeRange; 1] = [TimeRange { start_s: 0.0, end_s: 200.0 }];

/// A rate at 50 Hz over 200 s: white noise of 1e-3 rad/s on a motion.
fn rate(motion: impl Fn(f64) -> f64) -> Series {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let time: Vec<f64> = (0..=10_000).map(|k| 0.02 * f64::from(k)).collect();
    let values = time.iter().map(|t| motion(*t) + 1e-3 * rng.sample::<f64, _>(StandardNormal)).collect();
    Series { time_s: time.into(), values }
}

fn find(series: &Series, max_drift: f64) -> SteadySearch {
    find_steady(&[SteadySignal { series, max_deviation: 0.02, max_drift }], &WHOLE, &SteadySettings::default()).unwrap()
}

#[test]
fn nothing_is_steady_where_the_aircraft_moves_all_the_time() {
    // The quietest tenth of a flight of nothing but manoeuvres is no steady flight.
    let found = find(&rate(|t| 0.1 * (1.5 * t).sin()), 0.05);
    assert!(found.found.is_empty() && found.looked_at > 300 && found.quiet == 0, "{found:?}");
}

#[test]
fn steady_windows_lie_outside_gaps_and_manoeuvres_and_drift_little() {
    // A manoeuvre from 60 s to 80 s, a pause from 120 s to 140 s, a spiral that tightens from 160 s on.
    let motion = |t: f64| match t {
        t if (60.0..80.0).contains(&t) => 0.1 * (1.5 * t).sin(),
        t if t > 160.0 => 0.01 * (t - 160.0),
        _ => 0.0,
    };
    let full = rate(motion);
    let pairs = full.time_s.iter().zip(&*full.values).filter(|(t, _)| !(120.0..140.0).contains(*t));
    let (time, values): (Vec<f64>, Vec<f64>) = pairs.map(|(t, value)| (*t, *value)).unzip();
    let found = find(&Series { time_s: time.into(), values: values.into() }, 0.05).found;
    assert!(found.len() >= 8, "{found:?}");
    for stretch in &found {
        let TimeRange { start_s, end_s } = stretch.window;
        let apart = |from: f64, to: f64| end_s <= from + 0.5 || start_s >= to - 0.5;
        assert!(apart(60.0, 80.0) && apart(120.0, 140.0) && apart(165.0, 200.0), "{stretch:?}");
    }
}

#[test]
fn filtered_signals_are_refused_because_they_are_not_white() {
    let white = rate(|_| 0.0);
    let mut state = 0.0;
    let filtered = white.values.iter().map(|value| {
        state += 0.1 * (value - state);
        state
    });
    let filtered = Series { values: filtered.collect(), ..white.clone() };
    assert_eq!(find(&white, 0.05).found.len(), SteadySettings::default().most);
    let found = find(&filtered, 0.05);
    assert!(found.found.is_empty() && found.quiet > 300 && found.coloured > 0, "{found:?}");
}
