//! Signals, clocks, steady parts, recorded noise and proposed manoeuvres, worked as a user would.

use doublet::app::files::Files;
use doublet::app::{Document, Workbench};
use doublet::command::{EditCommand, UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet_core::prep::{Interpolation, Smoothing, noise_statistics, smooth};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::Input;
use doublet_core::series::TimeRange;
use doublet_engine::session::{Edit, SignalPreset, SteadyWindow, WindowEdit};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use crate::workbench::Bench;
use crate::{builder, click, drag, picture, secondary_click};

fn series(bench: &Bench<'_>, role: Role) -> doublet_core::series::Series {
    let loaded =
        bench.snapshot().flights[&bench.session().flights[0].name].ready().expect("the flight is read").clone();
    loaded.recording.role(role).expect("it is recorded").series.clone()
}

#[test]
fn a_ticked_moving_average_smooths_the_signal_the_filter_gets_and_undo_gives_it_back() {
    let mut bench = Bench::open();
    bench.show(Pane::Preprocess);
    let (raw, before) = (series(&bench, Role::SpecificForceX), bench.cm().estimates);
    // The signal shown first is that of the first accelerometer.
    bench.choose("moving average");
    let smoothed = series(&bench, Role::SpecificForceX);
    let expected = smooth(&raw.time_s, &raw.values, Smoothing::MovingAverage { width: 4 }).expect("it can be smoothed");
    assert_eq!(smoothed.values[..], expected[..]);
    let path = bench.snapshot().windows["first"].path.ready().expect("the path is up to date").clone();
    let inside = TimeRange { start_s: 5.0, end_s: 25.0 }.indices(&raw.time_s);
    assert_eq!(path.data.inputs.columns[Input::SpecificForceX as usize][..], expected[inside]);
    picture(&mut bench.harness, "preprocess");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.cm().estimates, before);
}

#[test]
fn a_dragged_width_is_one_step_of_undo() {
    let mut bench = Bench::open();
    bench.show(Pane::Preprocess);
    bench.choose("moving average");
    let width = |bench: &Bench<'_>| {
        let rule = bench.session().flights[0].signals.rule(Role::SpecificForceX).cloned();
        rule.and_then(|rule| rule.moving_average)
    };
    assert_eq!(width(&bench), Some(4));
    let from = bench.harness.get_by_label("width of the average").rect().center();
    drag(&mut bench.harness, from, from + egui::vec2(40.0, 0.0), 8);
    bench.settle();
    let wider = width(&bench).expect("it is still smoothed");
    assert!(wider > 8, "the drag goes through many widths: {wider}");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(width(&bench), Some(4), "the drag is one step");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(width(&bench), None, "the tick is the one before");
    bench.request(UiCommand::Edit(EditCommand::Redo));
    bench.request(UiCommand::Edit(EditCommand::Redo));
    assert_eq!(width(&bench), Some(wider));
}

#[test]
fn the_thesis_preset_brings_every_signal_to_100_hz() {
    let mut bench = Bench::open();
    bench.show(Pane::Preprocess);
    bench.choose(SignalPreset::Thesis.name());
    let signals = bench.session().flights[0].signals.clone();
    assert_eq!(signals.preset(), Some(SignalPreset::Thesis));
    let alpha = signals.rule(Role::AngleOfAttack).and_then(|rule| rule.resampling).expect("it is resampled");
    assert_eq!((alpha.rate_hz, alpha.interpolation), (100.0, Interpolation::QuadraticSpline));
    let path = bench.snapshot().windows["first"].path.ready().expect("the path is up to date").clone();
    assert_eq!(path.data.inputs.time_s.len(), 2001);
    let proposals = bench.snapshot().proposals["flight"].ready().expect("spectra are up to date").clone();
    let pitch = proposals.spectra.iter().find(|spectrum| spectrum.role == Role::PitchRate).expect("it has a spectrum");
    let end = |spectrum: &doublet_core::prep::Spectrum| spectrum.frequency_hz.last().copied().expect("it is not empty");
    let treated = pitch.treated.as_ref().expect("it was treated");
    assert!((end(&pitch.recorded) - 25.0).abs() < 1e-6 && (end(treated) - 50.0).abs() < 1e-6);
}

