//! Marks over two axes that are clicked one by one, taken together with a lasso, or walked through by the arrow keys.

use doublet_engine::verdict::Level;
use eframe::egui::{
    self, Color32, EventFilter, Id, Key, Modifiers, Painter, Pos2, Rect, Response, Role, Sense, Shape, Stroke, Ui,
    WidgetInfo, pos2, vec2,
};
use egui_plot::{AxisHints, Plot, PlotPoint};

use super::chart::{RIGHT_ROOM, TICK_SPACING, settle_axes, titled, unit_of};
use super::ticks::ticks;
use super::{level_mark, named_id, speak_value};
use crate::theme;

/// Part of the extent left free around the marks.
const MARGIN: f32 = 0.08;
/// Least distance between points of a lasso.
const LASSO_STEP: f32 = 3.0;
/// Most marks that can be pointed at; more are drawn and can be taken with the lasso.
const MOST: usize = 3000;

#[derive(Clone, Debug)]
pub struct ScatterMark {
    /// Its place.
    pub at: [f64; 2],
    /// Shape and colour.
    pub level: Option<Level>,
    /// Whether it is drawn hollow.
    pub is_hollow: bool,
    /// Whether it is selected.
    pub is_selected: bool,
    /// Half its size, points.
    pub radius: f32,
    /// Name for screen readers.
    pub label: String,
    /// Its place in words, for screen readers.
    pub value: String,
}

/// What lasts from frame to frame.
#[derive(Default)]
pub struct Scatter {
    lasso: Vec<Pos2>,
    /// The mark the arrow keys are at.
    at: Option<usize>,
}

/// The mark that was clicked, and the keys held.
pub type ClickedMark = (usize, Modifiers);

/// What was done.
#[derive(Debug)]
pub struct ScatterDone {
    /// The mark that was clicked, and what was held.
    pub clicked: Option<ClickedMark>,
    /// The marks inside a lasso that was closed, and what was held.
    pub enclosed: Option<(Vec<usize>, Modifiers)>,
    /// The marks under the pointer or with an open menu.
    pub pointed: Vec<(usize, Response)>,
    /// Whether the keyboard is at the plot.
    pub has_focus: bool,
    /// The plot.
    pub response: Response,
    /// Room of the marks.
    pub frame: Rect,
    /// Values at the lower left and the upper right corner.
    pub range: [[f64; 2]; 2],
}

/// What to draw.
pub struct ScatterPlot<'a> {
    /// Name, for screen readers; another one begins with the whole extent in view.
    pub name: &'a str,
    /// Titles of the axes, with units.
    pub titles: [&'a str; 2],
    /// Marks, first drawn first.
    pub marks: &'a [ScatterMark],
    /// Height, points.
    pub height: f32,
}

/// Height of a plot from which the title of its upright axis fits, points.
const TITLE_ROOM: f32 = 200.0;

