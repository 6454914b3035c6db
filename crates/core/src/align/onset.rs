//! Time of a control sensor from the first response of the aircraft to the control.

use nalgebra::{DMatrix, DVector};

use super::AlignError;
use super::derivative::usable;
use crate::series::{Series, TimeRange};

/// Widest search, s: clocks further apart are aligned by shared channels first.
const MOST_RANGE_S: f64 = 10.0;

/// How an onset is aligned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnsetSettings {
    /// Farthest the control sensor is shifted either way, s.
    pub range_s: f64,
    /// Number of integrals of the control the response may follow beside the control itself, for motion no companion shows.
    pub integrals: usize,
    /// Least share of the response's variance the control must explain.
    pub min_share: f64,
}

impl Default for OnsetSettings {
    /// 0.5 s either way, no integrals, share 0.5.
    fn default() -> Self {
        Self { range_s: 0.5, integrals: 0, min_share: 0.5 }
    }
}

/// A control sensor's shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnsetAlignment {
    /// To be added to the stamps of the control sensor, s; give it to [`super::ClockModel::shifted`].
    pub shift_s: f64,
    /// Its standard error for white noise on the response, s.
    pub shift_sd_s: f64,
    /// Share of the variance of the response that the shifted control explains.
    pub share: f64,
}

/// Shift of a control sensor that makes the body's acceleration answer the control at once (thesis section 4.4.3).
///
/// The acceleration follows `y = c0 + c1 t + sum_j a_j x_j + sum_k h_k I^k[u]`: the measured motion `x_j` of the `companions` (rates,
/// attitude), and the control `u` with its repeated integrals `I^k` from the start of the window, `k = 0 ..= integrals`, whose factors are
/// the first Markov parameters of what no companion shows. Over the window the shift is that for which least squares leaves
/// least; a parabola through the best three places it between steps of a quarter of the response's interval. `response` is an
/// acceleration (specific force, or an angular acceleration) and `companions` are samples at its stamps, against the reference
/// clock; `window` is in its time: from about a second of steady flight before the onset to one or two after it. `control`
/// needs samples over the window widened by the range. A sensor's own latency, and an actuator's, is part of the shift found.
///
/// # Errors
/// [`AlignError::Signal`], [`AlignError::Setting`]; [`AlignError::OnsetSamples`] for fewer than twice as many samples in the
/// window as terms, or a control that does not cover it; [`AlignError::NoResponse`]; [`AlignError::ShiftAtEnd`].
pub fn onset_alignment(
    control: &Series,
    response: &Series,
    companions: &[&Series],
    window: TimeRange,
    settings: &OnsetSettings,
) -> Result<OnsetAlignment, AlignError> {
    let range = settings.range_s;
    if !(range > 0.0 && range <= MOST_RANGE_S) {
        return Err(AlignError::Setting { setting: "range_s", value: range, allowed: "above zero, at most 10 s" });
    }
    let Series { time_s: control_time, values: control_values } = usable("control", control)?;
    let Series { time_s: response_time, values: response_values } = usable("response", response)?;
    let inside = window.indices(&response_time);
    if let Some(other) = companions.iter().find(|other| other.time_s != response.time_s) {
        let reason = format!("its {} stamps are not the {} of the response", other.time_s.len(), response.time_s.len());
        return Err(AlignError::Signal { channel: "companion".to_owned(), reason });
    }
    let terms = settings.integrals + companions.len() + 3;
    let covered = control_time.first().is_some_and(|&start| start <= window.start_s - range)
        && control_time.last().is_some_and(|&end| end >= window.end_s + range);
    let found = if covered { inside.len() } else { 0 };
    if found < 2 * terms {
        let TimeRange { start_s, end_s } = window;
        return Err(AlignError::OnsetSamples { found, needed: 2 * terms, start_s, end_s });
    }
    let time = &response_time[inside.clone()];
    let y = DVector::from_column_slice(&response_values[inside]);
    let stamps = TimeRange { start_s: time[0], end_s: time[time.len() - 1] }.indices(&response.time_s);
    let moved: Vec<&[f64]> = companions.iter().map(|other| &other.values[stamps.clone()]).collect();
    if moved.iter().any(|values| values.len() != time.len() || values.iter().any(|value| !value.is_finite())) {
        let reason = "a sample in the window is not finite".to_owned();
        return Err(AlignError::Signal { channel: "response or companion".to_owned(), reason });
    }
    let problem = Problem {
        control_time: &control_time,
        control: &control_values,
        time,
        y: &y,
        companions: &moved,
        integrals: settings.integrals,
    };
    let step = 0.25 * (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
    let half = (range / step).floor() as i64;
    let left: Vec<f64> = (-half..=half).map(|k| problem.left_over(k as f64 * step)).collect();
    let best = (0..left.len()).min_by(|&i, &j| left[i].total_cmp(&left[j])).unwrap_or(0);
    if best == 0 || best + 1 == left.len() {
        return Err(AlignError::ShiftAtEnd { range_s: range });
    }
    let curvature = (left[best - 1] - 2.0 * left[best] + left[best + 1]) / (step * step);
    let between = 0.5 * (left[best - 1] - left[best + 1]) / (curvature * step * step);
    let mean = y.mean();
    let total: f64 = y.iter().map(|value| (value - mean).powi(2)).sum();
    let share = 1.0 - left[best] / total;
    if !(share >= settings.min_share && curvature > 0.0) {
        return Err(AlignError::NoResponse { share, needed: settings.min_share });
    }
    let noise = left[best] / (time.len() - terms - 1) as f64;
    let shift_s = ((best as i64 - half) as f64 + between) * step;
    Ok(OnsetAlignment { shift_s, shift_sd_s: (2.0 * noise / curvature).sqrt(), share })
}

/// Least squares of the response on the shifted control and its integrals.
struct Problem<'a> {
    control_time: &'a [f64],
    control: &'a [f64],
    time: &'a [f64],
    y: &'a DVector<f64>,
    companions: &'a [&'a [f64]],
    integrals: usize,
}

impl Problem<'_> {
    /// Control at a time, linear between its samples.
    fn control_at(&self, t: f64) -> f64 {
        let right = self.control_time.partition_point(|&stamp| stamp < t).clamp(1, self.control_time.len() - 1);
        let (from, to) = (self.control_time[right - 1], self.control_time[right]);
        let fraction = (t - from) / (to - from);
        self.control[right - 1] + fraction * (self.control[right] - self.control[right - 1])
    }

    /// Sum of squares left over when the control's stamps are moved by `shift`.
    fn left_over(&self, shift: f64) -> f64 {
        let n = self.time.len();
        let start = self.time[0];
        let length = self.time[n - 1] - start;
        let control = 2 + self.companions.len();
        let terms = control + 1 + self.integrals;
        let mut x = DMatrix::zeros(n, terms);
        let level = self.control_at(start - shift);
        for (k, &t) in self.time.iter().enumerate() {
            x[(k, 0)] = 1.0;
            x[(k, 1)] = (t - start) / length;
            for (j, values) in self.companions.iter().enumerate() {
                x[(k, 2 + j)] = values[k];
            }
            x[(k, control)] = self.control_at(t - shift) - level;
        }
        for term in control + 1..terms {
            for k in 1..n {
                let step = (self.time[k] - self.time[k - 1]) / length;
                x[(k, term)] = x[(k - 1, term)] + 0.5 * step * (x[(k, term - 1)] + x[(k - 1, term - 1)]);
            }
        }
        let qr = x.qr();
        let mut rotated = self.y.clone();
        qr.q_tr_mul(&mut rotated);
        rotated.rows(terms, n - terms).norm_squared()
    }
}
