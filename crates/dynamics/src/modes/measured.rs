//! Period and damping of an oscillation as recorded.

use std::f64::consts::{LN_2, PI, TAU};

use doublet_core::decompose::singular;
use nalgebra::{DMatrix, DVector, Matrix2};
use thiserror::Error;

/// A number with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct Read {
    pub value: f64,
    pub standard_error: f64,
}

/// A damped oscillation `x(t) = c + d t + exp(-s t) (a cos(w t) + b sin(w t))`, `t` from the first sample, fitted to a record by least
/// squares. Standard errors are those of the fit, corrected for the correlation of its residuals in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// Decay `s = zeta w_n`, 1/s; negative for a growing oscillation.
    pub decay_1_s: Read,
    /// Damped frequency `w = w_n sqrt(1 - zeta^2)`, rad/s.
    pub frequency_rad_s: Read,
    /// Covariance of the two.
    pub covariance: f64,
    /// Amplitude at the first sample, in the unit of the record.
    pub amplitude: f64,
    /// Root mean square of the residual, in the same unit.
    pub residual_rms: f64,
    /// Cycles in the record.
    pub cycles: f64,
}

/// Why no oscillation can be read.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum ReadError {
    #[error("{samples} samples are too few for an oscillation: {needed} are needed")]
    TooFew { samples: usize, needed: usize },
    #[error("a sample is not a number, or its time is not later than the one before")]
    NotNumbers,
    #[error("less than a cycle of an oscillation lies in the record")]
    LessThanACycle,
    #[error("no oscillation found in the record")]
    NoOscillation,
}

impl Oscillation {
    /// Period of the damped oscillation `2 pi / w`, s.
    pub fn period_s(&self) -> Read {
        let Read { value: w, standard_error } = self.frequency_rad_s;
        Read { value: TAU / w, standard_error: TAU / (w * w) * standard_error }
    }

    /// Damping ratio `s / sqrt(s^2 + w^2)`.
    pub fn damping_ratio(&self) -> Read {
        let (s, w) = (self.decay_1_s, self.frequency_rad_s);
        let natural = s.value.hypot(w.value);
        let (by_s, by_w) = (w.value * w.value / natural.powi(3), -s.value * w.value / natural.powi(3));
        let variance =
            (by_s * s.standard_error).powi(2) + (by_w * w.standard_error).powi(2) + 2.0 * by_s * by_w * self.covariance;
        Read { value: s.value / natural, standard_error: variance.max(0.0).sqrt() }
    }

    /// Time to half amplitude `ln 2 / s`, s; negative: to double amplitude.
    pub fn half_s(&self) -> Read {
        let Read { value: s, standard_error } = self.decay_1_s;
        Read { value: LN_2 / s, standard_error: LN_2 / (s * s) * standard_error }
    }

    /// Time from the peaks of `first` to those of `second`, s, in half a period to either side: both are fitted with this oscillation's
    /// decay and frequency over the same record.
    ///
    /// # Errors
    /// Records of other lengths, or one that does not tell its phase.
    pub fn lag_s(&self, time_s: &[f64], first: &[f64], second: &[f64]) -> Result<f64, ReadError> {
        let phase = |values: &[f64]| -> Result<f64, ReadError> {
            check(time_s, values)?;
            let (_, solution) = project(time_s, values, self.decay_1_s.value, self.frequency_rad_s.value)
                .ok_or(ReadError::NoOscillation)?;
            Ok(solution[1].atan2(solution[0]))
        };
        let mut behind = phase(second)? - phase(first)?;
        behind -= TAU * ((behind + PI) / TAU).floor();
        Ok(behind / self.frequency_rad_s.value)
    }
}

const FEWEST: usize = 12;
/// Most samples the search looks at.
const SEARCHED: usize = 400;
/// Damping ratios the search begins from.
const DAMPING: [f64; 9] = [-0.2, -0.05, 0.0, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7];
/// Frequencies it begins from.
const FREQUENCIES: usize = 80;
/// Amplitude over the residual from which an oscillation stands out.
const STANDS_OUT: f64 = 3.0;
/// Relative error of the frequency beyond which it is not told.
const LARGEST_ERROR: f64 = 0.25;

