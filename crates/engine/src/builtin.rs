//! What comes with the program: aircraft, channel maps, sessions and the demonstration flight.
//!
//! A session names them `builtin:` and their path below `assets/` or `sessions/`, so it works wherever the program does.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, OnceLock, PoisonError};

use doublet_core::load::aircraft;
use flate2::read::DeflateDecoder;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use xxhash_rust::xxh3::xxh3_128;

use crate::keep::{PrivateFolder, hex};
use Bytes::{Deflated, Plain};

/// A file inside the program.
struct Shipped {
    /// Below its folder, with slashes.
    path: &'static str,
    bytes: Bytes,
    /// XXH3 of the contents.
    sum: u128,
}

/// The contents of a file as they lie in the program.
enum Bytes {
    Plain(&'static [u8]),
    Deflated { bytes: &'static [u8], size: usize },
}

/// `assets/` and `sessions/` by `build.rs`, in order of their paths.
static ASSETS: &[Shipped] = include!(concat!(env!("OUT_DIR"), "/assets.rs"));
static SESSIONS: &[Shipped] = include!(concat!(env!("OUT_DIR"), "/sessions.rs"));

impl Shipped {
    /// The contents; what is read in place is never packed.
    fn plain(&self) -> Option<&'static [u8]> {
        match self.bytes {
            Plain(bytes) => Some(bytes),
            Deflated { .. } => None,
        }
    }

    fn text(&self) -> Option<&'static str> {
        std::str::from_utf8(self.plain()?).ok()
    }

    /// The name in `folder` without extension, of a `.toml` that lies there.
    fn stem_in(&self, folder: &str) -> Option<&'static str> {
        let name = self.path.strip_prefix(folder)?;
        name.strip_suffix(".toml").filter(|stem| !stem.contains('/'))
    }

    fn contents(&self) -> std::io::Result<Cow<'static, [u8]>> {
        match self.bytes {
            Plain(bytes) => Ok(Cow::Borrowed(bytes)),
            Deflated { bytes, size } => {
                let mut contents = Vec::with_capacity(size);
                DeflateDecoder::new(bytes).read_to_end(&mut contents)?;
                Ok(Cow::Owned(contents))
            }
        }
    }
}

/// What a path in a session starts with when it names a built-in.
pub const PREFIX: &str = "builtin:";

fn asset(path: &str) -> Option<&'static Shipped> {
    ASSETS.iter().find(|file| file.path == path)
}

/// A built-in text: `aircraft/c337f.toml`, or `c337f` in the `folder` `aircraft`.
pub fn text(folder: &str, name: &str) -> Option<&'static str> {
    let file = asset(name).or_else(|| asset(&format!("{folder}/{name}.toml")));
    file.or_else(|| asset(&format!("{folder}/{name}")))?.text()
}

/// A font by its file's name in `assets/fonts/`; empty where there is none.
pub fn font(name: &str) -> &'static [u8] {
    asset(&format!("fonts/{name}")).and_then(Shipped::plain).unwrap_or_default()
}

/// Names of the built-in files of a folder of `assets/`, without their extension.
pub fn names(folder: &str) -> Vec<&'static str> {
    let folder = format!("{folder}/");
    ASSETS.iter().filter_map(|file| file.stem_in(&folder)).collect()
}

/// Names of the aircraft; their folder holds instruments and aerodynamic truths besides.
pub fn aircraft() -> Vec<&'static str> {
    let is_aircraft = |name: &&str| {
        let text = text("aircraft", name).unwrap_or_default();
        text.lines().any(|line| line.starts_with("format") && line.contains(aircraft::FORMAT))
    };
    names("aircraft").into_iter().filter(is_aircraft).collect()
}

/// A session that comes with the program, by its path in `sessions/` without extension.
pub fn session(name: &str) -> Option<&'static str> {
    SESSIONS.iter().find(|file| file.path.strip_suffix(".toml") == Some(name))?.text()
}

/// Names of the sessions that come with the program and need no recording beside what comes with it.
pub fn sessions() -> Vec<&'static str> {
    SESSIONS.iter().filter_map(|file| file.stem_in("")).collect()
}

/// Place on disk of a built-in file or folder, written there on first use: in the cache folder of the user, or in a folder of this
/// program alone where that cannot be written.
///
/// The folder's name carries the content's hash, so versions of the program do not disturb each other.
pub fn on_disk(name: &str) -> Result<PathBuf, String> {
    // Comparing megabytes once per program is enough; a file that left the disk since is written again.
    static PLACES: LazyLock<Mutex<HashMap<String, PathBuf>>> = LazyLock::new(Mutex::default);
    let known = PLACES.lock().unwrap_or_else(PoisonError::into_inner).get(name).cloned();
    if let Some(place) = known.filter(|place| place.exists()) {
        return Ok(place);
    }
    let place = write_entry(name)?;
    PLACES.lock().unwrap_or_else(PoisonError::into_inner).insert(name.to_owned(), place.clone());
    Ok(place)
}

