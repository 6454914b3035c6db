//! Settings proposed from the likelihood of the innovations: noise, delays and gusts.

pub mod delay;
pub mod flow_delay;
pub mod gusts;
pub mod noise;
