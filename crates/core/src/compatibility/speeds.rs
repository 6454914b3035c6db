//! Airspeeds that are off by a factor: in knots, taken for m/s, which ground speed in knots beside them hides from what compares the two;
//! calibrated, taken for true; or not corrected.

use super::air::true_of_calibrated;
use super::changes::ChannelFix;
use super::motion::Motion;
use super::rows::{Agreement, CompatibilityRow};
use crate::quantity::{Role, Unit};
use crate::statistics::median;

/// Relations that have the true airspeed on one side alone, and whether their slope is upside down.
const OF_AIRSPEED: [((Role, &str), bool); 3] = [
    ((Role::VelocityDown, "airspeed, theta and alpha"), false),
    ((Role::Altitude, "airspeed, theta and alpha"), false),
    ((Role::TrueAirspeed, "az and pitch rate"), true),
];
/// Those and what compares the airspeed with the velocity over the ground.
const OF_SCALE: [((Role, &str), bool); 5] = [
    OF_AIRSPEED[0],
    OF_AIRSPEED[1],
    OF_AIRSPEED[2],
    ((Role::TrueAirspeed, "v_north over turns"), true),
    ((Role::TrueAirspeed, "v_east over turns"), true),
];
/// Least squared correlation of a relation that shows the unit of speed, and most that it may be off it.
const LEAST_R2: f64 = 0.85;
const TOLERANCE: f64 = 0.15;
/// Least squared correlation of relations that show a factor together, and least that it is off one then: of clear relations, of others.
const CLEAR: [f64; 2] = [0.97, 0.06];
const OTHER: [f64; 2] = [0.93, 0.1];
/// Least segments of such a relation, and most that its factor may be off the median.
const SEGMENTS: usize = 2;
const SPREAD: f64 = 0.06;
/// The same of north and east over turns, which the wind leaves alone: squared correlation, change, segments and spread.
const OVER_TURNS: [((Role, &str), bool); 2] = [OF_SCALE[3], OF_SCALE[4]];
const TURNS_R2: f64 = 0.995;
const TURNS_CHANGE: f64 = 0.025;
const TURNS_SEGMENTS: usize = 3;
const TURNS_SPREAD: f64 = 0.01;
/// Air data that say what the true airspeed is, and least that their factor is off one found otherwise before the two disagree.
const OF_AIR_DATA: [((Role, &str), bool); 2] = [
    ((Role::TrueAirspeed, "Mach number and temperature"), true),
    ((Role::TrueAirspeed, "calibrated airspeed, pressure and temperature"), true),
];
const APART: f64 = 0.03;
/// Most that the factor may be off that of true over calibrated airspeed.
const AS_CALIBRATED: f64 = 0.035;

/// That the speeds are in knots, where two or more relations agree on it; each by itself may be hidden by gusts and sensors.
pub(super) fn in_knots(rows: &[CompatibilityRow]) -> Option<CompatibilityRow> {
    let knot = Unit::parse("kt").ok()?;
    if rows.iter().any(|row| row.agreement == Agreement::Contradicts && row.channel == Role::TrueAirspeed.name()) {
        return None;
    }
    let factors = factors(rows, &OF_AIRSPEED, LEAST_R2, 1);
    let is_knot = |factor: &f64| (factor / knot.scale - 1.0).abs() < TOLERANCE;
    if factors.len() < 2 || !factors.iter().all(is_knot) {
        return None;
    }
    let listed: Vec<String> = factors.iter().map(|factor| format!("{factor:.3}")).collect();
    Some(CompatibilityRow {
        channel: Role::TrueAirspeed.name().to_owned(),
        relation: None,
        agreement: Agreement::Contradicts,
        hypothesis: "knots".to_owned(),
        factor: Some(knot.scale),
        slope: Some(factors.iter().sum::<f64>() / factors.len() as f64),
        r2: None,
        segments: factors.len(),
        evidence: format!(
            "climb and normal acceleration from airspeed and attitude are {} times the measured: airspeed is in knots ({:.3} m/s)",
            listed.join(", "),
            knot.scale
        ),
        fix: Some(ChannelFix::Scale {
            role: Role::TrueAirspeed,
            factor: knot.scale,
            offset: 0.0,
            units: Some((knot.symbol, "m/s")),
        }),
        curves: None,
    })
}

