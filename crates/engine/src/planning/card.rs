//! The card of one test point: entry, stick picture, procedure, hazards, a row per run.

use doublet_core::simulate::{Form, InputKind};

use super::campaign::{Campaign, PlannedPoint};
use super::safety::{HazardLevel, M_S_PER_KT};
use crate::notation::significant;
use crate::report::document::{Axis, Block, Figure, LineStyle, Panel, Plot, Section, UnitSystem, points};
use crate::report::{Cell, Column, Table, TableOf};
use crate::session::Level;

/// Length of a foot, m.
pub(super) const M_PER_FT: f64 = 0.3048;

/// Surface of an input by the throttles.
pub(super) const THROTTLE: &str = "throttle";

/// The movement of the hand for each direction of a surface: surface, direction, control, opposite direction.
const HANDS: [(&str, &str, &str, &str); 10] = [
    ("aileron and rudder", "right", "stick right with right pedal", "left"),
    ("aileron and rudder", "left", "stick left with left pedal", "right"),
    ("throttle", "up", "throttles forward", "down"),
    ("throttle", "down", "throttles back", "up"),
    ("aileron", "right", "stick right", "left"),
    ("aileron", "left", "stick left", "right"),
    ("elevator", "down", "stick forward", "up"),
    ("elevator", "up", "stick back", "down"),
    ("rudder", "right", "right pedal", "left"),
    ("rudder", "left", "left pedal", "right"),
];

impl PlannedPoint {
    /// Surface of its manoeuvres in a session: the throttles are not one.
    pub(super) fn surface_of_window(&self) -> &str {
        if self.surface == THROTTLE { "" } else { &self.surface }
    }

    /// Kind of its manoeuvres in a session, that of an input by the throttles with their name.
    pub(super) fn kind_of_window(&self) -> String {
        if self.surface == THROTTLE { format!("{THROTTLE} {}", self.kind) } else { self.kind.clone() }
    }
}

/// A speed in m/s and in the unit of the instrument, or in that alone.
pub(super) fn speed(units: UnitSystem, m_s: f64, digits: usize) -> String {
    let kt = significant(m_s / M_S_PER_KT, digits);
    match units {
        UnitSystem::Si => format!("{} m/s ({kt} kt)", significant(m_s, digits)),
        UnitSystem::Aviation => format!("{kt} kt"),
    }
}

/// An altitude in m and in the unit of the instrument, or in that alone.
pub(super) fn height(units: UnitSystem, metres: f64, digits: usize) -> String {
    let ft = significant(metres / M_PER_FT, digits);
    match units {
        UnitSystem::Si => format!("{} m ({ft} ft)", significant(metres, digits)),
        UnitSystem::Aviation => format!("{ft} ft"),
    }
}

fn airspeed(point: &PlannedPoint, tolerance_m_s: f64, units: UnitSystem) -> String {
    let calibrated = format!("{} calibrated", speed(units, point.calibrated_m_s, 3));
    let flown = match units {
        UnitSystem::Si => format!("{} m/s true, {calibrated}", significant(point.airspeed_m_s, 3)),
        UnitSystem::Aviation => format!("{calibrated}, {} true", speed(units, point.airspeed_m_s, 3)),
    };
    format!("{flown}; ±{}", speed(units, tolerance_m_s, 2))
}

fn altitude(point: &PlannedPoint, tolerance_m: f64, units: UnitSystem) -> String {
    format!("{}; ±{}", height(units, point.altitude_m, 4), height(units, tolerance_m, 2))
}

/// Power setting as the instruments show it.
fn power(point: &PlannedPoint) -> String {
    if !point.power.is_empty() {
        return point.power.clone();
    }
    let speed = point.engine_speed_rpm.map(|rpm| format!("{} rev/min", significant(rpm, 4)));
    let pressure = point.manifold_pressure_inhg.map(|inhg| format!("{} inHg", significant(inhg, 3)));
    let given: Vec<String> = speed.into_iter().chain(pressure).collect();
    let held = if point.amplitude_inhg.is_some() { "before the input" } else { "not moved during the input" };
    if given.is_empty() { "not given".to_owned() } else { format!("{}; {held}", given.join(", ")) }
}

/// Limits of the wind in which a point is flown.
fn wind(campaign: &Campaign, units: UnitSystem) -> String {
    let limit = |name: &str, value: Option<f64>| value.map(|value| format!("{name} {}", speed(units, value, 2)));
    let wind = &campaign.wind;
    let stated = [
        limit("mean wind below", wind.speed_m_s),
        limit("vertical gusts below", wind.gust_m_s),
        limit("change over the altitude band below", wind.shear_m_s),
    ];
    let stated: Vec<String> = stated.into_iter().flatten().collect();
    if stated.is_empty() { "not given".to_owned() } else { stated.join(", ") }
}

fn gate(campaign: &Campaign) -> String {
    let gate = &campaign.entry;
    format!(
        "airspeed and altitude in tolerance, bank within {} deg, rates within {} deg/s for {} s before the input",
        significant(gate.bank_deg, 2),
        significant(gate.rate_deg_s, 2),
        significant(gate.steady_s, 2)
    )
}

