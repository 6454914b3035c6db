//! Flight path reconstruction: kinematics; extended, iterated extended and unscented Kalman filter; smoothers; consistency.
//!
//! `run` chooses the form and calls `packed`, or `filter` and `smoother`; these use `model`, and `model` uses `numeric`. Nothing
//! imports what stands to its left (`scripts/check_layers.sh`).

mod collect;
pub mod consistency;
mod data;
mod deviations;
mod error;
mod events;
mod filter;
mod measured;
mod model;
mod numeric;
mod outliers;
mod packed;
mod pass;
mod run;
mod sequential;
mod settings;
mod smoother;
pub mod tuning;

pub use data::{AirData, FilterData, InputSeries, MeasurementSeries, Outlier, Reconstruction, Smoothed};
pub use deviations::Deviations;
pub use error::ReconstructError;
pub(crate) use events::{check as check_samples, merged_steps};
pub(crate) use filter::initial::initial_state;
pub(crate) use filter::step::StepInputs;
pub(crate) use filter::terms::velocity_by_wind;
pub use measured::measured_path;
pub(crate) use model::kinematics::Trig;
pub use model::layout::{AIR_STATES, AirState, INPUTS, Input, MEASUREMENTS, Measurement, STATES, State};
pub(crate) use model::measurement::MeasurementModel;
pub(crate) use model::transition::{Constants, Inputs, Motion, integrate as integrate_motion, predict_state};
pub use outliers::without_outliers;
#[doc(hidden)]
pub use packed::dispatch::Width;
pub use pass::Watch;
#[doc(hidden)]
pub use run::{instructions, lane_groups, lanes, reconstruct, reconstruct_many, reconstruct_with};
pub use sequential::{FilteredSample, SequentialFilter};
pub use settings::{
    FilterSettings, InputHold, Linearisation, Method, SMOOTHER_TOLERANCE, SettingError, USUAL_OUTLIER_LIMIT,
    ValidSettings,
};