/// Reads the oscillation that explains a free response best. Decay and frequency are searched over a grid and refined by Gauss-Newton
/// steps; the four other parameters follow linearly (Golub and Pereyra 1973).
///
/// # Errors
/// What keeps it from being read.
pub fn read(time_s: &[f64], values: &[f64]) -> Result<Oscillation, ReadError> {
    check(time_s, values)?;
    let begins = time_s[0];
    let time: Vec<f64> = time_s.iter().map(|time| time - begins).collect();
    let length_s = time[time.len() - 1];
    let [mut s, mut w] = search(&time, values, length_s).ok_or(ReadError::NoOscillation)?;
    let mut damper = 1e-3;
    let mut best = squares(&time, values, s, w).ok_or(ReadError::NoOscillation)?;
    for _ in 0..200 {
        let (normal, gradient) = slopes(&time, values, s, w).ok_or(ReadError::NoOscillation)?;
        let damped = normal + Matrix2::from_diagonal(&(normal.diagonal() * damper));
        let Some(inverse) = damped.try_inverse() else { break };
        let step = inverse * gradient;
        let (next_s, next_w) = (s + step[0], w + step[1]);
        match squares(&time, values, next_s, next_w).filter(|found| next_w > 0.0 && *found <= best) {
            Some(found) => {
                (s, w, best, damper) = (next_s, next_w, found, damper * 0.2);
                if step.amax() < 1e-13 * s.hypot(w) {
                    break;
                }
            }
            None if damper > 1e8 => break,
            None => damper *= 8.0,
        }
    }
    result(&time, values, s, w, length_s)
}

fn check(time_s: &[f64], values: &[f64]) -> Result<(), ReadError> {
    let samples = time_s.len().min(values.len());
    if samples < FEWEST || time_s.len() != values.len() {
        return Err(ReadError::TooFew { samples, needed: FEWEST });
    }
    let ordered = time_s.windows(2).all(|pair| pair[1] > pair[0]);
    let finite = time_s.iter().chain(values).all(|value| value.is_finite());
    if ordered && finite { Ok(()) } else { Err(ReadError::NotNumbers) }
}

/// Decay and frequency of the best point of the grid.
fn search(time: &[f64], values: &[f64], length_s: f64) -> Option<[f64; 2]> {
    let every = time.len().div_ceil(SEARCHED).max(1);
    let thin = |values: &[f64]| -> Vec<f64> { values.iter().step_by(every).copied().collect() };
    let (time, values) = (thin(time), thin(values));
    let (lowest, highest) = (TAU * 0.5 / length_s, TAU * (time.len() as f64 / 5.0) / length_s);
    let mut best = (f64::INFINITY, None);
    for step in 0..FREQUENCIES {
        let w = lowest * (highest / lowest).powf(step as f64 / (FREQUENCIES - 1) as f64);
        for zeta in DAMPING {
            let s = w * zeta / (1.0 - zeta * zeta).sqrt();
            // What grows or dies by more than that over the record cannot be told from a jump.
            if (s * length_s).abs() > 40.0 {
                continue;
            }
            if let Some(found) = squares_by_normal_equations(&time, &values, s, w).filter(|found| *found < best.0) {
                best = (found, Some([s, w]));
            }
        }
    }
    best.1
}

/// Regressors `exp(-s t) cos(w t)`, `exp(-s t) sin(w t)`, 1 and t.
fn regressors(time: &[f64], s: f64, w: f64) -> DMatrix<f64> {
    DMatrix::from_fn(time.len(), 4, |row, column| {
        let t = time[row];
        match column {
            0 => (-s * t).exp() * (w * t).cos(),
            1 => (-s * t).exp() * (w * t).sin(),
            2 => 1.0,
            _ => t,
        }
    })
}

/// Residuals and linear parameters for a decay and a frequency, times from the first sample or from any other origin.
fn project(time_s: &[f64], values: &[f64], s: f64, w: f64) -> Option<(DVector<f64>, DVector<f64>)> {
    let begins = *time_s.first()?;
    let time: Vec<f64> = time_s.iter().map(|time| time - begins).collect();
    let x = regressors(&time, s, w);
    let z = DVector::from_column_slice(values);
    let solution = singular(x.clone(), true, true)?.solve(&z, 1e-13).ok()?;
    let residual = z - x * &solution;
    residual.iter().all(|value| value.is_finite()).then_some((residual, solution))
}

fn squares(time: &[f64], values: &[f64], s: f64, w: f64) -> Option<f64> {
    Some(project(time, values, s, w)?.0.norm_squared())
}

/// The same for the search, quicker and to fewer digits.
fn squares_by_normal_equations(time: &[f64], values: &[f64], s: f64, w: f64) -> Option<f64> {
    let x = regressors(time, s, w);
    let z = DVector::from_column_slice(values);
    let solution = x.tr_mul(&x).cholesky()?.solve(&x.tr_mul(&z));
    Some((z - x * solution).norm_squared()).filter(|squares| squares.is_finite())
}

