//! A plot of one quantity against another, or against words: tracks, envelopes, intervals, histograms.

use doublet_engine::report::document::{Axis, Figure, LineStyle as Style, Mark, Panel};
use eframe::egui::{self, Color32, Stroke, Ui};
use egui_plot::{AxisHints, Bar, BarChart, Line, LineStyle, Plot, PlotPoint, PlotPoints, Points, Polygon};

use super::figure::{FigureForm, FigureRequest, printed};
use super::readout::readable;
use super::stack_figure::WIDTH_MM;
use super::ticks::{tick, ticks};
use super::{named_id, speak_value};
use crate::{notation, theme};

/// Part of the extent left free around the data.
const MARGIN: f32 = 0.06;

/// Points from which their intervals run together.
const MANY: usize = 60;

/// Height of a line of a legend.
pub(super) const LEGEND_HEIGHT: f32 = 15.0;
/// Room of numbers and title below the axes of a chart.
const BELOW: f32 = 40.0;
/// Length of the line before a name of a legend.
const LEGEND_LINE: f32 = 12.0;
/// Room right of a chart for the half of the last label that lies beyond it.
pub(super) const RIGHT_ROOM: f32 = 14.0;
/// Distance between ticks from which their labels are drawn, and drawn fully.
const LABELS: egui::Rangef = egui::Rangef { min: 8.0, max: 12.0 };
/// Least distance between ticks of the level and of the upright axis.
pub(super) const TICK_SPACING: [f32; 2] = [84.0, 24.0];

/// How a curve of a chart is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ChartStyle {
    Line,
    /// A dashed line.
    Dashed,
    /// A dot per point, with this radius.
    Dots(f32),
    /// A closed, faintly filled outline.
    Area,
    /// A bar from zero per point, this wide on the level axis.
    Bars(f64),
    /// A level bar from zero per point, this wide on the upright axis.
    LevelBars(f64),
}

impl ChartStyle {
    fn legend(self) -> LegendMark {
        match self {
            Self::Line => LegendMark::Line,
            Self::Dashed => LegendMark::Dashed,
            Self::Dots(_) => LegendMark::Dots,
            Self::Area | Self::Bars(_) | Self::LevelBars(_) => LegendMark::Box,
        }
    }
}

#[derive(Clone, Debug)]
pub struct ChartCurve {
    /// Name in legend and tables.
    pub name: String,
    /// Colour.
    pub color: Color32,
    /// How it is drawn.
    pub style: ChartStyle,
    /// Points; one that is not finite breaks the line.
    pub points: Vec<[f64; 2]>,
    /// Half length of the upright interval at each point; none without.
    pub spread: Vec<f64>,
}

impl ChartCurve {
    /// A curve without intervals.
    pub fn new(name: impl Into<String>, color: Color32, style: ChartStyle, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), color, style, points, spread: Vec::new() }
    }

    /// Unbroken parts of its points.
    fn segments(&self) -> impl Iterator<Item = &[[f64; 2]]> {
        self.points.split(|[x, y]| !(x.is_finite() && y.is_finite())).filter(|segment| !segment.is_empty())
    }

    /// Ends of the interval at each point that has one.
    fn intervals(&self) -> impl Iterator<Item = [[f64; 2]; 2]> {
        let pairs = self.points.iter().zip(&self.spread).filter(|([_, y], spread)| (y + **spread).is_finite());
        pairs.map(|([x, y], spread)| [[*x, y - spread], [*x, y + spread]])
    }
}

#[derive(Clone, Debug, Default)]
pub struct Chart {
    /// Name, for tests, screen readers and proposed files.
    pub name: String,
    /// Label of the level and of the upright axis, with units.
    pub labels: [String; 2],
    /// Curves, first drawn first.
    pub curves: Vec<ChartCurve>,
    /// Level lines to compare with.
    pub levels: Vec<(f64, Color32)>,
    /// Words under places of the level axis.
    pub places: Vec<(f64, String)>,
    /// Words beside places of the upright axis.
    pub upright_places: Vec<(f64, String)>,
    /// How many units of the level axis are drawn as long as one of the upright axis; none fits both to the room.
    pub aspect: Option<f64>,
    /// Names of the curves are shown.
    pub legend: bool,
}

impl Chart {
    /// A chart without curves.
    pub fn new(name: &str, across: impl Into<String>, up: impl Into<String>) -> Self {
        Self { name: name.to_owned(), labels: [across.into(), up.into()], legend: true, ..Self::default() }
    }

