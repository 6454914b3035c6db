//! Frequency responses from averaged cross spectra, with coherence and random error.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix};

use super::FrequencyError;
use super::composite::{WindowQuality, composite_weights};
use super::record::{FrequencyRecord, check};
use super::transform::fourier_sums;

/// Cycles of a frequency a window must hold: half the main lobe of a Hann window is two bins wide.
const CYCLES: f64 = 2.0;
/// Inputs of which less than this part is not explained by the others are not told apart.
const TOLD_APART: f64 = 1e-4;
/// Averages beyond the number of inputs without which the unexplained power is not known.
const FREE: f64 = 0.5;
/// Relative standard deviation of the gain up to which a point is a value: three of them reach zero.
const VALUE: f64 = 1.0 / 3.0;
/// Part of a response up to which what the windows add in second order is small.
const RESOLVED: f64 = 0.1;

/// Frequencies and windows.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralSettings {
    /// Angular frequencies, rad/s, rising.
    pub omega_rad_s: Vec<f64>,
    /// Lengths of the windows, s: with several, each frequency is a composite of those that hold two cycles of it.
    pub windows_s: Vec<f64>,
    /// Part of a window that the next one overlaps, 0 to 0.9.
    pub overlap: f64,
    /// Whether a model is to be fitted, which needs the correlation of the errors between frequencies and the moments of the windows: it
    /// takes longer.
    pub for_fit: bool,
}

/// A response at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponsePoint {
    /// Angular frequency, rad/s.
    pub omega_rad_s: f64,
    /// Output over input, with the other inputs held; not finite where the inputs cannot be told apart.
    pub response: Complex<f64>,
    /// Partial coherence of input and output given the other inputs; the ordinary one of a single input.
    pub coherence: f64,
    /// Coherence of input and output regardless of the other inputs.
    pub ordinary_coherence: f64,
    /// Coherence of the output with all inputs together.
    pub multiple_coherence: f64,
    /// Effective number of independent averages `n` behind it.
    pub averages: f64,
    /// What the windows show is `H + m1 H' + m2 H''`, derivatives with respect to frequency: their main lobe smooths the response, weighted by
    /// the input's power about the frequency. Zero unless a fit is wanted.
    pub window_moments: [Complex<f64>; 2],
    /// Standard deviation of the gain relative to itself, and of the phase in rad; infinite where the coherence is no more than chance.
    pub relative_sd: f64,
    /// The same by noise alone, without what the windows lose of the response, which a fit accounts for; equal unless a fit is wanted.
    pub noise_sd: f64,
}

impl ResponsePoint {
    /// Gain, dB.
    pub fn gain_db(&self) -> f64 {
        20.0 * self.response.norm().log10()
    }

    /// Standard deviation of the gain, dB.
    pub fn gain_sd_db(&self) -> f64 {
        20.0 * std::f64::consts::LOG10_E * self.relative_sd
    }

    /// What the windows show of a response, its derivatives by central differences.
    pub fn through_windows(&self, response: impl Fn(f64) -> Complex<f64>) -> Complex<f64> {
        let [here, first, second] = self.window_terms(response);
        here + first + second
    }

    /// Whether the windows are long enough for a response: what they add to it in second order is a small part of it. Beside a resonance
    /// narrower than their main lobe it is not, and [`Self::through_windows`] says nothing.
    pub fn resolves(&self, response: impl Fn(f64) -> Complex<f64>) -> bool {
        let [here, _, second] = self.window_terms(response);
        second.norm() <= RESOLVED * here.norm()
    }

    /// A response, and what the windows add to it in first and second order.
    fn window_terms(&self, response: impl Fn(f64) -> Complex<f64>) -> [Complex<f64>; 3] {
        let ([first, second], none) = (self.window_moments, Complex::new(0.0, 0.0));
        let here = response(self.omega_rad_s);
        if first == none && second == none {
            return [here, none, none];
        }
        let step = 0.01 * self.omega_rad_s;
        let (below, above) = (response(self.omega_rad_s - step), response(self.omega_rad_s + step));
        [here, first * (above - below) / (2.0 * step), second * (above - here * 2.0 + below) / (step * step)]
    }

    /// Whether gain and phase are a value: three standard deviations of the gain do not reach zero.
    pub fn is_value(&self) -> bool {
        self.relative_sd <= VALUE && self.response.norm() > 0.0
    }
}

