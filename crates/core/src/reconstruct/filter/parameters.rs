//! The settings as the numbers of the filter's equations.

use crate::reconstruct::model::layout::{GROUPS, TRIPLES};
use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::numeric::vec3::Vec3;
use crate::reconstruct::settings::{FilterSettings, Linearisation, Method};

/// Variances of the noises, SI: the squares of the standard deviations in the settings.
#[derive(Clone, Copy)]
pub struct NoiseVariances<T> {
    /// Diagonal of Q: specific force, angular rate.
    pub process: [Vec3<T>; 2],
    /// Diagonal of R.
    pub measurement: [Vec3<T>; TRIPLES],
    /// Variance rates of the random walks, per second.
    pub random_walk: [Vec3<T>; GROUPS],
}

/// What every step of a run has in common, the same in every lane.
#[derive(Clone, Copy)]
pub struct FilterParameters<T> {
    pub noise: NoiseVariances<T>,
    /// Gravity, m/s^2.
    pub gravity: T,
    /// Innovation beyond which a measurement weighs less, in deviations; zero for none.
    pub robust_limit: f64,
    /// Square of the largest change, in standard deviations, at which the iteration ends.
    pub tolerance_squared: T,
    /// Limit on linearisations; 1 is the extended Kalman filter.
    pub max_iterations: usize,
    /// Linearise the transition at the predicted state instead of the prior one.
    pub at_prediction: bool,
    /// Whether the smoother yields the expected squares of the noises.
    pub noise_moments: bool,
}

impl<T: Real> FilterParameters<T> {
    /// Of the settings; `noise_moments` as in the field.
    pub fn new(settings: &FilterSettings, noise_moments: bool) -> Self {
        let (max_iterations, tolerance) = match settings.method {
            Method::Ekf | Method::Ukf { .. } => (1, 1.0),
            Method::Iekf { max_iterations, tolerance } => (max_iterations, tolerance),
        };
        Self {
            noise: NoiseVariances {
                process: [0, 1].map(|g| Self::squares(&settings.process_noise, g)),
                measurement: [0, 1, 2, 3].map(|m| Self::squares(&settings.measurement_noise, m)),
                random_walk: [0, 1, 2, 3, 4, 5].map(|g| Self::squares(&settings.random_walk, g)),
            },
            gravity: T::splat(settings.gravity_m_s2),
            robust_limit: settings.robust_limit,
            tolerance_squared: T::splat(tolerance.powi(2)),
            max_iterations,
            at_prediction: settings.linearisation == Linearisation::Predicted,
            noise_moments,
        }
    }

    fn squares(values: &[f64], g: usize) -> [T; 3] {
        let mut squares = [T::zero(); 3];
        for i in 0..3 {
            squares[i] = T::splat(values[3 * g + i].powi(2));
        }
        squares
    }
}
