//! A simple pilot: holds attitude, speed, altitude and heading; lets go for the manoeuvres.

use super::inputs::half_cosine;
use super::plan::{Flown, Hands, Power, Segment, Task};
use super::vehicle::{Controls, Loads, Surface, Vehicle};
use crate::motion::State;
use crate::propulsion::EngineInput;

/// What the pilot moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Deflections, within the stops.
    pub controls: Controls,
    pub engines: [EngineInput; 2],
    /// Wheel brakes, 0 to 1.
    pub brake: f64,
    /// Nose wheel, rad.
    pub steering_rad: f64,
}

/// What the pilot sees.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    pub time_s: f64,
    /// Motion.
    pub state: &'a State,
    /// Flow and loads.
    pub loads: &'a Loads,
    /// Altitude of the ground, m.
    pub ground_m: f64,
    /// Manifold pressure at full throttle, Pa.
    pub full_throttle_pa: f64,
    pub gravity_m_s2: f64,
}

/// The pilot's memory.
#[derive(Clone, Debug)]
pub struct Pilot {
    step_s: f64,
    /// Pitch attitude that holds the flight path, rad.
    pitch_rad: f64,
    /// Controls that hold the attitude, rad.
    trimmed: Controls,
    /// Low-passed controls, held during manoeuvres, rad.
    quiet: Controls,
    /// Manifold pressure that holds the airspeed, Pa.
    manifold_pa: f64,
    last: Option<Command>,
    /// Engine inputs of the last command outside a manoeuvre.
    steady_engines: [EngineInput; 2],
    /// Whether the controls were held for a manoeuvre at the last command.
    held: bool,
    /// Controls from which the hands move to others, and the time since they left them, s.
    leaving: Option<(Controls, f64)>,
    /// Prepares a manoeuvre: wings level instead of a heading, and this vertical speed (m/s) beside the task's, as a pilot
    /// never holds it perfectly.
    pub preparing: Option<f64>,
}

/// Dynamic pressure the gains of the controls hold for, Pa: 46 m/s at 4,000 ft.
const REFERENCE_PRESSURE_PA: f64 = 1150.0;
/// Time constant over which the held controls are averaged, s.
const QUIET_S: f64 = 2.0;
/// Time in which the hands move from the controls of the pilot to those of a manoeuvre and back, along a half cosine, s.
const TAKE_OVER_S: f64 = 0.5;
/// Lowest manifold pressure in flight, Pa.
const LOWEST_MANIFOLD_PA: f64 = 40_000.0;
/// Steepest bank the pilot flies, rad.
const MAX_BANK_RAD: f64 = 0.35;

impl Pilot {
    /// A pilot who acts every `step_s`.
    pub fn new(step_s: f64) -> Self {
        Self {
            step_s,
            pitch_rad: 0.08,
            trimmed: Controls::default(),
            quiet: Controls::default(),
            manifold_pa: 60_000.0,
            last: None,
            steady_engines: [EngineInput { speed_rad_s: 0.0, manifold_pressure_pa: 0.0 }; 2],
            held: false,
            leaving: None,
            preparing: None,
        }
    }

    /// Starts in steady flight with these controls and this manifold pressure.
    pub(crate) fn start_trimmed(&mut self, controls: Controls, pitch_rad: f64, manifold_pa: f64) {
        self.trimmed = controls;
        self.quiet = controls;
        self.pitch_rad = pitch_rad;
        self.manifold_pa = manifold_pa;
    }

