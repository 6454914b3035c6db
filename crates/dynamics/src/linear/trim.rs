//! Steady flight of an identified model.

use doublet_core::decompose::singular;
use doublet_core::replay::MotionAxis;
use nalgebra::{DMatrix, DVector, Vector3};

use super::flight::{Equations, InputVector, StateVector};
use super::{Condition, FlightModel, LinearError, SteadyFlight};

/// Newton steps before giving up.
const MAX_STEPS: usize = 40;
/// Residual accelerations at which a trim is accepted, m/s² and rad/s².
const TOLERANCE: f64 = 1e-9;
/// Residual at which the iteration stops, m/s² and rad/s².
const CONVERGED: f64 = 1e-12;

/// Equations of the trim with the unit of what is left of them; whether they are lateral.
const EQUATIONS: [(&str, &str, bool); 7] = [
    ("the forward acceleration", "m/s^2", false),
    ("the sideward acceleration", "m/s^2", true),
    ("the vertical acceleration", "m/s^2", false),
    ("the roll acceleration", "rad/s^2", true),
    ("the pitch acceleration", "rad/s^2", false),
    ("the yaw acceleration", "rad/s^2", true),
    ("the load factor", "m/s^2", false),
];

/// What the trim solves for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unknown {
    /// Angle of attack.
    Alpha,
    /// Bank angle.
    Bank,
    /// Thrust over the weight.
    Thrust,
    /// Angle of the flight path.
    Path,
    /// Aileron, elevator or rudder.
    Control(usize),
    /// Turn rate, or pitch rate of a pull-up.
    Rate,
}

/// Steady flight without sideslip.
#[derive(Clone, Debug, PartialEq)]
pub struct Trim {
    /// The condition.
    pub condition: Condition,
    /// Motion the model can fly.
    pub motion: MotionAxis,
    /// Angle of attack, rad.
    pub alpha_rad: f64,
    /// Bank, pitch angle, rad; heading is zero.
    pub euler_rad: [f64; 3],
    /// Angle of the flight path, rad.
    pub gamma_rad: f64,
    /// Roll, pitch and yaw rate, rad/s.
    pub rates_rad_s: [f64; 3],
    /// Aileron, elevator, rudder, rad.
    pub controls_rad: [f64; 3],
    /// Sum of the thrusts, N; zero where it is inside the coefficients.
    pub thrust_n: f64,
    /// Specific force in body axes, m/s².
    pub specific_force_m_s2: [f64; 3],
    /// Newton steps taken.
    pub iterations: usize,
}

impl Trim {
    pub(crate) fn state(&self) -> StateVector {
        let speed = self.condition.airspeed_m_s;
        let ([p, q, r], [phi, theta, psi]) = (self.rates_rad_s, self.euler_rad);
        let (sin, cos) = self.alpha_rad.sin_cos();
        StateVector::from([
            speed * cos,
            0.0,
            speed * sin,
            p,
            q,
            r,
            phi,
            theta,
            psi,
            0.0,
            0.0,
            self.condition.altitude_m,
        ])
    }

    pub(crate) fn input(&self) -> InputVector {
        let [aileron, elevator, rudder] = self.controls_rad;
        InputVector::new(aileron, elevator, rudder, self.thrust_n)
    }

    /// Load factor: specific force across the flight path in the plane of symmetry over gravity.
    pub fn load_factor(&self) -> f64 {
        let [x, _, z] = self.specific_force_m_s2;
        let (sin, cos) = self.alpha_rad.sin_cos();
        (x * sin - z * cos) / self.condition.gravity_m_s2
    }
}

/// Trims without sideslip: angle of attack, thrust (or flight path), bank and deflections at which no acceleration is left, by Newton's
/// method with central differences; steps are the shortest ones where the model leaves an unknown open. Attitude and rates follow from
/// the flight path and the turn (Stevens and Lewis 2003, section 3.6).
pub fn trim(model: &FlightModel, condition: &Condition) -> Result<Trim, LinearError> {
    let motion = model.motion()?;
    let equations = Equations::new(model, condition)?;
    let search = Search::new(model, condition, motion, &equations)?;
    search.solve()
}

