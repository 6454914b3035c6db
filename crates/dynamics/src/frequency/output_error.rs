//! Output error in the frequency domain: models fitted to the transforms of the records themselves.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector};

use super::FrequencyError;
use super::fit::{Bounds, EquivalentSystem, FitSettings, Information, Outcome, start};
use super::levenberg::{Evaluation, minimise};
use super::record::{FrequencyRecord, check};
use super::start::Sample;
use super::transform::ChirpZ;

/// Frequencies of a fit to records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutputErrorBand {
    /// Lowest frequency, rad/s.
    pub low_rad_s: f64,
    /// Highest frequency, rad/s.
    pub high_rad_s: f64,
    /// Step of the frequencies, rad/s, for records that begin and end at rest. Without it they are the harmonics of each record, at
    /// which what the motion has at its ends, free response and trim among it, is a polynomial in s over the denominator that is fitted
    /// along.
    pub step_rad_s: Option<f64>,
}

/// Transforms of one record, over the square root of its length.
struct Transformed {
    omega: Vec<f64>,
    input: Vec<Complex<f64>>,
    output: Vec<Complex<f64>>,
    /// Correlation of the transforms of white noise at frequencies so many steps apart.
    correlation: Vec<Complex<f64>>,
    /// Independent frequencies.
    independent: f64,
}

/// Fits a model to records of one input by maximum likelihood, for noise on the output that is white over the band: least
/// `sum |Y - H U|^2` over the finite Fourier transforms of all records (Klein and Morelli, 7.3). At the harmonics of a record, `Y = H U + T / D` with
/// a real polynomial `T` of the record's own, one order below the denominator, for its beginning and end (Pintelon and Schoukens, 2.6).
///
/// Covariance `A^-1 B A^-1`, `A = Re J*J`, `B = Re J* S R S J / 2`, with the power `S^2` of the residuals about each frequency, so that coloured
/// noise is counted where it is, and the correlation `R` of frequencies closer than the inverse of the record.
///
/// # Errors
/// Records of several inputs, a band that holds too few frequencies, and parameters the records do not determine.
pub fn fit_records(
    records: &[FrequencyRecord],
    band: &OutputErrorBand,
    settings: &FitSettings,
) -> Result<EquivalentSystem, FrequencyError> {
    if check(records)? != 1 {
        let what = "several inputs: fit the conditioned response instead".to_owned();
        return Err(FrequencyError::Record { record: 1, what });
    }
    let transformed: Vec<Transformed> =
        records.iter().map(|record| transform(record, band)).collect::<Result<_, _>>()?;
    let rows: usize = transformed.iter().map(|record| record.omega.len()).sum();
    let beginning = start(&group(&transformed, band), settings)?;
    let order = settings.form.orders().1;
    let ends = if band.step_rad_s.is_none() { order * transformed.len() } else { 0 };
    let own = beginning.parameters().len();
    // A power of the frequency of its own scale keeps the polynomials of the ends comparable.
    let unit = (band.low_rad_s * band.high_rad_s).sqrt();
    let evaluate = |parameters: &[f64]| {
        let model = beginning.with_parameters(&parameters[..own]);
        let mut residuals = DVector::from_element(rows, Complex::new(0.0, 0.0));
        let mut slopes = DMatrix::from_element(rows, own + ends, Complex::new(0.0, 0.0));
        let mut row = 0;
        for (index, record) in transformed.iter().enumerate() {
            for ((&omega, input), output) in record.omega.iter().zip(&record.input).zip(&record.output) {
                let forced = model.at(omega) * input;
                let mut value = forced;
                for (column, slope) in model.log_derivatives(omega).into_iter().enumerate() {
                    slopes[(row, column)] = slope * forced;
                }
                if ends > 0 {
                    let under = model.denominator_at(omega).inv() * unit.powi(order as i32);
                    let mut free = Complex::new(0.0, 0.0);
                    for k in 0..order {
                        let column = own + order * index + k;
                        let power = Complex::new(0.0, omega / unit).powu(k as u32) * under;
                        slopes[(row, column)] = power;
                        free += power * parameters[column];
                    }
                    let first = 1 + model.numerator.iter().map(|section| section.coefficients().len()).sum::<usize>();
                    for (column, slope) in
                        model.log_derivatives(omega).into_iter().enumerate().take(own - 1).skip(first)
                    {
                        slopes[(row, column)] += slope * free;
                    }
                    value += free;
                }
                residuals[row] = output - value;
                row += 1;
            }
        }
        Evaluation { residuals, slopes }
    };
    let bounds = Bounds::new(&beginning, settings, ends);
    let mut first = beginning.parameters();
    first.resize(own + ends, 0.0);
    let (parameters, found) = minimise(&first, &bounds.lower, &bounds.free, evaluate);
    let Information { free, slopes, inverse } = Information::new(&found.slopes, &bounds, &parameters, settings)?;
    let independent: f64 = transformed.iter().map(|record| record.independent).sum();
    if 2.0 * independent <= free.len() as f64 {
        return Err(FrequencyError::TooFewPoints { points: independent.floor() as usize, parameters: free.len() });
    }
    let freedom = 1.0 - 0.5 * free.len() as f64 / independent;
    let middle = middle(&transformed, &found.residuals, &slopes) / freedom;
    let covariance = &inverse * middle * &inverse;
    let is_delay_at_zero = bounds.is_delay_at_zero(&parameters);
    let outcome = Outcome { covariance, free, independent, error_ratio: None, frequencies: rows, is_delay_at_zero };
    Ok(EquivalentSystem::new(settings, beginning.with_parameters(&parameters[..own]), outcome))
}

