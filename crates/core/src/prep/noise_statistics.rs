//! Noise of channels over steady windows, and what it proposes for Q and R (thesis section 4.4.3, Tables 4.15-4.16).

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::{PrepError, check, whiteness_lags, whiteness_probability};
use crate::quantity::Role;
use crate::series::{Series, Window};

/// Noise of one channel over its steady windows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseStatistics {
    /// Standard deviation about the trend of each window, SI of the channel.
    pub std: f64,
    /// Standard deviation from the differences of successive samples, `sqrt(mean(d^2) / 2)`: below `std` where the noise is slower
    /// than the samples.
    pub difference_std: f64,
    /// Finest step between samples, zero for none: where `std` is not well above it, it is the recorder's resolution.
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

/// Noise of a channel over marked steady windows, each with its own polynomial trend of `degree` taken off.
///
/// `s^2 = sum r^2 / sum(n - degree - 1)` over the residuals of all windows; samples that are not finite are left out.
///
/// # Errors
/// Lengths that differ, time that does not increase, [`PrepError::TooFewSamples`] when no window holds `degree + 8` samples.
pub fn noise_statistics(series: &Series, windows: &[Window], degree: usize) -> Result<NoiseStatistics, PrepError> {
    check(&series.time_s, &series.values, "noise statistics", 1)?;
    /// Samples beyond the trend's own unknowns that a window needs.
    const BEYOND: usize = 7;
    let needed = degree + 1 + BEYOND;
    let mut most = 0;
    let (mut squares, mut free, mut samples, mut used) = (0.0, 0, 0, 0);
    let (mut differences, mut pairs, mut resolution) = (0.0, 0usize, f64::INFINITY);
    let mut products = [0.0; LAGS + 1];
    let (mut all_pairs, mut lost) = ([0usize; LAGS + 1], [0.0; LAGS + 1]);
    for window in windows {
        let inside = window.indices(&series.time_s);
        let (time, values): (Vec<f64>, Vec<f64>) = series.time_s[inside.clone()]
            .iter()
            .zip(&series.values[inside])
            .filter(|(_, value)| value.is_finite())
            .unzip();
        most = most.max(values.len());
        if values.len() < needed {
            continue;
        }
        let residual = detrended(&time, &values, degree);
        used += 1;
        samples += residual.len();
        free += residual.len() - degree - 1;
        squares += residual.iter().map(|r| r * r).sum::<f64>();
        for (lag, product) in products.iter_mut().enumerate() {
            *product += residual.iter().zip(residual.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>();
            let apart = residual.len().saturating_sub(lag);
            all_pairs[lag] += apart;
            // The trend takes one part in n of the sum of squares for each of its unknowns, and as much off every product.
            lost[lag] += (degree + 1) as f64 * apart as f64 / residual.len() as f64;
        }
        for pair in residual.windows(2) {
            differences += (pair[1] - pair[0]).powi(2);
            pairs += 1;
        }
        let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        resolution = steps.filter(|&step| step > 0.0).fold(resolution, f64::min);
    }
    if used == 0 {
        return Err(PrepError::TooFewSamples { method: "noise statistics in one window", needed, found: most });
    }
    let lags = whiteness_lags(samples, LAGS);
    let correlation = |lag: usize| if products[0] > 0.0 { products[lag] / products[0] } else { 0.0 };
    let untrended = |lag: usize| correlation(lag) + lost[lag] / samples as f64;
    let whiteness = whiteness_probability(samples, (1..=lags).map(|lag| (untrended(lag), all_pairs[lag])));
    Ok(NoiseStatistics {
        std: (squares / free as f64).sqrt(),
        difference_std: (0.5 * differences / pairs as f64).sqrt(),
        resolution: if resolution.is_finite() { resolution } else { 0.0 },
        samples,
        windows: used,
        lag_one: correlation(1),
        whiteness,
    })
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoiseOrigin {
    /// Steady windows of this recording.
    Windows(NoiseStatistics),
    /// The recorder's resolution over the root of twelve, since the windows show less.
    Resolution(NoiseStatistics),
    /// Thesis Table 4.15 (raw input; yaw rate 6.15e-4 rad/s, its printed 6.15e-2 being a misprint) or 4.16.
    Published,
    /// Thesis section 4.4.3: flow angles at a low rate deserve less trust than their scatter suggests.
    Judged,
}

/// A standard deviation proposed for one channel, and what was put in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseChoice {
    /// Proposed standard deviation, SI of the role.
    pub proposed: f64,
    /// Where it comes from.
    pub origin: NoiseOrigin,
    /// Standard deviation chosen instead, with the reason.
    pub instead: Option<(f64, String)>,
}

impl NoiseChoice {
    /// The standard deviation to use: what was chosen instead, or the proposal. Its square stands on the diagonal of Q (inertial
    /// samples) or R (measurements).
    pub fn std(&self) -> f64 {
        self.instead.as_ref().map_or(self.proposed, |(std, _)| *std)
    }
}

/// Published standard deviations, SI: thesis Tables 4.15 (raw) and 4.16.
const PUBLISHED: [(Role, f64); 16] = [
    (Role::SpecificForceX, 3.07e-2),
    (Role::SpecificForceY, 5.61e-3),
    (Role::SpecificForceZ, 1.46e-2),
    (Role::RollRate, 6.22e-4),
    (Role::PitchRate, 1.20e-3),
    (Role::YawRate, 6.15e-4),
    (Role::PositionNorth, 1.63e-1),
    (Role::PositionEast, 8.74e-2),
    (Role::PositionDown, 8.65e-2),
    (Role::VelocityNorth, 1.86e-2),
    (Role::VelocityEast, 1.70e-2),
    (Role::VelocityDown, 5.82e-3),
    (Role::BankAngle, 6.25e-4),
    (Role::PitchAngle, 3.52e-4),
    (Role::HeadingAngle, 2.32e-4),
    (Role::TrueAirspeed, 5.14e-2),
];
/// Standard deviations the thesis gave the flow angles, rad.
const JUDGED: [(Role, f64); 2] = [(Role::AngleOfAttack, 1.0e-2), (Role::Sideslip, 5.0e-3)];

/// Standard deviations proposed for every input and measurement of the flight-path reconstruction, by role: what the windows
/// show, never less than the recorder's resolution over the root of twelve; published ones where nothing was measured; the
/// judged ones for the flow angles.
pub fn noise_proposals(measured: &BTreeMap<Role, NoiseStatistics>) -> BTreeMap<Role, NoiseChoice> {
    let choice = |proposed: f64, origin: NoiseOrigin| NoiseChoice { proposed, origin, instead: None };
    let published = PUBLISHED.iter().map(|&(role, std)| {
        let proposal = match measured.get(&role) {
            Some(statistics) if statistics.std >= statistics.resolution / 12f64.sqrt() => {
                choice(statistics.std, NoiseOrigin::Windows(*statistics))
            }
            Some(statistics) => choice(statistics.resolution / 12f64.sqrt(), NoiseOrigin::Resolution(*statistics)),
            None => choice(std, NoiseOrigin::Published),
        };
        (role, proposal)
    });
    let judged = JUDGED.iter().map(|&(role, std)| (role, choice(std, NoiseOrigin::Judged)));
    published.chain(judged).collect()
}
