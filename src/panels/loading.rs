//! What is on board: fuel, seats and luggage; mass, centre of gravity and inertia that follow.

use std::collections::BTreeMap;

use doublet_core::airframe::{Aircraft, LoadedState, Loading};
use doublet_engine::session::{Edit, LoadingEdit};
use eframe::egui::{self, Grid, Id, RichText, ScrollArea, Slider, Ui};
use egui_plot::{Plot, PlotPoint, PlotPoints, Points, Polygon};

use super::{EditRequest, Panel, PanelContext, caption, empty, trouble};
use crate::notation;
use crate::theme;

/// Largest mass of a place that states none, kg.
const USUAL_CAPACITY_KG: f64 = 150.0;

/// The panel.
pub struct LoadingPanel;

/// A kind of place and the masses in it.
type Masses = fn(&mut Loading) -> &mut BTreeMap<String, f64>;

/// Title of a kind of place, its places with their capacity in kg, and where their masses are.
type Group<'a> = (&'static str, Vec<(&'a str, Option<f64>)>, Masses);

impl Panel for LoadingPanel {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let snapshot = ctx.snapshot;
        trouble(ui, snapshot.aircraft.error());
        let (Some(read), Some(loaded)) = (snapshot.aircraft.latest(), snapshot.loaded.latest()) else {
            return empty(ui, "The aircraft is not read yet.");
        };
        let aircraft = &read.aircraft;
        let loading = ctx.session.loading.clone().unwrap_or_else(|| aircraft.standard_loading.clone());
        ui.columns(2, |columns| {
            ScrollArea::vertical().id_salt("places").auto_shrink(false).show(&mut columns[0], |ui| {
                ui.label(RichText::new(&aircraft.name).strong());
                places(ctx, ui, aircraft, &loading);
                let standard = ui.add_enabled(ctx.session.loading.is_some(), egui::Button::new("Standard loading"));
                if standard.clicked() {
                    ctx.edit(Edit::Loading(LoadingEdit::Standard));
                }
            });
            let ui = &mut columns[1];
            if snapshot.loaded.is_stale() {
                ui.multiply_opacity(0.45);
            }
            numbers(ui, loaded);
            envelope(ui, aircraft, loaded);
        });
    }
}

/// A slider for every tank, seat and bay.
fn places(ctx: &mut PanelContext<'_>, ui: &mut Ui, aircraft: &Aircraft, loading: &Loading) {
    let tanks = aircraft.tanks.iter().map(|tank| (tank.name.as_str(), Some(tank.capacity_kg))).collect::<Vec<_>>();
    let seats = aircraft.seats.iter().map(|seat| (seat.name.as_str(), seat.capacity_kg)).collect::<Vec<_>>();
    let bays = aircraft.luggage.iter().map(|bay| (bay.name.as_str(), bay.capacity_kg)).collect::<Vec<_>>();
    let groups: [Group<'_>; 3] = [
        ("Fuel", tanks, |loading| &mut loading.fuel_kg),
        ("Seats", seats, |loading| &mut loading.seats_kg),
        ("Luggage", bays, |loading| &mut loading.luggage_kg),
    ];
    for (title, places, masses) in groups {
        if places.is_empty() {
            continue;
        }
        caption(ui, title);
        Grid::new(title).num_columns(2).spacing([8.0, 3.0]).show(ui, |ui| {
            for (name, capacity) in places {
                ui.label(name.replace('_', " "));
                place(ctx, ui, loading, (title, name, capacity), masses);
                ui.end_row();
            }
        });
        ui.add_space(4.0);
    }
    if aircraft.tanks.is_empty() && aircraft.seats.is_empty() && aircraft.luggage.is_empty() {
        ui.weak("The file of this aircraft states no tanks, seats or bays.");
    }
}

