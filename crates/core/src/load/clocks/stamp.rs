//! Times written with colons: of the day, or with their date.

use crate::load::clocks::utc;
use crate::statistics::median;

/// Bytes of the longest cell that is read as a time.
const LONGEST: usize = 40;

/// Half a day, s.
const HALF_DAY_S: f64 = 43_200.0;

/// A time written with colons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Stamp {
    /// `hh:mm:ss` with or without a fraction, s since midnight; before it the day of a year that is not stated, or a date of two readings.
    OfDay(f64),
    /// A date and a time of day, s since 1970-01-01; one that states no zone is taken for UTC.
    Dated(f64),
}

impl Stamp {
    /// The time in a cell. Its decimals follow a point or a comma, whichever the numbers beside it have.
    pub fn parse(cell: &[u8]) -> Option<Self> {
        if cell.len() > LONGEST || !cell.first()?.is_ascii_digit() || !cell.contains(&b':') {
            return None;
        }
        let mut plain = [0_u8; LONGEST];
        for (to, &from) in plain.iter_mut().zip(cell) {
            *to = if from == b',' { b'.' } else { from };
        }
        let text = std::str::from_utf8(&plain[..cell.len()]).ok()?.trim_end();
        let (text, half_s) = match text.get(text.len().saturating_sub(2)..).map(str::to_ascii_lowercase).as_deref() {
            Some("am") => (text[..text.len() - 2].trim_end(), Some(0.0)),
            Some("pm") => (text[..text.len() - 2].trim_end(), Some(HALF_DAY_S)),
            _ => (text, None),
        };
        let stamp = time_of_day(text)
            .map(Self::OfDay)
            .or_else(|| utc::parse(text).map(Self::Dated))
            .or_else(|| time_of_unknown_date(text).map(Self::OfDay))?;
        half_s.map_or(Some(stamp), |half_s| stamp.in_half_of_day(half_s))
    }

    /// A time on a clock of twelve hours, in the half of the day that begins at `half_s`.
    fn in_half_of_day(self, half_s: f64) -> Option<Self> {
        let hour = (self.seconds().rem_euclid(2.0 * HALF_DAY_S) / 3600.0).floor();
        let shift_s = half_s - if hour == 12.0 { HALF_DAY_S } else { 0.0 };
        (1.0..=12.0).contains(&hour).then_some(match self {
            Self::OfDay(seconds) => Self::OfDay(seconds + shift_s),
            Self::Dated(seconds) => Self::Dated(seconds + shift_s),
        })
    }

    /// Seconds since midnight, or since 1970-01-01.
    pub fn seconds(self) -> f64 {
        match self {
            Self::OfDay(seconds) | Self::Dated(seconds) => seconds,
        }
    }
}

/// Seconds since midnight behind the day of a year (`134:10:23:11.020`, as IRIG clocks write it), or behind a date of which day and month
/// cannot be told apart.
fn time_of_unknown_date(text: &str) -> Option<f64> {
    let (day, time) = utc::split_day(text)?;
    (utc::day_of_year(day).is_some() || utc::is_ambiguous(day)).then(|| time_of_day(time.trim_start()))?
}

/// Turns times of day written as numbers `hhmmss.ss` (receivers of satellites do) into seconds since midnight; whether they are such.
///
/// They are where no number has more than 59 seconds or minutes and the steps are even across full minutes in this reading alone.
pub(crate) fn read_digits(values: &mut [f64]) -> bool {
    /// What a number leaps at a full minute beyond its step.
    const LEAP: f64 = 40.0;
    let is_time = |value: f64| {
        let parts = [value.rem_euclid(100.0), (value / 100.0).floor().rem_euclid(100.0)];
        (0.0..240_000.0).contains(&value) && parts.iter().all(|part| *part < 60.0)
    };
    let seconds = seconds_of_digits;
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    if !finite().all(is_time) {
        return false;
    }
    let pairs = || finite().zip(finite().skip(1)).filter(|(before, after)| after > before);
    let mut steps: Vec<f64> = pairs().map(|(before, after)| seconds(after) - seconds(before)).collect();
    let Some(step) = median(&mut steps).filter(|step| (0.0..0.25 * LEAP).contains(step)) else { return false };
    let leaps: Vec<_> = pairs().filter(|(before, after)| after - before >= LEAP).collect();
    let even = leaps.iter().filter(|(before, after)| seconds(*after) - seconds(*before) < 1.5 * step).count();
    let is_even = !leaps.is_empty() && 2 * even > leaps.len();
    if is_even {
        values.iter_mut().for_each(|value| *value = seconds(*value));
    }
    is_even
}

