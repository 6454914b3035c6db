//! Windows with an analysis of a curve: spectrum, spectrogram, derivative, scatter.

use doublet_core::prep::Spectrogram;
use doublet_core::series::Series;
use doublet_engine::graph::StageError;
use doublet_engine::run::Job;
use doublet_engine::trace::{SLOPE_HALF_WIDTH, TraceAnalysis, TraceView, analyse};
use eframe::egui::{
    self, Align2, Color32, FontId, Mesh, Rect, Role, Sense, Shape, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2,
};

use super::Workbench;
use crate::ui_state::TraceRequest;
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::figure::FigureRequest;
use crate::widgets::spectrum_chart::{density_unit, spectrum_chart, spectrum_curve};
use crate::widgets::ticks::draw_time_axis;
use crate::widgets::time_plot::TIME_AXIS_HEIGHT;
use crate::widgets::time_view::TimeRange;
use crate::{notation, theme};

/// Windows open at once; of one more the oldest is closed.
const MOST_OPEN: usize = 4;
/// Size of a window at first.
const SIZE: egui::Vec2 = vec2(460.0, 300.0);
/// Range of densities of a spectrogram, decades.
const DECADES: f64 = 5.0;
/// Room left of a spectrogram for the frequencies.
const AXIS: f32 = 52.0;
/// Distance of the frequencies named beside it.
const TICK: f32 = 40.0;

#[derive(Default)]
pub(super) struct Analyses {
    open: Vec<Analysis>,
    count: usize,
}

struct Analysis {
    number: usize,
    request: TraceRequest,
    job: Option<Job<TraceAnalysis>>,
    result: Option<Result<TraceAnalysis, String>>,
}

impl Workbench {
    /// Whether a curve is still being looked at.
    pub fn is_analysing(&self) -> bool {
        self.analyses.open.iter().any(|one| one.job.is_some())
    }

    /// What was found of the curves looked at, the newest last.
    pub fn analyses(&self) -> impl Iterator<Item = (&TraceRequest, &TraceAnalysis)> {
        self.analyses.open.iter().filter_map(|one| Some((&one.request, one.result.as_ref()?.as_ref().ok()?)))
    }

    /// Starts what was asked for in the menu of a plot, and draws the windows.
    pub(super) fn show_analyses(&mut self, ctx: &egui::Context) {
        if let Some(request) = self.state.analysis.take() {
            self.begin_analysis(request, ctx);
        }
        let mut figures = Vec::new();
        self.analyses.open.retain_mut(|one| {
            one.take();
            one.show(ctx, &mut figures)
        });
        self.figures.extend(figures);
    }

    fn begin_analysis(&mut self, request: TraceRequest, ctx: &egui::Context) {
        let wake = ctx.clone();
        let TraceRequest { series, range, view, .. } = request.clone();
        let wake = move || wake.request_repaint();
        match Job::start::<StageError>("analysis of a curve", wake, move |_, _| analyse(&view, &series, range)) {
            Ok(job) => {
                let analyses = &mut self.analyses;
                analyses.count += 1;
                analyses.open.push(Analysis { number: analyses.count, request, job: Some(job), result: None });
                if analyses.open.len() > MOST_OPEN {
                    analyses.open.remove(0);
                }
            }
            Err(error) => self.complain(error.to_string()),
        }
    }
}

