//! Natural modes: of a linear model, with their intervals, over a parameter, and as measured in a recording.

mod interval;
mod locus;
pub mod measured;
mod pencil;
mod response;

pub use doublet_core::motion::{Mode, MotionState, natural_modes};
pub use interval::{Figure, FigureInterval, ModeEstimate, ModeStudy, mode_study};
pub use locus::{LocusParameter, LocusPoint, locus};
pub use pencil::{FreeResponse, MeasuredMode, PencilError, fit_free_response};
pub use response::phasors;

use crate::linear::StateSpace;

/// Modes of a linear model, fastest first. Where a state has a name of its own, modes cannot be told apart and there are none.
pub fn modes(model: &StateSpace) -> Vec<Mode> {
    model.meanings().map(|meanings| natural_modes(&model.a, &meanings)).unwrap_or_default()
}
