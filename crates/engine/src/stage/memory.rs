//! Memory that manoeuvres take while they are computed, known before they are.

use doublet_core::load::available_memory;
use doublet_core::message;
use doublet_core::message::quoted;

use crate::graph::StageResult;
use crate::session::{Finding, Level};

/// Memory that a sample takes at most until its results are written, bytes: what `crates/cli/tests/cli/windows.rs` measures, and 80 columns
/// for what its recording does not have: other manoeuvres, further measurements, engines, fuel, samples that are not those of the recording.
const MOST_BYTES_PER_SAMPLE: u64 = 1_800;
/// Memory that a sample takes, bytes: as measured over a million samples (`docs/reliability.md`).
const BYTES_PER_SAMPLE: u64 = 1_200;
/// Need up to which the memory available is not looked up, bytes.
const SMALL_BYTES: u64 = 100_000_000;
const GIGABYTE: f64 = 1e9;

/// Whether the memory that is available now can hold a manoeuvre of so many samples, or several of so many together, while they are
/// computed.
pub fn fit_in_memory(samples: usize) -> StageResult<()> {
    fit_in(samples, available_memory)
}

fn fit_in(samples: usize, available: impl FnOnce() -> Option<u64>) -> StageResult<()> {
    let needed = (samples as u64).saturating_mul(BYTES_PER_SAMPLE);
    if needed <= SMALL_BYTES {
        return Ok(());
    }
    match available().filter(|available| needed > *available) {
        None => Ok(()),
        Some(available) => Err(format!(
            "{samples} samples need {:.1} GB (available {:.1} GB): shorten the manoeuvre or resample",
            needed as f64 / GIGABYTE,
            available as f64 / GIGABYTE
        )
        .into()),
    }
}

/// That manoeuvres, given by name and number of samples, may need more memory than is available now: samples times the most bytes per
/// sample. None where it suffices or the system does not say what is available.
pub fn memory_finding<'a>(manoeuvres: impl Iterator<Item = (&'a str, usize)>) -> Option<Finding> {
    shortage(manoeuvres, available_memory)
}

fn shortage<'a>(
    manoeuvres: impl Iterator<Item = (&'a str, usize)>,
    available: impl FnOnce() -> Option<u64>,
) -> Option<Finding> {
    let manoeuvres: Vec<_> = manoeuvres.collect();
    let samples: usize = manoeuvres.iter().map(|(_, samples)| samples).sum();
    let needed = (samples as u64).saturating_mul(MOST_BYTES_PER_SAMPLE);
    if needed <= SMALL_BYTES {
        return None;
    }
    let available = available().filter(|available| needed > *available)?;
    let (longest, _) = manoeuvres.iter().max_by_key(|(_, samples)| *samples)?;
    let (needed_gb, available_gb) = (needed as f64 / GIGABYTE, available as f64 / GIGABYTE);
    let text = message!(
        "{} samples need up to {:.1} GB (available {:.1} GB); the longest manoeuvre is {}.",
        samples,
        needed_gb,
        available_gb,
        quoted(longest)
    );
    let finding = Finding::new(Level::Caution, "memory", "session", text)
        .with_figure(needed_gb, available_gb)
        .with_fix_text("Shorten the manoeuvres, resample to a lower rate, or close other programs.");
    Some(finding.with_setting("Manoeuvres", ""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_beyond_the_memory_is_refused_before_it_is_computed() {
        assert_eq!(fit_in(3_000_000, || Some(4_000_000_000)), Ok(()));
        assert_eq!(fit_in(4_000_000, || None), Ok(()));
        let message = fit_in(4_000_000, || Some(4_000_000_000)).unwrap_err().to_string();
        // A small need does not depend on the machine.
        assert_eq!(fit_in(80_000, || Some(0)), Ok(()));
        assert!(
            message.contains("4000000 samples") && message.contains("4.8 GB") && message.contains("4.0 GB"),
            "{message}"
        );
    }

    #[test]
    fn manoeuvres_beyond_the_memory_available_are_a_caution() {
        let manoeuvres = || [("short", 100_000), ("long", 1_900_000)].into_iter();
        // 2,000,000 samples of 1,800 bytes are 3.6 GB.
        assert_eq!(shortage(manoeuvres(), || Some(3_600_000_000)), None);
        assert_eq!(shortage(manoeuvres(), || None), None);
        let finding = shortage(manoeuvres(), || Some(3_000_000_000)).unwrap();
        assert_eq!((finding.code, finding.level), ("memory", Level::Caution));
        assert_eq!((finding.figure, finding.limit), (Some(3.6), Some(3.0)));
        assert!(finding.text.to_string().contains("'long'"), "{}", finding.text);
        // A small need does not depend on the machine.
        assert_eq!(shortage([("small", 50_000)].into_iter(), || Some(0)), None);
    }
}
