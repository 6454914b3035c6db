//! Measurements that neither noise nor a change of the flight explains: spikes and lost samples.
//!
//! A spike is a run of at most three samples of a measurement whose innovations lie on one side beyond a limit, and after which they
//! are back within a quarter of it. After a jump of the sensor they stay on that side. What follows a spike within two seconds, in any
//! measurement, may be its echo in the state: the largest is taken out first, and the filter runs again until none is left.

use std::sync::Arc;

use statrs::distribution::{ContinuousCDF, Normal};

use crate::reconstruct::data::{FilterData, MeasurementSeries, Outlier, Reconstruction};
use crate::reconstruct::model::layout::MEASUREMENTS;
use crate::reconstruct::settings::FilterSettings;
use crate::statistics::{MEDIAN_OF_NORMAL, median};

/// Runs of the filter at most.
pub(crate) const PASSES: usize = 8;
/// Samples of a spike at most.
const LONGEST: usize = 3;
/// Part of a spike that the next innovation may be on its side.
const BACK: f64 = 0.25;
/// Time within which a larger spike may explain a later one, s.
const ECHO_S: f64 = 2.0;
/// Measurements of a group, and the time within which theirs are one sample, s.
const GROUP: usize = 3;
const SAME_TIME_S: f64 = 1e-6;
/// Part of the samples of a measurement beyond which its noise is wrong, not its samples, and how many there may always be.
const MOST_PART: f64 = 0.05;
const FEW: usize = 3;
/// Probability that any sample of a measurement free of outliers is taken for one by [`without_outliers`].
const OUTLIER: f64 = 0.05;

/// The search for the outliers of one window.
pub(crate) struct OutlierSearch<'a> {
    original: &'a FilterData,
    limit: f64,
    /// Indices of the samples left out, in order.
    left_out: [Vec<usize>; MEASUREMENTS],
    /// Those of samples that stay whatever their innovations: where a sensor jumps.
    kept: [Vec<usize>; MEASUREMENTS],
}

/// A run of samples beyond the limit.
struct Run {
    measurement: usize,
    /// Indices of its samples.
    samples: Vec<usize>,
    time_s: f64,
    /// Its largest innovation over its deviation.
    size: f64,
}

impl<'a> OutlierSearch<'a> {
    pub(crate) fn new(original: &'a FilterData, limit: f64) -> Self {
        Self { original, limit, left_out: Default::default(), kept: Default::default() }
    }

    /// Leaves out what `run` shows to be outliers, of the samples it was given; whether that changed anything.
    pub(crate) fn search(&mut self, run: &Reconstruction) -> bool {
        let mut runs: Vec<Run> = (0..MEASUREMENTS).flat_map(|m| self.runs(m, run)).collect();
        runs.sort_by(|a, b| b.size.total_cmp(&a.size));
        let mut taken: Vec<&Run> = Vec::new();
        for run in &runs {
            if !taken.iter().any(|larger| run.may_echo(larger)) {
                taken.push(run);
            }
        }
        let changed = !taken.is_empty();
        for run in taken {
            self.take(run);
        }
        changed
    }

    /// Leaves a run out; where it goes on from one that was, a sensor has jumped and both stay.
    fn take(&mut self, run: &Run) {
        let (left_out, kept) = (&mut self.left_out[run.measurement], &mut self.kept[run.measurement]);
        let values = &self.original.measurements[run.measurement].values;
        let before = |index: usize| (0..index).rev().find(|&before| values[before].is_finite());
        let mut earlier = Vec::new();
        let mut at = before(run.samples[0]);
        while let Some(index) = at.filter(|index| left_out.contains(index)) {
            earlier.push(index);
            at = before(index);
        }
        if earlier.is_empty() {
            left_out.extend(&run.samples);
            left_out.sort_unstable();
        } else {
            left_out.retain(|index| !earlier.contains(index));
            kept.extend(earlier);
            kept.extend(&run.samples);
        }
    }

    /// The spikes of one measurement.
    fn runs(&self, m: usize, run: &Reconstruction) -> Vec<Run> {
        let columns = run.innovations[m].iter().zip(&run.innovation_deviations[m]);
        if !columns.clone().any(|(value, sigma)| value.abs() > self.limit * sigma) {
            return Vec::new();
        }
        let normalised = normalised(m, run);
        let mut magnitudes: Vec<f64> = normalised.iter().map(|(_, value)| value.abs()).collect();
        let Some(median) = median(&mut magnitudes) else { return Vec::new() };
        let limit = self.limit * (median / MEDIAN_OF_NORMAL).max(1.0);
        let mut found = Vec::new();
        let mut k = 0;
        while k < normalised.len() {
            let side = normalised[k].1.signum();
            let length = normalised[k..].iter().take_while(|(_, value)| value * side > limit).count();
            if length == 0 {
                k += 1;
                continue;
            }
            let samples = &normalised[k..k + length];
            let size = samples.iter().map(|(_, value)| value.abs()).fold(0.0, f64::max);
            let is_back = normalised.get(k + length).is_none_or(|(_, next)| next * side < BACK * size);
            let time_s = run.update_time_s[samples[0].0];
            let series = &self.original.measurements[m];
            let indices: Vec<usize> =
                samples.iter().filter_map(|(at, _)| nearest(series, run.update_time_s[*at])).collect();
            let is_kept = indices.iter().any(|index| self.kept[m].contains(index));
            if length <= LONGEST && is_back && !is_kept && !indices.is_empty() {
                found.push(Run { measurement: m, samples: indices, time_s, size });
            }
            k += length;
        }
        found
    }

