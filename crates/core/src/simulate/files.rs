//! The files of a flight, as bytes.

use std::fmt::Write;

use hdf5_writer::{
    AttributeBuilder, DatasetBuilder, FILTER_DEFLATE, FILTER_SHUFFLE, FilterDescription, H5WriteElement, Hdf5Builder,
    Hdf5Writer, WriteOptions,
};

use super::recorder::Stream;
use super::run::Flight;
use super::truth::{COLUMNS, LOADING_COLUMNS};
use super::{SimulateError, summary};

/// A file of a flight.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedFile {
    /// Path below the flight's folder, with forward slashes.
    pub path: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// File of the data bus and the engine monitor.
const BUS_FILE: &str = "bus.h5";
/// File of the true histories.
const TRUTH_FILE: &str = "truth.h5";
/// File of the true scalars.
const SCALARS_FILE: &str = "truth.toml";
/// Samples of one compressed chunk.
const CHUNK: u64 = 1 << 16;
/// Deflate level.
const LEVEL: u32 = 4;

impl Flight {
    /// All files of the flight: `bus.h5` (data bus and engine monitor), `pod.csv`, one CSV per control sensor, `truth.h5` and
    /// `truth.toml`. The same flight gives the same bytes.
    ///
    /// # Errors
    /// [`SimulateError::Encode`] with the file.
    pub fn files(&self) -> Result<Vec<RecordedFile>, SimulateError> {
        let file = |path: &str, bytes: Vec<u8>| RecordedFile { path: path.to_owned(), bytes };
        let mut files =
            vec![file(BUS_FILE, encode(BUS_FILE, self.bus_file())?), file("pod.csv", self.pod_csv().into_bytes())];
        for stream in &self.control_sensors {
            files.push(file(&format!("sensor_{}.csv", stream.spec.name), self.control_csv(stream).into_bytes()));
        }
        files.push(file(TRUTH_FILE, encode(TRUTH_FILE, self.truth_file())?));
        files.push(file(SCALARS_FILE, summary::scalars(self)?.into_bytes()));
        Ok(files)
    }

    /// Writes all files into `folder`, which is made if need be.
    ///
    /// # Errors
    /// [`SimulateError::Encode`] with the file that could not be written.
    pub fn write(&self, folder: &std::path::Path) -> Result<(), SimulateError> {
        let refuse = |path: &std::path::Path, error: std::io::Error| SimulateError::Encode {
            file: path.display().to_string(),
            reason: error.to_string(),
        };
        std::fs::create_dir_all(folder).map_err(|error| refuse(folder, error))?;
        for file in self.files()? {
            let path = folder.join(&file.path);
            std::fs::write(&path, &file.bytes).map_err(|error| refuse(&path, error))?;
        }
        Ok(())
    }

    /// A group per stream with its time vector.
    fn bus_file(&self) -> Result<Hdf5Builder, hdf5_writer::Error> {
        let mut builder = Hdf5Builder::new().attribute(AttributeBuilder::fixed_string("flight", self.scenario.name));
        for stream in &self.bus {
            let group = stream.spec.name;
            builder = builder.group_attribute(group, AttributeBuilder::scalar("rate_hz", stream.spec.rate_hz)?);
            // Whole milliseconds, as the recorder stamps, compress to almost nothing.
            let stamps: Vec<u32> = stream.time_s.iter().map(|time| (time * 1000.0).round() as u32).collect();
            builder = builder.dataset(dataset(&format!("{group}/time"), &stamps, "ms")?);
            for (spec, values) in stream.spec.channels.iter().zip(&stream.values) {
                builder = builder.dataset(dataset(&format!("{group}/{}", spec.name), values, spec.unit)?);
            }
        }
        Ok(builder)
    }

    /// True histories; biases and clocks as attributes of their groups.
    fn truth_file(&self) -> Result<Hdf5Builder, hdf5_writer::Error> {
        let truth = &self.truth;
        let mut builder = Hdf5Builder::new()
            .attribute(AttributeBuilder::fixed_string("flight", self.scenario.name))
            .attribute(AttributeBuilder::scalar("seed", self.seed)?);
        builder = builder.dataset(dataset("motion/time", &truth.time_s, "s")?);
        for ((name, unit), values) in COLUMNS.iter().zip(&truth.columns) {
            builder = builder.dataset(dataset(&format!("motion/{name}"), values, unit)?);
        }
        builder = builder.dataset(dataset("loading/time", &truth.loading_time_s, "s")?);
        for ((name, unit), values) in LOADING_COLUMNS.iter().zip(&truth.loading) {
            builder = builder.dataset(dataset(&format!("loading/{name}"), values, unit)?);
        }
        builder = builder.dataset(dataset("errors/time", &[0.0, self.scenario.duration_s], "s")?);
        for (name, value, unit) in self.constant_errors() {
            builder = builder.dataset(dataset(&format!("errors/{name}"), &[value, value], unit)?);
        }
        for (name, clock) in summary::clocks() {
            let group = format!("clocks/{name}");
            builder = builder.dataset(dataset(&format!("{group}/offset"), &[clock.offset_s], "s")?);
            builder = builder.dataset(dataset(&format!("{group}/drift"), &[clock.drift], "-")?);
            let formula = AttributeBuilder::fixed_string("formula", "t_bus = offset + (1 + drift) t_own");
            builder = builder.group_attribute(group, formula);
        }
        Ok(builder)
    }

