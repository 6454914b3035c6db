//! Levels of flying qualities: measures of the motion judged by limits that are data.

mod bank;
mod judge;
mod limits;
mod measures;
mod neal_smith;
mod pitch;

pub use bank::times_to_bank;
pub use judge::{Judgement, LevelShares, Quality, QualityLevel, Reason, judge, judge_samples, measure_interval};
pub use limits::{Airplane, Along, Limit, Limits, LimitsError, NotJudged, PilotTasks};
pub use measures::{Controls, EquivalentSystem, Measure, Measures, load_factor_per_alpha, measures, phi_over_beta};
pub use neal_smith::{NealSmith, PilotTask, neal_smith};
pub use pitch::{StepResponse, criterion_phase_rad, pitch_rate_by_elevator, step_response};
