//! Small things that a first look at the workbench stumbled over, each with what is to be seen now.

use doublet::command::{EditCommand, FileCommand, UiCommand, ViewCommand};
use doublet::notation;
use doublet::panels::Pane;
use doublet::step::Step;
use doublet::ui_state::Scope;
use doublet_core::model::{Coefficient, Structure, Term};
use doublet_core::reconstruct::{Measurement, State};
use doublet_core::series::TimeRange;
use doublet_engine::session::{Edit, ModelEdit, WindowEdit};
use egui::{Key, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

use crate::painted::{faults, opacities};
use crate::workbench::Bench;
use crate::{click, picture, secondary_click};

/// Longest way of the shipped flight from its origin is some tens of kilometres.
const MOST_KM: f64 = 200.0;

#[test]
fn long_track_is_in_kilometres() {
    let mut bench = Bench::shipped();
    bench.show(Pane::GroundTrack);
    picture(&mut bench.harness, "ground_track");
    secondary_click(&mut bench.harness, egui::pos2(430.0, 300.0));
    click(&mut bench.harness, "Save data as CSV…", 3);
    let file = bench.folder.path().join("track.csv");
    bench.enter_file(&file.display().to_string());
    let text = std::fs::read_to_string(file).expect("it is written");
    assert!(text.starts_with("east [km],"), "{text:.80}");
    let farthest =
        text.lines().skip(1).filter_map(|line| line.split(',').next()?.parse::<f64>().ok()).fold(0.0, f64::max);
    assert!((10.0..MOST_KM).contains(&farthest), "{farthest} km");
}

#[test]
fn derivative_with_something_against_it_is_marked_and_no_column_runs_into_the_next() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Derivatives);
    assert!(bench.harness.query_by_label("CX_alpha: caution").is_some(), "a borrowed derivative is marked");
    assert!(bench.harness.query_by_label_contains("Cm_q: ").is_none(), "a good one is not");
    for scope in [Scope::Over, Scope::Each, Scope::All] {
        bench.harness.state_mut().state.selection.scope = scope;
        bench.settle();
        let found = faults(&bench);
        let in_panel: Vec<_> =
            found.iter().filter(|fault| fault.contains('±') || fault.contains("lies over")).collect();
        assert!(in_panel.is_empty(), "{scope:?}: {in_panel:#?}");
        picture(&mut bench.harness, &format!("derivatives_{scope:?}"));
    }
}

#[test]
fn menu_ticks_the_theme_and_enter_saves_where_changes_would_be_lost() {
    let mut bench = Bench::open();
    click(&mut bench.harness, "View", 3);
    let chosen = |bench: &Bench<'_>, name: &str| {
        let node = bench.harness.get_by_label_contains(name);
        let node = node.accesskit_node();
        node.toggled() == Some(egui::accesskit::Toggled::True) || node.is_selected() == Some(true)
    };
    assert!(chosen(&bench, "Dark theme") && !chosen(&bench, "Light theme"));
    picture(&mut bench.harness, "menu_view");
    bench.harness.key_press(Key::Escape);
    bench.harness.run_steps(3);
    let note = WindowEdit::Note { name: "first".to_owned(), note: "kept".to_owned() };
    bench.harness.state_mut().apply(&Edit::Window(note));
    bench.settle();
    bench.request(UiCommand::File(FileCommand::OpenShipped));
    assert!(bench.harness.state().is_guarding());
    bench.harness.key_press(Key::Enter);
    bench.settle();
    let text = std::fs::read_to_string(bench.folder.path().join("session.toml")).expect("it is there");
    assert!(text.contains("note = \"kept\""), "Enter saved");
}

#[test]
fn panel_without_a_study_offers_it_and_the_log_names_no_file_of_a_cache() {
    let mut bench = Bench::open();
    bench.show(Pane::Sensitivity);
    bench.choose("Compute it");
    assert!(bench.snapshot().studies.sensitivity.ready().is_some(), "the button in the middle computes it");
    let mut bench = Bench::shipped();
    bench.show(Pane::Log);
    picture(&mut bench.harness, "log");
    for hidden in [".cache", "/tmp/", "doublet/demo"] {
        assert!(bench.harness.query_by_label_contains(hidden).is_none(), "the log says {hidden}");
    }
}

#[test]
fn layout_kept_as_it_first_is_has_lanes_high_enough_at_the_size_of_a_laptop() {
    let mut bench = Bench::shipped_in(1366.0, 768.0);
    bench.request(UiCommand::View(ViewCommand::Step(Step::Manoeuvres)));
    bench.harness.set_size(vec2(1366.0, 768.0));
    bench.harness.run_steps(4);
    let plots = bench.harness.get_all_by_label_contains("legend ").map(|node| node.rect()).collect::<Vec<_>>();
    let mut tops: Vec<f32> = plots.iter().map(|rect| rect.top()).collect();
    tops.sort_by(f32::total_cmp);
    tops.dedup_by(|a, b| (*a - *b).abs() < 4.0);
    assert!(tops.windows(2).all(|pair| pair[1] - pair[0] >= 80.0), "{tops:?}");
}

