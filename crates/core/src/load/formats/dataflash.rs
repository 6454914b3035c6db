//! ArduPilot flight logs: a source per message and instance, times in microseconds since boot.
//!
//! Form: ArduPilot `libraries/AP_Logger`, structures FMT, UNIT, MULT and FMTU; the binary form and the text one made from it.

use std::collections::BTreeMap;
use std::path::Path;

use crate::load::budget::{Budget, NUMBER_BYTES};
use crate::load::contents::{ChannelInfo, Source, one_line};
use crate::load::error::LoadError;
use crate::load::format::Format;
use crate::message;
use crate::message::{Message, quoted};

/// First bytes of every packet.
const MARK: [u8; 2] = [0xa3, 0x95];
/// Type of the packet that describes the others, and its length.
const FMT: u8 = 128;
const FMT_BYTES: usize = 89;
/// Unit that marks the field with the number of the instance.
const INSTANCE: &str = "instance";
/// Messages that describe others, or hold no history.
const DESCRIPTIONS: [&str; 6] = ["FMT", "UNIT", "MULT", "FMTU", "PARM", "MSG"];
/// Notes kept of texts and parameters.
const MOST_NOTES: usize = 5000;

/// How a character of a format stores a number: its bytes, and the factor to the value meant.
fn size(kind: char) -> Option<usize> {
    Some(match kind {
        'b' | 'B' | 'M' => 1,
        'h' | 'H' | 'c' | 'C' | 'g' => 2,
        'i' | 'I' | 'e' | 'E' | 'L' | 'f' | 'n' => 4,
        'q' | 'Q' | 'd' => 8,
        'N' => 16,
        'Z' | 'a' => 64,
        _ => return None,
    })
}

/// Factor of a character of a format that has one.
fn own_factor(kind: char) -> Option<f64> {
    match kind {
        'c' | 'C' | 'e' | 'E' => Some(0.01),
        'L' => Some(1e-7),
        _ => None,
    }
}

/// A number as stored; `None` for text and lists.
fn number(kind: char, bytes: &[u8]) -> Option<f64> {
    macro_rules! little {
        ($type:ty) => {
            <$type>::from_le_bytes(*bytes.first_chunk()?) as f64
        };
    }
    Some(match kind {
        'b' => little!(i8),
        'B' | 'M' => little!(u8),
        'h' | 'c' => little!(i16),
        'H' | 'C' => little!(u16),
        'i' | 'e' | 'L' => little!(i32),
        'I' | 'E' => little!(u32),
        'q' => little!(i64),
        'Q' => little!(u64),
        'f' => little!(f32),
        'd' => little!(f64),
        'g' => half(u16::from_le_bytes(*bytes.first_chunk()?)),
        _ => return None,
    })
}

/// IEEE 754 half precision.
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff) / 1024.0);
    sign * match exponent {
        0 => fraction * 2.0_f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2.0_f64.powi(exponent - 15),
    }
}

/// Text in a field of fixed length, up to its first NUL.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    one_line(&String::from_utf8_lossy(&bytes[..end]))
}

/// What a packet of one type is made of.
#[derive(Clone)]
struct Layout {
    name: String,
    /// Bytes with the three of the header.
    bytes: usize,
    kinds: Vec<char>,
    labels: Vec<String>,
}

impl Layout {
    /// A layout whose parts fit together; otherwise why they do not.
    fn new(name: String, bytes: usize, format: &str, columns: &str) -> Result<Self, String> {
        let kinds: Vec<char> = format.chars().collect();
        let mut labels: Vec<String> =
            columns.split(',').map(|label| label.trim().to_owned()).filter(|label| !label.is_empty()).collect();
        let sizes: Option<Vec<usize>> = kinds.iter().map(|kind| size(*kind)).collect();
        let Some(sizes) = sizes else { return Err(format!("format '{format}' has unknown letters")) };
        let needed = 3 + sizes.iter().sum::<usize>();
        if needed != bytes {
            return Err(format!("format '{format}' takes {needed} bytes, the log states {bytes}"));
        }
        for index in labels.len()..kinds.len() {
            labels.push(format!("field {index}"));
        }
        labels.truncate(kinds.len());
        Ok(Self { name, bytes, kinds, labels })
    }
}

