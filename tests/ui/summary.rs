//! The verdict on screen: its sentence, its grid, its reasons with the way to their fix, and the lamp.

use std::path::Path;

use doublet::app::Workbench;
use doublet::command::{EditCommand, UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet::step::Step;
use doublet_core::model::{Coefficient, Lag, Term};
use doublet_core::series::TimeRange;
use doublet_engine::session::{
    Configuration, Edit, EstimationEdit, FilterEdit, Fix, Manoeuvre, ModelEdit, Surface, WindowEdit, WindowRole,
};
use doublet_engine::verdict::{Finding, Level, VerdictCounts, Verdicts};
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use crate::picture;
use crate::workbench::Bench;

impl Bench<'_> {
    fn verdicts(&self) -> Verdicts {
        Verdicts::clone(self.snapshot().verdicts.ready().expect("the run was judged"))
    }

    /// Whether a button is called so.
    fn has_button(&self, label: &str) -> bool {
        self.harness.query_by_role_and_label(Role::Button, label).is_some()
    }
}

/// Every finding of a session.
fn findings(verdicts: &Verdicts) -> Vec<Finding> {
    let fits = verdicts.windows.values().flat_map(|window| &window.fits).chain(&verdicts.pooled);
    let of_fits = fits.flat_map(|fit| {
        let derivatives = fit.derivatives.iter().flat_map(|derivative| &derivative.verdict.reasons);
        fit.verdict.reasons.iter().chain(derivatives).cloned().collect::<Vec<_>>()
    });
    verdicts.session.reasons.iter().cloned().chain(of_fits).collect()
}

#[test]
fn first_tab_and_lamp_show_the_verdict_of_the_run() {
    let mut bench = Bench::open();
    let verdicts = bench.verdicts();
    assert!(bench.harness.query_all_by_label(&verdicts.headline()).count() >= 2, "in the panel and beside the lamp");
    let level = verdicts.session.level.name();
    assert!(bench.has_button(&format!("verdict: {level}")));
    let pooled = verdicts.fit(None, Coefficient::Cm).expect("Cm is estimated").verdict.level.name();
    assert!(bench.has_button(&format!("Cm, all manoeuvres: {pooled}")));
    let path = verdicts.windows["first"].verdict.level.name();
    assert!(bench.has_button(&format!("Flight path, first: {path}")));
    for finding in findings(&verdicts) {
        assert!(finding.panel.is_none_or(|panel| Pane::from_title(panel).is_some()), "{finding:?}");
    }
    picture(&mut bench.harness, "summary");
}

#[test]
fn drawer_of_a_laptop_shows_several_manoeuvres_beside_the_findings() {
    let mut bench = Bench::shipped_in(1280.0, 720.0);
    bench.request(UiCommand::View(ViewCommand::Step(Step::Filter)));
    bench.settle();
    picture(&mut bench.harness, "summary_drawer");
    let cells: Vec<_> =
        bench.harness.get_all_by_label_contains("Flight path, ").filter(|cell| cell.rect().bottom() < 700.0).collect();
    assert!(cells.len() >= 5, "{} rows", cells.len());
    let finding = bench.harness.get_all_by_label_contains("all manoeuvres: caution").map(|node| node.rect());
    let finding =
        finding.reduce(|one, other| if one.left() > other.left() { one } else { other }).expect("there is one");
    assert!(cells.iter().all(|cell| cell.rect().right() < finding.left()));
}

/// Keeps the elevator of the small flight at rest.
fn rest_elevator(folder: &Path) {
    let path = folder.join("flight.csv");
    let text = std::fs::read_to_string(&path).expect("the recording is there");
    let rest = |line: &str| {
        let kept = line.rsplit_once(',').filter(|(_, last)| last.parse::<f64>().is_ok()).map(|(kept, _)| kept);
        kept.map_or_else(|| line.to_owned(), |kept| format!("{kept},0")) + "\n"
    };
    std::fs::write(&path, text.lines().map(rest).collect::<String>()).expect("the recording can be written");
}

