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
pub use fit::{ClockChunk, ClockEstimate, ClockFitSettings, ClockPair, ClockSearch, clock_fit_pairs};
pub use onset::{OnsetAlignment, OnsetSettings, onset_alignment};

/// Why clocks cannot be aligned.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum AlignError {
    /// A setting is outside its range.
    #[error("{setting} is {value}, allowed is {allowed}")]
    Setting { setting: &'static str, value: f64, allowed: &'static str },
    /// A channel is not one value per increasing stamp.
    #[error("channel '{channel}' is not a signal: {reason}")]
    Signal { channel: String, reason: String },
    #[error("channel '{channel}' has no {needed_s} s without a gap in which it changes: choose another pair")]
    Still { channel: String, needed_s: f64 },
    #[error(
        "{found} of {chunks} chunks agree within {agreement_s} s, {needed} are needed (best correlation {best:.2}): give a start nearer to the truth, other channels, or a wider agreement"
    )]
    NoAgreement { found: usize, chunks: usize, needed: usize, agreement_s: f64, best: f64 },
    #[error("{found} samples in {start_s} to {end_s} s are too few to align the onset: {needed} are needed")]
    OnsetSamples { found: usize, needed: usize, start_s: f64, end_s: f64 },
    #[error(
        "the response explains {share:.2} of its variance by the input, {needed} are needed: choose another channel or manoeuvre"
    )]
    NoResponse { share: f64, needed: f64 },
    #[error(
        "the best shift lies at the end of the range searched, {range_s} s either way: align the clocks first, or widen it"
    )]
    ShiftAtEnd { range_s: f64 },
}
