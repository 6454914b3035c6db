//! Data files beside recordings: aircraft, instruments, propulsion maps, DATCOM listings.

pub mod aircraft;
pub mod datcom;
pub mod instruments;
pub mod propulsion_maps;
