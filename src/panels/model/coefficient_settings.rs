//! Axes, reference point, thrust and rotors of the coefficients, and what controls do between their recording and the air.

use doublet_core::model::{Axes, Gyroscopic, ThrustTreatment};
use doublet_engine::session::{AngularAcceleration, Edit, EstimationEdit, MomentReference, Preparation, Surface};
use doublet_engine::study::{ControlLag, LagKind, Study};
use eframe::egui::{Button, Grid, Ui};

use crate::panels::{PanelContext, choices, study_button, trouble};
use crate::widgets::quantity_edit::QuantityEdit;

/// Names of the axes of a point.
const AXES: [&str; 3] = ["aft", "right", "up"];

/// Draws the settings.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let now = &ctx.session.preparation;
    let mut next = now.clone();
    Grid::new("coefficients").num_columns(2).spacing([10.0, 3.0]).show(ui, |ui| {
        ui.weak("Axes").on_hover_text("Axes of moments, roll rate and yaw rate; CL and CD always use wind axes");
        choices(ui, &mut next.axes, &[(Axes::Body, "Body"), (Axes::Stability, "Stability")]);
        ui.end_row();
        ui.weak("Moments about");
        let loaded = ctx.snapshot.aircraft.latest();
        let stated = loaded.and_then(|data| data.aircraft.moment_reference_from_datum_m);
        let point = next.moment_reference.from_datum_m(stated).unwrap_or_default();
        let all = [
            (MomentReference::Aircraft, if stated.is_some() { "Aircraft's point" } else { "As the aircraft: CG" }),
            (MomentReference::CentreOfGravity, "CG"),
            (MomentReference::Datum(point), "Point"),
        ];
        choices(ui, &mut next.moment_reference, &all);
        ui.end_row();
        ui.weak("Thrust").on_hover_text("Thrust in the coefficients; needs an engine model or a thrust channel");
        let all = [
            (ThrustTreatment::Included, "Inside"),
            (ThrustTreatment::ForceRemoved, "Force out"),
            (ThrustTreatment::Removed, "Removed from CX and Cm"),
        ];
        choices(ui, &mut next.thrust, &all);
        ui.end_row();
        ui.weak("Propellers").on_hover_text("Gyroscopic moment of the propellers, if their speeds are known");
        let all =
            [(Gyroscopic::Signed, "Own sense"), (Gyroscopic::Summed, "All alike"), (Gyroscopic::Ignored, "Left out")];
        choices(ui, &mut next.gyroscopic, &all);
        ui.end_row();
        ui.weak("Angular acceleration").on_hover_text("Differentiated rates, a smoother state, or a recorded channel");
        let all = [
            (AngularAcceleration::Differentiated, "Differentiated"),
            (AngularAcceleration::Smoother, "Smoother"),
            (AngularAcceleration::Recorded, "Recorded"),
        ];
        choices(ui, &mut next.angular_acceleration, &all);
        ui.end_row();
    });
    if next != *now {
        ctx.edit(Edit::Estimation(EstimationEdit::Preparation(next)));
    }
    if let MomentReference::Datum(point) = now.moment_reference {
        reference_point(ctx, ui, point);
    }
    lags(ctx, ui);
}

/// The point the moments are about, from the datum.
fn reference_point(ctx: &mut PanelContext<'_>, ui: &mut Ui, point: [f64; 3]) {
    ui.horizontal_wrapped(|ui| {
        ui.weak("Point from the datum");
        for (axis, name) in AXES.into_iter().enumerate() {
            let label = format!("moment reference {name}");
            let edited = QuantityEdit::new(&label, point[axis]).unit("m", 1.0).per_point(1e-3).show(ui);
            ctx.edit_quantity(edited, |value| {
                let mut point = point;
                point[axis] = value;
                let moment_reference = MomentReference::Datum(point);
                Edit::Estimation(EstimationEdit::Preparation(Preparation {
                    moment_reference,
                    ..ctx.session.preparation.clone()
                }))
            });
        }
    });
}

/// Lag and delay of each control, beside what the fit finds for them.
fn lags(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let slot = &ctx.snapshot.studies.lags;
    Grid::new("lags").num_columns(5).spacing([10.0, 3.0]).show(ui, |ui| {
        ui.weak("Control");
        ui.weak("First-order lag").on_hover_text("Time constant between recorded and acting deflection");
        ui.weak("");
        ui.weak("Delay").on_hover_text("Negative if the deflection was recorded late");
        ui.end_row();
        for surface in Surface::ALL {
            let lag = ctx.session.preparation.control_lags.get(surface);
            ui.label(surface.name());
            let parts =
                [(LagKind::FirstOrder, "lag", lag.time_constant_s, 0.0), (LagKind::Delay, "delay", lag.delay_s, -2.0)];
            for (kind, what, value, lowest) in parts {
                let edit = |value| Edit::Estimation(EstimationEdit::ControlLag(surface, kind.set(lag, value)));
                let name = format!("{} {what}", surface.name());
                let field = QuantityEdit::new(&name, value).unit("ms", 1e3).per_point(1.0).allowed(lowest..=2.0);
                let edited = field.show(ui);
                ctx.edit_quantity(edited, edit);
                if let Some(value) = take(ui, slot.latest().and_then(|study| study.get(surface, kind)), slot.is_stale())
                {
                    ctx.edit(edit(value));
                }
            }
            ui.end_row();
        }
    });
    ui.horizontal(|ui| {
        let hint = "Best-fitting lag and delay of each control, one at a time";
        study_button(ctx, ui, (Study::Lags, slot), "Find lags of the controls", hint);
    });
    trouble(ui, slot.error());
}

/// What the fit found, to be taken by a click: the value, s.
fn take(ui: &mut Ui, found: Option<&ControlLag>, is_stale: bool) -> Option<f64> {
    let Some(found) = found else {
        ui.weak("");
        return None;
    };
    match found.found_s() {
        Ok((value, error)) => {
            let text = format!("{:.1} ± {:.1} ms", 1e3 * value, 1e3 * error);
            let button = ui.add_enabled(!is_stale, Button::new(text).small()).on_hover_text("Use the fitted value");
            button.on_disabled_hover_text("The session has changed: find again").clicked().then_some(value)
        }
        Err(error) => {
            ui.weak("none").on_hover_text(error.to_string());
            None
        }
    }
}
