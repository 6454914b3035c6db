//! Mean aerodynamic chord: thesis Table 5.1 and the integrals behind it.

use doublet_core::airframe::{WingPanel, mean_aerodynamic_chord};
use proptest::prelude::*;

use super::support::{close, reference, shipped};

/// Half a centimetre of the printed result and half a centimetre of the stations it follows from, m.
const PRINTED_M: f64 = 0.01;

#[test]
fn mean_chord_of_the_c337f_matches_thesis_table_5_1() {
    let Some(table) = reference("geometry.toml") else { return };
    let aircraft = shipped("c337f.toml");
    let whole = mean_aerodynamic_chord(&aircraft.wing_panels).unwrap();
    let panels = aircraft.wing_panels.iter().map(|panel| (panel.name.as_str(), panel.mean_chord()));
    for (name, chord) in panels.chain([("half_wing", whole)]) {
        close(name, chord.leading_edge_x_m, table.number(&format!("mac.{name}.x_le_m")), PRINTED_M);
        close(name, chord.y_m, table.number(&format!("mac.{name}.y_m")), PRINTED_M);
        close(name, chord.chord_m, table.number(&format!("mac.{name}.mac_m")), PRINTED_M);
    }
    for panel in &aircraft.wing_panels {
        let area = table.number(&format!("mac.{}.area_m2", panel.name));
        // Chord and semispan are printed to a centimetre: 1.88 m x 0.005 m + 4.10 m x 0.005 m.
        close("panel area", panel.area_m2(), area, 0.03);
    }
}

#[test]
fn stated_mean_chord_of_the_c337f_matches_its_panels() {
    let aircraft = shipped("c337f.toml");
    let (stated, computed) = (aircraft.mean_chord().unwrap(), mean_aerodynamic_chord(&aircraft.wing_panels).unwrap());
    close("x", stated.leading_edge_x_m, computed.leading_edge_x_m, PRINTED_M);
    close("y", stated.y_m, computed.y_m, PRINTED_M);
    close("chord", stated.chord_m, computed.chord_m, PRINTED_M);
}

#[test]
fn reference_values_of_the_c337f_match_thesis_table_f3() {
    let Some(table) = reference("geometry.toml") else { return };
    let aircraft = shipped("c337f.toml");
    assert_eq!(aircraft.reference.area_m2, table.number("reference.S_m2"));
    assert_eq!(aircraft.reference.span_m, table.number("reference.b_m"));
    assert_eq!(aircraft.reference.chord_m, table.number("reference.c_bar_m"));
    close("aspect ratio", aircraft.reference.aspect_ratio(), table.number("airframe.aspect_ratio_recommended"), 5e-4);
    assert_eq!(aircraft.sensors.accelerometer_from_datum_m, Some(table.point("accelerometer.position_F_D_m")));
}

proptest! {
    /// The weighted mean of the panels is the integral over the half span of c^2, x c and y c, by Simpson's rule (exact
    /// for these cubics) panel by panel.
    #[test]
    fn mean_chord_of_any_panels_is_the_integral_over_the_span(
        panels in prop::collection::vec((0.5..6.0, 0.3..4.0, 0.1..1.5, -1.0..1.0, -1.0..1.0), 1..6),
    ) {
        let mut wing = Vec::new();
        let mut root_y_m = 0.0;
        let mut integrals = [0.0; 4];
        for (index, &(semispan_m, root_chord_m, taper, x_root, x_tip)) in panels.iter().enumerate() {
            wing.push(WingPanel {
                name: index.to_string(), root_y_m, semispan_m, root_chord_m, taper,
                root_leading_edge_x_m: x_root, tip_leading_edge_x_m: x_tip,
            });
            for (t, weight) in [(0.0, 1.0), (0.5, 4.0), (1.0, 1.0)] {
                let c = root_chord_m * (1.0 + t * (taper - 1.0));
                let w = weight * semispan_m / 6.0;
                let (x, y) = (x_root + t * (x_tip - x_root), root_y_m + t * semispan_m);
                for (sum, value) in integrals.iter_mut().zip([c, c * c, x * c, y * c]) {
                    *sum += w * value;
                }
            }
            root_y_m += semispan_m;
        }
        let [area, cc, xc, yc] = integrals;
        let mean = mean_aerodynamic_chord(&wing).unwrap();
        // Round-off of sums of a few terms of order ten.
        prop_assert!((mean.chord_m - cc / area).abs() < 1e-12);
        prop_assert!((mean.leading_edge_x_m - xc / area).abs() < 1e-12);
        prop_assert!((mean.y_m - yc / area).abs() < 1e-11);
    }
}
