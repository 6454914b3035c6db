//! Physical quantities: units by name, and the roles a recorded channel can play.

mod role;
mod unit;

pub use role::Role;
pub use unit::{Dimension, Unit, UnknownUnit};
