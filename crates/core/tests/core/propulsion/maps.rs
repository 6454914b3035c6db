//! Files of charts and maps: what they refuse, and the procedure on charts with known answers.

use std::path::Path;

use doublet_core::airframe::EngineStation;
use doublet_core::load::propulsion_maps::{PropulsionSection, parse_engine_chart, parse_propeller_map};
use doublet_core::load::read_text;
use doublet_core::propulsion::{Ambient, EngineColumns, EngineInput, EngineModel, EngineState, MapVariable, RotorSum};
use proptest::prelude::*;

use super::support::{HP, IN_HG, RPM, c337f, folder, model};

/// Powers of hand-made charts are exact to round-off, W.
const ROUND_OFF_W: f64 = 1e-6;

/// A chart whose power is `N/1000 * (p - 10)` hp at sea level and falls to nothing at 30000 ft, full throttle
/// `30 - h/1000` inHg: small enough to follow the six steps by hand.
const HAND_CHART: &str = r#"
format = "doublet engine chart"
version = 1
engine = "by hand"
origin = "test"
speed_rpm = [1000.0, 2000.0]
[sea_level]
manifold_pressure_inHg = [10.0, 30.0]
power_hp = [[0.0, 20.0], [0.0, 40.0]]
[full_throttle]
altitude_ft = [0.0, 20000.0]
manifold_pressure_inHg = [[30.0, 10.0], [30.0, 10.0]]
power_hp = [[20.0, 10.0], [40.0, 20.0]]
"#;

fn message(result: Result<impl Sized, impl std::fmt::Display>) -> String {
    result.err().map(|error| error.to_string()).unwrap_or_default()
}

#[test]
fn chart_power_follows_the_six_steps_by_hand() {
    let chart = parse_engine_chart(HAND_CHART, Path::new("hand.toml")).unwrap();
    // N 1500, p 20: A at 10000 ft, 22.5 hp; B 15 hp; D at 4000 ft is 18 hp; standard temperature.
    let standard_k = 288.15 - 0.0065 * 4000.0 * 0.3048;
    let power = chart.power_w(1500.0 * RPM, 20.0 * IN_HG, 4000.0 * 0.3048, standard_k);
    assert!((power.value_w - 18.0 * HP).abs() < ROUND_OFF_W, "{}", power.value_w / HP);
    assert!(power.off_range.is_empty());
    // 10 degF warmer: 1 % less.
    let warm = chart.power_w(1500.0 * RPM, 20.0 * IN_HG, 4000.0 * 0.3048, standard_k + 10.0 / 1.8);
    assert!((warm.value_w - 0.99 * 18.0 * HP).abs() < ROUND_OFF_W);
    // Beyond all three: 500 rpm (B 5 hp, A 7.5 hp at 10000 ft), 12000 ft: 8 hp.
    let beyond = chart.power_w(500.0 * RPM, 20.0 * IN_HG, 12_000.0 * 0.3048, 288.15 - 0.0065 * 12_000.0 * 0.3048);
    assert!((beyond.value_w - 8.0 * HP).abs() < ROUND_OFF_W);
    let speed = beyond.off_range.get(MapVariable::EngineSpeed).unwrap();
    assert!((speed.excess() + 500.0 * RPM).abs() < 1e-9);
    let altitude = beyond.off_range.get(MapVariable::PressureAltitude).unwrap();
    assert!((altitude.excess() - 2000.0 * 0.3048).abs() < 1e-9);
    assert!(beyond.off_range.get(MapVariable::ManifoldPressure).is_none());
}

#[test]
fn chart_power_is_continuous_where_full_throttle_is_at_sea_level() {
    let chart = model().chart;
    let speed = 2700.0 * RPM;
    let at = |in_hg: f64| chart.power_w(speed, in_hg * IN_HG, 300.0, 286.0).value_w / HP;
    // Full throttle at sea level lies between 28.0 and 28.1 inHg here; 0.001 inHg is worth 0.011 hp, and the chord
    // differs from its limit by the curvature of the lines over 30 m and the rounding of the tables: below 0.1 hp.
    let mut previous = at(27.9);
    for step in 1..400 {
        let power = at(27.9 + 0.001 * f64::from(step));
        assert!((power - previous).abs() < 0.1, "{power} after {previous} hp at step {step}");
        previous = power;
    }
}