fn transform(record: &FrequencyRecord, band: &OutputErrorBand) -> Result<Transformed, FrequencyError> {
    let samples = record.output.len();
    let length_s = (samples - 1) as f64 * record.step_s;
    let harmonic = TAU / length_s;
    let nyquist = 0.5 * TAU / record.step_s;
    if !(band.low_rad_s > 0.0 && band.low_rad_s < band.high_rad_s && band.high_rad_s < nyquist) {
        let allowed = format!("the band lies above 0 rad/s and below half the sampling frequency, {nyquist:.4} rad/s");
        return Err(FrequencyError::Setting { setting: "highest frequency", value: band.high_rad_s, allowed });
    }
    let (first, spacing) = match band.step_rad_s {
        Some(step) if !(step.is_finite() && step > 0.0) => {
            let allowed = "above 0 rad/s".to_owned();
            return Err(FrequencyError::Setting { setting: "step of the frequencies", value: step, allowed });
        }
        Some(step) => (band.low_rad_s, step),
        None => ((band.low_rad_s / harmonic - 1e-9).ceil().max(1.0) * harmonic, harmonic),
    };
    let count = ((band.high_rad_s - first) / spacing + 1e-9).floor().max(-1.0) + 1.0;
    let plan = ChirpZ::new(samples, record.step_s, first, spacing, count as usize);
    let scale = length_s.sqrt().recip();
    let scaled = |values: &[f64]| plan.integrals(values).into_iter().map(|value| value * scale).collect();
    let correlation = |apart: usize| correlate_lines(spacing * record.step_s, apart, samples);
    let harmonics = band.step_rad_s.is_none();
    Ok(Transformed {
        omega: plan.omega_rad_s().to_vec(),
        input: scaled(&record.inputs[0]),
        output: scaled(&record.output),
        correlation: if harmonics { Vec::new() } else { (0..count as usize).map(correlation).collect() },
        independent: (count * spacing / harmonic).min(count),
    })
}

/// Correlation of the noise of two lines so many spacings apart, each a turn of `turn` per sample.
fn correlate_lines(turn: f64, apart: usize, samples: usize) -> Complex<f64> {
    let angle = turn * apart as f64;
    if apart == 0 {
        return Complex::new(1.0, 0.0);
    }
    let sum = (0.5 * angle * samples as f64).sin() / (samples as f64 * (0.5 * angle).sin());
    Complex::from_polar(sum.abs(), -0.5 * angle * (samples - 1) as f64) * sum.signum()
}

/// Responses over bands of frequency, by the cross spectra in them, to start from.
fn group(transformed: &[Transformed], band: &OutputErrorBand) -> Vec<Sample> {
    const BANDS: usize = 40;
    let ratio = (band.high_rad_s / band.low_rad_s).ln();
    let mut sums = vec![(Complex::new(0.0, 0.0), 0.0, 0.0); BANDS];
    for record in transformed {
        for ((omega, input), output) in record.omega.iter().zip(&record.input).zip(&record.output) {
            let place = (BANDS as f64 * (omega / band.low_rad_s).ln() / ratio).clamp(0.0, (BANDS - 1) as f64);
            let (cross, power, at) = &mut sums[place as usize];
            *cross += input.conj() * output;
            *power += input.norm_sqr();
            *at += omega * input.norm_sqr();
        }
    }
    let filled = sums.into_iter().filter(|(cross, power, _)| *power > 0.0 && cross.norm() > 0.0);
    filled.map(sample).collect()
}

fn sample((cross, power, at): (Complex<f64>, f64, f64)) -> Sample {
    Sample { omega: at / power, response: cross / power, weight: cross.norm() / power.sqrt() }
}

/// `Re J* S R S J / 2` with the local power of the residuals.
fn middle(
    transformed: &[Transformed],
    residuals: &DVector<Complex<f64>>,
    slopes: &DMatrix<Complex<f64>>,
) -> DMatrix<f64> {
    /// Independent frequencies to each side over which the power of the residuals is averaged.
    const REACH: f64 = 8.0;
    let mut sum = DMatrix::zeros(slopes.ncols(), slopes.ncols());
    let mut first = 0;
    for record in transformed {
        let count = record.omega.len();
        let reach = (REACH * count as f64 / record.independent.max(f64::MIN_POSITIVE)).ceil() as usize;
        let power: Vec<f64> = residuals.rows(first, count).iter().map(Complex::norm_sqr).collect();
        let local = |k: usize| {
            let near = &power[k.saturating_sub(reach)..(k + reach + 1).min(count)];
            near.iter().sum::<f64>() / near.len() as f64
        };
        let mut own = slopes.rows(first, count).into_owned();
        for (k, mut row) in own.row_iter_mut().enumerate() {
            row *= Complex::new(local(k).sqrt(), 0.0);
        }
        let spread = if record.correlation.is_empty() {
            own.clone()
        } else {
            let correlation = |k: usize, l: usize| match k >= l {
                true => record.correlation[k - l],
                false => record.correlation[l - k].conj(),
            };
            DMatrix::from_fn(count, count, correlation) * &own
        };
        sum += (own.adjoint() * spread).map(|value| 0.5 * value.re);
        first += count;
    }
    sum
}
