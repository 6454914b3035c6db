//! Inputs for the next flight, designed from what is known: signals within limits, the standard errors they will give, and how far the
//! aircraft goes.
//!
//! Data flow one way, `signal -> multisine -> shape -> fly -> predict -> plan -> search`.

mod error;
mod excursion;
mod fly;
mod multisine;
mod plan;
mod predict;
mod search;
mod shape;
mod signal;

pub use error::DesignError;
pub use excursion::{Excursion, Limit, Limits, Quantity, excursions};
pub use fly::{Disturbance, FlownInput, Plant, Start, fly};
pub use multisine::{orthogonal_multisines, relative_peak_factor};
pub use plan::{DesignKind, PlannedManoeuvre, Recipe, SURFACE_NAMES};
pub use predict::{
    Basis, ExpectedDerivative, KnownCoefficient, Prediction, designed_settings, window_data, window_variables,
};
pub use search::{Criterion, Designed, NextManoeuvre, Request, design, next_manoeuvres};
pub use shape::BaseTimes;
pub use signal::{CONTROLS, Input, THROTTLE};
