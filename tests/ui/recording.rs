//! A small flight whose derivatives are known, written to disk as a user would have it: a recording, a channel map, an
//! aircraft, a session.
//!
//! The motion is prescribed: airspeed constant, angle of attack and pitch sums of sines. The elevator is then what makes
//! the pitching moment exactly `Cm = CM[0] + CM[1] alpha + CM[2] q c / V + CM[3] delta_e`.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use doublet_core::atmos::Atmosphere;

/// True `Cm_0, Cm_alpha, Cm_q, Cm_delta_e`.
pub const CM: [f64; 4] = [0.03, -0.9, -14.0, -1.4];
/// Length, s.
pub const LENGTH_S: f64 = 60.0;
/// Time between samples, s.
pub const STEP_S: f64 = 0.02;
/// Altitude of the local origin, m.
const ORIGIN_M: f64 = 1500.0;
/// True airspeed, m/s.
pub const AIRSPEED_M_S: f64 = 90.0;
/// Gravity, m/s².
const GRAVITY_M_S2: f64 = 9.806_65;
/// Pitch inertia, kg m²; reference area, m²; chord, m.
const IYY_S_C: [f64; 3] = [22_965.0, 24.99, 1.991];

const AIRCRAFT: &str = r#"format = "doublet aircraft"
version = 1
name = "Test aircraft"
[datum]
origin = "nose"
[reference]
area_m2 = 24.99
span_m = 13.325
chord_m = 1.991
[mass]
mass_kg = 5000.0
cg_datum_m = [0.0, 0.0, 0.0]
[inertia]
moments_kg_m2 = [15351.0, 22965.0, 36220.0]
products_kg_m2 = { xz = 1908.0 }
"#;

const MAP: &str = r#"format = "doublet channel map"
version = 1
name = "test"
[[time]]
source = "*"
channel = "time"
unit = "s"
[roles]
ax = { channel = "ax", unit = "m/s^2" }
ay = { channel = "ay", unit = "m/s^2" }
az = { channel = "az", unit = "m/s^2" }
p = { channel = "p", unit = "rad/s" }
q = { channel = "q", unit = "rad/s" }
r = { channel = "r", unit = "rad/s" }
phi = { channel = "phi", unit = "rad" }
theta = { channel = "theta", unit = "rad" }
psi = { channel = "psi", unit = "rad" }
x = { channel = "x", unit = "m" }
z = { channel = "z", unit = "m" }
v_north = { channel = "v_north", unit = "m/s" }
v_down = { channel = "v_down", unit = "m/s" }
airspeed = { channel = "airspeed", unit = "m/s" }
alpha = { channel = "alpha", unit = "rad" }
delta_e = { channel = "delta_e", unit = "rad" }
"#;

const SESSION: &str = r#"format = "doublet session"
version = 1
title = "Test flight"
aircraft = "aircraft.toml"
[filter]
method = "ekf"
gravity_m_s2 = 9.80665
[filter.initial_deviation]
wind_north = 0.0
wind_east = 0.0
wind_down = 0.0
[preparation]
path = "filtered"
origin_altitude_m = 1500.0
[model]
Cm = ["1", "alpha", "qc/V", "delta_e"]
[[flight]]
name = "flight"
[[flight.recording]]
path = "flight.csv"
channel_map = "map.toml"
[[window]]
name = "first"
flight = "flight"
start_s = 5.0
end_s = 25.0
surface = "elevator"
"#;

/// A sum of sines with its first two derivatives.
fn sines(parts: &[(f64, f64)], t: f64) -> [f64; 3] {
    parts.iter().fold([0.0; 3], |sum, &(amplitude, rate)| {
        let (sin, cos) = (rate * t).sin_cos();
        [sum[0] + amplitude * sin, sum[1] + amplitude * rate * cos, sum[2] - amplitude * rate * rate * sin]
    })
}

/// Angle of attack and pitch angle with their derivatives.
fn motion(t: f64) -> ([f64; 3], [f64; 3]) {
    let mut alpha = sines(&[(0.03, 1.9), (0.015, 3.1)], t);
    let mut theta = sines(&[(0.04, 1.3), (0.02, 2.4)], t);
    alpha[0] += 0.06;
    theta[0] += 0.06;
    (alpha, theta)
}

/// Ground velocity north and down, m/s.
fn ground(t: f64) -> (f64, f64) {
    let ([alpha, ..], [theta, ..]) = motion(t);
    let path = theta - alpha;
    (AIRSPEED_M_S * path.cos(), -AIRSPEED_M_S * path.sin())
}

/// Writes the flight into `folder`; its session file.
pub fn write(folder: &Path) -> PathBuf {
    let mut text = "time,ax,ay,az,p,q,r,phi,theta,psi,x,z,v_north,v_down,airspeed,alpha,delta_e\n".to_owned();
    let (mut x, mut z) = (0.0, 0.0);
    let count = (LENGTH_S / STEP_S).round() as usize;
    for k in 0..=count {
        let t = k as f64 * STEP_S;
        let ([alpha, alpha_dot, _], [theta, q, q_dot]) = motion(t);
        let (u, w) = (AIRSPEED_M_S * alpha.cos(), AIRSPEED_M_S * alpha.sin());
        let ax = -w * alpha_dot + q * w + GRAVITY_M_S2 * theta.sin();
        let az = u * alpha_dot - q * u - GRAVITY_M_S2 * theta.cos();
        let density = Atmosphere::STANDARD.density_kg_m3(ORIGIN_M - z).expect("the flight is in the atmosphere");
        let [iyy, area, chord] = IYY_S_C;
        let moment = iyy * q_dot / (0.5 * density * AIRSPEED_M_S.powi(2) * area * chord);
        let elevator = (moment - CM[0] - CM[1] * alpha - CM[2] * q * chord / AIRSPEED_M_S) / CM[3];
        let (north, down) = ground(t);
        writeln!(
            text,
            "{t:.4},{ax:.9},0,{az:.9},0,{q:.9},0,0,{theta:.9},0,{x:.6},{z:.6},{north:.8},{down:.8},{AIRSPEED_M_S},{alpha:.9},{elevator:.9}"
        )
        .expect("text grows");
        // Simpson's rule over the step.
        let (middle, next) = (ground(t + 0.5 * STEP_S), ground(t + STEP_S));
        x += STEP_S / 6.0 * (north + 4.0 * middle.0 + next.0);
        z += STEP_S / 6.0 * (down + 4.0 * middle.1 + next.1);
    }
    for (name, contents) in
        [("flight.csv", text.as_str()), ("aircraft.toml", AIRCRAFT), ("map.toml", MAP), ("session.toml", SESSION)]
    {
        std::fs::write(folder.join(name), contents).expect("the test's folder can be written");
    }
    folder.join("session.toml")
}