#[test]
fn recording_that_was_moved_is_found_again_in_one_step_of_undo() {
    let mut bench = Bench::open_changed(|folder| {
        std::fs::create_dir(folder.join("elsewhere")).expect("there is room for a folder");
        std::fs::rename(folder.join("flight.csv"), folder.join("elsewhere/flight.csv")).expect("it is moved");
    });
    assert!(bench.snapshot().flights["flight"].error().is_some(), "it is missing");
    assert!(bench.harness.query_all_by_label("Find it…").count() >= 1, "the strip leads to it");
    let before = bench.session().clone();
    bench.request(UiCommand::File(FileCommand::FindRecording));
    bench.harness.get_by_label("File name").type_text("elsewhere/flight.csv");
    bench.harness.run_steps(2);
    bench.harness.key_press(Key::Enter);
    bench.settle();
    assert!(bench.snapshot().flights["flight"].ready().is_some(), "it is read from there");
    assert!(bench.session().flights[0].recordings[0].path.ends_with("flight.csv"));
    bench.request(UiCommand::Edit(doublet::command::EditCommand::Undo));
    assert_eq!(bench.session().flights, before.flights);
}

#[test]
fn reason_of_a_fit_that_failed_is_read_whole_in_a_narrow_window() {
    let mut bench = Bench::open();
    bench.harness.set_size(vec2(1280.0, 720.0));
    let terms = ["1", "alpha", "qc/V", "delta_e", "alpha^2", "alpha*delta_e", "alpha^3", "delta_e^2", "alpha_dot"];
    let terms: Vec<Term> = terms.iter().map(|term| Term::parse(term).expect("it is a term")).collect();
    let structure = Structure { models: vec![(Coefficient::Cm, terms)] };
    let window = TimeRange { start_s: 5.0, end_s: 5.14 };
    let name = "first".to_owned();
    bench.harness.state_mut().apply(&Edit::Model(ModelEdit::Structure(structure)));
    bench.harness.state_mut().apply(&Edit::Window(WindowEdit::Place { name, window }));
    bench.settle();
    bench.show(Pane::Derivatives);
    picture(&mut bench.harness, "failed_fit");
    let texts: Vec<String> = bench
        .harness
        .query_all_by_label_contains("⚠")
        .filter_map(|node| node.accesskit_node().value().or_else(|| node.accesskit_node().label()))
        .collect();
    assert!(!texts.is_empty(), "it says why");
    for text in texts {
        let digits = text.split(|letter: char| !letter.is_ascii_digit()).map(str::len).max();
        assert!(digits.is_some_and(|longest| longest <= 3), "no false precision: {text}");
    }
    let cut: Vec<String> = faults(&bench).into_iter().filter(|fault| fault.contains('⚠')).collect();
    assert!(cut.is_empty(), "{cut:#?}");
}

#[test]
fn advice_calls_every_measurement_by_the_symbol_it_has_elsewhere() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Innovations);
    picture(&mut bench.harness, "innovations");
    bench.click("Advice");
    picture(&mut bench.harness, "advice");
    let name = bench.harness.state().state.selection.window.clone().expect("one is chosen");
    let path = bench.snapshot().windows[&name].path.ready().expect("it is reconstructed").clone();
    let channels = &path.assessment().consistency.as_ref().expect("innovations are there").channels;
    assert!(channels.len() > 5);
    for channel in channels {
        let symbol = notation::measurement(channel.measurement);
        assert!(bench.harness.query_all_by_label(symbol).next().is_some(), "{symbol} heads a row");
        let raw = format!("{}: ", channel.measurement.name());
        assert!(raw.starts_with(symbol) || bench.harness.query_all_by_label_contains(&raw).next().is_none(), "{raw}");
    }
}

#[test]
fn aircraft_without_stations_has_dashes_for_its_centre_of_gravity_and_no_empty_envelope() {
    let mut bench = Bench::open_changed(|folder| {
        let path = folder.join("session.toml");
        let text = std::fs::read_to_string(&path).expect("there is a session");
        let changed = text.replace("aircraft.toml", "builtin:citation_550_simulated");
        assert_ne!(changed, text);
        std::fs::write(path, changed).expect("it can be written");
    });
    bench.show(Pane::Loading);
    picture(&mut bench.harness, "loading_without_stations");
    assert!(bench.harness.query_all_by_label("–").count() >= 3, "no station is known");
    assert_eq!(bench.harness.query_all_by_label("0.000").count(), 0, "nothing stands for what is not known");
    assert!(bench.harness.query_by_label("The file of this aircraft states no envelope.").is_some());
    assert!(bench.harness.query_by_label("envelope").is_none(), "no axes around one point");
}

