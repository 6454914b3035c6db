//! The hypotheses that remove contradictions: few mistakes that make many relations hold.

use std::cell::OnceCell;

use rayon::prelude::*;

use super::accelerometer::reversed_residuals;
use super::changes::{Candidate, ChannelFix, SPECIFIC_FORCE, candidates, turned_together};
use super::line::Figures;
use super::motion::{COMPARED, Motion, is_signed};
use super::outcome::{Outcome, Relation};
use super::rows::{CompatibilityRow, mistake_rows};
use crate::quantity::Role;

/// Most mistakes looked for in one recording.
const MOST_MISTAKES: usize = 10;
/// Weight of a relation that nothing but a wrong channel breaks, and of the others.
const EXACT_WEIGHT: f64 = 2.0;
const WEIGHT: f64 = 1.0;
/// A relation that held and no longer does counts this many times; a response but once, for its cause may be turned, too.
const BROKEN: f64 = 3.0;

/// A relation that held before channels were exchanged or turned holds better then when no more than this part of its disagreement is
/// left, and counts so.
const SHARPENED: f64 = 0.5;
const SHARPENED_WEIGHT: f64 = 0.5;
/// Lines that tell the sign of a specific force that its own relation does not tell.
const LINES_OF_TURN: usize = 2;
/// A channel tells its unit in a relation only where that holds better with the channel than without: by no more than this part of the
/// disagreement that is left without it.
const OWN_PART: f64 = 0.5;
/// Or where it was off by this part of the factor at least, in logarithms: numbers so large are those of another unit.
const AS_FAR: f64 = 0.4;
/// What a line usually leaves unexplained: its slope counts as much as it leaves less, within these factors.
const USUAL_LEFT: f64 = 0.05;
const LEAST_CLEAR: f64 = 0.3;
const MOST_CLEAR: f64 = 2.0;
/// A unit is named where a slope lies this near to one after the fix, and a line this clear or as many segments tell it.
const SLOPE_OF_UNIT: f64 = 0.15;
pub(super) const CLEAR_R2: f64 = 0.98;
const SEGMENTS_OF_UNIT: usize = 2;
/// Most that a slope is off one of an airspeed that is calibrated.
const AS_CALIBRATED: f64 = 0.04;
/// Slopes and least squared correlation of a channel that runs against what it is compared with.
pub(super) const OPPOSITE_SLOPE: std::ops::RangeInclusive<f64> = -1.25..=-0.8;
pub(super) const OPPOSITE_R2: f64 = 0.9;

/// Scores nearer than this are the same: slopes of one hypothesis and another differ by noise.
const SAME_SCORE: f64 = 0.02;

#[derive(Clone, Debug)]
pub(super) struct Mistake {
    /// What removes it.
    pub fixes: Vec<ChannelFix>,
    /// Whether it is that of linear acceleration, as in [`Candidate`].
    pub is_linear: bool,
    /// Relations that hold once it is removed, with their numbers before and after; the most telling first.
    pub repaired: Vec<Repaired>,
    /// Relations that held before and hold much better once it is removed.
    pub sharpened: Vec<Repaired>,
    /// Other fixes that would do as well.
    pub rivals: Vec<ChannelFix>,
    /// The motion before and after.
    pub motions: [Motion; 2],
}

/// What was found in the end.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// Mistakes in the order they were found.
    pub mistakes: Vec<Mistake>,
    /// Every relation after the fixes.
    pub outcomes: Vec<(Relation, Outcome)>,
}

/// A relation that holds by a hypothesis, with its numbers before and after.
pub(super) type Repaired = (Relation, Figures, Figures);

/// A candidate with what it does.
struct Trial {
    candidate: Candidate,
    repaired: Vec<Repaired>,
    sharpened: Vec<Repaired>,
    score: f64,
    motion: Motion,
}

