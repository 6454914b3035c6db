//! Output error with the equations of motion: derivatives of a flight that follows the recorded one.

use std::ops::Range;

use nalgebra::DMatrix;
use thiserror::Error;

use super::covariance::Unit;
use super::output_covariance::{Output, OutputWindow, covariance_of_outputs};
use super::{EstimateError, OutputErrorFit, OutputErrorSettings, OutputParameter, output_error};
use crate::model::Derivatives;
use crate::prep::accelerometer_at;
use crate::replay::{Motion, MotionAxis, Replay, ReplayError, Response, Start};

/// An output of the flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlightOutput {
    /// True airspeed, m/s.
    Airspeed,
    /// Angle of attack, rad.
    Alpha,
    /// Sideslip, rad.
    Beta,
    /// Roll rate, rad/s.
    RollRate,
    /// Pitch rate, rad/s.
    PitchRate,
    /// Yaw rate, rad/s.
    YawRate,
    /// Bank angle, rad.
    BankAngle,
    /// Pitch angle, rad.
    PitchAngle,
    /// Specific force along body x, m/s².
    SpecificForceX,
    /// Specific force along body y, m/s².
    SpecificForceY,
    /// Specific force along body z, m/s².
    SpecificForceZ,
}

impl FlightOutput {
    crate::variant_texts! {
        /// Name in tables.
        pub name:
            Airspeed "V", Alpha "alpha", Beta "beta", RollRate "p", PitchRate "q", YawRate "r", BankAngle "phi",
            PitchAngle "theta", SpecificForceX "ax", SpecificForceY "ay", SpecificForceZ "az",
    }

    /// Unit of its values.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Airspeed => "m/s",
            Self::Alpha | Self::Beta | Self::BankAngle | Self::PitchAngle => "rad",
            Self::RollRate | Self::PitchRate | Self::YawRate => "rad/s",
            Self::SpecificForceX | Self::SpecificForceY | Self::SpecificForceZ => "m/s²",
        }
    }

    /// Value at instant `at` of a simulated flight, `force` the specific force where it is measured, m/s².
    pub(super) fn at(self, response: &Response, at: usize, force: [f64; 3]) -> f64 {
        match self {
            Self::Airspeed => response.airspeed_m_s[at],
            Self::Alpha => response.alpha_rad[at],
            Self::Beta => response.beta_rad[at],
            Self::RollRate => response.rates_rad_s[0][at],
            Self::PitchRate => response.rates_rad_s[1][at],
            Self::YawRate => response.rates_rad_s[2][at],
            Self::BankAngle => response.euler_rad[0][at],
            Self::PitchAngle => response.euler_rad[1][at],
            Self::SpecificForceX => force[0],
            Self::SpecificForceY => force[1],
            Self::SpecificForceZ => force[2],
        }
    }

    /// Smallest bias of this output that matters.
    pub(super) fn scale(self) -> f64 {
        match self {
            Self::Airspeed => 0.1,
            Self::SpecificForceX | Self::SpecificForceY | Self::SpecificForceZ => 0.05,
            _ => 1e-3,
        }
    }
}

/// An initial state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitialState {
    /// Velocity relative to the air along a body axis, m/s.
    Velocity(usize),
    /// Rate about a body axis, rad/s.
    Rate(usize),
    /// Bank or pitch angle, rad.
    Euler(usize),
}

impl InitialState {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Velocity(axis) => ["u start", "v start", "w start"][axis],
            Self::Rate(axis) => ["p start", "q start", "r start"][axis],
            Self::Euler(axis) => ["phi start", "theta start", "psi start"][axis],
        }
    }

    /// Unit of its value.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Velocity(_) => "m/s",
            Self::Rate(_) => "rad/s",
            Self::Euler(_) => "rad",
        }
    }

    fn value_in(self, start: &mut Start) -> &mut f64 {
        match self {
            Self::Velocity(axis) => &mut start.air_velocity_body_m_s[axis],
            Self::Rate(axis) => &mut start.rates_rad_s[axis],
            Self::Euler(axis) => &mut start.euler_rad[axis],
        }
    }

    fn scale(self) -> f64 {
        match self {
            Self::Velocity(_) => 0.1,
            Self::Rate(_) | Self::Euler(_) => 1e-3,
        }
    }
}