/// A value of a message.
enum Value {
    Number(f64),
    Text(String),
}

impl Value {
    fn as_number(&self) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Text(_) => f64::NAN,
        }
    }

    fn into_text(self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Text(text) => text,
        }
    }
}

/// Numbers collected of one type, field by field; empty for fields of text.
type Collected = Vec<Vec<f64>>;

#[derive(Default)]
struct Log {
    layouts: BTreeMap<u8, Layout>,
    collected: BTreeMap<u8, Collected>,
    units: BTreeMap<u8, String>,
    multipliers: BTreeMap<u8, f64>,
    /// Letters of units and of multipliers for every field of a type.
    meanings: BTreeMap<u8, (Vec<u8>, Vec<u8>)>,
    notes: Vec<(String, String)>,
    warnings: Vec<Message>,
    /// Bytes that the latest message takes in memory.
    taken: u64,
    /// Whether numbers are scaled by their format already.
    is_scaled: bool,
}

/// Sources of a log in either form, and warnings.
pub(crate) fn sources(
    path: &Path,
    contents: &[u8],
    budget: &Budget<'_>,
) -> Result<(Vec<Source>, Vec<Message>), LoadError> {
    let mut log = Log::default();
    if contents.starts_with(&MARK) {
        log.read_packets(contents, budget)?;
    } else {
        log.is_scaled = true;
        log.read_lines(&String::from_utf8_lossy(contents), budget)?;
    }
    if log.layouts.len() < 2 {
        let what = "it describes no messages".to_owned();
        return Err(LoadError::Damaged { path: path.to_owned(), format: Format::DataFlash, what });
    }
    Ok(log.into_sources())
}

impl Log {
    fn read_packets(&mut self, contents: &[u8], budget: &Budget<'_>) -> Result<(), LoadError> {
        let (mut at, mut skipped, mut first_skipped) = (0, 0, 0);
        while at + 3 <= contents.len() {
            let kind = contents[at + 2];
            let bytes = match self.layouts.get(&kind) {
                Some(layout) => layout.bytes,
                None if kind == FMT => FMT_BYTES,
                None => 0,
            };
            if contents[at..].starts_with(&MARK) && bytes > 0 && at + bytes <= contents.len() {
                self.packet(kind, &contents[at + 3..at + bytes]);
                self.pay(budget)?;
                at += bytes;
            } else {
                // Only a known type tells the length: the next one is looked for.
                first_skipped = if skipped == 0 { at } else { first_skipped };
                skipped += 1;
                at += 1;
            }
        }
        skipped += contents.len() - at;
        if skipped > 0 {
            self.warnings.push(message!(
                "{} bytes, the first at byte {}, belong to no complete message of a known type and are left out",
                skipped,
                first_skipped
            ));
        }
        Ok(())
    }

    /// Takes what the latest message has added from the budget.
    fn pay(&mut self, budget: &Budget<'_>) -> Result<(), LoadError> {
        budget.take(std::mem::take(&mut self.taken), || "its messages".to_owned())
    }

    fn packet(&mut self, kind: u8, body: &[u8]) {
        if kind == FMT {
            if let ([of, length, ..], Some(name), Some(format), Some(columns)) =
                (body, body.get(2..6), body.get(6..22), body.get(22..86))
            {
                self.describe(*of, usize::from(*length), &text(name), &text(format), &text(columns));
            }
            return;
        }
        let Some(layout) = self.layouts.get(&kind) else { return };
        let mut at = 0;
        let values = layout.kinds.iter().map(|&letter| {
            let bytes = &body[at..at + size(letter).unwrap_or(0)];
            at += bytes.len();
            number(letter, bytes).map_or_else(|| Value::Text(text(bytes)), Value::Number)
        });
        let values = values.collect();
        self.message(kind, values);
    }

