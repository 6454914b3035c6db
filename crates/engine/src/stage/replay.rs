//! Proof of match: windows flown again by the identified model from the recorded controls, judged against tolerances.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::model::{Coefficient, Derivatives, Structure, Term, regressors, specific_force_at_cg};
use doublet_core::reconstruct::{Reconstruction, STATES, State};
use doublet_core::replay::{Motion, Replay, Response, Start};
use doublet_core::series::Series;
use doublet_core::validate::{Histories, Signal, TestResult, Theil, ToleranceTest, judge, theil};
use rayon::prelude::*;

use super::aero::{WindowAero, states_of};
use super::aircraft::AircraftData;
use super::fit::{PooledFits, WindowFits, constant_name};
use super::path::WindowPath;
use super::recording::LoadedFlight;
use super::tolerances::Tolerances;
use crate::graph::{Context, Footprint, Keyed, Stage, StageResult};
use crate::session::{Manoeuvre, Preparation, Session, Settings, WindowRole};

/// One window flown again.
#[derive(Clone, Debug)]
pub struct WindowReplay {
    /// Motion as reconstructed from the measurements.
    pub measured: Histories,
    /// Motion of the model.
    pub simulated: Histories,
    /// The same columns, shared, to draw; in the order of [`Signal::ALL`].
    pub series: Vec<ReplaySeries>,
    /// Theil's coefficient of each signal, of the changes from the start.
    pub theil: Vec<(Signal, Theil)>,
    /// Tests of the tolerance file that apply.
    pub tests: Vec<TestResult>,
}

/// One signal to draw.
#[derive(Clone, Debug)]
pub struct ReplaySeries {
    pub signal: Signal,
    /// As reconstructed.
    pub measured: Series,
    /// Of the model.
    pub simulated: Series,
    /// Half of the half width of the widest tolerance band about the measurement, where a test has one: plots draw plus and minus
    /// twice it.
    pub half_band: Option<Arc<[f64]>>,
}

/// All windows flown again: the replay, or one line why there is none.
#[derive(Clone, Debug, Default)]
pub struct ProofOfMatch {
    pub tolerances: String,
    /// Window and replay, in the order of the session.
    pub windows: Vec<(String, StageResult<Arc<WindowReplay>>)>,
}

/// A window with everything computed from it.
#[derive(Clone, Debug, Hash)]
pub struct StudyWindow<'a> {
    pub manoeuvre: &'a Manoeuvre,
    /// Flight it lies in.
    pub flight: Keyed<LoadedFlight>,
    /// The aircraft with what was on board in that flight.
    pub aircraft: Keyed<AircraftData>,
    pub path: Keyed<WindowPath>,
    /// Coefficients and variables.
    pub aero: Keyed<WindowAero>,
    /// Derivatives from it alone.
    pub fits: Keyed<WindowFits>,
}

/// Flies every validation window with the pooled model.
impl Stage for ProofOfMatch {
    type Params<'a> = Settings<'a>;
    type Inputs<'a> = (&'a [StudyWindow<'a>], &'a Keyed<PooledFits>);
    type Output = Self;
    const NAME: &'static str = "proof of match";

    fn run(settings: Settings<'_>, (windows, pooled): Self::Inputs<'_>, context: &Context<'_>) -> StageResult<Self> {
        let tolerances = Tolerances::builtin()?;
        let one = |window: &StudyWindow<'_>| -> StageResult<Arc<WindowReplay>> {
            let window = ReplayWindow { manoeuvre: window.manoeuvre, path: &window.path, aero: &window.aero };
            let model = model_of_window(pooled, settings.structure, &window)?;
            replay(&window, &model, settings.preparation, settings.filter.gravity_m_s2, &tolerances).map(Arc::new)
        };
        let fly = |window: &StudyWindow<'_>| {
            context.checkpoint()?;
            Ok((window.manoeuvre.name.clone(), one(window)))
        };
        let validation = windows.par_iter().filter(|window| window.manoeuvre.role == WindowRole::Validation);
        Ok(Self { windows: validation.map(fly).collect::<StageResult<_>>()?, tolerances: tolerances.name })
    }
}

