//! Cards of the tests of the rule that the session has no full record of, as a campaign.

use std::f64::consts::TAU;
use std::path::Path;

use doublet_core::airframe::{Aircraft, calibrated_m_s};
use doublet_core::atmos::Atmosphere;
use doublet_core::quantity::Role;
use doublet_core::statistics::median;
use serde::Serialize;

use super::TestFile;
use super::index::{IndexRow, IndexStatus};
use super::profile::{Moved, Profile};
use super::units::{FOOT_M, FOOT_PER_MINUTE_M_S};
use crate::builtin::PREFIX;
use crate::planning::{self, CAMPAIGN_FORMAT, CAMPAIGN_VERSION, HazardLevel, Risk};
use crate::session::{Manoeuvre, Session, Surface};
use crate::snapshot::Snapshot;
use crate::stage::{ObjectiveTest, measure_condition, movement};

/// Shortest run with the way back to trim, s.
const LEAST_RUN_S: f64 = 60.0;
/// Time of a run beside the record, s.
const AROUND_S: f64 = 30.0;
/// Length of a record of which the rule states none, s.
const RECORD_S: f64 = 30.0;
/// Time from one condition to the next, s.
const TRANSIT_S: f64 = 300.0;
/// Airspeed over the stall below which a card ends.
const STALL_RATIO: f64 = 1.2;
/// Tolerance of the entry airspeed, m/s.
const ENTRY_M_S: f64 = 1.0;
/// Steps to which altitudes (m) and airspeeds (m/s) are rounded.
const ALTITUDE_STEP_M: f64 = 10.0;
const AIRSPEED_STEP_M_S: f64 = 0.1;
/// Wind box of the shipped campaigns, m/s.
const WIND: Wind = Wind { speed_m_s: 10.0, gust_m_s: 0.5, shear_m_s: 2.0 };
/// Distance of an engine from the plane of symmetry within which its failure leaves no yawing moment, m.
const IN_LINE_M: f64 = 0.1;
/// Conditions of the rule in which flaps may be extended.
const EXTENDED: [&str; 4] = ["take-off", "approach", "landing", "segment"];

#[derive(Serialize)]
struct Campaign {
    format: &'static str,
    version: u32,
    title: String,
    aircraft: String,
    objectives: Vec<String>,
    restrictions: Vec<String>,
    stall_ratio: f64,
    limits: Vec<String>,
    fuel: Fuel,
    entry: Entry,
    wind: Wind,
    risk: Vec<Risk>,
    point: Vec<Point>,
}

#[derive(Serialize)]
struct Fuel {
    start_kg: f64,
    burn_kg_s: f64,
    transit_s: f64,
}

#[derive(Serialize)]
struct Entry {
    airspeed_m_s: f64,
}

#[derive(Serialize)]
struct Wind {
    speed_m_s: f64,
    gust_m_s: f64,
    shear_m_s: f64,
}

#[derive(Serialize)]
struct Point {
    id: String,
    airspeed_m_s: f64,
    altitude_m: f64,
    configuration: String,
    kind: String,
    surface: &'static str,
    amplitude_deg: f64,
    repeats: usize,
    duration_s: f64,
    hazard: &'static str,
    power: &'static str,
    loss_m_s: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    engine_speed_rpm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    manifold_pressure_inhg: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stall_ratio: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bank_deg: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    greatest_m_s: Option<f64>,
    procedure: Vec<String>,
    /// The records there are do not make the card flown.
    #[serde(skip_serializing_if = "Option::is_none")]
    judged: Option<planning::Flown>,
    risk: Vec<Risk>,
}

/// Why a test has no card.
enum NoCard {
    /// The aeroplane lacks what is tested.
    Outside(String),
    /// A number is missing.
    Withheld(String),
}

