//! The manoeuvre map: its values against the flight that was made, its marks selected by click, lasso and keys.

use doublet::command::{EditCommand, UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet_core::atmos::Atmosphere;
use doublet_engine::report::{MapOf, MapRow, manoeuvre_map};
use doublet_engine::session::WindowRole;
use egui::{Key, Modifiers, Pos2, ThemePreference, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

use crate::manoeuvres::bench;
use crate::painted::faults;
use crate::picture;
use crate::recording::AIRSPEED_M_S;
use crate::workbench::Bench;

impl Bench<'_> {
    fn map_rows(&self) -> Vec<MapRow> {
        manoeuvre_map(self.session(), self.snapshot(), MapOf::Latest)
    }

    /// The centre of the mark whose name begins so.
    fn mark_at(&self, begin: &str) -> Pos2 {
        self.harness.get_by_label_contains(begin).rect().center()
    }

    /// Draws a lasso through `corners`.
    fn lasso(&mut self, corners: &[Pos2], modifiers: Modifiers) {
        self.harness.event(egui::Event::ModifiersChanged(modifiers));
        self.harness.hover_at(corners[0]);
        self.harness.step();
        self.harness.drag_at(corners[0]);
        self.harness.step();
        for ends in corners.windows(2) {
            for step in 1..=4 {
                self.harness.hover_at(ends[0] + (ends[1] - ends[0]) * (step as f32 / 4.0));
                self.harness.step();
            }
        }
        picture(&mut self.harness, "map_lasso");
        self.harness.drop_at(corners[corners.len() - 1]);
        self.harness.run_steps(2);
        self.harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
        self.settle();
    }

    fn undo_once(&mut self) {
        self.request(UiCommand::Edit(EditCommand::Undo));
    }
}

/// Corners of a box about places.
fn about(places: &[Pos2]) -> [Pos2; 5] {
    let rect = egui::Rect::from_points(places).expand(16.0);
    [rect.left_top(), rect.right_top(), rect.right_bottom(), rect.left_bottom(), rect.left_top() + vec2(0.0, 4.0)]
}

#[test]
fn values_of_the_map_are_those_of_the_flight_that_was_made() {
    let bench = bench();
    let rows = bench.map_rows();
    let first = &rows[0];
    let close = |value: Option<f64>, expected: f64, error: f64| value.is_some_and(|v| (v - expected).abs() < error);
    assert_eq!(
        (first.name.as_str(), first.role, first.start_s, first.duration_s),
        ("first", "identification", 5.0, 20.0)
    );
    assert!(close(first.airspeed_m_s, AIRSPEED_M_S, 0.5), "{:?}", first.airspeed_m_s);
    assert!(close(first.alpha_rad, 0.06, 0.004), "{:?}", first.alpha_rad);
    let density = Atmosphere::STANDARD.density_kg_m3(1500.0).unwrap();
    let pressure = 0.5 * density * AIRSPEED_M_S * AIRSPEED_M_S;
    assert!(close(first.dynamic_pressure_pa, pressure, 0.02 * pressure), "{:?}", first.dynamic_pressure_pa);
    assert!(close(first.mass_kg, 5000.0, 1e-6));
    let path = bench.snapshot().windows["first"].path.ready().expect("there is a path").clone();
    let nis = path.assessment().consistency.as_ref().expect("there are innovations").nis_ratio;
    assert_eq!(first.nis_ratio, Some(nis));
    assert!(first.r_squared["Cm"] > 0.99 && first.information.is_some_and(|times| times > 10.0));
    assert_eq!(first.level, Some(bench.snapshot().verdicts.ready().unwrap().windows["first"].verdict.level));
    let found = bench.snapshot().proposals["flight"].ready().unwrap().windows.clone();
    let open: Vec<_> = found.iter().filter(|one| one.covering_window(bench.session()).is_none()).collect();
    assert!(!open.is_empty());
    let candidates: Vec<&MapRow> = rows.iter().filter(|row| row.is_candidate()).collect();
    assert_eq!(candidates.len(), open.len());
    // A doublet of 0.05 rad to either side.
    assert!(close(candidates[0].deflection_rad, 0.05, 0.01), "{:?}", candidates[0].deflection_rad);
    assert!(close(candidates[0].airspeed_m_s, AIRSPEED_M_S, 1e-9) && candidates[0].nis_ratio.is_none());
}

#[test]
fn click_lasso_and_buttons_of_the_map_act_on_all_selected_with_one_undo() {
    let mut bench = bench();
    bench.show(Pane::ManoeuvreMap);
    let [first, candidate] = ["mark first:", "candidate "].map(|name| bench.mark_at(name));
    bench.lasso(&about(&[candidate]), Modifiers::NONE);
    bench.click("accept");
    assert_eq!(bench.session().windows.len(), 2, "the candidate inside the lasso is accepted");
    let added = bench.session().windows[1].name.clone();
    let selection = |bench: &Bench<'_>| -> Vec<String> {
        let selection = &bench.harness.state().state.selection;
        selection.windows(bench.session()).map(|window| window.name.clone()).collect()
    };
    assert_eq!(selection(&bench), std::slice::from_ref(&added));
    let places = ["mark first:", &format!("mark {added}:")].map(|name| bench.mark_at(name));
    assert!(places[0].distance(first) > 1.0 || places[1].distance(candidate) > 1.0 || places[0] != places[1]);
    bench.lasso(&about(&places), Modifiers::NONE);
    assert_eq!(selection(&bench).len(), 2);
    bench.press("validation");
    let roles = |bench: &Bench<'_>| bench.session().windows.iter().map(|window| window.role).collect::<Vec<_>>();
    assert_eq!(roles(&bench), [WindowRole::Validation; 2]);
    bench.undo_once();
    assert_eq!(roles(&bench), [WindowRole::Identification; 2], "one undo for both");
    // A click selects alone, one with Shift adds and takes out again.
    bench.choose_containing("mark first:");
    assert_eq!(selection(&bench), ["first"]);
    for expected in [2, 1] {
        bench.harness.get_by_label_contains(&format!("mark {added}:")).click_modifiers(Modifiers::SHIFT);
        bench.settle();
        assert_eq!(selection(&bench).len(), expected);
    }
    bench.undo_once();
    assert_eq!(bench.session().windows.len(), 1, "the candidate is one again");
}

