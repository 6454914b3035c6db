//! `doublet map` and `doublet new --guess`: a recording of unknown names becomes a session.

use std::path::Path;

use doublet_core::load::ChannelMap;
use doublet_core::quantity::Role;

use crate::common::{doublet, root};
use crate::shared;

/// Standard output of a command and its exit code.
fn run_doublet(arguments: &[&str]) -> (String, Option<i32>) {
    let output = doublet(&root(), arguments);
    (String::from_utf8(output.stdout).unwrap(), output.status.code())
}

fn written(folder: &Path, text: &str) -> String {
    written_as(folder, "log.csv", text)
}

fn written_as(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn guessed_map_has_a_reason_for_every_row_and_is_a_map() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..500).map(|k| format!("{},{},{}\n", 0.02 * f64::from(k), k % 50, k % 9)).collect();
    let path = written(folder.path(), &format!("time [s],Pitch,q_dps\n{rows}"));
    let (text, code) = run_doublet(&["map", &path]);
    assert_eq!(code, Some(0));
    let map = ChannelMap::parse(&text).unwrap();
    assert_eq!(map.roles.keys().copied().collect::<Vec<_>>(), [Role::PitchRate, Role::PitchAngle]);
    assert!(
        text.contains("# q: 'q_dps' of log by its name, unit from the end of its name: 0 to 8.000 deg/s"),
        "{text}"
    );
    assert!(text.contains("# theta: 'Pitch' of log by its name, unit guessed from its values"), "{text}");
    let file = folder.path().join("map.toml");
    let write = ["map", &path, "--write", file.to_str().unwrap()];
    assert_eq!(run_doublet(&write).1, Some(0));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
    assert_eq!(run_doublet(&write).1, Some(1), "a map is never overwritten");
}

#[test]
fn shipped_maps_are_listed_and_shown() {
    let (list, _) = run_doublet(&["map", "--list"]);
    for name in list.lines() {
        let (text, code) = run_doublet(&["map", "--show", name]);
        assert_eq!(code, Some(0), "{name}");
        ChannelMap::parse(&text).unwrap();
    }
    assert!(list.lines().any(|name| name == "attas"), "{list}");
    assert_eq!(run_doublet(&["map", "--show", "nobody"]).1, Some(1));
}

#[test]
fn recordings_of_strangers_become_sessions_that_hold_the_guess() {
    let Some(folder) = shared::shared("data/formats") else { return };
    let out = tempfile::tempdir().unwrap();
    for file in [
        "generic_csv/05_units_row.csv",
        "generic_csv/10_quoted_commas_in_names.csv",
        "mdf4/three_groups_dz_deflate.mf4",
    ] {
        let recording = folder.join(file);
        let session = out.path().join(format!("{}.toml", file.replace(['/', '.'], "_")));
        let (recording, session) = (recording.to_str().unwrap(), session.to_str().unwrap());
        let (text, code) = run_doublet(&["new", recording, "--guess", "-o", session]);
        assert_eq!(code, Some(0), "{file}: {text}");
        assert!(text.contains("manoeuvres found: "), "{file}: {text}");
        let results = session.replace(".toml", "");
        let (_, code) = run_doublet(&["run", session, "--out", &results]);
        assert!(matches!(code, Some(0 | 3)), "{file}: {code:?}");
        let results = std::fs::read_to_string(Path::new(&results).join("results.json")).unwrap();
        let results: serde_json::Value = serde_json::from_str(&results).unwrap();
        assert!(results["windows"].as_array().is_some_and(|windows| !windows.is_empty()), "{file}");
    }
    let ambiguous = folder.join("generic_csv/17_1khz_in_ms.csv");
    let session = out.path().join("ambiguous.toml");
    let (text, code) = run_doublet(&["new", ambiguous.to_str().unwrap(), "--guess", "-o", session.to_str().unwrap()]);
    assert_eq!((code, session.exists()), (Some(3), false), "{text}");
    assert!(text.contains("in milliseconds 1000 Hz over 3 s"), "{text}");
}

