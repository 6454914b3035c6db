//! Recorder clocks: offset and drift against the reference clock, from UTC, from channels two recorders share, or from
//! the first response of the aircraft to its controls.
//!
//! Aligning maps time stamps; nothing is resampled by it.

mod clock;
mod derivative;
mod fit;
mod line;
mod onset;
mod peak;

use thiserror::Error;

pub use clock::ClockModel;
pub use fit::{ClockChunk, ClockEstimate, ClockFitSettings, ClockPair, ClockSearch, clock_fit, clock_fit_pairs};
pub use onset::{OnsetAlignment, OnsetSettings, onset_alignment};

/// Why clocks cannot be aligned.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum AlignError {
    /// A setting is outside its range.
    #[error("{setting} is {value}, allowed is {allowed}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// Value found.
        value: f64,
        /// Range in words.
        allowed: &'static str,
    },
    /// A channel is not one value per increasing stamp.
    #[error("channel '{channel}' is not a signal: {reason}")]
    Signal {
        /// The channel, by the name of its pair.
        channel: String,
        /// What is wrong with it, with its numbers.
        reason: String,
    },
    /// A channel does not change, so that nothing can be told from it.
    #[error("channel '{channel}' has no {needed_s} s without a gap in which it changes: choose another pair")]
    Still {
        /// The channel, by the name of its pair.
        channel: String,
        /// Length needed, s.
        needed_s: f64,
    },
    /// Too few chunks agree on one clock.
    #[error(
        "{found} of {chunks} chunks agree within {agreement_s} s, {needed} are needed (best correlation {best:.2}): give a start nearer to the truth, other channels, or a wider agreement"
    )]
    NoAgreement {
        /// Chunks that agree.
        found: usize,
        /// Chunks that were looked at.
        chunks: usize,
        /// Chunks needed.
        needed: usize,
        /// Largest distance from the line, s.
        agreement_s: f64,
        /// Best correlation of any chunk.
        best: f64,
    },
    /// The window holds too few samples for the onset.
    #[error("{found} samples in {start_s} to {end_s} s are too few to align the onset: {needed} are needed")]
    OnsetSamples {
        /// Samples found.
        found: usize,
        /// Samples needed.
        needed: usize,
        /// Start of the window, s.
        start_s: f64,
        /// End of the window, s.
        end_s: f64,
    },
    /// The response does not tell the time of the input.
    #[error(
        "the response explains {share:.2} of its variance by the input, {needed} are needed: choose another channel or manoeuvre"
    )]
    NoResponse {
        /// Share of the variance explained at the best shift.
        share: f64,
        /// Share needed.
        needed: f64,
    },
    /// The best shift lies at the end of the range searched.
    #[error(
        "the best shift lies at the end of the range searched, {range_s} s either way: align the clocks first, or widen it"
    )]
    ShiftAtEnd {
        /// Range searched, s.
        range_s: f64,
    },
}
