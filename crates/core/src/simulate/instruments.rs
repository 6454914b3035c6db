//! What the instruments see: the quantities at their places, and the sensors that turn them into numbers.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use super::vehicle::{Body, Controls, Loads};
use crate::airframe::frames;
use crate::motion::State;
use crate::propulsion::EngineInput;

/// A quantity the instruments read, in SI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "each name is the quantity")]
pub enum Quantity {
    SensorForceX,
    SensorForceY,
    SensorForceZ,
    RollRate,
    PitchRate,
    YawRate,
    Bank,
    Pitch,
    HeadingUnwrapped,
    TrueAirspeed,
    CalibratedAirspeed,
    StaticPressure,
    Temperature,
    PressureAltitude,
    GpsAltitude,
    VelocityNorth,
    VelocityEast,
    VelocityUp,
    Alpha,
    Beta,
    LoadFactor,
    TankMainRight,
    TankMainLeft,
    TankAuxRight,
    TankAuxLeft,
    Manifold1,
    Manifold2,
    Speed1,
    Speed2,
    Attitude0,
    Attitude1,
    Attitude2,
    Attitude3,
    Yoke,
    ColumnDrum,
    RightPedalDrum,
    LeftPedalDrum,
    None,
}

pub(crate) const QUANTITIES: usize = Quantity::None as usize + 1;

/// Values of all quantities at one instant.
pub type Quantities = [f64; QUANTITIES];

/// Everything known about one instant.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    pub time_s: f64,
    /// Motion.
    pub state: State,
    /// Flow and loads.
    pub loads: Loads,
    /// Deflections.
    pub controls: Controls,
    /// Velocity of the air over the ground, gusts included, m/s.
    pub wind_ned_m_s: Vector3<f64>,
    pub engines: [EngineInput; 2],
    /// Fuel of the tanks in the order of the aircraft file, kg.
    pub fuel_kg: [f64; 4],
    /// Static pressure, Pa.
    pub static_pressure_pa: f64,
    /// Static temperature, K.
    pub temperature_k: f64,
    pub pressure_altitude_m: f64,
    /// Heading without jumps, rad.
    pub heading_unwrapped_rad: f64,
}

/// Calibrated airspeed of an impact pressure in subsonic flow, m/s.
fn calibrated_airspeed(dynamic_pressure_pa: f64, mach: f64) -> f64 {
    const P0: f64 = 101_325.0;
    const A0: f64 = 340.294;
    // Impact pressure to second order of the Mach number, exact to 1e-5 below Mach 0.3.
    let impact = dynamic_pressure_pa * (1.0 + 0.25 * mach * mach + 0.025 * mach * mach * mach * mach);
    A0 * (5.0 * (libm::pow(impact / P0 + 1.0, 2.0 / 7.0) - 1.0)).max(0.0).sqrt()
}