    /// Draws it `height` points high; a figure that was asked for in its menu.
    pub fn show(&self, ui: &mut Ui, height: f32) -> Option<FigureRequest> {
        let palette = theme::palette(ui);
        let text = ui.visuals().weak_text_color();
        let top = ui.cursor().top();
        if self.legend && self.curves.iter().any(|curve| !curve.name.is_empty()) {
            self.show_legend(ui);
        }
        let height = height - (ui.cursor().top() - top);
        let upright = folded(ui, &self.labels[1], height.max(80.0) - BELOW);
        let mut plot = Plot::new(named_id(ui.ctx(), self.name.as_str()))
            .height(height.max(80.0))
            .width((ui.available_width() - RIGHT_ROOM).max(60.0))
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .set_margin_fraction(egui::vec2(MARGIN, MARGIN))
            .grid_color(palette.grid)
            .label_formatter(|_| None)
            .x_grid_spacer(|input| ticks(input, TICK_SPACING[0]))
            .y_grid_spacer(|input| ticks(input, TICK_SPACING[1]))
            .custom_y_axes(vec![titled(AxisHints::new_y(), &upright, &self.upright_places, ui)])
            .custom_x_axes(vec![titled(AxisHints::new_x(), &self.labels[0], &self.places, ui)]);
        if let Some(aspect) = self.aspect {
            plot = plot.data_aspect(aspect as f32);
        }
        let (named, named_upright) = (!self.places.is_empty(), !self.upright_places.is_empty());
        if named {
            let marks = marks_at(&self.places);
            plot = plot.x_grid_spacer(move |_| marks.clone());
        }
        if named_upright {
            let marks = marks_at(&self.upright_places);
            plot = plot.y_grid_spacer(move |_| marks.clone());
        }
        let shown = plot.show(ui, |plot| {
            for &(level, color) in &self.levels {
                let line = egui_plot::HLine::new("", level).color(color).style(LineStyle::dashed_dense());
                plot.hline(line.width(1.0).allow_hover(false));
            }
            self.curves.iter().for_each(|curve| draw(plot, curve));
        });
        let frame = *shown.transform.frame();
        settle_axes(&shown.response, frame);
        let name = self.name.clone();
        shown.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &name));
        speak_value(&shown.response, self.shown_curves());
        if let Some(at) = shown.response.hover_pos().filter(|at| frame.contains(*at)) {
            let value = shown.transform.value_from_position(at);
            let with_unit = |label: &str, value: f64| format!("{}{}", readable(value), unit_of(label));
            let place = if named { String::new() } else { with_unit(&self.labels[0], value.x) };
            let up = if named_upright { String::new() } else { with_unit(&self.labels[1], value.y) };
            let between = if named || named_upright { "" } else { ", " };
            let font = egui::FontId::proportional(10.5);
            let foot = frame.right_bottom() - egui::vec2(4.0, 2.0);
            let here = format!("{place}{between}{up}");
            speak_value(&shown.response, self.spoken(value.x, &here));
            ui.painter().text(foot, egui::Align2::RIGHT_BOTTOM, here, font, text);
        }
        let bounds = shown.transform.bounds();
        figure_menu(&shown.response)
            .map(|form| FigureRequest { figure: self.figure(frame.size(), (bounds.min(), bounds.max())), form })
    }

    /// Axes and curves in words.
    fn shown_curves(&self) -> String {
        let names: Vec<&str> =
            self.curves.iter().map(|curve| curve.name.as_str()).filter(|name| !name.is_empty()).collect();
        format!("{} over {}: {}", self.labels[1], self.labels[0], names.join(", "))
    }

    /// The place under the cursor, and the value of each curve nearest to it across.
    fn spoken(&self, across: f64, here: &str) -> String {
        let unit = unit_of(&self.labels[1]);
        let nearest = |curve: &ChartCurve| {
            let finite = curve.points.iter().filter(|[x, y]| x.is_finite() && y.is_finite());
            let point = finite.min_by(|a, b| (a[0] - across).abs().total_cmp(&(b[0] - across).abs()))?;
            Some(format!("{} {}{unit}", curve.name, readable(point[1]))).filter(|_| !curve.name.is_empty())
        };
        let values: Vec<String> = self.curves.iter().filter_map(nearest).collect();
        format!("at {here}: {}", values.join(", "))
    }

    /// Names of the curves in a line above the plot, where they cover nothing; once above charts of the same curves beside each other.
    pub fn show_legend(&self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = egui::vec2(10.0, 0.0);
            ui.spacing_mut().interact_size.y = LEGEND_HEIGHT;
            for curve in self.curves.iter().filter(|curve| !curve.name.is_empty()) {
                legend_entry(ui, &curve.name, (curve.color, false), curve.style.legend());
            }
        });
    }

    /// What is on screen, from the lower left to the upper right corner.
    fn figure(&self, size: egui::Vec2, (low, high): ([f64; 2], [f64; 2])) -> Figure {
        let axis = |axis: usize| Axis { range: Some([low[axis], high[axis]]), ..Axis::new(&self.labels[axis], "") };
        let (x, marks) =
            (axis(0), self.levels.iter().map(level_mark).chain(self.curves.iter().map(curve_mark)).collect());
        let x = Axis { places: self.places.clone(), ..x };
        let y = Axis { places: self.upright_places.clone(), ..axis(1) };
        Figure::new(
            self.name.replace(' ', "_"),
            self.name.clone(),
            (1, WIDTH_MM * f64::from(size.y / size.x.max(1.0))),
            vec![Panel::Plot(doublet_engine::report::document::Plot { x, y, marks })],
        )
    }
}

