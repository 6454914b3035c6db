//! HDF5 files, MATLAB v7.3 among them: a source per group, read with bounds.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use hdf5_reader::checksum::jenkins_lookup3;
use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Dataset, Datatype, FileStorage, Hdf5File, OpenOptions, Storage, StorageBuffer};

use crate::load::budget::Budget;
use crate::load::clocks::find_clocks::{find_clocks, inherit_clocks};
use crate::load::contents::{ChannelInfo, Data, Probe, Source, Stored, one_line};
use crate::load::error::LoadError;
use crate::load::file::stem;
use crate::load::format::Format;
use crate::load::formats::finish::finish;
use crate::load::formats::hdf5_decode::{Column, Layout, layout, read};
use crate::message;
use crate::message::{Message, quoted};

/// Deepest nesting of groups that is followed.
const MAX_DEPTH: usize = 32;
/// Most that deflate can expand data (zlib technical note: 1032:1), with room for headers. What claims more than the file could hold
/// was not written, or not all of it.
const MAX_EXPANSION: u64 = 1100;
/// Most chunks of a data set that is looked into while the file is listed.
const MAX_CHUNKS_LISTED: u64 = 1_000_000;
/// Decoded chunks kept while a file is open, bytes.
const CHUNK_CACHE_BYTES: usize = 8 << 20;
/// Layout class of a virtual data set, whose values lie in others (HDF5 file format, data layout message).
const VIRTUAL: u8 = 3;
/// Longest text kept as a note, characters.
const MAX_NOTE: usize = 4096;

/// Attribute names for a unit, a rate and a start, as met in flight-test files.
const UNIT_NAMES: [&str; 4] = ["units", "unit", "Units", "Unit"];
const RATE_NAMES: [&str; 5] = ["sample_rate", "sample_rate_hz", "sampling_rate", "rate_hz", "fs"];
const START_NAMES: [&str; 3] = ["start_time", "start_time_s", "t0"];

/// Lists the file from its headers and time vectors.
pub(crate) fn probe(path: &Path, format: Format) -> Result<Probe, LoadError> {
    let file = open(path)?;
    let fail = |error: Error| damaged(path, format, &error);
    let mut walk = Walk {
        path,
        format,
        left: limit(path),
        file: &file,
        sources: Vec::new(),
        warnings: Vec::new(),
        seen: BTreeSet::new(),
        hidden: Vec::new(),
    };
    let root = file.root_group().map_err(fail)?;
    walk.group(&root, "", 0)?;
    let Walk { mut sources, warnings, .. } = walk;
    sources.retain(|source| !source.channels.is_empty() || !source.notes.is_empty());
    let mut failed = None;
    let budget = Budget::for_file(path, format);
    for source in &mut sources {
        find_clocks(source, |source, index| {
            if let Err(error) = fetch(&file, &budget, path, format, source, index) {
                failed.get_or_insert(error);
            }
        });
    }
    if let Some(error) = failed {
        return Err(error);
    }
    inherit_clocks(&mut sources, "");
    let root_name = stem(path);
    for source in sources.iter_mut().filter(|source| source.name.is_empty()) {
        source.name.clone_from(&root_name);
    }
    finish(Probe { path: path.to_owned(), format, sources, warnings })
}

/// Reads every channel of `probe` that is still in its file; the file is closed again afterwards.
pub(crate) fn complete(probe: &mut Probe) -> Result<(), LoadError> {
    let mut wanted: BTreeMap<String, Vec<(usize, usize, usize)>> = BTreeMap::new();
    for (at, source) in probe.sources.iter().enumerate() {
        for (index, channel) in source.channels.iter().enumerate() {
            if let Data::Stored(stored) = &channel.data {
                wanted.entry(stored.object.clone()).or_default().push((at, index, stored.column));
            }
        }
    }
    if wanted.is_empty() {
        return Ok(());
    }
    let (path, format) = (probe.path.clone(), probe.format);
    let file = open(&path)?;
    let budget = Budget::for_file(&path, format);
    for (object, places) in wanted {
        let columns = load(&file, &budget, &path, format, &object)?;
        for (source, channel, column) in places {
            let channel = &mut probe.sources[source].channels[channel];
            match columns.get(column) {
                Some(values) if values.len() == channel.samples => channel.set(Arc::clone(values)),
                _ => {
                    let what = format!("data set '{object}' does not match its header");
                    return Err(LoadError::Damaged { path: path.clone(), format, what });
                }
            }
        }
    }
    Ok(())
}

