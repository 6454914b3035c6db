//! Modes measured in the recording: the free response at the end of each window, fitted without any model of the aircraft.

use std::ops::Range;

use doublet_core::statistics::median_step;
use doublet_dynamics::modes::{MeasuredMode, Mode, fit_free_response};

use crate::session::Surface;
use crate::stage::{CONTROLS, StudyWindow, WindowAero};

/// Part of a control's travel in a window within which it counts as at rest.
const REST: f64 = 0.03;
/// Shortest free response that is fitted, s.
const SHORTEST_S: f64 = 1.5;
/// Distance from a model's eigenvalue, relative to it, up to which a measured one has its name.
const NEAR: f64 = 0.5;

/// Modes in the free response of one window.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredWindow {
    pub window: String,
    /// Control of the manoeuvre.
    pub surface: Surface,
    /// Ends of the free response, s.
    pub span_s: [f64; 2],
    /// Modes with the name of the model's mode that is near, or why there are none.
    pub modes: Result<Vec<(Option<&'static str>, MeasuredMode)>, String>,
}

/// Modes in the free response of every window whose controls come to rest early enough: pitch rate and angle of attack behind the
/// elevator, roll rate, yaw rate and sideslip behind aileron and rudder.
pub fn measured_modes(windows: &[StudyWindow<'_>], model: &[Mode]) -> Vec<MeasuredWindow> {
    windows.iter().filter_map(|window| measured(window, model)).collect()
}

fn measured(window: &StudyWindow<'_>, model: &[Mode]) -> Option<MeasuredWindow> {
    let aero = &*window.aero;
    let data = &aero.data;
    let rows = free_rows(aero);
    let time = &data.time_s[rows.clone()];
    let (start_s, end_s) = (*time.first()?, *time.last()?);
    if end_s - start_s < SHORTEST_S {
        return None;
    }
    let step_s = median_step(time)?;
    let [p, q, r] = data.rates_rad_s.each_ref().map(|column| &column[rows.clone()]);
    let (alpha, beta) = (&data.alpha_rad[rows.clone()], &data.beta_rad[rows]);
    let surface = window.manoeuvre.surface?;
    let found = if surface == Surface::Elevator {
        fit_free_response(&[q, alpha], step_s, 2)
    } else {
        fit_free_response(&[p, r, beta], step_s, 3)
    };
    let modes = found
        .map(|found| found.modes.into_iter().map(|mode| name_mode(mode, model)).collect())
        .map_err(|error| error.to_string());
    Some(MeasuredWindow { window: window.manoeuvre.name.clone(), surface, span_s: [start_s, end_s], modes })
}

fn name_mode(mode: MeasuredMode, model: &[Mode]) -> (Option<&'static str>, MeasuredMode) {
    let off = |known: &&Mode| {
        (known.real_1_s - mode.real_1_s).hypot(known.imaginary_rad_s - mode.imaginary_rad_s) / known.frequency_rad_s()
    };
    let nearest = model.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    (nearest.filter(|known| off(known) < NEAR).map(|known| known.name), mode)
}

/// Samples of the free response: behind the last motion of the controls, up to an excluded part, or behind it where more is left.
fn free_rows(aero: &WindowAero) -> Range<usize> {
    let (time_s, mut rows) = (&aero.data.time_s, rest_from(aero)..aero.data.time_s.len());
    for part in &aero.settings.excluded {
        let excluded = part.indices(&time_s[rows.clone()]);
        let before = rows.start..rows.start + excluded.start;
        let after = rows.start + excluded.end..rows.end;
        if !excluded.is_empty() {
            rows = if before.len() > after.len() { before } else { after };
        }
    }
    rows
}

/// First sample from which all controls stay where they end.
fn rest_from(aero: &WindowAero) -> usize {
    let mut first = 0;
    for deflection in CONTROLS.iter().filter_map(|surface| aero.data.controls.get(&surface.role())) {
        let lowest = deflection.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = deflection.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let Some(last) = deflection.last() else { continue };
        // A control that only trembles is at rest all the time.
        let slack = (REST * (highest - lowest)).max(STILL_RAD);
        let moving = deflection.iter().rposition(|value| (value - last).abs() > slack);
        first = first.max(moving.map_or(0, |index| index + 1));
    }
    first.min(aero.data.time_s.len().saturating_sub(1))
}

/// Deflection that counts as none, rad.
const STILL_RAD: f64 = 0.004;
