//! What every recording goes through once its sources are known: the units of its times, and what is odd about them.

use std::path::Path;

use super::LoadError;
use super::contents::{Probe, Source};
use super::time_unit::settle_units;

/// Refuses a recording without a channel and lists what is odd about time.
pub(super) fn finish(mut probe: Probe) -> Result<Probe, LoadError> {
    if probe.sources.iter().all(|source| source.channels.is_empty()) {
        let what = "no numeric channel was found";
        return Err(LoadError::Empty { path: probe.path, what });
    }
    settle_units(&mut probe.sources);
    for source in &probe.sources {
        for clock in &source.clocks {
            if clock.question.is_some() && clock.fault_count > 0 {
                continue;
            }
            probe.warnings.extend(
                clock
                    .faults
                    .iter()
                    .map(|fault| format!("source '{}': time channel '{}' {fault}", source.name, clock.channel)),
            );
            if clock.fault_count > clock.faults.len() {
                let more = clock.fault_count - clock.faults.len();
                probe
                    .warnings
                    .push(format!("source '{}': {more} more such samples of '{}'", source.name, clock.channel));
            }
        }
        probe.warnings.extend(source.missing_time());
    }
    Ok(probe)
}

impl Source {
    /// What is to be done about the time of a source that has none, in one line.
    pub fn missing_time(&self) -> Option<String> {
        if !self.clocks.is_empty() || self.channels.iter().all(|channel| channel.samples <= 1) {
            return None;
        }
        let cure = match stated_rate(self) {
            Some((line, rate)) => {
                format!("{line} says {rate} Hz: give sample_rate = {rate} in the map's [[time]] entry")
            }
            None => "name it in the map's [[time]] entry or give sample_rate there".to_owned(),
        };
        Some(format!("source '{}': no time channel recognised; {cure}", self.name))
    }
}

/// A rate that a line of text in the file states (`25 Hz`), and where.
fn stated_rate(source: &Source) -> Option<(&str, f64)> {
    source.notes.iter().find_map(|(line, text)| {
        let lower = text.to_lowercase();
        let number =
            lower[..lower.find("hz")?].trim_end().rsplit(|letter: char| !(letter.is_ascii_digit() || letter == '.'));
        Some((line.as_str(), number.into_iter().next()?.parse().ok()?))
    })
}

/// Name of a file without its extension, which names the source of a file that has only one.
pub(super) fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned())
}
