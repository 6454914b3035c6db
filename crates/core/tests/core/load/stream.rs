//! Streams: MAVLink packets there and back, a malformed stream, a channel map row by row against the whole recording.

use crate::mavlink::packet;
use doublet_core::load::stream::{
    FieldType, JsonDecoder, MESSAGES, MavlinkDecoder, Message, StreamMap, StreamRow, TailedFile, TextDecoder,
    packet_checksum,
};
use doublet_core::load::{ChannelMap, inspect, plan, read};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Packets of the malformed stream; `DOUBLET_PACKETS=1000000` for as many as docs/live.md states.
const PACKETS: usize = 30_000;

fn heartbeat(sequence: u8) -> Vec<u8> {
    let message = Message { id: 0, name: "HEARTBEAT", fields: &[] };
    let mut bytes = vec![0xfe, 9, sequence, 1, 1, message.id as u8, 0, 0, 0, 0, 2, 3, 81, 4, 3];
    let sum = packet_checksum(&bytes[1..], 50);
    bytes.extend(sum.to_le_bytes());
    bytes
}

/// Numbers that the type of each field holds exactly.
fn values_of(message: &Message, time_ms: u32, random: &mut ChaCha8Rng) -> Vec<f64> {
    let value = |field: &doublet_core::load::stream::Field| match (field.name, field.kind) {
        ("time_boot_ms", _) => f64::from(time_ms),
        ("time_usec", _) => f64::from(time_ms) * 1000.0,
        ("time_unix_usec", _) => 1.7e15 + f64::from(time_ms) * 1000.0,
        (_, FieldType::I16) => f64::from(random.random::<i16>()),
        (_, FieldType::U16) => f64::from(random.random::<u16>()),
        (_, FieldType::I32) => f64::from(random.random::<i32>()),
        (_, FieldType::U8) => f64::from(random.random::<u8>()),
        (_, FieldType::F32) => f64::from(random.random_range(-1e3_f32..1e3)),
        (_, FieldType::U32 | FieldType::U64) => f64::from(random.random::<u32>()),
    };
    message.fields.iter().map(value).collect()
}

#[test]
fn mavlink_packets_come_back_with_equal_values_from_a_stream_and_from_a_telemetry_log() {
    for version in [1, 2] {
        let random = &mut ChaCha8Rng::seed_from_u64(u64::from(version));
        let (mut stream, mut log, mut sent) = (Vec::new(), Vec::new(), Vec::new());
        let mut sequence = 250_u8;
        let mut add = |packet: Vec<u8>, time_ms: u32| {
            log.extend((1_700_000_000_000_000_u64 + u64::from(time_ms) * 1000).to_be_bytes());
            log.extend(&packet);
            stream.extend(packet);
        };
        for step in 0..200_u32 {
            let time_ms = 5000 + 20 * step;
            for message in MESSAGES.iter().filter(|message| version == 2 || message.id < 256) {
                let values = values_of(message, time_ms, random);
                add(packet(message, &values, version, sequence), time_ms);
                sequence = sequence.wrapping_add(1);
                sent.push((message, values, time_ms));
            }
            add(heartbeat(sequence), time_ms);
            sequence = sequence.wrapping_add(1);
        }
        for (bytes, piece) in [(&stream, 7), (&stream, 4096), (&log, 333)] {
            let (mut decoder, mut rows) = (MavlinkDecoder::default(), Vec::<StreamRow>::new());
            bytes.chunks(piece).for_each(|piece| decoder.push(piece, &mut rows));
            decoder.end_of_datagram(&mut rows);
            assert_eq!(rows.len(), sent.len(), "version {version}, pieces of {piece}");
            assert_eq!((decoder.packets, decoder.lost), (sent.len() as u64, 0));
            for (row, (message, values, time_ms)) in rows.iter().zip(&sent) {
                assert_eq!(&*row.source, message.name);
                approx::assert_abs_diff_eq!(row.values[0], f64::from(*time_ms) * 1e-3, epsilon = 1e-9);
                for ((found, value), field) in row.values[1..].iter().zip(values).zip(message.fields) {
                    assert_eq!(*found, value * field.scale, "{} {}", message.name, field.name);
                }
            }
        }
    }
}

#[test]
fn a_telemetry_log_is_named_where_a_recording_is_asked_for() {
    let attitude = MESSAGES.iter().find(|message| message.name == "ATTITUDE").unwrap();
    let random = &mut ChaCha8Rng::seed_from_u64(1);
    for with_stamps in [true, false] {
        let mut log = Vec::new();
        for step in 0..50_u32 {
            for packet in [heartbeat(0), packet(attitude, &values_of(attitude, 20 * step, random), 2, step as u8)] {
                if with_stamps {
                    log.extend((1_700_000_000_000_000_u64 + u64::from(step) * 20_000).to_be_bytes());
                }
                log.extend(packet);
            }
        }
        let (_folder, path) = super::written("flight.tlog", log);
        let error = inspect(&path).unwrap_err().to_string();
        assert!(error.contains("MAVLink telemetry log is not read"), "{error}");
    }
}

