//! Intervals of modes from the covariance of the derivatives: by the delta method and by sampling.

use doublet_core::statistics::NORMAL_95;
use nalgebra::{Complex, DVector};

use super::{Mode, modes};
use crate::linear::{Condition, LinearError, Linearised, Method, Sensitivities, UncertainModel, linearise};
use crate::propagate::Interval;

/// A figure of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Real part of the eigenvalue, 1/s.
    Real,
    /// Imaginary part, rad/s.
    Imaginary,
    /// Undamped natural frequency, rad/s.
    Frequency,
    /// Damping ratio.
    Damping,
    /// Time to half the amplitude of a stable, to double that of an unstable mode, s.
    Time,
    /// Period of the damped oscillation, s.
    Period,
}

impl Figure {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Real, Self::Imaginary, Self::Frequency, Self::Damping, Self::Time, Self::Period];

    /// Its value for an eigenvalue; none for the period of an aperiodic mode and the time of a neutral one. The time has the sign of
    /// the stability, so that it goes on without a jump over infinity of its inverse.
    fn signed(self, value: Complex<f64>) -> f64 {
        let frequency = value.norm();
        match self {
            Self::Real => value.re,
            Self::Imaginary => value.im,
            Self::Frequency => frequency,
            Self::Damping => -value.re / frequency,
            Self::Time => -std::f64::consts::LN_2 / value.re,
            Self::Period => std::f64::consts::TAU / value.im,
        }
    }

    /// Its value for a mode; none for the period of an aperiodic mode.
    pub fn value(self, mode: &Mode) -> Option<f64> {
        let value = self.signed(mode.eigenvalue());
        value.is_finite().then(|| if self == Self::Time { value.abs() } else { value })
    }
}

/// Interval of a figure by both ways; none where the figure has no bounded one, as the time of a mode that may be neutral, or no own
/// one, as the frequency of an aperiodic mode.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct FigureInterval {
    pub figure: Figure,
    pub value: f64,
    /// By the slopes of the eigenvalue over the derivatives.
    pub delta: Option<Interval>,
    /// By quantiles of samples.
    pub sampled: Option<Interval>,
}

/// A mode with its intervals.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeEstimate {
    /// The mode.
    pub mode: Mode,
    /// Its figures.
    pub figures: Vec<FigureInterval>,
    /// Variances of real and imaginary part and their covariance, by the delta method.
    pub covariance: [f64; 3],
    /// Share of the samples in which it oscillates.
    pub oscillating: f64,
    /// Share of the samples in which it dies out.
    pub stable: f64,
}

impl ModeEstimate {
    /// Outline of the 95 % confidence ellipse of the eigenvalue in the plane of real and imaginary part, closed, `points` long; none of
    /// an aperiodic mode, whose imaginary part has no error.
    pub fn ellipse(&self, points: usize) -> Vec<[f64; 2]> {
        /// Square of its radius in standard deviations: the 95 % quantile of the chi-square distribution of two degrees of freedom.
        const SQUARE: f64 = 5.991_465;
        let [real, imaginary, joint] = self.covariance;
        if !(self.mode.oscillates() && real > 0.0 && imaginary > 0.0) {
            return Vec::new();
        }
        // Cholesky factor of the covariance.
        let first = real.sqrt();
        let mixed = joint / first;
        let second = (imaginary - mixed * mixed).max(0.0).sqrt();
        let radius = SQUARE.sqrt();
        let at = |index: usize| {
            let (sin, cos) = (std::f64::consts::TAU * index as f64 / (points.max(2) - 1) as f64).sin_cos();
            [
                self.mode.real_1_s + radius * first * cos,
                self.mode.imaginary_rad_s + radius * (mixed * cos + second * sin),
            ]
        };
        (0..points).map(at).collect()
    }

    /// A figure with its intervals.
    pub fn figure(&self, figure: Figure) -> Option<&FigureInterval> {
        self.figures.iter().find(|interval| interval.figure == figure)
    }
}

/// Modes of a model at a condition.
#[derive(Clone, Debug)]
pub struct ModeStudy {
    /// The linear model.
    pub linearised: Linearised,
    /// Slopes of it over the derivatives.
    pub sensitivities: Sensitivities,
    /// Modes, fastest first.
    pub modes: Vec<ModeEstimate>,
    /// Linear models of the samples; fewer than asked for where some have no trim.
    pub samples: Vec<Linearised>,
    /// Samples that have no trim.
    pub without_trim: usize,
}

/// Modes with intervals: slopes by central differences over each derivative, and `samples` draws of all derivatives together, the trim
/// solved anew each time. The same seed gives the same samples.
///
/// # Errors
/// [`LinearError`] of the estimates themselves.
pub fn mode_study(
    model: &UncertainModel,
    condition: &Condition,
    samples: usize,
    seed: u64,
) -> Result<ModeStudy, LinearError> {
    let sensitivities = model.sensitivities(condition)?;
    let linearised = sensitivities.nominal.clone();
    let nominal = modes(&linearised.motion());
    let draws = if sensitivities.changes.is_empty() { Vec::new() } else { model.samples(samples, seed) };
    let linear = |values: &DVector<f64>| linearise(&model.with_values(values), condition, Method::Analytic).ok();
    let sampled: Vec<Linearised> = draws.iter().filter_map(linear).collect();
    let matched: Vec<Vec<Option<Complex<f64>>>> =
        sampled.iter().map(|sample| matching(&nominal, &eigenvalues(sample))).collect();
    let slopes = slopes(&sensitivities, &nominal);
    let modes = nominal.iter().enumerate().map(|(index, mode)| {
        let of_mode: Vec<Complex<f64>> = matched.iter().filter_map(|values| values[index]).collect();
        estimate(mode, &slopes[index], &of_mode, (&sensitivities, model))
    });
    Ok(ModeStudy {
        modes: modes.collect(),
        without_trim: draws.len() - sampled.len(),
        samples: sampled,
        linearised,
        sensitivities,
    })
}

