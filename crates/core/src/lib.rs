//! Headless numerics of doublet: from recordings to stability and control derivatives.
//!
//! Data flow one way, `load -> align -> prep -> compatibility -> reconstruct -> model -> replay -> estimate -> validate -> sensitivity`; a module uses
//! only modules to its left, plus [`quantity`], [`message`](mod@message), [`series`], [`statistics`], `optimise`, [`decompose`], [`airframe`], [`propulsion`], [`atmos`], [`motion`] and [`schema`]. SI units and radians
//! throughout; axes, signs and normalisations are fixed in `docs/conventions.md`.

#![warn(missing_docs)]

pub mod airframe;
pub mod align;
pub mod atmos;
pub mod compatibility;
pub mod decompose;
pub mod estimate;
pub mod load;
pub mod message;
pub mod model;
pub mod motion;
pub(crate) mod optimise;
pub mod prep;
pub mod propulsion;
pub mod quantity;
pub mod reconstruct;
pub mod replay;
pub mod schema;
pub mod sensitivity;
pub mod series;
pub mod simulate;
pub mod statistics;
pub mod toml_error;
pub mod validate;
