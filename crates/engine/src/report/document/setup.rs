//! Sections on what was analysed and with what.

use doublet_core::quantity::{Dimension, Role};
use doublet_core::series::TimeRange;

use super::conditions::altitude_kind;
use super::figure::line;
use super::{Axis, Block, Colour, Contents, Figure, LineStyle, Mark, Panel, Parts, Plot, mass, paragraph};
use crate::notation::{self, significant};
use crate::report::table::{Cell, Table, TableOf};
use crate::report::{MapRow, WindowRow, applied_delays, tables};
use crate::session::{Manoeuvre, Session, WindowRole};
use crate::stage::CONDITION_NOTE;

/// The session and the units of the report.
pub fn overview(contents: &Contents<'_>) -> Parts {
    let (session, results) = (contents.session, contents.results);
    let facts = [
        ("Flights", session.flights.iter().map(|flight| flight.name.as_str()).collect::<Vec<_>>().join(", ")),
        ("Gravity", format!("{} m/s², {}", significant(results.gravity_m_s2, 6), results.gravity_origin)),
    ];
    let delays = applied_delays(&results.sensor_delays).map(|words| ("Delays applied", words));
    let gusts = results.gusts.as_ref().map(|gusts| ("Gusts", gusts.summary()));
    let body = vec![
        Block::Facts(
            facts.into_iter().chain(delays).chain(gusts).map(|(name, text)| (name.to_owned(), text)).collect(),
        ),
        paragraph(
            "Tables and figures use degrees and degrees per second. Everything else, including the stored channels, is in SI units. Derivatives are per radian and per unit of the dimensionless rate. Body axes are x forward, y right, z down.",
        ),
    ];
    let provenance = [tables::recordings(results), tables::files(results)];
    let provenance = provenance.into_iter().filter(|table| !table.rows.is_empty());
    Parts { body, appendix: provenance.map(Block::Table).collect() }
}

/// Reference geometry, what is on board, mass properties.
pub fn aircraft(contents: &Contents<'_>) -> Parts {
    let results = contents.results;
    let mut blocks = Vec::new();
    let length = |value: f64| format!("{} m", significant(value, 5));
    let place = |[x, y, z]: [f64; 3]| [x, y, z].map(|value| significant(value, 4)).join(", ") + " m";
    if let Some(reference) = &results.reference {
        let moment = reference.moment_reference_from_datum_m.map_or_else(|| "the centre of gravity".to_owned(), place);
        let reference = &reference.geometry;
        blocks.push(Block::Heading("Reference geometry".to_owned()));
        blocks.push(Block::Facts(vec![
            ("Wing area".to_owned(), format!("{} m²", significant(reference.area_m2, 5))),
            ("Span".to_owned(), length(reference.span_m)),
            ("Mean aerodynamic chord".to_owned(), length(reference.chord_m)),
            ("Length of Cl and Cn".to_owned(), length(reference.lateral_moment_length_m)),
            ("Length of roll and yaw rate".to_owned(), length(reference.lateral_rate_length_m)),
            ("Length of pitch rate".to_owned(), length(reference.pitch_rate_length_m)),
            ("Moment reference (datum axes: x aft, y right, z up)".to_owned(), moment),
        ]));
    }
    blocks.extend(mass::empty_aircraft(contents).into_iter().flatten());
    let mass = mass::flown(contents);
    blocks.extend(mass.body);
    Parts { body: blocks, appendix: mass.appendix }
}

/// Flight condition of every manoeuvre, and the manoeuvres on each flight.
pub fn windows(contents: &Contents<'_>) -> Parts {
    let times = tables::windows(contents.results).select(&[
        "window", "flight", "start_s", "end_s", "role", "surface", "kind", "samples", "excluded_s", "note", "error",
    ]);
    if times.rows.is_empty() {
        return Parts::default();
    }
    let mut blocks = vec![Block::Table(manoeuvre_table(contents))];
    blocks.extend(not_used(contents.session));
    for flight in &contents.session.flights {
        let Some(loaded) = contents.snapshot.flights.get(&flight.name).and_then(|slot| slot.ready()) else { continue };
        let spans: Vec<Mark> = contents
            .session
            .windows
            .iter()
            .filter(|window| window.flight == flight.name)
            .filter_map(|window| {
                let (label, colour) = match window.role {
                    WindowRole::Identification => ("identification", 0),
                    WindowRole::Validation => ("validation", 1),
                    WindowRole::Ignored => return None,
                };
                Some(Mark::Span {
                    label: label.into(),
                    colour: Colour::by_index(colour),
                    ends: [window.window.start_s, window.window.end_s],
                })
            })
            .collect();
        let panel = |(role, name): (Role, &'static str)| {
            let (unit, scale) = notation::role_unit(role);
            let channel = loaded.recording.role(role)?;
            let mut marks = spans.clone();
            marks.push(line("recorded", 7, &channel.series, scale));
            let plot = Plot { x: Axis::time(), y: Axis::new(notation::role(role), unit), marks };
            Some((name, Panel::Plot(plot)))
        };
        let recorded = [(Role::Altitude, "Altitude"), (Role::TrueAirspeed, "Airspeed")].into_iter().filter_map(panel);
        let (names, panels): (Vec<&str>, Vec<Panel>) = recorded.unzip();
        if !panels.is_empty() {
            let figure = Figure::new(
                format!("flight {}", flight.name),
                match names[..] {
                    [one] => format!("{one} of flight '{}', with its manoeuvres.", flight.name),
                    _ => format!("Altitude and airspeed of flight '{}', with its manoeuvres.", flight.name),
                },
                (1, 32.0),
                panels,
            );
            let of_flight = contents.session.active_windows().filter(|window| window.flight == flight.name);
            let excluded: Vec<TimeRange> = of_flight.flat_map(|window| window.excluded.iter().copied()).collect();
            blocks.push(Block::Figure(figure.with_excluded(&excluded)));
        }
    }
    Parts { body: blocks, appendix: vec![Block::Table(times)] }
}

