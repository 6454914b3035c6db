//! Flying a scenario.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::inputs::FirstOrderLag;
use super::instrument_errors::{self, InstrumentErrors, Recorder, quantity_errors};
use super::instruments::Instant;
use super::pilot::{Pilot, View, wrap};
use super::plan::{Flown, Segment};
use super::recorder::{History, Stream, StreamSpec};
use super::scenario::{Scenario, Start};
use super::trim::{full_throttle_pa, trim};
use super::truth::Truth;
use super::turbulence::Dryden;
use super::vehicle::{Body, Controls, Environment, Loads, Surface};
use super::{SimulateError, boxes};
use crate::airframe::Loading;
use crate::atmos::{Atmosphere, AtmosphereError};
use crate::motion::{State, runge_kutta_from};
use crate::propulsion::{Ambient, EngineInput};

/// Steps from one look at the engine maps to the next.
const ENGINE_STEPS: usize = 10;
/// Steps from one mass, centre of gravity and inertia to the next.
const LOADING_STEPS: usize = 100;
/// Time constant of engine speed and manifold pressure, s.
const ENGINE_LAG_S: f64 = 0.8;
/// Fuel burnt per energy: 0.27 kg/kWh, a usual figure of piston aero engines at cruise mixture, kg/J.
const FUEL_KG_PER_J: f64 = 0.27 / 3.6e6;

/// A flight as flown and recorded.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "names say it")]
pub struct Flight {
    pub scenario: Scenario,
    pub seed: u64,
    /// Manoeuvres with their inputs as flown.
    pub manoeuvres: Vec<Flown>,
    /// Streams of the data bus and the engine monitor.
    pub bus: Vec<Stream>,
    /// The air-data pod.
    pub pod: Stream,
    pub control_sensors: Vec<Stream>,
    /// Delay of each recording of the control sensors from the stated start to its first sample, s.
    pub start_delays_s: Vec<f64>,
    /// Constant errors of the instruments, drawn from the accuracies of the scenario.
    pub instrument_errors: InstrumentErrors,
    pub truth: Truth,
}

/// Flies a scenario. The same scenario and seed give the same flight. `progress` gets the fraction flown once a simulated
/// second and stops the flight by returning false.
///
/// # Errors
/// [`SimulateError::PastStop`] before the start when an input with its trim would pass a stop; trim errors for a start in flight;
/// [`SimulateError::LeftEnvelope`] when the aircraft leaves the angles of attack the truth holds for;
/// [`SimulateError::Cancelled`].
pub fn run(scenario: &Scenario, seed: u64, progress: &mut dyn FnMut(f64) -> bool) -> Result<Flight, SimulateError> {
    let mut flight = Flying::new(scenario, seed)?;
    let steps = (scenario.duration_s / scenario.step_s).round() as usize;
    let per_second = (1.0 / scenario.step_s).round().max(1.0) as usize;
    for step in 0..=steps {
        if step.is_multiple_of(per_second) && !progress(step as f64 / steps as f64) {
            return Err(SimulateError::Cancelled { time_s: step as f64 * scenario.step_s });
        }
        flight.step(step)?;
    }
    Ok(flight.finish(seed))
}

impl Flight {
    /// Constant errors of the instruments, those of every flight and those drawn: name, value, SI unit.
    pub fn constant_errors(&self) -> impl Iterator<Item = (&'static str, f64, &'static str)> + '_ {
        let drawn = self.instrument_errors.iter();
        let drawn = drawn.map(|(error, value)| (error.name(), *value, error.dimension().si_symbol()));
        Truth::biases().into_iter().chain(drawn)
    }
}

