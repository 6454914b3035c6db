//! Wide tables of messages: a column for every field of every topic, named `topic/field`, and a row for every message. PlotJuggler
//! writes such tables, with a column `__time` in s. Tables into which somebody joined the topics of a flight log of PX4 at one rate name
//! their columns `topic_field`.

use std::collections::BTreeSet;

use crate::load::clocks::time_names::is_time_name;
use crate::load::contents::{ChannelInfo, Source};

/// Largest part of the topics that a row holds on average.
const FILLED_SHARE: f64 = 0.6;

/// Parts of a message of ROS that are named like no topic: a topic ends before them.
const MESSAGE_PARTS: [&str; 12] = [
    "twist", "linear", "angular", "pose", "position", "orientation", "vector", "point", "accel", "transform",
    "angular_velocity", "linear_acceleration",
];

/// Topics of PX4 whose fields joined tables hold.
const JOINED: [&str; 18] = [
    "vehicle_attitude", "vehicle_angular_velocity", "vehicle_acceleration", "vehicle_local_position",
    "vehicle_global_position", "vehicle_gps_position", "vehicle_air_data", "sensor_combined", "sensor_accel",
    "sensor_gyro", "sensor_gps", "sensor_baro", "airspeed_validated", "airspeed", "actuator_controls_0",
    "actuator_outputs", "actuator_servos", "actuator_motors",
];
/// Words behind a topic that make another topic of it.
const OTHER_TOPICS: [&str; 3] = ["setpoint", "groundtruth", "wind"];

/// Columns whose fields are in the same rows.
struct Topic {
    /// Parts of the name that all of them begin with.
    path: Vec<String>,
    rows: Vec<bool>,
    columns: Vec<usize>,
}

/// A source for every topic of such a table; any other source as it is.
pub(crate) fn split(source: Source) -> Vec<Source> {
    let is_clock = |channel: &ChannelInfo| is_time_name(&channel.name) && parts(&channel.name).len() == 1;
    let Some(clock) = source.channels.iter().position(is_clock) else { return vec![source] };
    let joined = source.channels.iter().filter_map(|channel| split_joined(&channel.name)).map(|(topic, _)| topic);
    if joined.collect::<BTreeSet<_>>().len() > 1 {
        return part_joined(source, clock);
    }
    let topics = find_topics(&source.channels, clock);
    let filled: usize = topics.iter().map(|topic| topic.rows.iter().filter(|is_filled| **is_filled).count()).sum();
    let cells = topics.len() * source.channels[clock].samples;
    if topics.len() < 2 || filled as f64 > FILLED_SHARE * cells as f64 {
        return vec![source];
    }
    let mut sources: Vec<Source> = Vec::new();
    for mut topic in topics {
        let of_message = topic.path.iter().skip(1).position(|part| MESSAGE_PARTS.contains(&part.as_str()));
        topic.path.truncate(of_message.map_or(topic.path.len(), |at| at + 1));
        let name = topic_name(&topic.path);
        let count =
            sources.iter().filter(|other| other.name == name || other.name.starts_with(&format!("{name} "))).count();
        let mut part = Source::new(if count == 0 { name } else { format!("{name} {}", count + 1) });
        part.notes.clone_from(&source.notes);
        part.first_column = Some(0);
        for column in std::iter::once(clock).chain(topic.columns) {
            let channel = &source.channels[column];
            let values = channel.values().iter().zip(&topic.rows).filter(|(_, is_filled)| **is_filled);
            let kept = ChannelInfo::new("", channel.unit.clone(), values.map(|(value, _)| *value).collect());
            let name = if column == clock { channel.name.clone() } else { field_name(&channel.name, &topic.path) };
            part.channels.push(ChannelInfo { name, is_time_of_day: channel.is_time_of_day, ..kept });
        }
        sources.push(part);
    }
    sources
}

