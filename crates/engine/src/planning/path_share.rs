//! What path, sensors, clocks and the scatter between manoeuvres add to the errors of a session, and so to those of a design.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::statistics::NORMAL_95;
use doublet_dynamics::design::{CONTROLS, Designed, SURFACE_NAMES};

use super::basis::tells;
use super::designed_errors::designed_errors;
use super::rows::{DesignRow, PredictedRow};
use crate::graph::Control;
use crate::session::Session;
use crate::snapshot::Snapshot;
use crate::stage::{CoefficientFit, PathErrors};

/// Variance of each derivative beyond the noise of its fit, with the manoeuvres it is of.
#[derive(Clone, Debug, Default)]
pub struct PathShare {
    /// By derivative.
    parts: BTreeMap<String, Part>,
    /// Time of all manoeuvres of the session that are used, s.
    time_s: f64,
    /// Errors of path and sensors; none where they could not be formed.
    errors: Option<Arc<PathErrors>>,
    /// The same of the flight as designed; none where they could not be formed.
    designed: Option<Arc<PathErrors>>,
    /// Whether the manoeuvres of the session count beside those of the design.
    with_flown: bool,
}

#[derive(Clone, Debug, PartialEq)]
struct Part {
    /// Variance beyond that of the noise, of the scatter that noise gives between manoeuvres, and of path and sensors.
    variance: f64,
    /// Variance by the choice of the differentiation.
    choice: f64,
    /// Manoeuvres of the fit.
    windows: usize,
    /// Whether a manoeuvre of one control alone excites it.
    excited_by: [bool; CONTROLS],
}

impl PathShare {
    /// That of a session that was run and of a design from it; none where it has no pooled fit. `with_flown` where the manoeuvres of the
    /// session count beside those of the design.
    pub fn measure(
        (session, snapshot): (&Session, &Snapshot),
        designed: &Designed,
        with_flown: bool,
        control: &Control,
    ) -> Option<Self> {
        let pooled = snapshot.pooled.ready()?;
        let errors = pooled.path_errors.clone();
        let parts = pooled.fits.iter().flat_map(|fit| fit_parts(fit, session, errors.as_deref()));
        let times = session.active_windows().map(|window| window.window.end_s - window.window.start_s);
        let designed =
            errors.as_ref().and_then(|_| designed_errors((session, snapshot), designed, with_flown, control));
        Some(Self { parts: parts.collect(), time_s: times.sum(), errors, designed: designed.map(Arc::new), with_flown })
    }

    /// Variance to expect of a derivative beside that of its `noise`: what the errors of the instruments, which remain those of the session, do
    /// in the flight as designed; the larger choice of the differentiation; models that do not fit, which fall with the time flown; the
    /// scatter between manoeuvres by noise, of so many manoeuvres. None of a derivative that was not fitted.
    fn variance(&self, own: &PredictedRow, noise: f64, row: &DesignRow) -> Option<f64> {
        let name = own.name.as_str();
        let part = self.parts.get(name)?;
        let excite = row.manoeuvres.iter().filter(|manoeuvre| match manoeuvre.surfaces.as_slice() {
            [one] => SURFACE_NAMES.iter().zip(part.excited_by).any(|(name, excites)| excites && name == one),
            _ => true,
        });
        let count = excite.count();
        let times = row.manoeuvres.iter().map(|manoeuvre| manoeuvre.duration_s);
        let (windows, time_s) = match self.with_flown {
            true => (count + part.windows, times.sum::<f64>() + self.time_s),
            false => (count, times.sum()),
        };
        let more = time_s / self.time_s;
        let designed = self.designed.as_deref();
        let sensors = self.errors.as_ref().map_or(0.0, |errors| errors.instruments().variance(name, designed, more));
        let choice = designed.map_or(0.0, |designed| designed.variances(name).1).max(part.choice);
        let path = part.variance / more + choice + sensors;
        (windows > 0).then(|| path + noise * noise * (scatter_inflation(windows, own.scatter_share) - 1.0))
    }
}

