//! The first page of a new session: what the recordings hold, the session's name, and whose flight it is.

use std::path::Path;
use std::sync::Arc;

use doublet_core::load::{Probe, Source};
use doublet_engine::builtin;
use doublet_engine::verdict::Level;
use eframe::egui::{CollapsingHeader, ComboBox, Grid, Id, Label, RichText, ScrollArea, TextEdit, Ui};

use super::page::Answer;
use super::{AircraftChoice, Choosing};
use crate::notation::{self, plural};
use crate::theme;
use crate::widgets::aircraft_form::{AircraftForm, shipped_name, stated_name};
use crate::widgets::level_mark::level_mark;

/// Sources listed.
const LISTED: usize = 6;
/// The choice of no aircraft.
const WITHOUT: &str = "none: flight path only";
/// Channels listed of one source.
const MOST_CHANNELS: usize = 400;
/// Height of a list of findings and of channels, and of what is below the only list of channels, which has the rest of the page.
const LIST: f32 = 150.0;
const BELOW_LIST: f32 = 40.0;

/// Draws the page.
pub(super) fn show(choosing: &mut Choosing, ui: &mut Ui) -> Answer {
    let mut answer = Answer::Open;
    ui.horizontal_wrapped(|ui| {
        ui.label("Name");
        let name = ui.add(TextEdit::singleline(&mut choosing.name).desired_width(220.0));
        ui.ctx().accesskit_node_builder(name.id, |node| node.set_label("name of the session"));
        ui.add_space(16.0);
        answer = aircraft(choosing, ui);
    });
    if let Some(form) = &mut choosing.aircraft_form {
        ui.add_space(4.0);
        form.show(ui);
        ui.horizontal(|ui| {
            if ui.button("Save the aircraft…").clicked() {
                answer = Answer::SaveAircraft;
            }
            if ui.button("Not now").clicked() {
                choosing.aircraft_form = None;
            }
        });
    }
    ui.separator();
    recorders(choosing, ui);
    if let Some(at) = contents(choosing, ui) {
        answer = Answer::Remove(at);
    }
    ui.add_space(4.0);
    let hint = "Another file of the same flight: from another recorder, or with other channels";
    if ui.button("Add a file…").on_hover_text(hint).clicked() {
        answer = Answer::AskBeside;
    }
    answer
}

/// Whether several recordings are of one flight, and the clocks that are shifted to merge them; each shift can be refused.
fn recorders(choosing: &mut Choosing, ui: &mut Ui) {
    let count = choosing.inspected.probes.len();
    if count < 2 {
        return;
    }
    let is_one = choosing.inspected.is_one_flight;
    ui.horizontal_top(|ui| {
        level_mark(ui, Some(if is_one { Level::Good } else { Level::Caution }));
        let text = if is_one {
            format!("These {count} recordings are merged into one flight: no two have all rates and specific forces.")
        } else {
            format!("These {count} recordings may be different flights. Remove those of another flight.")
        };
        ui.add(Label::new(text).wrap());
    });
    let trusted = &choosing.inspected.trusted_clocks;
    let found = choosing.comparison.clocks.iter().filter(|clock| !trusted.contains(&clock.source)).map(|clock| {
        let fitted: Vec<&str> = clock.fit.iter().map(|pair| pair.other.as_str()).collect();
        let offset_s = notation::fixed(clock.offset_s, 1);
        (clock.source.clone(), true, format!("Shift the clock of {} by {offset_s} s", clock.source), fitted.join(", "))
    });
    let refused = trusted.iter().map(|source| {
        (source.clone(), false, format!("Shift the clock of {source} to that of the others"), String::new())
    });
    for (source, is_shifted, text, fitted) in found.chain(refused).collect::<Vec<_>>() {
        let mut is_wanted = is_shifted;
        let tick = ui.checkbox(&mut is_wanted, text);
        if !fitted.is_empty() {
            tick.on_hover_text(format!("The session fits it to {fitted}"));
        }
        if is_wanted != is_shifted {
            let trusted = &mut Arc::make_mut(&mut choosing.inspected).trusted_clocks;
            if is_wanted {
                trusted.remove(&source)
            } else {
                trusted.insert(source)
            };
        }
    }
    ui.add_space(4.0);
}

/// Format, sources and findings; the place of a recording that is to be left out.
fn contents(choosing: &Choosing, ui: &mut Ui) -> Option<usize> {
    let mut removed = None;
    let is_alone = choosing.inspected.probes.len() == 1;
    for (at, probe) in choosing.inspected.probes.iter().enumerate() {
        let count: usize = probe.sources.iter().map(|source| source.channels.len()).sum();
        let sources = match probe.sources.len() {
            1 => String::new(),
            sources => format!(" in {sources} sources"),
        };
        ui.horizontal(|ui| {
            if choosing.inspected.probes.len() > 1 {
                let button = ui.small_button("✖").on_hover_text("Leave this recording out");
                let name = format!("remove {}", probe.path.file_name().unwrap_or_default().display());
                ui.ctx().accesskit_node_builder(button.id, |node| node.set_label(name));
                removed = button.clicked().then_some(at).or(removed);
            }
            let text = format!("{}: {}, {count} channels{sources}", probe.path.display(), probe.format);
            ui.add(Label::new(text).truncate());
        });
        ui.horizontal_wrapped(|ui| {
            for source in probe.sources.iter().take(LISTED) {
                ui.label(RichText::new(summary(source)).weak());
            }
            let more = probe.sources.get(LISTED..).unwrap_or_default();
            if !more.is_empty() {
                let rest = more.iter().map(summary).collect::<Vec<_>>().join("\n");
                ui.label(RichText::new(format!("and {} more", more.len())).weak()).on_hover_text(rest);
            }
        });
        let findings = findings(probe);
        if !findings.is_empty() {
            let color = theme::palette(ui).warning;
            let title = RichText::new(plural(findings.len(), "finding")).color(color);
            CollapsingHeader::new(title).id_salt(&probe.path).show(ui, |ui| {
                ScrollArea::vertical().max_height(LIST).auto_shrink([false, true]).show(ui, |ui| {
                    findings.iter().for_each(|line| drop(ui.add(Label::new(line).wrap())));
                });
            });
        }
        CollapsingHeader::new("Channels").id_salt((&probe.path, "channels")).default_open(true).show(ui, |ui| {
            let rest = ui.clip_rect().bottom() - ui.cursor().top() - BELOW_LIST;
            channels(probe, if is_alone { rest.max(LIST) } else { LIST }, ui);
        });
    }
    removed
}

