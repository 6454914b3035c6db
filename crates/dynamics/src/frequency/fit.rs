//! Low-order equivalent systems fitted to frequency responses.

use doublet_core::statistics::NORMAL_95;
use nalgebra::{Complex, DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::FrequencyError;
use super::form::Form;
use super::levenberg::{Evaluation, minimise};
use super::response::{FrequencyResponse, ResponsePoint};
use super::start::{Sample, starting_values};
use super::transfer::{Delay, Section, TransferFunction};

/// Probability that an interval holds its value.
const CONFIDENCE: f64 = 0.95;

/// Parameters that are times of delay and not negative.
const DELAYS: [&str; 2] = ["tau", "phase_delay"];
/// Names of positive quantities beside those that begin with `omega`.
const POSITIVE: [&str; 3] = ["T_R", "T_theta2", "bandwidth"];
/// Draws of a model after which a negative delay is set to zero.
const MOST_DRAWS: usize = 100;

/// What is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitSettings {
    /// Form of the model.
    pub form: Form,
    /// Whether its delay is searched for.
    pub delay: Delay,
}

/// A parameter, or something that follows from the parameters, with its 95 % interval.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedParameter {
    /// Name: `K`, `inv_Ttheta2`, `zeta`, `omega`, `tau`, ...
    pub name: String,
    /// Estimate, SI and rad.
    pub value: f64,
    /// Standard error; zero of what is known.
    pub standard_error: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl FittedParameter {
    /// Whether it is a frequency or a time constant of a stable mode.
    fn is_positive(&self) -> bool {
        let is_named = self.name.starts_with("omega") || POSITIVE.contains(&self.name.as_str());
        is_named && self.value > 0.0
    }

    /// Whether its standard error is below its value, where it is a frequency or a time constant.
    pub fn is_determined(&self) -> bool {
        !self.is_positive() || self.standard_error < self.value
    }
}

/// A fitted model.
#[derive(Clone, Debug)]
pub struct EquivalentSystem {
    /// Its form.
    pub form: Form,
    /// The model.
    pub model: TransferFunction,
    /// Parameters in the order gain, numerator, denominator, delay.
    pub parameters: Vec<FittedParameter>,
    /// Correlation of the parameters; those known correlate with nothing.
    pub correlation: DMatrix<f64>,
    /// Frequencies fitted.
    pub frequencies: usize,
    /// Mean square residual over the random error the coherence tells: far above one the model is too simple; `None` of a fit to records.
    /// The standard errors are scaled by it.
    pub error_ratio: Option<f64>,
    /// The delay came to rest at its bound of zero: its interval is one-sided.
    pub is_delay_at_zero: bool,
    /// Covariance of gain, coefficients of the factors and delay.
    covariance: DMatrix<f64>,
    /// Standard errors in half an interval.
    quantile: f64,
}

/// Differences between a model and the points of a response that are values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mismatch {
    /// Root mean square, dB.
    pub rms_db: f64,
    /// Root mean square, rad.
    pub rms_phase_rad: f64,
    /// Largest, dB, and its frequency, rad/s.
    pub worst_db: (f64, f64),
    /// Largest, rad, and its frequency, rad/s.
    pub worst_phase_rad: (f64, f64),
    /// `20/n sum W (dB^2 + 0.01745 deg^2)` with `W = (1.58 (1 - exp(-gamma^2)))^2` (Tischler and Remple, chapter 11): up to 100 is a good fit,
    /// up to 50 one hardly told from the response.
    pub cost: f64,
    /// Values that were omitted, as the windows do not resolve the model there ([`ResponsePoint::resolves`]).
    pub unresolved: usize,
}

