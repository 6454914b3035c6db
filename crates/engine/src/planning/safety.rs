//! Whether a test point may be flown: its entry against the envelope of the aircraft, its own knock-it-off rule and the limits of the campaign.

use doublet_core::airframe::{Aircraft, MassProperties, calibrated_m_s};
use doublet_core::quantity::Role;
use doublet_core::simulate::InputKind;
use serde::{Deserialize, Serialize};

use super::campaign::{Campaign, TestPoint};
use crate::graph::StageResult;
use crate::notation::significant;

/// Speed of a knot, m/s.
pub(super) const M_S_PER_KT: f64 = 1852.0 / 3600.0;
/// Name of the load factor among the limits of a campaign.
const LOAD_FACTOR: &str = "n_z";
/// Entry airspeeds that are raised are multiples of this, m/s.
const RAISED_STEP_M_S: f64 = 0.1;

/// A hazard and what is done about it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Risk {
    pub hazard: String,
    pub mitigation: String,
    /// Level of the hazard with its mitigation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level: Option<HazardLevel>,
}

/// Level of a hazard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HazardLevel {
    Low,
    Medium,
    High,
}

impl HazardLevel {
    doublet_core::named_variants! {
        /// Name on cards and in files.
        pub name: Low "low", Medium "medium", High "high"
    }
}

/// Hazard of a point: the stated level, or that of its worst risk where this is higher. A category of another scale is kept.
pub(super) fn worst_hazard(stated: &str, risks: &[Risk]) -> String {
    let own = HazardLevel::from_name(stated);
    let worst = risks.iter().filter_map(|risk| risk.level).max().max(own);
    match worst {
        Some(level) if own.is_some() || stated.is_empty() => level.name().to_owned(),
        _ => stated.to_owned(),
    }
}

/// Wind in which points are flown; no limit where none is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WindBox {
    /// Greatest mean wind at the altitude of the point, m/s.
    pub speed_m_s: Option<f64>,
    /// Greatest vertical gust, m/s.
    pub gust_m_s: Option<f64>,
    /// Greatest change of the mean wind over the altitude band of the point, m/s.
    pub shear_m_s: Option<f64>,
}

/// What becomes of a point whose entry airspeed is too low.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OnLimit {
    /// Its entry airspeed is raised, and the card states why.
    #[default]
    Raise,
    /// The campaign is refused.
    Refuse,
}

/// What holds before an input begins: the tolerances of the entry and how long they are held.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EntryGate {
    /// Airspeed to either side, m/s.
    pub airspeed_m_s: f64,
    /// Altitude to either side, m.
    pub altitude_m: f64,
    /// Bank to either side, deg.
    pub bank_deg: f64,
    /// Rates of roll, pitch and yaw to either side, deg/s.
    pub rate_deg_s: f64,
    /// Time for which all of this holds, s.
    pub steady_s: f64,
    /// Airspeed the manoeuvre may lose, m/s.
    pub loss_m_s: f64,
    /// Room between the bank a manoeuvre holds and the limit of the campaign, deg.
    pub bank_margin_deg: f64,
    /// Room between the load factor a manoeuvre holds and every limit.
    pub load_factor_margin: f64,
    /// What becomes of a point that begins too slow.
    pub on_limit: OnLimit,
}

impl Default for EntryGate {
    /// Airspeed and altitude of thesis section 4.4.2.
    fn default() -> Self {
        Self {
            airspeed_m_s: 1.0,
            altitude_m: 10.0,
            bank_deg: 2.0,
            rate_deg_s: 0.5,
            steady_s: 5.0,
            loss_m_s: 0.0,
            bank_margin_deg: 5.0,
            load_factor_margin: 0.2,
            on_limit: OnLimit::Raise,
        }
    }
}

impl EntryGate {
    /// Checks that every number is possible.
    pub(super) fn check(&self) -> StageResult<()> {
        let numbers = [
            ("airspeed_m_s", self.airspeed_m_s),
            ("altitude_m", self.altitude_m),
            ("bank_deg", self.bank_deg),
            ("rate_deg_s", self.rate_deg_s),
            ("steady_s", self.steady_s),
            ("loss_m_s", self.loss_m_s),
            ("bank_margin_deg", self.bank_margin_deg),
            ("load_factor_margin", self.load_factor_margin),
        ];
        match numbers.iter().find(|(_, value)| !(0.0..=1000.0).contains(value)) {
            Some((key, value)) => Err(format!("entry.{key} is {value}, allowed is 0 to 1000").into()),
            None => Ok(()),
        }
    }
}

