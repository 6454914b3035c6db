//! What is asked of the identified model while somebody looks at it: computed in the background after the run, for what is on screen alone.

use super::overlays::overlay_experiments;
use super::tried_fixes::try_fixes;
use crate::graph::{Context, Stage};
use crate::planning::EnoughRequest;
use crate::prior::{PriorRequest, PriorStudy};
use crate::session::{Fix, Session};
use crate::snapshot::{AnySlot, Enough, Inquiries, Overlays, Slot, Snapshot, TriedFixes, answer};
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
    /// Whether the experiments of the session are compared: computed beside all else that is asked.
    pub experiments: bool,
    /// Experiments that are drawn over the session, by name.
    pub overlaid: Vec<String>,
    /// Fixes that are tried, each alone, on the session whose results have this generation.
    pub fixes: (u64, Vec<Fix>),
}

/// Computes what is asked of the model of `snapshot` apart from its experiments; `snapshot` shows each answer as it comes.
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
