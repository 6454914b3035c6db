//! PX4 flight logs.

use doublet_core::load::{Format, inspect};

use super::{channel, written};

fn message(kind: u8, body: &[u8]) -> Vec<u8> {
    let mut message = (body.len() as u16).to_le_bytes().to_vec();
    message.push(kind);
    message.extend(body);
    message
}

/// A log with a nested format, an array, two instances of a topic and a dropout.
pub fn log() -> Vec<u8> {
    let mut log = b"ULog\x01\x12\x35\x01".to_vec();
    log.extend(1_000_000_u64.to_le_bytes());
    log.extend(message(b'B', &[0; 40]));
    log.extend(message(b'F', b"point:float x;int16_t n;"));
    log.extend(message(b'F', b"air_data:uint64_t timestamp;float[2] q;point p;bool on;uint8_t[5] _padding0;"));
    log.extend(message(b'I', b"\x0dchar[4] sys_aPX4 "));
    log.extend(message(b'A', b"\x00\x03\x00air_data"));
    log.extend(message(b'A', b"\x01\x04\x00air_data"));
    for i in 0..20_u64 {
        for (id, scale) in [(3_u16, 1.0), (4, 2.0)] {
            let mut body = id.to_le_bytes().to_vec();
            body.extend((1_000_000 + 20_000 * i).to_le_bytes());
            for value in [i as f32 * scale, -(i as f32), 0.5 * i as f32] {
                body.extend(value.to_le_bytes());
            }
            body.extend((i as i16 - 10).to_le_bytes());
            body.push(u8::from(i % 2 == 0));
            log.extend(message(b'D', &body));
        }
    }
    log.extend(message(b'O', &25_u16.to_le_bytes()));
    log
}

#[test]
fn ulog_topics_are_sources_with_time_in_microseconds() {
    let (_folder, path) = written("flight.bin", log());
    let probe = inspect(&path).unwrap();
    assert_eq!((probe.format, probe.sources.len()), (Format::ULog, 2));
    assert_eq!(channel(&probe, "air_data", "q[0]").values()[19], 19.0);
    assert_eq!(channel(&probe, "air_data.1", "q[0]").values()[19], 38.0);
    assert_eq!(channel(&probe, "air_data", "q[1]").values()[4], -4.0);
    assert_eq!(channel(&probe, "air_data", "p.x").values()[4], 2.0);
    assert_eq!(channel(&probe, "air_data", "p.n").values()[0], -10.0);
    assert_eq!(channel(&probe, "air_data", "on").values()[..2], [1.0, 0.0]);
    let clock = &probe.source("air_data").unwrap().clocks[0];
    assert!((clock.rate_hz - 50.0).abs() < 1e-9 && (clock.start_s - 1.0).abs() < 1e-12, "{clock:?}");
    assert!(probe.warnings.iter().any(|warning| warning.to_string().contains("25 ms")), "{:?}", probe.warnings);
}

#[test]
fn ulog_cut_off_keeps_what_is_complete_and_says_so() {
    let whole = log();
    let (_folder, path) = written("flight.ulg", &whole[..whole.len() - 12]);
    let probe = inspect(&path).unwrap();
    assert_eq!(channel(&probe, "air_data", "on").samples, 20);
    assert_eq!(channel(&probe, "air_data.1", "on").samples, 19);
    assert!(
        probe.warnings.iter().any(|warning| warning.to_string().contains("cut off at byte")),
        "{:?}",
        probe.warnings
    );
}

#[test]
fn ulog_formats_that_multiply_are_refused() {
    let mut log = b"ULog\x01\x12\x35\x01".to_vec();
    log.extend([0; 8]);
    for level in 0..7 {
        log.extend(message(b'F', format!("f{level}:f{}[4000] x;", level + 1).as_bytes()));
    }
    log.extend(message(b'F', b"f7:"));
    log.extend(message(b'A', b"\x00\x01\x00f0"));
    let (_folder, path) = written("bomb.ulg", log);
    let line = inspect(&path).unwrap_err().to_string();
    assert!(line.contains("bomb.ulg") && line.contains("more than 65536 fields"), "{line}");
}

/// Bytes that look like nothing in particular.
fn garbage(count: usize) -> Vec<u8> {
    let mut state = 7_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    (0..count).map(|_| next()).collect()
}

#[test]
fn ulog_goes_on_after_damage_in_its_middle() {
    let whole = log();
    let data = whole.len() - 5 - 40 * 28;
    for (count, replaced) in [(777, 0), (100, 100), (1, 0), (31, 31), (60, 3)] {
        // In the middle of the tenth pair of messages.
        let at = data + 18 * 28 + 11;
        let damaged = [&whole[..at], &garbage(count), &whole[at + replaced..]].concat();
        let (_folder, path) = written("flight.ulg", damaged);
        let probe = inspect(&path).unwrap();
        assert!(
            probe.warnings.iter().any(|line| line.to_string().contains("damage at byte")),
            "{count}: {:?}",
            probe.warnings
        );
        let lost = replaced.div_ceil(56) + 1;
        for (source, scale) in [("air_data", 1.0), ("air_data.1", 2.0)] {
            let values = channel(&probe, source, "q[0]").values();
            assert!(values.len() >= 20 - lost, "{count}: {} of 20 samples", values.len());
            assert_eq!(values[..9], super::made(9, |i, _| i * scale), "before the damage");
            let after: Vec<f64> = (11 + lost..20).map(|i| i as f64 * scale).collect();
            assert!(values.ends_with(&after), "{count}: after the damage {values:?}");
        }
        assert!(probe.warnings.iter().all(|line| !line.to_string().contains("increas")), "{:?}", probe.warnings);
    }
}
