//! The dialog of a new session: what the recording holds, its name, aircraft and channel map, what is missing.

use std::path::Path;

use doublet_core::load::{Probe, Source};
use doublet_engine::begin::missing;
use doublet_engine::builtin;
use doublet_engine::verdict::Level;
use eframe::egui::{
    self, Align, Button, CollapsingHeader, ComboBox, Grid, Key, Label, Layout, Modifiers, ProgressBar, RichText,
    ScrollArea, TextEdit, Ui, vec2,
};

use super::aircraft::AircraftForm;
use super::{AircraftChoice, Choice, Choosing, Step, physics, roles};
use crate::notation::{self, plural};
use crate::theme;

/// Gaps and findings listed.
const LISTED: usize = 6;
/// The choice of no aircraft.
const WITHOUT: &str = "none: flight path only";
/// Room below the roles and the contradictions: what is missing, the buttons.
const BELOW: f32 = 126.0;
/// Of it, what is missing.
const LACKING: f32 = 52.0;
/// Channels listed of one source.
const MOST_CHANNELS: usize = 400;

/// What the dialog asks for.
pub enum Answer {
    Open,
    GivenUp,
    AskBeside,
    AskAircraft,
    SaveAircraft,
    Make,
}

/// Draws the dialog of a step; `below` another dialog it leaves the keyboard to that.
pub fn show(step: &mut Step, below: bool, ctx: &egui::Context) -> Answer {
    let mut answer = Answer::Open;
    let screen = ctx.content_rect().size();
    // Escape leaves a list or a field first; what was chosen by hand is not thrown away with it.
    let focus = ctx.memory(egui::Memory::focused);
    let (first, before) = match step {
        Step::Choosing(choosing) => (choosing.first_field, std::mem::replace(&mut choosing.focused, focus)),
        Step::Looking(..) | Step::Making(..) => (None, None),
    };
    let is_typing = [before, focus].into_iter().flatten().any(|field| Some(field) != first);
    let busy = egui::Popup::is_any_open(ctx) || is_typing;
    egui::Modal::new(egui::Id::unique("new session")).show(ctx, |ui| match step {
        Step::Looking(path, job, _) => {
            ui.set_width(420.0);
            ui.heading("New session");
            answer = waiting(ui, &format!("Reading {}", path.display()), job.progress());
        }
        Step::Making(choosing, job) => {
            ui.set_width(420.0);
            ui.heading(format!("New session {}", choosing.name));
            answer = waiting(ui, "Reading the channels and looking for manoeuvres", job.progress());
        }
        Step::Choosing(choosing) => {
            ui.set_width((screen.x - 80.0).clamp(640.0, 1200.0));
            answer = choose(choosing, ui, screen.y - 120.0);
        }
    });
    if !below && !busy && ctx.input(|input| input.key_pressed(Key::Escape)) {
        answer = Answer::GivenUp;
    }
    answer
}

fn waiting(ui: &mut Ui, what: &str, progress: f32) -> Answer {
    ui.add_space(6.0);
    ui.add(Label::new(what).truncate());
    ui.add(ProgressBar::new(progress).desired_height(10.0));
    ui.add_space(6.0);
    // The thread ends a moment after its last step wakes this one.
    ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
    if ui.button("Cancel").clicked() { Answer::GivenUp } else { Answer::Open }
}

fn choose(choosing: &mut Choosing, ui: &mut Ui, height: f32) -> Answer {
    let mut answer = Answer::Open;
    ui.heading("New session from a recording");
    contents(choosing, ui);
    ui.separator();
    ui.horizontal(|ui| {
        ui.label("Name");
        let name = ui.add(TextEdit::singleline(&mut choosing.name).desired_width(180.0));
        ui.ctx().accesskit_node_builder(name.id, |node| node.set_label("name of the session"));
        ui.add_space(12.0);
        answer = aircraft(choosing, ui);
        let hint = "Another file of the same flight, read along: of another recorder, or with the rest of the channels";
        if ui.button("Add a file…").on_hover_text(hint).clicked() {
            answer = Answer::AskBeside;
        }
    });
    if let Some(form) = &mut choosing.aircraft_form {
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
    maps(choosing, ui);
    ui.add_space(4.0);
    let contradictions = choosing.comparison.room();
    let room = (height - ui.min_rect().height() - BELOW - contradictions).max(150.0);
    roles::show(choosing, ui, room);
    ui.separator();
    physics::show(choosing, ui, contradictions);
    // Of one height whatever is missing, and with the roles whatever contradicts: the dialog does not move under the pointer.
    let below = ScrollArea::vertical().id_salt("lacking").max_height(LACKING).min_scrolled_height(LACKING);
    below.auto_shrink(false).show(ui, |ui| lacking(choosing, ui));
    if let Some(line) = &choosing.complaint {
        ui.add(Label::new(RichText::new(line).color(theme::palette(ui).error)).wrap());
    }
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        let lacks = choosing.lacks();
        let button = ui.add_enabled(lacks.is_none(), Button::new("Create session").min_size(vec2(120.0, 26.0)));
        let pressed = lacks.is_none() && ui.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::Enter));
        let button = button.on_hover_text("Ctrl+Enter").on_disabled_hover_text(lacks.unwrap_or_default());
        if button.clicked() || pressed {
            answer = Answer::Make;
        }
        if ui.add(Button::new("Cancel").min_size(vec2(80.0, 26.0))).clicked() {
            answer = Answer::GivenUp;
        }
        let about = "Nothing of the recording is changed or copied; the session is not saved until you save it.";
        let text = match lacks {
            Some(lacks) => RichText::new(format!("First: {lacks}")).color(theme::palette(ui).warning),
            None => RichText::new(about).weak(),
        };
        ui.add(Label::new(text).truncate());
    });
    answer
}

