//! Time plots: gaps, cursor, zoom, and what a frame costs.

use std::sync::Arc;

use doublet::theme;
use doublet::widgets::figure::FigureRequest;
use doublet::widgets::span_editor::{LANE_HEIGHT, Lane, SpanEvent, SpanItem, span_lane};
use doublet::widgets::time_plot::{
    PlotCache, SpanMark, StackResponse, TimePlot, Trace, TraceStyle, step_markers, time_at, time_stack, x_at,
};
use doublet::widgets::time_view::{TimeRange, TimeView};
use doublet_core::series::Series;
use egui::{Id, Modifiers, PointerButton, Pos2, pos2};
use egui_kittest::Harness;

use crate::allocations::bytes_during;
use crate::rasteriser::holds_color;
use crate::{drag, picture, widget_harness};

/// Rounding of a screen position to a time, in pixels of the plot.
const PIXELS: f64 = 1.5;
/// Bytes a frame of two plots may ask for whatever the length of the recording: points of about 1000 columns are
/// 32 kB per trace, and egui's shapes and meshes hold them a few times over.
const FRAME_BYTES: usize = 6_000_000;

/// A recording on screen.
pub struct Bench {
    pub view: TimeView,
    pub cache: PlotCache,
    pub seen: StackResponse,
    pub events: Vec<SpanEvent>,
    pub figures: Vec<FigureRequest>,
    rates: [Series; 2],
    truth: Series,
    sigma: Arc<[f64]>,
}

impl Bench {
    /// `count` samples at 100 Hz of two signals with a hole in the first.
    pub fn new(count: usize) -> Self {
        let time_s: Arc<[f64]> = (0..count).map(|k| k as f64 * 0.01).collect();
        let hole = count * 6 / 10..count * 7 / 10;
        let noise = |k: usize| ((k as u64).wrapping_mul(6_364_136_223_846_793_005) >> 40) as f64 / 1.6e7 - 0.5;
        let wave = |k: usize| (k as f64 * 0.008).sin() * (k as f64 * 0.0013).cos();
        let measured =
            (0..count).map(|k| if hole.contains(&k) { f64::NAN } else { wave(k) + 0.15 * noise(k) }).collect();
        let smooth: Arc<[f64]> = (0..count).map(|k| 30.0 * wave(k + 90)).collect();
        let series = |values| Series { time_s: time_s.clone(), values };
        Self {
            view: TimeView::new(TimeRange::new(0.0, (count - 1) as f64 * 0.01)),
            cache: PlotCache::default(),
            seen: StackResponse::default(),
            events: Vec::new(),
            figures: Vec::new(),
            rates: [series(measured), series(smooth)],
            truth: series((0..count).map(wave).collect()),
            sigma: (0..count).map(|k| 2.0 + 1.5 * (k as f64 * 0.002).sin()).collect(),
        }
    }

    /// Draws lane and plots.
    pub fn show(ui: &mut egui::Ui, bench: &mut Self) {
        let colors = theme::palette(ui).series;
        let [rate, angle] = &bench.rates;
        let measured = Trace { style: TraceStyle::Dots, ..Trace::new("q measured", rate, colors[0]) };
        let truth = Trace { style: TraceStyle::Dashed, ..Trace::new("q̂", &bench.truth, colors[1]) };
        let estimate = Trace { sigma: Some(&bench.sigma), ..Trace::new("α̇", angle, colors[2]) };
        let plots = [
            TimePlot::new("q", "rad/s", vec![measured, truth]),
            TimePlot { levels: vec![25.0], ..TimePlot::new("α̇", "deg/s", vec![estimate]) },
        ];
        let length = bench.view.full().length_s();
        let palette = theme::palette(ui);
        let spans = [
            (1, TimeRange::new(0.10 * length, 0.25 * length), "3-2-1-1 δₑ", palette.identification, true),
            (2, TimeRange::new(0.40 * length, 0.52 * length), "doublet δₐ", palette.validation, false),
        ];
        let marks = spans.map(|(_, part, _, color, selected)| SpanMark { part, color, selected });
        let items = spans.map(|(id, part, label, color, selected)| SpanItem {
            overlaps: false,
            id,
            part,
            label,
            note: "",
            excluded: &[],
            color,
            still: false,
            locked: false,
            selected,
        });
        let (_, rect) = ui.allocate_space(egui::vec2(ui.available_width(), LANE_HEIGHT));
        bench.seen = time_stack(ui, Id::unique("bench"), &mut bench.view, &mut bench.cache, &plots, &marks);
        bench.figures.extend(bench.seen.figure.take());
        let lane = Lane {
            rect,
            frame: bench.seen.frames[0],
            reach_bottom: bench.seen.frames[1].bottom(),
            range: bench.view.range(),
            samples_s: &rate.time_s,
            points: &[],
        };
        step_markers(ui, &mut bench.view, &rate.time_s);
        bench.events.extend(span_lane(ui, Id::unique("lane"), &lane, &items));
    }
}

