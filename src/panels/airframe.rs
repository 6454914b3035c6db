//! The aircraft to scale, from above and from the side, with everything on board; and the weighing that gives its centre of gravity.

use doublet_core::airframe::weighing::WeighingResult;
use doublet_core::airframe::{Aircraft, LoadedState};
use doublet_core::quantity::Dimension;
use doublet_engine::weigh::{ScaleReadings, weigh};
use eframe::egui::{self, Align, DragValue, Grid, Label, Layout, RichText, ScrollArea, Ui};
use egui_extras::{Column, TableBuilder};

use super::{Panel, PanelContext, awaiting, caption, choices, trouble};
use crate::notation;
use crate::theme;
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};

/// Rows a weighing begins with, and how many it may have.
const ATTITUDES: usize = 3;
const MOST_ATTITUDES: usize = 12;
/// Height of a row.
const ROW: f32 = 19.0;
/// Part of the height that the views have above the table.
const VIEWS: f32 = 0.62;

/// What is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Aspect {
    #[default]
    Views,
    Weighing,
}

/// Readings of the scales at one attitude as they are typed: degrees and kilograms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Readings {
    ground_pitch_deg: f64,
    aircraft_pitch_deg: f64,
    nose_kg: f64,
    right_kg: f64,
    left_kg: f64,
}

/// The panel.
pub struct Airframe {
    aspect: Aspect,
    weighing: Vec<Readings>,
}

impl Default for Airframe {
    fn default() -> Self {
        Self { aspect: Aspect::default(), weighing: vec![Readings::default(); ATTITUDES] }
    }
}

/// A point of the aircraft with what it is.
struct Place {
    kind: &'static str,
    name: String,
    mass_kg: Option<f64>,
    at_m: [f64; 3],
}

impl Panel for Airframe {
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
        ui.horizontal_wrapped(|ui| {
            choices(ui, &mut self.aspect, &[(Aspect::Views, "Views"), (Aspect::Weighing, "Weighing")]);
            ui.add(Label::new(RichText::new(&aircraft.name).strong()).truncate());
        });
        match self.aspect {
            Aspect::Views => views(ctx, ui, aircraft, loaded),
            Aspect::Weighing => self.weighing(ctx, ui, aircraft),
        }
    }
}

/// Everything that has a place.
fn places(aircraft: &Aircraft, loaded: &LoadedState) -> Vec<Place> {
    let mut places = Vec::new();
    let mut add = |kind, name: &str, mass_kg, at_m| {
        places.push(Place { kind, name: name.replace('_', " "), mass_kg, at_m });
    };
    add("centre of gravity", "as loaded", Some(loaded.properties.mass_kg), loaded.properties.cg_from_datum_m);
    add("fixed", &aircraft.empty.name, Some(aircraft.empty.mass_kg), aircraft.empty.cg_from_datum_m);
    aircraft.fixed_items.iter().for_each(|item| add("fixed", &item.name, Some(item.mass_kg), item.cg_from_datum_m));
    aircraft.tanks.iter().for_each(|tank| add("tank", &tank.name, Some(tank.capacity_kg), tank.cg_from_datum_m));
    for (kind, stations) in [("seat", &aircraft.seats), ("luggage", &aircraft.luggage)] {
        stations.iter().for_each(|station| add(kind, &station.name, station.capacity_kg, station.cg_from_datum_m));
    }
    aircraft.engines.iter().for_each(|engine| add("engine", &engine.name, None, engine.position_from_datum_m));
    let sensors = &aircraft.sensors;
    for (name, at_m) in [
        ("accelerometer", sensors.accelerometer_from_datum_m),
        ("alpha vane", sensors.alpha_vane_from_datum_m),
        ("beta vane", sensors.beta_vane_from_datum_m),
        ("antenna", sensors.antenna_from_datum_m),
        ("moment reference", aircraft.moment_reference_from_datum_m),
    ] {
        at_m.into_iter().for_each(|at_m| add("sensor", name, None, at_m));
    }
    if let Some(wheels) = &aircraft.wheels {
        let main = |side: f64| [wheels.main_x_m, side * wheels.main_y_m, 0.0];
        for (name, at_m) in [("nose wheel", [wheels.nose_x_m, 0.0, 0.0]), ("right", main(1.0)), ("left", main(-1.0))] {
            add("wheel", name, None, at_m);
        }
    }
    places
}

/// From above and from the side, beside each other, over the table of places.
fn views(ctx: &mut PanelContext<'_>, ui: &mut Ui, aircraft: &Aircraft, loaded: &LoadedState) {
    let places = places(aircraft, loaded);
    let (unit, scale) = ctx.unit(Dimension::Length);
    ui.add(Label::new(RichText::new(format!("x aft of the datum, {}", aircraft.datum)).size(11.0).weak()).truncate())
        .on_hover_text(&aircraft.datum);
    let height = VIEWS * ui.available_height();
    let wing = outline(aircraft);
    ui.columns(2, |columns| {
        for (column, (name, axis, up)) in
            columns.iter_mut().zip([("from above", 1, "y to the right"), ("from the side", 2, "z up")])
        {
            let chart = view((name, axis, up), &places, &wing, (unit, scale), column);
            ctx.chart(column, &chart, height);
        }
    });
    table(ctx, ui, &places);
}

