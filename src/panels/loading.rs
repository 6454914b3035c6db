//! What is on board: fuel, seats and luggage; mass, centre of gravity and inertia that follow.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::airframe::{Aircraft, LoadedState, Loading};
use doublet_core::quantity::Dimension;
use doublet_engine::session::{Edit, LoadingEdit, WindowRole};
use doublet_engine::stage::{PooledFits, loading_on_board};
use eframe::egui::{self, Grid, RichText, ScrollArea, Slider, Ui};
use egui_extras::{Column, TableBuilder};

use super::intervals::estimate;
use super::{EditRequest, Panel, PanelContext, awaiting, caption, choices, is_window_constant, role_color, trouble};
use crate::notation;
use crate::theme;
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};

/// Largest mass of a place that states none, kg.
const USUAL_CAPACITY_KG: f64 = 150.0;

/// The panel.
#[derive(Default)]
pub struct LoadingPanel {
    /// Estimate before the loading was changed, which the estimate now is compared with.
    before: Option<(Option<Loading>, Arc<PooledFits>)>,
    changes: bool,
}

/// Title of the tanks.
const FUEL: &str = "Fuel";

/// A kind of place and the masses in it.
type Masses = fn(&mut Loading) -> &mut BTreeMap<String, f64>;

/// Title of a kind of place, its places with their capacity in kg, and where their masses are.
type Group<'a> = (&'static str, Vec<(&'a str, Option<f64>)>, Masses);

impl Panel for LoadingPanel {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let snapshot = ctx.snapshot;
        trouble(ui, snapshot.aircraft.error());
        let (Some(read), Some(loaded)) = (snapshot.aircraft.latest(), snapshot.loaded.latest()) else {
            let why = match ctx.session.aircraft {
                Some(_) => "The aircraft could not be read.",
                None => "No aircraft is chosen: only flight paths are computed.",
            };
            return awaiting(ctx, ui, "the aircraft", why);
        };
        let aircraft = &read.aircraft;
        self.remember(ctx);
        let fuel_is_stated = ctx.session.loading.as_ref().is_some_and(|loading| !loading.fuel_kg.is_empty());
        ui.columns(2, |columns| {
            ScrollArea::vertical().id_salt("places").auto_shrink(false).show(&mut columns[0], |ui| {
                ui.label(RichText::new(&aircraft.name).strong());
                places(ctx, ui, aircraft);
                let fuel = ui.add_enabled(fuel_is_stated, egui::Button::new("Fuel as recorded"));
                let fuel = fuel.on_hover_text("Gives up the fuel stated by hand");
                if fuel.on_disabled_hover_text("It is: a moved slider states the fuel by hand").clicked() {
                    let loading = Loading { fuel_kg: BTreeMap::new(), ..own_loading(ctx, aircraft) };
                    ctx.edit(Edit::Loading(LoadingEdit::All(loading)));
                }
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
            choices(ui, &mut self.changes, &[(false, "Envelope"), (true, "Change of derivatives")]);
            match self.changes {
                true => self.changes(ctx, ui),
                false => envelope(ctx, ui, aircraft, loaded),
            }
        });
    }
}

impl LoadingPanel {
    /// Keeps the estimate that goes with the loading before the user changes it.
    fn remember(&mut self, ctx: &PanelContext<'_>) {
        let ready = ctx.snapshot.pooled.ready().filter(|_| !ctx.snapshot.busy);
        match (&self.before, ready) {
            (None, Some(pooled)) => self.before = Some((ctx.session.loading.clone(), Arc::clone(pooled))),
            (Some((loading, _)), Some(pooled)) if *loading == ctx.session.loading => {
                self.before = Some((loading.clone(), Arc::clone(pooled)));
            }
            _ => {}
        }
    }

    /// Every derivative before and after the loading was changed.
    fn changes(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let (Some((loading, before)), Some(now)) = (&self.before, ctx.snapshot.pooled.latest()) else {
            return awaiting(ctx, ui, "the derivatives", "There is no estimate yet.");
        };
        let changed = *loading != ctx.session.loading;
        let again = ui.horizontal_wrapped(|ui| {
            ui.weak(if changed { "Since the loading was changed" } else { "Move a slider: what changes shows here" });
            changed
                && ui
                    .button("Compare from here")
                    .on_hover_text("Take the loading now as the one to compare with")
                    .clicked()
        });
        let rows = changes(before, now);
        if ctx.snapshot.pooled.is_stale() {
            ui.multiply_opacity(0.6);
        }
        TableBuilder::new(ui)
            .id_salt("changes of derivatives")
            .striped(true)
            .auto_shrink(false)
            .cell_layout(egui::Layout::right_to_left(egui::Align::Center))
            .column(Column::exact(54.0))
            .columns(Column::exact(66.0), 2)
            .column(Column::remainder().at_least(54.0))
            .header(20.0, |mut header| {
                for title in ["", "Now", "Change", "Part"] {
                    header.col(|ui| {
                        ui.weak(title);
                    });
                }
            })
            .body(|body| {
                body.rows(20.0, rows.len(), |mut row| {
                    let (name, was, is) = &rows[row.index()];
                    row.col(|ui| {
                        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                            let before = format!("{} before", notation::number(*was));
                            ui.label(notation::derivative_job(ui, name)).on_hover_text(before);
                        });
                    });
                    let part = 100.0 * (is - was) / was.abs();
                    let cells =
                        [notation::number(*is), notation::number(is - was), format!("{} %", notation::fixed(part, 2))];
                    for text in cells {
                        row.col(|ui| {
                            ui.label(RichText::new(text).font(theme::figures(ui)).size(11.5));
                        });
                    }
                });
            });
        if again.inner {
            self.before = None;
        }
    }
}

