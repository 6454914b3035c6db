//! The aircraft to scale, edited by hand and by number, and its weighing.

use doublet::command::{EditCommand, UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet::step::Step;
use doublet_core::airframe::LoadedState;
use doublet_engine::aircraft::ChangedValue;
use egui::{ThemePreference, vec2};
use egui_kittest::kittest::Queryable;

use crate::workbench::Bench;
use crate::{drag, picture};

/// The shipped flight with the aircraft before it.
fn editor() -> Bench<'static> {
    let mut bench = Bench::shipped();
    bench.request(UiCommand::View(ViewCommand::Step(Step::Aircraft)));
    bench.show(Pane::Airframe);
    bench
}

fn loaded(bench: &Bench<'_>) -> LoadedState {
    (**bench.snapshot().loaded.ready().expect("it is up to date")).clone()
}

#[test]
fn aircraft_is_drawn_from_above_and_from_the_side_with_its_places() {
    let mut bench = editor();
    picture(&mut bench.harness, "airframe");
    for view in ["from above", "from the side"] {
        assert!(bench.harness.query_by_label(view).is_some(), "{view}");
    }
    let aircraft = bench.snapshot().aircraft.ready().expect("it is read").clone();
    for seat in &aircraft.aircraft.seats {
        let label = format!("seat {} from above", seat.name);
        let handle = bench.harness.query_by_label(&label);
        assert!(handle.is_some(), "{} has its handle", seat.name);
    }
    bench.click("Inertia");
    picture(&mut bench.harness, "airframe_inertia");
    bench.click("Limits");
    picture(&mut bench.harness, "airframe_limits");
}

#[test]
fn editor_has_room_in_small_and_large_windows_and_the_engine_chart_shows_the_flight() {
    for (width, height, theme) in [(1280.0, 720.0, ThemePreference::Light), (1920.0, 1080.0, ThemePreference::Dark)] {
        let mut bench = Bench::shipped_in(width, height);
        bench.request(UiCommand::View(ViewCommand::Appearance(theme)));
        bench.request(UiCommand::View(ViewCommand::Step(Step::Aircraft)));
        bench.show(Pane::Airframe);
        bench.click("Tanks and seats");
        picture(&mut bench.harness, &format!("airframe_{width}"));
        for view in ["from above", "from the side"] {
            let rect = bench.harness.get_by_label(view).rect();
            assert!(rect.width() > 200.0 && rect.height() > 120.0, "{view} has {rect:?} at {width}");
        }
        bench.show(Pane::Propulsion);
        for (aspect, chart) in [("Power by power", "powers of front"), ("Engine chart", "engine chart of front")] {
            bench.click(aspect);
            picture(&mut bench.harness, &format!("{}_{width}", aspect.replace(' ', "_")));
            assert!(bench.harness.query_by_label(chart).is_some(), "{chart}");
        }
    }
}

#[test]
fn typed_empty_mass_is_what_flies_and_undo_takes_it_back() {
    let mut bench = editor();
    let before = (loaded(&bench), bench.session().clone());
    bench.click("Mass");
    bench.enter("empty mass", "1400");
    assert_eq!(bench.session().aircraft_changes.get("mass.mass_kg"), Some(&ChangedValue::Number(1400.0)));
    let after = loaded(&bench);
    let added_kg = after.properties.mass_kg - before.0.properties.mass_kg;
    let empty_kg = bench.snapshot().aircraft.ready().expect("it is read").aircraft.empty.mass_kg;
    assert_eq!(empty_kg, 1400.0);
    assert!((added_kg - (1400.0 - 1382.1)).abs() < 1e-9, "{added_kg} kg");
    assert!(bench.snapshot().pooled.ready().is_some(), "the derivatives follow");
    // What cannot be is said in one line, with the range, beside the number; what was there last stays to look at.
    bench.enter("empty mass", "-5");
    let error = bench.snapshot().aircraft.error().expect("it is refused").to_owned();
    assert!(error.contains("mass.mass_kg is -5, allowed is 0.001 to 2000000 kg"), "{error}");
    assert!(bench.harness.query_by_label("must be 0.001 to 2000000 kg").is_some(), "said beside the number");
    picture(&mut bench.harness, "airframe_refused");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(*bench.session(), before.1);
    assert_eq!(loaded(&bench), before.0);
}

