//! Filters: extended, iterated extended and unscented, over whole matrices, and what every form of them is given and yields.

pub(crate) mod backend;
pub mod ekf;
pub mod initial;
pub mod parameters;
pub mod step;
pub mod terms;
pub mod ukf;
