//! What each channel is: by the recorder, by names, by values and by what they must obey together.

pub(crate) mod alike;
#[cfg(test)]
mod awkward_cases;
#[cfg(test)]
mod axes_cases;
pub(crate) mod by_physics;
pub(crate) mod by_words;
pub(crate) mod candidates;
pub(crate) mod guess;
pub(crate) mod guess_frames;
pub(crate) mod increments;
pub(crate) mod kinds;
#[cfg(test)]
mod layout_cases;
pub(crate) mod layouts;
pub(crate) mod motion;
pub(crate) mod motion_axes;
pub(crate) mod motion_ground;
pub(crate) mod motion_signs;
pub(crate) mod motion_units;
pub(crate) mod other_quantities;
pub(crate) mod other_units;
pub(crate) mod pairs;
pub(crate) mod physics;
pub(crate) mod ranges;
pub(crate) mod recorders;
pub(crate) mod runner_up;
pub(crate) mod slopes;
pub(crate) mod trace;
pub(crate) mod user_names;
pub(crate) mod vectors;
#[cfg(test)]
mod word_cases;
