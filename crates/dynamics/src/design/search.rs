//! The search for the best inputs within limits.

use super::DesignError;
use super::excursion::{Excursion, Limits, excursions};
use super::fly::{Disturbance, FlownInput, Plant, fly};
use super::plan::{DesignKind, PlannedManoeuvre, Recipe};
use super::predict::{Basis, Prediction, window_variables};
use super::shape::BaseTimes;
use super::signal::{CONTROLS, THROTTLE};
use crate::linear::{Method, Trim, linearise_at};
use crate::modes::modes;

/// What is made as small as the limits allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Criterion {
    /// Determinant of the covariance of the derivatives, each over its magnitude: the logarithm, coefficient by coefficient.
    D,
    /// Sum of the squares of the relative errors.
    A,
    /// Largest relative error.
    MaxRelative,
}

impl Criterion {
    doublet_core::named_variants! {
        /// Name.
        pub name: D "d", A "a", MaxRelative "max-relative"
    }

    /// What a prediction costs: comparable between criteria by neither size nor sign, smaller is better. A derivative that is not excited
    /// costs alike in every design that does not excite it.
    pub fn cost(self, prediction: &Prediction) -> f64 {
        /// Relative error that stands for a derivative which is not told at all.
        const UNTOLD: f64 = 1e3;
        let errors = prediction.relative_errors().map(|error| error.min(UNTOLD));
        match self {
            Self::D if prediction.log_determinant.is_finite() => prediction.log_determinant,
            // What cannot be told has no determinant: the product of the errors takes its place.
            Self::D => errors.map(|error| 2.0 * error.ln()).sum::<f64>() + UNTOLD,
            Self::A => errors.map(|error| error * error).sum(),
            Self::MaxRelative => errors.fold(0.0, f64::max),
        }
    }
}

/// What is to be designed.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Controls to move: 0 aileron, 1 elevator, 2 rudder, 3 throttle.
    pub surfaces: Vec<usize>,
    /// Time of all windows together, s.
    pub time_s: f64,
    /// Kind.
    pub kind: DesignKind,
    /// What is made small.
    pub criterion: Criterion,
    /// Rounds of the search over the free parameters; zero for shapes as published.
    pub rounds: usize,
    /// Draws of the derivatives over which the search takes the mean cost, beside the estimate itself.
    pub search_samples: usize,
    /// Draws of the derivatives, each with gusts and a start of its own, that say how far the aircraft goes and how errors scatter.
    pub samples: usize,
    /// Part of the room between trim and limits that the undisturbed flight may take.
    pub usage: f64,
    /// Seed of the draws.
    pub seed: u64,
    /// Whether the windows flown so far count.
    pub with_flown: bool,
}

impl Request {
    /// Usual part of the room between trim and limits that the undisturbed flight may take.
    pub const USUAL_USAGE: f64 = 0.9;

    /// A shape as published, without draws, for small relative errors.
    pub fn published(surfaces: Vec<usize>, kind: DesignKind, time_s: f64) -> Self {
        Self {
            surfaces,
            time_s,
            kind,
            criterion: Criterion::A,
            rounds: 0,
            search_samples: 0,
            samples: 0,
            usage: Self::USUAL_USAGE,
            seed: 1,
            with_flown: false,
        }
    }
}

/// A design and what it promises.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "names say it")]
pub struct Designed {
    pub kind: DesignKind,
    pub manoeuvres: Vec<PlannedManoeuvre>,
    /// The trim they begin in.
    pub plant: Plant,
    /// Their flight without disturbance.
    pub flown: Vec<FlownInput>,
    /// What they will say.
    pub prediction: Prediction,
    /// Of each derivative the corrected error that 95 % of the draws stay below; none where a draw has none.
    pub high_errors: Vec<Option<f64>>,
    /// How far the aircraft goes.
    pub excursions: Vec<Excursion>,
    /// Cost by every criterion.
    pub costs: [f64; 3],
    /// Draws without a trim or whose flight ended.
    pub failed_samples: usize,
    /// Band of the modes that the surfaces excite, as a multisine covers it, Hz.
    pub band_hz: [f64; 2],
}

