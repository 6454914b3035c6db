//! Loading of the aircraft: fuel, seats and luggage, with the resulting mass, centre of gravity and inertia.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::airframe::{Aircraft, LoadedState, Loading, LoadingIssue};
use doublet_core::quantity::Dimension;
use doublet_engine::aircraft::{AircraftChanges, instant};
use doublet_engine::session::{Edit, Flight, LoadingEdit, Manoeuvre, WindowRole};
use doublet_engine::stage::{FlownMass, PooledFits, loading_on_board};
use eframe::egui::{self, Align, Grid, Id, Layout, RichText, ScrollArea, Slider, Ui, UiBuilder};
use egui_extras::Column;

use crate::command::{UiCommand, ViewCommand};
use crate::panels::results::intervals::estimate;
use crate::panels::{
    EditRequest, NO_AIRCRAFT, Pane, Panel, PanelContext, awaiting, caption, choices, dim_if, is_window_constant,
    lacks_estimate, offer, role_color, trouble,
};
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::grid::figures_grid;
use crate::widgets::quantity_edit;
use crate::widgets::term::{column_title, column_titles};
use crate::{notation, theme};

/// Largest mass of a place that states none, kg.
const USUAL_CAPACITY_KG: f64 = 150.0;

/// Room for the name of a place and its mass beside a slider, points.
const BESIDE_SLIDER: f32 = 205.0;

/// Shortest and longest slider, points.
const SLIDER_WIDTHS: (f32, f32) = (36.0, 120.0);

/// Width of the table of masses below which its columns stand closer.
const NARROW: f32 = 290.0;

#[derive(Default)]
pub struct LoadingPanel {
    /// Estimate before the loading was changed, which the estimate now is compared with.
    before: Option<(MassSettings, Arc<PooledFits>)>,
    changes: bool,
}

/// What of a session says what the aircraft weighs and where.
type MassSettings = (Option<String>, AircraftChanges, Option<Loading>);

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
            if ctx.session.aircraft.is_none() {
                if offer(ui, NO_AIRCRAFT, "Choose an aircraft") {
                    ctx.commands.push(UiCommand::View(ViewCommand::Show(Pane::Airframe)));
                }
                return;
            }
            return awaiting(ctx, ui, "the aircraft", "The aircraft could not be read.");
        };
        let aircraft = &read.aircraft;
        self.remember(ctx);
        let fuel_is_stated = stated(ctx).is_some_and(|loading| !loading.fuel_kg.is_empty());
        ui.columns(2, |columns| {
            ScrollArea::vertical().id_salt("places").auto_shrink(false).show(&mut columns[0], |ui| {
                ui.label(RichText::new(&aircraft.name).strong());
                own_or_common(ctx, ui);
                places(ctx, ui, aircraft);
                let fuel = ui.add_enabled(fuel_is_stated, egui::Button::new("Fuel as recorded"));
                let fuel = fuel.on_hover_text("Discards the fuel stated by hand");
                if fuel.on_disabled_hover_text("Used now; moving a slider states the fuel by hand").clicked() {
                    let loading = Loading { fuel_kg: BTreeMap::new(), ..own_loading(ctx, aircraft) };
                    change(ctx, loading);
                }
                let has_own = shown_flight(ctx).is_some_and(|flight| flight.loading.is_some());
                let is_stated = ctx.session.loading.is_some() && !has_own;
                if ui.add_enabled(is_stated, egui::Button::new("Standard loading")).clicked() {
                    ctx.edit(Edit::Loading(LoadingEdit::Standard));
                }
            });
            let ui = &mut columns[1];
            dim_if(ui, snapshot.loaded.is_stale());
            numbers(ctx, ui, loaded);
            choices(ui, &mut self.changes, &[(false, "Envelope"), (true, "Change of derivatives")]);
            // Below the choice, which stays where it is when a warning comes or goes.
            warnings(ui, &limit_issues(selected_mass(ctx), loaded));
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
            (None, Some(pooled)) => self.before = Some((settings(ctx), Arc::clone(pooled))),
            (Some((before, _)), Some(pooled)) if *before == settings(ctx) => {
                self.before = Some((before.clone(), Arc::clone(pooled)));
            }
            _ => {}
        }
    }

    /// Every derivative before and after the loading was changed.
    fn changes(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let (Some((mass, before)), Some(now)) = (&self.before, ctx.snapshot.pooled.latest()) else {
            return awaiting(ctx, ui, "the derivatives", &lacks_estimate(ctx));
        };
        let changed = *mass != settings(ctx);
        let again = ui.horizontal_wrapped(|ui| {
            ui.weak(if changed {
                "Change since the last loading or aircraft edit"
            } else {
                "Move a slider or a part of the aircraft to see the changes"
            });
            changed
                && ui.button("Compare from here").on_hover_text("Use the current loading as the reference").clicked()
        });
        let rows = changes(before, now);
        if ctx.snapshot.pooled.is_stale() {
            ui.multiply_opacity(0.6);
        }
        figures_grid(ui, "changes of derivatives")
            .column(Column::exact(50.0))
            .columns(Column::exact(76.0), 2)
            .column(Column::remainder().at_least(58.0))
            .header(20.0, |header| column_titles(header, ["", "Now", "Change", "Change [%]"]))
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
                    // Two digits: it is a difference of numbers of four.
                    let change = notation::within(is - was, is - was);
                    let cells = [notation::number(*is), change, notation::fixed(part, 2)];
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

/// What the session says of mass now.
fn settings(ctx: &PanelContext<'_>) -> MassSettings {
    let session = ctx.session;
    (session.aircraft.clone(), session.aircraft_changes.clone(), stated(ctx).cloned())
}

/// Derivatives both estimates have, before and now.
fn changes<'a>(before: &'a PooledFits, now: &PooledFits) -> Vec<(&'a String, f64, f64)> {
    let estimates = before.fits.iter().filter_map(|fit| fit.fit.as_ref().ok());
    let names = estimates.flat_map(|fit| fit.names.iter().zip(&fit.estimates));
    let names = names.filter(|(name, _)| !is_window_constant(name));
    names.filter_map(|(name, was)| Some((name, *was, estimate(&now.fits, name)?.0))).collect()
}