/// A label with its unit.
fn labelled(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

impl Analysis {
    /// Takes what was found once it is there.
    fn take(&mut self) {
        if self.job.as_ref().is_some_and(Job::is_finished)
            && let Some(job) = self.job.take()
        {
            self.result = Some(job.finish().map_err(|error| error.to_string()));
        }
    }

    fn title(&self) -> String {
        let TraceRequest { name, range, view, over, .. } = &self.request;
        let [from, to] = [range.start_s, range.end_s].map(|time_s| notation::fixed(time_s, 1));
        let what = match (view, over) {
            (TraceView::Spectrum, _) => format!("Spectrum of {name}"),
            (TraceView::Spectrogram, _) => format!("Spectrogram of {name}"),
            (TraceView::Derivative, _) => format!("Derivative of {name}"),
            (TraceView::Scatter(_), Some((along, ..))) => format!("{name} against {along}"),
            (TraceView::Scatter(_), None) => format!("Scatter of {name}"),
        };
        format!("{what}, {from} to {to} s")
    }

    /// Draws it; whether it stays open.
    fn show(&self, ctx: &egui::Context, figures: &mut Vec<FigureRequest>) -> bool {
        let mut open = true;
        let title = self.title();
        let shift = 26.0 * (self.number % MOST_OPEN) as f32;
        egui::Window::new(notation::typeset(&title, 13.0))
            .id(egui::Id::unique(("analysis", self.number)))
            .open(&mut open)
            .default_pos(pos2(180.0 + shift, 120.0 + shift))
            .default_size(SIZE)
            .collapsible(false)
            .show(ctx, |ui| match &self.result {
                None => {
                    ui.horizontal(|ui| {
                        ui.spinner();
                        ui.weak("computing");
                    });
                }
                Some(Err(error)) => {
                    ui.label(format!("⚠ {error}"));
                }
                Some(Ok(found)) => self.draw(ui, found, figures),
            });
        open
    }

    fn draw(&self, ui: &mut Ui, found: &TraceAnalysis, figures: &mut Vec<FigureRequest>) {
        let palette = theme::palette(ui);
        let TraceRequest { name, unit, scale, .. } = &self.request;
        let id = |what: &str| format!("{what} {}", self.number);
        let height = (ui.available_height() - 18.0).max(160.0);
        let chart = match found {
            TraceAnalysis::Spectrum(found) => {
                let mut chart = spectrum_chart(&id("spectrum of a curve"), &found.frequency_hz, unit);
                chart.curves.push(spectrum_curve("", found, *scale, palette.series[0]));
                let at = (0..found.density.len()).max_by(|&i, &j| found.density[i].total_cmp(&found.density[j]));
                if let Some(at) = at {
                    ui.weak(format!("Highest at {} Hz", notation::number(found.frequency_hz[at])));
                }
                chart
            }
            TraceAnalysis::Spectrogram(found) => {
                ui.weak(format!("{DECADES} decades below the highest density, {}", density_unit(unit)));
                return spectrogram(ui, found, height);
            }
            TraceAnalysis::Derivative(Series { time_s, values }) => {
                ui.weak(format!("Slope of a parabola through {} samples", 2 * SLOPE_HALF_WIDTH + 1));
                let per_s = if unit.is_empty() { "1/s".to_owned() } else { format!("{unit}/s") };
                let mut chart =
                    Chart::new(&id("derivative of a curve"), "time [s]", labelled(&format!("d({name})/dt"), &per_s));
                let points = time_s.iter().zip(values.iter()).map(|(time_s, value)| [*time_s, scale * value]).collect();
                chart.curves.push(ChartCurve::new("", palette.series[0], ChartStyle::Line, points));
                chart
            }
            TraceAnalysis::Scatter { points, correlation, line } => self.scatter(ui, points, (*correlation, *line)),
        };
        let left = height - 22.0;
        figures.extend(chart.show(ui, left));
    }

    fn scatter(&self, ui: &mut Ui, points: &[[f64; 2]], (correlation, [slope, zero]): (f64, [f64; 2])) -> Chart {
        let palette = theme::palette(ui);
        let TraceRequest { name, unit, scale, over, .. } = &self.request;
        let (along, along_unit, along_scale) = over.clone().unwrap_or_default();
        ui.weak(format!("Correlation {}, {} points", notation::correlation(correlation), points.len()));
        let label = labelled(&along, &along_unit);
        let mut chart = Chart::new(&format!("scatter of a curve {}", self.number), label, labelled(name, unit));
        let drawn = points.iter().map(|[x, y]| [along_scale * x, scale * y]).collect();
        chart.curves.push(ChartCurve::new("samples", palette.series[0], ChartStyle::Dots(1.4), drawn));
        let ends = points
            .iter()
            .map(|point| point[0])
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
        let line = ends.map(|x| [along_scale * x, scale * (zero + slope * x)]).into();
        chart.curves.push(ChartCurve::new("least-squares line", palette.series[1], ChartStyle::Line, line));
        chart
    }
}

/// Draws a spectrogram: time along, frequency up, density as colour.
fn spectrogram(ui: &mut Ui, found: &Spectrogram, height: f32) {
    let palette = theme::palette(ui);
    let (outer, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "spectrogram"));
    let foot = outer.bottom() - TIME_AXIS_HEIGHT;
    let frame = Rect::from_min_max(pos2(outer.left() + AXIS, outer.top() + 4.0), pos2(outer.right() - 18.0, foot));
    let (columns, bins) = (found.time_s.len(), found.frequency_hz.len());
    let (Some(first), Some(last), Some(highest_hz)) =
        (found.time_s.first(), found.time_s.last(), found.frequency_hz.last())
    else {
        return;
    };
    let step_s = if columns > 1 { (last - first) / (columns - 1) as f64 } else { 1.0 };
    let range = TimeRange::new(first - 0.5 * step_s, last + 0.5 * step_s);
    let x = |time_s: f64| frame.left() + frame.width() * ((time_s - range.start_s) / range.length_s()) as f32;
    let y = |bin: f32| frame.bottom() - frame.height() * bin / bins as f32;
    let most = found.density.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut mesh = Mesh::default();
    for (time_s, densities) in found.time_s.iter().zip(&found.density) {
        let sides = x(time_s - 0.5 * step_s)..=x(time_s + 0.5 * step_s);
        for (bin, density) in densities.iter().enumerate() {
            let cell = Rect::from_x_y_ranges(sides.clone(), y(bin as f32 + 1.0)..=y(bin as f32));
            mesh.add_colored_rect(cell.intersect(frame), shade(palette, density / most));
        }
    }
    ui.painter().add(Shape::mesh(mesh));
    ui.painter().rect_stroke(frame, 0.0, Stroke::new(1.0, palette.grid), StrokeKind::Inside);
    let axis = Rect::from_x_y_ranges(frame.x_range(), foot..=outer.bottom());
    draw_time_axis(ui, axis, range, 84.0);
    let (ink, small) = (ui.visuals().weak_text_color(), FontId::proportional(11.0));
    let count = (frame.height() / TICK).floor().max(1.0) as usize;
    for tick in 0..=count {
        let part = tick as f64 / count as f64;
        let at = pos2(frame.left() - 5.0, frame.bottom() - frame.height() * part as f32);
        let align = if tick == count { Align2::RIGHT_TOP } else { Align2::RIGHT_CENTER };
        ui.painter().text(at, align, notation::fixed(part * highest_hz, 1), small.clone(), ink);
    }
    ui.painter().text(outer.left_top() + vec2(0.0, 2.0), Align2::LEFT_TOP, "Hz", small, ui.visuals().text_color());
}

/// Colour of a density as a part of the largest, over some decades.
fn shade(palette: &theme::Palette, part: f64) -> Color32 {
    let part = (1.0 + part.max(f64::MIN_POSITIVE).log10() / DECADES).clamp(0.0, 1.0) as f32;
    match part {
        part if part < 0.5 => palette.plot_background.lerp_to_gamma(palette.series[0], 2.0 * part),
        part => palette.series[0].lerp_to_gamma(palette.series[4], 2.0 * part - 1.0),
    }
}
