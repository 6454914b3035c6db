//! What the noise of a measurement should be: by the innovations of a manoeuvre and by steady flight, and what each does to the NIS.

use doublet_core::prep::NoiseOrigin;
use doublet_core::reconstruct::Measurement;
use doublet_core::reconstruct::consistency::{ChannelConsistency, WORTH_CHANGING};
use doublet_core::statistics::median;

use super::noise::{FlightNoise, NoiseRow};
use super::path::WindowPath;
use crate::notation::significant;
use crate::session::NoiseChannel;

/// Factor between two estimates of a deviation up to which they agree.
const AGREE: f64 = 1.5;
/// Correlation of successive steady samples from which they contain more than noise.
const SLOW: f64 = 0.3;

/// An estimate of the noise of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseEstimate {
    /// Standard deviation, SI.
    pub std: f64,
    /// NIS of the measurement with it over its expectation; 1 is ideal.
    pub nis: f64,
}

/// What follows from both estimates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseStep {
    /// The value in use is right.
    Keep,
    /// Set the value of the innovations; steady flight agrees, or shows nothing.
    Set,
    /// Both estimates differ: the innovations count in the manoeuvre.
    Differ,
    /// The innovations have an offset or are correlated: their size is not that of the noise.
    NotNoise,
}

/// Advice on the noise of one measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseAdvice {
    pub measurement: Measurement,
    /// Value in use.
    pub used: NoiseEstimate,
    /// By the innovations of the manoeuvre; none where they are not noise, or where the uncertain path alone explains them.
    pub innovations: Option<NoiseEstimate>,
    /// By steady flight, the resolution of the recorder or the instruments file; none without a proposal.
    pub steady: Option<NoiseEstimate>,
    /// What follows.
    pub step: NoiseStep,
    /// Why the estimates differ, or why the innovations are not noise; empty where neither is so.
    pub reason: String,
    /// What to do instead of setting this noise; empty where nothing else is to be done.
    pub action: &'static str,
}

impl NoiseAdvice {
    /// What to do, and why, in words; `show` writes a deviation in SI with its unit.
    pub fn text(&self, show: &dyn Fn(f64) -> String) -> String {
        let nis = |estimate: NoiseEstimate| significant(estimate.nis, 2);
        let with_nis = |estimate: NoiseEstimate| format!("{} (NIS ratio {})", show(estimate.std), nis(estimate));
        let because = if self.reason.is_empty() { String::new() } else { format!(": {}", self.reason) };
        match (self.step, self.innovations, self.steady) {
            (NoiseStep::Differ, Some(one), Some(other)) => {
                let step = match self.recommended() {
                    Some(set) => format!("Set {}", show(set.std)),
                    None => format!("Keep {}", show(self.used.std)),
                };
                format!("Innovations give {}, steady flight {}{because}. {step}.", with_nis(one), with_nis(other))
            }
            (NoiseStep::Set, Some(one), Some(other)) => {
                let (now, steady) = (nis(self.used), with_nis(other));
                format!("Set {}; now NIS ratio {now}. Steady flight agrees: {steady}.", with_nis(one))
            }
            (NoiseStep::Set, Some(one), None) => format!("Set {}; now NIS ratio {}.", with_nis(one), nis(self.used)),
            _ if !self.action.is_empty() => {
                let steady = self.steady.filter(|_| self.step == NoiseStep::NotNoise);
                let steady =
                    steady.map_or_else(String::new, |other| format!(" Steady flight gives {}.", with_nis(other)));
                format!("{}: {}.{steady}", capitalised(&self.reason), self.action)
            }
            (_, _, Some(other)) => {
                format!("Consistent: keep {}. Steady flight agrees: {}.", with_nis(self.used), with_nis(other))
            }
            _ => format!("Consistent: keep {}.", with_nis(self.used)),
        }
    }

    /// Whether an estimate leaves the NIS as near to its expectation as the value in use does.
    pub fn is_no_worse(&self, estimate: NoiseEstimate) -> bool {
        estimate.nis.ln().abs() <= self.used.nis.ln().abs().max(2.0 * WORTH_CHANGING.ln())
    }

