//! The model of the filter: order of states, kinematics, measurements, transition, sensor errors.
//!
//! A new sensor error is one line of [`layout::AirState`] and one of [`sensor_errors::effect`]; nothing outside this folder changes.

pub mod augmented;
pub mod dense;
pub mod kinematics;
pub mod layout;
pub mod measurement;
pub mod sensor_errors;
pub mod transition;