#[test]
fn map_files_refuse_what_they_do_not_know() {
    let path = Path::new("x.toml");
    let with = |from: &str, to: &str| HAND_CHART.replace(from, to);
    let chart = |text: &str| message(parse_engine_chart(text, path));
    assert_eq!(
        chart(&with("doublet engine chart", "doublet propeller map")),
        "x.toml: format is 'doublet propeller map', expected 'doublet engine chart'"
    );
    assert_eq!(
        chart(&with("version = 1", "version = 2")),
        "x.toml: version 2 of the format, this program reads version 1"
    );
    assert!(chart(&with("origin = ", "colour = 1\norigin = ")).starts_with("x.toml, line 5: unknown field `colour`"));
    assert_eq!(
        chart(&with("[30.0, 10.0], [30.0, 10.0]", "[30.0, 10.0], [30.0, 30.0]")),
        "x.toml: full-throttle manifold pressure[1][1] is 101591.67: values must be finite and decrease strictly"
    );
    assert!(chart(&with("[0.0, 20.0], ", "")).contains("rows of sea-level power has 1 values where its grid has 2"));
    assert!(chart(&with("[0.0, 20.0]", "[0.0, nan]")).contains("sea-level power[0][1] is NaN"));
    assert!(chart(&with("speed_rpm = [1000.0, 2000.0]", "speed_rpm = [1000.0]")).contains("at least 2 are needed"));
    assert!(chart("format").starts_with("x.toml, line 1: "));
    assert!(chart("").contains("missing field"));
    for text in ["", "format", HAND_CHART, &with("20.0", "x"), "\u{0}\u{feff}"] {
        assert_eq!(chart(text).lines().count().max(1), 1);
        assert!(!message(parse_propeller_map(text, path)).contains('\n'));
    }
}

#[test]
fn propeller_map_asks_for_every_pair_of_level_and_speed_once() {
    let text = std::fs::read_to_string(folder().join("mtv12_propeller.toml")).unwrap();
    let path = Path::new("m.toml");
    assert!(parse_propeller_map(&text, path).is_ok());
    let twice = text.replacen("speed_rpm = 2600.0\nefficiency", "speed_rpm = 2400.0\nefficiency", 1);
    assert!(message(parse_propeller_map(&twice, path)).contains("is given 2 times"));
    let short = text.replace("diameter_m = 1.92", "diameter_m = -1.92");
    assert_eq!(
        message(parse_propeller_map(&short, path)),
        "m.toml: diameter is -1.92, allowed is a finite number above 0"
    );
}

#[test]
fn propulsion_section_names_the_engine_that_is_wrong() {
    let stations =
        [EngineStation { name: "e".to_owned(), position_from_datum_m: [8.0, -1.4, 2.0], incidence_rad: 0.0 }];
    let section =
        |text: &str| toml::from_str::<PropulsionSection>(text).unwrap().powerplant(&stations, &folder(), read_text);
    let engine = "[[engine]]\nname = \"e\"\n";
    let half = format!("{engine}chart = \"io360_chart.toml\"\n");
    assert_eq!(
        message(section(&half)),
        "propulsion.engine 'e' has no propeller: give both chart and propeller, or neither"
    );
    assert_eq!(
        message(section(&format!("{engine}rotor_inertia_kg_m2 = -1.0"))),
        "propulsion.engine 'e': rotor_inertia_kg_m2 is -1, allowed is a finite number, 0 or more"
    );
    assert_eq!(
        message(section("[[engine]]\nname = \"left\"")),
        "propulsion.engine 'left' has no station: the aircraft has the engines e"
    );
    assert!(message(section(&format!("{engine}{engine}"))).contains("is given twice"));
    assert!(message(section(&format!("{half}propeller = \"none.toml\""))).contains("none.toml"));
    assert!(toml::from_str::<PropulsionSection>(&format!("{engine}colour = 1")).is_err());
    assert!(section("").unwrap().engines[0].model.is_none(), "a jet whose thrust is recorded");
}

#[test]
fn both_engines_share_one_chart_and_counter_rotate() {
    let powerplant = c337f();
    let models: Vec<&EngineModel> = powerplant.engines.iter().filter_map(|engine| engine.model.as_ref()).collect();
    assert!(std::sync::Arc::ptr_eq(&models[0].chart, &models[1].chart));
    assert_eq!(powerplant.rotor_momentum_body(&[246.0, 246.0], RotorSum::Signed).norm(), 0.0);
}

/// An ambient state at this airspeed and altitude.
fn ambient(airspeed_m_s: f64, pressure_altitude_m: f64) -> Ambient {
    Ambient { airspeed_m_s, pressure_altitude_m, air_temperature_k: 285.0, density_kg_m3: 1.1 }
}

