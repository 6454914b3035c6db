//! What the session says of axes, reference point, thrust, rotors and lags, against transformations of the coefficients themselves.

use crate::compute;
use crate::shared;
use std::path::Path;
use std::sync::Arc;

use doublet_core::model::{Axes, Coefficient, Gyroscopic, Lag, Term, ThrustTreatment, Variable};
use doublet_core::prep::{Differentiation, differentiate, smoothed_rate};
use doublet_core::quantity::Role;
use doublet_engine::builtin;
use doublet_engine::graph::Cache;
use doublet_engine::report::{self, HistoryFormat, Outputs};
use doublet_engine::run::{Control, Scope, Snapshot, run};
use doublet_engine::session::{
    self, AngularAcceleration, ControlLags, Estimation, ExpressionSetting, MapRef, MomentReference, Preparation,
    Session, Surface, WindowRole,
};
use doublet_engine::stage::{AirDensity, WindowAero};
use doublet_engine::verdict::{Level, judge};

/// Rounding of a few sums of order one.
const ROUNDING: f64 = 1e-12;

/// The shipped session with one window and nothing smoothed, so that every sample stands for itself.
fn shipped() -> Session {
    let mut session = session::parse(builtin::session("demo").unwrap()).unwrap();
    session.windows.truncate(1);
    session.preparation.matched_smoothing = false;
    session.preparation.differentiation_half_width_s = None;
    session
}

/// Coefficients of its window under a changed preparation, with the recording read once.
struct Bench {
    session: Session,
    cache: Cache,
}

impl Bench {
    fn new() -> Self {
        Self { session: shipped(), cache: Cache::new(1 << 30) }
    }

    fn with(&self, change: impl FnOnce(&mut Preparation)) -> Arc<WindowAero> {
        let mut session = self.session.clone();
        change(&mut session.preparation);
        // What is tested is what a saved session says.
        let session = session::parse(&session::print(&session).unwrap()).unwrap();
        let scope =
            Scope { session: &session, folder: Path::new(""), first: None, studies: &[], cause: "test", generation: 1 };
        let snapshot = run(&scope, &Snapshot::default(), &self.cache, &Control::default(), &|_| {});
        let found = snapshot.windows.values().next().unwrap();
        Arc::clone(found.aero.ready().unwrap())
    }
}

fn assert_close(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() < ROUNDING * expected.abs().max(1.0), "{what}: {found} {expected}");
}

