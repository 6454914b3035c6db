//! Ticks of plot axes and their labels.

use doublet_report::svg::axis::{ROUND, multiples, step_of, tick_label};
use eframe::egui::{Align2, FontId, Rect, TextStyle, Ui, pos2};

use super::time_plot::x_at;
use super::time_view::TimeRange;

/// Least distance of a label of the value axis from the ends of its plot.
const TICK_ROOM: f32 = 7.0;

/// Ticks at least `spacing` points apart, a power of ten times 1, 2 or 5.
pub(super) fn ticks(input: egui_plot::GridInput, spacing: f32) -> Vec<egui_plot::GridMark> {
    marks(&input, step_of(&ROUND, input.base_step_size * f64::from(spacing / 8.0)))
}

fn marks(input: &egui_plot::GridInput, step_size: f64) -> Vec<egui_plot::GridMark> {
    let (low, high) = input.bounds;
    multiples([low, high], step_size).into_iter().map(|value| egui_plot::GridMark { value, step_size }).collect()
}

/// Draws the time axis of `range` into `area`, which is as wide as the frames above it.
pub fn draw_time_axis(ui: &Ui, area: Rect, range: TimeRange, spacing: f32) {
    let ink = ui.visuals().weak_text_color();
    let base_step_size = 8.0 * range.length_s() / f64::from(area.width().max(1.0));
    let marks = ticks(egui_plot::GridInput { bounds: (range.start_s, range.end_s), base_step_size }, spacing);
    let font = TextStyle::Body.resolve(ui.style());
    let painter = ui.painter();
    for mark in marks {
        let at = pos2(x_at(area, range, mark.value), area.top() + 3.0);
        painter.text(at, Align2::CENTER_TOP, tick(mark.value, mark.step_size), font.clone(), ink);
    }
    let foot = pos2(area.center().x, area.bottom() - 1.0);
    painter.text(foot, Align2::CENTER_BOTTOM, "time [s]", FontId::proportional(11.5), ui.visuals().text_color());
}

/// Ticks far enough from the ends that the labels of stacked plots do not run into one another; of a less round step where fewer
/// than two would be left, which tell no scale.
pub(super) fn inner_ticks(input: egui_plot::GridInput, spacing: f32) -> Vec<egui_plot::GridMark> {
    let room = f64::from(TICK_ROOM / 8.0) * input.base_step_size;
    let (low, high) = input.bounds;
    let least = input.base_step_size * f64::from(spacing / 8.0);
    let inside = |step| {
        let mut marks = marks(&input, step);
        marks.retain(|mark| mark.value - low > room && high - mark.value > room);
        marks
    };
    let round = inside(step_of(&ROUND, least));
    if round.len() > 1 { round } else { Some(inside(step_of(&DIGITS, least))).filter(|m| m.len() > 1).unwrap_or(round) }
}

/// First digits of a step of whole digits.
const DIGITS: [f64; 9] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0];

/// Text of a tick: as many decimals as its step needs, powers of ten where these would be too many.
pub(super) fn tick(value: f64, step: f64) -> String {
    let is_plain = value == 0.0 || step.abs() >= 1e-5 && value.abs() < 1e6;
    if is_plain { tick_label(value, step.abs().max(1e-9)) } else { format!("{value:.1e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_far_enough_apart_and_inside() {
        for (low, high) in [(0.0, 219.99), (-1.2, 1.2), (5000.0, 5000.5), (1e-5, 3e-5)] {
            let input = egui_plot::GridInput { bounds: (low, high), base_step_size: (high - low) / 900.0 * 8.0 };
            let marks = ticks(input, 84.0);
            assert!((4..=11).contains(&marks.len()), "{} ticks from {low} to {high}", marks.len());
            let digits = marks[0].step_size / 10f64.powf(marks[0].step_size.log10().floor());
            assert!([1.0, 2.0, 5.0].iter().any(|m| (digits - m).abs() < 1e-6), "step {}", marks[0].step_size);
            assert!(marks.iter().all(|mark| (low - 1e-9..=high + 1e-9).contains(&mark.value)));
        }
    }

    #[test]
    fn a_narrow_strip_has_two_labels_where_a_less_round_step_gives_them() {
        // 52 points from -50 to 2050: of 1, 2 and 5 only a thousand is far enough from its neighbours, and alone.
        let input = egui_plot::GridInput { bounds: (-50.0, 2050.0), base_step_size: 2100.0 / 52.0 * 8.0 };
        let values: Vec<f64> = inner_ticks(input, 18.0).iter().map(|mark| mark.value).collect();
        assert_eq!(values, [800.0, 1600.0]);
    }
}
