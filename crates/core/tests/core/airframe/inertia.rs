//! Inertia against thesis Tables 5.10 to 5.14 and Eq. 5.10, and against point masses added one by one.

use doublet_core::airframe::{
    Axis, InertiaError, InertiaGroup, InertiaTensor, LoadedState, Loading, OwnInertia, frames::body_from_datum,
};
use proptest::prelude::*;

use super::support::{close, reference, shipped};

/// Deviation of a recomputed row of Table 5.12, kg m²: centroids and centre of gravity are printed to a centimetre, which moves
/// the rear powerplant's row by up to 3.2 and every other's by less.
const ROW_KG_M2: f64 = 3.3;
/// Deviation of the sum of the recomputed rows from Eq. 5.10, kg m²: the rows' rounding, partly cancelling.
const SUM_KG_M2: f64 = 3.0;
/// Deviation of the aircraft file from Eq. 5.10, kg m²: that of the rows, and the centre of gravity, printed to a centimetre, 0.217 m
/// from the groups' own centroid: 2 x 2103 kg x 0.217 m x 0.005 m.
const TOTAL_KG_M2: f64 = SUM_KG_M2 + 4.6;
/// Half a unit of the last printed digit of a moment of inertia, kg m².
const PRINTED_KG_M2: f64 = 0.05;

fn moments(tensor: &InertiaTensor) -> [f64; 3] {
    [tensor.xx, tensor.yy, tensor.zz]
}

#[test]
fn every_row_of_thesis_table_5_12_follows_by_the_parallel_axis_theorem() {
    let Some(table) = reference("inertia.toml") else { return };
    let point = table.point("table_5_12.point_of_reference_F_D_m");
    let mut sum = [0.0; 3];
    let (mut mass, mut moment) = (0.0, [0.0; 3]);
    let rows = table.named_rows("table_5_12.rows");
    assert_eq!(rows.len(), 25);
    for (name, row) in rows {
        let [mass_kg, x, y, z, xx, yy, zz, xx_cg, yy_cg, zz_cg] = row.try_into().unwrap();
        let inertia = OwnInertia::Given { tensor: InertiaTensor::diagonal(xx, yy, zz), at_mass_kg: mass_kg };
        let group = InertiaGroup { name: name.clone(), mass_kg, centroid_from_datum_m: [x, y, z], inertia };
        let found = moments(&group.about(point));
        for axis in 0..3 {
            close(&name, found[axis], [xx_cg, yy_cg, zz_cg][axis], ROW_KG_M2);
            sum[axis] += found[axis];
            moment[axis] += mass_kg * [x, y, z][axis];
        }
        mass += mass_kg;
    }
    for (found, name) in sum.into_iter().zip(["Ixx", "Iyy", "Izz"]) {
        close(name, found, table.number(&format!("total.{name}")), SUM_KG_M2);
    }
    // The rows' own centroid is not the point of reference: moments about the latter are larger by these percentages.
    close("mass of the rows", mass, 2102.9, 0.05);
    let excess = moments(&InertiaTensor::point_mass(mass, body_from_datum(moment.map(|m| m / mass), point)));
    for ((excess, sum), percent) in excess.into_iter().zip(sum).zip([1.7, 2.0, 0.1]) {
        close("excess", 100.0 * excess / sum, percent, 0.06);
    }
}

#[test]
fn c337f_as_printed_reproduces_eq_5_10() {
    let Some(table) = reference("inertia.toml") else { return };
    let aircraft = shipped("c337f_thesis.toml");
    let inertia = aircraft.standard_loading.mass_properties(&aircraft).inertia;
    for (found, name) in moments(&inertia).into_iter().zip(["Ixx", "Iyy", "Izz"]) {
        close(name, found, table.number(&format!("total.{name}")), TOTAL_KG_M2);
    }
    close("Ixz", inertia.xz, table.number("total.Ixz"), TOTAL_KG_M2);
    // Eq. 5.10 prints these two with the sign of datum axes; in body axes they turn. Rounded centroids of 2100 kg: 2.5 kg m2.
    close("Ixy", inertia.xy, table.number("total.minus_Ixy"), 2.5);
    close("Iyz", inertia.yz, table.number("total.minus_Iyz"), 2.5);
}

