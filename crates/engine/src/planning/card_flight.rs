//! The cards of a campaign as a flight of the simulator: a scenario, and the session of its recordings.

use std::fmt::Write;

use doublet_core::airframe::Aircraft;
use doublet_core::simulate::scenario::{self, FILE_FORMAT, FILE_VERSION};

use super::campaign::PlannedPoint;
use super::card::{THROTTLE, directions, pulses};
use super::designed_session::{FLIGHT_FOLDER, designed_session, loading_of_mass};
use super::evaluation::{Steady, straight_deflections};
use super::files::{aircraft_name, loading_text};
use crate::graph::StageResult;
use crate::session::{self, Manoeuvre, Session, Surface, WindowRole};
use crate::snapshot::Snapshot;

/// Pressure of an inch of mercury, Pa.
const IN_HG_PA: f64 = 3386.389;
/// Steady flight ahead of an input, s.
const LEAD_S: f64 = 3.0;
/// Time between two runs, s: airspeed and power are steady again.
const REST_S: f64 = 60.0;
/// Time in which a hand moves a control from one level to the next, s.
const RAMP_S: f64 = 0.1;

/// Files of the flight of a campaign, and the cards that the simulator cannot fly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CampaignFlight {
    /// `campaign_scenario.toml` and `campaign_session.toml`; empty where no card can be flown.
    pub files: Vec<(String, Vec<u8>)>,
    /// Numbers of the cards left out.
    pub left_out: Vec<String>,
}

