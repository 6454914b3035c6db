//! The estimation over all windows.

use std::ops::Range;

use nalgebra::{DMatrix, SymmetricEigen};

use super::kinematics::Errors;
use super::window::{Gain, Noise, Samples, Values};
use super::{
    ErrorTerm, Freedom, NoiseModel, Sensor, SensorError, SensorErrorFault, SensorErrorSettings, SensorErrorWindow,
};
use crate::estimate::flight_output_error::{corrected_covariance, roots_of_diagonal};
use crate::estimate::{OutputErrorFit, OutputParameter, output_error};
use crate::reconstruct::{FilterSettings, Measurement, Motion, check_samples, initial_state};

/// Standard error of every parameter from one window alone, and the parameter it is hardest to tell from there with their correlation.
type Alone = Vec<(f64, Option<(String, f64)>)>;

/// What one window alone says of an error all windows share.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowShare {
    /// Window.
    pub window: String,
    /// Standard error from this window alone, all else of it free too; infinite where it does not tell the error.
    pub standard_error: f64,
    /// Estimate whose error goes most with this one's there, and their correlation.
    pub partner: Option<(String, f64)>,
}

/// Estimate of one error.
#[derive(Clone, Debug, PartialEq)]
pub struct EstimatedError {
    /// Error.
    pub error: SensorError,
    /// Window it is of, where each has its own.
    pub window: Option<String>,
    /// Estimate, SI.
    pub value: f64,
    /// Standard error for residuals that are white.
    pub standard_error: f64,
    /// Standard error corrected for residuals that are coloured.
    pub corrected_error: f64,
    /// Estimate whose error goes most with this one's, and their correlation.
    pub partner: Option<(String, f64)>,
    /// What each window alone says; empty where each has its own.
    pub windows: Vec<WindowShare>,
}

/// What a measurement is left with.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputResidual {
    /// Measurement.
    pub measurement: Measurement,
    /// Samples compared.
    pub samples: usize,
    /// Root mean square of the residual, of filter error the innovation, SI.
    pub rms: f64,
    /// Root mean square of the innovations in their deviations, which is one where the noise is as stated; not a number for output
    /// error.
    pub normalised: f64,
    /// Coefficient of determination.
    pub r_squared: f64,
}

/// Result of the estimation.
#[derive(Clone, Debug)]
pub struct SensorErrorFit {
    /// The free errors, common ones first.
    pub errors: Vec<EstimatedError>,
    /// Initial states and winds of the windows: name, estimate, standard error, SI.
    pub initial: Vec<(String, f64, f64)>,
    /// Measurements compared.
    pub outputs: Vec<OutputResidual>,
    /// The estimation itself: of output error the outputs, of filter error innovations in their deviations with the sign turned.
    pub fit: OutputErrorFit,
    /// Rows of each window in it.
    pub samples: Vec<Range<usize>>,
}

/// What a parameter is the value of.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Error(SensorError),
    /// Component of the initial motion.
    Initial(usize),
    Wind(usize),
}

/// A parameter.
struct Unknown {
    place: Place,
    /// Window it is of; none for all.
    window: Option<usize>,
    parameter: OutputParameter,
}

/// Passes of filter error at most: gains are those of the path found before.
const PASSES: usize = 6;
/// Movement of the estimates, in their errors, at which the gains are those of the path found.
const SETTLED: f64 = 0.01;