/// Looks for mistakes until every relation holds or nothing explains what is left.
pub(super) fn search(mut motion: Motion, relations: &[Relation]) -> Found {
    let mut outcomes = judge(relations, &motion);
    let mut mistakes = Vec::new();
    while mistakes.len() < MOST_MISTAKES {
        let tried = |all: Vec<Candidate>| -> Vec<Trial> {
            all.into_par_iter().filter_map(|candidate| attempt(candidate, &motion, &outcomes)).collect()
        };
        let mut trials = tried(candidates(&motion, &suspects(&outcomes)));
        if trials.is_empty() {
            trials = tried(turned_together(&opposite(&outcomes)));
        }
        trials.sort_by(|a, b| rounded(b.score).total_cmp(&rounded(a.score)).then(rank(a).total_cmp(&rank(b))));
        let mut trials = trials.into_iter();
        let Some(best) = trials.next() else { break };
        let as_good = trials.filter(|other| {
            other.score > best.score - SAME_SCORE
                && other.candidate.cost <= best.candidate.cost
                && list_mended(other) == list_mended(&best)
        });
        let rivals = as_good.flat_map(|other| other.candidate.fixes).collect();
        let before = std::mem::replace(&mut motion, best.motion);
        let motions = [before, motion.clone()];
        outcomes = judge(relations, &motion);
        let Candidate { fixes, is_linear, .. } = best.candidate;
        let (repaired, sharpened) = (best.repaired, best.sharpened);
        mistakes.push(Mistake { fixes, is_linear, repaired, sharpened, rivals, motions });
    }
    Found { mistakes, outcomes }
}

