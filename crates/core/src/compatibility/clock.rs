//! The clock itself: slopes in time against what is a slope in time.

use rayon::prelude::*;

use super::changes::ChannelFix;
use super::motion::{Motion, Pace, pace};
use super::outcome::{Outcome, Relation};
use super::relations::ClockEffect;
use super::rows::{Agreement, CompatibilityRow};
use crate::quantity::Role;
use crate::series::Recording;
use crate::statistics::{extent, median};

/// Slowest rate that is not asked about, Hz.
const SLOWEST_HZ: f64 = 0.5;
/// Fastest one, Hz.
const FASTEST_HZ: f64 = 2e4;
/// Longest span that is not asked about, s: a day.
const LONGEST_S: f64 = 86_400.0;
/// Shortest one, s.
const SHORTEST_S: f64 = 1.0;
/// Farthest slope from one under the right unit.
const RIGHT_SLOPE: f64 = 0.15;
/// Squared correlation of a slope that counts.
const CLEAR_R2: f64 = 0.8;
/// Error of a clock that is worth a word.
const WORTH_SAYING: f64 = 0.01;
/// Errors that turning and moving show lie within this of each other, and each is this large.
const AGREEMENT: f64 = 0.01;
const EACH: f64 = 0.007;
/// Squared correlation of slopes precise enough to tell one.
const PRECISE_R2: f64 = 0.98;
/// Slopes of turning, and those of moving, lie within this of each other: a filter, a limit or coarse steps of one channel change its
/// slope alone.
const ALIKE: f64 = 0.015;
/// Fewest slopes that tell one.
const FEWEST_SLOPES: usize = 3;

/// Factors on the seconds as read, by the unit the numbers are in. Of `s` the numbers were taken for a smaller unit.
const UNITS: [(f64, &str); 9] = [
    (1e-3, "ms"),
    (1e-6, "us"),
    (1e-9, "ns"),
    (60.0, "min"),
    (3600.0, "h"),
    (86_400.0, "d"),
    (1e3, "s"),
    (1e6, "s"),
    (1e9, "s"),
];

