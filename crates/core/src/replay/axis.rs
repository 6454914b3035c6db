//! Flight of one axis alone, the motion of the other as it was recorded.

use nalgebra::{DMatrix, Matrix3, Vector2, Vector3};

use super::fly::{Flight, Response};
use super::forces::{Instant, Loads};
use super::sample::Sample;
use super::{Replay, ReplayError, Start};
use crate::model::{Coefficient, Derivatives};
use crate::motion::State;

/// Motion that a model flies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MotionAxis {
    /// Velocity in the plane of symmetry, pitch rate and pitch angle.
    Longitudinal,
    /// Velocity across it, roll and yaw rate and bank angle.
    Lateral,
    /// All six degrees of freedom.
    Both,
}

impl MotionAxis {
    crate::named_variants! {
        /// Name in tables.
        pub name: Longitudinal "longitudinal", Lateral "lateral", Both "both"
    }

    /// Whether a coefficient moves this axis.
    pub fn has(self, coefficient: Coefficient) -> bool {
        let is_lateral = matches!(coefficient, Coefficient::CY | Coefficient::Cl | Coefficient::Cn);
        match self {
            Self::Longitudinal => !is_lateral,
            Self::Lateral => is_lateral,
            Self::Both => true,
        }
    }

    crate::variant_texts! {
        /// Coefficients of body axes that it needs, in words.
        pub(super) needs:
            Longitudinal "longitudinal motion needs CX and CZ (or CD and CL) and Cm",
            Lateral "lateral motion needs CY, Cl and Cn",
            Both "six degrees of freedom need CX (or CD and CL), CY, CZ, Cl, Cm and Cn",
    }
}

/// Motion along a window as it was recorded, a column per component; every column has the length of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Position in local Earth axes, m.
    pub position_ned_m: [Vec<f64>; 3],
    /// Velocity relative to the air in body axes, m/s.
    pub air_velocity_body_m_s: [Vec<f64>; 3],
    /// Bank, pitch and heading angle, rad; heading without jumps.
    pub euler_rad: [Vec<f64>; 3],
    /// Roll, pitch and yaw rate, rad/s.
    pub rates_rad_s: [Vec<f64>; 3],
    /// Specific force at the centre of gravity in body axes, m/s².
    pub specific_force_m_s2: [Vec<f64>; 3],
}

impl From<&Response> for Motion {
    fn from(flown: &Response) -> Self {
        Self {
            position_ned_m: flown.position_ned_m.clone(),
            air_velocity_body_m_s: flown.air_velocity_body_m_s.clone(),
            euler_rad: flown.euler_rad.clone(),
            rates_rad_s: flown.rates_rad_s.clone(),
            specific_force_m_s2: flown.specific_force_m_s2.clone(),
        }
    }
}

impl Motion {
    /// Motion at sample `k`.
    fn at(&self, k: usize) -> Point {
        let vector = |columns: &[Vec<f64>; 3]| Vector3::from(columns.each_ref().map(|column| column[k]));
        Point {
            position_ned_m: vector(&self.position_ned_m),
            velocity_body_m_s: vector(&self.air_velocity_body_m_s),
            euler_rad: vector(&self.euler_rad),
            rates_rad_s: vector(&self.rates_rad_s),
            specific_force_m_s2: vector(&self.specific_force_m_s2),
        }
    }

    /// Length of the shortest and of the longest column.
    fn lengths(&self) -> (usize, usize) {
        let columns = [
            &self.position_ned_m, &self.air_velocity_body_m_s, &self.euler_rad, &self.rates_rad_s,
            &self.specific_force_m_s2,
        ];
        let lengths = columns.into_iter().flatten().map(Vec::len);
        (lengths.clone().min().unwrap_or(0), lengths.max().unwrap_or(0))
    }
}

/// Motion at one instant.
#[derive(Clone, Copy)]
struct Point {
    position_ned_m: Vector3<f64>,
    velocity_body_m_s: Vector3<f64>,
    euler_rad: Vector3<f64>,
    rates_rad_s: Vector3<f64>,
    specific_force_m_s2: Vector3<f64>,
}

