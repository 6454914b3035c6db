//! A matrix as a heat map between -1 and +1, with names along its sides and the value under the pointer.

use doublet_engine::report::document::{Figure, Matrix, Panel};
use eframe::egui::{
    self, Align2, Color32, CornerRadius, FontId, Mesh, Pos2, Rect, Role, Sense, Shape, Stroke, StrokeKind, Ui, Vec2,
    WidgetInfo, epaint::TextShape, pos2, vec2,
};

use super::chart::figure_menu;
use super::figure::FigureRequest;
use super::speak_value;
use super::stack_figure::WIDTH_MM;
use crate::notation;
use crate::theme::{self, Palette};

/// Largest and smallest cell.
const LARGEST_CELL: f32 = 88.0;
const SMALLEST_CELL: f32 = 6.0;
/// Smallest cell that still holds its value as text.
const TEXT_CELL: f32 = 30.0;
/// Smallest cell that holds three decimals and a sign.
const LONG_TEXT_CELL: f32 = 35.0;
/// Size of a value over that of its cell, and least and largest size of it.
const TEXT_PART: f32 = 0.24;
const TEXT_SIZES: [f32; 2] = [9.5, 14.0];
/// Longest name drawn along a side, characters.
const NAME_LENGTH: usize = 12;
/// Slope of the names above the columns, rad.
const NAME_SLOPE: f32 = -0.9;

/// A matrix to look at.
#[derive(Clone, Copy, Debug)]
pub struct MatrixView<'a> {
    /// What it is, for tests and screen readers.
    pub name: &'a str,
    /// Names of rows and columns: the matrix is square.
    pub labels: &'a [&'a str],
    /// Values by rows, `labels.len()` squared.
    pub values: &'a [f64],
    /// Absolute value at which the colour is full.
    pub full_scale: f64,
    /// Cells of at least this absolute value off the diagonal are outlined.
    pub notable: f64,
    /// Out of date: drawn pale until replaced.
    pub stale: bool,
}

/// `value` as a fraction of full scale, within -1 and 1; `None` when it is not finite.
pub fn intensity(value: f64, full_scale: f64) -> Option<f32> {
    (value.is_finite() && full_scale > 0.0).then(|| (value / full_scale).clamp(-1.0, 1.0) as f32)
}

/// Colour between the ground (0) and the end of the scale `intensity` points to.
pub fn color(palette: &Palette, intensity: f32) -> Color32 {
    let end = palette.diverging[usize::from(intensity > 0.0)];
    palette.plot_background.lerp_to_gamma(end, intensity.abs().min(1.0))
}

/// `name` cut to `length` characters, the last of them an ellipsis.
pub fn shortened(name: &str, length: usize) -> String {
    if name.chars().count() <= length {
        return name.to_owned();
    }
    name.chars().take(length.saturating_sub(1)).chain(['…']).collect()
}

/// The cell of a matrix of `size` rows in `area` under `at`.
pub fn cell_at(area: Rect, size: usize, at: Pos2) -> Option<(usize, usize)> {
    let place = (at - area.min) / area.size() * size as f32;
    (size > 0 && place.min_elem() >= 0.0 && place.max_elem() < size as f32)
        .then_some((place.y as usize, place.x as usize))
}

/// Room beside, above and right of a matrix whose longest name is `widest` points wide.
fn margins(widest: f32) -> [f32; 3] {
    [widest + 10.0, widest * NAME_SLOPE.sin().abs() + 16.0, widest * NAME_SLOPE.cos() + 4.0]
}

/// Size of the cells of a matrix of `size` rows in `room` whose longest name is `widest` points wide.
pub fn cell_in(room: Vec2, size: usize, widest: f32) -> f32 {
    let [side, above, right] = margins(widest);
    let cell = (room.x - side - right).min(room.y - above) / size.max(1) as f32;
    cell.clamp(SMALLEST_CELL, LARGEST_CELL).floor()
}

