//! Gusts along the path, as airspeed and velocity over the Earth show them.

use nalgebra::{DMatrix, DVector};

use crate::quantity::Role;
use crate::series::{Recording, Series, gap_threshold_s, value_at};
use crate::statistics::median;

/// Length over which the mean wind counts as constant, s.
const STRETCH_S: f64 = 120.0;
/// Least interval between samples: velocities over the Earth hold nothing faster, s.
const STEP_S: f64 = 0.2;
/// Fewest samples of a stretch.
const LEAST_SAMPLES: usize = 100;
/// Least airspeed, m/s: below, the aircraft may be on the ground.
const LEAST_AIRSPEED_M_S: f64 = 5.0;

/// Standard deviation of the gusts along the path, m/s; none where true airspeed or velocity over the Earth is missing.
///
/// With the velocity over the Earth `v`, a constant wind `w` and gusts `g` along the path, the airspeed is `V = |v - w| + g`, so that
/// `V^2 - v'v = -2 v'w + w'w + 2 V g`: `w` and `w'w` by least squares over 120 s, `g` by what is left. The median over all such stretches.
/// Errors of the airspeed and late stamps count as gusts.
pub fn gusts_along_path(recording: &Recording) -> Option<f64> {
    let series = |role: Role| recording.role(role).map(|channel| &channel.series);
    let velocity = [series(Role::VelocityNorth)?, series(Role::VelocityEast)?];
    gusts_of(&thinned(series(Role::TrueAirspeed)?, velocity, series(Role::VelocityDown)))
}

/// Median over the stretches of these samples.
fn gusts_of(samples: &[Sample]) -> Option<f64> {
    let first_s = samples.first()?.time_s;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of stretches")]
    let stretch = |sample: &Sample| ((sample.time_s - first_s) / STRETCH_S) as usize;
    let stretches = samples.chunk_by(|one, other| stretch(one) == stretch(other));
    median(&mut stretches.filter_map(deviation).collect::<Vec<_>>())
}

struct Sample {
    time_s: f64,
    airspeed_m_s: f64,
    velocity_m_s: [f64; 3],
}

/// Values between samples; none in a gap.
fn interpolate(series: &Series) -> impl Fn(f64) -> Option<f64> {
    let gap_s = gap_threshold_s(&series.time_s);
    move |time_s| value_at(&series.time_s, &series.values, gap_s, time_s)
}

/// Samples in flight at the times of the velocity north, not closer than they may be.
fn thinned(airspeed: &Series, [north, east]: [&Series; 2], down: Option<&Series>) -> Vec<Sample> {
    let (airspeed_at, east_at, down_at) = (interpolate(airspeed), interpolate(east), down.map(interpolate));
    let mut found: Vec<Sample> = Vec::new();
    for (&time_s, &north) in north.time_s.iter().zip(&*north.values) {
        if found.last().is_some_and(|last| time_s - last.time_s < STEP_S) {
            continue;
        }
        let Some((airspeed_m_s, east)) = airspeed_at(time_s).zip(east_at(time_s)) else { continue };
        let down = down_at.as_ref().and_then(|down| down(time_s)).unwrap_or(0.0);
        let velocity_m_s = [north, east, down];
        if airspeed_m_s > LEAST_AIRSPEED_M_S && velocity_m_s.iter().all(|value| value.is_finite()) {
            found.push(Sample { time_s, airspeed_m_s, velocity_m_s });
        }
    }
    found
}

/// Deviation of the gusts of one stretch.
fn deviation(stretch: &[Sample]) -> Option<f64> {
    if stretch.len() < LEAST_SAMPLES {
        return None;
    }
    let x = DMatrix::from_fn(stretch.len(), 3, |row, column| match column {
        2 => 1.0,
        _ => -2.0 * stretch[row].velocity_m_s[column],
    });
    let square = |sample: &Sample| sample.velocity_m_s.iter().map(|part| part * part).sum::<f64>();
    let z = DVector::from_iterator(stretch.len(), stretch.iter().map(|one| one.airspeed_m_s.powi(2) - square(one)));
    let svd = x.clone().svd(true, true);
    let wind = svd.solve(&z, 1e-9 * svd.singular_values.max()).ok()?;
    let left = z - x * wind;
    let squares = stretch.iter().zip(left.iter()).map(|(one, left)| (left / (2.0 * one.airspeed_m_s)).powi(2));
    Some((squares.sum::<f64>() / stretch.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gusts_are_found_beside_a_wind_and_turns() {
        let time_s: Vec<f64> = (0..30_000).map(|k| 0.02 * f64::from(k)).collect();
        let heading = |time_s: f64| 0.8 * (0.02 * time_s).sin();
        // Four sines of different periods: deviation 1.2 m/s.
        let gust = |time_s: f64| {
            [1.3, 2.1, 3.7, 5.9].iter().map(|rate| (rate * time_s).sin()).sum::<f64>() * 1.2 / 2.0_f64.sqrt()
        };
        let column = |value: &dyn Fn(f64) -> f64| Series {
            time_s: time_s.as_slice().into(),
            values: time_s.iter().map(|time_s| value(*time_s)).collect(),
        };
        for size in [0.0, 1.0] {
            let airspeed = column(&|time_s| 60.0 + size * gust(time_s));
            let north = column(&|time_s| 60.0 * heading(time_s).cos() + 7.0);
            let east = column(&|time_s| 60.0 * heading(time_s).sin() - 4.0);
            let found = gusts_of(&thinned(&airspeed, [&north, &east], None)).unwrap();
            assert!((found - 1.2 * size).abs() < 0.05 + 0.05 * size, "{found}");
        }
        assert_eq!(gusts_of(&[]), None);
    }
}
