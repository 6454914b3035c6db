//! The unit of time stamps that state none: what makes them a recording of flight, and what is to be asked.

use crate::load::clock::Clock;
use crate::load::clocks::counter::unwrap_counter;
use crate::load::contents::Source;
use crate::quantity::Unit;

/// What to do about a time that is not understood.
pub(crate) const UNREAD_CURE: &str = "write it as one of these, or state the sample rate in the channel map";

/// A unit of time and its name in words.
type NamedUnit = (Unit, &'static str);

/// Rates of recordings of flight, Hz: slower ones tell no motion, faster ones are not recorded for minutes.
const RATES_HZ: [f64; 2] = [0.5, 5000.0];
/// Rate that decides where two units are possible, Hz.
const USUAL_HZ: f64 = 50.0;
/// Rates in seconds at which stamps can be minutes, Hz: above they are hours.
const FAST_HZ: [f64; 2] = [400.0, 15_000.0];
/// Longest recording, s.
const LONGEST_S: f64 = 86_400.0;
/// Days since 1899-12-30 (serial days of spreadsheets) from 1954 to 2119.
const SERIAL_DAYS: [f64; 2] = [20_000.0, 80_000.0];
/// Seconds since 1970 from 2000 to 2100.
const SINCE_1970_S: [f64; 2] = [9.46e8, 4.1e9];
/// Whole stamps that fit another unit alone are not in seconds where these would be slower and longer than this, Hz and s.
const SLOWEST_HZ: f64 = 0.1;
const LONG_S: f64 = 43_200.0;
/// Units that stamps have where none is stated, with their words.
const UNITS: [(&str, &str); 7] = [
    ("s", "seconds"),
    ("ms", "milliseconds"),
    ("us", "microseconds"),
    ("ns", "nanoseconds"),
    ("min", "minutes"),
    ("h", "hours of the day"),
    ("d", "serial days of a spreadsheet"),
];

/// Stamps of one or more clocks as recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ticks {
    /// Shortest median interval of the clocks.
    interval: f64,
    /// Longest span.
    span: f64,
    /// Smallest and largest stamp.
    range: [f64; 2],
    /// Every stamp is a whole number.
    whole: bool,
}

impl Ticks {
    fn measure(stamps: &[f64], clock: &Clock) -> Self {
        let [first, last] = [clock.start_s, clock.end_s].map(|time_s| clock.unit.from_si(time_s));
        let interval = clock.unit.from_si(clock.interval_s());
        let whole = stamps.iter().all(|stamp| stamp.fract() == 0.0);
        Self { interval, span: last - first, range: [first, last], whole }
    }

    fn and(self, other: Self) -> Self {
        Self {
            interval: self.interval.min(other.interval),
            span: self.span.max(other.span),
            range: [self.range[0].min(other.range[0]), self.range[1].max(other.range[1])],
            whole: self.whole && other.whole,
        }
    }

    /// Rate and span in a unit.
    fn read_in(&self, unit: Unit) -> (f64, f64) {
        (1.0 / (self.interval * unit.scale), self.span * unit.scale)
    }

    /// Whether they make a recording of flight in a unit.
    fn fit(&self, unit: Unit) -> bool {
        let (rate_hz, span_s) = self.read_in(unit);
        let inside = |[least, most]: [f64; 2]| self.range.iter().all(|stamp| (least..=most).contains(stamp));
        let usual = match unit.symbol {
            "d" => inside(SERIAL_DAYS),
            "h" => inside([0.0, 24.0]),
            "min" => (FAST_HZ[0]..FAST_HZ[1]).contains(&(1.0 / self.interval)) && !is_round(self.interval),
            _ => true,
        };
        usual && (RATES_HZ[0]..RATES_HZ[1]).contains(&rate_hz) && span_s <= LONGEST_S
    }

    /// `25 Hz over 60 s`.
    fn describe_rate(&self, unit: Unit) -> String {
        let (rate_hz, span_s) = self.read_in(unit);
        let span = match span_s {
            span if span < 600.0 => format!("{} s", short(span)),
            span if span < 36_000.0 => format!("{} min", short(span / 60.0)),
            span if span < 864_000.0 => format!("{} h", short(span / 3600.0)),
            span => format!("{} days", short(span / 86_400.0)),
        };
        format!("{} Hz over {span}", short(rate_hz))
    }

