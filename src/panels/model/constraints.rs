//! What is known of a derivative before the fit: the menu of a tick, and the sign beside it.

use doublet_core::estimate::Constraint;
use doublet_core::model::{Coefficient, Term};
use doublet_engine::session::{Edit, EstimationEdit, TermConstraint};
use eframe::egui::{Grid, Popup, PopupCloseBehavior, Response, RichText, Ui};

use crate::notation;
use crate::panels::PanelContext;
use crate::panels::results::intervals;
use crate::widgets::quantity_edit::QuantityEdit;

/// Digits of the values a constraint begins with.
const DIGITS: i32 = 3;
/// Range that a bound begins with about the estimate, and deviation of a prior, as a part of it.
const SPREAD: f64 = 0.5;

/// Sign beside the tick of a derivative of which something is known.
pub fn sign(known: Constraint) -> &'static str {
    match known {
        Constraint::Free => "",
        Constraint::Fixed(_) => "=",
        Constraint::Bounds { .. } => "[ ]",
        Constraint::Prior { .. } => "±",
    }
}

/// Lets the user state what is known of the derivative of `coefficient` by `term`, on a secondary click on its tick.
pub fn menu(ctx: &mut PanelContext<'_>, tick: &Response, coefficient: Coefficient, term: &Term) {
    // A click on a choice must leave its numbers at hand.
    let stays = Popup::context_menu(tick).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    stays.show(|ui| {
        let name = term.derivative_name(coefficient);
        ui.label(notation::derivative_job(ui, &name));
        let now = ctx.session.estimation.known(coefficient, term);
        let estimate = ctx.snapshot.pooled.latest().and_then(|pooled| intervals::estimate(&pooled.fits, &name));
        let with = |known| {
            let term = term.clone();
            Edit::Estimation(EstimationEdit::Constrain(TermConstraint { coefficient, term, known }))
        };
        let value = notation::rounded(estimate.map_or(0.0, |(value, _)| value), DIGITS);
        let spread = notation::rounded(SPREAD * value.abs(), DIGITS).max(1e-3);
        let begins = [
            ("Free", "Estimated from the data alone", Constraint::Free),
            ("Fixed", "Fixed value: no error, one parameter less", Constraint::Fixed(value)),
            (
                "Bounds",
                "Limited to this range; held at a bound",
                Constraint::Bounds { lower: value - spread, upper: value + spread },
            ),
            (
                "Prior",
                "Prior value with standard deviation, from wind tunnel or handbook",
                Constraint::Prior { mean: value, deviation: spread },
            ),
        ];
        ui.horizontal(|ui| {
            for (label, hint, begin) in begins {
                let on = std::mem::discriminant(&now) == std::mem::discriminant(&begin);
                if ui.selectable_label(on, label).on_hover_text(hint).clicked() && !on {
                    ctx.edit(with(begin));
                }
            }
        });
        Grid::new("known").num_columns(2).show(ui, |ui| numbers(ctx, ui, (&name, now), &with));
        if let Some((value, error)) = estimate {
            ui.weak(format!("pooled {} ± {}", notation::number(value), notation::number(error)));
        }
    });
}

fn numbers(
    ctx: &mut PanelContext<'_>,
    ui: &mut Ui,
    (derivative, now): (&str, Constraint),
    with: &impl Fn(Constraint) -> Edit,
) {
    let mut number = |label: &str, value: f64, known: &dyn Fn(f64) -> Constraint| {
        ui.label(RichText::new(label).weak());
        let allowed = if label == "deviation" { f64::MIN_POSITIVE..=f64::INFINITY } else { f64::MIN..=f64::MAX };
        let name = format!("{label} of {derivative}");
        let per_point = 0.005 * value.abs().max(1e-3);
        let edited = QuantityEdit::new(&name, value).per_point(per_point).allowed(allowed).show(ui);
        ctx.edit_quantity(edited, |value| with(known(value)));
        ui.end_row();
    };
    match now {
        Constraint::Free => {}
        Constraint::Fixed(value) => number("value", value, &Constraint::Fixed),
        Constraint::Bounds { lower, upper } => {
            number("lower", lower, &|lower| Constraint::Bounds { lower, upper });
            number("upper", upper, &|upper| Constraint::Bounds { lower, upper });
        }
        Constraint::Prior { mean, deviation } => {
            number("mean", mean, &|mean| Constraint::Prior { mean, deviation });
            number("deviation", deviation, &|deviation| Constraint::Prior { mean, deviation });
        }
    }
}
