//! Gusts over the windows of a session, with the delays of its measurements, for the filter that reconstructs them.

use doublet_core::reconstruct::tuning::gusts::{Gusts, estimate_gusts};
use doublet_core::reconstruct::{FilterData, FilterSettings};

use super::delays::{SensorDelays, estimate_delays, needs_delays};
use super::window_samples::Samples;
use crate::graph::{Context, Control, Footprint, Keyed, Stage, StageResult};
use crate::session::{GustSource, PathSource, Session};

/// The gusts that the measurements of a session's windows call for; none where they cannot be estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionGusts(pub Option<Gusts>);

impl Footprint for SessionGusts {
    fn bytes(&self) -> usize {
        size_of::<Self>()
    }
}

/// Of all windows together, in the order of the session.
impl Stage for SessionGusts {
    type Params<'a> = &'a FilterSettings;
    type Inputs<'a> = &'a [Keyed<Samples>];
    type Output = Self;
    const NAME: &'static str = "gusts";

    fn run(settings: &FilterSettings, samples: &[Keyed<Samples>], context: &Context<'_>) -> StageResult<Self> {
        let data: Vec<&FilterData> = samples.iter().map(|samples| &*samples.data).collect();
        Ok(Self(estimate_gusts(&data, settings, &|| context.control().is_cancelled())?))
    }
}

/// Delays and gusts of the windows of a session, where it asks for them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Air {
    /// Delays of the measurements.
    pub delays: Option<SensorDelays>,
    /// Gusts.
    pub gusts: Option<Gusts>,
}

/// Whether a session asks for delays or gusts.
pub fn needs_air(session: &Session) -> bool {
    needs_delays(session) || needs_gusts(session)
}

fn needs_gusts(session: &Session) -> bool {
    session.gusts == GustSource::Estimated && session.preparation.path != PathSource::Measured
}

/// The session with these delays and gusts in its filter, where they are significant.
#[must_use]
pub fn settled(session: &Session, air: &Air) -> Session {
    let mut session = session.clone();
    if let Some(delays) = &air.delays {
        session.filter = delays.added_to(&session.filter);
    }
    if let Some(gusts) = air.gusts.as_ref().filter(|gusts| gusts.is_significant()) {
        session.filter = gusts.added_to(&session.filter);
    }
    session
}

/// Estimates what a session asks for, by functions of the settings of a filter. Late sensors look like gusts and gusts like late vanes:
/// delays are estimated in steady air first, and gusts with them. Where gusts remain, delays are estimated once more with these, and gusts
/// with those. A random walk does not tell a gust from a late vane or airspeed: in gusts those delays are left out.
///
/// # Errors
/// Those of the functions.
pub fn settle_air<E>(
    session: &Session,
    gusts: &dyn Fn(&FilterSettings) -> Result<Option<Gusts>, E>,
    delays: &dyn Fn(&FilterSettings) -> Result<Option<SensorDelays>, E>,
) -> Result<Air, E> {
    let with = |air: Air| settled(session, &air).filter;
    let late = |gusts: Option<Gusts>| match needs_delays(session) {
        true => delays(&with(Air { delays: None, gusts })),
        false => Ok(None),
    };
    let gusty = |delays: Option<SensorDelays>| match needs_gusts(session) {
        true => gusts(&with(Air { delays, gusts: None })),
        false => Ok(None),
    };
    let delays = late(None)?;
    let gusts = gusty(delays.clone())?;
    if delays.is_none() || !gusts.as_ref().is_some_and(Gusts::is_significant) {
        return Ok(Air { delays, gusts });
    }
    let delays = late(gusts)?.map(SensorDelays::without_air_data);
    Ok(Air { gusts: gusty(delays.clone())?, delays })
}

/// [`settle_air`] for windows of one flight that no pipeline runs.
pub(crate) fn air_of(session: &Session, data: &[&FilterData], control: &Control) -> StageResult<Air> {
    let gusts = |settings: &FilterSettings| Ok(estimate_gusts(data, settings, &|| control.is_cancelled())?);
    let delays = |settings: &FilterSettings| Ok(Some(estimate_delays(data, settings, control)?));
    settle_air(session, &gusts, &delays)
}
