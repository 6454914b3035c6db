//! An aircraft that is edited: what a session changes of the file it names, the numbers there are to change, the file they become;
//! its drawing and what is known of its motion at an instant.

mod fields;
mod file;
mod instant;
mod shape;

pub use crate::session::{AircraftChanges, ChangedValue};
pub use fields::{AircraftField, FieldUnit, PlaceKind, Section, fields};
pub use file::save;
pub use instant::{Instant, Motion, instant};
pub use shape::{ShapeOutline, ShapePart, ned_from_body, shape};
