//! Manoeuvres marked in any plot against time: what a drag marks, the menu under the pointer, excluded parts and candidates.

use doublet_core::quantity::Role as ChannelRole;
use doublet_engine::report::document::Figure;
use doublet_engine::run::Snapshot;
use doublet_engine::session::{Edit, Manoeuvre, Session, Surface, WindowEdit, WindowRole};
use eframe::egui::{self, Align2, Color32, CornerRadius, FontId, Rect, Shape, Stroke, Ui, pos2, vec2};

use crate::command::{CommandInfo, EditCommand, MarkCommand, UiCommand, ViewCommand};
use crate::panels::{Pane, PanelContext, View, choose};
use crate::theme;
use crate::ui_state::UiState;
use crate::widgets::hatch::hatch;
use crate::widgets::span_editor::snapped;
use crate::widgets::time_plot::{MarkKind, Marked, StackResponse, x_at};
use crate::widgets::time_view::TimeRange;

/// Height of legend and readout at the top of a plot, points.
const LEGEND: f32 = 24.0;
/// Room above the words of a drag that marks, which clears the legend.
pub const BELOW_LEGEND: f32 = 40.0;
/// Shortest part a drag marks, s.
const SHORTEST_S: f64 = 1e-3;
/// How to exclude a part of a manoeuvre.
const EXCLUDE_BY_DRAG: &str = "Or drag with Alt inside the manoeuvre, unless the desktop moves windows so.";
const EXCLUDE_BY_MARKERS: &str = "Set markers A and B inside the manoeuvre first (keys A and B). Then press E. \
    Or drag with Alt inside it, unless the desktop moves windows so.";
/// Most candidates drawn at once.
const MOST_CANDIDATES: usize = 200;

/// A window of `part` with a name nobody has.
pub fn new_window(session: &Session, flight: String, part: TimeRange) -> Manoeuvre {
    let names = (1..).map(|number| format!("manoeuvre {number}"));
    let name = names.into_iter().find(|name| session.window(name).is_none()).unwrap_or_default();
    Manoeuvre::new(name, flight, part)
}

/// The manoeuvres of the flight that a view shows; in that of the chosen one, that alone.
fn shown<'a>(ctx: &PanelContext<'a>, view: View) -> impl Iterator<Item = &'a Manoeuvre> {
    let selection = ctx.selection();
    ctx.session.windows.iter().filter(move |window| match view {
        View::Flight => selection.flight.as_ref() == Some(&window.flight),
        View::Window => selection.window.as_ref() == Some(&window.name),
    })
}

/// The manoeuvres of a flight that share time with `part`, without the one called `own`.
pub fn overlapping<'s>(session: &'s Session, flight: &str, part: TimeRange, own: &str) -> Vec<&'s str> {
    let of_flight = session.windows.iter().filter(|window| window.flight == flight && window.name != own);
    let shares = |window: &&Manoeuvre| window.window.start_s < part.end_s && window.window.end_s > part.start_s;
    of_flight.filter(shares).map(|window| window.name.as_str()).collect()
}

/// The manoeuvres that one overlaps, in words.
pub fn overlap_text(names: &[&str]) -> Option<String> {
    match names {
        [] => None,
        [one] => Some(format!("overlaps {one}")),
        [first, more @ ..] => Some(format!("overlaps {first} and {} more", more.len())),
    }
}

/// The manoeuvre at a time: the chosen one where it lies there.
pub fn at<'a>(ctx: &PanelContext<'a>, view: View, time_s: f64) -> Option<&'a Manoeuvre> {
    let here = |window: &&Manoeuvre| window.window.contains(time_s);
    let chosen =
        ctx.window().filter(|window| view == View::Window || Some(&window.flight) == ctx.selection().flight.as_ref());
    chosen.filter(here).or_else(|| shown(ctx, view).find(here))
}