pub fn harness<'a>(count: usize, dark: bool) -> Harness<'a, Bench> {
    let mut harness = widget_harness((1000.0, 520.0), dark, Bench::new(count), Bench::show);
    harness.run_steps(3);
    harness
}

/// Time at the middle of the first plot.
pub fn middle(harness: &Harness<'_, Bench>) -> Pos2 {
    harness.state().seen.frames[0].center()
}

#[test]
fn stacked_plots_share_their_left_and_right_edges() {
    let harness = harness(5000, true);
    let frames = &harness.state().seen.frames;
    assert_eq!(frames.len(), 2);
    assert_eq!(frames[0].x_range(), frames[1].x_range());
    assert!((frames[0].height() - frames[1].height()).abs() <= 1.0, "{frames:?}");
}

#[test]
fn traces_bands_and_holes_are_drawn_in_both_themes() {
    for dark in [true, false] {
        let mut harness = harness(20_000, dark);
        let at = middle(&harness) + egui::vec2(-60.0, 0.0);
        harness.hover_at(at);
        harness.run_steps(2);
        let image = picture(&mut harness, if dark { "plots_dark" } else { "plots_light" });
        let palette = theme::palette_of(dark);
        assert!(holds_color(&image, palette.series[1], 40), "the dashed truth is drawn");
        assert!(holds_color(&image, palette.series[2], 12), "the estimate is drawn");
    }
}

#[test]
fn cursor_is_the_time_under_the_pointer_in_every_plot() {
    let mut harness = harness(5000, true);
    let [first, second] = [0, 1].map(|row| harness.state().seen.frames[row].center());
    harness.hover_at(first + egui::vec2(100.0, 0.0));
    harness.run_steps(2);
    let above = harness.state().view.cursor_s.unwrap();
    harness.hover_at(second + egui::vec2(100.0, 0.0));
    harness.run_steps(2);
    assert_eq!(harness.state().view.cursor_s, Some(above));
    assert_eq!(harness.state().seen.hovered_plot, Some(1));
}

#[test]
fn drag_pans_wheel_zooms_about_the_pointer_and_history_leads_back() {
    let mut harness = harness(100_000, true);
    let full = harness.state().view.full();
    let at = middle(&harness);
    harness.hover_at(at);
    harness.step();
    let wheel = |y| egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: egui::vec2(0.0, y),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    };
    let (frame, before) = (harness.state().seen.frames[0], harness.state().view.range());
    let under = time_at(frame, before, at.x);
    harness.event(wheel(200.0));
    harness.run_steps(40);
    let zoomed = harness.state().view.range();
    assert!(zoomed.length_s() < 0.6 * full.length_s(), "{zoomed:?}");
    let tolerance_s = PIXELS * zoomed.length_s() / f64::from(frame.width());
    assert!((time_at(frame, zoomed, at.x) - under).abs() < tolerance_s);
    drag(&mut harness, at, at + egui::vec2(-120.0, 0.0), 6);
    let panned = harness.state().view.range();
    let expected_s = zoomed.start_s + 120.0 * zoomed.length_s() / f64::from(frame.width());
    assert!((panned.start_s - expected_s).abs() < tolerance_s, "{panned:?} {expected_s}");
    assert!((panned.length_s() - zoomed.length_s()).abs() < 1e-6);
    while harness.state_mut().view.go_back() {}
    assert_eq!(harness.state().view.range(), full);
}