/// One view. Each kind of place has its colour.
fn view(
    (name, axis, up): (&str, usize, &str),
    places: &[Place],
    wing: &[[f64; 3]],
    (unit, scale): (&str, f64),
    ui: &Ui,
) -> Chart {
    let palette = theme::palette(ui);
    let mut chart = Chart::new(&format!("aircraft {name}"), format!("x aft [{unit}]"), format!("{up} [{unit}]"));
    chart.aspect = Some(1.0);
    let flat = |at_m: &[f64; 3]| [scale * at_m[0], scale * at_m[axis]];
    if axis == 1 && !wing.is_empty() {
        let corners = wing.iter().map(flat).collect();
        chart.curves.push(ChartCurve::new("wing", palette.ignored, ChartStyle::Area, corners));
    }
    let kinds = [
        ("fixed", palette.ignored, 4.0),
        ("tank", palette.series[1], 4.0),
        ("seat", palette.series[0], 3.5),
        ("luggage", palette.series[6], 3.5),
        ("engine", palette.series[5], 4.5),
        ("sensor", palette.series[2], 3.0),
        ("wheel", palette.series[7], 4.0),
        ("centre of gravity", palette.error, 6.0),
    ];
    for (kind, color, radius) in kinds {
        let points: Vec<_> = places.iter().filter(|place| place.kind == kind).map(|place| flat(&place.at_m)).collect();
        if !points.is_empty() {
            chart.curves.push(ChartCurve::new(kind, color, ChartStyle::Dots(radius), points));
        }
    }
    chart
}

/// Corners of the wing as seen from above: along the leading edges of both halves and back along the trailing edges.
fn outline(aircraft: &Aircraft) -> Vec<[f64; 3]> {
    let mut leading = Vec::new();
    let mut trailing = Vec::new();
    for panel in &aircraft.wing_panels {
        let tip = panel.root_y_m + panel.semispan_m;
        leading.extend([[panel.root_leading_edge_x_m, panel.root_y_m, 0.0], [panel.tip_leading_edge_x_m, tip, 0.0]]);
        trailing.extend([
            [panel.root_leading_edge_x_m + panel.root_chord_m, panel.root_y_m, 0.0],
            [panel.tip_leading_edge_x_m + panel.taper * panel.root_chord_m, tip, 0.0],
        ]);
    }
    let mirrored = |corner: &[f64; 3]| [corner[0], -corner[1], corner[2]];
    let right = leading.iter().copied().chain(trailing.iter().rev().copied());
    let left = trailing.iter().map(mirrored).chain(leading.iter().rev().map(mirrored));
    let mut all: Vec<_> = right.chain(left).collect();
    all.extend(leading.first().copied());
    all
}

/// Every place with its coordinates and mass.
fn table(ctx: &PanelContext<'_>, ui: &mut Ui, places: &[Place]) {
    let (unit, scale) = ctx.unit(Dimension::Length);
    let figures = theme::figures(ui);
    TableBuilder::new(ui)
        .id_salt("places of the aircraft")
        .striped(true)
        .auto_shrink(false)
        .cell_layout(Layout::left_to_right(Align::Center))
        .column(Column::exact(112.0))
        .column(Column::remainder().at_least(90.0).clip(true))
        .columns(Column::exact(66.0), 4)
        .header(20.0, |mut header| {
            let lengths = ["x aft", "y right", "z up"].map(|name| format!("{name} [{unit}]"));
            let titles = ["".to_owned(), "Place".to_owned()].into_iter().chain(["Mass [kg]".to_owned()]).chain(lengths);
            for title in titles {
                header.col(|ui| {
                    ui.label(RichText::new(title).size(11.0).weak());
                });
            }
        })
        .body(|body| {
            body.rows(ROW, places.len(), |mut row| {
                let place = &places[row.index()];
                row.col(|ui| {
                    ui.weak(place.kind);
                });
                row.col(|ui| {
                    ui.add(Label::new(&place.name).truncate());
                });
                let mass = place.mass_kg.map_or_else(|| "–".to_owned(), |mass_kg| notation::fixed(mass_kg, 1));
                let lengths = place.at_m.map(|value| notation::fixed(scale * value, 3));
                for text in std::iter::once(mass).chain(lengths) {
                    row.col(|ui| {
                        ui.label(RichText::new(text).font(figures.clone()).size(11.5));
                    });
                }
            });
        });
}

