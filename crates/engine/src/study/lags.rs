//! Lags and delays of the controls, found by the fit.

use std::sync::Arc;

use doublet_core::estimate::{NonlinearSearch, PooledRegression, search_nonlinear};
use doublet_core::model::{Coefficient, Lag};
use rayon::prelude::*;

use super::StudyInput;
use crate::graph::{Context, Footprint, Stage, StageResult};
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
    pub surface: Surface,
    /// What was looked for.
    pub kind: LagKind,
    /// Coefficients it was looked for in: those with a term of the control.
    pub coefficients: Vec<Coefficient>,
    /// Result, s, beside the lag the session has; or one line why there is none.
    pub result: StageResult<NonlinearSearch>,
}

/// Lags and delays of all controls of the structure.
#[derive(Clone, Debug, Default)]
pub struct LagStudy {
    /// A delay and a first-order lag per control.
    pub lags: Vec<ControlLag>,
}

/// Value and standard error of one coefficient alone, s; or in few words where beyond the range searched it lies.
pub(crate) type LagAlone = StageResult<(f64, f64)>;

impl LagKind {
    doublet_core::named_variants! {
        /// Name in tables.
        pub name: Delay "delay", FirstOrder "first-order lag"
    }

    /// Range searched, s.
    pub fn range_s(self) -> [f64; 2] {
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
    pub fn found_s(&self) -> StageResult<(f64, f64)> {
        let search = self.result.as_ref().map_err(Clone::clone)?;
        if let Some(disagreement) = self.disagreement() {
            return Err(disagreement.into());
        }
        if !search.standard_error.is_finite() {
            return Err("the best value is at the limit of the search range and is not used".into());
        }
        Ok(((1e4 * search.value).round() / 1e4, search.standard_error))
    }

    /// Value of each coefficient alone and its standard error, s, in the order of the coefficients; in few words where beyond the
    /// range searched it lies.
    pub(crate) fn by_coefficient(&self) -> Vec<(Coefficient, LagAlone)> {
        let [lower, upper] = self.kind.range_s();
        let inside = |&(value, error): &(f64, f64)| match value {
            value if value < lower => Err(format!("below {:.0} ms", 1e3 * lower).into()),
            value if value > upper => Err(format!("above {:.0} ms", 1e3 * upper).into()),
            _ => Ok((value, error)),
        };
        let single = self.result.iter().flat_map(|search| &search.by_regression).map(inside);
        self.coefficients.iter().copied().zip(single).collect()
    }

    /// One line where the coefficients want different values: no one value is the control's then.
    pub fn disagreement(&self) -> Option<String> {
        let agreement = self.result.as_ref().ok()?.agreement();
        let describe = |(coefficient, found): (Coefficient, LagAlone)| match found {
            Ok((value, error)) => format!("{} gives {:.0} +- {:.0} ms", coefficient.name(), 1e3 * value, 1e3 * error),
            Err(beyond) => format!("{} says {beyond}", coefficient.name()),
        };
        let words: Vec<String> = self.by_coefficient().into_iter().map(describe).collect();
        (agreement < DISAGREE).then(|| format!("coefficients disagree: {}", words.join(", ")))
    }

    /// Coefficient of determination of the fits at the value found: the part of the coefficients' variance that they explain, each
    /// coefficient's over its own.
    pub fn r_squared(&self) -> Option<f64> {
        let fits = &self.result.as_ref().ok()?.fits;
        let samples: f64 = fits.iter().map(|fit| fit.fit.samples() as f64).sum();
        Some(fits.iter().map(|fit| fit.fit.samples() as f64 * fit.fit.quality.r_squared).sum::<f64>() / samples)
    }
}

/// Probability of the scatter of the coefficients' values below which they disagree.
const DISAGREE: f64 = 0.01;

impl LagStudy {
    /// What was found of one control; `None` where no coefficient has a term of it.
    pub fn get(&self, surface: Surface, kind: LagKind) -> Option<&ControlLag> {
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
impl Stage for LagStudy {
    type Params<'a> = ();
    type Inputs<'a> = &'a StudyInput<'a>;
    type Output = Self;
    const NAME: &'static str = "lags of the controls";

    fn run((): (), input: &StudyInput<'_>, context: &Context<'_>) -> StageResult<Self> {
        let windows = input.aero();
        let cases: Vec<_> = CONTROLS.into_iter().flat_map(|surface| LagKind::ALL.map(|kind| (surface, kind))).collect();
        let context = context.parts(cases.len());
        let one = |(surface, kind): (Surface, LagKind)| {
            let found = control_lag(input, &windows, surface, kind, &context);
            context.checkpoint()?;
            context.step();
            Ok(found)
        };
        let found = cases.into_par_iter().map(one).collect::<StageResult<Vec<_>>>()?;
        Ok(LagStudy { lags: found.into_iter().flatten().collect() })
    }
}

/// `None` where no coefficient has a term of the control.
fn control_lag<'a>(
    input: &StudyInput<'a>,
    windows: &[AeroWindow<'a>],
    surface: Surface,
    kind: LagKind,
    context: &Context<'_>,
) -> Option<ControlLag> {
    let (control, role) = (surface.variable(), surface.role());
    let mut structure = input.settings.structure.clone();
    structure
        .models
        .retain(|(_, terms)| terms.iter().any(|term| term.factors().iter().any(|&(variable, _)| variable == control)));
    let coefficients: Vec<Coefficient> = structure.models.iter().map(|(coefficient, _)| *coefficient).collect();
    if coefficients.is_empty() {
        return None;
    }
    let regressions_at = |value_s: f64| -> StageResult<Vec<PooledRegression>> {
        context.checkpoint()?;
        let late = |(manoeuvre, aero): &AeroWindow<'a>| -> StageResult<AeroWindow<'a>> {
            let mut settings = aero.settings.clone();
            let lag = settings.control_lags.get(&role).copied().unwrap_or_default();
            settings.control_lags.insert(role, kind.set(lag, value_s));
            Ok((*manoeuvre, Arc::new(WindowAero::form(aero.data.clone(), settings, aero.air_density)?)))
        };
        let windows = windows.iter().map(late).collect::<StageResult<Vec<_>>>()?;
        let found = stage::pooled_regressions(&windows, &structure, input.settings.estimation);
        found.into_iter().map(|regression| Ok(regression?.pooled)).collect()
    };
    let [lower, upper] = kind.range_s();
    let result = search_nonlinear(lower, upper, regressions_at);
    Some(ControlLag { surface, kind, coefficients, result })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lag(kind: LagKind, value: f64, by_regression: Vec<(f64, f64)>) -> ControlLag {
        let search =
            NonlinearSearch { value, standard_error: 0.001, by_regression, profile: Vec::new(), fits: Vec::new() };
        let coefficients = vec![Coefficient::CY, Coefficient::Cl, Coefficient::Cn];
        ControlLag { surface: Surface::Aileron, kind, coefficients, result: Ok(search) }
    }

    #[test]
    fn coefficients_that_disagree_give_no_delay_and_are_named() {
        // Of the simulated Citation's aileron 3-2-1-1: seven times its standard error, from Cl alone.
        let found = lag(LagKind::Delay, 0.008, vec![(0.099, 0.0087), (0.0074, 0.0007), (0.171, 0.015)]);
        let message = found.found_s().unwrap_err().to_string();
        assert_eq!(message, "coefficients disagree: CY gives 99 +- 9 ms, Cl gives 7 +- 1 ms, Cn gives 171 +- 15 ms");
        // Of the shipped flight's ailerons.
        let found = lag(LagKind::Delay, -0.0006, vec![(0.0128, 0.0071), (-0.00065, 0.00036), (0.00487, 0.0043)]);
        assert_eq!(found.found_s().unwrap(), (-0.0006, 0.001));
    }

    #[test]
    fn no_value_lies_outside_the_range_searched() {
        let found = lag(LagKind::FirstOrder, 0.29, vec![(0.29, 0.01), (0.478, 0.11), (-0.0244, 0.143)]);
        let single = found.by_coefficient();
        assert_eq!(single[0].1, Ok((0.29, 0.01)));
        assert_eq!(single[1].1, Err("above 300 ms".into()));
        assert_eq!(single[2].1, Err("below 0 ms".into()));
    }
}
