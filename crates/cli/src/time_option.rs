//! `--time`: the channel that is the time of its source, said on the command line.

use doublet_core::load::{ManualTime, Source, stated_unit};
use doublet_core::quantity::{Dimension, Unit};
use doublet_engine::begin::Inspected;

use crate::role_option::split_keys;

/// How the option is written.
pub const FORM: &str = "CHANNEL[,source=NAME][,unit=UNIT]";

/// Makes the channels that `options` name the time of their sources in the guess; in seconds where no unit is said or stated.
///
/// # Errors
/// One line: a channel or unit that there is not.
pub fn set_times(inspected: &mut Inspected, options: &[String]) -> Result<(), String> {
    for option in options {
        set_time(inspected, option).map_err(|line| format!("--time '{option}': {line}"))?;
    }
    Ok(())
}

fn set_time(inspected: &mut Inspected, option: &str) -> Result<(), String> {
    let (channel, named, option_unit) = parse(option)?;
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
        guess.time.push((source.name.clone(), ManualTime::Channel(channel.to_owned(), unit)));
        guess.rows.retain(|(_, row)| row.from.source != source.name || row.from.channel != channel);
    }
    if is_found { Ok(()) } else { Err(format!("no channel '{channel}' there; `doublet inspect` lists them")) }
}

/// Channel, source and unit of an option; a channel's name may hold commas.
fn parse(option: &str) -> Result<(&str, Option<&str>, Option<Unit>), String> {
    let (channel, keys) = split_keys(option, &["source", "unit"]);
    let (mut source, mut unit) = (None, None);
    for (key, value) in keys {
        match key {
            "source" => source = Some(value),
            _ => unit = Some(Unit::parse(value).map_err(|error| error.to_string())?),
        }
    }
    match unit {
        Some(other) if other.dimension != Dimension::Time => Err(format!("{} is not a unit of time", other.symbol)),
        unit => Ok((channel, source, unit)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn option_holds_channel_source_and_unit_of_time() {
        let (channel, source, unit) = parse("tick,source=log,unit=ms").unwrap();
        assert_eq!((channel, source, unit.map(|unit| unit.symbol)), ("tick", Some("log"), Some("ms")));
        assert_eq!(parse("Vtrue,_ktas").unwrap(), ("Vtrue,_ktas", None, None));
        assert!(parse("tick,unit=kg").unwrap_err().contains("kg is not a unit of time"));
    }
}
