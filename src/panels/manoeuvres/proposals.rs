//! Manoeuvres found in the control deflections, to be taken one by one or all, and the curves of pictures of manoeuvres.

use doublet_core::quantity::Role;
use doublet_core::series::Series;
use doublet_engine::report::document::{Axis, Colour, Figure, LineStyle, Mark, Panel, Plot};
use doublet_engine::session::{CandidateEdit, Edit, Manoeuvre, Surface, WindowEdit};
use doublet_engine::stage::{Candidate, FlightProposals, find_candidates};
use eframe::egui::{self, CollapsingHeader, Grid, Response, ScrollArea, Ui, vec2};

use crate::notation;
use crate::panels::manoeuvres::manoeuvre_list::menu;
use crate::panels::{PanelContext, View};
use crate::widgets::chart::figure_entries;
use crate::widgets::figure::{FigureForm, FigureRequest};
use crate::widgets::hatch::hatch;
use crate::widgets::time_view::TimeRange;

/// Height of a panel of its figure, mm.
const PANEL_MM: f64 = 45.0;
/// Most points of a curve of a picture.
const MOST: usize = 132;

/// The windows the chosen flight proposes and the session does not have.
pub fn proposals(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let name = ctx.selection().flight.clone().unwrap_or_default();
    let Some(found) = ctx.snapshot.proposals.get(&name).and_then(|slot| slot.latest()) else { return };
    let (open, refused) = open_and_refused(ctx, found);
    let header = match (open.len(), refused.len(), found.windows.len()) {
        (_, _, 0) => "No manoeuvre found in the control deflections".to_owned(),
        (0, 0, all) => format!("All {all} manoeuvres found are in the session"),
        (open, 0, all) => format!("Manoeuvres found: {all}, not in the session: {open}"),
        (open, refused, all) => format!("Manoeuvres found: {all}, not in the session: {open}, refused: {refused}"),
    };
    if open.is_empty() && refused.is_empty() && found.findings.is_empty() {
        if found.windows.is_empty() {
            ui.weak(header);
        }
        return;
    }
    CollapsingHeader::new(header).id_salt("proposals").default_open(false).show(ui, |ui| {
        found.findings.iter().for_each(|finding| drop(ui.weak(finding)));
        draw_refused(ctx, ui, &name, &refused);
        if open.is_empty() {
            return;
        }
        if ui.button(format!("Accept all {}", open.len())).clicked() {
            let all = open.iter().map(|(window, _)| window.clone()).collect();
            ctx.edit(Edit::Window(WindowEdit::AddAll(all)));
        }
        ScrollArea::vertical().id_salt("proposed").max_height(170.0).show(ui, |ui| {
            Grid::new("proposed").num_columns(4).striped(true).spacing([12.0, 2.0]).show(ui, |ui| {
                for (window, proposal) in &open {
                    if ui.link(&window.name).on_hover_text("Show it").clicked() {
                        let part = TimeRange::new(window.window.start_s, window.window.end_s);
                        ctx.view(View::Flight).zoom_to(part);
                    }
                    let (start, end) = (window.window.start_s, window.window.end_s);
                    ui.weak(format!("{} s to {} s", notation::fixed(start, 2), notation::fixed(end, 2)));
                    let amplitude = notation::fixed(proposal.amplitude_rad.to_degrees(), 1);
                    let text = format!("{:.0} %", 100.0 * proposal.confidence);
                    ui.label(text).on_hover_text(format!(
                        "how near the shape is to the ideal; {amplitude}°, shortest pulse {} s",
                        notation::fixed(proposal.base_time_s, 2)
                    ));
                    let accept = ui.small_button("Accept");
                    let label = format!("accept {}", window.name);
                    ui.ctx().accesskit_node_builder(accept.id, |node| node.set_label(label.as_str()));
                    if accept.clicked() {
                        ctx.edit(Edit::Window(WindowEdit::Add(window.clone())));
                    }
                    ui.end_row();
                }
            });
        });
    });
}