#[test]
fn dragged_seat_moves_the_centre_of_gravity_by_its_part_of_the_mass_in_one_step() {
    let mut bench = editor();
    let (before, session) = (loaded(&bench), bench.session().clone());
    let seat = bench.snapshot().aircraft.ready().expect("it is read").aircraft.seats[0].clone();
    let label = format!("seat {} from above", seat.name);
    let at = bench.harness.get_by_label(&label).rect().center();
    drag(&mut bench.harness, at, at + vec2(30.0, -20.0), 6);
    bench.settle();
    let key = format!("seat.{}.cg_datum_m", seat.name);
    let Some(ChangedValue::Triple(to)) = bench.session().aircraft_changes.get(&key).cloned() else {
        panic!("{:?}", bench.session().aircraft_changes)
    };
    let [x, y, z] = seat.cg_from_datum_m;
    assert!(to[0] > x + 0.1 && to[1] > y + 0.1, "aft and to the right: {to:?} from {:?}", seat.cg_from_datum_m);
    // Both axes have one scale.
    let (aft, right) = (to[0] - x, to[1] - y);
    assert!((aft / right - 1.5).abs() < 0.15, "{aft} m and {right} m");
    assert_eq!(to[2], z);
    let after = loaded(&bench);
    let mass_kg = before.properties.mass_kg;
    let carried_kg = match &bench.session().loading {
        Some(loading) => loading.seats_kg.get(&seat.name).copied().unwrap_or(0.0),
        None => bench.snapshot().aircraft.ready().expect("it is read").aircraft.standard_loading.seats_kg[&seat.name],
    };
    for (axis, moved) in [(0, to[0] - x), (1, to[1] - y)] {
        let cg = |state: &LoadedState| state.properties.cg_from_datum_m[axis];
        let expected = carried_kg * moved / mass_kg;
        assert!((cg(&after) - cg(&before) - expected).abs() < 1e-9, "{} for {expected} m", cg(&after) - cg(&before));
    }
    picture(&mut bench.harness, "airframe_dragged");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(*bench.session(), session, "the drag is one step");
}

#[test]
fn readings_of_the_scales_give_mass_and_centre_of_gravity() {
    let mut bench = editor();
    bench.click("Weighing");
    let aircraft = bench.snapshot().aircraft.ready().expect("it is read").clone();
    let wheels = aircraft.aircraft.wheels.expect("the file states them");
    // Balance of the moments of 1,400 kg at x = 3.5 m, z = 1.6 m, at two attitudes.
    for (at, pitch_deg) in [(1, -3.0_f64), (2, 4.0)] {
        let arm = 3.5 + 1.6 * pitch_deg.to_radians().tan();
        let main = 1400.0 * (arm - wheels.nose_x_m) / (wheels.main_x_m - wheels.nose_x_m);
        for (name, value) in [
            ("ground pitch", pitch_deg),
            ("aircraft pitch", pitch_deg),
            ("nose", 1400.0 - main),
            ("right", 0.5 * main),
            ("left", 0.5 * main),
        ] {
            bench.enter(&format!("weighing {at} {name}"), &format!("{value:.6}"));
        }
    }
    picture(&mut bench.harness, "weighing");
    assert!(bench.harness.query_by_label("1400.0 kg").is_some(), "the mass");
    assert!(bench.harness.query_by_label_contains("3.5000").is_some(), "its place along the aircraft");
}

#[test]
fn a_session_without_an_aircraft_takes_a_file_or_a_described_one_each_in_one_step_of_undo() {
    let mut bench = Bench::open_changed(|folder| {
        let path = folder.join("session.toml");
        let text = std::fs::read_to_string(&path).expect("it is written");
        let without = text.replace("aircraft = \"aircraft.toml\"\n", "");
        assert_ne!(text, without, "it had an aircraft");
        std::fs::write(&path, without).expect("it can be written");
    });
    assert!(bench.session().aircraft.is_none() && bench.snapshot().pooled.latest().is_none());
    bench.show(Pane::Correlation);
    let says_why = |bench: &Bench<'_>| bench.harness.query_all_by_label_contains("No aircraft is chosen").count();
    assert!(says_why(&bench) > 0);
    bench.show(Pane::Loading);
    bench.push("Choose an aircraft");
    picture(&mut bench.harness, "airframe_none");
    bench.push("Aircraft file…");
    bench.choose("aircraft.toml");
    bench.push("Open");
    assert_eq!(bench.session().aircraft.as_deref(), Some("aircraft.toml"));
    assert!(bench.cm().quality.r_squared > 0.99 && says_why(&bench) == 0);
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert!(bench.session().aircraft.is_none());
    bench.push("Describe aircraft…");
    bench.enter("name of the aircraft", "Glider 7");
    bench.enter("Mass", "600");
    picture(&mut bench.harness, "airframe_described");
    bench.push("Save the aircraft…");
    bench.push("Save");
    assert_eq!(bench.session().aircraft.as_deref(), Some("Glider_7.toml"));
    let mass_kg = loaded(&bench).properties.mass_kg;
    assert!((mass_kg - 600.0).abs() < 1e-9, "{mass_kg}");
}
