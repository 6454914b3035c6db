//! Windows over each other, structures beside each other, words at an instant, what goes into the report by hand.

use doublet::command::{EditCommand, UiCommand, ViewCommand};
use doublet::notation;
use doublet::panels::Pane;
use doublet::step::Step;
use doublet::ui_state::Scope;
use doublet_core::model::Coefficient;
use doublet_engine::compare::PRESENT;
use doublet_engine::session::{
    self, Edit, Experiment, ExperimentEdit, FilterEdit, ModelEdit, Surface, filter_experiments, noise_experiments,
};
use egui::{Key, pos2, vec2};
use egui_kittest::kittest::Queryable;

use crate::painted::faults;
use crate::workbench::Bench;
use crate::{picture, secondary_click};

/// Part of its range that an input has moved by where it has begun.
const MOVED: f64 = 0.2;
/// Longest time from an onset to there, s.
const RISE_S: f64 = 0.6;
/// Rounding of a sum over some thousand samples.
const ROUNDING: f64 = 1e-9;

/// Numbers behind the plot at a place of the screen.
fn save_data(bench: &mut Bench<'_>, at: egui::Pos2) -> String {
    secondary_click(&mut bench.harness, at);
    bench.harness.get_by_label_contains("This plot").click();
    bench.harness.run_steps(4);
    bench.harness.get_by_label("Save data as CSV…").click();
    bench.harness.run_steps(3);
    let file = bench.folder.path().join("plot.csv");
    bench.enter_file(&file.display().to_string());
    std::fs::read_to_string(file).expect("it is written")
}

#[test]
fn windows_over_each_other_have_their_inputs_begin_at_zero_and_their_model_beside_them() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Gallery);
    let elevator = bench.session().windows.iter().filter(|window| window.surface == Some(Surface::Elevator));
    let names: Vec<String> = elevator.map(|window| window.name.clone()).take(4).collect();
    assert_eq!(names.len(), 4);
    let selection = &mut bench.harness.state_mut().state.selection;
    selection.window = Some(names[0].clone());
    selection.others = names[1..].iter().cloned().collect();
    bench.settle();
    bench.harness.get_by_label("Over each other").click();
    bench.settle();
    picture(&mut bench.harness, "overlay");
    let top = bench.harness.get_by_label("Signals").rect().bottom();
    let text = save_data(&mut bench, pos2(500.0, top + 70.0));
    let mut lines = text.lines();
    let head = lines.next().unwrap_or_default();
    for name in &names {
        assert!(head.contains(&format!("{name} [deg]")), "{head}");
    }
    let rows: Vec<Vec<Option<f64>>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().ok()).collect()).collect();
    // Measured curves are every second column, the model of a deflection is empty.
    for (at, name) in names.iter().enumerate() {
        let curve: Vec<(f64, f64)> = rows.iter().filter_map(|row| Some((row[0]?, row[1 + 2 * at]?))).collect();
        let first = curve[0].1;
        let range = curve.iter().fold((first, first), |(low, high), (_, value)| (low.min(*value), high.max(*value)));
        let moved = |value: f64| (value - first).abs() > MOVED * (range.1 - range.0);
        let begins_s = curve.iter().find(|(_, value)| moved(*value)).map(|(time_s, _)| *time_s).expect("it moves");
        assert!((0.0..RISE_S).contains(&begins_s), "{name} begins at {begins_s} s");
    }
}

/// `N ln(v'v / N) + charge p` of the pooled fit of Cm.
fn criterion(bench: &Bench<'_>, charge: impl Fn(f64) -> f64) -> f64 {
    let fit = bench.cm();
    let samples = fit.residuals.len() as f64;
    let squares: f64 = fit.residuals.iter().map(|v| v * v).sum();
    samples * (squares / samples).ln() + charge(samples) * fit.estimates.len() as f64
}

