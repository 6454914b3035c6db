//! Findings about how a window is flown: on its wheels, too slow for its wing, across a turn.

use doublet_core::quantity::Role;
use doublet_core::reconstruct::State;
use doublet_core::series::{Recording, Series, TimeRange};
use doublet_core::{message, statistics};

use super::judge::{Evidence, level_above};
use super::{Finding, Level};
use crate::session::{Edit, Fix, Manoeuvre, Place, Session, WindowEdit};
use crate::snapshot::Snapshot;
use crate::stage::{LEAST_PRESSURE_SHARE, WindowAero, WindowPath};

/// Part of the samples with weight on the wheels.
const WHEELS_CAUTION: f64 = 0.0;
const WHEELS_BAD: f64 = 0.1;
/// Dynamic pressure over the median of the session's windows.
const PRESSURE_CAUTION: f64 = 0.5;
const PRESSURE_BAD: f64 = 0.1;
/// Lift coefficient beyond which no wing carries the aircraft: it is on the ground, or its airspeed, mass or area is wrong.
const LARGEST_LIFT: f64 = 3.5;
/// Airspeed over the stall's at the same load factor.
const STALL_CAUTION: f64 = 1.1;
const STALL_BAD: f64 = 0.9;
/// Part of a manoeuvre up to which samples on the wheels are excluded; the manoeuvre is ignored beyond.
const MOST_EXCLUDED: f64 = 0.5;
/// Change of the heading within a window, deg.
const TURN_DEG: f64 = 45.0;
/// Shortest part of a manoeuvre beside a turn that is proposed instead of it, s.
const LEAST_STRAIGHT_S: f64 = 4.0;

const CURE: &str = "Ignore the manoeuvre, or check airspeed: unit, zero, weight on wheels.";

/// Weight on the wheels; an airspeed at which the wing does not carry the aircraft, or that is far below that of the other windows or
/// of the flight. The first that holds.
pub(super) fn dynamic_pressure(
    place: &Place,
    evidence: Evidence<'_>,
    manoeuvre: &Manoeuvre,
    aero: &WindowAero,
) -> Option<Finding> {
    let flight = evidence.snapshot.flights.get(&manoeuvre.flight).and_then(|slot| slot.ready());
    let physics = evidence.snapshot.physics.get(&manoeuvre.flight).and_then(|slot| slot.ready());
    let found = flight
        .and_then(|flight| on_wheels(place, &flight.recording, manoeuvre))
        .or_else(|| too_slow_to_fly(place, evidence, aero))
        .or_else(|| below_other_windows(place, evidence, aero))
        .or_else(|| below_flight(place, physics?.airspeed_m_s?, aero));
    found.map(|finding| {
        let fix = finding.fix.clone().unwrap_or_else(|| Fix::ignore([manoeuvre.name.as_str()]));
        finding.with_fix_text(CURE).with_setting("Flight", "manoeuvre.role").with_fix(fix)
    })
}

fn on_wheels(place: &Place, recording: &Recording, manoeuvre: &Manoeuvre) -> Option<Finding> {
    let weight = &recording.role(Role::WeightOnWheels)?.series;
    let is_counted = |index: &usize| manoeuvre.excluded_at(weight.time_s[*index]).is_none();
    let counted: Vec<usize> = manoeuvre.window.indices(&weight.time_s).filter(is_counted).collect();
    let on_wheels: Vec<usize> = counted.iter().copied().filter(|index| weight.values[*index] > 0.5).collect();
    let part = on_wheels.len() as f64 / counted.len().max(1) as f64;
    let (level, limit) = level_above(part, WHEELS_CAUTION, WHEELS_BAD)?;
    let text =
        message!("Weight is on the wheels in {:.0} % of the samples (limit {:.0} %).", 100.0 * part, 100.0 * limit);
    let finding = Finding::new(level, "dynamic-pressure", place, text).with_figure(part, limit);
    Some(finding.with_fix((part < MOST_EXCLUDED).then(|| exclude(weight, &on_wheels, manoeuvre))))
}

