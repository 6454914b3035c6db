//! The only way of a stage to files, to progress, to cancellation and to other stages.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use super::{Cache, Control, Footprint, Key, KeyBuilder, Keyed, Stage, StageResult, guarded};
use crate::builtin;

/// State of a file or a folder when it was read: size and time of change of it and of what it holds. Reading recordings again to
/// compare their content would cost more than it saves.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct FileStamp(Vec<(PathBuf, Option<State>)>);

/// Size in bytes and time of change of a file.
type State = (u64, Option<SystemTime>);

impl FileStamp {
    /// The state a place has now.
    pub fn read(place: &Path) -> Self {
        let state = |file: &Path| Some(file.metadata().ok()?).map(|about| (about.len(), about.modified().ok()));
        Self(files(place).into_iter().map(|file| (file.clone(), state(&file))).collect())
    }
}

/// The files of a folder in order of their names, or the file itself.
fn files(place: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(place) else { return vec![place.to_path_buf()] };
    let mut files: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.sort();
    files
}

/// What a stage runs in. What it reads here becomes part of its key, and of that of the stage that asked for it.
pub struct Context<'a> {
    folder: &'a Path,
    cache: Option<&'a Cache>,
    control: Control,
    progress: &'a (dyn Fn(f32) + Sync),
    done: AtomicUsize,
    total: usize,
    files: Mutex<BTreeMap<PathBuf, FileStamp>>,
}

impl<'a> Context<'a> {
    /// A context whose relative paths start from `folder`; nothing is kept, nobody stops it or hears of its progress.
    pub fn new(folder: &'a Path) -> Self {
        let (control, files) = (Control::default(), Mutex::default());
        Self { folder, cache: None, control, progress: &|_| (), done: AtomicUsize::new(0), total: 1, files }
    }

    /// The same that keeps outputs in `cache`.
    #[must_use]
    pub fn with_cache(self, cache: &'a Cache) -> Self {
        Self { cache: Some(cache), ..self }
    }

    /// The same stopped by `control`, that tells `progress` the part done, 0 to 1.
    #[must_use]
    pub fn with_control(self, control: &Control, progress: &'a (dyn Fn(f32) + Sync)) -> Self {
        Self { control: control.clone(), progress, ..self }
    }

