//! Modes measured in a free response: matrix pencil (Hua and Sarkar 1990), refined by least squares, which gives their errors.

use doublet_core::decompose::{eigenvalues, singular};
use nalgebra::{Complex, DMatrix, DVector};
use thiserror::Error;

/// A mode measured in a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredMode {
    /// Real part of the eigenvalue, 1/s.
    pub real_1_s: f64,
    /// Imaginary part, not negative, rad/s.
    pub imaginary_rad_s: f64,
    /// Standard error of the real part, 1/s.
    pub real_error: f64,
    /// Standard error of the imaginary part, rad/s.
    pub imaginary_error: f64,
    /// Largest amplitude in any of the signals, in its unit.
    pub amplitude: f64,
}

impl MeasuredMode {
    /// Undamped natural frequency, rad/s.
    pub fn frequency_rad_s(&self) -> f64 {
        self.real_1_s.hypot(self.imaginary_rad_s)
    }

    /// Damping ratio.
    pub fn damping(&self) -> f64 {
        -self.real_1_s / self.frequency_rad_s()
    }
}

/// A free response and the modes that make it up.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeResponse {
    /// Modes, fastest first.
    pub modes: Vec<MeasuredMode>,
    /// Root mean square of what is left of each signal.
    pub residual: Vec<f64>,
    /// Offset of each signal.
    pub offset: Vec<f64>,
}

/// Why a free response cannot be fitted.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum PencilError {
    #[error(
        "{samples} samples are too few for {order} eigenvalues in {signals} signals: lengthen the record or lower the order"
    )]
    TooShort { samples: usize, order: usize, signals: usize },
    #[error("signal {signal} is not finite or has another length than the others")]
    Signal { signal: usize },
    #[error("the modes cannot be separated: not a free response, or too short for its slowest mode")]
    NoFit,
}

/// Fits `y_j(t) = offset_j + sum over modes` with common eigenvalues to signals sampled every `step_s`; `order` counts eigenvalues, two
/// per oscillation. Errors are those of least squares with white residuals of each signal's own size.
pub fn fit_free_response(signals: &[&[f64]], step_s: f64, order: usize) -> Result<FreeResponse, PencilError> {
    let samples = signals.first().map_or(0, |signal| signal.len());
    let count = signals.len();
    if order == 0 || samples < 3 * (order + 1) || samples * count <= order * (count + 1) + count {
        return Err(PencilError::TooShort { samples, order, signals: count });
    }
    if let Some(signal) =
        signals.iter().position(|signal| signal.len() != samples || signal.iter().any(|value| !value.is_finite()))
    {
        return Err(PencilError::Signal { signal: signal + 1 });
    }
    let start = pencil(signals, order, step_s).ok_or(PencilError::NoFit)?;
    let mut fit = Fit::new(signals, step_s, &start);
    fit.refine().ok_or(PencilError::NoFit)
}

/// Longest pencil, samples: longer ones gain little and cost the cube.
const LONGEST_PENCIL: usize = 60;

/// Eigenvalues, one of each pair: those of the shift of the signal's row space. The offset is one more, at zero: of the real ones the
/// slowest is left out.
fn pencil(signals: &[&[f64]], order: usize, step_s: f64) -> Option<Vec<Complex<f64>>> {
    let samples = signals.first()?.len();
    // A coarser grid where the stretch is long.
    let stride = (samples / (3 * LONGEST_PENCIL)).max(1);
    let scaled: Vec<Vec<f64>> = signals
        .iter()
        .map(|signal| {
            let kept: Vec<f64> = signal.iter().step_by(stride).copied().collect();
            let size = kept.iter().map(|value| value * value).sum::<f64>().sqrt();
            kept.iter().map(|value| value / size.max(f64::MIN_POSITIVE)).collect()
        })
        .collect();
    let length = scaled.first()?.len();
    let order = order + 1;
    let width = (length / 2).min(LONGEST_PENCIL).max(order + 1);
    let rows = length.checked_sub(width)?;
    if rows <= order {
        return None;
    }
    let hankel = DMatrix::from_fn(rows * scaled.len(), width + 1, |i, j| scaled[i / rows][i % rows + j]);
    let right = singular(hankel, false, true)?.v_t?;
    let space = right.rows(0, order.min(right.nrows())).transpose();
    let (first, second) = (space.rows(0, width).into_owned(), space.rows(1, width).into_owned());
    let shift = singular(first, true, true)?.solve(&second, 1e-12).ok()?;
    let step = step_s * stride as f64;
    let values = eigenvalues(shift)?;
    let mut found: Vec<Complex<f64>> = values
        .iter()
        .filter(|value| value.norm() > 1e-6)
        .map(|value| value.ln() / step)
        // Two real ones of a block come with what rounding leaves of an imaginary part.
        .map(|value| if value.im.abs() < 1e-6 * value.norm() { Complex::new(value.re, 0.0) } else { value })
        // A negative real value has no counterpart in continuous time.
        .filter(|value| value.im >= 0.0 && value.im < 0.999 * std::f64::consts::PI / step)
        .collect();
    found.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    match found.iter().rposition(|value| value.im == 0.0) {
        Some(offset) => _ = found.remove(offset),
        // Noise made a pair of the offset and the slow real one beside it: their sum is that one.
        None => {
            let slowest = found.iter_mut().min_by(|a, b| a.im.total_cmp(&b.im))?;
            *slowest = Complex::new(2.0 * slowest.re, 0.0);
        }
    }
    (!found.is_empty()).then_some(found)
}

