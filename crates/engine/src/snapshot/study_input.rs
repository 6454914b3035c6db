//! What a study is given of a snapshot.

use super::Snapshot;
use crate::graph::{Context, Keyed, Stage, StageResult};
use crate::session::Session;
use crate::stage::{self, AircraftData, StudyWindow};
use crate::study::StudyInput;

/// The output of a study of everything that `snapshot` has of `session`.
pub fn answer<S: for<'i> Stage<Inputs<'i> = &'i StudyInput<'i>>>(
    session: &Session,
    snapshot: &Snapshot,
    params: S::Params<'_>,
    context: &Context<'_>,
) -> StageResult<Keyed<S::Output>> {
    with_study_input(session, snapshot, context, |input| context.get::<S>(params, input))
}

/// Hands everything that `snapshot` has of `session` to a study.
pub fn with_study_input<T>(
    session: &Session,
    snapshot: &Snapshot,
    context: &Context<'_>,
    study: impl FnOnce(&StudyInput<'_>) -> StageResult<T>,
) -> StageResult<T> {
    let used = snapshot.gravity.as_ref().map_or_else(|| session.clone(), |used| stage::with_gravity(session, used));
    let plain = snapshot.aircraft.ready_keyed().ok_or(match session.aircraft {
        Some(_) => "the aircraft could not be read",
        None => stage::NO_AIRCRAFT,
    })?;
    let aircraft = context.get::<AircraftData>(session.loading.as_ref(), plain)?;
    let windows = session.active_windows().filter_map(|manoeuvre| {
        let results = snapshot.windows.get(&manoeuvre.name)?;
        Some(StudyWindow {
            manoeuvre,
            flight: snapshot.flights.get(&manoeuvre.flight)?.ready_keyed()?.clone(),
            aircraft: context.get::<AircraftData>(session.loading_in(&manoeuvre.flight), plain).ok()?,
            path: results.path.ready_keyed()?.clone(),
            aero: results.aero.ready_keyed()?.clone(),
            fits: results.fits.ready_keyed()?.clone(),
        })
    });
    let windows: Vec<_> = windows.collect();
    let pooled = snapshot.pooled.ready_keyed();
    let pooled = pooled.ok_or("nothing is identified yet: mark at least one manoeuvre as identification")?;
    let input = StudyInput { settings: used.settings(), aircraft: &aircraft, windows: &windows, pooled };
    study(&input)
}
