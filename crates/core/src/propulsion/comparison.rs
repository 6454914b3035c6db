//! Modelled power beside the power an engine monitor reports (thesis 6.3).

use crate::series::TimeRange;

/// How well two powers agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerComparison {
    /// Number of samples where both are finite.
    pub samples: usize,
    /// Mean of the modelled power, W.
    pub mean_modelled_w: f64,
    /// Mean of the monitor's power, W.
    pub mean_monitor_w: f64,
    /// Squared correlation coefficient; not a number where one of the two does not vary.
    pub r_squared: f64,
    /// Root mean square of modelled less monitor power, W.
    pub rms_w: f64,
}

/// Correlation of the power difference with one variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlation {
    /// Name of the variable.
    pub variable: String,
    /// Correlation coefficient; not a number where one of the two does not vary.
    pub coefficient: f64,
}

/// A named part of a flight.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseOfFlight {
    /// Name, for example `Climb`.
    pub name: String,
    /// Its time, s.
    pub window: TimeRange,
}

/// One phase of flight and the agreement of the powers in it.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseRow {
    /// Name of the phase.
    pub name: String,
    /// Agreement, with `samples` 0 and means that are not numbers where the phase holds no sample.
    pub comparison: PowerComparison,
}

/// Means, squared correlation and root mean square difference of modelled and monitored power.
///
/// `R² = (sum (x - mean x)(y - mean y))² / (sum (x - mean x)² sum (y - mean y)²)`,
/// `RMS = sqrt(mean((x - y)²))` over the samples where both are finite; the shorter column ends the comparison.
/// Thesis Table 6.12: R² there is the square of the correlation coefficient, and the monitor is not a validated truth.
pub fn compare_power(modelled_w: &[f64], monitor_w: &[f64]) -> PowerComparison {
    let (mut samples, mut square) = (0_usize, 0.0);
    let (mut sum_modelled, mut sum_monitor) = (0.0, 0.0);
    for (&x, &y) in modelled_w.iter().zip(monitor_w).filter(|(x, y)| x.is_finite() && y.is_finite()) {
        samples += 1;
        sum_modelled += x;
        sum_monitor += y;
        square += (x - y) * (x - y);
    }
    let count = samples as f64;
    PowerComparison {
        samples,
        mean_modelled_w: sum_modelled / count,
        mean_monitor_w: sum_monitor / count,
        r_squared: correlation(modelled_w.iter().copied(), monitor_w).powi(2),
        rms_w: (square / count).sqrt(),
    }
}

/// Correlation of modelled less monitor power with each variable (thesis Table 6.13).
///
/// The thesis' seven: modelled power, manifold pressure, static pressure, air temperature, engine speed, true airspeed,
/// pressure altitude. Columns are in any one unit each; samples where either side is not finite are left out.
pub fn difference_correlation(modelled_w: &[f64], monitor_w: &[f64], variables: &[(&str, &[f64])]) -> Vec<Correlation> {
    let difference = || modelled_w.iter().zip(monitor_w).map(|(x, y)| x - y);
    variables
        .iter()
        .map(|(name, column)| Correlation {
            variable: (*name).to_owned(),
            coefficient: correlation(difference(), column),
        })
        .collect()
}

/// The comparison of [`compare_power`] for each phase of flight (thesis Table 6.11, Figure 6.14).
///
/// `time_s` increases and belongs to both columns; phases may overlap and come in any order.
pub fn phase_table(time_s: &[f64], modelled_w: &[f64], monitor_w: &[f64], phases: &[PhaseOfFlight]) -> Vec<PhaseRow> {
    let samples = time_s.len().min(modelled_w.len()).min(monitor_w.len());
    phases
        .iter()
        .map(|phase| {
            let range = phase.window.indices(&time_s[..samples]);
            PhaseRow {
                name: phase.name.clone(),
                comparison: compare_power(&modelled_w[range.clone()], &monitor_w[range]),
            }
        })
        .collect()
}

/// Pearson's correlation coefficient over the samples where both are finite, in two passes.
fn correlation(x: impl Iterator<Item = f64> + Clone, y: &[f64]) -> f64 {
    let pairs = x.zip(y.iter().copied()).filter(|(x, y)| x.is_finite() && y.is_finite());
    let (mut count, mut sum_x, mut sum_y) = (0.0, 0.0, 0.0);
    for (x, y) in pairs.clone() {
        count += 1.0;
        sum_x += x;
        sum_y += y;
    }
    let (mean_x, mean_y) = (sum_x / count, sum_y / count);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in pairs {
        xx += (x - mean_x) * (x - mean_x);
        xy += (x - mean_x) * (y - mean_y);
        yy += (y - mean_y) * (y - mean_y);
    }
    if xx > 0.0 && yy > 0.0 { xy / (xx * yy).sqrt() } else { f64::NAN }
}
