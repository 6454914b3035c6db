//! A flight watched while it is flown: a simulated flight whose derivatives are known, sample by sample, with losses and from files.

#![expect(clippy::panic, clippy::unwrap_used, reason = "a test helper that fails is a failed test")]

use crate::mavlink;
use std::io::Write;
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use doublet_core::load::ChannelMap;
use doublet_core::load::stream::{MESSAGES, RoleSample, StreamMap, StreamRow};
use doublet_core::model::ThrustTreatment;
use doublet_core::quantity::Role;
use doublet_core::simulate::scenario::Start;
use doublet_core::simulate::{self, Scenario, scenario};
use doublet_engine::builtin;
use doublet_engine::graph::{Cache, Context};
use doublet_engine::live::{
    Feed, LineFormat, LivePipeline, LiveSettings, LiveUpdate, LiveWatch, Opening, Polled, open,
};
use doublet_engine::run::{Control, Scope, Snapshot, run};
use doublet_engine::session::{self, Flight, MapRef, RecordingRef, Session};
use doublet_engine::stage::LoadedFlight;
use doublet_engine::verdict::Level;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Onset of the inputs on all controls in the scenario `multisine`, s.
const ONSET_S: f64 = 20.0;

/// Folder with a flight of orthogonal multisines and `session.toml` over it, which takes deflections and flow angles from the truth.
static FLIGHT: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let flown = simulate::run(&scenario::build("multisine").unwrap(), 1, &mut |_| true).unwrap();
    flown.write(folder.path()).unwrap();
    let recording = |name: &str, map: &str| RecordingRef {
        path: name.to_owned(),
        sha256: None,
        channel_map: MapRef::File(format!("{}{map}", builtin::PREFIX)),
        only: None,
    };
    let recordings = vec![recording("bus.h5", "demo_flight"), recording("truth.h5", "demo_truth")];
    let demo = session::parse(builtin::session("demo").unwrap()).unwrap();
    let flights = vec![Flight::new("multisine".to_owned(), recordings)];
    let session = Session { flights, windows: Vec::new(), steady: Vec::new(), ..demo };
    session::save(&session, &folder.path().join("session.toml")).unwrap();
    folder
});

fn opening() -> Opening {
    Opening { session: Some(FLIGHT.path().join("session.toml").display().to_string()), ..Opening::default() }
}

/// Samples of the flight in the order of time, and the settings it is watched with.
fn samples() -> (Vec<RoleSample>, LiveSettings) {
    let mut watched = open(&opening()).unwrap();
    let mut map = StreamMap::new(ChannelMap::parse(&watched.map).unwrap());
    let (mut rows, mut samples) = (Vec::<StreamRow>::new(), Vec::new());
    while watched.source.poll(&mut rows).unwrap() == Polled::Rows {}
    rows.iter().for_each(|row| map.take(row, &mut samples));
    samples.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    (samples, watched.settings)
}

fn watch(samples: &[RoleSample], settings: LiveSettings) -> Vec<LiveUpdate> {
    let mut pipeline = LivePipeline::new(settings).unwrap();
    let mut updates = Vec::new();
    for piece in samples.chunks(100) {
        updates.extend(pipeline.push(piece.iter().copied()));
    }
    updates.extend(pipeline.finish());
    updates
}

/// Period of the Dutch roll of the true aircraft in its trim, s.
fn dutch_roll_period_s(scenario: &Scenario) -> f64 {
    let Start::Trimmed(condition) = &scenario.start else { panic!("the scenario begins in trim") };
    let body = scenario.vehicle.body(&scenario.loading).unwrap();
    let trim = simulate::trim(&scenario.vehicle, &body, &scenario.atmosphere, condition).unwrap();
    let modes = simulate::modes(&scenario.vehicle, &body, &trim);
    let dutch_roll = modes.iter().find(|mode| mode.name == "Dutch roll").unwrap();
    std::f64::consts::TAU / dutch_roll.imaginary_rad_s
}

fn estimate(update: &LiveUpdate, name: &str) -> (f64, f64) {
    let derivative = update.derivatives.iter().find(|derivative| derivative.name == name).unwrap();
    (derivative.estimate.unwrap(), derivative.standard_error.unwrap())
}

