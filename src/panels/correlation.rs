//! Correlation of the estimated parameters of one coefficient.

use doublet_engine::stage::CoefficientFit;
use eframe::egui::{RichText, Ui};

use super::{Panel, PanelContext, awaiting, is_window_constant, trouble};
use crate::notation;
use crate::theme;
use crate::ui_state::Scope;
use crate::widgets::matrix_view::MatrixView;

/// Correlations from here on deserve attention (Klein and Morelli 2006, section 5.1: 0.9).
const NOTABLE: f64 = 0.9;

/// The panel.
#[derive(Default)]
pub struct Correlation {
    chosen: usize,
}

impl Panel for Correlation {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let only = ctx.selection().scope == Scope::Chosen;
        let (fits, stale) = if only {
            let slot = ctx.results().map(|results| &results.fits);
            let fits = slot.and_then(|slot| slot.latest()).map_or(&[][..], |fits| fits.fits.as_slice());
            (fits, slot.is_some_and(|slot| slot.is_stale()))
        } else {
            let slot = &ctx.snapshot.pooled;
            (slot.latest().map_or(&[][..], |pooled| pooled.fits.as_slice()), slot.is_stale())
        };
        let fits: Vec<&CoefficientFit> = fits.iter().collect();
        if fits.is_empty() {
            return awaiting(ctx, ui, "the estimate", "There is no estimate yet.");
        }
        self.chosen = self.chosen.min(fits.len() - 1);
        ui.horizontal(|ui| {
            for (at, fit) in fits.iter().enumerate() {
                ui.selectable_value(&mut self.chosen, at, fit.coefficient.name());
            }
            let of = if only { ctx.selection().window.clone().unwrap_or_default() } else { "all windows".to_owned() };
            ui.weak(format!("{of}; outlined from {NOTABLE} on"));
        });
        let fit = match &fits[self.chosen].fit {
            Ok(fit) => fit,
            Err(error) => return trouble(ui, Some(&error.to_string())),
        };
        let shown: Vec<usize> = (0..fit.names.len())
            .filter(|&at| ctx.selection().constants || !is_window_constant(&fit.names[at]))
            .collect();
        let names: Vec<String> = shown.iter().map(|&at| notation::derivative(&fit.names[at])).collect();
        let values: Vec<f64> =
            shown.iter().flat_map(|&row| shown.iter().map(move |&column| fit.correlation[(row, column)])).collect();
        let labels: Vec<&str> = names.iter().map(String::as_str).collect();
        let condition = notation::number(fit.condition_number);
        ui.label(RichText::new(format!("condition number {condition}")).color(theme::palette(ui).ignored));
        let view = MatrixView {
            name: "correlation of parameters",
            labels: &labels,
            values: &values,
            full_scale: 1.0,
            notable: NOTABLE,
            stale,
        };
        ctx.figures.extend(view.show(ui).1);
    }
}
