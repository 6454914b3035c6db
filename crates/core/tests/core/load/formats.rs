//! Every format gives the numbers that were written into it.

use doublet_core::load::{ChannelMap, Format, inspect, plan, probe, read};

use super::{channel, fixture, made, written};

/// Largest difference of values that went through a double once: none beyond rounding of the generator.
const EXACT: f64 = 1e-15;

#[track_caller]
fn assert_values(values: &[f64], expected: &[f64]) {
    assert_eq!(values.len(), expected.len());
    for (index, (value, expected)) in values.iter().zip(expected).enumerate() {
        assert!((value - expected).abs() <= EXACT, "sample {index}: {value} is not {expected}");
    }
}

#[test]
fn mat_v5_keeps_every_class_compressed_or_not() {
    for name in ["v5_compressed.mat", "v5_plain.mat"] {
        let probe = inspect(&fixture(name)).unwrap();
        let root = name.trim_end_matches(".mat");
        assert_eq!(probe.format, Format::MatV5);
        let values = |source: &str, name: &str| channel(&probe, source, name).values().to_vec();
        assert_values(&values(root, "alpha"), &made(50, |_, t| t.sin()));
        assert_values(&values(root, "flaps"), &made(50, |i, _| i % 3.0));
        assert_values(&values(root, "logical"), &made(50, |i, _| 1.0 - i % 2.0));
        assert_values(&values(root, "counts"), &made(50, |i, _| -i));
        assert_values(&values(root, "wide[2]"), &made(50, |i, _| 3.0 * i));
        assert_values(&values(root, "tall[1]"), &made(50, |i, _| 2.0 * i));
        assert_values(&values("imu", "q"), &made(50, |_, t| t.cos()));
        assert_values(&values("imu.calibration", "scale"), &[2.0]);
        assert_values(&values(root, "cells{1}"), &[0.0, 1.0, 2.0, 3.0]);
        let source = probe.source(root).unwrap();
        let note = |name: &str| source.notes.iter().find(|(key, _)| key == name).map(|(_, text)| text.as_str());
        assert_eq!(note("note"), Some("steady flight, alpha in rad"));
        assert_eq!(note("cells{2}"), Some("text"));
        assert_eq!(probe.source("imu.calibration").unwrap().notes, [("by".to_owned(), "hand".to_owned())]);
        let clock = &source.clocks[0];
        assert_eq!((clock.channel.as_str(), clock.samples), ("t", 50));
        assert!((clock.rate_hz - 50.0).abs() < 1e-9 && (clock.end_s - 0.98).abs() < 1e-12);
        let clock = &probe.source("imu").unwrap().clocks[0];
        assert!((clock.start_s, (clock.rate_hz - 100.0).abs() < 1e-6) == (10.0, true), "{clock:?}");
    }
}

#[test]
fn mat_v5_of_big_endian_with_short_tags_is_read() {
    let probe = inspect(&fixture("v5_big_endian.mat")).unwrap();
    assert_values(channel(&probe, "v5_big_endian", "t").values(), &made(50, |_, t| t));
    assert_values(channel(&probe, "v5_big_endian", "sq").values(), &made(50, |i, _| i * i));
    assert_values(channel(&probe, "v5_big_endian", "k").values(), &[1.0, 2.0, -3.0]);
}

#[test]
fn mat_v5_names_what_it_leaves_out() {
    let probe = inspect(&fixture("v5_sparse.mat")).unwrap();
    assert_values(channel(&probe, "v5_sparse", "kept").values(), &made(50, |_, t| t.sin()));
    let warnings = probe.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(warnings.contains("'s' is sparse") && warnings.contains("'z' is complex"), "{warnings}");
}

#[test]
fn mat_v73_is_transposed_back_and_its_cells_are_followed() {
    let probe = inspect(&fixture("v73.mat")).unwrap();
    assert_eq!(probe.format, Format::MatV73);
    assert_values(channel(&probe, "v73", "u_IMU[1]").values(), &made(50, |i, _| 2.0 * i));
    assert_values(channel(&probe, "v73", "flag").values(), &made(50, |i, _| i % 2.0));
    assert_values(channel(&probe, "run", "alpha").values(), &made(50, |_, t| t.sin()));
    assert_values(channel(&probe, "v73", "cells{1}").values(), &[0.0, 1.0, 2.0, 3.0]);
    let notes = &probe.source("v73").unwrap().notes;
    assert!(notes.contains(&("note".to_owned(), "steady".to_owned())), "{notes:?}");
    assert!(notes.contains(&("cells{2}".to_owned(), "two".to_owned())), "{notes:?}");
}

