//! Least squares against published answers, and the properties every estimate keeps.

mod attas_table;
mod coloured;
mod constraints;
mod equations;
mod flight_filter_error;
mod flight_output_error;
mod frequency;
mod instrumental;
mod output_error;
mod properties;
mod recursive;
mod robust;
mod selection;
mod sensor_errors;
mod variants;