    /// What the pilot does now. During a manoeuvre the controls stay where they were and its input is added to them, or the pilot
    /// flies it; power stays but for the input.
    pub fn command(
        &mut self,
        vehicle: &Vehicle,
        segment: &Segment,
        manoeuvre: Option<&Flown>,
        view: &View<'_>,
    ) -> Command {
        if let (Some(flown), Some(last)) = (manoeuvre, self.last) {
            let since_s = view.time_s - flown.manoeuvre.onset_s;
            let is_held = flown.hands() == Hands::Held;
            let controls = if is_held {
                let mut controls = self.quiet;
                for surface in Surface::ALL {
                    *controls.get_mut(surface) += flown.signal(surface).at(since_s);
                }
                controls
            } else {
                self.hand_flown(segment, flown, view)
            };
            let controls = self.moved(vehicle.stops.limit(controls), is_held);
            let command = Command { controls, engines: self.moved_engines(flown, since_s, view), ..last };
            self.last = Some(command);
            return command;
        }
        let engines = self.engines(segment, view);
        self.steady_engines = engines;
        let (pitch, on_ground) = self.pitch(segment, view);
        let bank = if on_ground || self.preparing.is_some() { 0.0 } else { self.bank(segment, view) };
        let controls = vehicle.stops.limit(self.controls(
            &Demand { pitch_rad: pitch, bank_rad: bank, ..Demand::default() },
            on_ground,
            view,
        ));
        let (brake, steering_rad) = ground_controls(segment, view);
        let keep = libm::exp(-self.step_s / QUIET_S);
        for (quiet, now) in [
            (&mut self.quiet.aileron, controls.aileron),
            (&mut self.quiet.elevator, controls.elevator),
            (&mut self.quiet.rudder, controls.rudder),
        ] {
            *quiet = now + (*quiet - now) * keep;
        }
        let controls = self.moved(controls, false);
        let command = Command { controls, engines, brake, steering_rad };
        self.last = Some(command);
        command
    }

    /// Engine inputs of the steady flight before a manoeuvre, with the manifold pressure its input adds.
    fn moved_engines(&self, flown: &Flown, since_s: f64, view: &View<'_>) -> [EngineInput; 2] {
        let added_pa = flown.manifold_pa.at(since_s);
        if added_pa == 0.0 {
            return self.steady_engines;
        }
        self.steady_engines.map(|input| EngineInput {
            manifold_pressure_pa: (input.manifold_pressure_pa + added_pa)
                .clamp(LOWEST_MANIFOLD_PA, view.full_throttle_pa.max(LOWEST_MANIFOLD_PA)),
            ..input
        })
    }

    /// Controls of a manoeuvre that the pilot flies.
    fn hand_flown(&mut self, segment: &Segment, flown: &Flown, view: &View<'_>) -> Controls {
        let angle_rad = flown.angle_rad.at(view.time_s - flown.manoeuvre.onset_s);
        let airspeed_m_s = match segment.task {
            Task::Level { power: Power::Airspeed { airspeed_m_s, .. }, .. } | Task::Climb { airspeed_m_s, .. } => {
                airspeed_m_s
            }
            _ => view.loads.air.airspeed_m_s,
        };
        self.preparing = None;
        let demand = match flown.hands() {
            Hands::Held | Hands::Level => Demand {
                pitch_rad: self.pitch(segment, view).0,
                bank_rad: self.bank(segment, view),
                ..Demand::default()
            },
            Hands::Sideslip => {
                let straight_bank_rad = straight_bank_rad(view);
                Demand {
                    pitch_rad: self.pitch_for_airspeed(airspeed_m_s, view),
                    bank_rad: self.bank(segment, view) + straight_bank_rad,
                    sideslip_rad: angle_rad,
                    straight_bank_rad,
                }
            }
            Hands::Turn => Demand {
                pitch_rad: self.pitch_for_airspeed(airspeed_m_s, view),
                bank_rad: angle_rad,
                ..Demand::default()
            },
        };
        self.controls(&demand, false, view)
    }

    /// The controls on the way to `wanted`: letting go for a manoeuvre and taking over after it, hands need their time.
    fn moved(&mut self, wanted: Controls, held: bool) -> Controls {
        if let (Some(last), true) = (self.last, held != self.held) {
            self.leaving = Some((last.controls, 0.0));
        }
        self.held = held;
        let Some((from, elapsed_s)) = self.leaving.as_mut() else { return wanted };
        *elapsed_s += self.step_s;
        let part = *elapsed_s / TAKE_OVER_S;
        if part >= 1.0 {
            self.leaving = None;
            return wanted;
        }
        from.toward(&wanted, half_cosine(part))
    }

    /// Engine inputs of the task.
    fn engines(&mut self, segment: &Segment, view: &View<'_>) -> [EngineInput; 2] {
        match segment.task {
            Task::Ground { engines, .. } | Task::TakeOff { engines, .. } | Task::Climb { engines, .. } => engines,
            Task::Level { power: Power::Fixed(engines), .. } => engines,
            Task::Level { power: Power::Airspeed { airspeed_m_s, speed_rad_s }, .. } => {
                self.hold_airspeed(view, airspeed_m_s, speed_rad_s)
            }
            Task::Land { airspeed_m_s, engines, .. } if height_m(view) > FLARE_M => {
                self.hold_airspeed(view, airspeed_m_s, engines[1].speed_rad_s)
            }
            Task::Land { engines, .. } => engines,
        }
    }