/// The ignored manoeuvres with the author's note on each; none where all are used.
fn not_used(session: &Session) -> Option<Block> {
    let ignored = session.windows.iter().filter(|window| window.role == WindowRole::Ignored);
    let (without, noted): (Vec<&Manoeuvre>, Vec<&Manoeuvre>) = ignored.partition(|window| window.note.is_empty());
    let noted: Vec<String> = noted.iter().map(|window| format!("{} ({})", window.name, window.note)).collect();
    let without: Vec<&str> = without.iter().map(|window| window.name.as_str()).collect();
    let noted = (!noted.is_empty()).then(|| format!("Not used: {}.", noted.join("; ")));
    let without = (!without.is_empty()).then(|| format!("Not used, no reason noted: {}.", without.join(", ")));
    let sentences: Vec<String> = noted.into_iter().chain(without).collect();
    (!sentences.is_empty()).then(|| Block::Paragraph(sentences.join(" ")))
}

/// One row per manoeuvre in use: condition, mass, wind, steadiness before the input, verdict.
fn manoeuvre_table(contents: &Contents<'_>) -> Table {
    let results = contents.results;
    let condition = |row: &WindowRow| {
        results.manoeuvre_map.iter().find(|found| found.name == row.name && found.flight == row.flight)
    };
    let map_value = |row: &WindowRow, value: &dyn Fn(&MapRow) -> Option<f64>| condition(row).and_then(value);
    let caption = format!(
        "Manoeuvres: condition ({}), wind and gusts where they are known, and drift before the input. {CONDITION_NOTE}",
        altitude_kind(contents)
    );
    TableOf::new("flown", caption, &results.windows)
        .text("window", "Manoeuvre", |row| &row.name)
        .text("role", "Use", |row| if row.role == WindowRole::Validation.name() { "val" } else { "id" })
        .maybe("airspeed_m_s", "Airspeed", "m/s", 3, |row| map_value(row, &|row| row.airspeed_m_s))
        .maybe("altitude_m", "Altitude", "m", 4, |row| map_value(row, &|row| row.altitude_m))
        .maybe("mass_kg", "Mass", "kg", 5, |row| map_value(row, &|row| row.mass_kg))
        .maybe("cg_chord", "CG on chord", "", 3, |row| map_value(row, &|row| row.cg_chord))
        .maybe("wind_m_s", "Wind", "m/s", 2, |row| map_value(row, &|row| row.wind_m_s))
        .maybe("wind_deviation_m_s", "Gusts", "m/s", 2, |row| map_value(row, &|row| row.wind_deviation_m_s))
        .maybe("airspeed_slope_m_s2", "dV/dt", "m/s²", 2, |row| Some(row.before_input?.airspeed_slope_m_s2))
        .maybe("w_slope_m_s2", "dw/dt", "m/s²", 2, |row| Some(row.before_input?.w_slope_m_s2))
        .maybe("climb_m_s", "Climb", "m/s", 2, |row| row.before_input?.climb_m_s)
        .optional("verdict", "Verdict", |row| row.verdict.as_ref().map(|verdict| verdict.level.name()))
        .done()
}

/// Modelled power of each engine against that of its monitor (thesis 6.3).
pub fn engines(contents: &Contents<'_>) -> Parts {
    let results = contents.results;
    if results.engines.is_empty() {
        return Parts::default();
    }
    let mut blocks = Vec::new();
    let (power_unit, power) = notation::unit(Dimension::Power);
    for flight in &contents.session.flights {
        let Some(found) = contents.snapshot.engines.get(&flight.name).and_then(|slot| slot.ready()) else { continue };
        let panels = found.engines.iter().map(|engine| {
            let mut marks = vec![line("modelled", 0, &engine.power_w, power)];
            marks.extend(engine.monitor_power_w.iter().map(|monitor| Mark::Line {
                label: "monitor".into(),
                colour: Colour::by_index(1),
                style: LineStyle::Dashed,
                series: monitor.clone(),
                scale: power,
            }));
            Panel::Plot(Plot { x: Axis::time(), y: Axis::new(format!("P {}", engine.name), power_unit), marks })
        });
        blocks.push(Block::Figure(Figure::new(
            format!("engines {}", flight.name),
            format!("Power of the engines over flight {}.", flight.name),
            (1, 32.0),
            panels.collect(),
        )));
    }
    let by_phase = tables::engines(results);
    let whole = by_phase.clone().only("phase", |cell| *cell == Cell::text("whole flight"));
    let agreement = |cell: &Cell| *cell == Cell::text("r²") || *cell == Cell::text("RMS of the difference");
    let whole = whole
        .only("quantity", agreement)
        .select(&["flight", "engine", "quantity", "mean_modelled_w", "mean_monitor_w", "value", "unit"]);
    blocks.push(Block::Table(whole));
    Parts { body: blocks, appendix: vec![Block::Table(by_phase)] }
}
