//! Modes and levels: eigenvalues of the identified aircraft about a trim with their intervals, and the levels of its flying qualities,
//! live while airspeed, altitude, fuel, class or category change.

use doublet_engine::report::{ModeRow, mode_rows, qualities_row};
use doublet_engine::study::dynamics::{CATEGORIES, CLASSES};
use doublet_engine::study::{DynamicsRequest, DynamicsStudy, Study};
use eframe::egui::{ComboBox, Grid, ScrollArea, Slider, Ui};

use super::{Panel, PanelContext, choices, empty, study_button, trouble};
use crate::command::{RunCommand, UiCommand};
use crate::notation;
use crate::theme;
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::term::column_title;

/// Points of an ellipse.
const OUTLINE: usize = 73;
/// Radius of a root.
const ROOT: f32 = 4.0;

/// What is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Aspect {
    #[default]
    Roots,
    Modes,
    Levels,
}

/// The panel.
#[derive(Default)]
pub struct Dynamics {
    aspect: Aspect,
    request: DynamicsRequest,
}

impl Panel for Dynamics {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let slot = &ctx.snapshot.studies.dynamics;
        ui.horizontal_wrapped(|ui| {
            let hint =
                "Trims and linearises the identified model at the median condition of the windows, or as set below";
            study_button(ctx, ui, (Study::Dynamics(self.request), slot), "Compute modes and levels", hint);
            let all = [(Aspect::Roots, "Roots"), (Aspect::Modes, "Modes"), (Aspect::Levels, "Levels")];
            choices(ui, &mut self.aspect, &all);
        });
        trouble(ui, slot.error());
        let Some(study) = slot.latest() else {
            return empty(ui, "Modes and levels are computed when asked for.");
        };
        if self.controls(ctx, ui, study) {
            ctx.commands.push(UiCommand::Run(RunCommand::Study(Study::Dynamics(self.request))));
        }
        if slot.is_stale() {
            ui.multiply_opacity(0.45);
        }
        match self.aspect {
            Aspect::Roots => roots(ctx, ui, study),
            Aspect::Modes => modes(ui, study),
            Aspect::Levels => levels(ui, study),
        }
    }
}

impl Dynamics {
    /// The trim; whether it is another one.
    fn controls(&mut self, ctx: &PanelContext<'_>, ui: &mut Ui, study: &DynamicsStudy) -> bool {
        let before = self.request;
        let condition = &study.condition;
        ui.horizontal_wrapped(|ui| {
            let mut speed = self.request.airspeed_m_s.unwrap_or(condition.airspeed_m_s);
            let ends = 0.5 * condition.airspeed_m_s..=2.0 * condition.airspeed_m_s;
            if ui.add(Slider::new(&mut speed, ends).text("airspeed [m/s]").fixed_decimals(1)).changed() {
                self.request.airspeed_m_s = Some(speed);
            }
            let mut altitude = self.request.altitude_m.unwrap_or(condition.altitude_m);
            if ui.add(Slider::new(&mut altitude, 0.0..=10_000.0).text("altitude [m]").fixed_decimals(0)).changed() {
                self.request.altitude_m = Some(altitude);
            }
            if let Some((aboard, room)) = fuel(ctx) {
                let mut fuel = self.request.fuel_kg.unwrap_or(aboard);
                if ui.add(Slider::new(&mut fuel, 0.0..=room).text("fuel [kg]").fixed_decimals(1)).changed() {
                    self.request.fuel_kg = Some(fuel);
                }
            }
            for (name, chosen, all, shown) in [
                ("class", &mut self.request.class, &CLASSES[..], study.airplane.class),
                ("category", &mut self.request.category, &CATEGORIES[..], study.airplane.category),
            ] {
                ComboBox::from_id_salt(name).selected_text(format!("{name} {shown}")).width(90.0).show_ui(ui, |ui| {
                    ui.selectable_value(chosen, None, "as usual");
                    for (place, text) in all.iter().enumerate() {
                        ui.selectable_value(chosen, Some(place), *text);
                    }
                });
            }
            if ui.button("As flown").on_hover_text("The median condition of the identification windows").clicked() {
                let DynamicsRequest { class, category, .. } = self.request;
                self.request = DynamicsRequest { class, category, ..DynamicsRequest::default() };
            }
        });
        self.request != before
    }
}

