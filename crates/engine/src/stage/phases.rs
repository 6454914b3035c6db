//! Parts of a flight by what the air data say: ground, climb, level flight, descent.

use std::ops::Range;

use doublet_core::propulsion::PhaseOfFlight;
use doublet_core::series::TimeRange;

/// True airspeed below which an aircraft with engine models is taken to be on the ground, m/s (40 kt).
pub(crate) const GROUND_AIRSPEED_M_S: f64 = 20.6;
/// Vertical speed that separates climb and descent from level flight, m/s (200 ft/min).
const LEVEL_M_S: f64 = 1.0;
/// Half of the time the vertical speed is the mean of, s.
const HALF_MEAN_S: f64 = 30.0;
/// Shortest phase, s. What is shorter between two parts of one phase belongs to it; elsewhere it belongs to none.
const SHORTEST_S: f64 = 60.0;

/// Phases of the flight in their order in time, none overlapping; the three columns have one length.
pub fn phases(time_s: &[f64], altitude_m: &[f64], airspeed_m_s: &[f64]) -> Vec<PhaseOfFlight> {
    let names: Vec<_> = (0..time_s.len()).map(|k| name_phase(k, time_s, altitude_m, airspeed_m_s)).collect();
    let mut runs: Vec<(&str, Range<usize>)> = Vec::new();
    let mut first = 0;
    for run in names.chunk_by(|a, b| a == b) {
        let range = first..first + run.len();
        first = range.end;
        let Some(name) = run[0].filter(|_| time_s[range.end - 1] - time_s[range.start] >= SHORTEST_S) else { continue };
        match runs.last_mut() {
            Some((last, before)) if *last == name && names[before.end..range.start].iter().all(Option::is_some) => {
                before.end = range.end;
            }
            _ => runs.push((name, range)),
        }
    }
    runs.into_iter()
        .map(|(name, range)| PhaseOfFlight {
            name: name.to_owned(),
            window: TimeRange { start_s: time_s[range.start], end_s: time_s[range.end - 1] },
        })
        .collect()
}

fn name_phase(k: usize, time_s: &[f64], altitude_m: &[f64], airspeed_m_s: &[f64]) -> Option<&'static str> {
    if airspeed_m_s[k] < GROUND_AIRSPEED_M_S {
        return Some("ground");
    }
    let from = time_s.partition_point(|&time| time < time_s[k] - HALF_MEAN_S);
    let to = time_s.partition_point(|&time| time <= time_s[k] + HALF_MEAN_S) - 1;
    let climb_m_s = (altitude_m[to] - altitude_m[from]) / (time_s[to] - time_s[from]);
    match climb_m_s {
        climb if climb > LEVEL_M_S => Some("climb"),
        climb if climb < -LEVEL_M_S => Some("descent"),
        climb if climb.is_finite() => Some("level"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_made_flight_has_its_phases_at_their_times() {
        // 200 s on the ground, 300 s climb at 3 m/s, level with a pull-up of 20 s, 300 s descent, 200 s on the ground.
        let time: Vec<f64> = (0..3200).map(|k| 0.5 * f64::from(k)).collect();
        let altitude = |t: &f64| match *t {
            t if t < 200.0 => 0.0,
            t if t < 500.0 => 3.0 * (t - 200.0),
            t if (800.0..820.0).contains(&t) => 900.0 + 100.0 * (std::f64::consts::PI * (t - 800.0) / 20.0).sin(),
            t if t < 1100.0 => 900.0,
            t if t < 1400.0 => 900.0 - 3.0 * (t - 1100.0),
            _ => 0.0,
        };
        let airspeed: Vec<f64> = time.iter().map(|t| if (200.0..1400.0).contains(t) { 50.0 } else { 0.0 }).collect();
        let found = phases(&time, &time.iter().map(altitude).collect::<Vec<_>>(), &airspeed);
        let names: Vec<_> = found.iter().map(|phase| phase.name.as_str()).collect();
        assert_eq!(names, ["ground", "climb", "level", "descent", "ground"]);
        // A change of vertical speed is placed to within half of the time it is averaged over.
        for (phase, start) in found.iter().zip([0.0, 200.0, 500.0, 1100.0, 1400.0]) {
            assert!((phase.window.start_s - start).abs() <= HALF_MEAN_S, "{phase:?}");
        }
    }
}
