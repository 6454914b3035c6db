//! Forms of the filter: how each holds its estimate, and how it goes forwards and backwards through a block.

use super::ReconstructError;
use super::covariance::{Covariance, GROUPS};
use super::dense::Dense;
use super::kernel::{Estimate, Tuning};
use super::lanes::{Lanes, MOST_LANES};
use super::layout::STATES;
use super::march::RECORD;
use super::real::Real;
use super::settings::{Linearisation, Method, ValidSettings};
use super::smoother::Kept;
use super::window::Window;

/// State and covariance of as many windows as [`Form::Number`] has lanes.
pub trait Form: Clone {
    /// What the kernel computes with.
    type Number: Real;
    /// What the backward pass needs of one step.
    type Kept;
    /// Numbers a step tells per window: [`RECORD`], or [`super::march::FULL_RECORD`] with air-data states.
    const ROW: usize = RECORD;

    /// The estimate before the first step.
    fn new(windows: &[Result<Window<'_>, ReconstructError>], settings: &ValidSettings) -> Self;

    /// Forwards over `steps` steps of `drive`, told in `record`.
    fn run(&mut self, tuning: &Tuning<Self::Number>, steps: usize, drive: &[f64], record: &mut [f64]);

    /// Called once, at the end of the windows, before going backwards.
    fn begin_smoothing(&mut self) {}

    /// Backwards: `self`, smoothed, enters at the end of the steps and leaves at their start, where the filter was at
    /// `start`. `kept` is working space.
    fn smooth(
        &mut self,
        start: &Self,
        tuning: &Tuning<Self::Number>,
        steps: usize,
        drive: &[f64],
        kept: &mut Vec<Self::Kept>,
        record: &mut [f64],
    );

    /// Covariance of the window in `lane`.
    fn covariance(&self, lane: usize) -> Dense;
}

impl<T: Lanes> Form for Estimate<T> {
    type Number = T;
    type Kept = Kept<T>;

    fn new(windows: &[Result<Window<'_>, ReconstructError>], settings: &ValidSettings) -> Self {
        initial_estimate(windows, settings)
    }

    fn run(&mut self, tuning: &Tuning<T>, steps: usize, drive: &[f64], record: &mut [f64]) {
        T::run(self, tuning, steps, drive, record);
    }

    fn smooth(
        &mut self,
        start: &Self,
        tuning: &Tuning<T>,
        steps: usize,
        drive: &[f64],
        kept: &mut Vec<Kept<T>>,
        record: &mut [f64],
    ) {
        T::smooth(start, self, tuning, steps, drive, kept, record);
    }

    fn covariance(&self, lane: usize) -> Dense {
        let mut lanes = [0.0; MOST_LANES];
        let mut covariance = Dense::zeros();
        for i in 0..STATES {
            for j in 0..STATES {
                self.p.block(i / 3, j / 3)[i % 3][j % 3].store(&mut lanes);
                covariance[(i, j)] = lanes[lane];
            }
        }
        covariance
    }
}

/// Initial states and covariance, one window per lane; a lane without a window gets those of the first.
pub fn initial_estimate<T: Real>(
    windows: &[Result<Window<'_>, ReconstructError>],
    settings: &ValidSettings,
) -> Estimate<T> {
    let mut x = [[T::zero(); 3]; GROUPS];
    let mut variances = x;
    for k in 0..STATES {
        let first = windows.iter().flatten().map(|window| window.result.states[k][0]).next().unwrap_or(0.0);
        let mut lanes = [first; MOST_LANES];
        for (lane, window) in lanes.iter_mut().zip(windows) {
            if let Ok(window) = window {
                *lane = window.result.states[k][0];
            }
        }
        x[k / 3][k % 3] = T::load(&lanes);
        variances[k / 3][k % 3] = T::splat(settings.initial_deviation[k].powi(2));
    }
    Estimate { x, p: Covariance::diagonal(&variances) }
}

/// Settings as variances, the same in every lane; `see_noise` as in [`Tuning`].
pub fn tuning<T: Real>(settings: &ValidSettings, see_noise: bool) -> Tuning<T> {
    let square = |values: &[f64], g: usize| {
        let mut squares = [T::zero(); 3];
        for i in 0..3 {
            squares[i] = T::splat(values[3 * g + i].powi(2));
        }
        squares
    };
    let (max_iterations, tolerance) = match settings.method {
        Method::Ekf | Method::Ukf { .. } => (1, 1.0),
        Method::Iekf { max_iterations, tolerance } => (max_iterations, tolerance),
    };
    Tuning {
        gravity: T::splat(settings.gravity_m_s2),
        process: [0, 1].map(|g| square(&settings.process_noise, g)),
        measurement: [0, 1, 2, 3].map(|m| square(&settings.measurement_noise, m)),
        random_walk: [0, 1, 2, 3, 4, 5].map(|g| square(&settings.random_walk, g)),
        tolerance_squared: T::splat(tolerance.powi(2)),
        max_iterations,
        at_predicted: settings.linearisation == Linearisation::Predicted,
        see_noise,
    }
}
