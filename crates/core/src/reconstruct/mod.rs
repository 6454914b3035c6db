//! Flight path reconstruction: kinematics; extended, iterated extended and unscented Kalman filter; smoothers; consistency.
//!
//! `run` chooses the form and calls `packed`, or `filter` and `smoother`; these use `model`, and `model` uses `numeric`. Nothing
//! imports what stands to its left (`scripts/check_layers.sh`).

mod collect;
pub mod consistency;
mod data;
mod error;
mod events;
mod filter;
mod measured;
mod model;
mod numeric;
mod packed;
mod pass;
mod run;
mod settings;
mod smoother;
pub mod tuning;

pub use data::{AirData, FilterData, InputSeries, MeasurementSeries, Reconstruction, Smoothed};
pub use error::ReconstructError;
pub use measured::measured_path;
pub use model::layout::{AIR_STATES, AirState, INPUTS, Input, MEASUREMENTS, Measurement, STATES, State};
#[doc(hidden)]
pub use packed::dispatch::Width;
pub use pass::Watch;
#[doc(hidden)]
pub use run::reconstruct_with;
pub use run::{instructions, lane_groups, lanes, reconstruct, reconstruct_many};
pub use settings::{FilterSettings, InputHold, Linearisation, Method, SMOOTHER_TOLERANCE, SettingError, ValidSettings};