/// Designs inputs of one kind: amplitudes as large as limits, peaks and rates allow, the other free parameters by a pattern search over the
/// mean cost of the estimate and of draws of the derivatives.
pub fn design(basis: &Basis, request: &Request) -> Result<Designed, DesignError> {
    let plant = Plant::new(basis.model.model.clone(), &basis.condition)?;
    check_room(&basis.limits, &plant.trim)?;
    check_thrust(&plant, &request.surfaces)?;
    let linear = linearise_at(&plant.model, &plant.trim, Method::Analytic)?;
    let draws = basis.model.samples(request.search_samples + request.samples, request.seed);
    let plants: Vec<Option<Plant>> =
        draws.iter().map(|draw| Plant::new(basis.model.with_values(draw), &basis.condition).ok()).collect();
    let (searched, sampled) = plants.split_at(request.search_samples);
    let mut recipe = Recipe {
        kind: request.kind,
        surfaces: request.surfaces.clone(),
        time_s: request.time_s,
        base: BaseTimes::from_modes(&modes(&linear.motion())),
        rates: basis.limits.rates,
        step_s: basis.step_s.min(0.02),
        parameters: vec![0.0; request.kind.parameters() * request.surfaces.len()],
    };
    let search = Search { basis, request, plant: &plant, others: searched.iter().flatten().collect() };
    let mut best = search.cost(&recipe)?;
    search.improve(&mut recipe, &mut best);
    let manoeuvres = search.manoeuvres(&recipe)?;
    let flown = fly_all(&plant, &manoeuvres, basis.step_s)?;
    let prediction = predict(basis, &plant, &manoeuvres, &flown, request.with_flown)?;
    let mut disturbed = Vec::new();
    let mut predictions = Vec::new();
    for (index, other) in sampled.iter().enumerate() {
        let Some(other) = other else { continue };
        if let Ok(flights) = fly_disturbed(basis, other, &manoeuvres, index, request.seed) {
            disturbed.push(flights);
        }
        let calm = fly_all(other, &manoeuvres, basis.step_s);
        if let Ok(found) = calm.and_then(|calm| predict(basis, other, &manoeuvres, &calm, request.with_flown)) {
            predictions.push(found);
        }
    }
    Ok(Designed {
        kind: request.kind,
        excursions: excursions(&flown, &disturbed, &plant.trim),
        high_errors: high_errors(&prediction, &predictions),
        band_hz: recipe.band_hz(),
        costs: Criterion::ALL.map(|criterion| criterion.cost(&prediction)),
        failed_samples: request.samples - disturbed.len().min(request.samples),
        manoeuvres,
        plant,
        flown,
        prediction,
    })
}

/// Refuses limits that the trim itself touches.
fn check_room(limits: &Limits, trim: &Trim) -> Result<(), DesignError> {
    let closed = limits.motion.iter().find(|limit| {
        let about = limit.quantity.at_trim(trim);
        about >= limit.high || about <= limit.low
    });
    match closed {
        Some(limit) => Err(DesignError::NoRoom {
            quantity: limit.quantity.name(),
            trim: limit.quantity.at_trim(trim),
            low: limit.low,
            high: limit.high,
        }),
        None => Ok(()),
    }
}

/// Refuses an input by the throttle to a model without thrust.
fn check_thrust(plant: &Plant, controls: &[usize]) -> Result<(), DesignError> {
    if controls.contains(&THROTTLE) && !plant.model.has_thrust() { Err(DesignError::NoThrust) } else { Ok(()) }
}

/// Of each derivative the error that 95 % of the predictions stay below.
fn high_errors(prediction: &Prediction, samples: &[Prediction]) -> Vec<Option<f64>> {
    (0..prediction.derivatives.len()).map(|index| high_error(samples, index)).collect()
}

fn high_error(samples: &[Prediction], index: usize) -> Option<f64> {
    let all: Option<Vec<f64>> = samples.iter().map(|sample| sample.derivatives.get(index)?.corrected).collect();
    let mut all = all.filter(|all| !all.is_empty())?;
    all.sort_by(f64::total_cmp);
    all.get(((all.len() as f64 * 0.95).ceil() as usize).saturating_sub(1)).copied()
}

/// Flies every manoeuvre from the trim.
fn fly_all(plant: &Plant, manoeuvres: &[PlannedManoeuvre], step_s: f64) -> Result<Vec<FlownInput>, DesignError> {
    let mut flights: Vec<FlownInput> = Vec::with_capacity(manoeuvres.len());
    for (index, manoeuvre) in manoeuvres.iter().enumerate() {
        // The same manoeuvre is the same flight.
        let before = manoeuvres[..index].iter().position(|other| other == manoeuvre);
        let flight = match before.and_then(|before| flights.get(before)) {
            Some(flight) => flight.clone(),
            None => fly(plant, &manoeuvre.input, (manoeuvre.duration_s, step_s), None)?,
        };
        flights.push(flight);
    }
    Ok(flights)
}