#[test]
fn what_comes_with_the_program_is_named_with_and_without_its_prefix() {
    let out = tempfile::tempdir().unwrap();
    let recording = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/flights/demo/pod.csv");
    for aircraft in ["attas_vfw614", "builtin:attas_vfw614"] {
        let session = out.path().join(format!("{}.toml", aircraft.replace(':', "_")));
        let (recording, place) = (recording.to_str().unwrap(), session.to_str().unwrap());
        let (text, code) = run_doublet(&["new", recording, "--guess", "--aircraft", aircraft, "-o", place]);
        assert_eq!(code, Some(0), "{text}");
        assert!(std::fs::read_to_string(session).unwrap().contains("aircraft = \"builtin:attas_vfw614\""));
    }
}

/// Channels of a recorder that writes pulses of servos, in the pulses and rounding of its kind: deflections are said by `--role`.
#[test]
fn roles_said_on_the_command_line_take_the_place_of_the_guess() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..500).map(|k| format!("{},{},{}\n", 0.02 * f64::from(k), k % 50, 1500 + k % 9)).collect();
    let path = written(folder.path(), &format!("time [s],elevator,C2 [us]\n{rows}"));
    let role = "delta_e=C2,unit=deg,scale=-0.07,offset=-1500";
    let (text, code) = run_doublet(&["map", &path, "--role", role]);
    assert_eq!(code, Some(0), "{text}");
    let map = ChannelMap::parse(&text).unwrap();
    assert_eq!(map.roles.keys().copied().collect::<Vec<_>>(), [Role::Elevator]);
    let row = "'C2' of log by its name, unit instead of the recorded unit, sign reversed, scale 0.07, offset -1500 deg: \
               -0.5600 to 0 deg";
    assert!(text.contains(row), "{text}");
    for (option, answer) in [
        ("delta_e=C9", "no channel 'C9' there"),
        ("delta_e=C2,unit=kg", "delta_e is in rad, not in kg"),
        ("lift=C2", "role 'lift' not found"),
    ] {
        let output = doublet(&root(), &["map", &path, "--role", option]);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(error.contains(answer), "{option}: {error}");
    }
}

/// Deflections without a unit that can be radians or a part of full travel beside angles in degrees: asked for, until `--role` says it.
#[test]
fn deflection_that_can_be_two_things_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let log = |part: f64| {
        let row = |k: i32| format!("{},{},{}\n", 0.02 * f64::from(k), k % 50, part * f64::from(k % 9));
        written(folder.path(), &format!("time [s],Pitch,elevator\n{}", (0..500).map(row).collect::<String>()))
    };
    for (part, asked) in
        [(0.05, Some("radians or fractions of full travel")), (10.0, Some("degrees or per cent")), (2.0, None)]
    {
        let path = log(part);
        let session = folder.path().join(format!("{part}.toml"));
        let session = session.to_str().unwrap();
        let (text, code) = run_doublet(&["new", &path, "--guess", "-o", session]);
        assert_eq!(code, Some(if asked.is_some() { 3 } else { 0 }), "{part}: {text}");
        assert!(asked.is_none_or(|words| text.contains(words)), "{part}: {text}");
        let (text, code) =
            run_doublet(&["new", &path, "--guess", "--role", "delta_e=elevator,unit=deg,scale=20", "-o", session]);
        let exists = asked.is_none();
        assert_eq!(code, Some(i32::from(exists)), "{part}: {text}");
    }
}

