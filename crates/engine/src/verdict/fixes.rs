//! The fixes of a session's findings, and a verdict in numbers.

use serde::Serialize;

use super::{Level, Verdicts};
use crate::session::Fix;

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
    /// Those of `verdicts`: the level of a derivative is the worse of its own and of its fit's.
    pub fn count(verdicts: &Verdicts) -> Self {
        let mut counts = Self { level: verdicts.session.level, ..Self::default() };
        for fit in &verdicts.pooled {
            for derivative in &fit.derivatives {
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

/// The fixes of the findings of a session and of its pooled derivatives, in their order, each with the place of its first finding.
pub fn fixes(verdicts: &Verdicts) -> Vec<(&Fix, &str)> {
    let fits = verdicts.pooled.iter();
    let of_fits = fits.flat_map(|fit| {
        let derivatives = fit.derivatives.iter().flat_map(|derivative| &derivative.verdict.reasons);
        fit.verdict.reasons.iter().chain(derivatives)
    });
    let mut fixes: Vec<(&Fix, &str)> = Vec::new();
    for finding in verdicts.session.reasons.iter().chain(of_fits) {
        let Some(fix) = &finding.fix else { continue };
        if fixes.iter().all(|(known, _)| known.edits != fix.edits) {
            fixes.push((fix, &finding.place));
        }
    }
    fixes
}
