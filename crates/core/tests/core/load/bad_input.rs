//! Bad input: one line each, naming file, channel and fix.

use std::path::Path;

use doublet_core::load::{ChannelMap, LoadError, inspect, plan, plan_all, probe, read, read_all};
use doublet_core::quantity::Role;

use super::{fixture, written};

const HEAD: &str = "format = \"doublet channel map\"\nversion = 1\nname = \"test\"\n";

fn map(body: &str) -> ChannelMap {
    ChannelMap::parse(&format!("{HEAD}{body}")).unwrap()
}

/// The line an error gives, which must be one and hold every one of `parts`.
#[track_caller]
fn assert_line(error: &LoadError, parts: &[&str]) {
    let line = error.to_string();
    assert!(!line.contains('\n'), "{line:?}");
    for part in parts {
        assert!(line.contains(part), "'{part}' is not in: {line}");
    }
}

#[track_caller]
fn assert_map(body: &str, line: usize, parts: &[&str]) {
    let error = ChannelMap::parse(&format!("{HEAD}{body}")).unwrap_err();
    assert_line(&error, parts);
    let LoadError::Map { line: found, .. } = error else { panic!("{error}") };
    assert_eq!(found, line, "{error}");
}

#[test]
fn missing_empty_and_foreign_files_are_refused() {
    assert_line(&inspect(Path::new("/nowhere/run.mat")).unwrap_err(), &["/nowhere/run.mat", "check the path"]);
    let (_folder, path) = written("run.h5", "");
    assert_line(&inspect(&path).unwrap_err(), &["run.h5", "0 bytes"]);
    let (_folder, path) = written("run.csv", [0_u8, 1, 2, 3, 0, 255, 0, 9]);
    assert_line(&inspect(&path).unwrap_err(), &["run.csv", "binary"]);
    let (_folder, path) = written("run.csv", "Dear reader,\nthis is a letter.\n");
    assert_line(&inspect(&path).unwrap_err(), &["run.csv", "without a table of numbers"]);
    let (_folder, path) = written("run.mat", "MATLAB 5.0 MAT-file");
    assert_line(&inspect(&path).unwrap_err(), &["run.mat", "cut off"]);
    let folder = tempfile::tempdir().unwrap();
    assert_line(&inspect(folder.path()).unwrap_err(), &["folder without .csv"]);
}

#[test]
fn wrong_extension_does_not_matter() {
    let bytes = std::fs::read(fixture("v5_plain.mat")).unwrap();
    let (_folder, path) = written("log.csv", bytes);
    assert_eq!(inspect(&path).unwrap().format, doublet_core::load::Format::MatV5);
}

#[test]
fn truncated_mat_names_the_byte() {
    let bytes = std::fs::read(fixture("v5_plain.mat")).unwrap();
    let (_folder, path) = written("cut.mat", &bytes[..300]);
    assert_line(&inspect(&path).unwrap_err(), &["cut.mat", "MAT v5", "at byte", "copy it again"]);
}

#[test]
fn an_hdf5_set_that_claims_more_than_the_file_can_hold_is_left_out() {
    let probe = probe(&fixture("claims.h5")).unwrap();
    let text = probe.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    let parts = ["'huge'", "1152921504606846976", "more than the file can hold"];
    assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    assert_eq!(probe.sources[0].channels.iter().map(|channel| channel.name.as_str()).collect::<Vec<_>>(), ["time"]);
}