#[test]
fn names_file_beside_recording_or_session_gives_roles_and_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..500).map(|k| format!("{},{},{}\n", 0.02 * f64::from(k), k % 50, k % 9)).collect();
    let path = written(folder.path(), &format!("time [s],Pitch [deg],Knueppel quer\n{rows}"));
    let roles = |path: &str| {
        let printed: serde_json::Value = serde_json::from_str(&run_doublet(&["map", path, "--json"]).0).unwrap();
        let roles = printed["roles"].as_array().unwrap().clone();
        let row = |row: &serde_json::Value| {
            (row["role"].as_str().unwrap().to_owned(), row["unit"].clone(), row["sign"].clone())
        };
        (roles.iter().map(row).collect::<Vec<_>>(), printed["names"].as_array().unwrap().len())
    };
    let theta = ("theta".to_owned(), "deg".into(), 1.into());
    assert_eq!(roles(&path), (vec![theta.clone()], 0));
    let names = "format = \"doublet names\"\nversion = 1\n[[names]]\nrole = \"delta_a\"\nwords = [\"Knueppel quer\"]\n";
    let file = folder.path().join("doublet-names.toml");
    std::fs::write(&file, format!("{names}unit = \"deg\"\nsign = -1\n")).unwrap();
    let aileron = ("delta_a".to_owned(), "deg".into(), (-1).into());
    assert_eq!(roles(&path), (vec![theta, aileron], 1));
    // Of a session elsewhere.
    let other = tempfile::tempdir().unwrap();
    std::fs::rename(&file, other.path().join("doublet-names.toml")).unwrap();
    let session = other.path().join("s.toml");
    let (text, code) = run_doublet(&["new", &path, "--guess", "-o", session.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("delta_a: 'Knueppel quer' of log by the names file"), "{text}");
    std::fs::write(&file, format!("{names}unit = \"kg\"\n")).unwrap();
    let output = doublet(&root(), &["map", &path]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && error.contains("line 6: delta_a is in rad, not in kg"), "{error}");
}

#[test]
fn role_has_its_confidence_and_the_channel_that_would_take_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..500).map(|k| format!("{},{},{},{}\n", 0.02 * f64::from(k), k % 50, k % 9, k % 7)).collect();
    let path = written(folder.path(), &format!("time [s],Pitch [deg],pod_pitch [deg],pitch_rate\n{rows}"));
    let printed: serde_json::Value = serde_json::from_str(&run_doublet(&["map", &path, "--json"]).0).unwrap();
    let row = |role: &str| printed["roles"].as_array().unwrap().iter().find(|row| row["role"] == role).unwrap().clone();
    let (theta, q) = (row("theta"), row("q"));
    assert_eq!((&theta["channel"], &theta["runner_up"]["channel"]), (&"Pitch".into(), &"pod_pitch".into()));
    assert!(theta["runner_up"]["reason"].as_str().unwrap().starts_with("only the end of the name fits"), "{theta}");
    assert_eq!(q["runner_up"], serde_json::Value::Null);
    // A unit that nothing states costs confidence.
    assert!(theta["confidence"].as_f64().unwrap() > 0.98 && q["confidence"].as_f64().unwrap() < 0.95, "{theta} {q}");
}

/// A time that no name says is asked for, until `--time` says it.
#[test]
fn time_said_on_the_command_line_is_the_clock_of_its_source() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..500).map(|k| format!("{},{},{}\n", k % 50, k % 9, 20 * k)).collect();
    let path = written(folder.path(), &format!("Pitch,q_dps,tick\n{rows}"));
    assert!(run_doublet(&["map", &path]).0.contains("no time channel recognised"));
    let (text, code) = run_doublet(&["map", &path, "--time", "tick,unit=ms"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(!text.contains("no time channel") && text.contains("channel = \"tick\""), "{text}");
    ChannelMap::parse(&text).unwrap();
    let output = doublet(&root(), &["map", &path, "--time", "tock"]);
    assert!(String::from_utf8(output.stderr).unwrap().contains("no channel 'tock' there"));
}

/// What a recording does not have is said: nothing is written of one without a role, and of others the roles that nothing goes without.
#[test]
fn recording_without_a_role_is_refused_and_missing_roles_are_said() {
    let folder = tempfile::tempdir().unwrap();
    let session = folder.path().join("s.toml");
    let rows: String = (0..500).map(|k| format!("{},{},{}\n", 0.02 * f64::from(k), k % 50, k % 9)).collect();
    for head in ["Time [s],foo,bar", "Bordrechner [s],foo,bar"] {
        let path = written(folder.path(), &format!("{head}\n{rows}"));
        let output = doublet(&root(), &["new", &path, "--guess", "-o", session.to_str().unwrap()]);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), session.exists()), (Some(1), false), "{error}");
        let reason = "none of its 2 channel names is recognised; `doublet inspect ";
        assert!(error.lines().count() == 1 && error.contains(reason), "{error}");
    }
    let path = written(folder.path(), &format!("Zeit [s],Rollrate [°/s],Höhenruder [°]\n{rows}"));
    let (text, code) = run_doublet(&["new", &path, "--guess", "-o", session.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("  missing, needed for the flight path: ax, ay, az, q, r; name them"), "{text}");
    assert!(text.contains("  missing, needed for control derivatives: delta_a, delta_r; name them"), "{text}");
}

