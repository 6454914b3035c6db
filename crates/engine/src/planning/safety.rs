//! Whether a test point may be flown: its entry against the envelope of the aircraft, its own knock-it-off rule and the limits of the campaign.

use doublet_core::airframe::{Aircraft, MassProperties, calibrated_m_s};
use serde::{Deserialize, Serialize};

use super::campaign::{Campaign, TestPoint};
use crate::graph::StageResult;
use crate::notation::significant;

/// Speed of a knot, m/s.
pub(super) const M_S_PER_KT: f64 = 1852.0 / 3600.0;
/// Entry airspeeds that are raised are multiples of this, m/s.
const RAISED_STEP_M_S: f64 = 0.1;

/// A hazard and what is done about it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Risk {
    /// Hazard.
    pub hazard: String,
    /// Mitigation.
    pub mitigation: String,
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
    /// Calibrated airspeed of the stall at the mass of the point, m/s.
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
    if let Some(text) = outside(point, gate, aircraft, mass, campaign) {
        return refused(text);
    }
    let calibrated_of_true = calibrated_m_s(1.0, density_kg_m3);
    let stall_m_s = aircraft.flight_envelope.stall_at(1.0, mass.mass_kg);
    let ratio = point.stall_ratio.unwrap_or(campaign.stall_ratio);
    let least_m_s = stall_m_s.map(|stall| ratio * stall);
    let low = lower_bounds(campaign, aircraft, mass, (least_m_s, ratio), calibrated_of_true);
    let high = upper_bounds(campaign, aircraft, calibrated_of_true);
    let (mut airspeed_m_s, mut note) = (point.airspeed_m_s, None);
    let room_m_s = gate.airspeed_m_s + gate.loss_m_s;
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
            significant(gate.loss_m_s, 2),
        );
        if gate.on_limit == OnLimit::Refuse {
            return refused(format!("{text}; enter at {} m/s true or faster", significant(needed, 4)));
        }
        let (from, to) = (significant(airspeed_m_s, 3), significant(needed, 3));
        note = Some(format!("Entry airspeed raised from {from} to {to} m/s true: {text}."));
        airspeed_m_s = needed;
    }
    let calibrated = airspeed_m_s * calibrated_of_true;
    if let Some(bound) = high.iter().find(|bound| calibrated + gate.airspeed_m_s > bound.value_m_s) {
        let (own, limit) = (significant(calibrated + gate.airspeed_m_s, 3), significant(bound.value_m_s, 3));
        return refused(format!("{own} m/s calibrated with the entry tolerance exceeds {} {limit} m/s", bound.text));
    }
    let rule = |least: f64| {
        let (ratio, kt) = (significant(ratio, 3), significant(least / M_S_PER_KT, 3));
        format!(
            "Airspeed below {} m/s ({kt} kt) calibrated: {ratio} times the stall at this mass.",
            significant(least, 3)
        )
    };
    Ok(Entry { airspeed_m_s, calibrated_m_s: calibrated, note, stall_m_s, least_m_s, knock_off: least_m_s.map(rule) })
}

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
    mass: &MassProperties,
    (least_m_s, ratio): (Option<f64>, f64),
    calibrated_of_true: f64,
) -> Vec<Bound> {
    let envelope = &aircraft.flight_envelope;
    let buffet = envelope.stall_at(1.0, mass.mass_kg).zip(envelope.buffet_over_stall).map(|(stall, over)| stall * over);
    let stated =
        [(format!("{} times the stall", significant(ratio, 3)), least_m_s), ("the onset of buffet".to_owned(), buffet)];
    let limits = campaign_limits(campaign, calibrated_of_true).filter_map(|(low, _)| low);
    let limits = limits.map(|value_m_s| Bound { text: "the limit of the campaign".to_owned(), value_m_s });
    let stated = stated.into_iter().filter_map(|(text, value)| Some(Bound { text, value_m_s: value? }));
    stated.chain(limits).collect()
}