/// The candidates of a flight that are neither in the session nor refused, and those that were refused.
fn open_and_refused<'a>(
    ctx: &PanelContext<'_>,
    found: &'a FlightProposals,
) -> (Vec<Candidate<'a>>, Vec<Candidate<'a>>) {
    find_candidates(ctx.session, found).into_iter().partition(|(window, _)| !ctx.session.has_refused(window))
}

/// The refused candidates of a flight, and the way to offer them again.
fn draw_refused(ctx: &mut PanelContext<'_>, ui: &mut Ui, flight: &str, refused: &[Candidate<'_>]) {
    if refused.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        let names: Vec<&str> = refused.iter().map(|(window, _)| window.name.as_str()).collect();
        ui.weak(format!("{} refused", refused.len())).on_hover_text(names.join("\n"));
        if ui.small_button("Offer again").on_hover_text("Shows the refused candidates of this flight again").clicked() {
            ctx.edit(Edit::Candidate(CandidateEdit::Offer(Some(flight.to_owned()))));
        }
    });
}

/// Control and rate a manoeuvre shows most in.
pub(crate) fn roles(surface: Option<Surface>) -> [Role; 2] {
    let surface = surface.unwrap_or(Surface::Elevator);
    [surface.role(), surface.rate()]
}

/// The menu of a picture of a window: that of the manoeuvre, and the picture as a figure.
pub(crate) fn picture_menu(ctx: &mut PanelContext<'_>, response: &Response, window: &Manoeuvre) {
    let mut form = None;
    response.context_menu(|ui| {
        menu(ctx, ui, window);
        ui.separator();
        form = figure_entries(ui);
    });
    let figure = form.and_then(|form| figure_of(ctx, form, window));
    ctx.figures.extend(figure);
}

/// The curves of a picture of a window as a figure, each over its own axis.
fn figure_of(ctx: &PanelContext<'_>, form: FigureForm, window: &Manoeuvre) -> Option<FigureRequest> {
    let loaded = ctx.snapshot.flights.get(&window.flight).and_then(|slot| slot.latest())?;
    let x = Axis { range: Some([window.window.start_s, window.window.end_s]), ..Axis::time() };
    let panel = |(at, role): (usize, Role)| {
        let series = loaded.recording.role(role)?.series.clone();
        let (unit, scale) = ctx.state.units.of_role(role);
        let (label, colour) = (notation::role(role).into(), Colour::PALETTE[at]);
        let line = Mark::Line { label, colour, style: LineStyle::Solid, series, scale };
        Some(Panel::Plot(Plot { x: x.clone(), y: Axis::new(notation::role(role), unit), marks: vec![line] }))
    };
    let figure = Figure::new(
        format!("manoeuvre_{}", window.name.replace(' ', "_")),
        format!("manoeuvre {}", window.name),
        (1, PANEL_MM),
        roles(window.surface).into_iter().enumerate().filter_map(panel).collect(),
    );
    Some(FigureRequest { figure: figure.with_excluded(&window.excluded), form })
}

/// Hatches the excluded parts of a manoeuvre in a picture of it, which `rect` is as wide as.
pub(crate) fn hatch_excluded(ui: &Ui, window: &Manoeuvre, rect: egui::Rect) {
    let length_s = window.window.length_s();
    let x = |time_s: f64| rect.left() + rect.width() * ((time_s - window.window.start_s) / length_s) as f32;
    for part in &window.excluded {
        hatch(ui, egui::Rect::from_x_y_ranges(x(part.start_s)..=x(part.end_s), rect.y_range()).intersect(rect));
    }
}

/// A series over a window, stretched to a rectangle.
pub(crate) fn curve(series: &Series, window: &Manoeuvre, rect: egui::Rect) -> Vec<egui::Pos2> {
    let inside = window.window.indices(&series.time_s);
    let values = &series.values[inside.clone()];
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let length = window.window.end_s - window.window.start_s;
    let step = values.len().div_ceil(MOST).max(1);
    let points = series.time_s[inside].iter().zip(values).step_by(step).filter(|(_, value)| value.is_finite());
    points
        .map(|(time, value)| {
            let x = ((time - window.window.start_s) / length) as f32;
            let y = ((high - value) / (high - low).max(1e-12)) as f32;
            rect.left_top() + vec2(x * rect.width(), y * rect.height())
        })
        .collect()
}
