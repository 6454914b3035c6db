//! The whole recording: any channels in stacked plots, the manoeuvres as bands, missing channels.

use doublet_core::quantity::Role;
use doublet_core::series::{Channel, Recording, TimeRange};
use doublet_engine::begin;
use doublet_engine::session::{EXPRESSION_SOURCE, Edit, Manoeuvre, WindowEdit};
use doublet_engine::stage::LoadedFlight;
use doublet_engine::verdict::Level;
use eframe::egui::{self, DragAndDrop, Panel as Bar, Response, RichText, ScrollArea, TextEdit, Ui, vec2};

use crate::notation::{self, Units};
use crate::panels::marking::{self, Spot, new_window};
use crate::panels::signals::expressions::{self, Draft};
use crate::panels::{Panel, PanelContext, View, awaiting, empty, role_color, select, trouble};
use crate::theme;
use crate::widgets::matrix_view::shortened;
use crate::widgets::named_id;
use crate::widgets::snap::{SnapPoint, gap_edges};
use crate::widgets::span_editor::{LANE_HEIGHT, Lane, SpanEvent, SpanItem, body_id, span_lane};
use crate::widgets::time_plot::{PlotCache, SpanMark, TimePlot, Trace, step_markers, time_at};

/// Roles of the usual plots; of each inner list the first role the recording has is taken, all of them where `true`.
const USUAL: [(&[Role], bool); 6] = [
    (&[Role::Altitude, Role::GpsAltitude, Role::PositionDown], false),
    (&Role::AIRSPEEDS, false),
    (&[Role::AngleOfAttack, Role::PitchAngle, Role::BankAngle], true),
    (&[Role::RollRate, Role::PitchRate, Role::YawRate], true),
    (&[Role::Elevator, Role::Aileron, Role::Rudder], true),
    (&[Role::Power1, Role::Power2], true),
];

/// Least width of the panel in which the list of channels is shown unasked.
const LISTED: f32 = 740.0;

/// Longest name of a source as the title of its channels, characters.
const LONGEST_SOURCE: usize = 18;

/// A channel being dragged from the list onto a plot.
struct Carried(String);

/// Which parts share time with another one.
fn overlaps(parts: impl Iterator<Item = TimeRange>) -> Vec<bool> {
    let parts: Vec<TimeRange> = parts.collect();
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by(|a, b| parts[*a].start_s.total_cmp(&parts[*b].start_s));
    let mut found = vec![false; parts.len()];
    let mut last: Option<usize> = None;
    for at in order {
        if let Some(before) = last.filter(|before| parts[at].start_s < parts[*before].end_s) {
            (found[before], found[at]) = (true, true);
        }
        last = last.filter(|before| parts[*before].end_s > parts[at].end_s).or(Some(at));
    }
    found
}

/// What a pause over a manoeuvre in the bar says: its note, and the manoeuvres it overlaps.
fn note(ctx: &PanelContext<'_>, window: &Manoeuvre, is_shared: bool) -> String {
    if !is_shared {
        return window.note.clone();
    }
    let names = marking::overlapping(ctx.session, &window.flight, window.window, &window.name);
    let text = marking::overlap_text(&names).unwrap_or_default();
    format!("{}\n{} {text}", window.note, window.name).trim_start().to_owned()
}

#[derive(Default)]
pub struct Flight {
    cache: PlotCache,
    filter: String,
    draft: Option<Draft>,
    /// Whether the list of channels is shown; by the room there is unless somebody chose.
    listed: Option<bool>,
}

/// Name by which plots remember a channel: its role, or its source and name.
pub(crate) fn key(recording: &Recording, index: usize) -> String {
    match recording.roles.iter().find(|(_, at)| **at == index) {
        Some((role, _)) => role.name().to_owned(),
        None => recording.channels[index].full_name(),
    }
}

/// The channel remembered as `key`, with label, unit and factor from SI.
pub(crate) fn resolve<'a>(
    recording: &'a Recording,
    key: &str,
    units: Units,
) -> Option<(&'a Channel, &'a str, &'a str, f64)> {
    if let Some(role) = Role::from_name(key) {
        let (unit, scale) = units.of_role(role);
        return Some((recording.role(role)?, notation::role(role), unit, scale));
    }
    let (source, name) = key.rsplit_once('/')?;
    let channel = recording.channels.iter().find(|channel| channel.source == source && channel.name == name)?;
    Some((channel, &channel.name, &channel.unit, 1.0))
}

