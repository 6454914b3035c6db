//! Output error of one axis at a time: the published manoeuvre whose other axis is badly known, and sessions that model one axis
//! alone, on the shipped flight whose truth is known.

use crate::shared;
use std::path::Path;

use doublet_core::model::Coefficient;
use doublet_core::replay::MotionAxis;
use doublet_core::simulate::c337f;
use doublet_engine::graph::Cache;
use doublet_engine::graph::StageError;
use doublet_engine::run::{Control, Scope, Snapshot, run};
use doublet_engine::session::{self, Manoeuvre, Opened};
use doublet_engine::study::{
    CheckRequest, CheckStudy, CheckedDerivative, Estimator, FollowedFlight, MethodEstimates, Study, WindowChecks,
};
use doublet_engine::verdict::{Finding, Level};

/// Errors of estimates that agree, in corrected standard errors.
const ERRORS: f64 = 2.0;

/// Share of the derivatives that agree, at least.
const SHARE: f64 = 0.95;

/// Root mean square of the normalised errors, at least: path errors count as disturbance, so that it is below one.
const LEAST_RMS: f64 = 0.3;

/// A shipped session with some of its windows and, where one is named, the coefficients of one axis alone.
fn shipped(name: &str, keep: impl Fn(&Manoeuvre) -> bool, modelled: Option<MotionAxis>) -> Opened {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions").join(format!("{name}.toml"));
    let mut opened = session::open(&path).unwrap();
    opened.session.windows.retain(keep);
    if let Some(axis) = modelled {
        opened.session.structure.models.retain(|(coefficient, _)| axis.has(*coefficient));
    }
    opened
}

struct Checked {
    snapshot: Snapshot,
}

/// The session run with the checks of `axis`.
fn checked(opened: &Opened, axis: Option<MotionAxis>) -> Checked {
    checked_by(opened, CheckRequest { axis, ..CheckRequest::default() })
}

fn checked_by(opened: &Opened, request: CheckRequest) -> Checked {
    let scope = Scope {
        session: &opened.session,
        folder: &opened.folder,
        first: None,
        studies: &[Study::Checks(request)],
        cause: "test",
        generation: 1,
    };
    Checked { snapshot: run(&scope, &Snapshot::default(), &Cache::new(1 << 30), &Control::default(), &|_| ()) }
}

impl Checked {
    fn study(&self) -> &CheckStudy {
        self.snapshot.studies.checks.ready().unwrap()
    }

    /// Equation error of a window: estimate and corrected standard error.
    fn equation_error(&self, window: &str, name: &str) -> (f64, f64) {
        let fits = self.snapshot.windows[window].fits.ready().unwrap();
        let found = fits.fits.iter().find_map(|fit| {
            let estimate = fit.fit.as_ref().ok()?;
            let index = estimate.names.iter().position(|other| other == name)?;
            Some((estimate.estimates[index], fit.corrected_errors[index]))
        });
        found.unwrap_or_else(|| panic!("no {name} in {window}"))
    }
}

/// What the estimator called `key` found for the first motion of a window.
fn by<'w>(window: &'w WindowChecks, key: &str) -> Result<&'w MethodEstimates, &'w StageError> {
    window.results().find(|(method, ..)| method.key == key).unwrap().2
}

/// Derivatives by output error over the only motion of a window, their flight, and whether it is said not to follow.
fn flight(window: &WindowChecks) -> (&[CheckedDerivative], &FollowedFlight, bool) {
    let found = by(window, "output-error").unwrap_or_else(|error| panic!("{}: {error}", window.window));
    let flight = found.flight.as_ref().unwrap();
    (
        &found.derivatives,
        flight,
        window.findings().iter().any(|finding| finding.level == Level::Bad && finding.code == "follows"),
    )
}

#[test]
fn published_elevator_manoeuvre_alone_is_followed_by_its_own_axis_and_told_apart_by_both() {
    if shared::shared("data/attas").is_none() {
        return;
    }
    let opened = shipped("reference/attas", |window| window.name.starts_with("elevator"), None);
    let alone = checked(&opened, None);
    let window = &alone.study().windows[0];
    let (derivatives, own, is_bad) = flight(window);
    assert!(own.axis == MotionAxis::Longitudinal && !is_bad, "{:?}", window.findings());
    // Flown at 129.3 m/s.
    let start = &own.starts[0];
    assert!((start.estimate - start.path).abs() < 0.5 && (start.path - 129.3).abs() < 0.5, "{start:?}");
    for found in derivatives.iter().filter(|found| !found.name.ends_with("_0")) {
        let (estimate, error) = alone.equation_error(&window.window, &found.name);
        let apart = (found.estimate - estimate) / error.hypot(found.standard_error);
        println!(
            "{}: {:.4} ± {:.2e}, {estimate:.4} ± {error:.2e}: {apart:.1}",
            found.name, found.estimate, found.standard_error
        );
        assert!(apart.abs() < ERRORS, "{}: {apart} joint errors", found.name);
    }
    // Six degrees of freedom have to follow a lateral motion that nothing in this manoeuvre tells about, which is said.
    let both = checked(&opened, Some(MotionAxis::Both));
    let found = both.study().windows[0].findings();
    println!("{found:#?}");
    assert!(!found.is_empty());
}

