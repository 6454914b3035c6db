//! A recording of any length, its channel map and a session of one window over it.

use std::fmt::Write;
use std::path::Path;

/// Columns of the recording.
pub const NAMES: [&str; 17] = [
    "t", "ax", "ay", "az", "p", "q", "r", "phi", "theta", "psi", "airspeed", "altitude", "alpha", "beta", "delta_e",
    "delta_a", "delta_r",
];

/// Writes `flight.csv`, `map.toml` and `session.toml` into a folder, the columns of each sample in the order of [`NAMES`] changed by
/// `change`.
pub fn write(folder: &Path, samples: u32, change: impl Fn(u32, &mut [f64; 17])) {
    std::fs::write(folder.join("flight.csv"), recording(samples, change)).unwrap();
    std::fs::write(folder.join("map.toml"), channel_map()).unwrap();
    std::fs::write(folder.join("session.toml"), session(samples)).unwrap();
}

/// A pitch and roll oscillation at 130 m/s, in the order of [`NAMES`], at time `t`.
pub fn oscillation(t: f64) -> [f64; 17] {
    let (fast, slow) = ((6.0 * t).sin() + 0.3 * (11.0 * t).sin(), (2.5 * t).cos() + 0.3 * (5.0 * t).cos());
    [
        t,
        0.3 + 0.05 * fast,
        0.1 * slow,
        -9.7 + 0.8 * fast,
        4.0 * slow,
        3.0 * fast,
        0.8 * slow,
        5.0 * (2.5 * t).sin(),
        4.0 - 0.5 * slow,
        90.0 + 0.3 * (0.01 * t).sin(),
        130.0 + 0.2 * slow,
        3000.0 - 0.5 * (0.01 * t).sin(),
        4.5 + 0.6 * fast,
        0.4 * slow,
        -1.0 - 1.5 * (6.0 * t + 0.6).sin(),
        1.2 * (2.5 * t + 1.0).cos(),
        0.5 * fast + 0.2 * (3.0 * t).sin(),
    ]
}

/// The oscillation at 100 Hz.
fn recording(samples: u32, change: impl Fn(u32, &mut [f64; 17])) -> String {
    let mut text = NAMES.join(",") + "\n";
    for index in 0..samples {
        let mut row = oscillation(f64::from(index) / 100.0);
        change(index, &mut row);
        let row = row.map(|value| if value.abs() < 1e6 { format!("{value:.5}") } else { format!("{value:e}") });
        writeln!(text, "{}", row.join(",")).unwrap();
    }
    text
}

/// Channel map of the recording.
fn channel_map() -> String {
    let mut text = "format = \"doublet channel map\"\nversion = 1\nname = \"long\"\n[[time]]\nsource = \"*\"\nchannel = \"t\"\nunit = \"s\"\n[roles]\n".to_owned();
    for name in &NAMES[1..] {
        let unit = match *name {
            "ax" | "ay" | "az" => "m/s^2",
            "p" | "q" | "r" => "deg/s",
            "airspeed" => "m/s",
            "altitude" => "m",
            _ => "deg",
        };
        writeln!(text, "{name} = {{ channel = \"{name}\", unit = \"{unit}\" }}").unwrap();
    }
    text
}

/// One window over the whole recording, filtered, smoothed, fitted with three terms a coefficient.
fn session(samples: u32) -> String {
    let end_s = f64::from(samples) / 100.0;
    format!(
        r#"format = "doublet session"
version = 3
title = "long"
aircraft = "builtin:attas_vfw614"
[filter]
gravity_m_s2 = 9.8
[filter.process_noise]
ax = 0.02
[preparation]
remove_thrust = false
[model]
CX = ["1", "alpha"]
CY = ["1", "beta"]
CZ = ["1", "alpha"]
Cl = ["1", "pb/2V", "delta_a"]
Cm = ["1", "alpha", "delta_e"]
Cn = ["1", "beta", "delta_r"]
[[flight]]
name = "flight"
[[flight.recording]]
path = "flight.csv"
channel_map = "map.toml"
[[window]]
name = "w"
flight = "flight"
start_s = 0.0
end_s = {end_s}
"#
    )
}