#[test]
fn reason_of_a_cell_leads_to_the_panel_that_cures_it() {
    let mut bench = Bench::open_changed(rest_elevator);
    let verdicts = bench.verdicts();
    let fit = verdicts.fit(None, Coefficient::Cm).expect("Cm is asked for");
    let reason = fit.verdict.reasons.first().expect("an elevator at rest tells nothing").clone();
    let panel = Pane::from_title(reason.panel.expect("it has a fix")).expect("the panel is there");
    bench
        .harness
        .get_by_role_and_label(Role::Button, &format!("Cm, all manoeuvres: {}", fit.verdict.level.name()))
        .click();
    bench.settle();
    assert!(bench.harness.query_by_label(&reason.text.to_string()).is_some(), "{reason:?}");
    picture(&mut bench.harness, "summary_reasons");
    let shown = |harness: &Harness<'_, Workbench>| {
        let layout = &harness.state().state.shown.tree;
        layout.tiles.find_pane(&panel).is_some_and(|tile| layout.is_visible_in_layout(tile))
    };
    let button = format!("Open {}", panel.title());
    bench.harness.get_all_by_label(&button).next().expect("the reason leads there").click();
    bench.settle();
    assert!(shown(&bench.harness), "{} is in front", panel.title());
}

#[test]
fn fix_is_applied_by_a_click_shown_with_the_verdict_before_and_after_and_undone() {
    let mut bench = Bench::open();
    let lag = Lag { delay_s: 0.15, ..Lag::default() };
    bench.harness.state_mut().apply(&Edit::Estimation(EstimationEdit::ControlLag(Surface::Elevator, lag)));
    bench.settle();
    let delay_s = |bench: &Bench<'_>| bench.session().preparation.control_lags.get(Surface::Elevator).delay_s;
    let before = VerdictCounts::count(&bench.verdicts());
    let verdicts = bench.verdicts();
    let reason = verdicts.session.reasons.iter().find(|reason| reason.code == "timing").expect("it acts too early");
    let fix = reason.fix.as_ref().expect("its delay can be stated");
    let tried = bench.snapshot().inquiries.fixes.row(fix).and_then(|slot| slot.ready().map(|outcome| outcome.verdict));
    let tried = tried.expect("the fix is tried before it is applied");
    let label = format!("Apply: {}", fix.label);
    let place = bench.harness.get_by_role_and_label(Role::Button, &label).rect().center();
    bench.harness.get_by_role_and_label(Role::Button, &label).click();
    bench.settle();
    let applied = bench.harness.get_by_label_contains("Applied:").rect();
    assert!(applied.contains(place), "its row stays under the pointer: {applied:?} {place:?}");
    assert!(delay_s(&bench).abs() < 0.02, "{}", delay_s(&bench));
    assert_eq!(VerdictCounts::count(&bench.verdicts()), tried, "the verdict is the promised one");
    let shown = |bench: &Bench<'_>, counts: VerdictCounts| {
        let VerdictCounts { level, good, caution, bad } = counts;
        let text = format!("{} ({good} good, {caution} caution, {bad} bad)", level.name());
        bench.harness.query_all_by_label(&text).next().is_some()
    };
    assert!(shown(&bench, before) && shown(&bench, VerdictCounts::count(&bench.verdicts())));
    picture(&mut bench.harness, "summary_fix");
    bench.harness.get_by_role_and_label(Role::Button, "Undo").click();
    bench.settle();
    assert_eq!(delay_s(&bench), 0.15);
    assert!(bench.harness.query_by_label_contains("Applied:").is_none());
    // The finding goes once the pointer leaves the list.
    let is_listed =
        |bench: &Bench<'_>| bench.has_button(&label) || bench.harness.query_by_label_contains("Applied:").is_some();
    bench.harness.get_by_role_and_label(Role::Button, &label).click();
    bench.settle();
    assert!(is_listed(&bench));
    bench.harness.hover_at(egui::pos2(2.0, 2.0));
    bench.harness.run_steps(3);
    assert!(!is_listed(&bench), "the fixed finding is gone");
}