/// A campaign of the tests that are not passed in full, at the conditions of the session; none where there is none or nothing was flown. Rows
/// of the index whose card cannot be written state why.
pub(super) fn cards(
    session: &Session,
    folder: &Path,
    snapshot: &Snapshot,
    file: &TestFile,
    index: &mut [IndexRow],
) -> Option<String> {
    let loaded = snapshot.aircraft.ready()?;
    let flown =
        Flown { session, snapshot, file, aircraft: &loaded.aircraft, conditions: conditions(session, snapshot) };
    let point = flown.points(index);
    if point.is_empty() {
        return None;
    }
    let name = session.aircraft.as_deref()?;
    let aircraft =
        if name.starts_with(PREFIX) { name.to_owned() } else { folder.join(name).to_string_lossy().into_owned() };
    let loading = session.loading.as_ref().filter(|loading| !loading.fuel_kg.is_empty());
    let start_kg = loading.unwrap_or(&loaded.aircraft.standard_loading).fuel_kg.values().sum::<f64>();
    let burn_kg_s = burn_kg_s(session, snapshot);
    let fastest = flown.aircraft.flight_envelope.never_exceed_m_s;
    let limits = ["phi=-60deg:60deg", "n_z=0:2"].map(str::to_owned).into_iter();
    let campaign = Campaign {
        format: CAMPAIGN_FORMAT,
        version: CAMPAIGN_VERSION,
        title: format!("Tests without a full record: {}", file.rule.name),
        aircraft,
        objectives: vec![format!("A record for every test of {} that applies to the model.", file.rule.name)],
        restrictions: flown.restrictions(burn_kg_s.is_some(), index),
        stall_ratio: STALL_RATIO,
        limits: limits.chain(fastest.map(|speed| format!("calibrated_airspeed=:{speed}m/s"))).collect(),
        fuel: Fuel { start_kg, burn_kg_s: burn_kg_s.unwrap_or(0.0), transit_s: TRANSIT_S },
        entry: Entry { airspeed_m_s: ENTRY_M_S },
        wind: WIND,
        risk: vec![Risk {
            hazard: "Other traffic while heads are down".to_owned(),
            mitigation: "Clearing turn before each run; lookout by one member of the crew.".to_owned(),
            level: Some(HazardLevel::Low),
        }],
        point,
    };
    toml::to_string(&campaign).ok()
}

/// Fuel burnt over the manoeuvres of each flight, kg/s; none where the mass does not fall.
fn burn_kg_s(session: &Session, snapshot: &Snapshot) -> Option<f64> {
    let mut rates: Vec<f64> =
        session.flights.iter().filter_map(|flight| burn_of_flight(session, snapshot, &flight.name)).collect();
    median(&mut rates)
}

fn burn_of_flight(session: &Session, snapshot: &Snapshot, flight: &str) -> Option<f64> {
    let of_flight = session.windows.iter().filter(|window| window.flight == flight);
    let masses = of_flight.filter_map(|window| {
        let aero = snapshot.windows.get(&window.name)?.aero.ready()?;
        Some((window.window.start_s, aero.data.mass.first()?.mass_kg))
    });
    let masses: Vec<(f64, f64)> = masses.collect();
    let first = masses.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let last = masses.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let rate = (first.1 - last.1) / (last.0 - first.0);
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

/// A manoeuvre with the airspeed and altitude of its condition.
struct Condition<'a> {
    window: &'a Manoeuvre,
    airspeed_m_s: f64,
    altitude_m: f64,
}

/// Conditions of the manoeuvres, the slowest first.
fn conditions<'a>(session: &'a Session, snapshot: &Snapshot) -> Vec<Condition<'a>> {
    let mut found: Vec<Condition<'a>> =
        session.windows.iter().filter_map(|window| condition(window, snapshot)).collect();
    found.sort_by(|a, b| a.airspeed_m_s.total_cmp(&b.airspeed_m_s));
    found
}

fn condition<'a>(window: &'a Manoeuvre, snapshot: &Snapshot) -> Option<Condition<'a>> {
    let aero = snapshot.windows.get(&window.name)?.aero.ready()?;
    let found = measure_condition(aero)?;
    let altitude_m = found.altitude_m.unwrap_or(0.0).round();
    Some(Condition { window, airspeed_m_s: found.airspeed_m_s.round(), altitude_m })
}

/// What was flown, and by which aircraft.
struct Flown<'a> {
    session: &'a Session,
    snapshot: &'a Snapshot,
    file: &'a TestFile,
    aircraft: &'a Aircraft,
    conditions: Vec<Condition<'a>>,
}

