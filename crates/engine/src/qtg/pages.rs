//! Facts and figures of the pages.

use std::f64::consts::TAU;

use doublet_core::quantity::Dimension;
use doublet_core::series::{Recording, Series};
use doublet_core::validate::Signal;

use super::conditions::NOT_GIVEN;
use super::index::certainty;
use super::units::{name, requirements, unit};
use super::{Constants, DataCopy, TestEntry};
use crate::notation::{self, significant};
use crate::report::document::{Axis, Figure, LineStyle, Mark, Panel, Plot, line, replay_panel};
use crate::session::{Manoeuvre, Surface, WindowRole};
use crate::stage::{
    Judgement, Movement, ObjectiveTest, Quantity, RecordDemand, ReplaySeries, WindowAero, WindowReplay, deflection,
};

/// Signals of the motion in the plane of symmetry.
const LONGITUDINAL: [Signal; 6] = [
    Signal::PitchAngle,
    Signal::PitchRate,
    Signal::NormalAcceleration,
    Signal::AngleOfAttack,
    Signal::Airspeed,
    Signal::Altitude,
];
/// Signals of the motion out of it.
const LATERAL: [Signal; 6] = [
    Signal::RollRate,
    Signal::YawRate,
    Signal::BankAngle,
    Signal::Sideslip,
    Signal::HeadingAngle,
    Signal::SpecificForceY,
];

/// What the page says before any recording is looked at.
pub fn stated(entry: &TestEntry, rule: &ObjectiveTest, rule_name: &str) -> Vec<(String, String)> {
    let or = |own: &Option<String>, of_rule: &str| match own {
        Some(own) => own.clone(),
        None if of_rule.is_empty() => NOT_GIVEN.to_owned(),
        None => of_rule.to_owned(),
    };
    let page = if rule.page.is_empty() { String::new() } else { format!(", page {}", rule.page) };
    let mut facts = vec![
        ("Rule", format!("{} {}, {rule_name}{page}; tolerance {}", rule.paragraph, rule.name, certainty(rule).1)),
        ("Objective", or(&entry.objective, &rule.objective)),
        ("Required flight condition", or(&None, &rule.condition)),
        ("Flight condition of the record", or(&entry.condition, "")),
        ("Manual procedure", or(&entry.procedure, &rule.procedure)),
        ("Evaluation", evaluation(&rule.judgement).to_owned()),
        ("Tolerances", requirements(&rule.judgement)),
        ("Required record", asked_for(&rule.record)),
    ];
    if !rule.missing.is_empty() {
        facts.push(("Not read in the rule", rule.missing.clone()));
    }
    if !entry.scale.is_empty() {
        let changed = entry.scale.iter().map(|(name, factor)| format!("{} × {factor}", notation::derivative(name)));
        let changed = changed.collect::<Vec<_>>().join(", ");
        facts.push(("Model changed on purpose", format!("{changed}: this test shows that a wrong model fails")));
    }
    facts.extend(entry.note.iter().map(|note| ("Note", note.clone())));
    facts.into_iter().map(|(name, text)| (name.to_owned(), text)).collect()
}

/// How a result is judged.
fn evaluation(judgement: &Judgement) -> &'static str {
    match judgement {
        Judgement::History(_) => "flight and model in one plot; the model must stay inside the band at every sample",
        Judgement::Snapshot(_) => "trim of the model compared with the means of the flight",
        Judgement::TrimChange(_) => "change of trim from another manoeuvre, model compared with flight means",
        Judgement::Value { .. } => "flight and model at one time after the end of the input",
        Judgement::FreeResponse { .. } => {
            "period and damping from the free response of flight and model, by the same method"
        }
    }
}

/// What a page says where there is no record.
pub(crate) fn without_record() -> Vec<(String, String)> {
    let names = ["Automatic procedure", "Driven or constrained", "Validation data", "Initial conditions", "Result"];
    names.map(|name| (name.to_owned(), NOT_GIVEN.to_owned())).into()
}

fn asked_for(record: &RecordDemand) -> String {
    let demands = [
        (record.before_s, "s before the input"),
        (record.after_s, "s after it"),
        (record.least_s, "s in all"),
        (record.cycles, "cycles of the free response"),
    ];
    let words = demands.iter().filter(|(demand, _)| *demand > 0.0);
    let words: Vec<String> = words.map(|(demand, what)| format!("{demand} {what}")).collect();
    if words.is_empty() { "of any length".to_owned() } else { words.join(", ") }
}

