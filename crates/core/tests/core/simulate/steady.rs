//! Manoeuvres of steady flight and of power, flown by the pilot of a scenario file.

use std::fmt::Write;

use doublet_core::simulate::{Flight, Hands, run, scenario};

/// A scenario at 52 m/s and 4,000 ft without gusts.
fn scenario_text(manoeuvres: &str) -> String {
    let mut text =
        String::from("format = \"doublet scenario\"\nversion = 1\naircraft = \"c337f\"\nairspeed_m_s = 52.0\n");
    let _ = writeln!(text, "altitude_m = 1219.2\ngust_m_s = 0.0\n\n{manoeuvres}");
    text
}

fn fly(manoeuvres: &str) -> Flight {
    run(&scenario::parse(&scenario_text(manoeuvres)).unwrap(), 1, &mut |_| true).unwrap()
}

/// Mean of a true history over part of a manoeuvre, s after its onset.
fn mean(flight: &Flight, name: &str, manoeuvre: usize, (from_s, to_s): (f64, f64)) -> f64 {
    let onset_s = flight.manoeuvres[manoeuvre].manoeuvre.onset_s;
    let at = |time_s: f64| flight.truth.time_s.partition_point(|time| *time < onset_s + time_s);
    let values = &flight.truth.column(name).unwrap()[at(from_s)..at(to_s)];
    values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64
}

#[test]
fn sideslip_is_straight_and_its_deflections_leave_no_moment() {
    let flight = fly(
        "[[manoeuvre]]\nname = \"sideslip\"\nduration_s = 45.0\ntime_s = [5.0, 10.0, 35.0, 40.0]\nsideslip_rad = [0.0, 0.1, 0.1, 0.0]\n",
    );
    assert_eq!(flight.manoeuvres[0].hands(), Hands::Sideslip);
    let steady = |name: &str| mean(&flight, name, 0, (25.0, 35.0));
    // The hands bring the last part about slowly.
    assert!((steady("beta") - 0.1).abs() < 0.01, "sideslip {}", steady("beta"));
    for rate in ["p", "q", "r"] {
        assert!(steady(rate).abs() < 0.003, "{rate} {}", steady(rate));
    }
    assert!((steady("airspeed") - 52.0).abs() < 1.0, "airspeed {}", steady("airspeed"));
    // Deflections without rolling and yawing moment: Cl_beta b + Cl_da a + Cl_dr r = 0, Cn alike, by Cramer's rule.
    let aero = &flight.scenario.vehicle.aero;
    let of = |name: &str| aero.value(name).unwrap();
    let determinant = of("Cl_delta_a") * of("Cn_delta_r") - of("Cl_delta_r") * of("Cn_delta_a");
    let rudder = (of("Cl_beta") * of("Cn_delta_a") - of("Cl_delta_a") * of("Cn_beta")) / determinant;
    let aileron = (of("Cn_beta") * of("Cl_delta_r") - of("Cl_beta") * of("Cn_delta_r")) / determinant;
    let trim = |name: &str| mean(&flight, name, 0, (0.0, 4.0));
    for (name, expected) in [("delta_r", rudder), ("delta_a", aileron)] {
        let found = (steady(name) - trim(name)) / (steady("beta") - trim("beta"));
        assert!((found / expected - 1.0).abs() < 0.03, "{name}: {found} for {expected}");
    }
}

#[test]
fn turn_holds_its_bank_and_airspeed_and_has_the_load_factor_of_a_turn() {
    let flight = fly(
        "[[manoeuvre]]\nname = \"turn\"\nduration_s = 60.0\ntime_s = [5.0, 15.0, 50.0, 58.0]\nbank_rad = [0.0, 0.6, 0.6, 0.0]\n",
    );
    let steady = |name: &str| mean(&flight, name, 0, (35.0, 50.0));
    assert!((steady("phi") - 0.6).abs() < 0.02, "bank {}", steady("phi"));
    assert!((steady("airspeed") - 52.0).abs() < 1.5, "airspeed {}", steady("airspeed"));
    let load_factor = -steady("az") / 9.80665;
    assert!((load_factor - 1.0 / 0.6f64.cos()).abs() < 0.03, "load factor {load_factor}");
    assert!(steady("beta").abs() < 0.01, "sideslip {}", steady("beta"));
}

#[test]
fn power_moves_thrust_only_and_level_flight_keeps_its_altitude() {
    // A doublet of 4 inHg with the controls held, then a level acceleration by 7 inHg from another airspeed.
    let flight = fly("[[manoeuvre]]\nname = \"power\"\nduration_s = 25.0\ntime_s = [3.0, 3.0, 7.0, 7.0, 11.0, 11.0]\n\
         manifold_pa = [0.0, 13546.0, 13546.0, -13546.0, -13546.0, 0.0]\n\n\
         [[manoeuvre]]\nname = \"acceleration\"\nduration_s = 60.0\nairspeed_m_s = 48.0\nlevel = true\n\
         time_s = [5.0, 6.0, 60.0]\nmanifold_pa = [0.0, 23705.0, 23705.0]\n");
    let thrust = |manoeuvre, part| mean(&flight, "thrust_1", manoeuvre, part);
    assert!(
        thrust(0, (6.0, 7.0)) > 1.2 * thrust(0, (1.0, 3.0)) && thrust(0, (10.0, 11.0)) < 0.8 * thrust(0, (1.0, 3.0))
    );
    for name in ["delta_a", "delta_e", "delta_r"] {
        let moved = mean(&flight, name, 0, (6.0, 7.0)) - mean(&flight, name, 0, (1.0, 3.0));
        assert!(moved.abs() < 1e-6, "{name} moved by {moved}");
    }
    let airspeed = |part| mean(&flight, "airspeed", 1, part);
    assert!((airspeed((0.0, 4.0)) - 48.0).abs() < 1.0, "the pilot goes to 48 m/s first: {}", airspeed((0.0, 4.0)));
    assert!(airspeed((55.0, 60.0)) > 56.0, "accelerated to {}", airspeed((55.0, 60.0)));
    let climbed = mean(&flight, "z", 1, (55.0, 60.0)) - mean(&flight, "z", 1, (0.0, 4.0));
    assert!(climbed.abs() < 15.0, "altitude moved by {climbed}");
}

#[test]
fn file_that_states_two_ways_to_fly_or_a_deflection_beside_the_pilot_is_refused() {
    let refused = |own: &str| {
        let text = format!("[[manoeuvre]]\nname = \"a\"\nduration_s = 10.0\ntime_s = [0.0, 5.0]\n{own}\n");
        scenario::parse(&scenario_text(&text)).unwrap_err().to_string()
    };
    assert!(refused("bank_rad = [0.0, 0.1]\nlevel = true").contains("one of sideslip_rad, bank_rad and level"));
    assert!(refused("bank_rad = [0.0, 0.1]\nrudder_rad = [0.0, 0.1]").contains("no deflection can be stated"));
    assert!(refused("manifold_pa = [0.0]").contains("manifold_pa has 1 values, time_s 2"));
}
