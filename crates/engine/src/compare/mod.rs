//! Sessions, runs and experiments side by side: settings that differ, derivatives with the significance of their difference.

mod derivatives;
mod experiments;
mod settings;

pub use derivatives::{DerivativeDifference, Estimates, Interval, differences, estimates_of, read_estimates};
pub use experiments::{
    CoefficientOutcome, DerivativeOutcome, ExperimentOutcome, ExperimentRow, FitOutcome, MeasurementNis, PRESENT,
    experiment_differences,
};
pub(crate) use settings::entry_name;
pub use settings::{SettingDifference, settings};
