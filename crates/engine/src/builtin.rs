//! What comes with the program: aircraft, channel maps, sessions and the demonstration flight.
//!
//! A session names them `builtin:` and their path below `assets/` or `sessions/`, so it works wherever the program does.

use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, OnceLock, PoisonError};

use doublet_core::load::aircraft;
use include_dir::{Dir, DirEntry, File, include_dir};
use sha2::{Digest, Sha256};

use crate::keep::{PrivateFolder, hex};

static ASSETS: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../assets");
static SESSIONS: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../sessions");

/// What a path in a session starts with when it names a built-in.
pub const PREFIX: &str = "builtin:";

/// A built-in text: `aircraft/c337f.toml`, or `c337f` in the `folder` `aircraft`.
pub fn text(folder: &str, name: &str) -> Option<&'static str> {
    let file = ASSETS.get_file(name).or_else(|| ASSETS.get_file(format!("{folder}/{name}.toml")));
    file.or_else(|| ASSETS.get_file(format!("{folder}/{name}")))?.contents_utf8()
}

/// A font by its file's name in `assets/fonts/`; empty where there is none.
pub fn font(name: &str) -> &'static [u8] {
    ASSETS.get_file(format!("fonts/{name}")).map_or(&[], File::contents)
}

/// Names of the built-in files of a folder of `assets/`, without their extension.
pub fn names(folder: &str) -> Vec<&'static str> {
    let files = ASSETS.get_dir(folder).into_iter().flat_map(Dir::files);
    files
        .filter(|file| file.path().extension().is_some_and(|e| e == "toml"))
        .filter_map(|f| f.path().file_stem()?.to_str())
        .collect()
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
    SESSIONS.get_file(format!("{name}.toml"))?.contents_utf8()
}

/// Names of the sessions that come with the program and need no recording beside what comes with it.
pub fn sessions() -> Vec<&'static str> {
    let mut names: Vec<_> = SESSIONS.files().filter_map(|file| file.path().file_stem()?.to_str()).collect();
    names.sort_unstable();
    names
}

/// Place on disk of a built-in file or folder, written there on first use: in the cache folder of the user, or in a folder of this
/// program alone where that cannot be written.
///
/// The folder's name carries the content's hash, so versions of the program do not disturb each other.
///
/// # Errors
/// One line when nothing is called so or the files can be written nowhere.
pub fn on_disk(name: &str) -> Result<PathBuf, String> {
    // Hashing and comparing megabytes once per program is enough; a file that left the disk since is written again.
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
    let entry = ASSETS.get_entry(name).ok_or_else(|| format!("no built-in is called '{name}'"))?;
    let mut files = Vec::new();
    collect(entry, &mut files);
    let mut hasher = Sha256::new();
    for (path, contents) in &files {
        hasher.update(path.to_string_lossy().as_bytes());
        hasher.update(contents);
    }
    let hash = hex(&hasher.finalize()[..8]);
    let put = |root: &Path| {
        files.iter().try_for_each(|(path, contents)| {
            let place = root.join(path);
            write_once(&place, contents).map_err(|error| format!("{}: {error}", place.display()))
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
        format!("{refused}; {error}: set XDG_CACHE_HOME or TMPDIR to a folder that can be written, for what comes with doublet")
    })?;
    put(root)?;
    Ok(root.join(name))
}

/// A folder of this program alone. It outlives the program and is removed by the next that needs one.
fn own_folder() -> Result<&'static Path, String> {
    static FOLDER: OnceLock<Result<PrivateFolder, String>> = OnceLock::new();
    let made = FOLDER.get_or_init(|| {
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

fn collect(entry: &'static DirEntry<'static>, files: &mut Vec<(&'static Path, &'static [u8])>) {
    match entry {
        DirEntry::File(file) => files.push((file.path(), file.contents())),
        DirEntry::Dir(dir) => dir.entries().iter().for_each(|entry| collect(entry, files)),
    }
}

fn cache_folder() -> Option<PathBuf> {
    let home = || std::env::var_os("HOME").map(|home| Path::new(&home).join(".cache"));
    let base = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from).or_else(home)?;
    Some(base.join("doublet"))
}

/// Writes the file unless it is there in full, so that two programs may do so at once.
fn write_once(path: &Path, contents: &[u8]) -> std::io::Result<()> {
    if std::fs::read(path).is_ok_and(|present| present == contents) {
        return Ok(());
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(contents)?;
    file.persist(path)?;
    Ok(())
}