/// Normal matrix and gradient of decay and frequency, the linear parameters taken out.
fn slopes(time: &[f64], values: &[f64], s: f64, w: f64) -> Option<(Matrix2<f64>, nalgebra::Vector2<f64>)> {
    let (residual, solution) = project(time, values, s, w)?;
    let columns = projected_slopes(time, &solution, s, w)?;
    let normal = columns.transpose() * &columns;
    let gradient = columns.transpose() * residual;
    Some((normal.fixed_view::<2, 2>(0, 0).into_owned(), nalgebra::Vector2::new(gradient[0], gradient[1])))
}

/// Derivatives of the fit by decay and frequency, less what the linear parameters can take over.
fn projected_slopes(time: &[f64], solution: &DVector<f64>, s: f64, w: f64) -> Option<DMatrix<f64>> {
    let x = regressors(time, s, w);
    let (a, b) = (solution[0], solution[1]);
    let raw = DMatrix::from_fn(time.len(), 2, |row, column| {
        let (t, decay) = (time[row], (-s * time[row]).exp());
        let (sin, cos) = (w * t).sin_cos();
        let slope = if column == 0 { -(a * cos + b * sin) } else { b * cos - a * sin };
        t * decay * slope
    });
    let taken = singular(x.clone(), true, true)?.solve(&raw, 1e-13).ok()?;
    Some(raw - x * taken)
}

fn result(time: &[f64], values: &[f64], s: f64, w: f64, length_s: f64) -> Result<Oscillation, ReadError> {
    const PARAMETERS: f64 = 6.0;
    let (residual, solution) = project(time, values, s, w).ok_or(ReadError::NoOscillation)?;
    let columns = projected_slopes(time, &solution, s, w).ok_or(ReadError::NoOscillation)?;
    let normal = (columns.transpose() * columns).fixed_view::<2, 2>(0, 0).into_owned();
    let inverse = normal.try_inverse().ok_or(ReadError::NoOscillation)?;
    let samples = time.len() as f64;
    let variance = residual.norm_squared() / (samples - PARAMETERS) * correlation_length(residual.as_slice());
    let error = |index: usize| (inverse[(index, index)] * variance).max(0.0).sqrt();
    let oscillation = Oscillation {
        decay_1_s: Read { value: s, standard_error: error(0) },
        frequency_rad_s: Read { value: w, standard_error: error(1) },
        covariance: inverse[(0, 1)] * variance,
        amplitude: solution[0].hypot(solution[1]),
        residual_rms: (residual.norm_squared() / samples).sqrt(),
        cycles: length_s * w / TAU,
    };
    if oscillation.cycles < 1.0 {
        return Err(ReadError::LessThanACycle);
    }
    let is_told = oscillation.frequency_rad_s.standard_error < LARGEST_ERROR * w;
    let stands_out = oscillation.amplitude > STANDS_OUT * oscillation.residual_rms;
    if is_told && stands_out { Ok(oscillation) } else { Err(ReadError::NoOscillation) }
}

