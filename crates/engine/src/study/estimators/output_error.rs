//! Output error over one window: the flight of the estimated derivatives, and whether it follows the recorded one.

use std::f64::consts::TAU;
use std::sync::Arc;

use doublet_core::estimate::{
    FlightFitError, FlightFreedom, FlightOutput, FlightOutputFit, FlightWindow, InitialState, OutputErrorSettings,
    Unexplained, disturbance_covariance, flight_output_error,
};
use doublet_core::message;
use doublet_core::message::written;
use doublet_core::model::{Coefficient, CoefficientSettings, Derivatives, Term, Variable, VariableValues};
use doublet_core::reconstruct::{Measurement, State};
use doublet_core::replay::{Motion, MotionAxis};
use doublet_core::series::{Series, value_at};
use doublet_core::statistics::median_step;
use nalgebra::DMatrix;

use super::{CheckedDerivative, MethodEstimates, PartEstimates, WindowEstimation};
use crate::graph::{Context, StageResult};
use crate::notation::significant;
use crate::session::{Finding, Level, PathSource, Place};
use crate::stage::{self, StudyWindow, WindowAero, WindowFlight};
use crate::study::StudyInput;

/// Coefficient of determination of an output below which a flight follows it poorly, and below which it does not.
const POORLY: f64 = 0.7;
const NOT: f64 = 0.3;
/// Residual, in deviations of what is compared with, up to which an output is followed whatever its coefficient of
/// determination: it hardly moves.
const WITHIN: f64 = 3.0;
/// Distance of a start from the path, in joint deviations, beyond which the flight is another one.
const AWAY: f64 = 5.0;

/// One output of the followed flight.
#[derive(Clone, Debug)]
pub struct FollowedOutput {
    pub output: FlightOutput,
    /// As reconstructed.
    pub measured: Series,
    /// As flown by the estimated derivatives, recorded bias included.
    pub flown: Series,
    /// Coefficient of determination.
    pub r_squared: f64,
    /// Largest magnitude of the difference, SI.
    pub largest_deviation: f64,
    /// Root mean square of the difference, SI.
    pub rms: f64,
    /// Standard deviation of what it is compared with, SI: of the path for velocity and attitude, of a sample for rates and
    /// forces.
    pub deviation: f64,
}

impl FollowedOutput {
    /// Coefficient of determination that an output reaches which is followed.
    pub const LEAST_R_SQUARED: f64 = POORLY;

    /// How far the flight departs from the output, with the limit of its coefficient of determination; none where it follows.
    pub fn departure(&self) -> Option<(Level, f64)> {
        match self.r_squared {
            _ if self.rms <= WITHIN * self.deviation => None,
            r_squared if r_squared < NOT => Some((Level::Bad, NOT)),
            r_squared if r_squared < POORLY => Some((Level::Caution, POORLY)),
            _ => None,
        }
    }
}

/// One state the followed flight starts from, beside the path.
#[derive(Clone, Copy, Debug)]
pub struct FollowedStart {
    pub state: InitialState,
    /// Estimate, SI.
    pub estimate: f64,
    /// Of the path, SI.
    pub path: f64,
    /// Difference in joint deviations of both.
    pub distance: f64,
}

/// The flight of the estimates over one window.
#[derive(Clone, Debug)]
pub struct FollowedFlight {
    pub axis: MotionAxis,
    pub outputs: Vec<FollowedOutput>,
    /// Initial states against the path.
    pub starts: Vec<FollowedStart>,
    /// Steps it took.
    pub iterations: usize,
}

impl FollowedFlight {
    /// Outputs it does not follow and starts away from the path (`follows`): its derivatives are then those of another flight.
    pub fn findings(&self, window: &str) -> Vec<Finding> {
        let place = Place::in_manoeuvre(window, format!("output error ({})", self.axis.name()));
        let fix_text = "Do not use these derivatives: add a term or shorten the manoeuvre.";
        let mut found = Vec::new();
        for output in &self.outputs {
            let Some((level, limit)) = output.departure() else { continue };
            let (name, unit) = (output.output.name(), output.output.unit());
            let largest = written(output.largest_deviation, significant(output.largest_deviation, 3));
            let text = message!(
                "The simulation does not follow {}: R2 {:.2}, largest error {} {}.",
                name,
                output.r_squared,
                largest,
                unit
            );
            found.push(
                Finding::new(level, "follows", &place, text)
                    .with_figure(output.r_squared, limit)
                    .with_fix_text(fix_text)
                    .with_setting("Studies", ""),
            );
        }
        for start in self.starts.iter().filter(|start| start.distance.abs() > AWAY) {
            let text = format!(
                "{} {:.5} {} differs from the path, {:.5}, by {:.0} standard errors.",
                start.state.name(),
                start.estimate,
                start.state.unit(),
                start.path,
                start.distance.abs()
            );
            let finding = Finding::new(Level::Bad, "follows", &place, text);
            let finding = finding.with_figure(start.distance.abs(), AWAY).with_fix_text(fix_text);
            found.push(finding.with_setting("Studies", ""));
        }
        found
    }
}

