//! Measures against limits: levels, their reasons, and how likely they are.

use std::fmt;

use super::limits::{Airplane, Limit, Limits};
use super::measures::{Measure, Measures};

/// A level of flying qualities, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum QualityLevel {
    /// Clearly adequate.
    One,
    /// Adequate, with more work for the pilot or less effect.
    Two,
    /// Controllable.
    Three,
    /// A limit of Level 3 is violated.
    WorseThanThree,
}

impl QualityLevel {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::One, Self::Two, Self::Three, Self::WorseThanThree];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::One => "Level 1",
            Self::Two => "Level 2",
            Self::Three => "Level 3",
            Self::WorseThanThree => "worse than Level 3",
        }
    }

    /// What it is after limits up to this level are violated.
    fn after(violated: u8) -> Self {
        match violated {
            0 => Self::One,
            1 => Self::Two,
            2 => Self::Three,
            _ => Self::WorseThanThree,
        }
    }
}

/// A limit that keeps a measure from the next better level.
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// Measure.
    pub measure: Measure,
    /// Its value.
    pub value: f64,
    /// Whether it is below a minimum; else above a maximum.
    pub below: bool,
    /// The limit.
    pub bound: f64,
    /// Where the standard has it.
    pub source: String,
    /// What other readings of the standard have.
    pub disputed: Option<String>,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (sign, text) = (if self.below { '<' } else { '>' }, self.measure.text());
        if self.bound.is_infinite() {
            write!(f, "{text} is there")?;
        } else {
            write!(f, "{text} {sign} {}", self.bound)?;
        }
        if self.disputed.is_some() { f.write_str(" (disputed limit)") } else { Ok(()) }
    }
}

/// Level of one criterion.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Criterion.
    pub criterion: String,
    /// Its level; none where it was not judged.
    pub level: Option<QualityLevel>,
    /// Measures its limits are about.
    pub measures: Vec<Measure>,
    /// Values it was judged by.
    pub values: Vec<(Measure, f64)>,
    /// Limits that keep it from Level 1, each of its measure's own level; what is missing where it was not judged.
    pub reasons: Vec<Reason>,
    /// Whether it counts: a criterion whose limits are only remembered does not.
    pub counts: bool,
}

/// Levels of all criteria.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// Criteria in the order of the limits.
    pub qualities: Vec<Quality>,
    /// The worst level of those judged; none where none was.
    pub level: Option<QualityLevel>,
}

impl Judgement {
    /// A criterion.
    pub fn quality(&self, criterion: &str) -> Option<&Quality> {
        self.qualities.iter().find(|quality| quality.criterion == criterion)
    }

    /// Reasons why it is not Level 1.
    pub fn reasons(&self) -> impl Iterator<Item = &Reason> {
        self.qualities.iter().filter(|quality| quality.counts).flat_map(|quality| &quality.reasons)
    }
}

/// Judges measures. The level of a measure is one worse than the last level of which it violates a limit; a value equal to a limit
/// meets it; a criterion is as bad as its worst measure, the aircraft as its worst criterion. A criterion none of whose measures was
/// had is not judged, which does not count as met.
pub fn judge(limits: &Limits, airplane: &Airplane, measures: &Measures) -> Judgement {
    let mut qualities: Vec<Quality> = Vec::new();
    let applying = || limits.limit.iter().filter(|limit| limit.applies(airplane));
    for limit in applying() {
        if qualities.iter().any(|quality| quality.criterion == limit.criterion) {
            continue;
        }
        let rows: Vec<&Limit> = applying().filter(|other| other.criterion == limit.criterion).collect();
        qualities.push(quality(limits, airplane, measures, &rows));
    }
    let level = qualities.iter().filter(|quality| quality.counts).filter_map(|quality| quality.level).max();
    Judgement { qualities, level }
}

