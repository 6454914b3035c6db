//! Analyses of one curve of a plot: its spectrum, its spectrum over time, its derivative, the curve over another.

use doublet_core::prep::{Differentiation, Spectrogram, Spectrum, differentiate, spectrogram, spectrum};
use doublet_core::series::{Series, TimeRange, gap_threshold_s, value_at};

use crate::graph::StageResult;

/// Samples on each side of the parabola whose slope is the derivative.
pub const SLOPE_HALF_WIDTH: usize = 3;
/// Most points of a scatter.
const MOST_POINTS: usize = 4000;

/// What is computed of a curve.
#[derive(Clone, Debug)]
pub enum TraceView {
    /// Power spectral density.
    Spectrum,
    /// Power spectral density over time.
    Spectrogram,
    /// Slope of a parabola through 7 samples.
    Derivative,
    /// Over the values of this curve.
    Scatter(Series),
}

/// Result of an analysis, in the units of the curves.
#[derive(Clone, Debug, PartialEq)]
pub enum TraceAnalysis {
    /// Power spectral density.
    Spectrum(Spectrum),
    /// Power spectral density over time.
    Spectrogram(Spectrogram),
    /// Derivative with respect to time, per s.
    Derivative(Series),
    /// Points of both curves: the other along, this one up.
    Scatter {
        points: Vec<[f64; 2]>,
        correlation: f64,
        /// Slope and value at zero of the line of least squares.
        line: [f64; 2],
    },
}

/// Analyses the samples of `series` inside `range`.
pub fn analyse(view: &TraceView, series: &Series, range: TimeRange) -> StageResult<TraceAnalysis> {
    let within = series.within(range);
    match view {
        TraceView::Spectrum => {
            let found = spectrum(&within).ok_or("a spectrum needs 32 samples without a gap: show a longer time")?;
            Ok(TraceAnalysis::Spectrum(found))
        }
        TraceView::Spectrogram => {
            let found = spectrogram(&within).ok_or("a spectrogram needs 64 samples: show a longer time")?;
            Ok(TraceAnalysis::Spectrogram(found))
        }
        TraceView::Derivative => {
            let Series { time_s, values } = within.finite();
            let method = Differentiation::LocalPolynomial { degree: 2, half_width: SLOPE_HALF_WIDTH };
            let slopes = differentiate(&time_s, &values, method).map_err(|error| error.to_string())?;
            Ok(TraceAnalysis::Derivative(Series { time_s, values: slopes.into() }))
        }
        TraceView::Scatter(other) => scatter(&within, other),
    }
}

/// Both curves at the samples of the first.
fn scatter(series: &Series, other: &Series) -> StageResult<TraceAnalysis> {
    let gap_s = gap_threshold_s(&other.time_s);
    let pair = |(time_s, up): (&f64, &f64)| {
        let along = value_at(&other.time_s, &other.values, gap_s, *time_s)?;
        (along.is_finite() && up.is_finite()).then_some([along, *up])
    };
    let all: Vec<[f64; 2]> = series.time_s.iter().zip(series.values.iter()).filter_map(pair).collect();
    if all.len() < 3 {
        return Err("both curves have fewer than 3 samples in common".into());
    }
    let count = all.len() as f64;
    let mean = |axis: usize| all.iter().map(|point| point[axis]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let [xx, yy, xy] = all.iter().fold([0.0; 3], |[xx, yy, xy], point| {
        let (along, up) = (point[0] - x, point[1] - y);
        [xx + along * along, yy + up * up, xy + along * up]
    });
    let slope = if xx > 0.0 { xy / xx } else { 0.0 };
    let correlation = if xx * yy > 0.0 { xy / (xx * yy).sqrt() } else { 0.0 };
    let points = all.iter().step_by(all.len().div_ceil(MOST_POINTS)).copied().collect();
    Ok(TraceAnalysis::Scatter { points, correlation, line: [slope, y - slope * x] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(rad_s: f64) -> Series {
        let time: Vec<f64> = (0..1000).map(|k| 0.02 * f64::from(k)).collect();
        Series { values: time.iter().map(|t| (rad_s * t).sin()).collect(), time_s: time.into() }
    }

    #[test]
    fn a_wave_has_its_peak_its_slope_and_its_line_over_itself() {
        let (series, range) = (wave(6.0), TimeRange { start_s: 2.0, end_s: 18.0 });
        let Ok(TraceAnalysis::Spectrum(found)) = analyse(&TraceView::Spectrum, &series, range) else {
            panic!("a spectrum")
        };
        let at = (0..found.density.len()).max_by(|&i, &j| found.density[i].total_cmp(&found.density[j])).unwrap();
        assert!((found.frequency_hz[at] - 6.0 / std::f64::consts::TAU).abs() <= found.frequency_hz[0]);
        let Ok(TraceAnalysis::Derivative(slope)) = analyse(&TraceView::Derivative, &series, range) else {
            panic!("a slope")
        };
        for (time_s, found) in slope.time_s.iter().zip(slope.values.iter()).skip(10).take(700) {
            assert!((found - 6.0 * (6.0 * time_s).cos()).abs() < 0.15, "{time_s} {found}");
        }
        let twice = Series { values: series.values.iter().map(|v| 2.0 * v + 1.0).collect(), ..series.clone() };
        let view = TraceView::Scatter(series);
        let Ok(TraceAnalysis::Scatter { points, correlation, line }) = analyse(&view, &twice, range) else {
            panic!("a scatter")
        };
        assert_eq!(points.len(), 801);
        assert!((correlation - 1.0).abs() < 1e-9 && (line[0] - 2.0).abs() < 1e-9 && (line[1] - 1.0).abs() < 1e-9);
    }

    #[test]
    fn too_short_a_part_says_so() {
        let range = TimeRange { start_s: 2.0, end_s: 2.1 };
        for view in [TraceView::Spectrum, TraceView::Spectrogram, TraceView::Derivative] {
            assert!(analyse(&view, &wave(6.0), range).is_err(), "{view:?}");
        }
    }
}
