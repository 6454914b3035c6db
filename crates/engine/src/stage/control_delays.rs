//! How late the recorded deflections are by the residuals of the pooled fits, and what that gives to the derivatives.
//!
//! Residuals `r` of a coefficient with a deflection taken `tau` later are `r(tau) = r(0) + s tau`, `s` by central differences of one
//! sample. The delay of this coefficient is `-s'r / s's`, its variance the larger of that for white residuals and of the scatter between
//! manoeuvres (sum of `(s_w' r_w)^2` over `(s's)^2`), so correlated residuals and a model that fits no manoeuvre exactly are in it. The
//! coefficients and what is known of recorders before any flight are weighed together.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::estimate::PooledFit;
use doublet_core::model::{Coefficient, Structure};
use doublet_core::quantity::InstrumentError;
use doublet_core::statistics::median_step;
use rayon::prelude::*;

use super::aero::WindowAero;
use super::fit::{AeroWindow, pooled_regressions};
use crate::session::{Estimation, InstrumentAccuracy, Surface};

/// Deviation of the delay of a deflection before any flight, s: recorders deliver controls within some 0.05 s.
pub const PRIOR_DEVIATION_S: f64 = 0.05;

/// What the residuals say of the delay of a surface's deflection, and how the pooled derivatives move with it.
#[derive(Clone, Debug)]
pub struct ControlDelay {
    pub surface: Surface,
    /// Delay of the recorded deflection, s.
    pub delay_s: f64,
    pub standard_error_s: f64,
    /// What the residuals say of it, 1/s²; what was known beforehand is not part of it.
    pub information: f64,
    /// Change of each derivative when the samples are freed of the delay, per s.
    slopes: BTreeMap<String, f64>,
}

impl ControlDelay {
    /// Change of a derivative when the samples are freed of the delay, per s.
    pub fn slope(&self, derivative: &str) -> f64 {
        self.slopes.get(derivative).copied().unwrap_or_default()
    }

    /// Mean square of the change that the delay makes in a derivative.
    pub fn mean_square(&self, derivative: &str) -> f64 {
        let slope = self.slope(derivative);
        slope * slope * (self.delay_s * self.delay_s + self.standard_error_s * self.standard_error_s)
    }
}

/// The error of the instruments that the delay of a deflection is.
pub fn instrument_error(surface: Surface) -> InstrumentError {
    match surface {
        Surface::Aileron => InstrumentError::AileronDelay,
        Surface::Elevator => InstrumentError::ElevatorDelay,
        Surface::Rudder => InstrumentError::RudderDelay,
    }
}

/// Pooled fit of a coefficient, and how many of its parameters all windows share.
type SharedFit = (Coefficient, usize, PooledFit);

