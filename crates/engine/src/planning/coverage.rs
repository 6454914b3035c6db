//! Whether a design keeps what it promises: many flights of it in the simulator.

use doublet_core::simulate::{Scenario, scenario};
use doublet_dynamics::design::{Quantity, Request, design};
use doublet_dynamics::linear::Trim;
use rayon::prelude::*;

use super::basis::{DesignOptions, FlownWindow, basis};
use super::files::{aircraft_name, design_scenario};
use super::rows::{DesignRow, design_row};
use crate::graph::{Context, StageResult};
use crate::report::{Table, TableOf};
use crate::session::{Manoeuvre, Session};
use crate::stage::pooled_fits;
use crate::study::dynamics::{Flown, pooled_model};
use crate::study::{estimates, flown_aircraft, fly, windows};

/// A derivative: what was promised and what came.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignedDerivative {
    pub name: String,
    /// Corrected error before flying.
    pub predicted: f64,
    /// Standard deviation of the estimates.
    pub scatter: f64,
    /// Root mean square of their errors corrected for the correlation inside windows.
    pub corrected: f64,
    pub truth: f64,
}

/// An excursion: what was promised and what came.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignedExcursion {
    /// Quantity.
    pub name: &'static str,
    /// Least and greatest value before flying.
    pub predicted: (f64, f64),
    /// Least and greatest value of all flights.
    pub flown: (f64, f64),
    /// Part of the flights that stay inside.
    pub inside: f64,
}

/// What many flights of a design gave.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignCoverage {
    pub kind: &'static str,
    /// Flights.
    pub realisations: usize,
    pub derivatives: Vec<DesignedDerivative>,
    pub excursions: Vec<DesignedExcursion>,
    /// Part of the flights in which all excursions hold.
    pub inside: f64,
    /// Largest scatter over the magnitude of its truth.
    pub worst_relative_error: f64,
    /// Correlations of regressors above 0.6.
    pub correlations: Vec<(String, String, f64)>,
}

/// Predicted errors over the scatter of the estimates, and excursions.
pub fn design_coverage_tables(found: &DesignCoverage) -> [Table; 2] {
    let derivatives = TableOf::new("designed_errors", "Predicted errors over the scatter.", &found.derivatives)
        .symbol("derivative", "derivative", |row| &row.name)
        .number("predicted", "predicted", "", 3, |row| row.predicted)
        .number("scatter", "scatter", "", 3, |row| row.scatter)
        .number("corrected", "corrected", "", 3, |row| row.corrected)
        .number("over_scatter", "over scatter", "", 3, |row| row.predicted / row.scatter)
        .number("over_corrected", "over corrected", "", 3, |row| row.predicted / row.corrected);
    let excursions = TableOf::new("designed_excursions", "Predicted and flown excursions.", &found.excursions)
        .text("excursion", "excursion", |row| row.name)
        .number("predicted_low", "predicted least", "", 3, |row| row.predicted.0)
        .number("predicted_high", "greatest", "", 3, |row| row.predicted.1)
        .number("flown_low", "flown least", "", 3, |row| row.flown.0)
        .number("flown_high", "greatest", "", 3, |row| row.flown.1)
        .number("inside_percent", "flights inside", "%", 3, |row| 100.0 * row.inside);
    [derivatives.done(), excursions.done()]
}

/// Least and greatest value of each quantity over the windows of a flight.
type Extremes = Vec<(f64, f64)>;

