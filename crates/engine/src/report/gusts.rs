//! Delays of the measurements and gusts over the windows, as the reconstruction found them.

use doublet_core::reconstruct::State;
use doublet_core::statistics::squares_about_mean;
use serde::Serialize;

use crate::snapshot::Snapshot;
use crate::stage::SensorDelay;

/// Gusts the likelihood calls for, and what they do to the angle of attack.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GustRow {
    /// Whether the filter uses them, because they are significant.
    pub applied: bool,
    /// Random walk of the wind that represents them, m/s per square root of a second: horizontal, vertical.
    pub random_walk: [f64; 2],
    /// Standard error of the logarithm of each.
    pub log_standard_error: [Option<f64>; 2],
    /// Gain of the logarithm of the likelihood over a steady wind.
    pub log_likelihood_gain: f64,
    /// Standard deviation of the reconstructed wind about its mean in each manoeuvre, m/s: horizontal component, vertical.
    pub deviation_m_s: [f64; 2],
    /// Standard deviation of the vertical wind over airspeed, as a part of that of the angle of attack.
    pub part_of_alpha: f64,
}

impl GustRow {
    /// In words.
    pub fn summary(&self) -> String {
        if !self.applied {
            return "not significant".to_owned();
        }
        let [horizontal, vertical] = self.deviation_m_s;
        format!(
            "{vertical:.2} m/s rms vertical, {horizontal:.2} m/s horizontal, {:.0} % of the motion of alpha",
            100.0 * self.part_of_alpha
        )
    }
}

/// Gusts of a run that estimated them.
pub fn gusts(snapshot: &Snapshot) -> Option<GustRow> {
    let found = snapshot.delays_and_gusts.gusts.as_ref()?;
    let (mut squares, mut samples) = ([0.0; 4], 0.0);
    for path in snapshot.windows.values().filter_map(|results| results.path.ready()) {
        let path = &path.reconstruction;
        let states = path.smoothed.as_ref().map_or(&path.states, |smoothed| &smoothed.states);
        let state_values = |state: State| states[state as usize].as_slice();
        let count = path.time_s.len() as f64;
        let (u, w) = (state_values(State::VelocityU), state_values(State::VelocityW));
        let alpha: Vec<f64> = w.iter().zip(u).map(|(w, u)| w.atan2(*u)).collect();
        let flow: Vec<f64> = state_values(State::WindDown).iter().zip(u).map(|(wind, u)| wind / u.max(1.0)).collect();
        let horizontal = 0.5 * (variance(state_values(State::WindNorth)) + variance(state_values(State::WindEast)));
        let found = [horizontal, variance(state_values(State::WindDown)), variance(&flow), variance(&alpha)];
        squares.iter_mut().zip(found).for_each(|(sum, variance)| *sum += count * variance);
        samples += count;
    }
    let deviation = squares.map(|sum| (sum / samples).sqrt());
    Some(GustRow {
        applied: found.is_significant(),
        random_walk: found.walk,
        log_standard_error: found.log_standard_error,
        log_likelihood_gain: found.gain,
        deviation_m_s: [deviation[0], deviation[1]],
        part_of_alpha: deviation[2] / deviation[3],
    })
}

/// The delay of a group of measurements.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DelayRow {
    pub measurements: Vec<&'static str>,
    /// Delay of the time stamps in addition to the stated one, s.
    pub delay_s: f64,
    pub standard_error_s: f64,
    /// Whether the filter uses it, because it is significant.
    pub applied: bool,
}

impl DelayRow {
    /// In words.
    pub fn summary(&self) -> String {
        format!("{} {:.0} ± {:.0} ms", self.measurements.join(", "), 1e3 * self.delay_s, 1e3 * self.standard_error_s)
    }
}

/// The delays that the filter takes, in words; none where it takes none.
pub fn applied_delays(rows: &[DelayRow]) -> Option<String> {
    let applied: Vec<String> = rows.iter().filter(|row| row.applied).map(DelayRow::summary).collect();
    (!applied.is_empty()).then(|| applied.join("; "))
}

/// Delays of a run that estimated them.
pub fn delays(snapshot: &Snapshot) -> Vec<DelayRow> {
    snapshot.delays_and_gusts.delays.iter().flat_map(|found| found.0.iter().map(delay_row)).collect()
}

fn delay_row(found: &SensorDelay) -> DelayRow {
    DelayRow {
        measurements: found.kind.measurements().iter().map(|measurement| measurement.name()).collect(),
        delay_s: found.delay_s,
        standard_error_s: found.standard_error_s,
        applied: found.is_significant(),
    }
}

/// Mean square about the mean.
fn variance(values: &[f64]) -> f64 {
    squares_about_mean(values) / values.len().max(1) as f64
}