/// Entry of a point that may be flown.
pub(super) struct Entry {
    /// True airspeed, m/s.
    pub airspeed_m_s: f64,
    /// Calibrated airspeed, m/s.
    pub calibrated_m_s: f64,
    /// Why the airspeed is not that of the file.
    pub note: Option<String>,
    /// Load factor the manoeuvre holds.
    pub load_factor: f64,
    /// Calibrated airspeed of the stall at the mass and the load factor of the point, m/s.
    pub stall_m_s: Option<f64>,
    /// Calibrated airspeed below which the point ends, m/s.
    pub least_m_s: Option<f64>,
    /// The knock-it-off rule of that airspeed.
    pub knock_off: Option<String>,
}

/// A bound of the calibrated airspeed.
struct Bound {
    /// What it is, for sentences.
    text: String,
    value_m_s: f64,
}

/// Words of the kinds of input that hold a bank or a load factor.
const LOADED: [&str; 3] = ["turn", "manoeuvring", "pull-up"];

/// The load factor a point holds: as stated, or that of a level turn at its bank.
fn load_factor(point: &TestPoint) -> StageResult<f64> {
    let kind = point.kind.to_lowercase();
    if point.bank_deg.is_none() && point.load_factor.is_none() && LOADED.iter().any(|word| kind.contains(word)) {
        let (id, kind) = (&point.id, &point.kind);
        return Err(format!("point {id}: {kind} needs bank_deg or load_factor: state the greatest it holds").into());
    }
    let of_turn = point.bank_deg.map(|bank| bank.to_radians().cos().recip());
    Ok(point.load_factor.or(of_turn).unwrap_or(1.0))
}

/// The entry of a point with a mass in air of a density (kg/m³).
///
/// # Errors
/// One line: the point begins beyond a limit that a higher airspeed does not mend, or beyond any where points are refused.
pub(super) fn entry(
    campaign: &Campaign,
    point: &TestPoint,
    aircraft: &Aircraft,
    mass: &MassProperties,
    density_kg_m3: f64,
) -> StageResult<Entry> {
    let gate = &campaign.entry;
    let refused = |text: String| Err(format!("point {}: {text}", point.id).into());
    let load_factor = load_factor(point)?;
    if let Some(text) =
        outside(point, gate, aircraft, mass, campaign).or_else(|| overloaded(campaign, point, aircraft, load_factor))
    {
        return refused(text);
    }
    let calibrated_of_true = calibrated_m_s(1.0, density_kg_m3);
    // A push-over does not lower the stall of the level flight before it.
    let stalled_at = load_factor.max(1.0);
    let stall_m_s = aircraft.flight_envelope.stall_at(stalled_at, mass.mass_kg);
    let ratio = point.stall_ratio.unwrap_or(campaign.stall_ratio);
    let least_m_s = stall_m_s.map(|stall| ratio * stall);
    let low = lower_bounds(campaign, aircraft, (mass, stalled_at), (least_m_s, ratio), calibrated_of_true);
    let high = upper_bounds(campaign, point, aircraft, mass, calibrated_of_true);
    let (mut airspeed_m_s, mut note) = (point.airspeed_m_s, None);
    let loss_m_s = point.loss_m_s.unwrap_or(gate.loss_m_s);
    let room_m_s = gate.airspeed_m_s + loss_m_s;
    let slowest = low.iter().max_by(|a, b| a.value_m_s.total_cmp(&b.value_m_s));
    if let Some(bound) = slowest
        && airspeed_m_s * calibrated_of_true < bound.value_m_s + room_m_s
    {
        let needed = ((bound.value_m_s + room_m_s) / calibrated_of_true / RAISED_STEP_M_S).ceil() * RAISED_STEP_M_S;
        let text = format!(
            "{} m/s calibrated is below {} m/s: {} {} m/s, entry tolerance {} m/s, airspeed lost {} m/s",
            significant(airspeed_m_s * calibrated_of_true, 3),
            significant(bound.value_m_s + room_m_s, 3),
            bound.text,
            significant(bound.value_m_s, 3),
            significant(gate.airspeed_m_s, 2),
            significant(loss_m_s, 2),
        );
        if gate.on_limit == OnLimit::Refuse {
            return refused(format!("{text}; enter at {} m/s true or faster", significant(needed, 4)));
        }
        let (from, to) = (format!("{airspeed_m_s:.1}"), format!("{needed:.1}"));
        note = Some(format!("Entry airspeed raised from {from} to {to} m/s true: {text}."));
        airspeed_m_s = needed;
    }
    let calibrated = airspeed_m_s * calibrated_of_true;
    if let Some(bound) = high.iter().find(|bound| calibrated + gate.airspeed_m_s > bound.value_m_s) {
        let (own, limit) = (significant(calibrated + gate.airspeed_m_s, 3), significant(bound.value_m_s, 3));
        return refused(format!("{own} m/s calibrated with the entry tolerance exceeds {} {limit} m/s", bound.text));
    }
    let knock_off = least_m_s.map(|least| knock_off(least, ratio, stalled_at));
    Ok(Entry { airspeed_m_s, calibrated_m_s: calibrated, note, load_factor, stall_m_s, least_m_s, knock_off })
}