#[test]
fn flight_of_a_model_without_its_control_is_said_not_to_follow() {
    if shared::shared("data/attas").is_none() {
        return;
    }
    let mut opened =
        shipped("reference/attas", |window| window.name.starts_with("elevator"), Some(MotionAxis::Longitudinal));
    for (coefficient, terms) in &mut opened.session.structure.models {
        if *coefficient == Coefficient::Cm {
            terms.retain(|term| term.to_string() != "delta_e");
        }
    }
    let alone = checked(&opened, None);
    let found = alone.study().windows[0].findings();
    println!("{found:#?}");
    assert!(found.iter().any(|finding| finding.code == "follows"));
    // Or it does not settle, and there are no derivatives to be misled by.
    let is_bad = |finding: &Finding| finding.level == Level::Bad;
    assert!(by(&alone.study().windows[0], "output-error").is_err() || found.iter().any(is_bad));
}

/// Derivatives of every single window of a session that models one axis against the truth, in corrected standard errors.
fn against_truth(surfaces: &[&str], axis: MotionAxis) {
    let (vehicle, _) = c337f().unwrap();
    let (mut held, mut count, mut squares) = (0_u32, 0_u32, 0.0);
    for surface in surfaces {
        let opened = shipped("demo", |window| window.name.contains(surface), Some(axis));
        let alone = checked(&opened, None);
        for window in &alone.study().windows {
            let (derivatives, found, is_bad) = flight(window);
            assert_eq!(found.axis, axis);
            assert!(!is_bad, "{:?}", window.findings());
            for derivative in derivatives.iter().filter(|derivative| !derivative.name.ends_with("_0")) {
                let truth = vehicle.aero.value(&derivative.name).unwrap();
                let off = (derivative.estimate - truth) / derivative.standard_error;
                println!(
                    "{} {}: {:.4} ± {:.4}, truth {truth:.4}: {off:+.1}",
                    window.window, derivative.name, derivative.estimate, derivative.standard_error
                );
                held += u32::from(off.abs() < ERRORS);
                count += 1;
                squares += off * off;
            }
        }
    }
    let rms = (squares / f64::from(count)).sqrt();
    println!("{}: {held} of {count} within {ERRORS} corrected errors, normalised error {rms:.2}", axis.name());
    assert!(count >= 80 && f64::from(held) >= SHARE * f64::from(count), "{held} of {count} within two errors");
    // Nor are the errors so large that they say nothing.
    assert!(rms > LEAST_RMS, "normalised error {rms}");
}

#[test]
fn filter_error_of_an_elevator_and_an_aileron_manoeuvre_holds_the_truth() {
    /// Largest error, in standard errors.
    const LARGEST: f64 = 4.0;
    let (vehicle, _) = c337f().unwrap();
    let opened = shipped("demo", |window| window.name.starts_with("01") || window.name.starts_with("03"), None);
    let found = checked_by(
        &opened,
        CheckRequest { axis: None, estimators: Estimator::from_key("filter-error").into_iter().collect() },
    );
    let mut count = 0;
    for window in &found.study().windows {
        let filtered = by(window, "filter-error").unwrap();
        for derivative in filtered.derivatives.iter().filter(|derivative| !derivative.name.ends_with("_0")) {
            let truth = vehicle.aero.value(&derivative.name).unwrap();
            let off = (derivative.estimate - truth) / derivative.standard_error;
            assert!(off.abs() < LARGEST, "{} {}: {off:+.1} errors", window.window, derivative.name);
            count += 1;
        }
        // The air of this flight is calm: what drives the velocity is small.
        let noise = filtered.others.iter().map(|noise| noise.estimate).fold(0.0, f64::max);
        assert!(noise < 0.05, "{}: {noise}", window.window);
    }
    assert_eq!(count, 22);
}

#[test]
fn session_of_the_longitudinal_axis_alone_is_followed() {
    against_truth(&["elevator"], MotionAxis::Longitudinal);
}

#[test]
fn session_of_the_lateral_axis_alone_is_followed() {
    against_truth(&["aileron", "rudder"], MotionAxis::Lateral);
}

#[test]
fn aileron_manoeuvre_without_a_longitudinal_model_settles_or_is_told_not_to_follow() {
    if shared::shared("data/citation_simulated").is_none() {
        return;
    }
    let mut opened = shipped("reference/citation_aileron", |_| true, Some(MotionAxis::Lateral));
    let window = &mut opened.session.windows[0].window;
    window.end_s = window.end_s.min(window.start_s + 25.0);
    let alone = checked(&opened, None);
    let window = &alone.study().windows[0];
    let (derivatives, found, is_bad) = flight(window);
    println!("{} steps, {:?}", found.iterations, window.findings());
    assert!(!is_bad);
    for output in &found.outputs {
        println!("{}: R2 {:.3}, largest {:.2e}", output.output.name(), output.r_squared, output.largest_deviation);
        assert!(output.r_squared > 0.95, "{}", output.output.name());
    }
    let estimates: Vec<_> = derivatives.iter().filter(|derivative| !derivative.name.ends_with("_0")).collect();
    assert!(estimates.len() >= 12);
    for derivative in estimates {
        let (estimate, error) = alone.equation_error(&window.window, &derivative.name);
        let apart = (derivative.estimate - estimate) / error.hypot(derivative.standard_error);
        println!(
            "{}: {:.4} ± {:.2e}, {estimate:.4} ± {error:.2e}: {apart:.1}",
            derivative.name, derivative.estimate, derivative.standard_error
        );
        assert!(apart.abs() < ERRORS, "{}: {apart} joint errors", derivative.name);
    }
}