#[test]
fn time_that_goes_back_or_repeats_is_listed_and_refused_with_a_cure() {
    let text = "time,alpha\n0,1\n0.1,2\n0.1,3\n0.05,4\n0.2,5\n,6\n0.3,7\n";
    let (_folder, path) = written("log.csv", text);
    let listed = probe(&path).unwrap();
    let faults = &listed.sources[0].clocks[0].faults;
    assert_eq!(faults.len(), 3, "{faults:?}");
    let warnings = listed.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    for part in ["repeats the stamp 0.1 s at index 2", "from 0.1 s to 0.05 s at index 3", "not finite at index 5"] {
        assert!(warnings.contains(part), "{warnings}");
    }
    let roles = "[roles]\nalpha = { channel = \"alpha\", unit = \"deg\" }\n";
    let error = read(&plan(&listed, &map(roles))).unwrap_err();
    assert_line(&error, &["log.csv", "'time'", "'log'", "index 2", "0.1 s", "'drop' in the channel map"]);
    let dropping = map(&format!("[[time]]\nchannel = \"time\"\nunit = \"s\"\nrepair = \"drop\"\n{roles}"));
    let recording = read(&plan(&listed, &dropping)).unwrap();
    let alpha = &recording.role(Role::AngleOfAttack).unwrap().series;
    assert_eq!(alpha.time_s[..], [0.0, 0.1, 0.2, 0.3]);
    assert!((alpha.values[3] - 7_f64.to_radians()).abs() < 1e-15);
    assert!(
        recording.warnings.iter().any(|warning| warning.to_string().contains("3 of 7 samples omitted")),
        "{:?}",
        recording.warnings
    );
}

#[test]
fn a_few_rows_written_twice_are_left_out_and_a_counter_that_was_full_goes_on() {
    let rows: String = (0..20).map(|k| format!("{:.1},{k}\n", 0.1 * f64::from(k))).collect();
    let (_folder, path) = written("log.csv", format!("time,alpha\n{rows}1.9,19\n2.0,20\n"));
    let roles = "[roles]\nalpha = { channel = \"alpha\", unit = \"deg\" }\n";
    let recording = read(&plan(&probe(&path).unwrap(), &map(roles))).unwrap();
    assert_eq!(recording.role(Role::AngleOfAttack).unwrap().series.time_s.len(), 21);
    assert!(
        recording.warnings.iter().any(|line| line.to_string().contains("1 of 22 samples omitted")),
        "{:?}",
        recording.warnings
    );
    // Milliseconds in 16 bits.
    let rows: String = (0..20).map(|k| format!("{},{k}\n", (65_000 + 100 * k) % 65_536)).collect();
    let (_folder, path) = written("log.csv", format!("time [ms],alpha\n{rows}"));
    let recording = read(&plan(&probe(&path).unwrap(), &map(roles))).unwrap();
    let series = &recording.role(Role::AngleOfAttack).unwrap().series;
    let last_s = series.time_s[series.time_s.len() - 1];
    assert!((last_s - series.time_s[0] - 1.9).abs() < 1e-9, "{:?}", series.time_s);
    assert!(
        recording.warnings.iter().any(|line| line.to_string().contains("begins again at zero")),
        "{:?}",
        recording.warnings
    );
}

#[test]
fn what_follows_a_restart_of_the_recorder_is_put_behind_it() {
    let row = |k: u32| format!("{:.1},{k}\n", 0.1 * f64::from(k));
    let text: String = ["time,alpha\n".to_owned()].into_iter().chain((0..200).chain(0..100).map(row)).collect();
    let (_folder, path) = written("log.csv", &text);
    let listed = probe(&path).unwrap();
    assert!(
        listed.warnings.iter().any(|line| line.to_string().contains("from 19.9 s to 0 s")),
        "{:?}",
        listed.warnings
    );
    let roles = "[roles]\nalpha = { channel = \"alpha\", unit = \"deg\" }\n";
    let recording = read(&plan(&listed, &map(roles))).unwrap();
    let series = &recording.role(Role::AngleOfAttack).unwrap().series;
    // Ten seconds behind 19.9 s.
    assert!((series.time_s[200] - 29.9).abs() < 1e-9 && (series.time_s[299] - 39.8).abs() < 1e-9);
    assert_eq!((series.time_s.len(), series.values[200]), (300, 0.0));
    let restarts = &recording.restarts["log"];
    assert_eq!((restarts.len(), restarts[0].stamp_s, restarts[0].time_s), (1, 0.0, series.time_s[200]));
    // Late samples beside that are left out where the map says so, and the restart with them.
    let dropping = map(&format!("[[time]]\nchannel = \"time\"\nunit = \"s\"\nrepair = \"drop\"\n{roles}"));
    let recording = read(&plan(&listed, &dropping)).unwrap();
    assert_eq!(recording.role(Role::AngleOfAttack).unwrap().series.time_s.len(), 200);
    assert!(recording.restarts.is_empty());
}

