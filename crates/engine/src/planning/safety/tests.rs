//! Tests of the limits of test points.

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

/// Largest angle in texts, deg: of `Hold 30 deg and 40 deg for 10 s each` 40.
fn largest_deg<'t>(texts: impl Iterator<Item = &'t str>) -> Option<f64> {
    let words: Vec<&str> = texts.flat_map(str::split_whitespace).collect();
    let pairs = words.windows(2).filter(|pair| pair[1].trim_matches(|letter: char| !letter.is_alphabetic()) == "deg");
    pairs.filter_map(|pair| pair[0].parse().ok()).reduce(f64::max)
}

/// Limits are written out from the aircraft file and read from the texts of the cards, not taken from the code: stall 36 m/s and VA 69 m/s at
/// 2100.133 kg, VNE 102 m/s, load factor -1.496 to 3.740, ceiling 5900 m.
#[test]
fn no_card_of_any_shipped_campaign_breaks_a_limit() {
    let names = builtin::names("campaigns");
    assert!(names.len() >= 2 && names.contains(&"c337f") && names.contains(&"c337f_static"), "{names:?}");
    let mut turns = 0;
    for name in names {
        let text = builtin::text("campaigns", name).unwrap();
        let campaign = Campaign::parse(text).unwrap();
        assert_eq!(campaign.aircraft, "builtin:c337f", "{name}: write its limits down here");
        let bank_limit = largest_deg(campaign.knock_off.iter().map(String::as_str)).unwrap();
        for card in planned(text).unwrap() {
            let id = format!("{name} {}", card.id);
            // The bank a turn holds is that of its procedure.
            let turn = card.kind.contains("turn");
            turns += usize::from(turn);
            let bank = if turn { largest_deg(card.procedure.iter().map(String::as_str)).unwrap() } else { 0.0 };
            assert_eq!(card.bank_deg.unwrap_or(0.0), bank, "{id}");
            assert!(bank + 5.0 <= bank_limit, "{id}: {bank} deg of bank, the run ends at {bank_limit} deg");
            let load = 1.0 / bank.to_radians().cos();
            assert!((card.load_factor - load).abs() < 1e-9 && load + 0.2 <= 2.0, "{id}: load factor {load}");
            breaks_no_speed(&id, &campaign, &card, load);
            assert!(card.altitude_m + campaign.entry.altitude_m <= 5900.0, "{id}");
            assert!(card.cg_margin_m.unwrap() >= 0.0, "{id}");
            // Nothing of the shipped cards is raised, and each states what it needs to be flown.
            assert_eq!(card.entry_note, None, "{id}");
            assert!(card.engine_speed_rpm.is_some() && card.manifold_pressure_inhg.is_some() && !card.risks.is_empty());
        }
    }
    assert!(turns > 0);
}

fn breaks_no_speed(id: &str, campaign: &Campaign, card: &PlannedPoint, load: f64) {
    let room = campaign.entry.airspeed_m_s + campaign.entry.loss_m_s;
    let calibrated = card.airspeed_m_s * (1.0 - 2.25577e-5 * card.altitude_m).powf(4.25588 / 2.0);
    assert!((calibrated - card.calibrated_m_s).abs() < 1e-3, "{id}: {calibrated}");
    let (lighter, highest) = ((card.mass_kg / 2100.133).sqrt(), calibrated + campaign.entry.airspeed_m_s);
    let stall = 36.0 * lighter * load.sqrt();
    assert!(calibrated - room >= 1.2 * stall, "{id}: {calibrated} is {} times the stall", calibrated / stall);
    assert!(highest <= 102.0 && highest <= 69.0 * lighter, "{id}");
    for limit in campaign.limits.iter().filter(|limit| limit.quantity == "calibrated_airspeed") {
        assert!(calibrated - room >= limit.low.unwrap() && calibrated <= limit.high.unwrap(), "{id}");
    }
}