#[test]
fn structures_are_scored_as_their_fits_say_and_one_is_taken_back_in_one_step() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Model);
    let full = bench.session().structure.clone();
    let (akaike, bayes) = (criterion(&bench, |_| 2.0), criterion(&bench, f64::ln));
    bench.click("Keep as experiment");
    let coefficient = Coefficient::Cm;
    let terms = full.terms(coefficient).expect("Cm is modelled");
    let term = terms.iter().find(|one| one.to_string().contains('q')).expect("pitch damping is a term").clone();
    bench.harness.state_mut().apply(&Edit::Model(ModelEdit::SetTerm { coefficient, term, on: false }));
    bench.settle();
    bench.click("Experiments");
    let rows = bench.snapshot().inquiries.experiments.clone();
    let row = |name: &str| rows.row(name).and_then(|slot| slot.ready()).expect("it is computed").outcome.clone();
    let fit = |name: &str| row(name).coefficient("Cm").and_then(|one| one.fit.clone()).expect("Cm is fitted");
    let (kept, now) = (fit("Experiment 1"), fit(PRESENT));
    for (found, expected) in [(kept.akaike, akaike), (kept.bayes, bayes)] {
        assert!((found - expected).abs() < ROUNDING * expected.abs(), "{found} is not {expected}");
    }
    assert_eq!(kept.delta_akaike, Some(kept.akaike - now.akaike));
    assert_eq!(kept.delta_bayes, Some(kept.bayes - now.bayes));
    assert_eq!(now.parameters + 1, kept.parameters);
    assert!(now.akaike > kept.akaike + 100.0 && now.predicted_squared_error > kept.predicted_squared_error);
    let [before, without] = [&kept, &now].map(|fit| fit.honest_r_squared.expect("there are validation manoeuvres"));
    assert!(before > without + 0.01, "pitch damping predicts: {before}, {without} without");
    crate::click(&mut bench.harness, "Copy scores as CSV", 1);
    let text = crate::copied(&bench.harness).expect("the scores are in the clipboard");
    let line = text.lines().find(|line| line.starts_with("Experiment 1,Cm,")).expect("it is scored");
    let cells: Vec<f64> = line.split(',').skip(2).map(|cell| cell.parse().expect("a number")).collect();
    assert_eq!(
        (cells[2], cells[4], cells[5], cells[7]),
        (kept.r_squared, kept.predicted_squared_error, kept.akaike, kept.bayes)
    );
    // Side by side: what a structure of Cm leaves as it is steps back, and is the same in the clipboard.
    bench.click("Experiment 1");
    picture(&mut bench.harness, "structures_compared");
    let title = bench.harness.get_by_label("Difference").rect();
    let mut same = crate::painted::opacities(&bench, &notation::number(0.0), title.bottom());
    same.retain(|(place, _)| (place.left() - title.left()).abs() < 8.0);
    assert!(same.len() >= 2 && same.iter().all(|(_, opacity)| *opacity < 0.5), "{same:?}");
    crate::click(&mut bench.harness, "Copy derivatives as CSV", 1);
    let text = crate::copied(&bench.harness).expect("the derivatives are in the clipboard");
    let line = text.lines().find(|line| line.starts_with("Cm_alpha,")).expect("both have it");
    let cells: Vec<f64> = line.split(',').skip(1).map(|cell| cell.parse().expect("a number")).collect();
    let estimate = |name: &str| {
        let outcome = row(name);
        let all = outcome.coefficients.iter().flat_map(|one| &one.derivatives);
        all.clone().find(|one| one.name == "Cm_alpha").expect("it is estimated").interval.estimate
    };
    let (first, second) = (estimate(PRESENT), estimate("Experiment 1"));
    assert_eq!((cells[0], cells[2], cells[4]), (first, second, second - first));
    assert_ne!(first, second);
    let line = text.lines().find(|line| line.starts_with("Cm_q,")).expect("one of them has it");
    assert!(line.starts_with("Cm_q,,,"), "{line}");
    bench.click("Make current");
    assert_eq!(bench.session().structure, full);
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_ne!(bench.session().structure, full, "one step");
    let text = session::print(bench.session()).expect("it can be written");
    assert_eq!(session::parse(&text).expect("it can be read").experiments, bench.session().experiments);
}

