//! Whether what was flown is enough: errors after every window against goals, and the manoeuvre to fly next.

use doublet_core::hash_fields;
use doublet_dynamics::design::{Basis, DesignKind, ExpectedDerivative, Prediction, Request, next_manoeuvres};

use super::basis::{DesignOptions, basis_of};
use super::rows::names;
use crate::graph::{Context, Stage, StageResult};
use crate::session::{Manoeuvre, WindowRole};
use crate::snapshot::{DerivativeRow, Enough, NextRow, WindowInformation};
use crate::study::StudyInput;

/// A goal of one derivative.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// Derivative.
    pub name: String,
    /// Standard error to reach.
    pub standard_error: f64,
}

hash_fields!(Goal { name; standard_error });

/// What counts as enough of a session as it is edited; limits and noise as flown.
#[derive(Clone, Debug, PartialEq)]
pub struct EnoughRequest {
    /// Goals of single derivatives.
    pub goals: Vec<Goal>,
    /// Goal of all others: standard error over the magnitude of the estimate, per cent.
    pub relative_percent: f64,
    /// Surfaces the next manoeuvre may move: 0 aileron, 1 elevator, 2 rudder.
    pub surfaces: Vec<usize>,
    /// Its length, s.
    pub time_s: f64,
}

hash_fields!(EnoughRequest { goals, surfaces; relative_percent, time_s });

impl Default for EnoughRequest {
    /// Five per cent of every derivative, manoeuvres of 15 s on all surfaces.
    fn default() -> Self {
        Self { goals: Vec::new(), relative_percent: 5.0, surfaces: vec![0, 1, 2], time_s: 15.0 }
    }
}

impl EnoughRequest {
    fn options(&self) -> EnoughOptions {
        let next = Request::published(self.surfaces.clone(), DesignKind::Multisine, self.time_s);
        EnoughOptions { goals: self.goals.clone(), relative_percent: self.relative_percent, next }
    }
}

/// What counts as enough.
#[derive(Clone, Debug, PartialEq)]
pub struct EnoughOptions {
    /// Goals of single derivatives.
    pub goals: Vec<Goal>,
    /// Goal of all others: standard error over the magnitude of the estimate, per cent.
    pub relative_percent: f64,
    /// How the next manoeuvre is designed.
    pub next: Request,
}

/// What of the goals is met: errors over goals.
struct Standing {
    met: usize,
    worst: Option<(String, f64)>,
}

impl EnoughOptions {
    fn goal(&self, derivative: &ExpectedDerivative) -> f64 {
        let own = self.goals.iter().find(|goal| goal.name == derivative.name);
        own.map_or(0.01 * self.relative_percent * derivative.magnitude(), |goal| goal.standard_error)
    }

    fn standing(&self, prediction: &Prediction) -> Standing {
        let over = prediction.derivatives.iter().map(|derivative| {
            let error = derivative.corrected.unwrap_or(f64::INFINITY);
            (derivative.name.clone(), error / self.goal(derivative))
        });
        let over: Vec<(String, f64)> = over.collect();
        let met = over.iter().filter(|(_, ratio)| *ratio <= 1.0).count();
        Standing { met, worst: over.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)) }
    }
}

