//! Linear models about a trim: from derivatives with and without dimension, and from an identified model of any terms.

mod analytic;
mod dimensional;
mod error;
pub(crate) mod flight;
mod model;
mod nondimensional;
mod simulation;
mod state_space;
mod trim;
mod uncertain;
mod zeros;

pub use dimensional::{LateralDerivatives, LongitudinalDerivatives, SymmetricTrim};
pub use error::LinearError;
pub use flight::{Condition, FlightModel, INPUT_NAMES, STATE_NAMES, SteadyFlight, ThrustLine};
pub use model::{Linearised, Method, Part, linearise, linearise_at};
pub use nondimensional::{LiftAndDrag, Scales, StabilityLateral, StabilityLongitudinal};
pub use simulation::{OUTPUT_NAMES, Simulation};
pub use state_space::{Quantity, SIGNS, StateSpace, state_unit};
pub use trim::{Trim, trim};
pub use uncertain::{Change, Sensitivities, UncertainModel};
