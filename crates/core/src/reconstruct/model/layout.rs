//! The one place that knows the order of states, inputs and measurements.
//!
//! Elsewhere they go by name: `State::RollAngle as usize` is the index, [`State::name`] the label.

use crate::quantity::{Role, named_quantities};

/// Number of states.
pub const STATES: usize = 18;
/// Number of inputs (inertial measurements), which is also the number of process noises.
pub const INPUTS: usize = 6;
/// Number of measurements.
pub const MEASUREMENTS: usize = 12;
/// Number of air-data states, estimated only where the settings ask for them.
pub const AIR_STATES: usize = 5;

/// Number of states of the augmented model: those of [`State`], then those of [`AirState`].
pub(crate) const AUGMENTED_STATES: usize = STATES + AIR_STATES;

/// Number of groups of three states, which the blocks of the packed filter go by.
pub(crate) const GROUPS: usize = STATES / 3;
/// Group of position.
pub(crate) const POS: usize = 0;
/// Group of velocity.
pub(crate) const VEL: usize = 1;
/// Group of attitude.
pub(crate) const ATT: usize = 2;
/// Group of accelerometer biases.
pub(crate) const ACC: usize = 3;
/// Group of gyro biases.
pub(crate) const GYR: usize = 4;
/// Group of wind.
pub const WIND: usize = 5;

/// Number of groups of three measurements.
pub(crate) const TRIPLES: usize = MEASUREMENTS / 3;
/// Measured position.
pub(crate) const POSITION: usize = 0;
/// Measured ground velocity.
pub(crate) const GROUND: usize = 1;
/// Measured attitude.
pub const ATTITUDE: usize = 2;
/// Airspeed, angle of attack, sideslip.
pub const AIR: usize = 3;

named_quantities! {
    /// State vector of the reconstruction (thesis Eq. 3.4, in the order position, velocity, attitude, biases, wind).
    State;
    PositionNorth, "x", Length, "position north of the local origin";
    PositionEast, "y", Length, "position east of the local origin";
    PositionDown, "z", Length, "position below the local origin";
    VelocityU, "u", Speed, "airspeed component along body x";
    VelocityV, "v", Speed, "airspeed component along body y";
    VelocityW, "w", Speed, "airspeed component along body z";
    BankAngle, "phi", Angle, "bank angle";
    PitchAngle, "theta", Angle, "pitch angle";
    HeadingAngle, "psi", Angle, "heading angle";
    BiasAx, "bias_ax", Acceleration, "bias of the accelerometer along body x";
    BiasAy, "bias_ay", Acceleration, "bias of the accelerometer along body y";
    BiasAz, "bias_az", Acceleration, "bias of the accelerometer along body z";
    BiasP, "bias_p", AngularRate, "bias of the roll gyro";
    BiasQ, "bias_q", AngularRate, "bias of the pitch gyro";
    BiasR, "bias_r", AngularRate, "bias of the yaw gyro";
    WindNorth, "wind_north", Speed, "wind velocity towards north";
    WindEast, "wind_east", Speed, "wind velocity towards east";
    WindDown, "wind_down", Speed, "wind velocity downwards";
}

named_quantities! {
    /// Errors of the air data, constant over a window: `airspeed = (1 + airspeed_scale) V`,
    /// `alpha = (1 + upwash) atan(w / u) + alpha_offset`, `beta = (1 + sidewash) asin(v / V) + beta_offset`
    /// (Klein & Morelli 2006, chapter 10).
    AirState;
    AlphaOffset, "alpha_offset", Angle, "offset of the measured angle of attack";
    BetaOffset, "beta_offset", Angle, "offset of the measured sideslip";
    Upwash, "upwash", Dimensionless, "upwash factor of the measured angle of attack";
    AirspeedScale, "airspeed_scale", Dimensionless, "scale error of the measured airspeed";
    Sidewash, "sidewash", Dimensionless, "sidewash factor of the measured sideslip";
}

named_quantities! {
    /// Input vector: what the inertial unit measures (thesis Eq. 3.5), biased and noisy.
    Input;
    SpecificForceX, "ax", Acceleration, "specific force along body x";
    SpecificForceY, "ay", Acceleration, "specific force along body y";
    SpecificForceZ, "az", Acceleration, "specific force along body z";
    RollRate, "p", AngularRate, "roll rate";
    PitchRate, "q", AngularRate, "pitch rate";
    YawRate, "r", AngularRate, "yaw rate";
}

named_quantities! {
    /// Measurement vector (thesis Eq. 3.6).
    Measurement;
    PositionNorth, "x", Length, "position north";
    PositionEast, "y", Length, "position east";
    PositionDown, "z", Length, "position down";
    VelocityNorth, "v_north", Speed, "ground velocity north";
    VelocityEast, "v_east", Speed, "ground velocity east";
    VelocityDown, "v_down", Speed, "ground velocity down";
    BankAngle, "phi", Angle, "bank angle";
    PitchAngle, "theta", Angle, "pitch angle";
    HeadingAngle, "psi", Angle, "heading angle";
    Airspeed, "airspeed", Speed, "true airspeed";
    AngleOfAttack, "alpha", Angle, "angle of attack";
    Sideslip, "beta", Angle, "angle of sideslip";
}

impl Input {
    /// The recorded role that feeds this input.
    pub fn role(self) -> Role {
        match self {
            Self::SpecificForceX => Role::SpecificForceX,
            Self::SpecificForceY => Role::SpecificForceY,
            Self::SpecificForceZ => Role::SpecificForceZ,
            Self::RollRate => Role::RollRate,
            Self::PitchRate => Role::PitchRate,
            Self::YawRate => Role::YawRate,
        }
    }
}

impl Measurement {
    /// The recorded role that feeds this measurement.
    pub fn role(self) -> Role {
        match self {
            Self::PositionNorth => Role::PositionNorth,
            Self::PositionEast => Role::PositionEast,
            Self::PositionDown => Role::PositionDown,
            Self::VelocityNorth => Role::VelocityNorth,
            Self::VelocityEast => Role::VelocityEast,
            Self::VelocityDown => Role::VelocityDown,
            Self::BankAngle => Role::BankAngle,
            Self::PitchAngle => Role::PitchAngle,
            Self::HeadingAngle => Role::HeadingAngle,
            Self::Airspeed => Role::TrueAirspeed,
            Self::AngleOfAttack => Role::AngleOfAttack,
            Self::Sideslip => Role::Sideslip,
        }
    }
}
