//! Channel maps: which channel plays which role; the plan and the recording that follow from one.

pub(crate) mod attitude;
pub(crate) mod by_hand;
pub(crate) mod by_name;
pub(crate) mod derive;
pub(crate) mod expected;
pub(crate) mod map;
pub(crate) mod mixing;
pub(crate) mod plan;
pub(crate) mod read;