impl Point {
    fn towards(&self, next: &Self, fraction: f64) -> Self {
        let between = |a: &Vector3<f64>, b: &Vector3<f64>| a.lerp(b, fraction);
        Self {
            position_ned_m: between(&self.position_ned_m, &next.position_ned_m),
            velocity_body_m_s: between(&self.velocity_body_m_s, &next.velocity_body_m_s),
            euler_rad: between(&self.euler_rad, &next.euler_rad),
            rates_rad_s: between(&self.rates_rad_s, &next.rates_rad_s),
            specific_force_m_s2: between(&self.specific_force_m_s2, &next.specific_force_m_s2),
        }
    }
}

/// Rates of what is recorded between two samples.
struct Slope {
    wind_ned_m_s2: Vector3<f64>,
    angular_rad_s2: Vector3<f64>,
}

/// States of one axis: `u w q theta` or `v p r phi`.
type Free = [f64; 4];

/// Gives what is added to the states of one axis at a sample, from the response up to it.
pub type Correction<'a> = dyn FnMut(usize, &Response) -> [f64; 4] + 'a;

struct AxisFlight<'a> {
    flight: Flight<'a>,
    lateral: bool,
    gravity_m_s2: f64,
}

impl Replay {
    /// Flies `model` as [`Replay::fly`] does, but the states of `axis` alone; those of the other, heading and position among
    /// them, are `motion`, linear between samples, and so is the specific force along its axes:
    ///
    /// longitudinal `u' = f_x - g sin(theta) + r v - q w`, `w' = f_z + g cos(theta) cos(phi) + q u - p v`,
    /// `theta' = q cos(phi) - r sin(phi)` and the second of Euler's equations with `v p r phi` as recorded; lateral
    /// `v' = f_y + g cos(theta) sin(phi) + p w - r u`, `phi' = p + tan(theta) (q sin(phi) + r cos(phi))` and the first and
    /// third with `u w q theta` as recorded (thesis Eq. A.6-A.14; less the rate of the wind in body axes). With
    /// [`MotionAxis::Both`] nothing is taken from `motion`.
    ///
    /// # Errors
    /// Those of [`Replay::fly`], coefficients of the other axis not asked for; a motion of another length.
    pub fn fly_axis(
        &self,
        axis: MotionAxis,
        model: &Derivatives,
        start: &Start,
        motion: &Motion,
    ) -> Result<Response, ReplayError> {
        match axis {
            MotionAxis::Both => self.fly(model, start),
            _ => self.fly_corrected(axis, model, start, motion, None),
        }
    }

    /// [`Replay::fly_axis`] of one axis with its states corrected at every sample: `correct` gets the sample and the response up to it,
    /// and gives what is added to `u w q theta` or `v p r phi`, in m/s, rad/s and rad, before the step to the next.
    ///
    /// # Errors
    /// Those of [`Replay::fly_axis`].
    pub fn predict_axis(
        &self,
        axis: MotionAxis,
        model: &Derivatives,
        start: &Start,
        motion: &Motion,
        correct: &mut Correction<'_>,
    ) -> Result<Response, ReplayError> {
        self.fly_corrected(axis, model, start, motion, Some(correct))
    }

    fn fly_corrected(
        &self,
        axis: MotionAxis,
        model: &Derivatives,
        start: &Start,
        motion: &Motion,
        mut correct: Option<&mut Correction<'_>>,
    ) -> Result<Response, ReplayError> {
        let flight = self.axis_flight(axis, model, motion)?;
        let mut free = flight.free_of(&begin(start, motion));
        let mut response = Response::with_capacity(self.time_s.len());
        let last = self.samples.len() - 1;
        for (k, sample) in self.samples.iter().enumerate() {
            let to = k.min(last - 1) + 1;
            let (step_s, recorded, slope) =
                (self.time_s[to] - self.time_s[to - 1], motion.at(k), self.slope(motion, to));
            let point = flight.point(&recorded, &free);
            let (loads, angular, mut first) = flight.rate(&point, sample, &slope);
            self.go_on(k, &loads.air, &point.rates_rad_s)?;
            let (position, euler) = (&point.position_ned_m, point.euler_rad.into());
            response.push(self.time_s[k], position, euler, &point.rates_rad_s, &loads, angular);
            if k == last {
                break;
            }
            if let Some(correct) = &mut correct {
                let change = correct(k, &response);
                free = std::array::from_fn(|state| free[state] + change[state]);
                first = flight.rate(&flight.point(&recorded, &free), sample, &slope).2;
            }
            let (next, ahead) = (&self.samples[to], motion.at(to));
            let (middle, between) = (sample.towards(next, 0.5), recorded.towards(&ahead, 0.5));
            free = runge_kutta(&free, &first, step_s, |fraction, free| {
                let (sample, recorded) = if fraction < 0.75 { (&middle, &between) } else { (next, &ahead) };
                flight.rate(&flight.point(recorded, free), sample, &slope).2
            });
        }
        Ok(response)
    }

