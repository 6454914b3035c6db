//! Recordings of FlySight 2: rows of several tables in one text, each row headed by the name of its table.
//!
//! `$COL,IMU,time,wx,...` names the columns of a table and `$UNIT,IMU,s,deg/s,...` their units; `$IMU,59970.4,...` is one of its rows. Source:
//! FlySight 2, description of its files.

use std::collections::BTreeMap;

use crate::load::formats::text_layout::{Separator, TextLayout};

/// First bytes of a file.
const SIGNATURE: &[u8] = b"$FLYS,";

/// Whether a text begins as such a recording.
pub(crate) fn has_signature(contents: &[u8]) -> bool {
    contents.starts_with(SIGNATURE)
}

/// Texts about the recorder, each with the line it stands in.
type Notes = Vec<(String, String)>;

/// One table: names and units of its columns, its rows and the line of the first.
#[derive(Default)]
struct Rows {
    names: Vec<String>,
    units: Vec<Option<String>>,
    lines: Vec<u8>,
    first: usize,
}

/// Name, layout and rows of every table that has rows, and the lines about the recorder.
pub(crate) fn split_tables(contents: &[u8]) -> (Vec<(String, TextLayout, Vec<u8>)>, Notes) {
    let mut tables: BTreeMap<String, Rows> = BTreeMap::new();
    let mut notes = Vec::new();
    for (index, line) in contents.split(|&byte| byte == b'\n').enumerate() {
        let line = line.trim_ascii();
        let Some((head, rest)) = split_at_comma(line.strip_prefix(b"$").unwrap_or_default()) else { continue };
        match head {
            b"COL" | b"UNIT" => {
                let text = String::from_utf8_lossy(rest);
                let Some((name, cells)) = text.split_once(',') else { continue };
                let cells = cells.split(',').map(|cell| cell.trim().to_owned());
                let table = tables.entry(name.to_owned()).or_default();
                if head == b"COL" {
                    table.names = cells.collect();
                } else {
                    table.units = cells.map(|cell| (!cell.is_empty()).then_some(cell)).collect();
                }
            }
            b"VAR" | b"FLYS" => notes.push((format!("line {}", index + 1), String::from_utf8_lossy(rest).into_owned())),
            _ => {
                if let Some(table) = std::str::from_utf8(head).ok().and_then(|name| tables.get_mut(name)) {
                    if table.lines.is_empty() {
                        table.first = index + 1;
                    }
                    table.lines.extend_from_slice(rest);
                    table.lines.push(b'\n');
                }
            }
        }
    }
    let with_rows = tables.into_iter().filter(|(_, table)| !table.lines.is_empty());
    let laid_out = with_rows.map(|(name, table)| {
        let layout = TextLayout {
            separator: Separator::Byte(b','),
            decimal_comma: false,
            columns: table.names.len(),
            has_open_end: false,
            names: table.names,
            units: table.units,
            data_at: 0,
            data_line: table.first,
            notes: Vec::new(),
        };
        (name, layout, table.lines)
    });
    (laid_out.collect(), notes)
}

/// What stands before and behind the first comma.
fn split_at_comma(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let at = line.iter().position(|&byte| byte == b',')?;
    Some((&line[..at], &line[at + 1..]))
}

#[cfg(test)]
mod tests {
    use crate::load::probe_of;

    #[test]
    fn every_table_is_a_source_with_its_own_time() {
        let rows: String = (0..40)
            .map(|k| {
                let time = 59_970.0 + 0.01 * f64::from(k);
                let baro = if k % 4 == 0 { format!("$BARO,{time:.3},94321.5,25.1\n") } else { String::new() };
                format!("$IMU,{time:.3},1.5,-2.5,0.5\n{baro}")
            })
            .collect();
        let probe = probe_of(&format!(
            "$FLYS,1\n$VAR,FIRMWARE_VER,v2023\n$COL,BARO,time,pressure,temperature\n$UNIT,BARO,s,Pa,deg C\n$COL,IMU,time,wx,wy,wz\n\
             $UNIT,IMU,s,deg/s,deg/s,deg/s\n$COL,VBAT,time,voltage\n$DATA\n{rows}$IMU,5997\n"
        ));
        let names: Vec<&str> = probe.sources.iter().map(|source| source.name.as_str()).collect();
        assert_eq!(names, ["BARO", "IMU"]);
        assert_eq!(probe.sources[0].clocks[0].rate_hz.round(), 25.0);
        assert_eq!(probe.sources[0].channels[1].unit.as_deref(), Some("Pa"));
        assert_eq!(probe.sources[1].channels[2].values()[..40], [-2.5; 40]);
    }
}
