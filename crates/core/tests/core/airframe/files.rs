//! Aircraft files: what ships reads and passes; what is wrong is refused with its line or field.

use doublet_core::airframe::frames::body_from_datum;
use doublet_core::airframe::{InertiaModel, InertiaTensor, Loading, summary};
use doublet_core::load::aircraft::{self, AircraftFileError};

use proptest::prelude::*;

use super::support::{asset, close, shipped};

/// The least an aircraft file states.
const MINIMAL: &str = r#"format = "doublet aircraft"
version = 1
name = "minimal"
[reference]
area_m2 = 20.0
span_m = 12.0
chord_m = 1.8
[mass]
mass_kg = 1000.0
cg_datum_m = [2.0, 0.0, 1.0]
[inertia]
moments_kg_m2 = [1000.0, 1500.0, 2200.0]
products_kg_m2 = { xz = 50.0 }
"#;

#[test]
fn every_shipped_aircraft_reads_and_passes_its_check() {
    let mut read = Vec::new();
    for entry in std::fs::read_dir(asset("")).unwrap() {
        let path = entry.unwrap().path();
        let is_toml = path.extension().is_some_and(|extension| extension == "toml");
        if is_toml && std::fs::read_to_string(&path).unwrap().starts_with("format = \"doublet aircraft\"") {
            read.push(path.file_name().unwrap().to_string_lossy().into_owned());
            aircraft::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        }
    }
    for name in
        ["attas_vfw614.toml", "c337f.toml", "c337f_thesis.toml", "citation_550_simulated.toml", "citation_phlab.toml"]
    {
        assert!(read.iter().any(|found| found == name), "{name} is not among {read:?}");
    }
}

#[test]
fn minimal_aircraft_has_its_constant_mass_and_inertia() {
    let aircraft = aircraft::parse(MINIMAL).unwrap();
    let properties = Loading::default().mass_properties(&aircraft);
    assert_eq!((properties.mass_kg, properties.cg_from_datum_m), (1000.0, [2.0, 0.0, 1.0]));
    let expected = InertiaTensor { xz: 50.0, ..InertiaTensor::diagonal(1000.0, 1500.0, 2200.0) };
    assert_eq!(properties.inertia, expected);
    assert_eq!(Loading::default().issues(&aircraft, &properties), []);
    assert_eq!(aircraft.mean_chord(), None);
}

#[test]
fn stall_tells_the_greatest_lift_coefficient() {
    let with = |stall: &str| aircraft::parse(&MINIMAL.replace("[inertia]", &format!("[stall]\n{stall}\n[inertia]")));
    let stall = with("airspeed_m_s = 30.0\nmass_kg = 1100.0").unwrap().stall.unwrap();
    // 10787 N over 551.25 Pa and 20 m2.
    assert!((stall.max_lift_coefficient(20.0) - 0.978_44).abs() < 1e-5, "{}", stall.max_lift_coefficient(20.0));
    let refused = with("airspeed_m_s = 0.0\nmass_kg = 1100.0").unwrap_err().to_string();
    assert!(refused.contains("stall.airspeed_m_s") && refused.contains("1 to 150 m/s"), "{refused}");
    assert_eq!(aircraft::parse(MINIMAL).unwrap().stall, None);
}

#[test]
fn simulated_citation_has_the_constants_of_its_model() {
    let aircraft = shipped("citation_550_simulated.toml");
    let reference = &aircraft.reference;
    assert_eq!((reference.area_m2, reference.span_m, reference.chord_m), (24.99, 13.325, 1.991));
    assert_eq!((reference.lateral_moment_length_m, reference.lateral_rate_length_m), (13.325, 13.325 / 2.0));
    assert_eq!(reference.pitch_rate_length_m, 1.991);
    let properties = Loading::default().mass_properties(&aircraft);
    let expected = InertiaTensor { xz: 1908.0, ..InertiaTensor::diagonal(15351.0, 22965.0, 36220.0) };
    assert_eq!((properties.mass_kg, properties.inertia), (5000.0, expected));
}

