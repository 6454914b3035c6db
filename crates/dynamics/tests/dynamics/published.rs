//! Linear models and modes against published ones: Boeing 747 of NASA CR-2144, Etkin and Reid, a toolbox example; F-4C of Cook.

use std::path::Path;

use doublet_dynamics::linear::{
    LateralDerivatives, LiftAndDrag, LongitudinalDerivatives, Scales, StabilityLateral, StabilityLongitudinal,
    StateSpace, SymmetricTrim,
};
use doublet_dynamics::modes::{Mode, modes};
use nalgebra::DMatrix;
use toml::{Table, Value};

use crate::cr_2144::{FOOT, GRAVITY, lateral, level_trim, longitudinal, number};

fn reference() -> Option<Table> {
    let path = crate::shared::shared("reference/flying/linear_models.toml")?;
    Some(read(&path))
}

fn read(path: &Path) -> Table {
    std::fs::read_to_string(path).unwrap().parse().unwrap()
}

fn list(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|value| value.as_float().unwrap()).collect()
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().unwrap().iter().map(list).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found} instead of {expected} +- {tolerance}");
}

/// A condition of CR-2144 in SI units.
struct Condition {
    number: i64,
    trim: SymmetricTrim,
    longitudinal: LongitudinalDerivatives,
    lateral: LateralDerivatives,
    table: Value,
}

fn conditions(reference: &Table) -> Vec<Condition> {
    let conditions = reference["cr2144"]["condition"].as_array().unwrap();
    conditions.iter().map(condition).collect()
}

fn condition(table: &Value) -> Condition {
    let level = level_trim(table);
    let theta_rad = level.alpha_rad + number(table, "gamma_deg").to_radians();
    Condition {
        number: table["fc"].as_integer().unwrap(),
        trim: SymmetricTrim { theta_rad, ..level },
        longitudinal: longitudinal(table),
        lateral: lateral(table),
        table: table.clone(),
    }
}

fn named<'a>(modes: &'a [Mode], name: &str) -> &'a Mode {
    modes.iter().find(|mode| mode.name == name).unwrap_or_else(|| panic!("no {name} among {:?}", names(modes)))
}

fn names(modes: &[Mode]) -> Vec<&'static str> {
    modes.iter().map(|mode| mode.name).collect()
}

#[test]
fn modes_of_ten_conditions_are_the_published_ones_to_the_stated_tolerances() {
    let Some(reference) = reference() else { return };
    for Condition { number: fc, trim, longitudinal, lateral, table } in conditions(&reference) {
        let (pitch, roll) = (modes(&longitudinal.state_space(&trim).unwrap()), modes(&lateral.state_space(&trim)));
        let (published, computed) = (&table["published"], &table["computed"]);
        let (short, phugoid) = (named(&pitch, "short period"), named(&pitch, "phugoid"));
        let (dutch, roll_mode, spiral) =
            (named(&roll, "Dutch roll"), named(&roll, "roll subsidence"), named(&roll, "spiral"));
        let found = [
            ("short_period_omega", short.frequency_rad_s()),
            ("short_period_zeta", short.damping()),
            ("phugoid_omega", phugoid.frequency_rad_s()),
            ("phugoid_zeta", phugoid.damping()),
            ("dutch_roll_omega", dutch.frequency_rad_s()),
            ("dutch_roll_zeta", dutch.damping()),
            ("inv_T_roll", -roll_mode.real_1_s),
            ("inv_T_spiral", -spiral.real_1_s),
        ];
        for (key, value) in found {
            let (printed, exact) = (number(published, key), number(computed, key));
            // The computed values are given to five digits.
            close(&format!("FC{fc} {key} computed"), value, exact, 1e-4 * exact.abs().max(0.05));
            let tolerance = match (key, fc) {
                ("short_period_omega", _) => 0.006 * printed,
                ("short_period_zeta", _) => 0.003,
                ("phugoid_omega", 7) => 0.05 * printed,
                ("phugoid_omega" | "inv_T_roll", _) => 0.01 * printed,
                ("phugoid_zeta", 4 | 6 | 8 | 9 | 10) | ("dutch_roll_zeta", _) => 0.0015,
                ("phugoid_zeta", 7) => 0.025,
                ("dutch_roll_omega", _) => 0.005 * printed,
                ("inv_T_spiral", _) => 0.0004,
                // Not to be had from the printed derivatives: the computed value above is what is asserted.
                _ => continue,
            };
            close(&format!("FC{fc} {key} published"), value, printed, tolerance);
        }
        for (key, model) in
            [("A_longitudinal", longitudinal.state_space(&trim).unwrap()), ("A_lateral", lateral.state_space(&trim))]
        {
            let Some(expected) = table.get(key) else { continue };
            let scale: &[f64] = if key == "A_longitudinal" { &[FOOT, FOOT, 1.0, 1.0] } else { &[1.0; 4] };
            let expected = matrix(expected);
            for (i, j) in (0..16).map(|k| (k / 4, k % 4)) {
                let value = expected[(i, j)] * scale[i] / scale[j];
                close(&format!("FC{fc} {key} {i} {j}"), model.a[(i, j)], value, 1e-5 * value.abs().max(1e-3));
            }
        }
    }
}

