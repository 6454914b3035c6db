//! Replay of the flight: the aircraft in its attitude, measured, reconstructed and simulated, with velocity, wind and controls.

use doublet_core::airframe::Aircraft;
use doublet_core::quantity::Dimension;
use doublet_engine::aircraft::{Instant, Motion, ShapePart, instant, ned_from_body, shape};
use eframe::egui::{self, Align, Align2, Color32, FontId, Grid, Label, Layout, RichText, Sense, Slider, Ui, vec2};

use crate::panels::{Panel, PanelContext, awaiting, choices, empty};
use crate::widgets::attitude_view::{Arrow, AttitudeView, Camera, Face};
use crate::widgets::figure::FigureRequest;
use crate::widgets::time_view::TimeRange;
use crate::{notation, theme};

/// How many times faster than it was flown.
const SPEEDS: [(f64, &str); 5] = [(0.25, "¼×"), (1.0, "1×"), (4.0, "4×"), (16.0, "16×"), (64.0, "64×")];
/// Longest step from frame to frame, s: after a pause the picture does not jump.
const LONGEST_STEP_S: f64 = 0.1;
/// Length of the longest arrow over the span.
const ARROW: f64 = 0.62;
/// Radius of the compass over the span.
const COMPASS: f64 = 0.66;
/// Deflection that fills a bar, rad.
const FULL_DEFLECTION_RAD: f64 = 0.45;
/// Width of the numbers beside the picture, and that of a panel with room for both, points.
const NUMBERS: f32 = 306.0;
const BESIDE: f32 = 640.0;

/// What a motion is of, in the order of the columns.
const SOURCES: [&str; 3] = ["measured", "reconstructed", "model"];

pub struct Replay {
    is_playing: bool,
    speed: f64,
    /// Plays the chosen window, not the part of the flight on screen.
    of_window: bool,
    side_by_side: bool,
    /// Where it stands, once it was moved.
    now_s: Option<f64>,
    camera: Camera,
    shown: [bool; 3],
}

impl Default for Replay {
    fn default() -> Self {
        Self {
            is_playing: false,
            speed: 1.0,
            of_window: true,
            side_by_side: false,
            now_s: None,
            camera: Camera::default(),
            shown: [true; 3],
        }
    }
}

impl Panel for Replay {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let Some(flight) = ctx.selection().flight.clone() else { return empty(ui, "The session has no flight.") };
        let range = match ctx.window().filter(|_| self.of_window) {
            Some(window) => TimeRange::new(window.window.start_s, window.window.end_s),
            None => ctx.state.time.range(),
        };
        let Some(read) = ctx.snapshot.aircraft.latest() else {
            return awaiting(ctx, ui, "the aircraft", "Choose an aircraft: the picture uses its proportions.");
        };
        let now_s = self.follow_time(ctx, ui, range);
        self.controls(ctx, ui, range, now_s);
        let now = instant(ctx.snapshot, &flight, ctx.window(), now_s);
        let sources = [now.measured, now.reconstructed, now.model];
        let beside = ui.available_width() > BESIDE;
        if beside {
            let height = ui.available_height();
            ui.horizontal_top(|ui| {
                let width = ui.available_width() - NUMBERS;
                let down = Layout::top_down(Align::LEFT);
                ui.allocate_ui_with_layout(vec2(width, height), down, |ui| {
                    self.pictures(ctx, ui, &read.aircraft, &now, &sources);
                });
                ui.vertical(|ui| {
                    numbers(ctx, ui, &sources, &now);
                    deflections(ctx, ui, &now);
                });
            });
        } else {
            let height = (ui.available_height() - 236.0).max(120.0);
            let width = ui.available_width();
            let down = Layout::top_down(Align::LEFT);
            ui.allocate_ui_with_layout(vec2(width, height), down, |ui| {
                self.pictures(ctx, ui, &read.aircraft, &now, &sources);
            });
            deflections(ctx, ui, &now);
            numbers(ctx, ui, &sources, &now);
        }
    }
}