/// Flies every manoeuvre with gusts from a start of its own, of those that windows flown had.
fn fly_disturbed(
    basis: &Basis,
    plant: &Plant,
    manoeuvres: &[PlannedManoeuvre],
    draw: usize,
    seed: u64,
) -> Result<Vec<FlownInput>, DesignError> {
    let flight = |(window, manoeuvre): (usize, &PlannedManoeuvre)| {
        let number = draw * manoeuvres.len() + window;
        let mut start = basis.starts.get(number % basis.starts.len().max(1)).copied().unwrap_or_default();
        // The thrust tells whether a path was steady or the swing of a phugoid; where it is not known, each in half of the draws.
        let is_told = start.thrust_n.is_some();
        let steady = !is_told && draw.is_multiple_of(2) && plant.trim.condition.gamma_rad.is_some();
        if !steady {
            start.state[7] += start.path_rad;
        }
        let disturbance = Disturbance { start, gust_m_s: basis.gust_m_s, seed: seed.wrapping_add(number as u64 + 1) };
        let span = (manoeuvre.duration_s, basis.step_s);
        fly(&plant.at(&start, steady)?, &manoeuvre.input, span, Some(&disturbance))
    };
    manoeuvres.iter().enumerate().map(flight).collect()
}

/// What flown manoeuvres say.
fn predict(
    basis: &Basis,
    plant: &Plant,
    manoeuvres: &[PlannedManoeuvre],
    flown: &[FlownInput],
    with_flown: bool,
) -> Result<Prediction, DesignError> {
    let variables =
        flown.iter().map(|flown| window_variables(flown, plant, &basis.settings)).collect::<Result<Vec<_>, _>>()?;
    let windows: Vec<_> = manoeuvres.iter().zip(&variables).collect();
    basis.predict(&windows, with_flown)
}

struct Search<'a> {
    basis: &'a Basis,
    request: &'a Request,
    plant: &'a Plant,
    others: Vec<&'a Plant>,
}

impl Search<'_> {
    /// The manoeuvres of a recipe with the largest amplitudes that are allowed.
    fn manoeuvres(&self, recipe: &Recipe) -> Result<Vec<PlannedManoeuvre>, DesignError> {
        let peaks = self.basis.limits.peaks;
        let mut amplitudes = [0.0; CONTROLS];
        for group in recipe.groups() {
            let factor = self.largest_factor(recipe, &group)?;
            group.iter().for_each(|&surface| amplitudes[surface] = factor * peaks[surface]);
        }
        recipe.manoeuvres(amplitudes)
    }

    /// The largest part of the peaks at which the manoeuvres of a group stay within the limits.
    fn largest_factor(&self, recipe: &Recipe, group: &[usize]) -> Result<f64, DesignError> {
        /// Closeness to the wanted usage at which the search ends, and the most flights it takes.
        const CLOSE: f64 = 0.02;
        const FLIGHTS: usize = 14;
        let limits = &self.basis.limits;
        let wanted = self.request.usage;
        let mut factor = 0.3;
        for _ in 0..FLIGHTS {
            let mut amplitudes = [0.0; CONTROLS];
            group.iter().for_each(|&surface| amplitudes[surface] = factor * limits.peaks[surface]);
            let mut manoeuvres = recipe.manoeuvres(amplitudes)?;
            manoeuvres.retain(|manoeuvre| manoeuvre.surfaces == group);
            // The first of each sign says it all.
            manoeuvres.truncate(2);
            let flights = fly_all(self.plant, &manoeuvres, self.basis.step_s);
            let usage = match &flights {
                Ok(flights) => flights.iter().map(|f| limits.usage(f, &self.plant.trim)).fold(0.0, f64::max),
                Err(DesignError::Departed { .. }) => f64::INFINITY,
                Err(error) => return Err(error.clone()),
            };
            if usage <= wanted && (factor >= 1.0 || usage > wanted * (1.0 - CLOSE)) {
                return Ok(factor);
            }
            factor = (factor * (wanted * (1.0 - 0.5 * CLOSE) / usage.max(1e-9)).clamp(0.1, 5.0)).min(1.0);
        }
        // No amplitude was met to the last part: the last one is too large by little at most.
        Ok(0.9 * factor)
    }

    /// Mean cost of a recipe over the estimate and the draws.
    fn cost(&self, recipe: &Recipe) -> Result<f64, DesignError> {
        let manoeuvres = self.manoeuvres(recipe)?;
        let mut sum = 0.0;
        for (index, plant) in std::iter::once(self.plant).chain(self.others.iter().copied()).enumerate() {
            let cost = fly_all(plant, &manoeuvres, self.basis.step_s)
                .and_then(|flown| predict(self.basis, plant, &manoeuvres, &flown, self.request.with_flown))
                .map(|prediction| self.request.criterion.cost(&prediction));
            match cost {
                Ok(cost) => sum += cost,
                Err(error) if index == 0 => return Err(error),
                // A draw that departs makes the design worse than any that does not.
                Err(_) => return Ok(f64::INFINITY),
            }
        }
        Ok(sum / (1 + self.others.len()) as f64)
    }

    /// Moves one parameter at a time, keeps what lowers the cost, and halves the move when nothing does.
    fn improve(&self, recipe: &mut Recipe, best: &mut f64) {
        /// First move, in natural logarithms or exponents.
        const FIRST: f64 = 0.4;
        /// Bounds of the parameters, which keep shapes recognisable.
        const BOUND: f64 = 1.2;
        let mut step = FIRST;
        for _ in 0..self.request.rounds {
            let mut improved = false;
            for index in 0..recipe.parameters.len() {
                for direction in [step, -step] {
                    let kept = recipe.parameters[index];
                    recipe.parameters[index] = (kept + direction).clamp(-BOUND, BOUND);
                    match self.cost(recipe) {
                        Ok(cost) if cost < *best => {
                            *best = cost;
                            improved = true;
                            break;
                        }
                        _ => recipe.parameters[index] = kept,
                    }
                }
            }
            if !improved {
                step *= 0.5;
            }
        }
    }
}

