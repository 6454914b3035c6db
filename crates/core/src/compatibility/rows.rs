//! What was found, one row per relation and mistake.

use super::accelerometer::AccelerometerPlace;
use super::changes::ChannelFix;
use super::line::Figures;
use super::motion::Motion;
use super::mounting::RateErrors;
use super::offsets::{beside_vane, magnetic};
use super::outcome::{Outcome, Relation, relations};
use super::search::{CLEAR_R2, Found, Mistake, OPPOSITE_R2, OPPOSITE_SLOPE, Repaired};
use super::traces::Curves;
use crate::message;
use crate::message::{Message, written};
use crate::quantity::Role;

/// How a channel stands to the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Agreement {
    /// It fits.
    Fits,
    /// The recording does not show it.
    Undetermined,
    /// It does not fit, and the cause was not found or must be asked for.
    Doubtful,
    /// It does not fit, and one mistake of the channel map explains it.
    Contradicts,
}

/// One channel against the others.
#[derive(Clone, Debug, PartialEq)]
pub struct CompatibilityRow {
    /// Name of the channel's role, or `time`.
    pub channel: String,
    /// What was compared with what, as the relation names them; none about the clock.
    pub(super) relation: Option<(Role, &'static str)>,
    /// How it stands.
    pub agreement: Agreement,
    /// What is wrong, for example `sign reversed`; empty where nothing is or the cause was not found.
    pub hypothesis: String,
    /// What its values in SI, or the seconds as read, are to be multiplied by.
    pub factor: Option<f64>,
    /// Slope on what the others say; the effect of a deflection, the largest value where the size was judged.
    pub slope: Option<f64>,
    /// Squared correlation.
    pub r2: Option<f64>,
    /// Segments of the flight that tell.
    pub segments: usize,
    /// One sentence with the figures.
    pub evidence: String,
    /// What removes the contradiction.
    pub fix: Option<ChannelFix>,
    /// What contradicts, as curves before and after the fix.
    pub curves: Option<Curves>,
}

/// What the channels of a recording say of each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compatibility {
    /// The clock first, then mistakes, then every relation.
    pub rows: Vec<CompatibilityRow>,
    /// Where the accelerometers are from the point whose velocity is recorded; none where the channels contradict each other or do not tell.
    pub accelerometer: Option<AccelerometerPlace>,
    /// Mounting and scale factors of the gyros against the attitude; none where these channels contradict each other or do not show it.
    pub rates: Option<RateErrors>,
}

impl CompatibilityRow {
    /// A row about the clock.
    pub(super) fn of_clock(
        agreement: Agreement,
        fix: Option<ChannelFix>,
        evidence: String,
        slope: Option<f64>,
        segments: usize,
    ) -> Self {
        let factor = match fix {
            Some(ChannelFix::Clock { factor, .. }) => Some(factor),
            _ => None,
        };
        let hypothesis = fix.as_ref().map(ChannelFix::hypothesis).unwrap_or_default();
        Self {
            channel: "time".to_owned(),
            relation: None,
            agreement,
            hypothesis,
            factor,
            slope,
            r2: None,
            segments,
            evidence,
            fix,
            curves: None,
        }
    }

    /// A specific force that the ground velocity shows reversed: deviations of its changes as recorded and reversed, m/s.
    pub(super) fn of_reversed_force(force: Role, residuals_m_s: [f64; 2]) -> Self {
        let fix = ChannelFix::Scale { role: force, factor: -1.0, offset: 0.0, units: None };
        let [recorded, reversed] = residuals_m_s.map(significant);
        Self {
            channel: force.name().to_owned(),
            relation: None,
            agreement: Agreement::Contradicts,
            hypothesis: fix.hypothesis(),
            factor: Some(-1.0),
            slope: None,
            r2: None,
            segments: 1,
            evidence: format!(
                "ground velocity against specific force and attitude: rms {recorded} m/s with {} as recorded, {reversed} m/s with it reversed",
                force.name()
            ),
            fix: Some(fix),
            curves: None,
        }
    }

    /// `az: sign reversed (correlation -0.999)`: what is wrong in a few words.
    pub fn headline(&self) -> Message {
        let what = if self.hypothesis.is_empty() { "inconsistent, cause unknown" } else { self.hypothesis.as_str() };
        let figure = match (&self.fix, self.slope, self.r2) {
            (Some(ChannelFix::Scale { factor, offset: 0.0, units: None, .. }), Some(slope), Some(r2))
                if *factor < 0.0 =>
            {
                // A line of another channel may run the right way.
                if slope < 0.0 { message!(" (correlation {:.3})", -r2.sqrt()) } else { Message::default() }
            }
            (Some(ChannelFix::Swap { .. } | ChannelFix::Reassign { .. } | ChannelFix::Travel { .. }), ..)
            | (_, None, _) => Message::default(),
            (
                Some(ChannelFix::Scale {
                    role: Role::AngleOfAttack | Role::Sideslip | Role::HeadingAngle,
                    factor: 1.0,
                    ..
                }),
                ..,
            ) => Message::default(),
            (_, Some(slope), _) => message!(" (slope {})", written(slope, significant(slope))),
        };
        message!("{}: {}{}", &self.channel, what, figure)
    }

