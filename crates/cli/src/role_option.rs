//! `--role`: a channel for a role, said on the command line in the place of what was guessed.

use doublet_core::load::{self, ChannelName, ManualChannel, Probe};
use doublet_core::quantity::{Role, Unit};
use doublet_engine::begin::Inspected;

/// How the option is written.
pub const FORM: &str = "ROLE=CHANNEL[,source=NAME][,unit=UNIT][,scale=X][,offset=X]";

/// What one option says.
#[derive(Debug, Default, PartialEq)]
struct RoleOption<'t> {
    channel: &'t str,
    source: Option<&'t str>,
    unit: Option<Unit>,
    scale: Option<f64>,
    offset: Option<f64>,
}

/// Gives each role named by `options` its channel in the guess.
pub fn set_roles(inspected: &mut Inspected, options: &[String]) -> Result<(), String> {
    for option in options {
        let (role, parsed) = parse(option).map_err(|line| format!("--role '{option}': {line}"))?;
        let row = make_row(&inspected.probes, role, &parsed).map_err(|line| format!("--role '{option}': {line}"))?;
        inspected.guess.rows.retain(|(other, kept)| *other == role || kept.from != row.from);
        inspected.guess.set(role, Some(row));
    }
    Ok(())
}

/// Whether an option says the unit or the scale of `role`.
pub fn says_unit(role: Role, options: &[String]) -> bool {
    let parsed = options.iter().filter_map(|option| parse(option).ok());
    parsed.filter(|(other, _)| *other == role).any(|(_, parsed)| parsed.unit.is_some() || parsed.scale.is_some())
}

/// A role and what is said of it; a channel's name may hold commas.
fn parse(option: &str) -> Result<(Role, RoleOption<'_>), String> {
    let (name, rest) = option.split_once('=').ok_or_else(|| format!("write it as {FORM}"))?;
    let role = Role::from_name(name.trim()).ok_or_else(|| format!("role '{}' not found", name.trim()))?;
    let mut parsed = RoleOption::default();
    let (channel, keys) = split_keys(rest, &["source", "unit", "scale", "offset"]);
    for (key, value) in keys {
        let number = || value.parse::<f64>().ok().filter(|number| number.is_finite());
        let number = || number().ok_or_else(|| format!("'{value}' is not a number"));
        match key {
            "source" => parsed.source = Some(value),
            "unit" => parsed.unit = Some(Unit::parse(value).map_err(|error| error.to_string())?),
            "scale" => parsed.scale = Some(number()?),
            _ => parsed.offset = Some(number()?),
        }
    }
    parsed.channel = channel;
    Ok((role, parsed))
}

/// The channel that an option begins with, and the keys after it that are `known` with their values, the last first.
pub fn split_keys<'t>(option: &'t str, known: &[&str]) -> (&'t str, Vec<(&'t str, &'t str)>) {
    let (mut rest, mut keys) = (option, Vec::new());
    while let Some((before, last)) = rest.rsplit_once(',') {
        let Some((key, value)) = last.split_once('=').filter(|(key, _)| known.contains(&key.trim())) else { break };
        keys.push((key.trim(), value.trim()));
        rest = before;
    }
    (rest.trim(), keys)
}

fn make_row(probes: &[Probe], role: Role, parsed: &RoleOption<'_>) -> Result<ManualChannel, String> {
    let sources = probes.iter().flat_map(|probe| &probe.sources);
    let named = sources.filter(|source| parsed.source.is_none_or(|name| source.name == name));
    let found: Vec<&str> = named
        .filter(|source| source.channels.iter().any(|channel| channel.name == parsed.channel))
        .map(|source| source.name.as_str())
        .collect();
    let source = match found.as_slice() {
        [source] => (*source).to_owned(),
        [] => return Err(format!("no channel '{}' there; `doublet inspect` lists them", parsed.channel)),
        several => return Err(format!("several sources have it: add source= one of {}", several.join(", "))),
    };
    let mut row = load::guess_row(probes, role, &ChannelName { source, channel: parsed.channel.to_owned() });
    if let Some(unit) = parsed.unit {
        if unit.dimension != role.dimension() {
            return Err(format!("{} is in {}, not in {}", role.name(), role.dimension().si_symbol(), unit.symbol));
        }
        row.unit = Some(unit);
    }
    if let Some(scale) = parsed.scale {
        (row.scale, row.turned) = (scale.abs(), scale < 0.0);
    }
    row.offset = parsed.offset.unwrap_or(row.offset);
    Ok(row)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn option_holds_channel_source_unit_and_calibration() {
        let (role, parsed) = parse("delta_e = C2,source=RCOU, unit=deg,scale=-0.07,offset=-1500").unwrap();
        let wanted = RoleOption {
            channel: "C2",
            source: Some("RCOU"),
            unit: Unit::parse("deg").ok(),
            scale: Some(-0.07),
            offset: Some(-1500.0),
        };
        assert_eq!((role, parsed), (Role::Elevator, wanted));
        let (_, parsed) = parse("airspeed=Vtrue,_ktas,unit=kt").unwrap();
        assert_eq!((parsed.channel, parsed.unit.map(|unit| unit.symbol)), ("Vtrue,_ktas", Some("kt")));
        assert!(parse("delta_e").unwrap_err().contains("ROLE=CHANNEL"));
        assert!(parse("elev=C2").unwrap_err().contains("role 'elev' not found"));
        assert!(parse("delta_e=C2,scale=many").unwrap_err().contains("'many' is not a number"));
    }
}
