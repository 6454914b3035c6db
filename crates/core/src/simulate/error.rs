//! Errors of the simulator.

use thiserror::Error;

/// Why a simulation could not be set up or run.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum SimulateError {
    /// The aerodynamic truth file is not valid.
    #[error("aerodynamic truth '{name}': {reason}")]
    Truth { name: String, reason: String },
    /// A scenario file is not valid.
    #[error("scenario file: {reason}")]
    Scenario { reason: String },
    #[error(
        "derivative '{name}': {reason}; write a coefficient of CX CY CZ Cl Cm Cn, an underscore and a term, as in Cm_alpha or CX_alpha^2"
    )]
    BadDerivative { name: String, reason: String },
    #[error("derivative '{name}' is given twice: remove one")]
    RepeatedDerivative { name: String },
    /// An airframe cannot be flown.
    #[error("aircraft '{name}': {reason}")]
    Aircraft { name: String, reason: String },
    #[error(
        "no trim at {airspeed_m_s:.1} m/s and {altitude_m:.0} m: {worst} is still {residual:.2e} {unit} after {iterations} steps; choose a speed nearer the middle of the envelope"
    )]
    TrimNotFound {
        airspeed_m_s: f64,
        altitude_m: f64,
        worst: &'static str,
        residual: f64,
        unit: &'static str,
        iterations: usize,
    },
    #[error(
        "no trim at {airspeed_m_s:.1} m/s and {altitude_m:.0} m: it needs an angle of attack of {needed_deg:.1} deg, the derivatives hold from {low_deg:.1} to {high_deg:.1} deg; fly faster or lighter"
    )]
    TrimPastAlpha { airspeed_m_s: f64, altitude_m: f64, needed_deg: f64, low_deg: f64, high_deg: f64 },
    #[error(
        "no trim at {airspeed_m_s:.1} m/s and {altitude_m:.0} m: it needs {needed_n:.0} N of thrust per engine, at {rpm:.0} rpm there are {available_n:.0} N ({missing_n:.0} N short); fly slower or lower"
    )]
    TrimPastThrust { airspeed_m_s: f64, altitude_m: f64, needed_n: f64, rpm: f64, available_n: f64, missing_n: f64 },
    #[error(
        "{what}: {surface} needs {needed_deg:.2} deg, its stops are {low_deg:.1} and {high_deg:.1} deg ({past_deg:.2} deg past); reduce the amplitude or change the condition"
    )]
    PastStop { what: String, surface: &'static str, needed_deg: f64, low_deg: f64, high_deg: f64, past_deg: f64 },
    #[error("at {time_s:.2} s: {what} is {value:.3}, outside {low:.3} to {high:.3}; change the scenario")]
    LeftEnvelope { time_s: f64, what: &'static str, value: f64, low: f64, high: f64 },
    #[error("multisines for {controls} controls need at least that many harmonics, {first} to {last} are too few")]
    TooFewHarmonics { first: u32, last: u32, controls: usize },
    #[error("unknown scenario '{name}': use one of {}", known.join(", "))]
    UnknownScenario { name: String, known: Vec<&'static str> },
    /// Air data outside the atmosphere's range, or a map that cannot be read.
    #[error("{what}: {reason}")]
    Model { what: &'static str, reason: String },
    /// A recorded file could not be encoded.
    #[error("cannot encode {file}: {reason}")]
    Encode { file: String, reason: String },
    /// The caller asked to stop.
    #[error("stopped at {time_s:.0} s of the flight")]
    Cancelled { time_s: f64 },
}
