//! Sets of files in a folder that is the user's too: what doublet wrote there is replaced in one step, everything else stays.
//!
//! The files of a set are first written into a staging folder beside the target. What is put in place is the staging folder itself:
//! it takes the user's files in by hard links and is exchanged with the target in one step of the file system. Where that cannot be
//! (a mount point, the present folder of the shell, another owner, a file system without links) the earlier files of the set are
//! removed and the new ones moved in: after a kill the set is then short of files, never one of two runs together.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use thiserror::Error;

use super::durable::{folder_of, sync_folder, sync_folders};
use super::lock::{Lock, LockResult, describe_owner};
use super::manifest::{self, MANIFEST, Manifest};
use super::sweep::{STAGING, sweep};

/// Longest wait for another program that is putting its files into the same folder.
const PATIENCE: Duration = Duration::from_secs(10);
const PAUSE: Duration = Duration::from_millis(20);
/// Most of the user's files that are taken along by links; a folder with more is changed file by file.
const MOST_LINKS: usize = 2000;

/// What was put into a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Put {
    /// The folder, as it was named.
    pub folder: PathBuf,
    /// The files written, in the order of their names.
    pub files: Vec<PathBuf>,
    /// Files that were changed after doublet wrote them and where they are kept now.
    pub kept: Vec<(PathBuf, PathBuf)>,
}

impl Put {
    /// One line for every file that was kept aside.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        self.kept
            .iter()
            .map(|(was, is)| format!("{} was changed after doublet wrote it: kept as {}", was.display(), is.display()))
    }
}

/// Why a set of files was not put into its folder.
#[derive(Debug, Error)]
pub enum PutError {
    #[error("{0} exists and was not written by doublet: choose another folder for --out")]
    Foreign(String),
    #[error("{folder}: {owner} is writing there: try again when it is done, or choose another folder for --out")]
    Busy { folder: String, owner: String },
    /// A file could not be read, written or moved.
    #[error("{path}: {source}")]
    File { path: String, source: io::Error },
}

/// What becomes of files of an earlier set that the new one does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Earlier {
    /// They go: the set is one whole.
    Removed,
    /// They stay: each file stands for itself.
    Kept,
}

/// A folder of this program alone, known by its lock: one whose program died is removed by the next that looks.
#[derive(Debug)]
pub struct PrivateFolder {
    place: PathBuf,
    _lock: Lock,
}

impl PrivateFolder {
    /// A new folder in `home`.
    pub fn new(home: &Path) -> io::Result<Self> {
        sweep(home);
        // The lock comes before the folder, so that nobody takes the folder for that of a dead program.
        let made = tempfile::Builder::new().prefix(STAGING).make_in(home, Self::make_locked)?;
        let (lock, place) = made.keep().map_err(|error| error.error)?;
        Ok(Self { place, _lock: lock })
    }

    fn make_locked(place: &Path) -> io::Result<Lock> {
        let LockResult::Acquired(lock) = Lock::try_lock(place)? else {
            return Err(io::ErrorKind::AlreadyExists.into());
        };
        std::fs::create_dir(place).map(|()| lock)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.place
    }

    /// Removes it with all it holds and the file of its lock.
    pub fn remove(&self) {
        // What stays behind is found by the next who makes such a folder here.
        let _ = std::fs::remove_dir_all(&self.place);
        let _ = std::fs::remove_file(super::lock::lock_path(&self.place));
    }
}

/// A folder in which a set of files is written; it goes when this is dropped without being put in place.
#[derive(Debug)]
pub struct Staging {
    named: PathBuf,
    target: PathBuf,
    place: PrivateFolder,
    /// Whether the folder at `place` is no longer the one that was staged.
    exchanged: bool,
}

impl Drop for Staging {
    fn drop(&mut self) {
        if !self.exchanged {
            // What stays behind is found by the next who writes here.
            let _ = std::fs::remove_dir_all(self.path());
        }
    }
}

impl Staging {
    /// A staging folder for `folder`, which need not exist; links are followed. Leftovers of writers that died are removed.
    ///
    /// # Errors
    /// When neither the folder nor the one above it can be written.
    pub fn new(folder: &Path) -> Result<Self, PutError> {
        let failed = file_error(folder);
        let target = resolve(folder).map_err(&failed)?;
        let parent = folder_of(&target).to_path_buf();
        std::fs::create_dir_all(&parent).map_err(&failed)?;
        if !target.is_dir() {
            return Self::inside(&parent, folder, &target).map_err(&failed);
        }
        sweep(&target);
        if !same_device(&parent, &target) {
            return Self::inside(&target, folder, &target).map_err(&failed);
        }
        Self::inside(&parent, folder, &target).or_else(|_| Self::inside(&target, folder, &target)).map_err(failed)
    }