/// Flies `known` so many times, identifies these flights together with the settings of `session`, designs by `request` from that, flies the design once for each seed
/// behind `first_seed` with other gusts and noise each time, and identifies each flight by itself.
pub fn design_coverage(
    session: &Session,
    known: &Scenario,
    request: &Request,
    (known_flights, realisations, first_seed): (usize, usize, u64),
    context: &Context<'_>,
) -> StageResult<DesignCoverage> {
    let aircraft = flown_aircraft(session, known, context)?;
    // Windows of several flights stand side by side under names of their own.
    let of_flight = |flight: usize| -> Vec<Manoeuvre> {
        let mut own = windows(known);
        own.iter_mut().for_each(|window| window.name = format!("{} {}", flight + 1, window.name));
        own
    };
    let known_windows: Vec<Vec<Manoeuvre>> = (0..known_flights).map(of_flight).collect();
    let fly_known =
        |flight: usize| fly(session, known, &aircraft, &known_windows[flight], first_seed + flight as u64, context);
    let flights = (0..known_flights).into_par_iter().map(fly_known).collect::<StageResult<Vec<_>>>()?;
    let aero: Vec<_> = flights.iter().flat_map(|flight| flight.aero.iter().cloned()).collect();
    let paths: Vec<_> = flights.iter().flat_map(|flight| &flight.paths).collect();
    let pooled = pooled_fits(&aero, &session.structure, &session.estimation);
    let model = pooled_model(&pooled, (&session.structure, &session.estimation), &aero, &mut Vec::new())?;
    let flown = Flown::new(aero.iter().map(|(_, aero)| &**aero));
    let engines = &aircraft.loaded.powerplant.engines;
    let condition = flown.level_condition(&model.model, engines, session.filter.gravity_m_s2)?;
    let pairs: Vec<FlownWindow<'_>> =
        aero.iter().zip(&paths).map(|((window, aero), path)| ((*window, aero.clone()), *path)).collect();
    let basis = basis(session.settings(), &pairs, (&model, &condition), &DesignOptions::default())?;
    let designed = design(&basis, request).map_err(|error| error.to_string())?;
    let row = design_row(&basis, request, &designed);
    let file = design_scenario(&row, &designed, aircraft_name(session), Some(&known.loading))?;
    let next = scenario::parse(&file).map_err(|error| error.to_string())?;
    // Gusts and air of the day are those of the flight it was designed from.
    let next = Scenario { gust_m_s: known.gust_m_s, ..next };
    let next_windows = windows(&next);
    let context = context.parts(realisations);
    let one = |index: usize| {
        context.checkpoint()?;
        let seed = first_seed + (known_flights + index) as u64;
        let flight = fly(session, &next, &aircraft, &next_windows, seed, &context);
        let flight = flight.map_err(|error| error.at(format!("seed {seed}")))?;
        let extremes = extremes(&flight.flight, &next_windows, &designed.plant.trim);
        // A design predicts what the noise gives, not the scatter between windows.
        let found =
            estimates(&flight.pooled, |fit| &fit.noise_errors).map_err(|error| error.at(format!("seed {seed}")))?;
        context.step();
        Ok((found, extremes))
    };
    let flights = (0..realisations).into_par_iter().map(one).collect::<StageResult<Vec<_>>>()?;
    let derivatives = derivatives(&row, &flights, known);
    let stays = |flight: &Extremes, place: usize| {
        let (own, promised) = (flight[place], &row.excursions[place]);
        own.0 >= promised.low && own.1 <= promised.high
    };
    let share = |holds: &dyn Fn(&Extremes) -> bool| {
        flights.iter().filter(|flight| holds(&flight.1)).count() as f64 / flights.len() as f64
    };
    let excursions: Vec<DesignedExcursion> = row
        .excursions
        .iter()
        .enumerate()
        .map(|(place, promised)| DesignedExcursion {
            name: promised.name,
            predicted: (promised.low, promised.high),
            flown: flights
                .iter()
                .map(|flight| flight.1[place])
                .fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1))),
            inside: share(&|flight| stays(flight, place)),
        })
        .collect();
    Ok(DesignCoverage {
        kind: designed.kind.name(),
        realisations,
        inside: share(&|flight| (0..row.excursions.len()).all(|place| stays(flight, place))),
        worst_relative_error: derivatives.iter().map(|own| own.scatter / own.truth.abs()).fold(0.0, f64::max),
        correlations: row
            .correlations
            .iter()
            .filter(|own| own.correlation.abs() > 0.6)
            .map(|own| (own.first.clone(), own.second.clone(), own.correlation))
            .collect(),
        derivatives,
        excursions,
    })
}

/// What was promised for each derivative beside what the flights gave.
fn derivatives(
    row: &DesignRow,
    flights: &[(Vec<crate::study::Estimate>, Extremes)],
    known: &Scenario,
) -> Vec<DesignedDerivative> {
    row.predicted
        .iter()
        .filter_map(|own| {
            let estimate_and_error = |flight: &(Vec<crate::study::Estimate>, Extremes)| {
                flight.0.iter().find(|estimate| estimate.0 == own.name).map(|estimate| (estimate.1, estimate.3))
            };
            let all: Vec<(f64, f64)> = flights.iter().map(estimate_and_error).collect::<Option<_>>()?;
            let count = all.len() as f64;
            let mean = all.iter().map(|one| one.0).sum::<f64>() / count;
            Some(DesignedDerivative {
                name: own.name.clone(),
                predicted: own.corrected?,
                scatter: (all.iter().map(|one| (one.0 - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt(),
                corrected: (all.iter().map(|one| one.1 * one.1).sum::<f64>() / count).sqrt(),
                truth: known.vehicle.aero.value(&own.name)?,
            })
        })
        .collect()
}

/// Extremes of the true motion within the windows, in the order of [`Quantity::ALL`]; of the altitude what is gained or lost since the start of
/// each window, about that of the trim.
fn extremes(flight: &doublet_core::simulate::Flight, windows: &[Manoeuvre], trim: &Trim) -> Extremes {
    let truth = &flight.truth;
    Quantity::ALL
        .into_iter()
        .map(|quantity| {
            let (name, factor) = truth_column(quantity, trim.condition.gravity_m_s2);
            let values = truth.column(name).unwrap_or_default();
            let of_window = |own: &Manoeuvre| {
                let first = truth.time_s.partition_point(|time_s| *time_s < own.window.start_s);
                let last = truth.time_s.partition_point(|time_s| *time_s <= own.window.end_s);
                let values = values.get(first..last).unwrap_or_default();
                let start = values.first().map_or(0.0, |value| factor * f64::from(*value));
                let lift = if quantity == Quantity::Altitude { trim.condition.altitude_m - start } else { 0.0 };
                let ends = values.iter().map(|value| factor * f64::from(*value) + lift);
                ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
            };
            let each = windows.iter().map(of_window);
            each.fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)))
        })
        .collect()
}

/// Column of the truth that shows a quantity, and its factor.
fn truth_column(quantity: Quantity, gravity_m_s2: f64) -> (&'static str, f64) {
    match quantity {
        Quantity::Alpha => ("alpha", 1.0),
        Quantity::Beta => ("beta", 1.0),
        Quantity::LoadFactor => ("az", -1.0 / gravity_m_s2),
        Quantity::RollRate => ("p", 1.0),
        Quantity::Airspeed => ("airspeed", 1.0),
        Quantity::Altitude => ("z", -1.0),
        Quantity::Bank => ("phi", 1.0),
    }
}