/// Every motion of the manoeuvre.
pub(super) fn estimate(estimation: &WindowEstimation<'_>) -> Vec<PartEstimates> {
    estimation.by_motion(OutputErrorFlight::estimates)
}

/// Output error of one motion over one window, with what it was compared with. Derivatives of the motion that the window's own fit contains
/// are free, the others keep their pooled values; the other axis moves as reconstructed.
pub(super) struct OutputErrorFlight<'a> {
    pub(super) axis: MotionAxis,
    pub(super) freedom: FlightFreedom,
    pub(super) found: FlightOutputFit,
    pub(super) context: &'a Context<'a>,
    input: &'a StudyInput<'a>,
    window: &'a StudyWindow<'a>,
    ready: WindowFlight,
    model: Derivatives,
    measured: Vec<Vec<f64>>,
}

/// An error of a fit in words.
pub(super) fn line_of(error: FlightFitError) -> String {
    match error {
        FlightFitError::Stopped => "stopped".to_owned(),
        error => error.to_string(),
    }
}

impl<'a> OutputErrorFlight<'a> {
    /// Output error over `window`.
    pub(super) fn fit(
        input: &'a StudyInput<'a>,
        window: &'a StudyWindow<'a>,
        axis: MotionAxis,
        context: &'a Context<'a>,
    ) -> StageResult<Self> {
        let settings = input.settings;
        let (aero, path) = (&window.aero, &window.path.reconstruction);
        let ready = stage::window_flight(path, aero, settings.preparation, settings.filter.gravity_m_s2)?;
        let (model, shared) = model(input, window, axis);
        if shared.is_empty() {
            return Err("the manoeuvre has no fit of this axis to start from".into());
        }
        let measured = measurements(axis, aero, &ready.motion);
        let freedom = FlightFreedom { shared, own: Vec::new(), biases: axis.biased() };
        let go_on = || !context.control().is_cancelled();
        let windows = [flight_window(window, &ready, model.clone(), measured.clone())];
        let found = flight_output_error(axis, &windows, &freedom, &OutputErrorSettings::default(), &go_on);
        let found = found.map_err(line_of)?;
        Ok(Self { axis, freedom, found, context, input, window, ready, model, measured })
    }

