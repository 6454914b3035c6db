//! The file of a source put in order when its recording ends.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use csv::StringRecord;

use crate::keep;

/// Cuts off a last line that a full disk left without its end; the rest outlasts a loss of power.
pub fn cut_to_whole_lines(path: &Path) -> io::Result<()> {
    /// Bytes looked at, from the end: more than the longest line.
    const TAIL: u64 = 1 << 20;
    let mut file = OpenOptions::new().read(true).write(true).open(path)?;
    let length = file.metadata()?.len();
    let start = length.saturating_sub(TAIL);
    let mut tail = Vec::new();
    file.seek(SeekFrom::Start(start))?;
    file.read_to_end(&mut tail)?;
    if let Some(end) = tail.iter().rposition(|byte| *byte == b'\n').filter(|end| end + 1 < tail.len()) {
        file.set_len(start + end as u64 + 1)?;
    }
    file.sync_all()
}

/// Puts the rows of a table in the order of their times; those of one time become one row, whose empty cells the later fills.
pub fn put_in_order(path: &Path, time_s: &dyn Fn(Vec<f64>) -> Option<f64>) -> Result<(), Box<dyn std::error::Error>> {
    let mut table = csv::ReaderBuilder::new().from_reader(File::open(path)?);
    let header = table.headers()?.clone();
    let mut rows: Vec<(f64, StringRecord)> = Vec::new();
    for record in table.records() {
        let record = record?;
        let values = record.iter().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        // A row without a time is of no use in a session.
        if let Some(time_s) = time_s(values).filter(|time_s| time_s.is_finite()) {
            rows.push((time_s, record));
        }
    }
    rows.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    rows.dedup_by(|(later_s, later), (earlier_s, earlier)| {
        let is_same = later_s == earlier_s;
        if is_same {
            *earlier = earlier.iter().zip(later.iter()).map(|(a, b)| if a.is_empty() { b } else { a }).collect();
        }
        is_same
    });
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(&header)?;
    rows.iter().try_for_each(|(_, record)| writer.write_record(record))?;
    keep::replace(path, &writer.into_inner()?)?;
    Ok(())
}