/// Bias, scale factor and misalignment of sensors, constants over windows, by maximum likelihood: the path of each window is integrated
/// from its inertial samples with free initial states, and what the sensors then would show follows the measurements of all windows
/// together (output error on the kinematic equations; Klein and Morelli 2006, chapter 10; Maine and Iliff, NASA RP-1168). With
/// [`NoiseModel::Stated`] the path is that of an extended Kalman filter and its innovations are made least, each in its deviation, with
/// gains held while the estimates move (filter error; Jategaonkar, chapter 5).
///
/// `go_on` is asked before every path.
pub fn sensor_errors(
    windows: &[SensorErrorWindow<'_>],
    settings: &SensorErrorSettings,
    go_on: &dyn Fn() -> bool,
) -> Result<SensorErrorFit, SensorErrorFault> {
    for window in windows {
        let fault = |error| SensorErrorFault::Window { window: window.label.clone(), error };
        check_samples(window.data).map_err(fault)?;
    }
    let problem = Problem::new(windows, settings)?;
    let mut unknowns = problem.unknowns();
    let measured = problem.measured();
    let mut gains = problem.gains(&start(&unknowns))?;
    let mut pass = 0;
    let fit = loop {
        pass += 1;
        let parameters: Vec<OutputParameter> = unknowns.iter().map(|unknown| unknown.parameter.clone()).collect();
        let mut known: Vec<Option<(Vec<f64>, DMatrix<f64>)>> = windows.iter().map(|_| None).collect();
        let found = output_error(&parameters, &measured, &settings.search, |theta| {
            let mut all = DMatrix::zeros(measured.nrows(), measured.ncols());
            for (index, range) in problem.rows.iter().enumerate() {
                let own = own_values(&unknowns, index, theta);
                if !known[index].as_ref().is_some_and(|(before, _)| *before == own) {
                    if !go_on() {
                        return Err(SensorErrorFault::Stopped);
                    }
                    known[index] = Some((own, problem.compared(index, &unknowns, theta, gains.as_deref())));
                }
                if let Some((_, compared)) = &known[index] {
                    all.rows_mut(range.start, range.len()).copy_from(compared);
                }
            }
            Ok(all)
        });
        if !go_on() {
            return Err(SensorErrorFault::Stopped);
        }
        let found = found?;
        let moved = unknowns.iter().zip(&found.estimates).zip(&found.standard_errors);
        let largest = moved.map(|((unknown, value), error)| (value - unknown.parameter.start).abs() / error);
        let settled = largest.fold(0.0, f64::max) < SETTLED;
        if gains.is_none() || settled || pass == PASSES {
            break found;
        }
        unknowns.iter_mut().zip(&found.estimates).for_each(|(unknown, value)| unknown.parameter.start = *value);
        gains = problem.gains(&found.estimates)?;
    };
    problem.result(&unknowns, fit, gains.as_deref(), &measured)
}

fn start(unknowns: &[Unknown]) -> Vec<f64> {
    unknowns.iter().map(|unknown| unknown.parameter.start).collect()
}

/// Values of the parameters a window follows from.
fn own_values(unknowns: &[Unknown], window: usize, theta: &[f64]) -> Vec<f64> {
    let own = unknowns.iter().zip(theta).filter(|(unknown, _)| unknown.window.is_none_or(|of| of == window));
    own.map(|(_, value)| *value).collect()
}

/// Windows with what is free in them.
struct Problem<'a> {
    labels: Vec<&'a str>,
    samples: Vec<Samples>,
    rows: Vec<Range<usize>>,
    starts: Vec<Values>,
    outputs: Vec<Measurement>,
    walks: Vec<(SensorError, f64)>,
    settings: &'a SensorErrorSettings,
}

