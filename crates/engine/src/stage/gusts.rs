//! Gusts over the windows of a session, for the filter that reconstructs them.

use doublet_core::reconstruct::tuning::gusts::{Gusts, estimate_gusts};
use doublet_core::reconstruct::{FilterData, FilterSettings};

use super::window_samples::Samples;
use crate::graph::{Context, Footprint, Keyed, Stage, StageResult};
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
pub(super) fn needs_gusts(session: &Session) -> bool {
    session.gusts == GustSource::Estimated && session.preparation.path != PathSource::Measured
}
