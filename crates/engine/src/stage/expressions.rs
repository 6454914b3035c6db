//! Channels by expression, on a flight whose clocks and signals are as the session says.

use std::sync::Arc;

use doublet_core::message;
use doublet_core::message::quoted;
use doublet_core::prep::{Operand, between_samples, did_you_mean};
use doublet_core::series::{Channel, Recording, Series};

use super::recording::LoadedFlight;
use super::signals::wraps;
use crate::graph::StageResult;
use crate::session::{EXPRESSION_SOURCE, ExpressionSetting};

/// What to do where no name is near.
const LIST: &str = "choose a channel of the recording";

/// A channel that was made by an expression.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpressedChannel {
    /// What the session says of it.
    pub setting: ExpressionSetting,
    /// Its place among the recording's channels.
    pub channel: usize,
    /// The channel whose role it took.
    pub replaced: Option<usize>,
}

/// The flight with a channel for each expression, in their order. A role that is recorded goes over to the expression, and is said.
pub fn add_expressions(flight: &LoadedFlight, settings: &[ExpressionSetting]) -> StageResult<LoadedFlight> {
    let mut flight = flight.clone();
    for setting in settings {
        let LoadedFlight { recording, expressions, .. } = &mut flight;
        let channel = channel(recording, setting).map_err(|line| format!("expression '{}': {line}", setting.name))?;
        let place = recording.channels.len();
        recording.channels.push(channel);
        let replaced = setting.role.and_then(|role| recording.roles.insert(role, place));
        if let (Some(role), Some(recorded)) = (setting.role, replaced) {
            let recorded = &recording.channels[recorded];
            recording.warnings.push(message!(
                "{} is the expression {}, not the channel {} of {}",
                role.name(),
                quoted(&setting.name),
                quoted(&recorded.name),
                &recorded.source
            ));
        }
        expressions.push(ExpressedChannel { setting: setting.clone(), channel: place, replaced });
    }
    Ok(flight)
}

/// First value of an expression as it would be in the place of the one called `instead`, or behind all others; in its own unit, `None`
/// where no sample has one.
pub fn expression_preview(
    flight: &LoadedFlight,
    instead: Option<&str>,
    setting: &ExpressionSetting,
) -> StageResult<Option<f64>> {
    let mut recording = flight.recording.clone();
    let place = flight.expressions.iter().position(|made| Some(made.setting.name.as_str()) == instead);
    for made in flight.expressions[place.unwrap_or(flight.expressions.len())..].iter().rev() {
        recording.channels.truncate(made.channel);
        if let Some(role) = made.setting.role {
            match made.replaced {
                Some(recorded) => recording.roles.insert(role, recorded),
                None => recording.roles.remove(&role),
            };
        }
    }
    let made = channel(&recording, &ExpressionSetting { role: None, ..setting.clone() })?;
    setting.parse()?;
    Ok(made.series.values.iter().copied().find(|value| value.is_finite()))
}

/// The channel an expression gives: on the stamps of the first channel it names. Channels with the same stamps enter sample by sample,
/// others by straight lines between their own samples. In SI with a role, in the unit the session states otherwise.
fn channel(recording: &Recording, setting: &ExpressionSetting) -> StageResult<Channel> {
    let (expression, unit) = setting.parse()?;
    let mut columns: Vec<Arc<[f64]>> = Vec::new();
    let mut base: Option<Arc<[f64]>> = None;
    for (operand, position) in expression.operands() {
        let (found, turns) =
            operand_channel(recording, operand).map_err(|line| format!("at character {position}: {line}"))?;
        let Series { time_s, values } = &found.series;
        let base = base.get_or_insert_with(|| Arc::clone(time_s));
        columns.push(if Arc::ptr_eq(base, time_s) || base == time_s {
            Arc::clone(values)
        } else {
            between_samples(&found.series, base, recording.max_gap_s, turns).into()
        });
    }
    let time_s = base.unwrap_or_default();
    let mut stack = Vec::new();
    let in_unit = |value: f64| if setting.role.is_some() { unit.to_si(value) } else { value };
    let values = (0..time_s.len()).map(|k| in_unit(expression.value(|index| columns[index][k], &mut stack))).collect();
    let symbol = setting.role.map_or(unit.symbol, |role| role.dimension().si_symbol());
    Ok(Channel {
        source: EXPRESSION_SOURCE.to_owned(),
        name: setting.name.clone(),
        unit: symbol.to_owned(),
        series: Series { time_s, values },
    })
}

/// The channel an operand names, and whether it is an angle that jumps by whole turns.
fn operand_channel<'a>(recording: &'a Recording, operand: &Operand) -> StageResult<(&'a Channel, bool)> {
    let name = match operand {
        Operand::Role(role) => {
            let known = recording.roles.keys().map(|role| role.name());
            return recording.role(*role).map(|channel| (channel, wraps(*role))).ok_or_else(|| {
                format!("{} is not recorded: {}", role.name(), did_you_mean(role.name(), known, LIST)).into()
            });
        }
        Operand::Channel(name) => name,
    };
    let exact = recording.channels.iter().position(|channel| channel.full_name() == *name);
    let called: Vec<usize> =
        (0..recording.channels.len()).filter(|index| recording.channels[*index].name == *name).collect();
    match (exact, &called[..]) {
        (Some(index), _) | (None, &[index]) => {
            let role = recording.roles.iter().find(|(_, played)| **played == index).map(|(role, _)| *role);
            Ok((&recording.channels[index], role.is_some_and(wraps)))
        }
        (None, []) => {
            let known: Vec<String> =
                recording.channels.iter().flat_map(|channel| [channel.full_name(), channel.name.clone()]).collect();
            let hint = did_you_mean(name, known.iter().map(String::as_str), LIST);
            Err(format!("no channel is called '{name}': {hint}").into())
        }
        (None, several) => {
            let all: Vec<_> =
                several.iter().take(4).map(|index| format!("\"{}\"", recording.channels[*index].full_name())).collect();
            Err(format!(
                "{} channels are called '{name}': add the source, for example {}",
                several.len(),
                all.join(" or ")
            )
            .into())
        }
    }
}
