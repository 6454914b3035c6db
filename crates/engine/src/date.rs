//! Dates in UTC, as files state them.

use std::time::{SystemTime, UNIX_EPOCH};

/// Seconds of a day.
const DAY_S: u64 = 86_400;

/// Today as `YYYY-MM-DD`, or the day of `SOURCE_DATE_EPOCH` (s since 1970-01-01) where the environment has it, so that a report or an
/// export can be made again to the byte (reproducible-builds.org).
pub fn today() -> String {
    let stated = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.trim().parse().ok());
    let now = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |duration| duration.as_secs());
    format_day(stated.unwrap_or_else(now) / DAY_S)
}

/// The date of an instant in s since 1970-01-01 as `YYYY-MM-DD`; nothing before that and for what is no number.
pub fn format_instant(utc_s: f64) -> Option<String> {
    /// Years have four digits up to here.
    const LAST_S: f64 = 253_402_300_800.0;
    (0.0..LAST_S).contains(&utc_s).then(|| format_day(utc_s as u64 / DAY_S))
}

/// Date of a day counted from 1970-01-01, in the Gregorian calendar with years that begin in March, so that a leap day is the last.
fn format_day(day: u64) -> String {
    const DAYS_PER_ERA: u64 = 146_097; // 400 years
    const FROM_MARCH_OF_YEAR_0: u64 = 719_468;
    let shifted = day + FROM_MARCH_OF_YEAR_0;
    let (era, of_era) = (shifted / DAYS_PER_ERA, shifted % DAYS_PER_ERA);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let from_march = (5 * of_year + 2) / 153;
    let day_of_month = of_year - (153 * from_march + 2) / 5 + 1;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day_of_month:02}")
}

#[cfg(test)]
mod tests {
    use super::{format_day, format_instant};

    #[test]
    fn days_are_dates() {
        for (day, date) in [(0, "1970-01-01"), (11_016, "2000-02-29"), (11_017, "2000-03-01"), (20_454, "2026-01-01")] {
            assert_eq!(format_day(day), date);
            assert_eq!(format_instant(day as f64 * 86_400.0 + 86_399.5).as_deref(), Some(date));
        }
        assert_eq!(format_instant(253_402_300_799.0).as_deref(), Some("9999-12-31"));
        for instant in [-1.0, f64::NAN, f64::INFINITY, 1e12] {
            assert_eq!(format_instant(instant), None);
        }
    }
}
