//! An aircraft that is edited: changes of its file, its numbers, its own file, its drawing.

use std::collections::BTreeMap;

use doublet_core::load::aircraft::parse;
use doublet_engine::aircraft::{
    AircraftChanges, ChangedValue, Motion, ShapeOutline, ShapePart, fields, ned_from_body, save, shape,
};
use doublet_engine::begin::empty_session;
use doublet_engine::builtin;
use doublet_engine::graph::Context;
use doublet_engine::session::{AircraftEdit, Edit};
use doublet_engine::stage::{aircraft_of, load_aircraft};

/// The text of the aircraft that comes with the program.
fn text() -> &'static str {
    builtin::text("aircraft", "c337f").unwrap()
}

fn changed(changes: &[(&str, ChangedValue)]) -> AircraftChanges {
    let mut all = AircraftChanges::default();
    changes.iter().for_each(|(key, value)| all.set(key, value.clone()));
    all
}

#[test]
fn changed_numbers_are_what_the_aircraft_has_and_everything_else_stays_with_its_comments() {
    let changes = changed(&[
        ("mass.mass_kg", ChangedValue::Number(1400.5)),
        ("tank.main right.cg_datum_m", ChangedValue::Triple([3.9, 2.5, 2.0])),
        ("inertia.group.wing.mass_kg", ChangedValue::Number(210.0)),
        ("inertia.products_kg_m2.xz", ChangedValue::Number(-60.0)),
        ("inertia.group.wing.inertia.given.moments_kg_m2", ChangedValue::Triple([2000.0, 50.0, 2045.0])),
        ("sensors.antenna_datum_m", ChangedValue::Triple([4.0, 0.0, 2.2])),
    ]);
    let after = changes.apply(text()).unwrap();
    let (before, aircraft) = (parse(text()).unwrap(), parse(&after).unwrap());
    assert_eq!(aircraft.empty.mass_kg, 1400.5);
    assert_eq!(aircraft.tanks[0].cg_from_datum_m, [3.9, 2.5, 2.0]);
    assert_eq!(aircraft.tanks[1], before.tanks[1]);
    assert_eq!(aircraft.sensors.antenna_from_datum_m, Some([4.0, 0.0, 2.2]));
    assert_ne!(aircraft.inertia, before.inertia);
    assert_eq!(aircraft.envelope, before.envelope);
    assert!(after.contains("mass_kg = 1400.5\n") && after.contains("# thesis Tables F.1 and 5.7"), "{after}");
    let (lines, added) = (text().lines().count(), after.lines().count());
    assert!(added <= lines + 1, "{lines} and {added} lines");
}

#[test]
fn part_left_out_takes_its_mass_from_the_standard_loading_and_a_new_one_is_made() {
    let changes = changed(&[
        ("seat.copilot", ChangedValue::Removed),
        ("seat.jump seat.cg_datum_m", ChangedValue::Triple([3.0, 0.0, 1.1])),
        ("envelope", ChangedValue::Rows(vec![[1400.0, 3.42, 3.63], [2100.0, 3.55, 3.63]])),
    ]);
    let aircraft = parse(&changes.apply(text()).unwrap()).unwrap();
    let names: Vec<_> = aircraft.seats.iter().map(|seat| seat.name.as_str()).collect();
    assert_eq!(names, ["captain", "passenger left", "passenger right", "jump seat"]);
    assert!(!aircraft.standard_loading.seats_kg.contains_key("copilot"));
    assert_eq!(aircraft.envelope.unwrap().rows.len(), 2);
}

#[test]
fn part_that_is_set_again_is_not_left_out_and_one_left_out_keeps_nothing() {
    let mut changes = changed(&[("seat.captain.capacity_kg", ChangedValue::Number(120.0))]);
    changes.set("seat.captain", ChangedValue::Removed);
    assert_eq!(changes.iter().count(), 1);
    changes.set("seat.captain.capacity_kg", ChangedValue::Number(110.0));
    assert_eq!(changes.get("seat.captain"), None);
    changes.restore("seat.captain");
    assert!(changes.is_empty());
}

#[test]
fn saved_form_is_read_back_and_another_word_is_refused() {
    let changes = changed(&[
        ("mass.mass_kg", ChangedValue::Number(1400.5)),
        ("mass.cg_datum_m", ChangedValue::Triple([3.5, 0.0, 1.7])),
        ("seat.copilot", ChangedValue::Removed),
        ("envelope", ChangedValue::Rows(vec![[1400.0, 3.42, 3.63]])),
    ]);
    let text = toml::to_string(&changes.to_table()).unwrap();
    let read = |text: &str| AircraftChanges::try_from(&toml::from_str::<BTreeMap<_, _>>(text).unwrap());
    assert_eq!(read(&text).unwrap(), changes, "{text}");
    let refused = read("\"mass.mass_kg\" = \"heavy\"").unwrap_err();
    assert!(refused.contains("mass.mass_kg") && refused.contains("removed"), "{refused}");
}