    /// The pod's log: milliseconds since power-up, UTC to the second.
    fn pod_csv(&self) -> String {
        let stream = &self.pod;
        let mut text = String::with_capacity(stream.time_s.len() * 48 + 128);
        text.push_str("time,UTC");
        stream.spec.channels.iter().for_each(|channel| _ = write!(text, ",{}", channel.name));
        text.push_str("\nms,");
        stream.spec.channels.iter().for_each(|channel| _ = write!(text, ",{}", channel.unit));
        text.push('\n');
        for (row, &stamp) in stream.time_s.iter().enumerate() {
            let utc = self.scenario.utc_start_s + stream.spec.clock.bus_s(stamp);
            let _ = write!(text, "{},{}", (stamp * 1000.0).round(), time_of_day(utc, 0));
            write_row(&mut text, stream, row);
        }
        text
    }

    /// A control sensor's export: metadata, header, units, then microseconds since power-up and its attitude.
    fn control_csv(&self, stream: &Stream) -> String {
        let mut text = String::with_capacity(stream.time_s.len() * 32 + 4096);
        let _ = writeln!(text, "# sensor: {}", stream.spec.name);
        let _ = writeln!(text, "# output rate: {} Hz", stream.spec.rate_hz);
        for (index, (flown, delay)) in self.manoeuvres.iter().zip(&self.start_delays_s).enumerate() {
            // The phone notes when the command was given, the sensor begins a little later.
            let from = flown.manoeuvre.recorded_s().0 + 0.2 * delay;
            let utc = self.scenario.utc_start_s + from - delay;
            let _ = writeln!(text, "# recording {} started: {}Z", index + 1, time_of_day(utc, 3));
        }
        text.push_str("time");
        stream.spec.channels.iter().for_each(|channel| _ = write!(text, ",{}", channel.name));
        text.push_str("\nus");
        stream.spec.channels.iter().for_each(|channel| _ = write!(text, ",{}", channel.unit));
        text.push('\n');
        for (row, &stamp) in stream.time_s.iter().enumerate() {
            let _ = write!(text, "{}", (stamp * 1e6).round());
            write_row(&mut text, stream, row);
        }
        text
    }
}

/// Appends the values of one row with the decimals their resolution needs.
fn write_row(text: &mut String, stream: &Stream, row: usize) {
    for (channel, values) in stream.spec.channels.iter().zip(&stream.values) {
        let decimals = if channel.resolution >= 0.1 { 1 } else { 2 };
        let _ = write!(text, ",{:.decimals$}", values[row]);
    }
    text.push('\n');
}

/// `hh:mm:ss` with decimals.
fn time_of_day(seconds: f64, decimals: u32) -> String {
    let ticks_per_s = 10u64.pow(decimals);
    let ticks = (seconds * ticks_per_s as f64).round().max(0.0) as u64;
    let (whole, fraction) = (ticks / ticks_per_s, ticks % ticks_per_s);
    let clock = format!("{:02}:{:02}:{:02}", whole / 3600 % 24, whole / 60 % 60, whole % 60);
    if decimals == 0 { clock } else { format!("{clock}.{fraction:0width$}", width = decimals as usize) }
}

/// A data set with its unit, shuffled and deflated when it is long.
fn dataset<T: H5WriteElement>(path: &str, values: &[T], unit: &str) -> Result<DatasetBuilder, hdf5_writer::Error> {
    /// Data sets shorter than this are not worth a filter.
    const SHORT: u64 = 64;
    let length = values.len() as u64;
    let dataset =
        DatasetBuilder::typed_data(path, vec![length], values)?.attribute(AttributeBuilder::fixed_string("unit", unit));
    if length < SHORT {
        return Ok(dataset);
    }
    let filter = |id, client_data| FilterDescription { id, name: None, client_data };
    Ok(dataset
        .chunked(vec![length.min(CHUNK)])
        .filter(filter(FILTER_SHUFFLE, vec![size_of::<T>() as u32]))
        .filter(filter(FILTER_DEFLATE, vec![LEVEL])))
}

/// Bytes of an HDF5 file.
fn encode(file: &str, builder: Result<Hdf5Builder, hdf5_writer::Error>) -> Result<Vec<u8>, SimulateError> {
    let refuse = |error: hdf5_writer::Error| SimulateError::Encode { file: file.to_owned(), reason: error.to_string() };
    let plan = builder.and_then(Hdf5Builder::into_plan).map_err(refuse)?;
    let sink = std::io::Cursor::new(Vec::new());
    let sink = Hdf5Writer::new(sink, WriteOptions::default()).finish(plan).map_err(refuse)?;
    Ok(sink.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_of_day_is_written_with_leading_zeros() {
        assert_eq!(time_of_day(49_327.25, 3), "13:42:07.250");
        assert_eq!(time_of_day(7.0, 0), "00:00:07");
    }
}