    fn hold_airspeed(&mut self, view: &View<'_>, airspeed_m_s: f64, speed_rad_s: f64) -> [EngineInput; 2] {
        /// Manifold pressure per airspeed error, Pa s/m.
        const PROPORTIONAL: f64 = 4000.0;
        /// And per its integral, Pa/m.
        const INTEGRAL: f64 = 120.0;
        let error = airspeed_m_s - view.loads.air.airspeed_m_s;
        let highest = view.full_throttle_pa;
        // Far from the airspeed the integral would only run away.
        let near = if error.abs() < 3.0 { error } else { 0.0 };
        self.manifold_pa = (self.manifold_pa + INTEGRAL * near * self.step_s).clamp(LOWEST_MANIFOLD_PA, highest);
        let manifold_pressure_pa = (self.manifold_pa + PROPORTIONAL * error).clamp(LOWEST_MANIFOLD_PA, highest);
        [EngineInput { speed_rad_s, manifold_pressure_pa }; 2]
    }

    /// Pitch to fly, rad, and whether the wheels are on the ground.
    fn pitch(&mut self, segment: &Segment, view: &View<'_>) -> (f64, bool) {
        let rolling = height_m(view) < STANDING_M;
        match segment.task {
            Task::Ground { .. } => (0.0, true),
            Task::TakeOff { rotate_m_s, .. } if rolling && view.loads.air.airspeed_m_s < rotate_m_s => (0.0, true),
            Task::TakeOff { .. } => {
                self.pitch_rad = 0.12;
                (self.pitch_rad, rolling)
            }
            Task::Climb { altitude_m, airspeed_m_s, .. } => {
                // Level off when the rate of climb would carry through the altitude.
                if altitude_m + view.state.position_ned_m.z > CAPTURE_M {
                    (self.pitch_for_airspeed(airspeed_m_s, view), false)
                } else {
                    (self.pitch_for_altitude(altitude_m, 5.0, view), false)
                }
            }
            Task::Level { altitude_m, rate_m_s, .. } => (self.pitch_for_altitude(altitude_m, rate_m_s, view), false),
            Task::Land { .. } if rolling => (0.0, true),
            Task::Land { rate_m_s, .. } => {
                let height = height_m(view);
                let rate =
                    if height > FLARE_M { rate_m_s } else { 0.4 + (rate_m_s - 0.4) * (height - STANDING_M) / FLARE_M };
                (self.pitch_for_rate(-rate, view), false)
            }
        }
    }

    /// Pitch that brings a true airspeed back at fixed power, rad.
    fn pitch_for_airspeed(&mut self, airspeed_m_s: f64, view: &View<'_>) -> f64 {
        let error = airspeed_m_s - view.loads.air.airspeed_m_s;
        self.pitch_rad = (self.pitch_rad - 0.002 * error * self.step_s).clamp(-0.15, 0.25);
        (self.pitch_rad - 0.012 * error).clamp(-0.2, 0.25)
    }

    /// Pitch that brings the altitude, rad.
    fn pitch_for_altitude(&mut self, altitude_m: f64, rate_m_s: f64, view: &View<'_>) -> f64 {
        let error = altitude_m + view.state.position_ned_m.z;
        let rate = (0.08 * error).clamp(-rate_m_s, rate_m_s) + self.preparing.unwrap_or(0.0);
        self.pitch_for_rate(rate, view)
    }

    /// Pitch that brings a rate of climb, rad.
    fn pitch_for_rate(&mut self, rate_m_s: f64, view: &View<'_>) -> f64 {
        let error = (rate_m_s + view.state.velocity_ned_m_s.z) / view.loads.air.airspeed_m_s.max(20.0);
        self.pitch_rad = (self.pitch_rad + 0.25 * error * self.step_s).clamp(-0.2, 0.25);
        (self.pitch_rad + 0.6 * error).clamp(-0.25, 0.3)
    }

    /// Bank that brings the heading, rad.
    fn bank(&self, segment: &Segment, view: &View<'_>) -> f64 {
        let heading = view.state.euler_rad()[2];
        let error = wrap(segment.heading_rad - heading);
        // Close to the ground wings stay level.
        let steepest = if height_m(view) > 50.0 { MAX_BANK_RAD } else { 0.1 };
        (0.6 * error).clamp(-steepest, steepest)
    }

