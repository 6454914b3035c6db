//! Raw sensors to clean signals: thesis examples, synthetic truths, the shipped flight.

mod air_data;
mod control_surfaces;
mod demo;
mod fuel;
mod held;
mod manoeuvres;
mod noise;
mod steady;
mod support;