/// Samples that count as one because the residuals are correlated: `1 + 2 (r_1 + r_2 + ...)` up to the first that is not positive.
fn correlation_length(residual: &[f64]) -> f64 {
    let power: f64 = residual.iter().map(|value| value * value).sum();
    let lagged = |lag: usize| residual.iter().zip(&residual[lag..]).map(|(a, b)| a * b).sum::<f64>() / power;
    let positive = (1..residual.len() / 2).map(lagged).take_while(|value| *value > 0.0);
    1.0 + 2.0 * positive.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// `exp(-zeta w t) cos(w sqrt(1 - zeta^2) t)` over some cycles, from a time that is not zero.
    fn record(zeta: f64, omega: f64, cycles: f64) -> (Vec<f64>, Vec<f64>) {
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        let step = cycles * TAU / damped / 600.0;
        let time: Vec<f64> = (0..=600).map(|k| f64::from(k) * step).collect();
        let values = time.iter().map(|t| (-zeta * omega * t).exp() * (damped * t).cos()).collect();
        (time.iter().map(|time| time + 1200.0).collect(), values)
    }

    /// Exact cases: zeta, omega, period, time to half (negative: to double), amplitude per cycle, and half of the last digit of the
    /// two times.
    const CASES: [[f64; 7]; 3] = [
        [0.0485, 0.0673, 93.471, 212.358, 0.737054, 5.01e-4, 5.01e-4],
        [0.0351, 0.9470, 6.6389, 20.8530, 0.801977, 5.01e-5, 5.01e-5],
        [-0.0200, 0.2000, 31.4222, -173.287, 1.133929, 5.01e-5, 5.01e-4],
    ];

    #[test]
    fn exact_responses_are_read_to_the_stated_digits() {
        for [zeta, omega, period_s, half_s, ratio, of_period, of_half] in CASES {
            for cycles in [1.7, 6.0] {
                let (time, values) = record(zeta, omega, cycles);
                let found = read(&time, &values).unwrap();
                assert!((found.period_s().value - period_s).abs() < of_period, "{found:?}");
                assert!((found.half_s().value - half_s).abs() < of_half, "{found:?}");
                let per_cycle = (-found.decay_1_s.value * found.period_s().value).exp();
                assert!((per_cycle - ratio).abs() < 5.01e-7, "{found:?}");
                assert_relative_eq!(found.damping_ratio().value, zeta, max_relative = 1e-7);
                let natural_rad_s = found.decay_1_s.value.hypot(found.frequency_rad_s.value);
                assert_relative_eq!(natural_rad_s, omega, max_relative = 1e-7);
                assert_relative_eq!(found.cycles, cycles, max_relative = 1e-6);
            }
        }
    }

    #[test]
    fn standard_errors_are_the_scatter_over_noise() {
        let (time, clean) = record(0.14, 1.417, 1.7);
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut periods = Vec::new();
        let mut dampings = Vec::new();
        let mut stated = [0.0; 2];
        const RUNS: usize = 200;
        for _ in 0..RUNS {
            let noisy: Vec<f64> = clean
                .iter()
                .enumerate()
                .map(|(k, value)| {
                    let noise: f64 = StandardNormal.sample(&mut rng);
                    value + 0.03 * noise + 0.2 + 1e-4 * k as f64
                })
                .collect();
            let found = read(&time, &noisy).unwrap();
            periods.push(found.period_s().value);
            dampings.push(found.damping_ratio().value);
            stated[0] += found.period_s().standard_error / RUNS as f64;
            stated[1] += found.damping_ratio().standard_error / RUNS as f64;
        }
        for (values, stated, truth) in
            [(&periods, stated[0], TAU / (1.417 * (1.0f64 - 0.14 * 0.14).sqrt())), (&dampings, stated[1], 0.14)]
        {
            let mean = values.iter().sum::<f64>() / RUNS as f64;
            let scatter = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (RUNS - 1) as f64).sqrt();
            println!("mean {mean:.4} of {truth:.4}, scatter {scatter:.5}, stated {stated:.5}");
            assert!((0.8..1.3).contains(&(stated / scatter)), "stated {stated} for a scatter of {scatter}");
            assert!((mean - truth).abs() < 4.0 * scatter / (RUNS as f64).sqrt() + 0.05 * scatter);
        }
    }

    #[test]
    fn lag_of_peaks_is_that_of_the_phases() {
        let (zeta, omega) = (0.1, 1.5);
        let (time, values) = record(zeta, omega, 3.0);
        let found = read(&time, &values).unwrap();
        let damped = omega * (1.0f64 - zeta * zeta).sqrt();
        let later = |lag_s: f64| -> Vec<f64> {
            time.iter()
                .map(|t| t - 1200.0)
                .map(|t| 3.0 * (-zeta * omega * t).exp() * (damped * (t - lag_s)).cos())
                .collect()
        };
        for lag_s in [0.4, -1.1, 0.0] {
            let lag = found.lag_s(&time, &values, &later(lag_s)).unwrap();
            assert!((lag - lag_s).abs() < 1e-6, "{lag} for {lag_s}");
        }
    }

    #[test]
    fn what_does_not_oscillate_is_not_read() {
        let time: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.05).collect();
        let noise = |seed| -> Vec<f64> {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            time.iter().map(|_| StandardNormal.sample(&mut rng)).collect()
        };
        let read_noise: Vec<u64> = (0..40).filter(|&seed| read(&time, &noise(seed)).is_ok()).collect();
        assert!(read_noise.is_empty(), "noise of the seeds {read_noise:?} was read");
        let noise = noise(0);
        let slow: Vec<f64> = time.iter().map(|t| (0.4 * t).sin()).collect();
        assert_eq!(read(&time, &slow).unwrap_err(), ReadError::LessThanACycle);
        assert!(matches!(read(&time[..5], &noise[..5]), Err(ReadError::TooFew { samples: 5, .. })));
        let mut broken = noise;
        broken[7] = f64::NAN;
        assert_eq!(read(&time, &broken).unwrap_err(), ReadError::NotNumbers);
        assert_eq!(read(&[0.0; 20], &[1.0; 20]).unwrap_err(), ReadError::NotNumbers);
    }
}
