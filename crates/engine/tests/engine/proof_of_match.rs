//! Proof of match on the shipped flight: the truth stays inside the bands, a wrong derivative does not.

use std::path::Path;

use doublet_core::model::{Coefficient, Derivatives};
use doublet_core::simulate::c337f;
use doublet_core::validate::Signal;
use doublet_engine::run::Snapshot;
use doublet_engine::session::{self, Session, Surface, WindowRole};
use doublet_engine::stage::{ReplayWindow, Tolerances, WindowReplay, replay};

use crate::compute;

struct Demo {
    session: Session,
    snapshot: Snapshot,
}

fn demo() -> Demo {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions/demo.toml");
    let opened = session::open(&path).unwrap();
    let snapshot = compute(&opened.session, &opened.folder);
    Demo { session: opened.session, snapshot }
}

/// The derivatives the shipped flight was flown with, one of them scaled.
fn truth(scaled: &str, factor: f64) -> Derivatives {
    let (vehicle, _) = c337f().unwrap();
    let scale = |name: &str| if name == scaled { factor } else { 1.0 };
    let derivatives = vehicle.aero.derivatives().iter();
    derivatives.map(|d| (d.coefficient, d.term.clone(), d.value * scale(&d.name))).collect()
}

impl Demo {
    fn fly(&self, window: &str, model: &Derivatives) -> WindowReplay {
        let manoeuvre = self.session.window(window).unwrap();
        let results = &self.snapshot.windows[window];
        let (path, aero) = (results.path.ready().unwrap(), results.aero.ready().unwrap());
        let window = ReplayWindow { manoeuvre, path, aero };
        let gravity = self.session.filter.gravity_m_s2;
        let tolerances = Tolerances::builtin().unwrap();
        replay(&window, model, &self.session.preparation, gravity, &tolerances).unwrap()
    }

    fn validation(&self) -> Vec<&str> {
        let windows = self.session.windows.iter().filter(|window| window.role == WindowRole::Validation);
        windows.map(|window| window.name.as_str()).collect()
    }
}

#[test]
fn the_true_model_flies_inside_the_bands_and_a_wrong_one_does_not() {
    let demo = demo();
    let exact = truth("", 1.0);
    for window in demo.validation() {
        let replay = demo.fly(window, &exact);
        for test in &replay.tests {
            let ratios: Vec<_> = test.requirements.iter().flatten().map(|band| band.worst_ratio).collect();
            println!("{window}: {} {} of the width {ratios:.2?}", test.id, test.name);
            assert!(test.passed(), "{window}: {} with the true model", test.id);
        }
        assert!(!replay.tests.is_empty(), "{window} has no test");
    }
    // A derivative of the motion each input excites, wrong by more than an estimate can be.
    for (surface, derivative, factor) in
        [(Surface::Elevator, "Cm_alpha", 0.6), (Surface::Aileron, "Cl_delta_a", 0.6), (Surface::Rudder, "Cn_beta", 0.3)]
    {
        let wrong = truth(derivative, factor);
        let windows = demo.validation();
        let mut windows = windows.iter().filter(|name| demo.session.window(name).unwrap().surface == Some(surface));
        let window = windows.next().unwrap();
        let replay = demo.fly(window, &wrong);
        let ratios: Vec<_> =
            replay.tests.iter().flat_map(|test| &test.requirements).flatten().map(|b| b.worst_ratio).collect();
        println!("{window}: {factor} {derivative} of the width {ratios:.2?}");
        assert!(replay.tests.iter().any(|test| !test.passed()), "{window} passes with {factor} {derivative}");
        let signal = match surface {
            Surface::Elevator => Signal::PitchRate,
            Surface::Aileron => Signal::RollRate,
            Surface::Rudder => Signal::YawRate,
        };
        let coefficient = |replay: &WindowReplay| {
            let theil = replay.theil.iter().find(|(found, _)| *found == signal).unwrap().1;
            assert!((theil.bias + theil.variance + theil.covariance - 1.0).abs() < 1e-9);
            theil.coefficient
        };
        let (right, wrong) = (coefficient(&demo.fly(window, &exact)), coefficient(&replay));
        println!(
            "{window}: Theil's coefficient of {} {right:.3} with the truth, {wrong:.3} with {derivative}",
            signal.name()
        );
        assert!(right < 0.5 * wrong, "{right} against {wrong}");
    }
}

#[test]
fn the_run_flies_every_validation_window_with_the_identified_model() {
    let demo = demo();
    let proof = demo.snapshot.proof.ready().unwrap();
    let flown: Vec<&str> = proof.windows.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(flown, demo.validation());
    let mut passed = 0;
    for (name, replay) in &proof.windows {
        let replay = replay.as_ref().unwrap();
        let samples = demo.snapshot.windows[name].aero.ready().unwrap().data.time_s.len();
        assert_eq!(replay.simulated.time_s.len(), samples);
        for test in &replay.tests {
            let ratios: Vec<_> = test.requirements.iter().flatten().map(|band| band.worst_ratio).collect();
            println!("{name}: {} passed {} of the width {ratios:.2?}", test.id, test.passed());
            passed += usize::from(test.passed());
        }
    }
    assert_eq!(passed, flown.len(), "every validation manoeuvre passes its test with the identified model");
    // The same flights by narrower bands fail: the tolerances decide, not the program.
    let narrow = "name = \"narrow\"\n[[test]]\nid = \"n\"\nname = \"narrow\"\nsurface = \"elevator\"\n\
                  require = [{ any = [{ signal = \"theta\", absolute = 0.0001, unit = \"deg\" }] }]\n";
    let judged = proof.judge_by(&demo.session, &Tolerances::parse(narrow).unwrap());
    let elevator = |name: &str| demo.session.window(name).unwrap().surface == Some(Surface::Elevator);
    for (name, replay) in &judged.windows {
        let tests = &replay.as_ref().unwrap().tests;
        assert_eq!(tests.len(), usize::from(elevator(name)));
        assert!(tests.iter().all(|test| !test.passed()));
    }
}

#[test]
fn a_model_without_a_coefficient_says_so_in_its_window() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions/demo.toml");
    let mut opened = session::open(&path).unwrap();
    opened.session.structure.models.retain(|(coefficient, _)| *coefficient != Coefficient::Cn);
    opened.session.windows.retain(|window| ["12 rudder 3-2-1-1", "16 rudder doublet"].contains(&window.name.as_str()));
    opened.session.estimation.by_surface = false;
    let snapshot = compute(&opened.session, &opened.folder);
    let proof = snapshot.proof.ready().unwrap();
    let error = proof.window("16 rudder doublet").unwrap().as_ref().unwrap_err();
    assert!(error.to_string().contains("no derivatives of Cn") && !error.to_string().contains('\n'), "{error}");
}
