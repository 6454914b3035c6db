//! Coefficients and the variables they depend on, from the reconstructed path of one window.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::model::{
    AeroData, Coefficient, CoefficientSettings, Coefficients, Gyroscopic, Position, RECORDED, ThrustTreatment,
    Variables, coefficients, variables,
};
use doublet_core::prep::{MatchedSmoothing, smoothed_rate};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{FilterData, INPUTS, Input, Reconstruction, STATES, State};
use doublet_core::series::{Recording, Series, TimeRange};
use doublet_core::statistics::median_step;

use super::air_density::{AirDensity, air_over};
use super::aircraft::AircraftData;
use super::engines::{Air, ExtrapolatedThrust, engines};
use super::path::WindowPath;
use super::recording::LoadedFlight;
use super::samples::{differentiation, span};
use super::window_context::{ANGULAR_ACCELERATIONS, WindowContext};
use super::window_samples::{Samples, is_in};
use crate::graph::{Context, Footprint, Keyed, Stage, StageResult};
use crate::session::{AngularAcceleration, PathSource, Preparation, Surface};

/// Coefficients and variables over one window.
#[derive(Clone, Debug)]
pub struct WindowAero {
    /// Columns they were formed from.
    pub data: AeroData,
    /// How they were formed.
    pub settings: CoefficientSettings,
    /// The eight coefficients.
    pub coefficients: Coefficients,
    /// Variables available to terms.
    pub variables: Variables,
    /// Observed coefficients in the order of [`Coefficient::ALL`], shared, to draw.
    pub series: [Series; 8],
    /// Findings, one line each.
    pub warnings: Vec<Message>,
    /// Where the air density comes from.
    pub air_density: AirDensity,
    /// Engines of the aircraft whose thrust is neither recorded nor follows from their map.
    pub unknown_thrust: Vec<String>,
    /// Engines whose thrust a chart or map extrapolates.
    pub extrapolated_thrust: Vec<ExtrapolatedThrust>,
}

impl Footprint for WindowAero {
    fn bytes(&self) -> usize {
        self.data.time_s.len() * 36 * 8
    }
}

impl Stage for WindowAero {
    type Params<'a> = &'a Preparation;
    type Inputs<'a> = (&'a Keyed<LoadedFlight>, &'a Keyed<Samples>, &'a Keyed<WindowPath>, &'a Keyed<AircraftData>);
    type Output = Self;
    const NAME: &'static str = "coefficients";

    fn run(preparation: &Preparation, inputs: Self::Inputs<'_>, context: &Context<'_>) -> StageResult<Self> {
        let (flight, samples, path, aircraft) = inputs;
        let window = context.get::<WindowContext>(preparation, (flight, samples, aircraft))?;
        aero_in(&window, &path.reconstruction, aircraft, preparation)
    }
}

/// Control surfaces that may appear in terms.
pub const CONTROLS: [Surface; 3] = [Surface::Aileron, Surface::Elevator, Surface::Rudder];

impl WindowAero {
    /// Which samples of its data are not in an excluded part; `None` where all are.
    pub(crate) fn left(&self) -> Option<Vec<usize>> {
        let Self { data, settings, .. } = self;
        let excluded = &settings.excluded;
        (!excluded.is_empty())
            .then(|| (0..data.time_s.len()).filter(|&sample| !is_in(excluded, data.time_s[sample])).collect())
    }

    /// Time its rows cover, s: without that of excluded parts.
    pub(crate) fn covered_s(&self) -> f64 {
        let time_s = &self.coefficients.time_s;
        let (first, last) = span(time_s);
        match self.settings.excluded.as_slice() {
            [] => last - first,
            _ => median_step(time_s).unwrap_or(f64::NAN) * (time_s.len().max(2) - 1) as f64,
        }
    }

    /// The longest part of its rows without an excluded one in between.
    pub(crate) fn longest_rows(&self) -> Range<usize> {
        let time_s = &self.coefficients.time_s;
        let mut longest = 0..time_s.len();
        for part in &self.settings.excluded {
            let at = time_s[longest.clone()].partition_point(|time_s| *time_s < part.start_s) + longest.start;
            let (before, after) = (longest.start..at, at..longest.end);
            longest = if before.len() > after.len() { before } else { after };
        }
        longest
    }