#[test]
fn bank_load_factor_and_manoeuvring_speed_are_limits() {
    let shipped = builtin::text("campaigns", "c337f_static").unwrap();
    let refused = |from: &str, to: &str| {
        let text = shipped.replacen(from, to, 1);
        assert_ne!(text, shipped);
        planned(&text).unwrap_err()
    };
    // The turn as it was: 45 deg with a limit of 45 deg.
    assert!(refused("bank_deg = 40.0", "bank_deg = 45.0").starts_with("point S2: 45 deg of bank"));
    assert!(refused("bank_deg = 40.0\n", "").contains("bank_deg or load_factor"));
    assert!(refused("bank_deg = 40.0", "load_factor = 1.9").contains("load factor of 1.9"));
    assert!(refused("bank_deg = 40.0", "load_factor = 0.1").contains("load factor of 0.1"));
    // 60 deg is two times the weight: beyond the limit of 2 less its margin, with the limit of bank taken away.
    let without = shipped.replace("\"phi=-45deg:45deg\", ", "").replacen("bank_deg = 40.0", "bank_deg = 60.0", 1);
    assert!(planned(&without).unwrap_err().contains("load factor of 2"));
    // Without a limit of the campaign the structure's 3.740 remains: 75 deg are 3.864.
    let structure = without.replace("\"n_z=0:2\", ", "").replacen("bank_deg = 60.0", "bank_deg = 75.0", 1);
    assert!(planned(&structure).unwrap_err().contains("3.74"));
    // At 52 m/s true the turn is raised to 1.2 times its own stall, 1.1426 times that of level flight at 40 deg.
    let slow = shipped.replacen("airspeed_m_s = 55.0", "airspeed_m_s = 52.0", 1);
    let cards = planned(&slow).unwrap();
    let raised = card(&cards, "S2");
    let least = 1.2 * 36.0 * (raised.mass_kg / 2100.133 / 40.0_f64.to_radians().cos()).sqrt();
    assert!((0.0..0.1).contains(&(raised.calibrated_m_s - least - 2.0)), "{}", raised.calibrated_m_s);
    // A doublet at 75 m/s true is 69.7 m/s calibrated and more with the tolerance, above VA; the same by the throttles is not abrupt.
    let fast = |from: &str| {
        let place = shipped.find(from).unwrap();
        let (before, behind) = shipped.split_at(place);
        planned(&format!("{before}{}", behind.replacen("airspeed_m_s = 52.0", "airspeed_m_s = 75.0", 1)))
    };
    assert!(fast("id = \"S6\"").unwrap_err().contains("VA at this mass"));
    assert!(fast("id = \"S4\"").is_ok());
}

#[test]
fn cards_state_one_steady_time_and_the_hazard_of_the_worst_risk() {
    let text = shipped().replacen("steady_s = 5.0", "steady_s = 7.5", 1);
    let campaign = Campaign::parse(&text).unwrap();
    assert!(campaign.procedure.contains(&"Hands steady for 7.5 s.".to_owned()), "{:?}", campaign.procedure);
    // Stall and overstress are medium with their mitigations, beside points that state low.
    let hazards = |text: &str| planned(text).unwrap().iter().map(|card| card.hazard.clone()).collect::<Vec<_>>();
    assert!(text.contains("hazard = \"low\"") && hazards(&text).iter().all(|hazard| hazard == "medium"));
    let without = text.replace("level = \"medium\"\n", "");
    assert!(hazards(&without).iter().all(|hazard| hazard == "low"));
    let high = without.replacen("hazard = \"low\"", "hazard = \"high\"", 1);
    assert_eq!(hazards(&high).iter().filter(|hazard| *hazard == "high").count(), 1);
    // A category of another scale stays.
    let other = text.replace("hazard = \"low\"", "hazard = \"B2\"");
    assert!(hazards(&other).iter().all(|hazard| hazard == "B2"));
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
    let (begin, points) = (shipped.split("[[risk]]").next().unwrap(), &shipped[shipped.find("[[point]]").unwrap()..]);
    assert!(Campaign::parse(&format!("{begin}{points}")).is_ok());
    let hazardous = format!("{begin}{}", points.replacen("hazard = \"low\"", "hazard = \"high\"", 1));
    assert!(Campaign::parse(&hazardous).unwrap_err().to_string().contains("add a risk"));
}