/// Response of the output to one input.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyResponse {
    /// Number of the input, from 0.
    pub input: usize,
    /// Points in rising frequency.
    pub points: Vec<ResponsePoint>,
    /// Correlation of the relative errors of points, complex, where a fit is wanted.
    pub error_correlation: Option<DMatrix<Complex<f64>>>,
    /// Standard deviation over that of as many independent windows side by side, `c` of `c sqrt((1 - g) / (2 n_d g))` with `n_d` the length of
    /// all records over that of the window; one for each window length, for a steady random input.
    pub overlap_constants: Vec<f64>,
}

impl FrequencyResponse {
    /// Phases, rad, without jumps between neighbouring points that are values; those of others as they are found.
    pub fn phases_rad(&self) -> Vec<f64> {
        let mut last: Option<f64> = None;
        let mut phases = Vec::with_capacity(self.points.len());
        for point in &self.points {
            let phase = point.response.arg();
            let phase = phase - TAU * last.map_or(0.0, |last| ((phase - last) / TAU).round());
            if point.is_value() {
                last = Some(phase);
            }
            phases.push(phase);
        }
        phases
    }
}

/// A window of one record with the transforms of its signals under a taper of unit power.
struct Segment {
    record: usize,
    start: usize,
    /// Transforms of inputs and output at all frequencies.
    transforms: Vec<Vec<Complex<f64>>>,
    /// Transforms of the inputs under the first and the second derivative of the taper, where the moments are wanted.
    slopes: Vec<[Vec<Complex<f64>>; 2]>,
}

/// All segments of one window length.
struct Windowing {
    length_s: f64,
    segments: Vec<Segment>,
    /// Effective averages for a steady random input, and their relation to the plain count.
    averages: f64,
    overlap_constant: f64,
}

/// Frequency responses of the output to every input, each with the others held.
///
/// Records are cut into Hann windows less their mean, of every length and overlapping; the cross-spectral matrix `S_ij = mean conj(X_i) X_j`
/// of inputs and output averages over all windows of all records, and those of several window lengths are merged by their errors
/// frequency by frequency. `H = Sxx^-1 Sxy`, multiple coherence `1 - Snn / Syy`, partial coherence
/// `|H_i|^2 R_i / (|H_i|^2 R_i + Snn)` with `R_i = 1 / (Sxx^-1)_ii` the power of an input that the others do not explain, `Snn` what no input
/// explains (Bendat and Piersol, chapters 7 and 9).
///
/// Random error: `H` is linear in the output, so that noise `n(t)` moves it by `sum g(t) n(t)` with weights `g` known from inputs, windows
/// and overlaps. With noise of density `Snn` about the frequency, `var H_i = Snn sum |g|^2`; the effective number of averages is
/// `n = 1 / (R_i sum |g|^2)`, and `sd = sqrt((1 - gamma^2) / (2 n gamma^2))` for gain and phase alike with the partial coherence less its bias.
/// This holds for any overlap, any mixture of window lengths and inputs whose power changes along the record, such as sweeps.
///
/// Output through a window `w` is `Y_w = H X_w + j H' X_w' - H'' X_w'' / 2 ..` of the inputs through the window and its derivatives, so that
/// what is estimated is `H + m1 H' + m2 H''` with moments known from the inputs ([`ResponsePoint::window_moments`]).
///
/// # Errors
/// Records that do not go together, settings out of range, and windows that fit no record or frequency.
pub fn responses(
    records: &[FrequencyRecord],
    settings: &SpectralSettings,
) -> Result<Vec<FrequencyResponse>, FrequencyError> {
    let inputs = check(records)?;
    let omega = resolved(records, settings)?;
    let windowings: Vec<Windowing> = settings
        .windows_s
        .iter()
        .map(|&length_s| windowing(records, length_s, settings, &omega))
        .filter(|windowing| !windowing.segments.is_empty())
        .collect();
    let merged: Vec<Merged> = (0..omega.len()).map(|m| merge(&windowings, inputs, omega[m], m)).collect();
    let response = |input: usize| {
        let errors = noise_weights(records, &windowings, &merged, &omega, input, settings.for_fit);
        let point = |(m, merged): (usize, &Merged)| merged.point(input, omega[m], errors.power[m]);
        FrequencyResponse {
            input,
            points: merged.iter().enumerate().map(point).collect(),
            error_correlation: errors.correlation,
            overlap_constants: windowings.iter().map(|windowing| windowing.overlap_constant).collect(),
        }
    };
    Ok((0..inputs).map(response).collect())
}

