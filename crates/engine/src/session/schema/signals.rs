//! Saved form of smoothing and resampling.

use doublet_core::prep::{Interpolation, Resampling};
use serde::{Deserialize, Serialize};

use super::flight::{role_names, roles_from};
use super::{SessionError, choose, name_of, unknown};
use crate::session::{HeldSampleUse, SignalPreset, SignalRule, SignalSetting};

/// What is done to a flight's signals: a preset, or rules.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignalsTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    preset: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    max_gap_s: Option<f64>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    position_from_velocity: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    held_samples: Option<String>,
    #[serde(default, rename = "rule", skip_serializing_if = "Vec::is_empty")]
    rules: Vec<RuleTable>,
}

impl SignalsTable {
    /// Whether there is nothing to write.
    pub fn is_empty(&self) -> bool {
        let Self { preset, max_gap_s, position_from_velocity, held_samples, rules } = self;
        let none_stated = preset.is_none() && max_gap_s.is_none() && held_samples.is_none();
        none_stated && !position_from_velocity && rules.is_empty()
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RuleTable {
    roles: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    moving_average: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    polynomial: Option<PolynomialTable>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    resample: Option<ResampleTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PolynomialTable {
    degree: usize,
    width: usize,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ResampleTable {
    rate_hz: f64,
    interpolation: String,
}

const INTERPOLATIONS: [(&str, Interpolation); 2] =
    [("linear", Interpolation::Linear), ("quadratic_spline", Interpolation::QuadraticSpline)];

const HELD_SAMPLES: [(&str, HeldSampleUse); 2] = [("once", HeldSampleUse::Once), ("keep", HeldSampleUse::Every)];

/// The setting a table states: the rules of its preset, then its own.
///
/// # Errors
/// [`SessionError::Name`] for a role or choice that does not exist.
pub(crate) fn signals_from(table: SignalsTable) -> Result<SignalSetting, SessionError> {
    let mut rules = Vec::new();
    if let Some(name) = &table.preset {
        let preset = SignalPreset::ALL.into_iter().find(|preset| preset.name() == name);
        let known = SignalPreset::ALL.map(SignalPreset::name);
        rules = preset.ok_or_else(|| unknown("flight.signals", "preset", name, &known))?.rules();
    }
    for rule in table.rules {
        rules.push(rule_from(rule)?);
    }
    let held_samples = table.held_samples.map(|name| choose(&HELD_SAMPLES, "flight.signals.held_samples", &name));
    let (max_gap_s, position_from_velocity) = (table.max_gap_s, table.position_from_velocity);
    Ok(SignalSetting {
        max_gap_s,
        rules,
        position_from_velocity,
        held_samples: held_samples.transpose()?.unwrap_or_default(),
    })
}

fn rule_from(table: RuleTable) -> Result<SignalRule, SessionError> {
    let resampling = |resample: ResampleTable| {
        let interpolation = choose(&INTERPOLATIONS, "flight.signals.rule.resample", &resample.interpolation)?;
        Ok::<_, SessionError>(Resampling { rate_hz: resample.rate_hz, interpolation })
    };
    Ok(SignalRule {
        roles: roles_from("flight.signals.rule", &table.roles)?,
        moving_average: table.moving_average,
        polynomial: table.polynomial.map(|polynomial| (polynomial.degree, polynomial.width)),
        resampling: table.resample.map(resampling).transpose()?,
    })
}

/// The table of a setting.
pub(crate) fn signals_table(setting: &SignalSetting) -> SignalsTable {
    let preset = setting.preset_of_rules();
    let rules = if preset.is_some() { &[][..] } else { &setting.rules };
    SignalsTable {
        preset: preset.filter(|preset| *preset != SignalPreset::AsRecorded).map(|preset| preset.name().to_owned()),
        max_gap_s: setting.max_gap_s,
        position_from_velocity: setting.position_from_velocity,
        held_samples: (setting.held_samples != HeldSampleUse::default())
            .then(|| name_of(&HELD_SAMPLES, setting.held_samples)),
        rules: rules.iter().map(rule_table).collect(),
    }
}

fn rule_table(rule: &SignalRule) -> RuleTable {
    RuleTable {
        roles: role_names(&rule.roles),
        moving_average: rule.moving_average,
        polynomial: rule.polynomial.map(|(degree, width)| PolynomialTable { degree, width }),
        resample: rule.resampling.map(|resampling| ResampleTable {
            rate_hz: resampling.rate_hz,
            interpolation: name_of(&INTERPOLATIONS, resampling.interpolation),
        }),
    }
}
