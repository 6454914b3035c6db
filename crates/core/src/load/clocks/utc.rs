//! UTC times as text.

/// Seconds in a day.
const DAY_S: i64 = 86_400;

/// Seconds since 1970-01-01T00:00:00Z of `text`, `YYYY-MM-DDThh:mm:ss[.fraction]` with an optional `Z`, `UTC` or `+hh:mm`. A blank may
/// stand for the `T`; `YYYY/MM/DD`, `DD.MM.YYYY`, `DD-Mon-YYYY`, `MM/DD/YYYY` with a day above 12 and year and day of the year
/// (`YYYY:DDD:`, as IRIG clocks write it) for the date.
///
/// Days are those of the proleptic Gregorian calendar, without leap seconds (POSIX time). `None` for anything else.
pub(crate) fn parse(text: &str) -> Option<f64> {
    let (date, time) = split_day(text.trim())?;
    let [year, month, day] = split_date(date).or_else(|| date_of_year(date))?;
    let (time, zone_s) = split_zone(time.trim_start())?;
    let mut time = time.splitn(3, ':');
    let (hour, minute) = (time.next()?.parse::<i64>().ok()?, time.next()?.parse::<i64>().ok()?);
    let second = time.next().map_or(Some(0.0), |part| part.parse::<f64>().ok())?;
    let valid = (1600..=9999).contains(&year)
        && (1..=12).contains(&month)
        && (1..=days_in_month(year, month)).contains(&day)
        && (0..24).contains(&hour)
        && (0..60).contains(&minute)
        && (0.0..61.0).contains(&second);
    let whole = || days_from_1970(year, month, day) * DAY_S + hour * 3600 + minute * 60 - zone_s;
    valid.then(|| whole() as f64 + second)
}

/// What stands before the hours, and the time from them on.
pub(crate) fn split_day(text: &str) -> Option<(&str, &str)> {
    let mut colons = text.match_indices(':').map(|(at, _)| at);
    // `YYYY:DDD:hh:mm:ss` and `DDD:hh:mm:ss` part the day by colons too.
    let before = text.matches(':').count().checked_sub(3).and_then(|more| colons.clone().nth(more));
    let at = match before {
        Some(at) if text[..at].bytes().all(|byte| byte.is_ascii_digit() || byte == b':') => at,
        _ => text[..colons.next()?].rfind(|letter: char| !letter.is_ascii_digit())?,
    };
    let mark = text[at..].chars().next().filter(|mark| ['T', ' ', ':'].contains(mark))?;
    Some((text[..at].trim_end(), &text[at + mark.len_utf8()..]))
}

/// Months as their first three letters.
const MONTHS: [&str; 12] = ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];

/// Year, month and day of a year and the day of it in three digits: `2026-134`, `2026 134`, `2026:134`.
fn date_of_year(date: &str) -> Option<[i64; 3]> {
    let (year, of_year) = date.split_once(['-', ' ', ':', '/'])?;
    let year: i64 = year.parse().ok().filter(|year| (1600..=9999).contains(year))?;
    let mut day = day_of_year(of_year)?;
    let month = (1..=12).find(|month| {
        let days = days_in_month(year, *month);
        let is_inside = day <= days;
        day -= if is_inside { 0 } else { days };
        is_inside
    })?;
    Some([year, month, day])
}

/// The day of a year in three digits, from 001.
pub(crate) fn day_of_year(text: &str) -> Option<i64> {
    let is_day = text.len() == 3 && text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|day| is_day && (1..=366).contains(day))
}

/// Year, month and day. With points between them the day comes first, as German recorders write it; `05/12/2026` could be two days and is
/// none.
fn split_date(date: &str) -> Option<[i64; 3]> {
    let mark = ['-', '/', '.', ' '].into_iter().find(|mark| date.contains(*mark))?;
    let mut parts = date.splitn(3, mark);
    let (first, middle, last) = (parts.next()?, parts.next()?, parts.next()?);
    let (first, last): (i64, i64) = (first.parse().ok()?, last.parse().ok()?);
    let Ok(month) = middle.parse() else {
        let month = MONTHS.iter().zip(1..).find(|(name, _)| middle.to_lowercase().starts_with(**name))?.1;
        return Some(if last > 31 { [last, month, first] } else { [first, month, last] });
    };
    Some(match mark {
        '.' if last > 31 => [last, month, first],
        '/' if last > 31 && month > 12 => [last, first, month],
        '/' if last > 31 && first > 12 => [last, month, first],
        _ => [first, month, last],
    })
}