    /// The same window with other columns or settings.
    pub fn form(data: AeroData, settings: CoefficientSettings, air_density: AirDensity) -> StageResult<Self> {
        let coefficients = coefficients(&data, &settings)?;
        let variables = variables(&data, &settings)?;
        if coefficients.time_s.is_empty() {
            return Err("no samples left after exclusions: shorten the excluded parts".into());
        }
        let series = Coefficient::ALL.map(|c| Series {
            time_s: Arc::clone(&coefficients.time_s),
            values: Arc::clone(&coefficients.columns[c as usize]),
        });
        Ok(Self {
            data,
            settings,
            coefficients,
            variables,
            series,
            warnings: Vec::new(),
            air_density,
            unknown_thrust: Vec::new(),
            extrapolated_thrust: Vec::new(),
        })
    }
}

/// The same window as if its filter had been given `data` and found `path` instead of the nominal ones, at the same times: air, engines, loading and
/// deflections stay, and what differs between `data` and the samples of `nominal` is added to the inertial samples as measured.
pub fn aero_along(
    aero: &WindowAero,
    (nominal_data, nominal): (&FilterData, &Reconstruction),
    (data, path): (&FilterData, &Reconstruction),
    preparation: &Preparation,
) -> StageResult<WindowAero> {
    aero_along_from(aero, (nominal_data, nominal), (data, path), (preparation, preparation.path))
}

/// [`aero_along`] with the motion of `path` taken from `source`.
pub fn aero_along_from(
    aero: &WindowAero,
    (nominal_data, nominal): (&FilterData, &Reconstruction),
    (data, path): (&FilterData, &Reconstruction),
    (preparation, source): (&Preparation, PathSource),
) -> StageResult<WindowAero> {
    let first = nominal_data.inputs.time_s.len() - aero.data.time_s.len();
    let known = motion(first, nominal, preparation.path)?;
    let Motion { airspeed_m_s, alpha_rad, beta_rad, biases, .. } = motion(first, path, source)?;
    let moved = |column: &[f64], input: Input| -> Vec<f64> {
        let index = input as usize;
        let samples = data.inputs.columns[index][first..].iter().zip(&nominal_data.inputs.columns[index][first..]);
        let bias = biases[index] - known.biases[index];
        column.iter().zip(samples).map(|(value, (noisy, clean))| value + (noisy - clean) - bias).collect()
    };
    let [x, y, z] = &aero.data.specific_force_m_s2;
    let [p, q, r] = &aero.data.rates_rad_s;
    let specific_force_m_s2 =
        [moved(x, Input::SpecificForceX), moved(y, Input::SpecificForceY), moved(z, Input::SpecificForceZ)];
    let rates_rad_s = [moved(p, Input::RollRate), moved(q, Input::PitchRate), moved(r, Input::YawRate)];
    let angular_acceleration_rad_s2 = match preparation.angular_acceleration {
        AngularAcceleration::Recorded => aero.data.angular_acceleration_rad_s2.clone(),
        _ => angular_acceleration(&aero.data.time_s, &rates_rad_s, preparation)?,
    };
    let data = AeroData {
        airspeed_m_s,
        alpha_rad,
        beta_rad,
        rates_rad_s,
        specific_force_m_s2,
        angular_acceleration_rad_s2,
        ..aero.data.clone()
    };
    WindowAero::form(data, aero.settings.clone(), aero.air_density)
}

/// Forms the coefficients of one window from the samples its filter got and the path it found, without those of excluded parts.
///
/// # Errors
/// One line: nothing left of the window after settling, a control with a gap, or what the model refuses.
pub fn aero(
    recording: &Recording,
    (data, path): (&FilterData, &Reconstruction),
    (aircraft, excluded): (&AircraftData, &[TimeRange]),
    preparation: &Preparation,
) -> StageResult<WindowAero> {
    aero_in(&WindowContext::new(recording, (data, excluded), aircraft, preparation)?, path, aircraft, preparation)
}