    fn inside(home: &Path, named: &Path, target: &Path) -> io::Result<Self> {
        let place = PrivateFolder::new(home)?;
        Ok(Self { named: named.to_path_buf(), target: target.to_path_buf(), place, exchanged: false })
    }

    /// Where the files of the set are written.
    pub fn path(&self) -> &Path {
        self.place.path()
    }

    /// The place of a file of the set once it is put: that which is named to the user.
    pub fn target_of(&self, path: &str) -> String {
        let inner = Path::new(path).strip_prefix(self.path());
        inner.map_or_else(|_| path.to_owned(), |inner| self.named.join(inner).display().to_string())
    }

    /// Puts the files in place as the set called `set`. Earlier files of doublet are replaced, also those that `adopt` says are
    /// doublet's though no manifest names them; one the user changed since is kept beside as `*.bak`. Nothing else is touched.
    ///
    /// # Errors
    /// [`PutError`]; the folder is then as it was.
    pub fn put(mut self, set: &str, earlier: Earlier, adopt: &dyn Fn(&Path) -> bool) -> Result<Put, PutError> {
        let failed = file_error(&self.named);
        let mut files = manifest::hash_and_sync(self.path(), set).map_err(&failed)?;
        let _turn = self.turn()?;
        let present = Manifest::read(&self.target);
        let plan = Plan::new(&self.target, &self.named, &present, &files, set, earlier, adopt)?;
        let written = files.files.keys().map(|name| self.named.join(name)).collect();
        for (name, entry) in &present.files {
            if !plan.goes.contains(name) && !plan.changed.iter().any(|(was, _)| was == name) {
                files.files.entry(name.clone()).or_insert_with(|| entry.clone());
            }
        }
        files.write(self.path()).map_err(&failed)?;
        self.move_to_target(&plan, &files).map_err(&failed)?;
        let kept = plan.changed.iter().filter(|(_, to)| !to.is_empty());
        let kept = kept.map(|(was, to)| (self.named.join(was), self.named.join(to))).collect();
        Ok(Put { folder: self.named.clone(), files: written, kept })
    }

    /// Puts the files in place as a folder that does not exist yet.
    ///
    /// # Errors
    /// [`PutError`]; nothing is left behind then.
    pub fn put_new(self) -> Result<(), PutError> {
        let failed = file_error(&self.named);
        manifest::hash_and_sync(self.path(), "").map_err(&failed)?;
        let _turn = self.turn()?;
        if self.target.exists() {
            return Err(PutError::Foreign(self.named.display().to_string()));
        }
        sync_folders(self.path())
            .and_then(|()| std::fs::rename(self.path(), &self.target))
            .and_then(|()| sync_folder(folder_of(&self.target)))
            .map_err(failed)
    }

    /// Waits until nobody else puts files into the folder. Where no lock can be written there is none.
    fn turn(&self) -> Result<Option<Lock>, PutError> {
        let begun = Instant::now();
        loop {
            match Lock::try_lock(&self.target) {
                Ok(LockResult::Acquired(lock)) => return Ok(Some(lock)),
                Err(_) => return Ok(None),
                Ok(LockResult::Held(owner)) if begun.elapsed() > PATIENCE => {
                    return Err(PutError::Busy {
                        folder: self.named.display().to_string(),
                        owner: describe_owner(owner.as_ref()),
                    });
                }
                Ok(LockResult::Held(_)) => std::thread::sleep(PAUSE),
            }
        }
    }

    fn move_to_target(&mut self, plan: &Plan, files: &Manifest) -> io::Result<()> {
        if !self.target.exists() {
            sync_folders(self.path())?;
            std::fs::rename(self.path(), &self.target)?;
        } else if self.path().parent() == Some(folder_of(&self.target))
            && self.take_along(plan).is_ok()
            && self.exchange_synced()?
        {
            self.exchanged = true;
            let mut gone: BTreeSet<&str> = plan.goes.iter().map(String::as_str).collect();
            gone.insert(MANIFEST);
            // What came in since the links were made is moved over; what cannot be stays where it is.
            let _ = retire(self.path(), &self.target, Path::new(""), &gone);
        } else {
            self.place_one_by_one(plan, files)?;
        }
        // The files are in place whether or not the folders could be synced.
        let _ = sync_folder(&self.target).and_then(|()| sync_folder(folder_of(&self.target)));
        Ok(())
    }

    /// Takes the user's files into the staging folder by hard links, which are the same files under another name.
    fn take_along(&self, plan: &Plan) -> io::Result<()> {
        let refused = || io::Error::from(io::ErrorKind::Unsupported);
        let about = self.target.metadata()?;
        let is_here = std::env::current_dir().is_ok_and(|here| here.starts_with(&self.target));
        if is_here || !same_owner(&self.target, self.path()) {
            return Err(refused());
        }
        let mut links = Links { plan, from: &self.target, to: self.path(), left: MOST_LINKS };
        links.folder(Path::new(""))?;
        std::fs::set_permissions(self.path(), about.permissions())
    }

