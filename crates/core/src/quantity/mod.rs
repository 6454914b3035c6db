//! Physical quantities: units by name, and the roles a recorded channel can play.

mod bits;
mod instrument_error;
mod named;
mod role;
mod unit;

pub use bits::HashBits;
pub use instrument_error::InstrumentError;
pub(crate) use named::{deserialize_name, named_quantities};
pub use role::Role;
pub use unit::{Dimension, Unit, UnknownUnit};

/// A number for a message: as it is, with an exponent where it has many digits before or behind the point.
pub fn in_words(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() || (1e-6..1e15).contains(&size) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
