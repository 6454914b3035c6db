//! International Standard Atmosphere and gravity.

mod airspeed;
mod gravity;
mod isa;

pub use airspeed::{
    calibrated_of_impact_m_s, mach_of_calibrated, mach_of_equivalent, static_at_airspeed_k,
    static_of_total_temperature_k, true_of_calibrated_m_s, true_of_mach_m_s,
};
pub use gravity::{GravityError, STANDARD_GRAVITY_M_S2, gravity_m_s2};
pub use isa::{Atmosphere, AtmosphereError, density_kg_m3};
pub(crate) use isa::{GAS_CONSTANT_AIR_J_KG_K, HEAT_CAPACITY_RATIO_AIR};