impl Airframe {
    /// Readings of the scales at several attitudes, and the centre of gravity they give (thesis 5.1.3, Eq. 5.4 to 5.6).
    fn weighing(&mut self, ctx: &PanelContext<'_>, ui: &mut Ui, aircraft: &Aircraft) {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            ui.add(Label::new("Readings under the wheels at two or more pitch attitudes, fuel at rest: the moments over the tangent of pitch are a line, its slope the height of the centre of gravity.").wrap());
            ui.add_space(4.0);
            self.readings(ui);
            let rows: Vec<ScaleReadings> = self.weighing.iter().map(Readings::si).collect();
            ui.add_space(6.0);
            match weigh(aircraft, &rows) {
                Ok(found) => result(ctx, ui, aircraft, &found),
                Err(error) => drop(ui.add(Label::new(RichText::new(error).weak()).wrap())),
            }
        });
    }

    fn readings(&mut self, ui: &mut Ui) {
        Grid::new("readings").num_columns(6).striped(true).spacing([10.0, 4.0]).show(ui, |ui| {
            for title in ["", "ground pitch [deg]", "aircraft pitch [deg]", "nose [kg]", "right [kg]", "left [kg]"] {
                ui.label(RichText::new(title).size(11.0).weak());
            }
            ui.end_row();
            for (at, row) in self.weighing.iter_mut().enumerate() {
                ui.label(format!("{}", at + 1));
                let fields = [
                    ("ground pitch", &mut row.ground_pitch_deg, 0.01, -30.0..=30.0),
                    ("aircraft pitch", &mut row.aircraft_pitch_deg, 0.01, -30.0..=30.0),
                    ("nose", &mut row.nose_kg, 0.5, 0.0..=1e6),
                    ("right", &mut row.right_kg, 0.5, 0.0..=1e6),
                    ("left", &mut row.left_kg, 0.5, 0.0..=1e6),
                ];
                for (name, value, speed, range) in fields {
                    let field = ui.add(DragValue::new(value).speed(speed).range(range).max_decimals(3));
                    let label = format!("weighing {} {name}", at + 1);
                    ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(label.as_str()));
                }
                ui.end_row();
            }
        });
        ui.horizontal(|ui| {
            if ui.add_enabled(self.weighing.len() < MOST_ATTITUDES, egui::Button::new("Add attitude")).clicked() {
                self.weighing.push(Readings::default());
            }
            if ui.add_enabled(self.weighing.len() > 2, egui::Button::new("Remove last")).clicked() {
                self.weighing.pop();
            }
        });
    }
}

impl Readings {
    fn si(&self) -> ScaleReadings {
        ScaleReadings {
            ground_pitch_rad: self.ground_pitch_deg.to_radians(),
            aircraft_pitch_rad: self.aircraft_pitch_deg.to_radians(),
            wheels_kg: [self.nose_kg, self.right_kg, self.left_kg],
        }
    }
}

/// Mass and centre of gravity as weighed, beside what the file states for the empty aircraft.
fn result(ctx: &PanelContext<'_>, ui: &mut Ui, aircraft: &Aircraft, found: &WeighingResult) {
    caption(ui, "As weighed, with what was on board");
    let (unit, scale) = ctx.unit(Dimension::Length);
    let length = |value: f64, error: Option<f64>| {
        let error = error.map_or_else(String::new, |error| format!(" ± {}", notation::fixed(scale * error, 4)));
        format!("{}{error} {unit}", notation::fixed(scale * value, 4))
    };
    let empty = &aircraft.empty;
    let rows = [
        (
            "Mass",
            format!("{} kg", notation::fixed(found.mass_kg, 1)),
            format!("{} kg", notation::fixed(empty.mass_kg, 1)),
        ),
        ("Spread of the totals", format!("{} kg", notation::fixed(found.mass_spread_kg, 1)), String::new()),
        ("CG aft of the datum", length(found.x_m, found.x_error_m), length(empty.cg_from_datum_m[0], None)),
        ("CG to the right, level", length(found.level_y_m, None), length(empty.cg_from_datum_m[1], None)),
        ("CG above the datum", length(found.z_m, found.z_error_m), length(empty.cg_from_datum_m[2], None)),
        (
            "Turn of the struts",
            format!("{} deg", notation::fixed(found.strut_pitch_rad.to_degrees(), 3)),
            String::new(),
        ),
        ("R² of the line", notation::fixed(found.r_squared, 5), String::new()),
    ];
    Grid::new("as weighed").num_columns(3).striped(true).spacing([18.0, 3.0]).show(ui, |ui| {
        for title in ["", "weighed", "file, empty"] {
            ui.label(RichText::new(title).size(11.0).weak());
        }
        ui.end_row();
        for (name, weighed, stated) in rows {
            ui.label(name);
            ui.label(RichText::new(weighed).font(theme::figures(ui)));
            ui.label(RichText::new(stated).font(theme::figures(ui)).weak());
            ui.end_row();
        }
    });
}
