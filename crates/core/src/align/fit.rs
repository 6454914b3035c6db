//! Offset and drift of a recorder's clock from channels it shares with the reference.

use rayon::prelude::*;

use super::derivative::{Band, Derivative, Samples, derivative};
use super::line::{LEAST_SD_S, Line, Point, agreeing, weighted_line};
use super::peak::{Pair, Peak, whole_correlation};
use super::{AlignError, ClockModel};
use crate::series::Series;
use crate::statistics::median_step;

/// One quantity that both recorders have: load factor, airspeed, bank or pitch (thesis section 4.4.3).
#[derive(Clone, Copy, Debug)]
pub struct ClockPair<'a> {
    /// Name in messages.
    pub name: &'a str,
    /// Samples of the reference, against its clock.
    pub reference: &'a Series,
    /// Samples of the other recorder, against its own clock.
    pub other: &'a Series,
    /// The two have opposite signs, as specific force along body z and load factor do.
    pub inverted: bool,
}

/// Where the offset is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClockSearch {
    /// Anywhere the two records overlap.
    Everywhere,
    /// Within `max_lag_s` of this clock, as UTC start times give one.
    About(ClockModel),
}

/// How a clock is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockFitSettings {
    /// Number of chunks the common time is cut into.
    pub chunks: usize,
    /// Step of the grid of the correlation at the least smoothing, s; no sample is moved onto it but for the correlation.
    pub step_s: f64,
    /// Standard deviation of the Gaussian that smooths the derivative, s. By default each pair gets what tells its lag best:
    /// one, two, four or eight times the greater of 0.25 s and the longest median sample interval.
    pub smoothing_s: Option<f64>,
    /// Longest interval between samples that is bridged, s.
    pub max_gap_s: f64,
    /// Where to look.
    pub search: ClockSearch,
    /// Farthest a chunk may lie from the first guess, s.
    pub max_lag_s: f64,
    /// Least correlation of a chunk that counts.
    pub min_correlation: f64,
    /// Farthest a chunk may lie from the common line to count, s.
    pub agreement_s: f64,
    /// Largest drift, s per s.
    pub max_drift: f64,
    /// Whether drift is estimated; without it that of the first guess stays (zero for [`ClockSearch::Everywhere`]).
    pub fit_drift: bool,
}

impl Default for ClockFitSettings {
    /// Nine chunks at 0.025 s, gaps up to 1.5 s, lags up to 2 s, correlation 0.5, agreement 0.05 s, drift up to 1e-3, fitted.
    fn default() -> Self {
        Self {
            chunks: 9,
            step_s: 0.025,
            smoothing_s: None,
            max_gap_s: 1.5,
            search: ClockSearch::Everywhere,
            max_lag_s: 2.0,
            min_correlation: 0.5,
            agreement_s: 0.05,
            max_drift: 1e-3,
            fit_drift: true,
        }
    }
}

/// What one chunk of one pair shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockChunk {
    /// Index of the pair.
    pub pair: usize,
    /// Own time of the recorder at which the chunk speaks, s.
    pub own_s: f64,
    /// Reference time it gives for that own time, less the own time, s: the lag against own time of the figure.
    pub lag_s: f64,
    /// Its standard error, s.
    pub lag_sd_s: f64,
    /// Correlation coefficient of the two derivatives.
    pub correlation: f64,
    /// Distance from the fitted clock, s.
    pub residual_s: f64,
    /// Whether it belongs to the chunks that agree.
    pub used: bool,
}

/// A fitted clock.
#[derive(Clone, Debug, PartialEq)]
pub struct ClockEstimate {
    /// The clock.
    pub model: ClockModel,
    /// Standard error of the offset, that is at own time zero, s.
    pub offset_sd_s: f64,
    /// Standard error of the drift, s per s; zero where it was not fitted.
    pub drift_sd: f64,
    /// Own time at which the clock is known best, s, and its standard error there, s.
    pub best_known: (f64, f64),
    /// What each chunk shows, in order of pair and time.
    pub chunks: Vec<ClockChunk>,
}

