//! A stage says what it is; its key, its place in the cache, its cancellation and its failure follow from that.

use std::hash::{Hash, Hasher};
use std::ops::Deref;
use std::sync::Arc;

use doublet_core::airframe::{AircraftError, HistoryError};
use doublet_core::align::AlignError;
use doublet_core::atmos::AtmosphereError;
use doublet_core::estimate::EstimateError;
use doublet_core::model::ModelError;
use doublet_core::prep::PrepError;
use doublet_core::quantity::UnknownUnit;
use doublet_core::reconstruct::ReconstructError;
use doublet_core::reconstruct::tuning::delay::DelayError;
use doublet_core::reconstruct::tuning::noise::NoiseProposalError;
use doublet_core::replay::ReplayError;
use doublet_core::simulate::SimulateError;
use thiserror::Error;

use super::{Cancelled, Context, Footprint, Key};

/// A step of the analysis: a pure function of parameters, of earlier outputs and of the files it reads through its context.
///
/// Run by [`Context::get`], which keeps the output under a key of all three.
pub trait Stage {
    /// What of the session it depends on, hashed field by field.
    type Params<'a>: Hash;
    /// Earlier outputs: [`Keyed`], hashed by their keys.
    type Inputs<'a>: Hash;
    /// What it gives.
    type Output: Footprint;
    /// Name, also of the place of its failures.
    const NAME: &'static str;

    /// Computes the output.
    ///
    /// # Errors
    /// [`StageError`]: one line, or that it was stopped.
    fn run(params: Self::Params<'_>, inputs: Self::Inputs<'_>, context: &Context<'_>) -> StageResult<Self::Output>;
}

/// Result of a stage or of a part of one.
pub type StageResult<T> = Result<T, StageError>;

/// Why a stage has no output.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum StageError {
    /// It was stopped.
    #[error("cancelled")]
    Cancelled,
    /// Its inputs have nothing for it to work on.
    #[error("not applicable")]
    NotApplicable,
    /// The session, a recording or a file does not allow it: what, where, what to do, in one line.
    #[error("{0}")]
    Failed(String),
    /// The data of an aircraft are impossible.
    #[error("{named}: {}", errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Aircraft { named: String, errors: Vec<AircraftError> },
    /// A clock cannot be fitted.
    #[error(transparent)]
    Align(#[from] AlignError),
    /// A signal cannot be prepared.
    #[error(transparent)]
    Prep(#[from] PrepError),
    /// A unit is not known.
    #[error(transparent)]
    Unit(#[from] UnknownUnit),
    /// The air has no such state.
    #[error(transparent)]
    Atmosphere(#[from] AtmosphereError),
    /// The recorded fuel does not fit the aircraft.
    #[error(transparent)]
    Fuel(#[from] HistoryError),
    /// The filter failed.
    #[error(transparent)]
    Filter(ReconstructError),
    /// Coefficients cannot be formed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Derivatives cannot be estimated.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// No noise can be proposed.
    #[error(transparent)]
    Noise(#[from] NoiseProposalError),
    /// No delay can be found.
    #[error(transparent)]
    Delay(#[from] DelayError),
    /// A flight cannot be simulated.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// The model cannot be flown.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

impl StageError {
    /// The same with the place in front of the line: `place: line`.
    #[must_use]
    pub fn at(self, place: impl std::fmt::Display) -> Self {
        match self {
            Self::Cancelled | Self::NotApplicable => self,
            failed => Self::Failed(format!("{place}: {failed}")),
        }
    }
}

impl From<Cancelled> for StageError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<ReconstructError> for StageError {
    fn from(error: ReconstructError) -> Self {
        if error == ReconstructError::Cancelled { Self::Cancelled } else { Self::Filter(error) }
    }
}

impl From<String> for StageError {
    fn from(line: String) -> Self {
        Self::Failed(line)
    }
}

impl From<&str> for StageError {
    fn from(line: &str) -> Self {
        Self::Failed(line.to_owned())
    }
}

impl From<StageError> for String {
    fn from(error: StageError) -> Self {
        error.to_string()
    }
}

/// An output with the key of everything it follows from.
#[derive(Debug)]
pub struct Keyed<T> {
    value: Arc<T>,
    key: Key,
}

impl<T> Keyed<T> {
    /// An output under a key of its own.
    pub fn new(value: Arc<T>, key: Key) -> Self {
        Self { value, key }
    }

    /// Identity of what it follows from.
    pub fn key(&self) -> Key {
        self.key
    }

    /// The output, shared.
    pub fn shared(&self) -> &Arc<T> {
        &self.value
    }
}

impl<T> Clone for Keyed<T> {
    fn clone(&self) -> Self {
        Self { value: Arc::clone(&self.value), key: self.key }
    }
}

impl<T> Deref for Keyed<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> Hash for Keyed<T> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.key.hash(state);
    }
}

impl<T> From<T> for Keyed<T> {
    /// A value that no stage computed, under a key that nothing else has.
    fn from(value: T) -> Self {
        Self { value: Arc::new(value), key: Key::unique() }
    }
}
