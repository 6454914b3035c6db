//! Whether what was flown is enough.

use serde::Serialize;

use crate::graph::Footprint;

/// How far a session has come.
#[derive(Clone, Debug, Serialize)]
pub struct Enough {
    /// Whether every goal is met.
    pub enough: bool,
    /// Derivatives whose goal is met.
    pub met: usize,
    /// Derivatives in all.
    pub of: usize,
    /// Derivatives with their goals.
    pub derivatives: Vec<DerivativeRow>,
    /// After every identification window, in the order of the session.
    pub windows: Vec<WindowInformation>,
    /// Manoeuvres that could be flown next, best first; empty where all goals are met.
    pub next: Vec<NextRow>,
}

/// A derivative with its goal.
#[derive(Clone, Debug, Serialize)]
pub struct DerivativeRow {
    pub name: String,
    pub estimate: f64,
    pub corrected: Option<f64>,
    pub goal: f64,
    pub met: bool,
    pub met_after: Option<String>,
}

/// What the windows up to one say together.
#[derive(Clone, Debug, Serialize)]
pub struct WindowInformation {
    pub window: String,
    pub time_s: f64,
    pub met: usize,
    pub worst: Option<String>,
    pub worst_over_goal: Option<f64>,
    pub corrected: Vec<Option<f64>>,
}

/// A manoeuvre that could be flown next.
#[derive(Clone, Debug, Serialize)]
pub struct NextRow {
    pub kind: &'static str,
    pub surfaces: Vec<&'static str>,
    pub duration_s: f64,
    pub met: usize,
    pub worst: Option<String>,
    pub worst_over_goal: Option<f64>,
    pub signal_peak_rad: Vec<f64>,
}

impl Footprint for Enough {
    fn bytes(&self) -> usize {
        128 * (1 + self.derivatives.len()) * (1 + self.windows.len())
    }
}
