//! The filter written plainly with dense matrices: the definition of correct, and the baseline of the bench.
//!
//! States, inputs and measurements in the order of the layout. Thesis Eq. 3.7 and 3.8, sections 3.1.2 and 3.1.3.

use nalgebra::{SMatrix, SVector};
use num_dual::DualNum;

pub type X = SVector<f64, 18>;
pub type P = SMatrix<f64, 18, 18>;
pub type Z = SVector<f64, 12>;

/// How exp(F dt) is computed.
#[derive(Clone, Copy, PartialEq)]
pub enum Discretisation {
    /// To rounding.
    Exponential,
    /// Up to F^3 dt^3 / 6.
    ThirdOrder,
}

/// One step and its measurements; `present` false leaves a row out.
#[derive(Clone, Copy)]
pub struct Step {
    pub dt: f64,
    pub noise_scale: f64,
    pub start: [f64; 6],
    pub end: [f64; 6],
    pub z: Z,
    pub present: [bool; 12],
}

pub struct Dense {
    pub gravity: f64,
    pub q: SVector<f64, 6>,
    pub r: Z,
    pub random_walk: X,
    pub discretisation: Discretisation,
    pub at_predicted: bool,
    /// 1 is the extended Kalman filter.
    pub max_iterations: usize,
    pub tolerance: f64,
}

/// What one step leaves behind.
pub struct Told {
    pub innovation: Z,
    pub innovation_covariance: SMatrix<f64, 12, 12>,
    pub nis: f64,
    pub phi: P,
    pub predicted: (X, P),
}

/// Kinematic model (Eq. 3.7).
pub fn f<D: DualNum<Primitive = f64> + Copy>(x: &[D; 18], u: &[f64; 6], g: f64) -> [D; 18] {
    let [_, _, _, vu, vv, vw, phi, theta, psi, bx, by, bz, bp, bq, br, wx, wy, wz] = *x;
    let ax = -bx + u[0];
    let ay = -by + u[1];
    let az = -bz + u[2];
    let p = -bp + u[3];
    let q = -bq + u[4];
    let r = -br + u[5];
    let forward = vu * theta.cos() + (vv * phi.sin() + vw * phi.cos()) * theta.sin();
    let sideways = vv * phi.cos() - vw * phi.sin();
    let zero = D::from(0.0);
    [
        forward * psi.cos() - sideways * psi.sin() + wx,
        forward * psi.sin() + sideways * psi.cos() + wy,
        -vu * theta.sin() + (vv * phi.sin() + vw * phi.cos()) * theta.cos() + wz,
        ax - theta.sin() * g - q * vw + r * vv,
        ay + theta.cos() * phi.sin() * g + p * vw - r * vu,
        az + theta.cos() * phi.cos() * g - p * vv + q * vu,
        p + q * phi.sin() * theta.tan() + r * phi.cos() * theta.tan(),
        q * phi.cos() - r * phi.sin(),
        q * phi.sin() / theta.cos() + r * phi.cos() / theta.cos(),
        zero,
        zero,
        zero,
        zero,
        zero,
        zero,
        zero,
        zero,
        zero,
    ]
}

/// Navigation model (Eq. 3.8).
pub fn h<D: DualNum<Primitive = f64> + Copy>(x: &[D; 18]) -> [D; 12] {
    let [px, py, pz, u, v, w, phi, theta, psi, _, _, _, _, _, _, wx, wy, wz] = *x;
    let forward = u * theta.cos() + (v * phi.sin() + w * phi.cos()) * theta.sin();
    let sideways = v * phi.cos() - w * phi.sin();
    [
        px,
        py,
        pz,
        forward * psi.cos() - sideways * psi.sin() + wx,
        forward * psi.sin() + sideways * psi.cos() + wy,
        -u * theta.sin() + (v * phi.sin() + w * phi.cos()) * theta.cos() + wz,
        phi,
        theta,
        psi,
        (u * u + v * v + w * w).sqrt(),
        w.atan2(u),
        v.atan2((u * u + w * w).sqrt()),
    ]
}

fn array(x: &X) -> [f64; 18] {
    let mut a = [0.0; 18];
    a.copy_from_slice(x.as_slice());
    a
}

