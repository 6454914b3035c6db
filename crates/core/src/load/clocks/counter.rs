//! Time counters of a recorder that begin again at zero when they are full.

use std::borrow::Cow;

use crate::statistics::median;

/// Ticks that fill a counter of 16 and of 32 bits.
const FULL: [f64; 2] = [65_536.0, 4_294_967_296.0];
/// A tick in the unit recorded: the unit itself, a thousandth, a millionth.
const TICKS: [f64; 3] = [1.0, 1e-3, 1e-6];
/// A day and a week of GPS, at the end of which times of the day and of the week begin again, in seconds and in milliseconds.
const CALENDAR: [f64; 4] = [86_400.0, 86_400e3, 604_800.0, 604_800e3];
/// Farthest from full and from zero at the step, in median intervals: lost samples are allowed.
const INTERVALS: f64 = 20.0;

/// The stamps of a counter that was full and began again, continued; as they are where none was.
pub(crate) fn unwrap_counter(stamps: &[f64]) -> Cow<'_, [f64]> {
    let steps: Vec<&[f64]> = stamps.windows(2).filter(|pair| pair[1] < pair[0]).collect();
    if steps.is_empty() {
        return Cow::Borrowed(stamps);
    }
    let mut intervals: Vec<f64> = stamps.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    let near = INTERVALS * median(&mut intervals).unwrap_or(0.0);
    let is_full = |full: f64| {
        let wraps = |pair: &[f64]| (full - near..full).contains(&pair[0]) && (0.0..near).contains(&pair[1]);
        near > 0.0 && near < 0.1 * full && steps.iter().all(|pair| wraps(pair))
    };
    let counted = FULL.iter().flat_map(|full| TICKS.iter().map(move |tick| full * tick));
    let all = counted.chain(CALENDAR);
    let Some(full) = all.into_iter().find(|full| is_full(*full)) else { return Cow::Borrowed(stamps) };
    let mut before = f64::NEG_INFINITY;
    let mut turns = 0.0;
    let continued = stamps.iter().map(|&stamp| {
        if stamp < before {
            turns += 1.0;
        }
        if stamp.is_finite() {
            before = stamp;
        }
        stamp + turns * full
    });
    Cow::Owned(continued.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_that_was_full_goes_on_and_a_clock_set_back_does_not() {
        // Milliseconds in 16 bits, 20 ms apart, two turns.
        let counted: Vec<f64> = (0..9000_u32).map(|k| f64::from((k * 20 + 60_000) % 65_536)).collect();
        let found = unwrap_counter(&counted);
        assert!(found.windows(2).all(|pair| pair[1] - pair[0] == 20.0));
        // Microseconds in 32 bits, recorded in seconds.
        let seconds: Vec<f64> =
            (0..500_u64).map(|k| ((k * 20_000 + 4_290_000_000) % 4_294_967_296) as f64 * 1e-6).collect();
        let found = unwrap_counter(&seconds);
        assert!(found.windows(2).all(|pair| (pair[1] - pair[0] - 0.02).abs() < 1e-6));
        // Milliseconds of the week, 20 ms apart, over the end of the week.
        let week: Vec<f64> = (0..500_u32).map(|k| f64::from((k * 20 + 604_795_000) % 604_800_000)).collect();
        let found = unwrap_counter(&week);
        assert!(found.windows(2).all(|pair| pair[1] - pair[0] == 20.0));
        for set_back in [vec![0.0, 0.1, 0.2, 0.05, 0.15], vec![60.0, 65.0, 0.0, 5.0], vec![0.0, 0.1, 0.2]] {
            assert_eq!(unwrap_counter(&set_back)[..], set_back[..]);
        }
    }
}
