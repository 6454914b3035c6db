//! Figures of a report on screen, from the same data and the same axes as on paper.

use doublet_core::series::{Band, Decimated, Pyramid, decimate, decimate_band};
use doublet_engine::report::document::{
    Colour, DRAWN_COLUMNS, Figure, LineStyle as Style, Mark, Matrix, Panel, Plot as Axes,
};
use doublet_report::svg::{Range, range};
use eframe::egui::{self, Color32, Id, Role, Stroke, Ui, WidgetInfo};
use egui_plot::{
    AxisHints, Bar, BarChart, FilledArea, HLine, Line, LineStyle, Plot, PlotPoints, PlotUi, Points, Polygon,
};

use super::chart::{
    LEGEND_HEIGHT, LegendMark, RIGHT_ROOM, TICK_SPACING, figure_menu, legend_entry, marks_at, settle_axes, titled,
    unit_of,
};
use super::figure::{FigureForm, FigureRequest};
use super::matrix_view::MatrixView;
use super::readout::readable;
use super::speak_value;
use super::ticks::{inner_ticks, ticks};
use crate::{notation, theme};

/// Height of a panel for each millimetre it has on paper, points.
const POINTS_PER_MM: f64 = 4.0;
/// Height of the level axis with its title.
const AXIS_HEIGHT: f32 = 34.0;

/// Draws every panel of the figure, then its caption; the figure where it was asked for in the menu of a panel.
pub fn figure_view(ui: &mut Ui, figure: &Figure) -> Option<FigureRequest> {
    let mut wanted = None;
    legend(ui, figure);
    let columns = figure.columns.clamp(1, 2);
    for (row, panels) in figure.panels.chunks(columns).enumerate() {
        ui.columns(columns, |uis| {
            for (column, (ui, panel)) in uis.iter_mut().zip(panels).enumerate() {
                let id = Id::unique(("report figure", &figure.name, row, column));
                let form = match panel {
                    Panel::Plot(plot) => axes(ui, id, plot, figure.panel_height_mm * POINTS_PER_MM),
                    Panel::Matrix(matrix) => heat_map(ui, matrix),
                };
                wanted = form.or(wanted);
            }
        });
    }
    let caption = notation::typeset_in(&figure.caption, 11.5, ui.visuals().weak_text_color());
    ui.add(egui::Label::new(caption).wrap());
    wanted.map(|form| FigureRequest { figure: figure.clone(), form })
}

/// Names of what is drawn, each once, in a line above the panels.
fn legend(ui: &mut Ui, figure: &Figure) {
    let plots = figure.panels.iter().filter_map(|panel| match panel {
        Panel::Plot(plot) => Some(&plot.marks),
        Panel::Matrix(_) => None,
    });
    let mut entries: Vec<(&str, &Colour, LegendMark)> = Vec::new();
    for found in plots.flatten().map(entry).filter(|(name, ..)| !name.is_empty()) {
        if !entries.iter().any(|known| (known.0, known.1) == (found.0, found.1)) {
            entries.push(found);
        }
    }
    if entries.is_empty() {
        return;
    }
    let series = &theme::palette(ui).series;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = egui::vec2(10.0, 0.0);
        ui.spacing_mut().interact_size.y = LEGEND_HEIGHT;
        for (name, colour, mark) in entries {
            legend_entry(ui, name, (of_theme(colour, series), false), mark);
        }
    });
}

/// What a mark is called in the legend, its colour, and what stands before its name.
fn entry(mark: &Mark) -> (&str, &Colour, LegendMark) {
    match mark {
        Mark::Line { label, colour, style, .. } | Mark::Points { label, colour, style, .. } => {
            let shown = match style {
                Style::Dots => LegendMark::Dots,
                Style::Dashed => LegendMark::Dashed,
                Style::Solid => LegendMark::Line,
            };
            (label, colour, shown)
        }
        Mark::Level { label, colour, .. } => (label, colour, LegendMark::Line),
        Mark::Band { label, colour, .. } | Mark::Bars { label, colour, .. } | Mark::Span { label, colour, .. } => {
            (label, colour, LegendMark::Box)
        }
    }
}

/// A colour of the palette as the theme has it.
fn of_theme(colour: &Colour, series: &[Color32; 8]) -> Color32 {
    let Colour([red, green, blue]) = *colour;
    let place = Colour::PALETTE.iter().position(|of| of == colour);
    place.map_or(Color32::from_rgb(red, green, blue), |place| series[place])
}

fn heat_map(ui: &mut Ui, matrix: &Matrix) -> Option<FigureForm> {
    ui.strong(&matrix.title);
    let labels: Vec<&str> = matrix.names.iter().map(String::as_str).collect();
    let values: Vec<f64> = matrix.values.iter().flatten().copied().collect();
    let view = MatrixView {
        name: &matrix.title,
        labels: &labels,
        values: &values,
        full_scale: matrix.full_scale,
        notable: 0.9,
        stale: false,
    };
    let shown = ui.allocate_ui(egui::vec2(ui.available_width(), 260.0), |ui| view.show(ui)).inner;
    shown.1.map(|request| request.form)
}

