//! The fit of a calibration to readings.

use doublet_core::estimate::least_squares;
use nalgebra::DMatrix;

use super::{Curve, SensorKind, drum_radius_mm};

/// A calibration fitted to readings.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationFit {
    pub curve: Curve,
    /// Standard errors of the numbers of the curve, where it has more readings than numbers.
    pub errors: Vec<f64>,
    /// Readings it was fitted to: what was read, what it means.
    pub points: Vec<[f64; 2]>,
    /// Whether each reading counts: one that lets a probe fall where the fuel rises does not.
    pub used: Vec<bool>,
    /// Reading less curve, in the order of the readings.
    pub residuals: Vec<f64>,
    /// Root mean square of the residuals of what counts.
    pub deviation: f64,
    /// Coefficient of determination; of a table of the line of one to one.
    pub r_squared: f64,
    /// Readings about the middle of those taken between which the curve only rises or only falls.
    pub range: [f64; 2],
}

impl CalibrationFit {
    /// Radius of the drum and its standard error, mm, where the sensor is one.
    pub fn drum_radius_mm(&self, kind: &SensorKind) -> Option<(f64, f64)> {
        let error = self.errors.get(1).map_or(f64::NAN, |error| error.to_degrees());
        drum_radius_mm(kind, &self.curve).map(|radius| (radius, error))
    }
}

/// Readings from lines of two numbers each, as they are typed or copied from a table; empty lines and what follows `#` are passed over.
pub fn points(text: &str) -> Result<Vec<[f64; 2]>, String> {
    let mut points = Vec::new();
    for (at, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let words: Vec<&str> = line.split([' ', '\t', ';', ',']).filter(|word| !word.is_empty()).collect();
        if words.is_empty() {
            continue;
        }
        let number = |word: &&str| word.replace('\u{2212}', "-").parse::<f64>().ok().filter(|value| value.is_finite());
        let numbers: Option<Vec<f64>> = words.iter().map(number).collect();
        match numbers.as_deref() {
            Some(&[x, y]) => points.push([x, y]),
            _ => return Err(format!("line {}: '{}' is not two numbers", at + 1, line.trim())),
        }
    }
    Ok(points)
}

/// Fits the calibration of a sensor to readings; `degree` counts where the sensor has a choice.
///
/// Lines and polynomials by least squares; the exponent of the pod by least squares on the logarithm of the angle; a probe by the most
/// readings that never fall, with straight lines between them (thesis Tables 4.9 and 4.10).
pub fn fit(kind: &SensorKind, degree: usize, readings: &[[f64; 2]]) -> Result<CalibrationFit, String> {
    let mut points = readings.to_vec();
    points.sort_by(|one, other| one[0].total_cmp(&other[0]));
    match kind {
        SensorKind::Drum | SensorKind::Aileron | SensorKind::Elevator => polynomial(points, 1, false),
        SensorKind::Pedal(_) => polynomial(points, degree.clamp(1, 5), false),
        SensorKind::Pod(_) => {
            if let Some(point) = points.iter().find(|point| point[1] <= 0.0) {
                return Err(format!(
                    "the angle of attack at reading {} is {} deg: give angles above zero",
                    point[0], point[1]
                ));
            }
            polynomial(points, degree.clamp(1, 6), true)
        }
        SensorKind::Probe(_) => probe(points),
    }
}

