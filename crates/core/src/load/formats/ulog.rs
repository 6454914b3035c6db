//! PX4 flight logs: a source per topic, times in microseconds since boot.
//!
//! Form: PX4 guide, "ULog File Format", version 1.

use std::collections::BTreeMap;
use std::path::Path;

use crate::load::budget::{Budget, NUMBER_BYTES};
use crate::load::contents::{ChannelInfo, Source, one_line};
use crate::load::error::LoadError;
use crate::load::format::Format;
use crate::load::formats::stored_number::StoredNumber;
use crate::message;
use crate::message::{Message, quoted};

const HEADER_BYTES: usize = 16;
/// Deepest nesting of message formats that is followed.
const MAX_DEPTH: usize = 8;
/// Most fields in one message, a bound against formats that multiply; a message has at most 65535 bytes.
const MAX_FIELDS: usize = 65_536;
/// Longest name of a field with those it is nested in; PX4 has names of up to some 40 characters.
const MAX_NAME: usize = 255;

/// Kinds of messages: definitions, parameters, subscriptions, text, synchronisation, dropouts, data.
const KINDS: &[u8] = b"BFIMPQARLCSOD";
/// Messages in a row that make a place in a damaged log one to read on from.
const IN_A_ROW: usize = 4;
/// Most bytes of padding behind the last number of a message.
const MAX_PADDING: usize = 64;
/// Body of a synchronisation message.
const SYNC: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];

/// A field of a message format: type, number of elements, name.
struct Field {
    kind: String,
    count: usize,
    name: String,
}

/// A number in a message.
struct Number {
    name: String,
    offset: usize,
    kind: StoredNumber,
}

/// The type of number a format names.
fn stored_number(name: &str) -> Option<StoredNumber> {
    Some(match name {
        "int8_t" => StoredNumber::I8,
        "uint8_t" | "bool" => StoredNumber::U8,
        "int16_t" => StoredNumber::I16,
        "uint16_t" => StoredNumber::U16,
        "int32_t" => StoredNumber::I32,
        "uint32_t" => StoredNumber::U32,
        "int64_t" => StoredNumber::I64,
        "uint64_t" => StoredNumber::U64,
        "float" => StoredNumber::F32,
        "double" => StoredNumber::F64,
        _ => return None,
    })
}

/// A logged topic and what it has collected.
struct Topic {
    name: String,
    numbers: Vec<Number>,
    /// Bytes up to the end of the last number; padding behind it is not written.
    bytes: usize,
    values: Vec<Vec<f64>>,
    short: usize,
}

/// Sources of a flight log, and warnings.
pub(crate) fn sources(
    path: &Path,
    contents: &[u8],
    budget: &Budget<'_>,
) -> Result<(Vec<Source>, Vec<Message>), LoadError> {
    // Every number that is logged takes a byte, so the topics of a file have no more of them than it has bytes.
    let mut log = Log { fields_left: contents.len() + MAX_FIELDS, ..Log::default() };
    let mut at = HEADER_BYTES;
    while at < contents.len() {
        // A kind that a later version of the format may have is known by what follows it.
        let message = message_at(contents, at).filter(|(kind, body)| {
            log.latest.is_none() || KINDS.contains(kind) || log.is_in_order(contents, at + 3 + body.len())
        });
        let failed = match message.map(|(kind, body)| (log.message(kind, body), body.len())) {
            Some((Ok(()), size)) => {
                budget.take(std::mem::take(&mut log.taken), || "its topics".to_owned())?;
                at += 3 + size;
                continue;
            }
            Some((Err(what), _)) => Some(what),
            None => None,
        };
        // Damage in the middle of the data costs what it covers.
        let on = log.latest.and_then(|_| log.next_in_order(contents, at + 1));
        let left = on.unwrap_or(contents.len()) - at;
        match (on, failed) {
            (Some(on), _) => {
                log.forget_latest();
                log.warnings.push(message!(
                    "damage at byte {}: {} bytes are left out, reading continues at byte {}",
                    at,
                    left,
                    on
                ));
                at = on;
            }
            (None, Some(what)) if log.latest.is_none() => {
                let what = format!("message at byte {at}: {what}");
                return Err(LoadError::Damaged { path: path.to_owned(), format: Format::ULog, what });
            }
            (None, _) => {
                // A log ends where the power went off: what is complete counts.
                log.warnings.push(message!(
                    "the log is cut off at byte {}, {} bytes of an incomplete message are left out",
                    at,
                    left
                ));
                break;
            }
        }
    }
    if contents.len() < HEADER_BYTES {
        let (format, what) = (Format::ULog, "the header");
        let (needed, left) = (HEADER_BYTES as u64, contents.len() as u64);
        return Err(LoadError::Truncated { path: path.to_owned(), format, at: 0, what, needed, left });
    }
    Ok(log.into_sources())
}

