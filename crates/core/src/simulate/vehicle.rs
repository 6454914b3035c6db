//! The aircraft in flight: loads from air, engines and ground.

use nalgebra::Vector3;
use serde::Deserialize;

use super::SimulateError;
use super::aero::{AeroModel, DerivativeEntry};
use super::gear::{Gear, GearData};
use crate::airframe::{Aircraft, Loading, MassProperties, ReferenceGeometry, frames};
use crate::atmos::Atmosphere;
use crate::model::{Variable, VariableValues};
use crate::motion::{Airflow, FactoredInertia, Rate, State};
use crate::propulsion::{Ambient, EngineInput, Powerplant, RotorSum};
use crate::toml_error;

/// Deflections of the three controls, rad, signs of `docs/conventions.md`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct Controls {
    pub aileron: f64,
    pub elevator: f64,
    pub rudder: f64,
}

/// A control surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "names say it")]
pub enum Surface {
    Aileron,
    Elevator,
    Rudder,
}

impl Surface {
    crate::named_variants! {
        /// Name in messages and files.
        pub name: Aileron "aileron", Elevator "elevator", Rudder "rudder"
    }
}

impl Controls {
    /// The deflection that `of` gives each surface, rad.
    pub fn each(of: impl Fn(Surface) -> f64) -> Self {
        Self { aileron: of(Surface::Aileron), elevator: of(Surface::Elevator), rudder: of(Surface::Rudder) }
    }

    /// Deflections at a fraction of the way in a straight line to `end`.
    pub(crate) fn toward(&self, end: &Self, fraction: f64) -> Self {
        Self::each(|surface| self.get(surface) + fraction * (end.get(surface) - self.get(surface)))
    }

    /// Deflections half way from here to `end` along the parabola through `before`, as long before as `end` is after.
    pub fn half_way(&self, before: &Self, end: &Self) -> Self {
        Self::each(|surface| (3.0 * end.get(surface) + 6.0 * self.get(surface) - before.get(surface)) / 8.0)
    }

    /// Deflection of one surface, rad.
    pub fn get(&self, surface: Surface) -> f64 {
        match surface {
            Surface::Aileron => self.aileron,
            Surface::Elevator => self.elevator,
            Surface::Rudder => self.rudder,
        }
    }

    /// Deflection of one surface, to change it.
    pub fn get_mut(&mut self, surface: Surface) -> &mut f64 {
        match surface {
            Surface::Aileron => &mut self.aileron,
            Surface::Elevator => &mut self.elevator,
            Surface::Rudder => &mut self.rudder,
        }
    }
}

/// Stops of the controls: least and greatest deflection, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct Stops {
    pub aileron: (f64, f64),
    pub elevator: (f64, f64),
    pub rudder: (f64, f64),
}

impl Stops {
    /// Stops of one surface, rad.
    pub fn get(&self, surface: Surface) -> (f64, f64) {
        match surface {
            Surface::Aileron => self.aileron,
            Surface::Elevator => self.elevator,
            Surface::Rudder => self.rudder,
        }
    }

    /// Deflections held within the stops.
    pub fn limit(&self, controls: Controls) -> Controls {
        Controls::each(|surface| {
            let (low, high) = self.get(surface);
            controls.get(surface).clamp(low, high)
        })
    }

    /// Refuses a deflection past the stops.
    ///
    /// # Errors
    /// [`SimulateError::PastStop`] with how far past; `what` says who asks for it.
    pub fn check(&self, surface: Surface, deflection_rad: f64, what: &str) -> Result<(), SimulateError> {
        let (low, high) = self.get(surface);
        let past = (low - deflection_rad).max(deflection_rad - high);
        if past <= 0.0 {
            return Ok(());
        }
        Err(SimulateError::PastStop {
            what: what.to_owned(),
            surface: surface.name(),
            needed_deg: deflection_rad.to_degrees(),
            low_deg: low.to_degrees(),
            high_deg: high.to_degrees(),
            past_deg: past.to_degrees(),
        })
    }
}