impl Replay {
    /// The time shown: that of the play, or of the pointer in another plot while nothing plays. All plots follow.
    fn follow_time(&mut self, ctx: &mut PanelContext<'_>, ui: &Ui, range: TimeRange) -> f64 {
        if self.is_playing {
            let step_s = f64::from(ui.input(|input| input.stable_dt)).min(LONGEST_STEP_S);
            let next_s = self.now_s.filter(|now| range.contains(*now)).unwrap_or(range.start_s) + self.speed * step_s;
            self.is_playing = next_s < range.end_s;
            self.now_s = Some(next_s.min(range.end_s));
            ui.ctx().request_repaint();
        } else if let Some(pointed_s) = ctx.state.time.cursor_s.filter(|at| range.contains(*at)) {
            self.now_s = self.now_s.map(|_| pointed_s);
            if self.now_s.is_none() {
                return pointed_s;
            }
        }
        // The path of a window begins a sample or two behind its edge: in the middle there is everything.
        let middle_s = 0.5 * (range.start_s + range.end_s);
        let now_s = self.now_s.unwrap_or(middle_s).clamp(range.start_s, range.end_s);
        if self.now_s.is_some() && (self.is_playing || ctx.hovered_s.is_none()) {
            *ctx.hovered_s = Some(now_s);
        }
        now_s
    }

    fn controls(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, range: TimeRange, now_s: f64) {
        ui.horizontal_wrapped(|ui| {
            let (name, hint) =
                if self.is_playing { ("⏸ Pause", "Stop here") } else { ("▶ Play", "From here to the end") };
            if ui.button(name).on_hover_text(hint).clicked() {
                self.is_playing = !self.is_playing;
                let begins = self.is_playing && (now_s >= range.end_s || self.now_s.is_none());
                self.now_s = Some(if begins { range.start_s } else { now_s });
                ui.ctx().request_repaint();
            }
            choices(ui, &mut self.speed, &SPEEDS);
            ui.separator();
            choices(ui, &mut self.of_window, &[(true, "Manoeuvre"), (false, "Flight")]);
            ui.separator();
            choices(ui, &mut self.side_by_side, &[(false, "Overlaid"), (true, "Side by side")]);
        });
        ui.horizontal(|ui| {
            let mut time_s = now_s;
            ui.spacing_mut().slider_width = (ui.available_width() - 96.0).max(60.0);
            let slider = ui.add(Slider::new(&mut time_s, range.start_s..=range.end_s).show_value(false));
            ui.ctx().accesskit_node_builder(slider.id, |node| node.set_label("time of the replay"));
            if slider.changed() {
                self.now_s = Some(time_s);
                *ctx.hovered_s = Some(time_s);
                ui.ctx().request_repaint();
            }
            ui.label(RichText::new(format!("{} s", notation::fixed(now_s, 2))).font(theme::figures(ui)));
        });
    }

    /// One picture of all that is shown, or one of each source there is.
    fn pictures(
        &mut self,
        ctx: &mut PanelContext<'_>,
        ui: &mut Ui,
        aircraft: &Aircraft,
        now: &Instant,
        sources: &[Motion; 3],
    ) {
        let size = ui.available_size();
        let there: Vec<usize> = (0..3).filter(|&source| sources[source].attitude_rad.is_some()).collect();
        if there.is_empty() {
            return empty(ui, "No attitude here, neither recorded nor reconstructed.");
        }
        if self.side_by_side {
            let camera = &mut self.camera;
            ui.columns(there.len(), |columns| {
                for (ui, &source) in columns.iter_mut().zip(&there) {
                    let color = colors(ui)[source];
                    ui.label(RichText::new(SOURCES[source]).color(color).size(12.0));
                    let size = vec2(ui.available_width(), size.y - 20.0);
                    let figure = picture(ui, (aircraft, now), (sources, &[source]), (SOURCES[source], size), camera);
                    ctx.figures.extend(figure);
                }
            });
        } else {
            ui.horizontal_wrapped(|ui| {
                for &source in &there {
                    let text = RichText::new(SOURCES[source]).color(colors(ui)[source]).size(12.0);
                    ui.checkbox(&mut self.shown[source], text);
                }
            });
            let shown: Vec<usize> = there.into_iter().filter(|&source| self.shown[source]).collect();
            let size = vec2(ui.available_width(), (size.y - 26.0).max(60.0));
            let figure = picture(ui, (aircraft, now), (sources, &shown), ("attitude", size), &mut self.camera);
            ctx.figures.extend(figure);
        }
    }
}