/// Draws over a stack what is left out, the candidates and the drag that marks; carries that out where it ends.
pub fn show(ctx: &mut PanelContext<'_>, ui: &Ui, view: View, response: &StackResponse) {
    let frames = frames_on_screen(ui, &response.frames, response);
    if frames.is_empty() {
        return;
    }
    let range = ctx.view(view).range();
    // Legend and readout at the top of a plot stay clear.
    let below: Vec<Rect> = response.frames.iter().map(|frame| frame.with_min_y(frame.top() + LEGEND)).collect();
    let clear = frames_on_screen(ui, &below, response);
    for part in shown(ctx, view).flat_map(|window| &window.excluded) {
        clear.iter().for_each(|frame| hatch(ui, over(*frame, range, *part)));
    }
    let flight = ctx.selection().flight.clone().unwrap_or_default();
    let of = OfFlight { session: ctx.session, snapshot: ctx.snapshot, flight: &flight };
    if view == View::Flight {
        let open = of.open_candidates(range);
        let asked = ctx.state.candidate_of(open.iter().copied());
        ghosts(ui, (&frames, range), &open, &|one| {
            asked.is_some_and(|asked| std::ptr::eq(asked, one)) || ctx.selection().has_candidate(one)
        });
        // After the edges of the others, which else run through its words.
        if let (Some(asked), Some(frame)) = (asked, frames.first()) {
            let left = x_at(*frame, range, asked.window.start_s).max(frame.left());
            draw_label(ui, *frame, left, LEGEND, &format!("{}?  Y accept, N refuse", asked.name));
        }
    }
    let Some(marked) = response.marked else { return };
    let window = at(ctx, view, marked.from_s);
    draw_marked(ui, (&frames, range), marked.part, &of.meaning(ui, window, marked), BELOW_LEGEND);
    if let Some(edit) = of.carry_out(ctx.state, window, marked) {
        ctx.edit(edit);
    }
}

/// What of the frames of a stack is on screen.
pub fn frames_on_screen(ui: &Ui, frames: &[Rect], response: &StackResponse) -> Vec<Rect> {
    let clip = response.visible.map_or(ui.clip_rect(), |visible| visible.intersect(ui.clip_rect()));
    let seen = |frame: &Rect| Rect::from_x_y_ranges(frame.x_range(), frame.intersect(clip).y_range());
    frames.iter().map(seen).filter(Rect::is_positive).collect()
}

/// A part of time in a frame that shows `range`.
pub fn over(frame: Rect, range: TimeRange, part: TimeRange) -> Rect {
    let x = [part.start_s, part.end_s].map(|time_s| x_at(frame, range, time_s));
    Rect::from_x_y_ranges(x[0]..=x[1], frame.y_range()).intersect(frame)
}

/// Draws a drag that marks, and in words so far below the head of the first frame what it does.
pub fn draw_marked(
    ui: &Ui,
    (frames, range): (&[Rect], TimeRange),
    part: TimeRange,
    (text, color): &(String, Color32),
    below: f32,
) {
    for frame in frames {
        let rect = over(*frame, range, part);
        ui.painter().rect_filled(rect, 0.0, color.gamma_multiply(0.18));
        for x in [rect.left(), rect.right()] {
            ui.painter().vline(x, rect.y_range(), Stroke::new(1.0, *color));
        }
    }
    if let Some(first) = frames.first() {
        draw_label(ui, *first, over(*first, range, part).left(), below, text);
    }
}

/// The candidates as ghosts; those that the keys accept or refuse and those selected in the accent colour.
pub fn ghosts(
    ui: &Ui,
    (frames, range): (&[Rect], TimeRange),
    open: &[&Manoeuvre],
    is_lit: &dyn Fn(&Manoeuvre) -> bool,
) {
    let (accent, weak) = (theme::palette(ui).accent, ui.visuals().weak_text_color());
    for candidate in open {
        let is_lit = is_lit(candidate);
        let color = if is_lit { accent } else { weak };
        for frame in frames {
            let painter = ui.painter().with_clip_rect(*frame);
            let TimeRange { start_s, end_s } = candidate.window;
            let [left, right] = [start_s, end_s].map(|time_s| x_at(*frame, range, time_s));
            let rect = Rect::from_x_y_ranges(left..=right, frame.y_range());
            painter.rect_filled(rect, 0.0, color.gamma_multiply(if is_lit { 0.08 } else { 0.04 }));
            for x in [left, right] {
                let ends = [pos2(x, frame.top()), pos2(x, frame.bottom())];
                painter.extend(Shape::dashed_line(&ends, Stroke::new(1.0, color.gamma_multiply(0.8)), 4.0, 4.0));
            }
        }
    }
}

/// The flight that a plot shows, with what was computed of it.
#[derive(Clone, Copy)]
pub struct OfFlight<'a, 'f> {
    pub session: &'a Session,
    pub snapshot: &'a Snapshot,
    pub flight: &'f str,
}