    /// Whether they are times since 1970 in a part of a second: no other unit gives a date of this century.
    fn are_since_1970(&self, unit: Unit) -> bool {
        let [first, last] = SINCE_1970_S;
        let inside = |stamp: &f64| (first..=last).contains(&(stamp * unit.scale));
        unit.scale < 1.0 && self.range.iter().all(inside)
    }

    /// Whether the unit chosen leaves nothing to ask although it is not seconds: times since 1970, or whole numbers that would be
    /// samples every ten seconds and more for half a day.
    fn is_plain(&self, unit: Unit, others: &[NamedUnit]) -> bool {
        let (rate_hz, span_s) = self.read_in(Unit::si(crate::quantity::Dimension::Time));
        let is_no_flight = rate_hz < SLOWEST_HZ && span_s > LONG_S;
        self.are_since_1970(unit) || (unit.scale < 1.0 && others.is_empty() && self.whole && is_no_flight)
    }

    /// Whether they make a recording of flight in more than one unit; decimals of a second do not, unless they are minutes.
    fn is_ambiguous(&self) -> bool {
        let (chosen, others) = self.decide();
        if chosen.is_some_and(|(unit, _)| self.is_plain(unit, &others)) {
            return false;
        }
        let minutes = others.iter().any(|(unit, _)| unit.symbol == "min");
        !others.is_empty() && chosen.is_some_and(|(unit, _)| self.whole || minutes || unit.symbol != "s")
    }

    /// The fitting unit whose rate is nearest to the usual one, times since 1970 before seconds before others; and the other units that
    /// fit.
    fn decide(&self) -> (Option<NamedUnit>, Vec<NamedUnit>) {
        let known = UNITS.iter().filter_map(|&(symbol, word)| Some((Unit::parse(symbol).ok()?, word)));
        let mut fitting: Vec<_> = known.filter(|(unit, _)| self.fit(*unit)).collect();
        let far = |unit: &Unit| (self.read_in(*unit).0 / USUAL_HZ).ln().abs();
        let order = |unit: &Unit| (!self.are_since_1970(*unit), unit.symbol != "s");
        fitting.sort_by(|(a, _), (b, _)| order(a).cmp(&order(b)).then(far(a).total_cmp(&far(b))));
        if fitting.is_empty() { (None, fitting) } else { (Some(fitting.remove(0)), fitting) }
    }
}

/// Whether a number has two digits at most: a recorder's rate gives such an interval in seconds, hardly ever in minutes.
fn is_round(value: f64) -> bool {
    /// Relative rounding of intervals that are means of stamps.
    const ROUNDING: f64 = 1e-3;
    let two_digits = value * 10.0_f64.powf(1.0 - value.log10().floor());
    (two_digits - two_digits.round()).abs() < ROUNDING * two_digits
}