impl Mismatch {
    /// Of a model from a response; `None` without a point that is a value. Values beside a resonance of the model that is narrower than the
    /// windows are omitted, unless less than half would remain.
    pub fn compare(model: &TransferFunction, response: &FrequencyResponse) -> Option<Self> {
        let values: Vec<&ResponsePoint> = response.points.iter().filter(|point| point.is_value()).collect();
        let resolved: Vec<&ResponsePoint> =
            values.iter().copied().filter(|point| point.resolves(|omega| model.at(omega))).collect();
        let compared = if 2 * resolved.len() >= values.len() { &resolved } else { &values };
        let mut found = Self { unresolved: values.len() - compared.len(), ..Self::default() };
        let mut count = 0.0;
        for point in compared {
            let ratio = point.response / point.through_windows(|omega| model.at(omega));
            let (db, phase) = (20.0 * ratio.norm().log10(), ratio.arg());
            let weight = (1.58 * (1.0 - (-point.coherence).exp())).powi(2);
            found.cost += 20.0 * weight * (db * db + 0.01745 * phase.to_degrees().powi(2));
            found.rms_db += db * db;
            found.rms_phase_rad += phase * phase;
            if db.abs() >= found.worst_db.0.abs() {
                found.worst_db = (db, point.omega_rad_s);
            }
            if phase.abs() >= found.worst_phase_rad.0.abs() {
                found.worst_phase_rad = (phase, point.omega_rad_s);
            }
            count += 1.0;
        }
        found.cost /= count;
        found.rms_db = (found.rms_db / count).sqrt();
        found.rms_phase_rad = (found.rms_phase_rad / count).sqrt();
        (count > 0.0).then_some(found)
    }
}

/// Fits a model to the points of a response that are values, by the logarithm of gain and phase together weighted with the inverse of
/// their variance, hence by coherence: `sum |ln(H / model)|^2 / (2 sd^2)`, where the model is seen through the same windows
/// ([`ResponsePoint::window_moments`]). The covariance knows the correlation of the errors between
/// neighbouring frequencies, `A^-1 B A^-1` with `A = Re J*J` and `B = Re J* R J / 2`, which needs a response estimated with
/// [`super::SpectralSettings::for_fit`]. Coherence says how the frequencies compare; the level of their errors is that of the
/// residuals, which hold what the model lacks, while windows lose coherence that is no random error.
///
/// # Errors
/// Too few points, or parameters the points do not determine.
pub fn fit_response(response: &FrequencyResponse, settings: &FitSettings) -> Result<EquivalentSystem, FrequencyError> {
    let kept: Vec<usize> = (0..response.points.len()).filter(|&k| response.points[k].is_value()).collect();
    let points: Vec<ResponsePoint> = kept.iter().map(|&k| response.points[k]).collect();
    let samples: Vec<Sample> = points.iter().map(sample).collect();
    let start = start(&samples, settings)?;
    let bounds = Bounds::new(&start, settings, 0);
    let (parameters, found) = minimise(&start.parameters(), &bounds.lower, &bounds.free, |parameters: &[f64]| {
        evaluate(&start, &points, &samples, parameters)
    });
    let Information { free, slopes, inverse } = Information::new(&found.slopes, &bounds, &parameters, settings)?;
    let correlation = response.error_correlation.as_ref();
    let correlation = correlation.map(|matrix| matrix.select_rows(&kept).select_columns(&kept));
    let spread = correlation.as_ref().map_or_else(|| slopes.clone(), |matrix| matrix * &slopes);
    let middle = (slopes.adjoint() * spread).map(|value| 0.5 * value.re);
    let expected = samples.len() as f64 - (&inverse * &middle).trace();
    let error_ratio = found.cost() / expected.max(f64::MIN_POSITIVE);
    let covariance = &inverse * middle * &inverse * error_ratio;
    let shared = correlation.map_or(samples.len() as f64, |matrix| matrix.iter().map(Complex::norm_sqr).sum());
    let independent = (samples.len() as f64).powi(2) / shared;
    let is_delay_at_zero = bounds.is_delay_at_zero(&parameters);
    let (error_ratio, frequencies) = (Some(error_ratio), samples.len());
    let outcome = Outcome { covariance, free, independent, error_ratio, frequencies, is_delay_at_zero };
    Ok(EquivalentSystem::new(settings, start.with_parameters(&parameters), outcome))
}

fn sample(point: &ResponsePoint) -> Sample {
    Sample {
        omega: point.omega_rad_s,
        response: point.response,
        weight: (std::f64::consts::SQRT_2 * point.noise_sd).recip(),
    }
}