/// Expected square of a corrected error over that of its noise, if noise alone scatters so many manoeuvres. The corrected error is the larger
/// of that of the noise and of the scatter between manoeuvres, which is multiplied by the ratio `t / 1.96` of the quantiles of 95 % of Student
/// (`windows - 1` degrees of freedom) and normal: `E max(1, (t / 1.96)^2 c X)`, `X` the chi squared over its degrees of freedom and `c` the
/// `share` of the variance that the scatter shows on average. One for fewer than three manoeuvres, whose scatter is not used.
fn scatter_inflation(windows: usize, share: f64) -> f64 {
    const FEWEST: usize = 3;
    if windows < FEWEST {
        return 1.0;
    }
    let freedom = (windows - 1) as f64;
    let ratio = share * (student_quantile(freedom) / NORMAL_95).powi(2);
    // Of the chi squared over its degrees of freedom, not normalised; two of them have a density at zero.
    let density = |x: f64| match x > 0.0 {
        true => (x * (1.0 - x).exp()).powf(0.5 * freedom) / x,
        false if freedom > 2.0 => 0.0,
        false => std::f64::consts::E,
    };
    let end = 4.0 + 80.0 / freedom;
    integral(&|x| density(x) * (ratio * x).max(1.0), end) / integral(&density, end)
}

/// The quantile of 95 % about zero: with `t = sqrt(n) tan(angle)` the density over the angle is `cos(angle)^(n - 1)`.
fn student_quantile(freedom: f64) -> f64 {
    const HALVINGS: usize = 40;
    let density = |angle: f64| angle.cos().max(0.0).powf(freedom - 1.0);
    let all = integral(&density, std::f64::consts::FRAC_PI_2);
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if integral(&density, middle) < 0.95 * all { low = middle } else { high = middle }
    }
    freedom.sqrt() * low.tan()
}

/// Integral from zero to `end` by Simpson's rule.
fn integral(value: &dyn Fn(f64) -> f64, end: f64) -> f64 {
    const HALVES: usize = 2000;
    let step = end / (2 * HALVES) as f64;
    let at = |index: usize| value(step * index as f64);
    let inside: f64 = (1..2 * HALVES).map(|index| if index % 2 == 0 { 2.0 } else { 4.0 } * at(index)).sum();
    (at(0) + inside + at(2 * HALVES)) * step / 3.0
}

fn fit_parts(fit: &CoefficientFit, session: &Session, path: Option<&PathErrors>) -> Vec<(String, Part)> {
    let Ok(found) = &fit.fit else { return Vec::new() };
    let errors = fit.corrected_errors.iter().zip(&fit.noise_errors);
    let excited_by = tells(fit.coefficient, &session.estimation);
    let windows = fit.windows.len();
    let scattered = scatter_inflation(windows, 1.0);
    let part = |(name, (all, noise)): (&String, (&f64, &f64))| {
        let (sensors, choice) = path.map_or((0.0, 0.0), |path| path.variances(name));
        let variance = (all * all - sensors - choice - scattered * noise * noise).max(0.0);
        (name.clone(), Part { variance, choice, windows, excited_by })
    };
    found.names.iter().zip(errors).map(part).collect()
}

