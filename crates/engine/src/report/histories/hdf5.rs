//! Time histories as one HDF5 file, every data set with its unit.
//!
//! The library forms a file in memory, where it takes three times its size. It is given one value per data set instead, which makes
//! every header as long as it will be; then the lengths and addresses are put in, and the values are written behind the headers. The
//! file is the same to the byte.

use std::borrow::Cow;
use std::io::{BufWriter, Write};
use std::ops::Range;
use std::path::Path;

use hdf5_core::jenkins_lookup3;
use hdf5_writer::{AttributeBuilder, DatasetBuilder, Hdf5Builder, WriteOptions};

use super::{History, Values};
use crate::report::{ReportError, file_error};

/// Bytes of one value.
const VALUE: usize = size_of::<f64>();

/// Writes all histories; each data set has the attributes `units` and `description`.
pub fn write(histories: &[History<'_>], title: &str, path: &Path) -> Result<(), ReportError> {
    let formed = |error: &dyn std::fmt::Display| ReportError::Form { what: "histories.h5", reason: error.to_string() };
    let columns = columns(histories);
    let mut headers = encoded(&columns, title, |_| Cow::Borrowed(&[0.0])).map_err(|error| formed(&error))?;
    headers.truncate(headers.len().saturating_sub(VALUE * columns.len()));
    let lengths = columns.iter().map(|column| column.values.len());
    lengthen(&mut headers, lengths).ok_or_else(|| formed(&"its headers are not as expected"))?;
    put_values(path, &headers, &columns).map_err(file_error(path))
}

fn put_values(path: &Path, headers: &[u8], columns: &[Column<'_>]) -> std::io::Result<()> {
    let mut file = BufWriter::new(std::fs::File::create(path)?);
    file.write_all(headers)?;
    let mut bytes = Vec::new();
    for column in columns {
        bytes.clear();
        bytes.extend(column.values.iter().flat_map(f64::to_le_bytes));
        file.write_all(&bytes)?;
    }
    file.flush()
}

/// A data set of the file.
struct Column<'a> {
    path: String,
    unit: &'a str,
    description: &'a str,
    values: Values<'a>,
}

/// All data sets, in the order of their values in the file.
fn columns<'a>(histories: &'a [History<'_>]) -> Vec<Column<'a>> {
    let mut columns = Vec::new();
    for history in histories {
        let group = &history.group;
        let time = |time: &String| Column {
            path: format!("{group}/{time}"),
            unit: "s",
            description: "time",
            values: Values::Numbers(Cow::Borrowed(&history.time_s)),
        };
        columns.extend(history.time_paths.iter().map(time));
        columns.extend(history.columns.iter().map(|column| Column {
            path: format!("{group}/{}", column.path),
            unit: &column.unit,
            description: &column.description,
            values: column.values.borrowed(),
        }));
    }
    columns
}

/// The file as the library has it, with `values` of each data set.
fn encoded<'a>(
    columns: &[Column<'a>],
    title: &str,
    values: impl for<'c> Fn(&'c Column<'a>) -> Cow<'c, [f64]>,
) -> Result<Vec<u8>, hdf5_writer::Error> {
    let mut builder = Hdf5Builder::new()
        .attribute(AttributeBuilder::fixed_string("title", if title.is_empty() { "-" } else { title }))
        .attribute(AttributeBuilder::fixed_string("app", crate::PROGRAM));
    for column in columns {
        let values = values(column);
        let data_set = DatasetBuilder::typed_data(column.path.clone(), vec![values.len() as u64], &values)?
            .attribute(AttributeBuilder::fixed_string("units", column.unit))
            .attribute(AttributeBuilder::fixed_string("description", column.description));
        builder = builder.dataset(data_set);
    }
    builder.into_plan()?.encode(WriteOptions::default())
}

/// Where the superblock of version 2 has the end of the file, and where it ends itself with its checksum (HDF5 file format 3.0, II.A).
const END_OF_FILE: usize = 28;
const SUPERBLOCK: Range<usize> = 0..44;
/// Bytes to which headers are aligned.
const ALIGNMENT: usize = 8;
/// Types of the messages of an object header (HDF5 file format 3.0, IV.A.2), and where a length lies in the one, address and size in the
/// other.
const DATASPACE: u8 = 1;
const LAYOUT: u8 = 8;
const LENGTH: usize = 4;
const ADDRESS: usize = 2;
const SIZE: usize = 10;
/// Address of what takes no space.
const NOWHERE: u64 = u64::MAX;

/// Gives the data sets of one value, of which the headers are, `lengths` values that follow one another behind the headers; `None`
/// where the headers are of another form.
fn lengthen(headers: &mut [u8], mut lengths: impl Iterator<Item = usize>) -> Option<()> {
    let mut address = headers.len() as u64;
    let mut at = (SUPERBLOCK.end + 4).next_multiple_of(ALIGNMENT);
    while at < headers.len() {
        let header = object_header(headers, at)?;
        let (mut space, mut layout) = (None, None);
        let mut message = header.messages.start;
        while message < header.messages.end {
            let size = usize::from(u16::from_le_bytes(headers.get(message + 1..message + 3)?.try_into().ok()?));
            match *headers.get(message)? {
                DATASPACE => space = Some(message + 4),
                LAYOUT => layout = Some(message + 4),
                _ => {}
            }
            message += 4 + size;
        }
        if let (Some(space), Some(layout)) = (space, layout) {
            let length = lengths.next()? as u64;
            let size = length * VALUE as u64;
            put(headers, space + LENGTH, length)?;
            put(headers, layout + ADDRESS, if size > 0 { address } else { NOWHERE })?;
            put(headers, layout + SIZE, size)?;
            seal(headers, at..header.messages.end)?;
            address += size;
        }
        at = (header.messages.end + 4).next_multiple_of(ALIGNMENT);
    }
    put(headers, END_OF_FILE, address)?;
    seal(headers, SUPERBLOCK)?;
    lengths.next().is_none().then_some(())
}

/// An object header of version 2 that has neither times nor limits of attributes.
struct ObjectHeader {
    /// Where its messages lie; its checksum follows.
    messages: Range<usize>,
}

fn object_header(file: &[u8], at: usize) -> Option<ObjectHeader> {
    let [b'O', b'H', b'D', b'R', 2, flags] = *file.get(at..at + 6)? else { return None };
    // The flags say how many bytes the size has.
    let width = match flags {
        0..=3 => 1 << flags,
        _ => return None,
    };
    let mut size = [0; 8];
    size.get_mut(..width)?.copy_from_slice(file.get(at + 6..at + 6 + width)?);
    let start = at + 6 + width;
    let end = start.checked_add(usize::try_from(u64::from_le_bytes(size)).ok()?)?;
    (end <= file.len()).then_some(ObjectHeader { messages: start..end })
}

/// Puts a number at `at`.
fn put(file: &mut [u8], at: usize, value: u64) -> Option<()> {
    file.get_mut(at..at + 8)?.copy_from_slice(&value.to_le_bytes());
    Some(())
}

/// Puts the checksum of `range` behind it.
fn seal(file: &mut [u8], range: Range<usize>) -> Option<()> {
    let checksum = jenkins_lookup3(file.get(range.clone())?);
    file.get_mut(range.end..range.end + 4)?.copy_from_slice(&checksum.to_le_bytes());
    Some(())
}

#[cfg(test)]
mod tests {
    use super::super::HistoryColumn;
    use super::*;

    fn column(path: &str, values: Vec<f64>) -> HistoryColumn<'static> {
        HistoryColumn {
            path: path.to_owned(),
            unit: "rad/s".to_owned(),
            description: "d".repeat(300),
            values: Values::Numbers(Cow::Owned(values)),
        }
    }

    fn history(group: &str, samples: u32) -> History<'static> {
        History {
            group: group.to_owned(),
            kind: "path".to_owned(),
            time_paths: vec!["path/time".to_owned(), "innovations/time".to_owned()],
            time_s: Cow::Owned((0..samples).map(|k| f64::from(k) / 50.0).collect()),
            columns: vec![
                column("path/states/p", (0..samples).map(|k| f64::from(k).sin()).collect()),
                column("innovations/p", vec![f64::NAN; samples as usize]),
            ],
        }
    }

    #[test]
    fn a_file_written_value_by_value_is_that_of_the_library_to_the_byte() {
        let histories = [history("elevator 1", 700), history("empty", 0), history("é", 1)];
        let folder = tempfile::tempdir().unwrap();
        for (histories, title) in [(&histories[..], "a flight"), (&histories[..1], ""), (&[], "none")] {
            let path = folder.path().join("histories.h5");
            write(histories, title, &path).unwrap();
            let whole = encoded(&columns(histories), title, |column| column.values.all()).unwrap();
            assert!(std::fs::read(&path).unwrap() == whole, "{title}: {} histories", histories.len());
        }
    }
}
