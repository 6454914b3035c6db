//! Six-degree-of-freedom simulation with sensors and clocks: recordings whose every answer is known.
//!
//! A [`Vehicle`] is an aircraft with an aerodynamic truth; [`trim`] finds its steady flight and [`modes`] its natural
//! motion about it.

mod aero;
mod body;
mod error;
mod gear;
mod inputs;
mod modes;
mod multisine;
mod trim;
mod turbulence;
mod vehicle;

pub use aero::{AeroModel, Derivative, DerivativeEntry, VariableValues};
pub use body::{Inertia, Rate, State, runge_kutta, runge_kutta_from};
pub use error::SimulateError;
pub use gear::{Gear, GearData};
pub use inputs::{FirstOrderLag, Form, Hand, InputKind, InputSignal};
pub use modes::{Mode, modes, system_matrix};
pub use multisine::Multisine;
pub use trim::{Trim, TrimCondition, full_throttle_pa, trim};
pub use turbulence::Dryden;
pub use vehicle::{Airflow, Body, Controls, Environment, Loads, Stops, Surface, Thrust, Vehicle};
