//! What a recording holds: sources, channels, clocks.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use super::clock::Clock;

/// File format, recognised by content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MATLAB level 5 MAT-file (version 7 and earlier).
    MatV5,
    /// MATLAB version 7.3 MAT-file, an HDF5 file.
    MatV73,
    /// Hierarchical Data Format 5.
    Hdf5,
    /// Text with a separator between cells: comma, semicolon or tab.
    DelimitedText,
    /// Text in columns separated by blanks.
    TextColumns,
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
    /// Folder with one delimited text file per channel.
    Folder,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::MatV5 => "MAT v5",
            Self::MatV73 => "MAT v7.3",
            Self::Hdf5 => "HDF5",
            Self::DelimitedText => "delimited text",
            Self::TextColumns => "text columns",
            Self::ULog => "ULog",
            Self::DataFlash => "DataFlash",
            Self::Tdms => "TDMS",
            Self::Mdf4 => "MDF 4",
            Self::Mcap => "MCAP",
            Self::Parquet => "Parquet",
            Self::Folder => "folder of CSV files",
        })
    }
}

/// What a file or folder holds.
#[derive(Clone, Debug)]
pub struct Probe {
    /// File or folder.
    pub path: PathBuf,
    /// Its format.
    pub format: Format,
    /// Recorders, groups, structs or tables found in it.
    pub sources: Vec<Source>,
    /// Findings, one line each.
    pub warnings: Vec<String>,
}

/// One recorder, group, struct or table: channels that share a name space and usually a clock.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// Name: group path, struct name, topic, or the file's name without its extension.
    pub name: String,
    /// Channels in file order.
    pub channels: Vec<ChannelInfo>,
    /// Time vectors found, see [`ChannelInfo::clock`].
    pub clocks: Vec<Clock>,
    /// Text carried along: strings, attributes, metadata lines.
    pub notes: Vec<(String, String)>,
    /// First time, s, where the file gives a start time and a rate instead of a time vector.
    pub start_time_s: Option<f64>,
    /// Rate, Hz, that goes with it.
    pub sample_rate_hz: Option<f64>,
    /// Index of the channel that is the first column of a text table.
    pub(super) first_column: Option<usize>,
    /// Column that is called or written as a time and was not understood, with its first cell.
    pub(super) unread_time: Option<(String, String)>,
}

/// One channel as recorded.
#[derive(Clone, Debug)]
pub struct ChannelInfo {
    /// Name within its source; column `i` (from 0) of a matrix `M` is `M[i]`.
    pub name: String,
    /// Unit as recorded, not interpreted.
    pub unit: Option<String>,
    /// Number of samples.
    pub samples: usize,
    /// How many of them are NaN or infinite; `None` where the values have not been read yet.
    pub non_finite: Option<usize>,
    /// Index into the source's clocks; `None` for a channel without a time vector of its length.
    pub clock: Option<usize>,
    /// Whether it is a time vector itself.
    pub is_time: bool,
    /// Whether it was written as times of day.
    pub(super) is_time_of_day: bool,
    /// The samples, or where they are.
    pub(super) data: Data,
}

/// Samples in memory, or their place in the file.
#[derive(Clone, Debug)]
pub(super) enum Data {
    /// Samples as recorded.
    Values(Arc<[f64]>),
    /// Not read yet.
    Stored(Stored),
}

/// Place of a channel in an HDF5 file.
#[derive(Clone, Debug, Default)]
pub(super) struct Stored {
    /// Path of the data set.
    pub object: String,
    /// Which of its columns.
    pub column: usize,
}

/// `text` of a file with its line ends and other control characters replaced, to stand in a message.
pub(super) fn one_line(text: &str) -> String {
    text.replace(char::is_control, "\u{fffd}")
}

impl ChannelInfo {
    /// A channel whose samples are in memory.
    pub(super) fn new(name: impl Into<String>, unit: Option<String>, values: Vec<f64>) -> Self {
        let mut channel = Self::stored(name, unit, values.len(), Stored::default());
        channel.set(values.into());
        channel
    }

    /// A channel whose samples are still in the file.
    pub(super) fn stored(name: impl Into<String>, unit: Option<String>, samples: usize, stored: Stored) -> Self {
        let name = one_line(&name.into());
        let (is_time, is_time_of_day) = (false, false);
        Self { name, unit, samples, non_finite: None, clock: None, is_time, is_time_of_day, data: Data::Stored(stored) }
    }

    /// Puts the samples in.
    pub(super) fn set(&mut self, values: Arc<[f64]>) {
        self.samples = values.len();
        self.non_finite = Some(values.iter().filter(|value| !value.is_finite()).count());
        self.data = Data::Values(values);
    }

    /// Samples as recorded; empty while they are still in the file.
    pub fn values(&self) -> &[f64] {
        match &self.data {
            Data::Values(values) => values,
            Data::Stored(_) => &[],
        }
    }

    /// Variable and column of a name `M[i]`.
    pub(super) fn column(&self) -> Option<(&str, usize)> {
        let (variable, index) = self.name.strip_suffix(']')?.rsplit_once('[')?;
        Some((variable, index.parse().ok()?))
    }
}

impl Source {
    /// An empty source called `name`.
    pub(super) fn new(name: impl Into<String>) -> Self {
        Self { name: one_line(&name.into()), ..Self::default() }
    }

    /// Adds a matrix given column by column; a single column is a plain channel.
    pub(super) fn push_columns(&mut self, name: &str, unit: Option<&str>, columns: Vec<Vec<f64>>) {
        let single = columns.len() == 1;
        for (index, values) in columns.into_iter().enumerate() {
            let name = if single { name.to_owned() } else { format!("{name}[{index}]") };
            self.channels.push(ChannelInfo::new(name, unit.map(str::to_owned), values));
        }
    }
}
