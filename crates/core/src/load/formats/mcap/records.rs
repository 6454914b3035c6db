//! Records of a file, those inside compressed chunks too.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use super::SIGNATURE;
use crate::load::budget::Budget;
use crate::load::contents::one_line;
use crate::load::error::LoadError;
use crate::load::format::Format;
use crate::message;

/// Kinds of records that are looked at.
const FOOTER: u8 = 2;
const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const DATA_END: u8 = 15;

/// The description of messages.
pub struct Schema {
    pub name: String,
    pub encoding: String,
    pub text: String,
}

/// A topic.
pub struct Channel {
    pub schema: u16,
    pub topic: String,
    pub encoding: String,
}

pub struct Message<'a> {
    pub logged_ns: u64,
    pub published_ns: u64,
    pub data: Cow<'a, [u8]>,
}

/// What a file holds.
#[derive(Default)]
pub struct File<'a> {
    pub schemas: BTreeMap<u16, Schema>,
    pub channels: BTreeMap<u16, Channel>,
    pub messages: BTreeMap<u16, Vec<Message<'a>>>,
    pub warnings: Vec<message::Message>,
}

/// Reads little-endian numbers and fails where the bytes end.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn u8(&mut self) -> Option<u8> {
        Some(self.take(1)?[0])
    }

    fn u16(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(*self.take(2)?.first_chunk()?))
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(*self.take(4)?.first_chunk()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(*self.take(8)?.first_chunk()?))
    }

    fn text(&mut self) -> Option<String> {
        let length = self.u32()? as usize;
        Some(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    /// Kind and content of the next record.
    fn record(&mut self) -> Option<(u8, &'a [u8])> {
        let kind = self.u8()?;
        let length = usize::try_from(self.u64()?).ok()?;
        Some((kind, self.take(length)?))
    }
}

impl<'a> File<'a> {
    /// Reads forward to the end of the data; a file that was cut off gives what is whole in it.
    pub fn read(path: &Path, contents: &'a [u8], budget: &Budget<'_>) -> Result<Self, LoadError> {
        check_chunks(contents, budget)?;
        let mut file = Self::default();
        let mut reader = Reader(contents.get(SIGNATURE.len()..).unwrap_or_default());
        let mut damaged = 0;
        let is_closed = loop {
            let Some((kind, record)) = reader.record() else { break false };
            match kind {
                DATA_END | FOOTER => break true,
                CHUNK => match unpack(record, budget)? {
                    Some(Cow::Borrowed(records)) => file.records(records, Cow::Borrowed),
                    Some(Cow::Owned(records)) => file.records(&records, |data| Cow::Owned(data.to_vec())),
                    None => damaged += 1,
                },
                _ => _ = file.record(kind, record, Cow::Borrowed),
            }
        };
        if damaged > 0 {
            file.warnings.push(message!("{} chunks are damaged or of unknown compression and are left out", damaged));
        }
        if !is_closed {
            let at = contents.len() - reader.0.len();
            if file.messages.is_empty() {
                let what = format!("no message before byte {at}, where its records end");
                return Err(LoadError::Damaged { path: path.to_owned(), format: Format::Mcap, what });
            }
            file.warnings.push(message!("the file is cut off or damaged at byte {}; only the part before is used", at));
        }
        Ok(file)
    }

    fn records<'b>(&mut self, records: &'b [u8], keep: impl Fn(&'b [u8]) -> Cow<'a, [u8]>) {
        let mut reader = Reader(records);
        while let Some((kind, record)) = reader.record() {
            self.record(kind, record, &keep);
        }
    }

    fn record<'b>(&mut self, kind: u8, record: &'b [u8], keep: impl Fn(&'b [u8]) -> Cow<'a, [u8]>) -> Option<()> {
        let mut reader = Reader(record);
        match kind {
            SCHEMA => {
                let (id, name, encoding) = (reader.u16()?, reader.text()?, reader.text()?);
                self.schemas.entry(id).or_insert(Schema { name, encoding, text: reader.text()? });
            }
            CHANNEL => {
                let (id, schema) = (reader.u16()?, reader.u16()?);
                let (topic, encoding) = (one_line(&reader.text()?), one_line(&reader.text()?));
                self.channels.entry(id).or_insert(Channel { schema, topic, encoding });
            }
            MESSAGE => {
                let (channel, _sequence) = (reader.u16()?, reader.u32()?);
                let (logged_ns, published_ns) = (reader.u64()?, reader.u64()?);
                let message = Message { logged_ns, published_ns, data: keep(reader.0) };
                self.messages.entry(channel).or_default().push(message);
            }
            _ => {}
        }
        Some(())
    }
}

/// Refuses a file whose chunks state more than a recording may take, before any of them is unpacked.
fn check_chunks(contents: &[u8], budget: &Budget<'_>) -> Result<(), LoadError> {
    let mut reader = Reader(contents.get(SIGNATURE.len()..).unwrap_or_default());
    let (mut count, mut bytes) = (0, 0_u64);
    while let Some((kind, record)) = reader.record().filter(|(kind, _)| ![DATA_END, FOOTER].contains(kind)) {
        let packed = (kind == CHUNK).then(|| ChunkHead::read(record)).flatten();
        if let Some(head) = packed.filter(|head| !head.compression.is_empty()) {
            (count, bytes) = (count + 1, bytes.saturating_add(head.size));
        }
    }
    budget.check(bytes, || format!("its {count} chunks have {} MB", bytes / 1_000_000))
}

/// What a chunk states before its records.
struct ChunkHead<'a> {
    /// Bytes of its records when unpacked.
    size: u64,
    compression: String,
    packed: &'a [u8],
}

impl<'a> ChunkHead<'a> {
    fn read(chunk: &'a [u8]) -> Option<Self> {
        let mut reader = Reader(chunk);
        let (_start, _end, size, _check) = (reader.u64()?, reader.u64()?, reader.u64()?, reader.u32()?);
        let compression = reader.text()?;
        let length = usize::try_from(reader.u64()?).ok()?;
        Some(Self { size, compression, packed: reader.take(length)? })
    }
}

/// The records of a chunk; `None` where it is damaged or compressed in a way that is not known.
fn unpack<'a>(chunk: &'a [u8], budget: &Budget<'_>) -> Result<Option<Cow<'a, [u8]>>, LoadError> {
    let Some(ChunkHead { size, compression, packed }) = ChunkHead::read(chunk) else { return Ok(None) };
    if compression.is_empty() {
        return Ok(Some(Cow::Borrowed(packed)));
    }
    budget.take(size, || format!("a chunk of {size} bytes"))?;
    let mut records = Vec::new();
    let is_read = match compression.as_str() {
        "zstd" => ruzstd::decoding::StreamingDecoder::new(packed)
            .is_ok_and(|decoder| decoder.take(size).read_to_end(&mut records).is_ok()),
        "lz4" => lz4_flex::frame::FrameDecoder::new(packed).take(size).read_to_end(&mut records).is_ok(),
        _ => false,
    };
    Ok((is_read && records.len() as u64 == size).then_some(Cow::Owned(records)))
}