/// A source for every topic of a table of joined topics, and one for its other columns.
fn part_joined(source: Source, clock: usize) -> Vec<Source> {
    let time = source.channels[clock].clone();
    let mut rest = Source { channels: Vec::new(), ..source };
    let mut topics: Vec<Source> = Vec::new();
    for (index, channel) in source.channels.into_iter().enumerate() {
        let Some((name, field)) = split_joined(&channel.name).filter(|_| index != clock) else {
            rest.channels.push(channel);
            continue;
        };
        let at = topics.iter().position(|topic| topic.name == name).unwrap_or_else(|| {
            let channels = vec![time.clone()];
            topics.push(Source { channels, first_column: Some(0), notes: rest.notes.clone(), ..Source::new(name) });
            topics.len() - 1
        });
        topics[at].channels.push(ChannelInfo { name: field.to_owned(), ..channel });
    }
    rest.first_column = Some(clock).filter(|_| clock == 0);
    if rest.channels.len() > 1 {
        topics.push(rest);
    }
    topics
}

/// Topic and field of the name of a column of joined topics, whose instance is the first: `vehicle_attitude_0_q[0]`, `airspeed.true_airspeed_m_s`.
fn split_joined(name: &str) -> Option<(&'static str, &str)> {
    let topics = JOINED.iter().filter(|topic| name.starts_with(**topic));
    let topic = topics.max_by_key(|topic| topic.len())?;
    let field = name[topic.len()..].strip_prefix(['_', '.'])?;
    let field = ["0_", "0."].iter().find_map(|first| field.strip_prefix(first)).unwrap_or(field);
    (!field.is_empty() && !OTHER_TOPICS.iter().any(|other| field.starts_with(other))).then_some((topic, field))
}

/// The topics of all columns but the clock; none where a column names no topic.
fn find_topics(channels: &[ChannelInfo], clock: usize) -> Vec<Topic> {
    let mut folders: Vec<Topic> = Vec::new();
    for (index, channel) in channels.iter().enumerate().filter(|(index, _)| *index != clock) {
        let mut path = parts(&channel.name);
        if path.pop().is_none() || path.is_empty() {
            return Vec::new();
        }
        let at = folders.iter().position(|folder| folder.path == path).unwrap_or_else(|| {
            folders.push(Topic { path, rows: vec![false; channel.samples], columns: Vec::new() });
            folders.len() - 1
        });
        let folder = &mut folders[at];
        folder.rows.iter_mut().zip(channel.values()).for_each(|(is_filled, value)| *is_filled |= value.is_finite());
        folder.columns.push(index);
    }
    let mut topics: Vec<Topic> = Vec::new();
    for folder in folders.into_iter().filter(|folder| folder.rows.contains(&true)) {
        let same = topics.iter_mut().find(|topic| topic.path[0] == folder.path[0] && topic.rows == folder.rows);
        let Some(topic) = same else {
            topics.push(folder);
            continue;
        };
        let common = topic.path.iter().zip(&folder.path).take_while(|(one, other)| one == other).count();
        topic.path.truncate(common);
        topic.columns.extend(folder.columns);
    }
    topics
}

/// Splits a name at its strokes.
fn parts(name: &str) -> Vec<String> {
    name.split('/').filter(|part| !part.is_empty()).map(str::to_owned).collect()
}

/// The name of a topic as the recording has it: of several instances, the first has no number (`sensor_accel.00`, `sensor_accel.01`).
fn topic_name(path: &[String]) -> String {
    let name = path.join("/");
    match split_number(&name) {
        Some((stem, 0)) => stem.to_owned(),
        Some((stem, number)) => format!("{stem}.{number}"),
        None => name,
    }
}

/// The name of a field within its topic; `q.03` is `q[3]`.
fn field_name(name: &str, topic: &[String]) -> String {
    let fields: Vec<String> = parts(name).split_off(topic.len());
    let written = fields.iter().map(|field| match split_number(field) {
        Some((stem, number)) => format!("{stem}[{number}]"),
        None => field.clone(),
    });
    written.collect::<Vec<_>>().join(".")
}

/// A name and the number of two digits behind its last point.
fn split_number(name: &str) -> Option<(&str, usize)> {
    let (stem, number) = name.rsplit_once('.')?;
    let is_number = number.len() >= 2 && number.bytes().all(|digit| digit.is_ascii_digit());
    Some((stem, number.parse().ok().filter(|_| is_number)?))
}

#[cfg(test)]
mod tests {
    use crate::load::guesses::guess::guess;
    use crate::load::probe_of;
    use crate::quantity::Role;

