//! What a suspect cause changes of the derivatives: the fits with the path taken another way, with manoeuvres left out, with channels
//! and places corrected.

mod outlying;
mod variant;

use doublet_core::estimate::{Constraint, PooledFit, PooledRegression};
use doublet_core::model::{Coefficient, Structure, Term, Variable};
use doublet_core::statistics::squares_about_mean;
use rayon::prelude::*;

use super::judge::Evidence;
use super::{Level, accelerometer, propulsion};
use crate::graph::StageResult;
use crate::session::{PathSource, Session};
use crate::snapshot::{Cause, Consequence, Effect};
use crate::stage::{self, AeroWindow, Regression};
pub(super) use outlying::{OUTLYING_RATIO, Outlying};
use variant::Used;
pub(super) use variant::outside;

/// Most groups of manoeuvres that are left out in turn.
const GROUPS: usize = 24;
/// Part of the motion of a coefficient that a change must move to count at all, and to be bad.
pub(super) const LEAST_PART: f64 = 0.01;
const BAD_PART: f64 = 0.03;
/// Change of an estimate, in its corrected errors and as a part of it, that is a caution, and that is bad. Both must be exceeded.
pub(super) const CAUTION: (f64, f64) = (2.0, 0.1);
const BAD: (f64, f64) = (3.0, 0.2);

impl Consequence {
    /// Level of the change from `estimate`, whose corrected error is `error`, to that of `effect`.
    pub(super) fn level(&self, (estimate, error): (f64, f64), effect: &Effect) -> Level {
        let change = (effect.estimate - estimate).abs();
        let part = self.motion_ratio * change;
        // What the change is by chance, where fewer samples make the estimate less certain.
        let error = error * (effect.error_ratio.powi(2) - 1.0).max(1.0).sqrt();
        let exceeds = |(errors, of_value): (f64, f64)| change > (errors * error).max(of_value * estimate.abs());
        let level = if part > BAD_PART && exceeds(BAD) {
            Level::Bad
        } else if part > LEAST_PART && exceeds(CAUTION) {
            Level::Caution
        } else {
            Level::Good
        };
        level.min(effect.worst)
    }
}

/// Consequences for the derivatives of the pooled fit of one coefficient, by name.
#[derive(Clone, Debug)]
pub(super) struct Consequences {
    pub(super) coefficient: Coefficient,
    pub(super) derivatives: Vec<(String, Consequence)>,
    /// Manoeuvres that the model does not describe.
    pub(super) outlying: Vec<Outlying>,
}

impl Consequences {
    /// That of the derivative called `name`.
    pub(super) fn derivative(&self, name: &str) -> Option<&Consequence> {
        self.derivatives.iter().find(|(other, _)| other == name).map(|(_, consequence)| consequence)
    }
}

type Fitted = (Regression, PooledFit);

/// A cause, what it concerns, and the worst level its effect can give.
#[derive(Clone)]
struct Suspect {
    cause: Cause,
    of: Vec<String>,
    worst: Level,
}

impl Suspect {
    fn new(cause: Cause, of: Vec<String>) -> Self {
        Self { cause, of, worst: Level::Bad }
    }
}

/// Fits without a suspect cause.
struct Variant {
    suspect: Suspect,
    fits: Vec<Fitted>,
}

