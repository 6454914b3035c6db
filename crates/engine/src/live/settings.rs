//! What a flight is watched with.

use doublet_core::estimate::{Detrend, FrequencySettings};
use doublet_core::model::Structure;
use doublet_core::reconstruct::FilterSettings;

use super::limits::Limit;
use crate::session::{AngularAcceleration, PathSource, Preparation, Session};
use crate::stage::AircraftData;

/// Largest relative error, per cent, at which a derivative is known well enough.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// Of derivatives that are not named.
    pub all_percent: f64,
    /// Of single ones, by name.
    pub named: Vec<(String, f64)>,
}

impl Default for Goal {
    fn default() -> Self {
        Self { all_percent: 10.0, named: Vec::new() }
    }
}

impl Goal {
    pub fn percent(&self, derivative: &str) -> f64 {
        self.named.iter().find(|(name, _)| name == derivative).map_or(self.all_percent, |(_, percent)| *percent)
    }
}

/// What a flight is watched with.
#[derive(Clone, Debug)]
pub struct LiveSettings {
    /// Filter; never smoothed.
    pub filter: FilterSettings,
    /// How coefficients are formed, from the filtered path.
    pub preparation: Preparation,
    /// Terms of the coefficients.
    pub structure: Structure,
    /// Aircraft as loaded; without one only the path is computed.
    pub aircraft: Option<AircraftData>,
    /// Interval of updates, s of the flight.
    pub update_s: f64,
    /// How long a sample waits for others that are late, s.
    pub latency_s: f64,
    /// Time after which a sample counts 1/e; none where all count alike.
    pub forgetting_s: Option<f64>,
    /// Frequencies of the regression.
    pub band: FrequencySettings,
    /// Errors asked for.
    pub goal: Goal,
    /// What is not to be passed: of the aircraft's envelope unless something else is said of the same quantity.
    pub limits: Vec<Limit>,
}

impl LiveSettings {
    /// Those of a session, for an aircraft as loaded. The path is the filtered one and no window settles; a smoother of the rates has no
    /// place, so they are differentiated.
    pub fn from_session(session: &Session, aircraft: Option<AircraftData>) -> Self {
        let angular_acceleration = match session.preparation.angular_acceleration {
            AngularAcceleration::Smoother => AngularAcceleration::Differentiated,
            other => other,
        };
        let path = PathSource::Filtered;
        let preparation = Preparation { path, settle_s: 0.0, angular_acceleration, ..session.preparation.clone() };
        let envelope = aircraft.as_ref().map(|aircraft| aircraft.loaded.aircraft.flight_envelope);
        Self {
            filter: FilterSettings { smooth: false, smoother_passes: 1, ..session.filter.clone() },
            preparation,
            structure: session.structure.clone(),
            aircraft,
            update_s: 0.5,
            latency_s: 0.3,
            forgetting_s: Some(120.0),
            band: FrequencySettings { detrend: Detrend::Mean, ..FrequencySettings::default() },
            goal: Goal::default(),
            limits: envelope.map(|envelope| Limit::of_envelope(&envelope)).unwrap_or_default(),
        }
    }

    /// Watches these limits too, in the place of those of the same quantities.
    pub fn limit(&mut self, own: &[Limit]) {
        self.limits.retain(|known| own.iter().all(|limit| limit.quantity != known.quantity));
        self.limits.splice(..0, own.iter().cloned());
    }
}
