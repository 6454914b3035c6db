//! Exported models: DAVE-ML read back, JSBSim flown by JSBSim.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use doublet_core::airframe::{InertiaTensor, MassProperties, ReferenceGeometry};
use doublet_core::model::{Axes, Coefficient, Derivatives, Gyroscopic, Term, ThrustTreatment, Variable};
use doublet_engine::export::{DaveMl, ExportError, Format, IdentifiedCoefficient, IdentifiedModel, Parameter, write};
use doublet_engine::keep::PutError;
use doublet_engine::run::Snapshot;
use doublet_engine::session::{self, ControlLags, Session};
use nalgebra::{DMatrix, Vector3};
use rand::{RngExt, SeedableRng};

use crate::compute;

/// Difference allowed between a check case and the formulas of the file: rounding of ten terms of order one.
const READ_BACK: f64 = 1e-12;
/// Difference allowed between JSBSim and the model, in coefficients of order one: JSBSim turns velocities through its Earth-centred
/// frames and back, which costs some 1e-11.
const FLOWN: f64 = 1e-9;
/// Points JSBSim is asked for.
const POINTS: usize = 1000;

fn coefficient(coefficient: Coefficient, terms: &[(&str, f64)]) -> IdentifiedCoefficient {
    let parameters = terms.iter().map(|&(term, value)| {
        let term = Term::parse(term).unwrap();
        Parameter { name: term.derivative_name(coefficient), term, value, standard_error: 0.05 * value.abs() }
    });
    let count = terms.len();
    IdentifiedCoefficient {
        coefficient,
        parameters: parameters.collect(),
        correlation: DMatrix::from_fn(count, count, |i, j| if i == j { 1.0 } else { 0.1 / (1 + i + j) as f64 }),
        windows: vec!["01 <3-2-1-1> & more".into()],
        shares: DMatrix::identity(terms.len(), terms.len()),
        mean_constant: false,
    }
}

/// A model of everything a structure can hold that JSBSim has a property for.
fn model(coefficients: Vec<IdentifiedCoefficient>) -> IdentifiedModel {
    let ranges = [
        (Variable::Alpha, (-0.05, 0.2)),
        (Variable::AlphaDot, (-0.01, 0.02)),
        (Variable::Beta, (-0.15, 0.12)),
        (Variable::BetaDot, (-0.02, 0.02)),
        (Variable::RollRate, (-0.05, 0.06)),
        (Variable::PitchRate, (-0.01, 0.02)),
        (Variable::YawRate, (-0.03, 0.03)),
        (Variable::Aileron, (-0.2, 0.2)),
        (Variable::Elevator, (-0.3, 0.2)),
        (Variable::Rudder, (-0.2, 0.25)),
        (Variable::PropellerPressure, (0.05, 0.4)),
        (Variable::ThrustCoefficient, (0.02, 0.2)),
        (Variable::Airspeed, (40.0, 70.0)),
        (Variable::Altitude, (900.0, 2100.0)),
        (Variable::Mach, (0.11, 0.21)),
    ];
    IdentifiedModel {
        name: "test_aircraft".into(),
        aircraft: "Test aircraft".into(),
        title: "Everything a term can hold".into(),
        reference: ReferenceGeometry::conventional(18.6, 11.63, 1.55),
        moment_reference_datum_m: [3.1, 0.02, 1.4],
        about_centre_of_gravity: false,
        datum: "the nose".into(),
        mass: MassProperties {
            mass_kg: 1850.0,
            cg_from_datum_m: [3.33, -0.01, 1.25],
            inertia: InertiaTensor { xx: 5400.0, yy: 5300.0, zz: 9600.0, xz: 296.16, xy: 240.0, yz: -170.0 },
        },
        thrust: ThrustTreatment::Removed,
        gyroscopic: Gyroscopic::Signed,
        control_lags: ControlLags::default(),
        coefficients,
        ranges: BTreeMap::from(ranges),
    }
}