/// Derivatives both estimates have, before and now.
fn changes<'a>(before: &'a PooledFits, now: &PooledFits) -> Vec<(&'a String, f64, f64)> {
    let estimates = before.fits.iter().filter_map(|fit| fit.fit.as_ref().ok());
    let names = estimates.flat_map(|fit| fit.names.iter().zip(&fit.estimates));
    let names = names.filter(|(name, _)| !is_window_constant(name));
    names.filter_map(|(name, was)| Some((name, *was, estimate(&now.fits, name)?.0))).collect()
}

/// A slider for every tank, seat and bay.
/// The loading the session would have with nothing but what was stated by hand: without fuel the recording tells it.
fn own_loading(ctx: &PanelContext<'_>, aircraft: &Aircraft) -> Loading {
    let standard = || Loading { fuel_kg: BTreeMap::new(), ..aircraft.standard_loading.clone() };
    ctx.session.loading.clone().unwrap_or_else(standard)
}

fn places(ctx: &mut PanelContext<'_>, ui: &mut Ui, aircraft: &Aircraft) {
    let own = own_loading(ctx, aircraft);
    let on_board = loading_on_board(aircraft, Some(&own));
    let tanks = aircraft.tanks.iter().map(|tank| (tank.name.as_str(), Some(tank.capacity_kg))).collect::<Vec<_>>();
    let seats = aircraft.seats.iter().map(|seat| (seat.name.as_str(), seat.capacity_kg)).collect::<Vec<_>>();
    let bays = aircraft.luggage.iter().map(|bay| (bay.name.as_str(), bay.capacity_kg)).collect::<Vec<_>>();
    let groups: [Group<'_>; 3] = [
        (FUEL, tanks, |loading| &mut loading.fuel_kg),
        ("Seats", seats, |loading| &mut loading.seats_kg),
        ("Luggage", bays, |loading| &mut loading.luggage_kg),
    ];
    for (title, places, masses) in groups {
        if places.is_empty() {
            continue;
        }
        caption(ui, title);
        // A moved seat leaves the fuel to the recording; a moved tank states all tanks as they are shown.
        let loading = if title == FUEL { &on_board } else { &own };
        if title == FUEL && own.fuel_kg.is_empty() {
            ui.weak("Shown is the standard fuel. Where fuel was recorded the windows use the record.");
        }
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

/// The envelope with the point of this loading and the middle of every window that is in use.
fn envelope(ctx: &mut PanelContext<'_>, ui: &mut Ui, aircraft: &Aircraft, loaded: &LoadedState) {
    let palette = theme::palette(ui);
    let (unit, scale) = ctx.unit(Dimension::Length);
    let mut chart = Chart::new("envelope", format!("CG aft of the datum [{unit}]"), "mass [kg]");
    if let Some(envelope) = &aircraft.envelope {
        let corners = envelope.outline().into_iter().map(|(x_m, mass_kg)| [scale * x_m, mass_kg]);
        chart.curves.push(ChartCurve::new("", palette.accent, ChartStyle::Area, corners.collect()));
    } else {
        ui.weak("The file of this aircraft states no envelope.");
    }
    for role in [WindowRole::Identification, WindowRole::Validation] {
        let windows = ctx.session.windows.iter().filter(|window| window.role == role);
        let middle = windows.filter_map(|window| {
            let aero = ctx.snapshot.windows.get(&window.name)?.aero.latest()?;
            let inertia = aero.data.inertia.at(aero.data.time_s.len() / 2);
            Some([scale * inertia.cg_datum_m[0], inertia.mass_kg])
        });
        let points: Vec<[f64; 2]> = middle.collect();
        if !points.is_empty() {
            let color = role_color(palette, role);
            chart.curves.push(ChartCurve::new(role.name(), color, ChartStyle::Dots(3.0), points));
        }
    }
    let inside = loaded.envelope.is_none_or(|margin| margin.inside());
    let color = if inside { palette.good } else { palette.error };
    let here = vec![[scale * loaded.properties.cg_from_datum_m[0], loaded.properties.mass_kg]];
    chart.curves.push(ChartCurve::new("on board", color, ChartStyle::Dots(5.0), here));
    let height = ui.available_height();
    ctx.chart(ui, &chart, height);
}
