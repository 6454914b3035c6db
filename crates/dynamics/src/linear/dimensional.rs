//! Linear models from dimensional derivatives in body axes, the form of NASA CR-2144 (Heffley and Jewell 1972), appendix A.

use nalgebra::{DMatrix, Matrix4, Vector4};

use super::StateSpace;

/// Longitudinal dimensional derivatives in body axes about level or climbing flight with the wings level: forces per mass, moments
/// per moment of inertia, in any consistent units (SI gives the units [`StateSpace`] states).
///
/// `u' = Xu u + Xw w - W0 q - g cos(theta0) theta + Xd d`,
/// `(1 - Zwdot) w' = Zu u + Zw w + (U0 + Zq) q - g sin(theta0) theta + Zd d`,
/// `q' - Mwdot w' = Mu u + Mw w + Mq q + Md d`, `theta' = q`: `A = E^-1 F`, `B` likewise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LongitudinalDerivatives {
    /// Force along x by speed along x, 1/s.
    pub x_u: f64,
    /// By speed along z, 1/s.
    pub x_w: f64,
    /// Force along z by speed along x, 1/s.
    pub z_u: f64,
    /// By speed along z, 1/s.
    pub z_w: f64,
    /// By acceleration along z; multiplies `w'` on the left as `1 - Zwdot`.
    pub z_w_dot: f64,
    /// By pitch rate, m/s.
    pub z_q: f64,
    /// Pitch acceleration by speed along x, 1/(m s).
    pub m_u: f64,
    /// By speed along z, 1/(m s).
    pub m_w: f64,
    /// By acceleration along z, 1/m.
    pub m_w_dot: f64,
    /// By pitch rate, 1/s.
    pub m_q: f64,
    /// Forces and pitch acceleration by elevator deflection, `Xd Zd Md`.
    pub elevator: [f64; 3],
}

/// Trim of a symmetric flight.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct SymmetricTrim {
    pub airspeed_m_s: f64,
    /// Angle between body x and the flight path, rad.
    pub alpha_rad: f64,
    /// Pitch angle, rad.
    pub theta_rad: f64,
    pub gravity_m_s2: f64,
}

impl LongitudinalDerivatives {
    /// The model `u w q theta` by elevator; `None` where `Zwdot` is one.
    pub fn state_space(&self, trim: &SymmetricTrim) -> Option<StateSpace> {
        let (sin_alpha, cos_alpha) = trim.alpha_rad.sin_cos();
        let (sin_theta, cos_theta) = trim.theta_rad.sin_cos();
        let (u0, w0, g) = (trim.airspeed_m_s * cos_alpha, trim.airspeed_m_s * sin_alpha, trim.gravity_m_s2);
        let mut left = Matrix4::identity();
        left[(1, 1)] = 1.0 - self.z_w_dot;
        left[(2, 1)] = -self.m_w_dot;
        let right = Matrix4::new(
            self.x_u,
            self.x_w,
            -w0,
            -g * cos_theta, //
            self.z_u,
            self.z_w,
            u0 + self.z_q,
            -g * sin_theta, //
            self.m_u,
            self.m_w,
            self.m_q,
            0.0, //
            0.0,
            0.0,
            1.0,
            0.0,
        );
        let [x, z, m] = self.elevator;
        let factors = left.lu();
        let a = factors.solve(&right)?;
        let b = factors.solve(&Vector4::new(x, z, m, 0.0))?;
        let (a, b) = (DMatrix::from_fn(4, 4, |i, j| a[(i, j)]), DMatrix::from_fn(4, 1, |i, _| b[i]));
        Some(StateSpace::of_states("longitudinal", &["u", "w", "q", "theta"], &[("delta_e", "rad")], a, b))
    }
}

/// Lateral dimensional derivatives in body axes, the moments primed: the product of inertia solved,
/// `L' = (L + Ixz N / Ix) / (1 - Ixz^2 / (Ix Iz))`, `N' = (N + Ixz L / Iz) / (1 - Ixz^2 / (Ix Iz))`.
///
/// `beta' = Yv beta + sin(alpha) p - cos(alpha) r + (g / V) cos(theta0) phi + Yd d / V`, `p' = L'b beta + L'p p + L'r r + L'd d`,
/// `r' = N'b beta + N'p p + N'r r + N'd d`, `phi' = p + tan(theta0) r`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LateralDerivatives {
    /// Force along y by speed along y, 1/s.
    pub y_v: f64,
    /// Roll acceleration by sideslip, roll rate and yaw rate, primed.
    pub l: [f64; 3],
    /// Yaw acceleration by sideslip, roll rate and yaw rate, primed.
    pub n: [f64; 3],
    /// Side force over mass and airspeed, roll and yaw acceleration by aileron, primed.
    pub aileron: [f64; 3],
    /// The same by rudder.
    pub rudder: [f64; 3],
}

impl LateralDerivatives {
    /// The model `beta p r phi` by aileron and rudder.
    pub fn state_space(&self, trim: &SymmetricTrim) -> StateSpace {
        let (sin, cos) = trim.alpha_rad.sin_cos();
        let ([l_b, l_p, l_r], [n_b, n_p, n_r]) = (self.l, self.n);
        let gravity = trim.gravity_m_s2 / trim.airspeed_m_s * trim.theta_rad.cos();
        let a = DMatrix::from_row_slice(
            4,
            4,
            &[
                self.y_v,
                sin,
                -cos,
                gravity, //
                l_b,
                l_p,
                l_r,
                0.0, //
                n_b,
                n_p,
                n_r,
                0.0, //
                0.0,
                1.0,
                trim.theta_rad.tan(),
                0.0,
            ],
        );
        let ([ya, la, na], [yr, lr, nr]) = (self.aileron, self.rudder);
        let b = DMatrix::from_row_slice(4, 2, &[ya, yr, la, lr, na, nr, 0.0, 0.0]);
        let inputs = [("delta_a", "rad"), ("delta_r", "rad")];
        StateSpace::of_states("lateral", &["beta", "p", "r", "phi"], &inputs, a, b)
    }
}
