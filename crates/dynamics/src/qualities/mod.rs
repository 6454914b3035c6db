//! Levels of flying qualities: measures of the motion judged by limits that are data.

mod judge;
mod limits;
mod measures;

pub use judge::{Judgement, LevelShares, Quality, QualityLevel, Reason, judge, judge_samples};
pub use limits::{Airplane, Limit, Limits, LimitsError};
pub use measures::{EquivalentSystem, Measure, Measures, load_factor_per_alpha, measures, phi_over_beta};