/// Colours of measured, reconstructed and model, as in the plots.
fn colors(ui: &Ui) -> [Color32; 3] {
    let series = theme::palette(ui).series;
    [series[1], series[0], series[2]]
}

/// The outlines of the chosen sources with arrows of one of them.
fn picture(
    ui: &mut Ui,
    (aircraft, now): (&Aircraft, &Instant),
    (sources, chosen): (&[Motion; 3], &[usize]),
    (name, size): (&str, egui::Vec2),
    camera: &mut Camera,
) -> Option<FigureRequest> {
    let span_m = aircraft.reference.span_m;
    let cg = now.mass.map_or(aircraft.empty.cg_from_datum_m, |(_, cg)| cg);
    let outlines = shape(aircraft, cg, now.controls_rad.map(Option::unwrap_or_default));
    let (colors, accent) = (colors(ui), theme::palette(ui).warning);
    // The one that is reconstructed is filled and has the arrows, where it is shown.
    let first = chosen.iter().copied().find(|&source| source == 1).or(chosen.first().copied());
    let mut faces = Vec::new();
    for &source in chosen {
        let Some(attitude) = sources[source].attitude_rad else { continue };
        let turn = ned_from_body(attitude);
        let is_first = Some(source) == first;
        let color = colors[source];
        faces.extend(outlines.iter().map(|outline| {
            let part = match (is_first, outline.part) {
                (true, ShapePart::Control) => accent.gamma_multiply(0.75),
                (true, ShapePart::Wing | ShapePart::Tail) => color.gamma_multiply(0.35),
                _ => Color32::TRANSPARENT,
            };
            let strength = if outline.part == ShapePart::Body { 0.6 } else { 1.0 };
            let corners = outline.corners.iter().map(|&corner| turn(corner)).collect();
            Face { corners, line: color.gamma_multiply(strength), fill: part }
        }));
    }
    let motion = first.map(|source| sources[source]).unwrap_or_default();
    let arrows = arrows(ui, &motion, now, span_m);
    let heading_rad = motion.attitude_rad.map_or(0.0, |[_, _, heading]| heading);
    let view = AttitudeView { name, radius_m: COMPASS * span_m, heading_rad, faces: &faces, arrows: &arrows };
    view.show(ui, size, camera)
}

/// Velocity through the air, wind at its end, velocity over the ground: one triangle, at one scale.
fn arrows(ui: &Ui, motion: &Motion, now: &Instant, span_m: f64) -> Vec<Arrow> {
    let palette = theme::palette(ui);
    let length = |vector: [f64; 3]| vector.iter().map(|part| part * part).sum::<f64>().sqrt();
    let air = motion.air_velocity_ned_m_s();
    let ground = motion.velocity_ned_m_s;
    let longest = air.into_iter().chain(ground).map(length).fold(1.0, f64::max);
    let at = |vector: [f64; 3]| vector.map(|part| ARROW * span_m / longest * part);
    let mut arrows = Vec::new();
    let mut add = |name, ends, color| arrows.push(Arrow { name, ends, color });
    air.into_iter().for_each(|air| add("through the air", [[0.0; 3], at(air)], palette.series[4]));
    ground.into_iter().for_each(|ground| add("over the ground", [[0.0; 3], at(ground)], palette.series[3]));
    if let (Some(air), Some(wind)) = (air, now.wind_ned_m_s) {
        let end = [0, 1, 2].map(|axis| air[axis] + wind[axis]);
        add("wind", [at(air), at(end)], palette.series[6]);
    }
    arrows
}