impl Scatter {
    /// Draws marks.
    pub fn show(&mut self, ui: &mut Ui, plot: &ScatterPlot<'_>) -> ScatterDone {
        let palette = theme::palette(ui);
        let ends = plot.marks.iter().fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], mark| {
            [[low[0].min(mark.at[0]), low[1].min(mark.at[1])], [high[0].max(mark.at[0]), high[1].max(mark.at[1])]]
        });
        // A long title would leave a low plot: there its unit stands alone.
        let low = unit_of(plot.titles[1]);
        let up = if plot.height < TITLE_ROOM { low.trim() } else { plot.titles[1] };
        let mut shown = Plot::new(named_id(ui.ctx(), ("scatter", plot.name, plot.titles)))
            .height(plot.height.max(80.0))
            .width((ui.available_width() - RIGHT_ROOM).max(60.0))
            .allow_drag(false)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .set_margin_fraction(vec2(MARGIN, MARGIN))
            .grid_color(palette.grid)
            .label_formatter(|_| None)
            .x_grid_spacer(|input| ticks(input, TICK_SPACING[0]))
            .y_grid_spacer(|input| ticks(input, TICK_SPACING[1]))
            .custom_y_axes(vec![titled(AxisHints::new_y(), up, &[], ui)])
            .custom_x_axes(vec![titled(AxisHints::new_x(), plot.titles[0], &[], ui)]);
        for [x, y] in ends.into_iter().filter(|end| end.iter().all(|value| value.is_finite())) {
            shown = shown.include_x(x).include_y(y);
        }
        let shown = shown.show(ui, |_| {});
        let (response, transform) = (shown.response, shown.transform);
        let frame = *transform.frame();
        settle_axes(&response, frame);
        let name = format!("{}, {} marks", plot.name, plot.marks.len());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
        let places: Vec<Pos2> =
            plot.marks.iter().map(|mark| transform.position_from_point(&PlotPoint::from(mark.at))).collect();
        let painter = ui.painter().with_clip_rect(frame.expand(1.0));
        paint(ui, &painter, plot.marks, &places);
        let (mut clicked, pointed) = self.point(ui, plot.marks, &places, frame);
        let enclosed = self.lasso(ui, &painter, &response, &places);
        let has_focus = response.has_focus();
        if has_focus {
            let stroke = Stroke::new(1.5, palette.accent);
            ui.painter().rect_stroke(frame, 0.0, stroke, egui::StrokeKind::Inside);
            clicked = clicked.or(self.keys(ui, response.id, &places));
        }
        if let Some(place) = self.at.filter(|_| has_focus).and_then(|at| places.get(at)) {
            painter.rect_stroke(
                Rect::from_center_size(*place, vec2(22.0, 22.0)),
                3.0,
                Stroke::new(1.5, ui.visuals().strong_text_color()),
                egui::StrokeKind::Inside,
            );
        }
        let bounds = transform.bounds();
        ScatterDone { clicked, enclosed, pointed, has_focus, response, frame, range: [bounds.min(), bounds.max()] }
    }

    /// The mark the arrow keys are at.
    pub fn at(&self) -> Option<usize> {
        self.at
    }

    /// Lets every mark be pointed at and clicked: the one that was, and those under the pointer or with an open menu.
    fn point(
        &mut self,
        ui: &Ui,
        marks: &[ScatterMark],
        places: &[Pos2],
        frame: Rect,
    ) -> (Option<ClickedMark>, Vec<(usize, Response)>) {
        let (mut clicked, mut pointed) = (None, Vec::new());
        let inside = places.iter().enumerate().filter(|(_, place)| frame.contains(**place)).take(MOST);
        for (at, place) in inside {
            let mark = &marks[at];
            let rect = Rect::from_center_size(*place, vec2(2.0, 2.0) * (mark.radius + 3.0));
            // Clicked and not stopped at by Tab: the arrow keys walk through them.
            let response = ui.interact(rect, ui.scope_id().with(("mark", at)), Sense::CLICK);
            response.widget_info(|| WidgetInfo::selected(Role::Button, true, mark.is_selected, &mark.label));
            speak_value(&response, mark.value.clone());
            if response.clicked() {
                clicked = Some((at, ui.input(|input| input.modifiers)));
                self.at = Some(at);
            }
            if response.hovered() || response.context_menu_opened() {
                pointed.push((at, response));
            }
        }
        (clicked, pointed)
    }

    /// Draws the lasso of a drag; the marks inside where it ends. Escape gives it up.
    fn lasso(
        &mut self,
        ui: &Ui,
        painter: &Painter,
        response: &Response,
        places: &[Pos2],
    ) -> Option<(Vec<usize>, Modifiers)> {
        if response.drag_started_by(egui::PointerButton::Primary) {
            self.lasso = ui.input(|input| input.pointer.press_origin()).into_iter().collect();
        }
        if ui.input(|input| input.key_pressed(Key::Escape)) {
            self.lasso.clear();
        }
        let last = *self.lasso.last()?;
        if let Some(pos) = response.interact_pointer_pos().filter(|pos| pos.distance(last) >= LASSO_STEP) {
            self.lasso.push(pos);
        }
        if response.drag_stopped() {
            let lasso = std::mem::take(&mut self.lasso);
            let inside = (0..places.len()).filter(|&at| contains(&lasso, places[at])).collect();
            return Some((inside, ui.input(|input| input.modifiers)));
        }
        let color = theme::palette(ui).accent;
        let mut outline = self.lasso.clone();
        outline.extend(self.lasso.first());
        painter.extend(Shape::dashed_line(&outline, Stroke::new(1.5, color), 5.0, 4.0));
        for place in places.iter().filter(|place| contains(&self.lasso, **place)) {
            painter.circle_filled(*place, 9.0, color.gamma_multiply(0.25));
        }
        None
    }

    /// Walks to the next mark in the direction of an arrow key; the mark that Space or Enter selects.
    fn keys(&mut self, ui: &Ui, id: Id, places: &[Pos2]) -> Option<(usize, Modifiers)> {
        let filter = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(id, filter));
        if places.is_empty() {
            return None;
        }
        let here = self.at.filter(|at| *at < places.len());
        for (key, direction) in [
            (Key::ArrowLeft, vec2(-1.0, 0.0)),
            (Key::ArrowRight, vec2(1.0, 0.0)),
            (Key::ArrowUp, vec2(0.0, -1.0)),
            (Key::ArrowDown, vec2(0.0, 1.0)),
        ] {
            if ui.input(|input| input.key_pressed(key)) {
                self.at = here.map_or(Some(0), |here| next(places, here, direction).or(Some(here)));
            }
        }
        let chosen = ui.input(|input| input.key_pressed(Key::Space) || input.key_pressed(Key::Enter));
        here.filter(|_| chosen).map(|here| (here, ui.input(|input| input.modifiers)))
    }
}

