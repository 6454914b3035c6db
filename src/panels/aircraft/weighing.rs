//! Readings of the scales, and the centre of gravity they give.

use doublet_core::airframe::Aircraft;
use doublet_core::airframe::weighing::WeighingResult;
use doublet_core::quantity::Dimension;
use doublet_engine::weigh::{ScaleReadings, weigh};
use eframe::egui::{self, DragValue, Grid, Label, RichText, ScrollArea, Ui};

use crate::panels::{PanelContext, caption};
use crate::{notation, theme};

/// Rows a weighing begins with, and how many it may have.
const ATTITUDES: usize = 3;
const MOST_ATTITUDES: usize = 12;

/// Readings of the scales at one attitude as they are typed: degrees and kilograms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Readings {
    ground_pitch_deg: f64,
    aircraft_pitch_deg: f64,
    nose_kg: f64,
    right_kg: f64,
    left_kg: f64,
}

/// What was read.
pub(crate) struct Weighing {
    rows: Vec<Readings>,
}

impl Default for Weighing {
    fn default() -> Self {
        Self { rows: vec![Readings::default(); ATTITUDES] }
    }
}

impl Weighing {
    /// Readings of the scales at several attitudes, and the centre of gravity they give (thesis 5.1.3, Eq. 5.4 to 5.6).
    pub(crate) fn show(&mut self, ctx: &PanelContext<'_>, ui: &mut Ui, aircraft: &Aircraft) {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            ui.add(Label::new("Scale readings under the wheels at two or more pitch attitudes, fuel at rest. The slope of their moment over the tangent of pitch gives the height of the centre of gravity.").wrap());
            ui.add_space(4.0);
            self.readings(ui);
            let rows: Vec<ScaleReadings> = self.rows.iter().map(Readings::si).collect();
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
            for (at, row) in self.rows.iter_mut().enumerate() {
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
            if ui.add_enabled(self.rows.len() < MOST_ATTITUDES, egui::Button::new("Add attitude")).clicked() {
                self.rows.push(Readings::default());
            }
            if ui.add_enabled(self.rows.len() > 2, egui::Button::new("Remove last")).clicked() {
                self.rows.pop();
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
    caption(ui, "As weighed, including the load");
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