#[test]
fn words_at_an_instant_are_drawn_saved_changed_and_undone() {
    let mut bench = Bench::open();
    let place = bench.harness.get_by_role_and_label(egui::accesskit::Role::Button, "first").rect();
    let at = place.center() + vec2(0.0, 90.0);
    bench.harness.hover_at(at);
    bench.harness.run_steps(3);
    let time_s = bench.harness.state().state.time.cursor_s.expect("the pointer is over a plot");
    bench.harness.key_press(Key::T);
    bench.harness.run_steps(4);
    bench.harness.get_by_label("words of the annotation").type_text("gust from the left");
    bench.harness.run_steps(1);
    bench.harness.key_press(Key::Enter);
    bench.settle();
    let one = bench.session().annotations.first().expect("it is in the session").clone();
    assert_eq!((one.time_s, one.text.as_str()), (time_s, "gust from the left"));
    assert_eq!(bench.harness.state().document.history.undo_label(), Some("annotate"));
    picture(&mut bench.harness, "annotation");
    let text = session::print(bench.session()).expect("it can be written");
    assert_eq!(session::parse(&text).expect("it can be read").annotations, [one]);
    let all: Vec<_> =
        bench.harness.get_all_by_label_contains("annotation gust").map(|node| node.rect().center()).collect();
    crate::drag(&mut bench.harness, all[0], all[0], 0);
    bench.harness.run_steps(3);
    bench.harness.get_by_label("Remove annotation").click();
    bench.settle();
    assert!(bench.session().annotations.is_empty());
    bench.request(UiCommand::Edit(EditCommand::Undo));
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert!(bench.session().annotations.is_empty(), "before it was written");
    assert_eq!(bench.harness.state().document.history.undo_label(), None);
}

#[test]
fn aircraft_replay_and_pictures_of_windows_go_into_the_report() {
    let mut bench = Bench::shipped();
    for (pane, name) in [(Pane::Airframe, "from above"), (Pane::Airframe, "from the side"), (Pane::Replay, "attitude")]
    {
        bench.show(pane);
        let at = bench.harness.get_by_label(name).rect();
        secondary_click(&mut bench.harness, at.left_bottom() + vec2(50.0, -50.0));
        bench.harness.get_by_label("Add to the report").click();
        bench.settle();
    }
    let first = bench.session().windows[0].name.clone();
    let verdicts = ["good", "caution", "bad"].map(|word| format!("picture {first}: {word}"));
    bench.show(Pane::Gallery);
    let named = verdicts.into_iter().find(|name| bench.harness.query_by_label(name).is_some());
    let at = bench.harness.get_by_label(&named.expect("the manoeuvre has its picture")).rect();
    secondary_click(&mut bench.harness, at.center());
    bench.harness.get_by_label("Add to the report").click();
    bench.settle();
    let figures: Vec<_> =
        bench.session().report_figures.iter().map(|one| one.figure().expect("it can be read")).collect();
    let caption = |at: usize| figures[at].caption.as_str();
    assert_eq!([0, 1, 2].map(caption), ["the aircraft from above", "the aircraft from the side", "attitude, attitude"]);
    assert_eq!((caption(3), figures[3].panels.len()), (format!("manoeuvre {first}").as_str(), 2));
    let lines = |at: usize| doublet_report::svg::svg(&figures[at], "p").matches("<path").count();
    assert!((0..4).all(|at| lines(at) > 2), "each has its lines");
    // The wing is as wide in the figure as it is, but for its rounded tip.
    let aircraft = bench.snapshot().aircraft.ready().expect("it is read").clone();
    let doublet_engine::report::document::Panel::Plot(plot) = &figures[0].panels[0] else { panic!("a plot") };
    let right = plot.marks.iter().filter_map(|mark| match mark {
        doublet_engine::report::document::Mark::Points { points, .. } => Some(points),
        _ => None,
    });
    let tip = right.flatten().map(|point| point[1]).fold(0.0, f64::max);
    let half = 0.5 * aircraft.aircraft.reference.span_m;
    assert!((tip / half - 1.0).abs() < 0.05, "{tip} m of {half} m");
}

