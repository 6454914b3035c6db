//! Smoothing, sensors and channels by expression.

pub(super) mod bias_table;
pub(super) mod expressions;
pub(super) mod preprocess;
pub(super) mod sensors;
