//! A new session as a page of steps: the recording and its aircraft, what the channels mean, and a check of both.

use doublet_core::quantity::Role;
use doublet_core::reconstruct::Measurement;
use doublet_engine::begin::{Missing, missing};
use doublet_engine::verdict::Level;
use eframe::egui::{
    self, Align, Button, Grid, Key, Label, Layout, Modifiers, ProgressBar, RichText, ScrollArea, Ui, vec2,
};

use super::{Choice, Choosing, Step, physics, recording, roles};
use crate::widgets::level_mark::{channel_legend, level_mark};
use crate::{notation, theme};

/// Height of the foot: what is to be done first, the buttons.
const FOOT: f32 = 62.0;
/// Height of what is missing, below the roles.
const LACKING: f32 = 52.0;
/// Size of the buttons of the steps and of the foot.
const STEP: egui::Vec2 = vec2(190.0, 28.0);
const BUTTON: egui::Vec2 = vec2(92.0, 26.0);

/// What the page asks for.
pub enum Answer {
    Open,
    /// Leave it for now; the draft is kept.
    Left,
    GivenUp,
    AskBeside,
    /// Leave out the recording at this place.
    Remove(usize),
    AskAircraft,
    SaveAircraft,
    Make,
}

/// The steps, in their order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Page {
    #[default]
    Recording,
    Channels,
    Check,
}

impl Page {
    const ALL: [Self; 3] = [Self::Recording, Self::Channels, Self::Check];

    doublet_core::variant_texts! {
        title: Recording "Recording and aircraft", Channels "Channels", Check "Check"
    }

    /// The page `by` places on.
    fn step(self, by: isize) -> Option<Self> {
        let at = Self::ALL.iter().position(|page| *page == self)?.checked_add_signed(by)?;
        Self::ALL.get(at).copied()
    }

    /// How far it is: bad where something keeps the session from being made, a caution where something is in doubt.
    fn level(self, choosing: &Choosing) -> Level {
        match self {
            Self::Recording if choosing.lacks_aircraft_or_name().is_some() => Level::Bad,
            Self::Recording => Level::Good,
            Self::Channels if choosing.lacks_roles().is_some() => Level::Bad,
            Self::Channels => {
                let worst = missing_roles(choosing).iter().map(|lack| lack.level).max();
                worst.unwrap_or_default().min(Level::Caution)
            }
            Self::Check if choosing.lacks_units().is_some() => Level::Bad,
            Self::Check if !choosing.questions().is_empty() => choosing.comparison.worst().max(Level::Caution),
            Self::Check => choosing.comparison.worst(),
        }
    }
}

/// What the mark of a step means.
fn step_words(level: Level) -> &'static str {
    match level {
        Level::Good => "complete",
        Level::Caution => "check needed",
        Level::Bad => "incomplete: Create needs it",
    }
}

/// Draws what is waited for; what was asked for.
pub(super) fn wait(step: &Step, below: bool, ctx: &egui::Context) -> Answer {
    let (title, what, progress) = match step {
        Step::Looking(path, job, _) => {
            ("New session".to_owned(), format!("Reading {}", path.display()), job.progress())
        }
        Step::Making(choosing, job) => {
            let what = "Reading the channels and looking for manoeuvres".to_owned();
            (format!("New session {}", choosing.name), what, job.progress())
        }
        Step::Choosing(_) => return Answer::Open,
    };
    let mut answer = Answer::Open;
    egui::Modal::new(egui::Id::unique("new session")).show(ctx, |ui| {
        ui.set_width(420.0);
        ui.heading(title);
        ui.add_space(6.0);
        ui.add(Label::new(what).truncate());
        ui.add(ProgressBar::new(progress).desired_height(10.0));
        ui.add_space(6.0);
        // The thread ends a moment after its last step wakes this one.
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
        if ui.button("Cancel").clicked() {
            answer = Answer::GivenUp;
        }
    });
    if !below && ctx.input(|input| input.key_pressed(Key::Escape)) {
        answer = Answer::GivenUp;
    }
    answer
}

