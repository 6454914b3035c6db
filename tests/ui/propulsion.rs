//! Charts of the propulsion: the propeller's map with the flight on it, and the partial derivatives of the engine at a condition that is
//! typed, beside those of the core and of the thesis.

use doublet::notation;
use doublet::panels::Pane;
use doublet_core::propulsion::{EngineOutput, EnginePoint, PointInput};
use doublet_engine::graph::Context;
use doublet_engine::stage::{engine_partials, load_aircraft, propeller_curves};
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

use crate::help::unexplained;
use crate::workbench::Bench;
use crate::{copied_data, picture};

#[test]
fn propeller_map_and_partial_derivatives_are_those_of_the_model() {
    let mut bench = Bench::shipped_in(1366.0, 768.0);
    bench.show(Pane::Propulsion);
    bench.click("Propeller map");
    picture(&mut bench.harness, "propeller_map");
    let engines =
        bench.snapshot().engines.values().find_map(|slot| slot.ready()).expect("the flight has engines").clone();
    let engine = &engines.engines[0];
    let chart = format!("efficiency of {}", engine.curves.name);
    let place = bench.harness.get_by_role_and_label(Role::Image, &chart).rect();
    let text = copied_data(&mut bench.harness, place.center());
    let line = &engine.curves.lines[3];
    assert!(text.lines().next().is_some_and(|head| head.starts_with("advance ratio J,")), "{text:.120}");
    assert!(text.contains(&format!("CP {}", notation::number(line.power_coefficient))));
    let [ratio, efficiency] = line.efficiency[20];
    assert!(text.lines().any(|row| row.starts_with(&format!("{ratio},")) && row.contains(&efficiency.to_string())));
    // In flight the propeller pulls, and its efficiency is that of the map.
    let flown: Vec<f64> = engine.efficiency.values.iter().copied().filter(|value| value.is_finite()).collect();
    let most = flown.iter().copied().fold(0.0, f64::max);
    assert!((0.6..0.95).contains(&most), "{most}");

    bench.click("Partial derivatives");
    picture(&mut bench.harness, "partials_flown");
    // Testing conditions of thesis Table 7.14: 2350 rpm, 17.5 inHg, 296.65 K (296.6 is typed), 1219 m, 46 m/s.
    let typed = [
        ("engine speed", "2350"),
        ("manifold pressure", "592.6"),
        ("temperature at sea level", "296.6"),
        ("pressure altitude", "1219"),
        ("true airspeed", "46"),
    ];
    for (name, value) in typed {
        bench.enter(&format!("partials at {name}"), value);
    }
    picture(&mut bench.harness, "partials");
    assert_eq!(unexplained(&bench), [""; 0]);
    let point = EnginePoint {
        speed_rad_s: 2350.0 * std::f64::consts::TAU / 60.0,
        manifold_pressure_pa: 59_260.0,
        sea_level_temperature_k: 296.6,
        pressure_altitude_m: 1219.0,
        airspeed_m_s: 46.0,
    };
    let aircraft = bench.snapshot().aircraft.ready().expect("it is read").clone();
    let model = aircraft.powerplant.engines[0].model.as_ref().expect("it has a model");
    let found = engine_partials(model, &point).expect("it is in the troposphere");
    let expected = [
        1e-3 * found.nominal.power_w,
        found.nominal.thrust_n,
        found.nominal.total_pressure_rise,
        found.partial(EngineOutput::Thrust, PointInput::Airspeed),
        100.0 * found.partial(EngineOutput::Thrust, PointInput::ManifoldPressure),
    ];
    for value in expected {
        let text = notation::number(value);
        assert!(bench.harness.query_all_by_label(&text).next().is_some(), "the table says {text}");
    }
    // The thesis: 86.7 hp, 1172.7 N, 0.372; dT/dV -18.8 N per m/s.
    let hp = found.nominal.power_w / 745.699_87;
    assert!((hp / 86.7 - 1.0).abs() < 0.005 && (found.nominal.thrust_n / 1172.7 - 1.0).abs() < 0.01, "{found:?}");
    assert!((found.nominal.total_pressure_rise / 0.372 - 1.0).abs() < 0.01);
    assert!((found.partial(EngineOutput::Thrust, PointInput::Airspeed) / -18.8 - 1.0).abs() < 0.05);
}

#[test]
fn lines_of_the_shipped_propeller_are_its_map_over_its_whole_range() {
    let loaded = load_aircraft(&Context::new(std::path::Path::new(".")), "builtin:c337f").expect("it is shipped");
    let model = loaded.powerplant.engines[0].model.as_ref().expect("it has a model");
    let speed_rad_s = 2600.0 * std::f64::consts::TAU / 60.0;
    let curves = propeller_curves(&model.propeller, speed_rad_s, 0.0);
    assert!(curves.lines.len() > 4);
    for line in &curves.lines {
        assert!(line.efficiency.len() > 40 && line.efficiency[0][0] < line.efficiency[1][0]);
        for (at, other) in line.efficiency.iter().zip(&line.thrust) {
            let point = model.propeller.lookup(at[0], line.power_coefficient, speed_rad_s, 0.0);
            assert!(point.off_range.iter().all(|range| range.excess() < 1e-9), "J {} is inside the map", at[0]);
            assert_eq!((at[0], at[1], other[1]), (other[0], point.efficiency, point.thrust_coefficient));
        }
    }
    // More power at the same advance ratio gives more thrust (thesis Fig. 6.17b).
    let middle: Vec<f64> = curves.lines.iter().map(|line| line.thrust[line.thrust.len() / 2][1]).collect();
    assert!(middle.windows(2).all(|pair| pair[1] > pair[0]), "{middle:?}");
}
