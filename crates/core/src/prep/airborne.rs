//! When an aircraft flies: by its dynamic pressure and the switch of its wheels.

use super::stretches;
use crate::series::{Series, TimeRange, gap_threshold_s};

/// Spans of flight, in order of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Airborne {
    /// Spans in which the dynamic pressure is above the share asked for and no weight is on the wheels.
    pub spans: Vec<TimeRange>,
    /// Airspeed at that dynamic pressure, m/s.
    pub least_airspeed_m_s: f64,
}

/// Spans in which the dynamic pressure exceeds `share` of its median in flight and the weight is off the wheels.
///
/// `q / q_median = (V / V_median)^2` with the calibrated airspeed, or the true one where the density hardly changes. Counted as flight for
/// the median are the samples faster than half of what nine tenths stay below. `weight_on_wheels` is above one half on the ground.
/// `None` without a finite airspeed.
pub fn airborne(airspeed: &Series, weight_on_wheels: Option<&Series>, share: f64) -> Option<Airborne> {
    let finite = || airspeed.values.iter().copied().filter(|value| value.is_finite());
    let fast = 0.5 * quantile(finite().collect(), 0.9)?;
    let median = quantile(finite().filter(|value| *value > fast).collect(), 0.5)?;
    let least_airspeed_m_s = share.sqrt() * median;
    let flying = spans_where(airspeed, |value| value >= least_airspeed_m_s);
    let spans = match weight_on_wheels {
        None => flying,
        Some(weight) => super::intersect(&flying, &spans_where(weight, |value| value <= 0.5)),
    };
    Some(Airborne { spans, least_airspeed_m_s })
}

/// Value that a share of the others stay below; `None` of none.
fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let place = (last as f64 * share) as usize;
    crate::statistics::ranked(&mut values, place)
}

/// Spans whose finite samples all satisfy `holds`, none across a pause; each reaches to the sample that ends it.
fn spans_where(series: &Series, holds: impl Fn(f64) -> bool) -> Vec<TimeRange> {
    let Series { time_s: time, values } = series.finite();
    let mut spans = Vec::new();
    for range in stretches(&time, gap_threshold_s(&time)) {
        let mut open: Option<f64> = None;
        for k in range.clone() {
            match (open, holds(values[k])) {
                (None, true) => open = Some(time[k]),
                (Some(start_s), false) => {
                    spans.push(TimeRange { start_s, end_s: time[k] });
                    open = None;
                }
                _ => {}
            }
        }
        spans.extend(open.map(|start_s| TimeRange { start_s, end_s: time[range.end - 1] }));
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(value: impl Fn(f64) -> f64) -> Series {
        let time: Vec<f64> = (0..1000).map(|k| 0.1 * f64::from(k)).collect();
        Series { values: time.iter().map(|t| value(*t)).collect(), time_s: time.into() }
    }

    #[test]
    fn flight_is_above_its_share_of_the_median_pressure_with_weight_off_wheels() {
        // Taxi, a take-off run from 20 s at 5 m/s2, 100 m/s from 40 s on.
        let airspeed = series(|t| (5.0 * (t - 20.0)).clamp(3.0, 100.0));
        let found = airborne(&airspeed, None, 0.25).unwrap();
        assert_eq!((found.least_airspeed_m_s, found.spans.len()), (50.0, 1));
        assert!(
            (found.spans[0].start_s - 30.0).abs() < 0.11 && (found.spans[0].end_s - 99.9).abs() < 1e-9,
            "{found:?}"
        );
        let wheels = series(|t| if t < 35.05 { 1.0 } else { 0.0 });
        let off = airborne(&airspeed, Some(&wheels), 0.25).unwrap();
        assert!((off.spans[0].start_s - 35.1).abs() < 1e-9, "{off:?}");
        assert_eq!(airborne(&series(|_| f64::NAN), None, 0.25), None);
    }
}
