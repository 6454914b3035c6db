//! Saved form of smoothing and resampling.

use serde::{Deserialize, Serialize};

use super::is_default;
use crate::session::{HeldSampleUse, SignalPreset, SignalRule, SignalSetting};

/// What is done to a flight's signals: a preset, or rules.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SignalsTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    preset: Option<SignalPreset>,
    #[serde(skip_serializing_if = "Option::is_none")]
    max_gap_s: Option<f64>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    position_from_velocity: bool,
    #[serde(skip_serializing_if = "is_default")]
    held_samples: HeldSampleUse,
    #[serde(rename = "rule", skip_serializing_if = "Vec::is_empty")]
    rules: Vec<SignalRule>,
}

/// The rules of the preset, then the own ones.
impl From<SignalsTable> for SignalSetting {
    fn from(table: SignalsTable) -> Self {
        let SignalsTable { preset, max_gap_s, position_from_velocity, held_samples, rules } = table;
        let rules = preset.map(SignalPreset::rules).into_iter().flatten().chain(rules).collect();
        Self { max_gap_s, rules, position_from_velocity, held_samples }
    }
}

impl From<SignalSetting> for SignalsTable {
    fn from(setting: SignalSetting) -> Self {
        let preset = setting.preset_of_rules();
        let SignalSetting { max_gap_s, rules, position_from_velocity, held_samples } = setting;
        Self {
            preset: preset.filter(|preset| *preset != SignalPreset::AsRecorded),
            max_gap_s,
            position_from_velocity,
            held_samples,
            rules: if preset.is_some() { Vec::new() } else { rules },
        }
    }
}
