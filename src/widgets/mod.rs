//! Widgets drawn by hand: they show what they are given and report what the user did.

pub mod attitude_view;
pub mod chart;
pub mod curves;
pub mod document_view;
pub mod figure;
pub mod figure_view;
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