    fn read_lines(&mut self, contents: &str, budget: &Budget<'_>) -> Result<(), LoadError> {
        let mut types: BTreeMap<String, u8> = BTreeMap::new();
        let (mut skipped, mut first_skipped) = (0, 0);
        for (index, line) in contents.lines().enumerate() {
            let Some((name, rest)) = line.split_once(',') else {
                skipped += usize::from(!line.trim().is_empty());
                continue;
            };
            let name = name.trim();
            if name == "FMT" {
                let parts: Vec<&str> = rest.splitn(5, ',').map(str::trim).collect();
                if let [of, length, name, format, columns] = parts[..]
                    && let (Ok(of), Ok(length)) = (of.parse(), length.parse())
                {
                    types.insert(name.to_owned(), of);
                    self.describe(of, length, name, format, columns);
                }
                continue;
            }
            let layout = types.get(name).and_then(|kind| Some((*kind, self.layouts.get(kind)?)));
            let values = layout.and_then(|(kind, layout)| Some((kind, line_values(layout, rest)?)));
            match values {
                Some((kind, values)) => {
                    self.message(kind, values);
                    self.pay(budget)?;
                }
                None => {
                    first_skipped = if skipped == 0 { index + 1 } else { first_skipped };
                    skipped += 1;
                }
            }
        }
        if skipped > 0 {
            self.warnings.push(message!(
                "{} lines, the first line {}, are not complete messages and are left out",
                skipped,
                first_skipped
            ));
        }
        Ok(())
    }

    fn describe(&mut self, of: u8, length: usize, name: &str, format: &str, columns: &str) {
        match Layout::new(name.to_owned(), length, format, columns) {
            Ok(layout) => _ = self.layouts.entry(of).or_insert(layout),
            Err(what) => self.warnings.push(message!("messages {} are left out: {}", quoted(name), what)),
        }
    }

    fn message(&mut self, kind: u8, values: Vec<Value>) {
        let Some(layout) = self.layouts.get(&kind) else { return };
        let letter = |value: &Value| value.as_number() as u8;
        match (layout.name.as_str(), &values[..]) {
            ("UNIT", [_, id, Value::Text(label)]) => _ = self.units.insert(letter(id), label.clone()),
            ("MULT", [_, id, factor]) => _ = self.multipliers.insert(letter(id), factor.as_number()),
            ("FMTU", [_, of, Value::Text(units), Value::Text(factors)]) => {
                self.meanings.insert(letter(of), (units.clone().into_bytes(), factors.clone().into_bytes()));
            }
            ("PARM", [_, Value::Text(name), Value::Number(value), ..]) => self.note(name.clone(), value.to_string()),
            ("MSG", [time, ..]) => {
                let time = format!("message at {} s", time.as_number() * 1e-6);
                let last = values.into_iter().next_back().map(Value::into_text).unwrap_or_default();
                self.note(time, last);
            }
            (name, _) if DESCRIPTIONS.contains(&name) => {}
            _ => {
                let collected = self.collected.entry(kind).or_default();
                collected.resize_with(layout.kinds.len(), Vec::new);
                for (field, value) in collected.iter_mut().zip(&values) {
                    if let Value::Number(number) = value {
                        field.push(*number);
                        self.taken += NUMBER_BYTES;
                    }
                }
            }
        }
    }

    fn note(&mut self, key: String, value: String) {
        if self.notes.len() < MOST_NOTES {
            self.notes.push((key, value));
        }
    }

    /// Unit of a field and the factor to it from the number as stored.
    fn unit(&self, kind: u8, layout: &Layout, field: usize) -> (Option<String>, f64) {
        let own = own_factor(layout.kinds[field]).map(|factor| if self.is_scaled { 1.0 } else { factor });
        let meaning = self.meanings.get(&kind);
        let letters = meaning.map(|(units, factors)| (units.get(field).copied(), factors.get(field).copied()));
        let (unit, factor) = letters.unwrap_or_default();
        let unit =
            unit.and_then(|letter| self.units.get(&letter)).filter(|unit| !unit.is_empty() && *unit != "UNKNOWN");
        let factor = factor.filter(|letter| !b"-?".contains(letter)).and_then(|letter| self.multipliers.get(&letter));
        let factor = factor.copied().filter(|factor| factor.is_finite() && *factor != 0.0).unwrap_or(1.0);
        let is_clock = ["TimeUS", "TimeMS"].iter().position(|name| *name == layout.labels[field]);
        match (is_clock, own, unit) {
            (Some(ticks), _, _) => (Some(["us", "ms"][ticks].to_owned()), 1.0),
            (None, Some(own), unit) => (unit.cloned(), own),
            // Ticks keep their number: a unit with a prefix says the same.
            (None, None, Some(unit)) if unit == "s" && factor == 1e-3 => (Some("ms".to_owned()), 1.0),
            (None, None, Some(unit)) if unit == "s" && factor == 1e-6 => (Some("us".to_owned()), 1.0),
            (None, None, unit) => (unit.cloned(), factor),
        }
    }

