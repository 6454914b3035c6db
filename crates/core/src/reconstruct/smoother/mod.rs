//! Smoothers over whole matrices: Rauch-Tung-Striebel of the extended and of the unscented filter, and the iteration of the first.

pub mod dense;
pub mod iterated;
pub mod rts;
pub mod unscented;