/// The nearest place in a direction: what lies aside counts twice.
fn next(places: &[Pos2], here: usize, direction: egui::Vec2) -> Option<usize> {
    let from = places[here];
    let far = |at: usize| {
        let way = places[at] - from;
        let (ahead, aside) = (way.dot(direction), way.dot(direction.rot90()).abs());
        (at != here && ahead > 0.1).then_some((at, ahead + 2.0 * aside))
    };
    (0..places.len()).filter_map(far).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
}

/// Whether a place is inside a closed outline, by the number of edges to its left.
fn contains(outline: &[Pos2], place: Pos2) -> bool {
    let Some(&last) = outline.last() else { return false };
    let mut inside = false;
    let mut from = last;
    for &to in outline {
        if (from.y > place.y) != (to.y > place.y) {
            let x = from.x + (place.y - from.y) / (to.y - from.y) * (to.x - from.x);
            inside ^= x < place.x;
        }
        from = to;
    }
    inside
}

/// Draws marks, the selected ones last and ringed.
fn paint(ui: &Ui, painter: &Painter, marks: &[ScatterMark], places: &[Pos2]) {
    let accent = theme::palette(ui).accent;
    for selected in [false, true] {
        for (mark, place) in marks.iter().zip(places).filter(|(mark, _)| mark.is_selected == selected) {
            if selected {
                painter.circle_filled(*place, mark.radius + 5.0, accent.gamma_multiply(0.3));
                painter.circle_stroke(*place, mark.radius + 5.0, Stroke::new(2.0, accent));
            }
            if mark.is_hollow {
                hollow(painter, *place, mark.radius, ui.visuals().text_color());
            } else {
                level_mark::paint(painter, *place, mark.radius, mark.level, level_mark::color(ui, mark.level));
            }
        }
    }
}

/// The outline of a diamond.
pub fn hollow(painter: &Painter, center: Pos2, radius: f32, color: Color32) {
    let Pos2 { x, y } = center;
    let half = 1.15 * radius;
    let corners = vec![pos2(x, y - half), pos2(x + half, y), pos2(x, y + half), pos2(x - half, y)];
    painter.add(Shape::closed_line(corners, Stroke::new(1.3, color)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lasso_encloses_what_lies_inside_its_outline_and_nothing_in_its_bay() {
        // A square with a bay from the right.
        let outline = [(0.0, 0.0), (10.0, 0.0), (10.0, 4.0), (4.0, 5.0), (10.0, 6.0), (10.0, 10.0), (0.0, 10.0)];
        let outline: Vec<Pos2> = outline.into_iter().map(|(x, y)| pos2(x, y)).collect();
        for (x, y, inside) in
            [(2.0, 5.0, true), (9.0, 5.0, false), (9.0, 2.0, true), (9.0, 8.0, true), (-1.0, 5.0, false)]
        {
            assert_eq!(contains(&outline, pos2(x, y)), inside, "{x}, {y}");
        }
        assert!(!contains(&[], pos2(0.0, 0.0)));
    }

    #[test]
    fn arrow_keys_go_to_the_nearest_mark_ahead() {
        let places = [pos2(0.0, 0.0), pos2(10.0, 1.0), pos2(6.0, 8.0), pos2(0.0, -5.0)];
        assert_eq!(next(&places, 0, vec2(1.0, 0.0)), Some(1));
        assert_eq!(next(&places, 0, vec2(0.0, 1.0)), Some(2));
        assert_eq!(next(&places, 0, vec2(0.0, -1.0)), Some(3));
        assert_eq!(next(&places, 0, vec2(-1.0, 0.0)), None);
    }
}