fn aero_in(
    window: &WindowContext,
    path: &Reconstruction,
    aircraft: &AircraftData,
    preparation: &Preparation,
) -> StageResult<WindowAero> {
    let Formed { data, air_density, unknown_thrust, extrapolated_thrust, mut warnings } =
        aero_data(window, path, aircraft, preparation)?;
    let differentiation = differentiation(preparation, &data.time_s);
    let matched = preparation.matched_smoothing
        && data.angular_acceleration_rad_s2.is_none()
        && MatchedSmoothing::new(&data.time_s, differentiation)
            .inspect_err(|error| {
                warnings
                    .push(message!("regressors lack the smoothing of the angular acceleration: {}", error.to_string()))
            })
            .is_ok();
    let settings = CoefficientSettings {
        reference: aircraft.loaded.aircraft.reference,
        moment_reference: preparation
            .moment_reference
            .from_datum_m(aircraft.moment_reference_from_datum_m)
            .map(Position::Datum),
        axes: preparation.axes,
        thrust: preparation.thrust,
        gyroscopic: if rotors_known(&data) { preparation.gyroscopic } else { Gyroscopic::Ignored },
        differentiation,
        matched,
        control_lags: CONTROLS.map(|surface| (surface.role(), preparation.control_lags.get(surface))).into(),
        excluded: window.excluded.to_vec(),
    };
    let formed = WindowAero::form(data, settings, air_density)?;
    Ok(WindowAero { warnings, unknown_thrust, extrapolated_thrust, ..formed })
}

/// The rotors' momentum counts where every engine's speed is known.
fn rotors_known(data: &AeroData) -> bool {
    !data.engines.is_empty() && data.engines.iter().all(|engine| !engine.speed_rad_s.is_empty())
}

/// The slopes of a smoother over the rates, where the session asks for them.
fn angular_acceleration(
    time_s: &[f64],
    rates_rad_s: &[Vec<f64>; 3],
    preparation: &Preparation,
) -> StageResult<Option<[Vec<f64>; 3]>> {
    if preparation.angular_acceleration != AngularAcceleration::Smoother {
        return Ok(None);
    }
    let mut slopes = [const { Vec::new() }; 3];
    for (slope, (name, rate)) in slopes.iter_mut().zip(["p", "q", "r"].into_iter().zip(rates_rad_s)) {
        *slope = smoothed_rate(time_s, rate).map_err(|error| format!("{name}: {error}"))?.slope;
    }
    Ok(Some(slopes))
}

/// The angular acceleration as recorded; zero about an axis whose rate is not recorded either.
fn recorded_angular_acceleration(window: &WindowContext) -> StageResult<[Vec<f64>; 3]> {
    let mut found = [const { Vec::new() }; 3];
    for (column, (acceleration, rate)) in found.iter_mut().zip(ANGULAR_ACCELERATIONS) {
        *column = match (window.values(acceleration)?, window.values(rate)?) {
            (Some(values), _) => values.to_vec(),
            (None, None) => vec![0.0; window.time_s.len()],
            (None, Some(_)) => {
                let (name, rate) = (acceleration.name(), rate.name());
                return Err(format!("{name} is not recorded: map its channel, or use differentiated {rate}").into());
            }
        };
    }
    Ok(found)
}

/// Columns of a window, and what is to be known of them.
struct Formed {
    data: AeroData,
    air_density: AirDensity,
    unknown_thrust: Vec<String>,
    extrapolated_thrust: Vec<ExtrapolatedThrust>,
    warnings: Vec<Message>,
}

