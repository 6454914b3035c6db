//! Cards of the tests of the rule that the session has no record of, as a campaign.

use std::path::Path;

use doublet_core::statistics::median;
use serde::Serialize;

use super::index::{IndexRow, IndexStatus};
use crate::builtin::PREFIX;
use crate::planning::{CAMPAIGN_FORMAT, CAMPAIGN_VERSION};
use crate::session::{Session, Surface};
use crate::snapshot::Snapshot;
use crate::stage::{ObjectiveTest, Tolerances, movement};

/// Words of a kind of input with the surface it moves.
const MOVED_BY: [(&str, Surface); 9] = [
    ("pitch", Surface::Elevator),
    ("phugoid", Surface::Elevator),
    ("static stability", Surface::Elevator),
    ("manoeuvring", Surface::Elevator),
    ("roll", Surface::Aileron),
    ("spiral", Surface::Aileron),
    ("yaw", Surface::Rudder),
    ("dutch", Surface::Rudder),
    ("sideslip", Surface::Rudder),
];
/// Shortest run with the way back to trim, s.
const LEAST_RUN_S: f64 = 60.0;
/// Time of a run beside the record, s.
const AROUND_S: f64 = 30.0;
/// Length of a record of which the rule states none, s.
const RECORD_S: f64 = 30.0;

#[derive(Serialize)]
struct Campaign {
    format: &'static str,
    version: u32,
    title: String,
    aircraft: String,
    objectives: Vec<String>,
    fuel: Fuel,
    point: Vec<Point>,
}

#[derive(Serialize)]
struct Fuel {
    start_kg: f64,
    burn_kg_s: f64,
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
    procedure: Vec<String>,
}

/// A campaign of the missing tests, at the conditions of the session; none where none is missing or nothing was flown.
pub(super) fn cards(
    session: &Session,
    folder: &Path,
    snapshot: &Snapshot,
    rule: &Tolerances,
    index: &[IndexRow],
) -> Option<String> {
    let missing = |test: &&ObjectiveTest| {
        let row = index.iter().find(|row| row.id == test.id);
        row.is_some_and(|row| matches!(row.status, IndexStatus::Missing | IndexStatus::NotJudged))
    };
    let tests: Vec<&ObjectiveTest> = rule.tests.iter().filter(missing).collect();
    let conditions = conditions(session, snapshot);
    let (slow, fast) = (conditions.first()?, conditions.last()?);
    let point = |test: &&ObjectiveTest| point(test, session, snapshot, [*slow, *fast]);
    let point: Vec<Point> = tests.iter().map(point).collect();
    if point.is_empty() {
        return None;
    }
    let name = session.aircraft.as_deref()?;
    let aircraft =
        if name.starts_with(PREFIX) { name.to_owned() } else { folder.join(name).to_string_lossy().into_owned() };
    let loading = session.loading.as_ref().filter(|loading| !loading.fuel_kg.is_empty());
    let standard = snapshot.aircraft.ready().map(|loaded| &loaded.aircraft.standard_loading);
    let start_kg = loading.or(standard)?.fuel_kg.values().sum::<f64>();
    let campaign = Campaign {
        format: CAMPAIGN_FORMAT,
        version: CAMPAIGN_VERSION,
        title: format!("Tests without a record: {}", rule.name),
        aircraft,
        objectives: vec![format!("A record for every test of {} that applies to the model.", rule.name)],
        fuel: Fuel { start_kg, burn_kg_s: 0.0 },
        point,
    };
    toml::to_string(&campaign).ok()
}

/// Median airspeed and altitude of the manoeuvres, the slowest first.
fn conditions(session: &Session, snapshot: &Snapshot) -> Vec<[f64; 2]> {
    let one = |name: &String| {
        let aero = snapshot.windows.get(name)?.aero.ready()?;
        let airspeed = median(&mut aero.data.airspeed_m_s.to_vec())?;
        let altitude = aero.data.altitude_m.as_ref().and_then(|altitude| median(&mut altitude.to_vec()));
        Some([airspeed, altitude.unwrap_or(0.0)].map(f64::round))
    };
    let mut found: Vec<[f64; 2]> = session.windows.iter().filter_map(|window| one(&window.name)).collect();
    found.sort_by(|a, b| a[0].total_cmp(&b[0]));
    found
}

fn point(test: &ObjectiveTest, session: &Session, snapshot: &Snapshot, [slow, fast]: [[f64; 2]; 2]) -> Point {
    let cruise = test.condition.contains("cruise") || test.condition.contains("clean");
    let [airspeed_m_s, altitude_m] = if cruise { fast } else { slow };
    let kind = test.kinds.first().cloned().unwrap_or_else(|| "doublet".to_owned());
    let surface = test.surface.or_else(|| {
        let by_word = MOVED_BY.iter().find(|(word, _)| kind.contains(word));
        by_word.map(|(_, surface)| *surface)
    });
    let record = &test.record;
    let length_s = [record.least_s, record.before_s + record.after_s, RECORD_S].into_iter().fold(0.0, f64::max);
    Point {
        id: test.id.clone(),
        airspeed_m_s,
        altitude_m,
        configuration: test.condition.clone(),
        surface: surface.map_or("", Surface::name),
        amplitude_deg: surface.and_then(|surface| amplitude_deg(surface, session, snapshot)).unwrap_or(0.0),
        repeats: 2,
        duration_s: (length_s + AROUND_S).max(LEAST_RUN_S),
        procedure: vec![
            test.procedure.clone(),
            format!("Keep the controls as trimmed for {:.0} s before the input.", record.before_s.max(5.0)),
        ],
        kind,
    }
}

/// Median of the largest deflection of a surface in its manoeuvres, deg: what was flown before.
fn amplitude_deg(surface: Surface, session: &Session, snapshot: &Snapshot) -> Option<f64> {
    let of_window = |window: &crate::session::Manoeuvre| {
        let aero = snapshot.windows.get(&window.name)?.aero.ready()?;
        Some(movement(window, aero)?.largest_rad.abs().to_degrees())
    };
    let own = session.windows.iter().filter(|window| window.surface == Some(surface));
    let mut found: Vec<f64> = own.filter_map(of_window).collect();
    median(&mut found).map(|value| (10.0 * value).round() / 10.0)
}
