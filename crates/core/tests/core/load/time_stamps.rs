//! Time stamps of every kind engineers have: opened right, or asked about with the fix.

use doublet_core::load::{ChannelMap, CoarseStamps, Probe, guess, inspect, plan, read};
use doublet_core::quantity::Role;

use super::written;
use crate::shared::shared;

/// What must become of a file of the shared folder.
enum Fate {
    /// Its time is right without a word.
    Right,
    /// Its time is right and something is asked or said, with these words.
    Said(&'static str),
    /// It has no time until this fix is written.
    Refused(&'static str),
}
use Fate::{Refused, Right, Said};

/// Rate and duration of the recordings, Hz and s (expected.json).
const RATE_HZ: f64 = 25.0;
const DURATION_S: f64 = 60.0;

/// Every generic file and its fate. Signs are told by the physics check.
const FILES: [(&str, Fate); 23] = [
    ("01_ms_integer.csv", Right),
    ("02_us_integer.csv", Right),
    ("03_ns_since_1970.csv", Right),
    ("04_date_time_utcoffset.csv", Right),
    ("05_units_row.csv", Right),
    ("06_semicolon_decimal_comma.csv", Right),
    ("07_utf8_bom_degree_sign.csv", Right),
    ("08_utf16le_tab.txt", Right),
    ("09_two_header_lines.csv", Right),
    ("10_quoted_commas_in_names.csv", Right),
    ("11_name_round_unit.csv", Right),
    ("12_name_square_unit.csv", Right),
    ("13_mixed_rates_blanks.csv", Right),
    ("14_held_samples.csv", Right),
    ("15_lat_lon_alt_track.csv", Right),
    ("16_quaternion.csv", Right),
    ("17_1khz_in_ms.csv", Said("in milliseconds 1000 Hz over 3 s; state the unit s or ms")),
    ("18_time_of_day_over_midnight.csv", Said("passes midnight")),
    ("19_no_time_column.csv", Refused("line 1 states 25 Hz: state this sample rate")),
    ("20_signs_turned_no_units.csv", Right),
    ("21_whole_second_stamps.csv", Right),
    ("22_excel_serial_days.csv", Said("read in serial days of a spreadsheet, 25 Hz over 60 s")),
    ("23_gps_week_tow_ms.csv", Right),
];

/// Rate, Hz, and span, s, of what is read by a map made of its names, and everything a user is told before and meanwhile.
fn told(probe: &Probe) -> (Option<(f64, f64)>, String) {
    let map = ChannelMap::parse(&guess(std::slice::from_ref(probe)).text().unwrap()).unwrap();
    let plan = plan(probe, &map);
    let mut lines: Vec<String> =
        probe.warnings.iter().map(ToString::to_string).chain(plan.problems.iter().map(ToString::to_string)).collect();
    let read = read(&plan);
    lines.extend(read.as_ref().err().map(ToString::to_string));
    let times = probe.sources[0].clocks.first().zip(read.ok()).and_then(|(clock, recording)| {
        let time_s = &recording.role(Role::PitchRate)?.series.time_s;
        // Stamps coarser than the samples: the map takes their rate.
        let of_samples = |coarse: CoarseStamps| (coarse.rate_hz, time_s[time_s.len() - 1] - time_s[0]);
        Some(clock.coarse.map_or((clock.rate_hz, clock.end_s - clock.start_s), of_samples))
    });
    (times, lines.join("\n"))
}

#[test]
fn stamps_of_every_kind_open_right_or_name_their_cure() {
    let Some(folder) = shared("data/formats/generic_csv") else { return };
    let mut faults = Vec::new();
    for (name, fate) in &FILES {
        let (times, lines) = match inspect(&folder.join(name)) {
            Ok(probe) => told(&probe),
            Err(error) => (None, error.to_string()),
        };
        let near = |value: f64, truth: f64| (value / truth - 1.0).abs() < 1e-3;
        let is_right = times.is_some_and(|(rate, span)| near(rate, RATE_HZ) && near(span, DURATION_S));
        let asks = lines.contains("time '");
        let good = match fate {
            Right => is_right && !asks,
            // Read as seconds it could be meant: only the question keeps it from opening wrong.
            Said(words) => lines.contains(words) && (is_right || name.starts_with("17")),
            Refused(words) => times.is_none() && lines.contains(words),
        };
        if !good {
            faults.push(format!("{name}: {times:?}, {lines}"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// What reading `text` by `map` gives for the stamps of q, and what is said.
fn stamps(text: &str, map: &str) -> (Vec<f64>, String) {
    let (_folder, path) = written("r.csv", text);
    let probe = inspect(&path).unwrap();
    let map = format!(
        "format = \"doublet channel map\"\nversion = 1\nname = \"m\"\n{map}\n[roles]\nq = {{ channel = \"q\", unit = \"rad/s\" }}\n"
    );
    let recording = read(&plan(&probe, &ChannelMap::parse(&map).unwrap())).unwrap();
    (
        recording.role(Role::PitchRate).unwrap().series.time_s.to_vec(),
        recording.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"),
    )
}

#[test]
fn what_the_map_states_comes_before_what_stamps_look_like_and_a_contradiction_is_said() {
    let rows: String = (0..50).map(|k| format!("{},{}\n", 1000 + 20 * k, k % 7)).collect();
    let text = format!("time,q\n{rows}");
    let (free, message) = stamps(&text, "");
    assert!(
        (free[1] - free[0] - 0.02).abs() < 1e-12 && message.contains("read in milliseconds, 50 Hz over 0.98 s"),
        "{message}"
    );
    let (stated, message) = stamps(&text, "[[time]]\nchannel = \"time\"\nunit = \"ms\"");
    assert_eq!((stated, message.as_str()), (free, ""));
    let (wrong, message) = stamps(&text, "[[time]]\nchannel = \"time\"\nunit = \"s\"");
    assert_eq!(wrong[1] - wrong[0], 20.0);
    assert!(
        message.contains(
            "'time' is read in s: 0.05 Hz over 16.3 min; in milliseconds it is 50 Hz over 0.98 s: state the unit ms"
        ),
        "{message}"
    );
    // The name of the column states it.
    let (named, message) = stamps(&text.replace("time,", "t_us,"), "");
    assert!((named[1] - 1.02e-3).abs() < 1e-12 && message.contains("'t_us' is read in us: 50000 Hz"), "{message}");
}

#[test]
fn the_first_increasing_column_is_not_taken_for_time_without_a_word() {
    let rows: String = (0..9).map(|k| format!("{},{}\n", 0.7 * f64::from(k), k % 3)).collect();
    let (_folder, path) = written("r.csv", rows);
    let probe = inspect(&path).unwrap();
    let question = probe.sources[0].clocks[0].question.as_deref();
    assert!(
        question.is_some_and(|it| it.contains("'column[0]' is used as time: it is the first column")),
        "{question:?}"
    );
}
