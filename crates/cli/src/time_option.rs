//! `--time`: the channel that is the time of its source, said on the command line.

use doublet_core::load::{ChannelInfo, ManualTime, Source, stated_unit};
use doublet_core::quantity::{Dimension, Unit};
use doublet_engine::begin::Inspected;

use crate::role_option::split_keys;

/// How the option is written.
pub const FORM: &str = "CHANNEL[,source=NAME][,unit=UNIT][,rate=HZ]";

/// Makes the channels that `options` name the time of their sources in the guess; in seconds where no unit is said or stated. With a rate, the
/// channel gives the start alone.
pub fn set_times(inspected: &mut Inspected, options: &[String]) -> Result<(), String> {
    for option in options {
        set_time(inspected, option).map_err(|line| format!("--time '{option}': {line}"))?;
    }
    Ok(())
}

fn set_time(inspected: &mut Inspected, option: &str) -> Result<(), String> {
    let TimeOption { channel, source: named, unit: option_unit, rate_hz } = parse(option)?;
    let is_named = |source: &&Source| named.is_none_or(|name| source.name == name);
    let sources = inspected.probes.iter().flat_map(|probe| &probe.sources).filter(is_named);
    let mut is_found = false;
    for source in sources {
        let Some(info) = source.channels.iter().find(|other| other.name == channel) else { continue };
        is_found = true;
        let stated = stated_unit(info).filter(|unit| unit.dimension == Dimension::Time);
        let unit = option_unit.or(stated).unwrap_or(Unit::si(Dimension::Time));
        let guess = &mut inspected.guess;
        guess.time.retain(|(name, _)| *name != source.name);
        let time = match rate_hz {
            Some(rate_hz) => ManualTime::Even { start_s: start_s(source, info, unit, rate_hz), rate_hz },
            None => ManualTime::Channel(channel.to_owned(), unit),
        };
        guess.time.push((source.name.clone(), time));
        guess.rows.retain(|(_, row)| row.from.source != source.name || row.from.channel != channel);
    }
    if is_found { Ok(()) } else { Err(format!("no channel '{channel}' there; `doublet inspect` lists them")) }
}

/// Time of the first sample of a source whose samples are evenly spaced at a rate, by the stamps of a channel, s.
fn start_s(source: &Source, channel: &ChannelInfo, unit: Unit, rate_hz: f64) -> f64 {
    let clock = source.clocks.iter().find(|clock| clock.channel == channel.name && clock.unit == unit);
    let coarse = clock.and_then(|clock| clock.coarse).map(|coarse| coarse.start_s(rate_hz));
    let first = || channel.values().iter().find(|value| value.is_finite()).map(|value| unit.to_si(*value));
    coarse.or_else(first).unwrap_or(0.0)
}

/// What an option says.
#[derive(Debug, PartialEq)]
struct TimeOption<'t> {
    channel: &'t str,
    source: Option<&'t str>,
    unit: Option<Unit>,
    rate_hz: Option<f64>,
}

/// The parts of an option; a channel's name may hold commas.
fn parse(option: &str) -> Result<TimeOption<'_>, String> {
    let (channel, keys) = split_keys(option, &["source", "unit", "rate"]);
    let (mut source, mut unit, mut rate_hz) = (None, None, None);
    for (key, value) in keys {
        match key {
            "source" => source = Some(value),
            "rate" => {
                let rate = value.parse::<f64>().ok().filter(|rate| rate.is_finite() && *rate > 0.0);
                rate_hz = Some(rate.ok_or_else(|| format!("'{value}' must be a rate above 0 Hz"))?);
            }
            _ => unit = Some(Unit::parse(value).map_err(|error| error.to_string())?),
        }
    }
    match unit {
        Some(other) if other.dimension != Dimension::Time => Err(format!("{} is not a unit of time", other.symbol)),
        unit => Ok(TimeOption { channel, source, unit, rate_hz }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn option_holds_channel_source_and_unit_of_time() {
        let TimeOption { channel, source, unit, rate_hz } = parse("tick,source=log,unit=ms").unwrap();
        assert_eq!((channel, source, unit.map(|unit| unit.symbol)), ("tick", Some("log"), Some("ms")));
        assert_eq!(rate_hz, None);
        let plain = TimeOption { channel: "Vtrue,_ktas", source: None, unit: None, rate_hz: None };
        assert_eq!(parse("Vtrue,_ktas").unwrap(), plain);
        assert_eq!(parse("UTC,rate=50").unwrap().rate_hz, Some(50.0));
        assert!(parse("UTC,rate=0").unwrap_err().contains("rate above 0 Hz"));
        assert!(parse("tick,unit=kg").unwrap_err().contains("kg is not a unit of time"));
    }
}