#[test]
fn attas_has_its_published_constants_in_body_axes() {
    let aircraft = shipped("attas_vfw614.toml");
    let cg = Loading::default().mass_properties(&aircraft).cg_from_datum_m;
    let body = |point: Option<[f64; 3]>| body_from_datum(point.unwrap(), cg);
    assert_eq!(body(aircraft.sensors.accelerometer_from_datum_m), [-1.010, 0.886, 0.103]);
    assert_eq!(body(aircraft.sensors.alpha_vane_from_datum_m), [13.080, -0.010, -0.027]);
    assert_eq!(body(aircraft.sensors.beta_vane_from_datum_m), [13.080, -0.010, -0.027]);
    assert_eq!(body(aircraft.moment_reference_from_datum_m), [-0.02, -0.01, -0.12]);
    let engines: Vec<_> = aircraft.engines.iter().map(|engine| body(Some(engine.position_from_datum_m))).collect();
    assert_eq!(engines, [[-1.343, -2.990, -0.652], [-1.343, 2.990, -0.652]]);
    let reference = &aircraft.reference;
    assert_eq!((reference.lateral_moment_length_m, reference.lateral_rate_length_m), (10.75, 10.75));
    assert_eq!((reference.chord_m, reference.pitch_rate_length_m), (3.159, 3.159));
    assert!(matches!(aircraft.inertia, InertiaModel::Constant(tensor) if tensor.xz == 11442.0));
}

#[test]
fn phlab_inertia_matches_its_published_radii() {
    let aircraft = shipped("citation_phlab.toml");
    let InertiaModel::Constant(tensor) = aircraft.inertia else { panic!("constants expected") };
    let (m, b, c) = (aircraft.empty.mass_kg, aircraft.reference.span_m, aircraft.reference.chord_m);
    // Half a unit of the last printed digit of each constant.
    close("KX2", tensor.xx / (m * b * b), 0.019, 5e-4);
    close("KZ2", tensor.zz / (m * b * b), 0.042, 5e-4);
    close("KXZ", tensor.xz / (m * b * b), 0.002, 5e-4);
    close("KY2", tensor.yy / (m * c * c), 1.25 * 1.114, 5e-3);
}

#[test]
fn unknown_key_is_refused_with_its_line() {
    let text = MINIMAL.replace("chord_m = 1.8", "chord_m = 1.8\nwing_sweep_deg = 3.0");
    let error = aircraft::parse(&text).unwrap_err();
    assert!(
        matches!(&error, AircraftFileError::Syntax { line: 8, message } if message.contains("wing_sweep_deg")),
        "{error}"
    );
}

#[test]
fn missing_and_misspelt_values_are_refused_with_their_name() {
    let missing = aircraft::parse(&MINIMAL.replace("span_m = 12.0\n", "")).unwrap_err();
    assert!(missing.to_string().contains("span_m"), "{missing}");
    let word = aircraft::parse(&MINIMAL.replace("12.0", "\"wide\"")).unwrap_err();
    assert!(matches!(word, AircraftFileError::Syntax { line: 6, .. }), "{word}");
    let no_inertia = MINIMAL.replace("moments_kg_m2 = [1000.0, 1500.0, 2200.0]\n", "");
    assert!(aircraft::parse(&no_inertia).unwrap_err().to_string().contains("inertia is missing"));
    let shape = format!(
        "{MINIMAL}[[seat]]\nname = \"pilot\"\ncg_datum_m = [1.0, 0.0, 1.0]\ninertia = {{ given = {{ moments_kg_m2 = [1.0, 1.0, 1.0] }} }}\n"
    );
    assert!(aircraft::parse(&shape).unwrap_err().to_string().contains("seat.pilot.inertia.given.at_mass_kg"));
}