/// Kind and body of the message at a place; `None` where the file ends before it does.
fn message_at(contents: &[u8], at: usize) -> Option<(u8, &[u8])> {
    let (size, rest) = contents.get(at..)?.split_first_chunk()?;
    let (kind, rest) = rest.split_first()?;
    Some((*kind, rest.get(..usize::from(u16::from_le_bytes(*size)))?))
}

/// What a format comes to: its numbers, the bytes up to the end of the last, and how many fields were looked at.
#[derive(Default)]
struct Found {
    numbers: Vec<Number>,
    bytes: usize,
    fields: usize,
}

#[derive(Default)]
struct Log {
    formats: BTreeMap<String, Vec<Field>>,
    topics: BTreeMap<u16, Topic>,
    notes: Vec<(String, String)>,
    warnings: Vec<Message>,
    dropouts: usize,
    dropout_ms: u64,
    unknown: usize,
    fields_left: usize,
    /// Bytes that the latest message takes in memory.
    taken: u64,
    /// Topic of the latest data; `None` while the log is still defining what it holds.
    latest: Option<u16>,
}

impl Log {
    /// The first place from `at` on where messages follow each other.
    fn next_in_order(&self, contents: &[u8], at: usize) -> Option<usize> {
        (at..contents.len()).find(|&place| self.is_in_order(contents, place))
    }

    /// Whether messages follow each other from a place on.
    fn is_in_order(&self, contents: &[u8], mut place: usize) -> bool {
        (0..IN_A_ROW).all(|_| {
            let next = message_at(contents, place).filter(|(kind, body)| self.is_plausible(*kind, body));
            place += next.map_or(0, |(_, body)| 3 + body.len());
            next.is_some()
        })
    }

    /// Whether a message is one that a logger would write at this place.
    fn is_plausible(&self, kind: u8, body: &[u8]) -> bool {
        match kind {
            b'D' => {
                let topic = body.first_chunk().and_then(|id| self.topics.get(&u16::from_le_bytes(*id)));
                topic.is_some_and(|topic| (topic.bytes..=topic.bytes + MAX_PADDING).contains(&(body.len() - 2)))
            }
            b'S' => body == SYNC,
            b'O' => body.len() == 2,
            _ => false,
        }
    }

    /// Takes the latest data back: its message may reach into the damage.
    fn forget_latest(&mut self) {
        if let Some(topic) = self.latest.and_then(|id| self.topics.get_mut(&id)) {
            topic.values.iter_mut().for_each(|values| _ = values.pop());
        }
    }