/// A unit of the ticks with its factor to seconds, the relations it tells and those that hold, and the motion it makes.
type Candidate = ((f64, &'static str), (usize, usize), Motion);

/// The clock judged, and the motion by it.
pub(super) struct Clocked {
    /// What there is to say of it.
    pub rows: Vec<CompatibilityRow>,
    /// The motion on the clock as fixed; none where no stretch is long enough.
    pub motion: Option<Motion>,
    /// What the stamps are multiplied by in it.
    pub factor: f64,
}

/// What the relations in which time enters say: how many tell, and how many hold.
fn votes(motion: &Motion, relations: &[Relation]) -> (usize, usize) {
    let timed = relations.par_iter().filter(|relation| relation.clock() != ClockEffect::None);
    let figures = timed.filter_map(|relation| match relation.judge(motion) {
        // A turned sign is not the clock's.
        Outcome::Fits(figures) | Outcome::Differs(figures) => {
            Some((figures.slope.abs() - 1.0).abs() <= RIGHT_SLOPE && figures.r2 > CLEAR_R2)
        }
        Outcome::Absent | Outcome::Undetermined => None,
    });
    let holds: Vec<bool> = figures.collect();
    (holds.len(), holds.into_iter().filter(|holds| *holds).count())
}

fn is_plausible(pace: &Pace, factor: f64) -> bool {
    let (rate_hz, span_s) = (pace.rate_hz / factor, pace.span_s * factor);
    (SLOWEST_HZ..=FASTEST_HZ).contains(&rate_hz) && (SHORTEST_S..=LONGEST_S).contains(&span_s)
}

/// Judges the clock of a recording: the unit of its ticks, and whether it runs as fast as the motion.
pub(super) fn judge(recording: &Recording, relations: &[Relation]) -> Clocked {
    let Some(pace) = pace(recording) else { return Clocked { rows: Vec::new(), motion: None, factor: 1.0 } };
    let motion = Motion::new(recording, 1.0);
    let (decisive, hold) = motion.as_ref().map_or((0, 0), |motion| votes(motion, relations));
    let plausible = is_plausible(&pace, 1.0);
    if hold == 0 && (decisive > 0 || !plausible) {
        let others = UNITS.into_iter().filter(|(factor, _)| is_plausible(&pace, *factor));
        let mut best: Option<Candidate> = None;
        let mut possible = Vec::new();
        for (factor, unit) in others {
            possible.push((factor, unit));
            let Some(scaled) = Motion::new(recording, factor) else { continue };
            let votes = votes(&scaled, relations);
            let is_best = best.as_ref().is_none_or(|(_, most, _)| votes.1 > most.1);
            if votes.1 > 0 && 2 * votes.1 >= votes.0 && is_best {
                best = Some(((factor, unit), votes, scaled));
            }
        }
        if let Some(((factor, unit), votes, motion)) = best {
            return Clocked { rows: vec![in_unit(&pace, factor, unit, votes)], motion: Some(motion), factor };
        }
        if !plausible {
            // Under stamps that make no recording of flight nothing else can be checked.
            let likely = possible.first().and_then(|(factor, _)| Some((Motion::new(recording, *factor)?, *factor)));
            let rows = vec![ask_time_unit(&pace, &possible)];
            let (motion, factor) = match likely {
                Some((motion, factor)) => (Some(motion), factor),
                None => (motion, 1.0),
            };
            return Clocked { rows, motion, factor };
        }
    }
    let rows = motion.as_ref().and_then(|motion| common_error(motion, relations)).into_iter().collect();
    Clocked { rows, motion, factor: 1.0 }
}

fn pace_in_words(pace: &Pace, factor: f64) -> String {
    format!("{:.4} samples per second over {:.1} s", pace.rate_hz / factor, pace.span_s * factor)
}

fn in_unit(pace: &Pace, factor: f64, unit: &'static str, (decisive, hold): (usize, usize)) -> CompatibilityRow {
    let fix = ChannelFix::Clock { factor, unit: Some(unit) };
    let evidence = format!(
        "time unit is probably {}: {hold} of {decisive} integrals then match (as read: {})",
        fix.hypothesis(),
        pace_in_words(pace, 1.0),
    );
    CompatibilityRow::of_clock(Agreement::Contradicts, Some(fix), evidence, None, hold)
}

fn ask_time_unit(pace: &Pace, possible: &[(f64, &'static str)]) -> CompatibilityRow {
    let as_read = pace_in_words(pace, 1.0);
    let (fix, evidence) = match possible.first() {
        Some(&(factor, unit)) => {
            let fix = ChannelFix::Clock { factor, unit: Some(unit) };
            let words = fix.hypothesis();
            let then = pace_in_words(pace, factor);
            (
                Some(fix),
                format!(
                    "as read {as_read}; as {words} {then} (used for the other checks): state the unit of the time stamps"
                ),
            )
        }
        None => (None, format!("as read {as_read}: state the unit of the time stamps")),
    };
    CompatibilityRow::of_clock(Agreement::Doubtful, fix, evidence, None, 0)
}

/// A clock error that turning and moving share: a gyroscope's scale shows in one of them alone.
fn common_error(motion: &Motion, relations: &[Relation]) -> Option<CompatibilityRow> {
    let precise = relations.par_iter().filter(|relation| relation.is_exact() && !relation.involves(Role::Altitude));
    let precise: Vec<_> = precise.map(|relation| (relation, relation.judge(motion))).collect();
    let (mut turning, mut moving, mut unsure) = (Vec::new(), Vec::new(), Vec::new());
    for (relation, outcome) in precise {
        let Outcome::Fits(figures) = outcome else { continue };
        let too_long = match relation.clock() {
            ClockEffect::Multiplies => figures.slope,
            ClockEffect::Divides => 1.0 / figures.slope,
            ClockEffect::None => continue,
        };
        if figures.r2 > PRECISE_R2 {
            let turns = matches!(relation.compared(), Role::RollRate | Role::PitchRate | Role::YawRate);
            if turns { &mut turning } else { &mut moving }.push(too_long - 1.0);
            // Noise of one side alone moves the slope of the reduced major axis by 1 - r.
            unsure.push(1.0 - figures.r2.sqrt());
        }
    }
    let count = turning.len() + moving.len();
    let is_alike = |slopes: &[f64]| extent(slopes).is_none_or(|[least, greatest]| greatest - least < ALIKE);
    if !is_alike(&turning) || !is_alike(&moving) {
        return None;
    }
    let (turns, moves) = (median(&mut turning)?, median(&mut moving)?);
    let common = 0.5 * (turns + moves);
    let apart = (turns - moves).abs() > AGREEMENT || turns.abs().min(moves.abs()) < EACH || turns * moves < 0.0;
    let least = WORTH_SAYING + median(&mut unsure)?;
    if apart || common.abs() < least || count < FEWEST_SLOPES {
        return None;
    }
    let (percent, words) = (100.0 * common.abs(), if common > 0.0 { "far apart" } else { "close together" });
    let evidence = format!(
        "{count} rates against their integrals: slope {:.3} in rotation, {:.3} in translation; time stamps {percent:.1} % too {words}",
        1.0 + turns,
        1.0 + moves
    );
    let fix = ChannelFix::Clock { factor: 1.0 / (1.0 + common), unit: None };
    Some(CompatibilityRow::of_clock(Agreement::Doubtful, Some(fix), evidence, Some(1.0 + common), count))
}
