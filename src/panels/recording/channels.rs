//! Role, source, unit, rate, range and shape of every channel, and the consistency of the channels.

use std::sync::Arc;

use doublet_core::quantity::Role;
use doublet_core::series::{Channel, Recording, Statistics, TimeRange};
use doublet_core::statistics::sample_rate_hz;
use doublet_engine::begin::{self, Missing};
use doublet_engine::stage::{LoadedFlight, PhysicsRow};
use doublet_engine::verdict::Level;
use eframe::egui::{self, Align, Label, Layout, Panel as Bar, RichText, ScrollArea, Sense, TextStyle, Ui, vec2};
use egui_extras::{Column, TableRow};

use crate::command::{UiCommand, ViewCommand};
use crate::panels::{Pane, Panel, PanelContext, chosen_flight, trouble};
use crate::widgets::curves::draw_contradiction;
use crate::widgets::grid::texts_grid;
use crate::widgets::level_mark::{channel_legend, channel_words, level_mark};
use crate::widgets::sparkline::Sparkline;
use crate::widgets::term::column_titles;
use crate::{notation, theme};

/// Height of a row and width of a sparkline.
const ROW: f32 = 22.0;
const SHAPE: f32 = 96.0;
/// Width of the table from which every role is named in full.
const WIDE: f32 = 720.0;
/// Points of a sparkline.
const POINTS: usize = 64;
/// Part of the height that the comparison has where something contradicts, and where nothing does.
const COMPARED: f32 = 0.4;
const AGREED: f32 = 54.0;
/// Height of a line on what is missing.
const LACK: f32 = 20.0;
/// What the button of a fix does.
const FIX: &str = "Summary applies the fix and shows the verdict before and after";

/// One channel as the table shows it.
struct Row {
    role: Role,
    source: String,
    rate_hz: f64,
    gaps: usize,
    statistics: Option<Statistics>,
    shape: Sparkline,
}

#[derive(Default)]
pub struct Channels {
    of: Option<Arc<LoadedFlight>>,
    rows: Vec<Row>,
}

impl Panel for Channels {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        if chosen_flight(ctx, ui).is_none() {
            return;
        }
        let name = ctx.selection().flight.clone().unwrap_or_default();
        let Some(loaded) = ctx.snapshot.flights.get(&name).and_then(|slot| slot.latest()) else { return };
        if !self.of.as_ref().is_some_and(|of| Arc::ptr_eq(of, loaded)) {
            self.rows = rows(&loaded.recording);
            self.of = Some(Arc::clone(loaded));
        }
        let physics = ctx.snapshot.physics.get(&name);
        trouble(ui, physics.and_then(|slot| slot.error()));
        let found = physics.and_then(|slot| slot.latest()).cloned();
        let contradictions: Vec<&PhysicsRow> = found.iter().flat_map(|found| found.contradictions()).collect();
        let lacks = lacks(&loaded.recording);
        let height = if contradictions.is_empty() {
            AGREED + LACK * lacks.len() as f32
        } else {
            COMPARED * ui.available_height()
        };
        Bar::bottom("channels compared").default_size(height).resizable(!contradictions.is_empty()).show(ui, |ui| {
            compared(ctx, ui, &lacks, (found.is_some(), &contradictions));
        });
        let level = |role: Role| {
            let rows = found.as_ref()?.rows.iter().filter(|row| row.channel == role.name());
            rows.map(|row| row.level).max()
        };
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| self.table(ctx, ui, level));
    }
}

impl Channels {
    fn table(&self, ctx: &PanelContext<'_>, ui: &mut Ui, level: impl Fn(Role) -> Option<Level>) {
        let role = if ui.available_width() >= WIDE { 136.0 } else { 100.0 };
        texts_grid(ui, "channels of a flight")
            .column(Column::exact(18.0))
            .column(Column::exact(role).clip(true))
            .column(Column::remainder().at_least(90.0).clip(true))
            .columns(Column::exact(70.0), 2)
            .column(Column::exact(56.0))
            .column(Column::exact(54.0))
            .column(Column::exact(SHAPE + 6.0))
            .header(20.0, |header| {
                column_titles(header, ["", "Role", "Channel", "Smallest", "Largest", "Unit", "Hz", "Shape"])
            })
            .body(|body| {
                body.rows(ROW, self.rows.len(), |mut line| {
                    let row = &self.rows[line.index()];
                    let verdict_level = level(row.role);
                    cells(ctx, &mut line, row, verdict_level);
                });
            });
    }
}

