//! What can be wrong with a frequency response or a low-order fit.

use thiserror::Error;

/// Why there is no frequency response or equivalent system.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum FrequencyError {
    /// Nothing to transform.
    #[error("no record with samples")]
    NoRecord,
    /// Signals of one record, or records, that do not go together.
    #[error("record {record}: {what}")]
    Record { record: usize, what: String },
    /// A setting outside what it may be.
    #[error("{setting} {value}: {allowed}")]
    Setting { setting: &'static str, value: f64, allowed: String },
    #[error(
        "the longest record lasts {longest_s:.3} s, the shortest window {window_s:.3} s: give a shorter window length"
    )]
    WindowTooLong { longest_s: f64, window_s: f64 },
    #[error(
        "no frequency from {low:.4} to {high:.4} rad/s has two cycles in a window ({lowest:.4} rad/s and more have): give longer windows or a higher band"
    )]
    BandBelowWindows { low: f64, high: f64, lowest: f64 },
    #[error(
        "'{text}' is not a form: use short-period, roll, yaw, or numerator/denominator order such as 1/2, the first not above the second (6 at most)"
    )]
    Form { text: String },
    #[error(
        "{points} frequencies with enough coherence, {parameters} parameters: widen the band or take a simpler form"
    )]
    TooFewPoints { points: usize, parameters: usize },
    #[error(
        "the data do not determine the form '{form}': its parameters are dependent in this band; take a simpler form or a wider band"
    )]
    Undetermined { form: String },
}
