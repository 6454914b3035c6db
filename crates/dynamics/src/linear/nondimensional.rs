//! Dimensional derivatives from derivatives without dimension in stability axes: the forms of Etkin and Reid (1996), table 4.4, and of
//! NASA CR-2144, appendix A.

use nalgebra::{Matrix2, Vector2};

use super::dimensional::{LateralDerivatives, LongitudinalDerivatives};

/// Air, size and inertia that give derivatives their dimension, in consistent units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Air density, kg/m³.
    pub density: f64,
    /// Airspeed, m/s.
    pub airspeed: f64,
    /// Mach number.
    pub mach: f64,
    /// Angle of attack of body x, rad.
    pub alpha_rad: f64,
    /// Reference area, m².
    pub area: f64,
    /// Chord, m.
    pub chord: f64,
    /// Span, m.
    pub span: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Moments and product of inertia in body axes, `Ix Iy Iz Ixz` with `Ixz` the integral of `x z`, kg m².
    pub inertia: [f64; 4],
}

impl Scales {
    /// Dynamic pressure times area, N.
    fn force(&self) -> f64 {
        0.5 * self.density * self.airspeed * self.airspeed * self.area
    }
}

/// Longitudinal derivatives along stability axes x forward and z down (Etkin and Reid, table 6.1): by `u / u0`, `alpha`, and `q` and
/// `alpha'` times `c / 2 u0`; level flight with `theta0 = 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilityLongitudinal {
    /// Lift coefficient of the trim.
    pub lift: f64,
    /// Of the force along x.
    pub x: [f64; 4],
    /// Of the force along z.
    pub z: [f64; 4],
    /// Of the pitching moment.
    pub m: [f64; 4],
}

impl StabilityLongitudinal {
    /// With dimension, in the same axes; controls are left at zero.
    pub fn dimensional(&self, scales: &Scales) -> LongitudinalDerivatives {
        let Scales { density, airspeed, area, chord, mass, .. } = *scales;
        let (force, moment) = (density * airspeed * area / mass, density * airspeed * area * chord / scales.inertia[1]);
        let [x_u, x_alpha, ..] = self.x;
        let [z_u, z_alpha, z_q, z_rate] = self.z;
        let [m_u, m_alpha, m_q, m_rate] = self.m;
        LongitudinalDerivatives {
            x_u: 0.5 * force * x_u,
            x_w: 0.5 * force * x_alpha,
            z_u: force * (0.5 * z_u - self.lift),
            z_w: 0.5 * force * z_alpha,
            z_w_dot: 0.25 * force * chord / airspeed * z_rate,
            z_q: 0.25 * force * chord * z_q,
            m_u: 0.5 * moment * m_u,
            m_w: 0.5 * moment * m_alpha,
            m_w_dot: 0.25 * moment * chord / airspeed * m_rate,
            m_q: 0.25 * moment * chord * m_q,
            elevator: [0.0; 3],
        }
    }
}

/// Longitudinal derivatives of lift, drag and pitching moment (NASA CR-2144, tables IX-1 and IX-2): by angle of attack, Mach number, and
/// pitch rate and rate of the angle of attack times `c / 2V`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LiftAndDrag {
    /// Lift coefficient, by angle of attack, its rate, pitch rate, Mach number and elevator.
    pub lift: [f64; 6],
    /// Drag coefficient and by angle of attack.
    pub drag: [f64; 2],
    /// Pitching moment of the aerodynamic forces (minus that of the thrust in trim), by angle of attack, its rate, pitch rate, Mach
    /// number and elevator.
    pub moment: [f64; 6],
}

