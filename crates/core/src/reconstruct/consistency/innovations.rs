//! Consistency of a filter run: does the noise the settings state explain the innovations found?

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::prep::{WHITE_LEVEL, white_noise_probability};
use crate::reconstruct::data::Reconstruction;
use crate::reconstruct::model::layout::Measurement;
use crate::statistics::{NORMAL_95, autocorrelation};

/// Longest lag of the autocorrelation, samples.
pub const LAGS: usize = 40;
/// Probability on either side of a 95 % region.
const TAIL: f64 = 0.025;
/// Ratio of found to predicted deviation beyond which a setting is worth changing.
pub const WORTH_CHANGING: f64 = 1.15;
/// Correlation of neighbouring innovations beyond which something is left in them that no noise explains.
const CORRELATED: f64 = 0.3;
/// Mean innovation, in predicted deviations, from which an offset is worth looking for.
const OFFSET: f64 = 0.1;

/// Verdict on a whole run.
#[derive(Clone, Debug, PartialEq)]
pub struct Consistency {
    /// Mean of the normalised innovation squared divided by its degrees of freedom; 1 is ideal.
    pub nis_ratio: f64,
    /// Mean of the normalised innovation squared.
    pub nis_mean: f64,
    /// 95 % region of that mean for white innovations, `chi^2(sum of degrees) / samples`.
    pub nis_band: [f64; 2],
    /// The same region for the number of independent samples that the autocorrelation of the NIS leaves.
    pub nis_band_correlated: [f64; 2],
    /// Number of updates.
    pub updates: usize,
    /// One for every measurement that was taken.
    pub channels: Vec<ChannelConsistency>,
}

/// Verdict on the innovations of one measurement, in units of their predicted deviation.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelConsistency {
    /// Measurement.
    pub measurement: Measurement,
    /// Number of innovations K.
    pub samples: usize,
    /// Mean; consistent within `1.96 / sqrt(K)`.
    pub mean: f64,
    /// 95 % limit of the mean for white innovations.
    pub mean_limit: f64,
    /// Root mean square: the ratio of found to predicted deviation.
    pub deviation_ratio: f64,
    /// Autocorrelation at lags 1 to [`LAGS`] (fewer for short runs).
    pub autocorrelation: Vec<f64>,
    /// 95 % limit of the autocorrelation of a white sequence, `1.96 / sqrt(K)`.
    pub autocorrelation_limit: f64,
    /// Probability that white innovations are as correlated (Ljung and Box).
    pub whiteness: f64,
    /// Whether that probability is at least 5 %: one white sequence in twenty is not taken for white.
    pub is_white: bool,
}

impl ChannelConsistency {
    /// Whether the mean is further from zero than chance and of a size that matters.
    pub fn has_offset(&self) -> bool {
        self.mean.abs() > 3.0 * self.mean_limit && self.mean.abs() > OFFSET
    }

    /// Correlation of neighbouring innovations.
    pub fn lag_one(&self) -> f64 {
        self.autocorrelation.first().copied().unwrap_or(0.0)
    }

    /// Whether neighbouring innovations are so alike that their size alone says nothing about the noise.
    pub fn is_correlated(&self) -> bool {
        !self.is_white && self.lag_one().abs() > CORRELATED
    }

    /// Whether nothing is worth changing: no offset, not correlated, of the predicted size.
    pub fn is_consistent(&self) -> bool {
        let as_predicted = (1.0 / WORTH_CHANGING..=WORTH_CHANGING).contains(&self.deviation_ratio);
        !self.has_offset() && !self.is_correlated() && as_predicted
    }
}

/// Consistency of the innovations (Bar-Shalom, Li & Kirubarajan 2001, section 5.4), from `from_s` on so that the
/// convergence of the initial state can be left out. `None` without any update.
pub fn consistency(run: &Reconstruction, from_s: f64) -> Option<Consistency> {
    let first = run.update_time_s.partition_point(|time| *time < from_s);
    let updates: Vec<usize> = (first..run.nis.len()).filter(|&k| run.nis_degrees[k] > 0).collect();
    if updates.is_empty() {
        return None;
    }
    let count = updates.len() as f64;
    let degrees: f64 = updates.iter().map(|&k| f64::from(run.nis_degrees[k])).sum();
    let nis_mean = updates.iter().map(|&k| run.nis[k]).sum::<f64>() / count;
    let relative: Vec<f64> = updates.iter().map(|&k| run.nis[k] / f64::from(run.nis_degrees[k]) - 1.0).collect();
    let next = autocorrelation(&relative, 1).first().copied().unwrap_or(0.0).clamp(0.0, 0.999);
    let independent = (1.0 - next) / (1.0 + next);
    let channels = Measurement::ALL.into_iter().filter_map(|m| channel(run, m, first)).collect();
    Some(Consistency {
        nis_ratio: nis_mean * count / degrees,
        nis_mean,
        nis_band: band(degrees).map(|limit| limit / count),
        nis_band_correlated: band(degrees * independent).map(|limit| limit / (count * independent)),
        updates: updates.len(),
        channels,
    })
}