    /// The window with these recorded outputs.
    pub(super) fn flight_window(&self, measured: Vec<Vec<f64>>) -> FlightWindow<'_> {
        flight_window(self.window, &self.ready, self.model.clone(), measured)
    }

    /// The estimates, their errors with what the model leaves unexplained.
    fn estimates(&self) -> StageResult<MethodEstimates> {
        let windows = [self.flight_window(self.measured.clone())];
        let go_on = || !self.context.control().is_cancelled();
        let unexplained = [self.unexplained()?];
        let disturbed = disturbance_covariance(self.axis, (&windows, &self.freedom), &self.found, &unexplained, &go_on);
        let disturbed = disturbed.map_err(line_of)?;
        let mut found = self.found.clone();
        for (index, error) in found.corrected_errors.iter_mut().enumerate() {
            *error = error.hypot(disturbed[(index, index)].max(0.0).sqrt());
        }
        found.corrected_covariance += disturbed;
        let mut derivatives: Vec<_> = checked(&found).collect();
        let others = derivatives.split_off(self.freedom.shared.len());
        let covariance = first(&found.corrected_covariance, derivatives.len());
        let flight = Some(self.flight(&others));
        Ok(MethodEstimates { derivatives, covariance, others, flight })
    }

    /// The outputs with airspeed, flow angles and attitude as recorded in place of those of the path, whose errors are not white: each sample at
    /// the nearest instant, moved by the path between the two, less the mean difference from the path. Outputs without a sensor stay those of
    /// the path.
    pub(super) fn recorded(&self) -> Vec<Vec<f64>> {
        self.axis
            .outputs()
            .iter()
            .zip(&self.measured)
            .map(|(&output, column)| self.move_to_recorded(output, column))
            .collect()
    }

    fn move_to_recorded(&self, output: FlightOutput, column: &[f64]) -> Vec<f64> {
        let (time_s, path) = (&*self.window.aero.data.time_s, &self.window.path);
        let Some((series, delay_s)) = sensor(output).and_then(|measurement| path.recorded(measurement)) else {
            return column.to_vec();
        };
        let step_s = median_step(time_s).unwrap_or(f64::NAN);
        let mut differences: Vec<Option<f64>> = vec![None; time_s.len()];
        for (&stamp_s, &value) in series.time_s.iter().zip(series.values.iter()) {
            let Some(path) = value_at(time_s, column, f64::INFINITY, stamp_s - delay_s) else { continue };
            let turns = if output.unit() == "rad" { ((value - path) / TAU).round() } else { 0.0 };
            let after = time_s.partition_point(|&time| time < stamp_s - delay_s - 0.5 * step_s);
            if let Some(difference) = differences.get_mut(after) {
                *difference = Some(value - path - TAU * turns).filter(|difference| difference.is_finite());
            }
        }
        let known: Vec<f64> = differences.iter().copied().flatten().collect();
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        let moved = |(path, difference): (&f64, Option<f64>)| difference.map_or(f64::NAN, |own| path + own - mean);
        column.iter().zip(differences).map(moved).collect()
    }

    /// Smallest deviation that the noise of an output can have: that of the path where no sensor records it.
    pub(super) fn least_noise(&self, output: FlightOutput) -> f64 {
        match sensor(output) {
            Some(measurement) if self.window.path.recorded(measurement).is_none() => self.deviation(output),
            _ => 0.0,
        }
    }

    /// What the estimated derivatives leave of the coefficients along the path, every sample as it is, without its mean, which is
    /// a constant's; nothing in excluded stretches.
    fn unexplained(&self) -> StageResult<Vec<Unexplained>> {
        let own = &self.window.aero;
        let settings = CoefficientSettings { matched: false, excluded: Vec::new(), ..own.settings.clone() };
        let left = own.left();
        let aero = WindowAero::form(own.data.clone(), settings, own.air_density)?;
        let mut model = self.model.clone();
        self.freedom.shared.iter().zip(&self.found.fit.estimates).for_each(|(&entry, &value)| model.set(entry, value));
        let modelled: Vec<[f64; 6]> = values_along(&aero).iter().map(|v| model.body_coefficients(v)).collect();
        let moves = Coefficient::ALL[..6].iter().copied().filter(|&coefficient| self.axis.has(coefficient));
        let rest = |coefficient: Coefficient| {
            let observed = aero.coefficients.get(coefficient).iter();
            let rest: Vec<f64> = observed.zip(&modelled).map(|(z, y)| z - y[coefficient as usize]).collect();
            (coefficient, Self::subtract_mean(rest, left.as_deref()))
        };
        Ok(moves.map(rest).collect())
    }

    /// Without the mean of all samples, or of those left, the others then zero.
    fn subtract_mean(values: Vec<f64>, left: Option<&[usize]>) -> Vec<f64> {
        let Some(left) = left else {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            return values.into_iter().map(|value| value - mean).collect();
        };
        let mean = left.iter().map(|&sample| values[sample]).sum::<f64>() / left.len() as f64;
        let mut compared = vec![0.0; values.len()];
        left.iter().for_each(|&sample| compared[sample] = values[sample] - mean);
        compared
    }

    /// Standard deviation of a state of the path where the flight begins.
    fn path_deviation(&self, state: State) -> f64 {
        let path = &self.window.path.reconstruction;
        let deviations = match (self.input.settings.preparation.path, &path.smoothed) {
            (PathSource::Smoothed, Some(smoothed)) => &smoothed.deviations,
            _ => &path.deviations,
        };
        deviations[state as usize].get(self.ready.first).unwrap_or(0.0)
    }

    /// Standard deviation of what an output is compared with.
    fn deviation(&self, output: FlightOutput) -> f64 {
        let airspeed = self.window.aero.data.airspeed_m_s.first().copied().unwrap_or(f64::INFINITY);
        let sample = |input: usize| self.input.settings.filter.process_noise[input];
        match output {
            FlightOutput::Airspeed => self.path_deviation(State::VelocityU),
            FlightOutput::Alpha => self.path_deviation(State::VelocityW) / airspeed,
            FlightOutput::Beta => self.path_deviation(State::VelocityV) / airspeed,
            FlightOutput::RollRate => sample(3),
            FlightOutput::PitchRate => sample(4),
            FlightOutput::YawRate => sample(5),
            FlightOutput::BankAngle => self.path_deviation(State::BankAngle),
            FlightOutput::PitchAngle => self.path_deviation(State::PitchAngle),
            FlightOutput::SpecificForceX => sample(0),
            FlightOutput::SpecificForceY => sample(1),
            FlightOutput::SpecificForceZ => sample(2),
        }
    }

    /// Value and standard deviation of an initial state on the path; a rate is that of one sample.
    fn start(&self, state: InitialState) -> (f64, f64) {
        let start = &self.ready.start;
        match state {
            InitialState::Velocity(axis) => {
                let states = [State::VelocityU, State::VelocityV, State::VelocityW];
                (start.air_velocity_body_m_s[axis], self.path_deviation(states[axis]))
            }
            InitialState::Rate(axis) => (start.rates_rad_s[axis], self.input.settings.filter.process_noise[3 + axis]),
            InitialState::Euler(axis) => {
                let states = [State::BankAngle, State::PitchAngle, State::HeadingAngle];
                (start.euler_rad[axis], self.path_deviation(states[axis]))
            }
        }
    }

    /// The flight beside the recording; `others` begin with its initial states.
    fn flight(&self, others: &[CheckedDerivative]) -> FollowedFlight {
        let fit = &self.found.fit;
        let starts = self.axis.initial().iter().zip(others).map(|(&state, found)| {
            let (path, deviation) = self.start(state);
            let distance = (found.estimate - path) / deviation.hypot(found.standard_error);
            FollowedStart { state, estimate: found.estimate, path, distance }
        });
        let time_s: Arc<[f64]> = Arc::clone(&self.window.aero.data.time_s);
        let series = |values: Arc<[f64]>| Series { time_s: Arc::clone(&time_s), values };
        let outputs = self.axis.outputs().iter().enumerate().map(|(index, &output)| {
            let flown = fit.outputs.column(index);
            let differences = self.measured[index].iter().zip(flown.iter()).map(|(z, y)| (z - y).abs());
            FollowedOutput {
                output,
                measured: series(self.measured[index].as_slice().into()),
                flown: series(flown.iter().copied().collect()),
                r_squared: fit.quality[index].r_squared,
                largest_deviation: differences.fold(0.0, f64::max),
                rms: fit.noise[index],
                deviation: self.deviation(output),
            }
        });
        let (outputs, starts) = (outputs.collect(), starts.collect());
        FollowedFlight { axis: self.axis, outputs, starts, iterations: fit.cost.len() - 1 }
    }
}