fn evaluate(start: &TransferFunction, points: &[ResponsePoint], samples: &[Sample], parameters: &[f64]) -> Evaluation {
    let model = start.with_parameters(parameters);
    let mut residuals = DVector::from_element(points.len(), Complex::new(0.0, 0.0));
    let mut slopes = DMatrix::from_element(points.len(), parameters.len(), Complex::new(0.0, 0.0));
    for (row, (point, sample)) in points.iter().zip(samples).enumerate() {
        let seen = point.through_windows(|omega| model.at(omega));
        let ratio = sample.response / seen;
        residuals[row] = Complex::new(ratio.norm().ln(), ratio.arg()) * sample.weight;
        for column in 0..parameters.len() {
            let slope = point.through_windows(|omega| model.at(omega) * model.log_derivatives(omega)[column]);
            slopes[(row, column)] = slope / seen * sample.weight;
        }
    }
    Evaluation { residuals, slopes }
}

/// Starting values for samples that are enough.
pub(super) fn start(samples: &[Sample], settings: &FitSettings) -> Result<TransferFunction, FrequencyError> {
    let orders = settings.form.orders();
    let parameters = orders.0 + orders.1 + 1 + usize::from(settings.delay == Delay::Free);
    if samples.len() < parameters {
        return Err(FrequencyError::TooFewPoints { points: samples.len(), parameters });
    }
    let undetermined = || FrequencyError::Undetermined { form: settings.form.to_string() };
    starting_values(samples, orders, settings.delay).ok_or_else(undetermined)
}

/// Inverse of `Re J*J`, scaled for its condition.
pub(super) fn invert(slopes: &DMatrix<Complex<f64>>, settings: &FitSettings) -> Result<DMatrix<f64>, FrequencyError> {
    /// Reciprocal condition of the scaled information below which parameters are dependent.
    const DEPENDENT: f64 = 1e-12;
    let undetermined = || FrequencyError::Undetermined { form: settings.form.to_string() };
    let information = (slopes.adjoint() * slopes).map(|value| value.re);
    let scale: Vec<f64> = information.diagonal().iter().map(|value| value.sqrt()).collect();
    if scale.iter().any(|scale| !(scale.is_finite() && *scale > 0.0)) {
        return Err(undetermined());
    }
    let size = scale.len();
    let normal = DMatrix::from_fn(size, size, |i, j| information[(i, j)] / (scale[i] * scale[j]));
    if doublet_core::decompose::symmetric(normal.clone()).is_none_or(|eigen| eigen.eigenvalues.min() < DEPENDENT) {
        return Err(undetermined());
    }
    let inverse = normal.try_inverse().ok_or_else(undetermined)?;
    Ok(DMatrix::from_fn(size, size, |i, j| inverse[(i, j)] / (scale[i] * scale[j])))
}

/// What a search may do with each parameter.
pub(super) struct Bounds {
    pub lower: Vec<f64>,
    pub free: Vec<bool>,
    delay: usize,
}

impl Bounds {
    /// Of a model's parameters with `beside` others behind them.
    pub fn new(model: &TransferFunction, settings: &FitSettings, beside: usize) -> Self {
        let count = model.parameters().len();
        let (mut lower, mut free) = (vec![f64::NEG_INFINITY; count + beside], vec![true; count + beside]);
        lower[count - 1] = 0.0;
        free[count - 1] = settings.delay == Delay::Free;
        Self { lower, free, delay: count - 1 }
    }

    /// Whether the delay was searched for and came to rest at zero.
    pub fn is_delay_at_zero(&self, parameters: &[f64]) -> bool {
        self.free[self.delay] && parameters[self.delay] <= self.lower[self.delay]
    }

    /// Parameters that are searched for, with the delay or without it.
    fn searched(&self, with_delay: bool) -> Vec<usize> {
        (0..self.free.len()).filter(|&i| self.free[i] && (with_delay || i != self.delay)).collect()
    }
}

/// Information of the data on the parameters searched for.
pub(super) struct Information {
    /// Their places.
    pub free: Vec<usize>,
    /// Slopes of the residuals over them.
    pub slopes: DMatrix<Complex<f64>>,
    pub inverse: DMatrix<f64>,
}