#[test]
fn plot_and_notes_go_into_the_report_with_their_words() {
    let mut bench = Bench::open();
    let place = bench.harness.get_by_role_and_label(egui::accesskit::Role::Button, "first").rect();
    secondary_click(&mut bench.harness, place.center() + vec2(0.0, 60.0));
    bench.harness.get_by_label_contains("This plot").click();
    bench.harness.run_steps(4);
    bench.harness.get_by_label("Add to the report").click();
    bench.harness.run_steps(3);
    bench.show(Pane::Report);
    bench.enter("caption of figure 1", "The flight as it was");
    bench.harness.get_by_label("notes of the report").click();
    bench.harness.run_steps(2);
    bench.harness.get_by_label("notes of the report").type_text("Air calm below 4000 ft.");
    bench.harness.run_steps(2);
    bench.harness.get_by_label("PDF").click();
    bench.settle();
    assert_eq!(bench.session().report_notes, "Air calm below 4000 ft.");
    assert_eq!(bench.harness.state().document.history.undo_label(), Some("change notes of the report"));
    let chosen = &bench.session().report_figures;
    assert_eq!(chosen.iter().map(|one| one.caption.as_str()).collect::<Vec<_>>(), ["The flight as it was"]);
    let text = session::print(bench.session()).expect("it can be written");
    assert_eq!(&session::parse(&text).expect("it can be read"), bench.session(), "figure and words are saved");
    picture(&mut bench.harness, "report_chosen");
    bench.harness.get_by_label("Write report…").click();
    bench.settle();
    bench.harness.get_by_label("Save").click();
    bench.settle();
    let html = std::fs::read_to_string(bench.folder.path().join("report").join("session.html")).expect("it is written");
    let section = html.split("<section").nth(1).expect("it has sections");
    assert!(
        section.contains("Notes and chosen figures") && section.contains("Air calm below 4000 ft."),
        "{section:.400}"
    );
    assert!(section.contains("The flight as it was") && section.contains("<svg"));
    for _ in 0..3 {
        bench.request(UiCommand::Edit(EditCommand::Undo));
    }
    assert!(
        bench.session().report_figures.is_empty() && bench.session().report_notes.is_empty(),
        "three steps of undo"
    );
}