impl LiftAndDrag {
    /// With dimension, in body axes at [`Scales::alpha_rad`].
    pub fn dimensional(&self, scales: &Scales) -> LongitudinalDerivatives {
        let Scales { density, airspeed, mach, area, chord, mass, inertia: [_, inertia, ..], .. } = *scales;
        let (sin, cos) = scales.alpha_rad.sin_cos();
        let (slope, half_mach) = (sin / cos, 0.5 * mach);
        let [lift, lift_alpha, lift_rate, lift_q, lift_mach, lift_e] = self.lift;
        let [drag, drag_alpha] = self.drag;
        let [moment, moment_alpha, moment_rate, moment_q, moment_mach, moment_e] = self.moment;
        // Normal force up and axial force aft.
        let (normal, axial) = (lift * cos + drag * sin, drag * cos - lift * sin);
        let (normal_mach, axial_mach) = (lift_mach * cos, -lift_mach * sin);
        let normal_alpha = lift_alpha * cos - lift * sin + drag_alpha * sin + drag * cos;
        let axial_alpha = drag_alpha * cos - drag * sin - lift_alpha * sin - lift * cos;
        let along = density * area * airspeed * cos / mass;
        let turning = density * area * chord * airspeed * cos / inertia;
        let by_u = |value: f64, by_mach: f64, by_alpha: f64| value + half_mach * by_mach - 0.5 * slope * by_alpha;
        let by_w = |value: f64, by_mach: f64, by_alpha: f64| 0.5 * by_alpha + slope * (value + half_mach * by_mach);
        let force = scales.force();
        LongitudinalDerivatives {
            x_u: -along * by_u(axial, axial_mach, axial_alpha),
            x_w: -along * by_w(axial, axial_mach, axial_alpha),
            z_u: -along * by_u(normal, normal_mach, normal_alpha),
            z_w: -along * by_w(normal, normal_mach, normal_alpha),
            z_w_dot: -density * area * chord / (4.0 * mass) * lift_rate * cos * cos,
            z_q: -density * area * chord * airspeed / (4.0 * mass) * lift_q * cos,
            m_u: turning * by_u(moment, moment_mach, moment_alpha),
            m_w: turning * by_w(moment, moment_mach, moment_alpha),
            m_w_dot: density * area * chord * chord / (4.0 * inertia) * cos * moment_rate,
            m_q: density * area * chord * chord * airspeed / (4.0 * inertia) * moment_q,
            elevator: [force / mass * lift_e * sin, -force / mass * lift_e * cos, force * chord / inertia * moment_e],
        }
    }
}

/// Lateral derivatives in stability axes: by `beta`, `p b / 2V`, `r b / 2V`, aileron and rudder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StabilityLateral {
    /// Of the side force.
    pub y: [f64; 5],
    /// Of the rolling moment.
    pub l: [f64; 5],
    /// Of the yawing moment.
    pub n: [f64; 5],
}

impl StabilityLateral {
    /// With dimension, moments and rates turned by [`Scales::alpha_rad`] into body axes and primed there; the side force by rates is
    /// left out, as [`LateralDerivatives`] has none. `None` for an inertia that is not positive.
    pub fn dimensional(&self, scales: &Scales) -> Option<LateralDerivatives> {
        let Scales { airspeed, span, mass, inertia: [i_x, _, i_z, i_xz], .. } = *scales;
        let (sin, cos) = scales.alpha_rad.sin_cos();
        let body_from_stability = Matrix2::new(cos, -sin, sin, cos);
        let inverse = Matrix2::new(i_x, -i_xz, -i_xz, i_z).cholesky()?.inverse();
        let (force, half) = (scales.force(), span / (2.0 * airspeed));
        let moments = |index: usize| -> Vector2<f64> {
            inverse * body_from_stability * Vector2::new(self.l[index], self.n[index]) * (force * span)
        };
        // Rates in stability axes from those in body axes.
        let (by_roll, by_yaw) = (moments(1) * half, moments(2) * half);
        let by_rates = Matrix2::from_columns(&[by_roll, by_yaw]) * body_from_stability.transpose();
        let (beta, aileron, rudder) = (moments(0), moments(3), moments(4));
        let side = |index: usize| force * self.y[index] / (mass * airspeed);
        Some(LateralDerivatives {
            y_v: side(0),
            l: [beta.x, by_rates[(0, 0)], by_rates[(0, 1)]],
            n: [beta.y, by_rates[(1, 0)], by_rates[(1, 1)]],
            aileron: [side(3), aileron.x, aileron.y],
            rudder: [side(4), rudder.x, rudder.y],
        })
    }
}