/// Most bytes a data set of the file may decode to.
fn limit(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |metadata| metadata.len()).saturating_mul(MAX_EXPANSION)
}

fn open(path: &Path) -> Result<Hdf5File, LoadError> {
    Hdf5File::open_with_options(path, options(path)).map_err(|error| damaged(path, Format::Hdf5, &error))
}

/// How a file is opened: with bounds that follow from its size.
fn options(path: &Path) -> OpenOptions {
    let limit = limit(path).min(Budget::for_file(path, Format::Hdf5).all());
    let limit = usize::try_from(limit).unwrap_or(usize::MAX);
    OpenOptions::default()
        .with_chunk_cache_bytes(CHUNK_CACHE_BYTES)
        .with_max_read_bytes(limit)
        .with_max_chunk_bytes(limit.min(hdf5_reader::HDF5_MAX_CHUNK_BYTES))
}

/// A file in which some objects look empty. The library lists no group of which it cannot read the header of every member.
struct Hiding {
    file: FileStorage,
    /// Where the headers of the objects lie.
    addresses: Vec<u64>,
}

impl Storage for Hiding {
    fn len(&self) -> u64 {
        self.file.len()
    }

    fn read_range(&self, offset: u64, len: usize) -> Result<StorageBuffer, Error> {
        let buffer = self.file.read_range(offset, len)?;
        let (start, end) = (offset, offset.saturating_add(len as u64));
        if !self.addresses.iter().any(|&at| at < end && at.saturating_add(EMPTY_HEADER as u64) > start) {
            return Ok(buffer);
        }
        let mut bytes = buffer.to_vec();
        for &address in &self.addresses {
            for (at, byte) in (address..).zip(empty_header()) {
                let place = at.checked_sub(start).and_then(|place| bytes.get_mut(usize::try_from(place).ok()?));
                place.into_iter().for_each(|place| *place = byte);
            }
        }
        Ok(StorageBuffer::from_vec(bytes))
    }
}

/// Bytes of an object header without messages, the shortest there is.
const EMPTY_HEADER: usize = 11;

/// An object header of version 2 without messages, with its checksum (HDF5 file format, IV.A.1.b).
fn empty_header() -> [u8; EMPTY_HEADER] {
    let [a, b, c, d] = jenkins_lookup3(b"OHDR\x02\x00\x00").to_le_bytes();
    [b'O', b'H', b'D', b'R', 2, 0, 0, a, b, c, d]
}

/// Name and address of the member whose header the library could not read.
fn child_of(error: &Error) -> Option<(String, u64)> {
    let Error::Context { path, .. } = error else { return None };
    let (name, address) = path.strip_prefix("child '")?.rsplit_once("' at 0x")?;
    Some((name.to_owned(), u64::from_str_radix(address, 16).ok()?))
}

/// What an error of the reader means for the file.
fn damaged(path: &Path, format: Format, error: &Error) -> LoadError {
    let (path, what) = (path.to_owned(), one_line(&error.to_string()));
    if matches!(root_cause(error), Error::ResourceLimit(_)) {
        let budget_mb = Budget::for_file(&path, format).all() / 1_000_000;
        LoadError::TooLarge { path, format, what, budget_mb }
    } else if is_unsupported(error) {
        LoadError::Unsupported { path, what, fix: "store its data sets with gzip or without compression" }
    } else {
        LoadError::Damaged { path, format, what }
    }
}

fn root_cause(error: &Error) -> &Error {
    match error {
        Error::Context { source, .. } => root_cause(source),
        other => other,
    }
}

/// Whether the content is valid HDF5 of a kind that is not read.
fn is_unsupported(error: &Error) -> bool {
    matches!(
        root_cause(error),
        Error::UnsupportedLayoutClass(_)
            | Error::UnsupportedLayoutVersion(_)
            | Error::UnsupportedDatatypeClass(_)
            | Error::UnsupportedFilterPipelineVersion(_)
            | Error::UnsupportedFilter(_)
            | Error::UnsupportedEncoding(_)
            | Error::UnsupportedLinkType(_)
    )
}