/// A window made ready to be flown by `model` beside the outputs `measured`.
fn flight_window<'f>(
    window: &StudyWindow<'_>,
    ready: &'f WindowFlight,
    model: Derivatives,
    measured: Vec<Vec<f64>>,
) -> FlightWindow<'f> {
    let data = &window.aero.data;
    FlightWindow {
        label: window.manoeuvre.name.clone(),
        replay: &ready.replay,
        start: ready.start,
        motion: &ready.motion,
        model,
        measured,
        accelerometer_from_cg_m: data.accelerometer.map(|place| {
            (0..data.time_s.len()).map(|k| place.body_from_cg_m(data.mass.at(k).cg_from_datum_m)).collect()
        }),
    }
}

/// Recorded outputs of the axis, a column each, not a number in excluded stretches; specific forces where the accelerometers are.
fn measurements(axis: MotionAxis, aero: &WindowAero, motion: &Motion) -> Vec<Vec<f64>> {
    let compared = |output: &FlightOutput| match aero.left() {
        None => recorded_column(*output, aero, motion).to_vec(),
        Some(left) => {
            let mut values = vec![f64::NAN; aero.data.time_s.len()];
            left.iter().for_each(|&sample| values[sample] = recorded_column(*output, aero, motion)[sample]);
            values
        }
    };
    axis.outputs().iter().map(compared).collect()
}

fn recorded_column<'a>(output: FlightOutput, aero: &'a WindowAero, motion: &'a Motion) -> &'a [f64] {
    let data = &aero.data;
    match output {
        FlightOutput::Airspeed => &data.airspeed_m_s,
        FlightOutput::Alpha => &data.alpha_rad,
        FlightOutput::Beta => &data.beta_rad,
        FlightOutput::RollRate => &motion.rates_rad_s[0],
        FlightOutput::PitchRate => &motion.rates_rad_s[1],
        FlightOutput::YawRate => &motion.rates_rad_s[2],
        FlightOutput::BankAngle => &motion.euler_rad[0],
        FlightOutput::PitchAngle => &motion.euler_rad[1],
        FlightOutput::SpecificForceX => &data.specific_force_m_s2[0],
        FlightOutput::SpecificForceY => &data.specific_force_m_s2[1],
        FlightOutput::SpecificForceZ => &data.specific_force_m_s2[2],
    }
}

