//! TDMS files of LabVIEW: a source per group and time axis.
//!
//! Form: National Instruments, "TDMS File Format Internal Structure".

use std::collections::BTreeMap;
use std::path::Path;

use crate::load::budget::{Budget, NUMBER_BYTES};
use crate::load::contents::{ChannelInfo, Source, one_line};
use crate::load::error::LoadError;
use crate::load::format::Format;
use crate::load::pieces::Pieces;
use crate::message;
use crate::message::Message;

/// First bytes of a file and of every segment in it.
pub(crate) const SIGNATURE: &[u8] = b"TDSm";
/// Bytes of the lead-in of a segment.
const LEAD_IN: usize = 28;
/// Bits of the table of contents of a segment.
const NEW_OBJECTS: u32 = 1 << 2;
const RAW_DATA: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;
const DAQMX: u32 = 1 << 7;
/// Raw-data index of an object without data, and of one whose data are laid out as before.
const NO_DATA: u32 = u32::MAX;
const AS_BEFORE: u32 = 0;
/// Type of a time stamp, of text and of text's raw data.
const TIME_STAMP: u32 = 0x44;
const TEXT: u32 = 0x20;
/// Objects and chunks at most, a bound against counts that a file merely claims.
const MOST_OBJECTS: usize = 100_000;
/// Bytes of samples that are read at a time, at most.
const BLOCK: usize = 1 << 20;

/// Seconds and their fraction since 1904-01-01 UTC.
type Stamp = (i64, u64);

/// A property of an object.
#[derive(Clone, Debug, PartialEq)]
enum Property {
    Number(f64),
    Text(String),
    Time(Stamp),
}

/// Bytes of a value of fixed length.
fn size(kind: u32) -> Option<usize> {
    Some(match kind {
        1 | 5 | 0x21 => 1,
        2 | 6 => 2,
        3 | 7 | 9 | 0x19 => 4,
        4 | 8 | 10 | 0x1a => 8,
        TIME_STAMP => 16,
        _ => return None,
    })
}

/// Reads numbers of either byte order, and fails where the file ends.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    is_big: bool,
}

macro_rules! number {
    ($reader:expr, $type:ty) => {{
        let bytes = *$reader.take(size_of::<$type>())?.first_chunk()?;
        if $reader.is_big { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) }
    }};
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let taken = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(taken)
    }

    fn u32(&mut self) -> Option<u32> {
        Some(number!(self, u32))
    }

    fn text(&mut self) -> Option<String> {
        let length = self.u32()? as usize;
        Some(one_line(&String::from_utf8_lossy(self.take(length)?)))
    }

    fn stamp(&mut self) -> Option<Stamp> {
        if self.is_big {
            let seconds = number!(self, i64);
            return Some((seconds, number!(self, u64)));
        }
        let fraction = number!(self, u64);
        Some((number!(self, i64), fraction))
    }

    fn number(&mut self, kind: u32) -> Option<f64> {
        Some(match kind {
            1 => f64::from(number!(self, i8)),
            2 => f64::from(number!(self, i16)),
            3 => f64::from(number!(self, i32)),
            4 => number!(self, i64) as f64,
            5 | 0x21 => f64::from(number!(self, u8)),
            6 => f64::from(number!(self, u16)),
            7 => f64::from(number!(self, u32)),
            8 => number!(self, u64) as f64,
            9 | 0x19 => f64::from(number!(self, f32)),
            10 | 0x1a => number!(self, f64),
            _ => return None,
        })
    }

    fn property(&mut self) -> Option<(String, Property)> {
        let name = self.text()?;
        let value = match self.u32()? {
            TEXT => Property::Text(self.text()?),
            TIME_STAMP => Property::Time(self.stamp()?),
            kind => Property::Number(self.number(kind)?),
        };
        Some((name, value))
    }
}

/// How the samples of a channel lie in a segment.
#[derive(Clone, Copy)]
struct Layout {
    kind: u32,
    count: usize,
    /// Bytes of all of them.
    bytes: usize,
}

/// A group or channel and what the segments gave it.
#[derive(Default)]
struct Object {
    properties: BTreeMap<String, Property>,
    layout: Option<Layout>,
    values: Vec<f64>,
    stamps: Vec<Stamp>,
    is_text: bool,
}

impl Object {
    fn sample(&mut self, kind: u32, reader: &mut Reader<'_>) {
        if kind == TIME_STAMP {
            self.stamps.extend(reader.stamp());
        } else {
            self.values.extend(reader.number(kind));
        }
    }
}

/// Name of a group, bits of start and interval of its wave forms, and the source they make.
type GroupSource = (String, Option<(u64, u64)>, Source);

