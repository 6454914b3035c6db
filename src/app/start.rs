//! The start page: sessions opened last, what a new session is made of, the flights that come with the program, the tour.

use std::collections::BTreeMap;
use std::path::PathBuf;

use doublet_engine::{builtin, date, session};
use eframe::egui::text::LayoutJob;
use eframe::egui::{
    self, Button, Color32, CornerRadius, FontId, Label, Rect, RichText, Role, ScrollArea, Sense, Stroke, StrokeKind,
    Ui, WidgetInfo, pos2, vec2,
};

use super::{Document, Workbench, public, timeline};
use crate::command::{FileCommand, HelpCommand, UiCommand};
use crate::panels::headline;
use crate::ui_state::Thumbnail;
use crate::{notation, theme};

/// Size of a card, and height of its picture.
const CARD: egui::Vec2 = vec2(300.0, 176.0);
const PICTURE: f32 = 66.0;
/// Letters of a path shown at most: its end, where sessions of one name differ.
const PATH: usize = 44;
/// What the shipped sessions look like, as their verdicts were when the program was built.
const SHIPPED: &str = include_str!("shipped_flights.json");
/// What the shipped sessions teach.
const LESSONS: [(&str, &str); 2] = [
    ("demo", "Complete analysis: filter, model and one estimate from all manoeuvres."),
    ("demo_thesis", "As in the thesis: scatter of single-manoeuvre estimates, without a smoother."),
];
/// Width of the column with what can be begun.
const ACTIONS: f32 = 260.0;
/// Points of the altitude in a thumbnail.
const POINTS: usize = 90;

/// What the page has found out once.
#[derive(Default)]
pub(super) struct StartPage {
    /// Name and title of the sessions that come with the program.
    shipped: Vec<(&'static str, String)>,
    /// Their pictures by name.
    pictures: BTreeMap<String, Thumbnail>,
}

/// A session on the page.
struct Card<'a> {
    name: String,
    about: String,
    /// Below the verdict: where it is and when it was open, or what it teaches.
    foot: String,
    thumbnail: Option<&'a Thumbnail>,
    command: FileCommand,
}

impl Workbench {
    /// Whether the start page is on screen.
    pub fn is_on_start_page(&self) -> bool {
        self.start_shown || self.document.session().flights.is_empty()
    }

    /// A session without a flight: the window begins with the start page.
    pub fn nothing_open() -> Document {
        let mut document = Document::start(doublet_engine::begin::empty_session("", None));
        document.history.mark_saved();
        document
    }

    /// Keeps what the session on screen looks like, for the start page of the next time; not with edits that no file holds.
    pub(super) fn keep_thumbnail(&mut self) {
        if self.document.history.is_modified() {
            return;
        }
        let key = match (&self.document.path, self.document.shipped) {
            (Some(path), _) => path.canonicalize().unwrap_or_else(|_| path.clone()),
            (None, Some(name)) => PathBuf::from(format!("{}{name}", builtin::PREFIX)),
            (None, None) => return,
        };
        let session = self.document.session();
        let Some(flight) = session.flights.first() else { return };
        let loaded = self.snapshot.flights.get(&flight.name).and_then(|slot| slot.latest());
        let Some(line) = loaded.and_then(|loaded| timeline::altitude(&loaded.recording, POINTS)) else { return };
        let (Some(first), Some(last), Some((low, high))) = (line.points.first(), line.points.last(), line.extent)
        else {
            return;
        };
        let (start_s, length_s) = (first.0, (last.0 - first.0).max(1e-9));
        let along = |time_s: f64| ((time_s - start_s) / length_s) as f32;
        let up = |value: f64| ((value - low) / (high - low).max(1e-9)) as f32;
        let verdicts = self.snapshot.verdicts.latest();
        let windows = session.windows.iter().filter(|window| window.flight == flight.name);
        let thumbnail = Thumbnail {
            title: session.title.clone(),
            opened: date::today(),
            verdict: verdicts.map_or_else(String::new, |verdicts| headline(session, verdicts)),
            altitude: line.points.iter().map(|point| [along(point.0), up(point.1)]).collect(),
            windows: windows.map(|window| [along(window.window.start_s), along(window.window.end_s)]).collect(),
        };
        self.state.thumbnails.insert(key, thumbnail);
    }
}

