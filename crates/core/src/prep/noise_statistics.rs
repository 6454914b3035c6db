//! Noise of channels over steady parts, and what it proposes for Q and R (thesis section 4.4.3).

use nalgebra::{DMatrix, DVector};

use super::steady::MAX_LAG_ONE;
use super::{PrepError, check, whiteness_lags, whiteness_probability};
use crate::airframe::instruments::StatedNoise;
use crate::series::{Series, TimeRange};

/// Noise of one channel over its steady parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseStatistics {
    /// Standard deviation about the trend of each window, SI of the channel.
    pub std: f64,
    /// Standard deviation from the differences of successive samples, `sqrt(mean(d^2) / 2)`: below `std` where the noise is slower
    /// than the samples.
    pub difference_std: f64,
    /// Finest step between samples in the windows, of the whole recordings where there is none in them, zero for none at all: where `std`
    /// is not well above it, it is the recorder's resolution.
    pub resolution: f64,
    /// Samples.
    pub samples: usize,
    /// Windows that held enough samples.
    pub windows: usize,
    /// Correlation of successive residuals: near zero for white noise.
    pub lag_one: f64,
    /// Probability that white noise looks less white (Ljung and Box, Biometrika 65, 1978, over up to 20 lags, what the trends take off allowed for).
    pub whiteness: f64,
}

/// Lags of the test of whiteness.
const LAGS: usize = 20;

/// Noise of a channel over marked steady parts of one or more recordings, each window with its own polynomial trend taken off.
///
/// `s^2 = sum r^2 / sum(n - degree - 1)` over the residuals of all windows; samples that are not finite are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseSums {
    degree: usize,
    squares: f64,
    free: usize,
    samples: usize,
    windows: usize,
    differences: f64,
    pairs: usize,
    resolution: f64,
    /// Finest step of the whole recordings: of channels that do not move by one in any window.
    finest: f64,
    products: [f64; LAGS + 1],
    /// Pairs of residuals at each lag, and what the trends took off their products.
    all_pairs: [usize; LAGS + 1],
    lost: [f64; LAGS + 1],
    /// Samples of the fullest window, used or not.
    most: usize,
}

/// Samples beyond the trend's own unknowns that a window needs.
const BEYOND: usize = 7;

impl NoiseSums {
    /// Nothing yet, trends of `degree`.
    pub fn new(degree: usize) -> Self {
        let products = [0.0; LAGS + 1];
        Self {
            degree,
            squares: 0.0,
            free: 0,
            samples: 0,
            windows: 0,
            differences: 0.0,
            pairs: 0,
            resolution: f64::INFINITY,
            finest: f64::INFINITY,
            products,
            all_pairs: [0; LAGS + 1],
            lost: [0.0; LAGS + 1],
            most: 0,
        }
    }

    /// Adds the windows of a recording.
    ///
    /// # Errors
    /// Lengths that differ, time that does not increase.
    pub fn add(&mut self, series: &Series, windows: &[TimeRange]) -> Result<(), PrepError> {
        check(&series.time_s, &series.values, "noise statistics", 1)?;
        for window in windows {
            let Series { time_s: time, values } = series.within(*window).finite();
            self.most = self.most.max(values.len());
            if values.len() > self.degree + BEYOND {
                self.add_window(&time, &values);
            }
        }
        if self.resolution.is_infinite() {
            self.finest = finest_step(&series.values).min(self.finest);
        }
        Ok(())
    }