/// Seconds since midnight of a time of day written as a number `hhmmss.ss`.
pub(crate) fn seconds_of_digits(value: f64) -> f64 {
    let (hours, minutes) = ((value / 10_000.0).floor(), (value / 100.0).floor().rem_euclid(100.0));
    hours * 3600.0 + minutes * 60.0 + value.rem_euclid(100.0)
}

/// Seconds of a time of day `hh:mm:ss` or `hh:mm:ss.fff`.
fn time_of_day(text: &str) -> Option<f64> {
    let mut parts = text.split(':');
    let (hours, minutes, seconds) = (parts.next()?, parts.next()?, parts.next()?);
    let (hours, minutes): (u8, u8) = (hours.parse().ok()?, minutes.parse().ok()?);
    let seconds: f64 = seconds.parse().ok()?;
    let valid = parts.next().is_none() && minutes < 60 && (0.0..61.0).contains(&seconds);
    valid.then(|| f64::from(hours) * 3600.0 + f64::from(minutes) * 60.0 + seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_day_written_as_numbers_are_told_from_seconds() {
        let digits = |second: f64| {
            let (hour, minute) = ((second / 3600.0).floor(), (second / 60.0).floor() % 60.0);
            hour * 1e4 + minute * 100.0 + second % 60.0
        };
        let wanted: Vec<f64> = (0..2000).map(|k| 35_930.0 + 0.1 * f64::from(k)).collect();
        let mut values: Vec<f64> = wanted.iter().map(|second| digits(*second)).collect();
        assert!(read_digits(&mut values));
        let worst = values.iter().zip(&wanted).map(|(value, wanted)| (value - wanted).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-6, "{worst}");
        for (start, step) in [(0.0, 0.1), (95_800.0, 1.0), (100_000.0, 0.02), (0.0, 60.0), (0.0, 100.0)] {
            let mut seconds: Vec<f64> = (0..2000).map(|k| start + step * f64::from(k)).collect();
            assert!(!read_digits(&mut seconds), "{start} {step}");
        }
        assert!(!read_digits(&mut [f64::NAN; 4]) && !read_digits(&mut []));
    }

    #[test]
    fn times_are_read_with_either_mark_of_decimals_with_and_without_a_date() {
        for (cell, wanted) in [
            ("10:23:11", Stamp::OfDay(37_391.0)),
            ("10:23:11.020", Stamp::OfDay(37_391.02)),
            ("10:23:11,020", Stamp::OfDay(37_391.02)),
            ("1970-01-02 00:00:11.5", Stamp::Dated(86_411.5)),
            ("2026-05-12 10:23:11.020", Stamp::Dated(1_778_581_391.02)),
            ("2026-05-12T10:23:11,020", Stamp::Dated(1_778_581_391.02)),
            ("2026-05-12 12:23:11.020000+02:00", Stamp::Dated(1_778_581_391.02)),
            ("12.05.2026 10:23:11,020", Stamp::Dated(1_778_581_391.02)),
            ("10:23:11.020 AM", Stamp::OfDay(37_391.02)),
            ("12:00:01 am", Stamp::OfDay(1.0)),
            ("12:59:59 PM", Stamp::OfDay(46_799.0)),
            ("1:00:00PM", Stamp::OfDay(46_800.0)),
            ("1970-01-02 12:00:11.5 AM", Stamp::Dated(86_411.5)),
            ("134:10:23:11.020", Stamp::OfDay(37_391.02)),
            ("134 10:23:11,020", Stamp::OfDay(37_391.02)),
            ("2026 132 10:23:11.020", Stamp::Dated(1_778_581_391.02)),
            ("12-May-2026 10:23:11.020", Stamp::Dated(1_778_581_391.02)),
            ("5/13/2026 10:23:11 PM", Stamp::Dated(1_778_710_991.0)),
            ("12/05/2026 10:23:11", Stamp::OfDay(37_391.0)),
        ] {
            assert_eq!(Stamp::parse(cell.as_bytes()), Some(wanted), "{cell}");
        }
        for cell in [
            "10:23", "10h23m11s", "10:61:00", "ratio 1:2:3", "1:2:3:4", "400:10:23:11", "12/05/26 10:23:11",
            "13:00:00 PM", "0:10:00 AM", "",
        ] {
            assert_eq!(Stamp::parse(cell.as_bytes()), None, "{cell}");
        }
    }
}
