//! Flight data recorder files of X-Plane: a letter, the version, then lines headed by what they hold, and the rows.
//!
//! A row is time, longitude, latitude, altitude above sea level in ft, heading, pitch and roll in degrees, then the value of every dataref
//! that a line `DREF` names. Source: X-Plane, "FDR files", example of version 4.

use crate::load::formats::text_layout::{Separator, TextLayout};

/// Name of the one source of such a file.
pub(crate) const SOURCE: &str = "X-Plane FDR";
/// First columns of a row and their units.
const FIRST: [(&str, Option<&str>); 7] = [
    ("time", None),
    ("longitude", Some("deg")),
    ("latitude", Some("deg")),
    ("altitude", Some("ft")),
    ("heading", Some("deg")),
    ("pitch", Some("deg")),
    ("roll", Some("deg")),
];

/// Whether a text begins as such a recording: who wrote it (Apple or IBM line ends), and the version.
fn has_signature(contents: &[u8]) -> bool {
    let mut lines = contents.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    matches!(lines.next(), Some(b"A" | b"I")) && matches!(lines.next(), Some(b"3" | b"4"))
}

/// Layout and rows of such a recording; nothing of another text, or of one whose rows are headed by a word.
pub(crate) fn split(contents: &[u8]) -> Option<(TextLayout, Vec<u8>)> {
    if !has_signature(contents) {
        return None;
    }
    let mut names: Vec<String> = FIRST.iter().map(|(name, _)| (*name).to_owned()).collect();
    let (mut notes, mut rows, mut data_line) = (Vec::new(), Vec::new(), 0);
    for (index, line) in contents.split(|&byte| byte == b'\n').enumerate() {
        let line = line.trim_ascii();
        if line.first().is_some_and(u8::is_ascii_digit) && line.contains(&b',') {
            if rows.is_empty() {
                data_line = index + 1;
            }
            rows.extend_from_slice(line.strip_suffix(b",").unwrap_or(line));
            rows.push(b'\n');
            continue;
        }
        let text = String::from_utf8_lossy(line);
        match text.split_once(',').map(|(head, rest)| (head.trim(), rest.trim())) {
            Some(("DREF", rest)) => names.extend(rest.split([' ', '\t', ',']).next().map(str::to_owned)),
            _ if !text.is_empty() => notes.push(text.into_owned()),
            _ => {}
        }
    }
    let mut units: Vec<Option<String>> = FIRST.iter().map(|(_, unit)| unit.map(str::to_owned)).collect();
    units.resize(names.len(), None);
    let layout = TextLayout {
        separator: Separator::Byte(b','),
        decimal_comma: false,
        columns: names.len(),
        has_open_end: false,
        names,
        units,
        data_at: 0,
        data_line,
        notes,
    };
    (!rows.is_empty()).then_some((layout, rows))
}

#[cfg(test)]
mod tests {
    use crate::load::guesses::guess::guess;
    use crate::load::probe_of;
    use crate::quantity::Role;

    #[test]
    fn datarefs_name_the_columns_behind_the_first_seven() {
        let rows: String = (0..40).map(row).collect();
        let probe = probe_of(&format!(
            "I\r\n4\r\n\r\nACFT, Aircraft/mine.acf\nTAIL, ABC\n\
             DREF, sim/cockpit2/gauges/indicators/airspeed_kts_pilot\t\t1.0\t\t// IAS\nDREF, sim/flightmodel/position/Q 1.0\n{rows}"
        ));
        let source = &probe.sources[0];
        assert_eq!((source.clocks[0].channel.as_str(), source.clocks[0].rate_hz), ("time", 1.0));
        let map = guess(std::slice::from_ref(&probe));
        for (role, channel, unit) in [
            (Role::Longitude, "longitude", "deg"),
            (Role::GpsAltitude, "altitude", "ft"),
            (Role::HeadingAngle, "heading", "deg"),
            (Role::BankAngle, "roll", "deg"),
            (Role::CalibratedAirspeed, "sim/cockpit2/gauges/indicators/airspeed_kts_pilot", "kt"),
            (Role::PitchRate, "sim/flightmodel/position/Q", "deg/s"),
        ] {
            let row = map.row(role).unwrap_or_else(|| panic!("{}", role.name()));
            assert_eq!((row.from.channel.as_str(), row.unit.map(|unit| unit.symbol)), (channel, Some(unit)));
        }
    }

    fn row(k: u32) -> String {
        let t = f64::from(k);
        format!("12:00:{t:04.1}, 8.5{k:03}, 47.1{k:03}, {}, {}, 2.5, -1.5, {}, 0.4,\n", 9000 + k, 80 + k, 150 + k % 5)
    }
}
