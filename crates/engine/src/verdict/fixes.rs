//! The fixes of a session's findings.

use crate::session::Fix;
use crate::snapshot::Verdicts;

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
