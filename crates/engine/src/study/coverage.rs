//! Whether intervals hold the truth as often as they say: many flights of one scenario, each through both steps.

use std::sync::Arc;

use doublet_core::airframe::Loading;
use doublet_core::reconstruct::Reconstruction;
use doublet_core::series::{Recording, TimeRange};
use doublet_core::simulate::{self, Flight, Scenario, Surface as Control};
use doublet_core::statistics::NORMAL_95;
use rayon::prelude::*;

use crate::graph::{Context, Keyed, StageResult};
use crate::session::{Manoeuvre, Session, Surface};
use crate::stage::{self, AeroWindow, AircraftData, CoefficientFit, PooledFits, tank_channel};

/// How far a window reaches beyond the held controls before the onset and after the free response, s.
const MARGIN_S: f64 = 0.2;

/// One derivative over all realisations.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivativeCoverage {
    pub name: String,
    pub truth: f64,
    /// Mean of the estimates.
    pub mean: f64,
    /// Standard deviation of the estimates.
    pub scatter: f64,
    /// Root mean square of the conventional standard errors.
    pub standard_error: f64,
    /// Root mean square of the corrected standard errors.
    pub corrected_error: f64,
    /// What the mean is off the truth, in standard deviations of the estimates: 0.4 of them take three of a hundred intervals of the
    /// right length off the truth.
    pub bias: f64,
    /// Share of the realisations whose conventional 95 % interval contains the true value.
    pub conventional: f64,
    /// Share of the realisations whose corrected 95 % interval contains the true value.
    pub corrected: f64,
}

/// Coverage of every derivative.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Flights flown and identified.
    pub realisations: usize,
    pub manoeuvres: usize,
    /// Derivatives in the order of the session's structure.
    pub derivatives: Vec<DerivativeCoverage>,
}

/// Estimate with its two standard errors.
pub(crate) type Estimate = (String, f64, f64, f64);

/// Flies `scenario` once for each seed from `first_seed` on, with other gusts, another hand on the controls and other noise each time,
/// identifies its manoeuvres together with the settings of `session`, and counts how often the truth lies within 1.96
/// standard errors. Instruments are those the session's filter describes ([`Flight::measured`]); loading and gravity are the scenario's.
pub fn coverage(
    session: &Session,
    scenario: &Scenario,
    (realisations, first_seed): (usize, u64),
    context: &Context<'_>,
) -> StageResult<Coverage> {
    let aircraft = flown_aircraft(session, scenario, context)?;
    let windows = windows(scenario);
    let context = context.parts(realisations);
    let one = |index: usize| -> StageResult<Vec<Estimate>> {
        context.checkpoint()?;
        let seed = first_seed + index as u64;
        let found = fly(session, scenario, &aircraft, &windows, seed, &context);
        let found = found.and_then(|flight| estimates(&flight.pooled, |fit| &fit.corrected_errors));
        let found = found.map_err(|error| error.at(format!("seed {seed}")))?;
        context.step();
        Ok(found)
    };
    let found = (0..realisations).into_par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
    Ok(summarise(scenario, windows.len(), &found))
}

/// What the estimates of all flights say of each derivative that every flight has.
pub(crate) fn summarise(scenario: &Scenario, manoeuvres: usize, found: &[Vec<Estimate>]) -> Coverage {
    let names = found.first().into_iter().flatten().map(|(name, ..)| name);
    let derivatives = names.filter_map(|name| {
        let index_in = |flight: &'_ Vec<Estimate>| flight.iter().position(|(own, ..)| own == name);
        let estimates = found.iter().map(|flight| index_in(flight).map(|at| &flight[at]));
        let estimates: Vec<&Estimate> = estimates.collect::<Option<_>>()?;
        Some(derivative(name, scenario.vehicle.aero.value(name)?, &estimates))
    });
    Coverage { realisations: found.len(), manoeuvres, derivatives: derivatives.collect() }
}

/// Windows over the manoeuvres of a scenario.
pub(crate) fn windows(scenario: &Scenario) -> Vec<Manoeuvre> {
    let flown = scenario.manoeuvres.iter().filter(|manoeuvre| !manoeuvre.spoilt).enumerate();
    flown.map(|(number, flown)| mark_input(number, flown, scenario)).collect()
}

fn mark_input(number: usize, flown: &simulate::Manoeuvre, scenario: &Scenario) -> Manoeuvre {
    if let Some(input) = &flown.designed {
        return designed_window(number, flown, input, scenario);
    }
    let name = format!("{:02} {} {}", number + 1, flown.surface.name(), flown.kind.name());
    let held = TimeRange { start_s: flown.held_from_s() - MARGIN_S, end_s: flown.held_to_s() + MARGIN_S };
    Manoeuvre {
        surface: Some(match flown.surface {
            Control::Aileron => Surface::Aileron,
            Control::Elevator => Surface::Elevator,
            Control::Rudder => Surface::Rudder,
        }),
        kind: flown.kind.name().to_owned(),
        ..Manoeuvre::new(name, scenario.name.to_owned(), held)
    }
}

