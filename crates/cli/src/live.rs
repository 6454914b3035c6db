//! `doublet live`: a flight watched while it is flown.

use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

use clap::Args;
use doublet_engine::live::{Feed, Goal, Limit, LineFormat, LiveUpdate, LiveWatch, Opening};
use doublet_engine::planning::open_flight;
use doublet_engine::verdict::Level;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::output_path::output_path;
use crate::text;

/// Time without a change after which a file has ended, s.
const FILE_WAIT_S: f64 = 10.0;

#[derive(Debug, Args)]
pub struct LiveArguments {
    /// Recording, growing text file, telemetry log (.tlog), or session to replay.
    #[arg(long, conflicts_with_all = ["udp", "mavlink"])]
    pub file: Option<String>,
    /// UDP address and port for JSON or CSV lines: 127.0.0.1:9000.
    #[arg(long, value_name = "ADDR:PORT", conflicts_with = "mavlink")]
    pub udp: Option<String>,
    /// UDP address and port for MAVLink: 127.0.0.1:14550; or a telemetry log.
    #[arg(long, value_name = "ADDR:PORT")]
    pub mavlink: Option<String>,
    /// Accept packets from these IP addresses only [default: all senders]. Repeatable.
    #[arg(long, value_name = "ADDRESS", value_delimiter = ',')]
    pub from: Vec<IpAddr>,
    /// Session (file or builtin:NAME) for the settings; replayed without another source.
    #[arg(long)]
    pub session: Option<String>,
    /// Channel map (file or name) [default: session's, best fit or guess].
    #[arg(long)]
    pub map: Option<String>,
    /// Aircraft (file or name) [default: from session or map].
    #[arg(long)]
    pub aircraft: Option<String>,
    /// Replay speed, times real time, or `max` [default: max].
    #[arg(long, value_name = "X", value_parser = speed)]
    pub speed: Option<Speed>,
    /// Flight time between updates, s.
    #[arg(long, value_name = "S", default_value_t = 0.5)]
    pub every: f64,
    /// Time to wait for late samples, s.
    #[arg(long, value_name = "S", default_value_t = 0.3)]
    pub latency: f64,
    /// Forgetting time constant of the estimates, s; 0 for none.
    #[arg(long, value_name = "S", default_value_t = 120.0)]
    pub forget: f64,
    /// Target relative error, per cent: of all derivatives, or NAME=PERCENT.
    #[arg(long, value_name = "PERCENT")]
    pub goal: Vec<String>,
    /// Limits: QUANTITY=LOW:HIGH, such as airspeed=75kt:150kt, alpha=:14deg, n_z=0.2:3.5.
    #[arg(long, value_name = "LIMIT")]
    pub limit: Vec<Limit>,
    /// Campaign whose limits are added: file, or builtin:c337f.
    #[arg(long, value_name = "CAMPAIGN")]
    pub campaign: Option<String>,
    /// Record all incoming data into this new folder, with a session.
    #[arg(long, value_name = "FOLDER", value_parser = output_path())]
    pub record: Option<PathBuf>,
    /// Stop after this time without data, s; 0 for never [default: file 10, UDP 0].
    #[arg(long, value_name = "S")]
    pub wait: Option<f64>,
    /// Stop after this time, s.
    #[arg(long = "for", value_name = "S")]
    pub duration: Option<f64>,
    /// Print one JSON line per update.
    #[arg(long)]
    pub json: bool,
}

/// Speed of a recording flown again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// Times real time.
    Times(f64),
    /// As fast as it goes.
    Max,
}

/// Reads a speed.
fn speed(text: &str) -> Result<Speed, String> {
    match text.parse::<f64>() {
        _ if text == "max" => Ok(Speed::Max),
        Ok(times) if times > 0.0 && times.is_finite() => Ok(Speed::Times(times)),
        Ok(times) if times == f64::INFINITY => Ok(Speed::Max),
        _ => Err("give a number above 0, or max".to_owned()),
    }
}

/// Watches a flight to its end and prints every update.
pub fn live(arguments: &LiveArguments) -> Result<(), String> {
    let (file_wait, socket_wait) = waits(arguments.wait)?;
    let file = arguments.file.clone().map(Feed::File);
    let lines = arguments.udp.clone().map(|address| Feed::Lines(address, LineFormat::Any));
    let opening = Opening {
        feed: file.or(lines).or(arguments.mavlink.clone().map(Feed::Mavlink)),
        session: arguments.session.clone(),
        map: arguments.map.clone(),
        aircraft: arguments.aircraft.clone(),
        campaign: arguments.campaign.clone(),
        from: arguments.from.clone(),
        wait: file_wait,
        in_memory: None,
    };
    let watched = open_flight(&opening)?;
    let mut settings = watched.settings;
    settings.update_s = arguments.every;
    settings.latency_s = arguments.latency;
    settings.forgetting_s = Some(arguments.forget).filter(|forget| *forget > 0.0);
    settings.goal = goal(&arguments.goal)?;
    settings.limit(&arguments.limit);
    let speed = match arguments.speed {
        Some(Speed::Times(times)) if watched.is_recorded => Some(times),
        _ => None,
    };
    let mut watch = LiveWatch::new(watched.source, watched.map, settings, speed, socket_wait)?;
    if let Some(folder) = &arguments.record {
        watch.record(folder, watched.session.as_ref(), watched.aircraft.as_deref())?;
    }
    watched.notes.iter().for_each(|note| text::error_line(note));
    if let Some(address) = watch.address() {
        text::error_line(&format!("listening at {address}"));
    }
    let interrupted = interrupted()?;
    let followed = follow(&mut watch, arguments, &interrupted);
    // After an error of the source too the recording has its session.
    watch.stop();
    let not_recorded = watch.recording_errors();
    if let Some(recorded) = watch.finish()? {
        recorded.notes.iter().for_each(|note| text::error_line(note));
        text::error_line(&format!("session: {}", recorded.session.display()));
    }
    followed?;
    if not_recorded.is_empty() { Ok(()) } else { Err(not_recorded.join("; ")) }
}