    /// Exchanges staging folder and target: before it the new set is on the disk, behind it the exchange is, so that a loss of power while
    /// the earlier files go finds one of the sets whole.
    fn exchange_synced(&self) -> io::Result<bool> {
        sync_folders(self.path())?;
        let is_done = self.exchange();
        if is_done {
            // The files are in place whether or not the folder could be synced.
            let _ = sync_folder(folder_of(&self.target));
        }
        Ok(is_done)
    }

    #[cfg(any(target_os = "linux", target_os = "macos"))]
    fn exchange(&self) -> bool {
        use rustix::fs::{CWD, RenameFlags, renameat_with};
        renameat_with(CWD, self.path(), CWD, &self.target, RenameFlags::EXCHANGE).is_ok()
    }

    #[cfg(not(any(target_os = "linux", target_os = "macos")))]
    fn exchange(&self) -> bool {
        false
    }

    /// First the earlier files go, then the new ones come.
    fn place_one_by_one(&self, plan: &Plan, files: &Manifest) -> io::Result<()> {
        std::fs::rename(self.path().join(MANIFEST), self.target.join(MANIFEST))?;
        for (was, to) in plan.changed.iter().filter(|(_, to)| !to.is_empty()) {
            std::fs::rename(self.target.join(was), self.target.join(to))?;
        }
        for name in &plan.goes {
            let old = self.target.join(name);
            std::fs::remove_file(&old)?;
            // A folder that is left empty goes too; one that is not stays.
            let _ = old.parent().filter(|folder| *folder != self.target).map(std::fs::remove_dir);
        }
        for name in files.files.keys() {
            let new = self.path().join(name);
            if new.exists() {
                let place = self.target.join(name);
                std::fs::create_dir_all(folder_of(&place))?;
                std::fs::rename(new, place)?;
            }
        }
        Ok(())
    }
}

/// What becomes of the files that are there: names relative to the folder, with `/` between folders.
#[derive(Debug, Default)]
struct Plan {
    /// Files of doublet that go or are replaced.
    goes: BTreeSet<String>,
    /// Files of doublet that the user changed since, and the names they get; an empty name where they stay as they are.
    changed: Vec<(String, String)>,
}

impl Plan {
    fn new(
        target: &Path,
        shown: &Path,
        present: &Manifest,
        new: &Manifest,
        set: &str,
        earlier: Earlier,
        adopt: &dyn Fn(&Path) -> bool,
    ) -> Result<Self, PutError> {
        let mut plan = Self::default();
        let foreign = |name: &str| PutError::Foreign(shown.join(name).display().to_string());
        for name in new.files.keys() {
            let path = target.join(name);
            let blocked =
                path.ancestors().skip(1).take_while(|folder| *folder != target).any(|folder| folder.is_file());
            if blocked || path.is_dir() {
                return Err(foreign(name));
            }
            if path.symlink_metadata().is_err() {
                continue;
            }
            match present.files.get(name) {
                Some(entry) if entry.is_of(&path) => _ = plan.goes.insert(name.clone()),
                Some(_) => plan.changed.push((name.clone(), free_name(target, name))),
                None if adopt(&path) => _ = plan.goes.insert(name.clone()),
                None => return Err(foreign(name)),
            }
        }
        if earlier == Earlier::Removed {
            let stale = present.files.iter().filter(|(name, entry)| entry.set == set && !new.files.contains_key(*name));
            for (name, entry) in stale {
                let path = target.join(name);
                if entry.is_of(&path) {
                    plan.goes.insert(name.clone());
                } else {
                    plan.changed.push((name.clone(), String::new()));
                }
            }
        }
        let unlisted = present.files.is_empty() && target.join(MANIFEST).exists() && !Manifest::is_in(target);
        if unlisted { Err(foreign(MANIFEST)) } else { Ok(plan) }
    }

    /// Where a file of the folder is found afterwards; `None` where it is not taken along.
    fn destination<'p>(&'p self, name: &'p str) -> Option<&'p str> {
        match self.changed.iter().find(|(was, _)| was == name) {
            Some((_, to)) if to.is_empty() => Some(name),
            Some((_, to)) => Some(to),
            None => (!self.goes.contains(name) && name != MANIFEST).then_some(name),
        }
    }
}

/// The user's files on their way into the staging folder.
struct Links<'p> {
    plan: &'p Plan,
    from: &'p Path,
    to: &'p Path,
    left: usize,
}

