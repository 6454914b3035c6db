//! The airframe against the thesis's tables, against independent computations, and against impossible data.

mod check;
mod envelope;
mod files;
mod geometry;
mod history;
mod inertia;
mod mass;
mod support;
mod weighing;
