//! Modes and levels: eigenvalues of the identified aircraft about a trim with their intervals, and levels of flying qualities, updated
//! while airspeed, altitude, fuel, class or category change.

use std::ops::RangeInclusive;

use doublet_core::airframe::Loading;
use doublet_core::statistics::median;
use doublet_engine::report::document::{Block, level_map};
use doublet_engine::report::{
    AnticipationChart, Table, anticipation_chart, criterion_table, level_table, mode_rows, qualities_row,
    shown_mode_table,
};
use doublet_engine::run::Slot;
use doublet_engine::study::dynamics::{CATEGORIES, CLASSES, Standard};
use doublet_engine::study::{DynamicsRequest, DynamicsStudy};
use eframe::egui::{ComboBox, Grid, Label, RichText, ScrollArea, Slider, Ui};

use crate::notation;
use crate::panels::aircraft::loading::selected_mass;
use crate::panels::{Panel, PanelContext, awaiting, choices, dim_if, trouble};
use crate::theme;
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::term::column_title_called;

/// Points of an ellipse.
const OUTLINE: usize = 73;
/// Radius of a root.
const ROOT: f32 = 4.0;
/// Width of a slider with its value and name, points.
const SLIDER_ROOM: f32 = 290.0;
/// Width of a column of levels whose words break over lines, points.
const WIDEST: f32 = 250.0;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Aspect {
    #[default]
    Roots,
    Modes,
    Levels,
    Map,
    Anticipation,
}

#[derive(Default)]
pub struct Dynamics {
    aspect: Aspect,
    request: DynamicsRequest,
    /// The request that is answered or under way.
    asked: DynamicsRequest,
}

impl Panel for Dynamics {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let slot = &ctx.snapshot.inquiries.dynamics;
        let all = [
            (Aspect::Roots, "Roots"),
            (Aspect::Modes, "Modes"),
            (Aspect::Levels, "Levels"),
            (Aspect::Map, "Level map"),
            (Aspect::Anticipation, "Control anticipation"),
        ];
        ui.horizontal_wrapped(|ui| choices(ui, &mut self.aspect, &all));
        let moved = slot.latest().is_some_and(|study| self.controls(ctx, ui, study));
        self.ask(slot, moved);
        ctx.wanted.inquiry.dynamics = Some(self.asked);
        trouble(ui, slot.error());
        let Some(study) = slot.latest() else {
            if slot.error().is_none() {
                awaiting(ctx, ui, "the identified model", "Modes and levels need an identified model.");
            }
            return;
        };
        dim_if(ui, matches!(slot, Slot::Cancelled { .. } | Slot::Failed { .. }));
        match self.aspect {
            Aspect::Roots => roots(ctx, ui, study),
            Aspect::Modes => document(ctx, ui, &modes(study)),
            Aspect::Levels => levels(ui, study),
            Aspect::Map => ctx.document(ui, &level_map(&qualities_row(study))),
            Aspect::Anticipation => anticipation(ctx, ui, study),
        }
    }
}

impl Dynamics {
    /// Asks for the trim on the sliders. While one moves, each answer is awaited before the next is asked for, so that the roots move with
    /// it, and no draws are made; they follow when it rests.
    fn ask(&mut self, slot: &Slot<DynamicsStudy>, moved: bool) {
        let wanted = DynamicsRequest { samples: if moved { 0 } else { self.request.samples }, ..self.request };
        let is_answered = slot.ready().is_some_and(|study| study.request == self.asked) || slot.error().is_some();
        if is_answered || !moved {
            self.asked = wanted;
        }
    }

    /// The trim; whether a slider is being moved.
    fn controls(&mut self, ctx: &PanelContext<'_>, ui: &mut Ui, study: &DynamicsStudy) -> bool {
        let condition = &study.condition;
        let mut moved = false;
        ui.horizontal_wrapped(|ui| {
            let request = &mut self.request;
            let speed = request.airspeed_m_s.unwrap_or(condition.airspeed_m_s);
            let ends = 0.5 * condition.airspeed_m_s..=2.0 * condition.airspeed_m_s;
            request.airspeed_m_s =
                Self::slide(ui, &mut moved, speed, ends, "airspeed [m/s]", 1).or(request.airspeed_m_s);
            let altitude = request.altitude_m.unwrap_or(condition.altitude_m);
            request.altitude_m =
                Self::slide(ui, &mut moved, altitude, 0.0..=10_000.0, "altitude [m]", 0).or(request.altitude_m);
            let delay_s = request.stick_delay_s.unwrap_or(0.0);
            request.stick_delay_s =
                Self::slide(ui, &mut moved, delay_s, 0.0..=0.5, "stick delay [s]", 3).or(request.stick_delay_s);
            let aileron = request.aileron_rad.unwrap_or(0.0).to_degrees();
            let chosen = Self::slide(ui, &mut moved, aileron, 0.0..=30.0, "full aileron [deg]", 1)
                .filter(|chosen| *chosen > 0.0);
            request.aileron_rad = chosen.map(f64::to_radians).or(request.aileron_rad);
            if let Some((aboard, room)) = fuel(ctx) {
                let fuel = request.fuel_kg.unwrap_or(aboard);
                request.fuel_kg = Self::slide(ui, &mut moved, fuel, 0.0..=room, "fuel [kg]", 1).or(request.fuel_kg);
            }
            choose_standard(ui, &mut request.standard);
            for (name, chosen, all, shown) in [
                ("class", &mut request.class, &CLASSES[..], study.airplane.class),
                ("category", &mut request.category, &CATEGORIES[..], study.airplane.category),
            ] {
                ComboBox::from_id_salt(name).selected_text(format!("{name} {shown}")).width(90.0).show_ui(ui, |ui| {
                    ui.selectable_value(chosen, None, "as usual");
                    for (place, text) in all.iter().enumerate() {
                        ui.selectable_value(chosen, Some(place), *text);
                    }
                });
            }
            if ui.button("As flown").on_hover_text("Median condition of the identification manoeuvres").clicked() {
                let DynamicsRequest { standard, class, category, stick_delay_s, aileron_rad, .. } = *request;
                let usual = DynamicsRequest::default();
                *request = DynamicsRequest { standard, class, category, stick_delay_s, aileron_rad, ..usual };
            }
        });
        moved
    }

