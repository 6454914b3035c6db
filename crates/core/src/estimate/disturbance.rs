//! What disturbs a flight and is in no model, as error of what output error makes of the flight.

use nalgebra::{DMatrix, DVector};

use super::covariance::Taper;
use super::flight_output_error::Problem;
use super::{EstimateError, FlightFitError, FlightFreedom, FlightOutputFit, FlightWindow};
use crate::model::Coefficient;
use crate::replay::MotionAxis;

/// Time between the knots of a disturbance, s: what is faster hardly moves a manned aircraft, whose rigid-body modes are slower than
/// 2 Hz. Of a small unmanned one, with faster modes, a part of the variance is left out.
const KNOTS_S: f64 = 0.25;
/// Knots of a window at most; in longer ones they lie further apart.
const MOST_KNOTS: usize = 120;
/// Smallest disturbance flown to learn what one does.
const LEAST: f64 = 1e-5;

/// What the coefficients of an axis leave unexplained along the recorded motion of a window: the coefficient, one of
/// `CX CY CZ Cl Cm Cn`, and a value per sample.
pub type Unexplained = (Coefficient, Vec<f64>);

/// Covariance that unmodelled forces and moments give to the estimates of [`super::flight_output_error`], whose simulation knows
/// none: a gust moves the aircraft, and the derivatives follow it.
///
/// With the disturbance `d_c(t) = sum_i a_ci h_i(t)` of coefficient `c` by hat functions `h_i`, the estimates move by
/// `g_ci = D S' R^-1 dy/da_ci` for each unit of `a_ci`, `dy/da` from one more flight each; the covariance is
/// `sum_{c,c'} sum_{i,j} w_{|i-j|} R_cc'(j - i) g_ci g_c'j'` with the correlation `R` of the amplitudes found in `unexplained` and the
/// weights of [`Taper::Parzen`]. It adds to that of the measurement noise.
///
/// Its rows are those of the estimates. `windows`, `freedom` and `found` are those of the estimation; `unexplained` has the
/// coefficients of each window. `go_on` is asked before every simulated flight.
///
/// # Errors
/// [`FlightFitError::Stopped`], columns of another length, a flight that cannot be flown.
pub fn disturbance_covariance(
    axis: MotionAxis,
    (windows, freedom): (&[FlightWindow<'_>], &FlightFreedom),
    found: &FlightOutputFit,
    unexplained: &[Vec<Unexplained>],
    go_on: &dyn Fn() -> bool,
) -> Result<DMatrix<f64>, FlightFitError> {
    let estimates = found.fit.names.len();
    let mut products = DMatrix::zeros(estimates, estimates);
    for (index, disturbances) in unexplained.iter().enumerate().take(windows.len()) {
        let problem = Problem { axis, windows, freedom };
        let time_s = windows[index].replay.time_s();
        let knots = Knots::new(time_s);
        let mut gains = Vec::with_capacity(disturbances.len());
        let mut amplitudes = Vec::with_capacity(disturbances.len());
        for (coefficient, values) in disturbances {
            if values.len() != time_s.len() {
                let (expected, found) = (time_s.len(), values.len());
                return Err(EstimateError::Size { quantity: "unexplained coefficient", expected, found }.into());
            }
            let own = knots.amplitudes(time_s, values);
            let size = (own.iter().map(|a| a * a).sum::<f64>() / own.len() as f64).sqrt().max(LEAST);
            gains.push(gains_of(&problem, index, found, (*coefficient, size), &knots, go_on)?);
            amplitudes.push(own);
        }
        add_products(&gains, &amplitudes, &mut products);
    }
    Ok(0.5 * (&products + products.transpose()))
}

/// Hat functions over a window.
struct Knots {
    first_s: f64,
    spacing_s: f64,
    count: usize,
}

impl Knots {
    fn new(time_s: &[f64]) -> Self {
        let first_s = time_s.first().copied().unwrap_or(0.0);
        let length_s = time_s.last().copied().unwrap_or(0.0) - first_s;
        let count = ((length_s / KNOTS_S).ceil() as usize + 1).clamp(2, MOST_KNOTS);
        Self { first_s, spacing_s: length_s / (count - 1) as f64, count }
    }

    /// Hat `knot` at a time.
    fn hat(&self, knot: usize, time_s: f64) -> f64 {
        let from_knot = (time_s - self.first_s) / self.spacing_s - knot as f64;
        (1.0 - from_knot.abs()).max(0.0)
    }

    /// Mean of `values` under each hat.
    fn amplitudes(&self, time_s: &[f64], values: &[f64]) -> Vec<f64> {
        let under = |knot: usize| {
            let weighted = time_s.iter().zip(values).map(|(&time, value)| (self.hat(knot, time), value));
            let (weights, sum) =
                weighted.fold((0.0, 0.0), |(weights, sum), (hat, value)| (weights + hat, sum + hat * value));
            if weights > 0.0 { sum / weights } else { 0.0 }
        };
        (0..self.count).map(under).collect()
    }
}

/// Change of the estimates with each amplitude of one coefficient, knots by estimates; `size` is flown.
fn gains_of(
    problem: &Problem<'_>,
    index: usize,
    found: &FlightOutputFit,
    (coefficient, size): (Coefficient, f64),
    knots: &Knots,
    go_on: &dyn Fn() -> bool,
) -> Result<DMatrix<f64>, FlightFitError> {
    let fit = &found.fit;
    let theta = problem.of_window(index, &fit.estimates);
    let range = &found.samples[index];
    let undisturbed = fit.outputs.rows(range.start, range.len());
    let mut replay = problem.windows[index].replay.clone();
    let time_s = problem.windows[index].replay.time_s();
    let mut gains = DMatrix::zeros(knots.count, fit.names.len());
    for knot in 0..knots.count {
        if !go_on() {
            return Err(FlightFitError::Stopped);
        }
        replay.disturb(coefficient, time_s.iter().map(|&time| size * knots.hat(knot, time)));
        let mut change = problem.fly_in(&replay, index, &theta)? - undisturbed;
        for (mut column, noise) in change.column_iter_mut().zip(&fit.noise) {
            column.scale_mut((noise * noise * size).recip());
        }
        let towards = fit.sensitivities.iter().map(|s| s.rows(range.start, range.len()).dot(&change));
        let gradient = DVector::from_iterator(fit.names.len(), towards);
        gains.set_row(knot, &(&fit.covariance * gradient).transpose());
    }
    Ok(gains)
}

/// Adds `sum_{c,c'} sum_{i,j} w_{|i-j|} R_cc'(j - i) g_ci g_c'j'` to `products`, lags of the other sign as those of the pair the other way
/// round: it is the mean of this and its transpose.
fn add_products(gains: &[DMatrix<f64>], amplitudes: &[Vec<f64>], products: &mut DMatrix<f64>) {
    let Some(knots) = amplitudes.first().map(Vec::len) else { return };
    let weights: Vec<f64> = Taper::Parzen.weights(knots / 5).collect();
    for (a, first) in amplitudes.iter().enumerate() {
        for (b, second) in amplitudes.iter().enumerate() {
            for (lag, weight) in weights.iter().enumerate() {
                // Lag zero has no other sign.
                let both = if lag == 0 { 1.0 } else { 2.0 };
                let common: f64 = first.iter().zip(&second[lag..]).map(|(x, y)| x * y).sum();
                let correlation = both * weight * common / knots as f64;
                for (column, later) in gains[b].column_iter().enumerate() {
                    let later = &later.as_slice()[lag..];
                    for (row, earlier) in gains[a].column_iter().enumerate() {
                        let pairs: f64 = earlier.as_slice().iter().zip(later).map(|(x, y)| x * y).sum();
                        products[(row, column)] += correlation * pairs;
                    }
                }
            }
        }
    }
}
