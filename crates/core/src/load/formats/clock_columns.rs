//! Times of day in columns of their own: hours, minutes, seconds and thousandths.

use crate::load::contents::{ChannelInfo, Source};
use crate::load::names::words::plain_letters;

const HOURS: [&str; 5] = ["hour", "hours", "hh", "hr", "stunde"];
const MINUTES: [&str; 5] = ["min", "minute", "minutes", "mm", "mn"];
const SECONDS: [&str; 5] = ["sec", "second", "seconds", "ss", "sekunde"];
const THOUSANDTHS: [&str; 6] = ["ms", "msec", "msecs", "millisecond", "milliseconds", "millis"];

/// The column called so whose numbers are from zero to below `end`, whole ones where `whole`.
fn find(source: &Source, names: &[&str], end: f64, whole: bool) -> Option<usize> {
    let is_part = |value: &f64| !value.is_finite() || ((0.0..end).contains(value) && (!whole || value.fract() == 0.0));
    source.channels.iter().position(|channel| {
        names.contains(&plain_letters(&channel.name).as_str()) && channel.values().iter().all(is_part)
    })
}

/// Makes the column of the seconds times of day, s, where hours and minutes stand beside it; `pass_midnight` lets them increase.
pub(crate) fn join(source: &mut Source, pass_midnight: impl Fn(&mut [f64]) -> usize) {
    let parts =
        [find(source, &HOURS, 24.0, true), find(source, &MINUTES, 60.0, true), find(source, &SECONDS, 61.0, false)];
    let [Some(hours), Some(minutes), Some(seconds)] = parts else { return };
    let column = |index: usize| source.channels[index].values();
    let is_whole = column(seconds).iter().all(|value| !value.is_finite() || value.fract() == 0.0);
    let thousandths = find(source, &THOUSANDTHS, 1000.0, false).filter(|_| is_whole);
    let rest = |k: usize| thousandths.map_or(0.0, |index| 1e-3 * column(index)[k]);
    let count = column(seconds).len();
    if [hours, minutes].iter().any(|index| column(*index).len() != count) {
        return;
    }
    let of_day = |k: usize| 3600.0 * column(hours)[k] + 60.0 * column(minutes)[k] + column(seconds)[k] + rest(k);
    let mut values: Vec<f64> = (0..count).map(of_day).collect();
    pass_midnight(&mut values);
    let name = source.channels[seconds].name.clone();
    source.channels[seconds] =
        ChannelInfo { is_time_of_day: true, ..ChannelInfo::new(name, Some("s".to_owned()), values) };
    if let Some(index) = thousandths {
        source.channels.remove(index);
    }
}

#[cfg(test)]
mod tests {
    use crate::load::probe_of;

    #[test]
    fn hours_minutes_and_seconds_in_columns_are_one_time() {
        for (head, with_thousandths) in [("Year,Hour,Min,Sec", false), ("year,HH,MM,SS,ms", true)] {
            let text =
                format!("{head},Roll [deg]\n{}", (0..1000).map(|k| row(k, with_thousandths)).collect::<String>());
            let probe = probe_of(&text);
            let clock = &probe.sources[0].clocks[0];
            assert!((clock.start_s - 86_390.0).abs() < 1e-9 && (clock.rate_hz - 50.0).abs() < 0.1, "{head}: {clock:?}");
            assert!((clock.end_s - 86_409.98).abs() < 2e-3, "past midnight: {}", clock.end_s);
        }
    }

    fn row(k: u32, with_thousandths: bool) -> String {
        let t = 86_390.0 + 0.02 * f64::from(k);
        let (hour, minute, second) = ((t / 3600.0).floor() % 24.0, (t / 60.0).floor() % 60.0, t % 60.0);
        match with_thousandths {
            true => format!("2026,{hour},{minute},{},{:.0},{k}\n", second.floor(), 1e3 * second.fract()),
            false => format!("2026,{hour},{minute},{second:.2},{k}\n"),
        }
    }
}
