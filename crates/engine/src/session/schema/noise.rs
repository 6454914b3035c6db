//! Saved form of steady windows and of the reasons behind noise entries.

use std::collections::BTreeMap;

use doublet_core::series::TimeRange;
use serde::{Deserialize, Serialize};

use super::flight::{role_names, roles_from};
use super::{SessionError, unknown};
use crate::session::{NoiseChannel, SteadyWindow};

/// Reasons for noise entries.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseTable {
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    reason: BTreeMap<String, String>,
}

impl NoiseTable {
    /// The table of these reasons.
    pub fn from_reasons(reasons: &BTreeMap<String, String>) -> Self {
        Self { reason: reasons.clone() }
    }

    /// Whether there is nothing to write.
    pub fn is_empty(&self) -> bool {
        self.reason.is_empty()
    }

    /// The reasons.
    ///
    /// # Errors
    /// [`SessionError::Name`] for an entry that does not exist.
    pub fn reasons(self) -> Result<BTreeMap<String, String>, SessionError> {
        match self.reason.keys().find(|name| NoiseChannel::from_name(name).is_none()) {
            Some(name) => {
                let known: Vec<_> = NoiseChannel::all().map(NoiseChannel::name).collect();
                Err(unknown("noise.reason", "name", name, &known))
            }
            None => Ok(self.reason),
        }
    }
}

/// A steady window.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteadyTable {
    flight: String,
    start_s: f64,
    end_s: f64,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    roles: Vec<String>,
}

/// The window a table states.
///
/// # Errors
/// [`SessionError::Name`] for a role that does not exist.
pub(crate) fn steady_from(table: SteadyTable) -> Result<SteadyWindow, SessionError> {
    Ok(SteadyWindow {
        roles: roles_from("steady", &table.roles)?,
        flight: table.flight,
        window: TimeRange { start_s: table.start_s, end_s: table.end_s },
    })
}

/// The table of a window.
pub(crate) fn steady_table(steady: &SteadyWindow) -> SteadyTable {
    SteadyTable {
        flight: steady.flight.clone(),
        start_s: steady.window.start_s,
        end_s: steady.window.end_s,
        roles: role_names(&steady.roles),
    }
}