/// Three digits, without a tail of zeros.
fn short(value: f64) -> String {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 5")]
    let decimals = (2.0 - value.abs().log10().floor()).clamp(0.0, 5.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Gives clocks whose unit nobody stated the one in which their stamps make a recording of flight, and states the question where
/// that is not seconds or could be another. Clocks of one name in one file share their unit: the fastest decides.
pub(crate) fn settle_units(sources: &mut [Source]) {
    let open = |clock: &Clock| !clock.is_unit_stated && clock.index.is_some() && clock.interval_s() > 0.0;
    let mut groups: Vec<(String, Ticks)> = Vec::new();
    for source in sources.iter() {
        for clock in source.clocks.iter().filter(|clock| open(clock)) {
            let Some(index) = clock.index else { continue };
            let ticks = Ticks::measure(source.channels[index].values(), clock);
            match groups.iter_mut().find(|(name, _)| *name == clock.channel) {
                Some((_, all)) => *all = all.and(ticks),
                None => groups.push((clock.channel.clone(), ticks)),
            }
        }
    }
    for source in sources {
        for at in 0..source.clocks.len() {
            let clock = &source.clocks[at];
            let Some((_, ticks)) = groups.iter().find(|(name, _)| *name == clock.channel && open(clock)) else {
                continue;
            };
            let (unit, question) = judge(&clock.channel, ticks);
            let Some(index) = clock.index else { continue };
            let counted = unwrap_counter(source.channels[index].values());
            let stamps: Vec<f64> = counted.iter().map(|&value| unit.to_si(value)).collect();
            let mut settled = Clock::examine(&clock.channel, index, unit, &stamps);
            let is_unit_ambiguous = settled.question.is_none() && ticks.is_ambiguous();
            let question = settled.question.take().or(question).or_else(|| clock.question.clone());
            source.clocks[at] = Clock { is_unit_stated: false, is_unit_ambiguous, question, ..settled };
        }
    }
}

/// The unit of stamps without one, and what is to be asked.
fn judge(channel: &str, ticks: &Ticks) -> (Unit, Option<String>) {
    let seconds = Unit::si(crate::quantity::Dimension::Time);
    let as_seconds = ticks.describe_rate(seconds);
    let (chosen, others) = ticks.decide();
    let Some((unit, word)) = chosen else {
        let text = format!(
            "'{channel}' has no unit, and no unit gives plausible times: in seconds {as_seconds}; state its unit or the sample \
             rate in the channel map"
        );
        return (seconds, Some(text));
    };
    // Decimals of a second, or stamps that no other unit explains, leave nothing to ask.
    let asks = (unit.symbol != "s" && !ticks.is_plain(unit, &others)) || ticks.is_ambiguous();
    let or = others.iter().map(|(other, word)| format!("; in {word} {}", ticks.describe_rate(*other)));
    let or: String =
        if unit.symbol == "s" { or.collect() } else { or.chain([format!("; in seconds {as_seconds}")]).collect() };
    let choice = [unit]
        .into_iter()
        .chain(others.iter().map(|(other, _)| *other))
        .map(|unit| unit.symbol)
        .collect::<Vec<_>>()
        .join(" or ");
    let question = format!(
        "'{channel}' has no unit: read in {word}, {}{or}; state the unit {choice} in the channel map",
        ticks.describe_rate(unit)
    );
    (unit, asks.then_some(question))
}

/// What is odd about a clock in the unit that its file or map states, where another unit would mend it.
pub(crate) fn contradiction(source: &Source, clock: &Clock) -> Option<String> {
    let index = clock.index.filter(|_| clock.is_unit_stated && clock.interval_s() > 0.0)?;
    let ticks = Ticks::measure(source.channels[index].values(), clock);
    if ticks.fit(clock.unit) {
        return None;
    }
    let (better, _) = ticks.decide();
    let stated = format!("'{}' is read in {}: {}", clock.channel, clock.unit.symbol, ticks.describe_rate(clock.unit));
    Some(match better {
        Some((unit, word)) => {
            format!(
                "{stated}; in {word} it is {}: state the unit {} in the channel map",
                ticks.describe_rate(unit),
                unit.symbol
            )
        }
        None => format!("{stated}; check the recording, and the unit of time in the channel map"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stamps of 1,000 samples from `start` by `step`.
    fn judged(start: f64, step: f64) -> (&'static str, Option<String>) {
        let ticks = Ticks {
            interval: step,
            span: 999.0 * step,
            range: [start, start + 999.0 * step],
            whole: step.fract() == 0.0,
        };
        let (unit, question) = judge("t", &ticks);
        (unit.symbol, question)
    }

    #[test]
    fn stamps_without_a_unit_are_read_as_a_recording_of_flight() {
        for (start, step, symbol, asks) in [
            (0.0, 0.04, "s", false),
            (0.0, 0.001, "s", false),
            (0.0, 0.02 / 60.0, "s", true),
            (417_230.0, 40.0, "ms", true),
            (417_230.0, 80.0, "ms", false),
            (86_399_500_123.0, 40_000.0, "us", false),
            (1.778_769e18, 4e7, "ns", false),
            (1.778_769e12, 1000.0, "ms", false),
            (417_230.0, 1000.0, "us", true),
            (417_230.0, 5.0, "ms", true),
            (0.0, 1.0, "s", true),
            (0.0, 1e-5, "h", true),
            (46_156.6, 0.04 / 86_400.0, "d", true),
        ] {
            let (unit, question) = judged(start, step);
            assert_eq!((unit, question.is_some()), (symbol, asks), "{step}: {question:?}");
        }
        let (_, question) = judged(5000.0, 1.0);
        assert_eq!(
            question.unwrap(),
            "'t' has no unit: read in seconds, 1 Hz over 16.6 min; in milliseconds 1000 Hz over 0.999 s; state the unit s or ms in \
             the channel map"
        );
    }
}
