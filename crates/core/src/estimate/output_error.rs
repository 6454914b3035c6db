//! Output error in the time domain: parameters of a simulation that follows the measurement.

use nalgebra::{DMatrix, DVector, DVectorView, SymmetricEigen};

use super::fit::{correlation, standard_errors};
use super::{EstimateError, FitQuality};

/// A parameter of the simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputParameter {
    /// Name.
    pub name: String,
    /// Value to start from.
    pub start: f64,
    /// Smallest change that matters: the floor of the step of differentiation.
    pub scale: f64,
    /// Smallest and largest value.
    pub bounds: (f64, f64),
}

/// When the iteration ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutputErrorSettings {
    /// Steps at most.
    pub max_iterations: usize,
    /// Gain of log-likelihood, `N/2` times the fall of `ln |R|`, that ends the iteration: half the square of the step in standard
    /// errors.
    pub tolerance: f64,
    /// Step of differentiation as a fraction of the value, at least that of the parameter's scale.
    pub relative_step: f64,
}

impl Default for OutputErrorSettings {
    fn default() -> Self {
        Self { max_iterations: 50, tolerance: 1e-3, relative_step: 0.01 }
    }
}

/// Result of an output-error estimation.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputErrorFit {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Estimates.
    pub estimates: Vec<f64>,
    /// Inverse information matrix (Cramer-Rao bound for white residuals); zero for parameters at a bound.
    pub covariance: DMatrix<f64>,
    /// Square roots of its diagonal.
    pub standard_errors: Vec<f64>,
    /// Correlation of the parameters.
    pub correlation: DMatrix<f64>,
    /// Standard deviation of the residual of each output.
    pub noise: Vec<f64>,
    /// Quality of each output.
    pub quality: Vec<FitQuality>,
    /// Outputs of the simulation, samples by outputs.
    pub outputs: DMatrix<f64>,
    /// Change of the outputs with each parameter there.
    pub sensitivities: Vec<DMatrix<f64>>,
    /// Cost `ln |R|` before each step and at the end.
    pub cost: Vec<f64>,
    /// Parameters held by a bound.
    pub at_bound: Vec<bool>,
}

/// Halvings of a step, or tenfold dampings, after which the iteration counts as ended.
const MAX_HALVINGS: usize = 10;
/// Damping, as a fraction of the diagonal of the information matrix, tried first when a step raises the cost.
const FIRST_DAMPING: f64 = 1e-4;

/// Output error by Gauss-Newton (Maine and Iliff, NASA RP-1168; Jategaonkar, chapter 4): minimises `ln |R|` with
/// `R = (1/N) sum v_i v_i'` diagonal, `v` the measurement less the output of `simulate(parameters)`.
///
/// Alternates the noise estimate and the step `M^-1 g` with `M = sum S_i' R^-1 S_i`, `g = sum S_i' R^-1 v_i`, sensitivities `S`
/// by central differences. A step that raises the cost is damped (Levenberg-Marquardt). A parameter at a bound stays there
/// while the step points out. `measured`: samples by outputs, not finite where nothing was measured; `simulate` returns the
/// same shape, windows one below the other, each with its own initial states and biases among the parameters.
///
/// # Errors
/// Shapes that differ, parameters without influence or that the data cannot tell apart, an iteration that does not settle,
/// and whatever `simulate` gives at the start; an error or a value that is not finite at a trial counts as a failed step.
pub fn output_error<E: From<EstimateError>>(
    parameters: &[OutputParameter],
    measured: &DMatrix<f64>,
    settings: &OutputErrorSettings,
    mut simulate: impl FnMut(&[f64]) -> Result<DMatrix<f64>, E>,
) -> Result<OutputErrorFit, E> {
    output_error_in_lanes(parameters, measured, settings, 1, |several| {
        several.iter().map(|theta| simulate(theta)).collect()
    })
}