#[test]
fn control_columns_solve_the_acceleration_terms_too() {
    let Some(reference) = reference() else { return };
    for Condition { number: fc, trim, longitudinal, lateral, table } in conditions(&reference) {
        let Some(expected) = table.get("B_elevator").map(list) else { continue };
        let b = longitudinal.state_space(&trim).unwrap().b;
        for (i, scale) in [FOOT, FOOT, 1.0, 1.0].into_iter().enumerate() {
            close(&format!("FC{fc} B {i}"), b[i], expected[i] * scale, 1e-5 * expected[i].abs().max(1e-3));
        }
        let b = lateral.state_space(&trim).b;
        let (aileron, rudder) = (list(&table["B_aileron"]), list(&table["B_rudder"]));
        for i in 0..4 {
            assert_eq!([b[(i, 0)], b[(i, 1)]], [aileron[i], rudder[i]], "FC{fc} row {i}");
        }
    }
}

#[test]
fn derivatives_without_dimension_return_the_dimensional_tables() {
    let Some(reference) = reference() else { return };
    let tables = &reference["cr2144"];
    let [span, chord] = ["span_ft", "chord_ft"].map(|key| number(tables, key) * FOOT);
    let area = number(tables, "wing_area_ft2") * FOOT * FOOT;
    let slug_ft2 = 14.593_903 * FOOT * FOOT;
    for (index, name) in ["fc1", "fc2"].into_iter().enumerate() {
        let condition = &conditions(&reference)[index];
        let of = |key: &str| number(&condition.table, key);
        let airspeed = of("V_ft_s") * FOOT;
        let density = 2.0 * of("q_lb_ft2") * 47.880_26 / (airspeed * airspeed);
        let scales = Scales {
            density,
            airspeed,
            mach: of("mach"),
            alpha_rad: condition.trim.alpha_rad,
            area,
            chord,
            span,
            mass: of("weight_lb") * 0.453_592_37 * 9.80665 / GRAVITY,
            inertia: ["Ix", "Iy", "Iz", "Ixz"].map(|key| of(key) * slug_ft2),
        };
        let table = &tables["nondimensional"][name];
        let by = |key: &str| number(&table["longitudinal"], key);
        let pressure = 0.5 * density * airspeed * airspeed * area;
        let thrust = by("CD") * pressure / (scales.alpha_rad + 2.5_f64.to_radians()).cos();
        let moment = -thrust * 10.0 * FOOT / (pressure * chord);
        let found = LiftAndDrag {
            lift: [by("CL"), by("CLa"), by("CLad"), by("CLq"), by("CLM"), by("CLde")],
            drag: [by("CD"), by("CDa")],
            moment: [moment, by("Cma"), by("Cmad"), by("Cmq"), by("CmM"), by("Cmde")],
        }
        .dimensional(&scales);
        let printed = condition.longitudinal;
        for (what, found, printed, tolerance) in [
            ("Xu", found.x_u, printed.x_u, 0.006),
            ("Xw", found.x_w, printed.x_w, 0.006),
            ("Zu", found.z_u, printed.z_u, 0.006),
            ("Zw", found.z_w, printed.z_w, 0.006),
            ("Zwdot", found.z_w_dot, printed.z_w_dot, 0.006),
            ("Zq", found.z_q, printed.z_q, 0.013),
            ("Mu", found.m_u, printed.m_u, 0.06),
            ("Mw", found.m_w, printed.m_w, 0.006),
            ("Mwdot", found.m_w_dot, printed.m_w_dot, 0.006),
            ("Mq", found.m_q, printed.m_q, 0.006),
            ("Xde", found.elevator[0], printed.elevator[0], 0.006),
            ("Zde", found.elevator[1], printed.elevator[1], 0.006),
            ("Mde", found.elevator[2], printed.elevator[2], 0.006),
        ] {
            close(&format!("{name} {what}"), found, printed, tolerance * printed.abs());
        }
        let by = |row: [&str; 5]| row.map(|key| if key.is_empty() { 0.0 } else { number(&table["lateral"], key) });
        let lateral = StabilityLateral {
            y: by(["Cyb", "", "", "", "Cydr"]),
            l: by(["Clb", "Clp", "Clr", "Clda", "Cldr"]),
            n: by(["Cnb", "Cnp", "Cnr", "Cnda", "Cndr"]),
        };
        let found = lateral.dimensional(&scales).unwrap();
        let printed = condition.lateral;
        for (row, (found, printed)) in [(found.l, printed.l), (found.n, printed.n)].into_iter().enumerate() {
            for (found, printed) in found.into_iter().zip(printed) {
                close(&format!("{name} lateral row {row}"), found, printed, 0.0065 * printed.abs());
            }
        }
        // The moments of rolling controls; Cl_dr has one digit, so the rudder's roll is left to the yaw beside it.
        close(&format!("{name} L'da"), found.aileron[1], printed.aileron[1], 0.0065 * printed.aileron[1].abs());
        close(&format!("{name} N'dr"), found.rudder[2], printed.rudder[2], 0.0065 * printed.rudder[2].abs());
        let expected = list(&tables["closure"]["modes_lateral_from_nondim"][name]);
        let modes = modes(&found.state_space(&condition.trim));
        let dutch = named(&modes, "Dutch roll");
        let found = [
            -named(&modes, "spiral").real_1_s,
            -named(&modes, "roll subsidence").real_1_s,
            dutch.damping(),
            dutch.frequency_rad_s(),
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            close(&format!("{name} lateral mode"), found, expected, 2e-3 * expected.abs());
        }
    }
}