fn channel(run: &Reconstruction, measurement: Measurement, first: usize) -> Option<ChannelConsistency> {
    let m = measurement as usize;
    let pairs = run.innovations[m].iter().zip(&run.innovation_deviations[m]).skip(first);
    let normalised: Vec<f64> = pairs.map(|(value, deviation)| value / deviation).filter(|v| v.is_finite()).collect();
    if normalised.len() < 2 {
        return None;
    }
    let count = normalised.len() as f64;
    let mean = normalised.iter().sum::<f64>() / count;
    let deviation_ratio = (normalised.iter().map(|v| v * v).sum::<f64>() / count).sqrt();
    let limit = NORMAL_95 / count.sqrt();
    let autocorrelation = autocorrelation(&normalised, LAGS.min(normalised.len() / 2));
    let whiteness = white_noise_probability(&autocorrelation, normalised.len(), LAGS);
    Some(ChannelConsistency {
        measurement,
        samples: normalised.len(),
        mean,
        mean_limit: limit,
        deviation_ratio,
        autocorrelation,
        autocorrelation_limit: limit,
        whiteness,
        is_white: whiteness >= WHITE_LEVEL,
    })
}

/// 95 % region of the chi-square distribution.
fn band(degrees: f64) -> [f64; 2] {
    ChiSquared::new(degrees).map_or([f64::NAN; 2], |chi| [TAIL, 1.0 - TAIL].map(|part| chi.inverse_cdf(part)))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::{Measurement, Reconstruction, band, consistency};
    use crate::reconstruct::model::layout::{MEASUREMENTS, STATES};

    /// A run whose airspeed innovations are an autoregression of first order, all others absent.
    fn innovations(seed: u64, samples: usize, keep: f64) -> Reconstruction {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut value: f64 = StandardNormal.sample(&mut rng);
        let sequence = (0..samples).map(|_| {
            let draw: f64 = StandardNormal.sample(&mut rng);
            value = keep * value + (1.0 - keep * keep).sqrt() * draw;
            value
        });
        let time_s: std::sync::Arc<[f64]> = (0..samples).map(|k| 0.01 * k as f64).collect();
        let mut innovations: [Vec<f64>; MEASUREMENTS] = std::array::from_fn(|_| vec![f64::NAN; samples]);
        innovations[Measurement::Airspeed as usize] = sequence.collect();
        Reconstruction {
            states: std::array::from_fn(|_| Vec::new()),
            deviations: std::array::from_fn(|_| Vec::new().into()),
            update_time_s: time_s.clone(),
            innovations,
            innovation_deviations: std::array::from_fn(|_| vec![1.0; samples].into()),
            nis: vec![1.0; samples],
            nis_degrees: vec![1; samples],
            final_covariance: nalgebra::SMatrix::<f64, STATES, STATES>::identity(),
            log_likelihood: 0.0,
            air_data: None,
            smoothed: None,
            max_iterations_used: 0,
            outliers: Default::default(),
            warnings: Vec::new(),
            time_s,
        }
    }

    /// Share of sequences that do not count as white.
    fn refused(samples: usize, keep: f64, sequences: u64) -> f64 {
        let white = |seed| consistency(&innovations(seed, samples, keep), 0.0).unwrap().channels[0].is_white;
        (0..sequences).filter(|&seed| !white(seed)).count() as f64 / sequences as f64
    }

    #[test]
    fn one_white_sequence_in_twenty_is_refused_and_a_correlated_one_is_seen() {
        // 2,000 sequences at 5 %: a share of 3.5 to 6.5 % is three standard deviations either way.
        for samples in [50, 200, 1000, 3000] {
            let share = refused(samples, 0.0, 2000);
            println!("{samples} white samples: {:.2} % refused", 100.0 * share);
            assert!((0.035..0.065).contains(&share), "{samples}: {share}");
        }
        for (samples, keep, least) in [(200, 0.3, 0.6), (1000, 0.2, 0.9), (3000, 0.1, 0.8)] {
            let share = refused(samples, keep, 200);
            println!("{samples} samples correlated by {keep}: {:.0} % seen", 100.0 * share);
            assert!(share > least, "{samples} {keep}: {share}");
        }
    }

    /// Half of the last printed digit.
    const PRINTED: f64 = 5e-4;
    /// Next term of the cube-root approximation of Wilson & Hilferty (1931) at half a million degrees, relative.
    const CUBE_ROOT: f64 = 1e-6;

    #[test]
    fn chi_square_band_matches_tables_and_the_limit_of_many_degrees() {
        // NIST/SEMATECH e-Handbook, table 1.3.6.7.4
        for (degrees, expected) in [(1.0, [0.001, 5.024]), (12.0, [4.404, 23.337]), (100.0, [74.222, 129.561])] {
            for (found, expected) in band(degrees).into_iter().zip(expected) {
                assert!((found - expected).abs() <= PRINTED, "{degrees}: {found} {expected}");
            }
        }
        let degrees: f64 = 5e5;
        let spread = 2.0 / (9.0 * degrees);
        for (found, z) in band(degrees).into_iter().zip([-super::NORMAL_95, super::NORMAL_95]) {
            let expected = degrees * (1.0 - spread + z * spread.sqrt()).powi(3);
            assert!((found / expected - 1.0).abs() < CUBE_ROOT, "{found} {expected}");
        }
    }
}
