//! Widgets drawn by hand: they show what they are given and report what the user did.

pub mod aircraft_form;
pub mod attitude_view;
pub mod chart;
pub mod csv_text;
pub mod curves;
pub mod document_view;
pub mod figure;
pub mod figure_view;
pub mod grid;
pub mod guarded;
pub mod hatch;
pub mod heat_strip;
pub mod level_mark;
pub mod matrix_view;
mod plot_cache;
mod pointer;
pub mod quantity_edit;
mod readout;
pub mod scale_view;
pub mod scatter;
pub mod snap;
pub mod span_editor;
pub mod sparkline;
pub mod spectrum_chart;
mod stack_figure;
pub mod term;
pub mod ticks;
pub mod time_plot;
pub mod time_view;
mod trace_style;

use std::fmt::Debug;
use std::hash::Hash;

use eframe::egui::{Context, Id};

/// Where it is noted which of two sessions is being drawn.
const SIDE: &str = "the second session is being drawn";

/// States whether the second of two sessions beside each other is being drawn: what has the same name there has another id.
pub fn second_side(ctx: &Context, is_second: bool) {
    ctx.data_mut(|data| data.insert_temp(Id::unique(SIDE), is_second));
}

/// The id of what has a name, on the side that is being drawn.
pub fn named_id(ctx: &Context, name: impl Hash + Debug) -> Id {
    let is_second = ctx.data(|data| data.get_temp(Id::unique(SIDE)).unwrap_or(false));
    let id = Id::unique(name);
    if is_second { id.with("second") } else { id }
}

/// Says the value under the cursor to those who cannot see it.
pub fn speak_value(response: &egui::Response, value: String) {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_value(value));
}

/// Where an edit stands. A drag is `Begin`, any number of `Change`s, then `Commit` or `Cancel`; a typed value is a
/// `Commit` alone. Everything from `Begin` to `Commit` is one step of undo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EditPhase {
    /// A drag began; the value has not moved yet.
    Begin,
    /// The value moved and will move again.
    Change,
    /// The value is final.
    Commit,
    /// The drag was given up: the value is what it was at `Begin`.
    Cancel,
}
