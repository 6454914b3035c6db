//! Control deflections: thesis section 4.1 and synthetic sensors.

use doublet_core::load::instruments::{self, InstrumentError};
use doublet_core::prep::{
    ColumnFormula, DeflectionSettings, Differentiation, PrepError, SensorAttitude, SensorReference, aileron_deflection,
    attitude_turn, column_travel, deflection_noise, elevator_deflection, integrated_turn, integrated_turn_noise,
    rudder_deflection, rudder_history, sensor_rates,
};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::support::{asset, c337f};

/// Rounding of published figures: half their last digit, in their unit.
const HALF_DIGIT: f64 = 0.005;

#[test]
fn column_travel_matches_the_published_example_at_three_starting_positions() {
    // Section 4.1.3: one recorded signal, started at string lengths of 20.9, 23.0 and 18.9 cm, gives an absolute travel of
    // 4.60, 4.61 and 4.60 cm by Eq. 4.5. The signal itself is not printed: 2.319 cm either way gives all three.
    const SIGNAL_M: f64 = 0.02319;
    let travel = |string_m: f64, formula| {
        100.0 * (column_travel(SIGNAL_M, string_m, 0.025, formula) - column_travel(-SIGNAL_M, string_m, 0.025, formula))
    };
    for (string_m, published_cm) in [(0.209, 4.60), (0.230, 4.61), (0.189, 4.60)] {
        assert!((travel(string_m, ColumnFormula::Thesis) - published_cm).abs() < HALF_DIGIT, "from {string_m} m");
    }
    // The exact form from the right triangle: sqrt(0.23219^2 - b^2) - sqrt(0.18581^2 - b^2).
    let exact = 100.0 * ((0.23219f64.powi(2) - 6.25e-4).sqrt() - (0.18581f64.powi(2) - 6.25e-4).sqrt());
    assert!((travel(0.209, ColumnFormula::Exact) - exact).abs() < 1e-10);
    // Eq. 4.5 reads 1.1 to 2.0 % too little over 4 cm either way.
    for (displacement, least, most) in [(0.04, 0.9795, 0.9895), (-0.04, 0.9795, 0.9895), (1e-6, 0.985, 0.987)] {
        let [thesis, exact] = [ColumnFormula::Thesis, ColumnFormula::Exact]
            .map(|formula| column_travel(displacement, 0.209, 0.025, formula));
        assert!((least..most).contains(&(thesis / exact)), "{displacement}: {}", thesis / exact);
    }
    assert!(column_travel(0.19, 0.209, 0.025, ColumnFormula::Exact).is_nan());
}

#[test]
fn linkage_matches_tables_4_2_to_4_4() {
    let linkage = c337f().control;
    let degrees = |rad: f64| rad.to_degrees();
    // Table 4.2: 0.162 x 10 - 0.060 deg.
    assert!((degrees(aileron_deflection(&linkage, 10f64.to_radians())) - 1.56).abs() < 1e-9);
    // One turn of the drum is 78.2 mm of string, section 4.1.4.
    assert!((std::f64::consts::TAU * linkage.drum_radius_m * 1000.0 - 78.2).abs() < 0.05);
    // A column 2.1 cm from neutral is 5 deg of elevator (section 4.1.3), forward and down positive.
    let string = 0.209 - ((0.209f64.powi(2) - 6.25e-4).sqrt() - 0.021).hypot(0.025);
    let elevator = elevator_deflection(&linkage, string / linkage.drum_radius_m, DeflectionSettings::default());
    assert!((degrees(elevator) - 2.386 * 2.1).abs() < 1e-9 && (degrees(elevator) - 5.0).abs() < 0.05);
    let with = DeflectionSettings { elevator_intercept: true, ..Default::default() };
    assert!((degrees(elevator_deflection(&linkage, 0.0, with)) - 1.401).abs() < 1e-12);
    // Ends of the pedals' usable range and the scaling of outboard deflections, 13.6/22.8.
    for (sensor, displacement, inboard_deg) in [
        ("right_pedal", -0.0540, 13.63),
        ("right_pedal", 0.0668, -23.65 * 0.596),
        ("left_pedal", 0.0700, 13.76),
        ("left_pedal", -0.0850, -27.3 * 0.596),
        ("right_pedal", 0.0, 0.1207),
        ("left_pedal", 0.0, -0.05071 * 0.596),
    ] {
        let pedal = linkage.pedal(sensor).unwrap();
        // A hair inside, so that rounding does not leave the range.
        let turn = (1.0 - 1e-9) * displacement / linkage.drum_radius_m;
        let (rudder, held) = rudder_deflection(&linkage, pedal, turn);
        assert!((degrees(rudder) - inboard_deg).abs() < 0.03 && !held, "{sensor} {displacement}: {}", degrees(rudder));
    }
    let pedal = linkage.pedal("right_pedal").unwrap();
    let (values, warning) = rudder_history(&linkage, pedal, &[0.0, 6.0, 9.0]);
    assert_eq!(values[1], values[2]);
    assert!(warning.unwrap().to_string().contains("2 of 3 samples"));
}

