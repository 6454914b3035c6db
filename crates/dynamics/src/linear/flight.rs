//! An identified aircraft in steady flight: what it is, the condition, and its equations of motion.

use doublet_core::airframe::{MassProperties, ReferenceGeometry};
use doublet_core::atmos::{Atmosphere, AtmosphereError};
use doublet_core::model::{Axes, Derivatives, Position, RecordedValues, ThrustTreatment, Variable};
use doublet_core::motion::{FactoredInertia, State};
use doublet_core::replay::{Forces, Instant, MotionAxis, Sample};
use nalgebra::{Matrix3, SVector, Vector3};
use serde::{Deserialize, Serialize};

use super::LinearError;

/// States of the whole motion: `u v w p q r phi theta psi north east h`.
pub const STATES: usize = 12;
/// Names of the states, in their order.
pub const STATE_NAMES: [&str; STATES] = ["u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "north", "east", "h"];
/// Inputs: aileron, elevator, rudder, thrust at the airspeed of the condition.
pub const INPUTS: usize = 4;
/// Names and units of the inputs, in their order. `thrust` is the thrust at the airspeed of the condition: what acts differs by
/// [`Condition::thrust_n`].
pub const INPUT_NAMES: [(&str, &str); INPUTS] =
    [("delta_a", "rad"), ("delta_e", "rad"), ("delta_r", "rad"), ("thrust", "N")];
/// Values of the states: m/s, rad/s, rad, m.
pub(crate) type StateVector = SVector<f64, STATES>;
/// Values of the inputs: rad, N.
pub(crate) type InputVector = SVector<f64, INPUTS>;

/// Line of action of one engine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ThrustLine {
    /// A point of it.
    pub position: Position,
    /// Unit vector of the thrust in body axes.
    pub direction_body: [f64; 3],
    /// Share of the sum of the thrusts.
    pub share: f64,
}

/// An aircraft with derivatives: everything about it that does not change with the condition.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct FlightModel {
    pub derivatives: Derivatives,
    /// Reference area and lengths.
    pub reference: ReferenceGeometry,
    /// Axes of moments and rates.
    pub axes: Axes,
    /// Point the moments are about; none for the centre of gravity wherever it is.
    pub moment_reference: Option<Position>,
    /// What of the thrust is inside the coefficients.
    pub thrust: ThrustTreatment,
    pub engines: Vec<ThrustLine>,
}

impl FlightModel {
    /// Motion its coefficients can fly: both, or the longitudinal where only that is modelled.
    ///
    /// # Errors
    /// [`LinearError::NoCoefficient`] where CX, CZ (or CD, CL) and Cm are not all there, which every trim needs.
    pub fn motion(&self) -> Result<MotionAxis, LinearError> {
        let missing = self.derivatives.missing();
        let longitudinal = missing.iter().filter(|&&coefficient| MotionAxis::Longitudinal.has(coefficient));
        let names: Vec<_> = longitudinal.map(|coefficient| coefficient.name()).collect();
        if !names.is_empty() {
            return Err(LinearError::NoCoefficient { missing: names });
        }
        Ok(if missing.is_empty() { MotionAxis::Both } else { MotionAxis::Longitudinal })
    }

    /// Whether the thrust moves the aircraft of this model, so that a trim can ask for it.
    pub fn has_thrust(&self) -> bool {
        let outside = self.thrust != ThrustTreatment::Included && !self.engines.is_empty();
        outside || self.derivatives.term_of(Variable::ThrustCoefficient).is_some()
    }
}

/// Steady flight that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SteadyFlight {
    /// Straight.
    Straight,
    /// Coordinated turn to the right at this load factor, above 1.
    Turn(f64),
    /// Pull-up (above 1) or push-over (below) with the wings level at this load factor; pitch angle and speed pass through those of
    /// the trim.
    PullUp(f64),
}

/// A condition to trim and linearise at.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct Condition {
    /// True airspeed, m/s.
    pub airspeed_m_s: f64,
    pub altitude_m: f64,
    /// Air density there, kg/m³; about it the density changes as that of the standard atmosphere.
    pub density_kg_m3: f64,
    /// Speed of sound there, m/s.
    pub speed_of_sound_m_s: f64,
    pub gravity_m_s2: f64,
    /// Angle of the flight path, rad; none where it follows from the power the coefficients contain.
    pub gamma_rad: Option<f64>,
    /// Straight, turn or pull-up.
    pub flight: SteadyFlight,
    /// Mass, centre of gravity and inertia.
    pub mass: MassProperties,
    /// Change of the sum of the thrusts with airspeed at constant power setting, N s/m.
    pub thrust_slope_n_s_m: f64,
    /// Total-pressure rise through the propellers, Pa.
    pub pressure_rise_pa: f64,
    /// Angular momentum of the rotors along body x, kg m²/s.
    pub rotor_momentum_n_m_s: f64,
    /// Flaps, trims and what else the model takes as recorded: held.
    pub recorded: RecordedValues,
}