/// What becomes true at the first Ctrl-C, or when the system asks the program to end; the second ends it at once.
fn interrupted() -> Result<Arc<AtomicBool>, String> {
    /// Exit code of a program that was interrupted twice.
    const INTERRUPTED: i32 = 130;
    let interrupted = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        flag::register_conditional_shutdown(signal, INTERRUPTED, Arc::clone(&interrupted))
            .and_then(|_| flag::register(signal, Arc::clone(&interrupted)))
            .map_err(|error| format!("Ctrl-C cannot be caught: {error}"))?;
    }
    Ok(interrupted)
}

/// Steps until nothing comes any more, the time is over or it is interrupted; what was recorded is then ended as usual.
fn follow(watch: &mut LiveWatch, arguments: &LiveArguments, interrupted: &AtomicBool) -> Result<(), String> {
    let start = Instant::now();
    let until = arguments.duration.map(|duration| seconds("for", duration)).transpose()?.flatten();
    loop {
        let now = Instant::now();
        let is_over = until.is_some_and(|until| now.saturating_duration_since(start) > until);
        if is_over || interrupted.load(Ordering::Relaxed) {
            watch.stop();
        }
        let step = watch.step(now)?;
        for update in &step.updates {
            if arguments.json {
                text::document(&serde_json::to_string(update).map_err(|error| error.to_string())?);
            } else {
                print(update);
            }
        }
        if step.is_finished {
            return Ok(());
        }
        if let Some(rest) = step.rest {
            sleep(rest);
        }
    }
}

/// Seconds as a span of time; none for zero.
fn seconds(name: &str, value: f64) -> Result<Option<Duration>, String> {
    let span = Duration::try_from_secs_f64(value).map_err(|_| format!("--{name}: {value} is not a time in seconds"))?;
    Ok(Some(span).filter(|span| !span.is_zero()))
}

/// Silence after which a file and a socket have ended; none for never.
fn waits(stated: Option<f64>) -> Result<(Option<Duration>, Option<Duration>), String> {
    let file = seconds("wait", stated.unwrap_or(FILE_WAIT_S))?;
    Ok((file, stated.and(file)))
}

/// The errors asked for.
fn goal(texts: &[String]) -> Result<Goal, String> {
    let mut goal = Goal::default();
    for text in texts {
        let (name, number) = text.split_once('=').map_or((None, text.as_str()), |(name, number)| (Some(name), number));
        let percent = number.trim().trim_end_matches('%').parse::<f64>().ok().filter(|percent| *percent > 0.0);
        let percent =
            percent.ok_or_else(|| format!("--goal {text}: give a number of per cent above 0, or NAME=PERCENT"))?;
        match name {
            Some(name) => goal.named.push((name.trim().to_owned(), percent)),
            None => goal.all_percent = percent,
        }
    }
    Ok(goal)
}

/// One update in words.
fn print(update: &LiveUpdate) {
    let state_value = |name: &str| update.state.get(name).copied().unwrap_or(f64::NAN);
    let mut parts = vec![format!(
        "{:9.2} s  V {:.1} m/s  alpha {:.1} deg  lag {:.2} s  {}",
        update.time_s,
        state_value("airspeed"),
        state_value("alpha").to_degrees(),
        update.lag_s,
        update.counts
    )];
    let known = update.derivatives.iter().filter(|derivative| derivative.level == Level::Good).count();
    if !update.derivatives.is_empty() {
        parts.push(format!("enough {known} of {}", update.derivatives.len()));
    }
    if let Some(lamp) = update.correlation.as_ref().filter(|lamp| lamp.level > Level::Good) {
        parts.push(format!(
            "{}: {} and {} at {:.2}",
            lamp.coefficient, lamp.regressors[0], lamp.regressors[1], lamp.correlation
        ));
    }
    let near = update.limits.iter().filter(|limit| limit.level > Level::Good);
    parts.extend(near.map(|limit| format!("{} {}, margin {:.3}", limit.quantity, limit.level.name(), limit.margin)));
    parts.extend(update.alarms.iter().map(|alarm| format!("ALARM: {alarm}")));
    parts.extend(update.findings.iter().cloned());
    text::line(&parts.join("  "));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silence_ends_a_file_after_ten_seconds_and_a_socket_only_where_stated() {
        let of = |wait: f64| Some(Duration::from_secs_f64(wait));
        assert_eq!(waits(None), Ok((of(10.0), None)));
        assert_eq!(waits(Some(3.0)), Ok((of(3.0), of(3.0))));
        assert_eq!(waits(Some(0.0)), Ok((None, None)));
        assert!(waits(Some(-1.0)).is_err());
    }
}
