//! Errors of the simulator.

use thiserror::Error;

/// Why a simulation could not be set up or run.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SimulateError {
    /// The aerodynamic truth file is not valid.
    #[error("aerodynamic truth '{name}': {reason}")]
    Truth {
        /// Name of the set.
        name: String,
        /// What is wrong, with its place.
        reason: String,
    },
    /// A scenario file is not valid.
    #[error("scenario file: {reason}")]
    Scenario {
        /// What is wrong, with its place.
        reason: String,
    },
    /// A derivative name is not a body-axes coefficient with a known term.
    #[error(
        "derivative '{name}': {reason}; write a coefficient of CX CY CZ Cl Cm Cn, an underscore and a term, as in Cm_alpha or CX_alpha^2"
    )]
    BadDerivative {
        /// Name as given.
        name: String,
        /// What was not understood.
        reason: String,
    },
    /// A derivative is given twice.
    #[error("derivative '{name}' is given twice: remove one")]
    RepeatedDerivative {
        /// Its name.
        name: String,
    },
    /// An airframe cannot be flown.
    #[error("aircraft '{name}': {reason}")]
    Aircraft {
        /// Its name.
        name: String,
        /// What is wrong.
        reason: String,
    },
    /// The equations of steady flight have no solution near a sensible attitude.
    #[error(
        "no trim at {airspeed_m_s:.1} m/s and {altitude_m:.0} m: {worst} is still {residual:.2e} {unit} after {iterations} steps; choose a speed nearer the middle of the envelope"
    )]
    TrimNotFound {
        /// True airspeed, m/s.
        airspeed_m_s: f64,
        /// Altitude, m.
        altitude_m: f64,
        /// Equation with the largest residual.
        worst: &'static str,
        /// Its residual.
        residual: f64,
        /// Unit of the residual.
        unit: &'static str,
        /// Newton steps taken.
        iterations: usize,
    },
    /// Steady flight needs more angle of attack than the truth holds for.
    #[error(
        "no trim at {airspeed_m_s:.1} m/s and {altitude_m:.0} m: it needs an angle of attack of {needed_deg:.1} deg, the derivatives hold from {low_deg:.1} to {high_deg:.1} deg; fly faster or lighter"
    )]
    TrimPastAlpha {
        /// True airspeed, m/s.
        airspeed_m_s: f64,
        /// Altitude, m.
        altitude_m: f64,
        /// Angle of attack, deg.
        needed_deg: f64,
        /// Lower end, deg.
        low_deg: f64,
        /// Upper end, deg.
        high_deg: f64,
    },
    /// Steady flight needs more thrust than the engines give.
    #[error(
        "no trim at {airspeed_m_s:.1} m/s and {altitude_m:.0} m: it needs {needed_n:.0} N of thrust per engine, at {rpm:.0} rpm there are {available_n:.0} N ({missing_n:.0} N short); fly slower or lower"
    )]
    TrimPastThrust {
        /// True airspeed, m/s.
        airspeed_m_s: f64,
        /// Altitude, m.
        altitude_m: f64,
        /// Thrust needed per engine, N.
        needed_n: f64,
        /// Engine speed, rpm.
        rpm: f64,
        /// Thrust at full throttle, N.
        available_n: f64,
        /// What is missing, N.
        missing_n: f64,
    },
    /// A deflection lies past the surface's stop.
    #[error(
        "{what}: {surface} needs {needed_deg:.2} deg, its stops are {low_deg:.1} and {high_deg:.1} deg ({past_deg:.2} deg past); reduce the amplitude or change the condition"
    )]
    PastStop {
        /// Input or condition that asks for it.
        what: String,
        /// Surface.
        surface: &'static str,
        /// Deflection, deg.
        needed_deg: f64,
        /// Lower stop, deg.
        low_deg: f64,
        /// Upper stop, deg.
        high_deg: f64,
        /// How far past the nearer stop, deg.
        past_deg: f64,
    },
    /// The aircraft left the range the truth holds for.
    #[error("at {time_s:.2} s: {what} is {value:.3}, outside {low:.3} to {high:.3}; change the scenario")]
    LeftEnvelope {
        /// Time, s.
        time_s: f64,
        /// Quantity with unit.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Lower limit.
        low: f64,
        /// Upper limit.
        high: f64,
    },
    /// Fewer harmonics than controls.
    #[error("multisines for {controls} controls need at least that many harmonics, {first} to {last} are too few")]
    TooFewHarmonics {
        /// First harmonic.
        first: u32,
        /// Last harmonic.
        last: u32,
        /// Number of controls.
        controls: usize,
    },
    /// No scenario of that name.
    #[error("unknown scenario '{name}': use one of {}", known.join(", "))]
    UnknownScenario {
        /// Name as given.
        name: String,
        /// Scenarios there are.
        known: Vec<&'static str>,
    },
    /// Air data outside the atmosphere's range, or a map that cannot be read.
    #[error("{what}: {reason}")]
    Model {
        /// Model that refused.
        what: &'static str,
        /// Its own message.
        reason: String,
    },
    /// A recorded file could not be encoded.
    #[error("cannot encode {file}: {reason}")]
    Encode {
        /// File.
        file: String,
        /// Why.
        reason: String,
    },
    /// The caller asked to stop.
    #[error("stopped at {time_s:.0} s of the flight")]
    Cancelled {
        /// Simulated time reached, s.
        time_s: f64,
    },
}