#[test]
fn map_is_walked_and_used_by_keys_alone() {
    let mut bench = bench();
    bench.show(Pane::ManoeuvreMap);
    bench.harness.state_mut().state.selection.window = None;
    bench.harness.get_by_label_contains("manoeuvre map,").focus();
    bench.harness.run_steps(2);
    let candidate_right = bench.mark_at("candidate ").x > bench.mark_at("mark first:").x;
    // The first arrow goes to the first mark, the next ones from there.
    bench.harness.key_press(Key::ArrowRight);
    bench.harness.run_steps(2);
    bench.harness.key_press(Key::Space);
    bench.settle();
    assert_eq!(bench.harness.state().state.selection.window.as_deref(), Some("first"));
    bench.harness.key_press(Key::X);
    bench.settle();
    assert_eq!(bench.session().windows[0].role, WindowRole::Ignored);
    bench.undo_once();
    bench.harness.get_by_label_contains("manoeuvre map,").focus();
    bench.harness.run_steps(2);
    bench.harness.key_press(if candidate_right { Key::ArrowRight } else { Key::ArrowLeft });
    bench.harness.run_steps(2);
    picture(&mut bench.harness, "map_keys");
    bench.harness.key_press(Key::Enter);
    bench.settle();
    bench.harness.key_press(Key::Y);
    bench.settle();
    assert_eq!(bench.session().windows.len(), 2, "the candidate is accepted");
}

#[test]
fn map_of_the_shipped_flight_fits_a_laptop_and_is_a_figure() {
    let mut bench = Bench::shipped_in(1280.0, 720.0);
    bench.show(Pane::ManoeuvreMap);
    for theme in [ThemePreference::Dark, ThemePreference::Light] {
        bench.request(UiCommand::View(ViewCommand::Appearance(theme)));
        bench.harness.hover_at(egui::pos2(640.0, 717.0));
        bench.harness.run_steps(4);
        picture(&mut bench.harness, &format!("map_{theme:?}"));
        assert_eq!(faults(&bench), [""; 0]);
    }
    let name = bench.session().windows[0].name.clone();
    let mark = bench.mark_at(&format!("mark {name}:"));
    bench.harness.hover_at(mark);
    bench.harness.run_steps(20);
    picture(&mut bench.harness, "map_hover");
    assert!(bench.harness.query_by_label_contains("True airspeed: ").is_some(), "values with units");
    bench.harness.set_size(vec2(1920.0, 1080.0));
    bench.settle();
    picture(&mut bench.harness, "map_1920");
}

#[test]
fn marks_speak_their_coordinates_and_selected_candidates_are_of_the_shared_selection() {
    let mut bench = bench();
    bench.show(Pane::ManoeuvreMap);
    let is_mark = |label: &str| label.starts_with("mark ") || label.starts_with("candidate ");
    let marks = bench.harness.query_all_by_label_contains("a").filter_map(|node| {
        let node = node.accesskit_node();
        Some((node.label()?, node.value().unwrap_or_default()))
    });
    let marks: Vec<(String, String)> = marks.filter(|(label, _)| is_mark(label)).collect();
    assert!(marks.len() > 1, "{marks:?}");
    assert!(marks.iter().all(|(_, value)| value.contains(" m/s") && value.contains(" deg")), "{marks:?}");
    let candidate = marks.iter().find(|(label, _)| label.starts_with("candidate ")).expect("one is open").0.clone();
    bench.harness.get_by_label(&candidate).click();
    bench.settle();
    let selection = bench.harness.state().state.selection.clone();
    let found = bench.snapshot().proposals["flight"].ready().expect("the flight was looked through").windows.clone();
    let selected: Vec<_> = found.iter().filter(|one| selection.has_candidate(&one.manoeuvre)).collect();
    assert!(
        matches!(selected[..], [one] if candidate.contains(&one.manoeuvre.name)),
        "{candidate}: {}",
        selected.len()
    );
}