#[test]
fn estimates_converge_within_two_dutch_roll_periods_of_the_onset() {
    let (samples, settings) = samples();
    let scenario = scenario::build("multisine").unwrap();
    let period_s = dutch_roll_period_s(&scenario);
    let updates = watch(&samples, settings);
    // What two periods of the Dutch roll can tell: within a tenth of the truth, and within three of the errors stated.
    let names = [
        "Cl_beta", "Cl_p", "Cl_r", "Cl_delta_a", "Cn_beta", "Cn_p", "Cn_r", "Cn_delta_r", "CY_beta", "Cm_alpha",
        "Cm_delta_e",
    ];
    let truth = |name: &str| scenario.vehicle.aero.value(name).unwrap();
    let is_there = |update: &LiveUpdate, name: &str| (estimate(update, name).0 / truth(name) - 1.0).abs() < 0.1;
    let flown: Vec<&LiveUpdate> = updates.iter().filter(|update| update.time_s > ONSET_S).collect();
    for name in names {
        let last_off = flown.iter().rfind(|update| !is_there(update, name));
        let since_s = last_off.map_or(0.0, |update| update.time_s - ONSET_S);
        println!("{name}: within a tenth of the truth from {:.2} periods on", since_s / period_s);
        assert!(since_s < 2.0 * period_s, "{name}: {since_s} s, two periods are {} s", 2.0 * period_s);
    }
    let after = flown.iter().find(|update| update.time_s >= ONSET_S + 2.0 * period_s).unwrap();
    for name in names {
        let (value, error) = estimate(after, name);
        println!("{name}: {value:.4} +- {error:.4}, truth {:.4}", truth(name));
        assert!((value - truth(name)).abs() < 4.0 * error.max(0.01 * truth(name).abs()), "{name}: {value} {error}");
    }
}

#[test]
fn no_good_lamp_of_the_shipped_flight_is_beyond_three_of_its_errors_and_no_limit_is_passed_on_the_ground() {
    let demo = session::open(Path::new("builtin:demo")).unwrap();
    let scope =
        Scope { session: &demo.session, folder: &demo.folder, first: None, studies: &[], cause: "test", generation: 1 };
    let after = run(&scope, &Snapshot::default(), &Cache::new(0), &Control::default(), &|_| {});
    let pooled = after.pooled.ready().unwrap();
    let fits = || pooled.fits.iter().filter_map(|fit| fit.fit.as_ref().ok());
    let known =
        |name: &str| fits().find_map(|fit| Some(fit.estimates[fit.names.iter().position(|other| other == name)?]));
    let opening = Opening { session: Some("builtin:demo".to_owned()), ..Opening::default() };
    let watched = open(&opening).unwrap();
    let mut live = LiveWatch::new(watched.source, watched.map, watched.settings, None, None).unwrap();
    let (mut lamps, mut wrong) = (0, Vec::new());
    for update in follow(&mut live, usize::MAX, |_| ()) {
        let alarms = update.limits.iter().filter(|lamp| lamp.level == Level::Bad);
        assert!(update.is_airborne || alarms.count() == 0, "{} s: {:?}", update.time_s, update.limits);
        for lamp in update.derivatives.iter().filter(|lamp| lamp.level == Level::Good) {
            let Some(truth) = known(&lamp.name) else { continue };
            lamps += 1;
            let errors = (lamp.estimate.unwrap() - truth) / lamp.standard_error.unwrap();
            if errors.abs() > 3.0 {
                wrong.push(format!("{} s: {} {errors:.1}", update.time_s, lamp.name));
            }
        }
    }
    assert!(lamps > 50_000 && wrong.is_empty(), "{} of {lamps}: {wrong:?}", wrong.len());
}