impl Instant {
    /// What the instruments see, with the accelerometers at `accelerometer_from_datum_m` (thesis Eq. 4.10 the other way
    /// round: `f_ac = f_cg + w' x r + w x (w x r)`).
    pub fn quantities(&self, body: &Body, accelerometer_from_datum_m: [f64; 3], speed_of_sound_m_s: f64) -> Quantities {
        use Quantity as Q;
        let arm = frames::body_from_datum(accelerometer_from_datum_m, body.properties.cg_from_datum_m);
        let arm = Vector3::from(arm);
        let rates = self.state.rates_rad_s;
        let force = self.loads.specific_force_m_s2
            + self.loads.angular_acceleration_rad_s2.cross(&arm)
            + rates.cross(&rates.cross(&arm));
        let [phi, theta, _] = self.state.euler_rad();
        let air = &self.loads.air;
        let mach = air.airspeed_m_s / speed_of_sound_m_s;
        let deflections = ControlLinkage::positions(&self.controls);
        let velocity = self.state.velocity_ned_m_s;
        let mut values = [0.0; QUANTITIES];
        let mut set = |quantity: Q, value: f64| values[quantity as usize] = value;
        set(Q::SensorForceX, force.x);
        set(Q::SensorForceY, force.y);
        set(Q::SensorForceZ, force.z);
        set(Q::RollRate, rates.x);
        set(Q::PitchRate, rates.y);
        set(Q::YawRate, rates.z);
        set(Q::Bank, phi);
        set(Q::Pitch, theta);
        set(Q::HeadingUnwrapped, self.heading_unwrapped_rad);
        set(Q::TrueAirspeed, air.airspeed_m_s);
        set(Q::CalibratedAirspeed, calibrated_airspeed(air.dynamic_pressure_pa, mach));
        set(Q::StaticPressure, self.static_pressure_pa);
        set(Q::Temperature, self.temperature_k);
        set(Q::PressureAltitude, self.pressure_altitude_m);
        set(Q::GpsAltitude, -self.state.position_ned_m.z);
        set(Q::VelocityNorth, velocity.x);
        set(Q::VelocityEast, velocity.y);
        set(Q::VelocityUp, -velocity.z);
        set(Q::Alpha, air.alpha_rad);
        set(Q::Beta, air.beta_rad);
        set(Q::LoadFactor, -self.loads.specific_force_m_s2.z / crate::atmos::STANDARD_GRAVITY_M_S2);
        let tanks = [Q::TankMainRight, Q::TankMainLeft, Q::TankAuxRight, Q::TankAuxLeft];
        tanks.into_iter().zip(self.fuel_kg).for_each(|(quantity, mass)| set(quantity, mass));
        set(Q::Manifold1, self.engines[0].manifold_pressure_pa);
        set(Q::Manifold2, self.engines[1].manifold_pressure_pa);
        set(Q::Speed1, self.engines[0].speed_rad_s);
        set(Q::Speed2, self.engines[1].speed_rad_s);
        let attitude = [Q::Attitude0, Q::Attitude1, Q::Attitude2, Q::Attitude3];
        attitude.into_iter().zip(self.state.attitude).for_each(|(quantity, part)| set(quantity, part));
        set(Q::Yoke, deflections.yoke_rad);
        set(Q::ColumnDrum, deflections.column_drum_rad);
        set(Q::RightPedalDrum, deflections.right_pedal_drum_rad);
        set(Q::LeftPedalDrum, deflections.left_pedal_drum_rad);
        values
    }
}

/// Angles of the control sensors for given deflections: thesis section 4.1 the other way round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlLinkage {
    /// Yoke, counter-clockwise as the pilot sees it, rad.
    pub yoke_rad: f64,
    /// Drum of the pulley on the column, rad.
    pub column_drum_rad: f64,
    /// Drum of the pulley on the captain's right pedal, rad.
    pub right_pedal_drum_rad: f64,
    /// Drum of the pulley on the copilot's left pedal, rad.
    pub left_pedal_drum_rad: f64,
}

/// Radius of the pulley drums, m (thesis section 4.1.2).
const DRUM_RADIUS_M: f64 = 0.01245;
/// Aileron deflection per yoke angle, and deflection at zero yoke, deg (thesis Table 4.2).
const AILERON_FIT: (f64, f64) = (0.162, -0.060);
/// Elevator deflection per column travel, deg/cm (thesis Table 4.3).
const ELEVATOR_DEG_PER_CM: f64 = 2.386;
/// String length at neutral and its offset from the column, cm (thesis section 4.1.3).
const STRING_CM: (f64, f64) = (20.9, 2.5);
/// Rudder deflection (deg) against string displacement (m), lowest power first (thesis Table 4.4), and the displacements
/// between which each curve rises or falls all the way.
const RIGHT_PEDAL: ([f64; 6], (f64, f64)) =
    ([1.207e-1, -3.155e2, -1.098e3, -3.074e4, -8.065e4, 9.752e6], (-0.0540, 0.0668));