fn write_entry(name: &str) -> Result<PathBuf, String> {
    let below = format!("{name}/");
    let files: Vec<_> = ASSETS.iter().filter(|file| file.path == name || file.path.starts_with(&below)).collect();
    if files.is_empty() {
        return Err(format!("built-in '{name}' not found"));
    }
    let mut hasher = Sha256::new();
    for file in &files {
        hasher.update(file.path);
        hasher.update(file.sum.to_le_bytes());
    }
    let hash = hex(&hasher.finalize()[..8]);
    let put = |root: &Path| {
        files.par_iter().try_for_each(|file| {
            let place = root.join(file.path);
            write_once(&place, file).map_err(|error| format!("{}: {error}", place.display()))
        })
    };
    let refused = match cache_folder().map(|folder| folder.join(&hash)) {
        Some(root) => match put(&root) {
            Ok(()) => return Ok(root.join(name)),
            Err(line) => line,
        },
        None => "neither XDG_CACHE_HOME nor HOME is set".to_owned(),
    };
    let root = own_folder().map_err(|error| {
        format!("{refused}; {error}: set XDG_CACHE_HOME or TMPDIR to a writable folder for the built-in files")
    })?;
    put(root)?;
    Ok(root.join(name))
}

/// A folder of this program alone, once one was needed.
static OWN_FOLDER: OnceLock<Result<PrivateFolder, String>> = OnceLock::new();

/// Removes what was written for this program alone, when it ends. Of a program that is killed the next one that needs such a folder
/// removes it.
pub fn remove_own_folder() {
    if let Some(Ok(folder)) = OWN_FOLDER.get() {
        folder.remove();
    }
}

/// A folder of this program alone.
fn own_folder() -> Result<&'static Path, String> {
    let made = OWN_FOLDER.get_or_init(|| {
        let homes =
            [Some(std::env::temp_dir()), std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from), shared_memory()];
        let mut refused = Vec::new();
        for home in homes.into_iter().flatten() {
            match PrivateFolder::new(&home) {
                Ok(folder) => return Ok(folder),
                Err(error) => refused.push(format!("{}: {error}", home.display())),
            }
        }
        Err(refused.join("; "))
    });
    made.as_ref().map(PrivateFolder::path).map_err(Clone::clone)
}

/// Where Linux keeps files in memory.
fn shared_memory() -> Option<PathBuf> {
    let place = PathBuf::from("/dev/shm");
    place.is_dir().then_some(place)
}

fn cache_folder() -> Option<PathBuf> {
    let home = || std::env::var_os("HOME").map(|home| Path::new(&home).join(".cache"));
    let base = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from).or_else(home)?;
    Some(base.join("doublet"))
}

/// Writes the file unless it is there in full, so that two programs may do so at once.
fn write_once(path: &Path, file: &Shipped) -> std::io::Result<()> {
    if std::fs::read(path).is_ok_and(|present| xxh3_128(&present) == file.sum) {
        return Ok(());
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut written = tempfile::NamedTempFile::new_in(folder)?;
    written.write_all(&file.contents()?)?;
    written.persist(path)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every file comes out as it lies in the repository, and recordings of text are packed.
    #[test]
    fn every_file_is_that_of_the_repository() {
        for (folder, files) in [("assets", ASSETS), ("sessions", SESSIONS)] {
            let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
            for file in files {
                let there = std::fs::read(root.join(file.path)).unwrap();
                assert!(*file.contents().unwrap() == there, "{}", file.path);
                assert_eq!(file.sum, xxh3_128(&there), "{}", file.path);
            }
        }
        let packed: Vec<_> = ASSETS.iter().filter(|file| file.plain().is_none()).collect();
        assert_eq!(packed.len(), 6);
        assert!(packed.iter().all(|file| match file.bytes {
            Deflated { bytes, size } => 3 * bytes.len() < size,
            Plain(_) => false,
        }));
    }

    #[test]
    fn names_are_those_of_the_folder() {
        assert_eq!(names("equations"), ["lateral", "longitudinal", "short_period"]);
        assert_eq!(names("flights"), Vec::<&str>::new());
        assert_eq!(sessions(), ["demo", "demo_thesis"]);
        assert!(session("reference/phlab_short_period").is_some() && session("reference").is_none());
        assert!(font("DejaVuSans.ttf").len() > 700_000 && font("none").is_empty());
    }

    /// What is on disk is the file, also where another left something else in its place.
    #[test]
    fn a_changed_file_on_disk_is_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("flights/demo/pod.csv");
        let file = asset("flights/demo/pod.csv").unwrap();
        for before in [None, Some("other"), Some("")] {
            if let Some(text) = before {
                std::fs::write(&place, text).unwrap();
            }
            write_once(&place, file).unwrap();
            assert_eq!(xxh3_128(&std::fs::read(&place).unwrap()), file.sum);
        }
    }
}
