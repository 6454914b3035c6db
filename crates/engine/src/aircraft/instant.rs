//! What is known of the motion at one instant: measured, reconstructed, and as the model flew it.

use doublet_core::quantity::Role;
use doublet_core::reconstruct::{Measurement, State};
use doublet_core::series::{Recording, Series, value_at};
use doublet_core::validate::Signal;

use crate::session::Manoeuvre;
use crate::snapshot::Snapshot;

/// Longest time between two samples that a straight line bridges, s.
const GAP_S: f64 = 2.0;

/// Attitude, flow and velocity from one source; what it does not tell is `None`. SI and radians, axes of `docs/conventions.md`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Bank, pitch and heading, rad.
    pub attitude_rad: Option<[f64; 3]>,
    /// True airspeed, m/s.
    pub airspeed_m_s: Option<f64>,
    /// Angle of attack, rad.
    pub alpha_rad: Option<f64>,
    /// Angle of sideslip, rad.
    pub beta_rad: Option<f64>,
    /// Velocity over the ground: north, east, down, m/s.
    pub velocity_ned_m_s: Option<[f64; 3]>,
}

impl Motion {
    /// Velocity through the air: north, east, down, m/s: `u = V cos(alpha) cos(beta)`, `v = V sin(beta)`, `w = V sin(alpha) cos(beta)` turned
    /// by the attitude (thesis Eq. 4.9).
    pub fn air_velocity_ned_m_s(&self) -> Option<[f64; 3]> {
        let (speed, alpha, beta) = (self.airspeed_m_s?, self.alpha_rad?, self.beta_rad?);
        let body = [alpha.cos() * beta.cos(), beta.sin(), alpha.sin() * beta.cos()].map(|part| speed * part);
        Some(super::ned_from_body(self.attitude_rad?)(body))
    }
}

/// Everything that a picture of one instant shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Instant {
    /// As recorded.
    pub measured: Motion,
    /// As reconstructed, inside a window with a path.
    pub reconstructed: Motion,
    /// As the model flew the window, where it did.
    pub model: Motion,
    /// Wind: velocity of the air towards north, east and down, m/s, inside a window with a path.
    pub wind_ned_m_s: Option<[f64; 3]>,
    /// Deflections of aileron, elevator and rudder, rad.
    pub controls_rad: [Option<f64>; 3],
    /// Mass, kg, and centre of gravity, m from the datum, inside a window with coefficients.
    pub mass: Option<(f64, [f64; 3])>,
}

fn at(series: &Series, time_s: f64) -> Option<f64> {
    value_at(&series.time_s, &series.values, GAP_S, time_s)
}

/// All three or nothing.
fn triple(values: [Option<f64>; 3]) -> Option<[f64; 3]> {
    let [Some(x), Some(y), Some(z)] = values else { return None };
    Some([x, y, z])
}

/// An angle that is recorded within one turn: its last value where it jumps by more than half of one.
fn angle_at(series: &Series, time_s: f64) -> Option<f64> {
    let after = series.time_s.partition_point(|&own| own < time_s);
    let before = after.checked_sub(1).and_then(|before| series.values.get(before)).copied();
    match (before, series.values.get(after)) {
        (Some(before), Some(&after)) if (after - before).abs() > std::f64::consts::PI => Some(before),
        _ => at(series, time_s),
    }
}

fn recorded(recording: &Recording, time_s: f64) -> (Motion, [Option<f64>; 3]) {
    let series = |role: Role| recording.role(role).map(|channel| &channel.series);
    let value = |role| at(series(role)?, time_s);
    let angle = |role| angle_at(series(role)?, time_s);
    let motion = Motion {
        attitude_rad: triple([Role::BankAngle, Role::PitchAngle, Role::HeadingAngle].map(angle)),
        airspeed_m_s: value(Role::TrueAirspeed),
        alpha_rad: value(Role::AngleOfAttack),
        beta_rad: value(Role::Sideslip),
        velocity_ned_m_s: triple([Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown].map(value)),
    };
    (motion, [Role::Aileron, Role::Elevator, Role::Rudder].map(value))
}

/// What is known at `time_s` of a flight; of its window where the time lies inside.
pub fn instant(snapshot: &Snapshot, flight: &str, window: Option<&Manoeuvre>, time_s: f64) -> Instant {
    let mut all = Instant::default();
    if let Some(loaded) = snapshot.flights.get(flight).and_then(|slot| slot.latest()) {
        (all.measured, all.controls_rad) = recorded(&loaded.recording, time_s);
    }
    let inside = |window: &&Manoeuvre| window.flight == flight && window.window.contains(time_s);
    let Some(window) = window.filter(inside) else { return all };
    let Some(results) = snapshot.windows.get(&window.name) else { return all };
    if let Some(path) = results.path.latest() {
        let columns = path.series();
        let value = |measurement: Measurement| at(&columns.reconstructed[measurement as usize], time_s);
        let state = |state: State| at(&columns.states[state as usize], time_s);
        let tells_wind = path.tells_wind();
        all.reconstructed = Motion {
            attitude_rad: triple([State::BankAngle, State::PitchAngle, State::HeadingAngle].map(state)),
            airspeed_m_s: value(Measurement::Airspeed),
            alpha_rad: value(Measurement::AngleOfAttack),
            beta_rad: value(Measurement::Sideslip),
            velocity_ned_m_s: triple(
                [Measurement::VelocityNorth, Measurement::VelocityEast, Measurement::VelocityDown].map(value),
            )
            .filter(|_| tells_wind),
        };
        let wind = triple([State::WindNorth, State::WindEast, State::WindDown].map(state));
        all.wind_ned_m_s = wind.filter(|_| tells_wind);
    }
    if let Some(Ok(replay)) = snapshot.proof.latest().and_then(|proof| proof.window(&window.name)) {
        let value = |signal: Signal| {
            let series = replay.series.iter().find(|series| series.signal == signal)?;
            at(&series.simulated, time_s)
        };
        all.model = Motion {
            attitude_rad: triple([Signal::BankAngle, Signal::PitchAngle, Signal::HeadingAngle].map(value)),
            airspeed_m_s: value(Signal::Airspeed),
            alpha_rad: value(Signal::AngleOfAttack),
            beta_rad: value(Signal::Sideslip),
            velocity_ned_m_s: None,
        };
    }
    if let Some(aero) = results.aero.latest().filter(|aero| !aero.data.time_s.is_empty()) {
        let sample = aero.data.time_s.partition_point(|&own| own < time_s).min(aero.data.time_s.len() - 1);
        let mass = aero.data.mass.at(sample);
        all.mass = Some((mass.mass_kg, mass.cg_from_datum_m));
    }
    all
}