/// Equations of motion of a model at a condition.
pub(crate) struct Equations<'a> {
    pub model: &'a FlightModel,
    pub condition: &'a Condition,
    pub forces: Forces<'a>,
    pub inertia: FactoredInertia,
    /// Force and moment of the engines, each per newton of thrust.
    pub thrust_force: Vector3<f64>,
    pub thrust_moment_m: Vector3<f64>,
    /// Moment reference from the centre of gravity in body axes, m.
    pub arm_m: Vector3<f64>,
}

impl<'a> Equations<'a> {
    pub fn new(model: &'a FlightModel, condition: &'a Condition) -> Result<Self, LinearError> {
        for (quantity, value) in [
            ("airspeed", condition.airspeed_m_s),
            ("air density", condition.density_kg_m3),
            ("mass", condition.mass.mass_kg),
            ("gravity", condition.gravity_m_s2),
            ("speed of sound", condition.speed_of_sound_m_s),
        ] {
            if value.is_nan() || value <= 0.0 {
                return Err(LinearError::NotPositive { quantity, value });
            }
        }
        let cg = condition.mass.cg_from_datum_m;
        let (mut thrust_force, mut thrust_moment_m) = (Vector3::zeros(), Vector3::zeros());
        for engine in &model.engines {
            let force = Vector3::from(engine.direction_body) * engine.share;
            thrust_force += force;
            thrust_moment_m += Vector3::from(engine.position.body_from_cg_m(cg)).cross(&force);
        }
        match model.thrust {
            ThrustTreatment::Included => (thrust_force, thrust_moment_m) = Default::default(),
            ThrustTreatment::ForceRemoved => thrust_moment_m = Vector3::zeros(),
            ThrustTreatment::Removed => {}
        }
        Ok(Self {
            forces: Forces::new(&model.derivatives, model.reference, model.axes, condition.gravity_m_s2),
            inertia: FactoredInertia::new(&condition.mass.inertia).ok_or(LinearError::Inertia)?,
            arm_m: model.moment_reference.map_or([0.0; 3], |point| point.body_from_cg_m(cg)).into(),
            model,
            condition,
            thrust_force,
            thrust_moment_m,
        })
    }

    /// Air density at an altitude, kg/m³, and its slope: that of the condition, changing as the standard atmosphere's does; constant
    /// outside the troposphere.
    pub fn density(&self, altitude_m: f64) -> (f64, f64) {
        let (ratio, slope) = ratio_and_slope(Atmosphere::density_kg_m3, altitude_m, self.condition.altitude_m);
        (self.condition.density_kg_m3 * ratio, self.condition.density_kg_m3 * slope)
    }

    /// Speed of sound at an altitude, m/s, and its slope, alike.
    pub(crate) fn speed_of_sound(&self, altitude_m: f64) -> (f64, f64) {
        let (ratio, slope) = ratio_and_slope(Atmosphere::speed_of_sound_m_s, altitude_m, self.condition.altitude_m);
        (self.condition.speed_of_sound_m_s * ratio, self.condition.speed_of_sound_m_s * slope)
    }

    /// What acts beside the motion.
    pub fn sample(&self, airspeed_m_s: f64, altitude_m: f64, input: &InputVector) -> Sample {
        let condition = self.condition;
        let thrust_n = condition.thrust_n(input[3], airspeed_m_s);
        Sample {
            controls_rad: [input[0], input[1], input[2]],
            recorded: condition.recorded,
            density_kg_m3: self.density(altitude_m).0,
            speed_of_sound_m_s: self.speed_of_sound(altitude_m).0,
            wind_ned_m_s: Vector3::zeros(),
            thrust_n,
            thrust_force_n: self.thrust_force * thrust_n,
            thrust_moment_n_m: self.thrust_moment_m * thrust_n,
            pressure_rise_pa: condition.pressure_rise_pa,
            rotor_momentum_n_m_s: Vector3::new(condition.rotor_momentum_n_m_s, 0.0, 0.0),
            reference_arm_m: self.arm_m,
            mass_kg: condition.mass.mass_kg,
            inertia: self.inertia,
            disturbance: [0.0; 6],
        }
    }