/// One card: entry, input, procedure, hazards, a row per run to fill in, room for notes.
pub(super) fn card(campaign: &Campaign, point: &PlannedPoint, units: UnitSystem) -> Section {
    let surface = if point.surface.is_empty() { "all surfaces" } else { &point.surface };
    let mut blocks: Vec<Block> = Vec::new();
    blocks.extend(point.entry_note.iter().map(|note| Block::Outcome(Level::Caution, note.clone())));
    blocks.extend([Block::Heading("Entry".to_owned()), Block::Facts(facts(campaign, point, units))]);
    blocks.extend(stick_picture(point).map(Block::Figure));
    let procedure: Vec<String> = point.procedure.iter().chain(&campaign.procedure).cloned().collect();
    if !procedure.is_empty() {
        blocks.extend([Block::Heading("Procedure".to_owned()), Block::List(procedure)]);
    }
    if !point.knock_off.is_empty() {
        blocks.extend([Block::Heading("Knock it off".to_owned()), Block::List(point.knock_off.clone())]);
    }
    if !point.risks.is_empty() {
        blocks.push(Block::Table(risks(point)));
    }
    if !point.evaluation.is_empty() {
        blocks.push(Block::Table(evaluation(point)));
    }
    blocks.extend([Block::Heading("Runs".to_owned()), Block::Table(runs(point, surface))]);
    blocks.extend([Block::Heading("Crew notes".to_owned()), Block::Lines(2)]);
    let title = format!("Card {}: {} {}", point.id, surface, point.kind);
    Section::plain(&format!("card-{}", point.id), &title, true, blocks)
}

fn facts(campaign: &Campaign, point: &PlannedPoint, units: UnitSystem) -> Vec<(String, String)> {
    let given = |text: &String| if text.is_empty() { "not given".to_owned() } else { text.clone() };
    let margin = point.cg_margin_m.map_or_else(String::new, |own| format!(", {} m inside", significant(own, 2)));
    let stall = |stall: f64| {
        let ratio = significant(point.calibrated_m_s / stall, 3);
        format!("{} calibrated; entry is {ratio} times that", speed(units, stall, 3))
    };
    let stall = point.stall_m_s.map_or_else(|| "not given".to_owned(), stall);
    let room = |least: f64| speed(units, point.calibrated_m_s - least, 2);
    let knock_off = point.least_airspeed_m_s.map_or_else(|| "not given".to_owned(), room);
    let load = point.bank_deg.map(|bank| format!("{} deg of bank, ", significant(bank, 3))).unwrap_or_default();
    let load = format!("{load}load factor {}", significant(point.load_factor, 3));
    let flown = match point.status {
        status if point.windows.is_empty() => status.name().to_owned(),
        status => format!("{}: {}", status.name(), point.windows.join(", ")),
    };
    let unit = point.step_s.map_or_else(|| "not given".to_owned(), |step| format!("{} s", significant(step, 3)));
    let minutes = point.repeats as f64 * point.duration_s / 60.0;
    let place = format!("after {} min, {} min", significant(point.start_s / 60.0, 3), significant(minutes, 3));
    let mass = format!(
        "{} kg with {} kg of fuel; {} m behind the datum{margin}",
        significant(point.mass_kg, 4),
        significant(point.fuel_kg, 3),
        significant(point.cg_x_m, 4)
    );
    [
        ("Airspeed", airspeed(point, campaign.entry.airspeed_m_s, units)),
        ("Altitude", altitude(point, campaign.entry.altitude_m, units)),
        ("Configuration", given(&point.configuration)),
        ("Power", power(point)),
        ("Steady before the input", gate(campaign)),
        ("Wind box", wind(campaign, units)),
        ("Mass and centre of gravity", mass),
        ("Greatest bank and load factor", load),
        ("Stall at this mass and load factor", stall),
        ("Above the knock-off airspeed", knock_off),
        ("Time unit dt", unit),
        ("Hazard", given(&point.hazard)),
        ("In the flight", place),
        ("Flown", flown),
    ]
    .map(|(name, text)| (name.to_owned(), text))
    .into()
}

/// Size of the input: a deflection, or a change of the manifold pressure.
fn size(point: &PlannedPoint) -> String {
    match point.amplitude_inhg {
        Some(inhg) => format!("{} inHg", significant(inhg.abs(), 2)),
        None if point.amplitude_deg == 0.0 => "as the procedure".to_owned(),
        None => format!("{} deg", significant(point.amplitude_deg.abs(), 2)),
    }
}

/// Directions of the runs one after the other, each as its first word.
pub(super) fn directions(point: &PlannedPoint) -> Vec<&str> {
    let words = point.direction.split(',').map(|text| {
        let text = text.trim();
        let end = text.find(|letter: char| !letter.is_alphabetic()).unwrap_or(text.len());
        &text[..end]
    });
    words.filter(|word| !word.is_empty()).collect()
}

