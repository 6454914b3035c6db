//! Matrices with their labels beside them, channels that are structs, and the tables of simulators and avionics in their own forms.

use doublet_core::load::{guess, inspect};
use doublet_core::quantity::Role;

use super::{channel, element, written};

/// An array of `class` called `name`.
fn array(class: u8, dims: [usize; 2], name: &str, rest: &[u8]) -> Vec<u8> {
    let dims: Vec<u8> = dims.iter().flat_map(|dim| (*dim as i32).to_le_bytes()).collect();
    let flags = element(6, &[class, 0, 0, 0, 0, 0, 0, 0]);
    element(14, &[flags, element(5, &dims), element(1, name.as_bytes()), rest.to_vec()].concat())
}

fn numbers(name: &str, columns: &[&[f64]]) -> Vec<u8> {
    let bytes: Vec<u8> =
        columns.iter().flat_map(|column| column.iter().flat_map(|value| value.to_le_bytes())).collect();
    array(6, [columns[0].len(), columns.len()], name, &element(9, &bytes))
}

/// Rows of one length, stored column by column as 16-bit characters.
fn text(name: &str, rows: &[&str]) -> Vec<u8> {
    let width = rows.iter().map(|row| row.len()).max().unwrap();
    let letter = |row: &str, column: usize| u16::from(row.as_bytes().get(column).copied().unwrap_or(b' '));
    let codes: Vec<u8> =
        (0..width).flat_map(|column| rows.iter().flat_map(move |row| letter(row, column).to_le_bytes())).collect();
    array(4, [rows.len(), width], name, &element(4, &codes))
}

fn cells(name: &str, rows: &[&str]) -> Vec<u8> {
    let children: Vec<u8> = rows.iter().flat_map(|row| text("", &[row])).collect();
    array(1, [rows.len(), 1], name, &children)
}

fn structure(name: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
    const LENGTH: usize = 16;
    let mut names = Vec::new();
    for (field, _) in fields {
        names.extend(field.as_bytes());
        names.resize(names.len().next_multiple_of(LENGTH), 0);
    }
    let values: Vec<u8> = fields.iter().flat_map(|(_, value)| value.clone()).collect();
    array(2, [1, 1], name, &[element(5, &(LENGTH as i32).to_le_bytes()), element(1, &names), values].concat())
}

fn file(variables: &[Vec<u8>]) -> Vec<u8> {
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend([0, 1, b'I', b'M']);
    file.extend(variables.concat());
    file
}

const TIME: [f64; 6] = [0.0, 0.02, 0.04, 0.06, 0.08, 0.1];
const ALPHA: [f64; 6] = [2.0, 2.1, 2.2, 2.3, 2.2, 2.1];
const SPEED: [f64; 6] = [100.0, 101.0, 102.0, 103.0, 104.0, 105.0];

#[test]
fn columns_of_a_matrix_are_called_as_the_text_beside_it_says() {
    let columns: [&[f64]; 3] = [&TIME, &ALPHA, &SPEED];
    let by_text = file(&[
        numbers("fdata", &columns),
        text("fdatalab", &["time", "alpha", "V (ft/sec)"]),
        text("fdataunits", &["sec", "deg", "ft/sec"]),
        text("comment", &["first run"]),
    ]);
    let by_cells = file(&[
        cells("names", &["time", "alpha", "V"]),
        cells("units", &["[sec]", "[deg]", "[ft/sec]"]),
        numbers("fdata", &columns),
    ]);
    for (contents, speed) in [(by_text, "V (ft/sec)"), (by_cells, "V")] {
        let (_folder, path) = written("run.mat", contents);
        let probe = inspect(&path).unwrap();
        let alpha = channel(&probe, "run", "alpha");
        assert_eq!((alpha.values(), alpha.unit.as_deref(), alpha.clock), (&ALPHA[..], Some("deg"), Some(0)));
        let found = probe.sources[0].channels.iter().find(|channel| channel.values() == SPEED).unwrap();
        assert_eq!(found.unit.as_deref(), Some("ft/sec"));
        assert!(speed.starts_with(&found.name), "{}", found.name);
        assert_eq!(probe.sources[0].clocks[0].rate_hz, 50.0);
    }
}

#[test]
fn texts_that_do_not_name_every_column_name_none() {
    let columns: [&[f64]; 3] = [&TIME, &ALPHA, &SPEED];
    for labels in [
        vec![text("labels", &["time", "alpha"])],
        vec![text("labels", &["time", "alpha", "alpha"])],
        vec![text("labels", &[" ", " ", " "])],
        vec![text("labels", &["time", "alpha", "V"]), text("others", &["t", "a", "v"])],
    ] {
        let (_folder, path) = written("run.mat", file(&[labels, vec![numbers("fdata", &columns)]].concat()));
        let probe = inspect(&path).unwrap();
        assert_eq!(channel(&probe, "run", "fdata[1]").values(), ALPHA);
    }
}