/// Draws the page.
pub(super) fn show(app: &mut Workbench, ui: &mut Ui) {
    if app.start.shipped.is_empty() {
        let title = |name: &&'static str| session::parse(builtin::session(name)?).ok().map(|session| session.title);
        app.start.pictures = serde_json::from_str(SHIPPED).unwrap_or_default();
        app.start.shipped = builtin::sessions().into_iter().filter_map(|name| Some((name, title(&name)?))).collect();
    }
    let mut wanted = None;
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let room = ui.available_width();
        let width = room.min(ACTIONS + 24.0 + 3.0 * (CARD.x + 12.0));
        ui.horizontal_top(|ui| {
            ui.add_space(0.5 * (room - width).max(0.0) + 8.0);
            ui.vertical(|ui| {
                ui.set_width(ACTIONS);
                wanted = actions(app, ui);
            });
            ui.add_space(24.0);
            ui.vertical(|ui| {
                ui.set_width((width - ACTIONS - 48.0).max(CARD.x));
                wanted = cards(app, ui).or(wanted.take());
            });
        });
    });
    app.commands.extend(wanted);
}

/// What can be begun.
fn actions(app: &Workbench, ui: &mut Ui) -> Option<UiCommand> {
    let mut wanted = None;
    ui.add_space(28.0);
    ui.label(RichText::new("doublet").size(30.0).strong());
    ui.weak("Aerodynamic derivatives from flight test");
    ui.add_space(18.0);
    let rows = [
        ("New session from recording…", "One or several files of one flight", UiCommand::File(FileCommand::New)),
        (
            "New session from folder of CSV files…",
            "One file per channel or recorder",
            UiCommand::File(FileCommand::NewFromFolder),
        ),
        ("Open session…", "A session file of doublet", UiCommand::File(FileCommand::Open)),
        (
            "Five-minute tour",
            "From recording to report on the shipped flight, with the real controls",
            UiCommand::Help(HelpCommand::Tour),
        ),
        ("Keyboard shortcuts", "Keys and mouse gestures", UiCommand::Help(HelpCommand::Shortcuts)),
    ];
    for (name, about, command) in rows {
        if ui.add_sized(vec2(ACTIONS, 30.0), Button::new(name)).on_hover_text(about).clicked() {
            wanted = Some(command);
        }
    }
    if let Some(name) = app.draft_name() {
        ui.add_space(10.0);
        if ui.link(format!("Continue the new session {name} ▸")).clicked() {
            wanted = Some(UiCommand::File(FileCommand::ContinueNew));
        }
    }
    ui.add_space(10.0);
    ui.add(Label::new(RichText::new("Or drop a recording or a session file on this window.").weak()).wrap());
    if !app.document.session().flights.is_empty() {
        ui.add_space(10.0);
        if ui.link(format!("Back to {} ▸", app.document.session().title)).clicked() {
            wanted = Some(UiCommand::View(crate::command::ViewCommand::Workbench));
        }
    }
    wanted
}

/// Sessions opened last, and those that come with the program.
fn cards(app: &Workbench, ui: &mut Ui) -> Option<UiCommand> {
    let mut wanted = None;
    let thumbnails = &app.state.thumbnails;
    let recent: Vec<Card<'_>> = app
        .state
        .recent
        .iter()
        .enumerate()
        .map(|(at, path)| Card {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            about: path.display().to_string(),
            foot: {
                let opened = thumbnails.get(path).map_or("", |thumbnail| thumbnail.opened.as_str());
                let day = if opened.is_empty() { String::new() } else { format!("opened {opened}\n") };
                format!("{day}{}", end_of(&path.display().to_string()))
            },
            thumbnail: thumbnails.get(path),
            command: FileCommand::OpenRecent(at),
        })
        .collect();
    let shipped: Vec<Card<'_>> = app
        .start
        .shipped
        .iter()
        .map(|(name, title)| Card {
            name: title.clone(),
            about: "shipped session; save it under a name to keep changes".to_owned(),
            foot: LESSONS.iter().find(|(of, _)| of == name).map_or("", |(_, lesson)| lesson).to_owned(),
            thumbnail: thumbnails
                .get(&PathBuf::from(format!("{}{name}", builtin::PREFIX)))
                .or_else(|| app.start.pictures.get(*name)),
            command: FileCommand::OpenShippedSession(name),
        })
        .collect();
    for (title, cards, nothing) in [
        ("Sessions opened last", recent, "None yet. Opened and saved sessions appear here."),
        ("Shipped flights", shipped, ""),
    ] {
        ui.add_space(28.0);
        ui.heading(title);
        ui.add_space(4.0);
        if cards.is_empty() {
            ui.weak(nothing);
        }
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = vec2(12.0, 12.0);
            for one in &cards {
                if card(ui, one) {
                    wanted = Some(UiCommand::File(one.command));
                }
            }
        });
    }
    ui.add_space(28.0);
    ui.heading("A real flight");
    ui.add_space(4.0);
    ui.strong(public::TITLE);
    ui.add(Label::new(RichText::new(public::ABOUT).weak()).wrap());
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        if ui.button("Open the page of the files").on_hover_text(public::PAGE).clicked() {
            ui.ctx().open_url(egui::OpenUrl::new_tab(public::PAGE));
        }
        if ui.button("Choose its files…").clicked() {
            wanted = Some(UiCommand::File(FileCommand::OpenPublic));
        }
    });
    wanted
}

