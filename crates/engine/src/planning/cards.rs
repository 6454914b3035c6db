//! A campaign as a document: cover, envelope, order of the points, a card per point.

use doublet_core::airframe::{Aircraft, FlightEnvelope, calibrated_m_s};
use doublet_core::atmos::Atmosphere;

use super::campaign::{Campaign, FlownPoint, PlannedPoint};
use super::card::{card, height, speed};
use crate::date;
use crate::notation::significant;
use crate::report::document::{
    Axis, Block, Document, Figure, LineStyle, Mark, Panel, Plot, Section, Style, UnitSystem, points,
};
use crate::report::{Cell, Column, Table, TableOf};

/// Lays a campaign out in a style: cards last, one a page.
pub fn campaign_document(
    campaign: &Campaign,
    aircraft: &Aircraft,
    (planned, flown): (&[PlannedPoint], &[FlownPoint]),
    style: &Style,
) -> Document {
    let mass_kg = planned.first().map_or(0.0, |point| point.mass_kg);
    let mut sections = vec![
        Section::plain("order", "Test points in their order", false, vec![Block::Table(order(planned))]),
        Section::plain(
            "envelope",
            "Envelope",
            true,
            vec![
                Block::Figure(envelope_figure(&aircraft.flight_envelope, mass_kg, planned, flown)),
                Block::List(limits(&aircraft.flight_envelope, style.units)),
            ],
        ),
    ];
    sections.extend(planned.iter().map(|point| card(campaign, point, style.units)));
    let fact = |(name, text): (&String, &String)| (name.clone(), text.clone());
    let mut facts = vec![("Aircraft".to_owned(), aircraft.name.clone())];
    facts.extend(campaign.facts.iter().map(fact));
    let (points, runs) = (planned.len(), planned.iter().map(|point| point.repeats).sum::<usize>());
    let end_s = planned.last().map_or(0.0, |last| last.start_s + last.repeats as f64 * last.duration_s);
    facts.push(("Test points".to_owned(), format!("{points}, {runs} runs")));
    facts.push(("Estimated duration".to_owned(), format!("{} min at the points and between", number(end_s / 60.0, 3))));
    let mut cover = vec![Block::Facts(facts), Block::Heading("Objectives".to_owned())];
    cover.push(Block::List(campaign.objectives.clone()));
    if !campaign.restrictions.is_empty() {
        cover.extend([Block::Heading("Restrictions".to_owned()), Block::List(campaign.restrictions.clone())]);
    }
    let mut document = Document {
        title: campaign.title.clone(),
        subtitle: aircraft.name.clone(),
        date: date::today(),
        notice: "Limits on these pages are from the aircraft file; the flight manual takes precedence.".to_owned(),
        cover,
        signatures: ["Captain", "Test engineer", "Experiment lead"].map(str::to_owned).into(),
        style: Style::default(),
        sections,
    };
    Style { is_compact: true, ..style.clone() }.apply(&mut document);
    document
}

fn number(value: f64, digits: usize) -> String {
    significant(value, digits)
}

fn order(planned: &[PlannedPoint]) -> Table {
    let input = |point: &PlannedPoint| {
        let surface = if point.surface.is_empty() { "all surfaces" } else { &point.surface };
        Cell::text(format!("{surface} {}", point.kind))
    };
    let runs = |point: &PlannedPoint| Cell::text(format!("{} of {}", point.windows.len(), point.repeats));
    let caption =
        "Mass and centre of gravity follow the fuel burn; flown cards are matched with the manoeuvres of the session.";
    TableOf::new("order", caption, planned)
        .text("id", "Card", |point| &point.id)
        .column(Column::new("input", "Input"), |point| input(point))
        .number("airspeed_m_s", "True airspeed", "m/s", 3, |point| point.airspeed_m_s)
        .number("altitude_m", "Altitude", "m", 4, |point| point.altitude_m)
        .number("start_min", "After", "min", 3, |point| point.start_s / 60.0)
        .number("fuel_kg", "Fuel", "kg", 3, |point| point.fuel_kg)
        .number("mass_kg", "Mass", "kg", 4, |point| point.mass_kg)
        .number("cg_x_m", "CG", "m", 4, |point| point.cg_x_m)
        .column(Column::new("runs", "Runs"), |point| runs(point))
        .text("status", "Flown", |point| point.status.name())
        .done()
}