fn body_axes() -> IdentifiedModel {
    let lateral = [("1", 0.01), ("beta", -0.6), ("pb/2V", -0.1), ("rb/2V", 0.3), ("delta_a", 0.02), ("delta_r", 0.15)];
    model(vec![
        coefficient(
            Coefficient::CX,
            &[("1", -0.06), ("alpha", 0.22), ("alpha^2", 2.6), ("V*mach^-1", 1e-5), ("h", 1e-6)],
        ),
        coefficient(Coefficient::CY, &[&lateral[..], &[("beta_dot", 0.2), ("beta^3", -1.3)]].concat()),
        coefficient(
            Coefficient::CZ,
            &[("1", -0.3), ("alpha", -4.9), ("qc/V", -9.0), ("alpha_dot", -2.0), ("delta_e", -0.5)],
        ),
        coefficient(Coefficient::Cl, &[&lateral[..], &[("alpha*beta", -0.4)]].concat()),
        coefficient(
            Coefficient::Cm,
            &[("1", 0.03), ("alpha", -0.9), ("qc/V", -21.0), ("alpha_dot", -5.0), ("delta_e", -1.6)],
        ),
        coefficient(Coefficient::Cn, &lateral),
    ])
}

fn lift_and_drag() -> IdentifiedModel {
    let mut model = body_axes();
    model.name = "lift_and_drag".into();
    model.reference.pitch_rate_length_m = model.reference.chord_m / 2.0;
    model.reference.lateral_rate_length_m = model.reference.span_m / 1.25;
    model.coefficients.retain(|c| !matches!(c.coefficient, Coefficient::CX | Coefficient::CZ));
    model.coefficients.push(coefficient(Coefficient::CD, &[("1", 0.03), ("alpha^2", 1.9)]));
    model
        .coefficients
        .push(coefficient(Coefficient::CL, &[("1", 0.3), ("alpha", 5.0), ("qc/V", 8.0), ("delta_e", 0.5)]));
    model
}

/// Reads a DAVE-ML file and compares every check case, returning how many outputs there were.
fn check_daveml(path: &Path) -> usize {
    let text = std::fs::read_to_string(path).unwrap();
    let results = DaveMl::parse(&text).unwrap().check().unwrap();
    for result in &results {
        let error = (result.found - result.expected).abs();
        assert!(error < READ_BACK, "{}: {} differs by {error}", result.case, result.signal);
    }
    results.len()
}

#[test]
fn daveml_check_cases_come_back_from_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut with_power = body_axes();
    with_power.coefficients[0].parameters.push(Parameter {
        name: "CX_dpt_Tc2".into(),
        term: Term::parse("dpt/q*Tc^2").unwrap(),
        value: 0.3,
        standard_error: f64::NAN,
    });
    with_power.coefficients[0].correlation = DMatrix::identity(6, 6);
    for model in [with_power, lift_and_drag()] {
        write(&model, &[Format::DaveMl], folder.path()).unwrap();
        let outputs = check_daveml(&folder.path().join(format!("{}.dml", model.name)));
        assert_eq!(outputs, model.coefficients.len() * 41);
    }
}

#[test]
fn daveml_states_errors_correlations_and_reference() {
    let folder = tempfile::tempdir().unwrap();
    write(&body_axes(), &[Format::DaveMl], folder.path()).unwrap();
    let text = std::fs::read_to_string(folder.path().join("test_aircraft.dml")).unwrap();
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(&text, options).unwrap();
    let definitions = || document.descendants().filter(|node| node.tag_name().name() == "variableDef");
    let definition = |id: &str| definitions().find(|node| node.attribute("varID") == Some(id)).unwrap();
    let cx_alpha2 = definition("CX_alpha2");
    assert_eq!(cx_alpha2.attribute("initialValue"), Some("2.6"));
    let find = |node: roxmltree::Node<'_, '_>, name: &str| -> Vec<(String, String)> {
        let found = node.descendants().filter(|child| child.tag_name().name() == name);
        let attribute = |child: &roxmltree::Node<'_, '_>, name| child.attribute(name).unwrap_or_default().to_owned();
        found.map(|child| (attribute(&child, "varID"), attribute(&child, "corrCoef"))).collect()
    };
    let bounds = cx_alpha2.descendants().find(|node| node.tag_name().name() == "bounds").unwrap().text().unwrap();
    assert!((bounds.parse::<f64>().unwrap() - 0.05 * 2.6).abs() < 1e-15);
    // Third of five parameters: correlated with the two before it, and named to the two after it.
    assert_eq!(find(cx_alpha2, "correlation").len(), 2);
    assert_eq!(find(cx_alpha2, "correlation")[1], ("CX_alpha".into(), (0.1 / 4.0).to_string()));
    assert_eq!(find(cx_alpha2, "correlatesWith").len(), 2);
    assert_eq!(definition("x_ref").attribute("initialValue"), Some("3.1"));
    assert!(text.contains("q c/V") && text.contains("p b/(2 V)") && text.contains("identified from -0.05"));
}