/// As [`output_error`], with a simulation of several sets of parameters at once, at most `lanes`: a result for each.
pub(super) fn output_error_in_lanes<E: From<EstimateError>>(
    parameters: &[OutputParameter],
    measured: &DMatrix<f64>,
    settings: &OutputErrorSettings,
    lanes: usize,
    mut simulate_all: impl FnMut(&[Vec<f64>]) -> Vec<Result<DMatrix<f64>, E>>,
) -> Result<OutputErrorFit, E> {
    check_parameters(parameters)?;
    let mut theta: Vec<f64> = parameters.iter().map(|p| p.start.clamp(p.bounds.0, p.bounds.1)).collect();
    let mut outputs = simulate_one(&mut simulate_all, &theta)?;
    if outputs.shape() != measured.shape() {
        return Err(EstimateError::Size {
            quantity: "outputs of the simulation",
            expected: measured.len(),
            found: outputs.len(),
        }
        .into());
    }
    let mut cost = vec![cost_of(measured, &outputs)];
    let mut settled = false;
    let mut information;
    let mut held;
    let mut sensitivity;
    loop {
        let noise = noise_of(measured, &outputs);
        sensitivity = sensitivities((parameters, &theta), settings, &outputs, lanes, &mut simulate_all);
        let gradient;
        (information, gradient) = normal_equations(measured, &outputs, &noise, &sensitivity);
        held = held_by_bounds(parameters, &theta, &gradient);
        if settled {
            break;
        }
        if cost.len() > settings.max_iterations {
            return Err(
                EstimateError::NotConverged { method: "output error", iterations: settings.max_iterations }.into()
            );
        }
        let now = cost[cost.len() - 1];
        let mut damping = 0.0;
        let mut accepted = None;
        for _ in 0..=MAX_HALVINGS {
            let step = solve_free(parameters, &information, &gradient, &held, damping)?;
            let trial: Vec<f64> = (0..theta.len())
                .map(|index| (theta[index] + step[index]).clamp(parameters[index].bounds.0, parameters[index].bounds.1))
                .collect();
            if let Ok(result) = simulate_one(&mut simulate_all, &trial) {
                let cost = cost_of(measured, &result);
                if cost < now {
                    accepted = Some((trial, result, cost));
                    break;
                }
            }
            damping = if damping == 0.0 { FIRST_DAMPING } else { damping * 10.0 };
        }
        match accepted {
            Some((trial, result, next)) => {
                (theta, outputs) = (trial, result);
                cost.push(next);
                settled = 0.5 * measured.nrows() as f64 * (now - next) <= settings.tolerance;
            }
            None => settled = true,
        }
    }
    Ok(finish(parameters, theta, measured, (outputs, sensitivity), &information, held, cost)?)
}

/// Checks start values, scales and bounds.
fn check_parameters(parameters: &[OutputParameter]) -> Result<(), EstimateError> {
    if parameters.is_empty() {
        return Err(EstimateError::NoParameters);
    }
    for parameter in parameters {
        let OutputParameter { name, start, scale, bounds } = parameter;
        let fault = |value, allowed| EstimateError::Setting { setting: name.clone(), value, allowed };
        if !start.is_finite() {
            return Err(fault(*start, "a finite start"));
        }
        if !(*scale > 0.0 && scale.is_finite()) {
            return Err(fault(*scale, "a positive scale"));
        }
        if bounds.0.partial_cmp(&bounds.1) != Some(std::cmp::Ordering::Less) {
            return Err(fault(bounds.0, "a lower bound below the upper one"));
        }
    }
    Ok(())
}

/// Standard deviation of the residual of each output, over the samples measured.
fn noise_of(measured: &DMatrix<f64>, outputs: &DMatrix<f64>) -> Vec<f64> {
    measured.column_iter().zip(outputs.column_iter()).map(|(z, y)| deviation_of(z, y)).collect()
}

fn deviation_of(z: DVectorView<'_, f64>, y: DVectorView<'_, f64>) -> f64 {
    let residuals = z.iter().zip(y.iter()).filter(|(z, _)| z.is_finite()).map(|(z, y)| (z - y).powi(2));
    let (sum, count) = residuals.fold((0.0, 0_usize), |(sum, count), square| (sum + square, count + 1));
    // An output that fits exactly would weigh infinitely: its noise is at least what rounding leaves.
    let largest = z.iter().filter(|z| z.is_finite()).fold(f64::MIN_POSITIVE, |largest, z| largest.max(z.abs()));
    (sum / count.max(1) as f64).sqrt().max(largest * f64::EPSILON)
}

