//! The filter and smoother in their fast form: P in 3 x 3 blocks, one manoeuvre per lane of a vector.
//!
//! `filter::ekf` and `smoother::rts` specify what it computes; neither knows of the other, and `tests/core/reconstruct/equality.rs` proves
//! them equal.

pub(crate) mod block_loop;
pub mod covariance;
pub mod dispatch;
pub mod lanes;
pub mod rts;
pub mod step;
