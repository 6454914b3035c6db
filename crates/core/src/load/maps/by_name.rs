//! Channels of a source by the names a channel map gives, and its clock among them.

use std::collections::BTreeMap;

use crate::load::clocks::find_clocks::{add_even_clocks, assign_clocks, clock_of};
use crate::load::clocks::time_unit::UNREAD_CURE;
use crate::load::contents::{ChannelInfo, Source};
use crate::load::maps::map::{TimeEntry, TimeOrigin, matches};
use crate::quantity::{Dimension, Unit};

/// Number of columns of every matrix of `source` that matches `pattern`.
pub(crate) fn column_counts(source: &Source, pattern: &str) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for channel in &source.channels {
        if let Some((matrix, _)) = channel.column().filter(|(matrix, _)| matches(pattern, matrix)) {
            *counts.entry(matrix.to_owned()).or_default() += 1;
        }
    }
    counts
}

/// Channels of `source` under the first of `names` that any goes by; a full name `source/channel` counts too.
pub(crate) fn find<'s>(source: &'s Source, names: &[String]) -> impl Iterator<Item = usize> + use<'s> {
    let is = |channel: &ChannelInfo, name: &str| {
        matches(name, &channel.name)
            || name.strip_prefix(&source.name).and_then(|rest| rest.strip_prefix(['/', '.']))
                == Some(channel.name.as_str())
    };
    let name = names.iter().find(|name| source.channels.iter().any(|channel| is(channel, name))).cloned();
    source
        .channels
        .iter()
        .enumerate()
        .filter(move |(_, channel)| name.as_ref().is_some_and(|name| is(channel, name)))
        .map(|(index, _)| index)
}

/// Makes the clock of `source` the one that `entry` names.
pub(crate) fn set_clock(source: &mut Source, entry: &TimeEntry) -> Result<(), String> {
    match &entry.origin {
        TimeOrigin::File => return Ok(()),
        TimeOrigin::Even { start_s, rate_hz } => {
            source.clocks.clear();
            source.channels.iter_mut().for_each(|channel| channel.is_time = false);
            source.start_time_s = Some(*start_s);
            source.sample_rate_hz = Some(*rate_hz);
            add_even_clocks(source, *start_s, *rate_hz);
        }
        TimeOrigin::Channel { names, unit } => {
            let indices: Vec<usize> = find(source, names).collect();
            let is_unread = source.unread_time.as_ref().is_some_and(|(name, _)| names.contains(name));
            if let Some(what) = source.describe_unread_time().filter(|_| indices.is_empty() && is_unread) {
                return Err(format!("source '{}': {what}; {UNREAD_CURE}", source.name));
            }
            let &[index] = &indices[..] else {
                let (names, count) = (names.join("' or '"), indices.len());
                return Err(format!(
                    "source '{}' has {count} time channels '{names}', the map expects one",
                    source.name
                ));
            };
            let recorded = source.channels[index].unit.as_deref().and_then(|name| Unit::parse(name).ok());
            let recorded = recorded.filter(|unit| unit.dimension == Dimension::Time);
            source.channels.iter_mut().for_each(|channel| channel.is_time = false);
            source.channels[index].is_time = true;
            source.clocks = vec![clock_of(&source.channels[index], index, unit.or(recorded))];
        }
    }
    assign_clocks(source);
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::load::formats::recognise::inspect;
    use crate::load::guesses::guess::guess;
    use crate::load::maps::map::ChannelMap;
    use crate::load::maps::plan::plan;

    #[test]
    fn a_time_that_is_not_understood_is_said_once_for_all_roles() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.csv");
        let rows: String = (0..9).map(|k| format!("10h23m11s{k:03},0.1,0.2,0.{k}\n")).collect();
        std::fs::write(&path, format!("Timestamp,P [deg/s],Q [deg/s],R [deg/s]\n{rows}")).unwrap();
        let probe = inspect(&path).unwrap();
        let what = "source 'flight': 'Timestamp' is not a time in a known format, for example '10h23m11s000' (seconds, hh:mm:ss.fff and \
            YYYY-MM-DD hh:mm:ss.fff are); write it as one of these, or state the sample rate in the channel map";
        assert_eq!(probe.sources[0].missing_time().as_deref(), Some(what));
        let guessed = guess(std::slice::from_ref(&probe)).text().unwrap();
        let named = format!("{guessed}\n[[time]]\nchannel = \"Timestamp\"\n");
        let wrong = format!("{guessed}\n[[time]]\nchannel = \"Clock\"\n");
        let clock = "source 'flight' has 0 time channels 'Clock', the map expects one";
        for (text, expected) in [(guessed, what), (named, what), (wrong, clock)] {
            let map = ChannelMap::parse(&text).unwrap();
            assert_eq!(map.roles.len(), 3);
            let problems: Vec<_> = plan(&probe, &map).problems;
            assert_eq!(problems.len(), 1, "{problems:?}");
            assert_eq!(
                (problems[0].is_error, problems[0].text.as_str()),
                (true, &*format!("{}: {expected}", path.display()))
            );
        }
        let rate = format!("{}\n[[time]]\nsample_rate = 50.0\n", guess(std::slice::from_ref(&probe)).text().unwrap());
        assert_eq!(plan(&probe, &ChannelMap::parse(&rate).unwrap()).problems, []);
    }
}