/// A curve on paper.
fn curve_mark(curve: &ChartCurve) -> Mark {
    let (label, colour) = (curve.name.clone().into(), printed(curve.color));
    let style = match curve.style {
        ChartStyle::Bars(width) => return Mark::Bars { label, colour, width, bars: curve.points.clone() },
        ChartStyle::LevelBars(width) => {
            let points = curve.points.iter().flat_map(|&point| outline_of_bar(point, width)).collect();
            return Mark::Points { label, colour, style: Style::Solid, points };
        }
        ChartStyle::Dots(_) => Style::Dots,
        ChartStyle::Dashed => Style::Dashed,
        ChartStyle::Line | ChartStyle::Area => Style::Solid,
    };
    let spread = curve.spread.iter().copied().chain(std::iter::repeat(f64::NAN));
    let points = curve.points.iter().zip(spread).map(|(&[x, y], spread)| [x, y, spread]).collect();
    Mark::Points { label, colour, style, points }
}

/// A level on paper.
fn level_mark(&(value, color): &(f64, Color32)) -> Mark {
    Mark::Level { label: "".into(), colour: printed(color), value, band: [value; 2] }
}

/// A name behind the mark of its curve, pale where its curve is hidden. Of a size of its own, so that a line of them wraps.
pub(super) fn legend_entry(
    ui: &mut Ui,
    name: &str,
    (color, is_hidden): (Color32, bool),
    mark: LegendMark,
) -> egui::Response {
    let ink = if is_hidden { ui.visuals().weak_text_color() } else { ui.visuals().text_color() };
    let galley = ui.painter().layout_job(notation::typeset(name, 11.0));
    let size = egui::vec2(LEGEND_LINE + 4.0 + galley.size().x, LEGEND_HEIGHT);
    let (rect, entry) = ui.allocate_exact_size(size, egui::Sense::click());
    let color = if is_hidden { color.gamma_multiply(0.3) } else { color };
    legend_mark(ui.painter(), (rect.left(), rect.center().y), color, mark);
    let at = egui::Align2::RIGHT_CENTER.anchor_size(rect.right_center(), galley.size());
    ui.painter().galley(at.min, galley, ink);
    entry.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("legend {name}")));
    entry
}

/// What stands before a name of a legend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LegendMark {
    Line,
    /// A dashed line.
    Dashed,
    Dots,
    /// A filled box.
    Box,
}

/// The mark before a name of a legend, from its left end.
pub(super) fn legend_mark(painter: &egui::Painter, (left, y): (f32, f32), color: Color32, mark: LegendMark) {
    let stroke = Stroke::new(2.0, color);
    match mark {
        LegendMark::Line => {
            painter.hline(left..=left + LEGEND_LINE, y, stroke);
        }
        LegendMark::Dashed => {
            painter.hline(left..=left + 0.4 * LEGEND_LINE, y, stroke);
            painter.hline(left + 0.65 * LEGEND_LINE..=left + LEGEND_LINE, y, stroke);
        }
        LegendMark::Dots => {
            for part in [0.2, 0.8] {
                painter.circle_filled(egui::pos2(left + part * LEGEND_LINE, y), 2.0, color);
            }
        }
        LegendMark::Box => {
            let rect = egui::Rect::from_x_y_ranges(left..=left + LEGEND_LINE, y - 4.0..=y + 4.0);
            painter.rect_filled(rect, 1.0, color.gamma_multiply(0.6));
        }
    }
}

/// Corners of a level bar, and a gap to the next.
fn outline_of_bar([end, at]: [f64; 2], width: f64) -> [[f64; 3]; 6] {
    let (low, high) = (at - 0.5 * width, at + 0.5 * width);
    let corner = |x, y| [x, y, f64::NAN];
    [corner(0.0, low), corner(end, low), corner(end, high), corner(0.0, high), corner(0.0, low), [f64::NAN; 3]]
}

/// The word at a place of an axis.
fn word_at(places: &[(f64, String)], value: f64) -> String {
    places.iter().find(|(at, _)| *at == value).map_or_else(String::new, |place| place.1.clone())
}