#[test]
fn fix_is_kept_as_an_experiment_and_the_session_stays() {
    let mut bench = Bench::open();
    let lag = Lag { delay_s: 0.15, ..Lag::default() };
    bench.harness.state_mut().apply(&Edit::Estimation(EstimationEdit::ControlLag(Surface::Elevator, lag)));
    bench.settle();
    let verdicts = bench.verdicts();
    let reason = verdicts.session.reasons.iter().find(|reason| reason.code == "timing").expect("it acts too early");
    let fix = reason.fix.as_ref().expect("its delay can be stated");
    picture(&mut bench.harness, "summary_fixes");
    bench.harness.get_all_by_label("Add as experiment").next().expect("a delay is of the configuration").click();
    bench.settle();
    assert_eq!(bench.session().preparation.control_lags.get(Surface::Elevator).delay_s, 0.15);
    let fixed = fix.apply(bench.session()).expect("it applies");
    let experiment = bench.session().experiment(&fix.label).expect("it is kept under its label");
    assert_eq!(*experiment.configuration, Configuration::from_session(&fixed));
}

#[test]
fn failed_coefficient_turns_the_lamp_red_and_computing_is_another_sign() {
    let mut bench = Bench::open();
    // The pitch rate a second time, made dimensionless in another way: no fit tells the two apart.
    let term = Term::parse("qc/2V").expect("it is a term");
    let edit = Edit::Model(ModelEdit::SetTerm { coefficient: Coefficient::Cm, term, on: true });
    bench.harness.state_mut().apply(&edit);
    bench.harness.step();
    let computing = |bench: &Bench<'_>| bench.harness.query_all_by_label_contains(", computing").next().is_some();
    assert!(computing(&bench), "the ring turns about the last verdict");
    bench.settle();
    assert!(!computing(&bench));
    let verdicts = bench.verdicts();
    let fit = verdicts.fit(None, Coefficient::Cm).expect("Cm is modelled");
    assert_eq!((fit.verdict.level, verdicts.session.level), (Level::Bad, Level::Bad), "{:?}", fit.verdict.reasons);
    assert!(fit.verdict.reasons.iter().any(|reason| reason.code == "rank"), "{:?}", fit.verdict.reasons);
    assert!(bench.has_button("verdict: bad"));
    bench.show(Pane::Log);
    bench.harness.get_by_role_and_label(Role::Button, "verdict: bad").click();
    bench.settle();
    assert!(bench.has_button("Cm, all manoeuvres: bad"), "a click on the lamp shows why");
}

#[test]
fn verdict_of_the_shipped_flight_is_drawn_in_every_size_and_theme() {
    for (width, height) in [(1366.0, 768.0), (1920.0, 1080.0)] {
        let mut bench = Bench::shipped_in(width, height);
        let good = bench.verdicts().windows.values().filter(|window| window.verdict.level == Level::Good).count();
        assert!(good > 0, "{}", bench.verdicts().headline());
        for theme in [egui::ThemePreference::Dark, egui::ThemePreference::Light] {
            bench.request(UiCommand::View(ViewCommand::Appearance(theme)));
            bench.harness.hover_at(egui::pos2(2.0, 2.0));
            bench.harness.run_steps(3);
            picture(&mut bench.harness, &format!("summary_{width}_{theme:?}"));
        }
    }
}

#[test]
fn fixes_of_gravity_and_of_excluded_parts_can_be_tried_as_experiments() {
    let bench = Bench::open();
    let excluded = vec![TimeRange { start_s: 10.0, end_s: 12.0 }];
    let exclude = Edit::Window(WindowEdit::Exclude { name: "first".to_owned(), excluded });
    for edit in [Edit::Filter(FilterEdit::Gravity(9.79)), exclude] {
        let fix = Fix::new("fix", edit);
        assert!(fix.is_of_configuration(), "{fix:?}");
        let experiment = fix.to_experiment(bench.session()).expect("it applies");
        let fixed = fix.apply(bench.session()).expect("it applies");
        assert_eq!(experiment.configuration.applied_to(bench.session()), fixed, "the experiment is all of the fix");
    }
}