#[derive(Default)]
struct File<'b> {
    budget: Option<&'b Budget<'b>>,
    /// Why its numbers do not fit in memory.
    refused: Option<LoadError>,
    paths: Vec<String>,
    objects: BTreeMap<String, Object>,
    /// Paths of the channels with data in the present segment, in their order.
    present: Vec<String>,
    warnings: Vec<Message>,
}

/// Sources of a file, and warnings.
pub(crate) fn sources(path: &Path, budget: &Budget<'_>) -> Result<(Vec<Source>, Vec<Message>), LoadError> {
    let damaged = |what: String| LoadError::Damaged { path: path.to_owned(), format: Format::Tdms, what };
    let pieces = &mut budget.pieces()?;
    let mut file = File { budget: Some(budget), ..File::default() };
    let mut at = 0;
    while at < pieces.len() {
        let segment = file.segment(pieces, at);
        pieces.check()?;
        match segment {
            Ok(Some(next)) => at = next,
            Ok(None) => {
                let left = pieces.len() - at;
                file.warnings.push(message!(
                    "the file is cut off: {} bytes from byte {} on are not a whole segment",
                    left,
                    at
                ));
                break;
            }
            Err(what) => {
                let refused = file.refused.take();
                return Err(refused.unwrap_or_else(|| damaged(format!("segment at byte {at}: {what}"))));
            }
        }
    }
    file.refuse_scaled().map_err(damaged)?;
    Ok(file.into_sources())
}

/// Samples of a segment: where they begin and end, and their byte order.
#[derive(Clone, Copy)]
struct Samples {
    at: usize,
    end: usize,
    is_big: bool,
}