impl<'a> Problem<'a> {
    fn new(windows: &'a [SensorErrorWindow<'a>], settings: &'a SensorErrorSettings) -> Result<Self, SensorErrorFault> {
        let is_measured = |output: &Measurement| {
            let series = |window: &SensorErrorWindow<'_>| {
                window.data.measurements[*output as usize].values.iter().any(|value| value.is_finite())
            };
            windows.iter().any(series)
        };
        let outputs: Vec<Measurement> =
            Measurement::ALL.into_iter().filter(|m| settings.outputs.contains(m) && is_measured(m)).collect();
        if outputs.is_empty() {
            let outputs = settings.outputs.iter().map(|output| output.name()).collect::<Vec<_>>().join(", ");
            return Err(SensorErrorFault::NoOutput { outputs });
        }
        for &ErrorTerm { error, freedom, random_walk, .. } in &settings.errors {
            if random_walk > 0.0 && settings.noise == NoiseModel::Residuals {
                return Err(SensorErrorFault::RandomWalk { error });
            }
            if let SensorError::Bias(sensor) | SensorError::Scale(sensor) = error
                && let Sensor::Measurement(measurement) = sensor
                && (freedom != Freedom::Fixed || random_walk > 0.0)
                && !outputs.contains(&measurement)
            {
                return Err(SensorErrorFault::NotCompared { error, sensor: sensor.name() });
            }
        }
        let samples: Vec<Samples> = windows.iter().map(|window| Samples::new(window.data, &outputs)).collect();
        let ends = samples.iter().scan(0, |end, samples| {
            let start = *end;
            *end += samples.len();
            Some(start..*end)
        });
        let walks = settings.errors.iter().filter(|term| term.random_walk > 0.0);
        Ok(Self {
            labels: windows.iter().map(|window| window.label.as_str()).collect(),
            rows: ends.collect(),
            starts: windows.iter().map(|window| starting_values(window, settings)).collect(),
            walks: walks.map(|term| (term.error, term.random_walk)).collect(),
            samples,
            outputs,
            settings,
        })
    }

    /// Measured values of all windows; of filter error zero, what the innovations in their deviations are compared with.
    fn measured(&self) -> DMatrix<f64> {
        let total = self.rows.last().map_or(0, |rows| rows.end);
        let mut all = DMatrix::zeros(total, self.outputs.len());
        for (samples, rows) in self.samples.iter().zip(&self.rows) {
            all.rows_mut(rows.start, rows.len()).copy_from(&samples.measured);
        }
        if matches!(self.settings.noise, NoiseModel::Stated { .. }) {
            all.iter_mut().filter(|value| value.is_finite()).for_each(|value| *value = 0.0);
        }
        all
    }

    fn noise(&self) -> Option<Noise<'_>> {
        match &self.settings.noise {
            NoiseModel::Residuals => None,
            NoiseModel::Stated { process, measurement, path } => {
                Some(Noise { process, measurement, path, walks: &self.walks })
            }
        }
    }

    fn gains(&self, theta: &[f64]) -> Result<Option<Vec<Vec<Gain>>>, SensorErrorFault> {
        let Some(noise) = self.noise() else { return Ok(None) };
        let unknowns = self.unknowns();
        let sample_gains = |index: usize| self.samples[index].gains(&self.values(index, &unknowns, theta), &noise);
        Ok(Some((0..self.samples.len()).map(sample_gains).collect::<Result<_, _>>()?))
    }

    /// All parameters: common errors, then window by window its own errors, initial motion and wind.
    fn unknowns(&self) -> Vec<Unknown> {
        let mut all = Vec::new();
        let error = |term: &ErrorTerm, window: Option<usize>| Unknown {
            place: Place::Error(term.error),
            window,
            parameter: self.parameter(term.error.to_string(), window, term.value, term.error.scale()),
        };
        let free = |freedom| self.settings.errors.iter().filter(move |term| term.freedom == freedom);
        all.extend(free(Freedom::Common).map(|term| error(term, None)));
        for (window, samples) in self.samples.iter().enumerate() {
            let is_told = |term: &&ErrorTerm| match term.error {
                SensorError::Bias(Sensor::Measurement(m)) | SensorError::Scale(Sensor::Measurement(m)) => {
                    samples.has(&[m])
                }
                _ => true,
            };
            all.extend(free(Freedom::PerWindow).filter(is_told).map(|term| error(term, Some(window))));
            let motion = self.starts[window].motion;
            for (place, name, scale) in free_motion(samples) {
                let value = [motion.pos, motion.vel, motion.att][place / 3][place % 3];
                let parameter = self.parameter(format!("{name} start"), Some(window), value, scale);
                all.push(Unknown { place: Place::Initial(place), window: Some(window), parameter });
            }
            if self.settings.wind {
                for (place, name) in free_wind(samples) {
                    let parameter = self.parameter(name.to_owned(), Some(window), 0.0, 0.1);
                    all.push(Unknown { place: Place::Wind(place), window: Some(window), parameter });
                }
            }
        }
        all
    }

    fn parameter(&self, name: String, window: Option<usize>, start: f64, scale: f64) -> OutputParameter {
        let name = window.map_or(name.clone(), |window| format!("{name}[{}]", self.labels[window]));
        OutputParameter { name, start, scale, bounds: (f64::NEG_INFINITY, f64::INFINITY) }
    }

    /// What window `index` follows from.
    fn values(&self, index: usize, unknowns: &[Unknown], theta: &[f64]) -> Values {
        let mut values = self.starts[index].clone();
        for (unknown, value) in unknowns.iter().zip(theta) {
            if unknown.window.is_some_and(|window| window != index) {
                continue;
            }
            match unknown.place {
                Place::Error(error) => *values.errors.value_mut(error) = *value,
                Place::Wind(axis) => values.wind[axis] = *value,
                Place::Initial(place) => {
                    let Motion { pos, vel, att } = &mut values.motion;
                    [pos, vel, att][place / 3][place % 3] = *value;
                }
            }
        }
        values
    }

    /// What is compared with [`Problem::measured`].
    fn compared(&self, index: usize, unknowns: &[Unknown], theta: &[f64], gains: Option<&[Vec<Gain>]>) -> DMatrix<f64> {
        let values = self.values(index, unknowns, theta);
        let noise = self.noise();
        let Some((gains, noise)) = gains.zip(noise.as_ref()) else {
            return self.samples[index].follow(&values, None).outputs;
        };
        // Rows without a measurement are not compared, but must be numbers.
        let normalised = self.samples[index].follow(&values, Some((&gains[index], noise))).normalised;
        let measured = &self.samples[index].measured;
        normalised.zip_map(measured, |value, measured| if measured.is_finite() { -value } else { 0.0 })
    }

    fn result(
        &self,
        unknowns: &[Unknown],
        fit: OutputErrorFit,
        gains: Option<&[Vec<Gain>]>,
        measured: &DMatrix<f64>,
    ) -> Result<SensorErrorFit, SensorErrorFault> {
        let corrected = roots_of_diagonal(&corrected_covariance(&fit, measured, &self.rows)?);
        let shares: Vec<Alone> = (0..self.samples.len()).map(|window| self.alone(window, unknowns, &fit)).collect();
        let mut errors = Vec::new();
        let mut initial = Vec::new();
        for (k, unknown) in unknowns.iter().enumerate() {
            let Place::Error(error) = unknown.place else {
                initial.push((fit.names[k].clone(), fit.estimates[k], fit.standard_errors[k]));
                continue;
            };
            let share = |(window, shares): (usize, &Alone)| {
                let (standard_error, partner) = shares[k].clone();
                WindowShare { window: self.labels[window].to_owned(), standard_error, partner }
            };
            let of_windows = if unknown.window.is_none() { shares.as_slice() } else { &[] };
            errors.push(EstimatedError {
                error,
                window: unknown.window.map(|window| self.labels[window].to_owned()),
                value: fit.estimates[k],
                standard_error: fit.standard_errors[k],
                corrected_error: corrected[k],
                partner: strongest(&fit.names, fit.correlation.column(k).iter().copied().enumerate(), k),
                windows: of_windows.iter().enumerate().map(share).collect(),
            });
        }
        let outputs = self.residuals(unknowns, &fit, gains);
        Ok(SensorErrorFit { errors, initial, outputs, fit, samples: self.rows.clone() })
    }

    /// Standard error of every parameter from one window alone, and its partner there; infinite for what the window does not tell.
    fn alone(&self, window: usize, unknowns: &[Unknown], fit: &OutputErrorFit) -> Alone {
        /// Eigenvalue of the scaled information below which a direction is not told, and the share in it that names a parameter.
        const UNSEEN: (f64, f64) = (1e-9, 1e-3);
        let mut all = vec![(f64::INFINITY, None); unknowns.len()];
        let rows = &self.rows[window];
        let mut information = DMatrix::<f64>::zeros(unknowns.len(), unknowns.len());
        let measured = &self.samples[window].measured;
        for (output, noise) in fit.noise.iter().enumerate() {
            let weights = measured.column(output).map(|value| if value.is_finite() { noise.powi(-2) } else { 0.0 });
            let columns: Vec<_> =
                fit.sensitivities.iter().map(|s| s.view((rows.start, output), (rows.len(), 1))).collect();
            for (i, first) in columns.iter().enumerate() {
                let weighted = first.component_mul(&weights);
                for (j, second) in columns.iter().enumerate().take(i + 1) {
                    information[(i, j)] += weighted.dot(second);
                }
            }
        }
        let own: Vec<usize> = (0..unknowns.len()).filter(|&k| information[(k, k)] > 0.0).collect();
        let scale: Vec<f64> = own.iter().map(|&k| information[(k, k)].sqrt().recip()).collect();
        let scaled = DMatrix::from_fn(own.len(), own.len(), |i, j| {
            let (row, column) = (own[i].max(own[j]), own[i].min(own[j]));
            information[(row, column)] * scale[i] * scale[j]
        });
        let eigen = SymmetricEigen::new(scaled);
        let is_seen = |k: usize| eigen.eigenvalues[k] > UNSEEN.0;
        let covariance = DMatrix::from_fn(own.len(), own.len(), |i, j| {
            let terms = (0..own.len()).filter(|&k| is_seen(k));
            let v = &eigen.eigenvectors;
            terms.map(|k| v[(i, k)] * v[(j, k)] / eigen.eigenvalues[k]).sum::<f64>() * scale[i] * scale[j]
        });
        for (i, &k) in own.iter().enumerate() {
            let unseen: f64 = (0..own.len()).filter(|&j| !is_seen(j)).map(|j| eigen.eigenvectors[(i, j)].powi(2)).sum();
            if unseen > UNSEEN.1 {
                continue;
            }
            let deviation = |j: usize| covariance[(j, j)].sqrt();
            let correlations = (0..own.len()).map(|j| (own[j], covariance[(i, j)] / (deviation(i) * deviation(j))));
            all[k] = (deviation(i), strongest(&fit.names, correlations, k));
        }
        all
    }

    /// Residuals of every output.
    fn residuals(
        &self,
        unknowns: &[Unknown],
        fit: &OutputErrorFit,
        gains: Option<&[Vec<Gain>]>,
    ) -> Vec<OutputResidual> {
        let noise = self.noise();
        let shown: Vec<DMatrix<f64>> = (0..self.samples.len())
            .map(|index| {
                let values = self.values(index, unknowns, &fit.estimates);
                let gains = gains.zip(noise.as_ref()).map(|(gains, noise)| (gains[index].as_slice(), noise));
                self.samples[index].follow(&values, gains).outputs
            })
            .collect();
        let one = |(column, &measurement): (usize, &Measurement)| {
            let pairs = self.samples.iter().zip(&shown).flat_map(|(samples, shown)| {
                let (z, y) = (samples.measured.column(column), shown.column(column));
                let pairs: Vec<(f64, f64)> = z.iter().copied().zip(y.iter().copied()).collect();
                pairs.into_iter().filter(|(z, _)| z.is_finite())
            });
            let (z, y): (Vec<f64>, Vec<f64>) = pairs.unzip();
            let quality = super::super::FitQuality::compare(&z, &y);
            OutputResidual {
                measurement,
                samples: z.len(),
                rms: quality.rms,
                normalised: if noise.is_some() { fit.noise[column] } else { f64::NAN },
                r_squared: quality.r_squared,
            }
        };
        self.outputs.iter().enumerate().map(one).collect()
    }
}