/// What the envelope states and does not, one line each.
fn limits(envelope: &FlightEnvelope, units: UnitSystem) -> Vec<String> {
    let calibrated = |value: f64| format!("{} calibrated", speed(units, value, 3));
    let plain = |value: f64| number(value, 4);
    let stated = [
        ("stall, flaps up, power off", envelope.stall_m_s.map(calibrated)),
        ("onset of buffet over the stall", envelope.buffet_over_stall.map(|over| format!("{} times", plain(over)))),
        ("VA", envelope.manoeuvring_m_s.map(calibrated)),
        ("VFE", envelope.flaps_extended_m_s.map(calibrated)),
        ("VH", envelope.max_level_m_s.map(calibrated)),
        ("VNE", envelope.never_exceed_m_s.map(calibrated)),
        ("least load factor", envelope.load_factor_low.map(plain)),
        ("greatest load factor", envelope.load_factor_high.map(plain)),
        ("service ceiling", envelope.ceiling_m.map(|ceiling| height(units, ceiling, 4))),
        ("power of each engine", envelope.engine_power_w.map(|power| format!("{} kW", plain(power / 1000.0)))),
        (
            "engine speed",
            envelope.engine_speed_rad_s.map(|speed| format!("{} rev/min", plain(60.0 * speed / std::f64::consts::TAU))),
        ),
    ];
    stated.into_iter().map(|(name, value)| format!("{name}: {}", value.as_deref().unwrap_or("not given"))).collect()
}

/// Colours of the information that windows gave: much, as much as the others, little.
const INFORMATION: [(&str, usize); 3] =
    [("much information", 2), ("average information", 0), ("little information", 4)];

/// Altitude over airspeed and load factor over airspeed, with the points planned and flown.
pub fn envelope_figure(
    envelope: &FlightEnvelope,
    mass_kg: f64,
    planned: &[PlannedPoint],
    flown: &[FlownPoint],
) -> Figure {
    let mut altitude = Plot {
        x: Axis::new("true airspeed", "m/s"),
        y: Axis::new("altitude", "m"),
        marks: altitude_lines(envelope, mass_kg),
    };
    let mut load = Plot {
        x: Axis::new("calibrated airspeed", "m/s"),
        y: Axis::new("load factor", ""),
        marks: load_lines(envelope, mass_kg),
    };
    let mean = flown.iter().map(|point| point.share_of_information).sum::<f64>() / flown.len().max(1) as f64;
    let class = |point: &FlownPoint| match point.share_of_information / mean {
        share if share > 1.25 => 0,
        share if share < 0.75 => 2,
        _ => 1,
    };
    for (place, (label, colour)) in INFORMATION.into_iter().enumerate() {
        let own: Vec<&FlownPoint> = flown.iter().filter(|point| class(point) == place).collect();
        if own.is_empty() {
            continue;
        }
        let at = own.iter().map(|point| [point.airspeed_m_s, point.altitude_m]);
        altitude.marks.push(points(format!("flown, {label}"), colour, LineStyle::Dots, at));
        let loads = own
            .iter()
            .flat_map(|point| [point.load_factor_low, point.load_factor_high].map(|load| [point.calibrated_m_s, load]));
        load.marks.push(points("", colour, LineStyle::Dots, loads));
    }
    let at = planned.iter().map(|point| [point.airspeed_m_s, point.altitude_m]);
    altitude.marks.push(points("planned", 1, LineStyle::Dots, at));
    let at = planned.iter().map(|point| [point.calibrated_m_s, 1.0]);
    load.marks.push(points("", 1, LineStyle::Dots, at));
    Figure::new(
        "envelope",
        format!(
            "Envelope at {} kg with planned and flown points; smallest and largest load factor of each flown manoeuvre.",
            number(mass_kg, 4)
        ),
        (1, 60.0),
        vec![Panel::Plot(altitude), Panel::Plot(load)],
    )
}