#[test]
fn settings_of_the_session_transform_the_coefficients_of_every_sample() {
    let bench = Bench::new();
    let body = bench.with(|_| {});
    let column = |aero: &WindowAero, coefficient: Coefficient, k: usize| aero.coefficients.get(coefficient)[k];
    let samples = body.data.time_s.len();
    assert!(samples > 500);
    let reference = body.settings.reference;
    assert_eq!(body.settings.gyroscopic, Gyroscopic::Signed);

    let stability = bench.with(|preparation| preparation.axes = Axes::Stability);
    for k in 0..samples {
        let (sin, cos) = body.data.alpha_rad[k].sin_cos();
        let [l, n] = [Coefficient::Cl, Coefficient::Cn].map(|c| column(&body, c, k));
        assert_close(column(&stability, Coefficient::Cl, k), l * cos + n * sin, "Cl");
        assert_close(column(&stability, Coefficient::Cn, k), n * cos - l * sin, "Cn");
        let [p, r] = [Variable::RollRate, Variable::YawRate].map(|v| body.variables.get(v).unwrap()[k]);
        assert_close(stability.variables.get(Variable::RollRate).unwrap()[k], p * cos + r * sin, "p");
        assert_close(stability.variables.get(Variable::YawRate).unwrap()[k], r * cos - p * sin, "r");
        for same in [Coefficient::CX, Coefficient::CZ, Coefficient::Cm, Coefficient::CL, Coefficient::CD] {
            assert_eq!(column(&stability, same, k), column(&body, same, k));
        }
    }

    // M_P = M_cg - d x F, d from the centre of gravity to P in body axes.
    let point = [3.6, 0.1, 1.5];
    let about = bench.with(|preparation| preparation.moment_reference = MomentReference::Datum(point));
    let cg = bench.with(|preparation| preparation.moment_reference = MomentReference::CentreOfGravity);
    for k in 0..samples {
        let at = body.data.mass.at(k).cg_from_datum_m;
        let d = [at[0] - point[0], point[1] - at[1], at[2] - point[2]];
        let [x, y, z] = [Coefficient::CX, Coefficient::CY, Coefficient::CZ].map(|c| column(&cg, c, k));
        let (span, chord) = (reference.span_m, reference.chord_m);
        let expected = [
            column(&cg, Coefficient::Cl, k) - (d[1] * z - d[2] * y) / span,
            column(&cg, Coefficient::Cm, k) - (d[2] * x - d[0] * z) / chord,
            column(&cg, Coefficient::Cn, k) - (d[0] * y - d[1] * x) / span,
        ];
        for (coefficient, expected) in [Coefficient::Cl, Coefficient::Cm, Coefficient::Cn].into_iter().zip(expected) {
            assert_close(column(&about, coefficient, k), expected, coefficient.name());
        }
    }

    // Thrust out by force alone: CX as without thrust, Cm as with it.
    let [inside, force, out] = [ThrustTreatment::Included, ThrustTreatment::ForceRemoved, ThrustTreatment::Removed]
        .map(|thrust| {
            bench.with(|preparation| {
                (preparation.thrust, preparation.moment_reference) = (thrust, MomentReference::CentreOfGravity)
            })
        });
    let (mut most, mut shift) = (0.0_f64, 0.0_f64);
    for k in 0..samples {
        assert_eq!(column(&force, Coefficient::CX, k), column(&out, Coefficient::CX, k));
        assert_eq!(column(&force, Coefficient::Cm, k), column(&inside, Coefficient::Cm, k));
        most = most.max((column(&inside, Coefficient::CX, k) - column(&force, Coefficient::CX, k)).abs());
        shift = shift.max((column(&force, Coefficient::Cm, k) - column(&out, Coefficient::Cm, k)).abs());
    }
    assert!(most > 0.01 && shift > 1e-4, "{most} {shift}");

    // Rotors: M grows by h r, N falls by h q with h the sum of magnitudes; nothing where they are ignored.
    let [summed, ignored] = [Gyroscopic::Summed, Gyroscopic::Ignored]
        .map(|gyroscopic| bench.with(|preparation| preparation.gyroscopic = gyroscopic));
    for k in 0..samples {
        let h: f64 = body.data.engines.iter().map(|e| (e.rotor_inertia_kg_m2 * e.speed_rad_s[k]).abs()).sum();
        let scale = 0.5 * body.data.density_kg_m3[k] * body.data.airspeed_m_s[k].powi(2) * reference.area_m2;
        let [_, q, r] = body.data.rates_rad_s.each_ref().map(|rate| rate[k]);
        let [cm, cn] = [Coefficient::Cm, Coefficient::Cn].map(|c| column(&summed, c, k) - column(&ignored, c, k));
        assert_close(cm, h * r / (scale * reference.chord_m), "Cm");
        assert_close(cn, -h * q / (scale * reference.span_m), "Cn");
    }
}

#[test]
fn angular_acceleration_is_that_of_the_smoother_over_the_rates() {
    let bench = Bench::new();
    let smoother = bench.with(|preparation| {
        (preparation.angular_acceleration, preparation.matched_smoothing) = (AngularAcceleration::Smoother, true);
    });
    assert!(!smoother.settings.matched, "nothing else is smoothed");
    let time_s = &smoother.data.time_s;
    let found = smoother.data.angular_acceleration_rad_s2.as_ref().unwrap();
    for axis in 0..3 {
        let own = smoothed_rate(time_s, &smoother.data.rates_rad_s[axis]).unwrap();
        assert_eq!(found[axis], own.slope);
    }
    // Another way to the roll acceleration of this aileron doublet: the same motion, but for what 0.1 s to either side smooth away.
    let quadratic = Differentiation::LocalPolynomial { degree: 2, half_width: 5 };
    let other = differentiate(time_s, &smoother.data.rates_rad_s[0], quadratic).unwrap();
    let size = other.iter().map(|v| v * v).sum::<f64>().sqrt();
    let off = other.iter().zip(&found[0]).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    assert!(off < 0.2 * size, "{off} of {size}");
}