/// How a snapshot is evaluated and where its data are.
pub(crate) fn snapshot_facts(
    window: &Manoeuvre,
    [from_s, to_s]: [f64; 2],
    trim: Option<&str>,
) -> Vec<(String, String)> {
    let mut facts = vec![
        (
            "Automatic procedure",
            "the program trims the identified model, with the mean constants of the identification manoeuvres"
                .to_owned(),
        ),
        ("Driven or constrained", "airspeed, flight path, rates, rudder and power: the means of the flight".to_owned()),
        (
            "Validation data",
            format!(
                "flight {}, manoeuvre '{}', means from {from_s:.2} to {to_s:.2} s; recordings with their hashes under References",
                window.flight, window.name
            ),
        ),
    ];
    facts.extend(trim.map(|window| ("Trim", format!("manoeuvre '{window}': changes from it are compared"))));
    facts.into_iter().map(|(name, text)| (name.to_owned(), text)).collect()
}

/// What drives the model, how the test is evaluated, and where the validation data are.
pub(crate) fn record_facts(
    window: &Manoeuvre,
    aero: &WindowAero,
    recording: Option<&Recording>,
    movement: Option<&Movement>,
    data: Option<&DataCopy>,
    constants: Constants,
) -> Vec<(String, String)> {
    let duration_s = window.window.end_s - window.window.start_s;
    let mut facts = vec![
        ("Automatic procedure", automatic(constants).to_owned()),
        ("Driven or constrained", driven(aero, recording, constants)),
        (
            "Validation data",
            format!(
                "flight {}, manoeuvre '{}', {:.2} to {:.2} s ({duration_s:.1} s); recordings with their hashes under References",
                window.flight, window.name, window.window.start_s, window.window.end_s
            ),
        ),
        (
            "Copy of the data",
            data.map_or(NOT_GIVEN.to_owned(), |data| format!("{}, SHA-256 {}", data.name, data.sha256)),
        ),
        (
            "Input",
            movement.map_or("no deflection moved".to_owned(), |movement| {
                format!(
                    "{} by at most {} deg; {:.1} s of flight before, {:.1} s after",
                    movement.surface.name(),
                    significant(movement.largest_rad.to_degrees(), 3),
                    movement.before_s,
                    movement.after_s()
                )
            }),
        ),
    ];
    if window.role == WindowRole::Identification {
        facts.push(("Independence", "none: this manoeuvre was also used to identify the derivatives".to_owned()));
    }
    facts.into_iter().map(|(name, text)| (name.to_owned(), text)).collect()
}

/// How the model is flown.
fn automatic(constants: Constants) -> &'static str {
    match constants {
        Constants::Identification => {
            "the identified model, with the constants of the identification, starts from its own trim and runs with six degrees of \
             freedom, without feedback from the recording"
        }
        Constants::Refit => {
            "the identified model, with constants refitted to this manoeuvre, starts from the reconstructed state at the first sample \
             and runs with six degrees of freedom, without feedback from the recording"
        }
    }
}

/// What the model is given of the recording.
fn driven(aero: &WindowAero, recording: Option<&Recording>, constants: Constants) -> String {
    let recorded = Surface::ALL.into_iter().filter(|surface| deflection(*surface, aero).is_some());
    let surfaces: Vec<String> = recorded.map(|surface| name_channel(recording, surface)).collect();
    let surfaces = if surfaces.is_empty() { "no deflection".to_owned() } else { surfaces.join(", ") };
    let thrust = if aero.data.engines.is_empty() { "no thrust" } else { "thrust" };
    match constants {
        Constants::Identification => format!(
            "changes of {surfaces} and of {thrust} from the trim as recorded; air density and mass properties as recorded; constant wind"
        ),
        Constants::Refit => format!(
            "{surfaces} as recorded; {thrust}, air density, mass properties and reconstructed wind over the record"
        ),
    }
}

fn name_channel(recording: Option<&Recording>, surface: Surface) -> String {
    let found = recording.and_then(|recording| recording.role(surface.role()));
    found.map_or_else(|| surface.name().to_owned(), |channel| format!("{} (channel {})", surface.name(), channel.name))
}

