//! Work a panel has asked for, in the background: how far it is, what it came to, what went wrong.

use doublet_engine::keep::Put;
use doublet_engine::run::Job;
use eframe::egui::{ProgressBar, Ui};

use crate::panels::trouble;

/// Work under way, and what the last one came to.
pub struct Working<T: Send + 'static> {
    job: Option<Job<T>>,
    done: Option<T>,
    error: Option<String>,
}

impl<T: Send + 'static> Default for Working<T> {
    fn default() -> Self {
        Self { job: None, done: None, error: None }
    }
}

impl<T: Send + Outcome + 'static> Working<T> {
    /// Takes work that was begun.
    pub fn take(&mut self, job: std::io::Result<Job<T>>) {
        match job {
            Ok(job) => (self.job, self.error) = (Some(job), None),
            Err(error) => self.error = Some(error.to_string()),
        }
    }

    /// Whether it is under way.
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// What the last one came to.
    pub fn done(&self) -> Option<&T> {
        self.done.as_ref()
    }

    /// Draws how far it is, with a button that stops it, or what went wrong; whether it has just been done.
    pub fn show(&mut self, ui: &mut Ui) -> bool {
        let ended = self.job.take_if(|job| job.is_finished());
        let is_new = match ended.map(Job::finish) {
            Some(Ok(done)) => {
                self.done = Some(done);
                true
            }
            Some(Err(error)) => {
                self.error = Some(error.to_string());
                false
            }
            None => false,
        };
        if let Some(job) = &self.job {
            ui.horizontal(|ui| {
                ui.add(ProgressBar::new(job.progress()).desired_width(160.0).desired_height(8.0).animate(true));
                if ui.small_button("Stop").clicked() {
                    job.cancel();
                }
            });
        }
        trouble(ui, self.error.as_deref());
        if let Some(line) = self.done.as_ref().and_then(T::line) {
            ui.weak(line);
        }
        is_new
    }
}

/// What is said of work that is done.
pub trait Outcome {
    /// A line, where there is something to say.
    fn line(&self) -> Option<String> {
        None
    }
}

impl Outcome for doublet_engine::planning::DesignSheet {}

impl Outcome for doublet_engine::qtg::Judged {}

impl Outcome for Put {
    fn line(&self) -> Option<String> {
        Some(format!("Written to {}", self.folder.display()))
    }
}