impl<'a> OfFlight<'a, '_> {
    /// The candidates that overlap `range`, neither in the session nor refused, in the order of time.
    pub fn open_candidates(self, range: TimeRange) -> Vec<&'a Manoeuvre> {
        let found = self.snapshot.proposals.get(self.flight).and_then(|slot| slot.latest());
        let found = found.map_or(&[][..], |found| &found.windows);
        let on_screen = |window: TimeRange| window.start_s < range.end_s && window.end_s > range.start_s;
        found
            .iter()
            .filter(|one| on_screen(one.manoeuvre.window) && !self.session.has_refused(&one.manoeuvre))
            .filter(|one| one.covering_window(self.session).is_none())
            .map(|one| &one.manoeuvre)
            .take(MOST_CANDIDATES)
            .collect()
    }

    /// The candidate at a time: of several the one that begins last, which lies within the others.
    pub fn candidate_at(self, time_s: f64) -> Option<&'a Manoeuvre> {
        let open = self.open_candidates(TimeRange { start_s: time_s, end_s: time_s });
        open.into_iter().max_by(|a, b| a.window.start_s.total_cmp(&b.window.start_s))
    }

    /// What a drag does that began in `window`, in words, and its colour.
    pub fn meaning(self, ui: &Ui, window: Option<&Manoeuvre>, marked: Marked) -> (String, Color32) {
        let palette = theme::palette(ui);
        let length = format!("{:.2} s", marked.part.length_s());
        match (marked.kind, window.map(|window| &window.name)) {
            (MarkKind::Manoeuvre, _) => match overlap_text(&overlapping(self.session, self.flight, marked.part, "")) {
                Some(shared) => (format!("New manoeuvre, {length}, {shared}"), palette.warning),
                None => (format!("New manoeuvre, {length}"), palette.identification),
            },
            (MarkKind::Excluded, Some(name)) => (format!("Exclude {length} of {name}"), palette.cursor),
            (MarkKind::Included, Some(name)) => (format!("Include {length} of {name} again"), palette.cursor),
            (_, None) => ("No manoeuvre here".to_owned(), palette.ignored),
        }
    }

    /// The edit that a drag asks for which ended and began in `window`; what it changes is chosen.
    pub fn carry_out(self, state: &mut UiState, window: Option<&Manoeuvre>, marked: Marked) -> Option<Edit> {
        if !marked.is_done || marked.part.length_s() <= SHORTEST_S {
            return None;
        }
        if marked.kind == MarkKind::Manoeuvre {
            let loaded = self.snapshot.flights.get(self.flight).and_then(|slot| slot.latest());
            let rate = loaded.and_then(|loaded| loaded.recording.role(ChannelRole::RollRate));
            let samples_s = rate.map_or(&[][..], |channel| &channel.series.time_s);
            let [start_s, end_s] = [marked.part.start_s, marked.part.end_s].map(|time_s| snapped(samples_s, time_s));
            let window = new_window(self.session, self.flight.to_owned(), TimeRange::new(start_s, end_s));
            state.selection.window = Some(window.name.clone());
            return Some(Edit::Window(WindowEdit::Add(window)));
        }
        let window = window?;
        // Whole milliseconds are read easily in the session file.
        let part = TimeRange::new(to_ms(marked.part.start_s), to_ms(marked.part.end_s));
        let excluded = match marked.kind {
            MarkKind::Excluded => window.excluded_with(part),
            _ => Some(window.excluded_without(part)),
        };
        let excluded = excluded.filter(|excluded| *excluded != window.excluded)?;
        choose(state, self.session, &window.name);
        Some(Edit::Window(WindowEdit::Exclude { name: window.name.clone(), excluded }))
    }
}

/// The candidate drawn at a time.
pub fn candidate_at<'a>(ctx: &PanelContext<'a>, view: View, time_s: f64) -> Option<&'a Manoeuvre> {
    if view != View::Flight {
        return None;
    }
    let flight = ctx.selection().flight.as_deref().unwrap_or_default();
    OfFlight { session: ctx.session, snapshot: ctx.snapshot, flight }.candidate_at(time_s)
}

/// Words on a ground beside the line at `x`, on the side that has room.
fn draw_label(ui: &Ui, frame: Rect, x: f32, below: f32, text: &str) {
    let ink = ui.visuals().strong_text_color();
    let galley = ui.painter().layout_no_wrap(text.to_owned(), FontId::proportional(11.0), ink);
    let size = galley.size() + vec2(8.0, 4.0);
    let left = (x + 2.0).min(frame.right() - size.x).max(frame.left());
    let ground = Rect::from_min_size(pos2(left, frame.top() + below), size);
    ui.painter().rect_filled(ground, CornerRadius::same(3), ui.visuals().extreme_bg_color);
    ui.painter().text(ground.center(), Align2::CENTER_CENTER, text, FontId::proportional(11.0), ink);
}

fn to_ms(time_s: f64) -> f64 {
    (1000.0 * time_s).round() / 1000.0
}

/// Marks what is left out in a figure of a view.
pub fn add(ctx: &PanelContext<'_>, view: View, figure: Figure) -> Figure {
    let excluded: Vec<TimeRange> = shown(ctx, view).flat_map(|window| window.excluded.iter().copied()).collect();
    figure.with_excluded(&excluded)
}

