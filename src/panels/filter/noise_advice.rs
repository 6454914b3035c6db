//! Words and buttons of the advice on the noise of a measurement: both estimates, the NIS each gives, the reason where they differ.

use doublet_core::reconstruct::Measurement;
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

/// A deviation with its unit.
fn with_unit(ctx: &PanelContext<'_>, measurement: Measurement, std: f64) -> String {
    let (unit, scale) = ctx.unit(measurement.dimension());
    format!("{} {unit}", notation::number(scale * std))
}

/// An estimate with its unit and the NIS ratio of its measurement.
fn with_nis(ctx: &PanelContext<'_>, advice: &NoiseAdvice, estimate: NoiseEstimate) -> String {
    format!("{} (NIS ratio {})", with_unit(ctx, advice.measurement, estimate.std), nis(estimate))
}

fn nis(estimate: NoiseEstimate) -> String {
    doublet_engine::notation::significant(estimate.nis, 2)
}

/// What the NIS ratio of a measurement is.
const NIS_RATIO: &str = "NIS ratio: squared innovation of this measurement over its prediction; 1 is ideal";

/// What to do, and why.
pub fn advice_text(ctx: &PanelContext<'_>, advice: &NoiseAdvice) -> String {
    let estimate_text = |estimate| with_nis(ctx, advice, estimate);
    let reason = &advice.reason;
    let because = if reason.is_empty() { String::new() } else { format!(": {reason}") };
    match (advice.step, advice.innovations, advice.steady) {
        (NoiseStep::Differ, Some(one), Some(other)) => {
            let step = match advice.recommended() {
                Some(set) => format!("Set {}", with_unit(ctx, advice.measurement, set.std)),
                None => format!("Keep {}", with_unit(ctx, advice.measurement, advice.used.std)),
            };
            format!("Innovations give {}, steady flight {}{because}. {step}.", estimate_text(one), estimate_text(other))
        }
        (NoiseStep::Set, Some(one), Some(other)) => {
            format!(
                "Set {}; now NIS ratio {}. Steady flight agrees: {}.",
                estimate_text(one),
                nis(advice.used),
                estimate_text(other)
            )
        }
        (NoiseStep::Set, Some(one), None) => format!("Set {}; now NIS ratio {}.", estimate_text(one), nis(advice.used)),
        (NoiseStep::NotNoise, _, Some(other)) => {
            format!("{}. Steady flight gives {}.", capitalised(reason), estimate_text(other))
        }
        (NoiseStep::NotNoise, _, None) => format!("{}.", capitalised(reason)),
        _ if !reason.is_empty() => format!("{}.", capitalised(reason)),
        (_, _, Some(other)) => {
            format!("Consistent: keep {}. Steady flight agrees: {}.", estimate_text(advice.used), estimate_text(other))
        }
        _ => format!("Consistent: keep {}.", estimate_text(advice.used)),
    }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The estimates as buttons that take them: both where they differ, that of the innovations first.
pub fn buttons(ctx: &mut PanelContext<'_>, ui: &mut Ui, name: &str, advice: &NoiseAdvice) {
    let hint = advice_text(ctx, advice);
    let recommended = advice.recommended();
    let both = [(advice.innovations, "innovations", "flight"), (advice.steady, "recorded", "steady")];
    let shown = both.into_iter().filter(|(_, label, _)| match advice.step {
        NoiseStep::Differ => true,
        NoiseStep::Set => *label == "innovations",
        NoiseStep::Keep | NoiseStep::NotNoise => *label == "recorded",
    });
    let is_both = advice.step == NoiseStep::Differ;
    ui.vertical(|ui| {
        ui.set_min_width(PROPOSAL);
        ui.spacing_mut().item_spacing.y = 1.0;
        for (estimate, label, short) in shown {
            let is_offered = |estimate: &NoiseEstimate| is_both || advice.is_no_worse(*estimate);
            let Some(estimate) = estimate.filter(is_offered) else { continue };
            let (_, scale) = ctx.unit(advice.measurement.dimension());
            let is_recommended = recommended == Some(estimate);
            let is_other = is_both && label == "recorded";
            let mut text = RichText::new(format!("⇐ {}", notation::number(scale * estimate.std))).size(11.0);
            if is_other {
                text = text.weak();
            } else if is_recommended && advice.step != NoiseStep::NotNoise {
                text = text.color(theme::palette(ui).warning);
            }
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                let is_set = estimate.std == advice.used.std;
                let take = ui.add_enabled(!is_set, Button::new(text).small());
                let take = take.on_hover_text(&hint).on_disabled_hover_text(&hint);
                ui.ctx().accesskit_node_builder(take.id, |node| node.set_label(format!("take {label} {name}")));
                if take.clicked() {
                    ctx.edit(Edit::noise(NoiseChannel::Measurement(advice.measurement), estimate.std));
                }
                let beside = if is_both || advice.step == NoiseStep::NotNoise { short } else { "" };
                let nis_text = format!("{beside} NIS ratio {}", nis(estimate));
                let response =
                    ui.add(egui::Label::new(RichText::new(nis_text.trim()).size(10.5).weak()).selectable(false));
                response.on_hover_text(format!("{hint}\n{NIS_RATIO}"));
            });
        }
    });
}