#[test]
fn a_dragged_source_moves_its_stamps_in_one_step() {
    let mut bench = Bench::open();
    bench.show(Pane::Preprocess);
    let before = series(&bench, Role::PitchRate);
    let source = {
        let loaded = bench.snapshot().flights["flight"].ready().expect("the flight is read").clone();
        loaded.recording.role(Role::PitchRate).expect("it is recorded").source.clone()
    };
    bench.enter(&format!("shift {source}"), "40");
    let shift_s = bench.session().flights[0].clocks[0].shift_s;
    assert!((shift_s - 0.04).abs() < 1e-12, "{shift_s}");
    let after = series(&bench, Role::PitchRate);
    assert_eq!(before.values, after.values);
    assert!(before.time_s.iter().zip(&*after.time_s).all(|(a, b)| (b - a - 0.04).abs() < 1e-12));
    bench.harness.get_by_label(&format!("drag {source}")).scroll_to_me();
    bench.harness.run_steps(3);
    let strip = bench.harness.get_by_label(&format!("drag {source}")).rect();
    let from = strip.center();
    drag(&mut bench.harness, from, from + egui::vec2(strip.width() / 60.0, 0.0), 8);
    bench.settle();
    let dragged = bench.session().flights[0].clocks[0].shift_s;
    // Half a millisecond a point; the first points of the pointer's way tell a drag from a click.
    let whole = 5e-4 * f64::from(strip.width() / 60.0);
    assert!(dragged - 0.04 > 0.5 * whole && dragged - 0.04 < 1.01 * whole, "{dragged} s of {whole} s");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.session().flights[0].clocks[0].shift_s, shift_s, "the drag is one step");
}

#[test]
fn marked_windows_give_the_noise_and_a_button_takes_it() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Preprocess);
    let found = bench.snapshot().noise[&bench.session().flights[0].name].ready().expect("it was looked for").clone();
    let speaks = |steady: &&SteadyWindow| steady.roles.is_empty() || steady.roles.contains(&Role::PitchRate);
    let steady = found.windows.iter().find(speaks).expect("the flight has steady parts").window;
    let view = &mut bench.harness.state_mut().state.time;
    view.markers_s = [Some(steady.start_s), Some(steady.end_s)];
    bench.harness.run_steps(2);
    bench.click("Mark what is on screen");
    let marked = bench.session().steady[0].clone();
    assert_eq!((marked.window, marked.roles.len()), (steady, 0));
    let expected = noise_statistics(&series(&bench, Role::PitchRate), &[marked.window], 2).expect("samples lie inside");
    assert!(expected.samples > 100, "{}", expected.samples);
    bench.show(Pane::Noise);
    picture(&mut bench.harness, "noise_recorded");
    bench.choose("take recorded Q q");
    assert_eq!(bench.session().filter.process_noise[Input::PitchRate as usize], expected.std);
    // Another value, kept with its reason.
    bench.enter("Q q", "0.5");
    click(&mut bench.harness, "why Q q", 3);
    click(&mut bench.harness, "reason Q q", 2);
    bench.harness.get_by_label("reason Q q").type_text("vibration");
    bench.harness.run_steps(2);
    bench.choose("Keep");
    assert_eq!(bench.session().noise_reasons.get("q").map(String::as_str), Some("vibration"));
    bench.choose("take recorded Q q");
    assert!(!bench.session().noise_reasons.contains_key("q"));
    assert_eq!(bench.session().filter.process_noise[Input::PitchRate as usize], expected.std);
}

#[test]
fn proposed_manoeuvres_are_accepted_one_by_one_or_all_at_once() {
    let mut harness: Harness<'_, Workbench> = builder(1500.0, 950.0).build_eframe(|cc| {
        let document = Document::open_demo().expect("a session is shipped");
        let mut app = crate::overview(Workbench::new(cc, document).expect("a thread starts"));
        app.files = Files::without_system();
        let names: Vec<String> = app.document.session().windows.iter().map(|window| window.name.clone()).collect();
        for name in names {
            app.apply(&Edit::Window(WindowEdit::Remove(name)));
        }
        app
    });
    let settle = |harness: &mut Harness<'_, Workbench>| {
        harness.run_steps(3);
        for _ in 0..12_000 {
            if !harness.state().is_busy() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
            harness.step();
        }
        harness.run_steps(3);
        assert!(!harness.state().is_busy(), "results come in time");
    };
    settle(&mut harness);
    harness.state_mut().request(UiCommand::View(ViewCommand::Show(Pane::Manoeuvres)));
    settle(&mut harness);
    let found = harness.state().snapshot().proposals["FT1"].ready().expect("the flight is looked through").clone();
    harness.get_by_label_contains("not in the session:").click();
    settle(&mut harness);
    harness.get_by_label("accept 03 elevator doublet").click();
    settle(&mut harness);
    let session = |harness: &Harness<'_, Workbench>| harness.state().document.session().clone();
    let window = session(&harness).windows[0].clone();
    assert_eq!(session(&harness).windows.len(), 1);
    assert_eq!(window, found.windows[2].manoeuvre);
    let path = harness.state().snapshot().windows[&window.name].path.ready().expect("it is computed").clone();
    let expected = 50.0 * (window.window.end_s - window.window.start_s);
    assert!((path.data.inputs.time_s.len() as f64 - expected).abs() <= 1.0, "at 50 Hz");
    picture(&mut harness, "proposals");
    harness.get_by_label_contains("Accept all").click();
    settle(&mut harness);
    assert_eq!(session(&harness).windows.len(), found.windows.len());
    harness.state_mut().request(UiCommand::Edit(EditCommand::Undo));
    settle(&mut harness);
    assert_eq!(session(&harness).windows.len(), 1, "all of them are one step");
}