/// The loading the session would have with nothing but what was stated by hand: without fuel the recording tells it.
fn own_loading(ctx: &PanelContext<'_>, aircraft: &Aircraft) -> Loading {
    let standard = || Loading { fuel_kg: BTreeMap::new(), ..aircraft.standard_loading.clone() };
    stated(ctx).cloned().unwrap_or_else(standard)
}

/// The flight whose loading is shown: that of the chosen window, or the first.
fn shown_flight<'a>(ctx: &PanelContext<'a>) -> Option<&'a Flight> {
    ctx.window().and_then(|window| ctx.session.flight(&window.flight)).or_else(|| ctx.session.flights.first())
}

/// What the session states to be on board in that flight.
fn stated<'a>(ctx: &PanelContext<'a>) -> Option<&'a Loading> {
    shown_flight(ctx).map_or(ctx.session.loading.as_ref(), |flight| ctx.session.loading_in(&flight.name))
}

/// Changes the loading shown: the flight's own where it has one, the session's otherwise.
fn change(ctx: &mut PanelContext<'_>, loading: Loading) {
    let own = shown_flight(ctx).filter(|flight| flight.loading.is_some()).map(|flight| flight.name.clone());
    ctx.edit(Edit::Loading(match own {
        Some(flight) => LoadingEdit::OfFlight { flight, loading: Some(loading) },
        None => LoadingEdit::All(loading),
    }));
}

/// Whether the flight shown has a loading of its own, where there are several flights.
fn own_or_common(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let Some(flight) = shown_flight(ctx).filter(|_| ctx.session.flights.len() > 1) else { return };
    let mut own = flight.loading.is_some();
    let shown = ui.checkbox(&mut own, format!("Own loading of flight {}", flight.name));
    if shown.on_hover_text("Otherwise the loading of all flights").changed() {
        let loading = own.then(|| stated(ctx).cloned().unwrap_or_default());
        ctx.edit(Edit::Loading(LoadingEdit::OfFlight { flight: flight.name.clone(), loading }));
    }
}

