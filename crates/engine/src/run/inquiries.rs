//! What is asked of the identified model while somebody looks at it: computed in the background after the run, for what is on screen alone.

use super::experiments::{ExperimentRows, experiment_rows};
use super::overlays::{Overlays, overlay_experiments};
use super::snapshot::{AnySlot, Inquiries, Slot, Snapshot};
use super::tried_fixes::{TriedFixes, try_fixes};
use crate::graph::{Context, Keyed, Stage, StageResult};
use crate::planning::{Enough, EnoughRequest};
use crate::prior::{PriorRequest, PriorStudy};
use crate::session::{Fix, Session};
use crate::stage::{self, AircraftData, StudyWindow};
use crate::study::{DynamicsRequest, DynamicsStudy, StudyInput};

/// What a front end asks of the identified model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InquiryRequest {
    /// Trim about which it is linearised.
    pub dynamics: Option<DynamicsRequest>,
    /// Goals that what was flown is held to.
    pub enough: Option<EnoughRequest>,
    /// Earlier estimate it is held against.
    pub prior: Option<PriorRequest>,
    /// Whether the experiments of the session are compared.
    pub experiments: bool,
    /// Experiments that are drawn over the session, by name.
    pub overlaid: Vec<String>,
    /// Fixes that are tried, each alone, on the session whose results have this generation.
    pub fixes: (u64, Vec<Fix>),
}

/// Computes what is asked of the model of `snapshot`, which shows each answer as it comes.
pub(super) fn inquire(
    session: &Session,
    snapshot: &mut Snapshot,
    request: &InquiryRequest,
    context: &Context<'_>,
    publish: &(dyn Fn(Snapshot) + Sync),
) {
    let mut ask = Inquiry { session, snapshot, context, publish };
    if !request.overlaid.is_empty() || !ask.snapshot.inquiries.overlaid.0.is_empty() {
        // An experiment that was not computed says so itself.
        ask.fill(
            |inquiries| &mut inquiries.overlaid,
            |session, overlays: &mut Overlays, context, show| {
                let _ = overlay_experiments(session, &request.overlaid, overlays, context, show);
            },
        );
    }
    let (generation, fixes) = &request.fixes;
    if !fixes.is_empty() && *generation == ask.snapshot.generation {
        // A fix that cannot be tried says so itself.
        ask.fill(
            |inquiries| &mut inquiries.fixes,
            |session, tried: &mut TriedFixes, context, show| {
                let _ = try_fixes(session, fixes, tried, context, show);
            },
        );
    }
    if let Some(wanted) = request.dynamics {
        ask.answer::<DynamicsStudy>(wanted, |inquiries| &mut inquiries.dynamics);
    }
    if let Some(wanted) = &request.prior {
        ask.answer::<PriorStudy>(wanted, |inquiries| &mut inquiries.prior);
    }
    if let Some(wanted) = &request.enough {
        ask.answer::<Enough>(wanted, |inquiries| &mut inquiries.enough);
    }
    if request.experiments {
        // A row that was not computed says so itself.
        ask.fill(
            |inquiries| &mut inquiries.experiments,
            |session, rows: &mut ExperimentRows, context, show| {
                let _ = experiment_rows(session, rows, context, show);
            },
        );
    }
}

struct Inquiry<'a> {
    session: &'a Session,
    snapshot: &'a mut Snapshot,
    context: &'a Context<'a>,
    publish: &'a (dyn Fn(Snapshot) + Sync),
}

impl Inquiry<'_> {
    fn answer<S: for<'i> Stage<Inputs<'i> = &'i StudyInput<'i>>>(
        &mut self,
        params: S::Params<'_>,
        slot: fn(&mut Inquiries) -> &mut Slot<S::Output>,
    ) {
        slot(&mut self.snapshot.inquiries).begin();
        (self.publish)(self.snapshot.clone());
        let found = answer::<S>(self.session, self.snapshot, params, self.context);
        slot(&mut self.snapshot.inquiries).finish(found);
        (self.publish)(self.snapshot.clone());
    }

    /// Computes outputs one after another; every change is published.
    fn fill<T: Clone + Default + Sync>(
        &mut self,
        place: fn(&mut Inquiries) -> &mut T,
        compute: impl FnOnce(&Session, &mut T, &Context<'_>, &(dyn Fn(&T) + Sync)),
    ) {
        let mut outputs = std::mem::take(place(&mut self.snapshot.inquiries));
        let shown = &*self.snapshot;
        let show = |outputs: &T| {
            let mut snapshot = shown.clone();
            place(&mut snapshot.inquiries).clone_from(outputs);
            (self.publish)(snapshot);
        };
        compute(self.session, &mut outputs, self.context, &show);
        *place(&mut self.snapshot.inquiries) = outputs;
    }
}

/// The output of a study of everything that `snapshot` has of `session`.
///
/// # Errors
/// As [`with_study_input`], and those of the study.
pub fn answer<S: for<'i> Stage<Inputs<'i> = &'i StudyInput<'i>>>(
    session: &Session,
    snapshot: &Snapshot,
    params: S::Params<'_>,
    context: &Context<'_>,
) -> StageResult<Keyed<S::Output>> {
    with_study_input(session, snapshot, context, |input| context.get::<S>(params, input))
}

/// Hands everything that `snapshot` has of `session` to a study.
///
/// # Errors
/// One line: no aircraft, nothing identified; those of the study.
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
