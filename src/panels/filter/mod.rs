//! The flight path: noise, filter, states, innovations.

pub(super) mod filter_settings;
pub(super) mod innovations;
pub(super) mod noise;
pub(super) mod noise_advice;
pub(super) mod reconstruction;