impl Flown<'_> {
    /// Cards of the rows that need one; a row whose card cannot be written states why. No cards where nothing was flown.
    fn points(&self, index: &mut [IndexRow]) -> Vec<Point> {
        let (Some(slow), Some(fast)) = (self.conditions.first(), self.conditions.last()) else { return Vec::new() };
        let mut points: Vec<Point> = Vec::new();
        for row in index.iter_mut().filter(|row| row.status.needs_card()) {
            let Some(test) = self.file.rule.test(&row.id) else { continue };
            let (status, reason) = match self.point(test, row, [slow, fast]) {
                Ok(card) => {
                    points.push(card);
                    continue;
                }
                Err(NoCard::Outside(reason)) => (IndexStatus::Outside, reason),
                Err(NoCard::Withheld(reason)) => (IndexStatus::Withheld, reason),
            };
            // What was judged stays: the reason is added.
            let is_open = row.status == IndexStatus::Missing;
            row.reason = if is_open { reason } else { format!("{}; no card: {reason}", row.reason) };
            row.status = if is_open { status } else { row.status };
        }
        points
    }

    /// The card of a test at the slowest or the fastest condition, or why it has none.
    fn point(&self, test: &ObjectiveTest, row: &IndexRow, [slow, fast]: [&Condition<'_>; 2]) -> Result<Point, NoCard> {
        let profile = Profile::of_test(test);
        self.has_engines(&profile)?;
        // Of a test that passes in a part of its conditions the others are flown.
        let open = row.conditions_open.join(", ");
        let configuration = if open.is_empty() { test.condition.clone() } else { open };
        let is_clean = configuration.contains("clean") && profile.climb_m <= 0.0;
        let is_cruise = configuration.contains("cruise") || is_clean;
        let condition = if is_cruise { fast } else { slow };
        let altitude_m = condition.altitude_m.max((profile.least_entry_m() / ALTITUDE_STEP_M).ceil() * ALTITUDE_STEP_M);
        let density_kg_m3 = Atmosphere::STANDARD.density_kg_m3(altitude_m).map_err(|error| {
            NoCard::Withheld(format!("{error}: correct the altitude of manoeuvre '{}'", condition.window.name))
        })?;
        let calibrated_of_true = calibrated_m_s(1.0, density_kg_m3);
        let greatest_m_s = self.greatest(&profile, is_cruise)?;
        let airspeed_m_s = self.airspeed(&profile, condition.airspeed_m_s, calibrated_of_true, greatest_m_s);
        let record = &test.record;
        let length_s = [record.least_s, record.before_s + record.after_s, RECORD_S, profile.height_s()];
        let length_s = length_s.into_iter().fold(0.0, f64::max);
        let is_level = profile.power.is_empty();
        let setting =
            |roles: [Role; 2], per_si: f64| is_level.then(|| self.setting(condition, roles, per_si)).flatten();
        let surface = profile.surface;
        Ok(Point {
            id: test.id.clone(),
            airspeed_m_s,
            altitude_m,
            configuration,
            kind: test.kinds.first().cloned().unwrap_or_else(|| "doublet".to_owned()),
            surface: surface.map_or("", Surface::name),
            amplitude_deg: surface.and_then(|surface| self.amplitude_deg(surface)).unwrap_or(0.0),
            repeats: 2,
            duration_s: (length_s + AROUND_S + profile.back_s()).max(LEAST_RUN_S).round(),
            hazard: profile.hazard,
            power: profile.power,
            loss_m_s: profile.loss_m_s,
            engine_speed_rpm: setting([Role::EngineSpeed1, Role::EngineSpeed2], 60.0 / TAU),
            manifold_pressure_inhg: setting([Role::ManifoldPressure1, Role::ManifoldPressure2], 1.0 / INHG_PA),
            stall_ratio: profile.stall_ratio,
            bank_deg: profile.bank_deg(is_cruise),
            greatest_m_s,
            procedure: procedure(test, row, &profile),
            judged: match row.status {
                IndexStatus::Partly => Some(planning::Flown::Partly),
                IndexStatus::NotJudged => Some(planning::Flown::Repeat),
                _ => None,
            },
            risk: vec![profile.risk()],
        })
    }

    /// Whether the aeroplane has the engines of a test.
    fn has_engines(&self, profile: &Profile) -> Result<(), NoCard> {
        let engines = &self.aircraft.engines;
        if profile.engines > 1 && engines.len() == 1 {
            return Err(NoCard::Outside("the aeroplane has one engine".to_owned()));
        }
        let in_line = engines.iter().all(|engine| engine.position_from_datum_m[1].abs() <= IN_LINE_M);
        if profile.is_asymmetric && !engines.is_empty() && in_line {
            let reason = "engines in the plane of symmetry leave no yawing moment";
            return Err(NoCard::Withheld(reason.to_owned()));
        }
        Ok(())
    }

    /// Calibrated airspeed that what is moved or extended allows, m/s.
    fn greatest(&self, profile: &Profile, is_cruise: bool) -> Result<Option<f64>, NoCard> {
        let stated = |moved: Moved| {
            let own = self.file.equipment.get(moved.names().0).copied();
            own.or(self.aircraft.flight_envelope.flaps_extended_m_s.filter(|_| moved == Moved::Flaps))
        };
        let Some(moved) = profile.moved else {
            return Ok(stated(Moved::Flaps).filter(|speed| *speed > 0.0 && !is_cruise));
        };
        let (key, name) = moved.names();
        match stated(moved) {
            Some(0.0) => Err(NoCard::Outside(format!("the aeroplane has no {name}"))),
            None => Err(NoCard::Withheld(format!("state {key} under equipment in the test file"))),
            Some(speed) => {
                let limits = &self.aircraft.limits;
                let heaviest = limits.max_takeoff_kg.or(self.aircraft.flight_envelope.stall_mass_kg);
                let stall = heaviest.and_then(|mass| self.aircraft.flight_envelope.stall_at(1.0, mass));
                let least = stall.map_or(0.0, |stall| STALL_RATIO * stall) + profile.loss_m_s + 2.0 * ENTRY_M_S;
                if speed < least {
                    let reason = format!("{key} is below {least:.1} m/s, the least safe airspeed over the stall");
                    return Err(NoCard::Withheld(reason));
                }
                Ok(Some(speed))
            }
        }
    }

    /// True airspeed of the entry, m/s: that of the manoeuvres, below what is extended; an emergency descent at the manoeuvring airspeed.
    fn airspeed(&self, profile: &Profile, flown_m_s: f64, calibrated_of_true: f64, greatest_m_s: Option<f64>) -> f64 {
        let envelope = &self.aircraft.flight_envelope;
        let mass_kg = |condition: &Condition<'_>| {
            let aero = self.snapshot.windows.get(&condition.window.name)?.aero.ready()?;
            Some(aero.data.mass.first()?.mass_kg)
        };
        let lightest_kg = self.conditions.iter().filter_map(mass_kg).reduce(f64::min);
        let lighter = lightest_kg.zip(envelope.stall_mass_kg).map_or(1.0, |(own, stated)| (own / stated).min(1.0));
        let manoeuvring = envelope.manoeuvring_m_s.filter(|_| profile.is_fast);
        let wanted = manoeuvring.map(|speed| speed * lighter.sqrt() - 2.0 * ENTRY_M_S);
        let wanted = wanted.unwrap_or(flown_m_s * calibrated_of_true);
        let calibrated = greatest_m_s.map_or(wanted, |greatest| wanted.min(greatest - 2.0 * ENTRY_M_S));
        let steps = (calibrated / calibrated_of_true / AIRSPEED_STEP_M_S).floor();
        // Tenths are exact in the file only as a quotient.
        steps / (1.0 / AIRSPEED_STEP_M_S)
    }

    /// Median over a manoeuvre and over the engines of what was set, in the unit of the card; none where it was not recorded.
    fn setting(&self, condition: &Condition<'_>, roles: [Role; 2], per_si: f64) -> Option<f64> {
        let recording = &self.snapshot.flights.get(&condition.window.flight)?.ready()?.recording;
        let range = condition.window.window;
        let of_role = |role: Role| {
            let series = &recording.role(role)?.series;
            let first = series.time_s.partition_point(|&time| time < range.start_s);
            let last = series.time_s.partition_point(|&time| time <= range.end_s);
            median(&mut series.values.get(first..last)?.to_vec())
        };
        let mut values: Vec<f64> = roles.into_iter().filter_map(of_role).filter(|value| value.is_finite()).collect();
        median(&mut values).map(|value| (10.0 * value * per_si).round() / 10.0)
    }

    /// Median of the largest deflection of a surface in its manoeuvres, deg: what was flown before.
    fn amplitude_deg(&self, surface: Surface) -> Option<f64> {
        let of_window = |window: &Manoeuvre| {
            let aero = self.snapshot.windows.get(&window.name)?.aero.ready()?;
            Some(movement(window, aero)?.largest_rad.abs().to_degrees())
        };
        let own = self.session.windows.iter().filter(|window| window.surface == Some(surface));
        let mut found: Vec<f64> = own.filter_map(of_window).collect();
        median(&mut found).map(|value| (10.0 * value).round() / 10.0)
    }

    /// What the crew has to know before the flight, and the tests without a card.
    fn restrictions(&self, is_burn_known: bool, index: &[IndexRow]) -> Vec<String> {
        let mut lines = vec!["Altitudes are above sea level: add the elevation of the ground.".to_owned()];
        if !is_burn_known {
            lines.push("Fuel burn is not known: masses of all cards are those of the start.".to_owned());
        }
        let is_extended = |row: &&IndexRow| EXTENDED.iter().any(|word| row.condition.contains(word));
        let flaps = self.file.equipment.get(Moved::Flaps.names().0).copied();
        let is_known = flaps.or(self.aircraft.flight_envelope.flaps_extended_m_s).is_some();
        if !is_known && index.iter().filter(is_extended).any(|row| row.status.needs_card()) {
            lines.push("VFE is not known: flaps stay up until it is stated.".to_owned());
        }
        let without = index.iter().filter(|row| row.status == IndexStatus::Withheld);
        lines.extend(without.map(|row| format!("{} {}: {}.", row.id, row.name, row.reason)));
        lines
    }
}

