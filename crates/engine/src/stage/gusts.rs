//! Gusts over the windows of a session, for the filter that reconstructs them.

use doublet_core::reconstruct::tuning::gusts::{Gusts, estimate_gusts};
use doublet_core::reconstruct::{FilterData, FilterSettings};

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

/// Whether the paths of a session depend on its gusts.
pub fn needs_gusts(session: &Session) -> bool {
    session.gusts == GustSource::Estimated && session.preparation.path != PathSource::Measured
}

/// The session with these gusts in its filter, where they are significant.
pub fn with_gusts(session: &Session, gusts: Option<&Gusts>) -> Session {
    let mut session = session.clone();
    if let Some(gusts) = gusts.filter(|gusts| gusts.is_significant()) {
        session.filter = gusts.added_to(&session.filter);
    }
    session
}

/// The filter of a session for windows of one flight that no pipeline runs: with their gusts, where the session asks for them.
pub(crate) fn filter_for(session: &Session, data: &[&FilterData], control: &Control) -> StageResult<FilterSettings> {
    if !needs_gusts(session) {
        return Ok(session.filter.clone());
    }
    let gusts = estimate_gusts(data, &session.filter, &|| control.is_cancelled())?;
    Ok(with_gusts(session, gusts.as_ref()).filter)
}
