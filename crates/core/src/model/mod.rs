//! Aerodynamic model: coefficients from forces and moments, terms, structures, regressors.

mod names;

pub use names::{Coefficient, Variable};
