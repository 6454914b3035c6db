//! Delays of the measurements over the windows of a session, for the filter that reconstructs them.

use doublet_core::estimate::{InnovationEvidence, constant_errors};
use doublet_core::reconstruct::tuning::flow_delay::{FlowDelay, estimate_flow_delay};
use doublet_core::reconstruct::tuning::gusts::clean_windows;
use doublet_core::reconstruct::{FilterData, FilterSettings, Measurement};

use super::path_errors::{ConstantError, filter_freed, paths_at_samples, side_by_side};
use super::window_samples::Samples;
use crate::graph::{Context, Control, Footprint, Keyed, Stage, StageResult};
use crate::session::{DelaySource, PathSource, Session};

/// Most steps of Gauss and Newton. Each takes a path without and with each error.
const STEPS: usize = 4;
/// Change of all delays below which no further step is taken, s.
const CONVERGED_S: f64 = 0.001;
/// Where windows are fewer than errors: spans of them whose scatter says how well a delay is known, s, and how many there are at least for
/// each error.
const SPAN_S: f64 = 2.5;
const SPANS: usize = 2;
/// Least delay that is worth a change, s.
const LEAST_S: f64 = 0.005;
/// Largest standard error of a delay that is applied, s.
const MOST_UNCERTAIN_S: f64 = 0.015;

/// The delay of a group of measurements beside what the settings state.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorDelay {
    /// Measurements.
    pub kind: ConstantError,
    /// Delay, s: what the time stamps are late.
    pub delay_s: f64,
    pub standard_error_s: f64,
}

impl SensorDelay {
    /// Standard errors beyond which a delay is significant.
    pub const SIGNIFICANT: f64 = 4.0;

    /// Whether the innovations determine it and call for it.
    pub fn is_significant(&self) -> bool {
        self.is_beyond(Self::SIGNIFICANT)
    }

    /// Whether it is larger than so many of its standard errors, and these are small.
    pub fn is_beyond(&self, errors: f64) -> bool {
        let least = LEAST_S.max(errors * self.standard_error_s);
        self.standard_error_s < MOST_UNCERTAIN_S && self.delay_s.abs() > least
    }
}

/// The delays that the measurements of a session's windows show; empty where too few windows determine them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensorDelays(pub Vec<SensorDelay>);

impl Footprint for SensorDelays {
    fn bytes(&self) -> usize {
        self.0.len() * size_of::<SensorDelay>() + size_of::<Self>()
    }
}

/// Of all windows together, in the order of the session.
impl Stage for SensorDelays {
    type Params<'a> = &'a FilterSettings;
    type Inputs<'a> = &'a [Keyed<Samples>];
    type Output = Self;
    const NAME: &'static str = "delays";

    fn run(settings: &FilterSettings, samples: &[Keyed<Samples>], context: &Context<'_>) -> StageResult<Self> {
        let data: Vec<&FilterData> = samples.iter().map(|samples| &*samples.data).collect();
        estimate_delays(&data, settings, context.control())
    }
}

impl SensorDelays {
    /// With those of flow angles and airspeed replaced by `air_data`.
    pub(super) fn with_air_data(mut self, air_data: Self) -> Self {
        self.0.retain(|delay| !matches!(delay.kind, ConstantError::FlowDelay | ConstantError::AirspeedDelay));
        self.0.extend(air_data.0);
        self
    }

    /// The settings with the significant ones beside the delays they state.
    #[must_use]
    pub fn added_to(&self, settings: &FilterSettings) -> FilterSettings {
        let mut settings = settings.clone();
        for found in self.0.iter().filter(|found| found.is_significant()) {
            shift(&mut settings, found.kind, found.delay_s);
        }
        settings
    }
}

fn shift(settings: &mut FilterSettings, kind: ConstantError, by_s: f64) {
    for &measurement in kind.measurements() {
        settings.measurement_delay_s[measurement as usize] += by_s;
    }
}

/// Whether the paths of a session depend on the delays found.
pub(super) fn needs_delays(session: &Session) -> bool {
    session.delays == DelaySource::Estimated && session.preparation.path != PathSource::Measured
}