/// Times of a source in one line.
fn summary(source: &Source) -> String {
    let name = if source.name.is_empty() { "recording" } else { &source.name };
    match source.clocks.first() {
        Some(clock) => format!(
            "{name}: {} samples, {} Hz, {} s to {} s",
            clock.samples,
            notation::number(clock.rate_hz),
            notation::fixed(clock.start_s, 2),
            notation::fixed(clock.end_s, 2)
        ),
        None => format!("{name}: no time"),
    }
}

fn findings(probe: &Probe) -> Vec<String> {
    let mut lines: Vec<String> = probe.warnings.iter().map(ToString::to_string).collect();
    for source in &probe.sources {
        lines.extend(source.clocks.iter().filter_map(|clock| Some(format!("time {}", clock.question.as_ref()?))));
        for clock in source.clocks.iter().filter(|clock| !clock.gaps.is_empty()) {
            let longest = clock.gaps.iter().map(|gap| gap.end_s - gap.start_s).fold(0.0, f64::max);
            let (count, name) = (clock.gaps.len(), &source.name);
            lines.push(format!("{name}: {count} gaps, the longest {} s", notation::fixed(longest, 2)));
        }
        for channel in source.channels.iter().filter(|channel| channel.non_finite.is_some_and(|count| count > 0)) {
            let count = channel.non_finite.unwrap_or_default();
            lines.push(format!("{}: {count} of {} samples are not finite", channel.name, channel.samples));
        }
    }
    lines
}

/// Every channel with its unit and samples.
fn channels(probe: &Probe, height: f32, ui: &mut Ui) {
    ScrollArea::vertical().max_height(height).auto_shrink([false, true]).show(ui, |ui| {
        Grid::new((&probe.path, "listed")).num_columns(4).striped(true).spacing([14.0, 1.0]).show(ui, |ui| {
            for source in &probe.sources {
                for channel in source.channels.iter().take(MOST_CHANNELS) {
                    ui.weak(&source.name);
                    ui.label(&channel.name);
                    ui.label(channel.unit.as_deref().unwrap_or("no unit"));
                    ui.label(format!("{} samples{}", channel.samples, if channel.is_time { ", time" } else { "" }));
                    ui.end_row();
                }
            }
        });
    });
}

/// The aircraft: one that comes with the program, a file, or a few numbers.
fn aircraft(choosing: &mut Choosing, ui: &mut Ui) -> Answer {
    let mut answer = Answer::Open;
    ui.label("Aircraft");
    let (shown, about) = match &choosing.aircraft {
        AircraftChoice::Open => {
            (RichText::new("choose…"), "Aircraft of the recording: gives mass, inertia and reference area".to_owned())
        }
        AircraftChoice::Without => {
            (RichText::new(WITHOUT), "No coefficients and no derivatives are computed".to_owned())
        }
        AircraftChoice::Of(reference) => {
            let shown = match reference.strip_prefix(builtin::PREFIX) {
                Some(name) => shipped_name(name).to_owned(),
                None => name_in_file(ui, Path::new(reference)),
            };
            (RichText::new(shown), reference.clone())
        }
    };
    let combo = ComboBox::from_id_salt("aircraft").selected_text(shown).width(220.0).truncate();
    let combo = combo.show_ui(ui, |ui| {
        ui.selectable_value(&mut choosing.aircraft, AircraftChoice::Without, WITHOUT);
        for name in builtin::aircraft() {
            let choice = AircraftChoice::Of(format!("{}{name}", builtin::PREFIX));
            ui.selectable_value(&mut choosing.aircraft, choice, shipped_name(name));
        }
    });
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("aircraft"));
    // Nothing goes on without an aircraft, so the keyboard begins here.
    if !std::mem::replace(&mut choosing.has_begun, true) {
        combo.response.request_focus();
    }
    choosing.first_field = Some(combo.response.id);
    combo.response.on_hover_text(about);
    if ui.button("Aircraft file…").on_hover_text("An aircraft file of your own").clicked() {
        answer = Answer::AskAircraft;
    }
    let own =
        ui.button("Describe aircraft…").on_hover_text("Area, span, chord, mass and inertia make an aircraft file");
    if own.clicked() {
        choosing.aircraft_form = Some(AircraftForm::default());
    }
    answer
}

/// What an aircraft's own file calls it, read once for each version; the name of the file where it states none.
fn name_in_file(ui: &Ui, path: &Path) -> String {
    let changed = std::fs::metadata(path).and_then(|file| file.modified()).ok();
    let id = Id::unique(("name of an aircraft", path, changed));
    ui.data_mut(|data| data.get_temp_mut_or_insert_with(id, || read_name(path)).clone())
}

fn read_name(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let otherwise = || path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    stated_name(&text).map_or_else(otherwise, str::to_owned)
}
