//! A reconstruction against the states it was simulated from.

use doublet_core::reconstruct::{Reconstruction, STATES, State};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Mean squared normalised error of each state against truth, `mean ((x - truth) / sigma)^2`, from `from_s` on; 1 is
/// ideal. `truth` has one column per state at the inertial times. States without deviation give NaN.
pub fn normalised_errors(run: &Reconstruction, truth: &[Vec<f64>; STATES], from_s: f64) -> [f64; STATES] {
    let first = run.time_s.partition_point(|time| *time < from_s);
    let mut errors = [0.0; STATES];
    for (k, error) in errors.iter_mut().enumerate() {
        let rows = first..run.time_s.len().min(truth[k].len());
        let count = rows.len() as f64;
        *error =
            rows.map(|i| ((run.states[k][i] - truth[k][i]) / run.deviations[k].at(i)).powi(2)).sum::<f64>() / count;
    }
    errors
}

/// Normalised estimation error squared of the final state, `(x - truth)' P^-1 (x - truth)`, over the states that have a
/// deviation, and their number: the mean over independent runs lies within `chi^2(runs * number) / runs` where the
/// covariance tells the truth (Bar-Shalom, Li & Kirubarajan 2001, section 5.4). `None` where the covariance is not positive.
pub fn final_nees(run: &Reconstruction, truth: &[f64; STATES]) -> Option<(f64, usize)> {
    let p = &run.final_covariance;
    let free: Vec<usize> = (0..STATES).filter(|&k| p[(k, k)] > 0.0).collect();
    // in units of the deviations: the covariance spans ten decades
    let sigma = |i: usize| p[(free[i], free[i])].sqrt();
    let correlation = DMatrix::from_fn(free.len(), free.len(), |i, j| p[(free[i], free[j])] / (sigma(i) * sigma(j)));
    let mut errors = Vec::new();
    for (i, &k) in free.iter().enumerate() {
        let error = run.states[k].last()? - truth[k];
        let is_angle = (State::BankAngle as usize..=State::HeadingAngle as usize).contains(&k);
        errors.push(if is_angle { error.sin().atan2(error.cos()) } else { error } / sigma(i));
    }
    let errors = DVector::from_vec(errors);
    Some((errors.dot(&correlation.cholesky()?.solve(&errors)), free.len()))
}

/// 95 % region of the mean over `runs` independent runs of a normalised square with `degrees` degrees of freedom each.
pub fn mean_band(runs: usize, degrees: usize) -> [f64; 2] {
    let chi = ChiSquared::new((runs * degrees) as f64).unwrap();
    [0.025, 0.975].map(|part| chi.inverse_cdf(part) / runs as f64)
}