#[test]
fn lost_samples_and_jitter_are_survived_with_their_effect_stated() {
    let (samples, settings) = samples();
    let clean = watch(&samples, settings.clone());
    let random = &mut ChaCha8Rng::seed_from_u64(5);
    // Packets are the samples of one moment; one in twenty is lost, the others come up to 200 ms late.
    let (mut arrivals, mut packet, mut lost) = (Vec::new(), (f64::NAN, false, 0.0), 0);
    for sample in &samples {
        if sample.time_s != packet.0 {
            packet = (sample.time_s, random.random_bool(0.05), random.random_range(0.0..0.2));
        }
        if packet.1 {
            lost += usize::from(sample.role == Role::RollRate);
        } else {
            arrivals.push((sample.time_s + packet.2, *sample));
        }
    }
    arrivals.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let arrived: Vec<RoleSample> = arrivals.into_iter().map(|(_, sample)| sample).collect();
    let jittered = watch(&arrived, settings.clone());
    let (one, other) = (clean.last().unwrap(), jittered.last().unwrap());
    // Nobody asked for limits: those of the aircraft's envelope are watched. 46.3 m/s at 1219.2 m are 43.6 m/s calibrated.
    let watched: Vec<&str> = one.limits.iter().map(|limit| limit.quantity.as_str()).collect();
    assert_eq!(watched, ["n_z", "calibrated_airspeed"]);
    let airspeed = &one.limits[1];
    assert!(airspeed.range.iter().all(|value| (value - 43.6).abs() < 4.0), "{airspeed:?}");
    assert_eq!((airspeed.low, airspeed.high), (Some(36.0), Some(102.0)));
    assert_eq!((other.counts.late, other.counts.restarts, one.counts.lost), (0, 0, 0));
    // The median interval counts what is missing, but for the ends.
    assert!((other.counts.lost as i64 - lost as i64).abs() <= 3, "{} {lost}", other.counts.lost);
    // Rates between samples that are there lose of the fastest motion what a straight line loses.
    let known = one.derivatives.iter().filter(|derivative| derivative.relative_error_percent.unwrap() < 4.0);
    let moved: Vec<(f64, f64)> = known
        .map(|derivative| {
            let moved = (estimate(other, &derivative.name).0 / derivative.estimate.unwrap() - 1.0).abs();
            let error = 0.01 * derivative.relative_error_percent.unwrap();
            println!("{}: moved by {:.1} %, known to {:.1} %", derivative.name, 100.0 * moved, 100.0 * error);
            (moved, error)
        })
        .collect();
    println!("{lost} lost of {}", one.counts.samples);
    // By a twentieth, or by no more than three of its errors.
    assert!(moved.len() > 12 && moved.iter().all(|(moved, error)| *moved < (3.0 * error).max(0.05)), "{moved:?}");
    // With less patience than the jitter some samples come too late, and this is counted.
    let hasty = watch(&arrived, LiveSettings { latency_s: 0.05, ..settings });
    assert!(hasty.last().unwrap().counts.late > 0, "{:?}", hasty.last().unwrap().counts);
}

#[test]
fn a_pause_begins_the_filter_anew_and_the_estimates_go_on() {
    let (samples, settings) = samples();
    let without = |sample: &&RoleSample| !(35.0..37.0).contains(&sample.time_s);
    let kept: Vec<RoleSample> = samples.iter().filter(without).copied().collect();
    let (clean, paused) = (watch(&samples, settings.clone()), watch(&kept, settings));
    let (one, other) = (clean.last().unwrap(), paused.last().unwrap());
    assert_eq!(other.counts.restarts, 1);
    for name in ["Cl_p", "Cn_beta", "Cm_delta_e"] {
        let ((estimate, error), (moved, _)) = (self::estimate(one, name), self::estimate(other, name));
        assert!((moved - estimate).abs() < 3.0 * error, "{name}: {estimate} {moved} {error}");
    }
}