#[test]
fn c337f_differs_from_eq_5_10_by_the_corrected_contradictions_only() {
    let Some(table) = reference("inertia.toml") else { return };
    let aircraft = shipped("c337f.toml");
    let properties = aircraft.standard_loading.mass_properties(&aircraft);
    let [x, y, z] = properties.cg_from_datum_m;
    let at =
        |mass_kg: f64, position: [f64; 3]| InertiaTensor::point_mass(mass_kg, body_from_datum(position, [x, y, z]));
    // 12 kg less equipment, its own inertia in proportion; it moves into the plane of symmetry.
    let fewer = InertiaTensor::diagonal(830.2, 778.4, 1482.8).scaled(-12.0 / 324.6);
    let mut expected = fewer + at(-12.0, [3.63, 0.0, 1.45]);
    expected += at(324.6, [3.63, 0.0, 1.45]) + at(-324.6, [3.63, -0.05, 1.45]);
    // Rods about mid length instead of their ends; 0.4 kg more tail; the luggage's own inertia by its formula.
    let rods = -(20.9 * 0.37_f64.powi(2) + 2.0 * 42.4 * 0.75_f64.powi(2)) * (1.0 / 3.0 - 1.0 / 12.0);
    expected += InertiaTensor::diagonal(0.0, rods, rods) + at(0.4, [8.44, 0.0, 2.12]);
    expected += InertiaTensor::diagonal(0.0, -0.8, 0.8);
    // Seats of Table 5.2.
    let seats = [(2.59, 2.65), (3.61, 3.49)];
    for (now, before) in seats {
        expected += at(2.0 * 74.7, [now, 0.0, 1.11]) + at(-2.0 * 74.7, [before, 0.0, 1.11]);
    }
    let found = properties.inertia;
    let names = ["Ixx", "Iyy", "Izz"];
    for ((name, found), expected) in names.into_iter().zip(moments(&found)).zip(moments(&expected)) {
        close(name, found - table.number(&format!("total.{name}")), expected, TOTAL_KG_M2);
    }
    close("Ixz", found.xz - table.number("total.Ixz"), expected.xz, TOTAL_KG_M2);
    // Symmetric parts and a symmetric loading: round-off only.
    assert!(found.xy.abs() < 1e-9 && found.yz.abs() < 1e-9, "{found:?}");
}

#[test]
fn shapes_of_the_c337f_match_thesis_section_5_2_1() {
    let Some(table) = reference("inertia.toml") else { return };
    let cuboid = OwnInertia::Cuboid { length_m: 0.898, width_m: 0.839, height_m: 0.570 };
    let propeller = OwnInertia::Propeller { radius_m: 0.96 };
    for (shape, group) in [(cuboid, "powerplant_unit"), (propeller, "propeller_unit")] {
        let found = moments(&shape.tensor(table.number(&format!("groups.{group}.mass_kg"))));
        for (found, printed) in found.into_iter().zip(table.point(&format!("groups.{group}.I_kg_m2"))) {
            close(group, found, printed, PRINTED_KG_M2);
        }
    }
    let luggage = OwnInertia::Cuboid { length_m: 0.5, width_m: 0.5, height_m: 0.2 }.tensor(45.9);
    for (found, formula) in moments(&luggage).into_iter().zip([1.1, 1.1, 1.9]) {
        close("luggage", found, formula, PRINTED_KG_M2);
    }
    // The gear is printed with m L^2 / 3; about mid length it is a quarter of that.
    let gear = OwnInertia::Rod { length_m: 0.75, along: Axis::X }.tensor(42.4);
    close("main gear", gear.yy, table.point("groups.main_gear.I_kg_m2")[1] / 4.0, PRINTED_KG_M2);
    assert_eq!(gear.xx, 0.0);
    let down = OwnInertia::Rod { length_m: 2.0, along: Axis::Z }.tensor(3.0);
    assert_eq!(moments(&down), [1.0, 1.0, 0.0]);
    let half_full = OwnInertia::Given { tensor: InertiaTensor::diagonal(50.37, 5.15, 55.02), at_mass_kg: 132.5 };
    close("half a tank", half_full.tensor(66.25).zz, 27.51, 1e-9);
}

