//! Correlation of the estimated parameters, and of their regressors (thesis 4.4.3), for all coefficients at once.

use doublet_core::model::Coefficient;
use doublet_engine::stage::{CoefficientFit, RegressorCorrelation};
use doublet_engine::verdict::CONDITION_LIMIT;
use eframe::egui::{
    Align2, FontId, Label, Mesh, Rect, RichText, Role, ScrollArea, Sense, Shape, Stroke, StrokeKind, Ui, UiBuilder,
    Vec2, WidgetInfo, pos2, vec2,
};

use crate::panels::{Panel, PanelContext, awaiting, choices, is_window_constant, lacks_estimate};
use crate::ui_state::Scope;
use crate::widgets::matrix_view::{self, MatrixView};
use crate::{notation, theme};

/// Correlations from here on deserve attention (Klein and Morelli 2006, section 5.1: 0.9).
const NOTABLE: f64 = 0.9;
/// Least size of a matrix with its title, points.
const LEAST: f32 = 240.0;
/// Height of the title of a matrix.
const TITLE: f32 = 20.0;
/// Size of the colour bar, and steps of its colour.
const BAR: [f32; 2] = [150.0, 9.0];
const STEPS: usize = 30;

/// What is correlated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Of {
    #[default]
    Parameters,
    Regressors,
}

/// One coefficient.
struct Block {
    coefficient: Coefficient,
    /// What stands beside its name.
    about: String,
    names: Vec<String>,
    values: Vec<f64>,
    trouble: Option<String>,
}

#[derive(Default)]
pub struct Correlation {
    of: Of,
    /// The one coefficient shown; all of them without.
    only: Option<Coefficient>,
}

impl Panel for Correlation {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let alone = ctx.selection().scope == Scope::Chosen;
        let mut coefficients: Vec<(Option<Coefficient>, &str)> = vec![(None, "All")];
        coefficients.extend(ctx.session.structure.models.iter().map(|(one, _)| (Some(*one), one.name())));
        ui.horizontal_wrapped(|ui| {
            choices(ui, &mut self.of, &[(Of::Parameters, "Parameters"), (Of::Regressors, "Regressors")]);
            ui.separator();
            choices(ui, &mut self.only, &coefficients);
        });
        ui.horizontal_wrapped(|ui| {
            color_bar(ui);
            let source =
                if alone { ctx.selection().window.clone().unwrap_or_default() } else { "all manoeuvres".to_owned() };
            ui.weak(format!("{source}; outlined from {NOTABLE} on"));
        });
        let (blocks, stale) = match self.of {
            Of::Parameters => parameters(ctx, alone),
            Of::Regressors => {
                ctx.wanted.regressors = Some(alone);
                regressors(ctx)
            }
        };
        let blocks: Vec<Block> =
            blocks.into_iter().filter(|block| self.only.is_none_or(|only| only == block.coefficient)).collect();
        if blocks.is_empty() {
            return awaiting(ctx, ui, "the estimate", &lacks_estimate(ctx));
        }
        warnings(ui, self.of, &blocks);
        grid(ctx, ui, self.of, &blocks, stale);
    }
}

/// Those of the parameters, of the chosen window or pooled.
fn parameters(ctx: &PanelContext<'_>, alone: bool) -> (Vec<Block>, bool) {
    let (fits, stale) = if alone {
        let slot = ctx.results().map(|results| &results.fits);
        let fits = slot.and_then(|slot| slot.latest()).map_or(&[][..], |fits| fits.fits.as_slice());
        (fits, slot.is_some_and(|slot| slot.is_stale()))
    } else {
        let slot = &ctx.snapshot.pooled;
        (slot.latest().map_or(&[][..], |pooled| pooled.fits.as_slice()), slot.is_stale())
    };
    let constants = ctx.selection().constants;
    (fits.iter().map(|found| parameter_block(found, constants)).collect(), stale)
}

/// The correlation of the parameters of a fit, with the constants of manoeuvres or without.
fn parameter_block(found: &CoefficientFit, constants: bool) -> Block {
    let (coefficient, empty) = (found.coefficient, String::new());
    let fit = match &found.fit {
        Ok(fit) => fit,
        Err(error) => {
            let trouble = Some(error.to_string());
            return Block { coefficient, about: empty, names: Vec::new(), values: Vec::new(), trouble };
        }
    };
    let is_shown = |at: &usize| constants || !is_window_constant(&fit.names[*at]);
    let shown: Vec<usize> = (0..fit.names.len()).filter(is_shown).collect();
    let values = shown.iter().flat_map(|&row| shown.iter().map(move |&column| fit.correlation[(row, column)]));
    Block {
        coefficient,
        about: format!("condition number {} (limit {CONDITION_LIMIT})", notation::number(fit.condition_number)),
        names: shown.iter().map(|&at| notation::derivative(&fit.names[at])).collect(),
        values: values.collect(),
        trouble: None,
    }
}

/// Those of the regressors.
fn regressors(ctx: &PanelContext<'_>) -> (Vec<Block>, bool) {
    let slot = &ctx.snapshot.details;
    let found = slot.latest().map_or(&[][..], |details| details.regressors.as_slice());
    (found.iter().map(regressor_block).collect(), slot.is_stale())
}

fn regressor_block(found: &RegressorCorrelation) -> Block {
    let size = found.derivatives.len();
    let values = (0..size).flat_map(|row| (0..size).map(move |column| found.correlation[(row, column)]));
    Block {
        coefficient: found.coefficient,
        about: String::new(),
        names: found.derivatives.iter().map(|name| notation::derivative(name)).collect(),
        values: values.collect(),
        trouble: None,
    }
}