/// The hand movement of a direction of a surface and the opposite direction.
fn hand(surface: &str, direction: &str) -> Option<(&'static str, &'static str)> {
    let found = HANDS.iter().find(|(own, word, ..)| *own == surface && *word == direction);
    found.map(|(_, _, hand, opposite)| (*hand, *opposite))
}

/// Pulses of an input: duration, s, and sign.
pub(super) fn pulses(point: &PlannedPoint) -> Option<Vec<(f64, f64)>> {
    let (step_s, kind) = (point.step_s?, InputKind::from_name(&point.kind)?);
    let Form::Pulses(form) = kind.form() else { return None };
    Some(form.iter().map(|(length, level)| (length * step_s, *level)).collect())
}

/// The input of the first run over time, its directions named as the hand moves.
fn stick_picture(point: &PlannedPoint) -> Option<Figure> {
    let pulses = pulses(point)?;
    let first = directions(point).first().copied()?;
    let (forward, opposite) = hand(&point.surface, first)?;
    let (back, _) = hand(&point.surface, opposite)?;
    let amplitude = point.amplitude_inhg.unwrap_or(point.amplitude_deg).abs();
    let lead_s = pulses.iter().map(|pulse| pulse.0).sum::<f64>() / 4.0;
    let mut time_s = lead_s;
    let mut nodes = vec![[0.0, 0.0], [time_s, 0.0]];
    for (duration_s, level) in &pulses {
        nodes.push([time_s, level * amplitude]);
        time_s += duration_s;
        nodes.push([time_s, level * amplitude]);
    }
    nodes.extend([[time_s, 0.0], [time_s + lead_s, 0.0]]);
    let sequence: Vec<String> = pulses
        .iter()
        .map(|(duration_s, level)| {
            let hand = if *level > 0.0 { forward } else { back };
            format!("{hand} {} s", significant(*duration_s, 3))
        })
        .collect();
    let size = size(point);
    let places = vec![
        (amplitude, format!("{forward} {size}")),
        (0.0, "trim".to_owned()),
        (-amplitude, format!("{back} {size}")),
    ];
    let mirrored = if directions(point).iter().any(|other| *other != first) {
        " The other direction is the mirror image."
    } else {
        ""
    };
    Some(Figure::new(
        format!("stick-{}", point.id),
        format!("Stick picture, {first} first: {}; then release.{mirrored}", sequence.join(", ")),
        (1, 26.0),
        vec![Panel::Plot(Plot {
            x: Axis::time(),
            y: Axis { label: point.surface.clone(), places, ..Axis::default() },
            marks: vec![points("", 0, LineStyle::Solid, nodes)],
        })],
    ))
}

/// Slopes of the manoeuvres flown, beside those of the identified derivatives.
fn evaluation(point: &PlannedPoint) -> Table {
    let caption = "Least squares of the manoeuvres flown, beside the identified derivatives; errors corrected for correlated residuals.";
    TableOf::new(&format!("evaluation-{}", point.id), caption, &point.evaluation)
        .text("name", "Slope", |row| row.name)
        .number("value", "Flown", "", 4, |row| row.value)
        .number("standard_error", "Std error", "", 2, |row| row.standard_error)
        .maybe("model", "Model", "", 4, |row| row.model)
        .count("samples", "Samples", |row| row.samples)
        .done()
}

/// Hazards with what is done about each.
fn risks(point: &PlannedPoint) -> Table {
    TableOf::new(&format!("hazards-{}", point.id), "Hazards and mitigations.", &point.risks)
        .text("hazard", "Hazard", |risk| &risk.hazard)
        .optional("level", "Level", |risk| risk.level.map(HazardLevel::name))
        .text("mitigation", "Mitigation", |risk| &risk.mitigation)
        .done()
}

/// A row per run: what is to be given, and what the crew writes down.
fn runs(point: &PlannedPoint, surface: &str) -> Table {
    let columns = [
        ("run", "Run"),
        ("surface", "Surface"),
        ("direction", "Direction"),
        ("amplitude", "Amplitude"),
        ("time", "Time stamp"),
        ("fuel", "Fuel"),
        ("altitude", "Altitude"),
        ("remark", "Remark"),
    ];
    let amplitude = size(point);
    let blank = || Cell::text("\u{a0}".repeat(22));
    let directions = directions(point);
    let direction = |run: usize| match directions.get((run - 1) % directions.len().max(1)) {
        Some(word) => hand(&point.surface, word).map_or((*word).to_owned(), |(hand, _)| format!("{hand} first")),
        None => String::new(),
    };
    let row = |run: usize| {
        vec![
            Cell::text(format!("{}.{run}", point.id)),
            Cell::text(surface),
            Cell::text(direction(run)),
            Cell::text(amplitude.clone()),
            blank(),
            blank(),
            blank(),
            blank(),
        ]
    };
    Table {
        name: format!("runs-{}", point.id),
        caption: "For the crew to fill in.".to_owned(),
        columns: columns.map(|(key, heading)| Column::new(key, heading)).into(),
        rows: (1..=point.repeats).map(row).collect(),
    }
}