impl Footprint for ProofOfMatch {
    fn bytes(&self) -> usize {
        let samples = |replay: &Arc<WindowReplay>| replay.measured.time_s.len() * (4 * Signal::ALL.len() + 8) * 8;
        self.windows.iter().filter_map(|(_, replay)| replay.as_ref().ok()).map(samples).sum::<usize>() + 256
    }
}

impl ProofOfMatch {
    /// The same flights judged by other tolerances.
    #[must_use]
    pub fn judge_by(&self, session: &Session, tolerances: &Tolerances) -> Self {
        let one = |(name, replay): &(String, StageResult<Arc<WindowReplay>>)| {
            let judged = |replay: &Arc<WindowReplay>| {
                let tests = session.window(name).map(|window| tolerances.tests(window)).unwrap_or_default();
                Arc::new(replay.judge_by(tests))
            };
            (name.clone(), replay.as_ref().map(judged).map_err(Clone::clone))
        };
        Self { tolerances: tolerances.name.clone(), windows: self.windows.iter().map(one).collect() }
    }

    pub fn window(&self, name: &str) -> Option<&StageResult<Arc<WindowReplay>>> {
        self.windows.iter().find(|(window, _)| window == name).map(|(_, replay)| replay)
    }
}

impl WindowReplay {
    /// The same flight judged by other tests.
    #[must_use]
    pub fn judge_by<'a>(&self, tests: impl IntoIterator<Item = &'a ToleranceTest>) -> Self {
        let (measured, simulated) = (&self.measured, &self.simulated);
        let tests: Vec<_> = tests.into_iter().map(|test| judge(test, measured, simulated)).collect();
        let series = series(measured, simulated, &tests);
        Self { tests, series, ..self.clone() }
    }
}

/// What a window brings to its replay.
#[derive(Clone, Copy)]
pub struct ReplayWindow<'a> {
    pub manoeuvre: &'a Manoeuvre,
    /// Its reconstructed path.
    pub path: &'a WindowPath,
    /// Its coefficients and the columns they were formed from.
    pub aero: &'a WindowAero,
}

/// Derivatives of the pooled estimate, with the constants of a window: its own where it was identified, else those that leave no
/// mean residual in its coefficients, so that the replay tests derivatives, not trim.
pub fn model_of_window(
    pooled: &PooledFits,
    structure: &Structure,
    window: &ReplayWindow<'_>,
) -> StageResult<Derivatives> {
    let mut entries = Vec::new();
    for (coefficient, terms) in &structure.models {
        let name = coefficient.name();
        let fit = pooled.fits.iter().find(|fit| fit.coefficient == *coefficient);
        let fit =
            fit.ok_or_else(|| format!("{name} has no estimate: mark an identification manoeuvre that excites it"))?;
        let estimate = fit.fit.as_ref().map_err(|error| format!("{name} has no estimate: {error}"))?;
        let mut unexplained: Option<f64> = None;
        for term in terms {
            let derivative = term.derivative_name(*coefficient);
            let own = constant_name(&derivative, &window.manoeuvre.name);
            match estimate.parameter(&derivative).or_else(|| estimate.parameter(&own)) {
                Some((value, _)) => entries.push((*coefficient, term.clone(), value)),
                None if term.is_constant() => unexplained = Some(0.0),
                None => return Err(format!("{derivative} has no estimate").into()),
            }
        }
        if unexplained.is_some() {
            let known = entries.iter().filter(|(other, ..)| other == coefficient);
            let offset = mean_residual(*coefficient, known.map(|(_, term, value)| (term, *value)), window.aero)?;
            entries.push((*coefficient, Term::constant(), offset));
        }
    }
    Ok(entries.into_iter().collect())
}

/// Mean of the observed coefficient less the sum of derivative times term.
fn mean_residual<'a>(
    coefficient: Coefficient,
    known: impl Iterator<Item = (&'a Term, f64)>,
    aero: &WindowAero,
) -> StageResult<f64> {
    let observed = aero.coefficients.get(coefficient);
    let mut sum: f64 = observed.iter().sum();
    for (term, value) in known {
        let column = regressors(std::slice::from_ref(term), &aero.variables)?;
        sum -= value * column.sum();
    }
    Ok(sum / observed.len() as f64)
}