    fn message(&mut self, kind: u8, body: &[u8]) -> Result<(), String> {
        match kind {
            b'F' => self.format(body),
            b'A' => self.subscribe(body),
            b'D' => {
                self.data(body);
                Ok(())
            }
            b'I' => {
                self.information(body);
                Ok(())
            }
            b'O' => {
                self.dropouts += 1;
                self.dropout_ms += body.first_chunk().map_or(0, |bytes| u64::from(u16::from_le_bytes(*bytes)));
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// `name:type field;type[n] field;`
    fn format(&mut self, body: &[u8]) -> Result<(), String> {
        let text = one_line(&String::from_utf8_lossy(body));
        let (name, fields) = text.split_once(':').ok_or("a format without a name")?;
        let fields = fields.split(';').filter(|field| !field.trim().is_empty()).map(|field| {
            let (kind, name) = field.trim().split_once(' ').ok_or_else(|| format!("field '{field}' has no type"))?;
            let (kind, count) = match kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
                Some((kind, count)) => {
                    (kind, count.parse().map_err(|_| format!("field '{field}' has no valid length"))?)
                }
                None => (kind, 1),
            };
            Ok(Field { kind: kind.to_owned(), count, name: name.trim().to_owned() })
        });
        let fields = fields.collect::<Result<_, String>>()?;
        self.formats.insert(name.to_owned(), fields);
        Ok(())
    }

    fn subscribe(&mut self, body: &[u8]) -> Result<(), String> {
        let [multi, low, high, name @ ..] = body else { return Err("a subscription of too few bytes".to_owned()) };
        let format = one_line(&String::from_utf8_lossy(name));
        let mut found = Found::default();
        self.expand(&format, "", 0, 0, &mut found)?;
        let Found { numbers, bytes, fields } = found;
        let left = self.fields_left.checked_sub(fields);
        self.fields_left = left.ok_or("the topics have more fields than the file has bytes")?;
        self.taken += numbers.iter().map(|number| (size_of::<Number>() + number.name.len()) as u64).sum::<u64>();
        let name = if *multi == 0 { format } else { format!("{format}.{multi}") };
        let values = numbers.iter().map(|_| Vec::new()).collect();
        self.topics.insert(u16::from_le_bytes([*low, *high]), Topic { name, numbers, bytes, values, short: 0 });
        Ok(())
    }

    /// Adds the numbers of `format` from `offset` on to `found` and gives the offset after them.
    fn expand(
        &self,
        format: &str,
        prefix: &str,
        mut offset: usize,
        depth: usize,
        found: &mut Found,
    ) -> Result<usize, String> {
        let fields = self.formats.get(format).ok_or_else(|| format!("format '{format}' is not defined"))?;
        if depth > MAX_DEPTH {
            return Err(format!("format '{format}' nests deeper than {MAX_DEPTH}"));
        }
        for field in fields {
            if field.count > MAX_FIELDS {
                return Err(format!("format '{format}' has more than {MAX_FIELDS} fields"));
            }
            if field.kind == "char" {
                offset += field.count;
                continue;
            }
            for index in 0..field.count {
                found.fields += 1;
                if found.fields > MAX_FIELDS {
                    return Err(format!("format '{format}' has more than {MAX_FIELDS} fields"));
                }
                let index = if field.count == 1 { String::new() } else { format!("[{index}]") };
                let name = format!("{prefix}{}{index}", field.name);
                if name.len() > MAX_NAME {
                    return Err(format!("format '{format}' has a field whose name is longer than {MAX_NAME} bytes"));
                }
                if let Some(kind) = stored_number(&field.kind) {
                    let size = kind.size();
                    if !field.name.starts_with("_padding") {
                        found.numbers.push(Number { name, offset, kind });
                        found.bytes = offset + size;
                    }
                    offset += size;
                } else {
                    offset = self.expand(&field.kind, &format!("{name}."), offset, depth + 1, found)?;
                }
            }
        }
        Ok(offset)
    }

    fn data(&mut self, body: &[u8]) {
        let id = body.first_chunk().map(|bytes| u16::from_le_bytes(*bytes));
        let Some(topic) = id.and_then(|id| self.topics.get_mut(&id)) else {
            self.unknown += 1;
            return;
        };
        let body = &body[2..];
        if body.len() < topic.bytes {
            topic.short += 1;
            return;
        }
        self.latest = id;
        self.taken += NUMBER_BYTES * topic.numbers.len() as u64;
        for (number, values) in topic.numbers.iter().zip(&mut topic.values) {
            values.push(body.get(number.offset..).and_then(|bytes| number.kind.read(bytes)).unwrap_or(f64::NAN));
        }
    }

    /// `length, "type name", value`: text is kept.
    fn information(&mut self, body: &[u8]) {
        let Some((&length, rest)) = body.split_first() else { return };
        let Some((key, value)) = rest.split_at_checked(usize::from(length)) else { return };
        let key = String::from_utf8_lossy(key);
        if let Some((_, name)) = key.split_once(' ').filter(|(kind, _)| kind.starts_with("char")) {
            let text = String::from_utf8_lossy(value).into_owned();
            self.notes.push((name.to_owned(), text));
        }
    }

    fn into_sources(mut self) -> (Vec<Source>, Vec<Message>) {
        if self.dropouts > 0 {
            let (count, length) = (self.dropouts, self.dropout_ms);
            self.warnings.push(message!("the logger dropped data {} times, {} ms in all; see the gaps", count, length));
        }
        if self.unknown > 0 {
            self.warnings.push(message!("{} messages of unknown topics are left out", self.unknown));
        }
        let mut sources = Vec::new();
        for topic in self.topics.into_values() {
            if topic.short > 0 {
                let (count, name) = (topic.short, &topic.name);
                self.warnings.push(message!(
                    "topic {}: {} messages are too short and are left out",
                    quoted(name),
                    count
                ));
            }
            let mut source = Source::new(topic.name);
            for (number, values) in topic.numbers.into_iter().zip(topic.values).filter(|(_, values)| !values.is_empty())
            {
                let unit = (number.name == "timestamp").then(|| "us".to_owned());
                source.channels.push(ChannelInfo::new(number.name, unit, values));
            }
            sources.push(source);
        }
        sources.retain(|source| !source.channels.is_empty());
        if let Some(first) = sources.first_mut() {
            first.notes = self.notes;
        }
        (sources, self.warnings)
    }
}