impl MotionAxis {
    /// Outputs compared.
    pub fn outputs(self) -> &'static [FlightOutput] {
        use FlightOutput::{
            Airspeed, Alpha, BankAngle, Beta, PitchAngle, PitchRate, RollRate, SpecificForceX, SpecificForceY,
            SpecificForceZ, YawRate,
        };
        match self {
            Self::Longitudinal => &[Airspeed, Alpha, PitchRate, PitchAngle, SpecificForceX, SpecificForceZ],
            Self::Lateral => &[Beta, RollRate, YawRate, BankAngle, SpecificForceY],
            Self::Both => &[
                Airspeed, Alpha, PitchRate, PitchAngle, SpecificForceX, SpecificForceZ, Beta, RollRate, YawRate,
                BankAngle, SpecificForceY,
            ],
        }
    }

    /// Outputs recorded with a bias that the flight is free to have: the specific forces.
    pub fn biased(self) -> Vec<FlightOutput> {
        use FlightOutput::{SpecificForceX, SpecificForceY, SpecificForceZ};
        let is_force = |output: &FlightOutput| matches!(output, SpecificForceX | SpecificForceY | SpecificForceZ);
        self.outputs().iter().copied().filter(is_force).collect()
    }

    /// Initial states that are free.
    pub fn initial(self) -> &'static [InitialState] {
        use InitialState::{Euler, Rate, Velocity};
        match self {
            Self::Longitudinal => &[Velocity(0), Velocity(2), Rate(1), Euler(1)],
            Self::Lateral => &[Velocity(1), Rate(0), Rate(2), Euler(0)],
            Self::Both => &[Velocity(0), Velocity(2), Rate(1), Euler(1), Velocity(1), Rate(0), Rate(2), Euler(0)],
        }
    }
}

/// One window of a flight to be followed.
#[derive(Clone, Debug)]
pub struct FlightWindow<'a> {
    /// Name, which its own parameters carry.
    pub label: String,
    /// The window made ready to be flown.
    pub replay: &'a Replay,
    /// Where it starts, to begin with.
    pub start: Start,
    /// Motion as recorded, of which the axis that is not flown has its states.
    pub motion: &'a Motion,
    /// Derivatives to begin with, constants of this window among them; entry by entry the same terms in every window.
    pub model: Derivatives,
    /// One recorded column per output, in the order of [`MotionAxis::outputs`]; not finite where nothing was recorded.
    pub measured: Vec<Vec<f64>>,
    /// Where the specific forces were recorded: accelerometers from the centre of gravity in body axes at each sample, m; `None`
    /// for the centre of gravity itself.
    pub accelerometer_from_cg_m: Option<Vec<[f64; 3]>>,
}

/// What is free beside the initial states.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlightFreedom {
    /// Entries of the model all windows share.
    pub shared: Vec<usize>,
    /// Entries each window has for itself, as the constants.
    pub own: Vec<usize>,
    /// Outputs recorded with a bias of their own in every window.
    pub biases: Vec<FlightOutput>,
}

/// Why a flight cannot be followed.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what the variants are")]
pub enum FlightFitError {
    /// The estimation.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// The simulation.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    #[error("filter error takes one axis at a time: choose longitudinal or lateral")]
    OneAxis,
    /// The caller stopped it.
    #[error("stopped")]
    Stopped,
}

/// Result of following flights.
#[derive(Clone, Debug)]
pub struct FlightOutputFit {
    /// Estimates: shared derivatives, then for each window its own derivatives, initial states and biases, named `name[label]`.
    pub fit: OutputErrorFit,
    /// Covariance of the estimates corrected for residuals that are correlated in time and between outputs
    /// (Morelli and Klein 1997 with `S_i' R^-1` in place of the regressors).
    pub corrected_covariance: DMatrix<f64>,
    /// Square roots of its diagonal.
    pub corrected_errors: Vec<f64>,
    /// Samples of each window in `fit.outputs`.
    pub samples: Vec<Range<usize>>,
}