#[test]
fn hdf5_layouts_met_in_flight_test_are_read() {
    let listed = probe(&fixture("layouts.h5")).unwrap();
    assert_eq!(channel(&listed, "imu", "q").non_finite, None, "a listing reads headers and time only");
    let probe = inspect(&fixture("layouts.h5")).unwrap();
    assert_eq!(probe.format, Format::Hdf5);
    let q = channel(&probe, "imu", "q");
    assert_eq!((q.unit.as_deref(), q.non_finite, q.clock), (Some("deg/s"), Some(0), Some(0)));
    assert_values(q.values(), &made(50, |_, t| t.cos()));
    let q32 = channel(&probe, "imu", "q32");
    assert_eq!(q32.unit.as_deref(), Some("rad/s"));
    assert_values(q32.values(), &made(50, |_, t| f64::from(t.cos() as f32)));
    assert_values(channel(&probe, "imu", "valid").values(), &made(50, |i, _| 1.0 - i % 2.0));
    assert_values(channel(&probe, "imu", "acc[2]").values(), &made(50, |i, _| 3.0 * i));
    assert_values(channel(&probe, "engine", "n1").values(), &made(50, |i, _| i / 4.0));
    assert_values(channel(&probe, "engine", "n2").values(), &made(50, |i, _| -i));
    assert_eq!(channel(&probe, "engine", "n2").clock, Some(0));
    assert_eq!(channel(&probe, "imu/below", "r").clock, Some(0), "time of the group above");
    let gps = &probe.source("gps").unwrap().clocks[0];
    assert_eq!((gps.start_s, gps.rate_hz, gps.end_s), (5.0, 4.0, 9.75));
    let fix = &probe.source("gps/fix").unwrap().clocks[0];
    assert_eq!((fix.start_s, fix.rate_hz, fix.samples), (6.0, 2.0, 10));
}

#[test]
fn hdf5_becomes_a_recording_in_si() {
    let map = ChannelMap::parse(
        "format = \"doublet channel map\"\nversion = 1\nname = \"test\"\n\
         [roles]\nq = { channel = \"imu/q\" }\ngps_altitude = { channel = \"alt\" }\nr = { channel = \"q32\" }\n",
    )
    .unwrap();
    let probe = probe(&fixture("layouts.h5")).unwrap();
    let recording = read(&plan(&probe, &map)).unwrap();
    let role = |name: &str| recording.role(doublet_core::quantity::Role::from_name(name).unwrap()).unwrap();
    assert!((role("q").series.values[0] - 1_f64.to_radians()).abs() < EXACT);
    assert_eq!(role("gps_altitude").unit, "m");
    assert!((role("gps_altitude").series.values[3] - 103.0 * 0.3048).abs() < 1e-12);
    assert_eq!(role("gps_altitude").series.time_s[..3], [5.0, 5.25, 5.5]);
    let unmapped = recording.channels.iter().find(|channel| channel.name == "n1").unwrap();
    assert_eq!((unmapped.source.as_str(), unmapped.series.values.len()), ("engine", 50));
}

#[test]
fn csv_dialects_give_the_same_numbers() {
    let dialects = [
        "time,alpha,n\n0,1.5,10\n0.1,,11\n0.2,-2e-1,12\n0.3,1,13\n",
        "time;alpha;n\n0,0;1,5;10\n0,1;;11\n0,2;-2e-1;12\n0,3;1;13\n",
        "time\talpha\tn\r\n0\t1.5\t10\r\n0.1\t\t11\r\n0.2\t-0.2\t12\r\n0.3\t1\t13\r\n",
        "Recorder,7\nDate,2024-05-01\n\n\"time [s]\",\"alpha [deg]\",n\n0,\"1.5\",10\n0.1,,11\n0.2,-0.2,12\n0.3,1,13\n",
        "time,alpha,n\ns,deg,rpm\n,,\n0,1.5,10\n0.1,,11\n0.2,-0.2,12\n0.3,1,13",
        "\u{feff}# time alpha n\n  0.0 1.5D0 10\n 0.1 nan 11\n 0.2 -0.2 12\n 0.3 1 13\n",
    ];
    for (index, text) in dialects.iter().enumerate() {
        let (_folder, path) = written("log.mat", text);
        let probe = inspect(&path).unwrap_or_else(|error| panic!("dialect {index}: {error}"));
        let expected = if index == 5 { Format::TextColumns } else { Format::DelimitedText };
        assert_eq!(probe.format, expected, "dialect {index}");
        let alpha = channel(&probe, "log", "alpha");
        assert_eq!((alpha.samples, alpha.non_finite), (4, Some(1)), "dialect {index}");
        assert_eq!([alpha.values()[0], alpha.values()[2]], [1.5, -0.2], "dialect {index}");
        assert_eq!(channel(&probe, "log", "n").values(), [10.0, 11.0, 12.0, 13.0], "dialect {index}");
        let clock = &probe.sources[0].clocks[0];
        assert!((clock.rate_hz - 10.0).abs() < 1e-9 && clock.faults.is_empty(), "dialect {index}: {clock:?}");
    }
}

