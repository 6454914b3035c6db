//! The shipped flight treated as in the thesis: what of its weaknesses shows, and what a wrong clock adds (docs/fidelity.md).

use std::path::Path;

use doublet_engine::report::{self, PredictionAgreement, Results};
use doublet_engine::session::{self, PredictionParameters, Session, SignalPreset};

use crate::compute;

fn treated() -> Session {
    session::parse(doublet_engine::builtin::session("demo_thesis").unwrap()).unwrap()
}

fn results(session: &Session) -> Results {
    let folder = Path::new(".");
    let snapshot = compute(session, folder);
    assert!(snapshot.failures().is_empty(), "{:?}", snapshot.failures());
    report::build(session, &snapshot)
}

/// Mean, least and greatest over the identification windows.
fn estimates(results: &Results, name: &str) -> [f64; 3] {
    let row = results.derivative_summary.iter().find(|row| row.name == name).unwrap();
    println!("{name}: {:.4} ({:.4} to {:.4}), scatter {:.4}", row.mean, row.minimum, row.maximum, row.scatter);
    [row.mean, row.minimum, row.maximum]
}

/// R2 of the validation manoeuvres with each one's own constant.
fn r_squared(results: &Results, coefficient: &str) -> f64 {
    agreement(results, coefficient).r_squared_own_constant
}

fn agreement(results: &Results, coefficient: &str) -> PredictionAgreement {
    let row = results.validation.iter().find(|row| row.coefficient == coefficient).unwrap();
    let PredictionAgreement { r_squared_identified_constants: identified, r_squared_own_constant: own, .. } =
        row.agreement;
    println!("{coefficient}: R2 {identified:.3}, with the manoeuvre's own constant {own:.3}");
    row.agreement
}

#[test]
fn the_shipped_flight_treated_as_in_the_thesis_shows_some_of_its_weaknesses_and_an_early_clock_the_others() {
    let session = treated();
    assert_eq!(session.flights[0].signals.preset(), Some(SignalPreset::Thesis));
    assert!(session.flights[0].instruments.as_ref().unwrap().thesis_controls);
    let found = results(&session);
    // Truth: Cl_p -0.45, Cl_delta_a -0.172, Cm_q -5.15, CY_p -0.08, Cn_p -0.1.
    let [damping, least, greatest] = estimates(&found, "Cl_p");
    assert!((-0.446..-0.42).contains(&damping) && least > -0.48 && greatest > -0.42);
    let [aileron, ..] = estimates(&found, "Cl_delta_a");
    assert!((aileron / -0.172 - 1.0).abs() < 0.03, "{aileron}");
    let [pitch, ..] = estimates(&found, "Cm_q");
    assert!((pitch / -5.15 - 1.0).abs() < 0.05, "{pitch}");
    let [_, least, greatest] = estimates(&found, "CY_p");
    assert!(least < -0.2 && greatest > 0.1, "CY_p changes its sign from manoeuvre to manoeuvre");
    let summary = |name: &str| found.derivative_summary.iter().find(|row| row.name == name).unwrap();
    for name in ["Cl_p", "CY_p", "Cn_p", "Cn_beta"] {
        let understated = summary(name).scatter / summary(name).mean_variance.sqrt();
        println!("{name}: scatter over the standard error for white residuals {understated:.1}");
        assert!((4.0..20.0).contains(&understated), "{name}: {understated}");
    }
    for (coefficient, at_least) in [("CX", 0.90), ("CY", 0.99), ("CZ", 0.95), ("Cl", 0.99), ("Cm", 0.95), ("Cn", 0.98)]
    {
        assert!(r_squared(&found, coefficient) > at_least, "{coefficient}");
    }
    // Mean parameters and constants, as thesis 7.1: what the manoeuvre's own constant hides of CX.
    assert!(agreement(&found, "CX").r_squared_identified_constants < 0.0);
    let pitch = agreement(&found, "Cm");
    assert!(pitch.r_squared_identified_constants < 0.9 && pitch.r_squared_own_constant > 0.95);

    let mut early = session;
    early.estimation.predict_with = PredictionParameters::Pooled;
    let clock = early.flights[0].clocks.iter_mut().find(|clock| clock.source == "sensor_*").unwrap();
    clock.shift_s = -0.2;
    let found = results(&early);
    let [damping, _, greatest] = estimates(&found, "Cl_p");
    assert!(damping > -0.32 && greatest > -0.15, "{damping}");
    let [aileron, ..] = estimates(&found, "Cl_delta_a");
    assert!((-0.11..-0.08).contains(&aileron), "{aileron}");
    let [pitch, _, greatest] = estimates(&found, "Cm_q");
    assert!(pitch > -1.0 && greatest > 0.0, "{pitch}");
    assert!(r_squared(&found, "Cl") < 0.87 && r_squared(&found, "Cm") < 0.85 && r_squared(&found, "CY") > 0.97);
}