#[test]
fn a_typed_expression_becomes_a_channel_is_plotted_changed_and_removed() {
    let mut bench = Bench::open();
    bench.show(Pane::Flight);
    let (north, down) = (series(&bench, Role::VelocityNorth), series(&bench, Role::VelocityDown));
    bench.click("New channel by expression…");
    bench.enter("channel name", "path speed");
    bench.enter("channel unit", "m/s");
    let typed = |bench: &mut Bench<'_>, text: &str| {
        click(&mut bench.harness, "channel expression", 2);
        bench.harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
        bench.harness.run_steps(1);
        bench.harness.get_by_label("channel expression").type_text(text);
        bench.harness.run_steps(3);
    };
    typed(&mut bench, "sqrt(v_nort^2 + v_down^2)");
    bench.harness.get_by_label_contains("at character 6: no role is called 'v_nort': did you mean v_north");
    picture(&mut bench.harness, "expression_wrong");
    assert!(bench.session().flights[0].expressions.is_empty());
    typed(&mut bench, "sqrt(v_north^2 + v_down^2)");
    let first = north.values[0].hypot(down.values[0]);
    bench.harness.get_by_label(&format!("first value {} m/s", doublet::notation::number(first)));
    picture(&mut bench.harness, "expression");
    bench.click("Add channel");
    let made = |bench: &Bench<'_>| {
        let loaded = bench.snapshot().flights["flight"].ready().expect("the flight is read").clone();
        loaded.expressions.first().map(|made| loaded.recording.channels[made.channel].clone())
    };
    let channel = made(&bench).expect("it is computed");
    assert_eq!((channel.source.as_str(), channel.unit.as_str()), ("expression", "m/s"));
    assert_eq!((channel.series.values.len(), &channel.series.time_s), (north.values.len(), &north.time_s));
    for ((found, north), down) in channel.series.values.iter().zip(&*north.values).zip(&*down.values) {
        assert!((found - north.hypot(*down)).abs() < 1e-12, "{found}");
    }
    let plots = bench.harness.state().state.flight_plots.clone().expect("plots were chosen");
    assert_eq!(plots.last().map(Vec::as_slice), Some(&["expression/path speed".to_owned()][..]));
    picture(&mut bench.harness, "expression_plotted");
    let menu = |bench: &mut Bench<'_>, choice: &str| {
        bench.harness.get_by_label("plot expression/path speed").scroll_to_me();
        bench.harness.run_steps(3);
        let row = bench.harness.get_by_label("plot expression/path speed").rect();
        secondary_click(&mut bench.harness, row.center());
        click(&mut bench.harness, choice, 3);
    };
    menu(&mut bench, "Edit path speed…");
    typed(&mut bench, "2 * v_north");
    bench.click("Change channel");
    let doubled = made(&bench).expect("it is computed");
    assert!(doubled.series.values.iter().zip(&*north.values).all(|(found, north)| *found == 2.0 * north));
    menu(&mut bench, "Remove path speed");
    bench.settle();
    assert!(made(&bench).is_none() && bench.session().flights[0].expressions.is_empty());
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(made(&bench).expect("it is back").series.values, doubled.series.values);
    let text = doublet_engine::session::print(bench.session()).expect("it has a saved form");
    assert!(text.contains("[[flight.expression]]") && text.contains("expression = \"2 * v_north\""), "{text}");
}

#[test]
fn parts_of_steady_flight_are_not_called_windows() {
    let mut bench = Bench::open();
    bench.show(Pane::Preprocess);
    assert!(bench.harness.query_by_label("Steady parts").is_some());
    assert!(bench.harness.query_by_label_contains("teady windows").is_none());
}
