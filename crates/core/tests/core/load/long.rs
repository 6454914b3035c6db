//! Recordings longer than what is read of them at a time.

#[cfg(target_os = "linux")]
use std::time::Instant;

use doublet_core::load::inspect;
#[cfg(target_os = "linux")]
use doublet_core::load::{ChannelMap, guess, plan_all, read};

use super::recorders::mdf4_of;
use super::{channel, written};

/// Samples of a channel: several times what is read at once.
const SAMPLES: u32 = 300_000;

/// A LabVIEW file of two segments with a channel of doubles and one of 16 bits, sample by sample or channel by channel.
fn tdms_of(samples: u32, is_interleaved: bool) -> Vec<u8> {
    let word = |value: u32| value.to_le_bytes().to_vec();
    let text = |text: &str| [word(text.len() as u32), text.as_bytes().to_vec()].concat();
    let described = |name: &str, kind: u32| {
        let path = text(&format!("/'bus'/'{name}'"));
        [path, word(20), word(kind), word(1), u64::from(samples).to_le_bytes().to_vec(), word(0)].concat()
    };
    let metadata = [word(3), text("/'bus'"), word(u32::MAX), word(0), described("wide", 10), described("narrow", 2)];
    let metadata = metadata.concat();
    let mut file = Vec::new();
    for segment in 0..2_u32 {
        let numbers = (segment * samples)..((segment + 1) * samples);
        let wide = |sample: u32| f64::from(sample).sqrt().to_le_bytes().to_vec();
        let narrow = |sample: u32| ((sample % 30_000) as i16).to_le_bytes().to_vec();
        let raw: Vec<u8> = match is_interleaved {
            true => numbers.flat_map(|sample| [wide(sample), narrow(sample)].concat()).collect(),
            false => numbers.clone().flat_map(wide).chain(numbers.flat_map(narrow)).collect(),
        };
        let described = if segment == 0 { &metadata[..] } else { &[] };
        let contains = 8 | if segment == 0 { 6 } else { 0 } | if is_interleaved { 32 } else { 0 };
        let next = (described.len() + raw.len()) as u64;
        file.extend([b"TDSm".to_vec(), word(contains), word(4713), next.to_le_bytes().to_vec()].concat());
        file.extend((described.len() as u64).to_le_bytes());
        file.extend([described, &raw].concat());
    }
    file
}

#[test]
fn tdms_samples_are_the_same_wherever_a_piece_ends() {
    for is_interleaved in [false, true] {
        let (_folder, path) = written("long.tdms", tdms_of(SAMPLES, is_interleaved));
        let probe = inspect(&path).unwrap();
        assert_eq!(probe.warnings.iter().filter(|line| line.to_string().contains("cut off")).count(), 0);
        let wide: Vec<f64> = (0..2 * SAMPLES).map(|sample| f64::from(sample).sqrt()).collect();
        assert_eq!(channel(&probe, "bus", "wide").values(), wide, "interleaved: {is_interleaved}");
        let narrow: Vec<f64> = (0..2 * SAMPLES).map(|sample| f64::from(sample % 30_000)).collect();
        assert_eq!(channel(&probe, "bus", "narrow").values(), narrow, "interleaved: {is_interleaved}");
    }
}

/// A record of 15 bytes ends in no piece where it began.
#[test]
fn mdf_records_are_the_same_wherever_a_piece_ends() {
    let (_folder, path) = written("long.mf4", mdf4_of(SAMPLES));
    let probe = inspect(&path).unwrap();
    let alpha: Vec<f64> = (0..SAMPLES).map(|sample| -5.0 + 0.25 * (f64::from(sample % 1000) - 4.0)).collect();
    assert_eq!(channel(&probe, "Bus", "Alpha").values(), alpha);
    let speed = channel(&probe, "Bus", "TAS");
    assert_eq!((speed.samples, speed.non_finite, speed.values()[299_999]), (300_000, Some(1), 300_099.0));
    assert!(probe.warnings.is_empty(), "{:?}", probe.warnings);
}

/// Recording of the test below, made by `scripts/make_long_recording.py`.
#[cfg(target_os = "linux")]
const LONG: &str = "DOUBLET_LONG_RECORDING";

/// Largest resident memory of this process, bytes.
#[cfg(target_os = "linux")]
fn peak_bytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    1024.0 * line.trim().strip_suffix("kB").unwrap().trim().parse::<f64>().unwrap()
}

/// Largest memory of opening, guessing and reading it, with eight bytes a number: the numbers, those in other units, and a tenth beside.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "needs a recording of hundreds of megabytes"]
fn a_long_recording_takes_its_numbers_and_those_in_other_units() {
    let Some(path) = std::env::var_os(LONG) else { return };
    let begun = Instant::now();
    let probes = [inspect(path.as_ref()).unwrap()];
    let (opened_s, opened) = (begun.elapsed().as_secs_f64(), peak_bytes());
    let map = ChannelMap::parse(&guess(&probes).text().unwrap()).unwrap();
    let (guessed_s, guessed) = (begun.elapsed().as_secs_f64(), peak_bytes());
    let recording = read(&plan_all(&probes, &map)).unwrap();
    let (read_s, all) = (begun.elapsed().as_secs_f64(), peak_bytes());
    let channels = || probes.iter().flat_map(|probe| &probe.sources).flat_map(|source| &source.channels);
    let numbers = 8.0 * channels().map(|channel| channel.samples as f64).sum::<f64>();
    let converted = |channel: &doublet_core::series::Channel| {
        let same = channels().any(|raw| std::ptr::eq(raw.values().as_ptr(), channel.series.values.as_ptr()));
        if same { 0.0 } else { 8.0 * channel.series.values.len() as f64 }
    };
    let converted: f64 = recording.channels.iter().map(converted).sum();
    println!(
        "{:.0} MB of numbers, {:.0} MB in other units: opened {opened_s:.1} s, {:.0} MB; guessed {guessed_s:.1} s, {:.0} MB; read {read_s:.1} s, {:.0} MB",
        numbers / 1e6,
        converted / 1e6,
        opened / 1e6,
        guessed / 1e6,
        all / 1e6
    );
    assert!(all < 1.1 * (numbers + converted) + 50e6);
}