/// A trim being solved.
struct Search<'a> {
    condition: &'a Condition,
    equations: &'a Equations<'a>,
    motion: MotionAxis,
    unknowns: Vec<Unknown>,
    rows: Vec<usize>,
}

impl<'a> Search<'a> {
    fn new(
        model: &FlightModel,
        condition: &'a Condition,
        motion: MotionAxis,
        equations: &'a Equations<'a>,
    ) -> Result<Self, LinearError> {
        let powered = model.has_thrust();
        let turning = !matches!(condition.flight, SteadyFlight::Straight);
        if let SteadyFlight::Turn(load_factor) = condition.flight
            && (load_factor.is_nan() || load_factor <= 1.0)
        {
            return Err(LinearError::LoadFactor { load_factor });
        }
        let mut unknowns = vec![Unknown::Alpha, Unknown::Control(1)];
        unknowns.push(if powered { Unknown::Thrust } else { Unknown::Path });
        if !powered && condition.gamma_rad.is_some() {
            return Err(LinearError::NoThrust);
        }
        let lateral = motion == MotionAxis::Both;
        if lateral {
            unknowns.extend([Unknown::Bank, Unknown::Control(0), Unknown::Control(2)]);
        }
        if turning {
            unknowns.push(Unknown::Rate);
        }
        let wanted = |row: &usize| (lateral || !EQUATIONS[*row].2) && (turning || *row < 6);
        Ok(Self { condition, equations, motion, unknowns, rows: (0..7).filter(wanted).collect() })
    }

    /// State and inputs of the unknowns.
    fn point(&self, values: &DVector<f64>) -> (StateVector, InputVector, f64) {
        let condition = self.condition;
        let value_of =
            |wanted: Unknown| self.unknowns.iter().position(|&unknown| unknown == wanted).map(|index| values[index]);
        let alpha = value_of(Unknown::Alpha).unwrap_or(0.0);
        let phi = value_of(Unknown::Bank).unwrap_or(0.0);
        let gamma = value_of(Unknown::Path).or(condition.gamma_rad).unwrap_or(0.0);
        let (sin_alpha, cos_alpha) = alpha.sin_cos();
        let (across, climb) = (phi.cos() * sin_alpha, gamma.sin());
        // sin(gamma) = a sin(theta) - b cos(theta) with a = cos(alpha), b = cos(phi) sin(alpha), no sideslip.
        let root = (cos_alpha * cos_alpha - climb * climb + across * across).max(0.0).sqrt();
        let theta = (cos_alpha * across + climb * root).atan2(cos_alpha * cos_alpha - climb * climb);
        let rate = value_of(Unknown::Rate).unwrap_or(0.0);
        let rates = match condition.flight {
            SteadyFlight::Straight => Vector3::zeros(),
            SteadyFlight::PullUp(_) => Vector3::new(0.0, rate, 0.0),
            SteadyFlight::Turn(_) => {
                Vector3::new(-theta.sin(), phi.sin() * theta.cos(), phi.cos() * theta.cos()) * rate
            }
        };
        let speed = condition.airspeed_m_s;
        let weight = condition.mass.mass_kg * condition.gravity_m_s2;
        let state = StateVector::from([
            speed * cos_alpha,
            0.0,
            speed * sin_alpha,
            rates.x,
            rates.y,
            rates.z,
            phi,
            theta,
            0.0,
            0.0,
            0.0,
            condition.altitude_m,
        ]);
        let control = |index| value_of(Unknown::Control(index)).unwrap_or(0.0);
        let thrust = value_of(Unknown::Thrust).unwrap_or(0.0) * weight;
        (state, InputVector::new(control(0), control(1), control(2), thrust), gamma)
    }