#[test]
fn texts_in_a_struct_name_columns_too_and_a_column_without_a_name_keeps_its_own() {
    let columns: [&[f64]; 3] = [&TIME, &ALPHA, &SPEED];
    let texts = [("varlab", cells("", &["time", " ", "V"])), ("varunits", cells("", &["(sec)", "", "(ft/sec)"]))];
    let (_folder, path) = written("run.mat", file(&[numbers("data", &columns), structure("fds", &texts)]));
    let probe = inspect(&path).unwrap();
    assert_eq!(channel(&probe, "run", "data[1]").values(), ALPHA);
    assert_eq!(channel(&probe, "run", "V").unit.as_deref(), Some("ft/sec"));
}

#[test]
fn columns_of_sidpac_are_known_by_their_order() {
    let rows = 200;
    let wave = |k: usize| (0..rows).map(|row| (0.1 * row as f64 + k as f64).sin()).collect::<Vec<_>>();
    let mut columns: Vec<Vec<f64>> = (0..90).map(wave).collect();
    columns[0] = (0..rows).map(|row| 0.02 * row as f64).collect();
    let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let (_folder, path) = written("run.mat", file(&[numbers("fdata", &slices)]));
    let map = guess(&[inspect(&path).unwrap()]);
    assert_eq!(map.recorders, ["SIDPAC"]);
    for (role, channel, unit) in [
        (Role::TrueAirspeed, "fdata[1]", "ft/s"),
        (Role::RollRate, "fdata[4]", "deg/s"),
        (Role::SpecificForceZ, "fdata[12]", "g"),
        (Role::Elevator, "fdata[13]", "deg"),
    ] {
        let row = map.row(role).unwrap();
        assert_eq!((row.from.channel.as_str(), row.unit.unwrap().symbol, row.turned), (channel, unit, false));
    }
}

#[test]
fn a_struct_of_simulink_is_a_source_whose_labels_name_its_signals() {
    let signal = |label: &'static str, columns: &[&[f64]]| {
        structure("", &[("values", numbers("", columns)), ("label", text("", &[label]))])
    };
    let block = |name: &'static str, signals: Vec<u8>| {
        structure(name, &[("time", numbers("", &[&TIME])), ("signals", signals)])
    };
    let named = block("air", signal("alpha, V (ft/sec)", &[&ALPHA, &SPEED]));
    let nameless = block("Vtas", signal("", &[&SPEED]));
    let (_folder, path) = written("run.mat", file(&[named, nameless]));
    let probe = inspect(&path).unwrap();
    assert_eq!(channel(&probe, "air", "alpha").values(), ALPHA);
    assert_eq!(channel(&probe, "air", "V").unit.as_deref(), Some("ft/sec"));
    assert_eq!(channel(&probe, "Vtas", "Vtas").clock, Some(0));
    assert_eq!(probe.sources[0].clocks[0].rate_hz, 50.0);
}

#[test]
fn structs_of_one_row_of_numbers_and_its_units_are_channels() {
    let one = |name: &'static str, values: &[f64], unit: &str| {
        let fields = [
            ("data", numbers("", &[values])),
            ("units", text("", &[unit])),
            ("description", text("", &["as installed"])),
        ];
        (name, structure("", &fields))
    };
    let flight = structure(
        "flightdata",
        &[one("time", &TIME, "s"), one("vane_AOA", &ALPHA, "deg"), one("Dadc1_tas", &SPEED, "kts")],
    );
    let (_folder, path) = written("flight.mat", file(&[flight]));
    let probe = inspect(&path).unwrap();
    assert_eq!(probe.sources.len(), 1);
    let alpha = channel(&probe, "flightdata", "vane_AOA");
    assert_eq!((alpha.values(), alpha.unit.as_deref(), alpha.clock), (&ALPHA[..], Some("deg"), Some(0)));
    assert_eq!(probe.sources[0].clocks[0].rate_hz, 50.0);
    // Two rows of numbers in one struct stay a source of their own.
    let pair = structure("pair", &[("time", numbers("", &[&TIME])), ("q", numbers("", &[&ALPHA]))]);
    let (_folder, path) = written("pair.mat", file(&[pair]));
    assert_eq!(channel(&inspect(&path).unwrap(), "pair", "q").values(), ALPHA);
}