/// One manoeuvre more: what it would cost and what it would leave.
#[derive(Clone, Debug)]
pub struct NextManoeuvre {
    /// Manoeuvre.
    pub manoeuvre: PlannedManoeuvre,
    /// What flown windows and it say together.
    pub prediction: Prediction,
    /// Cost of both together.
    pub cost: f64,
}

/// Single manoeuvres that could be flown next, each beside the windows flown so far, best first: doublets, 3-2-1-1 and multisines of
/// `time_s` on each surface, and multisines on all of them at once.
///
/// `goes_on` is asked before each of them.
///
/// # Errors
/// [`DesignError::Linear`] without a trim, [`DesignError::Stopped`]; candidates that cannot be flown are left out.
pub fn next_manoeuvres(
    basis: &Basis,
    request: &Request,
    goes_on: &dyn Fn() -> bool,
) -> Result<Vec<NextManoeuvre>, DesignError> {
    let plant = Plant::new(basis.model.model.clone(), &basis.condition)?;
    check_room(&basis.limits, &plant.trim)?;
    check_thrust(&plant, &request.surfaces)?;
    let linear = linearise_at(&plant.model, &plant.trim, Method::Analytic)?;
    let base = BaseTimes::from_modes(&modes(&linear.motion()));
    let search = Search { basis, request, plant: &plant, others: Vec::new() };
    let mut candidates: Vec<(DesignKind, Vec<usize>)> = Vec::new();
    for &surface in &request.surfaces {
        for kind in [DesignKind::Doublet, DesignKind::ThreeTwoOneOne, DesignKind::Multisine] {
            candidates.push((kind, vec![surface]));
        }
    }
    if request.surfaces.len() > 1 {
        candidates.push((DesignKind::Multisine, request.surfaces.clone()));
    }
    let mut found = Vec::new();
    for (kind, surfaces) in candidates {
        if !goes_on() {
            return Err(DesignError::Stopped);
        }
        let parameters = vec![0.0; kind.parameters() * surfaces.len()];
        let (rates, step_s) = (basis.limits.rates, basis.step_s.min(0.02));
        let recipe = Recipe { kind, surfaces, time_s: request.time_s, base, rates, step_s, parameters };
        let Ok(mut manoeuvres) = search.manoeuvres(&recipe) else { continue };
        manoeuvres.truncate(1);
        let flown = fly_all(&plant, &manoeuvres, basis.step_s)?;
        let prediction = predict(basis, &plant, &manoeuvres, &flown, true)?;
        let cost = request.criterion.cost(&prediction);
        found.extend(manoeuvres.pop().map(|manoeuvre| NextManoeuvre { manoeuvre, prediction, cost }));
    }
    found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    Ok(found)
}