fn axes(ui: &mut Ui, id: Id, plot: &Axes, height: f64) -> Option<FigureForm> {
    let palette = theme::palette(ui);
    let range = range(&Panel::Plot(plot.clone()));
    #[expect(clippy::cast_possible_truncation, reason = "a few hundred points")]
    let height = height as f32;
    let mut shown = Plot::new(id)
        .height(height + AXIS_HEIGHT)
        .width((ui.available_width() - RIGHT_ROOM).max(60.0))
        .x_grid_spacer(|input| ticks(input, TICK_SPACING[0]))
        .y_grid_spacer(|input| inner_ticks(input, TICK_SPACING[1]))
        .custom_y_axes(vec![titled(AxisHints::new_y(), &plot.y.title(), &plot.y.places, ui)])
        .custom_x_axes(vec![titled(AxisHints::new_x(), &plot.x.title(), &plot.x.places, ui)])
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .show_x(false)
        .show_y(false)
        .grid_color(palette.grid)
        .label_formatter(|_| None)
        .default_x_bounds(range.x[0], range.x[1])
        .default_y_bounds(range.y[0], range.y[1]);
    if !plot.x.places.is_empty() {
        let marks = marks_at(&plot.x.places);
        shown = shown.x_grid_spacer(move |_| marks.clone());
    }
    if !plot.y.places.is_empty() {
        let marks = marks_at(&plot.y.places);
        shown = shown.y_grid_spacer(move |_| marks.clone());
    }
    let shown = shown.show(ui, |chart| {
        for mark in &plot.marks {
            draw(chart, mark, &range, &palette.series);
        }
    });
    settle_axes(&shown.response, *shown.transform.frame());
    shown.response.widget_info(|| WidgetInfo::labeled(Role::Image, true, format!("figure of {}", plot.y.title())));
    let (x, y) = (plot.x.title(), plot.y.title());
    let spoken = match shown.response.hover_pos().map(|at| shown.transform.value_from_position(at)) {
        Some(at) => format!("at {}{}, {}{}", readable(at.x), unit_of(&x), readable(at.y), unit_of(&y)),
        None => format!("{y} over {x}"),
    };
    speak_value(&shown.response, spoken);
    figure_menu(&shown.response)
}

/// The corners of a rectangle.
fn rectangle([left, right]: [f64; 2], [bottom, top]: [f64; 2], color: Color32) -> Polygon<'static> {
    let corners = vec![[left, bottom], [right, bottom], [right, top], [left, top]];
    Polygon::new("", PlotPoints::from(corners))
        .fill_color(color.gamma_multiply(0.25))
        .stroke(Stroke::NONE)
        .allow_hover(false)
}

fn draw(chart: &mut PlotUi<'_>, mark: &Mark, range: &Range, colors: &[Color32; 8]) {
    let color = |colour: &Colour| of_theme(colour, colors);
    let (from, to) = (range.x[0], range.x[1]);
    let line = |points: Vec<[f64; 2]>, colour: &Colour, style: Style| {
        let style = if style == Style::Dashed { LineStyle::dashed_loose() } else { LineStyle::Solid };
        Line::new("", PlotPoints::from(points)).color(color(colour)).style(style).allow_hover(false)
    };
    let dots = |places: Vec<[f64; 2]>, colour: &Colour| {
        Points::new("", places).radius(2.5).color(color(colour)).allow_hover(false)
    };
    match mark {
        Mark::Line { colour, style, series, scale, .. } => {
            let (time, values) = (&series.time_s, &series.values);
            let mut drawn = Decimated::<[f64; 2]>::default();
            decimate(&Pyramid::new(time, values), time, values, *scale, (from, to), DRAWN_COLUMNS, &mut drawn);
            match style {
                Style::Dots => chart.points(dots(drawn.points, colour)),
                _ => drawn.lines().for_each(|points| chart.line(line(points.to_vec(), colour, *style))),
            }
        }
        Mark::Band { colour, centre, half_width, scale, .. } => {
            let mut band = Band::default();
            let samples: (&[f64], &[f64], &[f64]) = (&centre.time_s, &centre.values, half_width);
            decimate_band(samples, *scale, 1.0, (from, to), DRAWN_COLUMNS, &mut band);
            for part in band.segments {
                let area = FilledArea::new("", &band.time_s[part.clone()], &band.low[part.clone()], &band.high[part]);
                chart.add(area.fill_color(color(colour).gamma_multiply(0.25)).allow_hover(false));
            }
        }
        Mark::Points { colour, style, points, .. } => {
            for &[x, y, bar] in points.iter().filter(|point| point.iter().all(|value| value.is_finite())) {
                chart.line(line(vec![[x, y - bar], [x, y + bar]], colour, Style::Solid).width(1.0));
            }
            for part in points.split(|point| !(point[0].is_finite() && point[1].is_finite())) {
                let places = part.iter().map(|&[x, y, _]| [x, y]).collect();
                match style {
                    Style::Dots => chart.points(dots(places, colour)),
                    _ => chart.line(line(places, colour, *style)),
                }
            }
        }
        Mark::Bars { colour, width, bars, .. } => {
            let bars = bars.iter().map(|&[x, y]| Bar::new(x, y).width(*width)).collect();
            chart.bar_chart(BarChart::new("", bars).color(color(colour).gamma_multiply(0.6)).allow_hover(false));
        }
        Mark::Level { colour, value, band, .. } => {
            chart.polygon(rectangle(range.x, *band, color(colour)));
            chart.hline(HLine::new("", *value).color(color(colour)).allow_hover(false));
        }
        Mark::Span { colour, ends, .. } => chart.polygon(rectangle(*ends, range.y, color(colour))),
    }
}
