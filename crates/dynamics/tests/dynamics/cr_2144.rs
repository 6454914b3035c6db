//! Conditions of the Boeing 747 of NASA CR-2144, in SI units.

use doublet_dynamics::linear::{LateralDerivatives, LongitudinalDerivatives, SymmetricTrim};
use toml::Value;

pub const FOOT: f64 = 0.3048;
pub const GRAVITY: f64 = 32.174 * FOOT;

pub fn number(table: &Value, key: &str) -> f64 {
    let value = table.get(key).unwrap_or_else(|| panic!("{key}"));
    value.as_float().or_else(|| value.as_integer().map(|value| value as f64)).unwrap()
}

/// Trim of a condition in level flight.
pub fn level_trim(condition: &Value) -> SymmetricTrim {
    let alpha_rad = number(condition, "alpha_deg").to_radians();
    let airspeed_m_s = number(condition, "V_ft_s") * FOOT;
    SymmetricTrim { airspeed_m_s, alpha_rad, theta_rad: alpha_rad, gravity_m_s2: GRAVITY }
}

pub fn longitudinal(condition: &Value) -> LongitudinalDerivatives {
    let of = |key: &str| number(&condition["longitudinal"], key);
    LongitudinalDerivatives {
        x_u: of("Xu"),
        x_w: of("Xw"),
        z_u: of("Zu"),
        z_w: of("Zw"),
        z_w_dot: of("Zwdot"),
        z_q: of("Zq") * FOOT,
        m_u: of("Mu") / FOOT,
        m_w: of("Mw") / FOOT,
        m_w_dot: of("Mwdot") / FOOT,
        m_q: of("Mq"),
        elevator: [of("Xde") * FOOT, of("Zde") * FOOT, of("Mde")],
    }
}

pub fn lateral(condition: &Value) -> LateralDerivatives {
    let by = |key: &str| number(&condition["lateral_primed"], key);
    LateralDerivatives {
        y_v: by("Yv"),
        l: [by("Lb"), by("Lp"), by("Lr")],
        n: [by("Nb"), by("Np"), by("Nr")],
        aileron: [0.0, by("Lda"), by("Nda")],
        rudder: [by("Ydr_star"), by("Ldr"), by("Ndr")],
    }
}