/// Fuel on board in the loading and what the tanks hold, kg.
fn fuel(ctx: &PanelContext<'_>) -> Option<(f64, f64)> {
    let aircraft = ctx.snapshot.aircraft.latest()?;
    let aboard: f64 = ctx.session.loading.as_ref().map_or(0.0, |loading| loading.fuel_kg.values().sum());
    let standard: f64 = aircraft.aircraft.standard_loading.fuel_kg.values().sum();
    let room: f64 = aircraft.aircraft.tanks.iter().map(|tank| tank.capacity_kg).sum();
    (room > 0.0).then_some((if aboard > 0.0 { aboard } else { standard }, room))
}

/// Eigenvalues of the upper half plane with their confidence ellipses.
fn roots(ctx: &mut PanelContext<'_>, ui: &mut Ui, study: &DynamicsStudy) {
    let palette = theme::palette(ui);
    let mut chart = Chart::new("roots", "real part [1/s]", "imaginary part [rad/s]");
    for (index, estimate) in study.modes.modes.iter().enumerate() {
        let color = palette.series[index % palette.series.len()];
        let mode = &estimate.mode;
        let place = vec![[mode.real_1_s, mode.imaginary_rad_s]];
        chart.curves.push(ChartCurve::new(mode.name, color, ChartStyle::Dots(ROOT), place));
        chart.curves.push(ChartCurve::new("", color, ChartStyle::Line, estimate.ellipse(OUTLINE)));
    }
    let height = ui.available_height();
    ctx.chart(ui, &chart, height);
}

/// A figure with its standard error.
fn with_error(mode: &ModeRow, key: &str, value: Option<f64>) -> String {
    let Some(value) = value else { return String::new() };
    let error = mode.intervals.get(key).and_then(|figure| figure.delta).map(|interval| interval.standard_error);
    error.map_or_else(
        || notation::number(value),
        |error| format!("{} ± {}", notation::number(value), notation::number(error)),
    )
}

fn modes(ui: &mut Ui, study: &DynamicsStudy) {
    ScrollArea::both().show(ui, |ui| {
        Grid::new("modes").striped(true).show(ui, |ui| {
            for head in ["mode", "real [1/s]", "frequency [rad/s]", "damping", "period [s]", "half [s]", "double [s]"] {
                column_title(ui, head);
            }
            ui.end_row();
            for mode in &mode_rows(study) {
                ui.label(mode.name);
                ui.label(with_error(mode, "real_1_s", Some(mode.real_1_s)));
                ui.label(with_error(mode, "frequency_rad_s", Some(mode.frequency_rad_s)));
                ui.label(with_error(mode, "damping", Some(mode.damping)));
                ui.label(with_error(mode, "period_s", mode.period_s));
                ui.label(with_error(mode, "time_to_half_s", mode.time_to_half_s));
                ui.label(with_error(mode, "time_to_double_s", mode.time_to_double_s));
                ui.end_row();
            }
        });
        study.notes.iter().for_each(|note| drop(ui.weak(note)));
    });
}

fn levels(ui: &mut Ui, study: &DynamicsStudy) {
    let found = qualities_row(study);
    ScrollArea::both().show(ui, |ui| {
        ui.label(format!(
            "{}, class {}, category {}: {}",
            found.standard,
            found.class,
            found.category,
            found.level.unwrap_or("not judged")
        ));
        Grid::new("levels").striped(true).show(ui, |ui| {
            for head in ["criterion", "level", "Level 1 with", "not Level 1 because"] {
                column_title(ui, head);
            }
            ui.end_row();
            for criterion in &found.criteria {
                ui.label(&criterion.criterion);
                if criterion.counts {
                    ui.label(criterion.level)
                } else {
                    ui.weak(format!("({})", criterion.level))
                };
                ui.label(
                    criterion.probabilities.map_or_else(String::new, |shares| format!("{:.0} %", 100.0 * shares[0])),
                );
                ui.label(criterion.reasons.join("; "));
                ui.end_row();
            }
        });
        ui.weak(&found.note);
    });
}