impl FlightOutputFit {
    /// The fit with its corrected errors.
    pub(super) fn new(
        fit: OutputErrorFit,
        measured: &DMatrix<f64>,
        samples: Vec<Range<usize>>,
    ) -> Result<Self, EstimateError> {
        let corrected_covariance = corrected_covariance(&fit, measured, &samples)?;
        let corrected_errors = roots_of_diagonal(&corrected_covariance);
        Ok(Self { fit, corrected_covariance, corrected_errors, samples })
    }
}

/// Output error in the time domain (methods as in [`output_error`]): flies the recorded controls from free initial states with
/// free derivatives until the outputs of `axis` follow the recorded ones, all windows with one set of shared derivatives. The
/// other axis moves as recorded ([`Replay::fly_axis`]), so that nothing need be known of its derivatives.
///
/// `go_on` is asked before every simulated flight.
///
/// # Errors
/// As for [`output_error`], [`Replay::fly_axis`] at the start, and [`FlightFitError::Stopped`].
pub fn flight_output_error(
    axis: MotionAxis,
    windows: &[FlightWindow<'_>],
    freedom: &FlightFreedom,
    settings: &OutputErrorSettings,
    go_on: &dyn Fn() -> bool,
) -> Result<FlightOutputFit, FlightFitError> {
    let problem = Problem { axis, windows, freedom };
    let Prepared { parameters, samples, measured } = problem.prepare()?;
    let (total, outputs) = measured.shape();
    // Parameters of one window leave the flights of the others as they were.
    let mut flown: Vec<Option<(Vec<f64>, DMatrix<f64>)>> = windows.iter().map(|_| None).collect();
    let fit = output_error(&parameters, &measured, settings, |theta| {
        let mut all = DMatrix::zeros(total, outputs);
        for (index, range) in samples.iter().enumerate() {
            let own = problem.of_window(index, theta);
            if !flown[index].as_ref().is_some_and(|(known, _)| *known == own) {
                if !go_on() {
                    return Err(FlightFitError::Stopped);
                }
                flown[index] = Some((own.clone(), problem.fly(index, &own)?));
            }
            if let Some((_, outputs)) = &flown[index] {
                all.rows_mut(range.start, range.len()).copy_from(outputs);
            }
        }
        Ok(all)
    });
    // A run that was stopped in the middle of an iteration ends with whatever that led to.
    if !go_on() {
        return Err(FlightFitError::Stopped);
    }
    let fit = fit?;
    FlightOutputFit::new(fit, &measured, samples).map_err(FlightFitError::from)
}

/// Flights with what is free in them.
pub(super) struct Problem<'a> {
    pub(super) axis: MotionAxis,
    pub(super) windows: &'a [FlightWindow<'a>],
    pub(super) freedom: &'a FlightFreedom,
}

