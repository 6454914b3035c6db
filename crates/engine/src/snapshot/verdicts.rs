//! Verdicts on a finished run: every manoeuvre, fit and derivative, and the session as a whole.

use std::collections::BTreeMap;

use doublet_core::model::{Coefficient, is_constant_name};
use serde::Serialize;

use crate::graph::Footprint;
use crate::session::{Finding, Level, Verdict};

/// Verdicts on everything a run computed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdicts {
    /// The whole session: its settings, its flights, the flight paths of its windows, its pooled fits (those of single windows
    /// where nothing is pooled) and its studies.
    pub session: Verdict,
    /// Windows not ignored, by name.
    pub windows: BTreeMap<String, WindowVerdict>,
    /// Fits over all identification windows, in the order of the structure, and the coefficients that no window is used for.
    pub pooled: Vec<FitVerdict>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct WindowVerdict {
    /// Its samples, flight path and loading: whether anything may be computed from them.
    pub verdict: Verdict,
    /// Fits from this window alone.
    pub fits: Vec<FitVerdict>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct FitVerdict {
    pub coefficient: Coefficient,
    /// The fit: the worst of its own reasons and of its derivatives', except that a derivative nobody can tell leaves it as it is.
    pub verdict: Verdict,
    /// Its parameters, in their order.
    pub derivatives: Vec<DerivativeVerdict>,
    /// Whether no window is used for it, so that there is no fit.
    pub is_unused: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub struct DerivativeVerdict {
    /// Name, for example `Cm_q`.
    pub name: String,
    pub verdict: Verdict,
    /// Its contribution, and what suspect causes change of it; of pooled fits alone.
    pub consequence: Option<Consequence>,
}

/// A cause whose effect on the derivatives is formed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// The reconstruction of the path: the effect is that of the path as measured.
    PathMeasured,
    /// The smoother: the effect is that of the filtered path.
    PathFiltered,
    /// A manoeuvre, or a group of them, left out.
    LeftOut,
    /// All manoeuvres with findings left out.
    SuspectsLeftOut,
    /// The manoeuvres that the model of the coefficient does not describe left out.
    OutlyingLeftOut,
    /// Samples left out at which a sensor is at the end of its range or the recorder stalls.
    SpoiltLeftOut,
    /// A channel that others contradict, corrected or left out.
    Channel,
    /// The place of the accelerometers, corrected.
    Accelerometer,
    /// Thrust that the coefficients contain and that changes with airspeed: the effect is that of a term of airspeed.
    Thrust,
}

/// What an estimate becomes without a suspect cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    pub cause: Cause,
    /// Object: manoeuvres, or a flight and its channel; empty for all manoeuvres.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub of: Vec<String>,
    /// Estimate without the cause.
    pub estimate: f64,
    /// Its standard error over that with the cause, by the regressors alone.
    pub error_ratio: f64,
    /// Worst level it can give: a caution of a cause that is itself in doubt.
    #[serde(skip)]
    pub(crate) worst: Level,
}

/// How a derivative contributes and what suspect causes change of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Consequence {
    /// Motion of its regressor times the estimate over the motion of the coefficient, in the manoeuvres of the fit.
    pub share: f64,
    /// Motion of its regressor over that of the coefficient: times a change of the estimate, the part of the motion this moves.
    #[serde(skip)]
    pub motion_ratio: f64,
    pub effects: Vec<Effect>,
}

impl Footprint for Verdicts {
    fn bytes(&self) -> usize {
        let fits = self.windows.values().flat_map(|window| &window.fits).chain(&self.pooled);
        fits.map(|fit| 128 + 64 * fit.derivatives.len()).sum::<usize>() + 512 * self.session.reasons.len()
    }
}

impl Verdicts {
    /// Verdict on the fit of `coefficient`, pooled or of one window.
    pub fn fit(&self, window: Option<&str>, coefficient: Coefficient) -> Option<&FitVerdict> {
        let fits = match window {
            None => &self.pooled,
            Some(name) => &self.windows.get(name)?.fits,
        };
        fits.iter().find(|fit| fit.coefficient == coefficient)
    }

    /// Coefficients of the model that no window is used for.
    pub fn unused(&self) -> impl Iterator<Item = &FitVerdict> {
        self.pooled.iter().filter(|fit| fit.is_unused)
    }

    /// The verdict in one line: its level with the coefficients that are worse, how many manoeuvres are good, and the other coefficients
    /// by level, the worst first.
    pub fn headline(&self) -> String {
        if self.windows.is_empty() {
            return format!("{}: no manoeuvre, nothing is estimated", self.session.level.name());
        }
        let level = self.session.level;
        let good = self.windows.values().filter(|window| window.verdict.level == Level::Good).count();
        let windows = format!("{good} of {} manoeuvres good", self.windows.len());
        let fits_of_level = |level: Level| -> Option<String> {
            let fits = self.pooled.iter().filter(|fit| fit.verdict.level == level);
            let names: Vec<&str> = fits.map(|fit| fit.coefficient.name()).collect();
            (!names.is_empty()).then(|| format!("{} {}", names.join(", "), level.name()))
        };
        let of_levels = |is_worse: bool| {
            let levels = [Level::Bad, Level::Caution, Level::Good].into_iter();
            levels.filter(move |one| (*one > level) == is_worse).filter_map(&fits_of_level)
        };
        let worse: Vec<String> = of_levels(true).collect();
        let except = if worse.is_empty() { String::new() } else { format!(" except {}", worse.join(", ")) };
        let parts: Vec<String> = std::iter::once(windows).chain(of_levels(false)).collect();
        format!("{}{except}: {}", level.name(), parts.join("; "))
    }
}

impl FitVerdict {
    /// Adds what speaks against the fit as a whole.
    pub(crate) fn add(&mut self, findings: Vec<Finding>) {
        let reasons = std::mem::take(&mut self.verdict.reasons);
        self.verdict = Verdict::from_findings(reasons.into_iter().chain(findings));
    }

    /// Verdict on the derivative called `name`.
    pub fn derivative(&self, name: &str) -> Option<&Verdict> {
        self.derivatives.iter().find(|derivative| derivative.name == name).map(|derivative| &derivative.verdict)
    }

    /// What suspect causes change of the derivative called `name`.
    pub fn consequence(&self, name: &str) -> Option<&Consequence> {
        self.derivatives.iter().find(|derivative| derivative.name == name)?.consequence.as_ref()
    }
}

/// A verdict in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct VerdictCounts {
    /// Level of the session.
    pub level: Level,
    /// Derivatives of the pooled fits that are good.
    pub good: usize,
    /// Those that are a caution.
    pub caution: usize,
    /// Those that are bad.
    pub bad: usize,
}

impl VerdictCounts {
    /// Those of `verdicts`, without constants: the level of a derivative is the worse of its own and of its fit's.
    pub fn count(verdicts: &Verdicts) -> Self {
        let mut counts = Self { level: verdicts.session.level, ..Self::default() };
        for fit in &verdicts.pooled {
            for derivative in fit.derivatives.iter().filter(|derivative| !is_constant_name(&derivative.name)) {
                match derivative.verdict.level.max(fit.verdict.level) {
                    Level::Good => counts.good += 1,
                    Level::Caution => counts.caution += 1,
                    Level::Bad => counts.bad += 1,
                }
            }
        }
        counts
    }
}
