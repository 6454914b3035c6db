//! A closer look at what is on screen.

use std::sync::Arc;

use doublet_core::model::Coefficient;
use doublet_core::reconstruct::Measurement;
use doublet_core::series::Series;

use crate::graph::{Footprint, StageResult};
use crate::stage::{
    BiasTable, CoefficientStudy, Contributions, Information, KindSummary, Misfit, NoiseAdvice, RegressorCorrelation,
    ResidualStudy, WindowPath,
};

/// What was found.
#[derive(Clone, Debug, Default)]
pub struct Details {
    /// The window looked at.
    pub window: Option<WindowDetails>,
    /// Terms of the model and candidates, where they were looked at.
    pub model: Vec<CoefficientStudy>,
    /// North and east positions of the flight whose track was wanted.
    pub track: Option<[Series; 2]>,
    /// Biases and wind of all windows.
    pub biases: BiasTable,
    /// Correlation of the regressors, where they were looked at.
    pub regressors: Vec<RegressorCorrelation>,
    /// Derivatives over all identification windows, then over those of each kind of input.
    pub kinds: Vec<KindSummary>,
}

/// A closer look at one window.
#[derive(Clone, Debug)]
pub struct WindowDetails {
    pub name: String,
    /// Residuals of its own fits.
    pub residuals: Vec<ResidualStudy>,
    /// What the noise of each measurement should be.
    pub noise: Vec<NoiseAdvice>,
    /// The noise of each measurement by the innovations of all manoeuvres, SI; those that have one.
    pub noise_of_all: Vec<(Measurement, f64)>,
    /// Half of the half width of the 95 % band of the observations about each of its fits, sample by sample.
    pub bands: Vec<(Coefficient, Arc<[f64]>)>,
    /// What moves with the residual where it is looked at, or why that is not known.
    pub misfit: Option<StageResult<Misfit>>,
    /// Parts of its fitted coefficients.
    pub contributions: Vec<Contributions>,
    /// Which seconds tell which derivative.
    pub information: Vec<Information>,
    /// Its path by the plain and by the iterated filter, both smoothed, or why it has none; `None` where it was not wanted.
    pub filters: Option<StageResult<[Arc<WindowPath>; 2]>>,
}

impl Footprint for Details {
    fn bytes(&self) -> usize {
        let filters = self.window.iter().filter_map(|window| window.filters.as_ref()?.as_ref().ok()).flatten();
        filters.map(|path| path.bytes()).sum::<usize>() + (1 << 20)
    }
}