/// An aircraft with an aerodynamic truth, ready to fly.
#[derive(Clone, Debug, PartialEq)]
pub struct Vehicle {
    /// Geometry, stations and masses.
    pub aircraft: Aircraft,
    /// Engines and propellers.
    pub powerplant: Powerplant,
    /// Aerodynamic derivatives.
    pub aero: AeroModel,
    /// Angle of attack the derivatives hold for, rad.
    pub alpha_range_rad: (f64, f64),
    /// Stops of the controls.
    pub stops: Stops,
    /// Landing gear.
    pub gear: Gear,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TruthFile {
    name: String,
    #[serde(rename = "description")]
    _description: String,
    alpha_range_deg: (f64, f64),
    stops_deg: StopsTable,
    gear: GearData,
    derivative: Vec<DerivativeEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StopsTable {
    aileron: (f64, f64),
    elevator: (f64, f64),
    rudder: (f64, f64),
}

impl Vehicle {
    /// An aircraft with the truth of a truth file (TOML).
    ///
    /// # Errors
    /// [`SimulateError::Truth`] where the file is not one, [`SimulateError::BadDerivative`] and
    /// [`SimulateError::RepeatedDerivative`] for a derivative, [`SimulateError::Aircraft`] without two engines with maps.
    pub fn new(aircraft: Aircraft, powerplant: Powerplant, truth: &str) -> Result<Self, SimulateError> {
        let file: TruthFile = toml::from_str(truth).map_err(|error| SimulateError::Truth {
            name: "file".into(),
            reason: toml_error::one_line(truth, &error),
        })?;
        if powerplant.engines.len() != 2 || powerplant.engines.iter().any(|engine| engine.model.is_none()) {
            let reason =
                format!("{} engines; two, each with chart and propeller map, are needed", powerplant.engines.len());
            return Err(SimulateError::Aircraft { name: aircraft.name, reason });
        }
        let radians = |(low, high): (f64, f64)| (low.to_radians(), high.to_radians());
        let alpha_range_rad = radians(file.alpha_range_deg);
        let stops = Stops {
            aileron: radians(file.stops_deg.aileron),
            elevator: radians(file.stops_deg.elevator),
            rudder: radians(file.stops_deg.rudder),
        };
        for (what, (low, high)) in [
            ("alpha_range_deg", alpha_range_rad),
            ("aileron stops", stops.aileron),
            ("elevator stops", stops.elevator),
            ("rudder stops", stops.rudder),
        ] {
            if low.partial_cmp(&high) != Some(std::cmp::Ordering::Less) {
                let reason = format!("{what}: the lower limit must be below the upper one");
                return Err(SimulateError::Truth { name: file.name, reason });
            }
        }
        Ok(Self {
            aircraft,
            powerplant,
            aero: AeroModel::new(file.derivative)?,
            alpha_range_rad,
            stops,
            gear: Gear::new(&file.gear),
        })
    }

    /// Mass, inertia and arms of the aircraft as loaded.
    ///
    /// # Errors
    /// [`SimulateError::Aircraft`] when the loading is impossible.
    pub fn body(&self, loading: &Loading) -> Result<Body, SimulateError> {
        let properties = loading.mass_properties(&self.aircraft);
        let impossible = loading.issues(&self.aircraft, &properties);
        let impossible = impossible.iter().find(|issue| issue.is_impossible()).map(ToString::to_string);
        let refuse = |reason| SimulateError::Aircraft { name: self.aircraft.name.clone(), reason };
        if let Some(reason) = impossible {
            return Err(refuse(reason));
        }
        let inertia = FactoredInertia::new(&properties.inertia)
            .ok_or_else(|| refuse("its inertia tensor is not positive definite".into()))?;
        let cg = properties.cg_from_datum_m;
        let hubs = [0, 1].map(|engine| {
            Vector3::from(frames::body_from_datum(self.powerplant.engines[engine].station.position_from_datum_m, cg))
        });
        let wheels = self.gear.arms(cg);
        Ok(Body { properties, inertia, hubs, wheels })
    }

    /// Reference geometry.
    pub fn reference(&self) -> &ReferenceGeometry {
        &self.aircraft.reference
    }

    /// Thrust of one engine and its slope over airspeed at a condition; the slope lets the thrust follow the airspeed
    /// between two looks at the maps.
    pub fn thrust(&self, engine: usize, input: EngineInput, ambient: &Ambient) -> Thrust {
        /// Half the interval the slope is taken over, m/s.
        const HALF_STEP_M_S: f64 = 0.5;
        let Some(model) = self.powerplant.engines.get(engine).and_then(|engine| engine.model.as_ref()) else {
            return Thrust::default();
        };
        let at = |airspeed_m_s: f64| model.state(input, &Ambient { airspeed_m_s: airspeed_m_s.max(0.1), ..*ambient });
        let state = at(ambient.airspeed_m_s);
        let ahead = at(ambient.airspeed_m_s + HALF_STEP_M_S).thrust_n;
        let behind = at(ambient.airspeed_m_s - HALF_STEP_M_S).thrust_n;
        Thrust {
            force_n: state.thrust_n,
            per_airspeed_n_s_m: (ahead - behind) / (2.0 * HALF_STEP_M_S),
            at_airspeed_m_s: ambient.airspeed_m_s,
            power_w: state.power_w,
        }
    }

    /// Loads on the aircraft in a state.
    pub fn loads(&self, body: &Body, state: &State, environment: &Environment) -> Loads {
        let body_from_ned = state.body_from_ned();
        let air_velocity = body_from_ned * (state.velocity_ned_m_s - environment.wind_ned_m_s);
        let air = Airflow::new(air_velocity, environment.density_kg_m3);
        let coefficients = self.aero.coefficients(&self.variables(state, &air, environment));
        let reference = self.reference();
        let qs = air.dynamic_pressure_pa * reference.area_m2;
        let [cx, cy, cz, cl, cm, cn] = coefficients;
        let lateral = qs * reference.lateral_moment_length_m;
        let aero_force_n = Vector3::new(cx, cy, cz) * qs;
        let aero_moment_n_m = Vector3::new(cl * lateral, cm * qs * reference.chord_m, cn * lateral);
        let thrust_n = environment.thrust.map(|thrust| thrust.at(air.airspeed_m_s));
        let (mut thrust_force_n, mut thrust_moment_n_m) = (Vector3::zeros(), Vector3::zeros());
        for engine in 0..2 {
            let force = environment.thrust_axis[engine] * thrust_n[engine];
            thrust_force_n += force;
            thrust_moment_n_m += body.hubs[engine].cross(&force);
        }
        let (ground_force_n, ground_moment_n_m) = self.gear.loads(&body.wheels, state, &body_from_ned, environment);
        let force = aero_force_n + thrust_force_n + ground_force_n;
        let moment = aero_moment_n_m + thrust_moment_n_m + ground_moment_n_m;
        let specific_force_m_s2 = force / body.properties.mass_kg;
        let angular_acceleration_rad_s2 =
            body.inertia.angular_acceleration(moment, state.rates_rad_s, environment.rotor_momentum_n_m_s);
        let mut acceleration_ned_m_s2 = body_from_ned.tr_mul(&specific_force_m_s2);
        acceleration_ned_m_s2.z += environment.gravity_m_s2;
        Loads {
            air,
            coefficients,
            aero_force_n,
            aero_moment_n_m,
            thrust_n,
            thrust_moment_n_m,
            ground_force_n,
            ground_moment_n_m,
            specific_force_m_s2,
            acceleration_ned_m_s2,
            angular_acceleration_rad_s2,
        }
    }

    /// Values of all variables the truth may depend on; those it may not are zero.
    fn variables(&self, state: &State, air: &Airflow, environment: &Environment) -> VariableValues {
        let reference = self.reference();
        let per_airspeed = 1.0 / air.airspeed_m_s.max(SLOWEST_M_S);
        let lateral = reference.lateral_rate_length_m * per_airspeed;
        let mut values = [0.0; Variable::ALL.len()];
        let mut set = |variable: Variable, value: f64| values[variable as usize] = value;
        set(Variable::Alpha, air.alpha_rad);
        set(Variable::Beta, air.beta_rad);
        set(Variable::RollRate, state.rates_rad_s.x * lateral);
        set(Variable::PitchRate, state.rates_rad_s.y * reference.pitch_rate_length_m * per_airspeed);
        set(Variable::HalfPitchRate, 0.5 * state.rates_rad_s.y * reference.chord_m * per_airspeed);
        set(Variable::YawRate, state.rates_rad_s.z * lateral);
        set(Variable::Aileron, environment.controls.aileron);
        set(Variable::Elevator, environment.controls.elevator);
        set(Variable::Rudder, environment.controls.rudder);
        set(Variable::Airspeed, air.airspeed_m_s);
        set(Variable::Altitude, -state.position_ned_m.z);
        set(Variable::Mach, air.airspeed_m_s / environment.speed_of_sound_m_s);
        let thrust: f64 = environment.thrust.iter().map(|thrust| thrust.at(air.airspeed_m_s)).sum();
        set(Variable::ThrustCoefficient, thrust / (air.dynamic_pressure_pa.max(1.0) * reference.area_m2));
        values
    }
}

/// Airspeed below which the rates without dimension stop growing, m/s: the aircraft is on the ground there.
const SLOWEST_M_S: f64 = 5.0;

/// Mass, inertia and arms for one loading.
#[derive(Clone, Debug)]
pub struct Body {
    /// Mass, centre of gravity and inertia.
    pub properties: MassProperties,
    /// Factored inertia.
    pub inertia: FactoredInertia,
    hubs: [Vector3<f64>; 2],
    wheels: [Vector3<f64>; 3],
}

/// Thrust of one engine about an airspeed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Thrust {
    /// Thrust at `at_airspeed_m_s`, N.
    pub force_n: f64,
    /// Slope over airspeed, N s/m.
    pub per_airspeed_n_s_m: f64,
    /// Airspeed it holds for, m/s.
    pub at_airspeed_m_s: f64,
    /// Brake power, W.
    pub power_w: f64,
}

impl Thrust {
    /// Thrust at an airspeed near that one, N.
    pub fn at(&self, airspeed_m_s: f64) -> f64 {
        self.force_n + self.per_airspeed_n_s_m * (airspeed_m_s - self.at_airspeed_m_s)
    }
}

/// What acts on the aircraft beside its own motion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct Environment {
    /// Deflections.
    pub controls: Controls,
    /// Thrust of the engines.
    pub thrust: [Thrust; 2],
    /// Direction of their thrust in body axes.
    pub thrust_axis: [Vector3<f64>; 2],
    /// Angular momentum of the rotors in body axes, signed, kg m²/s.
    pub rotor_momentum_n_m_s: Vector3<f64>,
    /// Velocity of the air over the ground, m/s.
    pub wind_ned_m_s: Vector3<f64>,
    /// Air density, kg/m³.
    pub density_kg_m3: f64,
    pub speed_of_sound_m_s: f64,
    pub gravity_m_s2: f64,
    /// Altitude of the ground, m.
    pub ground_m: f64,
    /// Wheel brakes, 0 to 1.
    pub brake: f64,
    /// Nose wheel angle, positive to the right, rad.
    pub steering_rad: f64,
}