impl Problem<'_> {
    /// Parameters of one window alone.
    fn own_count(&self) -> usize {
        self.freedom.own.len() + self.axis.initial().len() + self.freedom.biases.len()
    }

    /// What the search is given.
    pub(super) fn prepare(&self) -> Result<Prepared, EstimateError> {
        let first = self.windows.first().ok_or(EstimateError::NoParameters)?;
        let outputs = self.axis.outputs().len();
        let (mut samples, mut end) = (Vec::with_capacity(self.windows.len()), 0);
        for window in self.windows {
            let length = window.replay.time_s().len();
            let lengths = window.measured.iter().map(Vec::len);
            if window.measured.len() != outputs || lengths.clone().any(|found| found != length) {
                let (expected, found) = (outputs * length, lengths.sum());
                return Err(EstimateError::Size { quantity: "recorded outputs", expected, found });
            }
            if let Some(arms) = window.accelerometer_from_cg_m.as_ref().filter(|arms| arms.len() != length) {
                let (expected, found) = (length, arms.len());
                return Err(EstimateError::Size { quantity: "places of the accelerometers", expected, found });
            }
            samples.push(end..end + length);
            end += length;
        }
        let mut measured = DMatrix::zeros(end, outputs);
        for (window, range) in self.windows.iter().zip(&samples) {
            for (output, column) in window.measured.iter().enumerate() {
                measured.view_mut((range.start, output), (column.len(), 1)).copy_from_slice(column);
            }
        }
        Ok(Prepared { parameters: self.parameters(first), samples, measured })
    }

    fn parameters(&self, first: &FlightWindow<'_>) -> Vec<OutputParameter> {
        /// Smallest change of a derivative that matters.
        const DERIVATIVE: f64 = 0.01;
        let entry = |model: &Derivatives, index: usize, suffix: &str| {
            let entry = &model.entries()[index];
            Self::free(format!("{}{suffix}", entry.term.derivative_name(entry.coefficient)), entry.value, DERIVATIVE)
        };
        let mut all: Vec<_> = self.freedom.shared.iter().map(|&index| entry(&first.model, index, "")).collect();
        for window in self.windows {
            let suffix = format!("[{}]", window.label);
            all.extend(self.freedom.own.iter().map(|&index| entry(&window.model, index, &suffix)));
            let mut start = window.start;
            for &initial in self.axis.initial() {
                all.push(Self::free(
                    format!("{}{suffix}", initial.name()),
                    *initial.value_in(&mut start),
                    initial.scale(),
                ));
            }
            for &output in &self.freedom.biases {
                all.push(Self::free(format!("{} bias{suffix}", output.name()), 0.0, output.scale()));
            }
        }
        all
    }

    fn free(name: String, start: f64, scale: f64) -> OutputParameter {
        OutputParameter { name, start, scale, bounds: (f64::NEG_INFINITY, f64::INFINITY) }
    }

    /// Shared parameters and those of window `index`.
    pub(super) fn of_window(&self, index: usize, theta: &[f64]) -> Vec<f64> {
        let (shared, rest) = theta.split_at(self.freedom.shared.len());
        let own = &rest[index * self.own_count()..(index + 1) * self.own_count()];
        [shared, own].concat()
    }

    /// Outputs of window `index` with its parameters.
    fn fly(&self, index: usize, theta: &[f64]) -> Result<DMatrix<f64>, ReplayError> {
        self.fly_in(self.windows[index].replay, index, theta)
    }

    /// [`Problem::fly`] in other air.
    pub(super) fn fly_in(&self, replay: &Replay, index: usize, theta: &[f64]) -> Result<DMatrix<f64>, ReplayError> {
        let Flown { model, start, biases } = self.with_parameters(index, theta);
        let response = replay.fly_axis(self.axis, &model, &start, self.windows[index].motion)?;
        Ok(self.outputs_of(index, &response, &biases))
    }

    /// What window `index` flies with its parameters.
    pub(super) fn with_parameters(&self, index: usize, theta: &[f64]) -> Flown {
        let window = &self.windows[index];
        let (mut model, mut start) = (window.model.clone(), window.start);
        let mut values = theta.iter().copied();
        for &entry in self.freedom.shared.iter().chain(&self.freedom.own) {
            values.by_ref().take(1).for_each(|value| model.set(entry, value));
        }
        for &initial in self.axis.initial() {
            values.by_ref().take(1).for_each(|value| *initial.value_in(&mut start) = value);
        }
        let mut biases = vec![0.0; self.axis.outputs().len()];
        for (bias, value) in self.freedom.biases.iter().zip(values) {
            if let Some(place) = self.axis.outputs().iter().position(|output| output == bias) {
                biases[place] = value;
            }
        }
        Flown { model, start, biases }
    }

    /// Outputs of a flight of window `index`, samples by outputs.
    pub(super) fn outputs_of(&self, index: usize, response: &Response, biases: &[f64]) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(response.time_s.len(), biases.len());
        for sample in 0..response.time_s.len() {
            let force = self.force_at(index, response, sample, sample);
            for (column, (output, bias)) in self.axis.outputs().iter().zip(biases).enumerate() {
                all[(sample, column)] = output.at(response, sample, force) + bias;
            }
        }
        all
    }

    /// Specific force where it is recorded at `sample` of window `index`, instant `at` of a flight, m/s²: moved with the flight's own
    /// angular acceleration ([`accelerometer_at`]), no slope of a recorded rate, whose smoothing rounds off what follows a fast
    /// control.
    pub(super) fn force_at(&self, index: usize, response: &Response, at: usize, sample: usize) -> [f64; 3] {
        let values = |columns: &[Vec<f64>; 3]| columns.each_ref().map(|column| column[at]);
        let force = values(&response.specific_force_m_s2);
        let arm = self.windows[index].accelerometer_from_cg_m.as_ref().map(|arms| arms[sample]);
        arm.map_or(force, |arm| {
            let (rates, angular) = (values(&response.rates_rad_s), values(&response.angular_acceleration_rad_s2));
            accelerometer_at(arm, force, rates, angular)
        })
    }
}