/// Clock of a recorder against the reference from all quantities both have.
///
/// Derivatives smoothed by a Gaussian are correlated: first the whole record at every lag, which gives the first guess, then
/// chunk by chunk. The peak of each chunk lies between steps where a parabola through three correlations has its top. The
/// chunks of all pairs that agree on one line, `t_ref = offset + (1 + drift) t`, give the clock by weighted least squares;
/// thrice, each time with the clock just found. The lag found is that of the data: a channel's own age is part of it
/// (take it off with [`ClockModel::shifted`]). Chunks weigh by their residual with its correlation in time; standard errors are
/// scaled to the scatter of the chunks.
///
/// # Errors
/// [`AlignError::Setting`], [`AlignError::Signal`] for lengths that differ or time that does not increase, [`AlignError::Still`]
/// for a channel that does not change or has no stretch without gaps, [`AlignError::NoAgreement`].
pub fn clock_fit_pairs(pairs: &[ClockPair<'_>], settings: &ClockFitSettings) -> Result<ClockEstimate, AlignError> {
    /// How much wider the agreement of the first pass is: it still sees the drift within a chunk.
    const FIRST_AGREEMENT: f64 = 4.0;
    /// Passes after it, and the part of the lags that they look at.
    const FURTHER_PASSES: usize = 2;
    const FURTHER_LAGS: f64 = 0.25;
    check(settings)?;
    let bands = bands(pairs, settings)?;
    let samples = pairs.iter().map(PairSamples::new).collect::<Result<Vec<_>, _>>()?;
    let least = samples.iter().map(|pair| Prepared::new(pair, bands[0])).collect::<Result<Vec<_>, _>>()?;
    let model = match settings.search {
        ClockSearch::About(model) => model,
        ClockSearch::Everywhere => first_guess(&least)?,
    };
    let mut prepared = Vec::with_capacity(least.len());
    let mut chunks = Vec::with_capacity(least.len() * settings.chunks);
    for (index, least) in least.into_iter().enumerate() {
        let (best, shown) = best_band(index, least, &bands[1..], &model, settings)?;
        prepared.push(best);
        chunks.extend(shown);
    }
    let mut estimate = fit_line(&model, chunks, settings, FIRST_AGREEMENT * settings.agreement_s)?;
    for _ in 0..FURTHER_PASSES {
        let model = estimate.model;
        let mut chunks = Vec::with_capacity(prepared.len() * settings.chunks);
        for (index, prepared) in prepared.iter().enumerate() {
            chunks.extend(prepared.chunks(index, &model, settings.chunks, FURTHER_LAGS * settings.max_lag_s)?);
        }
        estimate = fit_line(&model, chunks, settings, settings.agreement_s)?;
    }
    Ok(estimate)
}

fn check(settings: &ClockFitSettings) -> Result<(), AlignError> {
    let positive = [
        ("chunks", settings.chunks as f64),
        ("step_s", settings.step_s),
        ("smoothing_s", settings.smoothing_s.unwrap_or(1.0)),
        ("max_gap_s", settings.max_gap_s),
        ("max_lag_s", settings.max_lag_s),
        ("min_correlation", settings.min_correlation),
        ("agreement_s", settings.agreement_s),
        ("max_drift", settings.max_drift),
    ];
    match positive.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
        Some((setting, value)) => Err(AlignError::Setting { setting, value, allowed: "finite and above zero" }),
        None => Ok(()),
    }
}