#[test]
fn a_changed_file_fails_its_check_cases() {
    let folder = tempfile::tempdir().unwrap();
    write(&body_axes(), &[Format::DaveMl], folder.path()).unwrap();
    let text = std::fs::read_to_string(folder.path().join("test_aircraft.dml")).unwrap();
    let changed = text.replace("initialValue=\"-4.9\"", "initialValue=\"-4.900000001\"");
    assert_ne!(changed, text);
    let results = DaveMl::parse(&changed).unwrap().check().unwrap();
    let failed: Vec<_> = results.iter().filter(|result| !result.passed()).collect();
    assert!(!failed.is_empty() && failed.iter().all(|result| result.signal == "CZ"));
}

#[test]
fn reader_refuses_what_it_cannot_evaluate() {
    let head = r#"<DAVEfunc xmlns="http://daveml.org/2010/DAVEML">"#;
    let variable =
        |inside: &str| format!(r#"{head}<variableDef name="a" varID="a" units="nd">{inside}</variableDef></DAVEfunc>"#);
    let math = |inside: &str| variable(&format!("<calculation><math>{inside}</math></calculation>"));
    for (text, part) in [
        ("no file".to_owned(), "XML"),
        (format!("{head}<griddedTableDef/></DAVEfunc>"), "griddedTableDef"),
        (math("<apply><exp/><cn>1</cn></apply>"), "exp"),
        (math("<apply><divide/><cn>1</cn></apply>"), "operands"),
        (math("<cn>one</cn>"), "'one'"),
        (math(""), "MathML"),
        (math(&format!("{}<cn>1</cn>{}", "<apply><plus/>".repeat(150), "</apply>".repeat(150))), "apply"),
    ] {
        let message = DaveMl::parse(&text).unwrap_err().to_string();
        assert!(message.contains(part) && !message.contains('\n'), "{message}");
    }
    let circular = DaveMl::parse(&math("<ci>a</ci>")).unwrap();
    assert!(circular.evaluate("a", &[]).unwrap_err().to_string().contains("'a'"));
    assert!(DaveMl::parse(&variable("")).unwrap().evaluate("a", &[]).is_err());
}

#[test]
fn jsbsim_refuses_terms_it_has_no_property_for() {
    let folder = tempfile::tempdir().unwrap();
    for (term, name) in [("dpt/q", "dpt/q"), ("alpha*Tc", "alpha*Tc")] {
        let mut model = body_axes();
        model.coefficients[0] = coefficient(Coefficient::CX, &[("1", -0.06), (term, 0.2)]);
        let error = write(&model, &[Format::DaveMl, Format::JsbSim], folder.path()).unwrap_err();
        let message = error.to_string();
        assert!(
            matches!(error, ExportError::Term { .. }) && message.contains(name) && message.contains("CX"),
            "{message}"
        );
    }
    let mut halves = body_axes();
    halves.coefficients[2] = coefficient(Coefficient::CL, &[("1", 0.3)]);
    assert!(write(&halves, &[Format::JsbSim], folder.path()).unwrap_err().to_string().contains("CX and CZ"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written when a term is refused");
}

#[test]
fn a_foreign_file_is_never_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test_aircraft.dml");
    std::fs::write(&path, "mine").unwrap();
    assert!(matches!(
        write(&body_axes(), &[Format::DaveMl], folder.path()),
        Err(ExportError::Put(PutError::Foreign(_)))
    ));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    std::fs::remove_file(&path).unwrap();
    write(&body_axes(), &[Format::DaveMl], folder.path()).unwrap();
    write(&body_axes(), &[Format::DaveMl], folder.path()).unwrap();
}

/// Python with JSBSim, where there is one.
fn jsbsim() -> bool {
    let found = Command::new("python3").args(["-c", "import jsbsim"]).output().is_ok_and(|run| run.status.success());
    if !found {
        println!("skipped: python3 with the package jsbsim is not installed (pip install jsbsim)");
    }
    found
}

const FT: f64 = 0.3048;
/// Moment of inertia of a slug square foot, kg m².
const SLUG_FT2: f64 = 1.355_817_948_331_400_4;
/// Rate of the Earth, which JSBSim turns with, rad/s.
const EARTH_RATE: f64 = 7.292e-5;
/// Properties read back at every point.
const READ: [&str; 27] = [
    "aero/alpha-rad", "aero/beta-rad", "velocities/vt-fps", "aero/qbar-psf", "velocities/p-aero-rad_sec",
    "velocities/q-aero-rad_sec", "velocities/r-aero-rad_sec", "aero/alphadot-rad_sec", "aero/betadot-rad_sec",
    "position/h-sl-ft", "velocities/mach", "forces/fbx-aero-lbs", "forces/fby-aero-lbs", "forces/fbz-aero-lbs",
    "moments/l-aero-lbsft", "moments/m-aero-lbsft", "moments/n-aero-lbsft", "inertia/ixx-slugs_ft2",
    "inertia/iyy-slugs_ft2", "inertia/izz-slugs_ft2", "inertia/weight-lbs", "velocities/p-rad_sec",
    "velocities/q-rad_sec", "velocities/r-rad_sec", "accelerations/pdot-rad_sec2", "accelerations/qdot-rad_sec2",
    "accelerations/rdot-rad_sec2",
];

/// Flies `model` in JSBSim through random points inside its ranges and compares forces and moments about the centre of gravity
/// with those of its derivatives; returns the largest difference in coefficients.
fn fly(model: &IdentifiedModel) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    write(model, &[Format::JsbSim], folder.path()).unwrap();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(337);
    let mut wanted = Vec::new();
    let points: Vec<_> = (0..POINTS)
        .map(|_| {
            let mut pick = |variable: Variable| {
                let (low, high) = model.ranges[&variable];
                low + (high - low) * rng.random::<f64>()
            };
            let (alpha, beta, speed) = (pick(Variable::Alpha), pick(Variable::Beta), pick(Variable::Airspeed));
            let flow = [alpha.cos() * beta.cos(), beta.sin(), alpha.sin() * beta.cos()].map(|part| part * speed / FT);
            let rates =
                [pick(Variable::RollRate) * 10.0, pick(Variable::PitchRate) * 30.0, pick(Variable::YawRate) * 10.0];
            let controls = [pick(Variable::Aileron), pick(Variable::Elevator), pick(Variable::Rudder)];
            wanted.push((alpha, beta, speed, controls));
            serde_json::json!({
                "initial": {
                    "ic/h-sl-ft": pick(Variable::Altitude) / FT, "ic/phi-rad": 0.1, "ic/theta-rad": 0.05,
                    "ic/u-fps": flow[0], "ic/v-fps": flow[1], "ic/w-fps": flow[2],
                    "ic/p-rad_sec": rates[0], "ic/q-rad_sec": rates[1], "ic/r-rad_sec": rates[2],
                },
                "controls": {
                    "fcs/right-aileron-pos-rad": controls[0], "fcs/left-aileron-pos-rad": -controls[0],
                    "fcs/elevator-pos-rad": controls[1], "fcs/rudder-pos-rad": controls[2],
                },
            })
        })
        .collect();
    let task = serde_json::json!({ "points": points, "read": READ });
    let (input, output) = (folder.path().join("points.json"), folder.path().join("results.json"));
    std::fs::write(&input, task.to_string()).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/jsbsim_points.py");
    let run = Command::new("python3").arg(script).arg(folder.path()).arg(&model.name).args([&input, &output]).output();
    let run = run.unwrap();
    assert!(run.status.success(), "{}{}", String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    let results: Vec<Vec<f64>> = serde_json::from_str(&std::fs::read_to_string(output).unwrap()).unwrap();
    assert_eq!(results.len(), POINTS);
    let derivatives = model.derivatives();
    let worst = results.iter().zip(&wanted).map(|(read, wanted)| difference(model, &derivatives, read, wanted));
    worst.fold(0.0, f64::max)
}

/// Largest difference of the six coefficients about the centre of gravity at one point.
fn difference(
    model: &IdentifiedModel,
    derivatives: &Derivatives,
    read: &[f64],
    &(alpha, beta, speed, controls): &(f64, f64, f64, [f64; 3]),
) -> f64 {
    let [ra, rb, rv, qbar_psf, p, q, r, alpha_dot, beta_dot, h_ft, mach] = read[..11].try_into().unwrap();
    for (name, read, wanted) in [("alpha", ra, alpha), ("beta", rb, beta), ("V", rv * FT / speed, 1.0)] {
        assert!((read - wanted).abs() < 1e-9, "JSBSim flies at {name} {read}, not {wanted}");
    }
    let reference = &model.reference;
    let (b, c) = (reference.span_m, reference.chord_m);
    let mut values = [0.0; Variable::ALL.len()];
    for (variable, value) in [
        (Variable::Alpha, alpha),
        (Variable::Beta, beta),
        (Variable::Airspeed, speed),
        (Variable::RollRate, p * (reference.lateral_rate_length_m / speed)),
        (Variable::PitchRate, q * (reference.pitch_rate_length_m / speed)),
        (Variable::YawRate, r * (reference.lateral_rate_length_m / speed)),
        (Variable::AlphaDot, alpha_dot * (reference.pitch_rate_length_m / speed)),
        (Variable::BetaDot, beta_dot * (reference.lateral_rate_length_m / speed)),
        (Variable::Aileron, controls[0]),
        (Variable::Elevator, controls[1]),
        (Variable::Rudder, controls[2]),
        (Variable::Altitude, h_ft * FT),
        (Variable::Mach, mach),
    ] {
        values[variable as usize] = value;
    }
    // Thesis Eq. 3.24 and the transfer M_cg = M_ref + d x F, in coefficients: d in body axes from the centre of gravity.
    let [cx, cy, cz, cl, cm, cn] = derivatives.body_coefficients(&values);
    let force = Vector3::new(cx, cy, cz);
    let (point, cg) = (model.moment_reference_datum_m, model.mass.cg_from_datum_m);
    let arm = Vector3::new(cg[0] - point[0], point[1] - cg[1], cg[2] - point[2]);
    let moment = Vector3::new(cl * b, cm * c, cn * b) + arm.cross(&force);
    let force_scale = qbar_psf * reference.area_m2 / (FT * FT);
    let found_force = Vector3::new(read[11], read[12], read[13]) / force_scale;
    let found_moment = Vector3::new(read[14], read[15], read[16]) / (force_scale / FT);
    let moment_error = (found_moment - moment).component_div(&Vector3::new(b, c, b));
    // Mass and moments of inertia arrive: 1 slug ft² is 1.35582 kg m².
    let InertiaTensor { xx, yy, zz, .. } = model.mass.inertia;
    for (found, stated) in read[17..20].iter().zip([xx, yy, zz]) {
        assert!((found * SLUG_FT2 - stated).abs() < 1e-6 * xx, "inertia {found}, stated {stated}");
    }
    assert!((read[20] * 0.453_592_37 - model.mass.mass_kg).abs() < 1e-6 * model.mass.mass_kg);
    // The products arrive with their signs: the aircraft turns as Euler's equation has it.
    let [rates, acceleration] = [21, 24].map(|first| Vector3::new(read[first], read[first + 1], read[first + 2]));
    let tensor = model.mass.inertia.matrix() / SLUG_FT2;
    let moment = Vector3::new(read[14], read[15], read[16]);
    let turning = tensor.try_inverse().unwrap() * (moment - rates.cross(&(tensor * rates)));
    let error = (turning - acceleration).amax();
    assert!(error < EARTH_RATE * rates.norm() * 3.0, "angular acceleration {acceleration}, by Euler {turning}");
    (found_force - force).amax().max(moment_error.amax())
}

#[test]
fn jsbsim_gives_the_coefficients_of_the_model() {
    if !jsbsim() {
        return;
    }
    for model in [body_axes(), lift_and_drag()] {
        let worst = fly(&model);
        println!("{}: {POINTS} points, largest difference {worst:.2e}", model.name);
        assert!(worst < FLOWN, "{}: {worst}", model.name);
    }
}

fn demo() -> (Session, Snapshot) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions/demo.toml");
    let opened = session::open(&path).unwrap();
    let snapshot = compute(&opened.session, &opened.folder);
    (opened.session, snapshot)
}

#[test]
fn the_demo_leaves_as_a_model_that_flies() {
    let (session, snapshot) = demo();
    let model = IdentifiedModel::new(&session, &snapshot).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let files = write(&model, &Format::ALL, folder.path()).unwrap().files;
    assert_eq!(files.len(), 4);
    let daveml = files.iter().find(|file| file.extension().is_some_and(|ending| ending == "dml")).unwrap();
    assert!(check_daveml(daveml) >= 6 * 41);
    // Derivatives are those of the results; the constant is the mean of those of the windows.
    let pooled = snapshot.pooled.ready().unwrap();
    let fit = pooled.fits.iter().find(|fit| fit.coefficient == Coefficient::Cm).unwrap();
    let estimate = fit.fit.as_ref().unwrap();
    let exported = model.coefficients.iter().find(|c| c.coefficient == Coefficient::Cm).unwrap();
    let value = |name: &str| exported.parameters.iter().find(|p| p.name == name).unwrap();
    assert_eq!(value("Cm_alpha").value, estimate.parameter("Cm_alpha").unwrap().0);
    let constants: Vec<f64> = (0..estimate.parameters())
        .filter(|&index| estimate.names[index].starts_with("Cm_0["))
        .map(|index| estimate.estimates[index])
        .collect();
    let (low, high) =
        (constants.iter().copied().fold(f64::MAX, f64::min), constants.iter().copied().fold(f64::MIN, f64::max));
    assert!(constants.len() > 3 && (low..=high).contains(&value("Cm_0").value));
    let most = fit.corrected_errors.iter().copied().fold(0.0, f64::max);
    assert!(exported.parameters.iter().all(|p| p.standard_error > 0.0 && p.standard_error <= most));
    assert!(jsbsim_or_skip(&model));
    // Moments of stability axes are nobody's here.
    let mut turned = session;
    turned.preparation.axes = Axes::Stability;
    let refused = IdentifiedModel::new(&turned, &snapshot).unwrap_err().to_string();
    assert_eq!(refused.lines().count(), 1);
    assert!(refused.contains("stability axes") && refused.contains("choose body axes"), "{refused}");
}

fn jsbsim_or_skip(model: &IdentifiedModel) -> bool {
    let missing = |variable: &Variable| !model.ranges.contains_key(variable);
    let mut whole = model.clone();
    // What the model does not depend on still needs a value to fly at.
    for variable in Variable::ALL.iter().filter(|variable| missing(variable)) {
        whole.ranges.insert(*variable, if *variable == Variable::Altitude { (1000.0, 1500.0) } else { (0.0, 0.0) });
    }
    !jsbsim() || fly(&whole) < FLOWN
}