/// Limits of airspeed over altitude as true airspeeds of the standard atmosphere, and the ceiling.
fn altitude_lines(envelope: &FlightEnvelope, mass_kg: f64) -> Vec<Mark> {
    /// Steps of altitude from the sea to the ceiling.
    const STEPS: usize = 40;
    let top = envelope.ceiling_m.unwrap_or(6000.0);
    let stall = envelope.stall_at(1.0, mass_kg);
    let buffet = stall.zip(envelope.buffet_over_stall).map(|(stall, over)| stall * over);
    let speeds = [
        ("stall", 5, LineStyle::Solid, stall),
        ("buffet", 5, LineStyle::Dashed, buffet),
        ("VFE", 3, LineStyle::Dashed, envelope.flaps_extended_m_s),
        ("VA", 6, LineStyle::Dashed, envelope.manoeuvring_m_s),
        ("VH", 7, LineStyle::Dashed, envelope.max_level_m_s),
        ("VNE", 7, LineStyle::Solid, envelope.never_exceed_m_s),
    ];
    let mut marks = Vec::new();
    let mut ends: Vec<f64> = Vec::new();
    for (label, colour, style, value) in speeds {
        let Some(value) = value else { continue };
        let edge: Vec<[f64; 2]> = (0..=STEPS)
            .filter_map(|step| {
                let altitude = top * step as f64 / STEPS as f64;
                let density = Atmosphere::STANDARD.density_kg_m3(altitude).ok()?;
                Some([value / calibrated_m_s(1.0, density), altitude])
            })
            .collect();
        ends.extend(edge.last().map(|point| point[0]));
        marks.push(points(label, colour, style, edge));
    }
    if let (Some(ceiling), Some(low), Some(high)) =
        (envelope.ceiling_m, ends.iter().copied().reduce(f64::min), ends.iter().copied().reduce(f64::max))
    {
        marks.push(points("ceiling", 4, LineStyle::Solid, vec![[low, ceiling], [high, ceiling]]));
    }
    marks
}

/// Load factors at which the wing stalls, and those of the structure, up to VNE.
fn load_lines(envelope: &FlightEnvelope, mass_kg: f64) -> Vec<Mark> {
    /// Steps of airspeed from rest to VNE.
    const STEPS: usize = 100;
    let Some(fastest) = envelope.never_exceed_m_s.or(envelope.max_level_m_s) else { return Vec::new() };
    let speeds = (0..=STEPS).map(|step| fastest * step as f64 / STEPS as f64);
    let mut marks = Vec::new();
    let upper: Vec<[f64; 2]> =
        speeds.clone().filter_map(|speed| Some([speed, envelope.load_factor_at(speed, mass_kg)?])).collect();
    let low = envelope.load_factor_low.unwrap_or(-1.0);
    let lower: Vec<[f64; 2]> = speeds
        .map(|speed| {
            let stalled = envelope.stall_at(1.0, mass_kg).map(|stall| -(speed / stall).powi(2));
            [speed, stalled.map_or(low, |stalled| stalled.max(low))]
        })
        .collect();
    if upper.is_empty() {
        return marks;
    }
    let close = [[fastest, upper.last().map_or(1.0, |p| p[1])], [fastest, lower.last().map_or(low, |p| p[1])]];
    marks.push(points("", 5, LineStyle::Solid, upper));
    // The lift to the other side is taken as large, which no cambered wing has: the true line lies further in.
    marks.push(points("", 5, LineStyle::Dashed, lower));
    marks.push(points("", 7, LineStyle::Solid, close));
    if let (Some(speed), Some(high)) = (envelope.manoeuvring_m_s, envelope.load_factor_high) {
        marks.push(points("", 6, LineStyle::Dashed, vec![[speed, low], [speed, high]]));
    }
    marks
}
