//! Recognising a recording by its content, not by its name.

use std::fs;
use std::path::Path;

use super::contents::{Format, Probe, Source};
use super::find_clocks::find_clocks;
use super::finish::finish;
use super::{LoadError, dataflash, hdf5, mat_contents, mcap, mdf4, parquet, tdms, text, ulog};

/// First bytes of a level 5 MAT-file, at offset 124: version 1.0, then the mark of the byte order.
const MAT_MARKS: [&[u8]; 2] = [&[0x00, 0x01, b'I', b'M'], &[0x01, 0x00, b'M', b'I']];
/// Signature of an HDF5 superblock.
const HDF5_SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Offsets at which the superblock of an HDF5 file with a user block is looked for.
const HDF5_OFFSETS: [usize; 4] = [0, 512, 1024, 2048];
/// First bytes of a flight log of PX4.
const ULOG_SIGNATURE: &[u8] = b"ULog\x01\x12\x35";
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
    if HDF5_OFFSETS.iter().any(|&at| head.get(at..).is_some_and(|rest| rest.starts_with(HDF5_SIGNATURE))) {
        let format = if head.starts_with(b"MATLAB 7.3") { Format::MatV73 } else { Format::Hdf5 };
        return hdf5::probe(path, format);
    }
    if head.starts_with(b"MATLAB 7.3") {
        let reason = "a MAT v7.3 header without the HDF5 that should follow it".to_owned();
        return Err(LoadError::NotRecognised { path: path.to_owned(), reason });
    }
    let contents = fs::read(path).map_err(open)?;
    let is_mat = contents.get(124..128).is_some_and(|mark| MAT_MARKS.contains(&mark));
    let (format, mut sources, warnings) = if is_mat {
        let (sources, warnings) = mat_contents::sources(path, &contents)?;
        (Format::MatV5, sources, warnings)
    } else if contents.starts_with(b"MATLAB 5.0") {
        let (needed, left) = (128, contents.len() as u64);
        let what = "the header";
        return Err(LoadError::Truncated { path: path.to_owned(), format: Format::MatV5, at: 0, what, needed, left });
    } else if contents.starts_with(ULOG_SIGNATURE) {
        let (sources, warnings) = ulog::sources(path, &contents)?;
        (Format::ULog, sources, warnings)
    } else if contents.starts_with(dataflash::SIGNATURE) || dataflash::is_text(&head) {
        let (sources, warnings) = dataflash::sources(path, &contents)?;
        (Format::DataFlash, sources, warnings)
    } else if contents.starts_with(tdms::SIGNATURE) {
        let (sources, warnings) = tdms::sources(path, &contents)?;
        (Format::Tdms, sources, warnings)
    } else if contents.starts_with(mdf4::SIGNATURE) || contents.starts_with(mdf4::UNFINISHED) {
        let (sources, warnings) = mdf4::sources(path, &contents)?;
        (Format::Mdf4, sources, warnings)
    } else if contents.starts_with(mcap::SIGNATURE) {
        let (sources, warnings) = mcap::sources(path, &contents)?;
        (Format::Mcap, sources, warnings)
    } else if contents.starts_with(parquet::SIGNATURE) {
        let (sources, warnings) = parquet::sources(path, contents)?;
        (Format::Parquet, sources, warnings)
    } else {
        text::sources(path, &contents)?
    };
    sources.iter_mut().for_each(|source| find_clocks(source, |_, _| {}));
    finish(Probe { path: path.to_owned(), format, sources, warnings })
}

/// Like [`probe`], and reads every channel to count the samples that are not finite.
///
/// # Errors
/// As [`probe`].
pub fn inspect(path: &Path) -> Result<Probe, LoadError> {
    let mut probe = probe(path)?;
    probe.complete()?;
    Ok(probe)
}

impl Probe {
    /// Reads the channels that are still in the file.
    ///
    /// # Errors
    /// As [`probe`].
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