/// Jacobian of `f`, element by element.
pub fn f_jacobian(x: &X, input: &[f64; 6], g: f64) -> P {
    let (u, v, w) = (x[3], x[4], x[5]);
    let (p, q, r) = (input[3] - x[12], input[4] - x[13], input[5] - x[14]);
    let ((sp, cp), (st, ct)) = (x[6].sin_cos(), x[7].sin_cos());
    let mut m = P::zeros();
    let rows = ground_velocity_rows(x);
    for i in 0..3 {
        for j in 0..6 {
            m[(i, 3 + j)] = rows[i][j];
        }
        m[(i, 15 + i)] = 1.0;
        m[(3 + i, 9 + i)] = -1.0;
    }
    m[(3, 4)] = r;
    m[(3, 5)] = -q;
    m[(3, 7)] = -g * ct;
    m[(3, 13)] = w;
    m[(3, 14)] = -v;
    m[(4, 3)] = -r;
    m[(4, 5)] = p;
    m[(4, 6)] = g * ct * cp;
    m[(4, 7)] = -g * st * sp;
    m[(4, 12)] = -w;
    m[(4, 14)] = u;
    m[(5, 3)] = q;
    m[(5, 4)] = -p;
    m[(5, 6)] = -g * ct * sp;
    m[(5, 7)] = -g * st * cp;
    m[(5, 12)] = v;
    m[(5, 13)] = -u;
    let t = st / ct;
    m[(6, 6)] = (q * cp - r * sp) * t;
    m[(6, 7)] = (q * sp + r * cp) / (ct * ct);
    m[(6, 12)] = -1.0;
    m[(6, 13)] = -sp * t;
    m[(6, 14)] = -cp * t;
    m[(7, 6)] = -q * sp - r * cp;
    m[(7, 13)] = -cp;
    m[(7, 14)] = sp;
    m[(8, 6)] = (q * cp - r * sp) / ct;
    m[(8, 7)] = (q * sp + r * cp) * t / ct;
    m[(8, 13)] = -sp / ct;
    m[(8, 14)] = -cp / ct;
    m
}

/// Derivative of ground velocity by u v w phi theta psi.
fn ground_velocity_rows(x: &X) -> [[f64; 6]; 3] {
    let (u, v, w) = (x[3], x[4], x[5]);
    let ((sp, cp), (st, ct), (ss, cs)) = (x[6].sin_cos(), x[7].sin_cos(), x[8].sin_cos());
    let forward = u * ct + (v * sp + w * cp) * st;
    let sideways = v * cp - w * sp;
    let down = -u * st + (v * sp + w * cp) * ct;
    [
        [
            ct * cs,
            sp * st * cs - cp * ss,
            cp * st * cs + sp * ss,
            sideways * st * cs + (v * sp + w * cp) * ss,
            down * cs,
            -forward * ss - sideways * cs,
        ],
        [
            ct * ss,
            sp * st * ss + cp * cs,
            cp * st * ss - sp * cs,
            sideways * st * ss - (v * sp + w * cp) * cs,
            down * ss,
            forward * cs - sideways * ss,
        ],
        [-st, sp * ct, cp * ct, sideways * ct, -forward, 0.0],
    ]
}

/// Jacobian of `h`, element by element.
pub fn h_jacobian(x: &X) -> SMatrix<f64, 12, 18> {
    let (u, v, w) = (x[3], x[4], x[5]);
    let rows = ground_velocity_rows(x);
    let mut m = SMatrix::<f64, 12, 18>::zeros();
    for i in 0..3 {
        m[(i, i)] = 1.0;
        m[(6 + i, 6 + i)] = 1.0;
        m[(3 + i, 15 + i)] = 1.0;
        for j in 0..6 {
            m[(3 + i, 3 + j)] = rows[i][j];
        }
    }
    let plane = (u * u + w * w).sqrt();
    let speed = (u * u + v * v + w * w).sqrt();
    m[(9, 3)] = u / speed;
    m[(9, 4)] = v / speed;
    m[(9, 5)] = w / speed;
    m[(10, 3)] = -w / (plane * plane);
    m[(10, 5)] = u / (plane * plane);
    m[(11, 3)] = -u * v / (plane * speed * speed);
    m[(11, 4)] = plane / (speed * speed);
    m[(11, 5)] = -w * v / (plane * speed * speed);
    m
}

fn wrapped(angle: f64) -> f64 {
    angle - std::f64::consts::TAU * (angle / std::f64::consts::TAU).round()
}

