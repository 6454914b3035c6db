//! What was identified and what may be believed of it.

pub(super) mod applied_fix;
pub(super) mod by_window;
pub(super) mod correlation;
pub(super) mod derivatives;
pub(super) mod dynamics;
pub(super) mod finding_rows;
pub(super) mod intervals;
pub(super) mod over_windows;
pub(super) mod prior;
pub(super) mod responses;
pub(super) mod sensitivity;
pub(super) mod studies;
pub(super) mod summary;
