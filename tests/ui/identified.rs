//! What is asked of the identified model in the window: modes that move with a slider, whether it is enough, an earlier estimate against the
//! flight, inputs designed, tests judged.

use std::path::Path;
use std::time::{Duration, Instant};

use doublet::command::{EditCommand, UiCommand};
use doublet::panels::Pane;
use doublet_engine::graph::Context;
use doublet_engine::planning::{Enough, EnoughRequest, enough_blocks};
use doublet_engine::report::Reference;
use doublet_engine::report::document::Block;
use doublet_engine::run::answer;
use doublet_engine::session::{Edit, LoadingEdit};
use doublet_engine::study::{DynamicsRequest, DynamicsStudy};
use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::help::unexplained;
use crate::painted::broken;
use crate::workbench::Bench;
use crate::{hold, picture, secondary_click};

/// Longest wait for work in the background.
const PATIENCE: Duration = Duration::from_secs(240);

/// Steps until a label holds `text`.
fn await_label(bench: &mut Bench<'_>, text: &str) {
    let started = Instant::now();
    while bench.harness.query_by_label_contains(text).is_none() {
        assert!(started.elapsed() < PATIENCE, "'{text}' comes in time");
        std::thread::sleep(Duration::from_millis(20));
        bench.harness.step();
    }
    bench.harness.run_steps(3);
}

/// Cells of the tables that are to stay on one line.
fn short_cells(blocks: &[Block]) -> Vec<String> {
    let tables = blocks.iter().filter_map(|block| if let Block::Table(table) = block { Some(table) } else { None });
    let cells = tables.flat_map(|table| {
        table
            .rows
            .iter()
            .flat_map(|row| row.iter().zip(&table.columns).map(|(cell, column)| cell.readable(column.digits)))
    });
    cells.filter(|text| text.chars().count() <= 30).collect()
}

/// Frequency of the short period.
fn short_period(study: &DynamicsStudy) -> f64 {
    let mode = study.modes.modes.iter().find(|estimate| estimate.mode.name == "short period");
    mode.expect("there is one").mode.frequency_rad_s()
}