/// A slider for every tank, seat and bay.
fn places(ctx: &mut PanelContext<'_>, ui: &mut Ui, aircraft: &Aircraft) {
    let own = own_loading(ctx, aircraft);
    // Fuel left to the record shows what the record starts with, so that a moved tank shifts its own record and no other's.
    let recorded =
        selected_mass(ctx).filter(|_| own.fuel_kg.is_empty()).map(|flown| flown.start.loading.fuel_kg.clone());
    let on_board = match recorded {
        Some(fuel_kg) => Loading { fuel_kg, ..own.clone() },
        None => loading_on_board(aircraft, Some(&own)),
    };
    let tanks = aircraft.tanks.iter().map(|tank| (tank.name.as_str(), Some(tank.capacity_kg))).collect::<Vec<_>>();
    let seats = aircraft.seats.iter().map(|seat| (seat.name.as_str(), seat.capacity_kg)).collect::<Vec<_>>();
    let bays = aircraft.luggage.iter().map(|bay| (bay.name.as_str(), bay.capacity_kg)).collect::<Vec<_>>();
    let groups: [Group<'_>; 3] = [
        (FUEL, tanks, |loading| &mut loading.fuel_kg),
        ("Seats", seats, |loading| &mut loading.seats_kg),
        ("Luggage", bays, |loading| &mut loading.luggage_kg),
    ];
    let slider_width = (ui.available_width() - BESIDE_SLIDER).clamp(SLIDER_WIDTHS.0, SLIDER_WIDTHS.1);
    ui.spacing_mut().slider_width = slider_width;
    let names = groups.iter().flat_map(|(_, places, _)| places);
    let font = egui::TextStyle::Body.resolve(ui.style());
    let laid = |name: &str| ui.painter().layout_no_wrap(name.replace('_', " "), font.clone(), egui::Color32::WHITE);
    let names = names.map(|(name, _)| laid(name).size().x).fold(0.0, f32::max);
    for (title, places, masses) in groups {
        if places.is_empty() {
            continue;
        }
        caption(ui, title);
        // A moved seat leaves the fuel to the recording; a moved tank states all tanks as they are shown.
        let loading = if title == FUEL { &on_board } else { &own };
        if title == FUEL {
            let (short, long) = fuel_in_words(ctx, &own);
            // One line whatever it says: below it nothing moves under the pointer.
            ui.add(egui::Label::new(RichText::new(short).weak()).truncate()).on_hover_text(long);
        }
        // Names of all groups have one width, so that the sliders begin on one line.
        Grid::new(title).num_columns(2).min_col_width(names).spacing([8.0, 3.0]).show(ui, |ui| {
            for (name, capacity) in places {
                ui.label(name.replace('_', " "));
                draw_slider(ctx, ui, loading, (title, name, capacity), masses);
                ui.end_row();
            }
        });
        ui.add_space(4.0);
    }
    if aircraft.tanks.is_empty() && aircraft.seats.is_empty() && aircraft.luggage.is_empty() {
        // The column justifies its texts.
        ui.with_layout(Layout::top_down(Align::Min), |ui| {
            ui.weak("The file of this aircraft states no tanks, seats or bays.")
        });
    }
}

/// One slider; a drag is one step of undo.
fn draw_slider(
    ctx: &mut PanelContext<'_>,
    ui: &mut Ui,
    loading: &Loading,
    (title, name, capacity): (&str, &str, Option<f64>),
    masses: Masses,
) {
    let mut changed = loading.clone();
    let mass = masses(&mut changed).entry(name.to_owned()).or_insert(0.0);
    // As the slider rounds and bounds it: what it does to a recorded mass by itself is no change of the loading.
    let most = capacity.unwrap_or(USUAL_CAPACITY_KG);
    let before = quantity_edit::to_decimals(*mass, 1).clamp(0.0, most);
    let mut now = before;
    let slider = Slider::new(&mut now, 0.0..=most).suffix(" kg").fixed_decimals(1);
    // Its identity is its own: text that comes or goes above it does not end a drag.
    let steady = UiBuilder::new().scope_id(Id::unique(("loading", title, name)));
    let response = ui.scope_builder(steady, |ui| ui.add(slider)).inner;
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(format!("{title} {name}")));
    if response.drag_started() {
        ctx.edits.push(EditRequest::Begin(format!("change {} {name}", title.to_lowercase())));
    }
    if now != before {
        *mass = now;
        change(ctx, changed);
    }
    if response.drag_stopped() {
        ctx.edits.push(EditRequest::Commit);
    }
}