/// Reads one data set, whose size was checked when it was listed, into columns. While it is read it takes its stored form twice, as a
/// chunk and as a whole, beside its columns.
fn load(
    file: &Hdf5File,
    budget: &Budget<'_>,
    path: &Path,
    format: Format,
    object: &str,
) -> Result<Vec<Arc<[f64]>>, LoadError> {
    let fail = |error: Error| damaged(path, format, &error);
    let dataset = file.dataset(object).map_err(fail)?;
    match layout(&dataset, format == Format::MatV73) {
        Layout::Columns(samples, columns) => {
            let kept = (samples as u64).saturating_mul(columns.len() as u64).saturating_mul(size_of::<f64>() as u64);
            let for_a_moment = stored_bytes(&dataset).max(chunk_bytes(&dataset)).saturating_mul(2);
            let what = || format!("data set '{}' has {samples} samples of {} columns", one_line(object), columns.len());
            budget.take(kept.saturating_add(for_a_moment), what)?;
            let read = read(&dataset, samples, &columns).map_err(fail)?;
            budget.give_back(for_a_moment);
            Ok(read)
        }
        _ => Ok(Vec::new()),
    }
}

/// Reads the channel `index` of `source` and its neighbours of the same data set.
fn fetch(
    file: &Hdf5File,
    budget: &Budget<'_>,
    path: &Path,
    format: Format,
    source: &mut Source,
    index: usize,
) -> Result<(), LoadError> {
    let Data::Stored(stored) = source.channels[index].data.clone() else { return Ok(()) };
    let columns = load(file, budget, path, format, &stored.object)?;
    for channel in &mut source.channels {
        let Data::Stored(other) = &channel.data else { continue };
        if let Some(values) = columns.get(other.column).filter(|_| other.object == stored.object) {
            channel.set(Arc::clone(values));
        }
    }
    Ok(())
}

struct Walk<'f> {
    path: &'f Path,
    format: Format,
    left: u64,
    file: &'f Hdf5File,
    sources: Vec<Source>,
    warnings: Vec<Message>,
    seen: BTreeSet<u64>,
    /// Addresses of the objects whose header is of a kind that is not read.
    hidden: Vec<u64>,
}