#[test]
fn an_engine_at_rest_and_an_aircraft_at_rest_give_numbers_where_they_are_defined() {
    let model = model();
    let stopped = model.state(EngineInput { speed_rad_s: 0.0, manifold_pressure_pa: 1e5 }, &ambient(50.0, 500.0));
    assert_eq!((stopped.power_w, stopped.thrust_n, stopped.total_pressure_rise), (0.0, 0.0, 0.0));
    let standing: EngineState =
        model.state(EngineInput { speed_rad_s: 250.0, manifold_pressure_pa: 9e4 }, &ambient(0.0, 500.0));
    assert!(standing.thrust_n > 2000.0 && standing.total_pressure_rise.is_nan());
}

#[test]
fn history_equals_its_samples_and_counts_excursions() {
    let model = model();
    let speed = [250.0, 100.0, 240.0, 90.0];
    let pressure = [6e4; 4];
    let airspeed = [50.0; 4];
    let altitude = [800.0; 4];
    let temperature = [285.0; 4];
    let density = [1.1; 4];
    let columns = EngineColumns {
        speed_rad_s: &speed,
        manifold_pressure_pa: &pressure,
        airspeed_m_s: &airspeed,
        pressure_altitude_m: &altitude,
        air_temperature_k: &temperature,
        density_kg_m3: &density,
    };
    let history = model.history(&columns).unwrap();
    for (k, &speed_rad_s) in speed.iter().enumerate() {
        let state = model.state(EngineInput { speed_rad_s, manifold_pressure_pa: 6e4 }, &ambient(50.0, 800.0));
        assert_eq!((history.power_w[k], history.thrust_n[k]), (state.power_w, state.thrust_n));
    }
    let (finding, samples) =
        history.off_range.iter().find(|(finding, _)| finding.variable == MapVariable::EngineSpeed).unwrap();
    assert_eq!((finding.value, *samples), (90.0, 2));
    let short = EngineColumns { density_kg_m3: &density[..3], ..columns };
    assert_eq!(
        message(model.history(&short)),
        "air density has 3 samples where engine speed has 4: resample all engine inputs to one time"
    );
}

#[test]
fn thrust_at_the_edge_is_that_of_the_last_advance_ratio_of_the_map() {
    let model = model();
    let (input, altitude_m) = (EngineInput { speed_rad_s: 260.0, manifold_pressure_pa: 8e4 }, 800.0);
    let fast = model.state(input, &ambient(150.0, altitude_m));
    let range = *fast.off_range.get(MapVariable::AdvanceRatio).unwrap();
    assert_eq!(fast.off_range.iter().count(), 1);
    // Power does not hang on the airspeed: neither does the power coefficient.
    let edge_m_s = range.high * 260.0 / std::f64::consts::TAU * model.propeller.diameter_m();
    let edge = model.state(input, &ambient(edge_m_s, altitude_m));
    let columns = EngineColumns {
        speed_rad_s: &[260.0; 2],
        manifold_pressure_pa: &[8e4; 2],
        airspeed_m_s: &[150.0, 50.0],
        pressure_altitude_m: &[altitude_m; 2],
        air_temperature_k: &[285.0; 2],
        density_kg_m3: &[1.1; 2],
    };
    let history = model.history(&columns).unwrap();
    let at_edge = &history.thrust_at_edge_n;
    assert!((at_edge[0] / edge.thrust_n - 1.0).abs() < 1e-9, "{} {}", at_edge[0], edge.thrust_n);
    assert!((fast.thrust_n - at_edge[0]).abs() > 1.0, "it is extrapolated");
    assert_eq!(at_edge[1], history.thrust_n[1]);
}

proptest! {
    /// Any numbers in: never a panic, and findings exactly where an input leaves its range.
    #[test]
    fn engine_state_survives_any_input(
        speed in prop_oneof![any::<f64>(), -100.0..600.0],
        pressure in prop_oneof![any::<f64>(), 0.0..120_000.0],
        airspeed in prop_oneof![any::<f64>(), -10.0..200.0],
        altitude in prop_oneof![any::<f64>(), -1000.0..9000.0],
    ) {
        let model = model_once();
        let input = EngineInput { speed_rad_s: speed, manifold_pressure_pa: pressure };
        let state = model.state(input, &ambient(airspeed, altitude));
        for finding in state.off_range.iter() {
            prop_assert!(finding.excess() != 0.0 && !finding.to_string().contains('\n'));
        }
        let outside = !speed.is_nan() && !(1800.0 * RPM..=2800.0 * RPM).contains(&speed);
        let near = (speed / RPM - 1800.0).abs() < 1e-6 || (speed / RPM - 2800.0).abs() < 1e-6;
        prop_assert!(near || state.off_range.get(MapVariable::EngineSpeed).is_some() == outside);
    }
}

/// The shipped model, read once.
fn model_once() -> &'static EngineModel {
    static MODEL: std::sync::OnceLock<EngineModel> = std::sync::OnceLock::new();
    MODEL.get_or_init(model)
}
