//! Noise of the recording carried through both steps.

use doublet_core::reconstruct::FilterData;
use doublet_core::sensitivity::{NoiseEffect, noise_effects, with_noise};
use rayon::prelude::*;

use super::StudyInput;
use crate::graph::{Context, Footprint, Stage, StageError, StageResult};
use crate::session::WindowRole;
use crate::stage::{self, AeroWindow, StudyWindow};

/// Fresh noise to compute with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MonteCarloRequest {
    pub realisations: usize,
    /// Seed of their noise: the same seed gives the same numbers, whatever the number of threads.
    pub seed: u64,
}

impl Default for MonteCarloRequest {
    fn default() -> Self {
        Self { realisations: 200, seed: 1 }
    }
}

/// What noise of the recording does to the pooled derivatives.
#[derive(Clone, Debug, Default)]
pub struct MonteCarloStudy {
    /// What was asked for.
    pub request: MonteCarloRequest,
    /// Realisations a window or a fit of which failed; they do not count.
    pub failed: usize,
    /// One entry per pooled derivative all windows share.
    pub effects: Vec<NoiseEffect>,
}

impl Footprint for MonteCarloStudy {
    fn bytes(&self) -> usize {
        256 * self.effects.len() + 64
    }
}

/// Repeats both steps with fresh noise on every sample of every identification window, of the deviations the session's filter
/// states, and watches the pooled derivatives: their scatter is the error the noise causes, regressors included, and their
/// shift the pull of noisy regressors. Deflections, engines, air and loading are taken as they are: the session states no
/// deviation for them.
impl Stage for MonteCarloStudy {
    type Params<'a> = MonteCarloRequest;
    type Inputs<'a> = &'a StudyInput<'a>;
    type Output = Self;
    const NAME: &'static str = "Monte Carlo";

    fn run(request: MonteCarloRequest, input: &StudyInput<'_>, context: &Context<'_>) -> StageResult<Self> {
        let MonteCarloRequest { realisations, seed } = request;
        let nominal: Vec<(String, f64)> =
            input.derivatives().into_iter().map(|(name, value, _)| (name, value)).collect();
        let used: Vec<_> =
            input.windows.iter().filter(|window| window.manoeuvre.role == WindowRole::Identification).collect();
        let context = context.parts(realisations);
        let one = |realisation: usize| -> StageResult<Result<Vec<f64>, StageError>> {
            context.checkpoint()?;
            let found = estimates(input, &used, &nominal, (seed, realisation), &context);
            // A filter that was stopped fails: that is not the realisation's fault.
            context.checkpoint()?;
            context.step();
            Ok(found)
        };
        let found = (0..realisations).into_par_iter().map(one).collect::<StageResult<Vec<_>>>()?;
        let (values, errors): (Vec<_>, Vec<_>) = found.into_iter().partition(Result::is_ok);
        let values: Vec<Vec<f64>> = values.into_iter().flatten().collect();
        if values.is_empty()
            && let Some(error) = errors.iter().find_map(|error| error.as_ref().err())
        {
            return Err(StageError::Failed(format!("no realisation could be estimated: {error}")));
        }
        Ok(MonteCarloStudy { request, failed: errors.len(), effects: noise_effects(&nominal, &values) })
    }
}

/// Pooled estimates of one realisation, in the order of `nominal`.
fn estimates<'a>(
    input: &StudyInput<'a>,
    used: &[&StudyWindow<'a>],
    nominal: &[(String, f64)],
    (seed, realisation): (u64, usize),
    context: &Context<'_>,
) -> StageResult<Vec<f64>> {
    let settings = input.settings;
    let noisy = |(index, window): (usize, &&StudyWindow<'_>)| {
        with_noise(&window.path.data, settings.filter, seed, (realisation * used.len() + index) as u64)
    };
    let data: Vec<FilterData> = used.iter().enumerate().map(noisy).collect();
    let paths = stage::reconstructions(
        &data.iter().collect::<Vec<_>>(),
        (settings.filter, settings.preparation.path),
        context.control(),
    );
    let aero = |((window, data), path): ((&&StudyWindow<'a>, &FilterData), Result<_, StageError>)| {
        let path = path?;
        let nominal = (&*window.path.data, &window.path.reconstruction);
        let aero = stage::aero_along(&window.aero, nominal, (data, &path), settings.preparation)?;
        Ok((window.manoeuvre, aero.into()))
    };
    let windows: Vec<AeroWindow<'_>> = used.iter().zip(&data).zip(paths).map(aero).collect::<StageResult<_>>()?;
    let mut found = Vec::with_capacity(nominal.len());
    for regression in stage::pooled_regressions(&windows, settings.structure, settings.estimation) {
        let regression = regression?.pooled;
        if !regression.shared().any(|name| nominal.iter().any(|(other, _)| other == name)) {
            continue;
        }
        let fit = regression.fit()?.fit;
        found.extend(regression.shared().cloned().zip(fit.estimates));
    }
    let value = |(name, _): &(String, f64)| {
        let value = found.iter().find(|(other, _)| other == name).map(|(_, value)| *value);
        value.ok_or_else(|| format!("{name} has no estimate").into())
    };
    nominal.iter().map(value).collect()
}
