//! Terms of the coefficients, their fits, and configurations side by side.

pub(super) mod coefficient_settings;
pub(super) mod constraints;
pub(super) mod experiment_intervals;
pub(super) mod experiment_tables;
pub(super) mod experiments;
pub(super) mod fits;
pub(super) mod match_panel;
pub(super) mod misfit;
pub(super) mod residuals;
pub(super) mod setting_words;
pub(super) mod term_effects;
pub(super) mod terms;