    #[test]
    fn a_row_for_every_message_makes_a_source_for_every_topic() {
        let head = "__time,vehicle_attitude/q.00,vehicle_attitude/q.01,vehicle_attitude/q.02,vehicle_attitude/q.03,\
                    sensor_combined/gyro_rad.00,sensor_combined/gyro_rad.01,sensor_accel.01/x";
        let mut text = format!("{head}\n");
        for k in 0..400_u32 {
            let t = 0.01 * f64::from(k);
            let half = 0.25 * t.sin();
            text += &format!("{t:.3},{:.6},{:.6},0,0,,,\n", half.cos(), half.sin());
            text += &format!("{:.3},,,,,{:.6},0.01,\n{:.3},,,,,,,9.81\n", t + 0.002, 0.5 * t.cos(), t + 0.004);
        }
        let probe = probe_of(&text);
        let names: Vec<&str> = probe.sources.iter().map(|source| source.name.as_str()).collect();
        assert_eq!(names, ["vehicle_attitude", "sensor_combined", "sensor_accel.1"]);
        assert!(probe.sources.iter().all(|source| (source.clocks[0].rate_hz - 100.0).abs() < 0.1));
        let map = guess(std::slice::from_ref(&probe));
        let rate = &map.row(Role::RollRate).unwrap().from;
        assert_eq!((rate.source.as_str(), rate.channel.as_str()), ("sensor_combined", "gyro_rad[0]"));
        let rate = rate.find(std::slice::from_ref(&probe)).unwrap();
        assert!(rate.samples == 400 && (rate.values()[100] - 0.5 * 1.0_f64.cos()).abs() < 1e-5);
        assert!(map.attitude.is_some());
    }

    #[test]
    fn a_topic_ends_before_the_parts_of_its_message() {
        let head = "__time,/gps/vel/twist/linear/x,/gps/vel/twist/linear/y,/imu/data/angular_velocity/x";
        let row =
            |k: u32| format!("{:.2},{},{},\n{:.2},,,0.{k}\n", 0.1 * f64::from(k), 40 + k, k, 0.1 * f64::from(k) + 0.05);
        let probe = probe_of(&format!("{head}\n{}", (0..50).map(row).collect::<String>()));
        let found: Vec<(&str, &str)> =
            probe.sources.iter().map(|one| (one.name.as_str(), one.channels[1].name.as_str())).collect();
        assert_eq!(found, [("gps/vel", "twist.linear.x"), ("imu/data", "angular_velocity.x")]);
    }

    #[test]
    fn joined_topics_of_px4_are_parted() {
        let head = "timestamp,vehicle_attitude_q[0],vehicle_attitude_q[1],vehicle_attitude_q[2],vehicle_attitude_q[3],\
                    vehicle_local_position_0_vx,vehicle_local_position_0_z,vehicle_local_position_setpoint_vx,note";
        let row = |k: u32| {
            let half = 0.2 * (0.01 * f64::from(k)).sin();
            format!("{},{:.6},{:.6},0,0,20.5,-{k},3,{k}\n", 5_000_000 + 10_000 * k, half.cos(), half.sin())
        };
        let probe = probe_of(&format!("{head}\n{}", (0..400).map(row).collect::<String>()));
        let names: Vec<(&str, usize)> =
            probe.sources.iter().map(|source| (source.name.as_str(), source.channels.len())).collect();
        assert_eq!(names[..2], [("vehicle_attitude", 5), ("vehicle_local_position", 3)]);
        assert_eq!(probe.sources[2].channels.len(), 3, "time, setpoint and note");
        let map = guess(std::slice::from_ref(&probe));
        let down = map.row(Role::PositionDown).unwrap();
        assert_eq!((down.from.channel.as_str(), down.turned), ("z", false));
        assert!(map.attitude.is_some());
        assert!(map.row(Role::VelocityNorth).is_some_and(|row| row.from.source == "vehicle_local_position"));
    }

    #[test]
    fn a_full_table_stays_one_source() {
        let rows: String = (0..50).map(|k| format!("{k},1.{k},2.{k}\n")).collect();
        let probe = probe_of(&format!("time,sim/position/P,sim/joystick/yoke\n{rows}"));
        assert_eq!(probe.sources.len(), 1);
        assert_eq!(probe.sources[0].channels[1].name, "sim/position/P");
    }
}
