//! Noise of the recording carried through both steps to the derivatives.

use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::reconstruct::{FilterData, FilterSettings};
use crate::statistics::quantile;

/// `data` with fresh Gaussian noise on every sample, of the deviations the filter takes for its inputs and measurements.
///
/// The same `seed` and `stream` give the same noise; streams of one seed are independent (ChaCha8).
pub fn with_noise(data: &FilterData, settings: &FilterSettings, seed: u64, stream: u64) -> FilterData {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    let mut noisy = data.clone();
    for (column, deviation) in noisy.inputs.columns.iter_mut().zip(settings.process_noise) {
        add_noise(Arc::make_mut(column), deviation, &mut rng);
    }
    for (series, deviation) in noisy.measurements.iter_mut().zip(settings.measurement_noise) {
        add_noise(Arc::make_mut(&mut series.values), deviation, &mut rng);
    }
    noisy
}

fn add_noise(values: &mut [f64], deviation: f64, rng: &mut ChaCha8Rng) {
    for value in values {
        let draw: f64 = StandardNormal.sample(rng);
        *value += deviation * draw;
    }
}

/// What noise of the recording does to one derivative.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseEffect {
    /// Derivative.
    pub derivative: String,
    /// Estimate from the recording as it is.
    pub estimate: f64,
    /// Standard deviation over the realisations: the error that noise of this size causes, regressors and all.
    pub scatter: f64,
    /// Mean over the realisations less the estimate. The recording holds such noise once already and the realisations hold it
    /// twice, so to first order the estimate itself is off by as much.
    pub shift: f64,
    /// Standard error of the shift.
    pub shift_error: f64,
    /// 2.5 and 97.5 % quantile of the realisations less their mean.
    pub quantiles: [f64; 2],
}

impl NoiseEffect {
    /// The estimate with the shift taken off (simulation and extrapolation, linear: Cook and Stefanski, JASA 89, 1994).
    pub fn extrapolated(&self) -> f64 {
        self.estimate - self.shift
    }
}

/// Effects from the estimates of many realisations; each of `realisations` has one entry per entry of `nominal` (name and
/// estimate). Fewer than two realisations give none.
pub fn noise_effects(nominal: &[(String, f64)], realisations: &[Vec<f64>]) -> Vec<NoiseEffect> {
    if realisations.len() < 2 {
        return Vec::new();
    }
    let values = |index: usize| realisations.iter().map(|realisation| realisation[index]).collect();
    let nominal = nominal.iter().enumerate();
    nominal.map(|(index, (name, estimate))| summarise_estimates(name, *estimate, values(index))).collect()
}

fn summarise_estimates(name: &str, estimate: f64, mut values: Vec<f64>) -> NoiseEffect {
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count as f64;
    values.iter_mut().for_each(|value| *value -= mean);
    let square: f64 = values.iter().map(|value| value * value).sum();
    let scatter = (square / (count - 1) as f64).sqrt();
    values.sort_by(f64::total_cmp);
    NoiseEffect {
        derivative: name.to_owned(),
        estimate,
        scatter,
        shift: mean - estimate,
        shift_error: scatter / (count as f64).sqrt(),
        quantiles: [quantile(&values, 0.025), quantile(&values, 0.975)],
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::DMatrix;

    use super::*;
    use crate::estimate::least_squares;
    use crate::reconstruct::{Input, InputSeries, Measurement, MeasurementSeries};

    fn data() -> FilterData {
        let time_s: Arc<[f64]> = (0..4000).map(|k| 0.01 * f64::from(k)).collect();
        let zero = || vec![0.0; time_s.len()];
        let mut measurements: [MeasurementSeries; 12] = Default::default();
        measurements[Measurement::Airspeed as usize] =
            MeasurementSeries { values: zero().into(), time_s: time_s.clone() };
        FilterData { inputs: InputSeries { columns: std::array::from_fn(|_| zero().into()), time_s }, measurements }
    }

    #[test]
    fn noise_has_the_deviations_of_the_filter_and_independent_streams() {
        let settings = FilterSettings::default();
        let (one, same, other) = (
            with_noise(&data(), &settings, 7, 0),
            with_noise(&data(), &settings, 7, 0),
            with_noise(&data(), &settings, 7, 1),
        );
        assert_eq!(one, same);
        let column = |data: &FilterData| data.inputs.columns[Input::PitchRate as usize].clone();
        let deviation = |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
        let q = settings.process_noise[Input::PitchRate as usize];
        let airspeed = &one.measurements[Measurement::Airspeed as usize].values;
        let v = settings.measurement_noise[Measurement::Airspeed as usize];
        // 4000 samples: a deviation is known within 1.1 %, a correlation within 0.016; five times that is never seen.
        approx::assert_relative_eq!(deviation(&column(&one)), q, max_relative = 0.06);
        approx::assert_relative_eq!(deviation(airspeed), v, max_relative = 0.06);
        let product: f64 = column(&one).iter().zip(column(&other).iter()).map(|(a, b)| a * b).sum::<f64>() / 4000.0;
        assert!((product / (q * q)).abs() < 0.08);
        assert!(one.measurements[0].values.is_empty());
    }

    #[test]
    fn extrapolation_undoes_the_pull_of_regressor_noise() {
        // A slope of 2 over a regressor of unit variance with noise of a fifth of it: least squares gives 2 / 1.04.
        const NOISE: f64 = 0.2;
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let truth: Vec<f64> = (0..20_000).map(|_| draw()).collect();
        let recorded: Vec<f64> = truth.iter().map(|x| x + NOISE * draw()).collect();
        let z: Vec<f64> = truth.iter().map(|x| 2.0 * x).collect();
        let slope = |x: &[f64]| {
            let x = DMatrix::from_column_slice(x.len(), 1, x);
            least_squares(&["slope".to_owned()], &x, &z).unwrap().estimates[0]
        };
        let nominal = [("slope".to_owned(), slope(&recorded))];
        let realisations: Vec<Vec<f64>> =
            (0..40).map(|_| vec![slope(&recorded.iter().map(|x| x + NOISE * draw()).collect::<Vec<_>>())]).collect();
        let effect = &noise_effects(&nominal, &realisations)[0];
        approx::assert_relative_eq!(effect.estimate, 2.0 / 1.04, max_relative = 0.004);
        // Second order in the noise remains: 2 (1 - 2/1.04 + 1/1.08) = 0.003, beside a scatter of 0.003 of this sample.
        approx::assert_relative_eq!(effect.extrapolated(), 2.0, max_relative = 0.006);
        assert!((0.5..2.0).contains(&(effect.scatter / 0.0028)), "{}", effect.scatter);
        assert!(effect.quantiles[0] < -effect.scatter && effect.quantiles[1] > effect.scatter);
        assert!(noise_effects(&nominal, &realisations[..1]).is_empty());
    }
}