/// A sensor whose control turns it by `turn` on an aircraft at `euler`, with the mount `rows`.
fn attitude_of(rows: [[f64; 3]; 3], turn: f64, euler: [f64; 3]) -> Rotation3<f64> {
    let body_from_earth = Rotation3::from_euler_angles(euler[0], euler[1], euler[2]).inverse();
    let mount = Matrix3::from_fn(|i, j| rows[i][j]);
    let about_z = Rotation3::from_euler_angles(0.0, 0.0, turn).inverse();
    Rotation3::from_matrix_unchecked(about_z.matrix() * mount * body_from_earth.matrix()).inverse()
}

/// Columns of Euler angles and of quaternions of attitudes.
struct Columns {
    euler: [Vec<f64>; 3],
    quaternion: [Vec<f64>; 4],
}

impl Columns {
    fn of(attitudes: &[Rotation3<f64>]) -> Self {
        let euler: Vec<_> = attitudes.iter().map(|attitude| attitude.euler_angles()).collect();
        let quaternion: Vec<_> = attitudes.iter().map(UnitQuaternion::from_rotation_matrix).collect();
        Self {
            euler: [
                euler.iter().map(|e| e.0).collect(),
                euler.iter().map(|e| e.1).collect(),
                euler.iter().map(|e| e.2).collect(),
            ],
            quaternion: [
                quaternion.iter().map(|e| e.w).collect(),
                quaternion.iter().map(|e| e.i).collect(),
                quaternion.iter().map(|e| e.j).collect(),
                quaternion.iter().map(|e| e.k).collect(),
            ],
        }
    }

    fn forms(&self) -> [SensorAttitude<'_>; 2] {
        let [phi, theta, psi] = &self.euler;
        let [e0, ex, ey, ez] = &self.quaternion;
        [SensorAttitude::Euler { phi, theta, psi }, SensorAttitude::Quaternion { e0, ex, ey, ez }]
    }
}

#[test]
fn turn_recovers_truth_from_euler_angles_and_quaternions_on_a_moving_aircraft() {
    /// Error of a fourth-order difference and trapezoids at 60 Hz for a turn of 2 rad at 3 rad/s, rad.
    const INTEGRATED: f64 = 2e-3;
    let linkage = c337f().control;
    let time: Vec<f64> = (0..600).map(|k| f64::from(k) / 60.0).collect();
    let aircraft = |t: f64| [0.5 * (0.7 * t).sin(), 0.1 * (1.3 * t).sin(), 3.0 + 0.2 * t];
    const PANEL: [[f64; 3]; 3] = [[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]];
    let fixed: Vec<_> = time.iter().map(|&t| attitude_of(PANEL, 0.0, aircraft(t))).collect();
    let fixed = Columns::of(&fixed);
    for (sensor, amplitude) in [("yoke", 1.0), ("column", 2.0), ("right_pedal", 1.0)] {
        let rows = linkage.mount(sensor).unwrap().sensor_from_reference;
        let panel = Matrix3::from_fn(|i, j| PANEL[i][j]);
        let in_body = Matrix3::from_fn(|i, j| rows[i][j]) * panel;
        let body_rows: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| in_body[(i, j)]));
        let turn = |t: f64| 0.3 + amplitude * (3.0 * t).sin();
        let turned: Vec<_> = time.iter().map(|&t| attitude_of(body_rows, turn(t), aircraft(t))).collect();
        let turned = Columns::of(&turned);
        for form in 0..2 {
            let (attitude, still) = (turned.forms()[form], fixed.forms()[form]);
            let reference = SensorReference { attitude: still, sensor_from_reference: rows };
            let found = attitude_turn(&attitude, &reference).unwrap();
            let integrated = integrated_turn(&time, &attitude, Some(&reference), Differentiation::Central4).unwrap();
            for (k, &t) in time.iter().enumerate() {
                assert!((found[k] - turn(t)).abs() < 1e-9, "{sensor} at {t} s: {} for {}", found[k], turn(t));
                // Euler angles of the sensors on their side pass the vertical: their rates are used where they do not.
                if form == 1 || sensor == "column" {
                    assert!((integrated[k] - turn(t) + turn(0.0)).abs() < INTEGRATED, "{sensor} at {t} s");
                }
            }
        }
    }
}