/// A time that is no time of the forms read is asked for once, and by a map that names it the refusal is one line.
#[test]
fn time_that_is_not_understood_is_said_once() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..500).map(|k| format!("10h23m{k:03},{},{}\n", k % 50, k % 9)).collect();
    let path = written(folder.path(), &format!("Timestamp,p [deg/s],q [deg/s]\n{rows}"));
    let session = folder.path().join("s.toml");
    let session = session.to_str().unwrap();
    let (text, code) = run_doublet(&["new", &path, "--guess", "-o", session]);
    assert_eq!(code, Some(3), "{text}");
    assert_eq!(
        text.matches("'Timestamp' is not a time in a known format, for example '10h23m000'").count(),
        1,
        "{text}"
    );
    let map = folder.path().join("map.toml");
    let roles = "p = { channel = \"p\" }\nq = { channel = \"q\" }\n";
    let header =
        "format = \"doublet channel map\"\nversion = 1\nname = \"m\"\n[[time]]\nchannel = \"Timestamp\"\n[roles]\n";
    std::fs::write(&map, format!("{header}{roles}")).unwrap();
    let output = doublet(&root(), &["new", &path, "--map", map.to_str().unwrap(), "-o", session]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), Path::new(session).exists()), (Some(1), false), "{error}");
    assert_eq!((error.lines().count(), error.matches("is not a time in a known format").count()), (1, 1), "{error}");
}

