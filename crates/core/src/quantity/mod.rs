//! Physical quantities: units by name, and the roles a recorded channel can play.

mod bits;
mod named;
mod role;
mod unit;

pub use bits::HashBits;
pub(crate) use named::named_quantities;
pub use role::Role;
pub use unit::{Dimension, Unit, UnknownUnit};