/// Frequencies that some window resolves.
fn resolved(records: &[FrequencyRecord], settings: &SpectralSettings) -> Result<Vec<f64>, FrequencyError> {
    let fault =
        |setting, value, allowed: &str| Err(FrequencyError::Setting { setting, value, allowed: allowed.to_owned() });
    if !(0.0..=0.9).contains(&settings.overlap) {
        return fault("overlap", settings.overlap, "from 0 to 0.9");
    }
    if let Some(&window) = settings.windows_s.iter().find(|window| !(window.is_finite() && **window > 0.0)) {
        return fault("window length", window, "above 0 s");
    }
    let (Some(&low), Some(&high)) = (settings.omega_rad_s.first(), settings.omega_rad_s.last()) else {
        return fault("frequencies", 0.0, "give at least one");
    };
    let is_rising = settings.omega_rad_s.windows(2).all(|pair| pair[0] < pair[1]);
    if !(low > 0.0 && high.is_finite() && is_rising) {
        return fault("lowest frequency", low, "above 0 rad/s, and the others rising");
    }
    let nyquist = records.iter().map(|record| 0.5 * TAU / record.step_s).fold(f64::INFINITY, f64::min);
    if high >= nyquist {
        let allowed = format!("below half the sampling frequency, {nyquist:.4} rad/s");
        return Err(FrequencyError::Setting { setting: "highest frequency", value: high, allowed });
    }
    let longest_s = records.iter().map(FrequencyRecord::length_s).fold(0.0, f64::max);
    // A window as long as the record may come out a rounding longer.
    let usable = settings.windows_s.iter().copied().filter(|window| *window <= longest_s * (1.0 + 1e-9));
    let longest_window_s = usable.fold(0.0, f64::max);
    if longest_window_s <= 0.0 {
        let window_s = settings.windows_s.iter().copied().fold(f64::INFINITY, f64::min);
        return Err(FrequencyError::WindowTooLong { longest_s, window_s });
    }
    let lowest = CYCLES * TAU / longest_window_s;
    let omega: Vec<f64> =
        settings.omega_rad_s.iter().copied().filter(|omega| *omega >= lowest * (1.0 - 1e-9)).collect();
    if omega.is_empty() { Err(FrequencyError::BandBelowWindows { low, high, lowest }) } else { Ok(omega) }
}

/// A Hann taper of unit power.
fn taper(samples: usize) -> Vec<f64> {
    // The mean of the fourth power of a sine is 3/8.
    let scale = (0.375 * samples as f64).sqrt().recip();
    (0..samples).map(|k| scale * (0.5 * taper_angle(k, samples)).sin().powi(2)).collect()
}

/// Turn of a taper from its beginning to its `k`-th sample.
fn taper_angle(k: usize, samples: usize) -> f64 {
    TAU * (k as f64 + 0.5) / samples as f64
}

/// First and second derivative of a taper, 1/s and 1/s2.
fn taper_slopes(samples: usize, step_s: f64) -> [Vec<f64>; 2] {
    let scale = (0.375 * samples as f64).sqrt().recip();
    let rate = TAU / (samples as f64 * step_s);
    let first = (0..samples).map(|k| 0.5 * scale * rate * taper_angle(k, samples).sin());
    let second = (0..samples).map(|k| 0.5 * scale * rate * rate * taper_angle(k, samples).cos());
    [first.collect(), second.collect()]
}

fn window_samples(length_s: f64, step_s: f64) -> usize {
    ((length_s / step_s).round() as usize).max(2)
}