impl File<'_> {
    /// Reads the segment at a place and gives that of the next; `None` where the file ends before it does.
    fn segment(&mut self, pieces: &mut Pieces<'_>, start: usize) -> Result<Option<usize>, String> {
        let length = pieces.len();
        if pieces.get(start, 4).is_none_or(|mark| mark != SIGNATURE) {
            return if length - start < LEAD_IN { Ok(None) } else { Err("it does not begin with TDSm".to_owned()) };
        }
        let Some(lead_in) = pieces.get(start, LEAD_IN) else { return Ok(None) };
        let mut reader = Reader { bytes: lead_in, at: 4, is_big: false };
        let Some(contains) = reader.u32() else { return Ok(None) };
        reader.is_big = contains & BIG_ENDIAN != 0;
        let is_big = reader.is_big;
        let rest = |reader: &mut Reader<'_>| Some((reader.u32()?, number!(reader, u64), number!(reader, u64)));
        let Some((_version, next, raw)) = rest(&mut reader) else { return Ok(None) };
        if contains & DAQMX != 0 {
            return Err("it contains raw DAQmx samples, which need scales: export plain channels".to_owned());
        }
        // A file whose writer lost its power says nothing of its last segment's length.
        let body = start + LEAD_IN;
        let (end, is_open) = match usize::try_from(next).ok().and_then(|next| body.checked_add(next)) {
            Some(end) if next != u64::MAX && end <= length => (end, false),
            _ => (length, true),
        };
        let raw_at = usize::try_from(raw).ok().and_then(|raw| body.checked_add(raw)).filter(|at| *at <= end);
        let Some(raw_at) = raw_at else { return Ok(None) };
        if raw_at > body {
            let Some(bytes) = pieces.get(body, raw_at - body) else { return Ok(None) };
            self.metadata(&mut Reader { bytes, at: 0, is_big }, contains & NEW_OBJECTS != 0)?;
        }
        if contains & RAW_DATA != 0 {
            self.data(pieces, Samples { at: raw_at, end, is_big }, contains & INTERLEAVED != 0)?;
        }
        if is_open {
            self.warnings.push(message!("the last segment was not closed; its complete part is used"));
        }
        Ok(Some(end.max(start + LEAD_IN)))
    }

    fn metadata(&mut self, reader: &mut Reader<'_>, is_new: bool) -> Result<(), String> {
        let cut = || "its description ends too early".to_owned();
        if is_new {
            self.present.clear();
        }
        let count = reader.u32().ok_or_else(cut)? as usize;
        for _ in 0..count {
            let path = reader.text().ok_or_else(cut)?;
            let index = reader.u32().ok_or_else(cut)?;
            if !self.objects.contains_key(&path) {
                if self.objects.len() >= MOST_OBJECTS {
                    return Err(format!("it has more than {MOST_OBJECTS} channels"));
                }
                self.paths.push(path.clone());
            }
            let object = self.objects.entry(path.clone()).or_default();
            match index {
                NO_DATA => {}
                AS_BEFORE if object.layout.is_none() => {
                    return Err(format!("'{path}' repeats a layout that is missing"));
                }
                AS_BEFORE => {}
                _ => object.layout = Some(layout(reader, &path).ok_or_else(cut)??),
            }
            if index != NO_DATA && !self.present.contains(&path) {
                self.present.push(path.clone());
            }
            if index == NO_DATA {
                self.present.retain(|other| *other != path);
            }
            for _ in 0..reader.u32().ok_or_else(cut)? {
                let (name, value) =
                    reader.property().ok_or_else(|| format!("a property of '{path}' cannot be read"))?;
                object.properties.insert(name, value);
            }
        }
        Ok(())
    }

    /// Reads chunk after chunk until the segment ends.
    fn data(&mut self, pieces: &mut Pieces<'_>, samples: Samples, is_interleaved: bool) -> Result<(), String> {
        let present: Vec<(String, Layout)> =
            self.present.iter().filter_map(|path| Some((path.clone(), self.objects.get(path)?.layout?))).collect();
        if present.iter().all(|(_, layout)| layout.bytes == 0) {
            return Ok(());
        }
        self.take_memory(&present, samples.end - samples.at)?;
        if is_interleaved {
            return self.rows(pieces, samples, &present);
        }
        let Samples { mut at, end, is_big } = samples;
        while at < end {
            for (path, layout) in &present {
                let next = at.saturating_add(layout.bytes).min(end);
                let object = self.objects.entry(path.clone()).or_default();
                match size(layout.kind) {
                    Some(bytes) => {
                        let count = layout.count.min((next - at) / bytes);
                        object.values.reserve(if layout.kind == TIME_STAMP { 0 } else { count });
                        for first in (0..count).step_by(BLOCK / bytes) {
                            let samples = (BLOCK / bytes).min(count - first);
                            let Some(bytes) = pieces.get(at + first * bytes, samples * bytes) else { return Ok(()) };
                            let mut reader = Reader { bytes, at: 0, is_big };
                            (0..samples).for_each(|_| object.sample(layout.kind, &mut reader));
                        }
                    }
                    None => object.is_text = true,
                }
                at = next;
            }
        }
        Ok(())
    }

    /// Reads samples of which each row holds one of every channel.
    fn rows(
        &mut self,
        pieces: &mut Pieces<'_>,
        Samples { mut at, end, is_big }: Samples,
        present: &[(String, Layout)],
    ) -> Result<(), String> {
        let row: Option<usize> = present.iter().map(|(_, layout)| size(layout.kind)).sum();
        let row = row.ok_or("it contains text between numbers")?;
        while end - at >= row {
            let rows = (BLOCK / row).max(1).min((end - at) / row);
            let Some(bytes) = pieces.get(at, rows * row) else { return Ok(()) };
            at += bytes.len();
            let mut reader = Reader { bytes, at: 0, is_big };
            for _ in 0..rows {
                for (path, layout) in present {
                    if let Some(object) = self.objects.get_mut(path) {
                        object.sample(layout.kind, &mut reader);
                    }
                }
            }
        }
        Ok(())
    }

    /// Takes the numbers of a segment from the budget before they are read: as many as its `bytes` can hold in this layout.
    fn take_memory(&mut self, present: &[(String, Layout)], bytes: usize) -> Result<(), String> {
        let chunk: usize = present.iter().fold(0_usize, |sum, (_, layout)| sum.saturating_add(layout.bytes)).max(1);
        let chunks = bytes.div_ceil(chunk);
        let numbers = |(_, layout): &(String, Layout)| {
            let size = size(layout.kind)?;
            let held = NUMBER_BYTES.max(size as u64);
            Some(held * layout.count.saturating_mul(chunks).min(bytes / size) as u64)
        };
        let needed = present.iter().filter_map(numbers).fold(0_u64, u64::saturating_add);
        let taken = self.budget.map_or(Ok(()), |budget| budget.take(needed, || "a segment of samples".to_owned()));
        taken.map_err(|error| {
            self.refused = Some(error);
            "too large".to_owned()
        })
    }

    /// Numbers that a scale turns into the quantity must not stand for it.
    fn refuse_scaled(&self) -> Result<(), String> {
        let is_scale = |name: &String| name.starts_with("NI_Scale[");
        match self.objects.iter().find(|(_, object)| object.properties.keys().any(is_scale)) {
            Some((path, _)) => Err(format!("the scale (NI_Scale) of '{path}' is not applied: export it scaled")),
            None => Ok(()),
        }
    }

    fn into_sources(mut self) -> (Vec<Source>, Vec<Message>) {
        let first = self.first_stamp();
        // A source per group and time axis, in the order of the file.
        let mut sources: Vec<GroupSource> = Vec::new();
        let mut texts = Vec::new();
        for path in std::mem::take(&mut self.paths) {
            let (Some(object), [group, channel]) = (self.objects.remove(&path), &names(&path)[..]) else { continue };
            if object.is_text {
                texts.push(path);
                continue;
            }
            let axis = axis(&object, first);
            let key = axis.map(|(start_s, interval_s)| (start_s.to_bits(), interval_s.to_bits()));
            let place = sources.iter().position(|(name, other, _)| name == group && *other == key);
            let place = place.unwrap_or_else(|| {
                let number = sources.iter().filter(|(name, ..)| name == group).count();
                let name = if number == 0 { group.clone() } else { format!("{group} ({})", number + 1) };
                let mut source = Source::new(name);
                source.start_time_s = axis.map(|(start_s, _)| start_s);
                source.sample_rate_hz = axis.map(|(_, interval_s)| 1.0 / interval_s);
                sources.push((group.clone(), key, source));
                sources.len() - 1
            });
            let unit = match object.properties.get("unit_string") {
                Some(Property::Text(unit)) => Some(unit.clone()),
                _ => None,
            };
            let source = &mut sources[place].2;
            if !object.values.is_empty() {
                source.channels.push(ChannelInfo::new(channel.clone(), unit, object.values));
            } else if !object.stamps.is_empty() {
                let since = object.stamps.iter().map(|stamp| since(*stamp, first)).collect();
                source.channels.push(ChannelInfo::new(channel.clone(), Some("s".to_owned()), since));
            }
        }
        if !texts.is_empty() {
            self.warnings.push(message!("channels of text are left out: {}", texts.join(", ")));
        }
        let mut sources: Vec<Source> =
            sources.into_iter().map(|(.., source)| source).filter(|source| !source.channels.is_empty()).collect();
        if let (Some(source), Some((seconds, _))) = (sources.first_mut(), first) {
            source.notes.push(("start, s since 1904-01-01 UTC".to_owned(), seconds.to_string()));
        }
        (sources, self.warnings)
    }

    /// The earliest start of a wave form, or else time stamp: time counts from there.
    fn first_stamp(&self) -> Option<Stamp> {
        let start = |object: &Object| match object.properties.get("wf_start_time") {
            Some(Property::Time(stamp)) if object.properties.contains_key("wf_increment") => Some(*stamp),
            _ => None,
        };
        let starts = self.objects.values().filter_map(start).filter(|stamp| *stamp != (0, 0));
        starts.min().or_else(|| self.objects.values().filter_map(|object| object.stamps.first().copied()).min())
    }
}

