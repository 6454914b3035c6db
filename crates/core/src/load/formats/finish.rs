//! What every recording goes through once its sources are known: the units of its times, and what is odd about them.

use crate::load::clock::TimeFault;
use crate::load::clocks::time_unit::{UNREAD_CURE, settle_units};
use crate::load::contents::{Probe, Source};
use crate::load::error::LoadError;
use crate::message;
use crate::message::{Message, quoted};

/// Refuses a recording without a channel and lists what is odd about time.
pub(crate) fn finish(mut probe: Probe) -> Result<Probe, LoadError> {
    if probe.sources.iter().all(|source| source.channels.is_empty()) {
        let what = "no numeric channel was found";
        return Err(LoadError::Empty { path: probe.path, what });
    }
    probe.sources.iter_mut().for_each(take_noted_unit);
    settle_units(&mut probe.sources);
    for source in &probe.sources {
        for clock in &source.clocks {
            probe.warnings.extend(clock.restarts.iter().map(|restart| {
                message!(
                    "source {}: time channel {} goes back from {} s to {} s: the recorder restarted",
                    quoted(&source.name),
                    quoted(&clock.channel),
                    restart.before_s,
                    restart.stamp_s
                )
            }));
            if clock.question.is_some() && clock.fault_count > 0 {
                continue;
            }
            let fault_of_clock = |fault: &TimeFault| {
                let fault = fault.to_string();
                message!("source {}: time channel {} {}", quoted(&source.name), quoted(&clock.channel), fault)
            };
            probe.warnings.extend(clock.faults.iter().map(fault_of_clock));
            if clock.fault_count > clock.faults.len() {
                let more = clock.fault_count - clock.faults.len();
                probe.warnings.push(message!(
                    "source {}: {} more such samples of {}",
                    quoted(&source.name),
                    more,
                    quoted(&clock.channel)
                ));
            }
        }
        probe.warnings.extend(source.missing_time().map(Message::from));
    }
    Ok(probe)
}

/// Gives the only channel of a struct that states no unit the one that a text beside it states.
fn take_noted_unit(source: &mut Source) {
    const UNITS: [&str; 4] = ["unit", "units", "y_unit", "yunit"];
    let noted = source.notes.iter().find(|(key, _)| UNITS.contains(&key.to_lowercase().as_str()));
    let Some((_, unit)) = noted.cloned() else { return };
    let mut channels = source.channels.iter_mut().filter(|channel| !channel.is_time && channel.samples > 1);
    if let (Some(channel), None) = (channels.next(), channels.next()) {
        channel.unit.get_or_insert(unit);
    }
}

impl Source {
    /// What is to be done about the time of a source that has none, in one line.
    pub fn missing_time(&self) -> Option<String> {
        Some(format!("source '{}': {}", self.name, self.describe_missing_time()?))
    }

    /// The same without the name of the source.
    pub fn describe_missing_time(&self) -> Option<String> {
        if !self.clocks.is_empty() || self.channels.iter().all(|channel| channel.samples <= 1) {
            return None;
        }
        let unread = self.describe_unread_time();
        let fix_text = match (stated_rate(self), &unread) {
            (Some((line, rate)), _) => {
                format!("{line} states {rate} Hz: state this sample rate in the channel map")
            }
            (None, Some(_)) => UNREAD_CURE.to_owned(),
            (None, None) => "state the time channel or the sample rate in the channel map".to_owned(),
        };
        let what = unread.unwrap_or_else(|| "no time channel recognised".to_owned());
        Some(format!("{what}; {fix_text}"))
    }

    /// Which column is a time that was not understood, and what would be.
    pub(crate) fn describe_unread_time(&self) -> Option<String> {
        let (name, cell) = self.unread_time.as_ref()?;
        Some(format!(
            "'{name}' is not a time in a known format, for example '{cell}' (seconds, hh:mm:ss.fff and YYYY-MM-DD hh:mm:ss.fff are)"
        ))
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