/// What a search is given.
pub(super) struct Prepared {
    /// Parameters to begin with.
    pub(super) parameters: Vec<OutputParameter>,
    pub(super) samples: Vec<Range<usize>>,
    /// What they are compared with, samples by outputs.
    pub(super) measured: DMatrix<f64>,
}

/// What one window flies.
pub(super) struct Flown {
    pub(super) model: Derivatives,
    pub(super) start: Start,
    /// Bias of each output.
    pub(super) biases: Vec<f64>,
}

/// Standard errors of a covariance.
pub(super) fn roots_of_diagonal(covariance: &DMatrix<f64>) -> Vec<f64> {
    covariance.diagonal().iter().map(|variance| variance.sqrt()).collect()
}

/// Covariance of the estimates by [`covariance_of_outputs`] with the information of [`output_error`], of `samples` window by window.
///
/// The autocorrelation of an output that is measured at a part of the samples only counts by that part: sums over them are of as
/// many products as there are.
pub(super) fn corrected_covariance(
    fit: &OutputErrorFit,
    measured: &DMatrix<f64>,
    samples: &[Range<usize>],
) -> Result<DMatrix<f64>, EstimateError> {
    let columns: Vec<usize> = (0..fit.names.len()).collect();
    // Both in deviations of the noise: the information is then that of plain least squares.
    let parts: Vec<Vec<(DMatrix<f64>, Vec<f64>)>> =
        (0..measured.ncols()).map(|output| weigh_output(fit, measured, samples, output)).collect();
    let mut outputs: Vec<Output<'_>> = Vec::with_capacity(parts.len());
    for parts in &parts {
        let window = |(sensitivities, residuals)| Some(OutputWindow { sensitivities, columns: &columns, residuals });
        outputs.push(parts.iter().map(|(sensitivities, residuals)| window((sensitivities, residuals))).collect());
    }
    covariance_of_outputs(&Unit::without_priors(&fit.covariance), &outputs)
}

/// Sensitivities and residuals of one output window by window, in deviations of its noise.
fn weigh_output(
    fit: &OutputErrorFit,
    measured: &DMatrix<f64>,
    samples: &[Range<usize>],
    output: usize,
) -> Vec<(DMatrix<f64>, Vec<f64>)> {
    let weight = fit.noise[output].recip();
    let present = measured.column(output).iter().filter(|value| value.is_finite()).count();
    let filling = (measured.nrows() as f64 / present.max(1) as f64).sqrt();
    let residual = |row: usize| {
        let z = measured[(row, output)];
        if z.is_finite() { filling * weight * (z - fit.outputs[(row, output)]) } else { 0.0 }
    };
    let sensitivity = |row: usize, parameter: usize| {
        let is_measured = measured[(row, output)].is_finite();
        if is_measured { weight * fit.sensitivities[parameter][(row, output)] } else { 0.0 }
    };
    let window = |rows: &Range<usize>| {
        let of_row = |row, parameter| sensitivity(rows.start + row, parameter);
        (DMatrix::from_fn(rows.len(), fit.names.len(), of_row), rows.clone().map(residual).collect())
    };
    samples.iter().map(window).collect()
}
