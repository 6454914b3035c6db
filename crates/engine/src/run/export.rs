//! Results written in the background, so that the window goes on drawing meanwhile.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread::JoinHandle;

use super::snapshot::Snapshot;
use crate::export::{self, Format, IdentifiedModel};
use crate::report;
use crate::session::Session;

/// Results on their way into a folder. Dropping it waits until they are there: no half-written folder is left behind.
pub struct Export {
    progress: Arc<AtomicU32>,
    thread: Option<JoinHandle<Result<PathBuf, String>>>,
}

impl Export {
    /// Starts writing all of `snapshot` into `folder` as [`report::write`] does; `wake` is called after every step.
    ///
    /// # Errors
    /// When the operating system refuses a thread.
    pub fn start(
        session: Arc<Session>,
        snapshot: Arc<Snapshot>,
        folder: PathBuf,
        wake: impl Fn() + Send + 'static,
    ) -> std::io::Result<Self> {
        Self::spawn(wake, move |progress| {
            report::write_with_progress(&session, &snapshot, &folder, progress).map_err(|error| error.to_string())
        })
    }

    /// Starts writing the identified model into `folder` in every format, as [`export::write`] does.
    ///
    /// # Errors
    /// When the operating system refuses a thread.
    pub fn start_model(
        session: Arc<Session>,
        snapshot: Arc<Snapshot>,
        folder: PathBuf,
        wake: impl Fn() + Send + 'static,
    ) -> std::io::Result<Self> {
        Self::spawn(wake, move |_| {
            let model = IdentifiedModel::new(&session, &snapshot).map_err(|error| error.to_string())?;
            export::write(&model, &Format::ALL, &folder).map_err(|error| error.to_string())?;
            Ok(folder)
        })
    }

    fn spawn(
        wake: impl Fn() + Send + 'static,
        job: impl FnOnce(&dyn Fn(f32)) -> Result<PathBuf, String> + Send + 'static,
    ) -> std::io::Result<Self> {
        let progress = Arc::new(AtomicU32::new(0.0_f32.to_bits()));
        let shown = Arc::clone(&progress);
        let write = move || {
            let result = job(&|part| {
                shown.store(part.to_bits(), Ordering::Relaxed);
                wake();
            });
            wake();
            result
        };
        let thread = std::thread::Builder::new().name("doublet-export".to_owned()).spawn(write)?;
        Ok(Self { progress, thread: Some(thread) })
    }

    /// Part that is written, 0 to 1.
    pub fn progress(&self) -> f32 {
        f32::from_bits(self.progress.load(Ordering::Relaxed))
    }

    /// Whether nothing is left to write, or writing has failed.
    pub fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits for the end: the folder, or one line why there is none.
    ///
    /// # Errors
    /// What stood in the way, one line.
    pub fn finish(mut self) -> Result<PathBuf, String> {
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) | None => Err("writing the results ended unexpectedly: export them again".to_owned()),
        }
    }
}

impl Drop for Export {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            // Nobody is left to tell how it ended.
            let _ = thread.join();
        }
    }
}