#[test]
fn experiments_are_added_computed_compared_and_one_is_made_current_in_one_step() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Experiments);
    let add = |bench: &mut Bench<'_>, family: &str| {
        bench.click("Add experiments");
        bench.click(family);
    };
    add(&mut bench, "Half and twice the measurement noise");
    add(&mut bench, "Cm without each term");
    bench.click("By all manoeuvres");
    bench.click("Keep");
    let names: Vec<String> = bench.session().experiments.iter().map(|one| one.name.clone()).collect();
    assert!(names.len() >= 5 && names.last().map(String::as_str) == Some("Experiment 1"), "{names:?}");
    let rows = &bench.snapshot().inquiries.experiments;
    let row = |name: &str| rows.row(name).and_then(|slot| slot.ready()).unwrap_or_else(|| panic!("{name} is computed"));
    assert!(names.iter().chain([&PRESENT.to_owned()]).all(|name| !row(name).outcome.coefficients.is_empty()));
    let without = names.iter().find(|name| name.contains("Cm_q")).expect("pitch damping is a term").clone();
    let akaike = row(&without).outcome.coefficient("Cm").and_then(|one| one.fit.as_ref()?.delta_akaike);
    let akaike = notation::fixed(akaike.expect("the samples are the same"), 0);
    let estimate = |name: &String| {
        let found = &row(name).outcome.coefficient("Cm").expect("it is modelled").derivatives;
        found.iter().find(|one| one.name == "Cm_alpha").map(|one| (name.clone(), one.interval.estimate))
    };
    let estimates: Vec<(String, f64)> = names.iter().filter_map(estimate).collect();
    bench.press("Cm");
    assert!(bench.harness.query_all_by_label(&akaike).next().is_some(), "the table says {akaike}");
    // Ordered by a derivative: the session stays first, the others rise, then fall, then stand as before.
    let top = |bench: &Bench<'_>, name: &str| {
        let label = format!("Cm_alpha of {name}");
        let cell = bench.harness.query_by_label(&label);
        cell.unwrap_or_else(|| panic!("{name} has its interval in its row")).rect().center().y
    };
    let shown = |bench: &Bench<'_>| {
        let mut shown = estimates.clone();
        shown.sort_by(|a, b| top(bench, &a.0).total_cmp(&top(bench, &b.0)));
        shown.into_iter().map(|(_, estimate)| estimate).collect::<Vec<_>>()
    };
    let mut rising: Vec<f64> = estimates.iter().map(|(_, estimate)| *estimate).collect();
    rising.sort_by(f64::total_cmp);
    let order = |bench: &mut Bench<'_>| {
        bench.harness.get_by_label("order by Cm_alpha").click();
        bench.harness.run_steps(3);
    };
    order(&mut bench);
    assert_eq!(shown(&bench), rising);
    assert!(estimates.iter().all(|(name, _)| top(&bench, PRESENT) < top(&bench, name)));
    picture(&mut bench.harness, "experiments_ordered");
    order(&mut bench);
    rising.reverse();
    assert_eq!(shown(&bench), rising);
    order(&mut bench);
    assert!(estimates.is_sorted_by(|a, b| top(&bench, &a.0) < top(&bench, &b.0)), "as the session has them");
    picture(&mut bench.harness, "experiments");
    bench.click(&without);
    picture(&mut bench.harness, "experiments_chosen");
    let before = bench.session().clone();
    bench.click("Make current");
    let structure = &bench.session().experiment(&without).expect("it stays").configuration.structure;
    assert_eq!(&bench.session().structure, structure);
    assert_ne!(structure, &before.structure);
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.session(), &before, "one step");
    // A second row beside it: what differs is named.
    bench.click("2 x measurement noise");
    assert!(bench.harness.query_all_by_label("Terms of Cm").next().is_some());
    assert!(bench.harness.query_all_by_label("Measurement noise of α").next().is_some());
    assert!(bench.harness.query_all_by_label_contains("model.").next().is_none(), "no key of the session file");
    picture(&mut bench.harness, "experiments_compared");
}

#[test]
fn board_of_experiments_has_every_derivative_and_cuts_no_text_on_a_small_screen() {
    let mut bench = Bench::shipped_in(1280.0, 720.0);
    bench.request(UiCommand::View(ViewCommand::Step(Step::Model)));
    bench.show(Pane::Experiments);
    bench.click("Add experiments");
    bench.click("Half and twice the measurement noise");
    let rows = &bench.snapshot().inquiries.experiments;
    let present = rows.row(PRESENT).and_then(|slot| slot.ready()).expect("it is computed");
    // The first coefficient is shown before another one is chosen.
    let first = present.outcome.coefficients.first().expect("there are estimates");
    assert!(first.derivatives.len() > 2);
    for derivative in &first.derivatives {
        let label = format!("{} of {PRESENT}", derivative.name);
        let cell = bench.harness.query_by_label(&label).unwrap_or_else(|| panic!("{label} is shown")).rect();
        assert!(cell.width() > 40.0 && cell.right() < 1280.0, "{}: {cell:?}", derivative.name);
    }
    picture(&mut bench.harness, "experiments_small");
    assert_eq!(faults(&bench), [""; 0]);
}

