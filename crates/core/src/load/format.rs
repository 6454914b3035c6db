//! File formats that are read: one row for each, with the bytes it is recognised by and the endings its files usually have.

use std::fmt;

/// File format, recognised by content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MATLAB level 5 MAT-file (version 7 and earlier).
    MatV5,
    /// MATLAB version 7.3 MAT-file, an HDF5 file.
    MatV73,
    /// Hierarchical Data Format 5.
    Hdf5,
    /// PX4 flight log.
    ULog,
    /// ArduPilot flight log, binary or as text.
    DataFlash,
    /// LabVIEW measurement file.
    Tdms,
    /// ASAM measurement file, version 4.
    Mdf4,
    /// Recording of messages by topic.
    Mcap,
    /// Apache Parquet table.
    Parquet,
    /// Text with a separator between cells: comma, semicolon or tab.
    DelimitedText,
    /// Text in columns separated by blanks.
    TextColumns,
    /// Folder with one delimited text file per channel.
    Folder,
}

/// What is known of a file format before a file of it is read.
#[expect(missing_docs, reason = "names say it")]
pub struct FormatInfo {
    pub format: Format,
    pub name: &'static str,
    /// Endings that its files usually have, without the dot.
    pub endings: &'static [&'static str],
    /// Bytes that a file of it has at one of the offsets `at`; none for tables of text and folders. Blanks do not count in a mark with commas.
    pub marks: &'static [&'static [u8]],
    /// Offsets of the marks.
    pub at: &'static [usize],
    /// Name of its fuzz target, and folder of its seeds.
    pub fuzz_target: &'static str,
}

/// Row without marks and endings, from which the rows below differ.
const PLAIN: FormatInfo =
    FormatInfo { format: Format::Folder, name: "", endings: &[], marks: &[], at: &[0], fuzz_target: "" };

/// Every format that is read, in the order in which files are tried: a MAT-file of version 7.3 is also an HDF5 file.
///
/// To add one: its variant and row here, its reader in `formats`, and the line in `formats/recognise.rs` that calls the reader.
pub const FORMATS: &[FormatInfo] = &[
    FormatInfo {
        format: Format::MatV73,
        name: "MAT v7.3",
        endings: &["mat"],
        marks: &[b"MATLAB 7.3"],
        fuzz_target: "hdf5",
        ..PLAIN
    },
    FormatInfo {
        format: Format::Hdf5,
        name: "HDF5",
        endings: &["h5", "hdf5", "nc"],
        marks: &[b"\x89HDF\r\n\x1a\n"],
        // The superblock stands behind a user block where there is one.
        at: &[0, 512, 1024, 2048],
        fuzz_target: "hdf5",
    },
    FormatInfo {
        format: Format::MatV5,
        name: "MAT v5",
        endings: &["mat"],
        // Version 1.0, then the mark of the byte order.
        marks: &[&[0x00, 0x01, b'I', b'M'], &[0x01, 0x00, b'M', b'I']],
        at: &[124],
        fuzz_target: "mat",
    },
    FormatInfo {
        format: Format::ULog,
        name: "ULog",
        endings: &["ulg"],
        marks: &[b"ULog\x01\x12\x35"],
        fuzz_target: "ulog",
        ..PLAIN
    },
    FormatInfo {
        format: Format::DataFlash,
        name: "DataFlash",
        endings: &["bin", "log"],
        // The description of the description: binary, and as text with or without blanks.
        marks: &[b"\xa3\x95\x80\x80\x59FMT\0", b"FMT,128,89,FMT,"],
        fuzz_target: "dataflash",
        ..PLAIN
    },
    FormatInfo {
        format: Format::Tdms,
        name: "TDMS",
        endings: &["tdms"],
        marks: &[b"TDSm"],
        fuzz_target: "tdms",
        ..PLAIN
    },
    FormatInfo {
        format: Format::Mdf4,
        name: "MDF 4",
        endings: &["mf4", "mdf"],
        // Finished, and as a recorder leaves it that was switched off.
        marks: &[b"MDF     ", b"UnFinMF "],
        fuzz_target: "mdf4",
        ..PLAIN
    },
    FormatInfo {
        format: Format::Mcap,
        name: "MCAP",
        endings: &["mcap"],
        marks: &[b"\x89MCAP0\r\n"],
        fuzz_target: "mcap",
        ..PLAIN
    },
    FormatInfo {
        format: Format::Parquet,
        name: "Parquet",
        endings: &["parquet"],
        marks: &[b"PAR1"],
        fuzz_target: "parquet",
        ..PLAIN
    },
    FormatInfo {
        format: Format::DelimitedText,
        name: "delimited text",
        endings: &["csv", "tsv", "txt", "log", "vbo"],
        fuzz_target: "csv",
        ..PLAIN
    },
    FormatInfo {
        format: Format::TextColumns,
        name: "text columns",
        endings: &["txt", "dat", "out", "asc", "pos"],
        fuzz_target: "csv",
        ..PLAIN
    },
    FormatInfo { format: Format::Folder, name: "folder of CSV files", fuzz_target: "csv", ..PLAIN },
];

impl FormatInfo {
    /// Whether a file that begins with `head` is of this format by its marks.
    pub(crate) fn is_of(&self, head: &[u8]) -> bool {
        self.at
            .iter()
            .filter_map(|at| head.get(*at..))
            .any(|rest| self.marks.iter().any(|mark| begins_with(rest, mark)))
    }
}

/// Whether `bytes` begin with `mark`, blanks aside where that is a line of text.
fn begins_with(bytes: &[u8], mark: &[u8]) -> bool {
    let letters = bytes.iter().filter(|byte| **byte != b' ').take(mark.len());
    bytes.starts_with(mark) || (mark.contains(&b',') && letters.eq(mark))
}

impl Format {
    /// Its row.
    pub(crate) fn info(self) -> &'static FormatInfo {
        FORMATS.iter().find(|info| info.format == self).unwrap_or(&PLAIN)
    }

    /// The format whose mark stands in the first bytes of a file; text has none.
    pub(crate) fn of_head(head: &[u8]) -> Option<Self> {
        FORMATS.iter().find(|info| info.is_of(head)).map(|info| info.format)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.info().name)
    }
}

/// The names of all formats, as a sentence lists them.
pub(crate) fn readable() -> String {
    let files: Vec<&str> = FORMATS.iter().filter(|info| info.format != Format::Folder).map(|info| info.name).collect();
    format!("{} or a {}", files.join(", "), Format::Folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_is_recognised_as_its_format_and_no_other_and_every_format_has_a_row() {
        for info in FORMATS {
            for (mark, at) in info.marks.iter().flat_map(|mark| info.at.iter().map(move |at| (mark, at))) {
                let head = [&vec![b' '; *at], *mark].concat();
                assert_eq!(Format::of_head(&head), Some(info.format), "{} at {at}", info.name);
            }
            assert_eq!(info.format.to_string(), info.name);
            assert!(info.marks.is_empty() || !info.endings.is_empty(), "{}", info.name);
        }
        assert_eq!(Format::of_head(b"FMT, 128, 89, FMT, BBnNZ, Type"), Some(Format::DataFlash));
        assert_eq!(Format::of_head(b"time,alpha,q\n0.0,1.0,2.0\n"), None);
        assert!(readable().contains("MCAP, Parquet, ") && readable().ends_with(" or a folder of CSV files"));
    }
}