/// `ln |R|`; infinite where the simulation is not finite.
fn cost_of(measured: &DMatrix<f64>, outputs: &DMatrix<f64>) -> f64 {
    if outputs.iter().any(|value| !value.is_finite()) {
        return f64::INFINITY;
    }
    2.0 * noise_of(measured, outputs).iter().map(|noise| noise.ln()).sum::<f64>()
}

/// Outputs of one set of parameters.
fn simulate_one<E: From<EstimateError>>(
    simulate_all: &mut impl FnMut(&[Vec<f64>]) -> Vec<Result<DMatrix<f64>, E>>,
    theta: &[f64],
) -> Result<DMatrix<f64>, E> {
    let found = simulate_all(&[theta.to_vec()]).pop();
    found.unwrap_or_else(|| Err(EstimateError::NoParameters.into()))
}

/// Change of the outputs with each parameter, by central differences; one-sided where the other side fails.
fn sensitivities<E>(
    (parameters, theta): (&[OutputParameter], &[f64]),
    settings: &OutputErrorSettings,
    outputs: &DMatrix<f64>,
    lanes: usize,
    simulate_all: &mut impl FnMut(&[Vec<f64>]) -> Vec<Result<DMatrix<f64>, E>>,
) -> Vec<DMatrix<f64>> {
    let step = |index: usize| {
        (settings.relative_step * theta[index].abs()).max(settings.relative_step * parameters[index].scale)
    };
    let shifted = |index: usize, sign: f64| {
        let mut shifted = theta.to_vec();
        shifted[index] = theta[index] + sign * step(index);
        shifted
    };
    let all: Vec<Vec<f64>> = (0..theta.len()).flat_map(|index| [shifted(index, 1.0), shifted(index, -1.0)]).collect();
    // No more than `lanes` outputs, and those of one parameter, exist at a time.
    let mut sides = all
        .chunks(lanes.max(1))
        .flat_map(simulate_all)
        .map(|found| found.ok().filter(|found| found.iter().all(|value| value.is_finite())));
    let mut result = Vec::with_capacity(theta.len());
    for index in 0..theta.len() {
        let sides = (sides.next().flatten(), sides.next().flatten());
        result.push(match sides {
            (Some(above), Some(below)) => (above - below) / (2.0 * step(index)),
            (Some(above), None) => (above - outputs) / step(index),
            (None, Some(below)) => (outputs - below) / step(index),
            (None, None) => DMatrix::zeros(outputs.nrows(), outputs.ncols()),
        });
    }
    result
}

/// Information matrix and gradient.
fn normal_equations(
    measured: &DMatrix<f64>,
    outputs: &DMatrix<f64>,
    noise: &[f64],
    sensitivities: &[DMatrix<f64>],
) -> (DMatrix<f64>, DVector<f64>) {
    let mut rows = DMatrix::zeros(measured.len(), sensitivities.len());
    let mut residuals = DVector::zeros(measured.len());
    for (entry, (z, y)) in measured.iter().zip(outputs.iter()).enumerate().filter(|(_, (z, _))| z.is_finite()) {
        let weight = 1.0 / noise[entry / measured.nrows()];
        residuals[entry] = (z - y) * weight;
        for (column, sensitivity) in sensitivities.iter().enumerate() {
            rows[(entry, column)] = sensitivity[entry] * weight;
        }
    }
    (rows.tr_mul(&rows), rows.tr_mul(&residuals))
}

/// Parameters at a bound whose gradient points outside.
fn held_by_bounds(parameters: &[OutputParameter], theta: &[f64], gradient: &DVector<f64>) -> Vec<bool> {
    let held = |(index, parameter): (usize, &OutputParameter)| {
        (theta[index] <= parameter.bounds.0 && gradient[index] < 0.0)
            || (theta[index] >= parameter.bounds.1 && gradient[index] > 0.0)
    };
    parameters.iter().enumerate().map(held).collect()
}

