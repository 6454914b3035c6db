//! Six-degree-of-freedom simulation with sensors and clocks: recordings whose every answer is known.
//!
//! A [`Vehicle`] is an aircraft with an aerodynamic truth; [`trim`] finds its steady flight and [`modes`] its natural
//! motion about it. [`scenario::build`] gives a flight by name, [`run`] flies it, [`Flight::files`] encodes what the
//! recorders hold and the truth.

mod aero;
mod boxes;
mod error;
mod files;
mod flight_plan;
mod gear;
mod inputs;
mod instrument_errors;
mod instruments;
mod measured;
mod modes;
mod multisine;
mod pilot;
mod plan;
mod recorder;
mod run;
pub mod scenario;
mod summary;
mod trim;
mod truth;
mod turbulence;
mod vehicle;

pub use crate::motion::{Airflow, FactoredInertia, Mode, Rate, State, runge_kutta};
pub use aero::{AeroModel, Derivative, DerivativeEntry};
pub use error::SimulateError;
pub use files::RecordedFile;
pub use flight_plan::c337f;
pub use gear::{Gear, GearData};
pub use inputs::{FirstOrderLag, Form, Hand, InputKind, InputSignal};
pub use instrument_errors::InstrumentErrors;
pub use instruments::{ControlLinkage, Quantity};
pub use modes::{modes, system_matrix};
pub use multisine::Multisine;
pub use plan::{DesignedInput, Flown, Hands, Manoeuvre, Power, Segment, Task};
pub use recorder::{ChannelSpec, Clock, Reading, Stream, StreamSpec};
pub use run::{Flight, run};
pub use scenario::Scenario;
pub use summary::{TrueModes, true_modes};
pub use trim::{Trim, TrimCondition, trim};
pub use truth::Truth;
pub use turbulence::Dryden;
pub use vehicle::{Body, Controls, Environment, Loads, Stops, Surface, Thrust, Vehicle};