fn list_mended(trial: &Trial) -> Vec<(Role, &'static str)> {
    let mut names: Vec<_> = trial.repaired.iter().map(|(one, ..)| (one.compared(), one.with())).collect();
    names.sort_unstable();
    names
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
    let changes = trial.candidate.fixes.iter().any(|fix| compared.is_some_and(|role| fix.roles().contains(&role)));
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

/// Channels with a sign that run against what they are compared with.
fn opposite(outcomes: &[(Relation, Outcome)]) -> Vec<Role> {
    let runs = |role: &Role| {
        outcomes.iter().any(|(relation, outcome)| relation.compared() == *role && runs_against(relation, outcome))
    };
    COMPARED.into_iter().filter(|role| is_signed(*role)).filter(runs).collect()
}

fn runs_against(relation: &Relation, outcome: &Outcome) -> bool {
    match outcome {
        Outcome::Differs(figures) if relation.is_of_lines() => {
            OPPOSITE_SLOPE.contains(&figures.slope) && figures.r2 > OPPOSITE_R2
        }
        _ => false,
    }
}

/// What a candidate does to the relations its channels enter; `None` where it repairs none or breaks as much.
fn attempt(candidate: Candidate, motion: &Motion, outcomes: &[(Relation, Outcome)]) -> Option<Trial> {
    let changed = candidate.applied(motion);
    let roles = candidate.roles();
    let entered = || outcomes.iter().filter(|(relation, _)| roles.iter().any(|role| relation.involves(*role)));
    let (mut repaired, mut score) = repair(&candidate, motion, &changed, entered());
    let is_named = match candidate.fixes[..] {
        [ChannelFix::Reassign { .. }] => tells_calibrated(&repaired),
        _ => candidate.roles_of_units().is_empty() || tells_unit(&repaired),
    };
    if repaired.is_empty() || !is_named {
        return None;
    }
    let mut sharpened = Vec::new();
    for (relation, before) in entered() {
        let lost = match (before, relation.judge(&changed)) {
            (Outcome::Fits(_), Outcome::Differs(_)) if !matches!(relation, Relation::Response(_)) => BROKEN,
            (Outcome::Fits(_), Outcome::Differs(_)) => 1.0,
            (Outcome::Fits(_), Outcome::Undetermined) | (Outcome::Undetermined, Outcome::Differs(_)) => 1.0,
            (Outcome::Fits(was), Outcome::Fits(is))
                if is_turn(&candidate) && relation.is_of_lines() && is.disagreement < SHARPENED * was.disagreement =>
            {
                sharpened.push((*relation, *was, is));
                -SHARPENED_WEIGHT
            }
            _ => 0.0,
        };
        score -= weight(relation) * lost;
    }
    repaired.sort_by(|a, b| {
        let rank = |one: &Repaired| (roles.contains(&one.0.compared()), one.0.is_exact(), one.0.is_of_lines());
        rank(b).cmp(&rank(a)).then(b.2.r2.total_cmp(&a.2.r2))
    });
    (score > 0.0).then_some(Trial { candidate, repaired, sharpened, score, motion: changed })
}

/// The motion with the sign of a specific force reversed whose own relation shows nothing, and the rows that say so: where lines it enters
/// hold much better then and none holds less, or the ground velocity shows it. Before the place of the accelerometers is sought: a
/// reversed axis gives a wrong one.
pub(super) fn turn_force(motion: Motion, relations: &[Relation]) -> (Vec<CompatibilityRow>, Motion) {
    let outcomes = judge(relations, &motion);
    let is_own =
        |relation: &Relation, role: Role| matches!(relation, Relation::Kinematic(_)) && relation.compared() == role;
    let is_silent = |role: &Role| {
        let mut own = outcomes.iter().filter(|(relation, _)| is_own(relation, *role));
        motion.has(*role) && own.all(|(_, outcome)| matches!(outcome, Outcome::Undetermined))
    };
    let silent: Vec<Role> = SPECIFIC_FORCE.into_iter().filter(is_silent).collect();
    if let Some(trial) = silent.iter().find_map(|role| turned_force(*role, &motion, &outcomes)) {
        let Trial { candidate: Candidate { fixes, is_linear, .. }, repaired, sharpened, motion: turned, .. } = trial;
        let motions = [motion, turned.clone()];
        let mistake = Mistake { fixes, is_linear, repaired, sharpened, rivals: Vec::new(), motions };
        return (mistake_rows(&mistake), turned);
    }
    let by_velocity = |role: &Role| Some((*role, reversed_residuals(&motion, *role)?));
    match silent.iter().find_map(by_velocity) {
        None => (Vec::new(), motion),
        Some((role, residuals_m_s)) => {
            let row = CompatibilityRow::of_reversed_force(role, residuals_m_s);
            (vec![row], Candidate::turned(role).applied(&motion))
        }
    }
}

fn turned_force(role: Role, motion: &Motion, outcomes: &[(Relation, Outcome)]) -> Option<Trial> {
    let candidate = Candidate::turned(role);
    let changed = candidate.applied(motion);
    let mut repaired: Vec<Repaired> = Vec::new();
    for (relation, before) in outcomes.iter().filter(|(relation, _)| relation.involves(role)) {
        match (before, relation.judge(&changed)) {
            (Outcome::Fits(was), Outcome::Fits(is)) if relation.is_of_lines() => {
                if is.disagreement > was.disagreement {
                    return None;
                }
                if is.disagreement < SHARPENED * was.disagreement {
                    repaired.push((*relation, *was, is));
                }
            }
            (Outcome::Fits(_), Outcome::Differs(_) | Outcome::Undetermined)
            | (Outcome::Undetermined, Outcome::Differs(_)) => return None,
            _ => {}
        }
    }
    repaired.sort_by(|a, b| b.1.disagreement.total_cmp(&a.1.disagreement));
    let score = repaired.len() as f64;
    let is_told = repaired.len() >= LINES_OF_TURN;
    is_told.then_some(Trial { candidate, repaired, sharpened: Vec::new(), score, motion: changed })
}

/// Whether channels are exchanged and nothing else is done.
fn is_swap(candidate: &Candidate) -> bool {
    candidate.fixes.iter().all(|fix| matches!(fix, ChannelFix::Swap { .. }))
}

/// Whether channels are exchanged or signs turned and nothing else is done: a factor can be chosen for what it sharpens, these cannot.
fn is_turn(candidate: &Candidate) -> bool {
    candidate.fixes.iter().all(is_turn_fix)
}

fn is_turn_fix(fix: &ChannelFix) -> bool {
    match fix {
        ChannelFix::Swap { .. } => true,
        ChannelFix::Scale { factor, offset, units: None, .. } => *factor == -1.0 && *offset == 0.0,
        _ => false,
    }
}

fn weight(relation: &Relation) -> f64 {
    if relation.is_exact() { EXACT_WEIGHT } else { WEIGHT }
}

/// The relations that `candidate`, which makes `changed` of `motion`, repairs, and what that scores. What does not hold comes first: most
/// candidates mend nothing, and the rest need not be computed.
fn repair<'a>(
    candidate: &Candidate,
    motion: &Motion,
    changed: &Motion,
    entered: impl Iterator<Item = &'a (Relation, Outcome)>,
) -> (Vec<Repaired>, f64) {
    let (mut repaired, mut score) = (Vec::new(), 0.0);
    let of_units = candidate.roles_of_units();
    let resting = OnceCell::new();
    let rest = || of_units.iter().fold(motion.clone(), |motion, role| motion.changed(*role, |_| 0.0));
    for (relation, before) in entered {
        let Outcome::Differs(was) = before else { continue };
        let after = relation.judge(changed);
        match &after {
            Outcome::Fits(is)
                if relation.is_repaired(before, &after)
                    && (of_units.is_empty()
                        || is_as_far_off(candidate, was)
                        || needs_channel(relation, is, resting.get_or_init(rest))) =>
            {
                let lost = if relation.is_of_lines() { off_one(is) } else { 0.0 };
                score += weight(relation) * (1.0 - lost);
                repaired.push((*relation, *was, *is));
            }
            Outcome::Fits(_) => score += 0.25 * weight(relation),
            // Of two exchanged surfaces the one that rested now rests in the other's place.
            Outcome::Undetermined if is_swap(candidate) && matches!(relation, Relation::Response(_)) => {
                score += 0.5 * weight(relation);
                repaired.push((*relation, *was, *was));
            }
            _ => {}
        }
    }
    (repaired, score)
}

