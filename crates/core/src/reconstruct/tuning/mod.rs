//! Settings proposed from the likelihood of the innovations: noise and delays.

pub mod delay;
pub mod noise;