/// Layout of the samples of a channel, after its length: type, dimension, count, and for text its bytes.
fn layout(reader: &mut Reader<'_>, path: &str) -> Option<Result<Layout, String>> {
    let (kind, dimension, count) = (reader.u32()?, reader.u32()?, number!(reader, u64));
    let bytes = match size(kind) {
        Some(size) => count.checked_mul(size as u64),
        None if kind == TEXT => Some(number!(reader, u64)),
        None => return Some(Err(format!("'{path}' has samples of unknown type {kind:#x}"))),
    };
    if dimension != 1 {
        return Some(Err(format!("'{path}' has {dimension} dimensions")));
    }
    let sizes = bytes.and_then(|bytes| Some((usize::try_from(bytes).ok()?, usize::try_from(count).ok()?)));
    Some(
        sizes
            .map(|(bytes, count)| Layout { kind, count, bytes })
            .ok_or_else(|| format!("'{path}' claims {count} samples")),
    )
}

/// Start and interval of a wave form, s; the start relative to `first`.
fn axis(object: &Object, first: Option<Stamp>) -> Option<(f64, f64)> {
    let number = |name: &str| match object.properties.get(name) {
        Some(Property::Number(number)) => Some(*number),
        _ => None,
    };
    let interval_s = number("wf_increment").filter(|interval| *interval > 0.0 && interval.is_finite())?;
    let start_s = match object.properties.get("wf_start_time") {
        Some(Property::Time(stamp)) if *stamp != (0, 0) => since(*stamp, first),
        _ => 0.0,
    };
    Some((start_s + number("wf_start_offset").unwrap_or(0.0), interval_s))
}

/// Seconds from one stamp to another: whole seconds are subtracted first, or fractions would be lost.
fn since(stamp: Stamp, first: Option<Stamp>) -> f64 {
    let (seconds, fraction) = first.unwrap_or((0, 0));
    let second = 2.0_f64.powi(-64);
    stamp.0.saturating_sub(seconds) as f64 + (stamp.1 as f64 - fraction as f64) * second
}

/// Names in a path `/'group'/'channel'`, in which quotes are doubled.
fn names(path: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut rest = path;
    while let Some(inner) = rest.strip_prefix("/'") {
        let mut name = String::new();
        let mut letters = inner.char_indices().peekable();
        let mut end = inner.len();
        while let Some((at, letter)) = letters.next() {
            if letter != '\'' {
                name.push(letter);
            } else if letters.next_if(|(_, next)| *next == '\'').is_some() {
                name.push('\'');
            } else {
                end = at + 1;
                break;
            }
        }
        names.push(name);
        rest = inner.get(end..).unwrap_or_default();
    }
    names
}
