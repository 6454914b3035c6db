//! The proof of match of a run: every validation window flown again.

use std::sync::Arc;

use rayon::prelude::*;

use super::board::Board;
use super::control::Cancelled;
use crate::graph::{Cache, Key, KeyBuilder};
use crate::session::WindowRole;
use crate::stage::{ProofOfMatch, ReplayWindow, Tolerances, WindowReplay, model_of_window, replay};
use crate::study::{StudyWindow, Subject};

/// Flies the validation windows with the pooled model, or finds them in the cache, and shows them. `key` is that of the pooled
/// estimate: everything the windows were made from.
pub fn prove(subject: &Subject<'_>, key: Key, cache: &Cache, board: &Board<'_>) -> Result<(), Cancelled> {
    let gravity_m_s2 = subject.session.filter.gravity_m_s2;
    let key = KeyBuilder::new("match", 1).key(key).parameters(&gravity_m_s2).finish();
    let result = cache.get_or_try(key, || fly(subject));
    board.update(|snapshot| snapshot.proof.finish(result))
}

fn fly(subject: &Subject<'_>) -> Result<ProofOfMatch, String> {
    let tolerances = Tolerances::builtin()?;
    let session = subject.session;
    let one = |window: &StudyWindow<'_>| -> Result<Arc<WindowReplay>, String> {
        let window = ReplayWindow { manoeuvre: window.manoeuvre, path: &window.path, aero: &window.aero };
        let model = model_of_window(subject.pooled, &session.structure, &window)?;
        replay(&window, &model, &session.preparation, session.filter.gravity_m_s2, &tolerances).map(Arc::new)
    };
    let named = |window: &StudyWindow<'_>| (window.manoeuvre.name.clone(), one(window));
    let validation = subject.windows.par_iter().filter(|window| window.manoeuvre.role == WindowRole::Validation);
    Ok(ProofOfMatch { windows: validation.map(named).collect(), tolerances: tolerances.name })
}