    /// Deflections that hold pitch and bank in a coordinated turn, or beside a sideslip.
    fn controls(&mut self, demand: &Demand, on_ground: bool, view: &View<'_>) -> Controls {
        let Demand { pitch_rad: pitch, bank_rad: bank, .. } = *demand;
        let [phi, theta, _] = view.state.euler_rad();
        let [p, q, r] = [view.state.rates_rad_s.x, view.state.rates_rad_s.y, view.state.rates_rad_s.z];
        let air = &view.loads.air;
        let gain = (REFERENCE_PRESSURE_PA / air.dynamic_pressure_pa.max(200.0)).clamp(0.2, 3.0);
        let turn = view.gravity_m_s2 * libm::tan((phi - demand.straight_bank_rad).clamp(-0.7, 0.7))
            / air.airspeed_m_s.max(20.0);
        let integral = if on_ground { 0.0 } else { self.step_s * gain };
        let sideslip = air.beta_rad - demand.sideslip_rad;
        let trimmed = &mut self.trimmed;
        trimmed.elevator = (trimmed.elevator - 0.35 * (pitch - theta) * integral).clamp(-0.35, 0.26);
        trimmed.aileron = (trimmed.aileron - 0.05 * (bank - phi) * integral).clamp(-0.1, 0.1);
        trimmed.rudder = (trimmed.rudder - 0.10 * sideslip * integral).clamp(-0.1, 0.1);
        let climb_turn = turn * libm::sin(phi);
        // On the ground the nose wheel steers.
        let yaw = gain * (0.5 * (r - turn * libm::cos(phi)) - 0.3 * sideslip);
        Controls {
            aileron: trimmed.aileron - gain * 0.5 * (1.6 * (bank - phi) - p),
            elevator: trimmed.elevator - gain * 0.7 * (1.1 * (pitch - theta) + climb_turn - q),
            rudder: if on_ground { 0.0 } else { trimmed.rudder + yaw },
        }
    }
}

/// What the pilot wants of the attitude.
#[derive(Clone, Copy, Debug, Default)]
struct Demand {
    pitch_rad: f64,
    bank_rad: f64,
    sideslip_rad: f64,
    /// Bank at which the flight is straight: zero without sideslip.
    straight_bank_rad: f64,
}

/// Bank at which gravity holds the side force, so that the flight is straight, rad.
fn straight_bank_rad(view: &View<'_>) -> f64 {
    /// Largest bank of a sideslip, rad.
    const LARGEST_RAD: f64 = 0.25;
    (-view.loads.specific_force_m_s2.y / view.gravity_m_s2).clamp(-LARGEST_RAD, LARGEST_RAD)
}

/// Height of the centre of gravity over the ground when the aircraft stands, with a little margin, m.
const STANDING_M: f64 = 1.9;
/// Height at which the flare begins, m.
const FLARE_M: f64 = 9.0;
/// Distance from the altitude at which a climb turns into level flight, m.
const CAPTURE_M: f64 = 40.0;

/// Height of the centre of gravity over the ground, m.
fn height_m(view: &View<'_>) -> f64 {
    -view.state.position_ned_m.z - view.ground_m
}

/// Brakes and nose wheel.
fn ground_controls(segment: &Segment, view: &View<'_>) -> (f64, f64) {
    if height_m(view) > 5.0 {
        return (0.0, 0.0);
    }
    let speed = view.state.velocity_ned_m_s.xy().norm();
    let heading_error = wrap(segment.heading_rad - view.state.euler_rad()[2]);
    let authority = 0.5 / (1.0 + 0.15 * speed);
    let steering = (1.5 * heading_error - 0.5 * view.state.rates_rad_s.z).clamp(-authority, authority);
    let brake = match segment.task {
        Task::Ground { speed_m_s: 0.0, .. } => 1.0,
        Task::Ground { speed_m_s, .. } => (0.3 * (speed - speed_m_s) + 0.2).clamp(0.0, 1.0),
        Task::Land { .. } if height_m(view) < STANDING_M => 0.6,
        _ => 0.0,
    };
    (brake, steering)
}

/// Angle in (-pi, pi].
pub(super) fn wrap(angle_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let wrapped = (angle_rad + PI).rem_euclid(TAU) - PI;
    if wrapped == -PI { PI } else { wrapped }
}
