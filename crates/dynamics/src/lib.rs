//! From derivatives to how an aircraft flies: linear models about a trim, natural modes, flying-qualities levels, frequency responses and
//! low-order equivalent systems, each with its interval.
//!
//! Data flow one way, `linear -> modes -> qualities`; [`frequency`] stands beside them, [`design`] behind `modes`. SI units and radians; axes, signs and normalisations
//! are those of `docs/conventions.md`.

#![warn(missing_docs)]

pub mod design;
pub mod frequency;
pub mod linear;
pub mod modes;
pub mod propagate;
pub mod qualities;