#[test]
fn what_is_recorded_opens_as_a_session_with_the_same_roles() {
    let watched = open(&opening()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("day");
    let mut live = LiveWatch::new(watched.source, watched.map, watched.settings, None, None).unwrap();
    live.record(&place, watched.session.as_ref(), watched.aircraft.as_deref()).unwrap();
    let mut updates = 0;
    loop {
        let step = live.step(Instant::now()).unwrap();
        updates += step.updates.len();
        if step.is_finished {
            break;
        }
    }
    let path = live.finish().unwrap().unwrap().session;
    assert!(updates > 90, "{updates}");
    let opened = session::open(&path).unwrap();
    let read = |session: &Session, folder: &Path| {
        Context::new(folder).get::<LoadedFlight>(&session.flights[0], ()).unwrap().recording.clone()
    };
    let again = read(&opened.session, &opened.folder);
    let own = session::open(&FLIGHT.path().join("session.toml")).unwrap();
    let before = read(&own.session, &own.folder);
    assert_eq!(again.roles.keys().collect::<Vec<_>>(), before.roles.keys().collect::<Vec<_>>());
    for role in before.roles.keys() {
        let (one, other) = (&before.role(*role).unwrap().series, &again.role(*role).unwrap().series);
        assert_eq!((&one.time_s, &one.values), (&other.time_s, &other.values), "{}", role.name());
    }
    assert_eq!(opened.session.filter.measurement_noise, own.session.filter.measurement_noise);
    assert!(live_again_refuses(&place));
}

/// A program that is killed leaves the session that was written while it watched, and which runs.
#[test]
fn a_session_is_written_within_the_first_minute_and_renewed_each_minute() {
    let folder = tempfile::tempdir().unwrap();
    let (source, place) = (folder.path().join("growing.csv"), folder.path().join("day"));
    let lines = text();
    std::fs::write(&source, lines[..200].join("\n") + "\n").unwrap();
    let opening = Opening {
        feed: Some(Feed::File(source.display().to_string())),
        map: Some(map_in(folder.path()).display().to_string()),
        aircraft: Some("c337f".to_owned()),
        wait: Some(Duration::from_secs(300)),
        ..Opening::default()
    };
    let watched = open(&opening).unwrap();
    let mut live = LiveWatch::new(watched.source, watched.map, watched.settings, None, None).unwrap();
    live.record(&place, None, watched.aircraft.as_deref()).unwrap();
    let session = place.join("session.toml");
    let start = Instant::now();
    let mut step_at = |seconds: u64| live.step(start + Duration::from_secs(seconds)).unwrap();
    step_at(0);
    assert!(!session.exists());
    assert!(step_at(59).updates.iter().any(|update| update.alarms == ["no data for 59 s"]));
    let first = session::open(&session).unwrap().session.windows[0].window;
    // Rows out of order are in the recording as they came.
    let mut file = std::fs::OpenOptions::new().append(true).open(&source).unwrap();
    let more = [&lines[200..380], &lines[390..400], &lines[380..390], &lines[400..]].concat();
    file.write_all((more.join("\n") + "\n").as_bytes()).unwrap();
    assert!(
        [60, 61, 62, 130]
            .map(&mut step_at)
            .iter()
            .flat_map(|step| &step.updates)
            .all(|update| update.counts.reordered == 10)
    );
    let opened = session::open(&session).unwrap();
    let window = opened.session.windows[0].window;
    assert!(window.start_s == first.start_s && window.end_s > first.end_s + 5.0, "{first:?} {window:?}");
    let session = &opened.session;
    let scope = Scope { session, folder: &opened.folder, first: None, studies: &[], cause: "test", generation: 1 };
    let found = run(&scope, &Snapshot::default(), &Cache::new(0), &Control::default(), &|_| {});
    assert!(found.windows.values().all(|one| one.path.ready().is_some()), "{:?}", found.failures());
}

/// Whether a recording is refused where there is one already.
fn live_again_refuses(place: &Path) -> bool {
    let watched = open(&opening()).unwrap();
    let mut live = LiveWatch::new(watched.source, watched.map, watched.settings, None, None).unwrap();
    live.record(place, None, None).is_err()
}

/// Steps until `enough` updates came or patience ends.
fn follow(live: &mut LiveWatch, enough: usize, mut between: impl FnMut(usize)) -> Vec<LiveUpdate> {
    let (start, mut updates) = (Instant::now(), Vec::new());
    for round in 0.. {
        between(round);
        let step = live.step(Instant::now()).unwrap();
        updates.extend(step.updates);
        if step.is_finished || updates.len() >= enough {
            break;
        }
        assert!(start.elapsed() < Duration::from_secs(240), "{} updates", updates.len());
        std::thread::sleep(step.rest.unwrap_or_default());
    }
    updates
}

/// Roles that are sent; the altitude by MAVLink alone.
const ROLES: [Role; 13] = [
    Role::SpecificForceX,
    Role::SpecificForceY,
    Role::SpecificForceZ,
    Role::RollRate,
    Role::PitchRate,
    Role::YawRate,
    Role::TrueAirspeed,
    Role::AngleOfAttack,
    Role::Sideslip,
    Role::Elevator,
    Role::Aileron,
    Role::Rudder,
    Role::Altitude,
];

/// The first seconds of the flight as text by role names in SI, inertial channels and what comes with them.
pub fn text() -> Vec<String> {
    let (samples, _) = samples();
    let mut lines = vec!["time,ax,ay,az,p,q,r,airspeed,alpha,beta,delta_e,delta_a,delta_r".to_owned()];
    let roles = &ROLES[..12];
    let mut latest = [f64::NAN; 12];
    for sample in samples.iter().filter(|sample| sample.time_s < 12.0) {
        if let Some(at) = roles.iter().position(|role| *role == sample.role) {
            latest[at] = sample.value;
            if sample.role == Role::YawRate && latest.iter().all(|value| value.is_finite()) {
                let cells: Vec<String> = latest.iter().map(f64::to_string).collect();
                lines.push(format!("{},{}", sample.time_s, cells.join(",")));
            }
        }
    }
    lines
}

/// The channel map of these lines, written into a folder.
pub fn map_in(folder: &Path) -> PathBuf {
    let map = folder.join("map.toml");
    let roles = ["ax", "ay", "az", "p", "q", "r", "airspeed", "alpha", "beta", "delta_e", "delta_a", "delta_r"];
    let units = ["m/s^2", "m/s^2", "m/s^2", "rad/s", "rad/s", "rad/s", "m/s", "rad", "rad", "rad", "rad", "rad"];
    let rows: Vec<String> = roles
        .iter()
        .zip(units)
        .map(|(role, unit)| format!("{role} = {{ channel = \"{role}\", unit = \"{unit}\" }}"))
        .collect();
    let header = "format = \"doublet channel map\"\nversion = 1\nname = \"own\"\n[[time]]\nsource = \"*\"\nchannel = \"time\"\nunit = \"s\"\n[roles]\n";
    std::fs::write(&map, format!("{header}{}\n", rows.join("\n"))).unwrap();
    map
}

#[test]
fn a_file_is_followed_while_it_grows_and_ends_when_nothing_comes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("growing.csv");
    let lines = text();
    let head = lines[..30].join("\n") + "\n";
    std::fs::write(&path, head).unwrap();
    let map = map_in(folder.path());
    let opening = Opening {
        feed: Some(Feed::File(path.display().to_string())),
        map: Some(map.display().to_string()),
        aircraft: Some("c337f".to_owned()),
        wait: Some(Duration::from_millis(300)),
        ..Opening::default()
    };
    let watched = open(&opening).unwrap();
    let mut live = LiveWatch::new(watched.source, watched.map, watched.settings, None, opening.wait).unwrap();
    let mut file = std::fs::OpenOptions::new().append(true).open(&path).unwrap();
    let mut pieces = lines[30..].chunks(20);
    let updates = follow(&mut live, usize::MAX, |_| {
        if let Some(piece) = pieces.next() {
            file.write_all((piece.join("\n") + "\n").as_bytes()).unwrap();
        }
    });
    let last = updates.last().unwrap();
    let end: f64 = lines.last().unwrap().split(',').next().unwrap().parse().unwrap();
    assert!((last.time_s - end).abs() < 1e-9, "{} {end}", last.time_s);
    assert_eq!(last.counts.samples as usize, lines.len() - 2, "each line once");
    assert!(updates.len() > 15 && last.derivatives.iter().any(|derivative| derivative.name == "Cl_p"));
}