/// Window over a designed input: from its onset for as long as it was designed for.
fn designed_window(
    number: usize,
    flown: &simulate::Manoeuvre,
    input: &simulate::DesignedInput,
    scenario: &Scenario,
) -> Manoeuvre {
    let window = TimeRange { start_s: flown.onset_s, end_s: flown.onset_s + input.held_s };
    let mut moved = input.surfaces();
    let surface = match (moved.next(), moved.next()) {
        (Some(Control::Aileron), None) => Some(Surface::Aileron),
        (Some(Control::Elevator), None) => Some(Surface::Elevator),
        (Some(Control::Rudder), None) => Some(Surface::Rudder),
        _ => None,
    };
    let place = format!("{:02} ", number + 1);
    // The inputs of a design have their number in their name.
    let name = if input.name.starts_with(&place) { input.name.clone() } else { place + &input.name };
    let kind = flown.kind.name().to_owned();
    Manoeuvre { surface, kind, ..Manoeuvre::new(name, scenario.name.to_owned(), window) }
}

/// A flight through both steps: its windows with their coefficients, and the pooled fits.
pub(crate) struct Realisation<'a> {
    pub flight: Flight,
    pub paths: Vec<Reconstruction>,
    /// Manoeuvres.
    pub aero: Vec<AeroWindow<'a>>,
    /// Fits of all of them together.
    pub pooled: PooledFits,
}

/// Flies a scenario and takes it through both steps.
pub(crate) fn fly<'a>(
    session: &Session,
    scenario: &Scenario,
    aircraft: &AircraftData,
    windows: &'a [Manoeuvre],
    seed: u64,
    context: &Context<'_>,
) -> StageResult<Realisation<'a>> {
    let fly = simulate::run(scenario, seed, &mut |_| !context.control().is_cancelled());
    context.checkpoint()?;
    let flight = fly?;
    let recording = record_flight(&flight, session, aircraft, seed);
    let data = windows
        .iter()
        .map(|window| Ok(stage::samples(&recording, window.samples(), Some(aircraft), &session.preparation)?.data))
        .collect::<StageResult<Vec<_>>>()?;
    let samples: Vec<_> = data.iter().map(|data| &**data).collect();
    let found = stage::estimate_delays_and_gusts(session, &samples, context.control())?;
    let filter = found.added_to(&session.filter);
    let by = (&filter, session.preparation.path);
    let paths = stage::reconstructions(&samples, by, context.control());
    let mut aero: Vec<AeroWindow<'_>> = Vec::with_capacity(windows.len());
    let mut kept = Vec::with_capacity(windows.len());
    for ((window, data), path) in windows.iter().zip(&data).zip(paths) {
        context.checkpoint()?;
        let path = path?;
        let formed = stage::aero(&recording, (data, &path), (aircraft, &window.excluded), &session.preparation)?;
        aero.push((window, Arc::new(formed)));
        kept.push(path);
    }
    let pooled = stage::pooled_fits(&aero, &session.structure, &session.estimation);
    Ok(Realisation { flight, paths: kept, aero, pooled })
}

/// Aircraft of a coverage study: that of the session with the scenario's loading.
pub(crate) fn flown_aircraft(
    session: &Session,
    scenario: &Scenario,
    context: &Context<'_>,
) -> StageResult<Keyed<AircraftData>> {
    let loading = flown_loading(scenario);
    session.aircraft.as_deref().ok_or_else(|| stage::NO_AIRCRAFT.to_owned())?;
    context.get::<AircraftData>(Some(&loading), &stage::aircraft_of(context, session)?)
}

/// The loading of a scenario without fuel, which the tanks of its recording give.
pub(crate) fn flown_loading(scenario: &Scenario) -> Loading {
    Loading { fuel_kg: Default::default(), ..scenario.loading.clone() }
}

/// Estimates of one flight, with the errors that `errors` takes from each fit as their corrected ones.
pub(crate) fn estimates(pooled: &PooledFits, errors: fn(&CoefficientFit) -> &[f64]) -> StageResult<Vec<Estimate>> {
    let mut estimates = Vec::new();
    for fit in &pooled.fits {
        let (errors, found) = (errors(fit), fit.fit.as_ref().map_err(Clone::clone)?);
        for (index, name) in found.names.iter().enumerate().filter(|(_, name)| !name.ends_with(']')) {
            estimates.push((name.clone(), found.estimates[index], found.standard_errors[index], errors[index]));
        }
    }
    Ok(estimates)
}

/// The recording of a flight by instruments that are as the session's filter describes them.
pub(crate) fn record_flight(flight: &Flight, session: &Session, aircraft: &AircraftData, seed: u64) -> Recording {
    let sensors = aircraft.loaded.aircraft.sensors;
    let cg = flight.truth.loading_cg_at_start();
    flight.measured(&session.filter, sensors.accelerometer_from_datum_m.unwrap_or(cg), tank_channel, seed)
}

fn derivative(name: &str, truth: f64, estimates: &[&Estimate]) -> DerivativeCoverage {
    let count = estimates.len() as f64;
    let mean_of =
        |value: &dyn Fn(&Estimate) -> f64| estimates.iter().map(|estimate| value(estimate)).sum::<f64>() / count;
    let mean = mean_of(&|(_, estimate, ..)| *estimate);
    let holds = |error: &dyn Fn(&Estimate) -> f64| {
        mean_of(&|found| f64::from(u8::from((found.1 - truth).abs() <= NORMAL_95 * error(found))))
    };
    let scatter = (mean_of(&|(_, estimate, ..)| (estimate - mean).powi(2)) * count / (count - 1.0)).sqrt();
    DerivativeCoverage {
        name: name.to_owned(),
        truth,
        mean,
        scatter,
        bias: (mean - truth) / scatter,
        standard_error: mean_of(&|found| found.2.powi(2)).sqrt(),
        corrected_error: mean_of(&|found| found.3.powi(2)).sqrt(),
        conventional: holds(&|found| found.2),
        corrected: holds(&|found| found.3),
    }
}