/// The flight while it is flown.
struct Flying<'a> {
    scenario: &'a Scenario,
    manoeuvres: Vec<Flown>,
    state: State,
    body: Body,
    loading: Loading,
    fuel_kg: [f64; 4],
    environment: Environment,
    pilot: Pilot,
    engines: [[FirstOrderLag; 2]; 2],
    engine_inputs: [EngineInput; 2],
    cables: [FirstOrderLag; 3],
    controls_before: Controls,
    gusts: Dryden,
    gust_rng: ChaCha8Rng,
    heading_unwrapped: f64,
    history: History,
    bus: Vec<Stream>,
    pod: Stream,
    control_sensors: Vec<Stream>,
    start_delays_s: Vec<f64>,
    instrument_errors: InstrumentErrors,
    truth: Truth,
    segment: usize,
    manoeuvre: usize,
    unsteadiness: Vec<f64>,
}

/// Generator of one purpose: streams of one seed do not touch each other.
fn generator(seed: u64, purpose: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(purpose);
    rng
}

fn refuse(error: AtmosphereError) -> SimulateError {
    SimulateError::Model { what: "atmosphere", reason: error.to_string() }
}

impl<'a> Flying<'a> {
    fn new(scenario: &'a Scenario, seed: u64) -> Result<Self, SimulateError> {
        let mut hand = generator(seed, 1);
        let manoeuvres: Vec<Flown> = scenario.manoeuvres.iter().map(|manoeuvre| manoeuvre.fly(&mut hand)).collect();
        let spread = |rng: &mut ChaCha8Rng| scenario.unsteadiness_m_s * rng.random_range(-1.0..1.0);
        let unsteadiness = manoeuvres.iter().map(|_| spread(&mut hand)).collect();
        let start_delays_s = manoeuvres.iter().map(|_| hand.random_range(0.2..1.5)).collect();
        let body = scenario.vehicle.body(&scenario.loading)?;
        let mut pilot = Pilot::new(scenario.step_s);
        let (state, environment, inputs) = start(scenario, &body, &mut pilot)?;
        check_inputs(scenario, &manoeuvres, &environment)?;
        let mut purpose = 10;
        let errors = instrument_errors::draw(&scenario.sensor_accuracy, &mut generator(seed, 3));
        let mut stream = |spec: StreamSpec, recorder: Recorder| {
            purpose += 1;
            Stream::new(spec, scenario.duration_s, scenario.exact_instruments, generator(seed, purpose))
                .with_errors(quantity_errors(recorder, &errors))
        };
        let lag = |value: f64| FirstOrderLag::new(ENGINE_LAG_S, scenario.step_s, value);
        let cable = |value: f64| FirstOrderLag::new(scenario.control_lag_s, scenario.step_s, value);
        let controls = environment.controls;
        let mut fuel_kg = [0.0; 4];
        for (mass, tank) in fuel_kg.iter_mut().zip(&scenario.vehicle.aircraft.tanks) {
            *mass = scenario.loading.fuel_kg.get(&tank.name).copied().unwrap_or(0.0);
        }
        Ok(Self {
            scenario,
            state,
            loading: scenario.loading.clone(),
            fuel_kg,
            environment,
            pilot,
            engines: inputs.map(|input| [lag(input.speed_rad_s), lag(input.manifold_pressure_pa)]),
            engine_inputs: inputs,
            controls_before: controls,
            cables: [cable(controls.aileron), cable(controls.elevator), cable(controls.rudder)],
            gusts: Dryden::new(scenario.gust_m_s),
            gust_rng: generator(seed, 2),
            heading_unwrapped: state.euler_rad()[2],
            history: History::new(scenario.step_s),
            bus: boxes::BUS.iter().map(|&spec| stream(spec, boxes::recorder(&spec))).collect(),
            pod: stream(boxes::pod(scenario.pod_rate_hz), Recorder::Pod),
            control_sensors: boxes::CONTROL_SENSORS
                .iter()
                .map(|&spec| stream(spec, Recorder::ControlSensors))
                .collect(),
            start_delays_s,
            instrument_errors: errors,
            truth: Truth::new(scenario),
            segment: 0,
            manoeuvre: 0,
            unsteadiness,
            body,
            manoeuvres,
        })
    }