/// Coefficients of `det(s I - A)`, highest power first (Faddeev and Leverrier).
fn polynomial(a: &DMatrix<f64>) -> Vec<f64> {
    let size = a.nrows();
    let mut coefficients = vec![1.0];
    let mut power = DMatrix::<f64>::identity(size, size);
    for k in 1..=size {
        let product = a * &power;
        let next = -product.trace() / k as f64;
        power = product + DMatrix::identity(size, size) * next;
        coefficients.push(next);
    }
    coefficients
}

#[test]
fn etkins_matrices_have_his_polynomials_and_eigenvalues() {
    let Some(reference) = reference() else { return };
    let etkin = &reference["etkin"];
    let model =
        |key: &str, states: &[&str]| StateSpace::of_states(key, states, &[], matrix(&etkin[key]), DMatrix::zeros(4, 0));
    let (pitch, roll) =
        (model("A_longitudinal", &["u", "w", "q", "theta"]), model("A_lateral", &["v", "p", "r", "phi"]));
    for (a, key) in [(&pitch.a, "polynomial_longitudinal"), (&roll.a, "polynomial_lateral")] {
        for (found, expected) in polynomial(a).into_iter().zip(list(&etkin[key])) {
            close(key, found, expected, 2e-4 * expected);
        }
    }
    let (pitch, roll) = (modes(&pitch), modes(&roll));
    for (mode, key) in [
        (named(&pitch, "phugoid"), "published_phugoid"),
        (named(&pitch, "short period"), "published_short_period"),
        (named(&roll, "Dutch roll"), "published_dutch_roll"),
    ] {
        let expected = list(&etkin[key]);
        for (found, expected) in [mode.real_1_s, mode.imaginary_rad_s].into_iter().zip(expected) {
            close(key, found, expected, 1.5e-4 * expected.abs());
        }
    }
    close("spiral", named(&roll, "spiral").real_1_s, number(etkin, "published_spiral"), 1e-6);
    close("roll", named(&roll, "roll subsidence").real_1_s, number(etkin, "published_roll"), 1e-4);
}