/// What a menu on manoeuvres is opened on.
#[derive(Clone, Copy)]
pub struct Spot<'a> {
    pub session: &'a Session,
    pub table: &'a [CommandInfo],
    pub window: Option<&'a Manoeuvre>,
    pub candidate: Option<&'a Manoeuvre>,
    /// Its time, where it has one, s.
    pub time_s: Option<f64>,
    /// Markers of the view.
    pub markers_s: [Option<f64>; 2],
}

/// The entries on manoeuvres of a menu; the command that was chosen.
pub fn menu(ui: &mut Ui, spot: &Spot<'_>) -> Option<UiCommand> {
    let mut chosen = None;
    let mut entry = |ui: &mut Ui, command: UiCommand, is_on: bool| {
        chosen = show_entry(ui, spot.table, command, is_on).or(chosen);
    };
    let (edit, mark) = (UiCommand::Edit, UiCommand::Mark);
    let between = match spot.markers_s {
        [Some(a), Some(b)] if a != b => Some(TimeRange::new(a, b)),
        _ => None,
    };
    if let Some(candidate) = spot.candidate {
        ui.weak(format!("Candidate {}", candidate.name));
        entry(ui, mark(MarkCommand::Accept), true);
        entry(ui, mark(MarkCommand::Refuse), true);
        ui.separator();
    }
    if let Some(window) = spot.window {
        ui.weak(&window.name);
        if let Some(time_s) = spot.time_s {
            let free = !window.flags.locked;
            let inside = window.window.start_s < time_s && time_s < window.window.end_s;
            entry(ui, mark(MarkCommand::StartHere), free && time_s < window.window.end_s);
            entry(ui, mark(MarkCommand::EndHere), free && time_s > window.window.start_s);
            entry(ui, mark(MarkCommand::Split), free && inside);
        }
        let excludes = between.is_some_and(|between| window.excluded_with(between).is_some());
        entry(ui, mark(MarkCommand::Exclude), excludes);
        entry(ui, mark(MarkCommand::Include), !window.excluded.is_empty());
        ui.menu_button("Use", |ui| {
            for role in WindowRole::ALL {
                entry(ui, edit(EditCommand::UseWindows(role)), true);
            }
        });
        ui.menu_button("Surface", |ui| {
            for surface in [None].into_iter().chain(Surface::ALL.map(Some)) {
                entry(ui, mark(MarkCommand::Surface(surface)), true);
            }
        });
        entry(ui, edit(EditCommand::RenameWindow), true);
        entry(ui, mark(MarkCommand::Note), true);
        entry(ui, mark(MarkCommand::Lock), true);
        entry(ui, edit(EditCommand::RemoveWindow), true);
        entry(ui, UiCommand::View(ViewCommand::ZoomToWindow), true);
        ui.menu_button("Open in", |ui| {
            entry(ui, UiCommand::View(ViewCommand::OpenWindow), true);
            for pane in
                [Pane::Manoeuvres, Pane::Reconstruction, Pane::Innovations, Pane::Fits, Pane::Derivatives, Pane::Replay]
            {
                entry(ui, UiCommand::View(ViewCommand::Show(pane)), true);
            }
        });
        ui.separator();
    }
    entry(ui, edit(EditCommand::AddWindow), between.is_some());
    entry(ui, mark(MarkCommand::NewShown), true);
    chosen
}

/// The command where its entry was chosen.
fn show_entry(ui: &mut Ui, table: &[CommandInfo], command: UiCommand, is_on: bool) -> Option<UiCommand> {
    let row = table.iter().find(|row| row.command == command)?;
    let mut button = ui.add_enabled(is_on, egui::Button::new(&row.name).shortcut_text(row.keys(ui.ctx())));
    if command == UiCommand::Mark(MarkCommand::Exclude) {
        button = button.on_hover_text(EXCLUDE_BY_DRAG).on_disabled_hover_text(EXCLUDE_BY_MARKERS);
    }
    button.clicked().then(|| {
        ui.close();
        command
    })
}

impl PanelContext<'_> {
    /// Carries out what was chosen in a menu: of all selected manoeuvres where its own is one of them, of its own else.
    pub fn follow_menu(&mut self, spot: &Spot<'_>, command: UiCommand) {
        if let Some(window) = spot.window.filter(|window| !self.selection().is_selected(&window.name)) {
            self.choose(&window.name);
        }
        self.state.at_s = spot.time_s;
        if let Some(candidate) = spot.candidate {
            self.state.candidate_s = Some(candidate.window.start_s);
        }
        self.commands.push(command);
    }
}