#[test]
fn right_drag_shows_exactly_the_part_it_covered_and_double_click_everything() {
    let mut harness = harness(100_000, true);
    let (frame, full) = (harness.state().seen.frames[0], harness.state().view.full());
    let [from, to] = [300.0, 420.0].map(|x| pos2(frame.left() + x, frame.center().y));
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: PointerButton::Secondary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    harness.hover_at(from);
    harness.step();
    harness.event(button(from, true));
    harness.step();
    for x in [10.0, 60.0, 120.0] {
        harness.hover_at(from + egui::vec2(x, 0.0));
        harness.step();
    }
    harness.event(button(to, false));
    harness.run_steps(2);
    let range = harness.state().view.range();
    let per_pixel_s = full.length_s() / f64::from(frame.width());
    assert!((range.start_s - time_at(frame, full, from.x)).abs() < PIXELS * per_pixel_s, "{range:?}");
    assert!((range.end_s - time_at(frame, full, to.x)).abs() < PIXELS * per_pixel_s, "{range:?}");
    for _ in 0..2 {
        harness.drag_at(from);
        harness.event(egui::Event::PointerButton {
            pos: from,
            button: PointerButton::Primary,
            pressed: false,
            modifiers: Modifiers::NONE,
        });
    }
    harness.run_steps(3);
    assert_eq!(harness.state().view.range(), full);
}

#[test]
fn zoomed_in_every_sample_is_a_point_of_its_own() {
    let mut harness = harness(1_000_000, true);
    harness.state_mut().view.zoom_to(TimeRange::new(5000.0, 5000.5));
    harness.run_steps(2);
    picture(&mut harness, "plots_exact");
    let frame = harness.state().seen.frames[0];
    let range = harness.state().view.range();
    let spacing = x_at(frame, range, 5000.01) - x_at(frame, range, 5000.0);
    assert!(spacing > 10.0, "samples lie {spacing} points apart");
}

#[test]
fn nothing_is_decimated_again_while_nothing_changes() {
    let mut harness = harness(200_000, true);
    let before = harness.state().cache.refreshed();
    harness.run_steps(10);
    assert_eq!(harness.state().cache.refreshed(), before);
    harness.state_mut().view.zoom_to(TimeRange::new(10.0, 900.0));
    harness.run_steps(3);
    assert_eq!(harness.state().cache.refreshed(), before + 3, "three traces, once each");
}

#[test]
fn a_frame_of_a_million_samples_asks_for_no_more_memory_than_one_of_ten_thousand() {
    let cost = |count| {
        let mut harness = harness(count, true);
        let length = harness.state().view.full().length_s();
        harness.run_steps(5);
        let pan = |harness: &mut Harness<'_, Bench>, share: f64| {
            harness.state_mut().view.zoom_to(TimeRange::new(share * length, (share + 0.7) * length));
            harness.step();
        };
        pan(&mut harness, 0.0);
        (1..=3).map(|k| bytes_during(|| pan(&mut harness, 0.1 * f64::from(k)))).max().unwrap()
    };
    let (short, long) = (cost(10_000), cost(1_000_000));
    println!("bytes per frame: {short} with 10 000 samples, {long} with 1 000 000");
    assert!(long < FRAME_BYTES, "{long} bytes");
    assert!(long < 2 * short, "{long} bytes against {short}");
}

/// Traces of a whole flight: 90 minutes at 100 Hz.
const FLIGHT_SAMPLES: usize = 540_000;
/// Frames measured.
const FRAMES: usize = 200;

#[test]
#[ignore = "measures time: run alone, `cargo test --test ui frame_time -- --ignored --nocapture`"]
fn frame_time_12_plots_540000_samples() {
    let time_s: Arc<[f64]> = (0..FLIGHT_SAMPLES).map(|k| k as f64 * 0.01).collect();
    let wave = |plot: usize| (0..FLIGHT_SAMPLES).map(|k| (k as f64 * 0.001 * (plot + 1) as f64).sin()).collect();
    let series: Vec<Series> = (0..12).map(|plot| Series { time_s: time_s.clone(), values: wave(plot) }).collect();
    let full = TimeRange::new(0.0, time_s[FLIGHT_SAMPLES - 1]);
    let ctx = egui::Context::default();
    theme::install(&ctx);
    let (mut view, mut cache) = (TimeView::new(full), PlotCache::default());
    let mut times_ms: Vec<f64> = (0..FRAMES + 5)
        .map(|frame| {
            let shift = 5.0 * frame as f64;
            view.zoom_to(TimeRange::new(shift, shift + 0.75 * full.end_s));
            let input = egui::RawInput {
                screen_rect: Some(egui::Rect::from_min_size(Pos2::ZERO, egui::vec2(1400.0, 1200.0))),
                ..Default::default()
            };
            let start = std::time::Instant::now();
            let output = ctx.run_ui(input, |ui| {
                let color = theme::palette(ui).series[0];
                let plots: Vec<_> = series
                    .iter()
                    .map(|series| TimePlot::new("signal", "m/s", vec![Trace::new("signal", series, color)]))
                    .collect();
                time_stack(ui, Id::unique("flight"), &mut view, &mut cache, &plots, &[]);
            });
            let meshes = ctx.tessellate(output.shapes, output.pixels_per_point);
            assert!(!meshes.is_empty());
            let mut textures = output.textures_delta;
            textures.clear();
            1e3 * start.elapsed().as_secs_f64()
        })
        .skip(5)
        .collect();
    times_ms.sort_by(f64::total_cmp);
    let (median, late) = (times_ms[FRAMES / 2], times_ms[FRAMES * 99 / 100]);
    println!("frame of 12 plots x {FLIGHT_SAMPLES} samples while panning: median {median:.1} ms, 99 % {late:.1} ms");
    assert!(median < 16.0 && late < 33.0);
}

