//! Geometry, stations, mass, centre of gravity, inertia, envelope and weighing of an aircraft.

mod aircraft;
mod check;
mod envelope;
mod flight_envelope;
pub mod frames;
mod geometry;
mod history;
mod inertia;
pub mod instruments;
mod loading;
mod mass;
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
pub use flight_envelope::{FlightEnvelope, FlightMargin, SEA_LEVEL_KG_M3, calibrated_m_s};
pub use geometry::{MeanChord, WingPanel, mean_aerodynamic_chord};
pub use history::{FuelSplit, HistoryError, MassHistory};
pub use inertia::{Axis, InertiaGroup, InertiaModel, OwnInertia};
pub use loading::{Loading, LoadingIssue};
pub use mass::MassProperties;
pub use statistics::{AircraftClass, ComponentFraction, GyrationRadii};
pub use summary::{AircraftSummary, ComponentComparison, LoadedState, summary};
pub use tensor::{InertiaError, InertiaTensor, PrincipalAxes};