/// Format, sources and findings.
fn contents(choosing: &Choosing, ui: &mut Ui) {
    for probe in &choosing.inspected.probes {
        let count: usize = probe.sources.iter().map(|source| source.channels.len()).sum();
        let sources = match probe.sources.len() {
            1 => String::new(),
            sources => format!(" in {sources} sources"),
        };
        ui.add(Label::new(format!("{}: {}, {count} channels{sources}", probe.path.display(), probe.format)).truncate());
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
                ScrollArea::vertical().max_height(90.0).auto_shrink([false, true]).show(ui, |ui| {
                    findings.iter().for_each(|line| drop(ui.add(Label::new(line).wrap())));
                });
            });
        }
        CollapsingHeader::new("Channels").id_salt((&probe.path, "channels")).show(ui, |ui| channels(probe, ui));
    }
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
    let mut lines = probe.warnings.clone();
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
fn channels(probe: &Probe, ui: &mut Ui) {
    ScrollArea::vertical().max_height(140.0).auto_shrink([false, true]).show(ui, |ui| {
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
        AircraftChoice::Open => (
            RichText::new("choose…").color(theme::palette(ui).warning),
            "Whose recording it is: mass, inertia and reference area come from it".to_owned(),
        ),
        AircraftChoice::Without => {
            (RichText::new(WITHOUT), "No coefficients and no derivatives are computed".to_owned())
        }
        AircraftChoice::Of(reference) => {
            let shown = match reference.strip_prefix(builtin::PREFIX) {
                Some(name) => name.into(),
                None => Path::new(reference).file_name().unwrap_or_default().to_string_lossy(),
            };
            (RichText::new(shown), reference.clone())
        }
    };
    let combo = ComboBox::from_id_salt("aircraft").selected_text(shown).width(220.0).truncate();
    let combo = combo.show_ui(ui, |ui| {
        ui.selectable_value(&mut choosing.aircraft, AircraftChoice::Without, WITHOUT);
        for name in builtin::aircraft() {
            let of = AircraftChoice::Of(format!("{}{name}", builtin::PREFIX));
            ui.selectable_value(&mut choosing.aircraft, of, name);
        }
    });
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("aircraft"));
    // Nothing goes on without an aircraft, so the keyboard begins here.
    if !std::mem::replace(&mut choosing.has_begun, true) {
        combo.response.request_focus();
    }
    choosing.first_field = Some(combo.response.id);
    combo.response.on_hover_text(about);
    if ui.button("Aircraft file…").on_hover_text("An aircraft file of your own (TOML)").clicked() {
        answer = Answer::AskAircraft;
    }
    let own = ui.button("Describe one").on_hover_text("Area, span, chord, mass and inertia make an aircraft file");
    if own.clicked() {
        choosing.aircraft_form = Some(AircraftForm::default());
    }
    answer
}

/// The maps that fit, the one with most roles first, and the one made by hand.
fn maps(choosing: &mut Choosing, ui: &mut Ui) {
    ui.horizontal_wrapped(|ui| {
        ui.label("Channel map");
        for (index, map) in choosing.inspected.fitting.iter().enumerate() {
            let text = format!("{} ({} roles)", map.name, map.plan.roles.len());
            ui.radio_value(&mut choosing.choice, Choice::Shipped(index), text).on_hover_text(&map.description);
        }
        let text = format!("By hand ({} roles)", choosing.hand.rows.len());
        let about = "Role by role, guessed from names, units and values to begin with. Kept in the session.";
        ui.radio_value(&mut choosing.choice, Choice::ByHand, text).on_hover_text(about);
    });
    if choosing.inspected.fitting.is_empty() {
        ui.weak("No map that comes with the program fits: the roles below are guessed. Look at each before you go on.");
    }
}

/// What is wrong with the plan, and the roles there are not with what they block.
fn lacking(choosing: &Choosing, ui: &mut Ui) {
    let palette = theme::palette(ui);
    let plan = match choosing.plan() {
        Ok(plan) => plan,
        Err(line) => return drop(ui.add(Label::new(RichText::new(line).color(palette.error)).wrap())),
    };
    let derived = choosing.derives_position();
    let position = doublet_core::reconstruct::Measurement::ALL[..3].iter().map(|measurement| measurement.role());
    let position: Vec<_> = position.collect();
    for lack in missing(|role| plan.roles.contains_key(&role) || (derived && position.contains(&role))) {
        let names: Vec<_> = lack.roles.iter().map(|role| notation::role(*role)).collect();
        let text = RichText::new(format!("{} {}", lack.means, names.join("  ")));
        let text = match lack.level {
            Level::Good => text.weak(),
            level => text.color(palette.of_level(level)),
        };
        ui.add(Label::new(text).wrap());
    }
    for problem in &plan.problems {
        let color = if problem.is_error { palette.error } else { palette.warning };
        ui.add(Label::new(RichText::new(&problem.text).color(color).size(11.5)).wrap());
    }
}