impl Links<'_> {
    fn folder(&mut self, inner: &Path) -> io::Result<()> {
        for entry in std::fs::read_dir(self.from.join(inner))? {
            let entry = entry?;
            self.left = self.left.checked_sub(1).ok_or(io::ErrorKind::Unsupported)?;
            let inner = inner.join(entry.file_name());
            if entry.file_type()?.is_dir() {
                self.subfolder(&inner, &entry.path())?;
            } else {
                let name = manifest::name_of(&inner)?;
                match self.plan.destination(&name) {
                    Some(same) if same == name => std::fs::hard_link(entry.path(), self.to.join(&inner))?,
                    Some(other) => std::fs::hard_link(entry.path(), self.to.join(other))?,
                    None => {}
                }
            }
        }
        Ok(())
    }

    fn subfolder(&mut self, inner: &Path, old: &Path) -> io::Result<()> {
        let new = self.to.join(inner);
        let is_ours = new.is_dir();
        if !is_ours {
            if self.plan.goes.iter().any(|name| Path::new(name).parent() == Some(inner))
                && only_goes(self.plan, old, inner)?
            {
                return Ok(());
            }
            std::fs::create_dir(&new)?;
        }
        if !same_owner(old, &new) {
            return Err(io::ErrorKind::Unsupported.into());
        }
        self.folder(inner)?;
        let about = old.metadata()?;
        std::fs::set_permissions(&new, about.permissions())?;
        if is_ours { Ok(()) } else { std::fs::File::open(&new)?.set_modified(about.modified()?) }
    }
}

/// Whether a folder holds nothing but files that go.
fn only_goes(plan: &Plan, folder: &Path, inner: &Path) -> io::Result<bool> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() || !plan.goes.contains(&manifest::name_of(&inner.join(entry.file_name()))?) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Removes the folder that was replaced: files that went, and second names of the user's files. A file that came in meanwhile is
/// moved to the new folder.
fn retire(old: &Path, new: &Path, inner: &Path, gone: &BTreeSet<&str>) -> io::Result<()> {
    for entry in std::fs::read_dir(old.join(inner))? {
        let entry = entry?;
        let inner = inner.join(entry.file_name());
        let place = new.join(&inner);
        if entry.file_type()?.is_dir() {
            if place.is_dir() || gone.iter().any(|name| Path::new(name).starts_with(&inner)) {
                retire(old, new, &inner, gone)?;
            } else {
                std::fs::rename(entry.path(), place)?;
            }
        } else if gone.contains(manifest::name_of(&inner)?.as_str()) || links(&entry.path()) > 1 {
            std::fs::remove_file(entry.path())?;
        } else if place.symlink_metadata().is_err() {
            std::fs::create_dir_all(folder_of(&place))?;
            std::fs::rename(entry.path(), place)?;
        }
    }
    std::fs::remove_dir(old.join(inner))
}

/// The first of `NAME.bak`, `NAME.bak2` and so on that is free.
fn free_name(folder: &Path, name: &str) -> String {
    let names = std::iter::once(format!("{name}.bak")).chain((2..).map(|number: u64| format!("{name}.bak{number}")));
    let mut free = names.filter(|name| folder.join(name).symlink_metadata().is_err());
    free.next().unwrap_or_else(|| format!("{name}.bak"))
}

/// The folder itself where the path is a link to it, also to one that does not exist yet.
fn resolve(folder: &Path) -> io::Result<PathBuf> {
    if let Ok(place) = folder.canonicalize() {
        return Ok(place);
    }
    let place = match folder.read_link() {
        Ok(link) => folder_of(folder).join(link),
        Err(_) => folder.to_path_buf(),
    };
    std::path::absolute(place)
}

fn file_error(path: &Path) -> impl Fn(io::Error) -> PutError + use<> {
    let path = path.display().to_string();
    move |source| PutError::File { path: path.clone(), source }
}

#[cfg(unix)]
fn same_device(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    matches!((a.metadata(), b.metadata()), (Ok(a), Ok(b)) if a.dev() == b.dev())
}

#[cfg(not(unix))]
fn same_device(_: &Path, _: &Path) -> bool {
    false
}

#[cfg(unix)]
fn same_owner(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    matches!((a.metadata(), b.metadata()), (Ok(a), Ok(b)) if (a.uid(), a.gid()) == (b.uid(), b.gid()))
}

#[cfg(not(unix))]
fn same_owner(_: &Path, _: &Path) -> bool {
    true
}

/// Names a file has on its disk.
#[cfg(unix)]
pub(super) fn links(path: &Path) -> u64 {
    use std::os::unix::fs::MetadataExt;
    path.symlink_metadata().map_or(0, |about| about.nlink())
}

#[cfg(not(unix))]
pub(super) fn links(_: &Path) -> u64 {
    1
}