/// A straight flight at 60 m/s: its receiver in one file, its altimeter in another, each with its own clock.
#[test]
fn altitude_of_another_recorder_is_position_down_beside_fixes() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str, text: String| written_as(folder.path(), name, &text);
    let fix = |k: i32| {
        let t = 0.1 * f64::from(k);
        format!("{t:.2},{:.7},8.0,{:.3}\n", 47.0 + 60.0 * t / 111_194.9, 2.0 * (0.5 * t).sin())
    };
    let height = |k: i32| {
        let t = 0.46 + 0.02 * f64::from(k);
        format!("{t:.2},{:.2},60.0\n", 1200.0 + 5.0 * (0.3 * t).sin())
    };
    let fixes: String = (0..400).map(fix).collect();
    let fixes = path("ins.csv", format!("Time [s],Latitude [deg],Longitude [deg],Pitch [deg]\n{fixes}"));
    let heights: String = (0..1900).map(height).collect();
    let heights = path("fti.csv", format!("Time [s],Altitude [m],TAS [m/s]\n{heights}"));
    let session = folder.path().join("s.toml");
    let (text, code) = run_doublet(&["new", &fixes, &heights, "--merge", "--guess", "-o", session.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{text}");
    assert!(!text.contains("another clock"), "{text}");
    assert!(text.contains("  z: 'Altitude' of fti by its name, unit as recorded, sign reversed: "), "{text}");
    let written = std::fs::read_to_string(&session).unwrap();
    assert!(
        written.contains(".channel_map.derive.position]") && !written.contains("altitude = \"altitude\""),
        "{written}"
    );
    // A map that takes the altitude into the fixes is refused, and that is no success.
    let roles = "[roles]\nlatitude = { channel = \"Latitude\" }\nlongitude = { channel = \"Longitude\" }\n\
                 altitude = { channel = \"Altitude\" }\n[derive.position]\naltitude = \"altitude\"\n";
    let map = path("map.toml", format!("format = \"doublet channel map\"\nversion = 1\nname = \"m\"\n{roles}"));
    let other = folder.path().join("t.toml");
    let (text, code) = run_doublet(&["new", &fixes, &heights, "--merge", "--map", &map, "-o", other.to_str().unwrap()]);
    assert_eq!(code, Some(3), "{text}");
    assert!(text.contains("altitude has another clock than latitude"), "{text}");
}

/// An inertial unit and an air data recorder, each with its own clock, that both have roll and pitch rate.
#[test]
fn recorders_that_only_together_have_all_rates_are_one_flight_on_one_time_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str, text: String| written_as(folder.path(), name, &text);
    // Sweeps: no other shift looks alike.
    let rates = |t: f64| [0.2 * (0.3 * t + 0.02 * t * t).sin(), 0.08 * (0.5 * t + 0.015 * t * t).cos()];
    let inertial = |k: i32| {
        let t = 0.02 * f64::from(k);
        let [p, q] = rates(t);
        format!("{:.2},0.2,0.1,{:.4},{p:.6},{q:.6},{:.6}\n", 412.5 + t, -9.8 - 20.0 * q, 0.1 * p)
    };
    let air = |k: i32| {
        let t = 0.04 * f64::from(k);
        let [p, q] = rates(t).map(f64::to_degrees);
        format!("{:.3},{:.2},{p:.4},{q:.4},{:.2}\n", 3.217 + t, 60.0 + (0.2 * t).sin(), -0.4 * q)
    };
    let inertial: String = (0..4000).map(inertial).collect();
    let inertial = path("imu.csv", format!("time_s,accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z\n{inertial}"));
    let air: String = (0..2000).map(air).collect();
    let air = path("air.csv", format!("time_s,tas_ms,roll_rate_dps,pitch_rate_dps,elevator_deg\n{air}"));
    let session = folder.path().join("s.toml");
    let (text, code) = run_doublet(&["new", &inertial, &air, "--guess", "-o", session.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{text}");
    let written: toml::Table = std::fs::read_to_string(&session).unwrap().parse().unwrap();
    let flights = written["flight"].as_array().unwrap();
    assert_eq!(flights.len(), 1, "{text}");
    let clock = &flights[0]["clock"][0];
    // 412.5 s less 3.217 s, as a start of the search that finds the rest.
    assert_eq!((clock["source"].as_str(), clock["offset_s"].as_float()), (Some("air"), Some(409.3)));
    let fitted: Vec<_> = clock["fit"].as_array().unwrap().iter().map(|pair| pair["other"].as_str().unwrap()).collect();
    assert_eq!(fitted, ["air/roll_rate_dps", "air/pitch_rate_dps"]);
    let starts = written["manoeuvre"].as_array().unwrap().iter().map(|one| one["start_s"].as_float().unwrap());
    assert!(starts.into_iter().all(|start_s| start_s >= 412.5), "manoeuvres lie on the time line of the inertial unit");
}

/// What a row makes of the values is said, and so is the sign that nothing documents.
#[test]
fn signs_that_are_taken_are_said_and_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let row = |k: i32| format!("{},{},{},{},1.0{}\n", 0.02 * f64::from(k), k % 50, k % 9, k % 7, k % 3);
    let rows: String = (0..500).map(row).collect();
    let path = written(folder.path(), &format!("time [s],Pitch [deg],acc_x [g],acc_y [g],acc_z [g]\n{rows}"));
    let session = folder.path().join("s.toml");
    let (text, code) = run_doublet(&["new", &path, "--guess", "-o", session.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("  az: 'acc_z' of log by its name, unit as recorded, sign reversed: -1.02"), "{text}");
    let question = "  question: log: the sign of 'acc_x', guessed as ax, is not documented: left as recorded; \
                    log: the sign of 'acc_y', guessed as ay, is not documented: left as recorded";
    assert!(text.contains(question), "{text}");
}