/// Mass, kg, and centre of gravity, m from the datum, at the linked cursor, inside a window with coefficients.
fn at_cursor(ctx: &PanelContext<'_>) -> Option<(f64, [f64; 3])> {
    let time_s = ctx.state.time.cursor_s?;
    let flight = ctx.selection().flight.as_deref()?;
    let inside = |window: &&Manoeuvre| window.flight == flight && window.window.contains(time_s);
    instant(ctx.snapshot, flight, ctx.session.active_windows().find(inside), time_s).mass
}

/// Mass properties over the flight of the chosen window, or of the first one that has them.
pub(crate) fn selected_mass<'a>(ctx: &PanelContext<'a>) -> Option<&'a FlownMass> {
    let mass_over = |flight: &str| ctx.snapshot.flown.get(flight)?.latest().map(|flown| &**flown);
    ctx.window()
        .and_then(|window| mass_over(&window.flight))
        .or_else(|| ctx.session.flights.iter().find_map(|flight| mass_over(&flight.name)))
}

/// Where the fuel comes from, in short and at length.
fn fuel_in_words(ctx: &PanelContext<'_>, own: &Loading) -> (&'static str, String) {
    let short = match (own.fuel_kg.is_empty(), selected_mass(ctx)) {
        (false, _) => "stated by hand, at the first record",
        (true, Some(_)) => "at the first record",
        (true, None) => "standard fuel",
    };
    let basis = selected_mass(ctx).map_or("no flight is read", |flown| flown.fuel.description());
    let long = format!(
        "{basis}. Moving a tank states the fuel at the first record and shifts the recorded fuel by the difference."
    );
    (short, long)
}

/// Mass, centre of gravity and inertia at the start, in the chosen window and at the end, and what is wrong with them.
fn numbers(ctx: &PanelContext<'_>, ui: &mut Ui, loaded: &LoadedState) {
    let flown = selected_mass(ctx);
    let window = flown.zip(ctx.window()).and_then(|(flown, window)| {
        flown.windows.iter().find(|(name, _)| *name == window.name).map(|(_, state)| &state.state)
    });
    let mut columns = vec![("Loading", loaded)];
    if let Some(flown) = flown {
        columns = vec![("Start", &flown.start.state)];
        columns.extend(window.map(|state| ("Manoeuvre", state)));
        columns.push(("End", &flown.end.state));
    }
    type Figure = fn(&LoadedState) -> String;
    let rows: [(&str, Figure); 9] = [
        ("Mass [kg]", |of| notation::four_digits(of.properties.mass_kg, 1)),
        ("CG aft [m]", |of| station(of, 0, 1.0)),
        ("CG right [m]", |of| station(of, 1, 1.0)),
        ("CG up [m]", |of| station(of, 2, 1.0)),
        ("CG [% MAC]", |of| notation::fixed(of.mean_chord_fraction.map_or(f64::NAN, |x| 100.0 * x), 1)),
        ("Ixx [kg m²]", |of| notation::four_digits(of.properties.inertia.xx, 0)),
        ("Iyy [kg m²]", |of| notation::four_digits(of.properties.inertia.yy, 0)),
        ("Izz [kg m²]", |of| notation::four_digits(of.properties.inertia.zz, 0)),
        ("Ixz [kg m²]", |of| notation::four_digits(of.properties.inertia.xz, 0)),
    ];
    let gap = if ui.available_width() < NARROW { 6.0 } else { 14.0 };
    // One column more than is filled: the last of a grid takes all that is left.
    Grid::new("loaded").num_columns(columns.len() + 2).spacing([gap, 3.0]).show(ui, |ui| {
        ui.label("");
        columns.iter().for_each(|(title, _)| {
            right(ui, |ui| drop(ui.weak(*title)));
        });
        ui.end_row();
        for (name, figure) in rows {
            column_title(ui, name);
            for (_, state) in &columns {
                right(ui, |ui| drop(ui.label(RichText::new(figure(state)).font(theme::figures(ui)))));
            }
            ui.end_row();
        }
    });
}

