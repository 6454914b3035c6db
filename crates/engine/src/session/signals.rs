//! What is done to signals before they are used.

use doublet_core::hash_fields;
use doublet_core::prep::{Interpolation, Resampling};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{Input, Measurement};
use serde::{Deserialize, Serialize};

use super::edit::flight_mut;
use super::schema::SignalsTable;
use super::{ClockSetting, EditError, Session};

/// Smoothing and resampling of a flight's signals. The default leaves every signal as recorded.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "SignalsTable", into = "SignalsTable")]
pub struct SignalSetting {
    /// Longest interval between samples that is bridged by anything that interpolates, s; `None` for a few of a channel's own.
    pub max_gap_s: Option<f64>,
    /// What is done to which roles. No role is named twice.
    pub rules: Vec<SignalRule>,
    /// Whether the ground velocity, as the rules leave it, gives the position north and east by the trapezoidal rule where none is
    /// recorded (thesis section 4.4.3).
    pub position_from_velocity: bool,
    /// What becomes of values that a recorder repeats because the sensor is slower than it.
    pub held_samples: HeldSampleUse,
}

hash_fields!(SignalSetting { rules, position_from_velocity, held_samples; max_gap_s });

/// What becomes of values that a recorder repeats because the sensor is slower than it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeldSampleUse {
    /// The first of each counts.
    #[default]
    Once,
    /// Every one counts as a measurement of its own.
    #[serde(rename = "keep")]
    Every,
}

/// What is done to some roles: averaging, then the polynomial, then new samples.
#[derive(Clone, Debug, Default, PartialEq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignalRule {
    /// Roles; those a recording lacks are passed over.
    pub roles: Vec<Role>,
    /// Samples of a moving average.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moving_average: Option<usize>,
    /// Degree and samples (odd) of a polynomial over a moving window (Savitzky-Golay).
    #[serde(default, with = "polynomial", skip_serializing_if = "Option::is_none")]
    pub polynomial: Option<(usize, usize)>,
    /// New samples.
    #[serde(default, rename = "resample", skip_serializing_if = "Option::is_none")]
    pub resampling: Option<Resampling>,
}

/// Saved form of a polynomial: `{ degree = 2, width = 11 }`.
mod polynomial {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Polynomial {
        degree: usize,
        width: usize,
    }

    pub fn serialize<S: Serializer>(value: &Option<(usize, usize)>, serializer: S) -> Result<S::Ok, S::Error> {
        value.map(|(degree, width)| Polynomial { degree, width }).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<(usize, usize)>, D::Error> {
        let polynomial = Option::<Polynomial>::deserialize(deserializer)?;
        Ok(polynomial.map(|Polynomial { degree, width }| (degree, width)))
    }
}

/// A named set of rules.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SignalPreset {
    /// Nothing is done: every signal keeps its samples.
    #[serde(rename = "as recorded")]
    AsRecorded,
    /// Thesis section 4.4.3: inertial samples through a moving average of 4 and a polynomial of degree 2 over 11, by quadratic
    /// spline to 100 Hz; flow angles by quadratic spline, all else that enters the filter by straight lines to 100 Hz; position from
    /// the velocity.
    Thesis,
}

impl SignalPreset {
    doublet_core::named_variants! {
        /// Name in files and menus.
        pub name: AsRecorded "as recorded", Thesis "thesis"
    }

    /// Whether it integrates the velocity to a position.
    pub fn position_from_velocity(self) -> bool {
        self == Self::Thesis
    }

    pub fn rules(self) -> Vec<SignalRule> {
        /// Rate the thesis brings every signal to, Hz.
        const RATE_HZ: f64 = 100.0;
        let by = |interpolation| Some(Resampling { rate_hz: RATE_HZ, interpolation });
        let rule = |roles, interpolation| SignalRule {
            roles,
            moving_average: None,
            polynomial: None,
            resampling: by(interpolation),
        };
        if self == Self::AsRecorded {
            return Vec::new();
        }
        let angles = [Measurement::AngleOfAttack, Measurement::Sideslip];
        let others = Measurement::ALL.into_iter().filter(|m| !angles.contains(m)).map(Measurement::role);
        let controls = [Role::Aileron, Role::Elevator, Role::Rudder];
        vec![
            SignalRule {
                moving_average: Some(4),
                polynomial: Some((2, 11)),
                ..rule(Input::ALL.map(Input::role).to_vec(), Interpolation::QuadraticSpline)
            },
            rule(angles.map(Measurement::role).to_vec(), Interpolation::QuadraticSpline),
            rule(others.chain(controls).collect(), Interpolation::Linear),
        ]
    }
}

impl SignalSetting {
    /// The rule that names a role.
    pub fn rule(&self, role: Role) -> Option<&SignalRule> {
        self.rules.iter().find(|rule| rule.roles.contains(&role))
    }

