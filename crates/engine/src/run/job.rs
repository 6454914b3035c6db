//! Files written and looked at in the background, so that the window goes on drawing meanwhile.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread::JoinHandle;

use crate::graph::{Control, StageError, StageResult, guarded};

/// Results or a report on their way to disk, or a recording being looked at. Dropping it waits for the end: nothing half-written is left
/// behind.
pub struct Job<T> {
    progress: Arc<AtomicU32>,
    control: Control,
    thread: Option<JoinHandle<StageResult<T>>>,
}

impl<T: Send + 'static> Job<T> {
    /// Starts `work` in a thread called `name`. It is given a control to look at between its steps and a function to tell the part
    /// done, 0 to 1, and returns what it came to, such as the place of what it wrote, or one line why there is nothing; `wake` is called after every step.
    pub fn start<E: Into<StageError>>(
        name: &str,
        wake: impl Fn() + Send + Sync + 'static,
        work: impl FnOnce(&Control, &(dyn Fn(f32) + Sync)) -> Result<T, E> + Send + 'static,
    ) -> std::io::Result<Self> {
        let progress = Arc::new(AtomicU32::new(0.0_f32.to_bits()));
        let control = Control::default();
        let (shown, watched) = (Arc::clone(&progress), control.clone());
        let place = name.to_owned();
        let run = move || {
            let show = |part: f32| {
                shown.store(part.to_bits(), Ordering::Relaxed);
                wake();
            };
            let result = guarded(&place, || work(&watched, &show).map_err(Into::into));
            wake();
            result
        };
        let thread = std::thread::Builder::new().name(name.to_owned()).spawn(run)?;
        Ok(Self { progress, control, thread: Some(thread) })
    }

    /// Part that is done, 0 to 1.
    pub fn progress(&self) -> f32 {
        f32::from_bits(self.progress.load(Ordering::Relaxed))
    }

    /// Asks it to stop at its next step.
    pub fn cancel(&self) {
        self.control.cancel();
    }

    /// Asks it to stop and does not wait for the end: for work that leaves nothing behind.
    pub fn abandon(mut self) {
        self.cancel();
        self.thread = None;
    }

    /// Whether nothing is left to do, or it has failed.
    pub fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits for the end: what it came to, or one line why there is nothing.
    pub fn finish(mut self) -> StageResult<T> {
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) | None => Err("the computation ended unexpectedly: try again".into()),
        }
    }
}

impl<T> Drop for Job<T> {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            // Nobody is left to tell how it ended.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_in_the_work_is_said_in_one_line() {
        let empty: Vec<f64> = Vec::new();
        let job = Job::start("report", || (), move |_, _| Ok::<_, StageError>(empty[empty.len()])).unwrap();
        let error = job.finish().unwrap_err().to_string();
        assert!(error.starts_with("report: internal error of doublet at engine/src/run/job.rs"), "{error}");
        assert!(error.contains("index out of bounds") && !error.contains('\n'), "{error}");
    }
}
