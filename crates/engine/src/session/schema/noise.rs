//! Saved form of steady parts and of the reasons behind noise entries.

use std::collections::BTreeMap;

use doublet_core::quantity::Role;
use doublet_core::series::TimeRange;
use serde::{Deserialize, Serialize};

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
    pub fn from_reasons(reasons: &BTreeMap<String, String>) -> Self {
        Self { reason: reasons.clone() }
    }

    /// Whether there is nothing to write.
    pub fn is_empty(&self) -> bool {
        self.reason.is_empty()
    }

    /// The reasons.
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

/// A steady part.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteadyTable {
    flight: String,
    start_s: f64,
    end_s: f64,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    roles: Vec<Role>,
}

impl From<SteadyTable> for SteadyWindow {
    fn from(SteadyTable { flight, start_s, end_s, roles }: SteadyTable) -> Self {
        Self { flight, window: TimeRange { start_s, end_s }, roles }
    }
}

impl From<SteadyWindow> for SteadyTable {
    fn from(SteadyWindow { flight, window, roles }: SteadyWindow) -> Self {
        Self { flight, start_s: window.start_s, end_s: window.end_s, roles }
    }
}
