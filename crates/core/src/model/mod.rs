//! Aerodynamic model: coefficients from forces and moments, terms, structures, regressors.

mod coefficients;
mod data;
mod derivatives;
mod error;
mod names;
mod structure;
mod term;
mod variables;

pub use coefficients::{Coefficients, angular_momentum, coefficients, specific_force_at_cg};
pub use data::{AeroData, Axes, CoefficientSettings, Engine, Gyroscopic, Lag, Position, ThrustTreatment};
pub use derivatives::{Derivative, Derivatives, VariableValues};
pub use error::ModelError;
pub use names::{Coefficient, RECORDED, RecordedValues, Variable};
pub use structure::Structure;
pub use term::{Term, is_constant_name};
pub use variables::{Variables, regressors, variables};
