//! Outputs of one kind by name, computed one after another.

use std::fmt::Display;

use super::{AnySlot, Slot, SlotGroup};
use crate::graph::{Keyed, StageError, StageResult};
use crate::session::Place;

/// Outputs by what they are computed for, in an order of their own.
#[derive(Clone, Debug)]
pub struct NamedSlots<T, N = String>(pub Vec<(N, Slot<T>)>);

impl<T, N> Default for NamedSlots<T, N> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T, N> NamedSlots<T, N> {
    /// The output for `name`.
    pub fn row<M: ?Sized>(&self, name: &M) -> Option<&Slot<T>>
    where
        N: PartialEq<M>,
    {
        self.0.iter().find(|(other, _)| other == name).map(|(_, slot)| slot)
    }
}

impl<T: Clone, N: Clone + PartialEq> NamedSlots<T, N> {
    /// Makes room for outputs of these names, all to be computed; what was known of them is shown until then.
    fn begin(&mut self, names: impl Iterator<Item = N>) {
        let mut known: Vec<_> = std::mem::take(&mut self.0).into_iter().map(Some).collect();
        let row = |name: N| {
            let found = known.iter_mut().find(|one| one.as_ref().is_some_and(|(other, _)| *other == name));
            let mut slot = found.and_then(Option::take).map(|(_, slot)| slot).unwrap_or_default();
            slot.begin();
            (name, slot)
        };
        self.0 = names.map(row).collect();
    }

    /// Computes the outputs of `names` one after another by their index; `show` hears of every change.
    ///
    /// # Errors
    /// That it was stopped. An output that cannot be computed says why itself.
    pub(crate) fn fill(
        &mut self,
        names: impl Iterator<Item = N>,
        show: &(dyn Fn(&Self) + Sync),
        mut compute: impl FnMut(usize, &(dyn Fn(f32) + Sync)) -> StageResult<Keyed<T>>,
    ) -> StageResult<()>
    where
        Self: Sync,
    {
        self.begin(names);
        show(self);
        for index in 0..self.0.len() {
            let shown: &Self = self;
            let progress = |part: f32| {
                let mut now = shown.clone();
                now.0[index].1.advance(part);
                show(&now);
            };
            let found = compute(index, &progress);
            let is_stopped = matches!(found, Err(StageError::Cancelled));
            if is_stopped {
                self.0.iter_mut().for_each(|(_, slot)| slot.end(&StageError::Cancelled));
            } else {
                self.0[index].1.finish(found);
            }
            show(self);
            if is_stopped {
                return Err(StageError::Cancelled);
            }
        }
        Ok(())
    }
}

impl<T, N: Display> SlotGroup for NamedSlots<T, N> {
    fn each_mut(&mut self, what: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot)) {
        self.0.iter_mut().for_each(|(_, slot)| visit(what, slot));
    }

    fn each(&self, what: &str, visit: &mut dyn FnMut(Place, &dyn AnySlot)) {
        self.0.iter().for_each(|(name, slot)| visit(format!("{what} '{name}'").into(), slot));
    }
}
