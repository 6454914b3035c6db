//! Recordings of VBOX (`.vbo`): a section for each part of the head, then a table in columns.
//!
//! Latitude and longitude are in minutes of arc, longitude positive to the west; the section `[header]` names the columns in full, with their
//! units. Source: Racelogic, format of `.vbo` files.

use crate::load::clocks::stamp::seconds_of_digits;
use crate::load::contents::{ChannelInfo, Source};
use crate::quantity::Unit;

/// Minutes of arc in a degree.
const MINUTES: f64 = 60.0;
/// Section in front of the names of the columns in full, and that of their names in the table.
const SECTIONS: [&str; 2] = ["[header]", "[column names]"];

/// Gives a source that a file of VBOX holds its units, times of day in seconds, and latitude and longitude in degrees, positive to the east.
pub(crate) fn settle(source: &mut Source) {
    let lines: Vec<&str> = source.notes.iter().map(|(_, text)| text.trim()).collect();
    let [Some(header), Some(_)] = SECTIONS.map(|section| lines.iter().position(|line| *line == section)) else {
        return;
    };
    let in_full: Vec<&str> = lines[header + 1..].iter().copied().take_while(|line| !line.starts_with('[')).collect();
    let units: Vec<Option<String>> = in_full.iter().map(|line| unit_of(line)).collect();
    if in_full.len() == source.channels.len() {
        for (channel, unit) in source.channels.iter_mut().zip(units) {
            channel.unit = channel.unit.take().or(unit);
        }
    }
    // A recording within one minute does not show by its steps that its times are hhmmss.
    if let Some(channel) = source.channels.iter_mut().find(|channel| channel.name == "time" && !channel.is_time_of_day)
    {
        channel.set(channel.values().iter().copied().map(seconds_of_digits).collect());
        channel.is_time_of_day = true;
    }
    for (name, sign) in [("lat", 1.0), ("long", -1.0)] {
        if let Some(channel) = source.channels.iter_mut().find(|channel| channel.name == name) {
            let degrees = channel.values().iter().map(|minutes| sign * minutes / MINUTES).collect();
            *channel = ChannelInfo::new(name, Some("deg".to_owned()), degrees);
        }
    }
}

/// Unit of the last word of a line: `vertical velocity m/s`; those of the first columns where it states none.
fn unit_of(line: &str) -> Option<String> {
    let last = line.rsplit_once(' ').map_or(line, |(_, last)| last);
    match line {
        "heading" => Some("deg".to_owned()),
        "height" => Some("m".to_owned()),
        _ => (last != line && Unit::parse(last).is_ok()).then(|| last.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use crate::load::probe_of;

    #[test]
    fn places_are_in_minutes_and_times_in_digits() {
        let row = |k: u32| {
            let second = 40.0 + 0.5 * f64::from(k);
            let time = 102_200.0 + 100.0 * (second / 60.0).floor() + second % 60.0;
            format!("010 {time:09.2} +03119.09973 +00058.49277 100.800 181.0 +600.00 -001.500\n")
        };
        // Over a full minute, and within one, where no step shows that times are written as hhmmss.
        for (rows, end_s) in [(80, 37_399.5), (30, 37_374.5)] {
            let rows: String = (0..rows).map(row).collect();
            let probe = probe_of(&format!(
                "File created on 12/05/2024 @ 10:22\n\n[header]\nsatellites\ntime\nlatitude\nlongitude\nvelocity kmh\nheading\nheight\n\
             vertical velocity m/s\n\n[comments]\nGPS : 2Hz\n\n[column names]\nsats time lat long velocity heading height vert-vel\n\n\
             [data]\n{rows}"
            ));
            let source = &probe.sources[0];
            let channel = |name: &str| source.channels.iter().find(|channel| channel.name == name).unwrap();
            assert!((channel("lat").values()[0] - 51.984_995_5).abs() < 1e-6, "{}", channel("lat").values()[0]);
            assert!((channel("long").values()[0] + 0.974_879_5).abs() < 1e-6, "{}", channel("long").values()[0]);
            assert_eq!(channel("velocity").unit.as_deref(), Some("kmh"));
            assert_eq!(channel("vert-vel").unit.as_deref(), Some("m/s"));
            let clock = &source.clocks[0];
            assert_eq!((clock.channel.as_str(), clock.start_s, clock.end_s), ("time", 37_360.0, end_s));
            assert_eq!(clock.faults.len() + clock.gaps.len(), 0);
        }
    }
}
