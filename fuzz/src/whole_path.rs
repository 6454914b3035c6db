//! The whole path: a session with some of its settings changed, checked and run on two seconds of flight.

use std::path::PathBuf;
use std::sync::LazyLock;

use doublet_engine::graph::Cache;
use doublet_engine::report;
use doublet_engine::run::{Control, Scope, Snapshot, run};
use doublet_engine::session;
use toml::Value;

/// Memory for what runs share.
const CACHE_BYTES: usize = 64 << 20;
/// Samples of the recording, at 50 Hz.
const SAMPLES: u32 = 100;

const MAP: &str = r#"format = "doublet channel map"
version = 1
name = "short"
[[time]]
source = "*"
channel = "t"
unit = "s"
[roles]
ax = { channel = "ax", unit = "m/s^2" }
ay = { channel = "ay", unit = "m/s^2" }
az = { channel = "az", unit = "m/s^2" }
p = { channel = "p", unit = "deg/s" }
q = { channel = "q", unit = "deg/s" }
r = { channel = "r", unit = "deg/s" }
phi = { channel = "phi", unit = "deg" }
theta = { channel = "theta", unit = "deg" }
psi = { channel = "psi", unit = "deg" }
airspeed = { channel = "V", unit = "m/s" }
altitude = { channel = "h", unit = "m" }
alpha = { channel = "alpha", unit = "deg" }
beta = { channel = "beta", unit = "deg" }
delta_e = { channel = "delta_e", unit = "deg" }
delta_a = { channel = "delta_a", unit = "deg" }
delta_r = { channel = "delta_r", unit = "deg" }
"#;

const SESSION: &str = r#"format = "doublet session"
version = 3
title = "two seconds"
aircraft = "builtin:attas_vfw614"
[filter]
method = "iekf"
gravity_m_s2 = 9.8
[filter.process_noise]
ax = 0.02
q = 5e-4
[filter.measurement_noise]
z = 10.0
theta = 7e-4
alpha = 2e-3
[filter.initial_deviation]
wind_north = 0.0
[preparation]
path = "smoothed"
differentiation_half_width_s = 0.1
remove_thrust = false
[estimation]
by_surface = false
constants = "common"
[model]
Cm = ["1", "alpha", "qc/V", "delta_e"]
Cl = ["1", "beta", "pb/2V", "delta_a"]
[[flight]]
name = "flight"
[[flight.recording]]
path = "short.csv"
channel_map = "short_map.toml"
[[window]]
name = "e1"
flight = "flight"
start_s = 0.1
end_s = 1.9
[[window]]
name = "e2"
flight = "flight"
start_s = 0.0
end_s = 1.0
role = "validation"
"#;

/// The folder with the recording, for as long as the program runs.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = std::env::temp_dir().join(format!("doublet-whole-path-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder can be made");
    std::fs::write(folder.join("short.csv"), recording()).expect("the recording can be written");
    std::fs::write(folder.join("short_map.toml"), MAP).expect("the map can be written");
    folder
});

static CACHE: LazyLock<Cache> = LazyLock::new(|| Cache::new(CACHE_BYTES));

/// Two seconds of a pitch and roll oscillation at 130 m/s.
fn recording() -> String {
    let mut text = "t,ax,ay,az,p,q,r,phi,theta,psi,V,h,alpha,beta,delta_e,delta_a,delta_r\n".to_owned();
    for index in 0..SAMPLES {
        let t = f64::from(index) / 50.0;
        let (fast, slow) = ((6.0 * t).sin(), (2.5 * t).cos());
        let row = [
            t,
            0.3 + 0.05 * fast,
            0.1 * slow,
            -9.7 + 0.8 * fast,
            4.0 * slow,
            3.0 * fast,
            0.8 * slow,
            5.0 * (2.5 * t).sin(),
            4.0 - 0.5 * slow,
            90.0 + 0.3 * t,
            130.0 + 0.2 * slow,
            3000.0 - 0.5 * t,
            4.5 + 0.6 * fast,
            0.4 * slow,
            -1.0 - 1.5 * (6.0 * t + 0.6).sin(),
            1.2 * (2.5 * t + 1.0).cos(),
            0.5 * fast,
        ];
        text.push_str(&row.map(|value| format!("{value:.5}")).join(","));
        text.push('\n');
    }
    text
}

/// What comes next of the bytes; zero once there are none.
struct Bytes<'d>(&'d [u8]);

impl Bytes<'_> {
    fn next(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    fn number(&mut self) -> f64 {
        let mut eight = [0; 8];
        eight.fill_with(|| self.next());
        match eight[0] % 4 {
            0 => f64::from_le_bytes(eight),
            1 => f64::from(eight[1]) * 10_f64.powi(i32::from(eight[2]) - 128),
            2 => -f64::from(eight[1]),
            _ => f64::from(eight[1]) / 100.0,
        }
    }
}

/// Changes one thing below `value`: the bytes say which and how.
fn change(value: &mut Value, bytes: &mut Bytes<'_>) {
    match value {
        Value::Table(table) if !table.is_empty() => {
            let at = usize::from(bytes.next()) % table.len();
            let Some(key) = table.keys().nth(at).cloned() else { return };
            match bytes.next() % 16 {
                0 => _ = table.remove(&key),
                _ => table.get_mut(&key).into_iter().for_each(|value| change(value, bytes)),
            }
        }
        Value::Array(list) if !list.is_empty() => {
            let at = usize::from(bytes.next()) % list.len();
            match bytes.next() % 16 {
                0 => _ = list.remove(at),
                1 => list.push(list[at].clone()),
                _ => change(&mut list[at], bytes),
            }
        }
        leaf => {
            *leaf = match bytes.next() % 8 {
                0 => Value::Integer(bytes.number() as i64),
                1 => Value::Boolean(bytes.next().is_multiple_of(2)),
                2 => Value::String(char::from(bytes.next()).to_string()),
                3 => Value::String(
                    ["alpha", "beta*q", "smoothed", "filtered", "ekf", "ukf", "e1"][usize::from(bytes.next()) % 7]
                        .to_owned(),
                ),
                _ => Value::Float(bytes.number()),
            }
        }
    }
}

/// Sessions with some settings changed, from their text to the results of a run. Every number of the results is one that JSON can hold.
pub fn whole_path(data: &[u8]) {
    let mut bytes = Bytes(data);
    let mut table: Value = toml::from_str::<toml::Table>(SESSION).map(Value::Table).expect("the session is TOML");
    for _ in 0..=bytes.next() % 4 {
        change(&mut table, &mut bytes);
    }
    let text = toml::to_string(&table).expect("a table has a text");
    let Ok(session) = session::parse(&text) else { return };
    if session::check(&session).iter().any(session::stops_run) {
        return;
    }
    let scope = Scope { session: &session, folder: &FOLDER, first: None, studies: &[], cause: "fuzz", generation: 1 };
    let snapshot = run(&scope, &Snapshot::default(), &CACHE, &Control::default(), &|_| {});
    let results = report::build(&session, &snapshot);
    serde_json::to_string(&results).expect("results have a form as JSON");
}
