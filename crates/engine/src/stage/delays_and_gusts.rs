//! Delays of the measurements and gusts, each estimated with the other in the filter.

use doublet_core::reconstruct::tuning::gusts::{Gusts, estimate_gusts};
use doublet_core::reconstruct::{FilterData, FilterSettings};

use super::delays::{SensorDelay, SensorDelays, estimate_delays, flow_delay_by_lift, needs_delays};
use super::gusts::needs_gusts;
use crate::graph::{Control, StageResult};
use crate::session::Session;

/// Delays and gusts of the windows of a session, where it asks for them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DelaysAndGusts {
    /// Delays of the measurements.
    pub delays: Option<SensorDelays>,
    pub gusts: Option<Gusts>,
}

impl DelaysAndGusts {
    /// The settings with those that are significant.
    #[must_use]
    pub fn added_to(&self, settings: &FilterSettings) -> FilterSettings {
        let mut settings = settings.clone();
        if let Some(delays) = &self.delays {
            settings = delays.added_to(&settings);
        }
        if let Some(gusts) = self.gusts.as_ref().filter(|gusts| gusts.is_significant()) {
            settings = gusts.added_to(&settings);
        }
        settings
    }
}

/// Whether a session asks for delays or gusts.
pub fn needs_delays_or_gusts(session: &Session) -> bool {
    needs_delays(session) || needs_gusts(session)
}

/// Estimates what a session asks for, by functions of the settings of a filter. Late sensors look like gusts and gusts like late vanes:
/// delays are estimated in steady air first, and gusts with them. Where gusts remain, delays are estimated once more with these, and gusts
/// with those. In gusts the innovations do not tell how late vanes and airspeed are: `flow_delay` gives that of the vanes, that of the airspeed
/// is left out.
pub fn estimate_in_turn<E>(
    session: &Session,
    gusts: &dyn Fn(&FilterSettings) -> Result<Option<Gusts>, E>,
    delays: &dyn Fn(&FilterSettings) -> Result<Option<SensorDelays>, E>,
    flow_delay: &dyn Fn() -> Option<SensorDelay>,
) -> Result<DelaysAndGusts, E> {
    let with = |known: DelaysAndGusts| known.added_to(&session.filter);
    let delays_with = |known: DelaysAndGusts| if needs_delays(session) { delays(&with(known)) } else { Ok(None) };
    let gusts_with = |delays: Option<SensorDelays>| match needs_gusts(session) {
        true => gusts(&with(DelaysAndGusts { delays, gusts: None })),
        false => Ok(None),
    };
    let delays = delays_with(DelaysAndGusts::default())?;
    let gusts = gusts_with(delays.clone())?;
    if delays.is_none() || !gusts.as_ref().is_some_and(Gusts::is_significant) {
        return Ok(DelaysAndGusts { delays, gusts });
    }
    let flow_delay = SensorDelays(flow_delay().into_iter().collect());
    let delays = delays_with(DelaysAndGusts { delays: Some(flow_delay.clone()), gusts })?;
    let delays = delays.map(|delays| delays.with_air_data(flow_delay));
    Ok(DelaysAndGusts { gusts: gusts_with(delays.clone())?, delays })
}

/// [`estimate_in_turn`] for windows of one flight that no pipeline runs.
///
/// # Errors
/// That of a window that cannot be filtered; or that it was stopped.
pub fn estimate_delays_and_gusts(
    session: &Session,
    data: &[&FilterData],
    control: &Control,
) -> StageResult<DelaysAndGusts> {
    let gusts = |settings: &FilterSettings| Ok(estimate_gusts(data, settings, &|| control.is_cancelled())?);
    let delays = |settings: &FilterSettings| Ok(Some(estimate_delays(data, settings, control)?));
    estimate_in_turn(session, &gusts, &delays, &|| flow_delay_by_lift(data, &session.filter))
}
