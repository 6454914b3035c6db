//! The list of what doublet wrote into a folder, with the content it had.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::{Component, Path};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Name of the list in its folder.
pub const MANIFEST: &str = "doublet_manifest.json";
const FORMAT: &str = "doublet manifest";
const VERSION: u32 = 1;

/// Files of a folder that doublet wrote, by name with `/` between folders.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Manifest {
    format: String,
    version: u32,
    pub files: BTreeMap<String, Entry>,
}

/// A file as it was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Entry {
    /// The set it belongs to.
    pub set: String,
    sha256: String,
}

impl Entry {
    /// Whether `path` still holds what was written, or nothing.
    pub(crate) fn is_of(&self, path: &Path) -> bool {
        path.symlink_metadata().is_ok_and(|about| about.is_file()) && hash(path).is_ok_and(|hash| hash == self.sha256)
    }
}

impl Manifest {
    /// The list of `folder`; empty where there is none that can be understood.
    pub fn read(folder: &Path) -> Self {
        let text = std::fs::read_to_string(folder.join(MANIFEST)).unwrap_or_default();
        let read = serde_json::from_str::<Self>(&text).ok();
        read.filter(|read| read.format == FORMAT && read.version <= VERSION).unwrap_or_default()
    }

    /// Whether `folder` has a list that can be understood.
    pub fn is_in(folder: &Path) -> bool {
        !Self::read(folder).format.is_empty()
    }

    /// Writes the list into `folder`, in one step: a list that is there is whole, and says that the set is.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        let part = folder.join(MANIFEST).with_extension("part");
        std::fs::write(&part, serde_json::to_string_pretty(self).map_err(io::Error::other)? + "\n")?;
        std::fs::File::open(&part)?.sync_all()?;
        std::fs::rename(part, folder.join(MANIFEST))
    }
}

/// Whether `folder` has a list of files that doublet wrote.
pub fn has_manifest(folder: &Path) -> bool {
    Manifest::is_in(folder)
}

/// Lists the files below `folder` as the set called `set`; each is on the disk once this returns.
pub(super) fn hash_and_sync(folder: &Path, set: &str) -> io::Result<Manifest> {
    let (mut folders, mut paths) = (vec![folder.to_path_buf()], Vec::new());
    while let Some(inner) = folders.pop() {
        for entry in std::fs::read_dir(inner)? {
            let path = entry?.path();
            if path.is_dir() { &mut folders } else { &mut paths }.push(path);
        }
    }
    // A disk takes several files at once in little more time than one.
    let listed = paths.par_iter().map(|path| -> io::Result<(String, Entry)> {
        let sha256 = hash(path)?;
        std::fs::File::open(path)?.sync_all()?;
        let inner = path.strip_prefix(folder).map_err(io::Error::other)?;
        Ok((name_of(inner)?, Entry { set: set.to_owned(), sha256 }))
    });
    let files = listed.collect::<io::Result<BTreeMap<_, _>>>()?;
    Ok(Manifest { format: FORMAT.to_owned(), version: VERSION, files })
}

/// A path inside the folder as the list has it.
pub(super) fn name_of(inner: &Path) -> io::Result<String> {
    let part = |part: Component<'_>| part.as_os_str().to_str().map(str::to_owned);
    let parts: Option<Vec<_>> = inner.components().map(part).collect();
    Ok(parts.map_or_else(|| inner.to_string_lossy().into_owned(), |parts| parts.join("/")))
}

fn hash(path: &Path) -> io::Result<String> {
    let mut hasher = Sha256::new();
    hash_file(path, &mut hasher)?;
    Ok(hex(&hasher.finalize()))
}

/// Bytes in hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of `bytes` in hexadecimal.
pub(crate) fn hash_bytes(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Adds the content of a file to a hash.
pub(crate) fn hash_file(path: &Path, hasher: &mut Sha256) -> io::Result<()> {
    let mut file = std::fs::File::open(path)?;
    let mut block = vec![0_u8; 1 << 16];
    loop {
        let read = file.read(&mut block)?;
        if read == 0 {
            return Ok(());
        }
        hasher.update(&block[..read]);
    }
}
