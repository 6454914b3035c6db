//! Why a model cannot be linearised.

use thiserror::Error;

/// Why a model cannot be trimmed or linearised.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LinearError {
    /// Coefficients without derivatives.
    #[error("the model has no derivatives of {}: a trim needs CX and CZ (or CD and CL) and Cm; mark identification manoeuvres that excite them", missing.join(", "))]
    NoCoefficient {
        /// Names of the coefficients.
        missing: Vec<&'static str>,
    },
    /// A quantity of the condition that must be positive.
    #[error("{quantity} of the trim is {value}: give a value above 0")]
    NotPositive {
        /// Quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// The inertia tensor.
    #[error("the inertia tensor of the trim is not positive definite: check its products against Ixx, Iyy and Izz")]
    Inertia,
    /// A flight path is asked of a model that contains the thrust.
    #[error(
        "the flight path angle cannot be chosen: coefficients include thrust; leave the angle out or remove the thrust"
    )]
    NoThrust,
    /// A load factor no such flight has.
    #[error("a turn at a load factor of {load_factor} does not exist: give one above 1")]
    LoadFactor {
        /// As asked for.
        load_factor: f64,
    },
    /// No steady flight.
    #[error(
        "no trim at {airspeed_m_s:.1} m/s and {altitude_m:.0} m: {residual:.2e} {unit} of {equation} is left after {iterations} steps; is a term of the control that balances it missing from the model?"
    )]
    NoTrim {
        /// True airspeed, m/s.
        airspeed_m_s: f64,
        /// Altitude, m.
        altitude_m: f64,
        /// Equation that is furthest from being met.
        equation: &'static str,
        /// What is left of it.
        residual: f64,
        /// Its unit.
        unit: &'static str,
        /// Steps taken.
        iterations: usize,
    },
    /// The accelerations cannot be solved for.
    #[error("the terms of alpha_dot or beta_dot cancel the mass of the aircraft: their derivatives are too large")]
    Singular,
    /// A derivative that is not there.
    #[error("the model has no derivative '{name}'")]
    NoDerivative {
        /// Its name.
        name: String,
    },
}