    /// Records the instant at `step` and flies on to the next.
    fn step(&mut self, step: usize) -> Result<(), SimulateError> {
        let scenario = self.scenario;
        let time_s = step as f64 * scenario.step_s;
        let altitude_m = -self.state.position_ned_m.z;
        let static_pressure_pa = scenario.atmosphere.pressure_pa(altitude_m).map_err(refuse)?;
        let temperature_k = scenario.atmosphere.temperature_k(altitude_m).map_err(refuse)?;
        let pressure_altitude_m = Atmosphere::STANDARD.altitude_m(static_pressure_pa).map_err(refuse)?;
        self.environment.density_kg_m3 = static_pressure_pa / (crate::atmos::GAS_CONSTANT_AIR_J_KG_K * temperature_k);
        self.environment.speed_of_sound_m_s = scenario.atmosphere.speed_of_sound_m_s(altitude_m).map_err(refuse)?;
        let airspeed_m_s = (self.state.velocity_ned_m_s - self.environment.wind_ned_m_s).norm();
        let density_kg_m3 = self.environment.density_kg_m3;
        let air = Ambient { airspeed_m_s, pressure_altitude_m, air_temperature_k: temperature_k, density_kg_m3 };
        if step.is_multiple_of(ENGINE_STEPS) {
            self.environment.run_engines(&scenario.vehicle, self.engine_inputs, &air);
        }
        if step > 0 && step.is_multiple_of(LOADING_STEPS) {
            self.burn_fuel(LOADING_STEPS as f64 * scenario.step_s)?;
        }
        self.blow(airspeed_m_s);
        let loads = scenario.vehicle.loads(&self.body, &self.state, &self.environment);
        self.check(time_s, &loads)?;
        let instant = Instant {
            time_s,
            state: self.state,
            loads,
            controls: self.environment.controls,
            wind_ned_m_s: self.environment.wind_ned_m_s,
            engines: self.engine_inputs,
            fuel_kg: self.fuel_kg,
            static_pressure_pa,
            temperature_k,
            pressure_altitude_m,
            heading_unwrapped_rad: self.heading_unwrapped,
        };
        self.record(step, &instant);
        // The controls of the next instant follow from the motion up to now.
        let controls = self.environment.controls;
        self.act(time_s + scenario.step_s, static_pressure_pa, &loads);
        self.advance(&loads, &controls);
        self.controls_before = controls;
        Ok(())
    }

    /// Steady wind and gusts.
    fn blow(&mut self, airspeed_m_s: f64) {
        let gust = self.gusts.step(airspeed_m_s, self.scenario.step_s, &mut self.gust_rng);
        let gust_ned = self.state.body_from_ned().tr_mul(&Vector3::from(gust));
        self.environment.wind_ned_m_s = self.scenario.wind_ned_m_s + gust_ned;
    }