    /// The one deviation to set, SI, by the innovations of the manoeuvre; none where the value in use is right or they are not noise.
    pub fn recommended(&self) -> Option<NoiseEstimate> {
        let is_right = (WORTH_CHANGING.powi(-2)..=WORTH_CHANGING.powi(2)).contains(&self.used.nis);
        match self.step {
            NoiseStep::Set | NoiseStep::Differ if !is_right => self.innovations,
            _ => None,
        }
    }
}

/// Advice on every measurement of a window that was taken.
///
/// With rho the ratio of found to predicted deviation of the innovations, S their predicted variance (its median over the window) and R
/// the square of the value in use: the innovations explain `R + (rho^2 - 1) S` (covariance matching; Mehra, IEEE Trans. Automatic Control
/// 17, 1972), and a deviation s gives `NIS = rho^2 S / (S - R + s^2)`, both with the uncertainty of the path as it is. Where that leaves
/// nothing for the noise, `rho^2 S` is still the most it can be; it is taken where R is much larger.
pub fn noise_advice(path: &WindowPath, used: &[f64], noise: Option<&FlightNoise>) -> Vec<NoiseAdvice> {
    let channels = path.assessment().consistency.as_ref().map_or(&[][..], |found| &found.channels);
    let one = |channel| channel_advice(path, channel, *used.get(channel.measurement as usize)?, noise);
    channels.iter().filter_map(one).collect()
}

/// The same of one measurement, with the value in use.
pub fn channel_advice(
    path: &WindowPath,
    channel: &ChannelConsistency,
    used: f64,
    noise: Option<&FlightNoise>,
) -> Option<NoiseAdvice> {
    let (index, run) = (channel.measurement as usize, &path.reconstruction);
    let pairs = run.innovations[index].iter().zip(&run.innovation_deviations[index]);
    let mut predicted: Vec<f64> =
        pairs.filter(|(value, _)| value.is_finite()).map(|(_, deviation)| deviation * deviation).collect();
    let row = noise.and_then(|noise| {
        let entry = NoiseChannel::Measurement(channel.measurement);
        noise.rows.iter().find(|row| row.channel == entry)
    });
    Some(advise(channel, used, median(&mut predicted)?, row))
}

/// The one deviation of a measurement for several paths, SI; `used` is the value in use.
pub fn noise_of_all<'a>(
    paths: impl Iterator<Item = &'a WindowPath>,
    measurement: Measurement,
    used: f64,
) -> Option<f64> {
    let advice = paths.filter_map(|path| {
        let channels = &path.assessment().consistency.as_ref()?.channels;
        channel_advice(path, channels.iter().find(|channel| channel.measurement == measurement)?, used, None)
    });
    pooled_noise(&advice.collect::<Vec<_>>())
}

/// The one deviation for several manoeuvres, SI: the root mean square of those that the innovations of each ask for; none where the
/// innovations of most of them are not noise.
fn pooled_noise(advice: &[NoiseAdvice]) -> Option<f64> {
    let is_noise = |advice: &&NoiseAdvice| advice.step != NoiseStep::NotNoise;
    let variances: Vec<f64> =
        advice.iter().filter(is_noise).filter_map(|advice| Some(advice.innovations?.std.powi(2))).collect();
    let most = !variances.is_empty() && 2 * variances.len() >= advice.len();
    most.then(|| (variances.iter().sum::<f64>() / variances.len() as f64).sqrt())
}

fn advise(channel: &ChannelConsistency, used: f64, predicted: f64, row: Option<&NoiseRow>) -> NoiseAdvice {
    let (found, variance) = (channel.deviation_ratio.powi(2), used * used);
    let estimate = |std: f64| NoiseEstimate { std, nis: found * predicted / (predicted - variance + std * std) };
    // Too high a noise makes innovations small and, by its low gain, correlated too.
    let is_small = channel.deviation_ratio < 1.0 / WORTH_CHANGING;
    let is_noise = !channel.has_offset() && (is_small || !channel.is_correlated());
    let explained = variance + (found - 1.0) * predicted;
    // Innovations contain the noise: it is no larger than they are, however uncertain the path.
    let bound = found * predicted;
    let asked =
        if explained > 0.0 { Some(explained) } else { Some(bound).filter(|_| AGREE * AGREE * bound < variance) };
    let innovations = asked.filter(|_| is_noise).map(|asked| estimate(asked.sqrt()));
    let steady = row.and_then(NoiseRow::proposed).map(estimate);
    let agree = |a: f64, b: f64, factor: f64| a <= factor * b && b <= factor * a;
    let apart = innovations.zip(steady).filter(|(one, other)| !agree(one.std, other.std, AGREE));
    let is_right = (1.0 / WORTH_CHANGING..=WORTH_CHANGING).contains(&channel.deviation_ratio);
    let (step, reason, action) = match apart {
        _ if !is_noise => {
            let (reason, action) = not_noise(channel);
            (NoiseStep::NotNoise, reason, action)
        }
        Some((one, other)) => (NoiseStep::Differ, row.map_or(String::new(), |row| difference(row, one, other)), ""),
        None if is_right => (NoiseStep::Keep, String::new(), ""),
        None if innovations.is_none() => {
            let reason = "innovations are smaller than the uncertainty of the path".to_owned();
            (NoiseStep::Keep, reason, "lower the process noise first")
        }
        None => (NoiseStep::Set, String::new(), ""),
    };
    NoiseAdvice { measurement: channel.measurement, used: estimate(used), innovations, steady, step, reason, action }
}

