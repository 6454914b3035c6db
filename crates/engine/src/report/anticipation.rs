//! The chart of control anticipation over short-period damping, both in logarithms, with the lines of all levels.

use doublet_dynamics::qualities::{Measure, Measures};

use crate::study::DynamicsStudy;

/// Ends of damping and CAP, within which every limit lies.
const ENDS: [[f64; 2]; 2] = [[0.1, 4.0], [0.01, 20.0]];

/// Places in decimal logarithms of damping and CAP.
#[derive(Clone, Debug, PartialEq)]
pub struct AnticipationChart {
    /// Ends of both axes.
    pub ranges: [[f64; 2]; 2],
    /// Round values on both axes, with their texts.
    pub places: [Vec<(f64, String)>; 2],
    /// Boundary of each level, open where it has no limit.
    pub levels: Vec<(u8, Vec<[f64; 2]>)>,
    pub estimate: [f64; 2],
    /// Samples of the derivatives.
    pub samples: Vec<[f64; 2]>,
}

/// The chart of a study; none without a short period of positive damping.
pub fn anticipation_chart(study: &DynamicsStudy) -> Option<AnticipationChart> {
    let estimate = point(&study.measures)?;
    let samples: Vec<[f64; 2]> = study.sampled.iter().filter_map(point).collect();
    let mut ranges = ENDS.map(|ends| ends.map(f64::log10));
    for place in samples.iter().chain([&estimate]) {
        for (range, value) in ranges.iter_mut().zip(place) {
            *range = [range[0].min(*value), range[1].max(*value)];
        }
    }
    let bounds = |measure: Measure| study.limits.bounds(&study.airplane, measure);
    let (damping, cap) = (bounds(Measure::ShortPeriodDamping), bounds(Measure::Cap));
    let levels = (1..=3_u8).filter_map(|level| {
        let row_of_level = |rows: &[(u8, Option<f64>, Option<f64>)]| rows.iter().find(|row| row.0 == level).copied();
        let ((_, left, right), (_, low, high)) = (row_of_level(&damping)?, row_of_level(&cap)?);
        Some((level, boundary([left, right], [low, high], &ranges)))
    });
    let levels = levels.collect();
    let places = ranges.map(logarithmic_places);
    Some(AnticipationChart { ranges, places, levels, estimate, samples })
}

fn point(measures: &Measures) -> Option<[f64; 2]> {
    let log_measure = |measure: Measure| measures.get(measure).filter(|value| *value > 0.0).map(f64::log10);
    Some([log_measure(Measure::ShortPeriodDamping)?, log_measure(Measure::Cap)?])
}

/// A box in logarithms, from its upper left corner round; sides without limit are left open.
fn boundary(across: [Option<f64>; 2], up: [Option<f64>; 2], ranges: &[[f64; 2]; 2]) -> Vec<[f64; 2]> {
    let end = |limit: Option<f64>, end: f64| limit.map_or(end, f64::log10);
    let [left, right] = [0, 1].map(|side| end(across[side], ranges[0][side]));
    let [low, high] = [0, 1].map(|side| end(up[side], ranges[1][side]));
    let mut corners = vec![[left, high], [left, low], [right, low]];
    if across[1].is_some() || up[1].is_some() {
        corners.extend([[right, high], [left, high]]);
    }
    corners
}

/// Places of 1, 2 and 5 times the powers of ten between the ends of a logarithmic axis, with their texts.
fn logarithmic_places([low, high]: [f64; 2]) -> Vec<(f64, String)> {
    /// What an end may be off by rounding.
    const ROUNDING: f64 = 1e-9;
    let mut places = Vec::new();
    for exponent in low.floor() as i32..=high.ceil() as i32 {
        for digit in [1.0, 2.0, 5.0] {
            let value = digit * 10f64.powi(exponent);
            let place = value.log10();
            if place >= low - ROUNDING && place <= high + ROUNDING {
                places.push((place, format!("{}", (value * 1e9).round() / 1e9)));
            }
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boundaries_close_where_they_have_limits_and_stay_open_where_not() {
        let ranges = ENDS.map(|ends| ends.map(f64::log10));
        let closed = boundary([Some(0.3), Some(2.0)], [Some(0.085), Some(3.6)], &ranges);
        assert_eq!((closed.len(), closed[0]), (5, closed[4]));
        assert!((closed[2][0] - 2f64.log10()).abs() < 1e-15 && (closed[2][1] - 0.085f64.log10()).abs() < 1e-15);
        // Level 3 has least values alone: an angle that ends at the axes' ends.
        let open = boundary([Some(0.15), None], [Some(0.038), None], &ranges);
        assert_eq!(
            open,
            [[0.15f64.log10(), ranges[1][1]], [0.15f64.log10(), 0.038f64.log10()], [ranges[0][1], 0.038f64.log10()]]
        );
        let texts: Vec<String> = logarithmic_places(ranges[0]).into_iter().map(|(_, text)| text).collect();
        assert_eq!(texts, ["0.1", "0.2", "0.5", "1", "2"]);
    }
}
