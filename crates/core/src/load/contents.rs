//! What a recording holds: sources, channels, clocks.

use std::path::PathBuf;
use std::sync::Arc;

use crate::load::clock::Clock;
use crate::load::format::Format;
use crate::message::Message;

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
    pub warnings: Vec<Message>,
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
    pub(crate) first_column: Option<usize>,
    /// Column that is called or written as a time and was not understood, with its first cell.
    pub(crate) unread_time: Option<(String, String)>,
}

/// One channel as recorded.
#[derive(Clone, Debug)]
pub struct ChannelInfo {
    /// Name within its source; column `i` (from 0) of a matrix `M` is `M[i]`.
    pub name: String,
    /// The name without what all channels of the source begin or end with, where that hides it.
    pub(crate) label: Option<String>,
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
    pub(crate) is_time_of_day: bool,
    /// The samples, or where they are.
    pub(crate) data: Data,
}

/// Samples in memory, or their place in the file.
#[derive(Clone, Debug)]
pub(crate) enum Data {
    /// Samples as recorded.
    Values(Arc<[f64]>),
    /// Not read yet.
    Stored(Stored),
}

/// Place of a channel in an HDF5 file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stored {
    /// Path of the data set.
    pub object: String,
    pub column: usize,
}

/// `text` of a file with its line ends and other control characters replaced, to stand in a message.
pub(crate) fn one_line(text: &str) -> String {
    text.replace(char::is_control, "\u{fffd}")
}

impl ChannelInfo {
    /// A channel whose samples are in memory.
    pub(crate) fn new(name: impl Into<String>, unit: Option<String>, values: Vec<f64>) -> Self {
        Self::shared(name, unit, values.into())
    }

    /// The same without a copy.
    pub(crate) fn shared(name: impl Into<String>, unit: Option<String>, values: Arc<[f64]>) -> Self {
        let mut channel = Self::stored(name, unit, values.len(), Stored::default());
        channel.set(values);
        channel
    }

    /// A channel whose samples are still in the file.
    pub(crate) fn stored(name: impl Into<String>, unit: Option<String>, samples: usize, stored: Stored) -> Self {
        let name = one_line(&name.into());
        let (is_time, is_time_of_day) = (false, false);
        let data = Data::Stored(stored);
        Self { name, label: None, unit, samples, non_finite: None, clock: None, is_time, is_time_of_day, data }
    }

    /// The name by which the channel is recognised.
    pub(crate) fn label(&self) -> &str {
        self.label.as_deref().unwrap_or(&self.name)
    }

    /// Puts the samples in.
    pub(crate) fn set(&mut self, values: Arc<[f64]>) {
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
    pub(crate) fn column(&self) -> Option<(&str, usize)> {
        let (variable, index) = self.name.strip_suffix(']')?.rsplit_once('[')?;
        Some((variable, index.parse().ok()?))
    }
}

impl Source {
    /// An empty source called `name`.
    pub(crate) fn new(name: impl Into<String>) -> Self {
        Self { name: one_line(&name.into()), ..Self::default() }
    }

    /// Whether it has a channel called `name`.
    pub(crate) fn has_channel(&self, name: &str) -> bool {
        self.channels.iter().any(|channel| channel.name == name)
    }

    /// Adds a matrix given column by column; a single column is a plain channel.
    pub(crate) fn push_columns(&mut self, name: &str, unit: Option<&str>, columns: Vec<Arc<[f64]>>) {
        let single = columns.len() == 1;
        for (index, values) in columns.into_iter().enumerate() {
            let name = if single { name.to_owned() } else { format!("{name}[{index}]") };
            self.channels.push(ChannelInfo::shared(name, unit.map(str::to_owned), values));
        }
    }
}