/// The title of an upright axis `length` long: its unit on a second line where both are longer than the axis.
fn folded(ui: &Ui, title: &str, length: f32) -> String {
    let galley = ui.painter().layout_no_wrap(title.to_owned(), egui::FontId::proportional(11.5), Color32::WHITE);
    match title.rfind(" [") {
        Some(at) if galley.size().x > length => format!("{}\n{}", &title[..at], &title[at + 1..]),
        _ => title.to_owned(),
    }
}

/// An axis with its title, and words in the place of numbers where it has any.
pub(super) fn titled(hints: AxisHints<'static>, title: &str, places: &[(f64, String)], ui: &Ui) -> AxisHints<'static> {
    let places = places.to_vec();
    hints
        .label(notation::typeset(title, 11.5))
        .label_spacing(LABELS)
        .tick_label_color(ui.visuals().weak_text_color())
        .formatter(move |mark, _| match places.is_empty() {
            true => tick(mark.value, mark.step_size),
            false => word_at(&places, mark.value),
        })
}

/// Asks for another frame where the axes have taken another room than in the last: a plot knows it only once its labels are laid out.
pub(super) fn settle_axes(response: &egui::Response, frame: egui::Rect) {
    let id = response.id.with("frame of its axes");
    let before = response.ctx.data_mut(|data| {
        let before = data.get_temp::<egui::Rect>(id);
        data.insert_temp(id, frame);
        before
    });
    if before != Some(frame) {
        response.ctx.request_repaint();
    }
}

/// Grid lines at places with words.
pub(super) fn marks_at(places: &[(f64, String)]) -> Vec<egui_plot::GridMark> {
    places.iter().map(|&(value, _)| egui_plot::GridMark { value, step_size: 1.0 }).collect()
}

/// The unit in the brackets at the end of a label, after a space.
pub(super) fn unit_of(label: &str) -> String {
    let unit = label.strip_suffix(']').and_then(|label| label.rsplit_once('[')).map(|(_, unit)| unit);
    unit.map_or_else(String::new, |unit| format!(" {unit}"))
}

fn draw<'a>(plot: &mut egui_plot::PlotUi<'a>, curve: &'a ChartCurve) {
    let color = curve.color;
    let line = |points: &[[f64; 2]], width: f32| {
        Line::new("", PlotPoints::new(points.to_vec())).color(color).width(width).allow_hover(false)
    };
    // Many intervals close to each other are a band behind the points.
    let strength = if curve.points.len() > MANY { 0.3 } else { 1.0 };
    curve.intervals().for_each(|ends| plot.line(line(&ends, 1.2).color(color.gamma_multiply(strength))));
    match curve.style {
        ChartStyle::Line => curve.segments().for_each(|points| plot.line(line(points, 1.4))),
        ChartStyle::Dashed => {
            curve.segments().for_each(|points| plot.line(line(points, 1.4).style(LineStyle::dashed_dense())));
        }
        ChartStyle::Dots(radius) => {
            let points: Vec<PlotPoint> = curve.points.iter().map(|[x, y]| PlotPoint::new(*x, *y)).collect();
            plot.points(Points::new("", PlotPoints::Owned(points)).color(color).radius(radius).allow_hover(false));
        }
        ChartStyle::Area => {
            let outline = Polygon::new("", PlotPoints::new(curve.points.clone()));
            let outline = outline.fill_color(color.gamma_multiply(0.12)).stroke(Stroke::new(1.5, color));
            plot.polygon(outline.allow_hover(false));
        }
        ChartStyle::LevelBars(width) => {
            let bars = curve.points.iter().map(|[end, at]| Bar::new(*at, *end).width(width));
            let chart = BarChart::new("", bars.collect()).color(color.gamma_multiply(0.6)).horizontal();
            plot.bar_chart(chart.allow_hover(false));
        }
        ChartStyle::Bars(width) => {
            let bars = curve.points.iter().map(|[x, y]| Bar::new(*x, *y).width(width));
            plot.bar_chart(BarChart::new("", bars.collect()).color(color.gamma_multiply(0.6)).allow_hover(false));
        }
    }
}

/// The menu of a plot that is not part of a stack.
pub fn figure_menu(response: &egui::Response) -> Option<FigureForm> {
    let mut wanted = None;
    response.context_menu(|ui| wanted = figure_entries(ui));
    wanted
}

/// The entries of a menu that take a figure away; the form that was chosen.
pub fn figure_entries(ui: &mut egui::Ui) -> Option<FigureForm> {
    let mut wanted = None;
    for (form, name) in FigureForm::ALL {
        if ui.button(name).clicked() {
            wanted = Some(form);
            ui.close();
        }
    }
    wanted
}