fn upper_bounds(campaign: &Campaign, aircraft: &Aircraft, calibrated_of_true: f64) -> Vec<Bound> {
    let envelope = &aircraft.flight_envelope;
    let stated = envelope.never_exceed_m_s.map(|value_m_s| Bound { text: "VNE".to_owned(), value_m_s }).into_iter();
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
mod tests {
    use doublet_core::load::aircraft;

    use super::super::campaign::PlannedPoint;
    use super::*;
    use crate::builtin;

    fn c337f() -> Aircraft {
        aircraft::parse(builtin::text("aircraft", "aircraft/c337f.toml").unwrap()).unwrap()
    }

    fn shipped() -> String {
        builtin::text("campaigns", "c337f").unwrap().to_owned()
    }

    fn planned(text: &str) -> Result<Vec<PlannedPoint>, String> {
        let aircraft = c337f();
        let campaign = Campaign::parse(text).map_err(|error| error.to_string())?;
        campaign.plan(&aircraft, &aircraft.standard_loading, None).map_err(|error| error.to_string())
    }

    fn card<'p>(cards: &'p [PlannedPoint], id: &str) -> &'p PlannedPoint {
        cards.iter().find(|card| card.id == id).unwrap()
    }

    /// Limits are written out from the aircraft file, not taken from the code: stall 36 m/s at 2100.133 kg, VNE 102 m/s, ceiling 5900 m.
    #[test]
    fn no_card_of_the_shipped_campaign_breaks_a_limit() {
        let campaign = Campaign::parse(&shipped()).unwrap();
        let (room, height) = (campaign.entry.airspeed_m_s + campaign.entry.loss_m_s, campaign.entry.altitude_m);
        let cards = planned(&shipped()).unwrap();
        assert_eq!(cards.len(), 9);
        for card in &cards {
            let id = &card.id;
            let calibrated = card.airspeed_m_s * (1.0 - 2.25577e-5 * card.altitude_m).powf(4.25588 / 2.0);
            assert!((calibrated - card.calibrated_m_s).abs() < 1e-3, "{id}: {calibrated}");
            let stall = 36.0 * (card.mass_kg / 2100.133).sqrt();
            assert!(calibrated - room >= 1.2 * stall, "{id}: {calibrated} is {} times the stall", calibrated / stall);
            assert!(calibrated + campaign.entry.airspeed_m_s <= 102.0, "{id}");
            assert!(card.altitude_m + height <= 5900.0, "{id}");
            assert!(card.cg_margin_m.unwrap() >= 0.0, "{id}");
            for limit in campaign.limits.iter().filter(|limit| limit.quantity == "calibrated_airspeed") {
                assert!(calibrated - room >= limit.low.unwrap() && calibrated <= limit.high.unwrap(), "{id}");
            }
            // Nothing of the shipped cards is raised, and each states what it needs to be flown.
            assert_eq!((&card.entry_note, card.step_s.is_some()), (&None, true), "{id}");
            assert!(card.engine_speed_rpm.is_some() && card.manifold_pressure_inhg.is_some() && !card.risks.is_empty());
        }
    }

    #[test]
    fn slow_entry_is_raised_or_refused() {
        let slow = shipped().replacen("airspeed_m_s = 52.0", "airspeed_m_s = 40.0", 1);
        let cards = planned(&slow).unwrap();
        let raised = card(&cards, "4.1");
        // The slowest of the limits is that of the campaign, 43.2 m/s, with 1 m/s of tolerance and 1 m/s lost.
        assert!((45.2..45.3).contains(&raised.calibrated_m_s), "{}", raised.calibrated_m_s);
        assert!(raised.entry_note.is_some());
        let without = slow.replace(", \"calibrated_airspeed=43.2m/s:102m/s\"", "");
        let cards = planned(&without).unwrap();
        let (raised, stall) = (card(&cards, "4.1"), 36.0 * (card(&cards, "4.1").mass_kg / 2100.133).sqrt());
        assert!((0.0..0.1).contains(&(raised.calibrated_m_s - 1.2 * stall - 2.0)), "{}", raised.calibrated_m_s);
        let refused = slow.replace("loss_m_s = 1.0", "loss_m_s = 1.0\non_limit = \"refuse\"");
        assert!(planned(&refused).unwrap_err().starts_with("point 4.1: "));
        // A point may have a rule of its own.
        let own = without.replace("repeats = 2\n", "repeats = 2\nstall_ratio = 1.0\n");
        assert_eq!(card(&planned(&own).unwrap(), "4.1").entry_note, None);
    }

    #[test]
    fn what_a_higher_airspeed_does_not_mend_is_refused() {
        for (from, to) in [
            ("airspeed_m_s = 52.0", "airspeed_m_s = 108.0"),
            ("altitude_m = 762.0", "altitude_m = 5895.0"),
            ("start_kg = 340.0", "start_kg = 640.0"),
        ] {
            let text = shipped().replacen(from, to, 1).replace(":102m/s", ":");
            assert!(planned(&text).unwrap_err().starts_with("point "), "{to}");
        }
        let shipped = shipped();
        let (begin, points) =
            (shipped.split("[[risk]]").next().unwrap(), &shipped[shipped.find("[[point]]").unwrap()..]);
        assert!(Campaign::parse(&format!("{begin}{points}")).is_ok());
        let hazardous = format!("{begin}{}", points.replacen("hazard = \"low\"", "hazard = \"high\"", 1));
        assert!(Campaign::parse(&hazardous).unwrap_err().to_string().contains("point.risk"));
    }
}