#[test]
fn every_coefficient_keeps_its_column_of_the_summary_and_every_window_its_name() {
    for (width, height) in [(1366.0, 768.0), (1920.0, 1080.0)] {
        let mut bench = Bench::shipped_in(1366.0, 768.0);
        // The reasons stand below at the first size and beside at the second: one does not take the size of the other.
        bench.request(UiCommand::View(ViewCommand::Step(Step::Results)));
        bench.show(Pane::Summary);
        bench.harness.set_size(vec2(width, height));
        bench.settle();
        let mut right = 0.0;
        for coefficient in ["CX", "CY", "CZ", "Cl", "Cm", "Cn"] {
            let name = format!("{coefficient}, all manoeuvres: ");
            let cell = bench
                .harness
                .get_all_by_role(egui::accesskit::Role::Button)
                .find(|cell| cell.accesskit_node().label().is_some_and(|label| label.starts_with(&name)));
            let cell = cell.expect("it is drawn").rect();
            assert!(cell.left() >= right && cell.right() < 0.5 * width, "{coefficient} at {width}: {cell:?}");
            right = cell.right();
        }
        let cut: Vec<String> = faults(&bench).into_iter().filter(|fault| fault.contains("elevator")).collect();
        assert!(cut.is_empty(), "{cut:#?}");
        assert!(shown(&bench, "07 elevator 3-2-1-1"), "the name is read whole at {width}");
    }
}

/// Whether this text is painted as it is, without an ellipsis.
fn shown(bench: &Bench<'_>, words: &str) -> bool {
    opacities(bench, words, 0.0).iter().any(|(_, opacity)| *opacity > 0.5)
}

#[test]
fn names_of_windows_are_read_whole_and_rows_stay_while_more_are_selected() {
    let mut bench = Bench::shipped_in(1366.0, 768.0);
    bench.request(UiCommand::View(ViewCommand::Step(Step::Manoeuvres)));
    bench.harness.set_size(vec2(1366.0, 768.0));
    bench.harness.run_steps(4);
    let row = |bench: &Bench<'_>| bench.harness.get_by_label("name of 03 elevator doublet").rect();
    let before = row(&bench);
    bench.request(UiCommand::Edit(EditCommand::SelectAll));
    assert!(bench.harness.query_by_label("35 selected:").is_some());
    assert_eq!(row(&bench).top(), before.top());
    picture(&mut bench.harness, "manoeuvres_selected");
    for name in ["03 elevator doublet", "07 elevator 3-2-1-1"] {
        assert!(faults(&bench).iter().all(|fault| !fault.contains(name)));
        assert!(opacities(&bench, name, before.top() - 60.0).len() == 1, "{name} without an ellipsis");
    }
}

#[test]
fn derivatives_stand_beside_their_numbers_in_a_wide_window() {
    let mut bench = Bench::shipped_in(1920.0, 1080.0);
    bench.request(UiCommand::View(ViewCommand::Step(Step::Results)));
    bench.show(Pane::Derivatives);
    bench.harness.set_size(vec2(1920.0, 1080.0));
    bench.settle();
    picture(&mut bench.harness, "derivatives_wide");
    let name = bench.harness.get_by_label("Cmα").rect();
    let pooled = bench.snapshot().pooled.ready().expect("it is computed");
    let fit = pooled.fits.iter().find(|fit| fit.coefficient == Coefficient::Cm).expect("it is modelled");
    let fit = fit.fit.as_ref().expect("it is estimated");
    let at = fit.names.iter().position(|name| name == "Cm_alpha").expect("it is a term");
    let number = bench.harness.get_by_label(&notation::number(fit.estimates[at])).rect();
    assert!(number.left() - name.right() < 180.0, "{name:?} {number:?}");
}

#[test]
fn sliders_of_the_trim_end_inside_a_narrow_panel() {
    let mut bench = Bench::shipped_in(1366.0, 768.0);
    bench.request(UiCommand::View(ViewCommand::Step(Step::Results)));
    bench.show(Pane::Dynamics);
    bench.harness.set_size(vec2(1366.0, 768.0));
    bench.settle();
    picture(&mut bench.harness, "modes_narrow");
    let name = bench.harness.get_all_by_label_contains("fuel [kg]").next().expect("it is named").rect();
    let chart = bench.harness.get_by_label("roots").rect();
    assert!(name.right() < 680.0 && chart.right() < 680.0, "{name:?} {chart:?}");
}

#[test]
fn path_beside_the_measurements_is_the_one_that_is_used() {
    let bench = Bench::shipped();
    let name = bench.harness.state().state.selection.window.clone().expect("one is chosen");
    let path = bench.snapshot().windows[&name].path.ready().expect("it is reconstructed").clone();
    let series = path.series();
    let north = Measurement::VelocityNorth as usize;
    // Before its first update the filter knows no wind: the smoother does.
    let (first, measured) = (series.reconstructed[north].values[0], series.measured[north].values[0]);
    assert!((first - measured).abs() < 0.3, "{first} beside {measured} m/s");
    let smoothed = series.smoothed.as_ref().expect("the session smooths");
    let bank = Measurement::BankAngle as usize;
    assert_eq!(series.reconstructed[bank].values, smoothed.states[State::BankAngle as usize].values);
}