/// One session; whether it was clicked.
fn card(ui: &mut Ui, card: &Card<'_>) -> bool {
    let (rect, response) = ui.allocate_exact_size(CARD, Sense::click());
    let palette = theme::palette(ui);
    let edge = match (response.has_focus(), response.hovered()) {
        (true, _) => Stroke::new(2.0, palette.accent),
        (false, true) => Stroke::new(1.0, palette.accent),
        (false, false) => Stroke::new(1.0, palette.grid),
    };
    let painter = ui.painter_at(rect);
    painter.rect(rect, CornerRadius::same(6), ui.visuals().faint_bg_color, edge, StrokeKind::Inside);
    let picture = Rect::from_min_max(rect.min + vec2(8.0, 8.0), pos2(rect.right() - 8.0, rect.top() + 8.0 + PICTURE));
    painter.rect_filled(picture, 3.0, palette.plot_background);
    if let Some(thumbnail) = card.thumbnail {
        draw_thumbnail(&painter, picture, thumbnail, [palette.series[0], palette.accent]);
    }
    let verdict = card.thumbnail.map_or("not opened yet", |thumbnail| thumbnail.verdict.as_str());
    let name = card.thumbnail.map_or(card.name.as_str(), |thumbnail| thumbnail.title.as_str());
    let below = Rect::from_min_max(pos2(rect.left() + 8.0, picture.bottom() + 6.0), rect.max - vec2(8.0, 4.0));
    let layout = egui::Layout::top_down(egui::Align::LEFT);
    let mut lines = ui.new_child(egui::UiBuilder::new().max_rect(below).layout(layout));
    lines.spacing_mut().item_spacing.y = 1.0;
    lines.spacing_mut().item_spacing.y = 3.0;
    let (strong, ink, weak) =
        (ui.visuals().strong_text_color(), ui.visuals().text_color(), ui.visuals().weak_text_color());
    let plain =
        |text: &str, size: f32, color| LayoutJob::simple(text.to_owned(), FontId::proportional(size), color, 0.0);
    let judged = notation::typeset_in(verdict, 11.0, ink);
    for mut job in [plain(name, 13.0, strong), judged, plain(&card.foot, 11.0, weak)] {
        (job.wrap.max_width, job.wrap.max_rows) = (below.width(), 2);
        lines.add(Label::new(job).selectable(false));
    }
    let label = format!("open {}", card.name);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &label));
    let response = response.on_hover_cursor(egui::CursorIcon::PointingHand);
    response.on_hover_text(format!("{name}\n{verdict}\n{}", card.about)).clicked()
}

/// The end of a path, behind an ellipsis where it is longer.
fn end_of(path: &str) -> String {
    let count = path.chars().count();
    if count <= PATH {
        path.to_owned()
    } else {
        format!("…{}", path.chars().skip(count - PATH + 1).collect::<String>())
    }
}

fn draw_thumbnail(painter: &egui::Painter, rect: Rect, thumbnail: &Thumbnail, [line, block]: [Color32; 2]) {
    let x = |along: f32| rect.left() + rect.width() * along.clamp(0.0, 1.0);
    for &[start, end] in &thumbnail.windows {
        let block_rect =
            Rect::from_x_y_ranges(x(start)..=x(end).max(x(start) + 1.5), rect.bottom() - 7.0..=rect.bottom() - 2.0);
        painter.rect_filled(block_rect, 0.0, block.gamma_multiply(0.8));
    }
    let upper = rect.height() - 14.0;
    let points = thumbnail.altitude.iter().map(|&[along, up]| pos2(x(along), rect.top() + 4.0 + upper * (1.0 - up)));
    painter.line(points.collect(), Stroke::new(1.2, line));
}