#[test]
fn every_field_set_to_what_it_is_changes_no_aircraft() {
    for name in builtin::aircraft() {
        let text = builtin::text("aircraft", name).unwrap();
        let aircraft = parse(text).unwrap();
        let mut changes = AircraftChanges::default();
        let fields = fields(&aircraft, &changes);
        assert!(fields.len() > 10, "{name}");
        for field in &fields {
            field.value.iter().for_each(|value| changes.set(&field.key, value.clone()));
        }
        let mut again = parse(&changes.apply(text).unwrap()).unwrap_or_else(|error| panic!("{name}: {error}"));
        // The angles of the file are degrees.
        for (now, before) in again.engines.iter_mut().zip(&aircraft.engines) {
            assert!((now.incidence_rad - before.incidence_rad).abs() < 1e-15);
            now.incidence_rad = before.incidence_rad;
        }
        assert_eq!(again, aircraft, "{name}");
    }
}

#[test]
fn every_field_leads_to_a_number_of_its_own() {
    let text = builtin::text("aircraft", "c337f").unwrap();
    let aircraft = parse(text).unwrap();
    for field in fields(&aircraft, &AircraftChanges::default()) {
        let value = match field.value.unwrap_or(field.proposal) {
            ChangedValue::Number(value) => ChangedValue::Number(1.001 * value + 0.001),
            ChangedValue::Triple([x, y, z]) => ChangedValue::Triple([x + 0.01, y + 0.01, z + 0.01]),
            ChangedValue::Rows(rows) => {
                ChangedValue::Rows(rows.iter().map(|[m, f, a]| [m + 0.001, f - 0.01, a + 0.01]).collect())
            }
            ChangedValue::Removed => continue,
        };
        let mut changes = AircraftChanges::default();
        changes.set(&field.key, value);
        let changed = parse(&changes.apply(text).unwrap()).unwrap_or_else(|error| panic!("{}: {error}", field.key));
        assert_ne!(changed, aircraft, "{}", field.key);
    }
}

#[test]
fn value_that_cannot_be_is_shown_as_it_was_typed() {
    let aircraft = parse(builtin::text("aircraft", "c337f").unwrap()).unwrap();
    let mut changes = AircraftChanges::default();
    changes.set("mass.mass_kg", ChangedValue::Number(-5.0));
    let fields = fields(&aircraft, &changes);
    let mass = fields.iter().find(|field| field.key == "mass.mass_kg").unwrap();
    assert_eq!((mass.value.clone(), mass.changed), (Some(ChangedValue::Number(-5.0)), true));
    assert_eq!(fields.iter().filter(|field| field.changed).count(), 1);
}

#[test]
fn saved_aircraft_is_the_edited_one_with_its_engines() {
    let folder = tempfile::tempdir().unwrap();
    let mut session = empty_session("edited", Some("builtin:c337f"));
    session.aircraft_changes.set("mass.mass_kg", ChangedValue::Number(1400.0));
    let path = folder.path().join("mine.toml");
    save(&session, folder.path(), &path).unwrap();
    let context = Context::new(folder.path());
    let edited = aircraft_of(&context, &session).unwrap();
    let saved = load_aircraft(&context, "mine.toml").unwrap();
    assert_eq!(saved.aircraft.empty.mass_kg, 1400.0);
    assert_eq!(saved.aircraft.inertia, edited.aircraft.inertia);
    assert!(edited.aircraft.notes.last().unwrap().contains("mass.mass_kg = 1400"), "{:?}", edited.aircraft.notes);
    assert_eq!(format!("{:?}", saved.powerplant), format!("{:?}", edited.powerplant));
    session.aircraft_changes.set("mass.mass_kg", ChangedValue::Number(-1.0));
    let refused = save(&session, folder.path(), &path).unwrap_err();
    assert!(refused.contains("mass.mass_kg") && !refused.contains('\n'), "{refused}");
    assert_eq!(load_aircraft(&context, "mine.toml").unwrap().aircraft.empty.mass_kg, 1400.0, "it stays as it was");
}