#[test]
fn roots_follow_a_slider_and_every_answer_is_that_of_the_engine_alone() {
    let mut bench = Bench::shipped_in(1600.0, 900.0);
    let (session, folder) = (bench.session().clone(), Path::new(""));
    bench.show(Pane::Dynamics);
    let study = bench.snapshot().inquiries.dynamics.ready().expect("it came without a button").clone();
    picture(&mut bench.harness, "modes");
    let alone = |bench: &Bench<'_>, request| {
        let context = Context::new(folder);
        let found = answer::<DynamicsStudy>(&session, bench.snapshot(), request, &context).expect("it is trimmed");
        short_period(&found)
    };
    assert_eq!(short_period(&study), alone(&bench, DynamicsRequest::default()));
    // Slider of the fuel: dragged to the left, less fuel, lighter and with another centre of gravity.
    let slider = bench.harness.get_all_by_role(Role::Slider).last().expect("the fuel is last").rect();
    let at = |part: f32| egui::pos2(slider.left() + part * slider.width(), slider.center().y);
    hold(&mut bench.harness, at(0.5), at(0.2), 4);
    let started = Instant::now();
    let moved = loop {
        bench.harness.step();
        let slot = &bench.snapshot().inquiries.dynamics;
        let found = slot.ready().filter(|found| found.request.samples == 0 && found.request.fuel_kg.is_some()).cloned();
        if let Some(found) = found {
            break found;
        }
        assert!(started.elapsed() < PATIENCE, "the roots follow the slider");
        std::thread::sleep(Duration::from_millis(2));
    };
    assert!(short_period(&moved) != short_period(&study), "while it moves");
    bench.harness.drop_at(at(0.2));
    bench.settle();
    let study = bench.snapshot().inquiries.dynamics.ready().expect("it rests").clone();
    assert_eq!(study.request.samples, DynamicsRequest::default().samples, "draws follow when it rests");
    assert_eq!(short_period(&study), alone(&bench, study.request));
    bench.click("Levels");
    assert!(bench.harness.query_by_label_contains("class I by its maximum mass").is_some());
    assert!(bench.harness.query_by_label_contains("criteria judged and counted").is_some());
    assert!(bench.harness.query_by_label_contains("the available aileron deflection").is_some(), "what is needed");
    picture(&mut bench.harness, "levels");
    bench.click("Control anticipation");
    assert!(bench.harness.query_by_label("control anticipation").is_some(), "the chart in logarithms");

    bench.show(Pane::Enough);
    let found = bench.snapshot().inquiries.enough.ready().expect("it is computed").clone();
    let again = answer::<Enough>(&session, bench.snapshot(), &EnoughRequest::default(), &Context::new(folder));
    let again = again.expect("it can be told");
    assert_eq!((found.met, found.of), (again.met, again.of));
    assert!(bench.harness.query_by_label_contains(&format!("{} of {} goals are met", found.met, found.of)).is_some());
    assert!(found.met < found.of && !found.next.is_empty() && found.windows.len() > 10);
    picture(&mut bench.harness, "enough");
    assert_eq!(unexplained(&bench), [""; 0], "every title says what it is");
    assert_eq!(broken(&bench, &short_cells(&enough_blocks(&found))), [""; 0], "short cells stay on one line");
    assert!(bench.harness.query_by_label("legend goal").is_some(), "curves are named");
    // A figure of a document goes into the report as a plot does.
    bench.harness.get_by_label_contains("figure of lg (error / goal)").scroll_to_me();
    bench.harness.run_steps(3);
    let figure = bench.harness.get_by_label_contains("figure of lg (error / goal)").rect();
    secondary_click(&mut bench.harness, figure.center());
    bench.choose("Add to the report");
    assert_eq!(bench.session().report_figures.len(), 1);
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert!(bench.session().report_figures.is_empty());

    let estimate = found.derivatives.iter().find(|row| row.name == "Cm_alpha").expect("it is identified").estimate;
    let values = vec![("Cm_alpha".to_owned(), 2.0 * estimate, Some(0.01)), ("Cm_q".to_owned(), -20.0, None)];
    bench.harness.state_mut().references.push(Reference { name: "wind tunnel".to_owned(), values });
    bench.show(Pane::Prior);
    let prior = bench.snapshot().inquiries.prior.ready().expect("it is computed").clone();
    let row = prior.derivatives.iter().find(|row| row.name == "Cm_alpha").expect("it was known");
    assert!(row.is_contradiction() && (row.flight.value - estimate).abs() < 1e-12);
    assert!(bench.harness.query_by_label_contains("Prior and flight disagree").is_some());
    picture(&mut bench.harness, "prior");
    assert_eq!(unexplained(&bench), [""; 0], "every title says what it is");
    assert_eq!(broken(&bench, &short_cells(&prior.blocks())), [""; 0], "short cells stay on one line");

    slider_of_the_fuel_begins_with_that_of_the_flight(&mut bench);
}

/// It begins at what the chosen flight has on board in its manoeuvres, not at what the session says of the others.
fn slider_of_the_fuel_begins_with_that_of_the_flight(bench: &mut Bench<'_>) {
    let (flight, all) = {
        let session = bench.session();
        let aircraft = bench.snapshot().aircraft.ready().expect("it is read");
        (session.flights[0].name.clone(), aircraft.aircraft.standard_loading.clone())
    };
    let mut own = all.clone();
    own.fuel_kg.values_mut().for_each(|fuel| *fuel *= 0.25);
    let aboard: f64 = own.fuel_kg.values().sum();
    let edit = LoadingEdit::OfFlight { flight, loading: Some(own) };
    bench.harness.state_mut().apply(&Edit::Loading(edit));
    bench.settle();
    bench.show(Pane::Dynamics);
    bench.choose_of("standard", "MIL-STD-1797A");
    bench.click("As flown");
    let judging = bench.snapshot().inquiries.dynamics.ready().expect("it is computed").limits.name.clone();
    assert_eq!(judging, "MIL-STD-1797A", "the choice of the standard stays");
    let sliders = bench.harness.get_all_by_role(Role::Slider);
    let shown = sliders.last().and_then(|slider| slider.accesskit_node().numeric_value()).expect("it has a value");
    let burnt = {
        let flown = bench.snapshot().flown.values().next().and_then(|slot| slot.ready()).expect("it is weighed");
        flown.start.state.properties.mass_kg - flown.end.state.properties.mass_kg
    };
    assert!(burnt > 1.0 && (aboard - burnt..aboard).contains(&shown), "{shown} kg of {aboard} less {burnt} kg");
}