    /// Lets the pilot act, through cables and engine lags: controls and engine inputs at `time_s`.
    fn act(&mut self, time_s: f64, static_pressure_pa: f64, sensed: &Loads) {
        let scenario = self.scenario;
        let segments = &scenario.segments;
        while self.segment + 1 < segments.len() && segments[self.segment + 1].start_s <= time_s {
            self.segment += 1;
        }
        while self.manoeuvres.get(self.manoeuvre).is_some_and(|flown| flown.manoeuvre.recorded_s().1 < time_s) {
            self.manoeuvre += 1;
        }
        let Some(segment): Option<&Segment> = segments.get(self.segment) else { return };
        let next = self.manoeuvres.get(self.manoeuvre);
        let held = next.filter(|flown| (flown.manoeuvre.held_from_s()..flown.manoeuvre.held_to_s()).contains(&time_s));
        /// How long before the held controls the pilot prepares, s.
        const PREPARATION_S: f64 = 15.0;
        let soon = next.is_some_and(|flown| flown.manoeuvre.held_from_s() - time_s < PREPARATION_S);
        self.pilot.preparing = soon.then(|| self.unsteadiness[self.manoeuvre]);
        let speed = self.engine_inputs[0].speed_rad_s;
        let view = View {
            time_s,
            state: &self.state,
            loads: sensed,
            ground_m: scenario.ground_m,
            full_throttle_pa: full_throttle_pa(static_pressure_pa, speed, self.environment.density_kg_m3),
            gravity_m_s2: self.environment.gravity_m_s2,
        };
        let command = self.pilot.command(&scenario.vehicle, segment, held, &view);
        for (engine, wanted) in command.engines.iter().enumerate() {
            let [speed, manifold] = &mut self.engines[engine];
            self.engine_inputs[engine] = EngineInput {
                speed_rad_s: speed.step(wanted.speed_rad_s),
                manifold_pressure_pa: manifold.step(wanted.manifold_pressure_pa.min(view.full_throttle_pa)),
            };
        }
        let [aileron, elevator, rudder] = &mut self.cables;
        self.environment.controls = Controls {
            aileron: aileron.step(command.controls.aileron),
            elevator: elevator.step(command.controls.elevator),
            rudder: rudder.step(command.controls.rudder),
        };
        self.environment.brake = command.brake;
        self.environment.steering_rad = command.steering_rad;
    }

    /// Burns fuel from the first two tanks, in proportion to what is in them, and takes the new mass and inertia.
    fn burn_fuel(&mut self, interval_s: f64) -> Result<(), SimulateError> {
        let power_w: f64 = self.environment.thrust.iter().map(|thrust| thrust.power_w.max(0.0)).sum();
        let burnt_kg = power_w * FUEL_KG_PER_J * interval_s;
        let on_board = self.fuel_kg[0] + self.fuel_kg[1];
        if on_board > burnt_kg {
            for tank in 0..2 {
                self.fuel_kg[tank] -= burnt_kg * self.fuel_kg[tank] / on_board;
            }
        }
        for (tank, mass) in self.scenario.vehicle.aircraft.tanks.iter().zip(self.fuel_kg) {
            if let Some(entry) = self.loading.fuel_kg.get_mut(&tank.name) {
                *entry = mass;
            }
        }
        self.body = self.scenario.vehicle.body(&self.loading)?;
        Ok(())
    }

    /// Refuses flight beyond the truth.
    fn check(&self, time_s: f64, loads: &Loads) -> Result<(), SimulateError> {
        let flying = loads.ground_force_n == Vector3::zeros();
        let (low, high) = self.scenario.vehicle.alpha_range_rad;
        let alpha = loads.air.alpha_rad;
        if flying && !(low..=high).contains(&alpha) {
            return Err(SimulateError::LeftEnvelope {
                time_s,
                what: "the angle of attack (rad)",
                value: alpha,
                low,
                high,
            });
        }
        Ok(())
    }

    /// Gives the instant to the truth and to all recorders.
    fn record(&mut self, step: usize, instant: &Instant) {
        let time_s = instant.time_s;
        let inside = |flown: &Flown| {
            let (from, to) = flown.manoeuvre.recorded_s();
            (from..=to).contains(&time_s)
        };
        let next = self.manoeuvres.get(self.manoeuvre);
        let in_manoeuvre = next.is_some_and(inside);
        let sensors_on =
            next.is_some_and(|flown| inside(flown) && time_s >= flown.manoeuvre.recorded_s().0 + self.late_s());
        self.truth.record(step, instant, &self.body, in_manoeuvre);
        let values =
            instant.quantities(&self.body, boxes::ACCELEROMETER_FROM_DATUM_M, self.environment.speed_of_sound_m_s);
        self.history.push(time_s, values);
        for stream in self.bus.iter_mut().chain([&mut self.pod]) {
            stream.sample(&self.history, true);
        }
        for stream in &mut self.control_sensors {
            stream.sample(&self.history, sensors_on);
        }
    }

