//! Settings that the measurements themselves propose: noise and delays. Nothing is applied.

use std::ops::ControlFlow;

use doublet_core::reconstruct::tuning::delay::{DelayEstimate, comparable, refine_delay};
use doublet_core::reconstruct::tuning::noise::{
    Likelihood, NoiseProgress, NoiseProposal, NoiseProposalError, NoiseProposalSettings, likelihood, propose_noise,
};
use doublet_core::reconstruct::{
    FilterData, FilterSettings, MEASUREMENTS, Measurement, ReconstructError, ValidSettings, lane_groups,
    reconstruct_many, without_outliers,
};
use rayon::prelude::*;

use crate::graph::{Control, StageResult};
use crate::stage::WindowPath;

/// Noise settings that make the measurements of these windows most likely; `progress` hears of every step.
pub fn tune_noise(
    paths: &[&WindowPath],
    settings: &FilterSettings,
    search: &NoiseProposalSettings,
    control: &Control,
    progress: &(dyn Fn(NoiseProgress) + Sync),
) -> StageResult<NoiseProposal> {
    if paths.is_empty() {
        return Err("no manoeuvre to estimate noise from: choose manoeuvres the filter can process".into());
    }
    let mut outliers = [0; MEASUREMENTS];
    let mut clean = Vec::new();
    for path in paths {
        let (data, found) = without_outliers(&path.data, &path.reconstruction, settings);
        clean.push(data);
        let counts = found.iter().zip(&path.reconstruction.outliers).map(|(found, before)| found + before.len());
        outliers.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
    }
    let groups = group(&clean);
    let mut evaluate = |settings: &ValidSettings| {
        let of_group = |group: &Vec<&FilterData>| likelihood(group, settings, &mut |_| go_on(control));
        let parts = groups.par_iter().map(of_group).collect::<Result<Vec<_>, NoiseProposalError>>()?;
        let mut sum = Likelihood::default();
        parts.iter().for_each(|part| sum.add(part));
        Ok(sum)
    };
    let mut step = |at| {
        progress(at);
        go_on(control)
    };
    Ok(propose_noise(settings, search, outliers, &mut evaluate, &mut step)?)
}

/// The common delay of some measurements that makes all measurements of these windows most likely, searched within `range_s`
/// of its present setting.
pub fn tune_delay(
    paths: &[&WindowPath],
    settings: &FilterSettings,
    measurements: &[Measurement],
    range_s: f64,
    control: &Control,
) -> StageResult<DelayEstimate> {
    let is_measured = |m: &Measurement| paths.iter().any(|path| !path.missing.contains(m));
    if let Some(missing) = measurements.iter().find(|m| !is_measured(m)) {
        return Err(
            format!("{} is not measured in any manoeuvre: its delay cannot be estimated", missing.name()).into()
        );
    }
    let settings = FilterSettings { smooth: false, ..settings.clone() };
    let whole: Vec<FilterData> =
        paths.iter().map(|path| comparable(&path.data, measurements, &settings, range_s)).collect();
    let groups = group(&whole);
    let mut evaluate = |settings: &ValidSettings| {
        let of_group = |group: &Vec<&FilterData>| -> Result<f64, ReconstructError> {
            let results = reconstruct_many(group, settings, &mut |_| go_on(control));
            results.into_iter().map(|result| Ok(result?.log_likelihood)).sum()
        };
        Ok(groups.par_iter().map(of_group).collect::<Result<Vec<_>, _>>()?.iter().sum())
    };
    Ok(refine_delay(&settings, measurements, range_s, &mut evaluate)?)
}

fn go_on(control: &Control) -> ControlFlow<()> {
    if control.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// Windows in groups that run side by side.
fn group(data: &[FilterData]) -> Vec<Vec<&FilterData>> {
    let all: Vec<&FilterData> = data.iter().collect();
    lane_groups(&all, rayon::current_num_threads())
        .into_iter()
        .map(|group| group.into_iter().map(|k| all[k]).collect())
        .collect()
}