impl Information {
    /// Of all that is searched for; a delay at its bound that cannot be separated from the others is left out.
    ///
    /// # Errors
    /// Parameters the data do not determine.
    pub fn new(
        slopes: &DMatrix<Complex<f64>>,
        bounds: &Bounds,
        parameters: &[f64],
        settings: &FitSettings,
    ) -> Result<Self, FrequencyError> {
        let of = |free: Vec<usize>| {
            let slopes = slopes.select_columns(&free);
            invert(&slopes, settings).map(|inverse| Self { free, slopes, inverse })
        };
        match of(bounds.searched(true)) {
            Err(_) if bounds.is_delay_at_zero(parameters) => of(bounds.searched(false)),
            found => found,
        }
    }
}

/// What a search leaves to be told.
pub(super) struct Outcome {
    /// Covariance of the parameters in `free`.
    pub covariance: DMatrix<f64>,
    pub free: Vec<usize>,
    /// Independent complex residuals.
    pub independent: f64,
    pub error_ratio: Option<f64>,
    pub frequencies: usize,
    pub is_delay_at_zero: bool,
}

impl EquivalentSystem {
    pub(super) fn new(settings: &FitSettings, model: TransferFunction, outcome: Outcome) -> Self {
        let count = model.parameters().len();
        let mut covariance = DMatrix::zeros(count, count);
        for (i, &row) in outcome.free.iter().enumerate().filter(|(_, row)| **row < count) {
            for (j, &column) in outcome.free.iter().enumerate().filter(|(_, column)| **column < count) {
                covariance[(row, column)] = outcome.covariance[(i, j)];
            }
        }
        let freedom = (2.0 * outcome.independent - outcome.free.len() as f64).max(1.0);
        let student = StudentsT::new(0.0, 1.0, freedom);
        let quantile = student.map_or(NORMAL_95, |student| student.inverse_cdf(0.5 * (1.0 + CONFIDENCE)));
        let mut system = Self {
            form: settings.form,
            model,
            parameters: Vec::new(),
            correlation: DMatrix::zeros(0, 0),
            frequencies: outcome.frequencies,
            error_ratio: outcome.error_ratio,
            is_delay_at_zero: outcome.is_delay_at_zero,
            covariance,
            quantile,
        };
        let form = settings.form;
        let reported = reported(form, &system.model);
        let slopes =
            system.slopes(|model| Some(self::reported(form, model).into_iter().map(|(_, value)| value).collect()));
        let slopes = slopes.unwrap_or_else(|| DMatrix::zeros(reported.len(), count));
        let covariance = &slopes * &system.covariance * slopes.transpose();
        let error = |i: usize| covariance[(i, i)].max(0.0).sqrt();
        system.correlation =
            DMatrix::from_fn(reported.len(), reported.len(), |i, j| match (i == j, error(i) * error(j)) {
                (true, _) => 1.0,
                (false, scale) if scale > 0.0 => covariance[(i, j)] / scale,
                (false, _) => 0.0,
            });
        let named = reported.into_iter().enumerate();
        system.parameters = named.map(|(i, (name, value))| system.interval(&name, value, error(i))).collect();
        system
    }

    /// The interval of a parameter: delays are not negative; frequencies and time constants are positive, and their intervals those of
    /// their logarithms. What the data do not determine has none: a delay at its bound, a positive quantity with an error above its value.
    fn interval(&self, name: &str, value: f64, standard_error: f64) -> FittedParameter {
        let is_delay = DELAYS.contains(&name);
        let is_open = is_delay && self.is_delay_at_zero && standard_error == 0.0;
        let standard_error = if is_open { f64::NAN } else { standard_error };
        let half = self.quantile * standard_error;
        let parameter = FittedParameter { name: name.to_owned(), value, standard_error, low: f64::NAN, high: f64::NAN };
        if parameter.is_positive() {
            let factor = if parameter.is_determined() { (half / value).exp() } else { f64::NAN };
            return FittedParameter { low: value / factor, high: value * factor, ..parameter };
        }
        let low = value - half;
        let low = if is_delay && low < 0.0 { 0.0 } else { low };
        FittedParameter { low, high: value + half, ..parameter }
    }