/// Consequences of every pooled fit; `suspects` are the manoeuvres with findings. None where the manoeuvres are too long together.
pub(super) fn consequences(evidence: Evidence<'_>, suspects: &[&str]) -> Vec<Consequences> {
    let snapshot = evidence.snapshot;
    let session = &snapshot.settle(evidence.session);
    let used: Vec<Used<'_>> = evidence.windows().filter_map(|window| Used::new(snapshot, window)).collect();
    if used.iter().map(|used| used.samples()).sum::<usize>() > stage::MOST_SAMPLES {
        return Vec::new();
    }
    let mut variants = Vec::new();
    let mut add = |suspect: Suspect, windows: Option<Vec<AeroWindow<'_>>>| {
        variants.extend(windows.map(|windows| Variant { suspect, fits: fits(session, &windows, &session.structure) }));
    };
    for (cause, source) in [(Cause::PathMeasured, PathSource::Measured), (Cause::PathFiltered, PathSource::Filtered)] {
        // A path as measured has no other.
        if session.preparation.path != source && session.preparation.path != PathSource::Measured {
            add(Suspect::new(cause, Vec::new()), variant::along(session, &used, source));
        }
    }
    let is_sound = |used: &&Used<'_>| !suspects.contains(&used.manoeuvre.name.as_str());
    if !suspects.is_empty() {
        let sound = used.iter().filter(is_sound).map(|used| used.as_computed()).collect();
        let names = suspects.iter().map(|&name| name.to_owned()).collect();
        add(Suspect::new(Cause::SuspectsLeftOut, names), Some(sound));
    }
    add(Suspect::new(Cause::SpoiltLeftOut, Vec::new()), variant::without_spoilt(evidence, &used));
    for (flight, slot) in &snapshot.physics {
        for row in slot.ready().into_iter().flat_map(|physics| physics.contradictions()) {
            let corrected = variant::corrected(session, &used, flight, row);
            let suspect = Suspect::new(Cause::Channel, vec![flight.clone(), row.channel.clone()]);
            add(Suspect { worst: row.level, ..suspect }, corrected);
        }
        if let Some(places_m) = accelerometer::found_and_taken_m(session, snapshot, flight) {
            let moved = variant::moved(session, &used, flight, places_m);
            add(Suspect::new(Cause::Accelerometer, vec![flight.clone()]), moved);
        }
    }
    let as_computed: Vec<AeroWindow<'_>> = used.iter().map(|used| used.as_computed()).collect();
    let with_airspeed = with_airspeed(&session.structure);
    // Thrust that nobody recorded leaves both models possible: neither shows that the other is wrong.
    let thrust = Suspect { worst: Level::Caution, ..Suspect::new(Cause::Thrust, Vec::new()) };
    variants.push(Variant { suspect: thrust, fits: fits(session, &as_computed, &with_airspeed) });
    fits(session, &as_computed, &session.structure)
        .par_iter()
        .map(|fitted| fit_consequences(fitted, &variants))
        .collect()
}

/// The models of the coefficients along the thrust, with a term of airspeed where they have none.
fn with_airspeed(structure: &Structure) -> Structure {
    let mut structure = structure.clone();
    structure.models.retain(|(coefficient, _)| propulsion::ALONG_THRUST.contains(coefficient));
    let airspeed = Term::product([(Variable::Airspeed, 1)]);
    for (_, terms) in &mut structure.models {
        if !terms.iter().any(|term| term.factors().iter().any(|(variable, _)| *variable == Variable::Airspeed)) {
            terms.push(airspeed.clone());
        }
    }
    structure
}

fn fits(session: &Session, windows: &[AeroWindow<'_>], structure: &Structure) -> Vec<Fitted> {
    let regressions = stage::pooled_regressions(windows, structure, &session.estimation);
    regressions.into_par_iter().filter_map(fit).collect()
}

fn fit(found: StageResult<Regression>) -> Option<Fitted> {
    let regression = found.ok()?;
    let fit = regression.pooled.fit().ok()?;
    Some((regression, fit))
}

fn fit_consequences(fitted: &Fitted, variants: &[Variant]) -> Consequences {
    let (regression, fit) = fitted;
    let same = |variant: &'_ Variant| -> Option<(Suspect, PooledFit)> {
        let (_, fit) = variant.fits.iter().find(|(other, _)| other.coefficient == regression.coefficient)?;
        Some((variant.suspect.clone(), fit.clone()))
    };
    let mut others: Vec<(Suspect, PooledFit)> = variants.iter().filter_map(same).collect();
    let pooled = &regression.pooled;
    let reduced = pooled.reduce().ok();
    let outlying = reduced.clone().map(|reduced| outlying::find_outlying(pooled, reduced, fit)).unwrap_or_default();
    // Triangles give the estimates and their unit covariance; a prior is weighed by the number of samples as well.
    let is_prior = |constraint: &Constraint| matches!(constraint, Constraint::Prior { .. });
    let small = reduced.filter(|_| !pooled.constraints.iter().any(is_prior));
    let pooled = small.as_ref().unwrap_or(pooled);
    others.extend(left_out(pooled));
    let names: Vec<String> = outlying.iter().map(|manoeuvre| manoeuvre.name.clone()).collect();
    others.extend(fit_without(pooled, Suspect::new(Cause::OutlyingLeftOut, names)));
    let derivatives = regression.pooled.shared().map(|name| (name.clone(), consequence(name, fitted, &others)));
    Consequences { coefficient: regression.coefficient, derivatives: derivatives.collect(), outlying }
}