impl Environment {
    /// Still air of `atmosphere` at `altitude_m`, engines stopped, controls neutral.
    ///
    /// # Errors
    /// [`SimulateError::Model`] outside the atmosphere's range.
    pub fn still(vehicle: &Vehicle, atmosphere: &Atmosphere, altitude_m: f64) -> Result<Self, SimulateError> {
        let mut thrust_axis = [Vector3::x(); 2];
        for (axis, engine) in thrust_axis.iter_mut().zip(&vehicle.powerplant.engines) {
            *axis = engine.thrust_direction_body();
        }
        let mut environment = Self {
            controls: Controls::default(),
            thrust: [Thrust::default(); 2],
            thrust_axis,
            rotor_momentum_n_m_s: Vector3::zeros(),
            wind_ned_m_s: Vector3::zeros(),
            density_kg_m3: 0.0,
            speed_of_sound_m_s: 0.0,
            gravity_m_s2: crate::atmos::STANDARD_GRAVITY_M_S2,
            ground_m: 0.0,
            brake: 0.0,
            steering_rad: 0.0,
        };
        environment.at_altitude(atmosphere, altitude_m)?;
        Ok(environment)
    }

    /// Takes the air at another altitude.
    ///
    /// # Errors
    /// [`SimulateError::Model`] outside the atmosphere's range.
    pub fn at_altitude(&mut self, atmosphere: &Atmosphere, altitude_m: f64) -> Result<(), SimulateError> {
        let refuse = |error: crate::atmos::AtmosphereError| SimulateError::Model {
            what: "atmosphere",
            reason: error.to_string(),
        };
        self.density_kg_m3 = atmosphere.density_kg_m3(altitude_m).map_err(refuse)?;
        self.speed_of_sound_m_s = atmosphere.speed_of_sound_m_s(altitude_m).map_err(refuse)?;
        Ok(())
    }