#[test]
fn csv_reports_units_metadata_gaps_and_words() {
    let text = "Aircraft;C337\ntime;alpha;mode\ns;deg;-\n0;1;auto\n1;x;auto\n2;3;auto\n5;4;hand\n";
    let (_folder, path) = written("log.txt", text);
    let probe = inspect(&path).unwrap();
    let source = &probe.sources[0];
    assert_eq!(channel(&probe, "log", "alpha").unit.as_deref(), Some("deg"));
    assert_eq!(source.notes[0], ("line 1".to_owned(), "Aircraft, C337".to_owned()));
    assert!(source.notes.iter().any(|(name, text)| name == "mode" && text.contains("auto")), "{:?}", source.notes);
    let gaps = &source.clocks[0].gaps;
    assert_eq!((gaps.len(), gaps[0].start_s, gaps[0].end_s), (1, 2.0, 5.0));
    assert!(
        probe
            .warnings
            .iter()
            .any(|warning| warning.to_string().contains("'alpha'") && warning.to_string().contains("line 5")),
        "{:?}",
        probe.warnings
    );
}

#[test]
fn columns_without_a_header_are_named_by_the_map() {
    let (_folder, path) = written("run.asc", "0 1 10\n1 2 20\n2 3 30\n3 4 40\n");
    let map = ChannelMap::parse(
        "format = \"doublet channel map\"\nversion = 1\nname = \"test\"\n[columns]\ncolumn = [\"t\", \"alpha\", \"V\"]\n\
         [[time]]\nchannel = \"column.t\"\nunit = \"ms\"\n[roles]\nalpha = { channel = \"column.alpha\", unit = \"deg\" }\n",
    )
    .unwrap();
    let recording = read(&plan(&probe(&path).unwrap(), &map)).unwrap();
    let alpha = recording.role(doublet_core::quantity::Role::AngleOfAttack).unwrap();
    assert_eq!(alpha.series.time_s[..], [0.0, 0.001, 0.002, 0.003]);
    assert!((alpha.series.values[3] - 4_f64.to_radians()).abs() < EXACT);
}

#[test]
fn first_column_that_increases_is_time_even_when_the_map_renames_it() {
    let (_folder, path) = written("run.asc", "0 1 10\n1 2 20\n2 3 30\n3 4 40\n");
    let map = ChannelMap::parse(
        "format = \"doublet channel map\"\nversion = 1\nname = \"test\"\n[columns]\n\"*\" = [\"s\", \"alpha\", \"V\"]\n\
         [roles]\nalpha = { channel = \"*.alpha\", unit = \"rad\" }\n",
    )
    .unwrap();
    let recording = read(&plan(&probe(&path).unwrap(), &map)).unwrap();
    let alpha = &recording.role(doublet_core::quantity::Role::AngleOfAttack).unwrap().series;
    assert_eq!((&alpha.time_s[..], &alpha.values[..]), (&[0.0, 1.0, 2.0, 3.0][..], &[1.0, 2.0, 3.0, 4.0][..]));
}

#[test]
fn column_numbers_beyond_the_names_are_left_as_they_are() {
    let (_folder, path) = written("run.csv", "t,a[0],a[7]\n0,1,2\n1,2,3\n2,3,4\n");
    let map = ChannelMap::parse(
        "format = \"doublet channel map\"\nversion = 1\nname = \"test\"\n[columns]\na = [\"first\", \"second\"]\n",
    )
    .unwrap();
    let recording = read(&plan(&probe(&path).unwrap(), &map)).unwrap();
    let names: Vec<&str> = recording.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["a.first", "a[7]"]);
}

#[test]
fn folder_of_csv_files_is_one_source() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in
        [("time.csv", "0\n0.5\n1\n"), ("q.csv", "1\n2\n3\n"), ("short.csv", "1\n2\n"), ("read.me", "hello")]
    {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let probe = inspect(folder.path()).unwrap();
    assert_eq!((probe.format, probe.sources.len()), (Format::Folder, 1));
    let source = &probe.sources[0];
    let find = |name: &str| source.channels.iter().find(|channel| channel.name == name).unwrap();
    assert_eq!((find("q").clock, find("short").clock, find("time").is_time), (Some(0), None, true));
    assert_eq!(source.clocks[0].rate_hz, 2.0);
}