fn aero_data(
    window: &WindowContext,
    path: &Reconstruction,
    aircraft: &AircraftData,
    preparation: &Preparation,
) -> StageResult<Formed> {
    let Motion { airspeed_m_s, alpha_rad, beta_rad, biases, down_m } = motion(window.first, path, preparation.path)?;
    let time_s = Arc::clone(&window.time_s);
    // The filter has the specific force moved to the centre of gravity; here it is wanted as measured, to be moved with the
    // centre of gravity of each sample and the differentiation of the coefficients.
    let accelerometer = aircraft.accelerometer.filter(|_| preparation.correct_accelerometer);
    let [ax, ay, az, p, q, r] = unbiased_inputs(window, &biases)?;
    let rates_rad_s = [p, q, r];
    let air = air_over(window, &down_m, preparation.origin_altitude_m)?;
    let mut warnings = air.warnings;
    let mut controls = BTreeMap::new();
    for role in CONTROLS.map(Surface::role) {
        if let Some(values) = window.values(role)? {
            controls.insert(role, values);
        }
    }
    // Only a term that is asked for needs these: what has a gap is missing to that term alone.
    for (_, role) in RECORDED {
        controls.extend(window.values(role).ok().flatten().map(|values| (role, values)));
    }
    let of_engines = Air {
        time_s: &time_s,
        airspeed_m_s: &airspeed_m_s,
        altitude_m: &air.altitude_m,
        temperature_k: &air.temperature_k,
        density_kg_m3: &air.density_kg_m3,
    };
    let engines = engines(window, aircraft, &of_engines)?;
    if preparation.thrust != ThrustTreatment::Included && engines.engines.is_empty() {
        return Err("thrust is unknown and cannot be removed: record it, or keep thrust in the coefficients".into());
    }
    warnings.extend(engines.warnings);
    let data = AeroData {
        alpha_rad,
        beta_rad,
        airspeed_m_s,
        angular_acceleration_rad_s2: match preparation.angular_acceleration {
            AngularAcceleration::Recorded => Some(recorded_angular_acceleration(window)?),
            _ => angular_acceleration(&time_s, &rates_rad_s, preparation)?,
        },
        rates_rad_s,
        specific_force_m_s2: [ax, ay, az],
        accelerometer,
        density_kg_m3: air.density_kg_m3,
        controls,
        mass: window.mass.clone()?,
        engines: engines.engines,
        propeller_pressure: engines.propeller_pressure,
        mach: window.values(Role::Mach)?,
        altitude_m: Some(air.altitude_m),
        time_s,
    };
    let (unknown_thrust, extrapolated_thrust) = (engines.unknown, engines.extrapolated);
    Ok(Formed { data, air_density: air.source, unknown_thrust, extrapolated_thrust, warnings })
}

/// What the path says of the motion from some sample on.
struct Motion {
    airspeed_m_s: Arc<[f64]>,
    alpha_rad: Arc<[f64]>,
    beta_rad: Arc<[f64]>,
    /// Of each inertial channel. A bias without a random walk is one number: its estimate from the whole window.
    biases: [f64; INPUTS],
    down_m: Vec<f64>,
}

fn motion(first: usize, path: &Reconstruction, source: PathSource) -> StageResult<Motion> {
    let states = states_of(path, source)?;
    let state = |state: State| &states[state as usize][first..];
    let (u, v, w) = (state(State::VelocityU), state(State::VelocityV), state(State::VelocityW));
    let each = |value: &dyn Fn(usize) -> f64| (0..u.len()).map(value).collect();
    let biases = [State::BiasAx, State::BiasAy, State::BiasAz, State::BiasP, State::BiasQ, State::BiasR];
    Ok(Motion {
        airspeed_m_s: each(&|k| (u[k] * u[k] + v[k] * v[k] + w[k] * w[k]).sqrt()),
        alpha_rad: each(&|k| w[k].atan2(u[k])),
        beta_rad: each(&|k| v[k].atan2(u[k].hypot(w[k]))),
        biases: biases.map(|bias| states[bias as usize].last().copied().unwrap_or(0.0)),
        down_m: state(State::PositionDown).to_vec(),
    })
}

pub(crate) fn states_of(path: &Reconstruction, source: PathSource) -> StageResult<&[Vec<f64>; STATES]> {
    match source {
        PathSource::Filtered | PathSource::Measured => Ok(&path.states),
        PathSource::Smoothed => path
            .smoothed
            .as_ref()
            .map(|smoothed| &smoothed.states)
            .ok_or("the path was not smoothed: choose the filtered path".into()),
    }
}

/// Inertial samples as recorded, less their biases.
fn unbiased_inputs(window: &WindowContext, biases: &[f64; INPUTS]) -> StageResult<[Vec<f64>; INPUTS]> {
    let mut columns: [Vec<f64>; INPUTS] = Default::default();
    for (input, bias) in Input::ALL.into_iter().zip(biases) {
        let Some(recorded) = window.values(input.role())? else {
            columns[input as usize] = vec![0.0; window.time_s.len()];
            continue;
        };
        columns[input as usize] = recorded.iter().map(|value| value - bias).collect();
    }
    Ok(columns)
}