/// Why the size of the innovations is not that of the noise, and what to check.
fn not_noise(channel: &ChannelConsistency) -> (String, &'static str) {
    if channel.has_offset() {
        let reason = format!("mean innovation is {:+.2} standard deviations", channel.mean);
        return (reason, "check the sensor for an offset");
    }
    let reason = format!("innovations are correlated (lag one {:.2})", channel.lag_one());
    (reason, "check for a delay, a filter in the sensor or too little process noise")
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Why steady flight and the innovations differ.
fn difference(row: &NoiseRow, innovations: NoiseEstimate, steady: NoiseEstimate) -> String {
    match row.choice.as_ref().map(|choice| &choice.origin) {
        Ok(NoiseOrigin::Stated(_)) => "the instruments file states the error over the whole range".to_owned(),
        Ok(NoiseOrigin::Resolution(_)) => "steady flight shows only the resolution of the recorder".to_owned(),
        Ok(NoiseOrigin::Differences) => "second differences show only the fast part of the noise".to_owned(),
        Ok(NoiseOrigin::Gusts) => "gusts count as noise of the airspeed where a flow vane is not recorded".to_owned(),
        Ok(NoiseOrigin::Windows(found)) if steady.std > innovations.std && found.lag_one > SLOW => {
            format!("steady samples contain turbulence (lag-one correlation {:.2})", found.lag_one)
        }
        Ok(NoiseOrigin::Windows(_)) if steady.std > innovations.std => {
            "the steady parts were noisier than this manoeuvre: check them".to_owned()
        }
        Ok(NoiseOrigin::Windows(_)) => {
            "in the manoeuvre the sensor has errors besides noise: delay, position or calibration".to_owned()
        }
        Err(_) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use doublet_core::prep::{NoiseChoice, NoiseStatistics};

    use super::*;

    fn channel(deviation_ratio: f64) -> ChannelConsistency {
        ChannelConsistency {
            measurement: Measurement::AngleOfAttack,
            samples: 1000,
            mean: 0.0,
            mean_limit: 0.06,
            deviation_ratio,
            autocorrelation: vec![0.0; 10],
            autocorrelation_limit: 0.06,
            whiteness: 0.5,
            is_white: true,
        }
    }

    fn row(std: f64, lag_one: f64) -> NoiseRow {
        let found = NoiseStatistics {
            std,
            difference_std: std,
            resolution: 0.0,
            samples: 500,
            windows: 3,
            lag_one,
            whiteness: 0.5,
        };
        let choice = Ok(NoiseChoice { proposed: std, origin: NoiseOrigin::Windows(found) });
        NoiseRow { channel: NoiseChannel::Measurement(Measurement::AngleOfAttack), statistics: Some(found), choice }
    }

    #[test]
    fn both_estimates_state_their_nis_and_the_innovations_count() {
        // R = 4 of S = 5: innovations of twice the predicted variance ask for R = 9.
        let found = advise(&channel(2.0_f64.sqrt()), 2.0, 5.0, Some(&row(9.0, 0.6)));
        let innovations = found.innovations.unwrap();
        assert!((innovations.std - 3.0).abs() < 1e-12 && (innovations.nis - 1.0).abs() < 1e-12);
        assert!((found.used.nis - 2.0).abs() < 1e-12);
        assert!((found.steady.unwrap().nis - 10.0 / 82.0).abs() < 1e-12);
        assert_eq!((found.step, found.recommended()), (NoiseStep::Differ, found.innovations));
        assert!(found.reason.contains("turbulence"), "{}", found.reason);
        assert!(found.text(&|std| format!("{std:.1} deg")).ends_with(". Set 3.0 deg."));
    }

    #[test]
    fn estimates_that_agree_are_one_and_a_right_value_is_kept() {
        let found = advise(&channel(2.0_f64.sqrt()), 2.0, 5.0, Some(&row(3.3, 0.0)));
        assert_eq!((found.step, found.reason.as_str()), (NoiseStep::Set, ""));
        let found = advise(&channel(1.02), 2.0, 5.0, Some(&row(2.1, 0.0)));
        assert_eq!((found.step, found.recommended()), (NoiseStep::Keep, None));
        let found = advise(&channel(1.02), 2.0, 5.0, Some(&row(9.0, 0.0)));
        assert_eq!(
            (found.step, found.recommended()),
            (NoiseStep::Differ, None),
            "steady flight differs, the value in use stays"
        );
    }

    #[test]
    fn noise_of_several_manoeuvres_is_the_root_mean_square_of_those_that_show_noise() {
        let [one, other] = [2.0_f64.sqrt(), 3.0_f64.sqrt()].map(|ratio| advise(&channel(ratio), 2.0, 5.0, None));
        // R = 4 of S = 5: they ask for R = 9 and R = 14.
        let pooled = pooled_noise(&[one.clone(), other.clone()]).unwrap();
        assert!((pooled - 11.5_f64.sqrt()).abs() < 1e-12);
        let mut correlated = channel(1.5);
        (correlated.is_white, correlated.autocorrelation[0]) = (false, 0.8);
        let not_noise = advise(&correlated, 2.0, 5.0, None);
        assert_eq!(pooled_noise(&[one.clone(), not_noise.clone()]), Some(one.innovations.unwrap().std));
        assert_eq!(pooled_noise(&[other, not_noise.clone(), not_noise]), None);
    }

    #[test]
    fn correlated_innovations_are_not_noise() {
        let mut correlated = channel(1.5);
        (correlated.is_white, correlated.autocorrelation[0]) = (false, 0.8);
        let found = advise(&correlated, 2.0, 5.0, Some(&row(1.0, 0.0)));
        assert_eq!((found.step, found.innovations), (NoiseStep::NotNoise, None));
        assert_eq!(found.recommended(), None);
    }

    #[test]
    fn noise_many_times_too_high_is_bounded_by_the_innovations() {
        // R = 4 of S = 4.1: a tenth of the predicted deviation leaves 4 - 0.99 * 4.1 < 0, and 0.01 * 4.1 at most.
        let found = advise(&channel(0.1), 2.0, 4.1, None);
        let asked = found.innovations.unwrap();
        assert!((asked.std - 0.041_f64.sqrt()).abs() < 1e-12);
        assert!((asked.nis - 0.041 / (0.1 + 0.041)).abs() < 1e-12);
        assert_eq!((found.step, found.recommended()), (NoiseStep::Set, Some(asked)));
        assert!(found.is_no_worse(asked));
        // R = 4 of S = 40: the path is uncertain, and 0.36 * 40 is more than the noise in use.
        let found = advise(&channel(0.6), 2.0, 40.0, None);
        assert_eq!((found.step, found.innovations), (NoiseStep::Keep, None));
        assert_eq!(found.action, "lower the process noise first");
        assert!(found.text(&|std| format!("{std} deg")).ends_with(": lower the process noise first."));
    }

    #[test]
    fn small_innovations_ask_for_less_noise_though_correlated() {
        let mut small = channel(0.5);
        (small.is_white, small.autocorrelation[0]) = (false, 0.8);
        // R = 4 of S = 4.4: innovations of half the predicted deviation ask for R = 4 - 0.75 * 4.4 = 0.7.
        let found = advise(&small, 2.0, 4.4, Some(&row(20.0, 0.6)));
        let asked = found.innovations.unwrap();
        assert!((asked.std - 0.7_f64.sqrt()).abs() < 1e-12 && (asked.nis - 1.0).abs() < 1e-12);
        assert_eq!(found.recommended(), Some(asked));
        assert!(found.is_no_worse(asked) && !found.is_no_worse(found.steady.unwrap()));
    }
}
