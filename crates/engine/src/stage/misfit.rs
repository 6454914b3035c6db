//! Where a fit fails: the band in which it expects its observations, and the channels that move with its residual.

use std::sync::Arc;

use doublet_core::model::{Coefficient, Structure, Term, regressors};
use doublet_core::prep::coherence;
use doublet_core::quantity::Role;
use doublet_core::series::{Channel, Recording, Series, TimeRange, gap_threshold_s, value_at};
use doublet_core::statistics::{NORMAL_95, median_step};
use doublet_core::validate::observation_deviation;
use nalgebra::DMatrix;

use super::aero::WindowAero;
use super::fit::{CoefficientFit, WindowFits, window_terms};
use crate::graph::StageResult;
use crate::session::Estimation;

/// Part of a manoeuvre on either side of the instant looked at, and the least of it, s.
const PART: f64 = 0.25;
const LEAST_S: f64 = 2.0;
/// Segments a part is divided into.
const SEGMENTS: usize = 4;
/// Steps longer than this many median ones end a part.
const UNEVEN: f64 = 1.5;

/// Where a residual is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MisfitPlace {
    pub coefficient: Coefficient,
    /// Instant, s.
    pub time_s: f64,
}

doublet_core::hash_fields!(MisfitPlace { coefficient; time_s });

/// The channels that move with a residual over a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Misfit {
    /// Coefficient and instant.
    pub place: MisfitPlace,
    /// Part about it.
    pub part: TimeRange,
    /// Deviation of the residual over the part, in units of the coefficient.
    pub residual_deviation: f64,
    /// Share that channels without relation to the residual exceed at 5 % of the frequencies.
    pub bound: f64,
    /// The channels, most coherent first.
    pub channels: Vec<CoherentChannel>,
}

/// A channel beside a residual.
#[derive(Clone, Debug, PartialEq)]
pub struct CoherentChannel {
    /// Name as recorded.
    pub name: String,
    /// Role, where the channel map gives one.
    pub role: Option<Role>,
    /// Unit of the channel, SI where it has a role.
    pub unit: String,
    /// Share of the power of the residual that follows the channel, 0 to 1.
    pub share: f64,
    /// Deviation of the channel over the part, in its unit.
    pub deviation: f64,
}

/// Regressors of a fit over the samples of its window, in the order of its parameters; none where they do not agree with it.
pub(super) fn own_regressors(
    found: &CoefficientFit,
    aero: &WindowAero,
    structure: &Structure,
    estimation: &Estimation,
) -> Option<DMatrix<f64>> {
    let fit = found.fit.as_ref().ok()?;
    let terms = structure.terms(found.coefficient)?;
    let (terms, _) = window_terms(found.coefficient, terms, aero, estimation);
    let find_term = |name: &String| terms.iter().find(|term| term.derivative_name(found.coefficient) == *name).cloned();
    let own: Vec<Term> = fit.names.iter().filter_map(find_term).collect();
    let x = regressors(&own, &aero.variables).ok().filter(|_| own.len() == fit.names.len())?;
    (x.nrows() == fit.samples()).then_some(x)
}

/// Half of the half width of the band that holds 95 % of the observations of each fit of a window, sample by sample: plots draw a band of
/// twice what they are given.
pub fn observation_bands(
    aero: &WindowAero,
    fits: &WindowFits,
    structure: &Structure,
    estimation: &Estimation,
) -> Vec<(Coefficient, Arc<[f64]>)> {
    let one = |found: &CoefficientFit| {
        let x = own_regressors(found, aero, structure, estimation)?;
        let deviation = observation_deviation(found.fit.as_ref().ok()?, &found.corrected_errors, &x);
        let half = deviation.iter().map(|deviation| 0.5 * NORMAL_95 * deviation);
        (!deviation.is_empty()).then(|| (found.coefficient, half.collect()))
    };
    fits.fits.iter().filter_map(one).collect()
}

/// Ranks the channels of a recording by how much of the power of a residual follows them over a quarter of the window on either side of
/// an instant, at least 2 s (see [`coherence`]). Channels that are constant, or missing in a part of the part, are left out.
pub fn misfit(recording: &Recording, fits: &WindowFits, place: MisfitPlace) -> StageResult<Misfit> {
    let found = fits.fits.iter().find(|fit| fit.coefficient == place.coefficient);
    let series = found.and_then(|fit| fit.series.as_ref());
    let residual = &series.ok_or("this coefficient has no residual")?.residual;
    let inside = about(residual, place.time_s).ok_or("the residual has no sample near this time")?;
    let (time_s, values) = (&residual.time_s[inside.clone()], &residual.values[inside]);
    let step_s = median_step(time_s).unwrap_or(f64::NAN);
    let length = 2 * (time_s.len() / (2 * SEGMENTS));
    let one = |(index, channel): (usize, &Channel)| {
        let beside = at(&channel.series, time_s)?;
        let deviation = deviation(&beside);
        let found = coherence(&beside, values, step_s, length)?;
        let role = recording.roles.iter().find(|(_, at)| **at == index).map(|(role, _)| *role);
        let is_constant = deviation <= 1e-12 * beside[0].abs();
        let coherent = CoherentChannel {
            name: channel.name.clone(),
            role,
            unit: channel.unit.clone(),
            share: found.share,
            deviation,
        };
        (!is_constant).then_some((coherent, found.bound))
    };
    let found: Vec<_> = recording.channels.iter().enumerate().filter_map(one).collect();
    let bound = found.first().map(|(_, bound)| *bound).ok_or("too few samples near this time for a coherence")?;
    let mut channels: Vec<_> = found.into_iter().map(|(channel, _)| channel).collect();
    channels.sort_by(|a, b| b.share.total_cmp(&a.share));
    let part = TimeRange::new(time_s[0], time_s[time_s.len() - 1]);
    Ok(Misfit { place, part, residual_deviation: deviation(values), bound, channels })
}

/// Samples about an instant without a gap between them.
fn about(residual: &Series, time_s: f64) -> Option<std::ops::Range<usize>> {
    let times = &residual.time_s;
    let (first, last) = (*times.first()?, *times.last()?);
    let half_s = (PART * (last - first)).max(LEAST_S);
    let longest_s = UNEVEN * median_step(times)?;
    let all = TimeRange::new(time_s - half_s, time_s + half_s).indices(times);
    if all.is_empty() {
        return None;
    }
    let middle = times.partition_point(|time| *time < time_s).clamp(all.start, all.end - 1);
    let is_next = |at: usize| times[at] - times[at - 1] <= longest_s && residual.values[at].is_finite();
    let start = (all.start + 1..=middle).rev().find(|&at| !is_next(at)).unwrap_or(all.start);
    let end = (middle + 1..all.end).find(|&at| !is_next(at)).unwrap_or(all.end);
    Some(start..end)
}

/// A channel at the samples of a residual, by straight lines between its own; none where it has a gap.
fn at(series: &Series, time_s: &[f64]) -> Option<Vec<f64>> {
    let gap_s = gap_threshold_s(&series.time_s);
    time_s.iter().map(|time_s| value_at(&series.time_s, &series.values, gap_s, *time_s)).collect()
}

fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}