fn windowing(records: &[FrequencyRecord], length_s: f64, settings: &SpectralSettings, omega: &[f64]) -> Windowing {
    let (mut segments, mut pairs, mut total_s) = (Vec::new(), 0.0, 0.0);
    for (index, record) in records.iter().enumerate() {
        let samples = window_samples(length_s, record.step_s);
        if samples > record.output.len() {
            continue;
        }
        total_s += record.length_s();
        let (taper, slopes) = (taper(samples), taper_slopes(samples, record.step_s));
        let hop = ((samples as f64 * (1.0 - settings.overlap)).round() as usize).max(1);
        let starts: Vec<usize> = (0..=record.output.len() - samples).step_by(hop).collect();
        for &start in &starts {
            let under = |taper: &[f64], signal: usize| {
                let values = &record.signal(signal)[start..start + samples];
                let mean = values.iter().sum::<f64>() / samples as f64;
                let tapered: Vec<f64> = values.iter().zip(taper).map(|(value, w)| (value - mean) * w).collect();
                fourier_sums(&tapered, record.step_s, omega)
            };
            let inputs = if settings.for_fit { record.inputs.len() } else { 0 };
            segments.push(Segment {
                record: index,
                start,
                transforms: (0..=record.inputs.len()).map(|signal| under(&taper, signal)).collect(),
                slopes: (0..inputs).map(|input| [0, 1].map(|order| under(&slopes[order], input))).collect(),
            });
        }
        for apart in 0..starts.len() {
            let shared: f64 = taper.iter().zip(taper.iter().skip(apart * hop)).map(|(a, b)| a * b).sum();
            if shared <= 0.0 {
                break;
            }
            let both_ways = if apart == 0 { 1.0 } else { 2.0 };
            pairs += both_ways * (starts.len() - apart) as f64 * shared * shared;
        }
    }
    let averages = (segments.len() as f64).powi(2) / pairs.max(f64::MIN_POSITIVE);
    let overlap_constant = (total_s / length_s / averages).sqrt();
    Windowing { length_s, segments, averages, overlap_constant }
}

/// Merged cross spectra at one frequency and what follows from them.
struct Merged {
    /// Weight of each window length over its number of segments.
    weights: Vec<f64>,
    /// Inverse of the spectral matrix of the inputs; `None` where they cannot be told apart.
    inverse: Option<DMatrix<Complex<f64>>>,
    response: Vec<Complex<f64>>,
    ordinary: Vec<f64>,
    /// [`ResponsePoint::window_moments`] of every input.
    moments: Vec<[Complex<f64>; 2]>,
    /// Power of the output that no input explains.
    unexplained: f64,
    /// What the inputs under the derivative of the taper do not explain either, where it is known.
    noise: Option<f64>,
    output: f64,
}

/// Signals of a segment at one frequency: inputs, `beside` those under the derivative of the taper, and the output.
fn signals(segment: &Segment, m: usize, beside: bool) -> Vec<Complex<f64>> {
    let (inputs, output) = segment.transforms.split_at(segment.transforms.len() - 1);
    let slopes = segment.slopes.iter().filter(|_| beside).map(|slopes| &slopes[0]);
    inputs.iter().chain(slopes).chain(output).map(|transform| transform[m]).collect()
}

/// Cross-spectral matrix of the signals of one window length.
fn spectral_matrix(windowing: &Windowing, m: usize, beside: bool) -> DMatrix<Complex<f64>> {
    let mut sum = DMatrix::from_element(0, 0, Complex::new(0.0, 0.0));
    for segment in &windowing.segments {
        let signals = signals(segment, m, beside);
        if sum.is_empty() {
            sum = DMatrix::from_element(signals.len(), signals.len(), Complex::new(0.0, 0.0));
        }
        for (i, one) in signals.iter().enumerate() {
            for (j, other) in signals.iter().enumerate() {
                sum[(i, j)] += one.conj() * other;
            }
        }
    }
    sum / Complex::new(windowing.segments.len() as f64, 0.0)
}

/// Sum of matrices by their shares.
fn weigh(matrices: &[DMatrix<Complex<f64>>], shares: &[f64]) -> DMatrix<Complex<f64>> {
    let size = matrices.first().map_or(0, DMatrix::nrows);
    let zero = DMatrix::from_element(size, size, Complex::new(0.0, 0.0));
    matrices.iter().zip(shares).fold(zero, |sum, (matrix, share)| sum + matrix * Complex::new(*share, 0.0))
}

/// Inverse of the inputs' part of a spectral matrix, where each input has power the others do not explain.
fn invert_inputs(matrix: &DMatrix<Complex<f64>>, inputs: usize) -> Option<DMatrix<Complex<f64>>> {
    let scale: Vec<f64> = (0..inputs).map(|i| matrix[(i, i)].re.sqrt()).collect();
    if scale.iter().any(|scale| *scale <= 0.0) {
        return None;
    }
    let normal = DMatrix::from_fn(inputs, inputs, |i, j| matrix[(i, j)] / (scale[i] * scale[j]));
    let inverse = normal.try_inverse()?;
    let is_apart = |i: usize| inverse[(i, i)].re > 0.0 && inverse[(i, i)].re < 1.0 / TOLD_APART;
    (0..inputs).all(is_apart).then(|| DMatrix::from_fn(inputs, inputs, |i, j| inverse[(i, j)] / (scale[i] * scale[j])))
}