#[test]
fn mass_fractions_match_thesis_tables_5_10_and_5_11() {
    let Some(table) = reference("inertia.toml") else { return };
    let aircraft = shipped("c337f.toml");
    let maximum = 2100.0;
    for part in &aircraft.component_fractions {
        let key = part.name.replace(' ', "_");
        close("mean", 100.0 * part.mean, table.number(&format!("mass_attribution.{key}.fraction_pct")), 1e-9);
        close("deviation", 100.0 * part.deviation, table.number(&format!("mass_attribution.{key}.sigma_pct")), 1e-9);
        for (method, fraction) in &part.methods {
            close(method, 100.0 * fraction, table.number(&format!("mass_fractions.{key}.{method}")), 1e-9);
        }
        // Half a tenth of a per cent of 2100 kg and the 16.2 kg of oil or 15.8 kg of equipment added to the statistics.
        let statistical = table.number(&format!("mass_attribution.{key}.mass_kg"));
        close("statistical mass", part.mean * maximum, statistical, 1.1);
        assert!(part.attributed_kg - statistical < 16.3, "{}", part.name);
        let score = part.standard_score(maximum).unwrap();
        close("score", score, (part.attributed_kg / maximum - part.mean) / part.deviation, 1e-12);
        assert!(score.abs() < 0.5, "{}: {score} standard deviations from comparable aircraft", part.name);
    }
    // Table 5.11 prints 1325.4 kg as the sum of its components.
    let parts = ["wing", "fuselage", "empennage", "nacelle", "landing_gear", "powerplant", "fixed_equipment"];
    let statistical = parts.map(|part| table.number(&format!("mass_attribution.{part}.mass_kg")));
    close("statistical empty mass", statistical.iter().sum(), 1329.5, 0.05);
    let sum: f64 = aircraft.component_fractions.iter().map(|part| part.attributed_kg).sum();
    // Without the booms (12.0 kg) and the trapped fuel (8.6 kg) of the empty aircraft.
    close("sum", sum, 1382.1 - 12.0 - 8.6, 0.05);
}

#[test]
fn class_one_estimate_matches_thesis_table_5_14() {
    let Some(table) = reference("inertia.toml") else { return };
    let aircraft = shipped("c337f.toml");
    let radii = aircraft.gyration_radii.unwrap();
    for (mass_kg, row) in [(1382.0, "OEW"), (2100.0, "MTOW")] {
        let estimate = moments(&radii.inertia(mass_kg, aircraft.reference.span_m));
        for (found, name) in estimate.into_iter().zip(["Ixx", "Iyy", "Izz"]) {
            let printed = table.number(&format!("class_I.{row}.{name}"));
            // Radii of three digits: 0.0005 of 0.255, twice.
            close(name, found, printed, 0.004 * printed);
        }
    }
    let state = LoadedState::new("take-off", &aircraft, &aircraft.standard_loading);
    let (own, estimate) = (state.properties.inertia, state.class_one.unwrap());
    for (own, estimate) in moments(&own).into_iter().zip(moments(&estimate)) {
        assert!(estimate < own && estimate > 0.78 * own, "the estimate {estimate} is below {own} by a fifth at most");
    }
}

#[test]
fn principal_axes_of_a_tilted_body_come_back() {
    let tilt = 0.1_f64;
    let (c, s) = (tilt.cos(), tilt.sin());
    let (a, b) = (100.0, 300.0);
    // A body with moments a, 250, b whose x axis points `tilt` above body x: principal x = (c, 0, -s).
    let tensor = InertiaTensor {
        xx: a * c * c + b * s * s,
        yy: 250.0,
        zz: a * s * s + b * c * c,
        xz: (a - b) * c * s,
        xy: 0.0,
        yz: 0.0,
    };
    let principal = tensor.principal_axes().unwrap();
    for (found, expected) in principal.moments_kg_m2.into_iter().zip([a, 250.0, b]) {
        close("moment", found, expected, 1e-9);
    }
    close("pitch", principal.pitch_rad, tilt, 1e-12);
    let axes = principal.body_from_principal;
    let back = axes * nalgebra::Matrix3::from_diagonal(&principal.moments_kg_m2.into()) * axes.transpose();
    assert!((back - tensor.matrix()).norm() < 1e-9);
    close("determinant", axes.determinant(), 1.0, 1e-12);
}

