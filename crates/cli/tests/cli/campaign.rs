//! Cards of a campaign flown by the simulator and evaluated by their least squares, beside the truth.

use serde_json::Value;

use crate::common::at_root::{document, doublet, text};

/// Slopes of a card in the evaluation: value, standard error and, where there is one, that of the identified derivatives.
fn slope(found: &Value, card: &str, name: &str) -> (f64, f64, Option<f64>) {
    let point = found["points"].as_array().unwrap().iter().find(|point| point["id"] == card).unwrap();
    let rows = point["evaluation"].as_array().unwrap_or_else(|| panic!("card {card} is not evaluated: {point}"));
    let row = rows.iter().find(|row| row["name"] == name).unwrap();
    (row["value"].as_f64().unwrap(), row["standard_error"].as_f64().unwrap(), row["model"].as_f64())
}

/// Cards S1 to S6 of the shipped campaign and doublets to identify from, flown once and evaluated without an edit of any file.
#[test]
fn cards_of_steady_flight_and_power_are_flown_and_their_least_squares_are_those_of_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let mut campaign = include_str!("../../../../assets/campaigns/c337f_static.toml").to_owned();
    for (id, surface, directions, step_s, amplitude) in [
        ("D1", "elevator", "down first, up first", 0.9, 2.0),
        ("D2", "aileron", "right first, left first", 1.0, 4.0),
        ("D3", "rudder", "right first, left first", 1.4, 2.8),
    ] {
        campaign += &format!(
            "\n[[point]]\nid = \"{id}\"\nairspeed_m_s = 52.0\naltitude_m = 1219.2\nkind = \"doublet\"\nsurface = \"{surface}\"\n\
             direction = \"{directions}\"\namplitude_deg = {amplitude:?}\nstep_s = {step_s:?}\nrepeats = 2\nhazard = \"low\"\n"
        );
    }
    std::fs::write(place("campaign.toml"), campaign).unwrap();
    let cards = doublet(&[
        "campaign",
        &place("campaign.toml"),
        "--session",
        "sessions/demo.toml",
        "--out",
        &place("D"),
        "--format",
        "html",
    ]);
    assert!(cards.status.success(), "{}", text(&cards.stderr));
    let flown = doublet(&["simulate", &place("D/campaign_scenario.toml"), "--out", &place("D/flight")]);
    assert!(flown.status.success(), "{}", text(&flown.stderr));
    let found =
        document(&["campaign", &place("campaign.toml"), "--session", &place("D/campaign_session.toml"), "--json"]);
    let points = found["points"].as_array().unwrap();
    for point in points {
        assert_eq!(
            point["windows"].as_array().unwrap().len() as u64,
            point["repeats"].as_u64().unwrap(),
            "{}",
            point["id"]
        );
    }
    let truth: toml::Table = std::fs::read_to_string(place("D/flight/truth.toml")).unwrap().parse().unwrap();
    let of = |name: &str| truth["derivatives"][name].as_float().unwrap();
    check_sideslip(&found, &of);
    check_turn(&found, &of, points);
    // CD = 0.03 + 0.086 CL^2 is what the truth was made for (assets/aircraft/c337f_truth.toml): its CX and CZ give it within their rounding.
    let (zero_lift, zero_lift_error, _) = slope(&found, "S3", "drag coefficient without lift");
    let (induced, induced_error, _) = slope(&found, "S3", "drag per lift squared");
    println!("CD0 {zero_lift} ± {zero_lift_error}, k {induced} ± {induced_error}");
    let [true_zero_lift, true_induced] = true_polar(&of);
    // Two accelerations determine the polar poorly, and their errors state it.
    assert!(
        (zero_lift - true_zero_lift).abs() < 1.96 * zero_lift_error && zero_lift_error < 0.01,
        "{zero_lift} for {true_zero_lift}"
    );
    assert!(
        (induced - true_induced).abs() < 1.96 * induced_error && induced_error < 0.04,
        "{induced} for {true_induced}"
    );
}