fn polynomial(points: Vec<[f64; 2]>, degree: usize, is_exponent: bool) -> Result<CalibrationFit, String> {
    let count = points.len();
    if count < degree + 1 {
        return Err(format!("{} readings are needed, {count} given", degree + 1));
    }
    // Powers of readings of order one keep the equations well conditioned.
    let size = points.iter().map(|point| point[0].abs()).fold(0.0, f64::max);
    if size == 0.0 {
        return Err("all readings are at zero: move the control".to_owned());
    }
    let x = DMatrix::from_fn(count, degree + 1, |row, power| (points[row][0] / size).powi(power as i32));
    let z: Vec<f64> = points.iter().map(|point| if is_exponent { point[1].ln() } else { point[1] }).collect();
    let names: Vec<String> = (0..=degree).map(|power| format!("a{power}")).collect();
    let unscale = |values: &[f64]| -> Vec<f64> {
        values.iter().enumerate().map(|(power, value)| value / size.powi(power as i32)).collect()
    };
    let (estimates, errors) = match count > degree + 1 {
        true => {
            let fit = least_squares(&names, &x, &z).map_err(|error| error.to_string())?;
            (fit.estimates.clone(), fit.standard_errors.clone())
        }
        // Through every reading; their scatter is not known.
        false => {
            let solved =
                x.lu().solve(&nalgebra::DVector::from_vec(z)).ok_or("two readings have the same abscissa: keep one")?;
            (solved.iter().copied().collect(), Vec::new())
        }
    };
    let coefficients = unscale(&estimates);
    let curve = if is_exponent { Curve::Exponential(coefficients) } else { Curve::Polynomial(coefficients) };
    let residuals: Vec<f64> = points.iter().map(|[x, y]| y - curve.at(*x)).collect();
    let mean = points.iter().map(|point| point[1]).sum::<f64>() / count as f64;
    let spread: f64 = points.iter().map(|point| (point[1] - mean).powi(2)).sum();
    let rest: f64 = residuals.iter().map(|residual| residual * residual).sum();
    let range = rising_range(&curve, [points[0][0], points[count - 1][0]]);
    Ok(CalibrationFit {
        errors: unscale(&errors),
        used: vec![true; count],
        deviation: (rest / count as f64).sqrt(),
        r_squared: 1.0 - rest / spread,
        residuals,
        range,
        points,
        curve,
    })
}

/// Readings about the middle of `ends` between which a curve only rises or only falls.
fn rising_range(curve: &Curve, [low, high]: [f64; 2]) -> [f64; 2] {
    /// Steps in which the curve is looked over.
    const LOOK: usize = 800;
    let place = |k: usize| low + (high - low) * k as f64 / LOOK as f64;
    let step = |k: usize| curve.at(place(k + 1)) - curve.at(place(k));
    let middle = LOOK / 2;
    let rises = step(middle) > 0.0;
    let goes_on = |k: &usize| (step(*k) > 0.0) == rises;
    let first = (0..middle).rev().take_while(goes_on).last().unwrap_or(middle);
    let last = (middle..LOOK).take_while(goes_on).last().unwrap_or(middle);
    [place(first), place(last + 1)]
}

fn probe(points: Vec<[f64; 2]>) -> Result<CalibrationFit, String> {
    if points.len() < 2 {
        return Err(format!("2 readings are needed, {} given", points.len()));
    }
    if let Some(pair) = points.windows(2).find(|pair| pair[0][0] == pair[1][0]) {
        return Err(format!("two readings are at {} lb: keep one", pair[0][0]));
    }
    let used = never_falling(&points);
    let kept: Vec<[f64; 2]> = points.iter().zip(&used).filter(|(_, used)| **used).map(|(point, _)| *point).collect();
    let residuals: Vec<f64> = points.iter().map(|[actual, shown]| shown - actual).collect();
    let counted = || residuals.iter().zip(&used).filter(|(_, used)| **used).map(|(residual, _)| residual * residual);
    let mean = kept.iter().map(|point| point[1]).sum::<f64>() / kept.len() as f64;
    let spread: f64 = kept.iter().map(|point| (point[1] - mean).powi(2)).sum();
    let rest: f64 = counted().sum();
    let range = [kept[0][0], kept[kept.len() - 1][0]];
    let deviation = (rest / kept.len() as f64).sqrt();
    let curve = Curve::Table(kept);
    Ok(CalibrationFit {
        curve,
        errors: Vec::new(),
        points,
        used,
        residuals,
        deviation,
        r_squared: 1.0 - rest / spread,
        range,
    })
}

/// Which readings belong to the most that never fall.
fn never_falling(points: &[[f64; 2]]) -> Vec<bool> {
    let mut longest: Vec<(usize, Option<usize>)> = Vec::new();
    for (at, point) in points.iter().enumerate() {
        let before = (0..at).filter(|&before| points[before][1] <= point[1]).max_by_key(|&before| longest[before].0);
        longest.push((before.map_or(1, |before| longest[before].0 + 1), before));
    }
    let mut used = vec![false; points.len()];
    let mut at = (0..points.len()).max_by_key(|&at| longest[at].0);
    while let Some(own) = at {
        used[own] = true;
        at = longest[own].1;
    }
    used
}
