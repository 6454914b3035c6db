//! Alarms of a live stream that is silent, as a whole or in part.

#![allow(clippy::unwrap_used, reason = "helpers of tests are not marked as tests")]

use std::net::UdpSocket;
use std::time::{Duration, Instant};

use doublet_engine::live::{Feed, LineFormat, LiveSettings, LiveWatch, Opening, open};

use crate::live::text;

/// A stream of JSON by UDP from the socket returned, with rates, forces and airspeed of the source `imu` and flow angles of `air`.
fn streamed(settings: impl FnOnce(&mut LiveSettings), wait: Option<Duration>) -> (LiveWatch, UdpSocket) {
    let opening = Opening {
        feed: Some(Feed::Lines("127.0.0.1:0".to_owned(), LineFormat::Json)),
        aircraft: Some("c337f".to_owned()),
        ..Opening::default()
    };
    let mut watched = open(&opening).unwrap();
    settings(&mut watched.settings);
    let live = LiveWatch::new(watched.source, watched.map, watched.settings, None, wait).unwrap();
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.connect(live.address().unwrap()).unwrap();
    (live, socket)
}

/// Sends the values of a row of [`text`] that belong to a source.
fn send(socket: &UdpSocket, (header, line): (&str, &str), source: &str) {
    let is_air = |name: &str| ["alpha", "beta"].contains(&name);
    let is_own = |name: &str| name == "time" || is_air(name) == (source == "air");
    let cells = header.split(',').zip(line.split(',')).filter(|(name, _)| is_own(name));
    let pairs: Vec<String> = cells.map(|(name, value)| format!("\"{name}\": {value}")).collect();
    socket.send(format!("{{\"source\": \"{source}\", {}}}", pairs.join(", ")).as_bytes()).unwrap();
}

#[test]
fn a_stream_of_which_nothing_ever_comes_gives_an_alarm() {
    let (mut live, _socket) = streamed(|_| {}, None);
    let start = Instant::now();
    let mut alarms_at = |seconds: u64| {
        let step = live.step(start + Duration::from_secs(seconds)).unwrap();
        step.updates.into_iter().flat_map(|update| update.alarms).collect::<Vec<_>>()
    };
    assert_eq!([0, 1].map(&mut alarms_at), [vec![], Vec::<String>::new()]);
    assert_eq!(
        [2, 3, 4].map(&mut alarms_at),
        [vec!["no data for 2 s".to_owned()], vec![], vec!["no data for 4 s".to_owned()]]
    );
}

/// Ten seconds of both sources, then five of only one: the alarms of these five seconds, each step's.
fn alarms_without(silent: &str) -> (Vec<Vec<String>>, f64) {
    let (mut live, socket) = streamed(|settings| settings.latency_s = 0.1, None);
    let lines = text();
    let rows: Vec<(f64, &str)> =
        lines[1..].iter().map(|line| (line.split(',').next().unwrap().parse().unwrap(), line.as_str())).collect();
    let (first_s, start) = (rows[0].0, Instant::now());
    let mut found = Vec::new();
    let mut last_s = f64::NAN;
    for tenth in 1..=110 {
        let until_s = first_s + 0.1 * f64::from(tenth);
        let is_now = |time_s: f64| time_s < until_s && time_s >= until_s - 0.1;
        for (time_s, line) in rows.iter().filter(|(time_s, _)| is_now(*time_s)) {
            let sources = ["imu", "air"].into_iter().filter(|source| *source != silent || *time_s < first_s + 6.0);
            sources.for_each(|source| send(&socket, (&lines[0], line), source));
        }
        let step = live.step(start + Duration::from_millis(100 * tenth as u64)).unwrap();
        for update in step.updates {
            last_s = update.time_s - first_s;
            found.push(update.alarms);
        }
    }
    (found, last_s)
}

#[test]
fn a_source_that_stops_while_another_goes_on_gives_an_alarm() {
    let (alarms, last_s) = alarms_without("imu");
    // The estimates stand still where the rates ended; the alarm comes every two seconds all the same.
    assert!(last_s < 6.1, "{last_s}");
    let said: Vec<&Vec<String>> = alarms.iter().filter(|alarms| !alarms.is_empty()).collect();
    assert_eq!(said.len(), 2, "{said:?}");
    for (alarms, seconds) in said.iter().zip([2, 4]) {
        assert_eq!(alarms.len(), 1, "{alarms:?}");
        assert!(alarms[0].starts_with(&format!("no data from 'imu' for {seconds} s")), "{alarms:?}");
        assert!(alarms[0].contains("estimates stand still"), "{alarms:?}");
    }
    let (alarms, last_s) = alarms_without("air");
    // The filter goes on by the rates; every update since then has the alarm.
    assert!(last_s > 10.0, "{last_s}");
    let first = alarms.iter().position(|alarms| !alarms.is_empty()).unwrap();
    assert!(alarms.len() - first > 4 && alarms[first..].iter().all(|alarms| alarms.len() == 1), "{alarms:?}");
    assert!(alarms[first][0].starts_with("no data from 'air' for 2 s"), "{alarms:?}");
}

#[test]
fn a_silent_socket_ends_after_a_stated_wait_alone_and_goes_on_when_packets_come_again() {
    let lines = text();
    for wait in [None, Some(Duration::from_secs(10))] {
        let (mut live, socket) = streamed(|settings| settings.latency_s = 0.1, wait);
        let start = Instant::now();
        // As fast as the receiver takes them.
        let send_at = |live: &mut LiveWatch, rows: &[String], seconds: f64| {
            let mut latest = None;
            for line in rows {
                ["imu", "air"].iter().for_each(|source| send(&socket, (&lines[0], line), source));
                let step = live.step(start + Duration::from_secs_f64(seconds)).unwrap();
                latest = step.updates.last().cloned().or(latest);
            }
            latest
        };
        let before = send_at(&mut live, &lines[1..300], 1.0).unwrap();
        let silent = [4, 64].map(|seconds| live.step(start + Duration::from_secs(seconds)).unwrap());
        let first = silent[0].updates.last().unwrap();
        assert_eq!(first.alarms, ["no data for 3 s"]);
        // The newest sample is three seconds older, and the filter where it was.
        assert!((first.lag_s - before.lag_s - 3.0).abs() < 0.5 && first.time_s == before.time_s, "{}", first.lag_s);
        assert_eq!(silent[1].is_finished, wait.is_some());
        if wait.is_none() {
            let second = silent[1].updates.last().unwrap();
            assert!(second.alarms == ["no data for 63 s"] && second.lag_s > 62.0, "{}", second.lag_s);
            let after = send_at(&mut live, &lines[300..], 65.0).unwrap();
            assert!(
                after.alarms.is_empty() && after.time_s > before.time_s + 3.0,
                "{} {}",
                before.time_s,
                after.time_s
            );
        }
    }
}