/// The airspeed below which a point ends, in words.
fn knock_off(least_m_s: f64, ratio: f64, load_factor: f64) -> String {
    let (ratio, kt) = (significant(ratio, 3), significant(least_m_s / M_S_PER_KT, 3));
    let loaded = if load_factor > 1.0 {
        format!(" and a load factor of {}", significant(load_factor, 3))
    } else {
        String::new()
    };
    let least = significant(least_m_s, 3);
    format!("Airspeed below {least} m/s ({kt} kt) calibrated: {ratio} times the stall at this mass{loaded}.")
}

/// A bank or load factor of a point beyond a limit of the campaign or the structure, less the margin.
fn overloaded(campaign: &Campaign, point: &TestPoint, aircraft: &Aircraft, load_factor: f64) -> Option<String> {
    let gate = &campaign.entry;
    let limits = |name: &'static str| campaign.limits.iter().filter(move |limit| limit.quantity == name);
    // Turns are flown to both sides.
    let ends = limits(Role::BankAngle.name()).flat_map(|limit| [limit.low, limit.high]).flatten();
    let least_deg = ends.map(|end| end.abs().to_degrees()).reduce(f64::min);
    if let Some((bank, limit)) = point.bank_deg.zip(least_deg)
        && bank + gate.bank_margin_deg > limit + ROUNDING
    {
        let margin = significant(gate.bank_margin_deg, 2);
        return Some(format!("{bank:.0} deg of bank with a margin of {margin} deg exceeds the limit {limit:.0} deg"));
    }
    let envelope = &aircraft.flight_envelope;
    let margin = gate.load_factor_margin;
    let high = limits(LOAD_FACTOR).filter_map(|limit| limit.high).chain(envelope.load_factor_high).reduce(f64::min);
    let low = limits(LOAD_FACTOR).filter_map(|limit| limit.low).chain(envelope.load_factor_low).reduce(f64::max);
    let beyond = high.filter(|high| load_factor + margin > high + ROUNDING);
    let beyond = beyond.or_else(|| low.filter(|low| load_factor - margin < low - ROUNDING))?;
    let (own, margin, limit) = (significant(load_factor, 3), significant(margin, 2), significant(beyond, 3));
    Some(format!("a load factor of {own} with a margin of {margin} is beyond the limit {limit}"))
}

/// What a sum of stated numbers may be off.
const ROUNDING: f64 = 1e-9;