#[test]
fn lines_by_udp_are_watched_as_json_and_as_text() {
    for is_json in [false, true] {
        let opening = Opening {
            feed: Some(Feed::Lines("127.0.0.1:0".to_owned(), LineFormat::Any)),
            aircraft: Some("c337f".to_owned()),
            ..Opening::default()
        };
        let watched = open(&opening).unwrap();
        let wait = Some(Duration::from_millis(400));
        let mut live = LiveWatch::new(watched.source, watched.map, watched.settings, None, wait).unwrap();
        let address = live.address().unwrap();
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        let lines = text();
        let names: Vec<&str> = lines[0].split(',').collect();
        let mut to_send = lines.iter().skip(usize::from(is_json));
        let updates = follow(&mut live, usize::MAX, |_| {
            for line in to_send.by_ref().take(20) {
                let pairs: Vec<String> =
                    names.iter().zip(line.split(',')).map(|(name, value)| format!("\"{name}\": {value}")).collect();
                let datagram = if is_json { format!("{{{}}}", pairs.join(", ")) } else { line.clone() };
                socket.send_to(datagram.as_bytes(), address).unwrap();
            }
        });
        let last = updates.last().unwrap();
        assert_eq!(last.counts.samples as usize, lines.len() - 2, "json {is_json}: each line once");
        assert!(last.findings.iter().all(|finding| !finding.contains("understood")), "{:?}", last.findings);
    }
}