/// The measurement that records an output; inertial samples record the others.
fn sensor(output: FlightOutput) -> Option<Measurement> {
    match output {
        FlightOutput::Airspeed => Some(Measurement::Airspeed),
        FlightOutput::Alpha => Some(Measurement::AngleOfAttack),
        FlightOutput::Beta => Some(Measurement::Sideslip),
        FlightOutput::BankAngle => Some(Measurement::BankAngle),
        FlightOutput::PitchAngle => Some(Measurement::PitchAngle),
        _ => None,
    }
}

/// Every estimate with its corrected error.
pub(super) fn checked(found: &FlightOutputFit) -> impl Iterator<Item = CheckedDerivative> + '_ {
    let rows = found.fit.names.iter().zip(&found.fit.estimates).zip(&found.corrected_errors);
    rows.map(|((name, &estimate), &standard_error)| CheckedDerivative { name: name.clone(), estimate, standard_error })
}

/// Covariance of the first `count` estimates.
pub(super) fn first(covariance: &DMatrix<f64>, count: usize) -> DMatrix<f64> {
    covariance.view((0, 0), (count, count)).into_owned()
}

/// The pooled model of `axis` with constants of this window, and its entries that the window's own fit has.
fn model(input: &StudyInput<'_>, window: &StudyWindow<'_>, axis: MotionAxis) -> (Derivatives, Vec<usize>) {
    let mut entries: Vec<(Coefficient, Term, f64)> = Vec::new();
    let mut free = Vec::new();
    for (coefficient, terms) in input.settings.structure.models.iter().filter(|(coefficient, _)| axis.has(*coefficient))
    {
        let own = window.fits.fits.iter().find(|fit| fit.coefficient == *coefficient);
        let own = own.and_then(|fit| fit.fit.as_ref().ok());
        let pooled = input.pooled.fits.iter().find(|fit| fit.coefficient == *coefficient);
        let pooled = pooled.and_then(|fit| fit.fit.as_ref().ok());
        for term in terms.iter().filter(|term| !term.is_constant()) {
            let name = term.derivative_name(*coefficient);
            let value =
                pooled.and_then(|fit| fit.parameter(&name)).or_else(|| own.and_then(|fit| fit.parameter(&name)));
            let is_fitted = own.is_some_and(|fit| fit.parameter(&name).is_some());
            if is_fitted {
                free.push(entries.len());
            }
            entries.push((*coefficient, term.clone(), value.map_or(0.0, |(value, _)| value)));
        }
        // The constant that goes with the pooled derivatives here: without it the flight would not be in trim.
        if terms.iter().any(Term::is_constant) {
            if own.is_some() {
                free.push(entries.len());
            }
            entries.push((*coefficient, Term::constant(), 0.0));
            let value = mean_offset(window, *coefficient, &entries);
            if let Some(entry) = entries.last_mut() {
                entry.2 = value;
            }
        }
    }
    (entries.into_iter().collect(), free)
}

/// Mean of the observed coefficient less what the entries of it give.
fn mean_offset(window: &StudyWindow<'_>, coefficient: Coefficient, entries: &[(Coefficient, Term, f64)]) -> f64 {
    let model: Derivatives = entries.iter().filter(|(other, ..)| *other == coefficient).cloned().collect();
    let aero = &window.aero;
    let observed = aero.coefficients.get(coefficient);
    let modelled = values_along(aero);
    let rest = observed.iter().zip(&modelled).map(|(value, v)| value - model.sums(v)[coefficient as usize]);
    rest.sum::<f64>() / observed.len() as f64
}

/// Variables of every sample of a window.
fn values_along(aero: &WindowAero) -> Vec<VariableValues> {
    let known: Vec<_> = aero.variables.known().filter_map(|v| Some((v, aero.variables.get(v)?))).collect();
    let at = |k: usize| {
        let mut values: VariableValues = [0.0; Variable::ALL.len()];
        known.iter().for_each(|(variable, column)| values[*variable as usize] = column[k]);
        values
    };
    (0..aero.coefficients.time_s.len()).map(at).collect()
}