const LEFT_PEDAL: ([f64; 6], (f64, f64)) =
    ([-5.071e-2, 3.129e2, -1.412e3, 1.406e3, 5.275e4, -1.737e6], (-0.0850, 0.0700));
/// Inboard over outboard travel of a rudder (thesis section 4.1.3).
const OUTBOARD_SCALE: f64 = 0.596;

impl ControlLinkage {
    /// Sensor angles of a set of deflections.
    pub fn positions(controls: &Controls) -> Self {
        let yoke_deg = (controls.aileron.to_degrees() - AILERON_FIT.1) / AILERON_FIT.0;
        let travel_cm = controls.elevator.to_degrees() / ELEVATOR_DEG_PER_CM;
        let (string_cm, offset_cm) = STRING_CM;
        let column_cm = (string_cm * string_cm - offset_cm * offset_cm).sqrt() - travel_cm;
        let pulled_cm = string_cm - (column_cm * column_cm + offset_cm * offset_cm).sqrt();
        let rudder_deg = controls.rudder.to_degrees();
        let measured_deg = if rudder_deg < 0.0 { rudder_deg / OUTBOARD_SCALE } else { rudder_deg };
        Self {
            yoke_rad: yoke_deg.to_radians(),
            column_drum_rad: pulled_cm / 100.0 / DRUM_RADIUS_M,
            right_pedal_drum_rad: invert(&RIGHT_PEDAL, measured_deg) / DRUM_RADIUS_M,
            left_pedal_drum_rad: invert(&LEFT_PEDAL, measured_deg) / DRUM_RADIUS_M,
        }
    }
}

