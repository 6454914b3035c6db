//! Channels by expression: what a session states of them, and how that changes.

use doublet_core::prep::{Expression, Operand};
use doublet_core::quantity::{Role, Unit};
use serde::{Deserialize, Serialize};

use super::edit::flight_mut;
use super::{EditError, Session};

/// Source of channels by expression in the list of channels.
pub const EXPRESSION_SOURCE: &str = "expression";
/// Most channels by expression of one flight: each holds a value per sample.
const MOST: usize = 100;
/// Longest name, bytes.
const LONGEST_NAME: usize = 80;

/// A channel computed from others, sample by sample, after clocks and the treatment of signals.
#[derive(Clone, Debug, Default, PartialEq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpressionSetting {
    /// Name in the list of channels; others name it `"expression/NAME"`.
    pub name: String,
    /// Unit the expression gives its values in.
    pub unit: String,
    /// Text, as [`Expression::parse`] understands it.
    pub expression: String,
    /// Role it plays, in the place of a recorded channel where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<Role>,
}

impl ExpressionSetting {
    /// The expression and its unit.
    pub fn parse(&self) -> Result<(Expression, Unit), String> {
        let Self { name, unit, role, .. } = self;
        let refused = |letter: char| letter.is_control() || matches!(letter, '/' | '"' | '{' | '}');
        if name.trim() != name || name.is_empty() || name.len() > LONGEST_NAME || name.contains(refused) {
            return Err(format!(
                "the name is {name:?}: give up to {LONGEST_NAME} characters without / \" {{ }} and without a space at either end"
            ));
        }
        if unit.trim().is_empty() {
            return Err("its unit is missing: state it, or - for a ratio".to_owned());
        }
        let unit = Unit::parse(unit).map_err(|error| error.to_string())?;
        if let Some(role) = role.filter(|role| role.dimension() != unit.dimension) {
            let si = role.dimension().si_symbol();
            return Err(format!(
                "{} cannot be in {}: give a unit like {si}, or leave the role out",
                role.name(),
                unit.symbol
            ));
        }
        let expression = Expression::parse(&self.expression).map_err(|error| error.to_string())?;
        Ok((expression, unit))
    }
}

/// What is wrong with the channels by expression of a flight: the name of each, and one line.
pub fn problems(settings: &[ExpressionSetting]) -> Vec<(String, String)> {
    let mut problems = Vec::new();
    if let Some(first) = settings.get(MOST) {
        problems.push((
            first.name.clone(),
            format!("the flight has {} expressions (limit {MOST}): remove some", settings.len()),
        ));
    }
    for (index, setting) in settings.iter().enumerate().take(MOST) {
        let earlier = &settings[..index];
        let mut report = |line: String| problems.push((setting.name.clone(), line));
        if earlier.iter().any(|other| other.name == setting.name) {
            report("the name is used twice: rename one".to_owned());
        }
        if let Some(role) = setting.role.filter(|role| earlier.iter().any(|other| other.role == Some(*role))) {
            report(format!("another expression already has the role {}: remove one of the two", role.name()));
        }
        match setting.parse() {
            Err(line) => report(line),
            Ok((expression, _)) => {
                if let Some(line) =
                    expression.operands().iter().find_map(|(operand, at)| loops(operand, *at, setting, earlier))
                {
                    report(line);
                }
            }
        }
    }
    problems
}

/// What is wrong with an operand that names an expression: itself, or one that is not above it.
fn loops(
    operand: &Operand,
    position: usize,
    setting: &ExpressionSetting,
    earlier: &[ExpressionSetting],
) -> Option<String> {
    let Operand::Channel(channel) = operand else { return None };
    let name = channel.strip_prefix(EXPRESSION_SOURCE)?.strip_prefix('/')?;
    if name == setting.name {
        return Some(format!("at character {position}: the expression refers to itself: use other channels"));
    }
    let above = earlier.iter().any(|other| other.name == name);
    (!above).then(|| {
        format!("at character {position}: expression '{name}' not found above it: only earlier ones can be used")
    })
}

/// A change of one channel by expression.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpressionEdit {
    pub flight: String,
    /// Present name; `None` adds one.
    pub from: Option<String>,
    /// All of it; `None` removes it.
    pub to: Option<ExpressionSetting>,
}

impl ExpressionEdit {
    pub(super) fn label(&self) -> String {
        match (&self.from, &self.to) {
            (None, Some(to)) => format!("add channel {}", to.name),
            (Some(from), Some(_)) => format!("change channel {from}"),
            (from, None) => format!("remove channel {}", from.as_deref().unwrap_or_default()),
        }
    }

    pub(super) fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        let flight = flight_mut(session, &self.flight)?;
        let mut next = flight.expressions.clone();
        let place = match &self.from {
            None => next.len(),
            Some(from) => {
                let place = next.iter().position(|setting| setting.name == *from);
                let place = place.ok_or_else(|| EditError::Expression(format!("no expression is called '{from}'")))?;
                next.remove(place);
                place
            }
        };
        if let Some(to) = &self.to {
            next.insert(place, to.clone());
        }
        if let Some((name, line)) = problems(&next).into_iter().next() {
            return Err(EditError::Expression(format!("expression '{name}': {line}")));
        }
        flight.expressions = next;
        Ok(())
    }
}