/// Draws the page; `below` another dialog it leaves the keyboard to that.
pub(super) fn show(choosing: &mut Choosing, below: bool, ui: &mut Ui) -> Answer {
    // Escape leaves a list or a field first.
    let focus = ui.memory(egui::Memory::focused);
    let before = std::mem::replace(&mut choosing.focused, focus);
    let is_typing = [before, focus].into_iter().flatten().any(|field| Some(field) != choosing.first_field);
    let is_busy = below || egui::Popup::is_any_open(ui.ctx()) || is_typing;
    let escaped = !is_busy && ui.input(|input| input.key_pressed(Key::Escape));
    physics::follow(choosing, ui.ctx());
    let mut answer = steps(choosing, ui);
    ui.separator();
    let room = (ui.available_height() - FOOT).max(120.0);
    let body = ui.allocate_ui(vec2(ui.available_width(), room), |ui| {
        ui.set_min_size(vec2(ui.available_width(), room));
        match choosing.page {
            Page::Recording => {
                let list = ScrollArea::vertical().id_salt("new session recording").auto_shrink(false);
                list.show(ui, |ui| recording::show(choosing, ui)).inner
            }
            Page::Channels => {
                channels(choosing, ui);
                Answer::Open
            }
            Page::Check => {
                let list = ScrollArea::vertical().id_salt("new session check").auto_shrink(false);
                list.show(ui, |ui| check(choosing, ui));
                Answer::Open
            }
        }
    });
    if !matches!(body.inner, Answer::Open) {
        answer = body.inner;
    }
    ui.separator();
    let pressed = foot(choosing, below, ui);
    if !matches!(pressed, Answer::Open) {
        answer = pressed;
    }
    if escaped { Answer::GivenUp } else { answer }
}

/// The steps with their levels, and the way out that keeps the draft.
fn steps(choosing: &mut Choosing, ui: &mut Ui) -> Answer {
    let mut answer = Answer::Open;
    let row = vec2(ui.available_width(), STEP.y);
    ui.allocate_ui_with_layout(row, Layout::left_to_right(Align::Center), |ui| {
        ui.heading("New session");
        ui.add_space(12.0);
        for (at, page) in Page::ALL.into_iter().enumerate() {
            let level = page.level(choosing);
            level_mark(ui, Some(level)).on_hover_text(step_words(level));
            let text = format!("{} {}", at + 1, page.title());
            let button = ui.add(Button::selectable(choosing.page == page, text).min_size(vec2(0.0, STEP.y)));
            let label = format!("new session step {}: {}", page.title(), level.name());
            ui.ctx().accesskit_node_builder(button.id, |node| node.set_label(label));
            if button.on_hover_text(step_words(level)).clicked() {
                choosing.page = page;
            }
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let hint = "Back to the workbench; File, Continue new session brings the draft back";
            if ui.button("Leave, keep the draft").on_hover_text(hint).clicked() {
                answer = Answer::Left;
            }
        });
    });
    answer
}

/// What is to be done first, and the buttons.
fn foot(choosing: &mut Choosing, below: bool, ui: &mut Ui) -> Answer {
    let mut answer = Answer::Open;
    let lacks = choosing.lacks();
    let open = choosing.questions().len();
    if let Some(line) = &choosing.complaint {
        ui.add(Label::new(RichText::new(line).color(theme::palette(ui).error)).truncate());
    } else {
        let text = match (lacks, choosing.describe_missing_inputs()) {
            (Some(lacks), _) => RichText::new(format!("First: {lacks}")).color(theme::palette(ui).warning),
            (None, Some(missing)) => RichText::new(missing).color(theme::palette(ui).warning),
            (None, None) if open > 0 => {
                let count = notation::plural(open, "open question");
                let text = format!("{count}: Create assumes what step Check lists");
                RichText::new(text).color(theme::palette(ui).warning)
            }
            (None, None) => {
                RichText::new("The recording is neither changed nor copied. Save the session yourself.").weak()
            }
        };
        ui.add(Label::new(text).truncate());
    }
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        let button = ui.add_enabled(lacks.is_none(), Button::new("Create session").min_size(vec2(120.0, BUTTON.y)));
        let pressed =
            lacks.is_none() && !below && ui.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::Enter));
        let button = button.on_hover_text("Ctrl+Enter").on_disabled_hover_text(lacks.unwrap_or_default());
        if button.clicked() || pressed {
            answer = Answer::Make;
        }
        for (name, by) in [("Next", 1), ("Back", -1)] {
            let to = choosing.page.step(by);
            if ui.add_enabled(to.is_some(), Button::new(name).min_size(BUTTON)).clicked()
                && let Some(to) = to
            {
                choosing.page = to;
            }
        }
        ui.add_space(16.0);
        if ui.add(Button::new("Cancel").min_size(BUTTON)).clicked() {
            answer = Answer::GivenUp;
        }
    });
    answer
}

