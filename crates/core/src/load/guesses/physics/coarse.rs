//! The search over all triples of angles, in few windows and with sums prepared once: which of them are worth a closer look.

use super::fit::snap;
use super::kinematics::{ANGLES, RATIO, log_likelihood, slope_likelihood};
use super::windows::Windows;

/// Most windows that triples are compared in.
const COARSE: usize = 110;
/// Least squared correlation of a rate with the one that the attitude makes.
const LEAST_R2: f64 = 0.4;

/// Recorded rates of one of SI.
const SCALES: [(f64, f64); 2] = [(1.0, 1.0), (ANGLES[1].1, ANGLES[1].1)];

/// Values about their mean over the length of them.
struct Unit {
    values: Vec<f64>,
    length: f64,
}

impl Unit {
    fn normalise(values: Vec<f64>) -> Self {
        let finite = values.iter().filter(|value| value.is_finite());
        let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        let mean: f64 = if count > 0.0 { sum / count } else { 0.0 };
        let about = |value: f64| if value.is_finite() { value - mean } else { 0.0 };
        let mut values: Vec<f64> = values.into_iter().map(about).collect();
        let length = values.iter().map(|value| value * value).sum::<f64>().sqrt();
        if length > 0.0 {
            values.iter_mut().for_each(|value| *value /= length);
        }
        Self { values, length }
    }

    fn correlate(&self, other: &Self) -> f64 {
        self.values.iter().zip(&other.values).map(|(a, b)| a * b).sum()
    }
}

/// An angle in one unit.
struct Angle {
    column: usize,
    sin: Vec<f64>,
    cos: Vec<f64>,
    slope: Vec<f64>,
    /// Squared correlation of its slope with each rate.
    plain: Vec<f64>,
}

/// A triple of columns in a unit, with its score.
pub struct Triple {
    pub columns: [usize; 3],
    pub unit: usize,
    pub score: f64,
}

/// The best triples among columns that can be angles in each unit, by rates among others.
pub fn triples(
    windows: &Windows,
    angles: [&[usize]; 2],
    rates: &[usize],
    [can_bank, can_pitch]: [&dyn Fn(usize, usize) -> bool; 2],
    most: usize,
) -> Vec<Triple> {
    let step = windows.count.div_ceil(COARSE).max(1);
    let units: Vec<Unit> = rates.iter().map(|j| Unit::normalise(thin(&windows.columns[*j].mean, step))).collect();
    let mut all: Vec<Triple> = Vec::new();
    for (unit, columns) in angles.into_iter().enumerate() {
        let scale = 1.0 / ANGLES[unit].1;
        let angles: Vec<Angle> =
            columns.iter().map(|column| form_angle(windows, *column, (step, scale), &units)).collect();
        for phi in angles.iter().filter(|phi| can_bank(phi.column, unit)) {
            for theta in angles.iter().filter(|theta| theta.column != phi.column && can_pitch(theta.column, unit)) {
                for psi in angles.iter().filter(|psi| psi.column != phi.column && psi.column != theta.column) {
                    let score = score([phi, theta, psi], rates, &units, windows.independent);
                    if let Some(score) = score {
                        all.push(Triple { columns: [phi.column, theta.column, psi.column], unit, score });
                    }
                }
            }
        }
    }
    all.sort_by(|a, b| b.score.total_cmp(&a.score));
    all.truncate(most);
    all
}

fn thin(values: &[f64], step: usize) -> Vec<f64> {
    values.iter().copied().step_by(step).collect()
}

/// A column as an angle in a unit, and what its slope has of each rate.
fn form_angle(windows: &Windows, column: usize, (step, scale): (usize, f64), units: &[Unit]) -> Angle {
    let (mean, slope) = (thin(&windows.columns[column].mean, step), thin(&windows.columns[column].slope, step));
    let plain = Unit::normalise(slope.clone());
    Angle {
        column,
        sin: mean.iter().map(|value| (scale * value).sin()).collect(),
        cos: mean.iter().map(|value| (scale * value).cos()).collect(),
        slope: slope.iter().map(|value| scale * value).collect(),
        plain: units.iter().map(|rate| plain.correlate(rate).powi(2)).collect(),
    }
}

/// What the best rates of a triple are worth; nothing where one has none.
fn score(angles: [&Angle; 3], rates: &[usize], units: &[Unit], independent: f64) -> Option<f64> {
    let [phi, theta, psi] = angles;
    let count = phi.slope.len();
    let mut total = 0.0;
    for axis in 0..3 {
        let made = (0..count).map(|k| match axis {
            0 => phi.slope[k] - psi.slope[k] * theta.sin[k],
            1 => theta.slope[k] * phi.cos[k] + psi.slope[k] * phi.sin[k] * theta.cos[k],
            _ => psi.slope[k] * phi.cos[k] * theta.cos[k] - theta.slope[k] * phi.sin[k],
        });
        let made = Unit::normalise(made.collect());
        let mut best = (0.0, 0, 0.0);
        for (j, rate) in units.iter().enumerate() {
            let correlation = made.correlate(rate);
            let r2 = correlation * correlation;
            let is_free = angles.iter().all(|angle| angle.column != rates[j]);
            let slope = correlation * rate.length / made.length;
            if r2 > best.0
                && is_free
                && let Some(factor) = snap(slope, &SCALES, RATIO)
            {
                best = (r2, j, slope_likelihood(slope, factor, r2));
            }
        }
        let (r2, j, slope) = best;
        if r2 < LEAST_R2 {
            return None;
        }
        total += slope + 1.3 * log_likelihood(r2, independent) - log_likelihood(angles[axis].plain[j], independent);
    }
    Some(total)
}