/// Pairs that can hardly be told apart, in words.
fn warnings(ui: &mut Ui, of: Of, blocks: &[Block]) {
    let mut pairs = Vec::new();
    for block in blocks {
        let size = block.names.len();
        for row in 0..size {
            for column in 0..row {
                let value = block.values[row * size + column];
                if value.abs() >= NOTABLE {
                    let names = format!("{} and {}", block.names[column], block.names[row]);
                    pairs.push((value.abs(), format!("{names} {}", notation::correlation(value))));
                }
            }
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    if pairs.is_empty() {
        ui.weak(format!("None reaches {NOTABLE}."));
        return;
    }
    let what = match of {
        Of::Parameters => "These derivatives are hard to separate",
        Of::Regressors => "These regressors are nearly proportional in these manoeuvres",
    };
    let text = format!("{what}: {}", pairs.iter().map(|pair| pair.1.as_str()).collect::<Vec<_>>().join(", "));
    ui.add(Label::new(notation::typeset_in(&text, 11.5, theme::palette(ui).warning)).wrap());
}

/// Room between two matrices, points.
const BETWEEN: Vec2 = vec2(8.0, 6.0);

/// Columns, and size of the place of a matrix, by which `matrices` (rows, width of the longest name) have the largest cells in `room`.
fn arrange(room: Vec2, matrices: &[(usize, f32)]) -> (usize, Vec2) {
    let place = |across: usize| {
        let width = room.x / across as f32;
        vec2(width, (room.y / matrices.len().div_ceil(across) as f32).max(LEAST.min(width)))
    };
    let cell = |across: usize| {
        let inner = place(across) - BETWEEN - vec2(0.0, TITLE);
        let cells = matrices.iter().map(|&(size, widest)| matrix_view::cell_in(inner, size, widest));
        cells.fold(f32::INFINITY, f32::min)
    };
    // Where cells are as large, more beside each other are fewer to scroll.
    let possible = (1..=matrices.len()).filter(|&across| across == 1 || room.x / across as f32 >= LEAST);
    let across = possible.max_by(|&a, &b| cell(a).total_cmp(&cell(b)).then(a.cmp(&b))).unwrap_or(1);
    (across, place(across))
}

/// All matrices, beside and below each other so that their cells are as large as the room allows.
fn grid(ctx: &mut PanelContext<'_>, ui: &mut Ui, of: Of, blocks: &[Block], stale: bool) {
    let room = ui.available_size();
    let matrices: Vec<_> =
        blocks.iter().map(|block| (block.names.len(), matrix_view::widest_name(ui, &block.names))).collect();
    let (across, Vec2 { x: width, y: height }) = arrange(room, &matrices);
    let down = blocks.len().div_ceil(across);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let origin = ui.cursor().min;
        for (at, block) in blocks.iter().enumerate() {
            let corner = origin + vec2((at % across) as f32 * width, (at / across) as f32 * height);
            let place = Rect::from_min_size(corner, vec2(width, height) - BETWEEN);
            let mut inner = ui.new_child(UiBuilder::new().id_salt(("correlation", at)).max_rect(place));
            inner.set_clip_rect(place.intersect(ui.clip_rect()));
            matrix(ctx, &mut inner, of, block, stale);
        }
        ui.allocate_rect(Rect::from_min_size(origin, vec2(room.x - 12.0, down as f32 * height)), Sense::hover());
    });
}

fn matrix(ctx: &mut PanelContext<'_>, ui: &mut Ui, of: Of, block: &Block, stale: bool) {
    ui.horizontal(|ui| {
        ui.set_height(TITLE);
        ui.label(notation::derivative_job(ui, &format!("{}_", block.coefficient.name())));
        ui.add(Label::new(RichText::new(&block.about).size(11.0).weak()).truncate());
    });
    if let Some(error) = &block.trouble {
        return crate::panels::trouble(ui, Some(error));
    }
    let labels: Vec<&str> = block.names.iter().map(String::as_str).collect();
    let what = match of {
        Of::Parameters => "parameters",
        Of::Regressors => "regressors",
    };
    let name = format!("correlation of {what} of {}", block.coefficient.name());
    let view =
        MatrixView { name: &name, labels: &labels, values: &block.values, full_scale: 1.0, notable: NOTABLE, stale };
    ctx.figures.extend(view.show(ui).1);
}

/// What the colours mean.
fn color_bar(ui: &mut Ui) {
    let palette = theme::palette(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(BAR[0] + 44.0, 18.0), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "colours from -1 to +1"));
    let bar = Rect::from_center_size(rect.center(), BAR.into());
    let mut mesh = Mesh::default();
    for step in 0..STEPS {
        let (from, to) = (step as f32 / STEPS as f32, (step + 1) as f32 / STEPS as f32);
        let part = Rect::from_x_y_ranges(bar.left() + from * BAR[0]..=bar.left() + to * BAR[0], bar.y_range());
        mesh.add_colored_rect(part, matrix_view::color(palette, from + to - 1.0));
    }
    ui.painter().add(Shape::mesh(mesh));
    ui.painter().rect_stroke(bar, 0.0, Stroke::new(1.0, palette.grid), StrokeKind::Outside);
    let (font, ink) = (FontId::proportional(10.5), ui.visuals().weak_text_color());
    ui.painter().text(pos2(bar.left() - 4.0, bar.center().y), Align2::RIGHT_CENTER, "\u{2212}1", font.clone(), ink);
    ui.painter().text(pos2(bar.right() + 4.0, bar.center().y), Align2::LEFT_CENTER, "+1", font, ink);
}