/// Asserts name, unit, last value and rate of channels of a text file.
fn assert_text(name: &str, contents: &str, rate_hz: f64, expected: &[(&str, Option<&str>, f64)]) {
    let (_folder, path) = written(name, contents);
    let probe = inspect(&path).unwrap();
    let source = &probe.sources[0];
    assert!((source.clocks[0].rate_hz - rate_hz).abs() < 1e-6 * rate_hz, "{name}: {} Hz", source.clocks[0].rate_hz);
    for (channel_name, unit, last) in expected {
        let found = channel(&probe, &source.name, channel_name);
        let finite = found.values().iter().rev().find(|value| value.is_finite());
        assert_eq!((found.unit.as_deref(), finite), (*unit, Some(last)), "{name}: {channel_name}");
    }
}

#[test]
fn tables_of_simulators_and_avionics_are_read_in_their_own_forms() {
    let jsbsim = "Time,Q (deg/s),V_{North} (ft/s),BodyAccel_X,/fdm/jsbsim/fcs/elevator-pos-rad\n\
                  0.05,1.5,100.25,0.4,-0.01\n0.1,1.75,100.5,0.5,-0.02\n0.15,2,100.75,0.6,-0.03\n0.2,2.25,101,0.7,-0.04\n";
    assert_text(
        "jsbsim.csv",
        jsbsim,
        20.0,
        &[
            ("Q", Some("deg/s"), 2.25),
            ("V_{North}", Some("ft/s"), 101.0),
            ("/fdm/jsbsim/fcs/elevator-pos-rad", None, -0.04),
        ],
    );
    let flightgear = "Time,Altitude (ft),Speed North (fps),alpha-deg,elevator (norm)\n\
                      63.25,5000,59.05,0.81,0.16\n63.3,5000.5,59.1,0.82,0.17\n63.35,5001,59.15,0.83,0.18\n63.4,5001.5,59.2,0.84,0.19\n";
    assert_text(
        "fg.csv",
        flightgear,
        20.0,
        &[("Altitude", Some("ft"), 5001.5), ("Speed North", Some("fps"), 59.2), ("alpha-deg", None, 0.84)],
    );
    let onspeed = "timeStamp,Pfwd,IAS,VerticalG,PitchRate,vnTimeUTC, EarthVerticalG\n\
                   2860003,847,73.12,1.02,-0.68,47:47.0,0.5\n2860023,848,73.13,1.03,-0.69,47:47.1,0.6\n\
                   2860043,849,73.14,1.04,-0.7,47:47.1,0.7\n2860063,850,73.15,1.05,-0.71,47:47.1,0.8\n";
    assert_text("onspeed.csv", onspeed, 50.0, &[("IAS", None, 73.15), ("EarthVerticalG", None, 0.8)]);
    let g3x = "#airframe_info,log_version=\"1.00\",airframe_name=\"RV-8\",product=\"GDU 460\"\n\
               Date (yyyy-mm-dd),Time (hh:mm:ss),UTC Offset (hh:mm),Pressure Altitude (ft),True Airspeed (kt),Pitch (deg),Lateral Accel (G)\n\
               Lcl Date,Lcl Time,UTCOfst,AltP,TAS,Pitch,LatAc\n\
               2026-05-14,16:30:00,+02:00,5000,95,1.5,0.01\n2026-05-14,16:30:01,+02:00,5001,96,1.6,0.02\n\
               2026-05-14,16:30:02,+02:00,5002,97,1.7,\n2026-05-14,16:30:03,+02:00,5003,98,1.8,0.04\n";
    assert_text("g3x.csv", g3x, 1.0, &[("TAS", Some("kt"), 98.0), ("LatAc", Some("G"), 0.04)]);
}

#[test]
fn topics_of_a_flight_log_as_tables_are_sources_with_their_own_clocks() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |step: u64, count: u64| -> String {
        (0..count).map(|k| format!("{},{},{}\n", 20_000_000 + step * k, 0.5 * k as f64, k)).collect()
    };
    for (topic, step, count) in
        [("sensor_combined_0", 5_000, 400), ("airspeed_0", 100_000, 20), ("airspeed_1", 100_000, 20)]
    {
        let text = format!("timestamp,value[0],value[1]\n{}", rows(step, count));
        std::fs::write(folder.path().join(format!("log_{topic}.csv")), text).unwrap();
    }
    let probe = inspect(folder.path()).unwrap();
    let names: Vec<&str> = probe.sources.iter().map(|source| source.name.as_str()).collect();
    assert_eq!(names, ["log_airspeed_0", "log_airspeed_1", "log_sensor_combined_0"]);
    for (source, rate_hz) in [("log_airspeed_1", 10.0), ("log_sensor_combined_0", 200.0)] {
        let clock = &probe.source(source).unwrap().clocks[0];
        assert!(
            (clock.rate_hz - rate_hz).abs() < 1e-6 * rate_hz && clock.start_s == 20.0,
            "{source}: {} Hz",
            clock.rate_hz
        );
        assert_eq!(channel(&probe, source, "value[1]").clock, Some(0));
    }
}