/// Columns of numbers behind the first plot below `top`, with their names.
fn columns(bench: &mut Bench<'_>, top: f32) -> (Vec<String>, Vec<Vec<Option<f64>>>) {
    let text = save_data(bench, pos2(500.0, top + 70.0));
    let mut lines = text.lines();
    let head = lines.next().unwrap_or_default().split(',').map(str::to_owned).collect();
    (head, lines.map(|line| line.split(',').map(|cell| cell.parse().ok()).collect()).collect())
}

#[test]
fn an_experiment_laid_over_the_session_is_drawn_in_every_plot_with_its_own_numbers_and_a_click_takes_it_off() {
    let mut bench = Bench::shipped();
    bench.harness.state_mut().state.selection.window = Some("03 elevator doublet".into());
    bench.settle();
    bench.show(Pane::Experiments);
    bench.click("Add experiments");
    bench.click("Cm without each term");
    bench.click("By all manoeuvres");
    let name = bench.session().experiments.iter().map(|one| one.name.clone()).find(|name| name.contains("Cm_q"));
    let name = name.expect("pitch damping is a term");
    bench.click(&format!("overlay {name}"));
    picture(&mut bench.harness, "overlay_chosen");
    assert_eq!(bench.harness.state().state.overlaid, std::slice::from_ref(&name));
    let slot = bench.snapshot().inquiries.overlaid.row(&name).and_then(|slot| slot.ready()).cloned();
    let overlaid = slot.expect("it is computed");
    let window = bench.harness.state().state.selection.window.clone().expect("a manoeuvre is chosen");
    let cm = |results: &doublet_engine::run::WindowResults| {
        let fits = results.fits.latest().expect("it is fitted").clone();
        let fit = fits.fits.iter().find(|fit| fit.coefficient == Coefficient::Cm).cloned();
        fit.expect("Cm is modelled")
    };
    let [own, other] = [&bench.snapshot().windows[&window], &overlaid.windows[&window]].map(cm);
    assert!(!other.fit.as_ref().expect("it is estimated").names.contains(&"Cm_q".to_owned()));
    let rms = |fit: &doublet_engine::stage::CoefficientFit| {
        let values = &fit.series.as_ref().expect("it has residuals").residual.values;
        (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
    };
    assert!(rms(&other) > 1.02 * rms(&own), "without pitch damping it fits worse: {} {}", rms(&other), rms(&own));
    for (pane, shown) in [(Pane::Reconstruction, "measured"), (Pane::Innovations, "Advice"), (Pane::Fits, "Fit")] {
        bench.show(pane);
        assert!(bench.harness.query_all_by_label(&format!("legend {name}")).next().is_some(), "{pane:?} {shown}");
        picture(&mut bench.harness, &format!("overlay_{pane:?}"));
    }
    // The numbers behind the residual are those of either fit.
    bench.press("Residual");
    let top = bench.harness.get_all_by_label("Whiteness").map(|node| node.rect().bottom()).fold(0.0, f32::max);
    let (head, rows) = columns(&mut bench, top);
    let at = head.iter().position(|title| title.contains(&name)).unwrap_or_else(|| panic!("{name} in {head:?}"));
    let (first, found) = (rows[0][0].expect("a time"), rows[0][at].expect("a value"));
    let drawn = overlaid.windows[&window].fits.latest().expect("it is fitted").fits[0].clone();
    let residual = &drawn.series.as_ref().expect("it has residuals").residual;
    let near = residual.time_s.partition_point(|time_s| *time_s < first - 1e-6);
    assert!((residual.values[near] - found).abs() <= 1e-6 * found.abs().max(1e-6), "{found} {}", residual.values[near]);
    bench.harness.state_mut().state.selection.scope = Scope::Intervals;
    bench.show(Pane::Derivatives);
    let of_all = format!("legend {name}, all manoeuvres");
    assert!(bench.harness.query_by_label(&of_all).is_some());
    picture(&mut bench.harness, "overlay_intervals");
    bench.show(Pane::Experiments);
    bench.click(&format!("overlay {name}"));
    assert!(bench.harness.state().state.overlaid.is_empty());
    bench.show(Pane::Fits);
    assert!(bench.harness.query_all_by_label(&format!("legend {name}")).next().is_none());
}

#[test]
fn experiments_of_one_name_are_numbered_and_none_is_overwritten() {
    let mut bench = Bench::open();
    bench.show(Pane::Experiments);
    bench.enter("name of the experiment", "mine");
    let first = bench.session().experiment("mine").expect("it is kept").clone();
    let edit = Edit::Filter(FilterEdit::Gravity(9.79));
    bench.harness.state_mut().apply(&edit);
    bench.settle();
    bench.harness.get_by_label("name of the experiment").focus();
    bench.harness.get_by_label("name of the experiment").type_text("mine");
    bench.harness.run_steps(2);
    assert!(bench.harness.query_by_label("Keep as mine 2").is_some(), "the button names it before it is kept");
    bench.harness.key_press(Key::Enter);
    bench.settle();
    let names = |bench: &Bench<'_>| bench.session().experiments.iter().map(|one| one.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&bench), ["mine", "mine 2"]);
    assert_eq!(bench.session().experiment("mine"), Some(&first), "it is what it was");
    // Of fixes with one label each is kept; the same one is not kept twice.
    let add = |experiment: &Experiment| Edit::Experiment(ExperimentEdit::Add(vec![experiment.clone()]));
    let other = Experiment { configuration: bench.session().experiments[1].configuration.clone(), ..first.clone() };
    for edit in [add(&first), add(&other)] {
        bench.harness.state_mut().apply(&edit);
    }
    bench.settle();
    assert_eq!(names(&bench), ["mine", "mine 2"]);
}

#[test]
fn experiments_are_computed_to_the_end_when_their_panel_is_left_and_another_manoeuvre_is_looked_at() {
    let mut bench = Bench::shipped();
    bench.request(UiCommand::View(ViewCommand::Step(Step::Model)));
    let added = [noise_experiments(bench.session()), filter_experiments(bench.session())].concat();
    let count = added.len() + 1;
    bench.harness.state_mut().apply(&Edit::Experiment(ExperimentEdit::Add(added)));
    bench.settle();
    assert!(bench.snapshot().inquiries.experiments.0.is_empty(), "nothing is computed before it is looked at");
    let show = |bench: &mut Bench<'_>, pane: Pane| {
        bench.harness.state_mut().request(UiCommand::View(ViewCommand::Show(pane)));
        bench.harness.run_steps(2);
    };
    show(&mut bench, Pane::Experiments);
    while bench.snapshot().inquiries.experiments.0.is_empty() {
        bench.harness.step();
    }
    let is_done = |bench: &Bench<'_>| {
        let rows = &bench.snapshot().inquiries.experiments.0;
        rows.len() == count && rows.iter().all(|(_, slot)| slot.ready().is_some())
    };
    assert!(!is_done(&bench), "the panel is left before all is computed");
    show(&mut bench, Pane::Fits);
    let layout = &bench.harness.state().state.shown.tree;
    let tile = layout.tiles.find_pane(&Pane::Experiments).expect("it is in the layout");
    assert!(!layout.active_tiles().contains(&tile), "the panel is left");
    bench.harness.state_mut().state.selection.window = Some("03 elevator doublet".into());
    bench.harness.run_steps(2);
    assert!(bench.harness.query_by_label_contains("Experiments: ").is_some(), "the status line says how far they are");
    bench.settle();
    assert!(is_done(&bench));
    assert!(bench.snapshot().details.ready().is_some());
}