fn eigenvalues(linearised: &Linearised) -> Vec<Complex<f64>> {
    let values = doublet_core::decompose::eigenvalues(linearised.motion().a).unwrap_or_default();
    values.into_iter().filter(|value| value.im >= 0.0).collect()
}

/// The eigenvalue that is each nominal mode's, nearest pairs first, each used once; none where too few are left.
fn matching(nominal: &[Mode], values: &[Complex<f64>]) -> Vec<Option<Complex<f64>>> {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (place, mode) in nominal.iter().enumerate() {
        for (index, value) in values.iter().enumerate() {
            pairs.push(((mode.eigenvalue() - value).norm(), place, index));
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found = vec![None; nominal.len()];
    let mut used = vec![false; values.len()];
    for (_, place, index) in pairs {
        if found[place].is_none() && !used[index] {
            found[place] = Some(values[index]);
            used[index] = true;
        }
    }
    found
}

/// Eigenvalues at both ends of a change, where it has both.
type Sides = Option<(Complex<f64>, Complex<f64>)>;

/// Eigenvalues of each mode on both sides of each derivative.
fn slopes(sensitivities: &Sensitivities, nominal: &[Mode]) -> Vec<Vec<Sides>> {
    let mut of_modes = vec![Vec::new(); nominal.len()];
    for change in &sensitivities.changes {
        let [above, below] = [&change.above, &change.below].map(|side| matching(nominal, &eigenvalues(side)));
        for (place, sides) in of_modes.iter_mut().enumerate() {
            sides.push(above[place].zip(below[place]));
        }
    }
    of_modes
}

fn estimate(
    mode: &Mode,
    sides: &[Sides],
    samples: &[Complex<f64>],
    (sensitivities, model): (&Sensitivities, &UncertainModel),
) -> ModeEstimate {
    // Slope of a figure over each derivative; not a number where a side has no such mode.
    let gradient = |figure: Figure| -> Vec<f64> {
        let slope = |(change, sides): (&crate::linear::Change, &Sides)| {
            sides.map_or(f64::NAN, |(above, below)| (figure.signed(above) - figure.signed(below)) / (2.0 * change.step))
        };
        sensitivities.changes.iter().zip(sides).map(slope).collect()
    };
    let (real, imaginary) = (gradient(Figure::Real), gradient(Figure::Imaginary));
    let covariance = |first: &[f64], second: &[f64]| covariance(sensitivities, model, first, second);
    let variances = [covariance(&real, &real), covariance(&imaginary, &imaginary), covariance(&real, &imaginary)];
    let figures = Figure::ALL.into_iter().filter_map(|figure| {
        let value = figure.value(mode)?;
        // Of an aperiodic mode frequency and damping are the size and the sign of the real part, which has the interval.
        if !mode.oscillates() && matches!(figure, Figure::Frequency | Figure::Damping | Figure::Imaginary) {
            return Some(FigureInterval { figure, value, delta: None, sampled: None });
        }
        let by = gradient(figure);
        let error = covariance(&by, &by).max(0.0).sqrt();
        let real_error = variances[0].max(0.0).sqrt();
        let real = (mode.real_1_s - NORMAL_95 * real_error, mode.real_1_s + NORMAL_95 * real_error);
        let delta = match figure {
            Figure::Time => times(error, real),
            _ => Interval::normal(value, error),
        };
        let delta = delta.filter(|interval| interval.standard_error.is_finite());
        Some(FigureInterval { figure, value, delta, sampled: sampled(figure, samples) })
    });
    let count = samples.len().max(1) as f64;
    let share =
        |holds: &dyn Fn(&Complex<f64>) -> bool| samples.iter().filter(|value| holds(value)).count() as f64 / count;
    let (oscillating, stable) = if samples.is_empty() {
        (f64::from(u8::from(mode.oscillates())), f64::from(u8::from(mode.is_stable())))
    } else {
        (share(&|value| value.im > 0.0), share(&|value| value.re < 0.0))
    };
    ModeEstimate { mode: mode.clone(), figures: figures.collect(), covariance: variances, oscillating, stable }
}

/// Of two figures with these slopes over each derivative.
fn covariance(sensitivities: &Sensitivities, model: &UncertainModel, first: &[f64], second: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (a, one) in sensitivities.changes.iter().zip(first) {
        for (b, other) in sensitivities.changes.iter().zip(second) {
            let value = model.covariance[(a.index, b.index)];
            if value != 0.0 {
                sum += one * other * value;
            }
        }
    }
    sum
}

/// Interval of the time to half or double from that of the real part; none where it holds zero.
fn times(standard_error: f64, (low, high): (f64, f64)) -> Option<Interval> {
    let (first, last) = (std::f64::consts::LN_2 / low.abs(), std::f64::consts::LN_2 / high.abs());
    (low * high > 0.0).then(|| Interval { standard_error, low: first.min(last), high: first.max(last) })
}

/// Quantiles and standard deviation of a figure over the samples.
fn sampled(figure: Figure, samples: &[Complex<f64>]) -> Option<Interval> {
    let sampled_interval =
        |figure: Figure| Interval::of_samples(samples.iter().map(|&value| figure.signed(value)).collect());
    if figure == Figure::Time {
        let real = sampled_interval(Figure::Real)?;
        return times(sampled_interval(figure)?.standard_error, (real.low, real.high));
    }
    sampled_interval(figure)
}
