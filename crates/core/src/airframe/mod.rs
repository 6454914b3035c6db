//! Geometry, stations, mass, centre of gravity, inertia, envelope and weighing of an aircraft.