    /// The parameter called `name`.
    pub fn parameter(&self, name: &str) -> Option<&FittedParameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// Whatever follows from the model, with its standard error by the delta method; `None` where it does not exist at the estimate or
    /// beside it.
    pub fn propagate(&self, name: &str, value: impl Fn(&TransferFunction) -> Option<f64>) -> Option<FittedParameter> {
        let slopes = self.slopes(|model| value(model).map(|value| vec![value]))?;
        let variance = (&slopes * &self.covariance * slopes.transpose())[(0, 0)];
        Some(self.interval(name, value(&self.model)?, variance.max(0.0).sqrt()))
    }

    /// `count` models whose gain, coefficients and delay are drawn from the normal distribution of the estimate, of which the part with a
    /// negative delay is left out; the same for the same seed. About a delay at its bound of zero that part is one half.
    pub fn samples(&self, count: usize, seed: u64) -> Vec<TransferFunction> {
        let parameters = DVector::from_vec(self.model.parameters());
        let eigen = self.covariance.clone().symmetric_eigen();
        let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
        let root = &eigen.eigenvectors * DMatrix::from_diagonal(&roots);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let delay = parameters.len() - 1;
        let mut model = || {
            let mut drawn = parameters.clone();
            for _ in 0..MOST_DRAWS {
                let normal = DVector::from_fn(parameters.len(), |_, _| StandardNormal.sample(&mut random));
                drawn = &parameters + &root * normal;
                if drawn[delay] >= 0.0 {
                    break;
                }
            }
            drawn[delay] = drawn[delay].max(0.0);
            self.model.with_parameters(drawn.as_slice())
        };
        (0..count).map(|_| model()).collect()
    }

    /// Derivatives of values of the model with respect to gain, coefficients and delay, by central differences over a hundredth of their
    /// standard errors.
    fn slopes(&self, values: impl Fn(&TransferFunction) -> Option<Vec<f64>>) -> Option<DMatrix<f64>> {
        let parameters = self.model.parameters();
        let here = values(&self.model)?;
        let mut slopes = DMatrix::zeros(here.len(), parameters.len());
        for (column, value) in parameters.iter().enumerate() {
            let deviation = self.covariance[(column, column)].max(0.0).sqrt();
            if deviation == 0.0 {
                continue;
            }
            let step = (0.01 * deviation).min(1e-3 * value.abs().max(1e-6));
            let moved = |step: f64| {
                let mut parameters = parameters.clone();
                parameters[column] += step;
                values(&self.model.with_parameters(&parameters))
            };
            for (row, (above, below)) in moved(step)?.iter().zip(moved(-step)?).enumerate() {
                slopes[(row, column)] = (above - below) / (2.0 * step);
            }
        }
        Some(slopes)
    }
}

/// Parameters as they are reported: frequency and damping of second-order factors with a positive last coefficient.
fn reported(form: Form, model: &TransferFunction) -> Vec<(String, f64)> {
    let mut reported = vec![("K".to_owned(), model.gain)];
    for (is_numerator, sections) in [(true, &model.numerator), (false, &model.denominator)] {
        let (mut first, mut second) = (0, 0);
        for section in sections {
            match section {
                Section::First(c0) => {
                    first += 1;
                    reported.push((form.first_order_name(is_numerator, first), *c0));
                }
                Section::Second { c1, c0 } => {
                    second += 1;
                    let suffix = form.second_order_suffix(is_numerator, second);
                    let omega = c0.sqrt();
                    if *c0 > 0.0 {
                        reported.push((format!("zeta{suffix}"), c1 / (2.0 * omega)));
                        reported.push((format!("omega{suffix}"), omega));
                    } else {
                        reported.push((format!("c1{suffix}"), *c1));
                        reported.push((format!("c0{suffix}"), *c0));
                    }
                }
            }
        }
    }
    reported.push(("tau".to_owned(), model.delay_s));
    reported
}