/// The map and its roles, and what is missing.
fn channels(choosing: &mut Choosing, ui: &mut Ui) {
    maps(choosing, ui);
    ui.add_space(4.0);
    let room = (ui.available_height() - LACKING - 18.0).max(80.0);
    roles::show(choosing, ui, room);
    ui.separator();
    // Of one height whatever is missing: nothing moves under the pointer.
    let below = ScrollArea::vertical().id_salt("lacking").max_height(LACKING).min_scrolled_height(LACKING);
    below.auto_shrink(false).show(ui, |ui| lacking(choosing, ui));
}

/// What is missing, what is open, and what contradicts.
fn check(choosing: &mut Choosing, ui: &mut Ui) {
    ui.strong("Missing");
    if choosing.plan().is_ok_and(|plan| plan.problems.is_empty()) && missing_roles(choosing).is_empty() {
        ui.weak("Nothing is missing.");
    }
    lacking(choosing, ui);
    open_questions(choosing, ui);
    ui.add_space(8.0);
    ui.strong("Channels against each other");
    physics::show(choosing, ui);
}

/// What the recording leaves open, one line each; units that their values suggest are confirmed by a click, one or all.
fn open_questions(choosing: &mut Choosing, ui: &mut Ui) {
    if choosing.questions().is_empty() {
        return;
    }
    ui.add_space(8.0);
    let units: Vec<Role> =
        choosing.questions().iter().filter_map(|question| Some(choosing.open_unit(question)?.0)).collect();
    let mut confirmed: Vec<Role> = Vec::new();
    ui.horizontal(|ui| {
        ui.strong("Open questions");
        if units.len() > 1 && ui.small_button(format!("Confirm all {} units", units.len())).clicked() {
            confirmed.clone_from(&units);
        }
    });
    Grid::new("open questions").num_columns(3).min_col_width(0.0).spacing([8.0, 3.0]).show(ui, |ui| {
        for question in choosing.questions() {
            level_mark(ui, Some(if question.must_be_answered { Level::Bad } else { Level::Caution }));
            if let Some((role, unit)) = choosing.open_unit(question) {
                let button = ui.small_button(format!("Confirm {}", notation::raise_powers(unit.symbol)));
                let name = format!("confirm the unit of {}", role.name());
                ui.ctx().accesskit_node_builder(button.id, |node| node.set_label(name.as_str()));
                confirmed.extend(button.clicked().then_some(role));
            } else {
                ui.label("");
            }
            let text = match &question.option {
                Some(_) if question.role.is_some() => {
                    format!("{}; set its unit or travel in Channels", question.text())
                }
                _ => question.text(),
            };
            ui.add(Label::new(notation::typeset(&text, 13.0)).wrap());
            ui.end_row();
        }
    });
    choosing.confirm_units(&confirmed);
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
        let about = "Role by role, initially guessed from names, units and values. Stored in the session.";
        ui.radio_value(&mut choosing.choice, Choice::ByHand, text).on_hover_text(about);
        ui.separator();
        channel_legend(ui);
    });
    if choosing.inspected.fitting.is_empty() {
        ui.weak("No shipped map fits: the roles below are guessed. Check each role before you continue.");
    }
}

/// Roles that no channel is given; of those whose channel cannot be read the problems of the plan say why.
pub(super) fn missing_roles(choosing: &Choosing) -> Vec<Missing> {
    let Ok(plan) = choosing.plan() else { return Vec::new() };
    let derived = choosing.derives_position();
    let position = Measurement::ALL[..3].iter().map(|measurement| measurement.role());
    let position: Vec<_> = position.collect();
    let is_by_hand = choosing.choice == Choice::ByHand;
    let is_given = |role| plan.roles.contains_key(&role) || (is_by_hand && choosing.hand.row(role).is_some());
    missing(|role| is_given(role) || (derived && position.contains(&role)))
}

/// What is wrong with the plan, and the roles there are not with what they block.
fn lacking(choosing: &Choosing, ui: &mut Ui) {
    let palette = theme::palette(ui);
    let plan = match choosing.plan() {
        Ok(plan) => plan,
        Err(line) => return drop(ui.add(Label::new(RichText::new(line).color(palette.error)).wrap())),
    };
    for lack in missing_roles(choosing) {
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
