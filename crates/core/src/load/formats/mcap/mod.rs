//! MCAP recordings of robots and simulators: a source per topic whose messages are JSON or, described by a ROS 2 schema, CDR.
//!
//! Form: foxglove, "MCAP File Format"; OMG, "Common Data Representation".

mod cdr;
mod json;
mod records;

use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;

use crate::load::budget::{Budget, NUMBER_BYTES};
use crate::load::contents::{ChannelInfo, Source, one_line};
use crate::load::error::LoadError;
use crate::message;
use crate::message::quoted;
use cdr::Layout;
use records::{Channel, File, Message};

/// First and last bytes of a file.
pub(crate) const SIGNATURE: &[u8] = b"\x89MCAP0\r\n";
/// Most fields of one message, a bound against descriptions that multiply.
const MOST_FIELDS: usize = 4096;
/// Deepest nesting that is followed.
const MAX_DEPTH: usize = 8;
/// Numbers that the three stamps of a message take.
const STAMP_NUMBERS: u64 = 6;
/// Longest array whose elements are channels.
const LONGEST_ARRAY: usize = 64;

/// A number of a message: its name with those it is nested in, and its value.
type Number = (Rc<str>, f64);
/// Seconds since an epoch and nanoseconds.
type Stamp = (i64, i64);
/// A channel: name, unit, values.
type Column = (Rc<str>, Option<&'static str>, Vec<f64>);

/// Names of the instant of measurement in a message: seconds and nanoseconds of ROS and of others.
const STAMPS: [[&str; 2]; 4] = [
    ["header.stamp.sec", "header.stamp.nanosec"],
    ["header.stamp.secs", "header.stamp.nsecs"],
    ["timestamp.sec", "timestamp.nsec"],
    ["stamp.sec", "stamp.nanosec"],
];

/// How the messages of a topic are decoded.
enum Decoder {
    Json,
    Cdr(Layout),
}

impl Decoder {
    fn decode(&self, data: &[u8]) -> Option<Vec<Number>> {
        match self {
            Self::Json => json::decode(data),
            Self::Cdr(layout) => layout.decode(data),
        }
    }

    fn unit(&self, name: &str) -> Option<&'static str> {
        match self {
            Self::Json => None,
            Self::Cdr(layout) => layout.unit(name),
        }
    }
}

/// The messages of a topic, decoded.
struct Topic {
    name: String,
    /// Which of the stamps are used.
    clock: &'static str,
    stamps: Vec<Stamp>,
    columns: Vec<Column>,
}

/// Sources of a file, and warnings.
pub(crate) fn sources(
    path: &Path,
    contents: &[u8],
    budget: &Budget<'_>,
) -> Result<(Vec<Source>, Vec<message::Message>), LoadError> {
    let mut file = File::read(path, contents, budget)?;
    let mut topics = Vec::new();
    let mut left_out = Vec::new();
    for (id, messages) in std::mem::take(&mut file.messages) {
        let Some(channel) = file.channels.get(&id) else { continue };
        match decoder(&file, channel) {
            Ok(decoder) => topics.extend(decode((channel, &decoder), &messages, budget, &mut file.warnings)?),
            Err(why) => left_out.push(format!("'{}' ({why})", channel.topic)),
        }
    }
    if topics.is_empty() && !left_out.is_empty() {
        return Err(LoadError::Unsupported {
            path: path.to_owned(),
            what: format!("every topic, {},", left_out.join(", ")),
            fix: "record messages as JSON or as CDR with their ros2msg schema",
        });
    }
    if !left_out.is_empty() {
        file.warnings.push(message!("topics left out: {}", left_out.join(", ")));
    }
    Ok((into_sources(topics), file.warnings))
}

/// The decoder of a topic, or why there is none.
fn decoder(file: &File<'_>, channel: &Channel) -> Result<Decoder, String> {
    let schema = file.schemas.get(&channel.schema);
    match (channel.encoding.as_str(), schema) {
        ("json", _) => Ok(Decoder::Json),
        ("cdr", Some(schema)) if schema.encoding == "ros2msg" => {
            Layout::new(&schema.name, &schema.text).map(Decoder::Cdr)
        }
        (encoding, schema) => {
            let described = schema.map_or_else(|| "none".to_owned(), |schema| format!("\"{}\"", schema.encoding));
            Err(format!("message encoding \"{encoding}\", schema encoding {described}"))
        }
    }
}

