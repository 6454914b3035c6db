//! Sessions, runs and experiments side by side: settings that differ, derivatives with the significance of their difference.

mod derivatives;
mod experiments;
mod settings;

pub use crate::snapshot::{
    CoefficientOutcome, DerivativeOutcome, ExperimentOutcome, ExperimentRow, FitOutcome, Interval, MeasurementNis,
    PRESENT, SettingDifference,
};
pub use derivatives::{DerivativeDifference, Estimates, differences, estimates_of, read_estimates};
pub use experiments::experiment_differences;
pub(crate) use settings::entry_name;
pub use settings::settings;
