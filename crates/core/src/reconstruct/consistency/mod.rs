//! Consistency of a run: of its innovations, of filter and smoother, and what the window can observe at all.

pub mod innovations;
pub mod observability;
pub mod smoother;

pub use innovations::{ChannelConsistency, Consistency, LAGS, WORTH_CHANGING, consistency};
pub use observability::{Observability, WeakState, observability, weak_states};
pub use smoother::{Disagreement, filter_smoother_disagreement};