/// A name with its middle left out where there is no room for it: names of one file often differ in their last letters only.
fn shortened(ui: &mut Ui, name: &str) {
    let width = |text: String| {
        let font = TextStyle::Body.resolve(ui.style());
        ui.painter().layout_no_wrap(text, font, ui.visuals().text_color()).size().x
    };
    let letters: Vec<char> = name.chars().collect();
    let without = |kept: usize| {
        // Of a path the folders matter least.
        let head = if name.contains('/') { 0 } else { kept / 3 };
        letters[..head].iter().chain(&['…']).chain(&letters[letters.len() + head - kept..]).collect::<String>()
    };
    let room = ui.available_width();
    let is_whole = width(name.to_owned()) <= room;
    let kept =
        if is_whole { 0 } else { (0..letters.len()).rev().find(|&kept| width(without(kept)) <= room).unwrap_or(0) };
    let text = if is_whole { name.to_owned() } else { without(kept) };
    ui.add(Label::new(text).truncate()).on_hover_text(name);
}

/// A figure at the right of its cell.
fn figure(ui: &mut Ui, text: RichText) -> egui::Response {
    let text = text.font(theme::figures(ui));
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.label(text)).inner
}

fn cells(ctx: &PanelContext<'_>, line: &mut TableRow<'_, '_>, row: &Row, level: Option<Level>) {
    let (unit, scale) = ctx.state.units.of_role(row.role);
    line.col(|ui| {
        level_mark(ui, level).on_hover_text(format!("{}: {}", row.role.name(), channel_words(level)));
    });
    line.col(|ui| {
        let about = format!("{}: {}", row.role.name(), row.role.description());
        ui.add(Label::new(notation::role(row.role)).truncate()).on_hover_text(about);
    });
    line.col(|ui| {
        shortened(ui, &row.source);
    });
    for value in [row.statistics.map(|found| found.min), row.statistics.map(|found| found.max)] {
        line.col(|ui| {
            let text = value.map_or_else(|| "–".to_owned(), |value| notation::number(scale * value));
            figure(ui, RichText::new(text));
        });
    }
    line.col(|ui| {
        ui.weak(unit);
    });
    line.col(|ui| {
        let text = RichText::new(notation::number(row.rate_hz));
        let text = if row.gaps > 0 { text.color(theme::palette(ui).warning) } else { text };
        figure(ui, text).on_hover_text(match row.gaps {
            0 => "no gap".to_owned(),
            gaps => format!("{gaps} gaps"),
        });
    });
    line.col(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(SHAPE, ROW - 4.0), Sense::hover());
        row.shape.paint(ui, rect.shrink2(vec2(1.0, 2.0)), theme::palette(ui).series[0]);
        let about = row.statistics.map_or_else(
            || "no finite sample".to_owned(),
            |found| format!("mean {} {unit}, {} samples", notation::number(scale * found.mean), found.samples),
        );
        response.on_hover_text(about);
    });
}

/// Every role of the recording.
fn rows(recording: &Recording) -> Vec<Row> {
    let channels = recording.roles.iter().filter_map(|(role, index)| Some((*role, recording.channels.get(*index)?)));
    channels.map(|(role, channel)| Row::new(role, channel)).collect()
}

impl Row {
    fn new(role: Role, channel: &Channel) -> Self {
        let series = &channel.series;
        let whole = TimeRange { start_s: f64::NEG_INFINITY, end_s: f64::INFINITY };
        let shape = Sparkline::new(series, POINTS);
        Self {
            role,
            source: channel.full_name(),
            rate_hz: sample_rate_hz(&series.time_s).unwrap_or(0.0),
            gaps: shape.breaks(),
            statistics: series.statistics(whole),
            shape,
        }
    }
}

/// Roles that the results need and no channel has.
fn lacks(recording: &Recording) -> Vec<Missing> {
    let missing = begin::missing(|role| recording.role(role).is_some());
    missing.into_iter().filter(|lack| lack.level > Level::Good).collect()
}

/// What is missing and what contradicts, with the curves over each other.
fn compared(
    ctx: &mut PanelContext<'_>,
    ui: &mut Ui,
    lacks: &[Missing],
    (is_compared, contradictions): (bool, &[&PhysicsRow]),
) {
    ui.add_space(4.0);
    channel_legend(ui);
    for lack in lacks {
        let names: Vec<_> = lack.roles.iter().map(|role| notation::role(*role)).collect();
        let text = RichText::new(format!("{} {}", lack.means, names.join("  ")));
        ui.add(Label::new(text.color(theme::palette(ui).of_level(lack.level))).truncate());
    }
    if contradictions.is_empty() {
        ui.weak(if is_compared { "All channels are consistent." } else { "Comparing channels…" });
        return;
    }
    ScrollArea::vertical().id_salt("contradictions").auto_shrink(false).show(ui, |ui| {
        for (at, row) in contradictions.iter().enumerate() {
            ui.horizontal_top(|ui| {
                level_mark(ui, Some(row.level));
                draw_contradiction(ui, at, row, |ui| {
                    if row.change.is_some() && ui.small_button("Fix in Summary").on_hover_text(FIX).clicked() {
                        ctx.commands.push(UiCommand::View(ViewCommand::Show(Pane::Summary)));
                    }
                });
            });
        }
    });
}