/// The plots shown before the user chose any.
fn usual(recording: &Recording) -> Vec<Vec<String>> {
    let plots = USUAL.iter().map(|(roles, all)| {
        let present = roles.iter().filter(|role| recording.role(**role).is_some());
        present.take(if *all { roles.len() } else { 1 }).map(|role| role.name().to_owned()).collect::<Vec<_>>()
    });
    plots.filter(|plot| !plot.is_empty()).collect()
}

impl Panel for Flight {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let slot = ctx.selection().flight.as_deref().and_then(|name| ctx.snapshot.flights.get(name));
        let Some(slot) = slot else {
            return empty(ui, "The session has no flight.");
        };
        trouble(ui, slot.error());
        let Some(loaded) = slot.latest() else {
            if slot.error().is_none() {
                awaiting(ctx, ui, "the recording", "The recording could not be read.");
            } else if let Some(flight) = ctx.selection().flight.clone() {
                expressions::mend(ctx, ui, &flight, &mut self.draft);
                expressions::dialog(ctx, ui, None, &mut self.draft, &mut Vec::new());
            }
            return;
        };
        let recording = &loaded.recording;
        let mut plots = ctx.state.flight_plots.clone().unwrap_or_else(|| usual(recording));
        let before = plots.clone();
        // Beside narrow plots the list of channels waits behind its button.
        let listed = self.listed.unwrap_or(ui.available_width() >= LISTED);
        if listed {
            Bar::left("channels").default_size(172.0).size_range(120.0..=260.0).show(ui, |ui| {
                self.channels(ctx, ui, loaded, &mut plots);
            });
        } else {
            Bar::left("channels folded").resizable(false).exact_size(22.0).show(ui, |ui| {
                let open = ui.add(egui::Button::new("▸").frame(false)).on_hover_text("Show the list of channels");
                ui.ctx().accesskit_node_builder(open.id, |node| node.set_label("show channels"));
                if open.clicked() {
                    self.listed = Some(true);
                }
            });
        }
        egui::CentralPanel::default()
            .frame(egui::Frame::new().inner_margin(egui::Margin { left: 6, ..Default::default() }))
            .show(ui, |ui| self.plots(ctx, ui, recording, &mut plots));
        expressions::dialog(ctx, ui, Some(loaded), &mut self.draft, &mut plots);
        plots.retain(|plot| !plot.is_empty());
        if plots != before {
            ctx.state.flight_plots = Some(plots);
        }
    }
}

