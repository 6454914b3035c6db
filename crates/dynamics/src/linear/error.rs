//! Why a model cannot be linearised.

use thiserror::Error;

/// Why a model cannot be trimmed or linearised.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum LinearError {
    #[error("the model has no derivatives of {}: a trim needs CX and CZ (or CD and CL) and Cm; mark identification manoeuvres that excite them", missing.join(", "))]
    NoCoefficient { missing: Vec<&'static str> },
    #[error("{quantity} of the trim is {value}: give a value above 0")]
    NotPositive { quantity: &'static str, value: f64 },
    #[error("the inertia tensor of the trim is not positive definite: check its products against Ixx, Iyy and Izz")]
    Inertia,
    #[error(
        "the flight path angle cannot be chosen: coefficients include thrust; leave the angle out or remove the thrust"
    )]
    NoThrust,
    #[error("a turn at a load factor of {load_factor} does not exist: give one above 1")]
    LoadFactor { load_factor: f64 },
    #[error(
        "no trim at {airspeed_m_s:.1} m/s and {altitude_m:.0} m: {residual:.2e} {unit} of {equation} is left after {iterations} steps; is a term of the control that balances it missing from the model?"
    )]
    NoTrim {
        airspeed_m_s: f64,
        altitude_m: f64,
        equation: &'static str,
        residual: f64,
        unit: &'static str,
        iterations: usize,
    },
    #[error("the terms of alpha_dot or beta_dot cancel the mass of the aircraft: their derivatives are too large")]
    Singular,
    #[error("the model has no derivative '{name}'")]
    NoDerivative { name: String },
}
