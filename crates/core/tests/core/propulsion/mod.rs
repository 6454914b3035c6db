//! Engine chart, propeller map, powerplant, engine comparison and Digital DATCOM against published numbers.

mod comparison;
mod datcom;
mod maps;
mod support;
mod tables;
