//! Progress bar on the terminal; silent when the output is not one.

use indicatif::{ProgressBar, ProgressStyle};

use crate::text::{error_line, harmless};

/// A bar from 0 to 1 with what is being done.
pub struct Progress(ProgressBar);

impl Progress {
    /// A new bar.
    pub fn new() -> Self {
        let bar = ProgressBar::new(1000);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {percent:>3} %  {msg}") {
            bar.set_style(style);
        }
        Self(bar)
    }

    /// Shows the part done and the present work.
    pub fn update(&self, part: f32, work: &str) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0..=1000")]
        self.0.set_position((part.clamp(0.0, 1.0) * 1000.0) as u64);
        self.0.set_message(harmless(work).into_owned());
    }

    /// Writes a line to standard error above the bar.
    pub fn error_line(&self, text: &str) {
        self.0.suspend(|| error_line(text));
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}