#[test]
fn velocity_through_the_air_lies_below_the_nose_by_the_angle_of_attack() {
    let motion = Motion {
        attitude_rad: Some([0.0, 0.1, 0.0]),
        airspeed_m_s: Some(50.0),
        alpha_rad: Some(0.1),
        beta_rad: Some(0.0),
        velocity_ned_m_s: None,
    };
    let [north, east, down] = motion.air_velocity_ned_m_s().unwrap();
    assert!((north - 50.0).abs() < 1e-12 && east.abs() < 1e-12 && down.abs() < 1e-12, "level flight");
    assert_eq!(Motion { beta_rad: None, ..motion }.air_velocity_ned_m_s(), None);
}

/// The lowest trailing corner of the controls on one side of the wing, z down.
fn trailing(outlines: &[ShapeOutline], span: f64, side: f64) -> f64 {
    let corners =
        outlines.iter().filter(|outline| outline.part == ShapePart::Control).flat_map(|outline| &outline.corners);
    corners.filter(|corner| side * corner[1] > 0.25 * span).map(|corner| corner[2]).fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn drawing_has_the_span_and_the_length_of_the_aircraft_whatever_aircraft_it_is() {
    for name in builtin::aircraft() {
        let aircraft = parse(builtin::text("aircraft", name).unwrap()).unwrap();
        let outlines = shape(&aircraft, aircraft.empty.cg_from_datum_m, [0.0; 3]);
        let ends = |axis: usize| {
            let all = || outlines.iter().flat_map(|outline| &outline.corners).map(|corner| corner[axis]);
            all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
        };
        let span = aircraft.reference.span_m;
        assert!((ends(1) / span - 1.0).abs() < 0.05, "{name}: {} of {span}", ends(1));
        let length = aircraft.gyration_radii.map_or(0.78 * span, |radii| radii.length_m);
        assert!((ends(0) / length - 1.0).abs() < 0.05, "{name}: {} of {length}", ends(0));
    }
}

#[test]
fn deflections_move_the_trailing_edges_as_the_conventions_say() {
    let aircraft = parse(builtin::text("aircraft", "c337f").unwrap()).unwrap();
    let span = aircraft.reference.span_m;
    let drawn = |deflections| shape(&aircraft, aircraft.empty.cg_from_datum_m, deflections);
    let level = trailing(&drawn([0.0; 3]), span, 1.0);
    // Positive aileron: right one down, left one up.
    let rolled = drawn([0.2, 0.0, 0.0]);
    assert!(trailing(&rolled, span, 1.0) > level + 0.05);
    assert!((trailing(&rolled, span, -1.0) - level).abs() < 1e-9, "the hinge is what is lowest there");
    // Positive rudder: trailing edge left.
    let left = |outlines: &[ShapeOutline]| {
        let fin = outlines.iter().rfind(|outline| outline.part == ShapePart::Control).unwrap();
        fin.corners.iter().map(|corner| corner[1]).fold(f64::INFINITY, f64::min)
    };
    assert!(left(&drawn([0.0, 0.0, 0.2])) < -0.03);
    assert_eq!(left(&drawn([0.0; 3])), 0.0);
}

#[test]
fn attitude_turns_the_nose_and_the_wings() {
    let close = |a: [f64; 3], b: [f64; 3]| assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-12), "{a:?} {b:?}");
    let right = std::f64::consts::FRAC_PI_2;
    // Heading east: the nose points east. Nose up: it points up. Banked right: the right wing points down.
    close(ned_from_body([0.0, 0.0, right])([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
    close(ned_from_body([0.0, right, 0.0])([1.0, 0.0, 0.0]), [0.0, 0.0, -1.0]);
    close(ned_from_body([right, 0.0, 0.0])([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
}

#[test]
fn edits_change_the_session_and_refuse_what_is_no_number() {
    let session = empty_session("edited", Some("builtin:c337f"));
    let set = |value| Edit::Aircraft(AircraftEdit::set("mass", "mass.mass_kg", ChangedValue::Number(value)));
    let heavier = set(1400.0).apply(&session).unwrap();
    assert_eq!(heavier.aircraft_changes.get("mass.mass_kg"), Some(&ChangedValue::Number(1400.0)));
    assert!(set(f64::NAN).apply(&session).unwrap_err().to_string().contains("mass.mass_kg"));
    let back = Edit::Aircraft(AircraftEdit::Restore("mass.mass_kg".to_owned())).apply(&heavier).unwrap();
    assert_eq!(back, session);
    let other = Edit::Aircraft(AircraftEdit::Use("builtin:navion".to_owned())).apply(&heavier).unwrap();
    assert!(other.aircraft_changes.is_empty());
    // The saved form holds the changes.
    let text = doublet_engine::session::print(&heavier).unwrap();
    assert_eq!(doublet_engine::session::parse(&text).unwrap().aircraft_changes, heavier.aircraft_changes, "{text}");
}
