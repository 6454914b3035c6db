//! The identified aircraft as a Functional Mock-up Unit: FMI 3.0, co-simulation and model exchange.
//!
//! One library for every aircraft: its derivatives, mass and start stand in `resources/model.json` of the unit, so a user needs no
//! compiler. Variables are those of [`variables`]; the description of a unit is written by `doublet fmu`.

#![allow(unsafe_code, reason = "the C interface that FMI 3.0 prescribes")]
#![allow(non_snake_case, reason = "names that FMI 3.0 prescribes")]

mod instance;
mod interface;
mod unsupported;
mod variables;

pub use instance::{Instance, TOKEN_PREFIX};
pub use variables::{Unit, Variable, VariableKind, variables};