    fn slide(
        ui: &mut Ui,
        moved: &mut bool,
        value: f64,
        ends: RangeInclusive<f64>,
        text: &str,
        decimals: usize,
    ) -> Option<f64> {
        let mut chosen = value;
        // A slider does not break: it begins the next line where it would end beyond this one.
        if ui.available_size_before_wrap().x < SLIDER_ROOM {
            ui.end_row();
        }
        let slider = ui.add(Slider::new(&mut chosen, ends).text(text).fixed_decimals(decimals));
        *moved |= slider.dragged();
        // A slider rounds what it is given: that is no choice.
        (slider.changed() && (slider.dragged() || slider.has_focus())).then_some(chosen)
    }
}

/// Choice of the standard that judges the levels.
pub(super) fn choose_standard(ui: &mut Ui, standard: &mut Standard) {
    let combo = ComboBox::from_id_salt("standard").selected_text(standard.title()).width(120.0);
    let combo = combo.show_ui(ui, |ui| {
        for choice in Standard::ALL {
            ui.selectable_value(standard, choice, choice.title());
        }
    });
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("standard"));
}

/// Fuel in the manoeuvres of the chosen flight (median), as the analysis takes it, or of its loading, and what the tanks hold, kg.
fn fuel(ctx: &PanelContext<'_>) -> Option<(f64, f64)> {
    let aircraft = ctx.snapshot.aircraft.latest()?;
    let sum = |loading: &Loading| loading.fuel_kg.values().sum::<f64>();
    let flown = selected_mass(ctx)
        .and_then(|flown| median(&mut flown.windows.iter().map(|(_, state)| sum(&state.loading)).collect::<Vec<_>>()));
    let aboard = flown.unwrap_or_else(|| sum(&aircraft.aircraft.standard_loading));
    let room: f64 = aircraft.aircraft.tanks.iter().map(|tank| tank.capacity_kg).sum();
    (room > 0.0).then_some((aboard, room))
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

/// Draws blocks that may be higher than the panel.
fn document(ctx: &mut PanelContext<'_>, ui: &mut Ui, blocks: &[Block]) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| ctx.document(ui, blocks));
}

/// Modes with their intervals, and what is to be known of them.
fn modes(study: &DynamicsStudy) -> Vec<Block> {
    let about = "± is one standard error, from the corrected covariance of the derivatives.".to_owned();
    let notes = study.notes.iter().map(|note| notation::raise_powers(note));
    let words = std::iter::once(about).chain(notes).map(Block::Paragraph);
    std::iter::once(Block::Table(shown_mode_table(&mode_rows(study)))).chain(words).collect()
}

/// Levels of flying qualities, then the paragraphs of all criteria and what is needed for those not judged.
fn levels(ui: &mut Ui, study: &DynamicsStudy) {
    let found = qualities_row(study);
    let worst = found.level.unwrap_or("not judged");
    let line = format!("{}, {}: {worst}, {}", found.standard, found.airplane_from, found.extent());
    ui.add(Label::new(line).wrap());
    let note = notation::raise_powers(&found.note);
    ui.add(Label::new(notation::typeset_in(&note, 13.0, ui.visuals().weak_text_color())).wrap());
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        for table in [level_table(&found), criterion_table(&found)] {
            ui.add_space(6.0);
            whole_table(ui, &table);
        }
    });
}

/// A table of the report with every row and every word, in a scroll area of the caller.
pub(super) fn whole_table(ui: &mut Ui, table: &Table) {
    ui.add(Label::new(RichText::new(&table.caption).size(11.5).weak()).wrap());
    Grid::new(&table.name).striped(true).max_col_width(WIDEST).show(ui, |ui| {
        for column in &table.columns {
            column_title_called(ui, &column.title(), &column.heading);
        }
        ui.end_row();
        for row in &table.rows {
            for (cell, column) in row.iter().zip(&table.columns) {
                ui.add(Label::new(notation::typeset(&cell.readable(column.digits), 13.0)).wrap());
            }
            ui.end_row();
        }
    });
}

/// Control anticipation over short-period damping in logarithms, with the lines of all levels.
fn anticipation(ctx: &mut PanelContext<'_>, ui: &mut Ui, study: &DynamicsStudy) {
    let Some(AnticipationChart { places, levels, estimate, samples, .. }) = anticipation_chart(study) else {
        ui.weak("Control anticipation needs a damped short period and an elevator.");
        return;
    };
    let palette = theme::palette(ui);
    let color = |index: usize| palette.series[index % palette.series.len()];
    let mut chart = Chart::new("control anticipation", "short-period damping", "CAP [rad/s²/g]");
    [chart.places, chart.upright_places] = places;
    chart.curves.push(ChartCurve::new("samples", color(7), ChartStyle::Dots(1.5), samples));
    chart.curves.extend(levels.into_iter().map(|(level, corners)| {
        let style = if level == 3 { ChartStyle::Dashed } else { ChartStyle::Line };
        ChartCurve::new(format!("Level {level}"), color(usize::from(level) + 1), style, corners)
    }));
    chart.curves.push(ChartCurve::new("estimate", color(1), ChartStyle::Dots(ROOT), vec![estimate]));
    let height = ui.available_height();
    ctx.chart(ui, &chart, height);
}
