//! Shipped channel maps against physics: level flight, rates against attitudes, first responses to controls.

use std::path::Path;

use doublet_core::load::{ChannelMap, plan, probe, read, read_all};
use doublet_core::quantity::Role;
use doublet_core::series::{Recording, Series};

use crate::shared::shared;

/// Gravity for sign and scale checks, m/s².
const GRAVITY_M_S2: f64 = 9.81;

fn map(name: &str) -> ChannelMap {
    let (_, text) = ChannelMap::shipped().iter().find(|(shipped, _)| *shipped == name).unwrap();
    ChannelMap::parse(text).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn load(path: &Path, map: &ChannelMap) -> Recording {
    let plan = plan(&probe(path).unwrap(), map);
    assert!(!plan.has_errors(), "{:?}", plan.problems);
    read(&plan).unwrap()
}

fn series(recording: &Recording, role: Role) -> &Series {
    &recording.role(role).unwrap_or_else(|| panic!("no {}", role.name())).series
}

/// Values of `role` between two times.
fn window(recording: &Recording, role: Role, start_s: f64, end_s: f64) -> Vec<f64> {
    let series = series(recording, role);
    let range = doublet_core::series::TimeRange { start_s, end_s }.indices(&series.time_s);
    series.values[range].to_vec()
}

#[test]
fn elevons_and_v_tails_are_mixed_to_the_deflections_of_the_conventions() {
    let header = "format = \"doublet channel map\"\nversion = 1\nname = \"t\"\n";
    let rows: String = (0..20).map(|k| format!("{},{},{},{}\n", 0.1 * f64::from(k), 2.0, 6.0, -3.0)).collect();
    let (_folder, path) = super::written("run.csv", format!("time [s],L,R,REV\n{rows}"));
    let degrees = |recording: &Recording, role| series(recording, role).values[3].to_degrees();
    let read = |mixing: &str| {
        let map = ChannelMap::parse(&format!("{header}[mixing]\n{mixing}\n")).unwrap();
        load(&path, &map)
    };
    // Left 2 deg, right 6 deg, both trailing edge down.
    let elevons = read("elevons = { left = \"L\", right = \"R\", unit = \"deg\" }");
    assert!((degrees(&elevons, Role::Elevator) - 4.0).abs() < 1e-12, "up and down together");
    assert!(
        (degrees(&elevons, Role::Aileron) - 2.0).abs() < 1e-12,
        "the right one further down is a right aileron down"
    );
    let tail = read("v_tail = { left = \"L\", right = \"R\", unit = \"deg\" }");
    assert!((degrees(&tail, Role::Elevator) - 4.0).abs() < 1e-12);
    assert!(
        (degrees(&tail, Role::Rudder) + 2.0).abs() < 1e-12,
        "the right panel further down pulls the tail to the left"
    );
    let turned = read("flaperons = { left = \"L\", right = \"REV\", right_sign = -1, unit = \"deg\" }");
    assert!(
        (degrees(&turned, Role::Flap) - 2.5).abs() < 1e-12 && (degrees(&turned, Role::Aileron) - 0.5).abs() < 1e-12
    );
    let fault = |text: &str| ChannelMap::parse(&format!("{header}{text}")).unwrap_err().to_string();
    let twice = "[roles]\ndelta_e = { channel = \"E\" }\n[mixing]\nelevons = { left = \"L\", right = \"R\" }\n";
    assert!(fault(twice).contains("gives delta_e twice"), "{}", fault(twice));
    assert!(fault("[mixing]\nwing = { left = \"L\", right = \"R\" }\n").contains("use one of elevons, tailerons"));
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Slope of the line through `y` against `x`, and their correlation.
fn line(x: &[f64], y: &[f64]) -> (f64, f64) {
    let (mx, my) = (mean(x), mean(y));
    let sum = |a: &[f64], ma: f64, b: &[f64], mb: f64| a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum::<f64>();
    let (xx, xy, yy) = (sum(x, mx, x, mx), sum(x, mx, y, my), sum(y, my, y, my));
    (xy / xx, xy / (xx * yy).sqrt())
}

fn central_difference(values: &[f64], step_s: f64) -> Vec<f64> {
    values.windows(3).map(|three| (three[2] - three[0]) / (2.0 * step_s)).collect()
}

/// Slope and correlation of the differentiated bank and pitch angle against what the rates say they do.
fn attitude_lines(recording: &Recording, start_s: f64, end_s: f64) -> [(f64, f64); 2] {
    let get = |role| window(recording, role, start_s, end_s);
    let (phi, theta) = (get(Role::BankAngle), get(Role::PitchAngle));
    let (p, q, r) = (get(Role::RollRate), get(Role::PitchRate), get(Role::YawRate));
    let time = &series(recording, Role::BankAngle).time_s;
    let step = time[1] - time[0];
    let phi_dot = |i: usize| p[i] + theta[i].tan() * (q[i] * phi[i].sin() + r[i] * phi[i].cos());
    let theta_dot = |i: usize| q[i] * phi[i].cos() - r[i] * phi[i].sin();
    let inner = 1..phi.len() - 1;
    let expected_phi: Vec<f64> = inner.clone().map(phi_dot).collect();
    let expected_theta: Vec<f64> = inner.map(theta_dot).collect();
    [line(&expected_phi, &central_difference(&phi, step)), line(&expected_theta, &central_difference(&theta, step))]
}

#[test]
fn every_shipped_map_is_read_and_describes_itself() {
    for (name, _) in ChannelMap::shipped() {
        let map = map(name);
        assert!(map.roles.len() > 15 && !map.description.is_empty(), "{name}");
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../assets/channel_maps/{name}.toml"));
        assert_eq!(ChannelMap::read(&file).unwrap(), map);
    }
}

#[test]
fn simulated_citation_with_truth_matches_its_statement() {
    let Some(path) = shared("data/citation_simulated/da3211_1_noisy_with_truth.mat") else { return };
    let recording = load(&path, &map("citation_simulated_truth"));
    assert_eq!((recording.roles.len(), recording.truth.len()), (18, 18));
    let get = |role| &series(&recording, role).values;
    assert_eq!(get(Role::SpecificForceX).len(), 6001);
    // Constant biases and wind of the statement.
    let truth = |name: &str| &recording.truth[name].values;
    assert_eq!((truth("wind_north")[0], truth("wind_east")[6000], truth("wind_down")[3000]), (6.0, 2.0, 10.0));
    assert!((truth("bias_p")[0] - 0.005_f64.to_radians()).abs() < 1e-12);
    // Noise of the statement: 0.2 m/s of airspeed, 0.1 deg of alpha, 1 m of position; a tenth for the sample's scatter.
    let rms = |role: Role, truth: &dyn Fn(usize) -> f64| {
        let values = get(role);
        (values.iter().enumerate().map(|(i, value)| (value - truth(i)).powi(2)).sum::<f64>() / values.len() as f64)
            .sqrt()
    };
    let (u, v, w) = (truth("u"), truth("v"), truth("w"));
    let airspeed = |i: usize| (u[i].powi(2) + v[i].powi(2) + w[i].powi(2)).sqrt();
    assert!((rms(Role::TrueAirspeed, &airspeed) / 0.2 - 1.0).abs() < 0.1);
    assert!((rms(Role::AngleOfAttack, &|i| w[i].atan2(u[i])) / 0.1_f64.to_radians() - 1.0).abs() < 0.1);
    assert!((rms(Role::PositionNorth, &|i| truth("x")[i]) / 1.0 - 1.0).abs() < 0.1);
    assert!((mean(get(Role::SpecificForceZ)[..100].as_ref()) + 9.773).abs() < 0.05, "trim is pitched by 4.5 deg");
}

#[test]
fn simulated_citation_gets_its_controls_from_the_clean_file() {
    let Some(noisy) = shared("data/citation_simulated/da3211_1_noisy_with_truth.mat") else { return };
    let Some(clean) = shared("data/citation_simulated/da3211_1.mat") else { return };
    let recording = read_all(&[&noisy, &clean], &map("citation_simulated_truth")).unwrap();
    let aileron = series(&recording, Role::Aileron);
    assert_eq!(aileron.time_s, series(&recording, Role::RollRate).time_s);
    assert!((aileron.values.iter().copied().fold(0.0, f64::max) - 0.05).abs() < 1e-9);
    // Positive aileron rolls to the left.
    let p_dot = central_difference(&series(&recording, Role::RollRate).values, 0.01);
    let (slope, _) = line(&aileron.values[1..6000], &p_dot);
    assert!(slope < 0.0, "{slope}");
}

#[test]
fn clean_simulated_citation_is_consistent_with_kinematics() {
    for (file, control, rate) in [
        ("da3211_1", Role::Aileron, Role::RollRate),
        ("de3211_1", Role::Elevator, Role::PitchRate),
        ("dedoublet_1", Role::Elevator, Role::PitchRate),
        ("dr3211_1", Role::Rudder, Role::YawRate),
    ] {
        let Some(path) = shared(&format!("data/citation_simulated/{file}.mat")) else { return };
        let recording = load(&path, &map("citation_simulated_clean"));
        for (slope, correlation) in attitude_lines(&recording, 1.0, 59.0) {
            assert!((slope - 1.0).abs() < 1e-3 && correlation > 0.999, "{file}: {slope} {correlation}");
        }
        // First response of the conventions: a positive deflection gives a negative rate.
        let acceleration = central_difference(&series(&recording, rate).values, 0.01);
        let (slope, _) = line(&series(&recording, control).values[1..6000], &acceleration);
        assert!(slope < 0.0, "{file}: {slope}");
        // Without wind the ground speed is the airspeed.
        let speed = |i: usize| {
            let part = |role| series(&recording, role).values[i].powi(2);
            (part(Role::VelocityNorth) + part(Role::VelocityEast) + part(Role::VelocityDown)).sqrt()
        };
        let airspeed = &series(&recording, Role::TrueAirspeed).values;
        for i in [0, 3000, 6000] {
            assert!((speed(i) - airspeed[i]).abs() < 1e-6, "{file} at {i}");
        }
    }
}

#[test]
fn attas_matches_the_published_regressors() {
    let names = ["fAttasElv1", "fAttasAil1", "fAttasRud1"];
    let paths: Vec<_> = names.iter().filter_map(|name| shared(&format!("data/attas/{name}.mat"))).collect();
    let Some(table) = shared("data/attas/regression_table.csv") else { return };
    let recording = read_all(&paths, &map("attas")).unwrap();
    assert_eq!(recording.role(Role::Aileron).unwrap().series.values.len(), 2128, "three files joined in time");
    let probe = doublet_core::load::inspect(&table).unwrap();
    for (role, column) in [(Role::Elevator, "de_rad"), (Role::Aileron, "da_rad"), (Role::Rudder, "dr_rad")] {
        let published = super::channel(&probe, "regression_table", column).values();
        for (i, (value, published)) in series(&recording, role).values.iter().zip(published).enumerate() {
            // The table has 15 digits.
            assert!((value - published).abs() < 1e-14, "{column} at {i}: {value} is not {published}");
        }
    }
}

#[test]
fn attas_is_consistent_with_physics() {
    let Some(path) = shared("data/attas/fAttasAil1.mat") else { return };
    let recording = load(&path, &map("attas"));
    let value = |role| mean(&series(&recording, role).values);
    assert!((value(Role::SpecificForceZ) / -GRAVITY_M_S2 - 1.0).abs() < 0.03, "{}", value(Role::SpecificForceZ));
    let [phi, theta] = attitude_lines(&recording, 50.0, 81.0);
    // Sampled at 25 Hz with rates that carry biases; a wrong unit or sign is off by far more.
    assert!((phi.0 - 1.0).abs() < 0.05 && phi.1 > 0.99, "{phi:?}");
    assert!((theta.0 - 1.0).abs() < 0.15 && theta.1 > 0.9, "{theta:?}");
    // Perfect gas, Mach number and calibrated airspeed agree with pressure, temperature and true airspeed.
    let (pressure, temperature) = (value(Role::StaticPressure), value(Role::AirTemperature));
    assert!((value(Role::AirDensity) / (pressure / (287.05 * temperature)) - 1.0).abs() < 1e-3);
    let mach = value(Role::TrueAirspeed) / (1.4 * 287.05 * temperature).sqrt();
    assert!((value(Role::Mach) / mach - 1.0).abs() < 0.02);
    let impact = pressure * ((1.0 + 0.2 * mach * mach).powf(3.5) - 1.0);
    let calibrated = 340.294 * (5.0 * ((impact / 101_325.0 + 1.0).powf(2.0 / 7.0) - 1.0)).sqrt();
    assert!((value(Role::CalibratedAirspeed) / calibrated - 1.0).abs() < 0.05, "knots, not m/s");
    let (slope, _) = line(&series(&recording, Role::Aileron).values, &series(&recording, Role::RollRate).values);
    assert!(slope < 0.0, "right aileron down rolls left: {slope}");
}

#[test]
fn phlab_is_consistent_with_physics() {
    let Some(path) = shared("data/phlab_citation") else { return };
    let recording = load(&path, &map("phlab_citation"));
    let get = |role, start, end| window(&recording, role, start, end);
    assert_eq!(series(&recording, Role::RollRate).values.len(), 48_321);
    // On the ground and in the long cruise az is -g.
    for (start, end) in [(20.0, 500.0), (3100.0, 3900.0)] {
        let az = mean(&get(Role::SpecificForceZ, start, end));
        assert!((az / -GRAVITY_M_S2 - 1.0).abs() < 0.04, "{az}");
    }
    for (slope, correlation) in attitude_lines(&recording, 3100.0, 4000.0) {
        assert!((slope - 1.0).abs() < 0.03 && correlation > 0.999, "{slope} {correlation}");
    }
    // Pulling up presses down: more pitch rate, more negative az; about V per q.
    let (q, az) = (get(Role::PitchRate, 3635.0, 3650.0), get(Role::SpecificForceZ, 3635.0, 3650.0));
    let airspeed = mean(&get(Role::TrueAirspeed, 3635.0, 3650.0));
    let (slope, correlation) = line(&q, &az);
    assert!(correlation < -0.95 && (slope / -airspeed - 1.0).abs() < 0.3, "{slope} {correlation} {airspeed}");
    // Turning on the ground pushes to the outside: ay is the ground speed times the yaw rate.
    let (slope, correlation) = line(&get(Role::YawRate, 20.0, 585.0), &get(Role::SpecificForceY, 20.0, 585.0));
    assert!(correlation > 0.6 && (2.0..15.0).contains(&slope), "{slope} m/s {correlation}");
    // Aileron against roll rate in the aperiodic roll; rudder against yaw acceleration at the start of the Dutch roll.
    let (slope, correlation) = line(&get(Role::Aileron, 3550.0, 3590.0), &get(Role::RollRate, 3550.0, 3590.0));
    assert!(slope < 0.0 && correlation < -0.95, "{slope} {correlation}");
    let (slope, correlation) = line(&get(Role::Rudder, 3717.0, 3719.0), &get(Role::YawRate, 3717.0, 3719.0));
    assert!(slope < 0.0 && correlation < -0.9, "{slope} {correlation}");
    // Trim: a higher angle of attack needs the trailing edge further up.
    let (slope, correlation) = line(&get(Role::AngleOfAttack, 3100.0, 4000.0), &get(Role::Elevator, 3100.0, 4000.0));
    assert!(slope < 0.0 && correlation < -0.5, "{slope} {correlation}");
    // True airspeed against Mach number and temperature.
    let mach = mean(&get(Role::Mach, 3200.0, 3300.0));
    let sound = (1.4 * 287.05 * mean(&get(Role::AirTemperature, 3200.0, 3300.0))).sqrt();
    assert!((mean(&get(Role::TrueAirspeed, 3200.0, 3300.0)) / (mach * sound) - 1.0).abs() < 0.02);
    // Two engines of about 500 lb/h.
    assert!((mean(&get(Role::FuelFlow, 3100.0, 3900.0)) * 3600.0 / 0.453_592_37 - 1015.0).abs() < 60.0);
}

#[test]
fn small_unmanned_aircraft_is_laid_end_to_end_and_consistent() {
    let Some(path) = shared("data/uav_oat/ProcessedData_2022_05_07_11_13_57.mat") else { return };
    let recording = load(&path, &map("uav_oat"));
    let laid = recording.warnings.iter().filter(|warning| warning.to_string().contains(": its clock plus")).count();
    assert_eq!(laid, 9, "{:?}", recording.warnings);
    let time = &series(&recording, Role::RollRate).time_s;
    assert_eq!(time.len(), 3355);
    assert!(time.windows(2).all(|pair| pair[0] < pair[1]));
    let az = mean(&series(&recording, Role::SpecificForceZ).values);
    assert!((az / -GRAVITY_M_S2 - 1.0).abs() < 0.1, "{az}");
    let cut = |source: &str| load(&path, &ChannelMap { source: source.to_owned(), ..map("uav_oat") });
    let one = cut("ail_1");
    assert_eq!(series(&one, Role::RollRate).values.len(), 360);
    for (slope, correlation) in attitude_lines(&one, 0.0, 8.0) {
        // Small aircraft in rough air at 50 Hz.
        assert!((slope - 1.0).abs() < 0.05 && correlation > 0.8, "{slope} {correlation}");
    }
    // Response a few samples after the command: positive deflection, negative rate.
    for (source, control, rate, lag) in [
        ("ail_1", Role::Aileron, Role::RollRate, 5),
        ("el_1", Role::Elevator, Role::PitchRate, 10),
        ("rud_1", Role::Rudder, Role::YawRate, 0),
    ] {
        let one = cut(source);
        let (control, rate) = (&series(&one, control).values, &series(&one, rate).values);
        let (slope, correlation) = line(&control[..control.len() - lag], &rate[lag..]);
        assert!(slope < 0.0 && correlation < -0.3, "{source}: {slope} {correlation}");
    }
}

#[test]
fn position_is_derived_from_fixes_on_a_flat_earth() {
    let text = "t,lat,lon,h\n0,nan,nan,nan\n1,48,11,1000\n2,48.001,11,1010\n3,48,11.001,990\n";
    let (_folder, path) = super::written("gps.csv", text);
    let map = ChannelMap::parse(
        "format = \"doublet channel map\"\nversion = 1\nname = \"gps\"\n\
         [roles]\nlatitude = { channel = \"lat\", unit = \"deg\" }\nlongitude = { channel = \"lon\", unit = \"deg\" }\n\
         gps_altitude = { channel = \"h\", unit = \"ft\" }\n[derive.position]\naltitude = \"gps_altitude\"\n",
    )
    .unwrap();
    let recording = load(&path, &map);
    let value = |role, i: usize| series(&recording, role).values[i];
    assert!(value(Role::PositionNorth, 0).is_nan());
    // Lengths of a degree at 48 deg: 111.1996 km of latitude, 74.6254 km of longitude (WGS 84), plus the height.
    assert!((value(Role::PositionNorth, 2) - 111.1996 * (1.0 + 304.8 / 6.37e6)).abs() < 0.01);
    assert!((value(Role::PositionEast, 3) - 74.6254 * (1.0 + 304.8 / 6.39e6)).abs() < 0.01);
    assert!((value(Role::PositionDown, 2) + 3.048).abs() < 1e-9);
    assert_eq!(value(Role::PositionNorth, 1), 0.0);
}
