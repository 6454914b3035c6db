//! Words and buttons of the advice on the noise of a measurement: both estimates, the NIS each gives, the reason where they differ.

use doublet_core::reconstruct::Measurement;
use doublet_core::reconstruct::consistency::WORTH_CHANGING;
use doublet_engine::session::{Edit, NoiseChannel};
use doublet_engine::stage::{NoiseAdvice, NoiseEstimate, NoiseStep};
use eframe::egui::{self, Button, RichText, Ui};

use crate::panels::PanelContext;
use crate::panels::filter::noise::PROPOSAL;
use crate::{notation, theme};

/// The advice on a measurement of the chosen manoeuvre.
pub fn find<'a>(ctx: &PanelContext<'a>, measurement: Measurement) -> Option<&'a NoiseAdvice> {
    ctx.details()?.noise.iter().find(|advice| advice.measurement == measurement)
}

/// The noise of a measurement by the innovations of all manoeuvres, SI.
fn of_all(ctx: &PanelContext<'_>, measurement: Measurement) -> Option<f64> {
    let all = &ctx.details()?.noise_of_all;
    all.iter().find(|(of, _)| *of == measurement).map(|(_, std)| *std)
}

/// A deviation with its unit.
fn with_unit(ctx: &PanelContext<'_>, measurement: Measurement, std: f64) -> String {
    let (unit, scale) = ctx.unit(measurement.dimension());
    format!("{} {unit}", notation::number(scale * std))
}

fn nis(estimate: NoiseEstimate) -> String {
    doublet_engine::notation::significant(estimate.nis, 2)
}

/// What the NIS ratio of a measurement is.
const NIS_RATIO: &str = "NIS ratio: squared innovation of this measurement over its prediction; 1 is ideal";

/// What to do, and why.
pub fn advice_text(ctx: &PanelContext<'_>, advice: &NoiseAdvice) -> String {
    advice.text(&|std| with_unit(ctx, advice.measurement, std))
}

/// The estimates as buttons that take them: by the innovations of this manoeuvre and of all, by steady flight.
pub fn buttons(ctx: &mut PanelContext<'_>, ui: &mut Ui, name: &str, advice: &NoiseAdvice) {
    let hint = advice_text(ctx, advice);
    let is_both = advice.step == NoiseStep::Differ;
    let by_innovations = matches!(advice.step, NoiseStep::Set | NoiseStep::Differ);
    let is_offered = |estimate: &NoiseEstimate| is_both || advice.is_no_worse(*estimate);
    let nis_text = |estimate: NoiseEstimate| format!("NIS ratio {}", nis(estimate));
    let this = advice.innovations.filter(|_| by_innovations).filter(is_offered);
    let all = of_all(ctx, advice.measurement).filter(|std| is_worth(*std, advice.used.std));
    let steady = advice.steady.filter(|_| advice.step != NoiseStep::Set).filter(is_offered);
    let offers = [
        this.map(|one| (one.std, "innovations", format!("this manoeuvre\n{}", nis_text(one)))),
        all.map(|std| (std, "all manoeuvres", "all manoeuvres".to_owned())),
        steady.map(|one| (one.std, "recorded", format!("steady\n{}", nis_text(one)))),
    ];
    let recommended = advice.recommended().map(|one| one.std);
    let (_, scale) = ctx.unit(advice.measurement.dimension());
    ui.vertical(|ui| {
        ui.set_min_width(PROPOSAL);
        ui.spacing_mut().item_spacing.y = 1.0;
        for (std, label, beside) in offers.into_iter().flatten() {
            let mut text = RichText::new(format!("⇐ {}", notation::number(scale * std))).size(11.0);
            if label == "recorded" && is_both {
                text = text.weak();
            } else if recommended == Some(std) {
                text = text.color(theme::palette(ui).warning);
            }
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                let take = ui.add_enabled(std != advice.used.std, Button::new(text).small());
                let take = take.on_hover_text(&hint).on_disabled_hover_text(&hint);
                ui.ctx().accesskit_node_builder(take.id, |node| node.set_label(format!("take {label} {name}")));
                if take.clicked() {
                    ctx.edit(Edit::noise(NoiseChannel::Measurement(advice.measurement), std));
                }
                let words = egui::Label::new(RichText::new(beside).size(10.5).weak()).selectable(false);
                ui.add(words).on_hover_text(format!("{hint}\n{NIS_RATIO}"));
            });
        }
    });
}

/// Whether a deviation differs from the one in use by more than is left alone.
fn is_worth(std: f64, used: f64) -> bool {
    !(1.0 / WORTH_CHANGING..=WORTH_CHANGING).contains(&(std / used))
}