    /// Slopes of one axis at the first sample from `start`, by central differences: of the rates of `u w q theta` or `v p r phi` with
    /// them, and of what `show` takes from a response of this one instant; columns by state.
    ///
    /// # Errors
    /// Those of [`Replay::fly_axis`].
    pub fn linearise_axis(
        &self,
        axis: MotionAxis,
        model: &Derivatives,
        start: &Start,
        motion: &Motion,
        show: &dyn Fn(&Response) -> Vec<f64>,
    ) -> Result<(DMatrix<f64>, DMatrix<f64>), ReplayError> {
        /// Differences of velocity, m/s, rate, rad/s, and angle, rad.
        const STEPS: [f64; 3] = [0.05, 1e-3, 1e-3];
        let flight = self.axis_flight(axis, model, motion)?;
        let steps = if flight.lateral {
            [STEPS[0], STEPS[1], STEPS[1], STEPS[2]]
        } else {
            [STEPS[0], STEPS[0], STEPS[1], STEPS[2]]
        };
        let (recorded, slope) = (motion.at(0), self.slope(motion, 1));
        let nominal = flight.free_of(&begin(start, motion));
        let at = |free: &Free| {
            let point = flight.point(&recorded, free);
            let (loads, angular, rates) = flight.rate(&point, &self.samples[0], &slope);
            let mut response = Response::with_capacity(1);
            let euler = point.euler_rad.into();
            response.push(self.time_s[0], &point.position_ned_m, euler, &point.rates_rad_s, &loads, angular);
            (rates, show(&response))
        };
        let (mut a, mut c) =
            (DMatrix::zeros(nominal.len(), nominal.len()), DMatrix::zeros(at(&nominal).1.len(), nominal.len()));
        for (state, step) in steps.into_iter().enumerate() {
            let [below, above] = [-step, step].map(|by| {
                let mut free = nominal;
                free[state] += by;
                at(&free)
            });
            let rates = above.0.iter().zip(&below.0).map(|(above, below)| (above - below) / (2.0 * step));
            let outputs = above.1.iter().zip(&below.1).map(|(above, below)| (above - below) / (2.0 * step));
            a.column_mut(state).iter_mut().zip(rates).for_each(|(slope, value)| *slope = value);
            c.column_mut(state).iter_mut().zip(outputs).for_each(|(slope, value)| *slope = value);
        }
        Ok((a, c))
    }

    /// One axis of a model made ready, the motion as long as the window.
    fn axis_flight<'a>(
        &'a self,
        axis: MotionAxis,
        model: &'a Derivatives,
        motion: &Motion,
    ) -> Result<AxisFlight<'a>, ReplayError> {
        self.check_axis(axis, model)?;
        let (shortest, longest) = motion.lengths();
        for found in [shortest, longest] {
            if found != self.time_s.len() {
                return Err(ReplayError::MotionLength { expected: self.time_s.len(), found });
            }
        }
        let flight = Flight::new(self, model, motion.position_ned_m[2][0]);
        Ok(AxisFlight { flight, lateral: axis == MotionAxis::Lateral, gravity_m_s2: self.gravity_m_s2 })
    }

    /// Rates of what is recorded over the step to sample `to`.
    fn slope(&self, motion: &Motion, to: usize) -> Slope {
        let step_s = self.time_s[to] - self.time_s[to - 1];
        Slope {
            wind_ned_m_s2: (self.samples[to].wind_ned_m_s - self.samples[to - 1].wind_ned_m_s) / step_s,
            angular_rad_s2: (motion.at(to).rates_rad_s - motion.at(to - 1).rates_rad_s) / step_s,
        }
    }
}

/// The first instant: the start, with what it does not have as recorded.
fn begin(start: &Start, motion: &Motion) -> Point {
    Point {
        velocity_body_m_s: start.air_velocity_body_m_s.into(),
        euler_rad: start.euler_rad.into(),
        rates_rad_s: start.rates_rad_s.into(),
        ..motion.at(0)
    }
}