    fn add_window(&mut self, time: &[f64], values: &[f64]) {
        let residual = detrended(time, values, self.degree);
        self.windows += 1;
        self.samples += residual.len();
        self.free += residual.len() - self.degree - 1;
        self.squares += residual.iter().map(|r| r * r).sum::<f64>();
        for (lag, product) in self.products.iter_mut().enumerate() {
            *product += residual.iter().zip(residual.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>();
            let apart = residual.len().saturating_sub(lag);
            self.all_pairs[lag] += apart;
            // The trend takes one part in n of the sum of squares for each of its unknowns, and as much off every product.
            self.lost[lag] += (self.degree + 1) as f64 * apart as f64 / residual.len() as f64;
        }
        for pair in residual.windows(2) {
            self.differences += (pair[1] - pair[0]).powi(2);
            self.pairs += 1;
        }
        self.resolution = finest_step(values).min(self.resolution);
    }

    /// What all windows show together.
    ///
    /// # Errors
    /// [`PrepError::TooFewSamples`] when no window holds `degree + 8` samples.
    pub fn statistics(&self) -> Result<NoiseStatistics, PrepError> {
        if self.windows == 0 {
            let (needed, found) = (self.degree + 1 + BEYOND, self.most);
            return Err(PrepError::TooFewSamples { method: "noise statistics in one window", needed, found });
        }
        let lags = whiteness_lags(self.samples, LAGS);
        let products = &self.products;
        let correlation = |lag: usize| if products[0] > 0.0 { products[lag] / products[0] } else { 0.0 };
        let untrended = |lag: usize| correlation(lag) + self.lost[lag] / self.samples as f64;
        let whiteness =
            whiteness_probability(self.samples, (1..=lags).map(|lag| (untrended(lag), self.all_pairs[lag])));
        Ok(NoiseStatistics {
            std: (self.squares / self.free as f64).sqrt(),
            difference_std: (0.5 * self.differences / self.pairs as f64).sqrt(),
            resolution: [self.resolution, self.finest].into_iter().find(|step| step.is_finite()).unwrap_or(0.0),
            samples: self.samples,
            windows: self.windows,
            lag_one: correlation(1),
            whiteness,
        })
    }
}

/// Noise of one channel over marked steady parts, see [`NoiseSums`].
///
/// # Errors
/// As [`NoiseSums::add`] and [`NoiseSums::statistics`].
pub fn noise_statistics(series: &Series, windows: &[TimeRange], degree: usize) -> Result<NoiseStatistics, PrepError> {
    let mut sums = NoiseSums::new(degree);
    sums.add(series, windows)?;
    sums.statistics()
}

/// Finest step between successive samples, without bound where there is none.
pub(crate) fn finest_step(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    steps.filter(|&step| step > 0.0).fold(f64::INFINITY, f64::min)
}

/// What a polynomial of `degree` in time leaves of the values.
fn detrended(time: &[f64], values: &[f64], degree: usize) -> Vec<f64> {
    let n = time.len();
    let (start, length) = (time[0], time[n - 1] - time[0]);
    // Powers of a time from -1 to 1 keep the columns apart.
    let x = DMatrix::from_fn(n, degree + 1, |k, power| (2.0 * (time[k] - start) / length - 1.0).powi(power as i32));
    let y = DVector::from_column_slice(values);
    let q = x.qr().q();
    let fitted = &q * q.tr_mul(&y);
    (y - fitted).as_slice().to_vec()
}

/// Where a proposed standard deviation comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum NoiseOrigin {
    /// Steady parts of the recordings.
    Windows(NoiseStatistics),
    /// The recorder's resolution over the root of twelve, since the windows show less.
    Resolution(NoiseStatistics),
    /// Stated for the instruments, from the source given.
    Stated(String),
    /// Second differences of the whole recording, since no steady part shows it.
    Differences,
    /// Gusts along the path, which the airspeed shows and no flow vane.
    Gusts,
}

/// A standard deviation proposed for one channel. Its square stands on the diagonal of Q (inertial samples) or R (measurements).
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseChoice {
    /// Standard deviation, SI of the role.
    pub proposed: f64,
    /// Where it comes from.
    pub origin: NoiseOrigin,
}

/// The standard deviation proposed for a channel: what is stated for its instrument to count always, otherwise what the windows show,
/// never less than the recorder's resolution over the root of twelve, otherwise what is stated. Nothing else is made up.
///
/// # Errors
/// One line with the reason where the windows tell nothing and nothing is stated: no samples, or what a trend leaves of them is not
/// white, so that it is motion, or filtered.
pub fn noise_proposal(
    measured: Result<&NoiseStatistics, String>,
    stated: Option<&StatedNoise>,
) -> Result<NoiseChoice, String> {
    let by =
        |stated: &StatedNoise| NoiseChoice { proposed: stated.std, origin: NoiseOrigin::Stated(stated.source.clone()) };
    if let Some(stated) = stated.filter(|stated| stated.always) {
        return Ok(by(stated));
    }
    let measured = match measured {
        Err(reason) => Err(reason),
        Ok(found) if found.lag_one > MAX_LAG_ONE => Err(format!(
            "the steady parts contain motion or filtered noise: lag-one correlation {:.2} (limit {MAX_LAG_ONE})",
            found.lag_one
        )),
        Ok(found) if found.std == 0.0 && found.resolution == 0.0 => Err("its samples are all the same".to_owned()),
        Ok(found) if found.std >= found.resolution / 12f64.sqrt() => {
            Ok(NoiseChoice { proposed: found.std, origin: NoiseOrigin::Windows(*found) })
        }
        Ok(found) => {
            let proposed = found.resolution / 12f64.sqrt();
            Ok(NoiseChoice { proposed, origin: NoiseOrigin::Resolution(*found) })
        }
    };
    measured.or_else(|reason| stated.map(by).ok_or(reason))
}