/// String displacement at which a monotone polynomial has a value; the nearer end beyond its range.
fn invert((coefficients, (low, high)): &([f64; 6], (f64, f64)), value: f64) -> f64 {
    let at = |s: f64| coefficients.iter().rev().fold(0.0, |sum, a| sum * s + a);
    let rising = at(*high) > at(*low);
    let (mut low, mut high) = (*low, *high);
    for _ in 0..45 {
        let middle = 0.5 * (low + high);
        if (at(middle) < value) == rising { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Where a control sensor sits: its axes in body axes, and which angle turns it about its own z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mount {
    /// Rows: the sensor's x, y and z axis in body axes before it is turned.
    pub sensor_from_body: [[f64; 3]; 3],
    /// Angle that turns it; [`Quantity::None`] for the one on the instrument panel.
    pub turned_by: Quantity,
    /// Angle it is turned by at neutral controls, rad: keeps the attitude of a sensor on its side away from the vertical.
    pub rest_rad: f64,
}

/// Rest angle of the pedal pulleys: outboard rudder turns them further than inboard rudder does.
const PEDAL_REST_RAD: f64 = 0.25;

impl Mount {
    /// Faces the pilot: x right, y up, z aft, so that a counter-clockwise yoke turns it positively, and a roll to the left too.
    const FACING_AFT: [[f64; 3]; 3] = [[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]];
    /// Lies flat: body axes.
    const FLAT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// Stands on its side: x forward, y up, z right.
    const ON_SIDE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]];

    pub const YOKE: Self = Self { sensor_from_body: Self::FACING_AFT, turned_by: Quantity::Yoke, rest_rad: 0.0 };
    pub const PANEL: Self = Self { sensor_from_body: Self::FACING_AFT, turned_by: Quantity::None, rest_rad: 0.0 };
    /// On the column's pulley, whose axis lies across the pitch axis.
    pub const COLUMN: Self = Self { sensor_from_body: Self::FLAT, turned_by: Quantity::ColumnDrum, rest_rad: 0.0 };
    /// On the right pedal's pulley, whose axis lies across the yaw and roll axes.
    pub(crate) const RIGHT_PEDAL: Self =
        Self { sensor_from_body: Self::ON_SIDE, turned_by: Quantity::RightPedalDrum, rest_rad: -PEDAL_REST_RAD };
    /// On the left pedal's pulley.
    pub(crate) const LEFT_PEDAL: Self =
        Self { sensor_from_body: Self::ON_SIDE, turned_by: Quantity::LeftPedalDrum, rest_rad: PEDAL_REST_RAD };

    /// Bank, pitch and heading of the sensor itself, rad.
    pub fn euler_rad(&self, values: &Quantities) -> [f64; 3] {
        let part = |quantity: Quantity| values[quantity as usize];
        let mut attitude =
            [Quantity::Attitude0, Quantity::Attitude1, Quantity::Attitude2, Quantity::Attitude3].map(part);
        let norm = attitude.iter().map(|e| e * e).sum::<f64>().sqrt();
        attitude.iter_mut().for_each(|e| *e /= norm);
        let state = State { attitude, ..State::new(Vector3::zeros(), Vector3::zeros(), [0.0; 3]) };
        let angle = if self.turned_by == Quantity::None { 0.0 } else { part(self.turned_by) };
        let (sin, cos) = libm::sincos(angle + self.rest_rad);
        let turn = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
        let rows = self.sensor_from_body;
        let mount = Matrix3::from_fn(|i, j| rows[i][j]);
        let m = turn * mount * state.body_from_ned();
        let theta = libm::asin((-m[(0, 2)]).clamp(-1.0, 1.0));
        [libm::atan2(m[(1, 2)], m[(2, 2)]), theta, libm::atan2(m[(0, 1)], m[(0, 0)])]
    }
}

/// Number the pod shows for an angle of attack: the inverse of `alpha[deg] = exp(sum a_k A^k)` with the coefficients of flight
/// FT1.0 (thesis Table 4.11), which stands for its pressure ratio (Eq. 4.8); it stays at 0 and 100 beyond its range.
pub(crate) fn pod_number(alpha_rad: f64) -> f64 {
    const FIT: [f64; 7] = [1.559, 1.589e-3, 1.572e-5, 1.525e-7, 1.455e-9, 1.370e-11, 1.278e-13];
    let wanted = libm::log(alpha_rad.to_degrees().max(0.1));
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        let exponent = FIT.iter().rev().fold(0.0, |sum, a| sum * middle + a);
        if exponent < wanted { low = middle } else { high = middle }
    }
    if high < 1e-9 { 0.0 } else { 0.5 * (low + high) }
}

/// Fuel a probe shows for a fuel mass, lb (thesis Tables 4.9-4.10, without the outlier of the left main probe).
pub(crate) fn probe_display_lb(tank: usize, actual_lb: f64) -> f64 {
    const STEP_LB: f64 = 16.59;
    const MAIN_LEFT: [f64; 18] = [
        0.0, 10.0, 20.0, 39.0, 41.0, 56.0, 68.0, 85.0, 100.0, 113.0, 130.0, 146.0, 164.0, 182.0, 211.0, 245.0, 274.0,
        276.0,
    ];
    const MAIN_RIGHT: [f64; 18] = [
        0.0, 17.0, 41.0, 66.0, 80.0, 90.0, 102.0, 120.0, 139.0, 155.0, 172.0, 187.0, 203.0, 221.0, 240.0, 256.0, 271.0,
        276.0,
    ];
    const AUX_LEFT: [f64; 8] = [0.0, 0.0, 18.0, 35.0, 50.0, 66.0, 85.0, 100.0];
    const AUX_RIGHT: [f64; 8] = [0.0, 0.0, 27.0, 41.0, 58.0, 74.0, 92.0, 107.0];
    let shown: &[f64] = match tank {
        0 => &MAIN_RIGHT,
        1 => &MAIN_LEFT,
        2 => &AUX_RIGHT,
        _ => &AUX_LEFT,
    };
    let place = (actual_lb / STEP_LB).clamp(0.0, (shown.len() - 1) as f64);
    let index = (place as usize).min(shown.len() - 2);
    shown[index] + (shown[index + 1] - shown[index]) * (place - index as f64)
}

