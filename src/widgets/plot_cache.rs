//! What is drawn of each trace, kept from frame to frame.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use doublet_core::series::{Band, Decimated, Pyramid, Series, Statistics, TimeRange, decimate, decimate_band};
use doublet_core::statistics;
use eframe::egui::Id;
use egui_plot::PlotPoint;

use super::time_plot::{TimePlot, Trace};

/// Part of a band's points that does not count for the value range.
const BAND_LEFT_OUT: f64 = 0.15;

/// What was drawn for one trace, and for what.
pub(super) struct Drawn {
    pub(super) series: Series,
    pub(super) sigma: Option<Arc<[f64]>>,
    pub(super) pyramid: Pyramid,
    key: Option<(TimeRange, usize, f64)>,
    pub(super) line: Decimated<PlotPoint>,
    pub(super) band: Band,
    pub(super) band_extent: Option<(f64, f64)>,
    pub(super) frame: u64,
    between: Option<(TimeRange, Option<Statistics>)>,
}

/// Decimated traces kept from frame to frame: nothing is computed again while range, width and samples stay.
#[derive(Default)]
pub struct PlotCache {
    pub(super) drawn: HashMap<(Id, usize, usize), Drawn>,
    /// Names hidden in a stack.
    pub(super) hidden: HashSet<(Id, String)>,
    /// Value range chosen by hand for a plot of a stack, by its row and label, in its unit.
    values: HashMap<(Id, usize, String), (f64, f64)>,
    /// How often everything had been asked for when a stack was drawn last.
    homes: HashMap<Id, u32>,
    refreshed: usize,
}

impl PlotCache {
    /// Hides a name of the stack `id`, or shows it again.
    pub(super) fn toggle(&mut self, id: Id, name: &str) {
        let key = (id, name.to_owned());
        if !self.hidden.remove(&key) {
            self.hidden.insert(key);
        }
    }

    /// Shows `name` alone of `all`; all of them where it is alone already.
    pub(super) fn solo<'a>(&mut self, id: Id, name: &str, all: impl Iterator<Item = &'a str>) {
        let others: HashSet<(Id, String)> =
            all.filter(|other| *other != name).map(|other| (id, other.to_owned())).collect();
        let is_alone = !others.is_empty() && others.iter().all(|other| self.hidden.contains(other));
        self.hidden.retain(|(stack, _)| *stack != id);
        if !is_alone {
            self.hidden.extend(others);
        }
    }

    /// Whether a name of the stack `id` is hidden.
    pub(super) fn is_hidden(&self, id: Id, name: &str) -> bool {
        !self.hidden.is_empty() && self.hidden.contains(&(id, name.to_owned()))
    }

    /// Value range chosen by hand for the plot `row` of the stack `id`.
    pub(super) fn chosen_values(&self, id: Id, row: usize, plot: &TimePlot<'_>) -> Option<(f64, f64)> {
        if self.values.is_empty() { None } else { self.values.get(&(id, row, plot.axis_label())).copied() }
    }

    /// Chooses that range.
    pub(super) fn choose_values(&mut self, id: Id, row: usize, plot: &TimePlot<'_>, values: (f64, f64)) {
        self.values.insert((id, row, plot.axis_label()), values);
    }

    /// Fits the values of every plot of the stack `id` to what is visible.
    pub(super) fn fit_values(&mut self, id: Id) {
        self.values.retain(|(stack, ..), _| *stack != id);
    }

    /// Fits the values of the stack `id` where everything was asked for since it was drawn last.
    pub(super) fn follow(&mut self, id: Id, homes: u32) {
        if self.homes.insert(id, homes).is_some_and(|before| before != homes) {
            self.fit_values(id);
        }
    }

    /// How many traces have been decimated since the cache was made.
    pub fn refreshed(&self) -> usize {
        self.refreshed
    }

    /// Brings the trace up to date for `range` and `columns`.
    pub(super) fn prepare(
        &mut self,
        at: (Id, usize, usize),
        trace: &Trace<'_>,
        range: TimeRange,
        columns: usize,
        frame: u64,
    ) {
        let Trace { series, sigma, scale, .. } = *trace;
        let fresh = || Drawn::new(series, sigma, frame);
        let drawn = self.drawn.entry(at).or_insert_with(fresh);
        if !same(&drawn.series, series) {
            *drawn = fresh();
        }
        if drawn.sigma.as_ref().map(Arc::as_ptr) != sigma.map(Arc::as_ptr) {
            drawn.sigma = sigma.cloned();
            drawn.key = None;
        }
        drawn.frame = frame;
        let key = Some((range, columns, scale));
        if drawn.key == key {
            return;
        }
        drawn.key = key;
        self.refreshed += 1;
        let count = series.time_s.len().min(series.values.len());
        let (time, values) = (&series.time_s[..count], &series.values[..count]);
        let range_s = (range.start_s, range.end_s);
        decimate(&drawn.pyramid, time, values, scale, range_s, columns, &mut drawn.line);
        if let Some(sigma) = sigma.filter(|sigma| sigma.len() == count) {
            decimate_band((time, values, sigma), scale, 2.0, range_s, columns / 2, &mut drawn.band);
            drawn.band_extent = usual_extent(&drawn.band);
        }
    }
}

impl Drawn {
    fn new(series: &Series, sigma: Option<&Arc<[f64]>>, frame: u64) -> Self {
        Self {
            series: series.clone(),
            sigma: sigma.cloned(),
            pyramid: Pyramid::new(&series.time_s, &series.values),
            key: None,
            line: Decimated::default(),
            band: Band::default(),
            band_extent: None,
            frame,
            between: None,
        }
    }

    /// Statistics of the samples of `part`, in SI; read once while the part stays.
    pub(super) fn statistics(&mut self, part: TimeRange) -> Option<Statistics> {
        if let Some((of, found)) = self.between
            && of == part
        {
            return found;
        }
        let found = self.series.statistics(part);
        self.between = Some((part, found));
        found
    }
}

/// Edges of a band without its widest parts, such as the uncertainty a filter starts from: they may leave the plot.
fn usual_extent(band: &Band) -> Option<(f64, f64)> {
    edge(&band.low, BAND_LEFT_OUT).zip(edge(&band.high, 1.0 - BAND_LEFT_OUT))
}

fn edge(values: &[f64], part: f64) -> Option<f64> {
    let mut values = values.to_vec();
    let at = (part * values.len().checked_sub(1)? as f64).round() as usize;
    statistics::ranked(&mut values, at)
}

/// Whether both hold the very same samples.
fn same(a: &Series, b: &Series) -> bool {
    Arc::ptr_eq(&a.time_s, &b.time_s) && Arc::ptr_eq(&a.values, &b.values)
}