/// Flies a window with `model` from its reconstructed start as [`window_flight`] has it, and judges it outside excluded parts.
pub fn replay(
    window: &ReplayWindow<'_>,
    model: &Derivatives,
    preparation: &Preparation,
    gravity_m_s2: f64,
    tolerances: &Tolerances,
) -> StageResult<WindowReplay> {
    let flight = window_flight(&window.path.reconstruction, window.aero, preparation, gravity_m_s2)?;
    fly_window(window, model, &flight, tolerances)
}

/// Flies a window made ready with `model` and judges it outside excluded parts.
pub(crate) fn fly_window(
    window: &ReplayWindow<'_>,
    model: &Derivatives,
    flight: &WindowFlight,
    tolerances: &Tolerances,
) -> StageResult<WindowReplay> {
    let ReplayWindow { manoeuvre, aero, .. } = window;
    let response = flight.replay.fly(model, &flight.start)?;
    let left = aero.left();
    let measured = outside(&left, measured_histories(&flight.motion, aero));
    let simulated = outside(&left, simulated_histories(&response));
    let tests = tolerances.tests(manoeuvre).into_iter();
    let tests: Vec<_> = tests.map(|test| judge(test, &measured, &simulated)).collect();
    let theil = Signal::ALL.map(|signal| {
        let from_start = |values: &[f64]| -> Vec<f64> { values.iter().map(|v| v - measured.get(signal)[0]).collect() };
        (signal, theil(&from_start(measured.get(signal)), &from_start(simulated.get(signal))))
    });
    let series = series(&measured, &simulated, &tests);
    Ok(WindowReplay { measured, simulated, series, theil: theil.into(), tests })
}

/// The samples of `histories` that are left.
fn outside(left: &Option<Vec<usize>>, histories: Histories) -> Histories {
    let Some(left) = left else { return histories };
    let pick = |column: &Vec<f64>| left.iter().map(|&sample| column[sample]).collect();
    Histories { time_s: pick(&histories.time_s), columns: histories.columns.each_ref().map(pick) }
}

/// Columns shared for drawing, with the bands of the tests.
fn series(measured: &Histories, simulated: &Histories, tests: &[TestResult]) -> Vec<ReplaySeries> {
    let time_s: Arc<[f64]> = measured.time_s.as_slice().into();
    let share = |values: &[f64]| Series { time_s: Arc::clone(&time_s), values: values.into() };
    let bands = bands(tests);
    let one = |signal: Signal| ReplaySeries {
        signal,
        measured: share(measured.get(signal)),
        simulated: share(simulated.get(signal)),
        half_band: bands.get(&signal).map(|widths| widths.iter().map(|width| 0.5 * width).collect()),
    };
    Signal::ALL.map(one).into()
}

/// A window made ready to be flown, and the motion it was recorded with.
pub struct WindowFlight {
    /// Controls, air, engines and loading.
    pub replay: Replay,
    /// Where the recorded motion starts.
    pub start: Start,
    /// Motion as reconstructed.
    pub motion: Motion,
    /// Sample of the path at which the coefficients begin: where the filter has settled.
    pub first: usize,
}

/// Makes a window ready to be flown in its reconstructed wind, with its recorded controls, thrust and loading.
pub fn window_flight(
    path: &Reconstruction,
    aero: &WindowAero,
    preparation: &Preparation,
    gravity_m_s2: f64,
) -> StageResult<WindowFlight> {
    let states = states_of(path, preparation.path)?;
    let begins_s = aero.data.time_s.first().copied().unwrap_or(f64::NAN);
    let first = path.time_s.partition_point(|&time| time < begins_s);
    let column = |state: State| states[state as usize][first..].to_vec();
    let wind = [State::WindNorth, State::WindEast, State::WindDown].map(column);
    let replay = Replay::new(&aero.data, &aero.settings, &wind, gravity_m_s2)?;
    let start = start(states, first, aero);
    let mut motion = Motion {
        position_ned_m: [State::PositionNorth, State::PositionEast, State::PositionDown].map(column),
        air_velocity_body_m_s: [State::VelocityU, State::VelocityV, State::VelocityW].map(column),
        euler_rad: [State::BankAngle, State::PitchAngle, State::HeadingAngle].map(column),
        rates_rad_s: aero.data.rates_rad_s.clone(),
        specific_force_m_s2: specific_force_at_cg(&aero.data, &aero.settings)?,
    };
    unwrap(&mut motion.euler_rad[2]);
    Ok(WindowFlight { replay, start, motion, first })
}