#[test]
fn pulley_without_reference_shows_the_aircrafts_turn_about_its_axis() {
    let time: Vec<f64> = (0..300).map(|k| f64::from(k) / 60.0).collect();
    const FLAT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let attitudes: Vec<_> = time.iter().map(|&t| attitude_of(FLAT, 0.5 * t, [0.0, 0.0, 6.0 + 0.1 * t])).collect();
    let columns = Columns::of(&attitudes);
    let turn = integrated_turn(&time, &columns.forms()[0], None, Differentiation::Central4).unwrap();
    assert!((turn[299] - 0.6 * time[299]).abs() < 1e-9, "heading passes half a turn without a jump");
    let short = SensorReference { attitude: columns.forms()[0].within(0..10).unwrap(), sensor_from_reference: FLAT };
    assert!(matches!(attitude_turn(&columns.forms()[0], &short), Err(PrepError::Length { .. })));
    assert!(columns.forms()[1].within(0..301).is_none());
}

#[test]
fn stated_noise_matches_simulated_noise() {
    /// Relative scatter of a standard deviation over 20,000 samples, four sigma, with their correlation.
    const SCATTER: f64 = 0.03;
    let noise = [2e-3, 1e-3, 3e-3];
    let euler = [0.6, -0.4, 1.0];
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let step = 1.0 / 60.0;
    let n = 20_000;
    let time: Vec<f64> = (0..n).map(|k| f64::from(k) * step).collect();
    let mut column = |axis: usize| -> Vec<f64> {
        time.iter().map(|_| euler[axis] + noise[axis] * rng.sample::<f64, _>(StandardNormal)).collect()
    };
    let (phi, theta, psi) = (column(0), column(1), column(2));
    let attitude = SensorAttitude::Euler { phi: &phi, theta: &theta, psi: &psi };
    let deviation = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    };
    // Thesis Eqs. 4.6 and 4.7 at rest: the squares of the weights of the difference sum to 130/144.
    let rates = sensor_rates(&time, &attitude, Differentiation::Central4).unwrap();
    let angles = (euler[0].sin() * noise[1]).hypot(euler[0].cos() * euler[1].cos() * noise[2]);
    let stated = angles * (130.0f64 / 144.0).sqrt() / step;
    assert!((deviation(&rates[2]) / stated - 1.0).abs() < SCATTER, "{} for {stated}", deviation(&rates[2]));
    let turn = integrated_turn(&time, &attitude, None, Differentiation::Central4).unwrap();
    let stated = integrated_turn_noise(euler, noise);
    assert!((deviation(&turn) / stated - 1.0).abs() < SCATTER, "{} for {stated}", deviation(&turn));
    // Through the slope of Table 4.2.
    let linkage = c337f().control;
    let aileron = deflection_noise(|yoke| aileron_deflection(&linkage, yoke), 0.2, stated);
    assert!((aileron - 0.162 * stated).abs() < 1e-12);
}

#[test]
fn instrument_file_rejects_what_no_installation_has_and_names_the_line() {
    let text = std::fs::read_to_string(asset("aircraft/c337f_instruments.toml")).unwrap();
    let refused = |from: &str, to: &str| instruments::parse(&text.replacen(from, to, 1)).unwrap_err();
    assert!(matches!(refused("doublet instruments", "doublet aircraft"), InstrumentError::Format { .. }));
    let line = text.lines().position(|line| line.starts_with("drum_radius_mm")).unwrap() + 1;
    let unknown = refused("drum_radius_mm", "drum_diameter_mm");
    assert!(matches!(unknown, InstrumentError::Syntax { .. }), "{unknown}");
    let wrong = refused("drum_radius_mm = 12.45", "drum_radius_mm = \"x\"");
    assert!(wrong.to_string().starts_with(&format!("line {line}:")), "{wrong}");
    for (from, to, key) in [
        ("drum_radius_mm = 12.45", "drum_radius_mm = -1.0", "drum_radius_mm"),
        ("offset_cm = 2.5", "offset_cm = 25.0", "offset_cm"),
        ("range_m = [-0.0540, 0.0668]", "range_m = [0.0668, -0.0540]", "right_pedal"),
        ("[0.0, 20.0, 39.0", "[0.0, 47.0, 39.0", "main left"),
        ("[0.0, 33.18, 49.78", "[0.0, 49.78, 49.78", "main left"),
        ("[0.0, 33.18, 49.78", "[33.18, 49.78", "main left"),
    ] {
        let error = refused(from, to).to_string();
        assert!(error.contains(key) && !error.contains('\n'), "{error}");
    }
}