#[test]
fn etkins_derivatives_without_dimension_give_his_matrix() {
    let Some(reference) = reference() else { return };
    let etkin = &reference["etkin"];
    // In his own units, as consistent as SI.
    let of = |key: &str| number(etkin, key);
    let row = |key: &str| ["u", "alpha", "q", "alphadot"].map(|name| number(&etkin[key], name));
    let scales = Scales {
        density: of("rho_slug_ft3"),
        airspeed: of("u0_ft_s"),
        mach: 0.8,
        alpha_rad: 0.0,
        area: of("S_ft2"),
        chord: of("c_ft"),
        span: of("b_ft"),
        mass: of("weight_lb") / 32.2,
        inertia: ["Ix", "Iy", "Iz", "Ixz"].map(of),
    };
    let set = StabilityLongitudinal { lift: of("CL0"), x: row("Cx"), z: row("Cz"), m: row("Cm") };
    let trim = SymmetricTrim { airspeed_m_s: scales.airspeed, alpha_rad: 0.0, theta_rad: 0.0, gravity_m_s2: 32.2 };
    let model = set.dimensional(&scales).state_space(&trim).unwrap();
    let printed = matrix(&etkin["A_longitudinal"]);
    for (i, j) in (0..16).map(|k| (k / 4, k % 4)) {
        close(&format!("A {i} {j}"), model.a[(i, j)], printed[(i, j)], 1e-3 * printed[(i, j)].abs() + 1e-12);
    }
    let found = modes(&model);
    for (mode, key) in [(named(&found, "phugoid"), "phugoid"), (named(&found, "short period"), "short_period")] {
        let expected = list(&etkin["computed_from_nondimensional"][key]);
        close(key, mode.real_1_s, expected[0], 2e-3 * expected[0].abs());
        close(key, mode.imaginary_rad_s, expected[1], 1e-3 * expected[1]);
    }
}

#[test]
fn order_of_states_changes_nothing() {
    let Some(reference) = reference() else { return };
    let damper = &reference["yaw_damper_747"];
    let a = matrix(&damper["A"]);
    let names = ["beta", "r", "p", "phi"];
    let computed = &damper["computed"];
    let mut orders = vec![];
    for first in 0..4 {
        for second in (0..4).filter(|&index| index != first) {
            for third in (0..4).filter(|&index| index != first && index != second) {
                orders.push([first, second, third, 6 - first - second - third]);
            }
        }
    }
    assert_eq!(orders.len(), 24);
    for order in orders {
        let permuted = DMatrix::from_fn(4, 4, |i, j| a[(order[i], order[j])]);
        let states = order.map(|index| names[index]);
        let found = modes(&StateSpace::of_states("lateral", &states, &[], permuted, DMatrix::zeros(4, 0)));
        let dutch = named(&found, "Dutch roll");
        let expected = list(&computed["dutch_roll"]);
        close("Dutch roll", dutch.real_1_s, expected[0], 1e-6);
        close("Dutch roll", dutch.imaginary_rad_s, expected[1], 1e-6);
        close("roll", named(&found, "roll subsidence").real_1_s, number(computed, "roll"), 1e-6);
        close("spiral", named(&found, "spiral").real_1_s, number(computed, "spiral"), 1e-6);
        let place = |name: &str| order.iter().position(|&index| names[index] == name).unwrap();
        assert!(dutch.participation[place("beta")] > dutch.participation[place("p")]);
    }
}

#[test]
fn heading_as_a_state_adds_a_zero_and_changes_no_other_mode() {
    let Some(reference) = reference() else { return };
    let f4c = &reference["f4c"];
    let model = StateSpace::of_states(
        "lateral",
        &["v", "p", "r", "phi", "psi"],
        &[],
        matrix(&f4c["A_computed"]),
        DMatrix::zeros(5, 0),
    );
    let found = modes(&model);
    let computed = &f4c["computed"];
    let expected = list(&computed["dutch_roll"]);
    close("Dutch roll", named(&found, "Dutch roll").real_1_s, expected[0], 2e-5);
    close("Dutch roll", named(&found, "Dutch roll").imaginary_rad_s, expected[1], 2e-5);
    close("roll", named(&found, "roll subsidence").real_1_s, number(computed, "roll"), 1e-5);
    close("spiral", named(&found, "spiral").real_1_s, number(computed, "spiral"), 1e-5);
    close("heading", named(&found, "heading").real_1_s, 0.0, 1e-12);
}
