//! The hypotheses that remove contradictions: few mistakes that make many relations hold.

use rayon::prelude::*;

use super::changes::{Candidate, Cure, candidates};
use super::line::Figures;
use super::motion::{COMPARED, Motion};
use super::outcome::{Outcome, Relation};
use crate::quantity::Role;

/// Most mistakes looked for in one recording.
const MOST_MISTAKES: usize = 10;
/// Weight of a relation that nothing but a wrong channel breaks, and of the others.
const EXACT_WEIGHT: f64 = 2.0;
const WEIGHT: f64 = 1.0;
/// A relation that held and no longer does counts this many times; a response but once, for its cause may be turned, too.
const BROKEN: f64 = 3.0;

/// Scores nearer than this are the same: slopes of one hypothesis and another differ by noise.
const SAME_SCORE: f64 = 0.02;

/// A mistake that was found.
#[derive(Clone, Debug)]
pub(super) struct Mistake {
    /// What removes it.
    pub cures: Vec<Cure>,
    /// Relations that hold once it is removed, with their numbers before and after; the most telling first.
    pub repaired: Vec<(Relation, Figures, Figures)>,
    /// Other cures that would do as well.
    pub rivals: Vec<Cure>,
    /// The motion before and after.
    pub motions: [Motion; 2],
}

/// What was found in the end.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// Mistakes in the order they were found.
    pub mistakes: Vec<Mistake>,
    /// Every relation after the cures.
    pub outcomes: Vec<(Relation, Outcome)>,
}

/// A candidate with what it does.
struct Trial {
    candidate: Candidate,
    repaired: Vec<(Relation, Figures, Figures)>,
    score: f64,
    motion: Motion,
}

/// Looks for mistakes until every relation holds or nothing explains what is left.
pub(super) fn search(mut motion: Motion, relations: &[Relation]) -> Found {
    let mut outcomes = judge(relations, &motion);
    let mut mistakes = Vec::new();
    while mistakes.len() < MOST_MISTAKES {
        let suspects = suspects(&outcomes);
        let all = candidates(&motion, &suspects).into_par_iter();
        let mut trials: Vec<Trial> = all.filter_map(|candidate| attempt(candidate, &motion, &outcomes)).collect();
        trials.sort_by(|a, b| rounded(b.score).total_cmp(&rounded(a.score)).then(rank(a).total_cmp(&rank(b))));
        let mut trials = trials.into_iter();
        let Some(best) = trials.next() else { break };
        let mends = |trial: &Trial| -> Vec<(Role, &'static str)> {
            let mut names: Vec<_> = trial.repaired.iter().map(|(one, ..)| (one.compared(), one.with())).collect();
            names.sort_unstable();
            names
        };
        let as_good = trials.filter(|other| {
            other.score > best.score - SAME_SCORE
                && other.candidate.cost <= best.candidate.cost
                && mends(other) == mends(&best)
        });
        let rivals = as_good.flat_map(|other| other.candidate.cures).collect();
        let before = std::mem::replace(&mut motion, best.motion);
        let motions = [before, motion.clone()];
        outcomes = judge(relations, &motion);
        mistakes.push(Mistake { cures: best.candidate.cures, repaired: best.repaired, rivals, motions });
    }
    Found { mistakes, outcomes }
}

/// What every relation says of `motion`.
fn judge(relations: &[Relation], motion: &Motion) -> Vec<(Relation, Outcome)> {
    relations.par_iter().map(|relation| (*relation, relation.judge(motion))).collect()
}

/// A score to the steps that count.
fn rounded(score: f64) -> f64 {
    (score / SAME_SCORE).round()
}

/// Among candidates that repair as much: cheap ones first, then those that change what is compared.
fn rank(trial: &Trial) -> f64 {
    let compared = trial.repaired.first().map(|(relation, ..)| relation.compared());
    let changes = trial.candidate.cures.iter().any(|cure| compared.is_some_and(|role| cure.roles().contains(&role)));
    let left: f64 = trial.repaired.iter().map(|(_, _, after)| after.disagreement.min(1.0)).sum();
    trial.candidate.cost + if changes { 0.0 } else { 0.05 } + 1e-3 * left
}

/// Channels that enter relations which do not hold.
fn suspects(outcomes: &[(Relation, Outcome)]) -> Vec<Role> {
    let differs = |role: &Role| {
        outcomes.iter().any(|(relation, outcome)| matches!(outcome, Outcome::Differs(_)) && relation.involves(*role))
    };
    COMPARED.into_iter().filter(differs).collect()
}

/// What a candidate does to the relations its channels enter; `None` where it repairs none or breaks as much.
fn attempt(candidate: Candidate, motion: &Motion, outcomes: &[(Relation, Outcome)]) -> Option<Trial> {
    let changed = candidate.cures.iter().fold(motion.clone(), |motion, cure| cure.applied(motion));
    let roles: Vec<Role> = candidate.cures.iter().flat_map(Cure::roles).collect();
    let (mut repaired, mut score) = (Vec::new(), 0.0);
    let entered = || outcomes.iter().filter(|(relation, _)| roles.iter().any(|role| relation.involves(*role)));
    let is_swap = matches!(candidate.cures[..], [Cure::Swap { .. }]);
    let weight = |relation: &Relation| if relation.is_exact() { EXACT_WEIGHT } else { WEIGHT };
    // What does not hold comes first: most candidates mend nothing, and the rest need not be computed.
    for (relation, before) in entered() {
        let Outcome::Differs(was) = before else { continue };
        let after = relation.judge(&changed);
        match &after {
            Outcome::Fits(is) if relation.is_repaired(before, &after) => {
                // Of two units the one whose slope is nearer to one.
                let slope = if matches!(relation, Relation::Kinematic(_) | Relation::Air(_)) { is.slope } else { 1.0 };
                score += weight(relation) * (1.0 - slope.ln().abs());
                repaired.push((*relation, *was, *is));
            }
            Outcome::Fits(_) => score += 0.25 * weight(relation),
            // Of two exchanged surfaces the one that rested now rests in the other's place.
            Outcome::Undetermined if is_swap && matches!(relation, Relation::Response(_)) => {
                score += 0.5 * weight(relation);
                repaired.push((*relation, *was, *was));
            }
            _ => {}
        }
    }
    if repaired.is_empty() {
        return None;
    }
    for (relation, before) in entered() {
        score -= weight(relation)
            * match (before, relation.judge(&changed)) {
                (Outcome::Fits(_), Outcome::Differs(_)) if !matches!(relation, Relation::Response(_)) => BROKEN,
                (Outcome::Fits(_), Outcome::Differs(_)) => 1.0,
                (Outcome::Fits(_), Outcome::Undetermined) | (Outcome::Undetermined, Outcome::Differs(_)) => 1.0,
                _ => 0.0,
            };
    }
    repaired.sort_by(|a, b| {
        let rank = |one: &(Relation, Figures, Figures)| (roles.contains(&one.0.compared()), one.0.is_exact());
        rank(b).cmp(&rank(a)).then(b.2.r2.total_cmp(&a.2.r2))
    });
    (score > 0.0).then_some(Trial { candidate, repaired, score, motion: changed })
}