/// Decodes the messages of a topic; `None` where no number comes of them.
fn decode(
    (channel, decoder): (&Channel, &Decoder),
    messages: &[Message<'_>],
    budget: &Budget<'_>,
    warnings: &mut Vec<message::Message>,
) -> Result<Option<Topic>, LoadError> {
    let what = || format!("topic '{}'", channel.topic);
    let mut places = BTreeMap::<Rc<str>, usize>::new();
    let mut columns = Vec::<Column>::new();
    // Instants of measurement where the message tells them, of sending, of recording.
    let mut stamps = Vec::<[Stamp; 3]>::new();
    for message in messages {
        let Some(mut numbers) = decoder.decode(&message.data) else { continue };
        let row = stamps.len();
        // Every column has a value for every message, also for those without it.
        budget.take((columns.len() as u64 + STAMP_NUMBERS) * NUMBER_BYTES, what)?;
        let measured = take_stamp(&mut numbers).unwrap_or_default();
        stamps.push([measured, split(message.published_ns), split(message.logged_ns)]);
        for (name, value) in numbers {
            let place = match places.get(&name) {
                Some(place) => *place,
                None if columns.len() >= MOST_FIELDS => continue,
                None => {
                    budget.take((row as u64 + 1) * NUMBER_BYTES + name.len() as u64, what)?;
                    places.insert(Rc::clone(&name), columns.len());
                    columns.push((Rc::clone(&name), decoder.unit(&name), Vec::new()));
                    columns.len() - 1
                }
            };
            let values = &mut columns[place].2;
            values.resize(row, f64::NAN);
            values.push(value);
        }
    }
    if columns.is_empty() {
        return Ok(None);
    }
    if stamps.len() < messages.len() {
        let undecoded = messages.len() - stamps.len();
        warnings.push(message!(
            "{}: {} messages cannot be decoded and are left out",
            quoted(&channel.topic),
            undecoded
        ));
    }
    let is_told = |which: &usize| stamps.iter().any(|stamp| stamp[*which] != stamps[0][*which]);
    let which = (0..2).find(is_told).unwrap_or(2);
    let mut order: Vec<usize> = (0..stamps.len()).collect();
    order.sort_by_key(|&row| stamps[row][which]);
    for (.., values) in &mut columns {
        values.resize(stamps.len(), f64::NAN);
        *values = order.iter().map(|&row| values[row]).collect();
    }
    let stamps = order.iter().map(|&row| stamps[row][which]).collect();
    let clock = ["header.stamp", "publish_time", "log_time"][which];
    Ok(Some(Topic { name: channel.topic.clone(), clock, stamps, columns }))
}

/// Takes the instant of measurement out of the numbers of a message.
fn take_stamp(numbers: &mut Vec<Number>) -> Option<Stamp> {
    let find = |numbers: &[Number], wanted: &str| numbers.iter().position(|(name, _)| **name == *wanted);
    let names = STAMPS.iter().find(|names| names.iter().all(|name| find(numbers, name).is_some()))?;
    let [seconds, nanoseconds] = names.map(|name| find(numbers, name).map_or(0.0, |place| numbers.remove(place).1));
    Some((seconds as i64, nanoseconds as i64))
}

/// Time of a record in whole seconds and nanoseconds: as a float of nanoseconds since 1970 it would have steps of 256.
fn split(time_ns: u64) -> Stamp {
    ((time_ns / 1_000_000_000) as i64, (time_ns % 1_000_000_000) as i64)
}

/// A source for each topic; time counts from the earliest stamp of all.
fn into_sources(topics: Vec<Topic>) -> Vec<Source> {
    let first = topics.iter().filter_map(|topic| topic.stamps.first()).min().copied().unwrap_or_default();
    let since = |stamp: &Stamp| stamp.0.saturating_sub(first.0) as f64 + stamp.1.saturating_sub(first.1) as f64 * 1e-9;
    let mut sources: Vec<Source> = topics
        .into_iter()
        .map(|topic| {
            let mut source = Source::new(topic.name);
            let time_s = topic.stamps.iter().map(since).collect();
            source.channels.push(ChannelInfo::new(topic.clock, Some("s".to_owned()), time_s));
            for (name, unit, values) in topic.columns {
                source.channels.push(ChannelInfo::new(&*name, unit.map(str::to_owned), values));
            }
            source
        })
        .collect();
    if let Some(source) = sources.first_mut() {
        source
            .notes
            .push(("start, s of the recorder's epoch".to_owned(), one_line(&format!("{}.{:09}", first.0, first.1))));
    }
    sources
}