/// How far a slope is off one, more where the line is clear: of two units the one whose slope is nearer.
fn off_one(figures: &Figures) -> f64 {
    figures.slope.ln().abs() * (USUAL_LEFT / (1.0 - figures.r2).max(f64::MIN_POSITIVE)).clamp(LEAST_CLEAR, MOST_CLEAR)
}

/// Whether a relation holds by what the channels say whose unit is changed: where it holds as well with them at rest, any factor that
/// makes them small enough does.
fn needs_channel(relation: &Relation, with: &Figures, without: &Motion) -> bool {
    if matches!(relation, Relation::Size(_) | Relation::Travel(_)) {
        return true;
    }
    match relation.judge(without) {
        Outcome::Fits(without) => with.disagreement < OWN_PART * without.disagreement,
        _ => true,
    }
}

/// Whether a relation was off as far as a wrong unit makes it: the other channels that enter hide a part of its factor.
fn is_as_far_off(candidate: &Candidate, was: &Figures) -> bool {
    let log_factor =
        |fix: &ChannelFix| if let ChannelFix::Scale { factor, .. } = fix { factor.abs().ln().abs() } else { 0.0 };
    let factor = candidate.fixes.iter().map(log_factor).fold(0.0, f64::max);
    was.slope.abs().ln().abs() > AS_FAR * factor
}

/// Whether an airspeed taken as a calibrated one is so near to what clear lines say that no other factor is meant.
fn tells_calibrated(repaired: &[Repaired]) -> bool {
    let clear = repaired.iter().filter(|(relation, _, after)| relation.is_of_lines() && after.r2 > CLEAR_R2);
    clear.map(|(.., after)| after.slope.ln().abs()).all(|off| off < AS_CALIBRATED)
}

/// Whether what is repaired is enough to name a unit: a size no aircraft has, or lines.
fn tells_unit(repaired: &[Repaired]) -> bool {
    if repaired.iter().any(|(relation, ..)| matches!(relation, Relation::Size(_) | Relation::Travel(_))) {
        return true;
    }
    let lines = || repaired.iter().filter(|(relation, ..)| relation.is_of_lines());
    let segments: usize = lines().map(|(.., after)| after.segments).sum();
    let is_clear = lines().any(|(.., after)| after.r2 > CLEAR_R2);
    let is_near = lines().any(|(.., after)| after.slope.ln().abs() < SLOPE_OF_UNIT.ln_1p());
    lines().next().is_none() || is_near && (is_clear || segments >= SEGMENTS_OF_UNIT)
}

#[cfg(test)]
mod tests {
    use super::super::relations::RELATIONS;
    use super::*;

    #[test]
    fn a_unit_is_told_by_a_clear_line_or_by_several_segments_near_one() {
        let line = |slope: f64, r2: f64, segments: usize| {
            let before = Figures { slope: 0.35, r2, disagreement: 0.8, segments, predicted: true };
            let after = Figures { slope, disagreement: 0.1, ..before };
            (Relation::Kinematic(&RELATIONS[0]), before, after)
        };
        // Side force of a fighter whose accelerometers are filtered: 3.28 times as large it would fit, in one segment, badly.
        assert!(!tells_unit(&[line(1.16, 0.906, 1)]));
        assert!(!tells_unit(&[line(1.05, 0.906, 1)]) && !tells_unit(&[line(1.16, 0.999, 5)]));
        assert!(tells_unit(&[line(1.05, 0.999, 1)]) && tells_unit(&[line(1.05, 0.906, 2)]));
        assert!(tells_unit(&[line(1.16, 0.906, 1), line(0.99, 0.93, 1)]));
    }
}