/// Least squares over eigenvalues, amplitudes and offsets.
struct Fit<'a> {
    signals: &'a [&'a [f64]],
    step_s: f64,
    values: Vec<Complex<f64>>,
}

/// Least sum of squares at some eigenvalues.
struct Amplitudes {
    /// Per signal: offset, then cosine and sine (or the one) amplitude of each mode.
    found: Vec<DVector<f64>>,
    /// Variance of the residual of each signal.
    variance: Vec<f64>,
    cost: f64,
}

impl<'a> Fit<'a> {
    fn new(signals: &'a [&'a [f64]], step_s: f64, values: &[Complex<f64>]) -> Self {
        Self { signals, step_s, values: values.to_vec() }
    }

    fn samples(&self) -> usize {
        self.signals[0].len()
    }

    fn time(&self, k: usize) -> f64 {
        k as f64 * self.step_s
    }

    /// Columns of the amplitudes: one, then `exp(a t) cos(b t)` and `exp(a t) sin(b t)`, or `exp(a t)`.
    fn basis(&self, values: &[Complex<f64>]) -> DMatrix<f64> {
        let mut columns = vec![DVector::from_element(self.samples(), 1.0)];
        for value in values {
            let at = |part: &dyn Fn(f64) -> f64| {
                DVector::from_fn(self.samples(), |k, _| (value.re * self.time(k)).exp() * part(value.im * self.time(k)))
            };
            columns.push(at(&f64::cos));
            if value.im > 0.0 {
                columns.push(at(&f64::sin));
            }
        }
        DMatrix::from_columns(&columns)
    }

    fn amplitudes(&self, values: &[Complex<f64>]) -> Option<Amplitudes> {
        let basis = self.basis(values);
        // A mode that grows too fast overflows: there are no amplitudes of it.
        let decomposition = singular(basis.clone(), true, true)?;
        let (mut found, mut variance, mut cost) = (Vec::new(), Vec::new(), 0.0);
        for signal in self.signals {
            let signal = DVector::from_column_slice(signal);
            let amplitudes = decomposition.solve(&signal, 1e-12).ok()?;
            let rest = (&signal - &basis * &amplitudes).norm_squared();
            let spread = signal.add_scalar(-signal.mean()).norm_squared().max(f64::MIN_POSITIVE);
            cost += rest / spread;
            variance.push(rest / (signal.len() as f64 - basis.ncols() as f64).max(1.0));
            found.push(amplitudes);
        }
        cost.is_finite().then_some(Amplitudes { found, variance, cost })
    }

    /// Gauss-Newton steps over the eigenvalues, amplitudes solved anew at each, then the errors.
    fn refine(&mut self) -> Option<FreeResponse> {
        /// Steps at most.
        const STEPS: usize = 30;
        let mut current = self.amplitudes(&self.values)?;
        for _ in 0..STEPS {
            let (jacobian, rest) = self.jacobian(&current);
            let step = singular(jacobian, true, true)?.solve(&rest, 1e-12).ok()?;
            let mut share = 1.0;
            let better = loop {
                let values = self.moved(&step, share);
                match self.amplitudes(&values) {
                    Some(next) if next.cost < current.cost => break Some((values, next)),
                    _ if share < 1e-3 => break None,
                    _ => share *= 0.5,
                }
            };
            let Some((values, next)) = better else { break };
            let gain = current.cost - next.cost;
            (self.values, current) = (values, next);
            if gain < 1e-14 * current.cost {
                break;
            }
        }
        self.outcome(&current)
    }

    /// Eigenvalues after a share of a step; the first entries of the step are theirs.
    fn moved(&self, step: &DVector<f64>, share: f64) -> Vec<Complex<f64>> {
        let mut place = 0;
        let mut take = || {
            place += 1;
            share * step[place - 1]
        };
        let one = |value: &Complex<f64>| {
            let real = value.re + take();
            let imaginary = if value.im > 0.0 { (value.im + take()).abs() } else { 0.0 };
            Complex::new(real, imaginary)
        };
        self.values.iter().map(one).collect()
    }

    /// Slopes of all signals over eigenvalues, then each signal's amplitudes, and the residuals; each signal divided by its standard
    /// deviation.
    fn jacobian(&self, current: &Amplitudes) -> (DMatrix<f64>, DVector<f64>) {
        let (samples, basis) = (self.samples(), self.basis(&self.values));
        let own = basis.ncols();
        let shared: usize = self.values.iter().map(|value| if value.im > 0.0 { 2 } else { 1 }).sum();
        let rows = samples * self.signals.len();
        let mut jacobian = DMatrix::zeros(rows, shared + own * self.signals.len());
        let mut rest = DVector::zeros(rows);
        for (j, (signal, amplitudes)) in self.signals.iter().zip(&current.found).enumerate() {
            let weight = 1.0 / current.variance[j].max(f64::MIN_POSITIVE).sqrt();
            let fitted = &basis * amplitudes;
            for k in 0..samples {
                let (row, time) = (j * samples + k, self.time(k));
                rest[row] = weight * (signal[k] - fitted[k]);
                let (mut column, mut term) = (0, 1);
                for value in &self.values {
                    let cosine = basis[(k, term)];
                    if value.im > 0.0 {
                        let (a, b, sine) = (amplitudes[term], amplitudes[term + 1], basis[(k, term + 1)]);
                        jacobian[(row, column)] = weight * time * (a * cosine + b * sine);
                        jacobian[(row, column + 1)] = weight * time * (b * cosine - a * sine);
                        (column, term) = (column + 2, term + 2);
                    } else {
                        jacobian[(row, column)] = weight * time * amplitudes[term] * cosine;
                        (column, term) = (column + 1, term + 1);
                    }
                }
                for other in 0..own {
                    jacobian[(row, shared + j * own + other)] = weight * basis[(k, other)];
                }
            }
        }
        (jacobian, rest)
    }

    fn outcome(&self, current: &Amplitudes) -> Option<FreeResponse> {
        let (jacobian, _) = self.jacobian(current);
        let information = jacobian.transpose() * &jacobian;
        let covariance = information.cholesky()?.inverse();
        let (mut column, mut term, mut modes) = (0, 1, Vec::new());
        for value in &self.values {
            let error = |column: usize| covariance[(column, column)].max(0.0).sqrt();
            let oscillates = value.im > 0.0;
            let size = |amplitudes: &DVector<f64>| {
                if oscillates { amplitudes[term].hypot(amplitudes[term + 1]) } else { amplitudes[term].abs() }
            };
            modes.push(MeasuredMode {
                real_1_s: value.re,
                imaginary_rad_s: value.im,
                real_error: error(column),
                imaginary_error: if oscillates { error(column + 1) } else { 0.0 },
                amplitude: current.found.iter().map(size).fold(0.0, f64::max),
            });
            let width = if oscillates { 2 } else { 1 };
            (column, term) = (column + width, term + width);
        }
        modes.sort_by(|a, b| b.frequency_rad_s().total_cmp(&a.frequency_rad_s()));
        Some(FreeResponse {
            modes,
            residual: current.variance.iter().map(|variance| variance.sqrt()).collect(),
            offset: current.found.iter().map(|amplitudes| amplitudes[0]).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitudes_of_a_mode_that_overflows_do_not_exist() {
        let signal: Vec<f64> = (0..200).map(|k| (0.1 * f64::from(k)).sin()).collect();
        let signals = [signal.as_slice()];
        let values = [Complex::new(1e3, 2.0)];
        let fit = Fit::new(&signals, 0.02, &values);
        assert!(fit.amplitudes(&values).is_none());
    }
}
