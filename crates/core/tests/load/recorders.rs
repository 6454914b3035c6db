//! Logs of ArduPilot, LabVIEW and MDF recorders: small ones made here byte by byte, and those of the shared folder with what
//! reference readers give.

use std::collections::BTreeMap;

use doublet_core::load::{Format, Probe, inspect};
use doublet_core::quantity::Unit;
use serde_json::Value;

use super::shared::shared;
use super::{channel, written};

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
    let records: Vec<u8> = (0..10_i16)
        .flat_map(|sample| {
            let packed = (sample - 4) << 4;
            let speed = 100.0 + f32::from(sample);
            let invalid = u8::from(sample == 3);
            joined(&[&(0.1 * f64::from(sample)).to_le_bytes(), &packed.to_le_bytes(), &speed.to_le_bytes(), &[invalid]])
        })
        .collect();
    let counts = joined(&[&[0; 8], &10_u64.to_le_bytes(), &[0; 8], &14_u32.to_le_bytes(), &1_u32.to_le_bytes()]);
    let group = block(&mut file, "##CG", &[0, time, names[5], 0, 0, 0], &counts);
    let data = block(&mut file, "##DT", &[], &records);
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
    let warnings = probe.warnings.join("\n");
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

#[test]
fn logs_of_recorders_give_what_reference_readers_give() {
    let Some(folder) = shared("data/formats") else { return };
    let text = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    let expected: Value = serde_json::from_str(&text).unwrap();
    let mut compared = BTreeMap::<&str, usize>::new();
    for (path, file) in expected["files"].as_object().unwrap() {
        let format = path.split('/').next().unwrap();
        if !["ardupilot_dataflash", "tdms", "mdf4"].contains(&format) {
            continue;
        }
        let probe = inspect(&folder.join(path)).unwrap();
        for (name, source) in file["sources"].as_object().unwrap() {
            *compared.entry(format).or_default() += assert_source(path, &probe, name, source);
        }
    }
    assert_eq!(compared, BTreeMap::from([("ardupilot_dataflash", 234), ("mdf4", 55), ("tdms", 24)]));
}

#[test]
fn tables_of_avionics_and_simulators_give_what_reference_readers_give() {
    let Some(folder) = shared("data/formats") else { return };
    let text = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    let expected: Value = serde_json::from_str(&text).unwrap();
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