    fn residual(&self, values: &DVector<f64>) -> DVector<f64> {
        let (state, input, _) = self.point(values);
        let (rate, force) = self.equations.rates(&state, &input);
        let (sin, cos) = values[0].sin_cos();
        let gravity = self.condition.gravity_m_s2;
        let wanted = match self.condition.flight {
            SteadyFlight::Straight => 0.0,
            SteadyFlight::Turn(load_factor) | SteadyFlight::PullUp(load_factor) => load_factor,
        };
        let load = force.x * sin - force.z * cos - wanted * gravity;
        DVector::from_iterator(self.rows.len(), self.rows.iter().map(|&row| if row == 6 { load } else { rate[row] }))
    }

    /// Where the iteration starts: what a wing of usual size flies at.
    fn start(&self) -> DVector<f64> {
        let condition = self.condition;
        let turn = match condition.flight {
            SteadyFlight::Turn(load_factor) => {
                let bank = (1.0 / load_factor).acos();
                (bank, condition.gravity_m_s2 * bank.tan() / condition.airspeed_m_s)
            }
            SteadyFlight::PullUp(load_factor) => {
                (0.0, condition.gravity_m_s2 * (load_factor - 1.0) / condition.airspeed_m_s)
            }
            SteadyFlight::Straight => (0.0, 0.0),
        };
        DVector::from_iterator(
            self.unknowns.len(),
            self.unknowns.iter().map(|unknown| match unknown {
                Unknown::Alpha => 0.05,
                Unknown::Bank => turn.0,
                Unknown::Thrust => 0.1,
                Unknown::Rate => turn.1,
                Unknown::Path | Unknown::Control(_) => 0.0,
            }),
        )
    }

    fn solve(&self) -> Result<Trim, LinearError> {
        /// Step of the differences.
        const DIFFERENCE: f64 = 1e-5;
        /// Longest step of an unknown.
        const LONGEST: f64 = 0.5;
        let mut values = self.start();
        let mut left = self.residual(&values);
        let mut iterations = 0;
        while iterations < MAX_STEPS && left.amax() > CONVERGED {
            let mut jacobian = DMatrix::zeros(left.len(), values.len());
            for column in 0..values.len() {
                let mut ahead = values.clone();
                ahead[column] += DIFFERENCE;
                let mut behind = values.clone();
                behind[column] -= DIFFERENCE;
                let slope = (self.residual(&ahead) - self.residual(&behind)) / (2.0 * DIFFERENCE);
                jacobian.set_column(column, &slope);
            }
            let smallest = 1e-9 * jacobian.amax();
            let Some(step) = singular(jacobian, true, true).and_then(|it| it.solve(&left, smallest).ok()) else {
                break;
            };
            let next = &values - &step * (LONGEST / step.amax()).min(1.0);
            let rest = self.residual(&next);
            iterations += 1;
            // At the limit of rounding a step no longer helps.
            if !rest.amax().is_finite() || (left.amax() < TOLERANCE && rest.amax() >= left.amax()) {
                break;
            }
            (values, left) = (next, rest);
        }
        let worst = left.iamax();
        if left[worst].is_nan() || left[worst].abs() > TOLERANCE {
            let (equation, unit, _) = EQUATIONS[self.rows[worst]];
            return Err(LinearError::NoTrim {
                airspeed_m_s: self.condition.airspeed_m_s,
                altitude_m: self.condition.altitude_m,
                equation,
                residual: left[worst],
                unit,
                iterations,
            });
        }
        let (state, input, gamma_rad) = self.point(&values);
        let (_, force) = self.equations.rates(&state, &input);
        Ok(Trim {
            condition: *self.condition,
            motion: self.motion,
            alpha_rad: values[0],
            euler_rad: [state[6], state[7], 0.0],
            gamma_rad,
            rates_rad_s: [state[3], state[4], state[5]],
            controls_rad: [input[0], input[1], input[2]],
            thrust_n: input[3],
            specific_force_m_s2: force.into(),
            iterations,
        })
    }
}