fn start(states: &[Vec<f64>; STATES], first: usize, aero: &WindowAero) -> Start {
    let at = |state: State| states[state as usize][first];
    Start {
        position_ned_m: [State::PositionNorth, State::PositionEast, State::PositionDown].map(at),
        air_velocity_body_m_s: [State::VelocityU, State::VelocityV, State::VelocityW].map(at),
        euler_rad: [State::BankAngle, State::PitchAngle, State::HeadingAngle].map(at),
        rates_rad_s: aero.data.rates_rad_s.each_ref().map(|column| column[0]),
    }
}

/// The reconstructed motion.
pub(crate) fn measured_histories(motion: &Motion, aero: &WindowAero) -> Histories {
    let columns = Signal::ALL.map(|signal| measured_column(signal, motion, aero));
    Histories { time_s: aero.data.time_s.to_vec(), columns }
}

fn measured_column(signal: Signal, motion: &Motion, aero: &WindowAero) -> Vec<f64> {
    let data = &aero.data;
    let ([ax, ay, az], [phi, theta, psi]) = (&motion.specific_force_m_s2, &motion.euler_rad);
    match signal {
        Signal::Airspeed => data.airspeed_m_s.to_vec(),
        Signal::Altitude => negate(&motion.position_ned_m[2]),
        Signal::AngleOfAttack => data.alpha_rad.to_vec(),
        Signal::Sideslip => data.beta_rad.to_vec(),
        Signal::BankAngle => phi.clone(),
        Signal::PitchAngle => theta.clone(),
        Signal::HeadingAngle => psi.clone(),
        Signal::RollRate => data.rates_rad_s[0].clone(),
        Signal::PitchRate => data.rates_rad_s[1].clone(),
        Signal::YawRate => data.rates_rad_s[2].clone(),
        Signal::SpecificForceX => ax.clone(),
        Signal::SpecificForceY => ay.clone(),
        Signal::NormalAcceleration => negate(az),
    }
}

/// The motion of the model, its heading on the same turn as the measured one, since both start alike.
fn simulated_histories(response: &Response) -> Histories {
    let columns = Signal::ALL.map(|signal| simulated_column(signal, response));
    Histories { time_s: response.time_s.clone(), columns }
}

fn simulated_column(signal: Signal, response: &Response) -> Vec<f64> {
    let [ax, ay, az] = &response.specific_force_m_s2;
    let [phi, theta, psi] = &response.euler_rad;
    let [p, q, r] = &response.rates_rad_s;
    match signal {
        Signal::Airspeed => response.airspeed_m_s.clone(),
        Signal::Altitude => negate(&response.position_ned_m[2]),
        Signal::AngleOfAttack => response.alpha_rad.clone(),
        Signal::Sideslip => response.beta_rad.clone(),
        Signal::BankAngle => phi.clone(),
        Signal::PitchAngle => theta.clone(),
        Signal::HeadingAngle => psi.clone(),
        Signal::RollRate => p.clone(),
        Signal::PitchRate => q.clone(),
        Signal::YawRate => r.clone(),
        Signal::SpecificForceX => ax.clone(),
        Signal::SpecificForceY => ay.clone(),
        Signal::NormalAcceleration => negate(az),
    }
}

fn negate(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| -value).collect()
}

/// Takes the jumps out of an angle, its first value brought to (-pi, pi].
fn unwrap(angle_rad: &mut [f64]) {
    let mut before = 0.0;
    for value in angle_rad {
        *value += ((before - *value) / std::f64::consts::TAU).round() * std::f64::consts::TAU;
        before = *value;
    }
}

/// The widest half width of the tests' bands at each sample, by signal, SI.
pub fn bands(tests: &[TestResult]) -> BTreeMap<Signal, Vec<f64>> {
    let mut bands: BTreeMap<Signal, Vec<f64>> = BTreeMap::new();
    for band in tests.iter().flat_map(|test| &test.requirements).flatten() {
        let widest = bands.entry(band.tolerance.signal).or_insert_with(|| band.half_width.clone());
        widest.iter_mut().zip(&band.half_width).for_each(|(widest, width)| *widest = widest.max(*width));
    }
    bands
}
