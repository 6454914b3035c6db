//! How the filter works, and how coefficients are formed from its path.

use doublet_core::reconstruct::{InputHold, Method};
use doublet_engine::session::{Edit, EstimationEdit, FilterEdit, GravitySource, PathSource, Preparation};
use eframe::egui::{CollapsingHeader, Grid, Id, Ui};

use crate::panels::{PanelContext, choices};
use crate::widgets::quantity_edit::QuantityEdit;

/// Half width of the differentiation that a tick switches on, s.
const HALF_WIDTH_S: f64 = 0.2;
/// Width of the longest name before a setting: the columns stay where they are when a row comes or goes.
const COLUMN: f32 = 96.0;

/// Width from which two settings stand in a row.
const FOUR_COLUMNS: f32 = 590.0;

/// What the kinds of filter are.
const ABOUT_FILTER: &str = "EKF: extended Kalman filter. Iterated: relinearises about its own update until converged (IEKF). Unscented: propagates sigma points instead of derivatives (UKF)";

/// Filter, path, and how coefficients follow from the path.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    filter(ctx, ui);
    CollapsingHeader::new("Coefficients from the path").show(ui, |ui| preparation(ctx, ui));
}

/// The limits of innovations, in one row: beyond the one a spike is left out, beyond the other a measurement weighs less.
fn limits(ui: &mut Ui, ctx: &mut PanelContext<'_>, narrow: bool) {
    let [outliers, robust] = [ctx.session.filter.outlier_limit, ctx.session.filter.robust_limit];
    ui.weak("Outliers beyond").on_hover_text(
        "Rejects spikes of up to three samples beyond this many standard deviations. At least 3; 0 turns it off",
    );
    let limit = QuantityEdit::new("outlier limit", outliers).unit("σ", 1.0).per_point(0.1);
    let edited = limit.allowed(0.0..=1000.0).show(ui);
    ctx.edit_quantity(edited, |value| {
        // Below three, noise itself would be left out.
        let value = if value < 1.5 { 0.0 } else { value.max(3.0) };
        Edit::Filter(FilterEdit::OutlierLimit(value))
    });
    break_row(ui, narrow);
    ui.weak("Huber beyond").on_hover_text(
        "Innovations beyond this many standard deviations weigh less. At least 1; 1.345 to 3 is usual; 0 turns it off",
    );
    let limit = QuantityEdit::new("robust limit", robust).unit("σ", 1.0).per_point(0.05);
    let edited = limit.allowed(0.0..=1000.0).show(ui);
    ctx.edit_quantity(edited, |value| {
        let value = if value < 0.5 { 0.0 } else { value.max(1.0) };
        Edit::Filter(FilterEdit::RobustLimit(value))
    });
    ui.end_row();
}

/// Ends the row between two settings of a narrow panel.
fn break_row(ui: &mut Ui, narrow: bool) {
    if narrow {
        ui.end_row();
    }
}

fn filter(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let filter = &ctx.session.filter;
    let narrow = ui.available_width() < FOUR_COLUMNS;
    let (id, columns) = if narrow { ("narrow filter", 2) } else { ("filter", 4) };
    Grid::new(id).num_columns(columns).min_col_width(COLUMN).spacing([10.0, 4.0]).show(ui, |ui| {
        ui.weak("Filter").on_hover_text(ABOUT_FILTER);
        let [iterated, unscented] = kinds(ui, &ctx.session.title, filter.method);
        let mut method = filter.method;
        if choices(ui, &mut method, &[(Method::Ekf, "EKF"), (iterated, "Iterated"), (unscented, "Unscented")]) {
            ctx.edit(Edit::Filter(FilterEdit::Method(method)));
        }
        break_row(ui, narrow);
        ui.weak("Input hold").on_hover_text("Interpolation of the inertial sensors between samples");
        let mut hold = filter.hold;
        if choices(ui, &mut hold, &[(InputHold::FirstOrder, "Linear"), (InputHold::ZeroOrder, "Held")]) {
            ctx.edit(Edit::Filter(FilterEdit::Hold(hold)));
        }
        ui.end_row();
        ui.weak("Path used").on_hover_text(
            "Filtered: past data only. Smoothed: whole manoeuvre. Measured: airspeed, flow angles and attitude as recorded, no filter",
        );
        let mut path = ctx.session.preparation.path;
        let all = [(PathSource::Filtered, "Filtered"), (PathSource::Smoothed, "Smoothed"), (PathSource::Measured, "Measured")];
        if choices(ui, &mut path, &all) {
            ctx.edit(Edit::Estimation(EstimationEdit::Path(path)));
        }
        let used = ctx.snapshot.gravity.as_ref();
        break_row(ui, narrow);
        ui.weak("Gravity")
            .on_hover_text(used.map_or("Default: from latitude and altitude", |used| used.origin.as_str()));
        let gravity_m_s2 = match ctx.session.gravity {
            GravitySource::Stated => filter.gravity_m_s2,
            GravitySource::Position => used.map_or(filter.gravity_m_s2, |used| used.m_s2),
        };
        let gravity = QuantityEdit::new("gravity", gravity_m_s2).unit("m/s²", 1.0).per_point(1e-4).allowed(9.7..=9.9);
        let edited = gravity.show(ui);
        ctx.edit_quantity(edited, |value| Edit::Filter(FilterEdit::Gravity(value)));
        ui.end_row();
        limits(ui, ctx, narrow);
        methods(ui, ctx, (iterated, unscented), narrow);
    });
}