    /// The same for work of `total` parts, each counted by [`Context::step`].
    #[must_use]
    pub fn parts(&self, total: usize) -> Context<'a> {
        let Self { folder, cache, progress, .. } = *self;
        let (control, done) = (self.control.clone(), AtomicUsize::new(0));
        Context { folder, cache, control, progress, done, total, files: Mutex::default() }
    }

    /// Counts one part as done.
    pub fn step(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        (self.progress)(done as f32 / self.total.max(1) as f32);
    }

    /// Tells the part done, 0 to 1.
    pub(crate) fn advance(&self, part: f32) {
        (self.progress)(part);
    }

    /// Folder relative paths start from.
    pub(crate) fn folder(&self) -> &'a Path {
        self.folder
    }

    /// Where outputs are kept.
    pub(crate) fn cache(&self) -> Option<&'a Cache> {
        self.cache
    }

    /// Handle that stops it.
    pub fn control(&self) -> &Control {
        &self.control
    }

    /// Goes on, or ends the stage.
    pub fn checkpoint(&self) -> StageResult<()> {
        Ok(self.control.checkpoint()?)
    }

    /// The output of a stage: from the cache while parameters, inputs and files are what they were, or else computed.
    ///
    /// # Errors
    /// Those of the stage; they are not kept.
    pub fn get<S: Stage>(&self, params: S::Params<'_>, inputs: S::Inputs<'_>) -> StageResult<Keyed<S::Output>> {
        self.get_watched::<S>(params, inputs, self.progress)
    }

    /// The same, its progress told to `progress`.
    pub(crate) fn get_watched<S: Stage>(
        &self,
        params: S::Params<'_>,
        inputs: S::Inputs<'_>,
        progress: &(dyn Fn(f32) + Sync),
    ) -> StageResult<Keyed<S::Output>> {
        let own = match self.find::<S>(&params, &inputs) {
            Ok(known) => return Ok(known),
            Err(own) => own,
        };
        let context = Context { progress, ..self.parts(1) };
        let output = guarded(S::NAME, || S::run(params, inputs, &context));
        let read = context.files();
        self.declare(&read);
        Ok(self.insert::<S>(own, read, output?))
    }

    /// The output of a stage where it is in the cache, or the key of its parameters and inputs.
    pub(crate) fn find<S: Stage>(
        &self,
        params: &S::Params<'_>,
        inputs: &S::Inputs<'_>,
    ) -> Result<Keyed<S::Output>, Key> {
        let own = KeyBuilder::new(S::NAME).with(std::any::type_name::<S>()).with(params).with(inputs).finish();
        let Some(cache) = self.cache else { return Err(own) };
        let places = cache.places(self.trace(own));
        let read = places.into_iter().map(|place| (place.clone(), FileStamp::read(&place))).collect();
        let key = key_with_files(own, &read);
        let value = cache.get(key).ok_or(own)?;
        self.declare(&read);
        Ok(keyed(value, key))
    }

    /// Keeps the output of a stage that read no files under the key that [`Context::find`] gave.
    pub(crate) fn store<S: Stage>(&self, own: Key, output: S::Output) -> Keyed<S::Output> {
        self.insert::<S>(own, BTreeMap::new(), output)
    }

    fn insert<S: Stage>(&self, own: Key, read: BTreeMap<PathBuf, FileStamp>, output: S::Output) -> Keyed<S::Output> {
        let key = key_with_files(own, &read);
        let Some(cache) = self.cache else { return keyed(output.into(), key) };
        if !read.is_empty() {
            cache.set_places(self.trace(own), read.into_keys().collect());
        }
        keyed(cache.insert(key, output), key)
    }

    /// Key of the list of files a stage reads: relative paths lead elsewhere from another folder.
    fn trace(&self, own: Key) -> Key {
        KeyBuilder::new("files").with(&own).with(self.folder).finish()
    }

    /// Files and folders read so far, as they were then.
    pub fn files(&self) -> BTreeMap<PathBuf, FileStamp> {
        self.read().clone()
    }

    fn read(&self) -> MutexGuard<'_, BTreeMap<PathBuf, FileStamp>> {
        self.files.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// States what was read in another context.
    pub(crate) fn declare(&self, read: &BTreeMap<PathBuf, FileStamp>) {
        self.read().extend(read.iter().map(|(place, stamp)| (place.clone(), stamp.clone())));
    }

    /// Place on disk of a path written in a session, from here on read by this stage: relative to its folder, or what comes with the
    /// program.
    pub(crate) fn locate(&self, path: &str) -> StageResult<PathBuf> {
        if let Some(name) = path.strip_prefix(builtin::PREFIX) {
            return Ok(builtin::on_disk(name)?);
        }
        let place = self.folder.join(path);
        self.read().entry(place.clone()).or_insert_with(|| FileStamp::read(&place));
        match place.metadata() {
            Ok(about) if about.is_file() || about.is_dir() => Ok(place),
            Ok(_) => Err(format!("{} is neither a file nor a folder", place.display()).into()),
            Err(_) => Err(format!("{}: file or folder not found", place.display()).into()),
        }
    }

    /// Text of a file that people write, at a place on disk.
    pub fn read_text(&self, place: &Path) -> io::Result<String> {
        self.read().entry(place.to_path_buf()).or_insert_with(|| FileStamp::read(place));
        doublet_core::load::read_text(place)
    }

    /// Text of a file written in a session, or of what comes with the program in `kind`.
    pub fn text(&self, path: &str, kind: &str) -> StageResult<String> {
        if let Some(name) = path.strip_prefix(builtin::PREFIX) {
            let text = builtin::text(kind, name).map(str::to_owned);
            let known = || builtin::names(kind).join(", ");
            return text.ok_or_else(|| format!("built-in '{name}' not found in {kind}: use one of {}", known()).into());
        }
        let place = self.locate(path)?;
        self.read_text(&place).map_err(|error| format!("{}: {error}", place.display()).into())
    }
}

fn keyed<T: Footprint>(value: Arc<T>, key: Key) -> Keyed<T> {
    let key = value.content().unwrap_or(key);
    Keyed::new(value, key)
}

/// The key of a stage that read these files: without any its own.
fn key_with_files(own: Key, read: &BTreeMap<PathBuf, FileStamp>) -> Key {
    if read.is_empty() { own } else { KeyBuilder::new("read").with(&own).with(read).finish() }
}
