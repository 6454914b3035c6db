//! What was recorded: traces, channels, the track, the replay, a flight while it is flown.

pub(super) mod channels;
pub(super) mod cross_plot;
pub(super) mod flight;
pub(super) mod ground_track;
pub(super) mod live;
pub(super) mod overlay;
pub(super) mod replay;