/// The settings of each method. Those without an effect are greyed: no row comes or goes under the pointer.
fn methods(ui: &mut Ui, ctx: &mut PanelContext<'_>, (iterated, unscented): (Method, Method), narrow: bool) {
    let method = ctx.session.filter.method;
    let is_smoothed = ctx.session.preparation.path == PathSource::Smoothed;
    let field = |ui: &mut Ui, is_on: bool, field: QuantityEdit<'_>| ui.add_enabled_ui(is_on, |ui| field.show(ui)).inner;
    ui.weak("Smoother passes").on_hover_text("More than one relinearises about the smoothed path");
    let passes = QuantityEdit::new("smoother passes", ctx.session.filter.smoother_passes as f64).per_point(0.1);
    let edited = field(ui, is_smoothed, passes.allowed(1.0..=100.0));
    ctx.edit_quantity(edited, |value| {
        Edit::Filter(FilterEdit::SmootherPasses(value.round().clamp(1.0, 100.0) as usize))
    });
    if let Method::Ukf { spread } = unscented {
        break_row(ui, narrow);
        ui.weak("Spread").on_hover_text("Unscented: distance of the sigma points from the mean");
        let spread = QuantityEdit::new("spread", spread).unit("σ", 1.0).per_point(0.01).allowed(0.1..=10.0);
        let edited = field(ui, method == unscented, spread);
        ctx.edit_quantity(edited, |spread| Edit::Filter(FilterEdit::Method(Method::Ukf { spread })));
    }
    ui.end_row();
    if let Method::Iekf { max_iterations, tolerance } = iterated {
        let is_on = method == iterated;
        ui.weak("Iterations").on_hover_text("Iterated: largest number per sample");
        let iterations = QuantityEdit::new("iterations", max_iterations as f64).per_point(0.1).allowed(1.0..=100.0);
        let edited = field(ui, is_on, iterations);
        ctx.edit_quantity(edited, |value| {
            let max_iterations = value.round().clamp(1.0, 100.0) as usize;
            Edit::Filter(FilterEdit::Method(Method::Iekf { max_iterations, tolerance }))
        });
        break_row(ui, narrow);
        ui.weak("Tolerance").on_hover_text(
            "Iterated: converged when all state changes are below this fraction of the standard deviation",
        );
        let tolerance = QuantityEdit::new("tolerance", tolerance).unit("σ", 1.0).logarithmic().allowed(1e-12..=1.0);
        let edited = field(ui, is_on, tolerance);
        ctx.edit_quantity(edited, |tolerance| {
            Edit::Filter(FilterEdit::Method(Method::Iekf { max_iterations, tolerance }))
        });
        ui.end_row();
    }
}

/// The iterated and the unscented filter with the settings they last had in this session.
fn kinds(ui: &Ui, session: &str, now: Method) -> [Method; 2] {
    let id = Id::unique(("filter settings", session));
    let usual = [Method::USUAL_IEKF, Method::Ukf { spread: Method::USUAL_SPREAD }];
    ui.data_mut(|data| {
        let last = data.get_temp_mut_or(id, usual);
        match now {
            Method::Iekf { .. } => last[0] = now,
            Method::Ukf { .. } => last[1] = now,
            Method::Ekf => {}
        }
        *last
    })
}

/// What happens between the path and the coefficients.
fn preparation(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let now = &ctx.session.preparation;
    let mut next = now.clone();
    ui.horizontal_wrapped(|ui| {
        for (on, text, hint) in [
            (&mut next.correct_accelerometer, "accelerometers", "Moves the specific force to the centre of gravity"),
            (&mut next.correct_vanes, "vanes", "Removes the effect of body rates from the flow angles"),
            (&mut next.correct_antenna, "antenna", "Moves position and ground velocity to the centre of gravity"),
        ] {
            ui.checkbox(on, text).on_hover_text(hint);
        }
    });
    ui.horizontal_wrapped(|ui| {
        let mut local = next.differentiation_half_width_s.is_some();
        let hint = "Angular acceleration by a local parabola; off: central differences (thesis Eq. D.1)";
        if ui.checkbox(&mut local, "local differentiation").on_hover_text(hint).changed() {
            next.differentiation_half_width_s = local.then_some(HALF_WIDTH_S);
        }
        let hint = "Gives the regressors the same smoothing as the differentiated rates";
        ui.checkbox(&mut next.matched_smoothing, "smooth both sides alike").on_hover_text(hint);
    });
    if next != *now {
        ctx.edit(Edit::Estimation(EstimationEdit::Preparation(next)));
    }
    Grid::new("preparation").num_columns(4).spacing([10.0, 4.0]).show(ui, |ui| {
        duration(ctx, ui, ("Settling", "settling", now.settle_s), |value| Preparation {
            settle_s: value,
            ..now.clone()
        });
        if let Some(half_width_s) = now.differentiation_half_width_s {
            let with = |value| Preparation { differentiation_half_width_s: Some(value), ..now.clone() };
            duration(ctx, ui, ("Half width", "half width", half_width_s), with);
        }
        ui.end_row();
    });
}

/// A time of the preparation.
fn duration(
    ctx: &mut PanelContext<'_>,
    ui: &mut Ui,
    (title, name, value): (&str, &str, f64),
    with: impl FnOnce(f64) -> Preparation,
) {
    ui.weak(title);
    let edited = QuantityEdit::new(name, value).unit("s", 1.0).per_point(1e-3).allowed(0.0..=10.0).show(ui);
    ctx.edit_quantity(edited, |value| Edit::Estimation(EstimationEdit::Preparation(with(value))));
}
