//! Logs of ArduPilot, LabVIEW and MDF recorders: small ones made here byte by byte, and those of the shared folder with what
//! reference readers give.

use std::collections::BTreeMap;
use std::path::PathBuf;

use doublet_core::load::{Format, LoadError, Probe, inspect};
use doublet_core::quantity::Unit;
use serde_json::Value;

use super::{channel, written};
use crate::shared::shared;

/// Relative difference to a number that went through single precision or nine digits of text.
const PRINTED: f64 = 2e-7;

/// A text of `length` bytes, filled with NUL.
fn padded(text: &str, length: usize) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(length, 0);
    bytes
}

fn joined(parts: &[&[u8]]) -> Vec<u8> {
    parts.concat()
}

/// An ArduPilot log of two instances of a message, one of them written late once, with garbage between packets.
pub fn dataflash() -> Vec<u8> {
    let packet = |kind: u8, body: &[u8]| joined(&[&[0xa3, 0x95, kind], body]);
    let describe = |of: u8, length: u8, name: &str, format: &str, labels: &str| {
        packet(128, &joined(&[&[of, length], &padded(name, 4), &padded(format, 16), &padded(labels, 64)]))
    };
    let mut log = describe(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
    log.extend(describe(129, 76, "UNIT", "QbZ", "TimeUS,Id,Label"));
    log.extend(describe(130, 44, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds"));
    log.extend(describe(131, 20, "MULT", "Qbd", "TimeUS,Id,Mult"));
    log.extend(describe(140, 18, "IMU", "QBhf", "TimeUS,I,Acc,Gyr"));
    log.extend(describe(141, 14, "ODD", "Qb", "TimeUS,X"));
    let at = 1_000_000_u64;
    for (id, label) in [(b'#', "instance"), (b's', "s"), (b'o', "m/s/s"), (b'E', "rad/s")] {
        log.extend(packet(129, &joined(&[&at.to_le_bytes(), &[id], &padded(label, 64)])));
    }
    for (id, factor) in [(b'B', 0.01_f64), (b'F', 1e-6)] {
        log.extend(packet(131, &joined(&[&at.to_le_bytes(), &[id], &factor.to_le_bytes()])));
    }
    log.extend(packet(130, &joined(&[&at.to_le_bytes(), &[140], &padded("s#oE", 16), &padded("F-B-", 16)])));
    for sample in [0_u64, 1, 3, 2, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23] {
        for instance in 0..2_u8 {
            let acceleration = 100 * sample as i16 + i16::from(instance);
            let body = joined(&[
                &(at + 20_000 * sample).to_le_bytes(),
                &[instance],
                &acceleration.to_le_bytes(),
                &(0.5 * sample as f32).to_le_bytes(),
            ]);
            log.extend(packet(140, &body));
        }
        log.extend([0, 0xa3, 7]);
    }
    log
}

/// A LabVIEW file of two segments: wave forms of two rates in one group, the second segment adding to the first.
pub fn tdms() -> Vec<u8> {
    let text = |text: &str| joined(&[&(text.len() as u32).to_le_bytes(), text.as_bytes()]);
    let number = |name: &str, value: f64| joined(&[&text(name), &10_u32.to_le_bytes(), &value.to_le_bytes()]);
    let start = |seconds: i64| {
        joined(&[&text("wf_start_time"), &0x44_u32.to_le_bytes(), &(1_u64 << 63).to_le_bytes(), &seconds.to_le_bytes()])
    };
    let word = |value: u32| value.to_le_bytes();
    let channel = |path: &str, kind: u32, count: u64, interval: f64, unit: &str| {
        let index = joined(&[&word(20), &word(kind), &word(1), &count.to_le_bytes()]);
        let unit = joined(&[&text("unit_string"), &word(0x20), &text(unit)]);
        joined(&[&text(path), &index, &word(3), &start(1000), &number("wf_increment", interval), &unit])
    };
    let segment = |contains: u32, metadata: &[u8], raw: &[u8]| {
        let next = (metadata.len() + raw.len()) as u64;
        let lead_in = joined(&[b"TDSm", &word(contains), &word(4713), &next.to_le_bytes()]);
        joined(&[&lead_in, &(metadata.len() as u64).to_le_bytes(), metadata, raw])
    };
    let metadata = joined(&[
        &word(2),
        &channel("/'it''s'/'alpha'", 10, 4, 0.5, "deg"),
        &channel("/'it''s'/'count'", 2, 2, 1.0, ""),
    ]);
    let raw = |from: i16| {
        let alpha: Vec<u8> = (0..4).flat_map(|index| f64::from(2 * from + index).to_le_bytes()).collect();
        let count: Vec<u8> = (from..from + 2).flat_map(i16::to_le_bytes).collect();
        joined(&[&alpha, &count])
    };
    joined(&[&segment(0xe, &metadata, &raw(0)), &segment(0x8, &[], &raw(2))])
}

/// An MDF file of one group: time, a linear integer of 12 bits, and a float with an invalid sample.
pub fn mdf4() -> Vec<u8> {
    mdf4_of(10)
}

/// The same of any length.
pub fn mdf4_of(samples: u32) -> Vec<u8> {
    mdf4_from(samples, false)
}

/// The same with its records in two blocks, each in a list of its own; the first list leads to the second.
fn mdf4_in_lists(samples: u32) -> Vec<u8> {
    mdf4_from(samples, true)
}

fn mdf4_from(samples: u32, is_in_lists: bool) -> Vec<u8> {
    let mut file = joined(&[b"MDF     4.10    doublet ", &[0; 40]]);
    // Blocks are laid one behind another; links are filled in where the blocks they lead to stand already.
    let block = |file: &mut Vec<u8>, id: &str, links: &[u64], data: &[u8]| {
        file.resize(file.len().next_multiple_of(8), 0);
        let (place, length) = (file.len() as u64, 24 + 8 * links.len() + data.len());
        let head =
            joined(&[id.as_bytes(), &[0; 4], &(length as u64).to_le_bytes(), &(links.len() as u64).to_le_bytes()]);
        let links: Vec<u8> = links.iter().flat_map(|link| link.to_le_bytes()).collect();
        file.extend(joined(&[&head, &links, data]));
        place
    };
    // The header stands at byte 64 and leads to the data group, which comes last: its first link is written at the end.
    let header = block(&mut file, "##HD", &[0; 6], &joined(&[&1_000_000_000_u64.to_le_bytes(), &[0; 24]]));
    let text = |file: &mut Vec<u8>, text: &str| block(file, "##TX", &[], &padded(text, text.len() + 1));
    let linear = {
        let values: Vec<u8> = [-5.0_f64, 0.25].iter().flat_map(|value| value.to_le_bytes()).collect();
        let head = joined(&[&[1, 0, 0, 0, 0, 0, 2, 0], &[0; 16]]);
        block(&mut file, "##CC", &[0; 4], &joined(&[&head, &values]))
    };
    let names = ["t", "Alpha", "TAS", "deg", "kt", "Bus"].map(|name| text(&mut file, name));
    let channel =
        |file: &mut Vec<u8>, next: u64, name: u64, unit: u64, conversion: u64, place: [u32; 4], kinds: [u8; 4]| {
            let numbers: Vec<u8> = place.iter().flat_map(|value| value.to_le_bytes()).collect();
            block(file, "##CN", &[next, 0, name, 0, conversion, 0, unit, 0], &joined(&[&kinds, &numbers, &[0; 52]]))
        };
    // Byte offset, bits, flags, invalidation bit; kind, synchronisation, type, bit offset.
    let speed = channel(&mut file, 0, names[2], names[4], 0, [10, 32, 2, 0], [0, 0, 4, 0]);
    let alpha = channel(&mut file, speed, names[1], names[3], linear, [8, 12, 0, 0], [0, 0, 2, 4]);
    let time = channel(&mut file, alpha, names[0], 0, 0, [0, 64, 0, 0], [2, 1, 4, 0]);
    let records: Vec<u8> = (0..samples)
        .flat_map(|sample| {
            let packed = ((sample % 1000) as i16 - 4) << 4;
            let speed = 100.0 + sample as f32;
            let invalid = u8::from(sample == 3);
            joined(&[&(0.1 * f64::from(sample)).to_le_bytes(), &packed.to_le_bytes(), &speed.to_le_bytes(), &[invalid]])
        })
        .collect();
    let counts =
        joined(&[&[0; 8], &u64::from(samples).to_le_bytes(), &[0; 8], &14_u32.to_le_bytes(), &1_u32.to_le_bytes()]);
    let group = block(&mut file, "##CG", &[0, time, names[5], 0, 0, 0], &counts);
    let data = if is_in_lists {
        let (first, rest) = records.split_at(15 * (samples as usize / 2));
        let parts = [first, rest].map(|part| block(&mut file, "##DT", &[], part));
        let last = block(&mut file, "##DL", &[0, parts[1]], &[0; 8]);
        block(&mut file, "##DL", &[last, parts[0]], &[0; 8])
    } else {
        block(&mut file, "##DT", &[], &records)
    };
    let data_group = block(&mut file, "##DG", &[0, group, data, 0], &[0; 8]);
    let link = header as usize + 24;
    file[link..link + 8].copy_from_slice(&data_group.to_le_bytes());
    file
}

#[test]
fn dataflash_is_split_by_instance_scaled_once_and_put_in_order() {
    let (_folder, path) = written("00000001.BIN", dataflash());
    let probe = inspect(&path).unwrap();
    assert_eq!((probe.format, probe.sources.len()), (Format::DataFlash, 2));
    for instance in 0..2 {
        let name = format!("IMU[{instance}]");
        let expected: Vec<f64> =
            (0..24).map(|sample| 0.01 * (100.0 * f64::from(sample) + f64::from(instance))).collect();
        let found = channel(&probe, &name, "Acc");
        assert_eq!(found.unit.as_deref(), Some("m/s/s"));
        assert!(found.values().iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12), "{:?}", found.values());
        let clock = &probe.source(&name).unwrap().clocks[0];
        assert!((clock.start_s - 1.0).abs() < 1e-12 && (clock.rate_hz - 50.0).abs() < 1e-9, "{clock:?}");
        assert_eq!(clock.fault_count, 0);
    }
    let warnings = probe.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(warnings.contains("'IMU[0]': 1 messages were written late"), "{warnings}");
    assert!(warnings.contains("72 bytes") && warnings.contains("messages 'ODD' are left out"), "{warnings}");
}

#[test]
fn wave_forms_of_two_rates_in_one_group_have_their_own_times() {
    let (_folder, path) = written("run.tdms", tdms());
    let probe = inspect(&path).unwrap();
    assert_eq!(probe.format, Format::Tdms);
    assert_eq!(channel(&probe, "it's", "alpha").values(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    assert_eq!(channel(&probe, "it's (2)", "count").values(), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(channel(&probe, "it's", "alpha").unit.as_deref(), Some("deg"));
    let rates = ["it's", "it's (2)"].map(|name| probe.source(name).unwrap().clocks[0].rate_hz);
    assert_eq!(rates, [2.0, 1.0]);
}

/// It was called damaged, and to be copied again.
#[cfg(feature = "parquet")]
#[test]
fn parquet_compressed_with_brotli_is_refused_with_what_to_write() {
    let mut bytes = parquet();
    // Codec of the first column, behind its path: 1 is Snappy, 4 is Brotli.
    let at = bytes.windows(6).position(|window| window == b"when\x15\x02").unwrap();
    bytes[at + 5] = 8;
    let (_folder, path) = written("flight.parquet", bytes);
    let line = inspect(&path).unwrap_err().to_string();
    assert!(line.contains("Brotli") && line.contains("write the file with zstd or snappy"), "{line}");
}

/// A list of each kind that leads back to its first block: each once was followed for up to 43 s.
#[test]
fn mdf_links_that_lead_back_are_refused() {
    for id in [b"##DG", b"##CG", b"##CN", b"##DL"] {
        let mut bytes = mdf4_in_lists(10);
        let at = bytes.windows(4).position(|window| window == id).unwrap();
        bytes[at + 24..at + 32].copy_from_slice(&(at as u64).to_le_bytes());
        let (_folder, path) = written("circle.mf4", bytes);
        let refused = inspect(&path);
        assert!(matches!(refused, Err(LoadError::Damaged { format: Format::Mdf4, .. })), "{id:?}: {refused:?}");
    }
    // The lists as they are lead to the same samples as one block.
    let [(_first, whole), (_second, listed)] = [mdf4(), mdf4_in_lists(10)].map(|bytes| written("bus.mf4", bytes));
    let [whole, listed] =
        [whole, listed].map(|path| channel(&inspect(&path).unwrap(), "Bus", "Alpha").values().to_vec());
    assert_eq!(whole, listed);
}

#[test]
fn mdf_bits_conversion_and_invalid_samples_are_read() {
    let (_folder, path) = written("bus.mf4", mdf4());
    let probe = inspect(&path).unwrap();
    assert_eq!(probe.format, Format::Mdf4);
    let alpha: Vec<f64> = (0..10).map(|sample| -5.0 + 0.25 * f64::from(sample - 4)).collect();
    assert_eq!(channel(&probe, "Bus", "Alpha").values(), alpha);
    let speed = channel(&probe, "Bus", "TAS");
    assert_eq!((speed.unit.as_deref(), speed.non_finite, speed.values()[9]), (Some("kt"), Some(1), 109.0));
    assert!(speed.values()[3].is_nan());
    assert!((probe.source("Bus").unwrap().clocks[0].rate_hz - 10.0).abs() < 1e-9);
}

/// A recording of two topics: one of JSON, one of CDR with text, a list and an array before its numbers, written out of order into an lz4
/// chunk; and a topic that cannot be decoded.
pub fn mcap() -> Vec<u8> {
    let text = |text: &str| joined(&[&(text.len() as u32).to_le_bytes(), text.as_bytes()]);
    let record = |kind: u8, content: &[u8]| joined(&[&[kind], &(content.len() as u64).to_le_bytes(), content]);
    let schema = |id: u16, name: &str, encoding: &str, data: &str| {
        record(3, &joined(&[&id.to_le_bytes(), &text(name), &text(encoding), &text(data)]))
    };
    let channel = |id: u16, schema: u16, topic: &str, encoding: &str| {
        record(4, &joined(&[&id.to_le_bytes(), &schema.to_le_bytes(), &text(topic), &text(encoding), &[0; 4]]))
    };
    let message = |channel: u16, at_ns: u64, data: &[u8]| {
        record(5, &joined(&[&channel.to_le_bytes(), &[0; 4], &(at_ns + 7).to_le_bytes(), &at_ns.to_le_bytes(), data]))
    };
    let description = "std_msgs/Header header\nuint8 LIMIT=3\nint16[] counts # how many\nfloat64[9] c_covariance\n\
                       geometry_msgs/Vector3 angular_velocity\nfloat32[2] pair\n"
        .to_owned()
        + &"=".repeat(80)
        + "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
        + &"=".repeat(80)
        + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
        + &"=".repeat(80)
        + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
    let imu = |sample: u32| {
        // Every number starts at a multiple of its size after the four bytes of the head.
        let mut data = vec![0, 1, 0, 0];
        data.extend(1_700_000_000_i32.to_le_bytes());
        data.extend((sample * 20_000_000).to_le_bytes());
        data.extend(4_u32.to_le_bytes());
        data.extend(b"imu\0");
        data.extend(3_u32.to_le_bytes());
        data.extend([1, 0, 2, 0, 3, 0, 0, 0, 0, 0, 0, 0]);
        let pad = |data: &mut Vec<u8>| data.resize(4 + (data.len() - 4).next_multiple_of(8), 0);
        pad(&mut data);
        data.extend([0; 72]);
        for axis in 0..3 {
            data.extend((0.25 * f64::from(sample) + f64::from(axis)).to_le_bytes());
        }
        data.extend([1.5_f32, -2.5].map(f32::to_le_bytes).concat());
        data
    };
    let mut inner = Vec::new();
    for sample in [1_u32, 0, 2, 3, 4] {
        inner.extend(message(1, 1_700_000_000_000_000_000 + 1000 * u64::from(sample), &imu(sample)));
    }
    let mut packed = lz4_flex::frame::FrameEncoder::new(Vec::new());
    std::io::Write::write_all(&mut packed, &inner).unwrap();
    let packed = packed.finish().unwrap();
    let sizes = joined(&[&[0; 16], &(inner.len() as u64).to_le_bytes(), &[0; 4]]);
    let chunk = joined(&[&sizes, &text("lz4"), &(packed.len() as u64).to_le_bytes(), &packed]);
    let mut file = b"\x89MCAP0\r\n".to_vec();
    file.extend(record(1, &joined(&[&text(""), &text("doublet")])));
    file.extend(schema(1, "sensor_msgs/msg/Imu", "ros2msg", &description));
    file.extend(channel(1, 1, "/imu", "cdr"));
    file.extend(channel(2, 0, "/air", "json"));
    file.extend(channel(3, 0, "/odd", "protobuf"));
    file.extend(record(6, &chunk));
    for sample in 0..5_u64 {
        let data = format!("{{\"tas\": {sample}, \"on\": true, \"wind\": {{\"n\": [1, {sample}]}}, \"name\": \"x\"}}");
        file.extend(message(2, 1_700_000_000_100_000_000 + 100_000_000 * sample, data.as_bytes()));
        file.extend(message(3, sample, &[1, 2]));
    }
    file.extend(record(15, &[0; 4]));
    file
}

/// A table of stamps, numbers with blanks, a switch and words, in two groups of rows.
pub fn parquet() -> Vec<u8> {
    use parquet::data_type::{BoolType, ByteArrayType, DoubleType, Int64Type};
    let schema = "message table { REQUIRED INT64 when (TIMESTAMP(NANOS,true)); OPTIONAL DOUBLE alpha; REQUIRED BOOLEAN gear; \
                  OPTIONAL BYTE_ARRAY phase (UTF8); }";
    let schema = std::sync::Arc::new(parquet::schema::parser::parse_message_type(schema).unwrap());
    let codec = parquet::basic::Compression::SNAPPY;
    let properties = parquet::file::properties::WriterProperties::builder().set_compression(codec).build();
    let mut writer = parquet::file::writer::SerializedFileWriter::new(Vec::new(), schema, properties.into()).unwrap();
    for group in 0..2_i64 {
        let mut rows = writer.next_row_group().unwrap();
        // Nanoseconds since 1970, whose floating-point numbers are 256 apart.
        let stamps: Vec<i64> = (0..5).map(|row| 1_700_000_000_000_000_001 + 20_000_000 * (5 * group + row)).collect();
        let mut column = rows.next_column().unwrap().unwrap();
        column.typed::<Int64Type>().write_batch(&stamps, None, None).unwrap();
        column.close().unwrap();
        let mut column = rows.next_column().unwrap().unwrap();
        let alpha = [0.25, 0.5, 0.75].map(|value| value + group as f64);
        column.typed::<DoubleType>().write_batch(&alpha, Some(&[1, 0, 1, 0, 1]), None).unwrap();
        column.close().unwrap();
        let mut column = rows.next_column().unwrap().unwrap();
        column.typed::<BoolType>().write_batch(&[true, false, true, true, false], None, None).unwrap();
        column.close().unwrap();
        let mut column = rows.next_column().unwrap().unwrap();
        column.typed::<ByteArrayType>().write_batch(&["climb".into()], Some(&[0, 0, 1, 0, 0]), None).unwrap();
        column.close().unwrap();
        rows.close().unwrap();
    }
    writer.into_inner().unwrap()
}

#[cfg(feature = "parquet")]
#[test]
fn tables_of_parquet_keep_their_stamps_exact_and_their_blanks_blank() {
    let (_folder, path) = written("flight.parquet", parquet());
    let probe = inspect(&path).unwrap();
    assert_eq!(probe.format, Format::Parquet);
    let when = channel(&probe, "flight", "when").values();
    assert!(when.iter().enumerate().all(|(row, time_s)| *time_s == 0.02 * row as f64), "{when:?}");
    let clock = &probe.source("flight").unwrap().clocks[0];
    assert_eq!((clock.channel.as_str(), clock.samples, clock.fault_count), ("when", 10, 0));
    let alpha = channel(&probe, "flight", "alpha");
    assert_eq!((alpha.non_finite, alpha.values()[2], alpha.values()[9]), (Some(4), 0.5, 1.75));
    assert_eq!(channel(&probe, "flight", "gear").values()[..5], [1.0, 0.0, 1.0, 1.0, 0.0]);
    assert!(
        probe.warnings.iter().any(|warning| warning.to_string().contains("left out: phase")),
        "{:?}",
        probe.warnings
    );
}

#[test]
fn messages_are_laid_out_by_their_description_and_put_in_the_order_of_their_stamps() {
    let (_folder, path) = written("flight.mcap", mcap());
    let probe = inspect(&path).unwrap();
    assert_eq!((probe.format, probe.sources.len()), (Format::Mcap, 2));
    let imu = probe.source("/imu").unwrap();
    let names: Vec<&str> = imu.channels.iter().map(|channel| channel.name.as_str()).collect();
    let axes = ["angular_velocity.x", "angular_velocity.y", "angular_velocity.z"];
    assert_eq!(names, [&["header.stamp"], &axes[..], &["pair[0]", "pair[1]"]].concat());
    assert_eq!(channel(&probe, "/imu", "angular_velocity.y").values(), [1.0, 1.25, 1.5, 1.75, 2.0]);
    assert_eq!(channel(&probe, "/imu", "angular_velocity.y").unit.as_deref(), Some("rad/s"));
    assert_eq!(channel(&probe, "/imu", "pair[1]").values(), [-2.5; 5]);
    assert_eq!(channel(&probe, "/air", "wind.n[1]").values(), [0.0, 1.0, 2.0, 3.0, 4.0]);
    // The two topics keep their places to each other: the second was sent 0.1 s after the first was measured.
    let starts = ["/imu", "/air"].map(|name| probe.source(name).unwrap().clocks[0].start_s);
    assert!(starts[0] == 0.0 && (starts[1] - 0.1).abs() < 1e-12, "{starts:?}");
    let warnings = probe.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(warnings.contains("'/odd' (message encoding \"protobuf\", schema encoding none)"), "{warnings}");
}

#[test]
fn recordings_of_messages_that_are_cut_off_give_what_is_whole_and_never_panic() {
    let whole = mcap();
    for length in 8..whole.len() {
        let (_folder, path) = written("cut.mcap", &whole[..length]);
        let _ = inspect(&path);
    }
    let (_folder, path) = written("cut.mcap", &whole[..whole.len() - 20]);
    let probe = inspect(&path).unwrap();
    assert!(
        probe.warnings.iter().any(|warning| warning.to_string().contains("cut off or damaged")),
        "{:?}",
        probe.warnings
    );
    assert_eq!(channel(&probe, "/imu", "angular_velocity.x").samples, 5);
}

/// Asserts that a source has the channels and the clock that the reference reader gives; returns the number of channels.
fn assert_source(path: &str, probe: &Probe, name: &str, expected: &Value) -> usize {
    let number = |value: &Value| value.as_f64();
    let close =
        |found: f64, expected: f64| (found - expected).abs() <= PRINTED * found.abs().max(expected.abs()).max(1e-9);
    let clock = &expected["time"];
    if let Some(rate) = number(&clock["rate_hz"]) {
        let found = &probe.source(name).unwrap_or_else(|| panic!("{path}: no source {name}")).clocks[0];
        assert!((found.rate_hz - rate).abs() < 1e-4 * rate, "{path} {name}: {} Hz, not {rate}", found.rate_hz);
        let start = number(&clock["start_s"]).unwrap();
        assert!((found.start_s - start).abs() < 1e-6, "{path} {name}: starts at {} s, not {start}", found.start_s);
    }
    let Some(channels) = expected["channels"].as_object() else { return 0 };
    for (key, expected) in channels {
        // Where a name ends in a unit the channel is called without it.
        let is_whole = probe.source(name).is_some_and(|source| source.channels.iter().any(|found| found.name == *key));
        let key = if is_whole { key.as_str() } else { key.rsplit_once(" (").map_or(key.as_str(), |(name, _)| name) };
        let found = channel(probe, name, key);
        let place = format!("{path} {name}/{key}");
        // What is no unit, a clock or a direction, is the reference reader's word for the column.
        if let Some(unit) = expected["unit"].as_str().filter(|unit| unit.is_empty() || Unit::parse(unit).is_ok()) {
            assert_eq!(found.unit.as_deref().unwrap_or(""), unit, "{place}");
        }
        assert_eq!(found.samples as f64, number(&expected["samples"]).unwrap(), "{place}");
        let values: Vec<f64> = found.values().iter().copied().filter(|value| value.is_finite()).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let found = BTreeMap::from([
            ("first", values[0]),
            ("last", values[values.len() - 1]),
            ("mean", mean),
            ("min", values.iter().copied().fold(f64::INFINITY, f64::min)),
            ("max", values.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
        ]);
        for (what, found) in found {
            let expected = number(&expected[what]).unwrap();
            assert!(close(found, expected), "{place}: {what} {found}, not {expected}");
        }
    }
    channels.len()
}

/// The folder of the shared recordings and what reference readers give of them.
fn expected() -> Option<(PathBuf, Value)> {
    let folder = shared("data/formats")?;
    let text = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    Some((folder, serde_json::from_str(&text).unwrap()))
}

#[test]
fn logs_of_recorders_give_what_reference_readers_give() {
    let Some((folder, expected)) = expected() else { return };
    let mut compared = BTreeMap::<&str, usize>::new();
    for (path, file) in expected["files"].as_object().unwrap() {
        let format = path.split('/').next().unwrap();
        if !["ardupilot_dataflash", "tdms", "mdf4", "mcap", "parquet"].contains(&format) {
            continue;
        }
        if file["behaviour"].as_str().is_some_and(|behaviour| behaviour.starts_with("refuse")) {
            let refused = inspect(&folder.join(path)).unwrap_err().to_string();
            assert!(refused.contains("message encoding \"a\", schema encoding \"c\""), "{refused}");
            continue;
        }
        let probe = inspect(&folder.join(path)).unwrap();
        if format == "parquet" {
            *compared.entry(format).or_default() += assert_source(path, &probe, &probe.sources[0].name, file);
            continue;
        }
        for (name, source) in file["sources"].as_object().unwrap() {
            *compared.entry(format).or_default() += assert_source(path, &probe, name, source);
        }
    }
    assert_eq!(
        compared,
        BTreeMap::from([("ardupilot_dataflash", 234), ("mcap", 34), ("mdf4", 55), ("parquet", 28), ("tdms", 24)])
    );
}

#[test]
fn tables_of_avionics_and_simulators_give_what_reference_readers_give() {
    let Some((folder, expected)) = expected() else { return };
    let mut compared = Vec::new();
    for path in ["garmin_g1000_csv/g1000_layout_synthetic.csv", "xplane_data_txt/Data.txt"] {
        let mut file = expected["files"][path].clone();
        if path.starts_with("garmin") {
            // Its units stand in a list of their own; the time is that of the day.
            for (name, unit) in file["units"].as_object().unwrap().clone() {
                if let Some(channel) = file["channels"].get_mut(&name) {
                    channel["unit"] = unit;
                }
            }
            file["time"]["start_s"] = Value::from(16.5 * 3600.0);
        }
        let probe = inspect(&folder.join(path)).unwrap();
        compared.push(assert_source(path, &probe, &probe.sources[0].name, &file));
    }
    assert_eq!(compared, [31, 46]);
}

#[test]
fn tables_of_simulators_loggers_and_topics_give_what_reference_readers_give() {
    let Some((folder, expected)) = expected() else { return };
    let mut compared = BTreeMap::<&str, usize>::new();
    for (path, file) in expected["files"].as_object().unwrap() {
        let format = path.split('/').next().unwrap();
        if !["jsbsim_csv", "flightgear_csv", "onspeed_csv", "ulog2csv"].contains(&format) {
            continue;
        }
        let probe = inspect(&folder.join(path)).unwrap();
        // Stamps that repeat are asked about; their rate is none of the file's.
        let is_asked = file["behaviour"].as_str().is_some_and(|behaviour| behaviour.starts_with("ask"));
        let plain = |file: &Value| {
            let mut file = file.clone();
            // The reference reader's units are of the project's documents, not of the file.
            let channels = file["channels"].as_object_mut().unwrap();
            channels.values_mut().for_each(|channel| channel["unit"] = Value::Null);
            // Channels without a value have nothing to compare.
            channels.retain(|_, channel| channel["first"].is_number());
            // Uneven stamps have no one rate.
            if is_asked || format == "ulog2csv" || file["time"]["repeats"].as_f64().is_some_and(|repeats| repeats > 0.0)
            {
                file["time"] = Value::Null;
            }
            file
        };
        *compared.entry(format).or_default() += assert_source(path, &probe, &probe.sources[0].name, &plain(file));
    }
    println!("channels compared: {compared:?}");
    assert_eq!(compared.len(), 4);
    assert!(compared.values().all(|count| *count > 20), "{compared:?}");
}
