//! Formats of recorders and programs that are known and not read: a refused file is named, with what makes a recording of it.

use crate::load::error::LoadError;
use crate::load::mavlink;

/// A format by the bytes that its files have at an offset.
struct Unsupported {
    name: &'static str,
    marks: &'static [&'static [u8]],
    at: usize,
    fix: &'static str,
}

/// A format by the bytes that its files begin with.
const fn at_start(name: &'static str, marks: &'static [&'static [u8]], fix: &'static str) -> Unsupported {
    Unsupported { name, marks, at: 0, fix }
}

const UNPACK: &str = "unpack it";

/// Formats with a mark at a fixed place.
const MARKED: &[Unsupported] = &[
    at_start("a ROS 1 bag", &[b"#ROSBAG V"], "convert it to MCAP: mcap convert"),
    at_start("an SQLite database", &[b"SQLite format 3\0"], "convert a ROS 2 bag to MCAP: ros2 bag convert"),
    at_start("NetCDF 3", &[b"CDF\x01", b"CDF\x02", b"CDF\x05"], "convert it to NetCDF 4: nccopy -k nc4"),
    Unsupported { at: 8, ..at_start("a Garmin FIT file", &[b".FIT"], "convert it to CSV: FitCSVTool") },
    at_start("IRIG 106 Chapter 10", &[b"\x25\xeb"], "export it with its TMATS as MDF 4, MAT or CSV"),
    at_start("a NumPy array", &[b"\x93NUMPY"], "save it as CSV or MAT: scipy.io.savemat"),
    at_start("a Python pickle", &[b"\x80\x03", b"\x80\x04\x95", b"\x80\x05\x95"], "save it as Parquet"),
    at_start("an Arrow or Feather file", &[b"ARROW1"], "save it as Parquet"),
    at_start("Spektrum telemetry", &[b"\xff\xff\xff\xff"], "export it as CSV"),
    at_start("an old Excel workbook", &[b"\xd0\xcf\x11\xe0"], "save its sheet as CSV"),
    at_start("an archive or an Excel workbook", &[b"PK\x03\x04"], "unpack it, or save its sheet as CSV"),
    at_start("a gzip file", &[b"\x1f\x8b"], UNPACK),
    at_start("an xz file", &[b"\xfd7zXZ"], UNPACK),
    at_start("a zstd file", &[b"\x28\xb5\x2f\xfd"], UNPACK),
    at_start("a bzip2 file", &[b"BZh"], UNPACK),
    at_start("a 7z archive", &[b"7z\xbc\xaf\x27\x1c"], UNPACK),
    Unsupported { at: 4, ..at_start("a video", &[b"ftyp"], "extract its telemetry as CSV") },
    at_start("a PDF document", &[b"%PDF"], "give the table it was made of"),
];

/// What Betaflight and INAV write first in a log.
const BLACKBOX: &[u8] = b"H Product:Blackbox";
/// The date in a log of a gliding recorder, which begins with its maker.
const IGC_DATE: &[u8] = b"\nHFDTE";

/// `error` with the name of the format of a file that begins with `head`, where nothing in it was recognised.
pub(crate) fn name_format(error: LoadError, head: &[u8]) -> LoadError {
    match error {
        LoadError::NotRecognised { path, reason } => match find(head) {
            Some((name, fix)) => LoadError::Unsupported { path, what: name.to_owned(), fix },
            None => LoadError::NotRecognised { path, reason },
        },
        other => other,
    }
}

/// Name of a format and what to do with its files.
fn find(head: &[u8]) -> Option<(&'static str, &'static str)> {
    let has = |mark: &[u8]| head.windows(mark.len()).any(|bytes| bytes == mark);
    if mavlink::is_log(head) {
        let fix = "give the log of the autopilot (.bin, .ulg), or follow it live";
        return Some(("a MAVLink telemetry log", fix));
    }
    if has(BLACKBOX) {
        return Some(("a Betaflight or INAV log", "convert it to CSV: blackbox_decode"));
    }
    if head.first() == Some(&b'A') && has(IGC_DATE) {
        return Some(("an IGC log", "give a recording with angular rates and specific forces"));
    }
    let is_of = |format: &&Unsupported| {
        head.get(format.at..).is_some_and(|rest| format.marks.iter().any(|mark| rest.starts_with(mark)))
    };
    if let Some(format) = MARKED.iter().find(is_of) {
        return Some((format.name, format.fix));
    }
    match head.trim_ascii_start() {
        [b'<', ..] => Some(("XML", "give the table of its numbers as CSV")),
        [b'{', ..] | [b'[', b'{', ..] => Some(("JSON", "convert it to CSV")),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    fn named(head: &[u8]) -> String {
        let error = LoadError::NotRecognised { path: PathBuf::from("flight"), reason: "unknown".to_owned() };
        name_format(error, head).to_string()
    }

    #[test]
    fn a_format_that_is_not_read_is_named_with_what_to_do() {
        for (head, name) in [
            (&b"#ROSBAG V2.0\n"[..], "ROS 1 bag"),
            (b"\x0e\x20\x4b\x08\x22\0\0\0.FIT", "FIT"),
            (b"H Product:Blackbox flight data recorder by Nicholas Sherlock\n", "Betaflight"),
            (b"AXCS123\r\nHFDTE280709\r\n", "IGC"),
            (b"<?xml version=\"1.0\"?>", "XML"),
            (b"PK\x03\x04", "Excel"),
        ] {
            let text = named(head);
            assert!(text.contains(name) && text.contains("is not read; "), "{text}");
        }
        assert!(named(b"Anything else").contains("not a recording"));
    }
}