#[test]
fn a_session_without_a_manoeuvre_in_use_says_what_to_do_instead_of_a_verdict() {
    let mut bench = Bench::open();
    let says = |bench: &Bench<'_>, text: &str| bench.harness.query_all_by_label_contains(text).count();
    let role = |role| Edit::Window(WindowEdit::Role { name: "first".to_owned(), role });
    bench.harness.state_mut().apply(&role(WindowRole::Ignored));
    bench.settle();
    assert_eq!(says(&bench, "all manoeuvres are ignored"), 2, "in the panel and beside the lamp");
    bench.harness.state_mut().apply(&Edit::Window(WindowEdit::Remove("first".to_owned())));
    bench.settle();
    assert_eq!(says(&bench, "Nothing is estimated: mark a manoeuvre"), 2);
    assert!(bench.has_button("verdict: none yet"));
    assert_eq!(says(&bench, "0 of 0"), 0);
    picture(&mut bench.harness, "summary_no_manoeuvre");
    bench.press("Show the manoeuvres found");
    let layout = &bench.harness.state().state.shown.tree;
    let tile = layout.tiles.find_pane(&Pane::Manoeuvres).expect("it is in the layout");
    assert!(layout.is_visible_in_layout(tile));
    (0..2).for_each(|_| bench.request(UiCommand::Edit(EditCommand::Undo)));
    assert_eq!(says(&bench, "Nothing is estimated"), 0);
}

#[test]
fn summary_opens_with_the_findings_of_the_worst_coefficients_where_the_session_has_none() {
    let mut bench = Bench::shipped();
    let verdicts = bench.verdicts();
    assert!(verdicts.session.reasons.is_empty(), "{:?}", verdicts.session.reasons);
    let level = verdicts.pooled.iter().map(|fit| fit.verdict.level).max().expect("there are fits");
    assert!(level > Level::Good);
    let worst = verdicts.pooled.iter().find(|fit| fit.verdict.level == level).expect("one is the worst");
    assert!(bench.harness.query_by_label("No findings.").is_none());
    let title = format!("{}, all manoeuvres: {}", worst.coefficient.name(), level.name());
    picture(&mut bench.harness, "summary_worst");
    bench.harness.get_by_role_and_label(Role::Link, &title).click();
    bench.settle();
    assert!(bench.has_button("Session"), "its findings are chosen");
    bench.press("Session");
    assert!(bench.harness.query_by_role_and_label(Role::Link, &title).is_some());
}

#[test]
fn manoeuvres_removed_together_are_called_the_same_in_the_status_line_and_in_the_list_of_edits() {
    let mut bench = Bench::open();
    let second = Manoeuvre {
        name: "second".to_owned(),
        window: TimeRange { start_s: 30.0, end_s: 45.0 },
        ..bench.session().windows[0].clone()
    };
    bench.harness.state_mut().apply(&Edit::Window(WindowEdit::Add(second)));
    bench.settle();
    bench.harness.state_mut().state.selection.others = ["second".to_owned()].into();
    bench.request(UiCommand::Edit(EditCommand::RemoveWindow));
    assert!(bench.session().windows.is_empty());
    let causes: Vec<&str> = bench.snapshot().log.iter().map(|line| line.cause.as_str()).collect();
    assert_eq!(causes.last(), Some(&"remove 2 manoeuvres"), "{causes:?}");
    assert_eq!(bench.harness.state().document.history.undo_label(), Some("remove 2 manoeuvres"));
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.snapshot().log.last().map(|line| line.cause.as_str()), Some("undo remove 2 manoeuvres"));
}