/// Whether a date leaves open which of its first two numbers is the month: `05/12/2026`.
pub(crate) fn is_ambiguous(date: &str) -> bool {
    let parts: Vec<u32> = date.split('/').filter_map(|part| part.parse().ok()).collect();
    matches!(parts[..], [first, second, year] if (1..=12).contains(&first) && (1..=12).contains(&second) && year > 999)
}

/// Names of UTC behind a time.
const UTC_NAMES: [&str; 3] = ["Z", "UTC", "GMT"];

/// Time of day and its zone's offset from UTC, s: `Z`, `UTC`, `+02:00`, `+0200` or `+02`.
fn split_zone(time: &str) -> Option<(&str, i64)> {
    if let Some(time) = UTC_NAMES.iter().find_map(|name| time.strip_suffix(name)) {
        return Some((time.trim_end(), 0));
    }
    let Some(at) = time.rfind(['+', '-']) else { return Some((time, 0)) };
    let zone = &time[at + 1..];
    let (hours, minutes) = match zone.split_once(':') {
        Some(parts) => parts,
        None if zone.len() == 4 => (zone.get(..2)?, zone.get(2..)?),
        None => (zone, "0"),
    };
    let (hours, minutes) = (hours.parse::<u8>().ok()?, minutes.parse::<u8>().ok()?);
    let offset = i64::from(hours) * 3600 + i64::from(minutes) * 60;
    Some((time[..at].trim_end(), if time[at..].starts_with('-') { -offset } else { offset }))
}

fn is_leap(year: i64) -> bool {
    year % 4 == 0 && (year % 100 != 0 || year % 400 == 0)
}

fn days_in_month(year: i64, month: i64) -> i64 {
    match month {
        2 => 28 + i64::from(is_leap(year)),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

fn days_from_1970(year: i64, month: i64, day: i64) -> i64 {
    let leap_days = |year: i64| year / 4 - year / 100 + year / 400;
    let years = 365 * (year - 1970) + leap_days(year - 1) - leap_days(1969);
    years + (1..month).map(|month| days_in_month(year, month)).sum::<i64>() + day - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utc_matches_posix_time() {
        // Values of `date -u -d ... +%s`.
        assert_eq!(parse("1970-01-01T00:00:00Z"), Some(0.0));
        assert_eq!(parse("2000-02-29T12:00:00Z"), Some(951_825_600.0));
        assert_eq!(parse("2024-05-01T09:30:00.25"), Some(1_714_555_800.25));
        for text in [
            "2024-05-01T11:30:00+02:00", "2024-05-01 11:30:00+0200", "2024-05-01 11:30:00 +02",
            "2024-05-01 04:30:00-05:00", "2024-05-01 09:30:00 UTC", "2024/05/01 09:30:00", "01.05.2024 09:30:00",
            "01-May-2024 09:30:00", "01 MAY 2024 09:30:00", "2024:122:09:30:00", "2024 122 09:30:00",
            "2024-122T09:30:00Z",
        ] {
            assert_eq!(parse(text), Some(1_714_555_800.0), "{text}");
        }
        // 15 October 2024; a month's T is not the mark of the time.
        for text in ["15-OCT-2024 09:30:00", "10/15/2024 09:30:00", "15/10/2024 09:30:00", "2024-289T09:30:00"] {
            assert_eq!(parse(text), Some(1_728_984_600.0), "{text}");
        }
    }

    #[test]
    fn utc_rejects_what_is_no_time() {
        for text in [
            "", "yesterday", "2023-02-29T00:00:00Z", "2024-05-01", "2024-13-01T00:00:00Z", "2024-05-01T24:00:00Z",
            "05/12/2026 10:23:11", "05-12-2026 10:23:11", "2024-000T09:30:00", "2023:366:09:30:00",
            "15-Okt-2024 09:30:00", "2024-05-01T09:30:00+", "2024-05-01T09:30:00+0é0",
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