/// Bands of the derivative, the least smoothing first.
fn bands(pairs: &[ClockPair<'_>], settings: &ClockFitSettings) -> Result<Vec<Band>, AlignError> {
    /// Smoothing that suits the short-period motion of light and transport aircraft, s.
    const SMOOTHING_S: f64 = 0.25;
    /// Times the least smoothing that are tried, for quantities slow beside their noise.
    const TIMES: [f64; 4] = [1.0, 2.0, 4.0, 8.0];
    if pairs.is_empty() {
        return Err(AlignError::Setting { setting: "pairs of channels", value: 0.0, allowed: "at least 1" });
    }
    let series = pairs.iter().flat_map(|pair| [pair.reference, pair.other]);
    let slowest = series.map(|series| median_step(&series.time_s).unwrap_or(0.0)).fold(SMOOTHING_S, f64::max);
    let band = |smoothing_s: f64, times: f64| Band {
        step_s: times * settings.step_s,
        smoothing_s: times * smoothing_s,
        max_gap_s: settings.max_gap_s,
    };
    Ok(match settings.smoothing_s {
        Some(smoothing_s) => vec![band(smoothing_s, 1.0)],
        None => TIMES.map(|times| band(slowest, times)).to_vec(),
    })
}

/// Usable samples of a pair.
struct PairSamples<'a> {
    reference: Samples<'a>,
    other: Samples<'a>,
    inverted: bool,
}

impl<'a> PairSamples<'a> {
    fn new(pair: &ClockPair<'a>) -> Result<Self, AlignError> {
        let [reference, other] = [pair.reference, pair.other].map(|series| Samples::new(pair.name, series));
        Ok(Self { reference: reference?, other: other?, inverted: pair.inverted })
    }
}

/// A pair with the band it is compared in and its reference there.
struct Prepared<'a> {
    pair: &'a PairSamples<'a>,
    band: Band,
    reference: Derivative,
}

impl<'a> Prepared<'a> {
    fn new(pair: &'a PairSamples<'a>, band: Band) -> Result<Self, AlignError> {
        let reference = derivative(&pair.reference, &ClockModel::REFERENCE, &band)?;
        Ok(Self { pair, band, reference })
    }

    /// The other channel against a clock, with the sign of the reference.
    fn other(&self, model: &ClockModel) -> Result<Derivative, AlignError> {
        let mut found = derivative(&self.pair.other, model, &self.band)?;
        if self.pair.inverted {
            found.values.iter_mut().for_each(|value| *value = -*value);
        }
        Ok(found)
    }

    /// What each chunk shows about a clock, within `max_lag_s` of it.
    fn chunks(
        &self,
        index: usize,
        model: &ClockModel,
        count: usize,
        max_lag_s: f64,
    ) -> Result<Vec<ClockChunk>, AlignError> {
        let (reference, other) = (&self.reference, self.other(model)?);
        let step_s = self.band.step_s;
        let max_lag = (max_lag_s / step_s).ceil() as i64;
        let from = reference.first.max(other.first);
        let end = |signal: &Derivative| signal.first + signal.values.len() as i64;
        let span = (end(reference).min(end(&other)) - from).max(0);
        let edge = |chunk: usize| from + span * chunk as i64 / count as i64;
        let both = Pair::new(reference, &other, self.band);
        let peaks = (0..count).into_par_iter().filter_map(|chunk| both.peak(edge(chunk)..edge(chunk + 1), max_lag));
        Ok(peaks.map(|peak| Self::describe_chunk(&peak, index, model)).collect())
    }

    fn describe_chunk(peak: &Peak, pair: usize, model: &ClockModel) -> ClockChunk {
        let own_s = model.own_s(peak.centre_s);
        ClockChunk {
            pair,
            own_s,
            lag_s: peak.centre_s - peak.lag_s - own_s,
            lag_sd_s: peak.lag_sd_s,
            correlation: peak.correlation,
            residual_s: 0.0,
            used: false,
        }
    }
}

/// A pair in the band whose chunks together tell the lag best, `sum 1 / sd^2` over those that correlate, and these chunks; bands too
/// slow for its stretches without gaps are passed over.
fn best_band<'a>(
    index: usize,
    least: Prepared<'a>,
    slower: &[Band],
    model: &ClockModel,
    settings: &ClockFitSettings,
) -> Result<(Prepared<'a>, Vec<ClockChunk>), AlignError> {
    let chunks = |prepared: &Prepared<'_>| prepared.chunks(index, model, settings.chunks, settings.max_lag_s);
    let information = |chunks: &[ClockChunk]| -> f64 {
        let strong = chunks.iter().filter(|chunk| chunk.correlation >= settings.min_correlation);
        strong.map(|chunk| 1.0 / chunk.lag_sd_s.max(LEAST_SD_S).powi(2)).sum()
    };
    let mut shown = chunks(&least)?;
    let mut best = least;
    for &band in slower {
        let candidate = match Prepared::new(best.pair, band) {
            Err(AlignError::Still { .. }) => break,
            other => other?,
        };
        match chunks(&candidate) {
            Err(AlignError::Still { .. }) => break,
            Ok(others) if information(&others) > information(&shown) => (shown, best) = (others, candidate),
            Ok(_) => {}
            Err(error) => return Err(error),
        }
    }
    Ok((best, shown))
}