/// One run of a card.
struct Run {
    card: String,
    duration_s: f64,
    time_s: Vec<f64>,
    /// Keys of the scenario with their values at the nodes.
    columns: Vec<(&'static str, Vec<f64>)>,
    is_level: bool,
}

/// The cards one after the other as a scenario, and the session of its recordings in `flight` beside it, whose manoeuvres have surface and
/// kind of the cards: for aircraft that the simulator knows. Inputs of pulses are for identification, all else for validation.
pub fn campaign_flight(
    points: &[PlannedPoint],
    aircraft: &Aircraft,
    session: &Session,
    snapshot: &Snapshot,
) -> StageResult<CampaignFlight> {
    let mut flight = CampaignFlight::default();
    if !scenario::aircraft().contains(&aircraft_name(session)) {
        return Ok(flight);
    }
    let mut flown: Vec<(&PlannedPoint, Run)> = Vec::new();
    for point in points {
        let runs: Option<Vec<Run>> = (0..point.repeats).map(|number| run(point, number, snapshot)).collect();
        match runs {
            Some(runs) => flown.extend(runs.into_iter().map(|run| (point, run))),
            None => flight.left_out.push(point.id.clone()),
        }
    }
    let Some((first, _)) = flown.first() else { return Ok(flight) };
    let loading = loading_of_mass(aircraft, session.loading.as_ref(), first.mass_kg)?;
    let mut text = format!(
        "format = \"{FILE_FORMAT}\"\nversion = {FILE_VERSION}\naircraft = {:?}\nairspeed_m_s = {:?}\naltitude_m = {:?}\nrest_s = {REST_S:?}\n{}",
        aircraft_name(session),
        first.airspeed_m_s,
        first.altitude_m,
        loading_text(&loading)
    );
    for (point, run) in &flown {
        text += &run.manoeuvre(point);
    }
    let parsed = scenario::parse(&text).map_err(|error| error.to_string())?;
    let mut own = designed_session(session, &parsed, FLIGHT_FOLDER)?;
    own.title = format!("{}: cards flown", session.title);
    own.windows.iter_mut().zip(&flown).for_each(|(window, (point, _))| name_window(window, point));
    let own = session::print(&own).map_err(|error| error.to_string())?;
    let files = [("campaign_scenario.toml", text), ("campaign_session.toml", own)];
    flight.files = files.map(|(name, text)| (name.to_owned(), text.into_bytes())).into();
    Ok(flight)
}

/// Surface, kind and use of a manoeuvre by its card.
fn name_window(window: &mut Manoeuvre, point: &PlannedPoint) {
    let mut surfaces = point.surface.split(" and ").filter_map(|word| {
        [Surface::Aileron, Surface::Elevator, Surface::Rudder].into_iter().find(|surface| surface.name() == word)
    });
    (window.surface, window.also) = (surfaces.next(), surfaces.next());
    window.kind = point.kind_of_window();
    let identifies = window.surface.is_some() && Steady::of_kind(&point.kind).is_none();
    window.role = if identifies { WindowRole::Identification } else { WindowRole::Validation };
}

/// A run of a card; none of a kind that the simulator does not fly.
fn run(point: &PlannedPoint, number: usize, snapshot: &Snapshot) -> Option<Run> {
    let directions = directions(point);
    let direction = directions.get(number % directions.len().max(1)).copied().unwrap_or_default();
    let amplitude_rad = point.amplitude_deg.abs().to_radians();
    let card = format!("{} {}", point.id, point.kind_of_window());
    let run = |duration_s, (time_s, values): (Vec<f64>, Vec<f64>), key, is_level| Run {
        card: card.clone(),
        duration_s,
        time_s,
        columns: vec![(key, values)],
        is_level,
    };
    match Steady::of_kind(&point.kind) {
        Some(Steady::Sideslip) => {
            let [rudder, _] = straight_deflections(snapshot)?;
            let sideslip = sign("rudder", direction)? * amplitude_rad / rudder;
            Some(run(45.0, in_two_steps(0.5 * sideslip, sideslip, 45.0), "sideslip_rad", false))
        }
        Some(Steady::Turn) => {
            let bank = point.bank_deg?.to_radians() * if direction == "left" { -1.0 } else { 1.0 };
            Some(run(60.0, in_two_steps(0.75 * bank, bank, 60.0), "bank_rad", false))
        }
        Some(Steady::Acceleration) => {
            let added = point.amplitude_inhg?.abs() * IN_HG_PA * if direction == "down" { -1.0 } else { 1.0 };
            /// Time after the power is back, s: the airspeed then returns to that of the entry, and must not pass it.
            const BACK_S: f64 = 45.0;
            let half_s = 0.5 * point.duration_s;
            let nodes = (vec![LEAD_S, LEAD_S + 1.0, half_s, half_s + 1.0], vec![0.0, added, added, 0.0]);
            Some(run(half_s + BACK_S, nodes, "manifold_pa", true))
        }
        None => {
            /// Free response behind an input by the throttles, and by a surface, s.
            const FREE_S: (f64, f64) = (15.0, 8.0);
            let (time_s, levels) = ramps(&pulses(point)?);
            let end_s = time_s.last().copied().unwrap_or(0.0);
            let sized = |amplitude: f64| levels.iter().map(|level| amplitude * level).collect::<Vec<f64>>();
            if point.surface == THROTTLE {
                let values = sized(sign(THROTTLE, direction)? * point.amplitude_inhg?.abs() * IN_HG_PA);
                return Some(run(end_s + FREE_S.0, (time_s, values), "manifold_pa", false));
            }
            let key = |word: &str| match word {
                "aileron" => Some("aileron_rad"),
                "elevator" => Some("elevator_rad"),
                "rudder" => Some("rudder_rad"),
                _ => None,
            };
            let column = |word: &str| Some((key(word)?, sized(sign(word, direction)? * amplitude_rad)));
            let columns = point.surface.split(" and ").map(column).collect::<Option<Vec<_>>>()?;
            Some(Run { card: card.clone(), duration_s: end_s + FREE_S.1, time_s, columns, is_level: false })
        }
    }
}

/// Sign of a control's deflection, or of the manifold pressure, for a direction of the hand (docs/conventions.md).
fn sign(control: &str, direction: &str) -> Option<f64> {
    match (control, direction) {
        ("elevator", "down") | ("aileron" | "rudder", "left") | (THROTTLE, "up") => Some(1.0),
        ("elevator", "up") | ("aileron" | "rudder", "right") | (THROTTLE, "down") => Some(-1.0),
        _ => None,
    }
}

/// Nodes of an angle that is brought about in two steps, each held, and taken away.
fn in_two_steps(first: f64, second: f64, duration_s: f64) -> (Vec<f64>, Vec<f64>) {
    /// Time to change from one step to the next, s.
    const CHANGE_S: f64 = 5.0;
    let held_s = (duration_s - LEAD_S - 3.0 * CHANGE_S - 2.0 * LEAD_S) / 2.0;
    let mut time_s = vec![LEAD_S];
    for wait_s in [CHANGE_S, held_s, CHANGE_S, held_s, CHANGE_S] {
        time_s.push(time_s.last().copied().unwrap_or(0.0) + wait_s);
    }
    (time_s, vec![0.0, first, first, second, second, 0.0])
}

/// Nodes of pulses of unit size, joined by ramps.
fn ramps(pulses: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>) {
    let (mut time_s, mut values) = (vec![LEAD_S], vec![0.0]);
    let mut from_s = LEAD_S;
    for (duration_s, level) in pulses {
        time_s.extend([from_s + RAMP_S, from_s + duration_s.max(RAMP_S)]);
        values.extend([*level, *level]);
        from_s += duration_s.max(RAMP_S);
    }
    time_s.push(from_s + RAMP_S);
    values.push(0.0);
    (time_s, values)
}

impl Run {
    /// The run as a manoeuvre of a scenario file.
    fn manoeuvre(&self, point: &PlannedPoint) -> String {
        let mut text = format!("\n[[manoeuvre]]\nname = {:?}\nduration_s = {:?}\n", self.card, self.duration_s);
        let _ = writeln!(text, "airspeed_m_s = {:?}\naltitude_m = {:?}", point.airspeed_m_s, point.altitude_m);
        let _ = writeln!(text, "time_s = {:?}", self.time_s);
        for (key, values) in &self.columns {
            let _ = writeln!(text, "{key} = {values:?}");
        }
        if self.is_level {
            text += "level = true\n";
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_become_ramps_and_angles_are_held_twice() {
        let (time_s, values) = ramps(&[(1.0, 1.0), (1.0, -1.0)]);
        assert_eq!(time_s, [3.0, 3.1, 4.0, 4.1, 5.0, 5.1]);
        assert_eq!(values, [0.0, 1.0, 1.0, -1.0, -1.0, 0.0]);
        let (time_s, values) = in_two_steps(0.05, 0.1, 45.0);
        assert_eq!(time_s, [3.0, 8.0, 18.5, 23.5, 34.0, 39.0]);
        assert_eq!(values, [0.0, 0.05, 0.05, 0.1, 0.1, 0.0]);
    }

    #[test]
    fn hands_move_the_controls_as_the_conventions_state() {
        // Right pedal: trailing edge right, negative. Stick right: right aileron up, negative. Stick forward: trailing edge down, positive.
        assert_eq!(
            [sign("rudder", "right"), sign("aileron", "right"), sign("elevator", "down")],
            [Some(-1.0), Some(-1.0), Some(1.0)]
        );
        assert_eq!([sign(THROTTLE, "up"), sign("elevator", "right")], [Some(1.0), None]);
    }
}
