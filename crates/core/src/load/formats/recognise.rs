//! Recognising a recording by its content, not by its name.

use std::fs;
use std::path::Path;

use crate::load::budget::Budget;
use crate::load::clocks::find_clocks::{find_clocks, inherit_clocks};
use crate::load::contents::{Probe, Source};
use crate::load::error::LoadError;
use crate::load::file::stem;
use crate::load::format::Format;
use crate::load::formats::finish::finish;
use crate::load::formats::{dataflash, hdf5, mat_contents, mcap, mdf4, parquet, tdms, text, ulog, unsupported};

/// Bytes looked at to recognise a file.
const HEAD_BYTES: usize = 4096;

/// Lists what the file or folder `path` holds, whatever its name says.
///
/// Of an HDF5 file only headers and time vectors are read; of other formats everything, because nothing less tells what they
/// hold.
///
/// # Errors
/// [`LoadError`], naming the file and what to do: it cannot be opened, is empty, is of no known format, is cut off or damaged.
pub fn probe(path: &Path) -> Result<Probe, LoadError> {
    let open = |cause| LoadError::Open { path: path.to_owned(), cause };
    let metadata = fs::metadata(path).map_err(open)?;
    if metadata.is_dir() {
        return text::probe_folder(path);
    }
    if metadata.len() == 0 {
        return Err(LoadError::Empty { path: path.to_owned(), what: "0 bytes" });
    }
    let head = head(path).map_err(open)?;
    let format = Format::of_head(&head);
    if let Some(format @ (Format::Hdf5 | Format::MatV73)) = format {
        if !Format::Hdf5.info().is_of(&head) {
            let reason = "a MAT v7.3 header without the HDF5 that should follow it".to_owned();
            return Err(LoadError::NotRecognised { path: path.to_owned(), reason });
        }
        return hdf5::probe(path, format);
    }
    let budget = Budget::for_file(path, format.unwrap_or(Format::DelimitedText));
    let read = read_sources(format, path, &budget);
    let (format, mut sources, warnings) = read.map_err(|error| unsupported::name_format(error, &head))?;
    sources.iter_mut().for_each(|source| find_clocks(source, |_, _| {}));
    if format == Format::MatV5 {
        inherit_clocks(&mut sources, &stem(path));
    }
    finish(Probe { path: path.to_owned(), format, sources, warnings })
}

/// Reads a file of which nothing less than everything tells what it holds; a file without a mark is text.
fn read_sources(format: Option<Format>, path: &Path, budget: &Budget<'_>) -> Result<text::Contents, LoadError> {
    let Some(format) = format else {
        let contents = budget.read_whole()?;
        if contents.starts_with(b"MATLAB 5.0") {
            let (format, what, needed, left) = (Format::MatV5, "the header", 128, contents.len() as u64);
            return Err(LoadError::Truncated { path: path.to_owned(), format, at: 0, what, needed, left });
        }
        return text::sources(path, &contents, budget);
    };
    let (sources, warnings) = match format {
        Format::MatV5 => mat_contents::sources(path, budget),
        Format::ULog => ulog::sources(path, &budget.read_whole()?, budget),
        Format::DataFlash => dataflash::sources(path, &budget.read_whole()?, budget),
        Format::Tdms => tdms::sources(path, budget),
        Format::Mdf4 => mdf4::sources(path, budget),
        Format::Mcap => mcap::sources(path, &budget.read_whole()?, budget),
        Format::Parquet => parquet::sources(path, budget),
        Format::MatV73 | Format::Hdf5 | Format::DelimitedText | Format::TextColumns | Format::Folder => {
            return text::sources(path, &budget.read_whole()?, budget);
        }
    }?;
    Ok((format, sources, warnings))
}

/// Like [`probe`], and reads every channel to count the samples that are not finite.
pub fn inspect(path: &Path) -> Result<Probe, LoadError> {
    let mut probe = probe(path)?;
    probe.complete()?;
    Ok(probe)
}

impl Probe {
    /// Reads the channels that are still in the file.
    pub fn complete(&mut self) -> Result<(), LoadError> {
        hdf5::complete(self)
    }

    /// The source called `name`.
    pub fn source(&self, name: &str) -> Option<&Source> {
        self.sources.iter().find(|source| source.name == name)
    }
}

fn head(path: &Path) -> std::io::Result<Vec<u8>> {
    use std::io::Read;
    let mut head = Vec::with_capacity(HEAD_BYTES);
    fs::File::open(path)?.take(HEAD_BYTES as u64).read_to_end(&mut head)?;
    Ok(head)
}
