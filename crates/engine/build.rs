//! The files of `assets/` and `sessions/` as tables of what comes inside the program; recordings that are text are deflated.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

use flate2::Compression;
use flate2::write::DeflateEncoder;
use xxhash_rust::xxh3::xxh3_128;

fn main() -> io::Result<()> {
    let root = Path::new(&variable("CARGO_MANIFEST_DIR")?).join("../..").canonicalize()?;
    let out = PathBuf::from(variable("OUT_DIR")?);
    for folder in ["assets", "sessions"] {
        let root = root.join(folder);
        // Also when a file comes or goes anywhere below.
        println!("cargo::rerun-if-changed={}", root.display());
        let mut files = Vec::new();
        walk(&root, &mut files)?;
        files.sort();
        let mut table = String::from("&[\n");
        for file in &files {
            table.push_str(&row(&root, file, &out)?);
        }
        table.push(']');
        fs::write(out.join(format!("{folder}.rs")), table)?;
    }
    Ok(())
}

fn variable(name: &str) -> io::Result<String> {
    env::var(name).map_err(io::Error::other)
}

/// Every file below a folder but hidden ones, as programs leave beside what they have open.
fn walk(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        if path.is_dir() {
            walk(&path, files)?;
        } else if !entry.file_name().as_encoded_bytes().starts_with(b".") {
            files.push(path);
        }
    }
    Ok(())
}

/// One file in the table: its path with slashes, its bytes and their sum.
fn row(root: &Path, file: &Path, out: &Path) -> io::Result<String> {
    let contents = fs::read(file)?;
    let path = file.strip_prefix(root).map_err(io::Error::other)?.to_string_lossy().replace('\\', "/");
    let bytes = if path.ends_with(".csv") {
        let packed = out.join(path.replace('/', "-") + ".deflate");
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&contents)?;
        fs::write(&packed, encoder.finish()?)?;
        format!("Deflated {{ bytes: include_bytes!({:?}), size: {} }}", packed.display().to_string(), contents.len())
    } else {
        format!("Plain(include_bytes!({:?}))", file.display().to_string())
    };
    Ok(format!("    Shipped {{ path: {path:?}, bytes: {bytes}, sum: {} }},\n", xxh3_128(&contents)))
}
