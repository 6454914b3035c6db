//! Recognising a recording by its content, not by its name.

use std::fs;
use std::path::Path;

use super::clock::find_clocks;
use super::contents::{Format, Probe, Source};
use super::time_unit::settle_units;
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

/// Refuses a recording without a channel and lists what is odd about time.
pub(super) fn finish(mut probe: Probe) -> Result<Probe, LoadError> {
    if probe.sources.iter().all(|source| source.channels.is_empty()) {
        let what = "no numeric channel was found";
        return Err(LoadError::Empty { path: probe.path, what });
    }
    settle_units(&mut probe.sources);
    for source in &probe.sources {
        for clock in &source.clocks {
            if clock.question.is_some() && clock.fault_count > 0 {
                continue;
            }
            probe.warnings.extend(
                clock
                    .faults
                    .iter()
                    .map(|fault| format!("source '{}': time channel '{}' {fault}", source.name, clock.channel)),
            );
            if clock.fault_count > clock.faults.len() {
                let more = clock.fault_count - clock.faults.len();
                probe
                    .warnings
                    .push(format!("source '{}': {more} more such samples of '{}'", source.name, clock.channel));
            }
        }
        probe.warnings.extend(source.missing_time());
    }
    Ok(probe)
}

impl Source {
    /// What is to be done about the time of a source that has none, in one line.
    pub fn missing_time(&self) -> Option<String> {
        if !self.clocks.is_empty() || self.channels.iter().all(|channel| channel.samples <= 1) {
            return None;
        }
        let cure = match stated_rate(self) {
            Some((line, rate)) => {
                format!("{line} says {rate} Hz: give sample_rate = {rate} in the map's [[time]] entry")
            }
            None => "name it in the map's [[time]] entry or give sample_rate there".to_owned(),
        };
        Some(format!("source '{}': no time channel recognised; {cure}", self.name))
    }
}

/// A rate that a line of text in the file states (`25 Hz`), and where.
fn stated_rate(source: &Source) -> Option<(&str, f64)> {
    source.notes.iter().find_map(|(line, text)| {
        let lower = text.to_lowercase();
        let number =
            lower[..lower.find("hz")?].trim_end().rsplit(|letter: char| !(letter.is_ascii_digit() || letter == '.'));
        Some((line.as_str(), number.into_iter().next()?.parse().ok()?))
    })
}

fn head(path: &Path) -> std::io::Result<Vec<u8>> {
    use std::io::Read;
    let mut head = Vec::with_capacity(HEAD_BYTES);
    fs::File::open(path)?.take(HEAD_BYTES as u64).read_to_end(&mut head)?;
    Ok(head)
}

/// Name of a file without its extension, which names the source of a file that has only one.
pub(super) fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned())
}
