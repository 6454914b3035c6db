//! Speeds in knots that were taken for m/s: ground speed in knots beside the airspeed hides it from what compares the two.

use super::changes::Cure;
use super::rows::{Agreement, CompatibilityRow};
use crate::quantity::{Role, Unit};

/// Relations that have the true airspeed on one side alone, and whether their slope is upside down.
const OF_AIRSPEED: [((Role, &str), bool); 3] = [
    ((Role::VelocityDown, "airspeed, theta and alpha"), false),
    ((Role::Altitude, "airspeed, theta and alpha"), false),
    ((Role::TrueAirspeed, "az and pitch rate"), true),
];
/// Least squared correlation of a relation that shows the unit of speed, and most that it may be off it.
const LEAST_R2: f64 = 0.85;
const TOLERANCE: f64 = 0.15;

/// That the speeds are in knots, where two or more relations agree on it; each by itself may be hidden by gusts and sensors.
pub(super) fn in_knots(rows: &[CompatibilityRow]) -> Option<CompatibilityRow> {
    let knot = Unit::parse("kt").ok()?;
    if rows.iter().any(|row| row.agreement == Agreement::Contradicts && row.channel == Role::TrueAirspeed.name()) {
        return None;
    }
    let factor = |(relation, is_upside_down): &((Role, &'static str), bool)| {
        let row = rows.iter().find(|row| row.relation == Some(*relation))?;
        let slope = row.slope.filter(|slope| *slope > 0.0 && row.r2.is_some_and(|r2| r2 > LEAST_R2))?;
        Some(if *is_upside_down { 1.0 / slope } else { slope })
    };
    let factors: Vec<f64> = OF_AIRSPEED.iter().filter_map(factor).collect();
    let is_knot = |factor: &f64| (factor / knot.scale - 1.0).abs() < TOLERANCE;
    if factors.len() < 2 || !factors.iter().all(is_knot) {
        return None;
    }
    let said: Vec<String> = factors.iter().map(|factor| format!("{factor:.3}")).collect();
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
            "climb and normal acceleration by airspeed and attitude are {} of what they are: speeds are in knots, {:.3} m/s",
            said.join(", "),
            knot.scale
        ),
        cure: Some(Cure::Scale {
            role: Role::TrueAirspeed,
            factor: knot.scale,
            offset: 0.0,
            units: Some((knot.symbol, "m/s")),
        }),
        curves: None,
    })
}