/// A limit besides airspeed that a point is beyond.
fn outside(
    point: &TestPoint,
    gate: &EntryGate,
    aircraft: &Aircraft,
    mass: &MassProperties,
    campaign: &Campaign,
) -> Option<String> {
    let highest = point.altitude_m + gate.altitude_m;
    if let Some(ceiling) = aircraft.flight_envelope.ceiling_m.filter(|ceiling| highest > *ceiling) {
        return Some(format!("{highest:.0} m with the entry tolerance exceeds the ceiling {ceiling:.0} m"));
    }
    for limit in campaign.limits.iter().filter(|limit| limit.quantity == "altitude") {
        if limit.high.is_some_and(|high| highest > high) {
            return Some(format!("{highest:.0} m with the entry tolerance exceeds the limit of the campaign"));
        }
        if limit.low.is_some_and(|low| point.altitude_m - gate.altitude_m < low) {
            return Some(format!("{:.0} m is below the limit of the campaign", point.altitude_m - gate.altitude_m));
        }
    }
    let cg = mass.cg_from_datum_m[0];
    let margin = aircraft.envelope.as_ref().and_then(|envelope| envelope.margin(mass.mass_kg, cg))?;
    (!margin.inside()).then(|| {
        format!("{:.0} kg with the centre of gravity at {cg:.3} m is outside the envelope of the loading", mass.mass_kg)
    })
}

fn lower_bounds(
    campaign: &Campaign,
    aircraft: &Aircraft,
    (mass, load_factor): (&MassProperties, f64),
    (least_m_s, ratio): (Option<f64>, f64),
    calibrated_of_true: f64,
) -> Vec<Bound> {
    let envelope = &aircraft.flight_envelope;
    let stall = envelope.stall_at(load_factor, mass.mass_kg);
    let buffet = stall.zip(envelope.buffet_over_stall).map(|(stall, over)| stall * over);
    let loaded =
        if load_factor > 1.0 { format!(" at a load factor of {}", significant(load_factor, 3)) } else { String::new() };
    let of_stall = format!("{} times the stall{loaded}", significant(ratio, 3));
    let stated = [(of_stall, least_m_s), ("the onset of buffet".to_owned(), buffet)];
    let limits = campaign_limits(campaign, calibrated_of_true).filter_map(|(low, _)| low);
    let limits = limits.map(|value_m_s| Bound { text: "the limit of the campaign".to_owned(), value_m_s });
    let stated = stated.into_iter().filter_map(|(text, value)| Some(Bound { text, value_m_s: value? }));
    stated.chain(limits).collect()
}

fn upper_bounds(
    campaign: &Campaign,
    point: &TestPoint,
    aircraft: &Aircraft,
    mass: &MassProperties,
    calibrated_of_true: f64,
) -> Vec<Bound> {
    let envelope = &aircraft.flight_envelope;
    // Pulses, sweeps and the like move a control of the flight abruptly. VA is that of the mass of the stall and falls with the root of mass.
    let kind = point.kind.to_lowercase();
    let names = |shape: InputKind| kind.contains(&shape.name().to_lowercase());
    let is_abrupt = InputKind::ALL.into_iter().any(names) && point.amplitude_inhg.is_none();
    let lighter = envelope.stall_mass_kg.map_or(1.0, |stated_kg| (mass.mass_kg / stated_kg).min(1.0).sqrt());
    let manoeuvring = envelope.manoeuvring_m_s.filter(|_| is_abrupt).map(|value| value * lighter);
    let stated = [
        ("VNE", envelope.never_exceed_m_s),
        ("VA at this mass", manoeuvring),
        ("the greatest airspeed of the point", point.greatest_m_s),
    ];
    let stated =
        stated.into_iter().filter_map(|(text, value)| Some(Bound { text: text.to_owned(), value_m_s: value? }));
    let limits = campaign_limits(campaign, calibrated_of_true).filter_map(|(_, high)| high);
    stated.chain(limits.map(|value_m_s| Bound { text: "the limit of the campaign".to_owned(), value_m_s })).collect()
}

/// Limits of the campaign on airspeed as calibrated airspeeds, m/s.
fn campaign_limits(
    campaign: &Campaign,
    calibrated_of_true: f64,
) -> impl Iterator<Item = (Option<f64>, Option<f64>)> + '_ {
    campaign.limits.iter().filter_map(move |limit| {
        let factor = match limit.quantity.as_str() {
            "calibrated_airspeed" => 1.0,
            "airspeed" => calibrated_of_true,
            _ => return None,
        };
        Some((limit.low.map(|low| low * factor), limit.high.map(|high| high * factor)))
    })
}

#[cfg(test)]
mod tests;
