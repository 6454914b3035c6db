//! Derivatives against what they were computed with: both steps again with each quantity a little lower and higher.

use doublet_core::airframe::{Aircraft, Loading, MassProperties};
use doublet_core::estimate::Fit;
use doublet_core::sensitivity::{Estimate, Quantity, SensitivityTable, Step, TornadoBar, central, quantities, tornado};
use rayon::prelude::*;

use super::StudyInput;
use crate::graph::{Context, Footprint, Stage, StageError, StageResult};
use crate::session::WindowRole;
use crate::stage::{self, AeroWindow, AircraftData, StudyWindow, WindowAero};

/// Step of the central differences as a fraction of each quantity, of the reference chord for the centre of gravity (thesis 7.2).
pub const STEP_FRACTION: f64 = 0.05;

/// Pooled derivatives against every quantity.
#[derive(Clone, Debug, Default)]
pub struct SensitivityStudy {
    /// One table per quantity, in the order of the thesis.
    pub tables: Vec<SensitivityTable>,
    /// The same as bars, derivative by derivative, the widest first.
    pub tornado: Vec<TornadoBar>,
}

impl Footprint for SensitivityStudy {
    fn bytes(&self) -> usize {
        self.tables.iter().map(|table| table.partials.len() * 256).sum::<usize>() + 64
    }
}

/// Central differences of every pooled derivative over every quantity (thesis 7.2.1). Mass, centre of gravity and inertia go
/// through both steps: they move sensors, engines and moments. Deflections and air angles are scaled where they enter the model.
impl Stage for SensitivityStudy {
    type Params<'a> = ();
    type Inputs<'a> = &'a StudyInput<'a>;
    type Output = Self;
    const NAME: &'static str = "sensitivity";

    fn run((): (), input: &StudyInput<'_>, context: &Context<'_>) -> StageResult<Self> {
        let aircraft: &Aircraft = &input.aircraft.loaded.aircraft;
        let loading = mean_loading(input)?;
        let steps = quantities(aircraft, &loading, STEP_FRACTION);
        let nominal: Vec<Estimate> = input
            .pooled
            .fits
            .iter()
            .filter_map(|fit| Some(with_constant(fit.fit.as_ref().ok()?, &fit.corrected_errors)))
            .flatten()
            .collect();
        let context = context.parts(2 * steps.len());
        let table = |step: Step| {
            let side = |change: f64| estimate_changed(input, &loading, &step, change, &context);
            let (low, high) = (side(-step.half_width)?, side(step.half_width)?);
            Ok(central(step, &nominal, &low, &high))
        };
        let tables = steps.into_par_iter().map(table).collect::<StageResult<Vec<_>>>()?;
        Ok(SensitivityStudy { tornado: tornado(&tables), tables })
    }
}

fn estimate_changed(
    input: &StudyInput<'_>,
    loading: &Loading,
    step: &Step,
    change: f64,
    context: &Context<'_>,
) -> StageResult<Vec<Estimate>> {
    context.checkpoint()?;
    let windows = perturb(input, (&step.quantity, loading), change, context);
    let found = windows.and_then(|windows| estimates(input, &windows)).map_err(|error| {
        let Step { quantity, .. } = step;
        error.at(format!("with {} changed by {change:.4} {}", quantity.name(), quantity.unit()))
    })?;
    context.step();
    Ok(found)
}

/// What was on board on the average of the identification windows' middles: the loading a quantity's value and its step are of.
fn mean_loading(input: &StudyInput<'_>) -> StageResult<Loading> {
    let windows = input.windows.iter().filter(|window| window.manoeuvre.role == WindowRole::Identification);
    let at_middle =
        |window: &StudyWindow<'_>| window.aircraft.loading_at(&window.flight.recording, window.manoeuvre.middle_s());
    let loadings = windows.map(at_middle).collect::<Result<Vec<_>, _>>()?;
    let mut mean = input.aircraft.loading.clone();
    for (tank, fuel_kg) in mean.fuel_kg.iter_mut().filter(|_| !loadings.is_empty()) {
        let held = loadings.iter().filter_map(|loading| loading.fuel_kg.get(tank));
        *fuel_kg = held.sum::<f64>() / loadings.len() as f64;
    }
    Ok(mean)
}