fn quality(limits: &Limits, airplane: &Airplane, measured: &Measures, rows: &[&Limit]) -> Quality {
    let (mut values, mut reasons, mut worst): (Vec<(Measure, f64)>, _, _) = (Vec::new(), Vec::new(), None);
    for row in rows {
        if values.iter().any(|(measure, _)| *measure == row.measure) {
            continue;
        }
        let Some(value) = measured.get(row.measure) else { continue };
        values.push((row.measure, value));
        let of_measure = rows.iter().filter(|other| other.measure == row.measure);
        let violated = of_measure.filter_map(|limit| {
            violation(limits, airplane, measured, limit, value).map(|reason| (limit.level, reason))
        });
        let last = violated.max_by_key(|(level, _)| *level);
        let level = QualityLevel::after(last.as_ref().map_or(0, |(level, _)| *level));
        reasons.extend(last.map(|(_, reason)| reason));
        worst = worst.max(Some(level));
    }
    let criterion = rows.first().map(|row| row.criterion.clone()).unwrap_or_default();
    let mut measures: Vec<Measure> = rows.iter().map(|row| row.measure).collect();
    measures.dedup();
    Quality { criterion, level: worst, measures, values, reasons, counts: rows.iter().all(|row| row.counts()) }
}

/// How a value violates a limit, if it does.
fn violation(limits: &Limits, airplane: &Airplane, measures: &Measures, limit: &Limit, value: f64) -> Option<Reason> {
    let mut minimum = limit.minimum;
    if limit.measure == Measure::DutchRollDampingFrequency {
        let damping = measures.get(Measure::DutchRollDamping);
        let enough = limits.dutch_roll_enough.as_ref().zip(damping).is_some_and(|(enough, damping)| {
            damping >= enough.damping && enough.classes.iter().any(|class| class == airplane.class)
        });
        if enough {
            return None;
        }
        if let Some((increase, coupling)) =
            limits.dutch_roll_increase.as_ref().zip(measures.get(Measure::DutchRollCoupling))
        {
            let factor = increase.factor.get(usize::from(limit.level) - 1).copied().unwrap_or(0.0);
            minimum = minimum.map(|minimum| minimum + factor * (coupling - increase.above).max(0.0));
        }
    }
    let below = minimum.filter(|minimum| value < *minimum).map(|bound| (true, bound));
    let above = limit.maximum.filter(|maximum| value > *maximum).map(|bound| (false, bound));
    let (below, bound) = below.or(above)?;
    let (source, disputed) = (limit.source.clone(), limit.disputed.clone());
    Some(Reason { measure: limit.measure, value, below, bound, source, disputed })
}

/// Share of samples at each level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelShares {
    /// Criterion, or `all` for the worst of them.
    pub criterion: String,
    /// Share of the judged samples at each level, in the order of [`QualityLevel::ALL`].
    pub shares: [f64; 4],
    /// Samples judged.
    pub judged: usize,
}

/// How often each level comes out of samples of the measures: per criterion, then of the worst under the name `all`.
pub fn judge_samples<'a>(
    limits: &Limits,
    airplane: &Airplane,
    samples: impl IntoIterator<Item = &'a Measures>,
) -> Vec<LevelShares> {
    let mut found: Vec<LevelShares> = Vec::new();
    let mut count = |criterion: &str, level: Option<QualityLevel>| {
        let place = found.iter().position(|row| row.criterion == criterion).unwrap_or_else(|| {
            found.push(LevelShares { criterion: criterion.to_owned(), ..LevelShares::default() });
            found.len() - 1
        });
        if let Some(level) = level {
            found[place].shares[level as usize] += 1.0;
            found[place].judged += 1;
        }
    };
    for sample in samples {
        let judgement = judge(limits, airplane, sample);
        judgement.qualities.iter().for_each(|quality| count(&quality.criterion, quality.level));
        count("all", judgement.level);
    }
    for row in &mut found {
        let judged = row.judged.max(1) as f64;
        row.shares.iter_mut().for_each(|share| *share /= judged);
    }
    found
}