#[test]
fn each_control_has_its_own_lag() {
    let bench = Bench::new();
    let plain = bench.with(|_| {});
    let lagged = bench.with(|preparation| {
        preparation.control_lags = ControlLags::default()
            .with(Surface::Aileron, Lag { time_constant_s: 0.0, delay_s: 0.04 })
            .with(Surface::Rudder, Lag { time_constant_s: 0.1, delay_s: 0.0 });
    });
    let of = |aero: &WindowAero, variable| aero.variables.get(variable).unwrap().to_vec();
    assert_eq!(of(&lagged, Variable::Elevator), of(&plain, Variable::Elevator));
    // 0.04 s is two samples of 50 Hz: the column moves by them.
    let (before, after) = (of(&plain, Variable::Aileron), of(&lagged, Variable::Aileron));
    let off = before.iter().zip(&after[2..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let moved = before.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-3 * moved.max(1e-3) + 1e-6 && moved > 1e-3, "{off} {moved}");
    // First order: d' = (u - d) / T, for u in straight lines between samples.
    let (u, d) = (&plain.data.controls[&Role::Rudder], of(&lagged, Variable::Rudder));
    let mut expected = u[0];
    for k in 1..u.len() {
        let dt = plain.data.time_s[k] - plain.data.time_s[k - 1];
        let slope = (u[k] - u[k - 1]) / dt;
        let decay = (-dt / 0.1).exp();
        expected = expected * decay + u[k - 1] * (1.0 - decay) + slope * (dt - 0.1 * (1.0 - decay));
        assert!((d[k] - expected).abs() < 1e-9, "{k}: {} {expected}", d[k]);
    }
}

#[test]
fn preparation_is_saved_as_it_reads_and_older_forms_mean_what_they_meant() {
    let plain = shipped();
    let text = session::print(&plain).unwrap();
    for absent in ["axes", "moment_reference", "gyroscopic", "control_lag", "angular_acceleration"] {
        assert!(!text.contains(absent), "{absent} is as it always was and is not written");
    }
    let old = text.replace("actuator_lag_s = 0.0", "actuator_lag_s = 0.08");
    let lags = session::parse(&old).unwrap().preparation.control_lags;
    assert_eq!((lags, lags.summary()), (ControlLags::common(0.08), "lag 0.08 s".to_owned()));

    let mut session = plain;
    session.preparation.control_lags =
        ControlLags::common(0.08).with(Surface::Elevator, Lag { time_constant_s: 0.05, delay_s: 0.01 });
    session.preparation.moment_reference = MomentReference::Datum([3.0, 0.0, 1.25]);
    session.preparation.thrust = ThrustTreatment::ForceRemoved;
    session.preparation.axes = Axes::Stability;
    session.preparation.gyroscopic = Gyroscopic::Summed;
    session.preparation.angular_acceleration = AngularAcceleration::Smoother;
    let text = session::print(&session).unwrap();
    for line in [
        "remove_thrust = \"force\"",
        "axes = \"stability\"",
        "gyroscopic = \"summed\"",
        "angular_acceleration = \"smoother\"",
        "[preparation.control_lag.elevator]\nlag_s = 0.05\ndelay_s = 0.01",
        "[preparation.control_lag.rudder]\nlag_s = 0.08\ndelay_s = 0.0",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    assert_eq!(session::parse(&text).unwrap(), session);
    assert_eq!(
        session.preparation.control_lags.summary(),
        "elevator lag 0.05 s and delay 0.01 s, aileron lag 0.08 s, rudder lag 0.08 s"
    );

    session.preparation.control_lags.rudder.delay_s = f64::NAN;
    let problems: Vec<String> = session::check(&session).iter().map(ToString::to_string).collect();
    assert_eq!(
        problems,
        ["preparation.control_lag.rudder.delay_s: NaN is out of range: enter a number from -10 to 10"]
    );
}

#[test]
fn assumed_density_is_called_so_and_smoothed_states_are_written_with_their_deviations() {
    if shared::shared("data/citation_simulated").is_none() {
        return;
    }
    // Neither altitude nor pressure is recorded: the session puts the origin at 1,000 m.
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions/reference/citation_aileron.toml");
    let opened = session::open(&path).unwrap();
    let (session, folder) = (&opened.session, opened.folder.as_path());
    let snapshot = compute(session, folder);
    let aero = snapshot.windows.values().next().unwrap().aero.ready().unwrap();
    assert_eq!(aero.air_density, AirDensity::AssumedAltitude(1000.0));
    assert!(
        aero.warnings.iter().any(|line| line.to_string().contains("air density is assumed")),
        "{:?}",
        aero.warnings
    );
    let reasons = judge(session, &snapshot).session.reasons;
    let found = reasons.iter().find(|finding| finding.code == "assumed").unwrap();
    assert!(found.level == Level::Caution && found.text.to_string().contains("1000 m above the sea"), "{found:?}");
    let folder = tempfile::tempdir().unwrap();
    let outputs = Outputs { tables: Vec::new(), histories: vec![HistoryFormat::Csv], recordings: false };
    let out = folder.path().join("out");
    report::write(session, &snapshot, &out, &outputs, &Control::default(), &|_| ()).unwrap();
    let results: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("results.json")).unwrap()).unwrap();
    assert_eq!(results["windows"][0]["air_density"], "standard atmosphere at an assumed altitude");
    let files = std::fs::read_dir(out.join("histories_csv")).unwrap().map(|file| file.unwrap().path());
    let heads: Vec<String> = files
        .map(|file| std::fs::read_to_string(file).unwrap().lines().next().unwrap_or_default().to_owned())
        .collect();
    let of = |folder: &str| heads.iter().map(|head| head.matches(&format!("path/{folder}/")).count()).sum::<usize>();
    assert_eq!((of("smoothed"), of("smoothed_deviations")), (18, 18));
}