/// All windows with one quantity changed, the change of mass properties being that of `loading`.
fn perturb<'a>(
    input: &StudyInput<'a>,
    (quantity, loading): (&Quantity, &Loading),
    change: f64,
    context: &Context<'_>,
) -> StageResult<Vec<AeroWindow<'a>>> {
    let aircraft = input.aircraft;
    match quantity.mass_change(&aircraft.loaded.aircraft, loading, change) {
        Some(mass) => recompute(input, mass, context),
        None => input
            .windows
            .iter()
            .map(|window| {
                let data = quantity.scaled(&window.aero.data, change);
                let aero = WindowAero::form(data, window.aero.settings.clone(), window.aero.air_density)?;
                Ok((window.manoeuvre, aero.into()))
            })
            .collect(),
    }
}

/// Both steps of all windows with `change` added to the mass properties. A path that does not change is not reconstructed again.
fn recompute<'a>(
    input: &StudyInput<'a>,
    change: MassProperties,
    context: &Context<'_>,
) -> StageResult<Vec<AeroWindow<'a>>> {
    let settings = input.settings;
    let aircraft: Vec<_> = input.windows.iter().map(|window| window.aircraft.with_mass_change(change)).collect();
    let mut changed = Vec::new();
    for (window, aircraft) in input.windows.iter().zip(&aircraft) {
        let recording = &window.flight.recording;
        let samples = stage::samples(recording, window.manoeuvre.samples(), Some(aircraft), settings.preparation)?;
        if samples.data != window.path.data {
            changed.push((window.manoeuvre.name.as_str(), samples.data));
        }
    }
    let data: Vec<_> = changed.iter().map(|(_, data)| &**data).collect();
    let reconstructions =
        stage::reconstructions(&data, (settings.filter, settings.preparation.path), context.control());
    let named = |error: &StageError, window: &StudyWindow<'_>| {
        error.clone().at(format!("manoeuvre '{}'", window.manoeuvre.name))
    };
    let form = |(window, aircraft): (&StudyWindow<'a>, &AircraftData)| -> StageResult<AeroWindow<'a>> {
        let place = changed.iter().position(|(name, _)| *name == window.manoeuvre.name);
        let path = match place {
            None => (&*window.path.data, &window.path.reconstruction),
            Some(index) => (&*changed[index].1, reconstructions[index].as_ref().map_err(|error| named(error, window))?),
        };
        let aircraft = (aircraft, &*window.manoeuvre.excluded);
        Ok((window.manoeuvre, stage::aero(&window.flight.recording, path, aircraft, settings.preparation)?.into()))
    };
    input.windows.iter().zip(&aircraft).map(|each| context.checkpoint().and_then(|()| form(each))).collect()
}

/// Pooled estimates of the derivatives all windows share.
fn estimates(input: &StudyInput<'_>, windows: &[AeroWindow<'_>]) -> StageResult<Vec<Estimate>> {
    let settings = input.settings;
    let mut found = Vec::new();
    for regression in stage::pooled_regressions(windows, settings.structure, settings.estimation) {
        let regression = regression?.pooled;
        // A coefficient that has no pooled estimate has none here either.
        let Ok(pooled) = regression.fit() else { continue };
        found.extend(with_constant(&pooled.fit, &pooled.fit.standard_errors));
    }
    Ok(found)
}

/// Estimates all windows share, behind the mean over the windows of the constants each has to itself (thesis Tables 7.2-7.12 have
/// one constant per coefficient).
fn with_constant(fit: &Fit, errors: &[f64]) -> Vec<Estimate> {
    let rows = fit.names.iter().zip(fit.estimates.iter()).zip(errors);
    let (own, shared): (Vec<_>, Vec<_>) = rows.partition(|((name, _), _)| name.ends_with(']'));
    let count = own.len() as f64;
    let mean = own.iter().map(|((_, value), _)| **value).sum::<f64>() / count;
    let error = own.iter().map(|(_, error)| *error * *error).sum::<f64>().sqrt() / count;
    let name = own.first().and_then(|((name, _), _)| name.split('[').next()).map(str::to_owned);
    let constant = name.map(|name| (name, mean, error));
    constant
        .into_iter()
        .chain(shared.into_iter().map(|((name, value), error)| (name.clone(), *value, *error)))
        .collect()
}