    /// How much later than its margin a recording of the control sensors may begin, s.
    fn late_s(&self) -> f64 {
        // The stated start lies before the recorded interval, the first sample in its margin.
        0.2 * self.start_delays_s.get(self.manoeuvre).copied().unwrap_or(0.0)
    }

    /// One step of the integration from loads already known, the controls moving from `start` to those of the environment along a
    /// parabola: a straight line would put a corner at every step, which no control has.
    fn advance(&mut self, loads: &Loads, start: &Controls) {
        let (vehicle, body) = (&self.scenario.vehicle, &self.body);
        let (end, mut environment) = (self.environment.controls, self.environment);
        let half_way = start.half_way(&self.controls_before, &end);
        let before = self.heading_unwrapped;
        self.state = runge_kutta_from(&self.state, &loads.rate(&self.state), self.scenario.step_s, |part, state| {
            environment.controls = if part < 1.0 { half_way } else { end };
            vehicle.loads(body, state, &environment).rate(state)
        });
        self.heading_unwrapped = before + wrap(self.state.euler_rad()[2] - before);
    }

    fn finish(self, seed: u64) -> Flight {
        Flight {
            scenario: self.scenario.clone(),
            seed,
            manoeuvres: self.manoeuvres,
            bus: self.bus,
            pod: self.pod,
            control_sensors: self.control_sensors,
            start_delays_s: self.start_delays_s,
            instrument_errors: self.instrument_errors,
            truth: self.truth,
        }
    }
}

/// State, environment and engine inputs at the start.
fn start(
    scenario: &Scenario,
    body: &Body,
    pilot: &mut Pilot,
) -> Result<(State, Environment, [EngineInput; 2]), SimulateError> {
    let (state, mut environment, inputs) = match scenario.start {
        Start::Trimmed(condition) => {
            let trim = trim(&scenario.vehicle, body, &scenario.atmosphere, &condition)?;
            let pitch = trim.state.euler_rad()[1];
            pilot.start_trimmed(trim.environment.controls, pitch, trim.engines[0].manifold_pressure_pa);
            (trim.state, trim.environment, trim.engines)
        }
        Start::Parked => {
            let heading = scenario.segments.first().map_or(0.0, |segment| segment.heading_rad);
            // The wheels touch the ground where the datum frame has its zero when the aircraft stands.
            let height_m = body.properties.cg_from_datum_m[2];
            let position = Vector3::new(0.0, 0.0, -(scenario.ground_m + height_m));
            let state = State::new(position, Vector3::zeros(), [0.0, 0.0, heading]);
            let idle = EngineInput { speed_rad_s: 113.0, manifold_pressure_pa: 57_000.0 };
            let environment = Environment::still(&scenario.vehicle, &scenario.atmosphere, scenario.ground_m)?;
            (state, environment, [idle; 2])
        }
    };
    environment.ground_m = scenario.ground_m;
    environment.wind_ned_m_s = scenario.wind_ned_m_s;
    Ok((state, environment, inputs))
}

/// Refuses inputs that would pass a stop, taken about the controls at the start.
fn check_inputs(scenario: &Scenario, manoeuvres: &[Flown], environment: &Environment) -> Result<(), SimulateError> {
    for flown in manoeuvres {
        let manoeuvre = &flown.manoeuvre;
        for surface in Surface::ALL {
            let about = environment.controls.get(surface);
            let what = format!("{} {} at {:.0} s", surface.name(), manoeuvre.kind.name(), manoeuvre.onset_s);
            for side in [-1.0, 1.0] {
                let deflection = about + side * flown.signal(surface).peak_rad();
                scenario.vehicle.stops.check(surface, deflection, &what)?;
            }
        }
    }
    Ok(())
}