    /// Roles without which there is nothing to compare; none about the clock.
    pub fn needed(&self) -> Vec<Role> {
        let Some((compared, with)) = self.relation else { return Vec::new() };
        let all = relations();
        let same = all.iter().filter(|relation| relation.compared() == compared && relation.with() == with);
        let same: Vec<&Relation> = same.collect();
        let is_needed = |role: &Role| same.iter().any(|relation| relation.needs(*role));
        Role::ALL.into_iter().filter(|role| *role == compared || is_needed(role)).collect()
    }

    /// Whether it does not fit and no mistake explains it.
    pub(super) fn is_unexplained(&self) -> bool {
        self.agreement == Agreement::Doubtful && self.relation.is_some() && self.fix.is_none()
    }
}

impl Compatibility {
    /// Rows that say something is wrong or must be asked, the worst first.
    pub fn contradictions(&self) -> impl Iterator<Item = &CompatibilityRow> {
        let with_agreement = |agreement| self.rows.iter().filter(move |row| row.agreement == agreement);
        with_agreement(Agreement::Contradicts).chain(with_agreement(Agreement::Doubtful))
    }
}

/// A number to three significant digits.
fn significant(value: f64) -> String {
    match value.abs() {
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size >= 1.0 => format!("{value:.2}"),
        size if size >= 0.01 => format!("{value:.4}"),
        _ => format!("{value:.2e}"),
    }
}

fn plural(segments: usize) -> String {
    format!("{segments} segment{}", if segments == 1 { "" } else { "s" })
}

/// Takes the rows that nothing explains as they are with the velocities over the ground taken without their delay.
pub(super) fn explain_by_delay(rows: &mut [CompatibilityRow], punctual: &[CompatibilityRow]) {
    for row in rows.iter_mut().filter(|row| row.is_unexplained()) {
        let same = punctual.iter().find(|other| other.relation == row.relation && other.channel == row.channel);
        if let Some(fits) = same.filter(|other| matches!(other.agreement, Agreement::Fits | Agreement::Undetermined)) {
            *row = CompatibilityRow {
                evidence: format!("{}, without the delay of the ground velocity", fits.evidence),
                ..fits.clone()
            };
        }
    }
}

/// A relation in words with its figures.
fn sentence(relation: &Relation, figures: &Figures) -> String {
    let (channel, with, slope) = (relation.compared().name(), relation.with(), significant(figures.slope));
    let segments = plural(figures.segments);
    match relation {
        Relation::Kinematic(_) | Relation::Air(_) => {
            format!("{channel} against {with}: slope {slope}, R2 {:.3} over {segments}", figures.r2)
        }
        Relation::Response(_) => {
            format!("{channel} against {with}: effect {slope}, {:.0} % explained, {segments}", 100.0 * figures.r2)
        }
        Relation::Size(_) => format!("{channel} reaches {slope}; expected: {with}"),
        Relation::Offset(_) => {
            format!("{channel} is {:+.1} deg off {with}, over {segments}", figures.slope.to_degrees())
        }
        Relation::Travel(_) => {
            let degrees = figures.slope.to_degrees();
            format!("{channel} reaches {slope} rad ({} deg); expected: {with}", significant(degrees))
        }
    }
}

/// Rows of what a search found.
pub(super) fn rows(found: &Found) -> Vec<CompatibilityRow> {
    let mistakes = found.mistakes.iter().flat_map(mistake_rows);
    mistakes.chain(found.outcomes.iter().filter_map(|(relation, outcome)| outcome_row(relation, outcome))).collect()
}

pub(super) fn mistake_rows(mistake: &Mistake) -> Vec<CompatibilityRow> {
    let fixes: &[ChannelFix] = if mistake.is_linear { &mistake.fixes[..1] } else { &mistake.fixes };
    fixes.iter().filter_map(|fix| fix_row(mistake, fix)).collect()
}