#[test]
fn impossible_tensors_are_refused_with_their_numbers() {
    assert_eq!(InertiaTensor::diagonal(1.0, f64::NAN, 1.0).check(), Err(InertiaError::NotFinite));
    let negative = InertiaTensor { xz: 200.0, ..InertiaTensor::diagonal(100.0, 200.0, 150.0) };
    assert!(matches!(negative.check(), Err(InertiaError::NotPositive { smallest_kg_m2 }) if smallest_kg_m2 < 0.0));
    let pointed = InertiaTensor::diagonal(100.0, 100.0, 211.0).check();
    assert_eq!(pointed, Err(InertiaError::Triangle { largest_kg_m2: 211.0, others_kg_m2: 200.0 }));
    assert_eq!(InertiaTensor::diagonal(100.0, 100.0, 200.0).check(), Ok(()), "a flat plate exists");
    let published = InertiaTensor::diagonal(100.0, 100.0, 206.0);
    assert_eq!(published.check(), Ok(()));
    close("excess", published.triangle_excess().unwrap(), 0.03, 1e-12);
}

proptest! {
    /// Three or more point masses about their own centre, moved to any point and back, are the same body; directly summed
    /// they agree.
    #[test]
    fn parallel_axis_there_and_back_is_the_same_body(
        points in prop::collection::vec((1.0..100.0, [-5.0..5.0, -5.0..5.0, -5.0..5.0]), 3..8),
        target in [-5.0..5.0, -5.0..5.0, -5.0..5.0],
    ) {
        let mass: f64 = points.iter().map(|(m, _)| m).sum();
        let cg: [f64; 3] = std::array::from_fn(|axis| points.iter().map(|(m, r)| m * r[axis]).sum::<f64>() / mass);
        let about = |point: [f64; 3]| points.iter().fold(InertiaTensor::default(), |sum, (m, r)| {
            sum + InertiaTensor::point_mass(*m, body_from_datum(*r, point))
        });
        let own = about(cg);
        let body = InertiaGroup {
            name: "body".into(), mass_kg: mass, centroid_from_datum_m: cg,
            inertia: OwnInertia::Given { tensor: own, at_mass_kg: mass },
        };
        // Round-off relative to the largest sum of m r^2 possible here.
        let tolerance = 1e-12 * mass * 300.0;
        prop_assert!((body.about(target).matrix() - about(target).matrix()).norm() < tolerance);
        let back = body.about(target).matrix() - InertiaTensor::point_mass(mass, body_from_datum(cg, target)).matrix();
        prop_assert!((back - own.matrix()).norm() < tolerance);
    }

    /// Whatever is put on board, the tensor stays one that a body can have.
    #[test]
    fn inertia_of_any_loading_is_possible(
        fuel in [0.0..132.5, 0.0..132.5, 0.0..54.1, 0.0..54.1], seats in [0.0..150.0, 0.0..150.0], luggage in 0.0..200.0,
    ) {
        let aircraft = shipped("c337f.toml");
        let tanks = aircraft.tanks.iter().map(|tank| tank.name.clone()).zip([fuel[0], fuel[1], fuel[2], fuel[3]]);
        let loading = Loading {
            fuel_kg: tanks.collect(),
            seats_kg: [("captain".to_owned(), seats[0]), ("passenger left".to_owned(), seats[1])].into(),
            luggage_kg: [("luggage".to_owned(), luggage)].into(),
            added_items: Vec::new(),
        };
        let properties = loading.mass_properties(&aircraft);
        prop_assert_eq!(properties.inertia.check(), Ok(()));
        let total = 1382.1 + fuel.iter().sum::<f64>() + seats.iter().sum::<f64>() + luggage;
        prop_assert!((properties.mass_kg - total).abs() < 1e-9);
    }
}