/// Damped step of the free parameters, zero for the others.
fn solve_free(
    parameters: &[OutputParameter],
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    held: &[bool],
    damping: f64,
) -> Result<DVector<f64>, EstimateError> {
    let free: Vec<usize> = (0..held.len()).filter(|&index| !held[index]).collect();
    let mut step = DVector::zeros(held.len());
    if free.is_empty() {
        return Ok(step);
    }
    let (scaled, scale) = scaled_information(parameters, information, &free)?;
    let damped = scaled + DMatrix::identity(free.len(), free.len()) * damping;
    let right = gradient.select_rows(&free).component_mul(&scale);
    let factor = damped.clone().cholesky().ok_or_else(|| dependent(parameters, &free, damped))?;
    for (value, &index) in factor.solve(&right).component_mul(&scale).iter().zip(&free) {
        step[index] = *value;
    }
    Ok(step)
}

/// Information of the free parameters with a unit diagonal, and the scale that makes it so.
fn scaled_information(
    parameters: &[OutputParameter],
    information: &DMatrix<f64>,
    free: &[usize],
) -> Result<(DMatrix<f64>, DVector<f64>), EstimateError> {
    if let Some(&index) = free.iter().find(|&&index| information[(index, index)] <= 0.0) {
        let dependent = vec![super::Dependence { name: parameters[index].name.clone(), on: Vec::new() }];
        return Err(EstimateError::RankDeficient { rank: free.len() - 1, parameters: free.len(), dependent });
    }
    let scale = DVector::from_iterator(free.len(), free.iter().map(|&index| 1.0 / information[(index, index)].sqrt()));
    let scaled = DMatrix::from_fn(free.len(), free.len(), |i, j| information[(free[i], free[j])] * scale[i] * scale[j]);
    Ok((scaled, scale))
}

/// Parameters the data cannot tell apart: those that share the weakest direction of the scaled information.
fn dependent(parameters: &[OutputParameter], free: &[usize], scaled: DMatrix<f64>) -> EstimateError {
    /// Share of the largest part in the direction from which on a parameter is named.
    const NAMED: f64 = 0.05;
    let eigen = SymmetricEigen::new(scaled);
    let direction = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    let mut order: Vec<usize> = (0..free.len()).collect();
    order.sort_by(|&a, &b| direction[b].abs().total_cmp(&direction[a].abs()));
    let largest = order.first().map_or(0.0, |&first| direction[first].abs());
    let named = order.iter().filter(|&&k| direction[k].abs() > NAMED * largest);
    let mut names = named.map(|&k| parameters[free[k]].name.clone());
    let name = names.next().unwrap_or_default();
    let dependent = vec![super::Dependence { name, on: names.collect() }];
    EstimateError::RankDeficient { rank: free.len().saturating_sub(1), parameters: free.len(), dependent }
}

/// Puts the result together.
fn finish(
    parameters: &[OutputParameter],
    theta: Vec<f64>,
    measured: &DMatrix<f64>,
    (outputs, sensitivities): (DMatrix<f64>, Vec<DMatrix<f64>>),
    information: &DMatrix<f64>,
    held: Vec<bool>,
    cost: Vec<f64>,
) -> Result<OutputErrorFit, EstimateError> {
    let free: Vec<usize> = (0..held.len()).filter(|&index| !held[index]).collect();
    let mut covariance = DMatrix::zeros(held.len(), held.len());
    if !free.is_empty() {
        let (scaled, scale) = scaled_information(parameters, information, &free)?;
        let factor = scaled.clone().cholesky().ok_or_else(|| dependent(parameters, &free, scaled))?;
        let inverse = factor.inverse();
        for (i, &row) in free.iter().enumerate() {
            for (j, &column) in free.iter().enumerate() {
                covariance[(row, column)] = inverse[(i, j)] * scale[i] * scale[j];
            }
        }
    }
    let quality = measured.column_iter().zip(outputs.column_iter()).map(|(z, y)| {
        let (z, y): (Vec<f64>, Vec<f64>) = z.iter().zip(y.iter()).filter(|(z, _)| z.is_finite()).unzip();
        FitQuality::compare(&z, &y)
    });
    Ok(OutputErrorFit {
        names: parameters.iter().map(|parameter| parameter.name.clone()).collect(),
        estimates: theta,
        standard_errors: standard_errors(&covariance),
        correlation: correlation(&covariance),
        covariance,
        noise: noise_of(measured, &outputs),
        quality: quality.collect(),
        outputs,
        sensitivities,
        cost,
        at_bound: held,
    })
}