/// Delays of ground velocity and position, altitude, flow angles, airspeed and attitude that make the innovations of all windows smallest, by steps
/// of Gauss and Newton ([`constant_errors`]). Offsets of the flow angles are estimated with them.
///
/// # Errors
/// That it was stopped. What the filter fails on leaves none.
pub(super) fn estimate_delays(
    data: &[&FilterData],
    settings: &FilterSettings,
    control: &Control,
) -> StageResult<SensorDelays> {
    let clean = clean_windows(data, settings, &|| control.is_cancelled())?;
    let data: Vec<&FilterData> = clean.iter().collect();
    let mut settings = settings.simplified(false);
    let kinds = ConstantError::OFFSETS_AND_DELAYS.into_iter();
    let kinds: Vec<ConstantError> = kinds.filter(|kind| kind.is_in(&data)).collect();
    let mut found: Vec<SensorDelay> = kinds
        .iter()
        .filter(|kind| kind.is_delay())
        .map(|&kind| SensorDelay { kind, delay_s: 0.0, standard_error_s: f64::INFINITY })
        .collect();
    for _ in 0..STEPS {
        control.checkpoint()?;
        let Ok(Some((estimates, deviations))) = step(&data, &kinds, &settings, control) else {
            control.checkpoint()?;
            return Ok(SensorDelays::default());
        };
        let mut largest = 0.0_f64;
        let of_delays = kinds.iter().zip(estimates.iter().zip(&deviations)).filter(|(kind, _)| kind.is_delay());
        for (known, (&kind, (&by_s, &deviation))) in found.iter_mut().zip(of_delays) {
            known.delay_s += by_s;
            known.standard_error_s = deviation;
            shift(&mut settings, kind, by_s);
            largest = largest.max(by_s.abs());
        }
        if largest < CONVERGED_S || !found.iter().any(SensorDelay::is_significant) {
            break;
        }
    }
    Ok(SensorDelays(found))
}

/// Delay of the flow angles beside the one `settings` state for the angle of attack, by the lift over the windows ([`estimate_flow_delay`]).
pub fn flow_delay_by_lift(data: &[&FilterData], settings: &FilterSettings) -> Option<SensorDelay> {
    let clean = clean_windows(data, settings, &|| false).ok()?;
    let found = estimate_flow_delay(&clean.iter().collect::<Vec<_>>())?;
    let stated_s = settings.measurement_delay_s[Measurement::AngleOfAttack as usize];
    let FlowDelay { delay_s, standard_error_s } = found;
    Some(SensorDelay { kind: ConstantError::FlowDelay, delay_s: delay_s - stated_s, standard_error_s })
}

/// One step: what each error is by the innovations with these settings, and its standard error; none where the windows are too short.
fn step(
    data: &[&FilterData],
    kinds: &[ConstantError],
    settings: &FilterSettings,
    control: &Control,
) -> StageResult<Option<(Vec<f64>, Vec<f64>)>> {
    // Rates of change are those of the smoothed path: the filtered one jumps where a measurement is taken.
    let smoothed = (settings, PathSource::Smoothed);
    let nominal = side_by_side(data, smoothed, control)?;
    let at_samples = paths_at_samples(data, &nominal, smoothed)?;
    let freed = filter_freed(data, &at_samples, kinds, settings, control)?;
    let has_many_windows = data.len() > kinds.len();
    let evidence: Vec<InnovationEvidence> = nominal
        .iter()
        .enumerate()
        .flat_map(|(index, nominal)| {
            let freed: Vec<_> = kinds.iter().zip(&freed).map(|(kind, paths)| (&paths[index], kind.step())).collect();
            match has_many_windows {
                true => vec![InnovationEvidence::new(nominal, &freed)],
                false => InnovationEvidence::of_spans(nominal, &freed, SPAN_S),
            }
        })
        .collect();
    if !has_many_windows && evidence.len() < SPANS * kinds.len() {
        return Ok(None);
    }
    let priors: Vec<f64> = kinds.iter().map(|kind| kind.prior_deviation()).collect();
    let found = constant_errors(&evidence, &priors)?;
    Ok(Some((found.estimates, found.cautious_deviations)))
}