fn fix_row(mistake: &Mistake, fix: &ChannelFix) -> Option<CompatibilityRow> {
    let roles = fix.roles();
    let own = mistake.repaired.iter().find(|(relation, ..)| roles.contains(&relation.compared()));
    let entered = |(relation, ..): &&Repaired| roles.iter().any(|role| relation.involves(*role));
    let own = own.or_else(|| mistake.repaired.iter().find(entered));
    // A channel that repairs nothing makes something hold better.
    let own = own.or_else(|| mistake.sharpened.iter().find(entered));
    let (relation, before, after) = own.or(mistake.repaired.first())?;
    let others: Vec<String> = mistake
        .repaired
        .iter()
        .filter(|(other, ..)| (other.compared(), other.with()) != (relation.compared(), relation.with()))
        .map(|(other, ..)| format!("{} against {}", other.compared().name(), other.with()))
        .collect();
    let mut evidence = sentence(relation, before);
    if relation.is_of_lines() {
        evidence += &format!("; corrected: slope {}, R2 {:.3}", significant(after.slope), after.r2);
    }
    if !others.is_empty() {
        evidence += &format!("; also fixes {}", others.join(", "));
    }
    let rivals: Vec<String> = mistake.rivals.iter().map(headline_of).collect();
    if !rivals.is_empty() {
        evidence += &format!("; equally likely: {}", rivals.join(", "));
    }
    if mistake.is_linear {
        evidence += "; ax and ay lack gravity too: add g sin(theta) to ax; add -g cos(theta) sin(phi) to ay; \
                     add -g cos(theta) cos(phi) to az";
    }
    let (agreement, remark) = offset_agreement(fix, before, &mistake.motions[0]);
    evidence += &remark;
    let factor = if let ChannelFix::Scale { factor, .. } = fix { Some(*factor) } else { None };
    Some(CompatibilityRow {
        channel: roles.first()?.name().to_owned(),
        relation: Some((relation.compared(), relation.with())),
        agreement,
        hypothesis: if mistake.is_linear { "gravity removed by the attitude".to_owned() } else { fix.hypothesis() },
        factor: factor.filter(|_| !mistake.is_linear),
        slope: Some(before.slope),
        r2: Some(before.r2),
        segments: before.segments,
        evidence,
        // A channel map cannot restore what depends on the attitude.
        fix: (!mistake.is_linear).then(|| fix.clone()),
        curves: relation.curves(&mistake.motions[0], &mistake.motions[1]),
    })
}

/// How certain a fix is, and what there is to say of it, where it is an offset of an angle.
fn offset_agreement(fix: &ChannelFix, before: &Figures, motion: &Motion) -> (Agreement, String) {
    match fix {
        ChannelFix::Scale { role: Role::AngleOfAttack, factor: 1.0, offset, .. } if *offset != 0.0 => {
            let (is_certain, remark) = beside_vane(before.slope, motion);
            (if is_certain { Agreement::Contradicts } else { Agreement::Doubtful }, remark)
        }
        ChannelFix::Scale { role: Role::HeadingAngle, factor: 1.0, offset, .. } if *offset != 0.0 => {
            (Agreement::Contradicts, format!("; {}", magnetic(-offset)))
        }
        _ => (Agreement::Contradicts, String::new()),
    }
}

fn headline_of(fix: &ChannelFix) -> String {
    format!("{}: {}", fix.roles().first().map_or("time", |role| Role::name(*role)), fix.hypothesis())
}

/// Whether a line shows a difference that neither gusts nor sensors make.
fn is_clear(relation: &Relation, figures: &Figures) -> bool {
    let runs_against = OPPOSITE_SLOPE.contains(&figures.slope) && figures.r2 > OPPOSITE_R2;
    matches!(relation, Relation::Kinematic(_)) && (figures.r2 > CLEAR_R2 || runs_against)
}

fn outcome_row(relation: &Relation, outcome: &Outcome) -> Option<CompatibilityRow> {
    let channel = relation.compared().name();
    let (agreement, figures, evidence) = match outcome {
        Outcome::Absent => return None,
        Outcome::Fits(_) | Outcome::Undetermined if relation.is_of_values() => return None,
        Outcome::Undetermined => {
            let evidence = format!("{channel} against {}: not determined, too little motion", relation.with());
            (Agreement::Undetermined, None, evidence)
        }
        Outcome::Fits(figures) => (Agreement::Fits, Some(figures), sentence(relation, figures)),
        Outcome::Differs(figures) if figures.predicted && (relation.is_exact() || is_clear(relation, figures)) => {
            (Agreement::Doubtful, Some(figures), sentence(relation, figures))
        }
        Outcome::Differs(figures) => {
            let evidence =
                format!("{}: not determined, masked by gusts and sensor errors", sentence(relation, figures));
            (Agreement::Undetermined, Some(figures), evidence)
        }
    };
    Some(CompatibilityRow {
        channel: channel.to_owned(),
        relation: Some((relation.compared(), relation.with())),
        agreement,
        hypothesis: String::new(),
        factor: None,
        slope: figures.map(|figures| figures.slope),
        r2: figures.map(|figures| figures.r2),
        segments: figures.map_or(0, |figures| figures.segments),
        evidence,
        fix: None,
        curves: None,
    })
}