impl Flight {
    /// The list of channels: tick to plot, drag onto a plot to add there.
    fn channels(
        &mut self,
        ctx: &mut PanelContext<'_>,
        ui: &mut Ui,
        loaded: &LoadedFlight,
        plots: &mut Vec<Vec<String>>,
    ) {
        let recording = &loaded.recording;
        flight_choice(ctx, ui);
        let flight = ctx.selection().flight.clone().unwrap_or_default();
        ui.horizontal(|ui| {
            let fold = ui.add(egui::Button::new("◂").frame(false)).on_hover_text("Hide the list of channels");
            ui.ctx().accesskit_node_builder(fold.id, |node| node.set_label("hide channels"));
            if fold.clicked() {
                self.listed = Some(false);
            }
            let new = ui.small_button("New channel…").on_hover_text("Channel computed from others");
            ui.ctx().accesskit_node_builder(new.id, |node| node.set_label("New channel by expression…"));
            if new.clicked() {
                self.draft = Some(Draft::new(&flight));
            }
        });
        let field =
            ui.add(TextEdit::singleline(&mut self.filter).hint_text("Filter channels").desired_width(f32::INFINITY));
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("Filter channels"));
        let wanted = self.filter.to_lowercase();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            missing(ui, recording);
            for (title, rows) in tree(recording, &wanted) {
                let count = rows.len();
                // Channels with a meaning are at hand, the rest of each recorder when asked for.
                let open = title == MEANT || title == EXPRESSION_SOURCE;
                // A header does not shorten its text by itself.
                let shown = shortened(title, LONGEST_SOURCE);
                egui::CollapsingHeader::new(format!("{shown} ({count})"))
                    .id_salt(title)
                    .default_open(open)
                    .open((!wanted.is_empty()).then_some(true))
                    .show(ui, |ui| {
                        for (index, key, role) in rows {
                            let channel = &recording.channels[index];
                            let label = role.map_or(channel.name.as_str(), |role| notation::role(role));
                            let row = channel_row(ui, (index, channel), role, label, key, plots);
                            if let Some(made) = loaded.expressions.iter().find(|made| made.channel == index) {
                                expressions::menu(ctx, &row, &flight, &made.setting, &mut self.draft);
                            }
                        }
                    });
            }
        });
    }

    /// The lane of windows and the plots.
    fn plots(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, recording: &Recording, plots: &mut Vec<Vec<String>>) {
        let (palette, area) = (theme::palette(ui), ui.max_rect());
        let resolved: Vec<Vec<_>> = plots
            .iter()
            .map(|keys| keys.iter().filter_map(|key| resolve(recording, key, ctx.state.units)).collect())
            .collect();
        let drawn: Vec<TimePlot<'_>> = resolved
            .iter()
            .map(|plot| {
                // Several traces are named in the legend.
                let label = if let [(_, label, ..)] = plot.as_slice() { *label } else { "" };
                let unit = plot.first().map_or("", |(_, _, unit, _)| *unit);
                let traces = plot.iter().enumerate().map(|(at, (channel, label, _, scale))| Trace {
                    scale: *scale,
                    ..Trace::new(label, &channel.series, palette.series[at % palette.series.len()])
                });
                TimePlot::new(label, unit, traces.collect())
            })
            .collect();
        let flight = ctx.selection().flight.clone().unwrap_or_default();
        let chosen = ctx.selection().window.clone();
        let windows: Vec<_> =
            ctx.session.windows.iter().enumerate().filter(|(_, window)| window.flight == flight).collect();
        let shared = overlaps(windows.iter().map(|(_, window)| window.window));
        let notes: Vec<String> =
            windows.iter().zip(&shared).map(|((_, window), shared)| note(ctx, window, *shared)).collect();
        let items: Vec<SpanItem<'_>> = windows
            .iter()
            .zip(notes.iter().zip(&shared))
            .map(|((at, window), (note, &overlaps))| SpanItem {
                id: *at as u64,
                part: TimeRange::new(window.window.start_s, window.window.end_s),
                label: &window.name,
                note,
                excluded: &window.excluded,
                color: role_color(palette, window.role),
                // Only the chosen one can be dragged: none is moved by accident where many lie close.
                still: chosen.as_deref() != Some(window.name.as_str()),
                locked: window.flags.locked,
                selected: ctx.selection().is_selected(&window.name),
                overlaps,
            })
            .collect();
        let marks: Vec<SpanMark> =
            items.iter().map(|item| SpanMark { part: item.part, color: item.color, selected: item.selected }).collect();
        let (_, rect) = ui.allocate_space(vec2(ui.available_width(), LANE_HEIGHT));
        let seen = ctx.stack(ui, "flight", View::Flight, &mut self.cache, &drawn, &marks);
        let samples_s = recording.role(Role::RollRate).map_or(&[][..], |channel| &channel.series.time_s);
        let range = ctx.state.time.range();
        // Only a drag asks for them.
        let points = if ui.ctx().dragged_id().is_some() { snap_points(ctx, &flight, recording) } else { Vec::new() };
        if let (Some(first), Some(last)) = (seen.frames.first(), seen.frames.last()) {
            let lane = Lane { rect, frame: *first, reach_bottom: last.bottom(), range, samples_s, points: &points };
            if let Some(event) = span_lane(ui, named_id(ui.ctx(), "windows"), &lane, &items) {
                let modifiers = ui.input(|input| input.modifiers);
                take(ctx, (&flight, modifiers), event);
            }
            for (at, window) in &windows {
                let body = body_id(named_id(ui.ctx(), "windows"), *at as u64);
                if let Some(response) = ui.ctx().read_response(body) {
                    lane_menu(ctx, &response, window, &lane);
                }
            }
        }
        if let Some(time_s) = seen.clicked_s
            && let Some(item) = items.iter().find(|item| item.part.contains(time_s))
        {
            ctx.choose(item.label);
        }
        // Without the pointer in any plot and with no widget focused the keys still mark.
        let is_free = ctx.state.time.cursor_s.is_none() && ui.memory(|memory| memory.focused().is_none());
        if seen.hovered_plot.is_some() || is_free {
            step_markers(ui, &mut ctx.state.time, samples_s);
        }
        let unit = |key: &str| resolve(recording, key, ctx.state.units).map(|(_, _, unit, _)| unit);
        drop_on(ui, area, &seen.frames, plots, unit);
        if plots.is_empty() {
            empty(ui, "Tick channels on the left to plot them.");
        }
    }
}

