//! Slots: the state of one output, and what a run does to many of them together.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::graph::{Keyed, Stage, StageError};
use crate::session::Place;
use crate::stage::LoadedFlight;

/// State of one stage's output. What was there before stays visible until it is replaced.
#[derive(Clone, Debug, Default)]
pub enum Slot<T> {
    /// Nothing asked for it yet.
    #[default]
    NotRequested,
    /// Being computed.
    Running {
        /// Part done, 0 to 1.
        progress: f32,
        /// The output before.
        last: Option<Keyed<T>>,
    },
    /// Up to date.
    Ready(Keyed<T>),
    /// Could not be computed.
    Failed {
        /// One line: what, where, what to do.
        error: String,
        /// The output before.
        last: Option<Keyed<T>>,
    },
    /// Its run was stopped, or what it follows from has changed since and nothing asked for it again.
    Cancelled {
        /// The output before.
        last: Option<Keyed<T>>,
    },
}

impl<T> Slot<T> {
    /// The newest output there is, up to date or not.
    pub fn latest(&self) -> Option<&Arc<T>> {
        self.keyed().map(Keyed::shared)
    }

    /// The same with its key.
    pub fn keyed(&self) -> Option<&Keyed<T>> {
        match self {
            Self::NotRequested => None,
            Self::Ready(value) => Some(value),
            Self::Running { last, .. } | Self::Failed { last, .. } | Self::Cancelled { last } => last.as_ref(),
        }
    }

    /// The output, if it is up to date.
    pub fn ready(&self) -> Option<&Arc<T>> {
        if let Self::Ready(value) = self { Some(value.shared()) } else { None }
    }

    /// The same with its key.
    pub(crate) fn ready_keyed(&self) -> Option<&Keyed<T>> {
        if let Self::Ready(value) = self { Some(value) } else { None }
    }

    /// Why there is no up-to-date output.
    pub fn error(&self) -> Option<&str> {
        if let Self::Failed { error, .. } = self { Some(error) } else { None }
    }

    /// Whether the newest output is out of date.
    pub fn is_stale(&self) -> bool {
        !matches!(self, Self::Ready(_) | Self::NotRequested)
    }

    /// Notes the part done of a running stage.
    pub(crate) fn advance(&mut self, part: f32) {
        if let Self::Running { progress, .. } = self {
            *progress = part;
        }
    }

    /// Takes the result of the stage.
    pub(crate) fn finish(&mut self, result: Result<Keyed<T>, StageError>) {
        match result {
            Ok(value) => *self = Self::Ready(value),
            Err(error) => self.fail(&error),
        }
    }
}

impl<T> From<T> for Slot<T> {
    fn from(value: T) -> Self {
        Self::Ready(value.into())
    }
}

/// What a run does to a slot, whatever it holds.
pub(crate) trait AnySlot {
    /// Marks it as being computed, keeping what it held.
    fn begin(&mut self);
    /// Notes that the run ended without an output, for this reason.
    fn end(&mut self, reason: &StageError);
    /// Marks it as out of date without anything computing it.
    fn expire(&mut self);
    /// Notes that its stage failed, was stopped or does not apply.
    fn fail(&mut self, error: &StageError);
    /// Why there is no up-to-date output.
    fn failure(&self) -> Option<&str>;
}

impl<T> AnySlot for Slot<T> {
    fn begin(&mut self) {
        *self = Self::Running { progress: 0.0, last: self.keyed().cloned() };
    }

    fn end(&mut self, reason: &StageError) {
        if matches!(self, Self::Running { .. }) {
            self.fail(reason);
        }
    }

    fn expire(&mut self) {
        if !matches!(self, Self::NotRequested) {
            *self = Self::Cancelled { last: self.keyed().cloned() };
        }
    }

    fn fail(&mut self, error: &StageError) {
        match error {
            StageError::NotApplicable => *self = Self::NotRequested,
            StageError::Cancelled => self.expire(),
            error => *self = Self::Failed { error: error.to_string(), last: self.keyed().cloned() },
        }
    }

    fn failure(&self) -> Option<&str> {
        self.error()
    }
}

/// Slots that are made, begun, cancelled and failed together.
pub(crate) trait SlotGroup {
    /// Makes room for the flights and windows of a session and forgets all others.
    fn follow(&mut self, _flights: &[&str], _windows: &[&str]) {}
    /// Every slot with what it is.
    fn each_mut(&mut self, what: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot));
    /// Every slot with its place, such as `engines of flight 'a'`: what, then the name of the flight or window.
    fn each(&self, what: &str, visit: &mut dyn FnMut(Place, &dyn AnySlot));
}

impl<T> SlotGroup for Slot<T> {
    fn each_mut(&mut self, what: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot)) {
        visit(what, self);
    }

    fn each(&self, what: &str, visit: &mut dyn FnMut(Place, &dyn AnySlot)) {
        visit(what.into(), self);
    }
}

/// By flight.
impl<T> SlotGroup for BTreeMap<String, Slot<T>> {
    fn follow(&mut self, flights: &[&str], _: &[&str]) {
        follow(self, flights);
    }

    fn each_mut(&mut self, what: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot)) {
        self.values_mut().for_each(|slot| visit(what, slot));
    }

    fn each(&self, what: &str, visit: &mut dyn FnMut(Place, &dyn AnySlot)) {
        self.iter().for_each(|(name, slot)| visit(place_of(what, name), slot));
    }
}

/// Place of what a flight or manoeuvre has.
fn place_of(what: &str, name: &str) -> Place {
    match what {
        LoadedFlight::NAME => Place::flight(name),
        _ => format!("{what} '{name}'").into(),
    }
}

pub(super) fn follow<T: Default>(slots: &mut BTreeMap<String, T>, names: &[&str]) {
    slots.retain(|name, _| names.contains(&name.as_str()));
    names.iter().for_each(|name| {
        slots.entry((*name).to_owned()).or_default();
    });
}

/// Declares slots once: the fields of a struct, and with them everything a run does to all of its slots. With the name of its stage
/// behind it a failure of a slot is told as one of the run, at that place.
macro_rules! slots {
    (@place) => { "" };
    (@place $place:expr) => { $place };
    (
        $(#[$about:meta])* pub struct $name:ident {
            $($(#[$plain_doc:meta])* pub $plain:ident: $plain_type:ty,)*
        }
        slots { $($(#[$doc:meta])* $slot:ident: $type:ty $(=> $place:expr)?,)* }
    ) => {
        $(#[$about])*
        #[derive(Clone, Debug, Default)]
        pub struct $name {
            $($(#[$plain_doc])* pub $plain: $plain_type,)*
            $($(#[$doc])* pub $slot: $type,)*
        }

        impl SlotGroup for $name {
            fn follow(&mut self, flights: &[&str], windows: &[&str]) {
                $(self.$slot.follow(flights, windows);)*
            }

            fn each_mut(&mut self, _: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot)) {
                $(self.$slot.each_mut(slots!(@place $($place)?), visit);)*
            }

            #[allow(unused_variables, reason = "a group may have no slot whose failures are those of the run")]
            fn each(&self, what: &str, visit: &mut dyn FnMut(Place, &dyn AnySlot)) {
                $($(self.$slot.each(&format!("{what}{}", $place), visit);)?)*
            }
        }
    };
}

pub(super) use slots;
