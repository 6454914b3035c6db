//! Sensitivity of derivatives to what they were computed with (thesis 7.2.1).

mod noise;
mod quantity;
mod table;

pub use noise::{NoiseEffect, noise_effects, with_noise};
pub use quantity::{Quantity, QuantityGroup, Step, quantities};
pub use table::{Estimate, Partial, SensitivityTable, TornadoBar, central, tornado};