/// Excludes samples of a manoeuvre, each up to the next sample.
fn exclude(series: &Series, samples: &[usize], manoeuvre: &Manoeuvre) -> Fix {
    let mut all = manoeuvre.clone();
    for run in samples.chunk_by(|a, b| a + 1 == *b) {
        let (first, last) = (run[0], run[run.len() - 1]);
        let end_s = series.time_s.get(last + 1).copied().unwrap_or(f64::INFINITY);
        let part = TimeRange { start_s: series.time_s[first], end_s };
        all.excluded = all.excluded_with(part).unwrap_or(all.excluded);
    }
    let Manoeuvre { name, excluded, .. } = all;
    let label = format!("exclude the samples of '{name}' with weight on the wheels");
    Fix::new(label, Edit::Window(WindowEdit::Exclude { name, excluded }))
}

/// By the stall of the aircraft where its file states one: `V / V_s = (CL_max / CN)^(1/2)` at the same load factor.
fn too_slow_to_fly(place: &Place, evidence: Evidence<'_>, aero: &WindowAero) -> Option<Finding> {
    let (pressure, airspeed) = (mean_pressure(aero), mean(&aero.data.airspeed_m_s));
    let weight = mean(&aero.data.specific_force_m_s2[2]).abs() * aero.data.mass.first()?.mass_kg;
    let area_m2 = aero.settings.reference.area_m2;
    let lift = weight / (pressure * area_m2);
    let stall = evidence.snapshot.aircraft.ready().and_then(|loaded| loaded.aircraft.stall);
    let Some(stall) = stall else {
        if lift <= LARGEST_LIFT {
            return None;
        }
        let text = message!(
            "Dynamic pressure {:.1} Pa (airspeed {:.1} m/s) needs a normal-force coefficient of {:.1} \
             (limit {}).",
            pressure,
            airspeed,
            lift,
            LARGEST_LIFT
        );
        return Some(Finding::new(Level::Bad, "dynamic-pressure", place, text).with_figure(lift, LARGEST_LIFT));
    };
    let part = (stall.max_lift_coefficient(area_m2) / lift).sqrt();
    let (level, limit) = match part {
        part if part >= STALL_CAUTION => return None,
        part if part >= STALL_BAD => (Level::Caution, STALL_CAUTION),
        _ => (Level::Bad, STALL_BAD),
    };
    let text = message!(
        "Airspeed {:.1} m/s (dynamic pressure {:.0} Pa) is {:.2} times the stall speed (limit {}).",
        airspeed,
        pressure,
        part,
        limit
    );
    Some(Finding::new(level, "dynamic-pressure", place, text).with_figure(part, limit))
}

fn below_other_windows(place: &Place, evidence: Evidence<'_>, aero: &WindowAero) -> Option<Finding> {
    let (pressure, airspeed) = (mean_pressure(aero), mean(&aero.data.airspeed_m_s));
    let median = evidence.median_pressure_pa?;
    let part = pressure / median;
    let (level, limit) = level_below(part, PRESSURE_CAUTION)?;
    let text = message!(
        "Dynamic pressure {:.0} Pa (airspeed {:.1} m/s) is {:.2} times the manoeuvres' median {:.0} Pa \
         (limit {}).",
        pressure,
        airspeed,
        part,
        median,
        limit
    );
    Some(Finding::new(level, "dynamic-pressure", place, text).with_figure(part, limit))
}

/// Against the median airspeed of the whole flight: all windows may be on the ground.
fn below_flight(place: &Place, median_m_s: f64, aero: &WindowAero) -> Option<Finding> {
    let airspeed = mean(&aero.data.airspeed_m_s);
    let part = (airspeed / median_m_s).powi(2);
    let (level, limit) = level_below(part, LEAST_PRESSURE_SHARE)?;
    let text = message!(
        "Dynamic pressure is {:.2} times that of the flight: airspeed {:.1} m/s, median {:.1} m/s \
         (limit {}).",
        part,
        airspeed,
        median_m_s,
        limit
    );
    Some(Finding::new(level, "dynamic-pressure", place, text).with_figure(part, limit))
}