    /// The setting with what `rule` does for `role` alone; its list of roles does not count.
    #[must_use]
    pub fn with(&self, role: Role, rule: &SignalRule) -> Self {
        let mut next = self.clone();
        next.rules.iter_mut().for_each(|other| other.roles.retain(|named| *named != role));
        let does = |other: &SignalRule| (other.moving_average, other.polynomial, other.resampling);
        match next.rules.iter_mut().find(|other| does(other) == does(rule)) {
            Some(same) => same.roles.push(role),
            None => next.rules.push(SignalRule { roles: vec![role], ..rule.clone() }),
        }
        next.rules.retain(|rule| !rule.roles.is_empty() && does(rule) != (None, None, None));
        next
    }

    /// The preset whose rules these are, whatever becomes of the position.
    pub(crate) fn preset_of_rules(&self) -> Option<SignalPreset> {
        SignalPreset::ALL.into_iter().find(|preset| preset.rules() == self.rules)
    }

    pub fn preset(&self) -> Option<SignalPreset> {
        self.preset_of_rules().filter(|preset| preset.position_from_velocity() == self.position_from_velocity)
    }

    /// The setting with a preset in the place of what is done to signals.
    #[must_use]
    pub fn with_preset(&self, preset: SignalPreset) -> Self {
        let position_from_velocity = preset.position_from_velocity();
        Self { rules: preset.rules(), position_from_velocity, ..self.clone() }
    }

    /// What is wrong with it, one line each.
    pub fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        if let Some(gap) = self.max_gap_s.filter(|gap| !(gap.is_finite() && *gap > 0.0)) {
            problems.push(format!("longest gap {gap} s must be above zero"));
        }
        for (index, rule) in self.rules.iter().enumerate() {
            let twice = rule.roles.iter().enumerate().find(|(place, role)| {
                let earlier = self.rules[..index].iter().flat_map(|rule| &rule.roles);
                earlier.chain(&rule.roles[..*place]).any(|other| other == *role)
            });
            if let Some((_, role)) = twice {
                problems.push(format!("{} is in two rules: remove it from one", role.name()));
            }
            if rule.moving_average == Some(0) {
                problems.push("moving average over 0 samples: enter a number from 1 up".to_owned());
            }
            if let Some((degree, width)) = rule.polynomial
                && (width % 2 == 0 || degree >= width)
            {
                problems.push(format!(
                    "polynomial of degree {degree} over {width} samples: enter an odd number of samples above the degree"
                ));
            }
            if let Some(Resampling { rate_hz, .. }) = rule.resampling
                && !(rate_hz > 0.0 && rate_hz <= MOST_HZ)
            {
                problems.push(format!("resampling to {rate_hz} Hz: enter a rate above 0 and up to {MOST_HZ} Hz"));
            }
        }
        problems
    }
}

/// Highest rate a signal is resampled to, Hz.
const MOST_HZ: f64 = 1000.0;

/// A change of clocks, smoothing or resampling.
#[derive(Clone, Debug, PartialEq)]
pub enum SignalEdit {
    /// What is done to a flight's signals.
    Setting {
        flight: String,
        /// All of it.
        setting: SignalSetting,
    },
    /// Another instruments file.
    Instruments {
        flight: String,
        /// Its file, or `builtin:` and a name.
        file: String,
    },
    /// Shifts the clock of a source by hand.
    Shift {
        flight: String,
        /// Source as its clock names it (a beginning with `*`), or its own name where it has no clock yet.
        source: String,
        /// Seconds added to its stamps beside what its clock says.
        shift_s: f64,
    },
}

impl SignalEdit {
    pub(super) fn label(&self) -> String {
        match self {
            Self::Setting { flight, .. } => format!("change signals of {flight}"),
            Self::Instruments { flight, .. } => format!("change instruments of {flight}"),
            Self::Shift { source, .. } => format!("shift {source} in time"),
        }
    }

    pub(super) fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        let (Self::Setting { flight: name, .. }
        | Self::Instruments { flight: name, .. }
        | Self::Shift { flight: name, .. }) = self;
        let flight = flight_mut(session, name)?;
        match self {
            Self::Setting { setting, .. } => match setting.problems().into_iter().next() {
                Some(problem) => return Err(EditError::Signals(problem)),
                None => flight.signals = setting.clone(),
            },
            Self::Instruments { file, .. } => {
                flight.instruments.get_or_insert_default().file.clone_from(file);
            }
            Self::Shift { source, shift_s, .. } => {
                if !shift_s.is_finite() {
                    let field = format!("shift of {source}");
                    return Err(EditError::Value { field, value: *shift_s, allowed: "it must be a number, s" });
                }
                match flight.clocks.iter_mut().find(|clock| clock.source == *source) {
                    Some(clock) => clock.shift_s = *shift_s,
                    None => flight.clocks.push(ClockSetting { shift_s: *shift_s, ..ClockSetting::new(source) }),
                }
            }
        }
        Ok(())
    }
}
