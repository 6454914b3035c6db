//! Units that channels state, beside their name or at the end of it.

use super::contents::ChannelInfo;
use crate::quantity::{Dimension, Unit};

/// Ends of names that tell a unit, in small letters, longest first.
const UNIT_ENDINGS: &[(&str, &str)] = &[
    ("_rad_s2", "rad/s^2"),
    ("_deg_s2", "deg/s^2"),
    ("_rad_s", "rad/s"),
    ("_deg_s", "deg/s"),
    ("_radps", "rad/s"),
    ("_degps", "deg/s"),
    ("_dps", "deg/s"),
    ("_m_s2", "m/s^2"),
    ("_mps2", "m/s^2"),
    ("_ft_s2", "ft/s^2"),
    ("_m_s", "m/s"),
    ("_mps", "m/s"),
    ("_ft_s", "ft/s"),
    ("_fps", "ft/s"),
    ("_fpm", "ft/min"),
    ("_degc", "degC"),
    ("_inhg", "inHg"),
    ("_mbar", "mbar"),
    ("_hpa", "hPa"),
    ("_kpa", "kPa"),
    ("_rad", "rad"),
    ("_deg", "deg"),
    ("_kts", "kt"),
    ("_kt", "kt"),
    ("_pa", "Pa"),
    ("_psi", "psi"),
    ("_rpm", "rpm"),
    ("_ft", "ft"),
    ("_kg", "kg"),
    ("_lb", "lb"),
    ("_k", "K"),
    ("_g", "g"),
    ("_m", "m"),
    ("_n", "N"),
    ("_w", "W"),
];

/// Ends of names that look like a unit and are a direction or an angle.
const NO_UNITS: &[&str] = &["v_n", "vel_n", "velocity_n", "pos_n", "position_n", "angle_psi", "heading_psi", "yaw_psi"];

/// A name without the unit it ends on, and that unit: `alpha` and degrees of `alpha_deg` or `alpha-deg`.
pub fn stem_and_unit(name: &str) -> (&str, Option<Unit>) {
    let lower = name.to_ascii_lowercase().replace('-', "_");
    let is_unit = !NO_UNITS.iter().any(|name| lower.ends_with(name));
    let known = |(ending, _): &&(&str, &str)| lower.len() > ending.len() && lower.ends_with(ending);
    let ending = UNIT_ENDINGS.iter().find(known).filter(|_| is_unit);
    ending.map_or((name, None), |(ending, unit)| (&name[..name.len() - ending.len()], Unit::parse(unit).ok()))
}

/// Unit of a channel as recorded, or else as its name ends; `None` where neither tells one that is known.
pub fn stated_unit(channel: &ChannelInfo) -> Option<Unit> {
    let recorded = channel.unit.as_deref().filter(|unit| !unit.is_empty());
    recorded.and_then(|unit| Unit::parse(unit).ok()).or_else(|| stem_and_unit(&channel.name).1)
}

/// Whether a recorded unit says no more than that there is none.
pub(super) fn is_count(unit: Unit) -> bool {
    unit.dimension == Dimension::Dimensionless && unit.scale == 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_at_the_end_of_a_name_is_no_unit() {
        for name in ["v_n", "gps_vel_n", "pos_N", "heading_psi"] {
            assert_eq!(stem_and_unit(name), (name, None));
        }
        let (stem, unit) = stem_and_unit("thrust_n");
        assert_eq!((stem, unit.map(|unit| unit.dimension)), ("thrust", Some(Dimension::Force)));
    }
}