/// Level of a dynamic pressure that is this part of what it is compared with.
fn level_below(part: f64, caution: f64) -> Option<(Level, f64)> {
    match part {
        part if part < PRESSURE_BAD => Some((Level::Bad, PRESSURE_BAD)),
        part if part < caution => Some((Level::Caution, caution)),
        _ => None,
    }
}

/// Whether the heading changes as in a turn: the coefficients are then not those of small motion about straight flight.
pub(super) fn turn(place: &Place, manoeuvre: &Manoeuvre, path: &WindowPath) -> Option<Finding> {
    let run = &path.reconstruction;
    let states = run.smoothed.as_ref().map_or(&run.states, |smoothed| &smoothed.states);
    let heading = &states[State::HeadingAngle as usize];
    let (samples, turned) = turned_deg(heading.iter().copied(), f64::INFINITY);
    if turned <= TURN_DEG {
        return None;
    }
    let (before, _) = turned_deg(heading.iter().copied(), TURN_DEG);
    let (after, _) = turned_deg(heading.iter().rev().copied(), TURN_DEG);
    let text =
        message!("The manoeuvre includes a turn: heading changes by {:.0} deg (limit {:.0} deg).", turned, TURN_DEG);
    let finding = Finding::new(Level::Caution, "turn", place, text).with_figure(turned, TURN_DEG);
    let fix_text = "End the manoeuvre before the turn, or start it after.";
    let finding = finding.with_fix_text(fix_text).with_setting("Manoeuvres", "manoeuvre.end_s");
    let at = |sample: usize| run.time_s.get(sample).copied();
    let beside = [
        at(before.saturating_sub(1)).map(|end_s| TimeRange { end_s, ..manoeuvre.window }),
        at(samples - after).map(|start_s| TimeRange { start_s, ..manoeuvre.window }),
    ];
    Some(finding.with_fix(beside_turn(manoeuvre, beside)))
}

/// The samples from the first on over which the heading, rad, stays within `limit_deg`, and the range that it has over them, deg.
fn turned_deg(mut heading: impl Iterator<Item = f64>, limit_deg: f64) -> (usize, f64) {
    let Some(mut last) = heading.next() else { return (0, 0.0) };
    let (mut samples, mut change, mut low, mut high) = (1, 0.0_f64, 0.0_f64, 0.0_f64);
    for angle in heading {
        change += (angle - last).sin().atan2((angle - last).cos());
        let range = [low.min(change), high.max(change)];
        if (range[1] - range[0]).to_degrees() > limit_deg {
            break;
        }
        ([low, high], last) = (range, angle);
        samples += 1;
    }
    (samples, (high - low).to_degrees())
}

/// Shortens a manoeuvre to the longer of the parts beside its turn; none where both are too short for a response.
fn beside_turn(manoeuvre: &Manoeuvre, parts: [Option<TimeRange>; 2]) -> Option<Fix> {
    let length_s = |part: &TimeRange| part.end_s - part.start_s;
    let longest = parts.into_iter().flatten().max_by(|a, b| length_s(a).total_cmp(&length_s(b)))?;
    let (TimeRange { start_s, end_s }, name) = (longest, manoeuvre.name.clone());
    let label = format!("shorten '{name}' to {start_s:.2} to {end_s:.2} s, beside the turn");
    let edit = Edit::Window(WindowEdit::Place { name, window: longest });
    (length_s(&longest) >= LEAST_STRAIGHT_S).then(|| Fix::new(label, edit))
}

/// Mean dynamic pressure `rho V^2 / 2` of a window, Pa.
pub(super) fn mean_pressure(aero: &WindowAero) -> f64 {
    let samples = aero.data.density_kg_m3.iter().zip(aero.data.airspeed_m_s.iter());
    samples.map(|(density, speed)| 0.5 * density * speed * speed).sum::<f64>() / aero.data.time_s.len() as f64
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Median of the mean dynamic pressures of the windows not ignored, Pa.
pub(super) fn median_pressure(session: &Session, snapshot: &Snapshot) -> Option<f64> {
    let pressure = |window: &Manoeuvre| Some(mean_pressure(snapshot.windows.get(&window.name)?.aero.ready()?));
    let mut pressures: Vec<f64> = session.active_windows().filter_map(pressure).collect();
    statistics::median(&mut pressures)
}