    /// Sets thrust and rotor momentum for the engines' inputs and `ambient`.
    pub(crate) fn run_engines(&mut self, vehicle: &Vehicle, inputs: [EngineInput; 2], ambient: &Ambient) {
        self.thrust = [0, 1].map(|engine| vehicle.thrust(engine, inputs[engine], ambient));
        let speeds = inputs.map(|input| input.speed_rad_s);
        self.rotor_momentum_n_m_s = vehicle.powerplant.rotor_momentum_body(&speeds, RotorSum::Signed);
    }
}

/// Forces and moments on the aircraft in body axes about the centre of gravity, and what they do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct Loads {
    /// Flow.
    pub air: Airflow,
    /// Aerodynamic coefficients `CX CY CZ Cl Cm Cn`, without thrust.
    pub coefficients: [f64; 6],
    /// Aerodynamic force, N.
    pub aero_force_n: Vector3<f64>,
    /// Aerodynamic moment, N m.
    pub aero_moment_n_m: Vector3<f64>,
    /// Thrust of each engine, N.
    pub thrust_n: [f64; 2],
    pub thrust_moment_n_m: Vector3<f64>,
    pub ground_force_n: Vector3<f64>,
    pub ground_moment_n_m: Vector3<f64>,
    /// Specific force at the centre of gravity, m/s².
    pub specific_force_m_s2: Vector3<f64>,
    /// Acceleration over the ground, m/s².
    pub acceleration_ned_m_s2: Vector3<f64>,
    pub angular_acceleration_rad_s2: Vector3<f64>,
}

impl Loads {
    /// Rate of change of the state these loads act in.
    pub fn rate(&self, state: &State) -> Rate {
        state.rate(self.acceleration_ned_m_s2, self.angular_acceleration_rad_s2)
    }
}