/// The delay of each surface that the windows record and the structure has.
pub fn control_delays(
    windows: &[AeroWindow<'_>],
    (structure, estimation): (&Structure, &Estimation),
    accuracy: &InstrumentAccuracy,
) -> Vec<ControlDelay> {
    let Some(step_s) = windows.first().and_then(|(_, aero)| median_step(&aero.data.time_s)) else { return Vec::new() };
    let nominal = fit_shared(windows, structure, estimation);
    let delay = |surface: &Surface| {
        let moved = |by_s: f64| -> Option<Vec<SharedFit>> {
            let windows: Option<Vec<AeroWindow<'_>>> =
                windows.iter().map(|(window, aero)| Some((*window, taken_later(aero, *surface, by_s)?))).collect();
            Some(fit_shared(&windows?, structure, estimation))
        };
        let deviation_s = accuracy.0.get(&instrument_error(*surface)).copied().unwrap_or(PRIOR_DEVIATION_S);
        control_delay((*surface, deviation_s), &nominal, [&moved(-step_s)?, &moved(step_s)?], step_s)
    };
    Surface::ALL.par_iter().filter_map(delay).collect()
}

fn fit_shared(windows: &[AeroWindow<'_>], structure: &Structure, estimation: &Estimation) -> Vec<SharedFit> {
    let found = pooled_regressions(windows, structure, estimation).into_iter().flatten();
    let fit = |regression: super::Regression| {
        Some((regression.coefficient, regression.pooled.shared().count(), regression.pooled.fit().ok()?))
    };
    found.filter_map(fit).collect()
}

/// The window with the deflection of a surface as recorded `by_s` later, straight lines between the samples; the same where it has none.
fn taken_later(aero: &Arc<WindowAero>, surface: Surface, by_s: f64) -> Option<Arc<WindowAero>> {
    let mut data = aero.data.clone();
    let Some(deflection) = data.controls.get_mut(&surface.role()) else { return Some(Arc::clone(aero)) };
    let time_s = &data.time_s;
    let at = |time: &f64| {
        let after = time_s.partition_point(|sample| *sample < time + by_s).clamp(1, time_s.len() - 1);
        let part = (time + by_s - time_s[after - 1]) / (time_s[after] - time_s[after - 1]);
        deflection[after - 1] + part.clamp(0.0, 1.0) * (deflection[after] - deflection[after - 1])
    };
    if time_s.len() < 2 {
        return None;
    }
    *deflection = time_s.iter().map(at).collect();
    WindowAero::form(data, aero.settings.clone(), aero.air_density).ok().map(Arc::new)
}

/// The delay by all coefficients together, from the fits with the deflection taken `step_s` earlier and later.
fn control_delay(
    (surface, deviation_s): (Surface, f64),
    nominal: &[SharedFit],
    [earlier, later]: [&[SharedFit]; 2],
    step_s: f64,
) -> Option<ControlDelay> {
    let mut information = deviation_s.powi(-2);
    let mut weighed = 0.0;
    let mut slopes = BTreeMap::new();
    for (coefficient, shared, fit) in nominal {
        let index_in = |fits: &[SharedFit]| fits.iter().position(|(other, ..)| other == coefficient);
        let (earlier, later) = (&earlier[index_in(earlier)?].2, &later[index_in(later)?].2);
        if let Some((delay_s, variance)) = delay_by(fit, [earlier, later], step_s) {
            information += 1.0 / variance;
            weighed += delay_s / variance;
        }
        let moved = later.fit.estimates.iter().zip(&earlier.fit.estimates).take(*shared);
        let moved = moved.map(|(later, earlier)| (later - earlier) / (2.0 * step_s));
        slopes.extend(fit.fit.names.iter().cloned().zip(moved));
    }
    let standard_error_s = information.sqrt().recip();
    let by_residuals = information - deviation_s.powi(-2);
    Some(ControlDelay { surface, delay_s: weighed / information, standard_error_s, information: by_residuals, slopes })
}

/// Delay by the residuals of one coefficient, s, and its variance, s²; none where they do not depend on the deflection.
fn delay_by(nominal: &PooledFit, [earlier, later]: [&PooledFit; 2], step_s: f64) -> Option<(f64, f64)> {
    let residuals = &nominal.fit.residuals;
    let slopes: Vec<f64> = later
        .fit
        .residuals
        .iter()
        .zip(earlier.fit.residuals.iter())
        .map(|(later, earlier)| (later - earlier) / (2.0 * step_s))
        .collect();
    let curvature: f64 = slopes.iter().map(|slope| slope * slope).sum();
    let gradient: f64 = slopes.iter().zip(residuals.iter()).map(|(slope, residual)| slope * residual).sum();
    let delay_s = -gradient / curvature;
    let left = |sample: usize| residuals[sample] + slopes[sample] * delay_s;
    let freedom = residuals.len().saturating_sub(nominal.fit.estimates.len()).max(1) as f64;
    let white = (0..slopes.len()).map(|sample| left(sample).powi(2)).sum::<f64>() / (freedom * curvature);
    let of_window = |range: &std::ops::Range<usize>| -> f64 { range.clone().map(|k| slopes[k] * left(k)).sum() };
    let scatter = nominal.samples.iter().map(|range| of_window(range).powi(2)).sum::<f64>() / (curvature * curvature);
    let variance = white.max(scatter);
    (delay_s.is_finite() && variance > 0.0 && variance.is_finite()).then_some((delay_s, variance))
}