    /// Puts back what is too much to be spikes.
    pub(crate) fn put_back(&mut self) {
        for (left_out, series) in self.left_out.iter_mut().zip(&self.original.measurements) {
            let most = FEW.max((MOST_PART * series.time_s.len() as f64) as usize);
            if left_out.len() > most {
                left_out.clear();
            }
        }
    }

    /// Whether anything is left out.
    pub(crate) fn found_any(&self) -> bool {
        self.left_out.iter().any(|samples| !samples.is_empty())
    }

    /// The window without them.
    pub(crate) fn data(&self) -> FilterData {
        let mut data = self.original.clone();
        for (series, samples) in data.measurements.iter_mut().zip(&self.left_out) {
            leave_out(series, samples);
        }
        data
    }

    /// Those left out, as they stand in the window as `recorded`.
    pub(crate) fn outliers(&self, recorded: &FilterData) -> [Vec<Outlier>; MEASUREMENTS] {
        std::array::from_fn(|m| {
            let series = &recorded.measurements[m];
            let outlier = |&index: &usize| Outlier { time_s: series.time_s[index], value: series.values[index] };
            self.left_out[m].iter().map(outlier).collect()
        })
    }
}

impl Run {
    /// Whether a larger one explains it.
    fn may_echo(&self, larger: &Self) -> bool {
        let after_s = self.time_s - larger.time_s;
        let is_of_its_group = self.measurement / GROUP == larger.measurement / GROUP && after_s.abs() < SAME_TIME_S;
        !is_of_its_group && (0.0..ECHO_S).contains(&after_s)
    }
}

impl FilterData {
    /// The same without the samples at these times.
    #[must_use]
    pub fn without(&self, outliers: &[Vec<Outlier>; MEASUREMENTS]) -> Self {
        let mut data = self.clone();
        for (series, outliers) in data.measurements.iter_mut().zip(outliers) {
            let samples: Vec<usize> = outliers.iter().filter_map(|outlier| nearest(series, outlier.time_s)).collect();
            leave_out(series, &samples);
        }
        data
    }
}

/// Indices of the innovations of a measurement, and they over their deviations.
fn normalised(m: usize, run: &Reconstruction) -> Vec<(usize, f64)> {
    let columns = run.innovations[m].iter().zip(&run.innovation_deviations[m]);
    columns.map(|(value, sigma)| value / sigma).enumerate().filter(|(_, value)| value.is_finite()).collect()
}

/// The sample of a series nearest to a time.
fn nearest(series: &MeasurementSeries, time_s: f64) -> Option<usize> {
    let after = series.time_s.partition_point(|time| *time < time_s);
    let distance = |k: &usize| series.time_s.get(*k).map_or(f64::INFINITY, |time| (time - time_s).abs());
    [after.saturating_sub(1), after]
        .into_iter()
        .filter(|&k| series.values.get(k).is_some_and(|value| value.is_finite()))
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

fn leave_out(series: &mut MeasurementSeries, samples: &[usize]) {
    if samples.is_empty() {
        return;
    }
    let values = Arc::make_mut(&mut series.values);
    samples.iter().for_each(|&index| values[index] = f64::NAN);
}

/// `data` without outliers, and how many each measurement had. A sample is one when its innovation, over its predicted
/// deviation, is further from the typical one of its measurement than the furthest of that many normal numbers is once in
/// twenty: noise cannot be estimated from data with outliers in, and a limit that cuts good samples off makes it too small (by
/// 0.6 % at 3.29 deviations).
pub fn without_outliers(
    data: &FilterData,
    run: &Reconstruction,
    settings: &FilterSettings,
) -> (FilterData, [usize; MEASUREMENTS]) {
    let mut data = data.clone();
    let mut outliers = [0; MEASUREMENTS];
    for m in 0..MEASUREMENTS {
        let normalised = normalised(m, run);
        let mut magnitudes: Vec<f64> = normalised.iter().map(|(_, value)| value.abs()).collect();
        let Some(median) = median(&mut magnitudes) else { continue };
        let furthest = Normal::standard().inverse_cdf(1.0 - 0.5 * OUTLIER / normalised.len() as f64);
        let limit = furthest * median / MEDIAN_OF_NORMAL;
        let series = &mut data.measurements[m];
        let beyond = normalised.iter().filter(|(_, value)| value.abs() > limit);
        let times = beyond.map(|(k, _)| run.update_time_s[*k] + settings.measurement_delay_s[m]);
        let samples: Vec<usize> = times.filter_map(|time_s| nearest(series, time_s)).collect();
        outliers[m] = samples.len();
        leave_out(series, &samples);
    }
    (data, outliers)
}