#[test]
fn a_restart_beside_another_recorder_is_refused() {
    let row = |k: u32| format!("{:.1},{k}\n", 0.1 * f64::from(k));
    let table = |rows: &mut dyn Iterator<Item = u32>| format!("time,alpha\n{}", rows.map(row).collect::<String>());
    let (folder, path) = written("log.csv", table(&mut (0..200).chain(0..100)));
    let other = folder.path().join("other.csv");
    std::fs::write(&other, table(&mut (0..300)).replace("alpha", "beta")).unwrap();
    let roles =
        "[roles]\nalpha = { channel = \"alpha\", unit = \"deg\" }\nbeta = { channel = \"beta\", unit = \"deg\" }\n";
    let error = read_all(&[path, other], &map(roles)).unwrap_err();
    assert_line(&error, &["log.csv", "19.9 s", "index 200", "separate file"]);
}

#[test]
fn nan_runs_are_kept_and_counted() {
    let (_folder, path) = written("log.csv", "time,alpha\n0,1\n1,nan\n2,NaN\n3,\n4,5\n");
    let probe = inspect(&path).unwrap();
    assert_eq!(probe.sources[0].channels[1].non_finite, Some(3));
    let recording = read(&plan(&probe, &map("[roles]\nalpha = { channel = \"alpha\", unit = \"deg\" }\n"))).unwrap();
    let values = &recording.role(Role::AngleOfAttack).unwrap().series.values;
    assert_eq!(values.iter().filter(|value| value.is_nan()).count(), 3);
    assert!(
        recording
            .warnings
            .iter()
            .any(|warning| warning.to_string().contains("alpha: 3 of 5 samples are not finite, the first at 1.000 s"))
    );
}

#[test]
fn blanks_between_the_samples_of_a_slower_sensor_are_not_counted() {
    let warnings = |lost: usize| -> Vec<String> {
        let row = |k: usize| if k % 10 == 3 && k / 10 >= lost { format!("{k},1\n") } else { format!("{k},\n") };
        let rows: String = (0..400).map(row).collect();
        let (_folder, path) = written("log.csv", format!("time,alpha\n{rows}"));
        let map = map("[roles]\nalpha = { channel = \"alpha\", unit = \"deg\" }\n");
        let warnings = read(&plan(&inspect(&path).unwrap(), &map)).unwrap().warnings;
        warnings.iter().map(ToString::to_string).filter(|warning| warning.contains("not finite")).collect()
    };
    assert_eq!(warnings(0), Vec::<String>::new());
    // Fewer than ten samples show no rate.
    assert!(warnings(35)[0].contains("395 of 400 samples are not finite"), "{:?}", warnings(35));
}