    /// Rates of the states, in their units per second, and the specific force, m/s².
    pub fn rates(&self, state: &StateVector, input: &InputVector) -> (StateVector, Vector3<f64>) {
        self.rates_in_gust(state, input, &Vector3::zeros())
    }

    /// The same in air that moves by a gust in body axes, m/s: `u v w` are then the velocity over the ground.
    pub(crate) fn rates_in_gust(
        &self,
        state: &StateVector,
        input: &InputVector,
        gust_body_m_s: &Vector3<f64>,
    ) -> (StateVector, Vector3<f64>) {
        let velocity = Vector3::new(state[0], state[1], state[2]);
        let rates = Vector3::new(state[3], state[4], state[5]);
        let euler = [state[6], state[7], state[8]];
        let body_from_ned = body_from_ned(euler);
        let flow = velocity - gust_body_m_s;
        let instant = Instant { velocity_body_m_s: flow, rates_rad_s: rates, body_from_ned, altitude_m: state[11] };
        let sample = self.sample(flow.norm(), state[11], input);
        let loads = self.forces.loads(&instant, &sample, [None; 3]);
        let gravity = body_from_ned.column(2) * self.condition.gravity_m_s2;
        let acceleration = loads.specific_force_m_s2 + gravity - rates.cross(&velocity);
        let angular = self.inertia.angular_acceleration(loads.moment_n_m, rates, sample.rotor_momentum_n_m_s);
        let [(sin_phi, cos_phi), (sin_theta, cos_theta)] = [euler[0], euler[1]].map(f64::sin_cos);
        let turning = rates.y * sin_phi + rates.z * cos_phi;
        let path = body_from_ned.tr_mul(&velocity);
        let rate = StateVector::from([
            acceleration.x,
            acceleration.y,
            acceleration.z,
            angular.x,
            angular.y,
            angular.z,
            rates.x + turning * sin_theta / cos_theta,
            rates.y * cos_phi - rates.z * sin_phi,
            turning / cos_theta,
            path.x,
            path.y,
            -path.z,
        ]);
        (rate, loads.specific_force_m_s2)
    }
}

/// A quantity of the standard atmosphere over altitude.
type OverAltitude = fn(&Atmosphere, f64) -> Result<f64, AtmosphereError>;

/// Value of the standard atmosphere at an altitude over that at another; `None` outside its troposphere.
fn standard_ratio(of: OverAltitude, altitude_m: f64, from_m: f64) -> Option<f64> {
    Some(of(&Atmosphere::STANDARD, altitude_m).ok()? / of(&Atmosphere::STANDARD, from_m).ok()?)
}

/// That ratio and its slope, 1/m; one and zero outside.
fn ratio_and_slope(of: OverAltitude, altitude_m: f64, from_m: f64) -> (f64, f64) {
    /// Half the interval of the slope, m.
    const HALF_M: f64 = 10.0;
    let at = |altitude_m: f64| standard_ratio(of, altitude_m, from_m);
    let slope = at(altitude_m + HALF_M).zip(at(altitude_m - HALF_M)).map_or(0.0, |(a, b)| (a - b) / (2.0 * HALF_M));
    (at(altitude_m).unwrap_or(1.0), slope)
}

impl Condition {
    /// Thrust acting at an airspeed, N, of a power setting that gives `at_condition_n` at the airspeed of the condition.
    pub fn thrust_n(&self, at_condition_n: f64, airspeed_m_s: f64) -> f64 {
        at_condition_n + self.thrust_slope_n_s_m * (airspeed_m_s - self.airspeed_m_s)
    }

    /// The condition at another altitude, density and speed of sound changed as those of the standard atmosphere; unchanged air where
    /// that ends.
    #[must_use]
    pub fn at_altitude(&self, altitude_m: f64) -> Self {
        let ratio = |of: OverAltitude| standard_ratio(of, altitude_m, self.altitude_m).unwrap_or(1.0);
        Self {
            altitude_m,
            density_kg_m3: self.density_kg_m3 * ratio(Atmosphere::density_kg_m3),
            speed_of_sound_m_s: self.speed_of_sound_m_s * ratio(Atmosphere::speed_of_sound_m_s),
            ..*self
        }
    }
}

/// Rotation from local Earth to body axes.
pub(super) fn body_from_ned(euler_rad: [f64; 3]) -> Matrix3<f64> {
    State::new(Vector3::zeros(), Vector3::zeros(), euler_rad).body_from_ned()
}
