//! The date of today in UTC, as files state it.

use std::time::{SystemTime, UNIX_EPOCH};

/// Today as `YYYY-MM-DD`.
pub fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |duration| duration.as_secs());
    of_day(seconds / 86_400)
}

/// Date of a day counted from 1970-01-01, in the Gregorian calendar with years that begin in March, so that a leap day is the last.
fn of_day(day: u64) -> String {
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
    use super::of_day;

    #[test]
    fn days_are_dates() {
        for (day, date) in [(0, "1970-01-01"), (11_016, "2000-02-29"), (11_017, "2000-03-01"), (20_454, "2026-01-01")] {
            assert_eq!(of_day(day), date);
        }
    }
}