/// Goes through the identification windows of `windows` in their order: the errors that the windows up to each give together, in the noise that all of
/// them left; and what one manoeuvre more would make of them.
pub fn enough<'a>(
    windows: impl IntoIterator<Item = &'a Manoeuvre>,
    basis: &Basis,
    options: &EnoughOptions,
    goes_on: &dyn Fn() -> StageResult<()>,
) -> StageResult<Enough> {
    let line = |error: doublet_dynamics::design::DesignError| error.to_string();
    if let Some(goal) = options.goals.iter().find(|goal| !basis.model.names.contains(&goal.name)) {
        return Err(format!("no derivative of the model is called '{}'", goal.name).into());
    }
    let constant = constant_variances(&basis.predict(&[], true).map_err(line)?);
    let used = |name: &str| basis.coefficients.iter().any(|known| known.flown.iter().any(|own| own.label == name));
    let order = windows.into_iter().filter(|window| window.role == WindowRole::Identification && used(&window.name));
    let mut so_far: Vec<&str> = Vec::new();
    let mut time_s = 0.0;
    let mut known = Vec::new();
    let mut last = Prediction::default();
    let mut met_after: Vec<Option<String>> = Vec::new();
    for window in order {
        goes_on()?;
        so_far.push(&window.name);
        time_s += window.window.end_s - window.window.start_s;
        last = basis.of_windows(|label| so_far.contains(&label)).predict(&[], true).map_err(line)?;
        add_constant(&mut last, &constant);
        let standing = options.standing(&last);
        met_after.resize(last.derivatives.len(), None);
        for (derivative, after) in last.derivatives.iter().zip(&mut met_after) {
            let met = derivative.corrected.is_some_and(|error| error <= options.goal(derivative));
            // A goal that is lost again with a later window counts from when it is met for good.
            *after = if met { after.take().or_else(|| Some(window.name.clone())) } else { None };
        }
        known.push(WindowInformation {
            window: window.name.clone(),
            time_s,
            met: standing.met,
            worst: standing.worst.as_ref().map(|worst| worst.0.clone()),
            worst_over_goal: standing.worst.map(|worst| worst.1).filter(|ratio| ratio.is_finite()),
            corrected: last.derivatives.iter().map(|derivative| derivative.corrected).collect(),
        });
    }
    let standing = options.standing(&last);
    let derivatives = last.derivatives.iter().zip(met_after).map(|(derivative, met_after)| DerivativeRow {
        name: derivative.name.clone(),
        estimate: derivative.estimate,
        corrected: derivative.corrected,
        goal: options.goal(derivative),
        met: met_after.is_some(),
        met_after,
    });
    let of = last.derivatives.len();
    let is_enough = of > 0 && standing.met == of;
    let next = if is_enough { Vec::new() } else { next_rows(basis, options, &constant, goes_on)? };
    Ok(Enough { enough: is_enough, met: standing.met, of, derivatives: derivatives.collect(), windows: known, next })
}

impl Stage for Enough {
    type Params<'a> = &'a EnoughRequest;
    type Inputs<'a> = &'a StudyInput<'a>;
    type Output = Self;
    const NAME: &'static str = "enough";

    fn run(request: &EnoughRequest, input: &StudyInput<'_>, context: &Context<'_>) -> StageResult<Self> {
        let basis = basis_of(input, &DesignOptions::default(), context)?;
        context.checkpoint()?;
        let windows = input.windows.iter().map(|window| window.manoeuvre);
        enough(windows, &basis, &request.options(), &|| context.checkpoint())
    }
}

/// What the present error of each derivative holds beyond that of the noise in all windows: errors of the sensors and of the path, which no
/// further window makes smaller.
fn constant_variances(all: &Prediction) -> Vec<f64> {
    let variance = |derivative: &ExpectedDerivative| {
        let noise = derivative.corrected.unwrap_or(derivative.present);
        (derivative.present.powi(2) - noise.powi(2)).max(0.0)
    };
    all.derivatives.iter().map(variance).collect()
}

fn add_constant(prediction: &mut Prediction, variances: &[f64]) {
    for (derivative, variance) in prediction.derivatives.iter_mut().zip(variances) {
        derivative.corrected = derivative.corrected.map(|error| error.hypot(variance.sqrt()));
    }
}

/// Candidates, best first: by the worst error over its goal, then by the number of goals met.
fn next_rows(
    basis: &Basis,
    options: &EnoughOptions,
    constant: &[f64],
    goes_on: &dyn Fn() -> StageResult<()>,
) -> StageResult<Vec<NextRow>> {
    let found = next_manoeuvres(basis, &options.next, &|| goes_on().is_ok());
    goes_on()?;
    let found = found.map_err(|error| error.to_string())?;
    let mut rows: Vec<NextRow> = found
        .into_iter()
        .map(|mut next| {
            add_constant(&mut next.prediction, constant);
            let standing = options.standing(&next.prediction);
            let peaks = next.manoeuvre.input.peaks();
            NextRow {
                kind: next.manoeuvre.kind.name(),
                surfaces: names(&next.manoeuvre.surfaces),
                duration_s: next.manoeuvre.duration_s,
                met: standing.met,
                worst: standing.worst.as_ref().map(|worst| worst.0.clone()),
                worst_over_goal: standing.worst.map(|worst| worst.1).filter(|ratio| ratio.is_finite()),
                signal_peak_rad: next.manoeuvre.surfaces.iter().map(|&surface| peaks[surface]).collect(),
            }
        })
        .collect();
    rows.sort_by(|a, b| {
        let key = |row: &NextRow| row.worst_over_goal.unwrap_or(f64::INFINITY);
        key(a).total_cmp(&key(b)).then(b.met.cmp(&a.met))
    });
    Ok(rows)
}