/// An inch of mercury, Pa.
const INHG_PA: f64 = 3386.389;

/// What is done: the test, the height and the rate that is planned for, what a record that is there lacks.
fn procedure(test: &ObjectiveTest, row: &IndexRow, profile: &Profile) -> Vec<String> {
    let mut lines = vec![test.procedure.clone()];
    if profile.climb_m != 0.0 {
        lines.push(format!(
            "Planned for {:.0} ft/min: {:.0} s for {:.0} ft.",
            profile.rate_m_s / FOOT_PER_MINUTE_M_S,
            profile.height_s(),
            profile.climb_m.abs() / FOOT_M
        ));
    }
    if row.status != IndexStatus::Missing {
        lines.push(format!("So far: {}.", row.reason));
    }
    lines.push(format!("Keep the controls as trimmed for {:.0} s before the input.", test.record.before_s.max(5.0)));
    lines
}

#[cfg(test)]
mod tests {
    use doublet_core::load::aircraft;

    use super::super::index::index;
    use super::*;
    use crate::{builtin, session};

    #[test]
    fn an_altitude_outside_the_atmosphere_leaves_out_its_own_cards_only() {
        let file = TestFile::parse(builtin::text("qtg", "demo").unwrap(), Path::new(".")).unwrap();
        let session = session::parse(builtin::session("demo").unwrap()).unwrap();
        let aircraft = aircraft::parse(builtin::text("aircraft", "c337f").unwrap()).unwrap();
        let snapshot = Snapshot::default();
        let cards_of = |altitude_m: f64| {
            let slow = Condition { window: &session.windows[0], airspeed_m_s: 45.0, altitude_m: 1000.0 };
            let fast = Condition { window: &session.windows[1], airspeed_m_s: 60.0, altitude_m };
            let conditions = vec![slow, fast];
            let flown = Flown { session: &session, snapshot: &snapshot, file: &file, aircraft: &aircraft, conditions };
            let mut index = index(&file.rule, &[]);
            let ids: Vec<String> = flown.points(&mut index).into_iter().map(|card| card.id).collect();
            (ids, index)
        };
        let (all, _) = cards_of(1000.0);
        let (left, index) = cards_of(40_000.0);
        assert!(!left.is_empty() && left.len() < all.len(), "{left:?} of {all:?}");
        for row in index.iter().filter(|row| all.contains(&row.id)) {
            let is_left = left.contains(&row.id);
            let expected = if is_left { IndexStatus::Missing } else { IndexStatus::Withheld };
            assert_eq!(row.status, expected, "{}", row.id);
            assert_eq!(!is_left, row.reason.contains("40000 m"), "{}: {}", row.id, row.reason);
        }
    }
}
