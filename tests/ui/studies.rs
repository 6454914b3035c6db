//! Studies and diagnostics in the window: correlation of parameters and regressors, information over time, studies on request.

use doublet::layouts::LayoutKey;
use doublet::panels::Pane;
use doublet_core::model::{Coefficient, Variable};
use egui_kittest::kittest::Queryable;

use crate::picture;
use crate::workbench::Bench;

/// Rounding of sums over a few thousand samples, relative.
const ROUNDING: f64 = 1e-9;

#[test]
fn regressors_are_correlated_as_their_samples_are_and_all_coefficients_are_shown() {
    let mut bench = Bench::open();
    bench.show(Pane::Correlation);
    assert!(bench.harness.query_by_label("correlation of parameters of Cm").is_some());
    bench.choose("Regressors");
    assert!(bench.harness.query_by_label("correlation of regressors of Cm").is_some());
    picture(&mut bench.harness, "correlation_regressors");
    let details = bench.snapshot().details.ready().expect("it was looked at").clone();
    let found = details.regressors.iter().find(|one| one.coefficient == Coefficient::Cm).expect("Cm is modelled");
    assert_eq!(found.derivatives, ["Cm_alpha", "Cm_q", "Cm_delta_e"]);
    let aero = bench.snapshot().windows["first"].aero.ready().expect("it is there").clone();
    let column = |variable: Variable| aero.variables.get(variable).expect("it is recorded").to_vec();
    // q c / V of a flight at nearly one airspeed is q but for a factor of each sample.
    let (alpha, elevator) = (column(Variable::Alpha), column(Variable::Elevator));
    let centred = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|value| value - mean).collect::<Vec<_>>()
    };
    let (a, e) = (centred(&alpha), centred(&elevator));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let expected = dot(&a, &e) / (dot(&a, &a) * dot(&e, &e)).sqrt();
    assert!((found.correlation[(0, 2)] - expected).abs() < ROUNDING, "{} and {expected}", found.correlation[(0, 2)]);
}

#[test]
fn information_of_a_window_adds_up_and_lies_where_the_aircraft_moves() {
    let mut bench = Bench::open();
    bench.show(Pane::Fits);
    bench.choose("Information");
    picture(&mut bench.harness, "information");
    assert!(bench.harness.query_by_label("information on Cm").is_some());
    let details = bench.snapshot().details.ready().expect("it was looked at").clone();
    let window = details.window.as_ref().expect("a manoeuvre is chosen");
    let found = window.information.iter().find(|one| one.coefficient == Coefficient::Cm).expect("Cm is fitted");
    let session = bench.session().windows[0].window;
    assert!((found.edges_s[0] - session.start_s).abs() < 0.1);
    assert!((found.edges_s[found.edges_s.len() - 1] - session.end_s).abs() < 0.1);
    for (name, shares) in &found.shares {
        assert_eq!(shares.len() + 1, found.edges_s.len());
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < ROUNDING, "{name}");
    }
    // The elevator's own derivative is told while it moves: the parts with most of it hold more than their part of time.
    let (_, shares) = found.shares.iter().find(|(name, _)| name == "Cm_delta_e").expect("it is estimated");
    let mut sorted = shares.clone();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let tenth: f64 = sorted.iter().take(sorted.len() / 10).sum();
    assert!(tenth > 0.2, "{tenth} of the information in a tenth of the time");
}

#[test]
fn manoeuvres_are_compared_in_the_window_with_the_line_of_the_regression() {
    let mut bench = Bench::shipped_in(1600.0, 900.0);
    bench.show(Pane::Studies);
    bench.click("compute Between manoeuvres");
    picture(&mut bench.harness, "studies_condition");
    let study = bench.snapshot().studies.manoeuvres.ready().expect("it was computed").clone();
    let regression = study.conditions.iter().find(|one| one.derivative == "Cm_q" && one.variables.len() == 2);
    let regression = regression.expect("the damping in pitch is estimated");
    assert!(bench.harness.query_by_label("derivative over the flight condition").is_some());
    if let (Some([from, to]), Ok(found)) = (regression.line(0), regression.result.as_ref()) {
        let slope = (to[1] - from[1]) / (to[0] - from[0]);
        assert!((slope / found.fit.estimates[1] - 1.0).abs() < ROUNDING, "{slope}");
        let flown: Vec<f64> = regression.points.iter().map(|(_, point)| point.condition[0]).collect();
        assert_eq!(from[0], flown.iter().copied().fold(f64::INFINITY, f64::min));
        let middle = from[1] + slope * (found.mean[0] - from[0]);
        assert!((middle / found.fit.estimates[0] - 1.0).abs() < ROUNDING, "at the mean it has the value at the mean");
    }
    for aspect in ["Each manoeuvre left out", "Kinds of input"] {
        bench.click(aspect);
        picture(&mut bench.harness, &format!("studies_{}", aspect.replace(' ', "_")));
    }
    let left_out = &study.left_out[0].windows[0];
    bench.click("Each manoeuvre left out");
    assert!(bench.harness.query_all_by_label(&left_out.label).next().is_some(), "its row is there");
}

#[test]
fn matrices_fill_a_large_screen() {
    let mut bench = Bench::shipped_in(2560.0, 1440.0);
    bench.show(Pane::Correlation);
    bench.harness.state_mut().state.show_layout(LayoutKey::Named("correlation".to_owned()));
    bench.harness.state_mut().state.shown.tree =
        egui_tiles::Tree::new_tabs(egui::Id::unique("correlation"), vec![Pane::Correlation]);
    bench.harness.state_mut().state.shown.touched = true;
    bench.settle();
    picture(&mut bench.harness, "correlation_2560");
    let matrices: Vec<egui::Rect> = bench
        .harness
        .query_all_by_label_contains("correlation of parameters of ")
        .map(|matrix| matrix.rect())
        .collect();
    assert_eq!(matrices.len(), 6);
    let used = matrices.iter().fold(egui::Rect::NOTHING, |used, matrix| used.union(*matrix));
    assert!(used.right() < 2560.0 && used.bottom() < 1440.0, "nothing is scrolled: {used:?}");
    // The matrix of most terms limits the cells of all: in its direction it fills its place.
    let largest = matrices.iter().map(|matrix| matrix.height()).fold(0.0, f32::max);
    assert!(largest > 400.0, "{largest}: two rows of three share 1300 points");
}