/// Stretch of the flight that is sent as MAVLink, s: rest, then the inputs.
const SENT_S: std::ops::Range<f64> = 17.0..40.0;

/// The flight as MAVLink 2, the packets of one moment together, servo steps of 0.025 deg.
fn telemetry() -> Vec<(f64, Vec<u8>)> {
    let (samples, _) = samples();
    let (mut latest, mut sequence, mut sent) = ([f64::NAN; 13], 0_u8, Vec::new());
    for sample in samples.iter().filter(|sample| SENT_S.contains(&sample.time_s)) {
        let Some(at) = ROLES.iter().position(|role| *role == sample.role) else { continue };
        latest[at] = sample.value;
        if sample.role != Role::YawRate || latest.iter().any(|value| !value.is_finite()) {
            continue;
        }
        let [ax, ay, az, p, q, r, airspeed, alpha, beta, elevator, aileron, rudder, altitude] = latest;
        let time_us = (sample.time_s * 1e6).round();
        let servo = |rad: f64| (1500.0 + rad.to_degrees() / 0.025).round();
        let imu = [time_us, ax, ay, az, p, q, r, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 63.0];
        let servos = [time_us, servo(aileron), servo(elevator), 1500.0, servo(rudder), 0.0, 0.0, 0.0, 0.0, 0.0];
        let flow = [time_us, alpha.to_degrees(), beta.to_degrees()];
        let messages: [(&str, &[f64]); 4] = [
            ("HIGHRES_IMU", &imu),
            ("VFR_HUD", &[airspeed, airspeed, altitude, 0.0, 0.0, 0.0]),
            ("AOA_SSA", &flow),
            ("SERVO_OUTPUT_RAW", &servos),
        ];
        let mut packets = Vec::new();
        for (name, values) in messages {
            let message = MESSAGES.iter().find(|message| message.name == name).unwrap();
            packets.extend(mavlink::packet(message, values, 2, sequence));
            sequence = sequence.wrapping_add(1);
        }
        sent.push((sample.time_s, packets));
    }
    sent
}

/// A channel map of that telemetry.
fn telemetry_map() -> String {
    let mut map = String::from(
        "format = \"doublet channel map\"\nversion = 1\nname = \"own\"\n[[time]]\nsource = \"*\"\nchannel = \"time\"\nunit = \"s\"\n[roles]\n",
    );
    let imu = [("ax", "xacc"), ("ay", "yacc"), ("az", "zacc"), ("p", "xgyro"), ("q", "ygyro"), ("r", "zgyro")];
    let mut role = |name: &str, source: &str, channel: &str, rest: &str| {
        map.push_str(&format!("{name} = {{ source = \"{source}\", channel = \"{channel}\", {rest} }}\n"));
    };
    for (name, channel) in imu {
        let unit = if name.starts_with('a') { "m/s^2" } else { "rad/s" };
        role(name, "HIGHRES_IMU", channel, &format!("unit = \"{unit}\""));
    }
    role("airspeed", "VFR_HUD", "airspeed", "unit = \"m/s\"");
    role("altitude", "VFR_HUD", "alt", "unit = \"m\"");
    role("alpha", "AOA_SSA", "AOA", "unit = \"deg\"");
    role("beta", "AOA_SSA", "SSA", "unit = \"deg\"");
    for (name, channel) in [("delta_a", "servo1_raw"), ("delta_e", "servo2_raw"), ("delta_r", "servo4_raw")] {
        role(name, "SERVO_OUTPUT_RAW", channel, "unit = \"deg\", offset = -1500, scale = 0.025");
    }
    map
}

