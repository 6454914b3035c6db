//! Landing gear: three sprung wheels with rolling, braking and side friction.

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

use super::vehicle::Environment;
use crate::airframe::frames;
use crate::motion::State;

/// Gear of a truth file: where the wheels touch when the aircraft stands, and how stiff they are.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GearData {
    /// Nose wheel, m from the datum.
    nose_from_datum_m: [f64; 3],
    /// Right main wheel, m from the datum; the left one mirrors it.
    main_from_datum_m: [f64; 3],
    /// Deflection under the standing aircraft, m.
    static_deflection_m: f64,
    /// Load of the nose wheel when standing, N.
    nose_load_n: f64,
    /// Load of each main wheel when standing, N.
    main_load_n: f64,
    /// Damping as a fraction of critical.
    damping_ratio: f64,
    /// Rolling friction, -.
    rolling_friction: f64,
    /// Friction of locked main wheels, -.
    braking_friction: f64,
    /// Side friction, -.
    side_friction: f64,
}

/// Sprung wheels: nose, right main, left main.
#[derive(Clone, Debug, PartialEq)]
pub struct Gear {
    unloaded_from_datum_m: [[f64; 3]; 3],
    stiffness_n_m: [f64; 3],
    damping_n_s_m: [f64; 3],
    rolling_friction: f64,
    braking_friction: f64,
    side_friction: f64,
}

/// Speed of a contact point at which friction reaches 1/sqrt(2) of its full value, m/s.
const FRICTION_SPEED_M_S: f64 = 0.1;
/// Slip angle at which side friction reaches 1/sqrt(2) of its full value, rad.
const SLIP_ANGLE_RAD: f64 = 0.08;

impl Gear {
    /// Springs that carry the standing loads at the static deflection.
    pub fn new(data: &GearData) -> Self {
        let [x, y, z] = data.main_from_datum_m;
        let standing = [data.nose_from_datum_m, [x, y, z], [x, -y, z]];
        let loads = [data.nose_load_n, data.main_load_n, data.main_load_n];
        let stiffness_n_m = loads.map(|load| load / data.static_deflection_m);
        let damping_n_s_m = [0, 1, 2].map(|wheel| {
            let mass = loads[wheel] / crate::atmos::STANDARD_GRAVITY_M_S2;
            2.0 * data.damping_ratio * (stiffness_n_m[wheel] * mass).sqrt()
        });
        Self {
            unloaded_from_datum_m: standing.map(|[x, y, z]| [x, y, z - data.static_deflection_m]),
            stiffness_n_m,
            damping_n_s_m,
            rolling_friction: data.rolling_friction,
            braking_friction: data.braking_friction,
            side_friction: data.side_friction,
        }
    }

    /// Unloaded contact points from the centre of gravity, body axes, m.
    pub fn arms(&self, cg_from_datum_m: [f64; 3]) -> [Vector3<f64>; 3] {
        self.unloaded_from_datum_m.map(|point| Vector3::from(frames::body_from_datum(point, cg_from_datum_m)))
    }

    /// Force and moment of the ground in body axes, N and N m.
    pub fn loads(
        &self,
        arms: &[Vector3<f64>; 3],
        state: &State,
        body_from_ned: &Matrix3<f64>,
        environment: &Environment,
    ) -> (Vector3<f64>, Vector3<f64>) {
        /// Height of the centre of gravity above which no wheel can touch, m.
        const CLEAR_M: f64 = 5.0;
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        let height = -state.position_ned_m.z - environment.ground_m;
        if height > CLEAR_M {
            return (force, moment);
        }
        for (wheel, arm) in arms.iter().enumerate() {
            let compression = body_from_ned.tr_mul(arm).z - height;
            if compression <= 0.0 {
                continue;
            }
            let velocity = state.velocity_ned_m_s + body_from_ned.tr_mul(&state.rates_rad_s.cross(arm));
            let load = self.stiffness_n_m[wheel] * compression + self.damping_n_s_m[wheel] * velocity.z;
            let ground_force = self.contact_force(wheel, load.max(0.0), &velocity, body_from_ned, environment);
            let wheel_force = body_from_ned * ground_force;
            force += wheel_force;
            moment += arm.cross(&wheel_force);
        }
        (force, moment)
    }

    /// Force on a wheel in local Earth axes for its load and the velocity of its contact point.
    fn contact_force(
        &self,
        wheel: usize,
        load_n: f64,
        velocity: &Vector3<f64>,
        body_from_ned: &Matrix3<f64>,
        environment: &Environment,
    ) -> Vector3<f64> {
        let nose = wheel == 0;
        let heading = libm::atan2(body_from_ned[(0, 1)], body_from_ned[(0, 0)]);
        let (sin, cos) = libm::sincos(heading + if nose { environment.steering_rad } else { 0.0 });
        let along = velocity.x * cos + velocity.y * sin;
        let across = velocity.y * cos - velocity.x * sin;
        let braking = if nose { 0.0 } else { self.braking_friction * environment.brake };
        let drag = -(self.rolling_friction + braking) * load_n * saturating(along / FRICTION_SPEED_M_S);
        let side =
            -self.side_friction * load_n * saturating(across / (FRICTION_SPEED_M_S + SLIP_ANGLE_RAD * along.abs()));
        Vector3::new(drag * cos - side * sin, drag * sin + side * cos, -load_n)
    }
}

/// Odd, smooth, between -1 and 1.
fn saturating(x: f64) -> f64 {
    x / (1.0 + x * x).sqrt()
}