/// Power the engine monitor estimates, W: `210 hp (N / 2800 rpm)^1.58 (p_z / 28 inHg)^1.36`, fitted to the monitor's
/// column of thesis Table 6.11.
pub fn monitor_power_w(engine: EngineInput) -> f64 {
    const RATED_W: f64 = 210.0 * 745.699_871_582;
    const RATED_RAD_S: f64 = 2800.0 * PI / 30.0;
    const RATED_PA: f64 = 28.0 * 3386.389;
    let speed = libm::pow((engine.speed_rad_s / RATED_RAD_S).max(0.0), 1.58);
    RATED_W * speed * libm::pow((engine.manifold_pressure_pa / RATED_PA).max(0.0), 1.36)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bisection to 45 halvings of 0.15 m times 400 deg/m, deg.
    const BISECTION_DEG: f64 = 1e-9;

    #[test]
    fn linkage_is_the_inverse_of_the_published_fits() {
        let controls = Controls { aileron: 0.05, elevator: -0.04, rudder: -0.06 };
        let positions = ControlLinkage::positions(&controls);
        let aileron = 0.162 * positions.yoke_rad.to_degrees() - 0.060;
        assert!((aileron - controls.aileron.to_degrees()).abs() < BISECTION_DEG);
        let pulled = positions.column_drum_rad * DRUM_RADIUS_M * 100.0;
        let travel = (20.9f64.powi(2) - 2.5f64.powi(2)).sqrt() - ((20.9 - pulled).powi(2) - 2.5f64.powi(2)).sqrt();
        assert!((2.386 * travel - controls.elevator.to_degrees()).abs() < BISECTION_DEG);
        for (drum, (fit, _)) in
            [(positions.right_pedal_drum_rad, RIGHT_PEDAL), (positions.left_pedal_drum_rad, LEFT_PEDAL)]
        {
            let string = drum * DRUM_RADIUS_M;
            let deflection: f64 = fit.iter().enumerate().map(|(k, a)| a * string.powi(k as i32)).sum();
            assert!((OUTBOARD_SCALE * deflection - controls.rudder.to_degrees()).abs() < BISECTION_DEG);
        }
    }

    #[test]
    fn pod_number_matches_calibration_points() {
        // reference: alpha 4.754, 8.055 and 11.449 deg at 0, 85 and 100 (printed coefficients hold about three digits).
        for (alpha_deg, number) in [(4.0f64, 0.0), (8.055, 85.0), (11.449, 100.0), (13.0, 100.0)] {
            assert!((pod_number(alpha_deg.to_radians()) - number).abs() < 0.05, "{alpha_deg}");
        }
    }

    #[test]
    fn probes_show_the_published_points() {
        for (tank, actual, shown) in
            [(1, 182.51, 146.0), (0, 49.78, 66.0), (3, 16.59, 0.0), (2, 99.55, 92.0), (0, 292.0, 276.0)]
        {
            assert!((probe_display_lb(tank, actual) - shown).abs() < 0.05, "tank {tank}");
        }
    }

    #[test]
    fn monitor_estimate_is_near_the_published_column() {
        // thesis Table 6.11: N rpm, p_z inHg, P_mvp hp; the fit's own scatter is 9 hp.
        for (rpm, inhg, hp) in
            [(2350.0, 17.7, 88.2), (2330.0, 24.7, 132.3), (2770.0, 27.9, 210.0), (1180.0, 17.2, 29.4)]
        {
            let engine = EngineInput { speed_rad_s: rpm * PI / 30.0, manifold_pressure_pa: inhg * 3386.389 };
            assert!((monitor_power_w(engine) / 745.7 - hp).abs() < 9.0);
        }
    }
}
