//! What the Arrow schema of a table adds to Parquet's own: units, and columns that are durations.
//!
//! Form: Apache Arrow, "Columnar Format", Schema.fbs and Message.fbs; Google, "FlatBuffers Internals".

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

/// A column.
pub struct Field {
    pub name: String,
    /// Unit among its notes.
    pub unit: Option<String>,
    /// Ticks of a second where it is a duration.
    pub ticks: Option<i64>,
}

/// Type of a message that is a schema, and of a field that is a duration.
const SCHEMA: u8 = 1;
const DURATION: u8 = 18;
/// Ticks of a second by the unit of a duration.
const TICKS: [i64; 4] = [1, 1000, 1_000_000, 1_000_000_000];
/// What goes before a message.
const CONTINUATION: [u8; 4] = [0xff; 4];
/// Keys under which writers leave a unit.
const UNIT_KEYS: [&str; 3] = ["unit", "units", "Unit"];

/// A table of a flat buffer: the bytes and its place in them.
#[derive(Clone, Copy)]
struct Table<'a>(&'a [u8], usize);

fn u16_at(bytes: &[u8], at: usize) -> Option<usize> {
    Some(usize::from(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?)))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<usize> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?) as usize)
}

impl<'a> Table<'a> {
    /// Place of a field; `None` where it is left at its default.
    fn field_offset(self, field: usize) -> Option<usize> {
        let Self(bytes, at) = self;
        let back = i32::from_le_bytes(*bytes.get(at..)?.first_chunk()?);
        let layout = usize::try_from(i64::try_from(at).ok()? - i64::from(back)).ok()?;
        let entry = 4 + 2 * field;
        let offset = (entry < u16_at(bytes, layout)?).then(|| u16_at(bytes, layout + entry))??;
        (offset != 0).then(|| at.checked_add(offset))?
    }

    fn byte(self, field: usize) -> Option<u8> {
        self.0.get(self.field_offset(field)?).copied()
    }

    /// Where a field leads to.
    fn target(self, field: usize) -> Option<usize> {
        let place = self.field_offset(field)?;
        place.checked_add(u32_at(self.0, place)?)
    }

    fn table(self, field: usize) -> Option<Self> {
        Some(Self(self.0, self.target(field)?))
    }

    fn tables(self, field: usize) -> Option<impl Iterator<Item = Self>> {
        let bytes = self.0;
        let start = self.target(field)?;
        let count = u32_at(bytes, start)?.min(bytes.len() / 4);
        Some((0..count).filter_map(move |index| {
            let place = start + 4 + 4 * index;
            Some(Self(bytes, place.checked_add(u32_at(bytes, place)?)?))
        }))
    }

    fn text(self, field: usize) -> Option<&'a str> {
        let start = self.target(field)?;
        let length = u32_at(self.0, start)?;
        std::str::from_utf8(self.0.get(start + 4..)?.get(..length)?).ok()
    }
}

/// The fields of a schema as it is left in the notes of a file.
pub fn fields(encoded: &str) -> Option<Vec<Field>> {
    let bytes = BASE64_STANDARD.decode(encoded).ok()?;
    let message = match bytes.strip_prefix(&CONTINUATION) {
        Some(rest) => rest.get(4..)?,
        None => bytes.get(4..)?,
    };
    let message = Table(message, u32_at(message, 0)?);
    // Message: version, type and place of the header. Schema: byte order, fields.
    let schema = (message.byte(1)? == SCHEMA).then(|| message.table(2))??;
    Some(schema.tables(1)?.filter_map(field).collect())
}

/// Field: name, whether it may be null, type, its table, dictionary, children, notes.
fn field(table: Table<'_>) -> Option<Field> {
    let name = table.text(0)?.to_owned();
    let is_duration = table.byte(2) == Some(DURATION);
    // A duration without a unit is in the default, milliseconds.
    let ticks = is_duration
        .then(|| table.table(3)?.byte(0).map_or(Some(TICKS[1]), |unit| TICKS.get(usize::from(unit)).copied()));
    let unit = table
        .tables(6)
        .and_then(|mut notes| notes.find_map(|note| UNIT_KEYS.contains(&note.text(0)?).then(|| note.text(1))?));
    Some(Field { name, unit: unit.map(str::to_owned), ticks: ticks.flatten() })
}