#[test]
fn lost_and_damaged_packets_are_counted_and_the_rest_is_read() {
    let attitude = MESSAGES.iter().find(|message| message.name == "ATTITUDE").unwrap();
    let random = &mut ChaCha8Rng::seed_from_u64(1);
    let (mut decoder, mut rows) = (MavlinkDecoder::default(), Vec::new());
    for step in 0..100_u32 {
        let mut bytes = packet(attitude, &values_of(attitude, 20 * step, random), 2, step as u8);
        match step {
            10 | 20..25 => continue,
            30 => bytes[15] ^= 1,
            40 => bytes.truncate(20),
            _ => {}
        }
        decoder.push(&bytes, &mut rows);
        decoder.end_of_datagram(&mut rows);
    }
    assert_eq!((rows.len(), decoder.lost), (92, 8));
}

#[test]
fn a_malformed_stream_is_passed_over() {
    let packets = std::env::var("DOUBLET_PACKETS").ok().and_then(|count| count.parse().ok()).unwrap_or(PACKETS);
    let random = &mut ChaCha8Rng::seed_from_u64(42);
    let (mut mavlink, mut text, mut json) =
        (MavlinkDecoder::default(), TextDecoder::new("noise"), JsonDecoder::default());
    let map = ChannelMap::parse(include_str!("../../../../../assets/channel_maps/mavlink.toml")).unwrap();
    let (mut map, mut samples) = (StreamMap::new(map), Vec::new());
    for number in 0..packets {
        let message = &MESSAGES[random.random_range(0..MESSAGES.len())];
        let version = if message.id < 256 { random.random_range(1..3) } else { 2 };
        let mut bytes = packet(message, &values_of(message, random.random(), random), version, number as u8);
        match number % 4 {
            0 => bytes = (0..random.random_range(0..300)).map(|_| random.random()).collect(),
            1 => {
                let at = random.random_range(0..bytes.len());
                bytes[at] = random.random();
            }
            2 => bytes.truncate(random.random_range(0..bytes.len())),
            _ => {}
        }
        let mut rows = Vec::new();
        mavlink.push(&bytes, &mut rows);
        if random.random_bool(0.5) {
            mavlink.end_of_datagram(&mut rows);
        }
        if number % 16 == 0 {
            text.push(&bytes, &mut rows);
            rows.extend(json.decode(&String::from_utf8_lossy(&bytes)));
        }
        rows.iter().for_each(|row| map.take(row, &mut samples));
        samples.clear();
    }
    // A quarter of the packets was whole.
    assert!(mavlink.packets as usize > packets / 5, "{} of {packets}", mavlink.packets);
}

#[test]
fn a_map_row_by_row_matches_the_reading_of_the_whole_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let mut text = String::from("Time [ms],Roll rate [deg/s],Pitch,Lat,Lon,Height [ft],unused\n");
    for k in 0..200 {
        let t = f64::from(k) * 0.02;
        text.push_str(&format!(
            "{},{:.4},{:.5},{:.7},{:.7},{:.2},x\n",
            1000.0 + 20.0 * f64::from(k),
            10.0 * t.sin(),
            0.1 * t.cos(),
            51.0 + 1e-5 * t,
            4.0 + 2e-5 * t,
            4000.0 + t
        ));
    }
    let map = ChannelMap::parse(
        "format = \"doublet channel map\"\nversion = 1\nname = \"test\"\n[derive.position]\naltitude = \"gps_altitude\"\n[roles]\n\
         p = { channel = \"Roll rate\", sign = -1 }\ntheta = { channel = \"Pitch\", unit = \"rad\", offset = 0.1, scale = 2.0 }\n\
         latitude = { channel = \"Lat\", unit = \"deg\" }\nlongitude = { channel = \"Lon\", unit = \"deg\" }\n\
         gps_altitude = { channel = \"Height\" }\n",
    )
    .unwrap();
    // The file grows line by line, with a line that has not ended.
    std::fs::write(&path, "").unwrap();
    let mut tail = TailedFile::open(&path).unwrap();
    let (mut stream, mut samples) = (StreamMap::new(map.clone()), Vec::new());
    let mut written = 0;
    for end in (37..text.len()).step_by(37).chain([text.len()]) {
        use std::io::Write;
        std::fs::OpenOptions::new()
            .append(true)
            .open(&path)
            .unwrap()
            .write_all(&text.as_bytes()[written..end])
            .unwrap();
        written = end;
        let mut rows = Vec::new();
        while tail.poll(&mut rows).unwrap() {}
        rows.iter().for_each(|row| stream.take(row, &mut samples));
    }
    let recording = read(&plan(&inspect(&path).unwrap(), &map)).unwrap();
    assert_eq!(recording.roles.len(), 8);
    for (&role, &index) in &recording.roles {
        let series = &recording.channels[index].series;
        let own: Vec<_> = samples.iter().filter(|sample| sample.role == role).collect();
        assert_eq!(own.len(), series.values.len(), "{}", role.name());
        for (sample, (time_s, value)) in own.iter().zip(series.time_s.iter().zip(&*series.values)) {
            assert_eq!((sample.time_s, sample.value), (*time_s, *value), "{}", role.name());
        }
    }
}
