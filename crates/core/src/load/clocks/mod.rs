//! Time vectors: which channel is the time of which others, in which unit, from which epoch.

pub(crate) mod counter;
pub(crate) mod find_clocks;
pub(crate) mod labels;
pub(crate) mod stamp;
pub(crate) mod time_names;
pub(crate) mod time_unit;
pub(crate) mod utc;