/// A cell of a grid, its content at the right.
fn right(ui: &mut Ui, content: impl FnOnce(&mut Ui)) {
    // A layout without a size would be as high as the rest of the panel.
    let size = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, Layout::right_to_left(Align::Center), content);
}

/// What is wrong with a loading: at the start of the flight, the landing mass at its end.
fn limit_issues<'a>(flown: Option<&'a FlownMass>, loaded: &'a LoadedState) -> Vec<&'a LoadingIssue> {
    let Some(flown) = flown else { return loaded.warnings.iter().collect() };
    let is_of_landing = |issue: &&LoadingIssue| matches!(issue, LoadingIssue::OverLandingMass { .. });
    let of_start = flown.start.state.warnings.iter().filter(|issue| !is_of_landing(issue));
    of_start.chain(flown.end.state.warnings.iter().filter(is_of_landing)).collect()
}

/// Lists what is wrong with a loading.
fn warnings(ui: &mut Ui, issues: &[&LoadingIssue]) {
    let palette = theme::palette(ui);
    for warning in issues {
        // In a column every line would be stretched to its width.
        ui.horizontal_wrapped(|ui| ui.colored_label(palette.warning, format!("⚠ {warning}")));
    }
}

/// A coordinate of the centre of gravity in the unit of `scale`; a dash where the aircraft states no station at all.
pub(crate) fn station(of: &LoadedState, axis: usize, scale: f64) -> String {
    let place = of.properties.cg_from_datum_m;
    if place == [0.0; 3] { "–".to_owned() } else { notation::fixed(scale * place[axis], 3) }
}

/// The envelope with the point of this loading and the middle of every window that is in use.
fn envelope(ctx: &mut PanelContext<'_>, ui: &mut Ui, aircraft: &Aircraft, loaded: &LoadedState) {
    let palette = theme::palette(ui);
    let (unit, scale) = ctx.unit(Dimension::Length);
    let mut chart = Chart::new("envelope", format!("CG aft of the datum [{unit}]"), "mass [kg]");
    if let Some(envelope) = &aircraft.envelope {
        let corners = envelope.outline().into_iter().map(|(x_m, mass_kg)| [scale * x_m, mass_kg]);
        chart.curves.push(ChartCurve::new("envelope", palette.ignored, ChartStyle::Area, corners.collect()));
    } else {
        ui.weak("The file of this aircraft states no envelope.");
        if loaded.properties.cg_from_datum_m == [0.0; 3] {
            return;
        }
    }
    for role in [WindowRole::Identification, WindowRole::Validation] {
        let windows = ctx.session.windows.iter().filter(|window| window.role == role);
        let middle = windows.filter_map(|window| {
            let aero = ctx.snapshot.windows.get(&window.name)?.aero.latest()?;
            let mass = aero.data.mass.at(aero.data.time_s.len() / 2);
            Some([scale * mass.cg_from_datum_m[0], mass.mass_kg])
        });
        let points: Vec<[f64; 2]> = middle.collect();
        if !points.is_empty() {
            let color = role_color(palette, role);
            chart.curves.push(ChartCurve::new(role.name(), color, ChartStyle::Dots(3.0), points));
        }
    }
    let start = selected_mass(ctx).map_or(loaded, |flown| &flown.start.state);
    let inside = start.envelope.is_none_or(|margin| margin.inside());
    let color = if inside { palette.good } else { palette.error };
    let here = vec![[scale * start.properties.cg_from_datum_m[0], start.properties.mass_kg]];
    chart.curves.push(ChartCurve::new("at the start", color, ChartStyle::Dots(5.0), here));
    if let Some((mass_kg, [x_m, ..])) = at_cursor(ctx) {
        let here = vec![[scale * x_m, mass_kg]];
        chart.curves.push(ChartCurve::new("at the cursor", palette.series[1], ChartStyle::Dots(6.0), here));
    }
    let height = ui.available_height();
    ctx.chart(ui, &chart, height);
}