/// Attitude, flow and speed of every source, and the wind.
fn numbers(ctx: &PanelContext<'_>, ui: &mut Ui, sources: &[Motion; 3], now: &Instant) {
    let (degrees, per_rad) = ctx.unit(Dimension::Angle);
    let (speed, per_m_s) = ctx.unit(Dimension::Speed);
    let palette = theme::palette(ui);
    let attitude = |axis: usize| move |motion: &Motion| motion.attitude_rad.map(|attitude| attitude[axis]);
    let over_ground = |motion: &Motion| motion.velocity_ned_m_s.map(|[north, east, _]| north.hypot(east));
    let climb = |motion: &Motion| motion.velocity_ned_m_s.map(|[_, _, down]| -down);
    type Value<'v> = &'v dyn Fn(&Motion) -> Option<f64>;
    let rows: [(&str, &str, f64, Value<'_>, Option<Color32>); 8] = [
        ("bank φ", degrees, per_rad, &attitude(0), None),
        ("pitch θ", degrees, per_rad, &attitude(1), None),
        ("heading ψ", degrees, per_rad, &attitude(2), None),
        ("airspeed V", speed, per_m_s, &|motion| motion.airspeed_m_s, Some(palette.series[4])),
        ("angle of attack α", degrees, per_rad, &|motion| motion.alpha_rad, None),
        ("sideslip β", degrees, per_rad, &|motion| motion.beta_rad, None),
        ("ground speed", speed, per_m_s, &over_ground, Some(palette.series[3])),
        ("rate of climb", speed, per_m_s, &climb, None),
    ];
    let colors = colors(ui);
    Grid::new("numbers of the replay").num_columns(4).striped(true).spacing([8.0, 2.0]).show(ui, |ui| {
        ui.label("");
        for (name, color) in ["measured", "reconstr.", "model"].into_iter().zip(colors) {
            ui.label(RichText::new(name).size(11.0).color(color));
        }
        ui.end_row();
        for (name, unit, scale, value, color) in rows {
            let text = RichText::new(format!("{name} [{unit}]")).size(11.5);
            ui.label(if let Some(color) = color { text.color(color) } else { text });
            for motion in sources {
                cell(ui, value(motion).map(|value| scale * value));
            }
            ui.end_row();
        }
    });
    if let Some([north, east, down]) = now.wind_ned_m_s {
        let [north, east, down] = [north, east, down].map(|part| notation::fixed(per_m_s * part, 1));
        let text = format!("wind to north {north}, east {east}, down {down} {speed}");
        ui.label(RichText::new(text).size(11.5).color(palette.series[6]));
    }
    if let Some((mass_kg, [x, ..])) = now.mass {
        let (unit, scale) = ctx.unit(Dimension::Length);
        // An aircraft without stations has its centre of gravity at the datum.
        let cg = if x == 0.0 { String::new() } else { format!(", CG x {} {unit}", notation::fixed(scale * x, 3)) };
        let text = format!("mass {} kg{cg}", notation::fixed(mass_kg, 1));
        ui.label(RichText::new(text).size(11.5));
    }
}

fn cell(ui: &mut Ui, value: Option<f64>) {
    let text = value.map_or_else(|| "–".to_owned(), |value| notation::fixed(value, 2));
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        ui.add(Label::new(RichText::new(text).font(theme::figures(ui)).size(11.5)));
    });
}

/// A bar from the middle for each control.
fn deflections(ctx: &PanelContext<'_>, ui: &mut Ui, now: &Instant) {
    let (unit, scale) = ctx.unit(Dimension::Angle);
    let palette = theme::palette(ui);
    ui.add_space(4.0);
    for (name, value) in ["aileron", "elevator", "rudder"].into_iter().zip(now.controls_rad) {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width().min(NUMBERS), 16.0), Sense::hover());
        let text =
            value.map_or_else(|| "–".to_owned(), |value| format!("{} {unit}", notation::fixed(scale * value, 2)));
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, format!("{name} {text}")));
        let painter = ui.painter_at(rect);
        let (font, ink) = (FontId::proportional(11.0), ui.visuals().text_color());
        painter.text(rect.left_center(), Align2::LEFT_CENTER, name, font.clone(), ink);
        painter.text(rect.right_center(), Align2::RIGHT_CENTER, &text, font, ink);
        let bar = egui::Rect::from_min_max(rect.min + vec2(58.0, 4.0), rect.max - vec2(66.0, 4.0));
        painter.rect_filled(bar, 2.0, palette.grid);
        let Some(value) = value else { continue };
        let middle = bar.center().x;
        #[expect(clippy::cast_possible_truncation, reason = "points of a screen")]
        let reach = (value / FULL_DEFLECTION_RAD).clamp(-1.0, 1.0) as f32 * 0.5 * bar.width();
        let filled =
            egui::Rect::from_x_y_ranges(middle.min(middle + reach)..=middle.max(middle + reach), bar.y_range());
        painter.rect_filled(filled, 2.0, palette.warning);
        painter.vline(middle, bar.y_range(), egui::Stroke::new(1.0, ink));
    }
}