/// Moments an edge of the chosen window is drawn to: onset and end of the manoeuvres found, the markers, edges of the other windows
/// and of gaps. The onset is the last sample at which the control still rests.
fn snap_points(ctx: &PanelContext<'_>, flight: &str, recording: &Recording) -> Vec<SnapPoint> {
    let found = ctx.snapshot.proposals.get(flight).and_then(|slot| slot.latest());
    let found = found.iter().flat_map(|found| &found.windows);
    let mut points: Vec<SnapPoint> = found
        .flat_map(|found| [(found.onset_s, "onset"), (found.manoeuvre.window.end_s, "end")])
        .map(|(time_s, word)| SnapPoint { time_s, word })
        .collect();
    let markers = ctx.state.time.markers_s.into_iter().zip(["marker A", "marker B"]);
    points.extend(markers.filter_map(|(time_s, word)| Some(SnapPoint { time_s: time_s?, word })));
    let others =
        ctx.session.windows.iter().filter(|window| {
            window.flight == flight && ctx.selection().window.as_deref() != Some(window.name.as_str())
        });
    let edges = others.flat_map(|window| [window.window.start_s, window.window.end_s]);
    points.extend(edges.map(|time_s| SnapPoint { time_s, word: "manoeuvre" }));
    if let Some(channel) = recording.role(Role::RollRate) {
        let series = &channel.series;
        points.extend(gap_edges(&series.time_s, &series.values, ctx.state.time.range()));
    }
    points
}

/// Title of the branch of channels with a role.
const MEANT: &str = "Roles";

/// A title with its channels: index, key and role of each.
type Branch<'a> = (&'a str, Vec<(usize, String, Option<Role>)>);

/// Channels that hold `wanted`, in branches: those with a role, then the others by their source.
fn tree<'a>(recording: &'a Recording, wanted: &str) -> Vec<Branch<'a>> {
    let mut branches: Vec<Branch<'_>> = Vec::new();
    for (index, channel) in recording.channels.iter().enumerate() {
        let key = key(recording, index);
        let role = Role::from_name(&key);
        let about = role.map_or("", Role::description);
        let known = format!("{} {key} {} {} {about}", role.map_or("", notation::role), channel.name, channel.source);
        if !known.to_lowercase().contains(wanted) {
            continue;
        }
        let title = if role.is_some() { MEANT } else { channel.source.as_str() };
        match branches.iter_mut().find(|(other, _)| *other == title) {
            Some((_, rows)) => rows.push((index, key, role)),
            None => branches.push((title, vec![(index, key, role)])),
        }
    }
    branches
}

/// Which flight is shown, where there are several.
fn flight_choice(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let session = ctx.session;
    if session.flights.len() < 2 {
        return;
    }
    let chosen = ctx.selection().flight.clone().unwrap_or_default();
    let combo = egui::ComboBox::from_id_salt("flight").selected_text(&chosen).width(ui.available_width());
    let combo = combo.show_ui(ui, |ui| {
        for flight in &session.flights {
            if ui.selectable_label(flight.name == chosen, &flight.name).clicked() && flight.name != chosen {
                match session.windows.iter().find(|window| window.flight == flight.name) {
                    Some(window) => ctx.choose(&window.name),
                    None => ctx.state.selection.flight = Some(flight.name.clone()),
                }
            }
        }
    });
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("flight shown"));
}

/// One channel of the list; its tick and its name, as one.
fn channel_row(
    ui: &mut Ui,
    (index, channel): (usize, &Channel),
    role: Option<Role>,
    label: &str,
    key: String,
    plots: &mut Vec<Vec<String>>,
) -> Response {
    let was = plots.iter().any(|plot| plot.contains(&key));
    let mut on = was;
    let row = ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        let tick = ui.checkbox(&mut on, "");
        ui.ctx().accesskit_node_builder(tick.id, |node| node.set_label(format!("plot {key}")));
        let text = if role.is_some() { RichText::new(label) } else { RichText::new(label).weak() };
        let name = ui.dnd_drag_source(named_id(ui.ctx(), ("channel", index)), Carried(key.clone()), |ui| {
            ui.add(egui::Label::new(text).truncate().selectable(false))
        });
        let about = role.map_or("not mapped to a role", Role::description);
        let name = name.response.interact(egui::Sense::click()).on_hover_text(format!(
            "{about}\n{} · {} · {} samples",
            channel.source,
            channel.name,
            channel.series.values.len()
        ));
        // What is carried is drawn on a layer of its own.
        if tick.layer_id == name.layer_id { tick | name } else { tick }
    });
    if on && !was {
        plots.push(vec![key]);
    } else if was && !on {
        plots.iter_mut().for_each(|plot| plot.retain(|other| *other != key));
    }
    row.inner
}

