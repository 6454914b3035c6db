//! Least squares of few regressors, over the windows in which all are finite.

/// Most regressors of one fit.
pub const MOST: usize = 7;
const FEWEST: usize = 20;
/// Least part of a regressor that the others do not explain.
const LEAST_OWN_PART: f64 = 1e-9;

/// A fit `y = sum of coefficients times regressors + constant`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Coefficients in the order of the regressors.
    pub coefficients: [f64; MOST],
    /// Part of the variance that is explained.
    pub r2: f64,
}

/// Fits `y` with a constant; nothing where too few windows are finite or the regressors are collinear.
pub fn fit(y: &[f64], regressors: &[&[f64]]) -> Option<Fit> {
    let size = regressors.len().min(MOST);
    let is_finite = |k: usize| y[k].is_finite() && regressors.iter().all(|x| x[k].is_finite());
    let mut means = [0.0; MOST];
    let (mut y_mean, mut number) = (0.0, 0_usize);
    for k in (0..y.len()).filter(|k| is_finite(*k)) {
        number += 1;
        y_mean += y[k];
        (0..size).for_each(|i| means[i] += regressors[i][k]);
    }
    if number < FEWEST {
        return None;
    }
    let count = number as f64;
    y_mean /= count;
    means.iter_mut().for_each(|mean| *mean /= count);
    let mut normal = [[0.0; MOST + 1]; MOST];
    let mut squares = 0.0;
    for k in (0..y.len()).filter(|k| is_finite(*k)) {
        let dy = y[k] - y_mean;
        squares += dy * dy;
        for i in 0..size {
            let xi = regressors[i][k] - means[i];
            normal[i][MOST] += xi * dy;
            (i..size).for_each(|j| normal[i][j] += xi * (regressors[j][k] - means[j]));
        }
    }
    let right = normal.map(|row| row[MOST]);
    let coefficients = solve(&mut normal, size)?;
    let explained: f64 = (0..size).map(|i| coefficients[i] * right[i]).sum();
    (squares > 0.0).then(|| Fit { coefficients, r2: (explained / squares).clamp(0.0, 1.0) })
}

/// Solves symmetric normal equations by elimination.
fn solve(normal: &mut [[f64; MOST + 1]; MOST], size: usize) -> Option<[f64; MOST]> {
    let own: [f64; MOST] = std::array::from_fn(|i| normal[i][i]);
    for i in 0..size {
        (0..i).for_each(|j| normal[i][j] = normal[j][i]);
    }
    for i in 0..size {
        let pivot = normal[i][i];
        if pivot.is_nan() || pivot <= LEAST_OWN_PART * own[i] || own[i] <= 0.0 {
            return None;
        }
        let row = normal[i];
        for below in normal.iter_mut().take(size).skip(i + 1) {
            let factor = below[i] / pivot;
            (i..size).for_each(|j| below[j] -= factor * row[j]);
            below[MOST] -= factor * row[MOST];
        }
    }
    let mut found = [0.0; MOST];
    for i in (0..size).rev() {
        let rest: f64 = (i + 1..size).map(|j| normal[i][j] * found[j]).sum();
        found[i] = (normal[i][MOST] - rest) / normal[i][i];
    }
    found.iter().all(|value| value.is_finite()).then_some(found)
}

/// Slope and squared correlation of `y` on `x`.
pub fn line(y: &[f64], x: &[f64]) -> Option<(f64, f64)> {
    let pairs = || y.iter().zip(x).map(|(y, x)| if (y + x).is_finite() { (*y, *x, 1.0) } else { (0.0, 0.0, 0.0) });
    let (mut y_sum, mut x_sum, mut count) = (0.0, 0.0, 0.0);
    for (y, x, one) in pairs() {
        (y_sum, x_sum, count) = (y_sum + y, x_sum + x, count + one);
    }
    if count < FEWEST as f64 {
        return None;
    }
    let (y_mean, x_mean) = (y_sum / count, x_sum / count);
    let (mut yy, mut xy, mut xx) = (0.0, 0.0, 0.0);
    for (y, x, one) in pairs() {
        let (dy, dx) = (y - one * y_mean, x - one * x_mean);
        (yy, xy, xx) = (yy + dy * dy, xy + dy * dx, xx + dx * dx);
    }
    let slope = xy / xx;
    (xx > 0.0 && yy > 0.0 && slope.is_finite()).then(|| (slope, (slope * xy / yy).clamp(0.0, 1.0)))
}

/// The factor of `units` that a number is within `ratio` of, either way, whatever its sign.
pub fn snap<T: Copy>(number: f64, units: &[(T, f64)], ratio: f64) -> Option<T> {
    let far = |factor: f64| (number.abs() / factor).ln().abs();
    let nearest = units.iter().min_by(|a, b| far(a.1).total_cmp(&far(b.1)))?;
    (far(nearest.1) < ratio.ln()).then_some(nearest.0)
}
