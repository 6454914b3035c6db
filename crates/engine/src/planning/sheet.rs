//! A design of a session as it is edited, with its card and its files.

use std::path::Path;

use doublet_core::airframe::Aircraft;
use doublet_dynamics::design::{Criterion, DesignKind, Designed, Request};

use super::basis::{DesignOptions, SEARCH_SAMPLES, basis_of};
use super::document::{comparison_table, design_document};
use super::files::design_files;
use super::path_share::PathShare;
use super::rows::{DesignRow, designed_rows};
use crate::graph::{Context, Control, StageResult};
use crate::report::document::{Block, Document, Style};
use crate::session::{Level, Session};
use crate::snapshot::{Snapshot, with_study_input};

/// Full travel of a surface to either side where nothing else is said, rad.
const FULL_TRAVEL_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;

/// What is asked of a design in the window.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetRequest {
    /// Surfaces to move: 0 aileron, 1 elevator, 2 rudder.
    pub surfaces: Vec<usize>,
    /// Time of all windows together, s.
    pub time_s: f64,
    pub kind: DesignKind,
    /// What is made small.
    pub criterion: Criterion,
    /// Rounds of the search.
    pub rounds: usize,
    /// Whether every other kind is designed beside it.
    pub compare: bool,
}

impl Default for SheetRequest {
    /// A minute of multisines on all surfaces, as published.
    fn default() -> Self {
        Self {
            surfaces: vec![0, 1, 2],
            time_s: 60.0,
            kind: DesignKind::Multisine,
            criterion: Criterion::A,
            rounds: 0,
            compare: true,
        }
    }
}

impl SheetRequest {
    fn request(&self) -> Request {
        /// Draws that say how far the aircraft goes.
        const SAMPLES: usize = 40;
        Request {
            criterion: self.criterion,
            rounds: self.rounds,
            search_samples: SEARCH_SAMPLES,
            samples: SAMPLES,
            ..Request::published(self.surfaces.clone(), self.kind, self.time_s)
        }
    }
}

/// A design with its card.
#[derive(Clone, Debug)]
pub struct DesignSheet {
    /// What it promises.
    pub row: DesignRow,
    pub designed: Designed,
    pub card: Document,
    session: Session,
    aircraft: Aircraft,
}

/// Designs an input from what `snapshot` has of `session`, limits and noise as flown.
pub fn design_sheet(
    session: &Session,
    snapshot: &Snapshot,
    folder: &Path,
    request: &SheetRequest,
    control: &Control,
) -> StageResult<DesignSheet> {
    let context = Context::new(folder).with_control(control, &|_| ());
    with_study_input(session, snapshot, &context, |input| {
        let basis = basis_of(input, &DesignOptions::default(), &context)?;
        context.checkpoint()?;
        let (mut row, designed) = designed_rows(&basis, &request.request(), request.compare, &|| context.checkpoint())?;
        PathShare::measure((session, snapshot), &designed, false, control).iter().for_each(|share| row.add_path(share));
        let card = design_document(session, &row, &designed, &Style::default());
        let aircraft = input.aircraft.loaded.aircraft.clone();
        Ok(DesignSheet { row, designed, card, session: session.clone(), aircraft })
    })
}

impl DesignSheet {
    /// The card on screen, kinds side by side before it.
    pub fn blocks(&self) -> Vec<Block> {
        let compared = (!self.row.comparison.is_empty()).then(|| Block::Table(comparison_table(&self.row)));
        let best = self.row.comparison.iter().filter_map(|own| Some((own, own.costs.get(self.row.criterion)?)));
        let best = best.min_by(|a, b| a.1.total_cmp(b.1)).filter(|(own, _)| own.kind != self.row.kind);
        let better = best.map(|(own, _)| {
            let text = format!(
                "{} gives smaller errors in the same time (cost {} below that of the {})",
                own.kind, self.row.criterion, self.row.kind
            );
            Block::Outcome(Level::Caution, text)
        });
        let sections = self.card.sections.iter().filter(|section| section.name != "notes");
        let card = sections.flat_map(|section| {
            std::iter::once(Block::Heading(section.title.clone())).chain(section.blocks.iter().cloned())
        });
        compared.into_iter().chain(better).chain(self.card.cover.iter().cloned()).chain(card).collect()
    }

    /// Files that go with the card.
    pub fn files(&self) -> Result<Vec<(String, Vec<u8>)>, String> {
        design_files(&self.session, Some(&self.aircraft), &self.row, &self.designed, [FULL_TRAVEL_RAD; 3])
    }
}
