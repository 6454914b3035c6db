//! What can be wrong with a frequency response or a low-order fit.

use thiserror::Error;

/// Why there is no frequency response or equivalent system.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FrequencyError {
    /// Nothing to transform.
    #[error("no record with samples")]
    NoRecord,
    /// Signals of one record, or records, that do not go together.
    #[error("record {record}: {what}")]
    Record {
        /// Its number, from 1.
        record: usize,
        /// What is wrong.
        what: String,
    },
    /// A setting outside what it may be.
    #[error("{setting} {value}: {allowed}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        allowed: String,
    },
    /// Every record is shorter than every window.
    #[error(
        "the longest record lasts {longest_s:.3} s, the shortest window {window_s:.3} s: give a shorter window length"
    )]
    WindowTooLong {
        /// Longest record, s.
        longest_s: f64,
        /// Shortest window, s.
        window_s: f64,
    },
    /// No frequency of the band can be resolved.
    #[error(
        "no frequency from {low:.4} to {high:.4} rad/s has two cycles in a window ({lowest:.4} rad/s and more have): give longer windows or a higher band"
    )]
    BandBelowWindows {
        /// Lowest frequency asked for, rad/s.
        low: f64,
        /// Highest frequency asked for, rad/s.
        high: f64,
        /// Lowest frequency that is resolved, rad/s.
        lowest: f64,
    },
    /// A form that is none.
    #[error(
        "'{text}' is not a form: use short-period, roll, yaw, or numerator/denominator order such as 1/2, the first not above the second (6 at most)"
    )]
    Form {
        /// As written.
        text: String,
    },
    /// Fewer frequencies with a value than the model has parameters.
    #[error(
        "{points} frequencies with enough coherence, {parameters} parameters: widen the band or take a simpler form"
    )]
    TooFewPoints {
        /// Frequencies with a value.
        points: usize,
        /// Parameters of the form.
        parameters: usize,
    },
    /// Parameters the data do not tell apart.
    #[error(
        "the data do not determine the form '{form}': its parameters are dependent in this band; take a simpler form or a wider band"
    )]
    Undetermined {
        /// Name of the form.
        form: String,
    },
}