/// Measured less expected, angles wrapped, zero where absent.
fn residual(step: &Step, x: &X) -> Z {
    let expected = h(&array(x));
    Z::from_fn(|i, _| match (step.present[i], i) {
        (false, _) => 0.0,
        (true, 6..=8 | 10 | 11) => wrapped(step.z[i] - expected[i]),
        (true, _) => step.z[i] - expected[i],
    })
}

/// Variance that stands for a measurement that is not there.
const ABSENT: f64 = 1e30;

impl Dense {
    fn rates(&self, x: &X, u: &[f64; 6]) -> X {
        X::from_column_slice(&f(&array(x), u, self.gravity))
    }

    pub fn integrate(&self, x: &X, step: &Step) -> X {
        let mut middle = step.start;
        for i in 0..6 {
            middle[i] = 0.5 * (step.start[i] + step.end[i]);
        }
        let k1 = self.rates(x, &step.start);
        let k2 = self.rates(&(x + k1 * (0.5 * step.dt)), &middle);
        let k3 = self.rates(&(x + k2 * (0.5 * step.dt)), &middle);
        let k4 = self.rates(&(x + k3 * step.dt), &step.end);
        x + (k1 + (k2 + k3) * 2.0 + k4) * (step.dt / 6.0)
    }

    /// exp(F dt) and the integral of exp(F s).
    fn discretise(&self, jacobian: &P, dt: f64) -> (P, P) {
        let terms = match self.discretisation {
            Discretisation::Exponential => 12,
            Discretisation::ThirdOrder => 3,
        };
        let mut term = P::identity();
        let mut phi = term;
        let mut integral = term * dt;
        for k in 1..=terms {
            term = jacobian * term * (dt / k as f64);
            phi += term;
            if k < terms {
                integral += term * (dt / (k + 1) as f64);
            }
        }
        (phi, integral)
    }

    /// Covariance of the random walks over a step that ends at `x`: a wind that changes by dW changes the velocity relative to the air
    /// by -C' dW.
    fn walks(&self, x: &X, dt: f64) -> P {
        let mut columns = P::identity();
        let rows = ground_velocity_rows(x);
        for i in 0..3 {
            for j in 0..3 {
                columns[(3 + j, 15 + i)] = -rows[i][j];
            }
        }
        columns * P::from_diagonal(&(self.random_walk * dt)) * columns.transpose()
    }

    /// Prediction and update in place.
    pub fn step(&self, x: &mut X, p: &mut P, step: &Step) -> Told {
        let predicted = self.integrate(x, step);
        let mut middle = step.start;
        for i in 0..6 {
            middle[i] = 0.5 * (step.start[i] + step.end[i]);
        }
        let at = if self.at_predicted { &predicted } else { &*x };
        let jacobian = f_jacobian(at, &middle, self.gravity);
        let (phi, integral) = self.discretise(&jacobian, step.dt);
        let gamma = integral * jacobian.fixed_columns::<6>(9);
        let noise = SMatrix::<f64, 6, 6>::from_diagonal(&(self.q * step.noise_scale));
        let prior = phi * *p * phi.transpose() + gamma * noise * gamma.transpose() + self.walks(&predicted, step.dt);

        let mut r = self.r;
        for i in 0..12 {
            if !step.present[i] {
                r[i] = ABSENT;
            }
        }
        let r = SMatrix::<f64, 12, 12>::from_diagonal(&r);
        let mut point = predicted;
        let mut told = None;
        let mut iteration = 1;
        loop {
            let h = h_jacobian(&point);
            let ph = prior * h.transpose();
            let s = h * ph + r;
            let factor = s.cholesky().expect("innovation covariance is positive definite");
            let gain = factor.solve(&ph.transpose()).transpose();
            let innovation = residual(step, &point);
            if told.is_none() {
                let nis = innovation.dot(&factor.solve(&innovation));
                told = Some(Told { innovation, innovation_covariance: s, nis, phi, predicted: (predicted, prior) });
            }
            let next = predicted + gain * (innovation - h * (predicted - point));
            let moved =
                (3..9).chain(15..18).any(|i| (next[i] - point[i]).powi(2) > self.tolerance.powi(2) * prior[(i, i)]);
            point = next;
            if iteration >= self.max_iterations || !moved {
                let updated = prior - gain * ph.transpose();
                *p = (updated + updated.transpose()) * 0.5;
                break;
            }
            iteration += 1;
        }
        *x = point;
        told.expect("the loop runs at least once")
    }
}