/// Deflections and bank per sideslip, by Cramer's rule from the truth.
fn check_sideslip(found: &Value, of: &dyn Fn(&str) -> f64) {
    let determinant = of("Cl_delta_a") * of("Cn_delta_r") - of("Cl_delta_r") * of("Cn_delta_a");
    let rudder = (of("Cl_beta") * of("Cn_delta_a") - of("Cl_delta_a") * of("Cn_beta")) / determinant;
    let aileron = (of("Cn_beta") * of("Cl_delta_r") - of("Cl_beta") * of("Cn_delta_r")) / determinant;
    for (name, truth) in [("rudder per sideslip", rudder), ("aileron per sideslip", aileron)] {
        let (value, error, model) = slope(found, "S1", name);
        println!("{name} {value} ± {error}, model {model:?}, truth {truth}");
        assert!((value / truth - 1.0).abs() < 0.02, "{name}: {value} ± {error} for {truth}");
        assert!((model.unwrap() / truth - 1.0).abs() < 0.05, "{name}: model {model:?} for {truth}");
    }
    let (value, _, model) = slope(found, "S1", "bank per sideslip");
    println!("bank per sideslip {value}, model {model:?}");
    assert!((value / model.unwrap() - 1.0).abs() < 0.02, "bank: {value} for {model:?}");
}

/// Elevator and angle of attack per load factor of a turn at constant airspeed, from the truth at the mass and density of the card.
fn check_turn(found: &Value, of: &dyn Fn(&str) -> f64, points: &[Value]) {
    let point = points.iter().find(|point| point["id"] == "S2").unwrap();
    let number = |key: &str| point[key].as_f64().unwrap();
    let (airspeed, weight) = (number("airspeed_m_s"), number("mass_kg") * 9.80665);
    // Air of the simulated day at 1,219 m: 101,325 Pa and 296.65 K at sea level.
    let temperature = 296.65 - 0.0065 * 1219.2;
    let density = 101_325.0 * (temperature / 296.65f64).powf(5.255_88) / (287.053 * temperature);
    let (area, chord) = (18.7, 1.68);
    let load_factor: f64 = 1.15;
    let rate = 9.80665 / airspeed * (1.0 + load_factor.powi(-2)) * chord / airspeed;
    let force = -weight / (0.5 * density * airspeed * airspeed * area) - of("CZ_q") * rate;
    let moment = -of("Cm_q") * rate;
    let determinant = of("CZ_alpha") * of("Cm_delta_e") - of("CZ_delta_e") * of("Cm_alpha");
    let alpha = (force * of("Cm_delta_e") - of("CZ_delta_e") * moment) / determinant;
    let elevator = (of("CZ_alpha") * moment - of("Cm_alpha") * force) / determinant;
    for (name, truth) in [("elevator per load factor", elevator), ("angle of attack per load factor", alpha)] {
        let (value, error, model) = slope(found, "S2", name);
        println!("{name} {value} ± {error}, model {model:?}, truth {truth}");
        assert!((value / truth - 1.0).abs() < 0.04, "{name}: {value} ± {error} for {truth}");
        assert!((model.unwrap() / truth - 1.0).abs() < 0.03, "{name}: model {model:?} for {truth}");
    }
}

/// Drag without lift and drag per lift squared of the truth, by a line over trimmed angles of attack of 52 to 65 m/s.
fn true_polar(of: &dyn Fn(&str) -> f64) -> [f64; 2] {
    let at = |alpha: f64| {
        let elevator = -(of("Cm_0") + of("Cm_alpha") * alpha) / of("Cm_delta_e");
        let x = of("CX_0") + of("CX_alpha") * alpha + of("CX_alpha2") * alpha * alpha + of("CX_delta_e") * elevator;
        let z = of("CZ_0") + of("CZ_alpha") * alpha + of("CZ_delta_e") * elevator;
        (-x * alpha.cos() - z * alpha.sin(), -z * alpha.cos() + x * alpha.sin())
    };
    let rows: Vec<(f64, f64)> =
        (0..=20).map(|k| at(0.02 + 0.003 * f64::from(k))).map(|(drag, lift)| (drag, lift * lift)).collect();
    let count = rows.len() as f64;
    let (drag, square) =
        (rows.iter().map(|row| row.0).sum::<f64>() / count, rows.iter().map(|row| row.1).sum::<f64>() / count);
    let slope = rows.iter().map(|row| (row.1 - square) * (row.0 - drag)).sum::<f64>()
        / rows.iter().map(|row| (row.1 - square).powi(2)).sum::<f64>();
    [drag - slope * square, slope]
}
