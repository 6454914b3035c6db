//! Delays of the measurements and gusts, each estimated with the other in the filter.

use doublet_core::reconstruct::tuning::gusts::{Gusts, estimate_gusts};
use doublet_core::reconstruct::{FilterData, FilterSettings};

use super::delays::{SensorDelays, estimate_delays, needs_delays};
use super::gusts::needs_gusts;
use crate::graph::{Control, StageResult};
use crate::session::Session;

/// Delays and gusts of the windows of a session, where it asks for them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DelaysAndGusts {
    /// Delays of the measurements.
    pub delays: Option<SensorDelays>,
    /// Gusts.
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
/// with those. A random walk does not tell a gust from a late vane or airspeed: in gusts those delays are left out.
///
/// # Errors
/// Those of the functions.
pub fn estimate_in_turn<E>(
    session: &Session,
    gusts: &dyn Fn(&FilterSettings) -> Result<Option<Gusts>, E>,
    delays: &dyn Fn(&FilterSettings) -> Result<Option<SensorDelays>, E>,
) -> Result<DelaysAndGusts, E> {
    let with = |known: DelaysAndGusts| known.added_to(&session.filter);
    let delays_with = |gusts: Option<Gusts>| match needs_delays(session) {
        true => delays(&with(DelaysAndGusts { delays: None, gusts })),
        false => Ok(None),
    };
    let gusts_with = |delays: Option<SensorDelays>| match needs_gusts(session) {
        true => gusts(&with(DelaysAndGusts { delays, gusts: None })),
        false => Ok(None),
    };
    let delays = delays_with(None)?;
    let gusts = gusts_with(delays.clone())?;
    if delays.is_none() || !gusts.as_ref().is_some_and(Gusts::is_significant) {
        return Ok(DelaysAndGusts { delays, gusts });
    }
    let delays = delays_with(gusts)?.map(SensorDelays::without_air_data);
    Ok(DelaysAndGusts { gusts: gusts_with(delays.clone())?, delays })
}

/// [`estimate_in_turn`] for windows of one flight that no pipeline runs.
pub(crate) fn estimate_delays_and_gusts(
    session: &Session,
    data: &[&FilterData],
    control: &Control,
) -> StageResult<DelaysAndGusts> {
    let gusts = |settings: &FilterSettings| Ok(estimate_gusts(data, settings, &|| control.is_cancelled())?);
    let delays = |settings: &FilterSettings| Ok(Some(estimate_delays(data, settings, control)?));
    estimate_in_turn(session, &gusts, &delays)
}