/// What the airspeed is to be multiplied by according to a relation that shows it clearly, and the squared correlation.
fn factor_by(
    rows: &[CompatibilityRow],
    (relation, is_upside_down): ((Role, &'static str), bool),
    least_r2: f64,
    segments: usize,
) -> Option<(f64, f64)> {
    let row = rows.iter().find(|row| row.relation == Some(relation))?;
    let r2 = row.r2.filter(|r2| *r2 > least_r2 && row.segments >= segments)?;
    let slope = row.slope.filter(|slope| *slope > 0.0)?;
    Some((if is_upside_down { 1.0 / slope } else { slope }, r2))
}

/// The factors by each of the relations.
fn factors(
    rows: &[CompatibilityRow],
    relations: &[((Role, &'static str), bool)],
    least_r2: f64,
    segments: usize,
) -> Vec<f64> {
    let factor = |relation: &_| factor_by(rows, *relation, least_r2, segments).map(|(factor, _)| factor);
    relations.iter().filter_map(factor).collect()
}

/// The value nearest to one that a factor may have. Noise of one side alone changes the slope of the reduced major axis by the
/// correlation, times or over.
fn nearest_to_one((factor, r2): (f64, f64)) -> f64 {
    let correlation = r2.sqrt();
    if factor > 1.0 { (factor * correlation).max(1.0) } else { (factor / correlation).min(1.0) }
}

/// That the airspeed is too small or too large by one factor, where two or more relations agree on it: calibrated where the factor is that
/// between the two, of a pitot system that is not corrected otherwise.
pub(super) fn scaled(rows: &[CompatibilityRow], motion: &Motion) -> Option<CompatibilityRow> {
    let role = Role::TrueAirspeed;
    if rows.iter().any(|row| row.agreement == Agreement::Contradicts && row.channel == role.name()) {
        return None;
    }
    let agreed = agreed(rows, CLEAR).or_else(|| agreed(rows, OTHER));
    let is_over_turns = agreed.is_none();
    let (factor, factors) = agreed.or_else(|| find_factor_over_turns(rows))?;
    let percent = 100.0 * (1.0 - 1.0 / factor).abs();
    let too = if factor > 1.0 { "small" } else { "large" };
    let (hypothesis, fix) = match calibrated(motion).filter(|ratio| (factor / ratio - 1.0).abs() < AS_CALIBRATED) {
        Some(_) => {
            let fix = ChannelFix::Reassign { from: role, to: Role::CalibratedAirspeed };
            (fix.hypothesis(), fix)
        }
        None => (format!("{percent:.0} % too {too}"), ChannelFix::Scale { role, factor, offset: 0.0, units: None }),
    };
    let listed: Vec<String> = factors.iter().map(|factor| format!("{factor:.3}")).collect();
    let others = if is_over_turns { Vec::new() } else { against(rows, factor) };
    let others: Vec<String> = others.iter().map(|other| format!("{other:.3}")).collect();
    let measured = match is_over_turns {
        true => "recorded ground velocity over turns matches",
        false => "recorded ground velocity, climb and normal acceleration match",
    };
    let disagreeing = match others.is_empty() {
        true => String::new(),
        false => format!("; other comparisons disagree: {} times", others.join(", ")),
    };
    Some(CompatibilityRow {
        channel: role.name().to_owned(),
        relation: None,
        agreement: if others.is_empty() { Agreement::Contradicts } else { Agreement::Doubtful },
        hypothesis,
        factor: Some(factor),
        slope: Some(1.0 / factor),
        r2: None,
        segments: factors.len(),
        evidence: format!("{measured} {} times this airspeed{disagreeing}", listed.join(", ")),
        fix: Some(fix),
        curves: None,
    })
}

/// Factors by air data and by other relations that are nearer to one than to `factor`: they contradict it.
fn against(rows: &[CompatibilityRow], factor: f64) -> Vec<f64> {
    let all = factors(rows, &OF_AIR_DATA, LEAST_R2, 1).into_iter().chain(factors(rows, &OF_SCALE, OTHER[0], 1));
    all.filter(|other| (other / factor).ln().abs() > APART && other.ln().abs() < (other / factor).ln().abs()).collect()
}

/// The factor that two thirds of the relations, and two at least, agree on, with theirs; none where as many others contradict it.
fn agreed(rows: &[CompatibilityRow], [least_r2, least_change]: [f64; 2]) -> Option<(f64, Vec<f64>)> {
    let shown = |relation: &_| factor_by(rows, *relation, least_r2, SEGMENTS);
    let mut all: Vec<(f64, f64)> = OF_SCALE.iter().filter_map(shown).collect();
    let count = all.len();
    let middle = median(&mut all.iter().map(|(factor, _)| *factor).collect::<Vec<_>>())?;
    all.retain(|(factor, _)| (factor / middle - 1.0).abs() < SPREAD);
    let nearest = median(&mut all.iter().copied().map(nearest_to_one).collect::<Vec<_>>())?;
    let mut factors: Vec<f64> = all.into_iter().map(|(factor, _)| factor).collect();
    let factor = median(&mut factors)?;
    let is_off = (nearest - 1.0).abs() > least_change;
    let is_shown = factors.len() >= 2 && 3 * factors.len() >= 2 * count && is_off;
    (is_shown && against(rows, factor).len() < factors.len()).then_some((factor, factors))
}

/// The factor that the velocities north and east over turns agree on, with theirs; none where air data contradict it.
fn find_factor_over_turns(rows: &[CompatibilityRow]) -> Option<(f64, Vec<f64>)> {
    let factors = factors(rows, &OVER_TURNS, TURNS_R2, TURNS_SEGMENTS);
    let [north, east] = factors[..] else { return None };
    let factor = (north * east).sqrt();
    let is_shown = (north / east).ln().abs() < TURNS_SPREAD && (factor - 1.0).abs() > TURNS_CHANGE;
    let by_air_data = self::factors(rows, &OF_AIR_DATA, LEAST_R2, 1);
    let is_contradicted = by_air_data.iter().any(|other| (other / factor).ln().abs() > APART);
    (is_shown && !is_contradicted).then_some((factor, factors))
}

/// Median of true over calibrated airspeed at the recorded height, where that makes a difference.
fn calibrated(motion: &Motion) -> Option<f64> {
    let speeds =
        motion.column(Role::TrueAirspeed).filter(|_| motion.has(Role::StaticPressure) || motion.has(Role::Altitude))?;
    let steps = motion.segments.iter().flat_map(Clone::clone).filter(|&k| speeds[k].is_finite());
    let ratio = median(&mut steps.map(|k| true_of_calibrated(motion, k, speeds[k]) / speeds[k]).collect::<Vec<_>>())?;
    (ratio > 1.0 + AS_CALIBRATED).then_some(ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A relation of [`OF_SCALE`] or [`OF_AIR_DATA`] that shows this factor clearly.
    fn row((relation, is_upside_down): ((Role, &'static str), bool), factor: f64) -> CompatibilityRow {
        let mut row = CompatibilityRow::of_clock(Agreement::Fits, None, String::new(), None, 5);
        row.relation = Some(relation);
        row.slope = Some(if is_upside_down { 1.0 / factor } else { factor });
        row.r2 = Some(0.98);
        row
    }

    #[test]
    fn factor_of_the_airspeed_is_none_where_as_many_comparisons_contradict_it() {
        let mut rows = vec![row(OF_SCALE[3], 1.083), row(OF_SCALE[4], 1.139), row(OF_AIR_DATA[0], 0.981)];
        let Some((factor, shown)) = agreed(&rows, CLEAR) else { panic!("no factor") };
        assert_eq!((factor, shown.len()), (1.139, 2));
        rows.push(row(OF_AIR_DATA[1], 0.903));
        assert_eq!(agreed(&rows, CLEAR), None);
    }

    #[test]
    fn a_few_per_cent_are_shown_by_both_velocities_over_turns() {
        let mut rows: Vec<_> = [0.962, 0.964].into_iter().zip(OVER_TURNS).map(|(factor, of)| row(of, factor)).collect();
        assert!(find_factor_over_turns(&rows).is_none(), "correlation of 0.98");
        rows.iter_mut().for_each(|row| row.r2 = Some(0.999));
        assert!((find_factor_over_turns(&rows).unwrap().0 - 0.963).abs() < 1e-4);
        rows.push(row(OF_AIR_DATA[0], 1.0));
        assert!(find_factor_over_turns(&rows).is_none(), "the Mach number shows none");
        rows.truncate(2);
        rows[1].slope = Some(1.0 / 0.98);
        assert!(find_factor_over_turns(&rows).is_none(), "the two disagree");
    }
}