/// The fit without each manoeuvre, or each group of them where there are many.
fn left_out(pooled: &PooledRegression) -> Vec<(Suspect, PooledFit)> {
    let count = pooled.windows.len();
    let groups = count.min(GROUPS);
    if groups < 2 {
        return Vec::new();
    }
    let names = |group: usize| pooled.windows.iter().skip(group).step_by(groups);
    let suspect =
        |group: usize| Suspect::new(Cause::LeftOut, names(group).map(|window| window.label.clone()).collect());
    (0..groups).into_par_iter().filter_map(|group| fit_without(pooled, suspect(group))).collect()
}

/// The fit without the manoeuvres of a suspect; none where there are none, or the others do not suffice.
fn fit_without(pooled: &PooledRegression, suspect: Suspect) -> Option<(Suspect, PooledFit)> {
    if suspect.of.is_empty() {
        return None;
    }
    let PooledRegression { names, per_window, constraints, windows } = pooled;
    let (names, per_window, constraints) = (names.clone(), per_window.clone(), constraints.clone());
    let windows = windows.iter().filter(|window| !suspect.of.contains(&window.label)).cloned().collect();
    let fit = PooledRegression { names, per_window, constraints, windows }.fit().ok()?;
    Some((suspect, fit))
}

fn consequence(name: &str, (regression, fit): &Fitted, others: &[(Suspect, PooledFit)]) -> Consequence {
    let at = |fit: &PooledFit| {
        let index = fit.fit.names.iter().position(|other| other == name)?;
        Some((fit.fit.estimates[index], fit.fit.unit_covariance[(index, index)].max(0.0).sqrt()))
    };
    let term = regression.pooled.names.iter().position(|other| other == name);
    let Some(((estimate, unit_error), term)) = at(fit).zip(term) else { return Consequence::default() };
    let (mut regressor, mut coefficient) = (0.0, 0.0);
    for window in &regression.pooled.windows {
        regressor += squares_about_mean(window.x.column(term).as_slice());
        coefficient += squares_about_mean(&window.z);
    }
    let motion_ratio = (regressor / coefficient).sqrt();
    let effect = |(Suspect { cause, of, worst }, fit): &(Suspect, PooledFit)| {
        let (estimate, error) = at(fit)?;
        let of = of.clone();
        Some(Effect { cause: *cause, of, estimate, error_ratio: error / unit_error, worst: *worst })
    };
    Consequence {
        share: motion_ratio * estimate.abs(),
        motion_ratio,
        effects: others.iter().filter_map(effect).collect(),
    }
}

#[cfg(test)]
mod tests {
    use doublet_core::estimate::PooledWindow;
    use nalgebra::DMatrix;

    use super::*;

    #[test]
    fn estimates_without_a_manoeuvre_are_those_of_all_its_samples() {
        let window = |index: usize| {
            let x =
                DMatrix::from_fn(90, 2, |k, term| if term == 0 { 1.0 } else { (0.2 * (k + 9 * index) as f64).sin() });
            let z = (0..90).map(|k| 2.0 * x[(k, 1)] + (0.3 * (k * k + index) as f64).cos()).collect();
            PooledWindow { label: index.to_string(), x, z }
        };
        let pooled = PooledRegression {
            names: vec!["C_0".to_owned(), "C_a".to_owned()],
            per_window: vec![true, false],
            constraints: Vec::new(),
            windows: (0..4).map(window).collect(),
        };
        let (whole, reduced) = (left_out(&pooled), left_out(&pooled.reduce().unwrap()));
        assert_eq!((whole.len(), reduced.len()), (4, 4));
        for ((of, a), (_, b)) in whole.iter().zip(&reduced) {
            let apart = a.fit.estimates.iter().zip(&b.fit.estimates).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) < 1e-12, "{:?}", of.of);
            assert!((&a.fit.unit_covariance - &b.fit.unit_covariance).amax() < 1e-12, "{:?}", of.of);
        }
    }

    #[test]
    fn a_cause_in_doubt_makes_no_derivative_bad() {
        let consequence = Consequence { share: 1.0, motion_ratio: 1.0, effects: Vec::new() };
        let effect = |worst| Effect { cause: Cause::Channel, of: Vec::new(), estimate: 2.0, error_ratio: 1.0, worst };
        let level = |worst| consequence.level((1.0, 0.01), &effect(worst));
        assert_eq!([Level::Bad, Level::Caution].map(level), [Level::Bad, Level::Caution]);
    }
}
