//! Saved form of channels by expression.

use doublet_core::quantity::Role;
use serde::{Deserialize, Serialize};

use super::SessionError;
use super::flight::roles_from;
use crate::session::ExpressionSetting;

/// A channel by expression.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpressionTable {
    name: String,
    unit: String,
    expression: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    role: Option<String>,
}

/// The setting a table states.
///
/// # Errors
/// [`SessionError::Name`] for a role that does not exist.
pub(crate) fn expression_from(table: ExpressionTable) -> Result<ExpressionSetting, SessionError> {
    let place = format!("flight.expression '{}'", table.name);
    let roles = table.role.map(|role| roles_from(&place, &[role])).transpose()?;
    let role = roles.and_then(|roles| roles.first().copied());
    Ok(ExpressionSetting { name: table.name, unit: table.unit, expression: table.expression, role })
}

/// The table of a setting.
pub(crate) fn expression_table(setting: &ExpressionSetting) -> ExpressionTable {
    let ExpressionSetting { name, unit, expression, role } = setting.clone();
    ExpressionTable { name, unit, expression, role: role.map(Role::name).map(str::to_owned) }
}