/// Roles the recording does not have, with what that means.
fn missing(ui: &mut Ui, recording: &Recording) {
    for lack in begin::missing(|role| recording.role(role).is_some()) {
        let text = RichText::new(lack.means).size(11.0);
        let text = match lack.level {
            Level::Good => text.weak(),
            level => text.color(theme::palette(ui).of_level(level)),
        };
        ui.add(egui::Label::new(text).wrap());
        let names: Vec<_> = lack.roles.into_iter().map(notation::role).collect();
        ui.add(egui::Label::new(RichText::new(names.join("  ")).size(11.5)).wrap());
        ui.add_space(4.0);
    }
}

/// Turns what happened on the lane into edits and a choice.
fn take(ctx: &mut PanelContext<'_>, (flight, modifiers): (&str, egui::Modifiers), event: SpanEvent) {
    let session = ctx.session;
    match event {
        SpanEvent::Selected(id) => {
            if let Some(window) = session.windows.get(id as usize) {
                select(ctx.state, session, &window.name, modifiers);
            }
        }
        SpanEvent::Dragged { id, phase, part } => {
            if let Some(window) = session.windows.get(id as usize) {
                ctx.choose(&window.name);
                let place = part;
                ctx.edit_phase(phase, Edit::Window(WindowEdit::Place { name: window.name.clone(), window: place }));
            }
        }
        SpanEvent::Zoomed(part) => ctx.state.time.zoom_to(part),
        SpanEvent::Drawn(part) => {
            let window = new_window(session, flight.to_owned(), part);
            ctx.state.selection.window = Some(window.name.clone());
            ctx.edit(Edit::Window(WindowEdit::Add(window)));
        }
    }
}

fn lane_menu(ctx: &mut PanelContext<'_>, response: &Response, window: &Manoeuvre, lane: &Lane<'_>) {
    let id = response.id.with("menu at");
    if response.secondary_clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        response.ctx.data_mut(|data| data.insert_temp(id, time_at(lane.frame, lane.range, at.x)));
    }
    let time_s = response.ctx.data(|data| data.get_temp(id));
    let (session, table, markers_s) = (ctx.session, ctx.table, ctx.state.time.markers_s);
    let spot = Spot { session, table, window: session.window(&window.name), candidate: None, time_s, markers_s };
    let mut chosen = None;
    response.context_menu(|ui| chosen = marking::menu(ui, &spot));
    if let Some(command) = chosen {
        ctx.follow_menu(&spot, command);
    }
}

/// Puts a channel that was let go over a plot into it; over a plot of another unit it gets one of its own below that, and below the
/// last plot one at the end.
fn drop_on<'a>(
    ui: &Ui,
    area: egui::Rect,
    frames: &[egui::Rect],
    plots: &mut Vec<Vec<String>>,
    unit: impl Fn(&str) -> Option<&'a str>,
) {
    let Some(carried) = DragAndDrop::payload::<Carried>(ui.ctx()) else { return };
    let Some(at) = ui.input(|i| i.pointer.interact_pos()) else { return };
    if !area.contains(at) {
        return;
    }
    let row = frames.iter().position(|frame| frame.contains(at));
    let below = frames.last().map_or(area, |last| egui::Rect::from_min_max(last.left_bottom(), area.max));
    let own = unit(&carried.0);
    let fits = row.is_some_and(|row| plots[row].iter().all(|key| unit(key) == own));
    let target = match row {
        Some(row) if fits => frames[row],
        Some(row) => {
            egui::Rect::from_x_y_ranges(frames[row].x_range(), frames[row].bottom() - 3.0..=frames[row].bottom())
        }
        None if below.contains(at) => below,
        None => return,
    };
    if row.is_some() && !fits {
        let text = format!("[{}] differs: opens a new plot", own.unwrap_or_default());
        egui::Tooltip::always_open(
            ui.ctx().clone(),
            ui.layer_id(),
            named_id(ui.ctx(), "another unit"),
            egui::PopupAnchor::Pointer,
        )
        .show(|ui| ui.label(text));
    }
    let accent = theme::palette(ui).accent;
    ui.painter().rect_stroke(target, 3.0, egui::Stroke::new(2.0, accent), egui::StrokeKind::Inside);
    if ui.input(|i| i.pointer.any_released()) {
        plots.iter_mut().for_each(|plot| plot.retain(|key| *key != carried.0));
        match row {
            Some(row) if fits => plots[row].push(carried.0.clone()),
            Some(row) => plots.insert(row + 1, vec![carried.0.clone()]),
            None => plots.push(vec![carried.0.clone()]),
        }
        DragAndDrop::clear_payload(ui.ctx());
    }
}
