//! The aircraft: geometry, loading, inertia, propulsion.

pub(super) mod aircraft_editor;
pub(super) mod aircraft_numbers;
pub(super) mod airframe;
pub(super) mod loading;
pub(super) mod propeller;
pub(super) mod propulsion;
pub(super) mod weighing;
