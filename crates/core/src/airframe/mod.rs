//! Geometry, stations, mass, centre of gravity, inertia, envelope and weighing of an aircraft.

mod aircraft;
mod check;
mod envelope;
pub mod frames;
mod geometry;
mod history;
mod inertia;
mod loading;
mod statistics;
mod summary;
mod tensor;
pub mod weighing;

pub use aircraft::{
    Aircraft, EngineStation, FixedItem, FuelBookkeeping, MassLimits, ReferenceGeometry, SensorStations, Stall, Station,
    Tank, WheelStations,
};
pub use check::AircraftError;
pub use envelope::{Envelope, EnvelopeMargin, EnvelopeRow, EnvelopeSide};
pub use geometry::{MeanChord, WingPanel, mean_aerodynamic_chord};
pub use history::{FuelSplit, HistoryError, MassHistory};
pub use inertia::{Axis, InertiaGroup, InertiaModel, OwnInertia};
pub use loading::{Loading, LoadingIssue};
pub use statistics::{ComponentFraction, GyrationRadii};
pub use summary::{AircraftSummary, ComponentComparison, LoadedState, summary};
pub use tensor::{InertiaError, InertiaTensor, PrincipalAxes};

/// Mass, centre of gravity and inertia of an aircraft as loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct MassProperties {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of gravity in datum axes (x aft, y right, z up), m.
    pub cg_from_datum_m: [f64; 3],
    /// Inertia about the centre of gravity in body axes.
    pub inertia: InertiaTensor,
    /// What is wrong with the loading, each bound to its field.
    pub warnings: Vec<LoadingIssue>,
}