#[test]
fn a_plan_lists_every_problem_before_reading() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("time", "0\n1\n2\n"), ("q", "1\n2\n3\n"), ("short", "1\n2\n")] {
        std::fs::write(folder.path().join(format!("{name}.csv")), text).unwrap();
    }
    let probe = probe(folder.path()).unwrap();
    let map = map(
        "[roles]\nq = { channel = \"q\" }\nr = { channel = \"short\", unit = \"rad/s\" }\np = { channel = \"Q\", unit = \"rad/s\" }\n\
         phi = { channel = \"gone\", unit = \"rad\", optional = true }\n",
    );
    let plan = plan(&probe, &map);
    let text: Vec<String> = plan.problems.iter().map(ToString::to_string).collect();
    assert_eq!(plan.problems.iter().filter(|problem| problem.is_error).count(), 3, "{text:?}");
    let all = text.join("\n");
    assert!(all.contains("q: ") && all.contains("no recorded unit; give 'unit' in the map (line 5)"), "{all}");
    assert!(all.contains("short has 2 samples, 'time' has 3"), "{all}");
    assert!(all.contains("no channel 'Q'") && all.contains("there is 'q'"), "{all}");
    assert!(all.contains("no channel 'gone'"), "{all}");
    assert_line(&read(&plan).unwrap_err(), &["p: no channel", "q: ", "r: "]);
}

#[test]
fn recorded_units_are_checked() {
    let (_folder, path) = written("log.csv", "t [s],alpha [furlong],q [kt],r [deg/s]\n0,1,1,1\n1,2,2,2\n2,3,3,3\n");
    let probe = probe(&path).unwrap();
    let plan = plan(
        &probe,
        &map(
            "[roles]\nalpha = { channel = \"alpha\" }\nq = { channel = \"q\" }\nr = { channel = \"r\", unit = \"rad/s\" }\n",
        ),
    );
    let text = plan.problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(text.contains("unknown unit 'furlong'"), "{text}");
    assert!(text.contains("is in kt, which does not convert to rad/s"), "{text}");
    assert!(text.contains("was recorded in deg/s, the map's rad/s is used"), "{text}");
}

#[test]
fn two_files_with_one_role_are_named_both() {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["first.csv", "second.csv"].map(|name| folder.path().join(name));
    for path in &paths {
        std::fs::write(path, "t,q,a\n0,1,1\n1,2,2\n2,3,3\n").unwrap();
    }
    let roles = "[roles]\nq = { channel = \"q\", unit = \"rad/s\" }\n";
    assert_line(&read_all(&paths, &map(roles)).unwrap_err(), &["first.csv", "second.csv", "name the source"]);
    let both = map(
        "[roles]\nq = { source = \"first\", channel = \"q\", unit = \"rad/s\" }\nr = { source = \"second\", channel = \"q\", unit = \"rad/s\" }\n",
    );
    let recording = read_all(&paths, &both).unwrap();
    assert_eq!(recording.role(Role::YawRate).unwrap().source, "second");
    assert_eq!(recording.channels.len(), 4, "two mapped, two as recorded");
    let overlapping =
        plan_all(&paths.map(|path| probe(&path).unwrap()), &map(&format!("join_in_time = true\n{roles}")));
    assert!(overlapping.problems[0].text.contains("ends at 2 s, after"), "{:?}", overlapping.problems);
}

#[test]
fn position_is_not_derived_across_clocks() {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["gps.csv", "baro.csv"].map(|name| folder.path().join(name));
    std::fs::write(&paths[0], "t,lat,lon\n0,48,11\n1,48,11\n2,48,11\n").unwrap();
    std::fs::write(&paths[1], "t,h\n0,100\n2,110\n").unwrap();
    let map = map(
        "[roles]\nlatitude = { channel = \"lat\", unit = \"deg\" }\nlongitude = { channel = \"lon\", unit = \"deg\" }\n\
         altitude = { channel = \"h\", unit = \"ft\" }\n[derive.position]\naltitude = \"altitude\"\n",
    );
    assert_line(&read_all(&paths, &map).unwrap_err(), &["altitude has another clock than latitude"]);
}