/// Flight and model over each other with the bands of the test, and the deflections.
pub fn figure(id: &str, window: &Manoeuvre, replay: &WindowReplay, aero: &WindowAero) -> Figure {
    let judged = |signal: Signal| replay.series.iter().any(|s| s.signal == signal && s.half_band.is_some());
    let (signals, surfaces): (Vec<Signal>, &[Surface]) = match window.surface {
        Some(Surface::Elevator) => (LONGITUDINAL.into(), &[Surface::Elevator]),
        Some(Surface::Aileron | Surface::Rudder) => (LATERAL.into(), &[Surface::Aileron, Surface::Rudder]),
        None => ([LONGITUDINAL, LATERAL].concat(), &Surface::ALL),
    };
    let further = Signal::ALL.into_iter().filter(|signal| judged(*signal) && !signals.contains(signal));
    let mut signals: Vec<Signal> = signals.iter().copied().chain(further).collect();
    // What is judged comes first.
    signals.sort_by_key(|signal| !judged(*signal));
    let replayed = |signal: &Signal| replay.series.iter().find(|series| series.signal == *signal);
    let mut panels: Vec<Panel> = signals.iter().filter_map(replayed).map(signal_panel).collect();
    panels.extend(surfaces.iter().filter_map(|surface| control_panel(*surface, replay, aero)));
    let band = if replay.series.iter().any(|series| series.half_band.is_some()) {
        " with the tolerance band (the widest if a parameter has several)"
    } else {
        ""
    };
    for panel in &mut panels {
        if let Panel::Plot(plot) = panel {
            plot.x.label = format!("test {id}: time");
        }
    }
    // As high as the page of the test holds them beside its text.
    let rows = panels.len().div_ceil(COLUMNS).max(1) as f64;
    Figure::new(
        format!("qtg {id}"),
        format!("{id}: flight, manoeuvre {}{band}, and model.", window.name),
        (COLUMNS, (PAGE_MM / rows - AROUND_MM).clamp(LOWEST_MM, HIGHEST_MM)),
        panels,
    )
}

/// Panels beside each other.
const COLUMNS: usize = 4;
/// Height that a figure takes of the page of its test, mm.
const PAGE_MM: f64 = 64.0;
/// Height a panel takes beside its plotting area, mm.
const AROUND_MM: f64 = 10.0;
/// Least height of a plotting area, mm.
const LOWEST_MM: f64 = 18.0;
/// Largest, mm.
const HIGHEST_MM: f64 = 30.0;

/// Flight with its band and the model on top.
fn signal_panel(series: &ReplaySeries) -> Panel {
    let mut series = series.clone();
    // A heading is shown from 0 to 360 deg.
    let begins = series.measured.values.first().copied().unwrap_or(0.0);
    if series.signal == Signal::HeadingAngle && begins < 0.0 {
        let turned = |shown: &mut Series| shown.values = shown.values.iter().map(|value| value + TAU).collect();
        turned(&mut series.measured);
        turned(&mut series.simulated);
    }
    let mut panel = replay_panel(&series, unit(series.signal.dimension()));
    if let Panel::Plot(plot) = &mut panel {
        plot.y.label = name(Quantity::Signal(series.signal));
        for mark in &mut plot.marks {
            if let Mark::Line { label, style, .. } = mark {
                // Dashed, so that the flight is seen below a model that matches it.
                (*label, *style) = match label.as_ref() {
                    "measured" => ("flight".into(), LineStyle::Solid),
                    _ => ("model".into(), LineStyle::Dashed),
                };
            }
        }
    }
    panel
}

fn control_panel(surface: Surface, replay: &WindowReplay, aero: &WindowAero) -> Option<Panel> {
    let values = deflection(surface, aero)?;
    let time_s = replay.series.first()?.measured.time_s.clone();
    let (unit, scale) = unit(Dimension::Angle);
    let series = Series { time_s, values: values.into() };
    let mark = line("as recorded, driving the model", 7, &series, scale);
    Some(Panel::Plot(Plot {
        x: Axis::time(),
        y: Axis::new(format!("{} deflection", surface.name()), unit),
        marks: vec![mark],
    }))
}