/// Response and unexplained output power.
fn solve(matrix: &DMatrix<Complex<f64>>, inverse: &DMatrix<Complex<f64>>, inputs: usize) -> (Vec<Complex<f64>>, f64) {
    let cross = matrix.view((0, inputs), (inputs, 1));
    let response = inverse * cross;
    let explained: f64 = (0..inputs).map(|i| (response[(i, 0)].conj() * cross[(i, 0)]).re).sum();
    let output = matrix[(inputs, inputs)].re;
    (response.iter().copied().collect(), (output - explained).clamp(0.0, output))
}

fn merge(windowings: &[Windowing], inputs: usize, omega: f64, m: usize) -> Merged {
    let matrices: Vec<_> = windowings.iter().map(|windowing| spectral_matrix(windowing, m, false)).collect();
    let both = windowings.iter().zip(&matrices);
    let qualities: Vec<_> = both.map(|(windowing, matrix)| assess_window(windowing, matrix, inputs, omega)).collect();
    let shares = composite_weights(&qualities);
    let matrix = weigh(&matrices, &shares);
    let output = matrix[(inputs, inputs)].re;
    let ordinary = |i: usize| matrix[(i, inputs)].norm_sqr() / (matrix[(i, i)].re * output);
    let inverse = invert_inputs(&matrix, inputs);
    let missing = vec![Complex::new(f64::NAN, f64::NAN); inputs];
    let (response, unexplained) =
        inverse.as_ref().map_or((missing, f64::NAN), |inverse| solve(&matrix, inverse, inputs));
    let is_fitted =
        windowings.iter().flat_map(|windowing| &windowing.segments).any(|segment| !segment.slopes.is_empty());
    let noise = is_fitted.then(|| {
        let matrices: Vec<_> = windowings.iter().map(|windowing| spectral_matrix(windowing, m, true)).collect();
        let matrix = weigh(&matrices, &shares);
        invert_inputs(&matrix, 2 * inputs).map(|inverse| solve(&matrix, &inverse, 2 * inputs).1)
    });
    let per_segment = shares.iter().zip(windowings).map(|(share, windowing)| share / windowing.segments.len() as f64);
    let weights: Vec<f64> = per_segment.collect();
    let moments = window_moments(windowings, &weights, inverse.as_ref(), inputs, m);
    Merged {
        weights,
        inverse,
        response,
        ordinary: (0..inputs).map(ordinary).collect(),
        moments,
        unexplained,
        noise: noise.flatten(),
        output,
    }
}

fn assess_window(
    windowing: &Windowing,
    matrix: &DMatrix<Complex<f64>>,
    inputs: usize,
    omega: f64,
) -> Option<WindowQuality> {
    if omega * windowing.length_s < CYCLES * TAU * (1.0 - 1e-9) {
        return None;
    }
    let output = matrix[(inputs, inputs)].re;
    let unexplained = invert_inputs(matrix, inputs).map_or(output, |inverse| solve(matrix, &inverse, inputs).1);
    let coherence = if output > 0.0 { 1.0 - unexplained / output } else { 0.0 };
    Some(WindowQuality { coherence, averages: windowing.averages })
}

/// Moments of the windows at one frequency, `j Sxx^-1 mean conj(X) X_w'` and `-Sxx^-1 mean conj(X) X_w'' / 2` of each input by itself.
fn window_moments(
    windowings: &[Windowing],
    weights: &[f64],
    inverse: Option<&DMatrix<Complex<f64>>>,
    inputs: usize,
    m: usize,
) -> Vec<[Complex<f64>; 2]> {
    let mut moments = vec![[Complex::new(0.0, 0.0); 2]; inputs];
    let Some(inverse) = inverse else { return moments };
    for (windowing, weight) in windowings.iter().zip(weights) {
        for segment in &windowing.segments {
            for (input, slopes) in segment.slopes.iter().enumerate() {
                let row = (0..inputs).map(|l| inverse[(input, l)] * segment.transforms[l][m].conj());
                let row = row.sum::<Complex<f64>>() * *weight;
                moments[input][0] += row * slopes[0][m] * Complex::new(0.0, 1.0);
                moments[input][1] += row * slopes[1][m] * -0.5;
            }
        }
    }
    moments
}