#[test]
fn mavlink_by_udp_gives_the_estimates_of_the_same_packets_in_a_log() {
    let folder = tempfile::tempdir().unwrap();
    let (log, map) = (folder.path().join("flight.tlog"), folder.path().join("map.toml"));
    let sent = telemetry();
    let mut bytes = Vec::new();
    for (time_s, packets) in &sent {
        // A log has the time of the clock before every packet.
        let mut rest = &packets[..];
        while !rest.is_empty() {
            let (packet, after) = rest.split_at(12 + usize::from(rest[1]));
            bytes.extend((1_700_000_000_000_000_u64 + (time_s * 1e6) as u64).to_be_bytes());
            bytes.extend(packet);
            rest = after;
        }
    }
    std::fs::write(&log, bytes).unwrap();
    std::fs::write(&map, telemetry_map()).unwrap();
    // Nothing of the engines is sent: thrust stays in the coefficients.
    let mut session = session::open(&FLIGHT.path().join("session.toml")).unwrap().session;
    session.preparation.thrust = ThrustTreatment::Included;
    let own = folder.path().join("session.toml");
    std::fs::write(&own, session::print(&session).unwrap()).unwrap();
    let watch = |place: String| {
        let opening = Opening {
            feed: Some(Feed::Mavlink(place)),
            map: Some(map.display().to_string()),
            session: Some(own.display().to_string()),
            ..Opening::default()
        };
        let watched = open(&opening).unwrap();
        let wait = Some(Duration::from_millis(400));
        LiveWatch::new(watched.source, watched.map, watched.settings, None, wait).unwrap()
    };
    let from_log = follow(&mut watch(log.display().to_string()), usize::MAX, |_| {});
    let mut live = watch("127.0.0.1:0".to_owned());
    let (address, socket) = (live.address().unwrap(), UdpSocket::bind("127.0.0.1:0").unwrap());
    let mut to_send = sent.iter();
    let by_udp = follow(&mut live, usize::MAX, |_| {
        for (_, packets) in to_send.by_ref().take(20) {
            socket.send_to(packets, address).unwrap();
        }
    });
    let (one, other) = (from_log.last().unwrap(), by_udp.last().unwrap());
    assert_eq!((one.counts, one.time_s), (other.counts, other.time_s));
    assert_eq!((one.counts.lost, one.counts.late, one.counts.restarts), (0, 0, 0));
    let scenario = scenario::build("multisine").unwrap();
    let mut told = 0;
    for derivative in &one.derivatives {
        let (Some(_), Some(_)) = (derivative.estimate, derivative.standard_error) else { continue };
        let ((log, error), (udp, _)) = (estimate(one, &derivative.name), estimate(other, &derivative.name));
        assert!((log - udp).abs() <= 1e-9 * log.abs(), "{}: {log} from the log, {udp} by UDP", derivative.name);
        // What is known well is near the truth: a servo step is a tenth of a standard deviation of the inputs.
        let truth = scenario.vehicle.aero.value(&derivative.name).unwrap();
        if error < 0.05 * log.abs() {
            told += 1;
            println!("{}: {log:.4} +- {error:.4}, truth {truth:.4}", derivative.name);
            assert!(
                (log - truth).abs() < 5.0 * error + 0.05 * truth.abs(),
                "{}: {log} {error} {truth}",
                derivative.name
            );
        }
    }
    assert!(told > 8, "{told}");
}

#[test]
fn what_cannot_be_watched_is_refused_in_one_line() {
    let refused = |opening: Opening| open(&opening).err().unwrap();
    assert!(refused(Opening::default()).contains("no data source"));
    let file = |name: &str| Opening { feed: Some(Feed::File(name.to_owned())), ..Opening::default() };
    assert!(refused(file("/nowhere/at/all.csv")).contains("/nowhere/at/all.csv"));
    let lines = Feed::Lines("nowhere:port".to_owned(), LineFormat::Any);
    assert!(refused(Opening { feed: Some(lines), ..Opening::default() }).contains("address"));
    let aircraft = Opening { aircraft: Some("nothing".to_owned()), ..opening() };
    assert!(!refused(aircraft).contains('\n'));
}
