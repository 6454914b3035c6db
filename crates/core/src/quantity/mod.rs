//! Physical quantities: units by name, and the roles a recorded channel can play.

mod bits;
mod role;
mod unit;

pub use bits::HashBits;
pub use role::Role;
pub use unit::{Dimension, Unit, UnknownUnit};