impl Walk<'_> {
    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), LoadError> {
        if depth > MAX_DEPTH || !self.seen.insert(group.address()) {
            return Ok(());
        }
        let (groups, datasets) = self.members(group, path)?;
        let attributes = group.attributes().unwrap_or_default();
        if find(&attributes, &["MATLAB_sparse"]).is_some() {
            self.warnings.push(message!("{} is sparse and is not read; save it as full(...)", quoted(path)));
            return Ok(());
        }
        let mut source = Source::new(path);
        source.sample_rate_hz = number(&attributes, &RATE_NAMES).filter(|rate| *rate > 0.0);
        source.start_time_s = number(&attributes, &START_NAMES);
        source.notes = attributes.iter().filter_map(note).collect();
        let at = self.sources.len();
        self.sources.push(source);
        for dataset in &datasets {
            self.dataset(at, path, dataset)?;
        }
        for child in groups.iter().filter(|child| !child.name().starts_with('#')) {
            let name = child.name();
            let path = joined(path, name);
            self.group(child, &path, depth + 1)?;
        }
        Ok(())
    }

    /// Groups and data sets below `group`. Those whose header is of a kind that is not read, virtual ones for instance, are named.
    fn members(&mut self, group: &Group, path: &str) -> Result<(Vec<Group>, Vec<Dataset>), LoadError> {
        let mut found = group.members();
        while let Err(error) = &found
            && is_unsupported(error)
            && let Some((name, address)) = child_of(error)
            && !self.hidden.contains(&address)
        {
            self.left_out(&joined(path, &name), error);
            self.hidden.push(address);
            found = self.members_of_others(path);
        }
        found.map_err(|error| damaged(self.path, self.format, &error))
    }

    /// Groups and data sets below the group at `path`, without those that are hidden.
    fn members_of_others(&self, path: &str) -> Result<(Vec<Group>, Vec<Dataset>), Error> {
        let file = FileStorage::open(self.path)?;
        let storage = Arc::new(Hiding { file, addresses: self.hidden.clone() });
        let file = Hdf5File::from_storage_with_options(storage, options(self.path))?;
        let group = if path.is_empty() { file.root_group()? } else { file.group(path)? };
        group.members()
    }

    fn left_out(&mut self, object: &str, error: &Error) {
        let reason = match root_cause(error) {
            Error::UnsupportedLayoutClass(VIRTUAL) => "it is virtual: store its values as a plain data set".to_owned(),
            other => one_line(&other.to_string()),
        };
        self.warnings.push(message!("{} is not read ({}) and is left out", quoted(one_line(object)), reason));
    }

    /// Whether a data set can be read; if not, it is named.
    fn is_readable(&mut self, dataset: &Dataset, object: &str) -> Result<bool, LoadError> {
        if dataset.shape().is_empty() && dataset.num_elements().is_ok_and(|count| count == 0) {
            self.warnings.push(message!("{} is empty and is left out", quoted(object)));
            return Ok(false);
        }
        let Some(chunk) = dataset.chunks() else { return Ok(true) };
        let chunks = dataset
            .shape()
            .iter()
            .zip(&chunk)
            .try_fold(1_u64, |count, (&side, &chunk)| count.checked_mul(side.div_ceil(u64::from(chunk).max(1))));
        if chunks.is_none_or(|chunks| chunks == 0 || chunks > MAX_CHUNKS_LISTED) {
            return Ok(true);
        }
        let first = dataset.iter_chunks().and_then(|mut chunks| chunks.next().transpose());
        match first {
            Ok(Some(_)) => Ok(true),
            Ok(None) => {
                self.warnings.push(message!("{} was never written and is left out", quoted(object)));
                Ok(false)
            }
            Err(error) if is_unsupported(&error) => {
                self.left_out(object, &error);
                Ok(false)
            }
            Err(error) => Err(damaged(self.path, self.format, &error)),
        }
    }

    fn dataset(&mut self, at: usize, path: &str, dataset: &Dataset) -> Result<(), LoadError> {
        let name = dataset.name().rsplit('/').next().unwrap_or_default().to_owned();
        let object = joined(path, &name);
        let attributes = dataset.attributes();
        let class = find(&attributes, &["MATLAB_class"]).and_then(|attribute| attribute.read_string().ok());
        if find(&attributes, &["MATLAB_empty"]).is_some() {
            return Ok(());
        }
        if !self.may_be_held(dataset, &object) || !self.is_readable(dataset, &object)? {
            return Ok(());
        }
        match class.as_deref() {
            Some("char") => return self.characters(at, &name, dataset),
            Some("cell") => return self.cells(at, path, &name, dataset),
            Some("function_handle" | "table" | "timetable" | "datetime" | "string") => {
                let kind = class.unwrap_or_default();
                self.warnings.push(message!(
                    "{} is a MATLAB {} and is not read; save its columns as arrays",
                    quoted(&object),
                    kind
                ));
                return Ok(());
            }
            _ => {}
        }
        let unit = find(&attributes, &UNIT_NAMES).and_then(|attribute| attribute.read_string().ok());
        match layout(dataset, self.format == Format::MatV73) {
            Layout::Columns(samples, columns) => {
                let at = self.own_clock(at, &object, &attributes);
                let is_table = matches!(dataset.dtype(), Datatype::Compound { .. });
                let at = if is_table { self.table(at, &object) } else { at };
                for (column, layout) in columns.iter().enumerate() {
                    let suffix = &layout.suffix;
                    let name =
                        if is_table { suffix.trim_start_matches('.').to_owned() } else { format!("{name}{suffix}") };
                    let stored = Stored { object: object.clone(), column };
                    self.sources[at].channels.push(ChannelInfo::stored(name, unit.clone(), samples, stored));
                }
            }
            Layout::Text => {
                let text = dataset.read_strings().unwrap_or_default().join(", ");
                self.sources[at].notes.push((name, text.chars().take(MAX_NOTE).collect()));
            }
            Layout::Other(reason) => self.warnings.push(message!("{} is {} and is left out", quoted(&object), reason)),
        }
        Ok(())
    }

    /// Takes what a data set would decode to from what all of them together may; one that claims more is named and left out.
    fn may_be_held(&mut self, dataset: &Dataset, object: &str) -> bool {
        let decoded = match layout(dataset, self.format == Format::MatV73) {
            // Fields of a compound may claim to lie one over the other.
            Layout::Columns(samples, columns) => columns
                .iter()
                .map(Column::size)
                .sum::<usize>()
                .checked_mul(samples)
                .map_or(u64::MAX, |bytes| bytes as u64),
            _ => 0,
        };
        match self.left.checked_sub(stored_bytes(dataset).max(decoded)) {
            Some(left) => {
                self.left = left;
                true
            }
            None => {
                self.warnings.push(message!(
                    "{} claims {} elements, more than the file can hold: most of it was never written, it is left out",
                    quoted(one_line(object)),
                    format!("{:?}", dataset.shape())
                ));
                false
            }
        }
    }

    /// A table of compounds is a source of its own.
    fn table(&mut self, at: usize, object: &str) -> usize {
        let (rate, start) = (self.sources[at].sample_rate_hz, self.sources[at].start_time_s);
        self.sources.push(Source { sample_rate_hz: rate, start_time_s: start, ..Source::new(object) });
        self.sources.len() - 1
    }

    /// A data set with its own rate and start belongs to a source that has them.
    fn own_clock(&mut self, at: usize, object: &str, attributes: &[Attribute]) -> usize {
        let Some(rate) = number(attributes, &RATE_NAMES).filter(|rate| *rate > 0.0) else { return at };
        let start = number(attributes, &START_NAMES).or(self.sources[at].start_time_s);
        let group = &mut self.sources[at];
        if group.channels.is_empty() && group.sample_rate_hz.is_none() {
            (group.sample_rate_hz, group.start_time_s) = (Some(rate), start);
        }
        if (group.sample_rate_hz, group.start_time_s) == (Some(rate), start) {
            return at;
        }
        let own = Source { sample_rate_hz: Some(rate), start_time_s: start, ..Source::new(object) };
        self.sources.push(own);
        self.sources.len() - 1
    }

    /// MATLAB text: 16-bit characters, transposed.
    fn characters(&mut self, at: usize, name: &str, dataset: &Dataset) -> Result<(), LoadError> {
        if let Layout::Columns(samples, columns) = layout(dataset, true) {
            let columns = read(dataset, samples, &columns).map_err(|error| damaged(self.path, self.format, &error))?;
            let codes = columns.iter().flat_map(|column| column.iter()).map(|&code| code as u16);
            let text = char::decode_utf16(codes).map(|code| code.unwrap_or(char::REPLACEMENT_CHARACTER)).take(MAX_NOTE);
            self.sources[at].notes.push((name.to_owned(), text.collect()));
        }
        Ok(())
    }

    /// MATLAB cells: references to data sets that the group `#refs#` keeps.
    fn cells(&mut self, at: usize, path: &str, name: &str, dataset: &Dataset) -> Result<(), LoadError> {
        let Ok(refs) = self.file.group("#refs#") else { return Ok(()) };
        let fail = |error: Error| damaged(self.path, self.format, &error);
        let bytes = dataset.read_raw_bytes().map_err(fail)?;
        for (index, address) in bytes.as_chunks::<8>().0.iter().enumerate() {
            let Ok(Some(target)) = refs.child_name_by_address(u64::from_le_bytes(*address)) else { continue };
            let Ok(cell) = refs.dataset(&target) else {
                self.warnings.push(message!(
                    "cell {} of {} is not an array and is left out",
                    index + 1,
                    quoted(format!("{path}/{name}"))
                ));
                continue;
            };
            let before = self.sources[at].channels.len();
            let notes = self.sources[at].notes.len();
            let kind = find(&cell.attributes(), &["MATLAB_class"]).and_then(|attribute| attribute.read_string().ok());
            if kind.as_deref() != Some("cell") {
                self.dataset(at, "#refs#", &cell)?;
            }
            let label = format!("{name}{{{}}}", index + 1);
            for channel in &mut self.sources[at].channels[before..] {
                channel.name = channel.name.replacen(&target, &label, 1);
            }
            for (note, _) in &mut self.sources[at].notes[notes..] {
                note.clone_from(&label);
            }
        }
        Ok(())
    }
}

/// Bytes of all elements of a data set as its header has them.
fn stored_bytes(dataset: &Dataset) -> u64 {
    let element = dataset.raw_element_size().unwrap_or(1).max(1) as u64;
    dataset.shape().iter().fold(element, |bytes, &side| bytes.saturating_mul(side))
}

fn chunk_bytes(dataset: &Dataset) -> u64 {
    let element = dataset.raw_element_size().unwrap_or(1).max(1) as u64;
    dataset.chunks().into_iter().flatten().fold(element, |bytes, side| bytes.saturating_mul(u64::from(side)))
}

fn joined(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}/{name}") }
}

fn find<'a>(attributes: &'a [Attribute], names: &[&str]) -> Option<&'a Attribute> {
    names.iter().find_map(|name| attributes.iter().find(|attribute| attribute.name == *name))
}

fn number(attributes: &[Attribute], names: &[&str]) -> Option<f64> {
    find(attributes, names)?.read_as_f64().ok().filter(|value| value.is_finite())
}

/// Name and value of a text attribute.
fn note(attribute: &Attribute) -> Option<(String, String)> {
    let text = attribute.read_string().ok()?;
    Some((attribute.name.clone(), text.chars().take(MAX_NOTE).collect()))
}