#[test]
fn other_formats_and_newer_versions_are_refused_in_words() {
    let other = aircraft::parse("format = \"doublet session\"\nversion = 1\n").unwrap_err();
    assert_eq!(other.to_string(), "not an aircraft file: format is 'doublet session', expected 'doublet aircraft'");
    assert!(matches!(aircraft::parse("").unwrap_err(), AircraftFileError::Format { .. }));
    let newer = aircraft::parse(&MINIMAL.replace("version = 1", "version = 2")).unwrap_err();
    assert!(matches!(newer, AircraftFileError::Version { found: 2 }));
}

#[test]
fn impossible_values_are_refused_with_field_value_and_range() {
    let text = MINIMAL.replace("12.0", "-12.0").replace("1000.0\n", "-1.0\n");
    let error = aircraft::parse(&text).unwrap_err().to_string();
    assert!(error.contains("reference.span_m is -12, allowed is 0.001 to 1000 m"), "{error}");
    assert!(error.contains("mass.mass_kg is -1, allowed is 0.001 to 2000000 kg"), "{error}");
    let inertia = aircraft::parse(&MINIMAL.replace("2200.0", "2700.0")).unwrap_err().to_string();
    assert!(inertia.starts_with("inertia is impossible: largest principal moment"), "{inertia}");
}

#[test]
fn engines_stand_in_their_own_section_beside_propulsion_and_datcom() {
    let engine = "[[engine]]\nname = \"front\"\nposition_datum_m = [0.5, 0.0, 1.2]\nincidence_deg = 2.0\n";
    let propulsion = "[[propulsion.engine]]\nname = \"front\"\nchart = \"a.toml\"\n[datcom]\ntitle = \"a\"\n";
    let aircraft = aircraft::parse(&format!("{MINIMAL}{engine}{propulsion}")).unwrap();
    assert_eq!(aircraft.engines[0].position_from_datum_m, [0.5, 0.0, 1.2]);
    close("incidence", aircraft.engines[0].incidence_rad, 2.0_f64.to_radians(), 1e-15);
}

#[test]
fn summary_states_mass_centre_of_gravity_margin_inertia_and_axes() {
    let summary = summary(&shipped("c337f.toml"));
    let take_off = &summary.states[1];
    close("mass", take_off.properties.mass_kg, 2100.0, 1e-9);
    close("% MAC", 100.0 * take_off.mean_chord_fraction.unwrap(), 22.2, 0.05);
    assert!(take_off.envelope.unwrap().inside());
    let principal = take_off.principal.unwrap();
    let inertia = take_off.properties.inertia;
    // Turning the tensor by half atan2(2 Ixz, Izz - Ixx) removes its product.
    let angle = 0.5 * (2.0 * inertia.xz).atan2(inertia.zz - inertia.xx);
    close("principal pitch", principal.pitch_rad.abs(), angle.abs(), 1e-12);
    let text = summary.to_string();
    for part in
        ["2100.0 kg", "% MAC", "inside:", "Ixz", "principal axes", "class I", "component groups weigh 1373.5 kg"]
    {
        assert!(text.contains(part), "'{part}' is missing in\n{text}");
    }
}

proptest! {
    /// A line struck out, doubled or spoilt: the reader answers with an aircraft that passes its check or with one message.
    #[test]
    fn damaged_files_are_read_or_refused_in_words(
        line in any::<prop::sample::Index>(), kind in 0..3, number in prop::num::f64::ANY, junk in "[ -~]{0,20}",
    ) {
        let text = std::fs::read_to_string(asset("c337f.toml")).unwrap();
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let index = line.index(lines.len());
        match kind {
            0 => drop(lines.remove(index)),
            1 => lines.insert(index, junk),
            _ => {
                let key = lines[index].split('=').next().unwrap_or_default().to_owned();
                lines[index] = format!("{key}= {number:?}").replace("NaN", "nan");
            }
        }
        match aircraft::parse(&lines.join("\n")) {
            Ok(aircraft) => prop_assert_eq!(aircraft.check(), Ok(())),
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }
}