impl AxisFlight<'_> {
    fn free_of(&self, point: &Point) -> Free {
        let (velocity, euler, rates) = (&point.velocity_body_m_s, &point.euler_rad, &point.rates_rad_s);
        if self.lateral { [velocity.y, rates.x, rates.z, euler.x] } else { [velocity.x, velocity.z, rates.y, euler.y] }
    }

    /// The recorded motion with the states of the axis in place.
    fn point(&self, recorded: &Point, free: &Free) -> Point {
        let mut point = *recorded;
        let (velocity, euler, rates) = (&mut point.velocity_body_m_s, &mut point.euler_rad, &mut point.rates_rad_s);
        if self.lateral {
            [velocity.y, rates.x, rates.z, euler.x] = *free;
        } else {
            [velocity.x, velocity.z, rates.y, euler.y] = *free;
        }
        point
    }

    /// Loads, angular acceleration and the rates of the free states.
    fn rate(&self, point: &Point, sample: &Sample, slope: &Slope) -> (Loads, Vector3<f64>, Free) {
        let (velocity, rates) = (point.velocity_body_m_s, point.rates_rad_s);
        let attitude = State::new(Vector3::zeros(), Vector3::zeros(), point.euler_rad.into());
        let instant = Instant {
            velocity_body_m_s: velocity,
            rates_rad_s: rates,
            body_from_ned: attitude.body_from_ned(),
            altitude_m: self.flight.altitude_m(point.position_ned_m.z),
        };
        let force = point.specific_force_m_s2;
        let recorded = if self.lateral { [Some(force.x), None, Some(force.z)] } else { [None, Some(force.y), None] };
        let loads = self.flight.forces.loads(&instant, sample, recorded);
        let gravity = Vector3::z() * self.gravity_m_s2;
        let along = loads.specific_force_m_s2 + instant.body_from_ned * (gravity - slope.wind_ned_m_s2);
        let acceleration = along - rates.cross(&velocity);
        let angular = self.angular_acceleration(&loads.moment_n_m, &rates, sample, slope.angular_rad_s2);
        let [(sin_phi, cos_phi), (sin_theta, cos_theta)] = [point.euler_rad.x, point.euler_rad.y].map(libm::sincos);
        let free = if self.lateral {
            let turn = (rates.y * sin_phi + rates.z * cos_phi) * sin_theta / cos_theta;
            [acceleration.y, angular.x, angular.z, rates.x + turn]
        } else {
            [acceleration.x, acceleration.z, angular.y, rates.y * cos_phi - rates.z * sin_phi]
        };
        (loads, angular, free)
    }

    /// `I w' = M - w x (I w + h)` solved for the components of the axis, the others as recorded.
    fn angular_acceleration(
        &self,
        moment_n_m: &Vector3<f64>,
        rates: &Vector3<f64>,
        sample: &Sample,
        recorded: Vector3<f64>,
    ) -> Vector3<f64> {
        let tensor: &Matrix3<f64> = sample.inertia.tensor();
        let right = moment_n_m - rates.cross(&(tensor * rates + sample.rotor_momentum_n_m_s));
        let mut angular = recorded;
        if self.lateral {
            let (xx, xz, zz) = (tensor[(0, 0)], tensor[(0, 2)], tensor[(2, 2)]);
            let left = Vector2::new(tensor[(0, 1)], tensor[(2, 1)]) * recorded.y;
            let [roll, yaw] = [right.x - left.x, right.z - left.y];
            // Positive: so is the whole tensor.
            let determinant = xx * zz - xz * xz;
            angular.x = (zz * roll - xz * yaw) / determinant;
            angular.z = (xx * yaw - xz * roll) / determinant;
        } else {
            let coupled = tensor[(1, 0)] * recorded.x + tensor[(1, 2)] * recorded.z;
            angular.y = (right.y - coupled) / tensor[(1, 1)];
        }
        angular
    }
}

/// One step of the classical fourth-order Runge-Kutta method from `k1`; `rate` gets the fraction of the step and the states there.
fn runge_kutta(free: &Free, k1: &Free, step_s: f64, rate: impl Fn(f64, &Free) -> Free) -> Free {
    let plus = |k: &Free, by: f64| -> Free { std::array::from_fn(|i| free[i] + by * k[i]) };
    let k2 = rate(0.5, &plus(k1, 0.5 * step_s));
    let k3 = rate(0.5, &plus(&k2, 0.5 * step_s));
    let k4 = rate(1.0, &plus(&k3, step_s));
    std::array::from_fn(|i| free[i] + step_s / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
}
