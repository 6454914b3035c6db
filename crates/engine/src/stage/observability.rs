//! What a window cannot tell of the states.

use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::reconstruct::consistency::{WeakState, observability, weak_states};
use doublet_core::reconstruct::{FilterData, FilterSettings, Reconstruction, State};

/// What a window cannot tell of the states that are not known beforehand.
#[derive(Clone, Debug, Default)]
pub struct Observability {
    /// Rank of the Lie derivatives in the middle of the window (thesis 3.1.5).
    pub rank: usize,
    /// States that are not known beforehand: the rank at which all are told.
    pub open: usize,
    /// States that no measurement sees.
    pub hidden: Vec<State>,
    /// States of whose first deviation much is left.
    pub weak: Vec<WeakState>,
}

impl Observability {
    /// What is worth a finding, one line each. Nothing depends on the horizontal position.
    pub(super) fn lines(&self) -> Vec<Message> {
        let matters = |state: &&State| !matches!(state, State::PositionNorth | State::PositionEast);
        let names: Vec<_> = self.hidden.iter().filter(matters).map(|state| state.name()).collect();
        let hidden = (!names.is_empty()).then(|| {
            let (rank, open, names) = (self.rank, self.open, names.join(", "));
            message!("observability rank {} of {}: {} not observable", rank, open, names)
        });
        let weak = self.weak.iter().map(|weak| {
            message!(
                "{} is weakly observable: {:.0} % of its initial standard deviation remains, correlated with {} ({:.2})",
                weak.state.name(),
                100.0 * weak.remaining,
                weak.partner.name(),
                weak.correlation
            )
        });
        hidden.into_iter().chain(weak).collect()
    }
}

/// States the measurements of the window cannot tell, by the rank of the Lie derivatives in its middle (thesis 3.1.5), and those
/// they told little about, by what is left of the initial deviation. A state that was known at the start is neither.
pub(super) fn assess_observability(
    data: &FilterData,
    reconstruction: &Reconstruction,
    filter: &FilterSettings,
) -> Observability {
    /// Part of its initial deviation a weak state keeps.
    const WEAK: f64 = 0.5;
    let middle = reconstruction.time_s.len() / 2;
    let x = reconstruction.states.each_ref().map(|column| column[middle]);
    let input = data.inputs.columns.each_ref().map(|column| column[middle]);
    let measured = data.measurements.each_ref().map(|measurement| !measurement.time_s.is_empty());
    let found = observability(&x, &input, &measured, &filter.initial_deviation, filter.gravity_m_s2);
    let is_open = |state: &State| filter.initial_deviation[*state as usize] > 0.0;
    let open = State::ALL.iter().filter(|state| is_open(state)).count();
    let hidden: Vec<State> = found.unobservable.into_iter().filter(is_open).collect();
    // A random walk makes a state as uncertain as it is, whatever the window tells.
    let steady = |state: State| filter.random_walk[state as usize] == 0.0 && !hidden.contains(&state);
    let weak = weak_states(reconstruction, WEAK).into_iter().filter(|weak| steady(weak.state)).collect();
    Observability { rank: found.rank, open, hidden, weak }
}