/// One slider; a drag is one step of undo.
fn place(
    ctx: &mut PanelContext<'_>,
    ui: &mut Ui,
    loading: &Loading,
    (title, name, capacity): (&str, &str, Option<f64>),
    masses: Masses,
) {
    let mut changed = loading.clone();
    let mass = masses(&mut changed).entry(name.to_owned()).or_insert(0.0);
    let slider = Slider::new(mass, 0.0..=capacity.unwrap_or(USUAL_CAPACITY_KG)).suffix(" kg").fixed_decimals(1);
    ui.spacing_mut().slider_width = 120.0;
    let response = ui.add(slider);
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(format!("{title} {name}")));
    if response.drag_started() {
        ctx.edits.push(EditRequest::Begin(format!("change {} {name}", title.to_lowercase())));
    }
    if response.changed() {
        ctx.edit(Edit::Loading(LoadingEdit::All(changed)));
    }
    if response.drag_stopped() {
        ctx.edits.push(EditRequest::Commit);
    }
}

/// Mass, centre of gravity, inertia and what is wrong with them.
fn numbers(ui: &mut Ui, loaded: &LoadedState) {
    let properties = &loaded.properties;
    let [x, y, z] = properties.cg_from_datum_m;
    let inertia = &properties.inertia;
    let mut rows = vec![
        ("Mass", format!("{} kg", notation::fixed(properties.mass_kg, 1))),
        (
            "CG aft, right, up",
            format!("{}, {}, {} m", notation::fixed(x, 3), notation::fixed(y, 3), notation::fixed(z, 3)),
        ),
        (
            "Ixx, Iyy, Izz",
            format!(
                "{}, {}, {} kg m²",
                notation::fixed(inertia.xx, 0),
                notation::fixed(inertia.yy, 0),
                notation::fixed(inertia.zz, 0)
            ),
        ),
        ("Ixz", format!("{} kg m²", notation::fixed(inertia.xz, 0))),
    ];
    if let Some(fraction) = loaded.mean_chord_fraction {
        rows.insert(2, ("CG on the chord", format!("{} % MAC", notation::fixed(100.0 * fraction, 1))));
    }
    Grid::new("loaded").num_columns(2).spacing([10.0, 3.0]).show(ui, |ui| {
        for (name, value) in rows {
            ui.weak(name);
            ui.label(RichText::new(value).font(theme::figures(ui)));
            ui.end_row();
        }
    });
    let palette = theme::palette(ui);
    for warning in &properties.warnings {
        ui.add(egui::Label::new(RichText::new(format!("⚠ {warning}")).color(palette.warning)).wrap());
    }
}

/// The envelope with the point of this loading.
fn envelope(ui: &mut Ui, aircraft: &Aircraft, loaded: &LoadedState) {
    let palette = theme::palette(ui);
    let Some(envelope) = &aircraft.envelope else {
        ui.weak("The file of this aircraft states no envelope.");
        return;
    };
    let corners: Vec<PlotPoint> = envelope.outline().into_iter().map(|(x_m, kg)| PlotPoint::new(x_m, kg)).collect();
    let (x_m, mass_kg) = (loaded.properties.cg_from_datum_m[0], loaded.properties.mass_kg);
    let inside = loaded.envelope.is_some_and(|margin| margin.inside());
    let color = if inside { palette.good } else { palette.error };
    let text = ui.visuals().weak_text_color();
    Plot::new(Id::unique("envelope"))
        .height(ui.available_height().max(120.0))
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .show_x(false)
        .show_y(false)
        .grid_color(palette.grid)
        .set_margin_fraction(egui::vec2(0.12, 0.12))
        .label_formatter(|_| None)
        .custom_x_axes(vec![egui_plot::AxisHints::new_x().label("CG aft of the datum [m]").tick_label_color(text)])
        .custom_y_axes(vec![egui_plot::AxisHints::new_y().label("mass [kg]").tick_label_color(text)])
        .show(ui, |plot| {
            let outline = Polygon::new("", PlotPoints::Borrowed(&corners));
            plot.polygon(
                outline
                    .fill_color(palette.accent.gamma_multiply(0.12))
                    .stroke(egui::Stroke::new(1.5, palette.accent))
                    .allow_hover(false),
            );
            plot.points(Points::new("", vec![[x_m, mass_kg]]).radius(5.0).color(color).allow_hover(false));
        });
}