/// Of a recording without static pressure the density is `p / (R T)` at the standard pressure of the altitude: on a day 20 K warmer than the
/// standard one it is `T / (T + 20 K)` of the standard density. A temperature that is not that of the outside air is not used.
#[test]
fn a_warm_day_lowers_the_density_of_a_recording_without_static_pressure() {
    let mut session = session::parse(builtin::session("demo").unwrap()).unwrap();
    session.windows = vec![session.window("03 elevator doublet").unwrap().clone()];
    let map = builtin::text("channel_maps", "demo_flight").unwrap();
    let pressure = "[roles.static_pressure]\nsource = \"*air_data\"\nchannel = \"p_s\"\nunit = \"inHg\"\n";
    assert!(map.contains(pressure));
    for recording in &mut session.flights[0].recordings {
        recording.channel_map = MapRef::Own(map.replace(pressure, "").into());
    }
    let aero = |session: &Session| {
        let snapshot = compute(session, Path::new(""));
        let aero = &snapshot.windows.values().next().unwrap().aero;
        Arc::clone(aero.ready().unwrap_or_else(|| panic!("{:?} {:?}", aero.error(), snapshot.flights)))
    };
    let mut warmer = |excess_k: &str| {
        session.flights[0].expressions = vec![ExpressionSetting {
            name: "outside air".to_owned(),
            unit: "K".to_owned(),
            expression: format!("288.15 + {excess_k} - 0.0065 * altitude"),
            role: Some(Role::AirTemperature),
        }];
        aero(&session)
    };
    let (standard, warm, sensor) = (warmer("0"), warmer("20"), warmer("60"));
    assert_eq!(warm.air_density, AirDensity::AltitudeAndTemperature);
    let altitude_m = warm.data.altitude_m.as_ref().unwrap();
    for (k, altitude) in altitude_m.iter().enumerate() {
        let standard_k = 288.15 - 0.006_5 * altitude;
        let ratio = warm.data.density_kg_m3[k] / standard.data.density_kg_m3[k];
        assert!((ratio - standard_k / (standard_k + 20.0)).abs() < 1e-9, "{k}: {ratio}");
    }
    assert_eq!(sensor.air_density, AirDensity::RecordedAltitude);
    assert!((sensor.data.density_kg_m3[0] / standard.data.density_kg_m3[0] - 1.0).abs() < 1e-9);
    assert!(
        sensor.warnings.iter().any(|line| line.to_string().contains("which is implausible")),
        "{:?}",
        sensor.warnings
    );
}

/// A channel by expression is a term of the model: with the elevator's values it has the elevator's derivative, predicts and flies as
/// it does.
#[test]
fn an_expression_is_a_term_of_the_model() {
    let mut session = session::parse(builtin::session("demo").unwrap()).unwrap();
    let used = ["01 aileron doublet", "03 elevator doublet", "05 rudder doublet", "04 elevator doublet"];
    session.windows = used.map(|name| session.window(name).unwrap().clone()).into();
    session.windows[3].role = WindowRole::Validation;
    session.estimation = Estimation::default();
    let computed = |session: &Session| {
        let session = session::parse(&session::print(session).unwrap()).unwrap();
        compute(&session, Path::new(""))
    };
    let plain = computed(&session);
    let expression = ExpressionSetting {
        name: "elevator again".to_owned(),
        unit: "-".to_owned(),
        expression: "delta_e".to_owned(),
        role: Some(Role::Other1),
    };
    session.flights[0].expressions.push(expression);
    for (_, terms) in &mut session.structure.models {
        for term in terms.iter_mut().filter(|term| **term == Term::from(Variable::Elevator)) {
            *term = Term::parse("other_1").unwrap();
        }
    }
    let by_expression = computed(&session);
    let fits = |snapshot: &Snapshot| -> Vec<(String, f64)> {
        let pooled = snapshot.pooled.ready().unwrap();
        let fits = pooled.fits.iter().filter_map(|fit| fit.fit.as_ref().ok());
        fits.flat_map(|fit| fit.names.iter().cloned().zip(fit.estimates.iter().copied())).collect()
    };
    let (expected, found) = (fits(&plain), fits(&by_expression));
    assert!(found.iter().any(|(name, _)| name == "Cm_other_1"), "{found:?}");
    assert_eq!(found.len(), expected.len());
    for ((name, value), (_, of_elevator)) in found.iter().zip(&expected) {
        assert_close(*value, *of_elevator, name);
    }
    let flown = |snapshot: &Snapshot| -> Vec<f64> {
        let replay = snapshot.proof.ready().unwrap().windows[0].1.clone().unwrap();
        let theil = |index: usize| replay.theil[index].1.coefficient;
        (0..replay.theil.len()).map(theil).collect()
    };
    let (expected, found) = (flown(&plain), flown(&by_expression));
    assert!(!expected.is_empty());
    for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert!((found - expected).abs() < 1e-9, "{k}: {found} {expected}");
    }
}