/// Width of the longest of the names of a matrix, points.
pub fn widest_name(ui: &Ui, labels: &[String]) -> f32 {
    let width =
        |name: &String| ui.painter().layout_job(notation::typeset(&shortened(name, NAME_LENGTH), 11.0)).size().x;
    labels.iter().map(width).fold(0.0, f32::max)
}

impl MatrixView<'_> {
    /// Draws it into the room there is; row and column under the pointer, and a figure asked for in its menu.
    pub fn show(&self, ui: &mut Ui) -> (Option<(usize, usize)>, Option<FigureRequest>) {
        let size = self.labels.len();
        if size == 0 || self.values.len() != size * size {
            return (None, None);
        }
        let ink = ui.visuals().text_color();
        let names: Vec<_> = self
            .labels
            .iter()
            .map(|name| ui.painter().layout_job(notation::typeset(&shortened(name, NAME_LENGTH), 11.0)))
            .collect();
        let widest = names.iter().map(|name| name.size().x).fold(0.0, f32::max);
        let [side, above, right] = margins(widest);
        let cell = cell_in(ui.available_size(), size, widest);
        let extent = cell * size as f32;
        let (outer, response) = ui.allocate_exact_size(vec2(side + extent + right, above + extent), Sense::click());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, self.name));
        let area = Rect::from_min_size(outer.min + vec2(side, above), Vec2::splat(extent));
        self.cells(ui, area, cell);
        for (at, name) in names.iter().enumerate() {
            let middle = (at as f32 + 0.5) * cell;
            let row = Align2::RIGHT_CENTER.anchor_size(pos2(area.left() - 6.0, area.top() + middle), name.size());
            ui.painter().galley(row.min, name.clone(), ink);
            // Turned about its upper left corner: its left edge then hangs down to the right.
            let hanging = name.size().y * vec2(-NAME_SLOPE.sin(), NAME_SLOPE.cos());
            let foot = pos2(area.left() + middle - 0.5 * hanging.x, area.top() - 4.0 - hanging.y);
            ui.painter().add(TextShape::new(foot, name.clone(), ink).with_angle(NAME_SLOPE));
        }
        let wanted = figure_menu(&response).map(|form| FigureRequest { figure: self.figure(), form });
        let under = response.hover_pos().and_then(|at| cell_at(area, size, at));
        if let Some(cell_under) = under {
            self.point_out(ui, response, (area, cell), cell_under);
        }
        (under, wanted)
    }

    /// Outlines the cell under the pointer and says its value.
    fn point_out(&self, ui: &Ui, response: egui::Response, (area, cell): (Rect, f32), (row, column): (usize, usize)) {
        let size = self.labels.len();
        let under = Rect::from_min_size(area.min + vec2(column as f32, row as f32) * cell, Vec2::splat(cell));
        ui.painter().rect_stroke(under, 0.0, Stroke::new(1.5, ui.visuals().strong_text_color()), StrokeKind::Outside);
        let value = self.values[row * size + column];
        let value = notation::fixed(value, 4);
        let text = format!("{} × {}:  {value}", self.labels[row], self.labels[column]);
        speak_value(&response, text.clone());
        response.on_hover_text_at_pointer(text);
    }

    /// The matrix for a page.
    fn figure(&self) -> Figure {
        /// Height of a row, mm.
        const ROW_MM: f64 = 12.0;
        let size = self.labels.len();
        let matrix = Matrix {
            title: self.name.to_owned(),
            names: self.labels.iter().map(|label| (*label).to_owned()).collect(),
            values: self.values.chunks(size.max(1)).map(<[f64]>::to_vec).collect(),
            full_scale: self.full_scale,
        };
        Figure::new(
            self.name.replace(' ', "_"),
            self.name.to_owned(),
            (1, (ROW_MM * size as f64).min(WIDTH_MM)),
            vec![Panel::Matrix(matrix)],
        )
    }

    /// Coloured cells, with their values where there is room.
    fn cells(&self, ui: &Ui, area: Rect, cell: f32) {
        let palette = theme::palette(ui);
        let size = self.labels.len();
        let pale = if self.stale { 0.4 } else { 1.0 };
        let painter = ui.painter();
        painter.rect_filled(area, CornerRadius::ZERO, palette.plot_background);
        let ground = painter.add(Shape::Noop);
        let mut mesh = Mesh::default();
        let (mut marks, mut outlined) = (Vec::new(), Vec::new());
        for (at, &value) in self.values.iter().enumerate() {
            let (row, column) = (at / size, at % size);
            let corner = area.min + vec2(column as f32, row as f32) * cell;
            let rect = Rect::from_min_size(corner, Vec2::splat(cell)).shrink(0.5);
            let Some(intensity) = intensity(value, self.full_scale) else {
                marks.push((rect, "–".to_owned(), palette.ignored));
                continue;
            };
            // Everything goes with itself: the diagonal says nothing and draws no eye.
            if row == column {
                mesh.add_colored_rect(rect, palette.grid);
                marks.push((rect, "1".to_owned(), ui.visuals().weak_text_color()));
                continue;
            }
            mesh.add_colored_rect(rect, color(palette, intensity * pale));
            if value.abs() >= self.notable {
                outlined.push(rect);
            }
            if cell >= TEXT_CELL {
                let text = if cell < LONG_TEXT_CELL { notation::fixed(value, 2) } else { notation::correlation(value) };
                marks.push((rect, text, contrast(color(palette, intensity * pale))));
            }
        }
        painter.set(ground, Shape::mesh(mesh));
        for rect in outlined {
            painter.rect_stroke(rect, 0.0, Stroke::new(2.0, palette.warning), StrokeKind::Inside);
        }
        let font = FontId::proportional((TEXT_PART * cell).clamp(TEXT_SIZES[0], TEXT_SIZES[1]));
        for (rect, text, ink) in marks {
            painter.text(rect.center(), Align2::CENTER_CENTER, text, font.clone(), ink);
        }
        painter.rect_stroke(area, 0.0, ui.visuals().widgets.noninteractive.bg_stroke, StrokeKind::Outside);
    }
}