#[test]
fn tests_that_come_with_the_program_are_offered_where_the_session_has_their_windows() {
    let mut bench = Bench::open();
    bench.show(Pane::Qualification);
    assert_eq!(bench.harness.get_by_label("file of tests").accesskit_node().value().as_deref(), Some(""));
    assert!(bench.harness.query_by_label_contains("Choose a file of objective tests").is_some());
    let judge = bench.harness.get_by_role_and_label(Role::Button, "Judge the tests");
    assert!(judge.accesskit_node().is_disabled());
    picture(&mut bench.harness, "qualification_empty");
    // A file of one's own comes by the dialog.
    let own = bench.folder.path().join("own_tests.toml");
    std::fs::write(&own, "").expect("the folder can be written");
    bench.push("browse file of tests");
    bench.choose("own_tests.toml");
    bench.push("Open");
    let typed = bench.harness.get_by_label("file of tests").accesskit_node().value().expect("it holds a text");
    assert_eq!(Path::new(&typed).canonicalize().ok(), own.canonicalize().ok());
}

#[test]
fn inputs_are_designed_and_tests_judged_in_the_background() {
    let mut bench = Bench::shipped_in(1600.0, 900.0);
    bench.show(Pane::Qualification);
    bench.harness.get_by_role_and_label(Role::Button, "Judge the tests").click();
    await_label(&mut bench, "tests pass");
    picture(&mut bench.harness, "qualification");
    // One is changed on purpose to fail; where the vane is not recorded (117 kt) no trim is judged.
    assert!(bench.harness.query_by_label_contains("10 of 18 tests pass (1 in part), 1 fail (1 on purpose)").is_some());
    assert_eq!(unexplained(&bench), [""; 0], "every title says what it is");
    bench.show(Pane::Design);
    bench.harness.get_by_role_and_label(Role::CheckBox, "compare kinds").click();
    bench.harness.run_steps(2);
    bench.harness.get_by_role_and_label(Role::Button, "Design the input").click();
    await_label(&mut bench, "Expected standard errors");
    picture(&mut bench.harness, "design");
    for (part, written, raw) in [
        ("Expected excursions", ["α", "β", "deg", "deg/s"], ["alpha", "beta", "rad", "rad/s"]),
        ("Expected standard errors", ["CXα", "CXα²", "CXq", "CXδe"], ["CX_alpha", "CX_alpha2", "CX_q", "CX_delta_e"]),
    ] {
        bench.harness.get_by_label(part).scroll_to_me();
        bench.harness.run_steps(4);
        picture(&mut bench.harness, &format!("design {part}"));
        for (written, raw) in written.into_iter().zip(raw) {
            assert!(bench.harness.query_all_by_label(written).next().is_some(), "{written} as it is written elsewhere");
            assert_eq!(bench.harness.query_all_by_label(raw).count(), 0, "{raw}");
        }
    }
    assert_eq!(unexplained(&bench), [""; 0], "every title says what it is");
    let folder = bench.folder.path().join("card");
    bench.harness.get_by_label("folder of the card").focus();
    bench.harness.get_by_label("folder of the card").type_text(&folder.display().to_string());
    bench.harness.run_steps(2);
    bench.harness.get_by_role_and_label(Role::Button, "Write card and files").click();
    await_label(&mut bench, "Written to");
    for name in ["design.html", "design.csv", "design_scenario.toml", "design_ardupilot.lua", "design_px4.params"] {
        assert!(folder.join(name).is_file(), "{name}");
    }
}
