//! The fixes of a session's findings.

use super::Finding;
use crate::session::{Edit, Fix, Place, WindowEdit};
use crate::snapshot::Verdicts;

/// The fixes of the findings of a session and of its pooled derivatives, in their order, each with the place of its first finding. Those
/// of one kind that shorten manoeuvres or exclude parts of them are one.
pub fn fixes(verdicts: &Verdicts) -> Vec<(Fix, &Place)> {
    let fits = verdicts.pooled.iter();
    let of_fits = fits.flat_map(|fit| {
        let derivatives = fit.derivatives.iter().flat_map(|derivative| &derivative.verdict.reasons);
        fit.verdict.reasons.iter().chain(derivatives)
    });
    let mut kinds: Vec<Vec<(&Finding, &Fix)>> = Vec::new();
    for finding in verdicts.session.reasons.iter().chain(of_fits) {
        let Some(fix) = &finding.fix else { continue };
        if kinds.iter().flatten().any(|(_, known)| known.edits == fix.edits) {
            continue;
        }
        let is_alike =
            |(first, known): &(&Finding, &Fix)| first.code == finding.code && is_of_parts(known) && is_of_parts(fix);
        match kinds.iter_mut().find(|kind| kind.first().is_some_and(is_alike)) {
            Some(kind) => kind.push((finding, fix)),
            None => kinds.push(vec![(finding, fix)]),
        }
    }
    let join = |kind: &Vec<(&'_ Finding, &'_ Fix)>| Fix::join(&kind.iter().map(|(_, fix)| *fix).collect::<Vec<_>>());
    kinds.iter().filter_map(|kind| Some((join(kind)?, &kind.first()?.0.place))).collect()
}

/// Whether a fix only places manoeuvres or excludes parts of them.
fn is_of_parts(fix: &Fix) -> bool {
    let is = |edit: &Edit| matches!(edit, Edit::Window(WindowEdit::Place { .. } | WindowEdit::Exclude { .. }));
    fix.edits.iter().all(is)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::{Level, Verdict};

    #[test]
    fn exclusions_of_one_kind_are_one_fix_and_others_stay_apart() {
        let exclude = |name: &str| {
            let (name, excluded) = (name.to_owned(), Vec::new());
            Fix::new("exclude", Edit::Window(WindowEdit::Exclude { name, excluded }))
        };
        let finding = |code, place: &str, fix: Fix| Finding::new(Level::Caution, code, place, "").with_fix(fix);
        let reasons = vec![
            finding("stuck", "a", exclude("a")),
            finding("stuck", "b", exclude("b")),
            finding("turn", "c", exclude("c")),
            finding("scatter", "d", Fix::ignore(["a"])),
            finding("scatter", "e", Fix::ignore(["b"])),
            finding("stuck", "f", exclude("a")),
        ];
        let verdicts = Verdicts { session: Verdict { level: Level::Caution, reasons }, ..Verdicts::default() };
        let found: Vec<_> =
            fixes(&verdicts).into_iter().map(|(fix, place)| (fix.edits.len(), place.to_string())).collect();
        assert_eq!(found, [(2, "a"), (1, "c"), (1, "d"), (1, "e")].map(|(edits, place)| (edits, place.to_owned())));
    }
}