impl Merged {
    /// The response to `input`, whose error has the power `power` for noise of unit density.
    fn point(&self, input: usize, omega_rad_s: f64, power: f64) -> ResponsePoint {
        let response = self.response[input];
        let rest = self.inverse.as_ref().map_or(f64::NAN, |inverse| inverse[(input, input)].re.recip());
        let averages = (rest * power).recip();
        let explained = response.norm_sqr() * rest;
        let inputs = self.response.len();
        // What the fit of the inputs took from the unexplained power; as few averages as inputs explain all of it.
        let deviation = |unexplained: f64, explained_by: usize| {
            let free = averages - explained_by as f64;
            let noise = if free > FREE { unexplained * averages / free * power } else { f64::INFINITY };
            let certain = response.norm_sqr() - noise;
            if certain > 0.0 { (0.5 * noise / certain).sqrt() } else { f64::INFINITY }
        };
        let relative_sd = deviation(self.unexplained, inputs);
        let noise_sd = self.noise.map_or(relative_sd, |noise| deviation(noise, 2 * inputs).min(relative_sd));
        ResponsePoint {
            omega_rad_s,
            response,
            coherence: explained / (explained + self.unexplained),
            ordinary_coherence: self.ordinary[input],
            multiple_coherence: 1.0 - self.unexplained / self.output,
            averages,
            window_moments: self.moments[input],
            relative_sd,
            noise_sd,
        }
    }
}

/// Power of each point's error for noise of unit density, and correlation of the relative errors.
struct NoiseErrors {
    power: Vec<f64>,
    correlation: Option<DMatrix<Complex<f64>>>,
}

fn noise_weights(
    records: &[FrequencyRecord],
    windowings: &[Windowing],
    merged: &[Merged],
    omega: &[f64],
    input: usize,
    for_fit: bool,
) -> NoiseErrors {
    let count = omega.len();
    let mut power = vec![0.0; count];
    let mut covariance = DMatrix::from_element(count, count, Complex::new(0.0, 0.0));
    for (index, record) in records.iter().enumerate() {
        let tapers: Vec<Vec<f64>> =
            windowings.iter().map(|windowing| taper(window_samples(windowing.length_s, record.step_s))).collect();
        let weights = |m: usize| {
            let mut weights = vec![Complex::new(0.0, 0.0); record.output.len()];
            let Some(inverse) = &merged[m].inverse else { return weights };
            for ((windowing, taper), share) in windowings.iter().zip(&tapers).zip(&merged[m].weights) {
                for segment in windowing.segments.iter().filter(|segment| segment.record == index && *share > 0.0) {
                    let inputs = (0..inverse.ncols()).map(|l| inverse[(input, l)] * segment.transforms[l][m].conj());
                    let mut phasor = inputs.sum::<Complex<f64>>() * *share;
                    let turn = Complex::from_polar(1.0, -omega[m] * record.step_s);
                    for (weight, window) in weights[segment.start..].iter_mut().zip(taper) {
                        *weight += phasor * *window;
                        phasor *= turn;
                    }
                }
            }
            weights
        };
        if !for_fit {
            for (m, power) in power.iter_mut().enumerate() {
                *power += weights(m).iter().map(Complex::norm_sqr).sum::<f64>();
            }
            continue;
        }
        let all: Vec<Vec<Complex<f64>>> = (0..count).map(weights).collect();
        for k in 0..count {
            for l in 0..=k {
                let sum: Complex<f64> = all[k].iter().zip(&all[l]).map(|(a, b)| a * b.conj()).sum();
                covariance[(k, l)] += sum;
            }
            power[k] = covariance[(k, k)].re;
        }
    }
    let correlation = for_fit.then(|| relative_correlation(&covariance, merged, input));
    NoiseErrors { power, correlation }
}

/// Correlation of `error / H` from the lower triangle of the covariance of the errors.
fn relative_correlation(covariance: &DMatrix<Complex<f64>>, merged: &[Merged], input: usize) -> DMatrix<Complex<f64>> {
    let unit = |m: usize| Complex::from_polar(1.0, -merged[m].response[input].arg());
    let below = |k: usize, l: usize| {
        let scale = (covariance[(k, k)].re * covariance[(l, l)].re).sqrt();
        covariance[(k, l)] * unit(k) * unit(l).conj() / scale
    };
    let count = merged.len();
    DMatrix::from_fn(count, count, |k, l| if k >= l { below(k, l) } else { below(l, k).conj() })
}