#[test]
fn maps_are_refused_with_their_line() {
    assert_map("sauce = \"*\"\n", 4, &["unknown field", "sauce"]);
    assert_map("[roles]\nalfa = { channel = \"a\", unit = \"deg\" }\n", 5, &["unknown role 'alfa'", "alpha"]);
    assert_map("[roles]\nalpha = { channel = \"a\", unit = \"dog\" }\n", 5, &["unknown unit 'dog'"]);
    assert_map("[roles]\nalpha = { channel = \"a\", unit = \"kt\" }\n", 5, &["'kt'", "rad"]);
    assert_map("[roles]\nalpha = { channel = \"a\", sine = 1 }\n", 5, &["sine"]);
    assert_map("[roles]\nalpha = { unit = \"deg\" }\n", 5, &["'channel' or 'sum'"]);
    assert_map("[roles]\nalpha = { channel = \"a\", sign = 2 }\n", 5, &["sign is 1 or -1"]);
    assert_map("\n[[time]]\nsample_rate = 0.0\n", 5, &["more than 0 Hz"]);
    assert_map("[[time]]\nchannel = \"t\"\nutc_start = \"noon\"\n", 6, &["'noon'"]);
    assert_map("[truth]\nu = { channel = \"a\" }\n", 5, &["needs its unit"]);
    assert_map("roles = 3 4\n", 4, &[]);
    let newer = ChannelMap::parse("format = \"doublet channel map\"\nversion = 9\nname = \"x\"\n").unwrap_err();
    assert_line(&newer, &["line 2", "version 9"]);
}

#[test]
fn a_mutated_map_gives_a_map_or_a_line() {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(11);
    let mut refused = 0;
    for (_, text) in ChannelMap::shipped() {
        for _ in 0..200 {
            let mut changed = text.as_bytes().to_vec();
            let at = random.random_range(0..changed.len());
            changed[at] = random.random_range(9..127);
            if let Err(error) = ChannelMap::parse(&String::from_utf8_lossy(&changed)) {
                assert_line(&error, &["channel map, line "]);
                refused += 1;
            }
        }
    }
    assert!(refused > 100, "only {refused} of 1000 changed maps were refused");
}

#[test]
fn line_ends_and_quotes_of_text_are_read_or_refused() {
    let names = |probe: &doublet_core::load::Probe| {
        probe.sources[0].channels.iter().map(|channel| channel.name.clone()).collect::<Vec<_>>()
    };
    let rows = |end: &str| (0..30).map(|i| format!("{}.5,{},{}{end}", i, 2 * i, 3 * i)).collect::<String>();
    let (_folder, path) = written("returns.csv", format!("t,alpha,q\r{}", rows("\r")));
    let probe = inspect(&path).unwrap();
    assert_eq!(
        (names(&probe), probe.sources[0].channels[1].samples),
        (vec!["t".into(), "alpha".into(), "q".into()], 30)
    );
    // A line end inside a quoted name.
    let (_folder, path) = written("name.csv", format!("t,\"angle of\nattack\",q\n{}", rows("\n")));
    let probe = inspect(&path).unwrap();
    assert_eq!(
        (names(&probe), probe.sources[0].channels[1].values()[29]),
        (vec!["t".into(), "angle of attack".into(), "q".into()], 58.0)
    );
    // A quote that nothing closes.
    let (_folder, path) = written("open.csv", format!("t,\"alpha,q\n{}", rows("\n")));
    let probe = inspect(&path).unwrap();
    assert_eq!(names(&probe).iter().map(|name| name.replace('"', "")).collect::<Vec<_>>(), ["t", "alpha", "q"]);
    assert_eq!(probe.sources[0].channels[2].samples, 30);
    let broken = rows("\n").replacen(",20,", ",\"20,", 1);
    let (_folder, path) = written("row.csv", format!("t,alpha,q\n{broken}"));
    assert_line(&inspect(&path).unwrap_err(), &["row.csv", "line 12", "quote"]);
    // One that was cut off inside its last line.
    let (_folder, path) = written("cut.csv", format!("t,alpha,q\n{}\"30.5,\"6", rows("\n")));
    assert!(inspect(&path).is_ok_and(|probe| probe.sources[0].channels[0].samples >= 30));
}
