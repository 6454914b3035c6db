//! Whether intervals of natural modes hold those of the truth: many flights of one scenario, the truth linearised at each one's trim.

use doublet_core::model::Derivatives;
use doublet_core::simulate::Scenario;
use doublet_dynamics::linear::{FlightModel, Method, linearise};
use doublet_dynamics::modes::{Figure, FigureInterval, ModeEstimate, mode_study, modes};
use doublet_dynamics::propagate::Interval;
use rayon::prelude::*;

use super::coverage::{Realisation, flown_aircraft, fly, windows};
use super::dynamics::{Flown, pooled_model};
use crate::graph::{Context, StageResult};
use crate::session::Session;
use crate::stage::AircraftData;

/// Draws of the derivatives of each flight.
const SAMPLES: usize = 400;

/// One figure of one mode over all realisations.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureCoverage {
    pub mode: &'static str,
    pub figure: Figure,
    /// Mean of the truth's values at the trims.
    pub truth: f64,
    /// Standard deviation of estimate less truth.
    pub scatter: f64,
    /// Mean of estimate less truth over that scatter.
    pub bias: f64,
    /// Root mean square of the standard errors by slopes.
    pub standard_error: f64,
    /// Share of the 95 % intervals by slopes that hold the truth.
    pub delta: f64,
    /// Share of the sampled ones.
    pub sampled: f64,
    /// Flights in which both the truth and the estimate have the mode.
    pub flights: usize,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModeCoverage {
    /// Flights flown and identified.
    pub realisations: usize,
    pub manoeuvres: usize,
    /// Figures of the modes, fastest mode first.
    pub figures: Vec<FigureCoverage>,
}

/// A mode of one flight: its name, figures of the estimate and the truth's values of them.
type Found = (&'static str, Vec<(FigureInterval, f64)>);

/// Flies `scenario` once for each seed from `first_seed` on, identifies each flight with the settings of `session`, linearises both the
/// identified model and the truth at the median condition of its windows, and counts how often the intervals hold the truth.
pub fn mode_coverage(
    session: &Session,
    scenario: &Scenario,
    (realisations, first_seed): (usize, u64),
    context: &Context<'_>,
) -> StageResult<ModeCoverage> {
    let aircraft = flown_aircraft(session, scenario, context)?;
    let windows = windows(scenario);
    let context = context.parts(realisations);
    let one = |index: usize| -> StageResult<Vec<Found>> {
        context.checkpoint()?;
        let seed = first_seed + index as u64;
        let found = fly(session, scenario, &aircraft, &windows, seed, &context)
            .and_then(|flight| compare(session, scenario, &aircraft, &flight, seed));
        context.step();
        found.map_err(|error| error.at(format!("seed {seed}")))
    };
    let found = (0..realisations).into_par_iter().map(one).collect::<StageResult<Vec<_>>>()?;
    let mut keys: Vec<(&'static str, Figure)> = Vec::new();
    for (name, figures) in found.iter().flatten() {
        for (interval, _) in figures {
            if !keys.contains(&(name, interval.figure)) {
                keys.push((name, interval.figure));
            }
        }
    }
    let rows = keys.into_iter().filter_map(|(mode, figure)| {
        let wanted_figure = |(name, figures): &Found| {
            let wanted = figures.iter().find(|(interval, _)| *name == mode && interval.figure == figure)?;
            (wanted.0.delta.is_some() && wanted.0.sampled.is_some()).then_some(*wanted)
        };
        let all: Vec<(FigureInterval, f64)> = found.iter().flatten().filter_map(wanted_figure).collect();
        (all.len() > 1).then(|| row(mode, figure, &all))
    });
    Ok(ModeCoverage { realisations, manoeuvres: windows.len(), figures: rows.collect() })
}

/// Modes of one flight beside the truth's at its trim.
fn compare(
    session: &Session,
    scenario: &Scenario,
    aircraft: &AircraftData,
    flight: &Realisation<'_>,
    seed: u64,
) -> StageResult<Vec<Found>> {
    let line = |error: doublet_dynamics::linear::LinearError| error.to_string();
    let flown = Flown::new(flight.aero.iter().map(|(_, aero)| &**aero));
    let model = pooled_model(&flight.pooled, (&session.structure, &session.estimation), &flight.aero, &mut Vec::new())?;
    let truth = scenario.vehicle.aero.derivatives().iter();
    let derivatives: Derivatives = truth.map(|d| (d.coefficient, d.term.clone(), d.value)).collect();
    let truth = FlightModel { derivatives, moment_reference: None, ..model.model.clone() };
    let engines = &aircraft.loaded.powerplant.engines;
    let condition = flown.level_condition(&truth, engines, session.filter.gravity_m_s2)?;
    let truth = modes(&linearise(&truth, &condition, Method::Analytic).map_err(line)?.motion());
    let study = mode_study(&model, &condition, SAMPLES, seed).map_err(line)?;
    let beside = |estimate: ModeEstimate| -> Option<Found> {
        let own = truth.iter().find(|mode| mode.name == estimate.mode.name)?;
        let figures = estimate.figures.into_iter();
        Some((own.name, figures.filter_map(|interval| Some((interval, interval.figure.value(own)?))).collect()))
    };
    Ok(study.modes.into_iter().filter_map(beside).collect())
}

fn row(mode: &'static str, figure: Figure, all: &[(FigureInterval, f64)]) -> FigureCoverage {
    let count = all.len() as f64;
    let mean = |value: &dyn Fn(&(FigureInterval, f64)) -> f64| all.iter().map(value).sum::<f64>() / count;
    let off = mean(&|(found, truth)| found.value - truth);
    let scatter = (mean(&|(found, truth)| (found.value - truth - off).powi(2)) * count / (count - 1.0)).sqrt();
    let holds = |of: &dyn Fn(&FigureInterval) -> Option<Interval>| {
        mean(&|(found, truth)| {
            let held = of(found).is_some_and(|interval| (interval.low..=interval.high).contains(truth));
            f64::from(u8::from(held))
        })
    };
    FigureCoverage {
        mode,
        figure,
        truth: mean(&|(_, truth)| *truth),
        scatter,
        bias: off / scatter,
        standard_error: mean(&|(found, _)| found.delta.map_or(0.0, |interval| interval.standard_error.powi(2))).sqrt(),
        delta: holds(&|found| found.delta),
        sampled: holds(&|found| found.sampled),
        flights: all.len(),
    }
}