impl DesignRow {
    /// Adds the errors of path and sensors of the session it starts from, and the scatter of so many manoeuvres: the promised error.
    pub fn add_path(&mut self, share: &PathShare) {
        let of_row = |own: &PredictedRow| share.variance(own, own.corrected?, self);
        let added: Vec<Option<f64>> = self.predicted.iter().map(of_row).collect();
        for (own, variance) in self.predicted.iter_mut().zip(added) {
            own.path_error = variance.map(f64::sqrt);
            let noise = own.corrected;
            own.promised = noise.map(|noise| (noise * noise + variance.unwrap_or(0.0)).sqrt());
        }
        let instruments = share.errors.as_ref().map(|errors| errors.instruments());
        self.sensor_accuracy = instruments.map(|own| own.accuracy().clone()).unwrap_or_default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::ManoeuvreRow;

    fn predicted(name: &str, corrected: f64) -> PredictedRow {
        PredictedRow {
            name: name.to_owned(),
            estimate: 1.0,
            standard_error: None,
            corrected: Some(corrected),
            relative_error_percent: None,
            corrected_high: None,
            present: 0.0,
            path_error: None,
            promised: None,
            scatter_share: 1.0,
        }
    }

    fn manoeuvre(surface: &'static str, duration_s: f64) -> ManoeuvreRow {
        ManoeuvreRow {
            number: 1,
            name: String::new(),
            surfaces: vec![surface],
            duration_s,
            peak_rad: BTreeMap::new(),
            rate_rad_s: BTreeMap::new(),
            peak_thrust_n: None,
            relative_peak_factor: BTreeMap::new(),
        }
    }

    #[test]
    fn the_share_of_a_model_that_does_not_fit_falls_with_the_time_of_all_manoeuvres() {
        let part = |excited_by| Part { variance: 4.0, choice: 0.0, windows: 8, excited_by };
        let parts = [
            ("Cm_q".to_owned(), part([false, true, false, true])),
            ("Cl_p".to_owned(), part([true, false, true, false])),
        ];
        let share = PathShare { parts: parts.into(), time_s: 100.0, ..PathShare::default() };
        let mut row = DesignRow {
            kind: "doublet",
            time_s: 125.0,
            criterion: "d",
            predicted: vec![predicted("Cm_q", 3.0), predicted("Cl_p", 3.0), predicted("CX_q", 3.0)],
            manoeuvres: vec![manoeuvre("elevator", 25.0), manoeuvre("aileron", 60.0), manoeuvre("rudder", 40.0)],
            ..DesignRow::default()
        };
        row.add_path(&share);
        let promised: Vec<f64> = row.predicted.iter().filter_map(|own| own.promised).collect();
        // 4 * 100 / 125 beside 9, whichever surface excites it; a derivative that was not fitted has its noise alone.
        let expected = (9.0 + 3.2_f64).sqrt();
        assert_eq!(promised, [expected, expected, 3.0]);
        assert_eq!(row.predicted[0].path_error, Some(3.2f64.sqrt()));
        assert_eq!(row.predicted[2].path_error, None);
    }

    #[test]
    fn scatter_of_few_manoeuvres_costs_what_its_distribution_gives() {
        // Abramowitz and Stegun, table 26.10, 0.95.
        for (freedom, expected) in [(2.0, 4.303), (3.0, 3.182), (6.0, 2.447), (30.0, 2.042)] {
            assert!((student_quantile(freedom) - expected).abs() < 6e-4, "{}", student_quantile(freedom));
        }
        // Two degrees of freedom: X is exponential, E max(1, m X) = 1 + m exp(-1 / m).
        let m = (4.302_653_f64 / NORMAL_95).powi(2);
        assert!(
            (scatter_inflation(3, 1.0) / (1.0 + m * (-1.0 / m).exp()) - 1.0).abs() < 1e-4,
            "{}",
            scatter_inflation(3, 1.0)
        );
        // Many manoeuvres: X is normal about one with variance 2 / n, E max(1, X) = 1 + sqrt(2 / n) / sqrt(2 pi).
        let many = 1.0 + (2.0_f64 / 2000.0).sqrt() / std::f64::consts::TAU.sqrt();
        assert!(
            (scatter_inflation(2001, 1.0) / many - 1.0).abs() < 2e-3,
            "{} for {many}",
            scatter_inflation(2001, 1.0)
        );
        assert_eq!(scatter_inflation(2, 1.0), 1.0);
    }
}
