//! Two sessions or two runs side by side: settings that differ, derivatives with the significance of their difference.

mod derivatives;
mod settings;

pub use derivatives::{DerivativeDifference, Estimates, Interval, differences, estimates_of, read_estimates};
pub(crate) use settings::entry_name;
pub use settings::{SettingDifference, settings};