/// Offset with the best correlation of the whole records, summed over the pairs, which share one band.
fn first_guess(prepared: &[Prepared<'_>]) -> Result<ClockModel, AlignError> {
    let mut correlations = Vec::with_capacity(prepared.len());
    for prepared in prepared {
        correlations.push(whole_correlation(&prepared.reference, &prepared.other(&ClockModel::REFERENCE)?));
    }
    let step_s = prepared.first().map_or(0.0, |prepared| prepared.band.step_s);
    let first = correlations.iter().map(|c| c.first_lag).min().unwrap_or(0);
    let end = correlations.iter().map(|c| c.first_lag + c.values.len() as i64).max().unwrap_or(0);
    let mut sum = vec![0.0; (end - first).max(0) as usize];
    for correlation in &correlations {
        let from = (correlation.first_lag - first) as usize;
        sum[from..].iter_mut().zip(&correlation.values).for_each(|(sum, value)| *sum += value);
    }
    let best = (0..sum.len()).max_by(|&i, &j| sum[i].total_cmp(&sum[j])).unwrap_or(0);
    Ok(ClockModel { offset_s: -(first + best as i64) as f64 * step_s, drift: 0.0 })
}

/// The clock through the chunks that agree.
fn fit_line(
    model: &ClockModel,
    mut chunks: Vec<ClockChunk>,
    settings: &ClockFitSettings,
    agreement_s: f64,
) -> Result<ClockEstimate, AlignError> {
    let correction = |chunk: &ClockChunk| chunk.lag_s - model.offset_s - model.drift * chunk.own_s;
    let points: Vec<Point> = chunks
        .iter()
        .map(|chunk| Point { own_s: chunk.own_s, value_s: correction(chunk), sd_s: chunk.lag_sd_s })
        .collect();
    let strong: Vec<usize> = (0..chunks.len()).filter(|&k| chunks[k].correlation >= settings.min_correlation).collect();
    let candidates: Vec<Point> = strong.iter().map(|&k| points[k]).collect();
    let inside = agreeing(&candidates, agreement_s, settings.max_drift, settings.fit_drift);
    let mut used = vec![false; points.len()];
    strong.iter().zip(&inside).for_each(|(&k, &inside)| used[k] = inside);
    let needed = if settings.fit_drift { 3 } else { 1 };
    let found = used.iter().filter(|&&used| used).count();
    let line = if found >= needed { weighted_line(&points, &used, settings.fit_drift) } else { None };
    let line = line.ok_or_else(|| AlignError::NoAgreement {
        found,
        chunks: chunks.len(),
        needed,
        agreement_s,
        best: chunks.iter().map(|chunk| chunk.correlation).fold(0.0, f64::max),
    })?;
    for ((chunk, point), used) in chunks.iter_mut().zip(&points).zip(used) {
        chunk.residual_s = point.value_s - line.at(point.own_s);
        chunk.used = used;
    }
    Ok(estimate(model, &line, chunks))
}

/// The clock corrected by a line.
fn estimate(model: &ClockModel, line: &Line, chunks: Vec<ClockChunk>) -> ClockEstimate {
    let model = ClockModel { offset_s: model.offset_s + line.at(0.0), drift: model.drift + line.slope };
    let best_known = (line.centre_s, line.variance[0].sqrt());
    let drift_sd = line.variance[1].sqrt();
    let offset_sd_s = best_known.1.hypot(drift_sd * line.centre_s);
    ClockEstimate { model, offset_sd_s, drift_sd, best_known, chunks }
}