/// The parameter other than `own` with the strongest correlation.
fn strongest(names: &[String], correlations: impl Iterator<Item = (usize, f64)>, own: usize) -> Option<(String, f64)> {
    let others = correlations.filter(|(k, value)| *k != own && value.is_finite());
    let (k, value) = others.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    Some((names[k].clone(), value))
}

/// Where a window starts: known errors as stated, motion from the first measurements.
fn starting_values(window: &SensorErrorWindow<'_>, settings: &SensorErrorSettings) -> Values {
    let x = initial_state(window.data, &FilterSettings::default(), &mut Vec::new());
    let mut errors = Errors::none();
    for term in &settings.errors {
        *errors.value_mut(term.error) = term.value;
    }
    let triple = |first: usize| [x[first], x[first + 1], x[first + 2]];
    let motion = Motion { pos: triple(0), vel: triple(3), att: triple(6) };
    Values { motion, wind: [0.0; 3], errors, gravity: settings.gravity_m_s2 }
}

/// Components of the initial motion that what is measured can tell, with names and smallest changes that matter: those of the symmetric
/// motion, of the asymmetric motion, the heading, the position.
fn free_motion(samples: &Samples) -> Vec<(usize, &'static str, f64)> {
    use Measurement::{
        Airspeed, AngleOfAttack, BankAngle, HeadingAngle, PitchAngle, PositionDown, PositionEast, PositionNorth,
        Sideslip, VelocityDown, VelocityEast, VelocityNorth,
    };
    let horizontal = [VelocityNorth, VelocityEast, PositionNorth, PositionEast];
    let symmetric =
        samples.has(&[Airspeed, AngleOfAttack, PitchAngle, VelocityDown, PositionDown]) || samples.has(&horizontal);
    let asymmetric = samples.has(&[Sideslip, BankAngle, HeadingAngle]) || samples.has(&horizontal);
    let heading = samples.has(&[HeadingAngle]) || samples.has(&horizontal);
    let all = [
        (samples.has(&[PositionNorth]), 0, "x", 1.0),
        (samples.has(&[PositionEast]), 1, "y", 1.0),
        (samples.has(&[PositionDown]), 2, "z", 1.0),
        (symmetric, 3, "u", 0.1),
        (asymmetric, 4, "v", 0.1),
        (symmetric, 5, "w", 0.1),
        (asymmetric, 6, "phi", 1e-3),
        (symmetric, 7, "theta", 1e-3),
        (heading, 8, "psi", 1e-3),
    ];
    all.into_iter().filter(|(free, ..)| *free).map(|(_, place, name, scale)| (place, name, scale)).collect()
}

/// Components of the wind that what is measured can tell, with names.
fn free_wind(samples: &Samples) -> Vec<(usize, &'static str)> {
    use Measurement::{PositionDown, PositionEast, PositionNorth, VelocityDown, VelocityEast, VelocityNorth};
    let level = samples.has(&[VelocityNorth, VelocityEast, PositionNorth, PositionEast]);
    let down = samples.has(&[VelocityDown, PositionDown]);
    let all = [(level, 0, "wind_north"), (level, 1, "wind_east"), (down, 2, "wind_down")];
    all.into_iter().filter(|(free, ..)| *free).map(|(_, axis, name)| (axis, name)).collect()
}
