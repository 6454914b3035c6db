//! Studies of a run: each on request, kept while what it follows from stays the same.

use super::board::Board;
use super::control::Cancelled;
use super::snapshot::{Slot, Studies};
use crate::graph::{Cache, Footprint, Key, KeyBuilder};
use crate::study::{self, MonteCarloStudy, Study, StudyError, Subject, Watch};

/// Marks the studies that were asked for as running and the others as out of date.
pub fn begin(studies: &mut Studies, wanted: &[Study]) {
    start(&mut studies.manoeuvres, wanted.contains(&Study::Manoeuvres));
    start(&mut studies.sensitivity, wanted.contains(&Study::Sensitivity));
    start(&mut studies.checks, wanted.iter().any(is_checks));
    start(&mut studies.lags, wanted.contains(&Study::Lags));
    start(&mut studies.monte_carlo, wanted.iter().any(is_monte_carlo));
}

fn start<T>(slot: &mut Slot<T>, is_wanted: bool) {
    if is_wanted { slot.begin() } else { slot.expire() }
}

fn is_monte_carlo(study: &Study) -> bool {
    matches!(study, Study::MonteCarlo { .. })
}

fn is_checks(study: &Study) -> bool {
    matches!(study, Study::Checks { .. })
}

/// The Monte Carlo study that is shown.
fn known(studies: &Studies) -> Option<Study> {
    let MonteCarloStudy { realisations, seed, .. } = **studies.monte_carlo.latest()?;
    Some(Study::MonteCarlo { realisations, seed })
}

/// Marks the studies that were running as stopped.
pub fn cancel(studies: &mut Studies) {
    studies.manoeuvres.cancel();
    studies.sensitivity.cancel();
    studies.checks.cancel();
    studies.lags.cancel();
    studies.monte_carlo.cancel();
}

/// What the studies of a run share.
pub struct Runner<'a> {
    /// What they look at.
    pub subject: Subject<'a>,
    /// Key of the pooled estimate: everything the studies follow from.
    pub key: Key,
    /// Studies that were asked for; of the others those still known are shown.
    pub wanted: &'a [Study],
    /// Results kept.
    pub cache: &'a Cache,
    /// Where results are shown.
    pub board: &'a Board<'a>,
}

impl Runner<'_> {
    /// Computes what was asked for.
    pub fn run(&self) -> Result<(), Cancelled> {
        self.one(Study::Manoeuvres, |studies| &mut studies.manoeuvres, study::manoeuvres)?;
        self.one(Study::Sensitivity, |studies| &mut studies.sensitivity, study::sensitivity)?;
        self.checks()?;
        self.one(Study::Lags, |studies| &mut studies.lags, study::lags)?;
        let wanted = self.wanted.iter().copied().find(is_monte_carlo);
        let Some(study) = wanted.or_else(|| self.board.read(|snapshot| known(&snapshot.studies))) else {
            return Ok(());
        };
        let Study::MonteCarlo { realisations, seed } = study else { return Ok(()) };
        let compute = |subject: &Subject<'_>, watch: &Watch<'_>| study::monte_carlo(subject, realisations, seed, watch);
        self.one(study, |studies| &mut studies.monte_carlo, compute)
    }

    /// The checks asked for, or those shown.
    fn checks(&self) -> Result<(), Cancelled> {
        let shown = || self.board.read(|snapshot| Some(snapshot.studies.checks.latest()?.axis));
        let wanted = self.wanted.iter().find_map(|study| match study {
            Study::Checks { axis } => Some(*axis),
            _ => None,
        });
        let Some(axis) = wanted.or_else(shown) else { return Ok(()) };
        let compute = |subject: &Subject<'_>, watch: &Watch<'_>| study::checks(subject, axis, watch);
        self.one(Study::Checks { axis }, |studies| &mut studies.checks, compute)
    }

    fn one<T: Footprint>(
        &self,
        study: Study,
        slot: fn(&mut Studies) -> &mut Slot<T>,
        compute: impl Fn(&Subject<'_>, &Watch<'_>) -> Result<T, StudyError>,
    ) -> Result<(), Cancelled> {
        let Self { board, cache, .. } = self;
        let key = KeyBuilder::new("study", 1).key(self.key).parameters(&study).finish();
        let is_wanted = self.wanted.contains(&study);
        let result = match cache.get::<T>(key) {
            Some(known) => Ok(known),
            None if !is_wanted => return Ok(()),
            None => {
                let progress = |part| {
                    // A run that was stopped shows no more progress; the study finds out by itself.
                    let _ = board.update(|snapshot| slot(&mut snapshot.studies).advance(part));
                };
                match compute(&self.subject, &Watch::new(board.control, &progress)) {
                    Ok(value) => Ok(cache.insert(key, value)),
                    Err(StudyError::Failed(error)) => Err(error),
                    Err(StudyError::Cancelled) => return Err(Cancelled),
                }
            }
        };
        let show = |snapshot: &mut super::Snapshot| slot(&mut snapshot.studies).finish(result);
        if is_wanted { board.step(show) } else { board.update(show) }
    }
}