    fn into_sources(mut self) -> (Vec<Source>, Vec<Message>) {
        let mut sources = Vec::new();
        for (kind, mut collected) in std::mem::take(&mut self.collected) {
            let Some(layout) = self.layouts.get(&kind).cloned() else { continue };
            let units: Vec<(Option<String>, f64)> =
                (0..layout.kinds.len()).map(|field| self.unit(kind, &layout, field)).collect();
            let instance = units.iter().position(|(unit, _)| unit.as_deref() == Some(INSTANCE));
            for (values, (_, factor)) in collected.iter_mut().zip(&units) {
                if *factor != 1.0 {
                    values.iter_mut().for_each(|value| *value *= factor);
                }
            }
            let count = collected.iter().map(Vec::len).max().unwrap_or(0);
            for (name, samples) in instances(&layout.name, instance.map(|field| &collected[field]), count) {
                let samples = self.in_order(&name, &layout, &collected, samples);
                let mut source = Source::new(name);
                for ((label, (unit, _)), values) in layout.labels.iter().zip(&units).zip(&collected) {
                    if !values.is_empty() {
                        let values = samples.iter().map(|&sample| values[sample]).collect();
                        let unit = unit.clone().filter(|unit| unit != INSTANCE);
                        source.channels.push(ChannelInfo::new(label.clone(), unit, values));
                    }
                }
                sources.push(source);
            }
        }
        sources.retain(|source| !source.channels.is_empty());
        if let Some(first) = sources.first_mut() {
            first.notes = self.notes;
        }
        (sources, self.warnings)
    }

    /// Samples in the order of their stamps: a log has several writers, and a message may come after a younger one.
    fn in_order(&mut self, name: &str, layout: &Layout, collected: &[Vec<f64>], mut samples: Vec<usize>) -> Vec<usize> {
        let clock = layout.labels.iter().position(|label| label == "TimeUS" || label == "TimeMS");
        let Some(stamps) = clock.map(|field| &collected[field]).filter(|stamps| !stamps.is_empty()) else {
            return samples;
        };
        let late = samples.windows(2).filter(|pair| stamps[pair[1]] < stamps[pair[0]]).count();
        if late > 0 && late * 10 < samples.len() {
            samples.sort_by(|&a, &b| stamps[a].total_cmp(&stamps[b]));
            self.warnings.push(message!(
                "{}: {} messages were written late and are put in the order of their stamps",
                quoted(name),
                late
            ));
        }
        samples
    }
}

/// Values of a line of text; `None` where it has too few.
fn line_values(layout: &Layout, rest: &str) -> Option<Vec<Value>> {
    let count = layout.kinds.len();
    let cells: Vec<&str> = rest.splitn(count, ',').map(str::trim).collect();
    (cells.len() == count)
        .then(|| cells.iter().zip(&layout.kinds).map(|(cell, kind)| parse_value(cell, *kind)).collect())?
}

fn parse_value(cell: &str, kind: char) -> Option<Value> {
    if ['n', 'N', 'Z', 'a'].contains(&kind) {
        Some(Value::Text(one_line(cell)))
    } else {
        Some(Value::Number(cell.parse().ok()?))
    }
}

/// Name and samples of every instance of a message, numbered in `numbers`; all `count` of them where it has none.
fn instances(name: &str, numbers: Option<&Vec<f64>>, count: usize) -> Vec<(String, Vec<usize>)> {
    let Some(numbers) = numbers else { return vec![(name.to_owned(), (0..count).collect())] };
    let mut found: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    for (sample, number) in numbers.iter().enumerate() {
        found.entry(*number as i64).or_default().push(sample);
    }
    found.into_iter().map(|(number, samples)| (format!("{name}[{number}]"), samples)).collect()
}