#[test]
fn markers_are_set_by_clicks_with_a_modifier_and_stepped_by_samples() {
    let mut harness = harness(5000, true);
    let (frame, range) = (harness.state().seen.frames[0], harness.state().view.range());
    let click = |harness: &mut Harness<'_, Bench>, x: f32, modifiers: Modifiers| {
        let pos = pos2(frame.left() + x, frame.center().y);
        harness.hover_at(pos);
        harness.step();
        for pressed in [true, false] {
            let button = PointerButton::Primary;
            let event = egui::Event::PointerButton { pos, button, pressed, modifiers };
            harness.event_modifiers(event, modifiers);
            harness.step();
        }
        harness.run_steps(8);
        time_at(frame, range, pos.x)
    };
    let a = click(&mut harness, 200.0, Modifiers::SHIFT);
    let b = click(&mut harness, 600.0, Modifiers::COMMAND);
    assert_eq!(harness.state().view.markers_s, [Some(a), Some(b)]);
    assert_eq!(harness.state().view.range(), range, "a click moves nothing");
    harness.remove_cursor();
    harness.state_mut().view.cursor_s = None;
    harness.run_steps(2);
    picture(&mut harness, "plots_markers");
    harness.key_press(egui::Key::ArrowRight);
    harness.run_steps(2);
    let [Some(stepped), _] = harness.state().view.markers_s else { panic!("marker A is gone") };
    assert!(stepped > a && stepped - a <= 0.01, "{stepped} after {a}");
    assert!((stepped / 0.01 - (stepped / 0.01).round()).abs() < 1e-9, "{stepped} is no sample");
}

#[test]
fn the_line_of_a_fit_is_seen_on_the_dots_it_is_fitted_to_whichever_comes_first() {
    let time_s: Arc<[f64]> = (0..2000).map(|k| k as f64 * 0.01).collect();
    let values: Arc<[f64]> = time_s.iter().map(|time_s| (0.8 * time_s).sin()).collect();
    let series = Series { time_s, values };
    for line_first in [true, false] {
        let series = series.clone();
        let state = (TimeView::new(TimeRange::new(0.0, 20.0)), PlotCache::default());
        let mut harness = widget_harness((700.0, 260.0), true, state, move |ui, (view, cache)| {
            let colors = theme::palette(ui).series;
            let observed = Trace { style: TraceStyle::Dots, ..Trace::new("observed", &series, colors[7]) };
            let fit = Trace::new("fit", &series, colors[0]);
            let traces = if line_first { vec![fit, observed] } else { vec![observed, fit] };
            let _ = time_stack(ui, Id::unique("dots"), view, cache, &[TimePlot::new("Cm", "", traces)], &[]);
        });
        harness.run_steps(3);
        let image = picture(&mut harness, &format!("dots_{line_first}"));
        let colors = theme::DARK.series;
        // Below the legend, where both colours are as well.
        let near = |color: egui::Color32| {
            let is_near =
                |pixel: &image::Rgba<u8>| pixel.0.iter().zip(color.to_array()).take(3).all(|(a, b)| a.abs_diff(b) < 40);
            image.enumerate_pixels().filter(|&(_, y, pixel)| y > 40 && is_near(pixel)).count()
        };
        let (line, dots) = (near(colors[0]), near(colors[7]));
        assert!(line > 600 && line > 4 * dots, "{line} pixels of the line, {dots} of the dots");
    }
}
