//! Measures against limits: levels, their reasons, and how likely they are.

use std::fmt;

use super::limits::{Airplane, Along, Limit, Limits, NotJudged};
use super::measures::{Measure, Measures};
use crate::propagate::Interval;

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
    doublet_core::named_variants! {
        /// In words.
        pub name: One "Level 1", Two "Level 2", Three "Level 3", WorseThanThree "worse than Level 3"
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
#[expect(missing_docs, reason = "names say it")]
pub struct Reason {
    pub measure: Measure,
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
            // A boundary between two points has more digits than its source.
            let bound = format!("{:.3e}", self.bound).parse().unwrap_or(self.bound);
            write!(f, "{text} {sign} {bound}")?;
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
    /// Whether it counts: a criterion whose limits are only remembered, or are guidance, does not.
    pub counts: bool,
    /// Whether its limits are guidance for design.
    pub is_guidance: bool,
    /// Standard with its date.
    pub standard: String,
    /// Paragraph, figure and page.
    pub source: String,
    /// What is needed to judge it, where it was not judged.
    pub needed: Option<String>,
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
    let open = limits
        .not_judged
        .iter()
        .filter(|row| row.categories.is_empty() || row.categories.iter().any(|category| category == airplane.category));
    qualities.extend(open.map(|row| not_judged(row, measures)));
    let level = qualities.iter().filter(|quality| quality.counts).filter_map(|quality| quality.level).max();
    Judgement { qualities, level }
}

/// A criterion of the standard that is listed only.
fn not_judged(row: &NotJudged, measured: &Measures) -> Quality {
    Quality {
        criterion: row.criterion.clone(),
        level: None,
        measures: row.measures.clone(),
        values: row.measures.iter().filter_map(|measure| Some((*measure, measured.get(*measure)?))).collect(),
        reasons: Vec::new(),
        counts: true,
        is_guidance: false,
        standard: row.standard.clone(),
        source: row.source.clone(),
        needed: Some(row.needed.clone()),
    }
}

fn quality(limits: &Limits, airplane: &Airplane, measured: &Measures, rows: &[&Limit]) -> Quality {
    let (mut values, mut reasons, mut worst): (Vec<(Measure, f64)>, _, _) = (Vec::new(), Vec::new(), None);
    let mut beyond: Option<String> = None;
    let mut judged: Vec<Measure> = Vec::new();
    for row in rows {
        if judged.contains(&row.measure) {
            continue;
        }
        judged.push(row.measure);
        let Some(value) = measured.get(row.measure) else { continue };
        let of_measure = || rows.iter().filter(|other| other.measure == row.measure);
        // A boundary over a measure that was not had says nothing.
        let others = of_measure().filter_map(|limit| limit.along.as_ref()).map(|along| along.measure);
        let Some(others) = others.map(|other| Some((other, measured.get(other)?))).collect::<Option<Vec<_>>>() else {
            continue;
        };
        for pair in std::iter::once((row.measure, value)).chain(others) {
            if !values.contains(&pair) {
                values.push(pair);
            }
        }
        let missed = of_measure().filter_map(|limit| outside_figure(limit.along.as_ref()?, measured)).next();
        if missed.is_some() {
            beyond = beyond.or(missed);
            continue;
        }
        let violated = of_measure().filter_map(|limit| {
            violation(limits, airplane, measured, limit, value).map(|reason| (limit.level, reason))
        });
        let last = violated.max_by_key(|(level, _)| *level);
        let level = QualityLevel::after(last.as_ref().map_or(0, |(level, _)| *level));
        reasons.extend(last.map(|(_, reason)| reason));
        worst = worst.max(Some(level));
    }
    let of_first = |text: fn(&Limit) -> &String| rows.first().map(|row| text(row).clone()).unwrap_or_default();
    let measures = judged;
    let others = rows.iter().filter_map(|row| row.along.as_ref()).map(|along| along.measure);
    let needed = measures.iter().copied().chain(others).find(|measure| measured.get(*measure).is_none());
    Quality {
        criterion: of_first(|row| &row.criterion),
        level: worst,
        needed: needed.map(|measure| measure.needs().to_owned()).or(beyond).filter(|_| worst.is_none()),
        measures,
        values,
        reasons,
        counts: rows.iter().all(|row| row.counts()),
        is_guidance: rows.iter().any(|row| row.is_guidance),
        standard: of_first(|row| &row.standard),
        source: of_first(|row| &row.source),
    }
}

/// Why a boundary is not judged: the other measure lies outside its figure.
fn outside_figure(along: &Along, measured: &Measures) -> Option<String> {
    let at = measured.get(along.measure)?;
    let [low, high] = along.figure_missed_by(at)?;
    let (name, unit) = (along.measure.text(), along.measure.unit());
    Some(format!("{name} inside the figure, {low} to {high} {unit}: it is {at:.1} {unit}"))
}

/// How a value violates a limit, if it does.
fn violation(limits: &Limits, airplane: &Airplane, measures: &Measures, limit: &Limit, value: f64) -> Option<Reason> {
    let along = limit.along.as_ref().zip(limit.along.as_ref().and_then(|along| measures.get(along.measure)));
    let (low, high) = along.map_or((None, None), |(along, at)| along.bounds(at));
    let (mut minimum, maximum) = (limit.minimum.or(low), limit.maximum.or(high));
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
    let above = maximum.filter(|maximum| value > *maximum).map(|bound| (false, bound));
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
    for sample in samples {
        let judgement = judge(limits, airplane, sample);
        judgement.qualities.iter().for_each(|quality| count_level(&mut found, &quality.criterion, quality.level));
        count_level(&mut found, "all", judgement.level);
    }
    for row in &mut found {
        let judged = row.judged.max(1) as f64;
        row.shares.iter_mut().for_each(|share| *share /= judged);
    }
    found
}

fn count_level(found: &mut Vec<LevelShares>, criterion: &str, level: Option<QualityLevel>) {
    let place = found.iter().position(|row| row.criterion == criterion).unwrap_or_else(|| {
        found.push(LevelShares { criterion: criterion.to_owned(), ..LevelShares::default() });
        found.len() - 1
    });
    if let Some(level) = level {
        found[place].shares[level as usize] += 1.0;
        found[place].judged += 1;
    }
}

/// Interval of 95 % of a measure from samples; none where fewer than nine in ten have a finite value.
pub fn measure_interval(samples: &[Measures], measure: Measure) -> Option<Interval> {
    let found: Vec<f64> =
        samples.iter().filter_map(|sample| sample.get(measure)).filter(|value| value.is_finite()).collect();
    (10 * found.len() >= 9 * samples.len()).then(|| Interval::of_samples(found)).flatten()
}