/// Ink that can be read on `ground`.
fn contrast(ground: Color32) -> Color32 {
    let [red, green, blue, _] = ground.to_array().map(f32::from);
    if 0.299 * red + 0.587 * green + 0.114 * blue > 140.0 { Color32::BLACK } else { egui::Color32::from_gray(235) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_beyond_full_scale_saturate_and_missing_ones_have_no_colour() {
        assert_eq!(intensity(1.0 + 1e-12, 1.0), Some(1.0));
        assert_eq!(intensity(-7.0, 1.0), Some(-1.0));
        assert_eq!(intensity(0.25, 0.5), Some(0.5));
        assert_eq!(intensity(f64::NAN, 1.0), None);
        assert_eq!(intensity(1.0, 0.0), None);
        assert_eq!(color(&theme::DARK, 1.0), theme::DARK.diverging[1]);
        assert_eq!(color(&theme::DARK, -1.0), theme::DARK.diverging[0]);
        assert_eq!(color(&theme::DARK, 0.0), theme::DARK.plot_background);
    }

    #[test]
    fn long_names_end_in_an_ellipsis() {
        assert_eq!(shortened("alpha_dot*c/V squared", 9), "alpha_do…");
        assert_eq!(shortened("α̇", 9), "α̇");
    }

    #[test]
    fn pointer_finds_its_cell_and_nothing_outside() {
        let area = Rect::from_min_size(pos2(100.0, 50.0), Vec2::splat(80.0));
        assert_eq!(cell_at(area, 4, pos2(101.0, 51.0)), Some((0, 0)));
        assert_eq!(cell_at(area, 4, pos2(179.0, 71.0)), Some((1, 3)));
        assert_eq!(cell_at(area, 4, pos2(181.0, 71.0)), None);
        assert_eq!(cell_at(area, 4, pos2(150.0, 49.0)), None);
    }
}
