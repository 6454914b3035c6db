//! Lags and delays of the controls, found by the fit.

use std::sync::Arc;

use doublet_core::estimate::{NonlinearSearch, PooledRegression, search_nonlinear};
use doublet_core::model::{Coefficient, Lag};
use rayon::prelude::*;

use super::{StudyError, Subject, Watch};
use crate::graph::Footprint;
use crate::session::Surface;
use crate::stage::{self, AeroWindow, CONTROLS, WindowAero};

/// What a control may do between its recording and the air.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LagKind {
    /// It acts late by a pure delay; a negative one says that its recording is late.
    Delay,
    /// It follows with a first-order lag.
    FirstOrder,
}

/// Lag or delay of one control.
#[derive(Clone, Debug)]
pub struct ControlLag {
    /// Control.
    pub surface: Surface,
    /// What was looked for.
    pub kind: LagKind,
    /// Coefficients it was looked for in: those with a term of the control.
    pub coefficients: Vec<Coefficient>,
    /// Result, s, beside the lag the session has; or one line why there is none.
    pub result: Result<NonlinearSearch, String>,
}

/// Lags and delays of all controls of the structure.
#[derive(Clone, Debug, Default)]
pub struct LagStudy {
    /// A delay and a first-order lag per control.
    pub lags: Vec<ControlLag>,
}

impl LagKind {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Delay, Self::FirstOrder];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Delay => "delay",
            Self::FirstOrder => "first-order lag",
        }
    }

    /// Range searched, s.
    fn range_s(self) -> [f64; 2] {
        match self {
            Self::Delay => [-0.1, 0.2],
            Self::FirstOrder => [0.0, 0.3],
        }
    }

    /// `lag` with this part set to `value_s`.
    pub fn set(self, lag: Lag, value_s: f64) -> Lag {
        match self {
            Self::Delay => Lag { delay_s: value_s, ..lag },
            Self::FirstOrder => Lag { time_constant_s: value_s, ..lag },
        }
    }
}

impl ControlLag {
    /// Value to take, to a tenth of a millisecond, and its standard error, s.
    ///
    /// # Errors
    /// One line: why none was found; that it lies at an end of the range searched.
    pub fn found_s(&self) -> Result<(f64, f64), String> {
        let search = self.result.as_ref().map_err(Clone::clone)?;
        if !search.standard_error.is_finite() {
            return Err("the best value lies at or beyond an end of the range searched, it is not taken".to_owned());
        }
        Ok(((1e4 * search.value).round() / 1e4, search.standard_error))
    }
}

impl LagStudy {
    /// What was found of one control; `None` where no coefficient has a term of it.
    pub fn of(&self, surface: Surface, kind: LagKind) -> Option<&ControlLag> {
        self.lags.iter().find(|lag| lag.surface == surface && lag.kind == kind)
    }
}

impl Footprint for LagStudy {
    fn bytes(&self) -> usize {
        self.lags.iter().filter_map(|lag| lag.result.as_ref().ok()).map(search_bytes).sum::<usize>() + 64
    }
}

fn search_bytes(search: &NonlinearSearch) -> usize {
    search.fits.iter().map(|fit| fit.fit.residuals.len() * 16 + 4096).sum()
}

/// Finds the delay and the first-order lag of every control by the fit of the coefficients that have a term of it, one at a time,
/// the others as the session has them.
///
/// # Errors
/// That it was stopped.
pub fn lags(subject: &Subject<'_>, watch: &Watch<'_>) -> Result<LagStudy, StudyError> {
    let windows = subject.aero();
    let cases: Vec<_> = CONTROLS.into_iter().flat_map(|surface| LagKind::ALL.map(|kind| (surface, kind))).collect();
    let watch = watch.parts(cases.len());
    let one = |(surface, kind): (Surface, LagKind)| {
        let found = control_lag(subject, &windows, surface, kind, &watch);
        watch.checkpoint()?;
        watch.step();
        Ok(found)
    };
    let found = cases.into_par_iter().map(one).collect::<Result<Vec<_>, StudyError>>()?;
    Ok(LagStudy { lags: found.into_iter().flatten().collect() })
}

/// `None` where no coefficient has a term of the control.
fn control_lag<'a>(
    subject: &Subject<'a>,
    windows: &[AeroWindow<'a>],
    surface: Surface,
    kind: LagKind,
    watch: &Watch<'_>,
) -> Option<ControlLag> {
    let (control, role) = (surface.variable(), surface.role());
    let mut structure = subject.session.structure.clone();
    structure
        .models
        .retain(|(_, terms)| terms.iter().any(|term| term.factors().iter().any(|&(variable, _)| variable == control)));
    let coefficients: Vec<Coefficient> = structure.models.iter().map(|(coefficient, _)| *coefficient).collect();
    if coefficients.is_empty() {
        return None;
    }
    let regressions_at = |value_s: f64| -> Result<Vec<PooledRegression>, SearchError> {
        watch.checkpoint().map_err(|_| SearchError("stopped".to_owned()))?;
        let late = |(manoeuvre, aero): &AeroWindow<'a>| -> Result<AeroWindow<'a>, String> {
            let mut settings = aero.settings.clone();
            let lag = settings.control_lags.get(&role).copied().unwrap_or_default();
            settings.control_lags.insert(role, kind.set(lag, value_s));
            Ok((*manoeuvre, Arc::new(WindowAero::formed(aero.data.clone(), settings, Vec::new())?)))
        };
        let windows = windows.iter().map(late).collect::<Result<Vec<_>, _>>().map_err(SearchError)?;
        let found = stage::pooled_regressions(&windows, &structure, &subject.session.estimation);
        found.into_iter().map(|regression| Ok(regression.map_err(SearchError)?.pooled)).collect()
    };
    let [lower, upper] = kind.range_s();
    let result = search_nonlinear(lower, upper, regressions_at).map_err(|SearchError(error)| error);
    Some(ControlLag { surface, kind, coefficients, result })
}

/// One line: why a lag could not be tried.
struct SearchError(String);

impl From<doublet_core::estimate::EstimateError> for SearchError {
    fn from(error: doublet_core::estimate::EstimateError) -> Self {
        Self(error.to_string())
    }
}
