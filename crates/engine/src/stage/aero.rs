//! Coefficients and the variables they depend on, from the reconstructed path of one window.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use doublet_core::atmos::{Atmosphere, density_kg_m3};
use doublet_core::model::{
    AeroData, Coefficient, CoefficientSettings, Coefficients, Gyroscopic, Position, RECORDED, ThrustTreatment,
    Variables, coefficients, variables,
};
use doublet_core::prep::{MatchedSmoothing, smoothed_rate};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{FilterData, INPUTS, Input, Reconstruction, STATES, State};
use doublet_core::series::{Recording, Series, TimeRange};
use doublet_core::statistics::median_step;

use super::aircraft::AircraftData;
use super::engines::{Air, ExtrapolatedThrust, engines};
use super::path::WindowPath;
use super::recording::LoadedFlight;
use super::samples::{differentiation, span};
use super::window_context::{ANGULAR_ACCELERATIONS, WindowContext};
use super::window_samples::{Samples, is_in};
use crate::graph::{Context, Footprint, Keyed, Stage, StageResult};
use crate::session::{AngularAcceleration, Finding, Level, PathSource, Preparation, Surface};

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
    pub warnings: Vec<String>,
    /// Where the air density comes from.
    pub air_density: AirDensity,
    /// Engines of the aircraft whose thrust is neither recorded nor follows from their map.
    pub unknown_thrust: Vec<String>,
    /// Engines whose thrust a chart or map extrapolates.
    pub extrapolated_thrust: Vec<ExtrapolatedThrust>,
}

/// Where the air density of a window comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AirDensity {
    /// Recorded itself.
    Recorded,
    /// Recorded static pressure and air temperature.
    PressureAndTemperature,
    /// Recorded static pressure at the temperature of the standard atmosphere.
    Pressure,
    /// The standard atmosphere at the recorded altitude.
    RecordedAltitude,
    /// The standard atmosphere at the height above the sea that the satellites give.
    SatelliteAltitude,
    /// The standard atmosphere at an altitude that nothing recorded: that of the origin which the session assumes, m, and the
    /// climb of the path.
    AssumedAltitude(f64),
}

impl AirDensity {
    /// Name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Recorded => "recorded",
            Self::PressureAndTemperature => "recorded pressure and temperature",
            Self::Pressure => "recorded pressure and standard temperature",
            Self::RecordedAltitude => "standard atmosphere at the recorded altitude",
            Self::SatelliteAltitude => "standard atmosphere at the satellite altitude",
            Self::AssumedAltitude(_) => "standard atmosphere at an assumed altitude",
        }
    }

    /// That it is only assumed (`assumed`), where it is.
    pub fn finding(self) -> Option<Finding> {
        let Self::AssumedAltitude(origin_m) = self else { return None };
        let text = format!(
            "Altitude, pressure and density not recorded: density is that of {origin_m:.0} m above the sea at the start."
        );
        let finding = Finding::new(Level::Caution, "assumed", "air density", text);
        let fix_text = "Map the pressure altitude, or check the stated initial altitude.";
        Some(finding.with_fix_text(fix_text).with_setting("Model", "preparation.origin_altitude_m"))
    }
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
    /// Which samples of its data are not in an excluded stretch; `None` where all are.
    pub(crate) fn left(&self) -> Option<Vec<usize>> {
        let Self { data, settings, .. } = self;
        let excluded = &settings.excluded;
        (!excluded.is_empty())
            .then(|| (0..data.time_s.len()).filter(|&sample| !is_in(excluded, data.time_s[sample])).collect())
    }

    /// Time its rows cover, s: without that of excluded stretches.
    pub(crate) fn covered_s(&self) -> f64 {
        let time_s = &self.coefficients.time_s;
        let (first, last) = span(time_s);
        match self.settings.excluded.as_slice() {
            [] => last - first,
            _ => median_step(time_s).unwrap_or(f64::NAN) * (time_s.len().max(2) - 1) as f64,
        }
    }

    /// The longest stretch of its rows without an excluded one in between.
    pub(crate) fn longest_rows(&self) -> Range<usize> {
        let time_s = &self.coefficients.time_s;
        let mut longest = 0..time_s.len();
        for stretch in &self.settings.excluded {
            let at = time_s[longest.clone()].partition_point(|time_s| *time_s < stretch.start_s) + longest.start;
            let (before, after) = (longest.start..at, at..longest.end);
            longest = if before.len() > after.len() { before } else { after };
        }
        longest
    }

    /// The same window with other columns or settings.
    ///
    /// # Errors
    /// One line: what the model refuses.
    pub fn form(data: AeroData, settings: CoefficientSettings, air_density: AirDensity) -> StageResult<Self> {
        let coefficients = coefficients(&data, &settings)?;
        let variables = variables(&data, &settings)?;
        if coefficients.time_s.is_empty() {
            return Err("excluded parts leave no sample of the manoeuvre: shorten them".into());
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
///
/// # Errors
/// One line: what the model refuses.
pub fn aero_along(
    aero: &WindowAero,
    (nominal_data, nominal): (&FilterData, &Reconstruction),
    (data, path): (&FilterData, &Reconstruction),
    preparation: &Preparation,
) -> StageResult<WindowAero> {
    aero_along_from(aero, (nominal_data, nominal), (data, path), (preparation, preparation.path))
}

/// [`aero_along`] with the motion of `path` taken from `source`.
///
/// # Errors
/// As for [`aero_along`].
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

/// Forms the coefficients of one window from the samples its filter got and the path it found, without those of excluded stretches.
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
                warnings.push(format!("regressors are not smoothed as the angular acceleration is: {error}"))
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
                return Err(format!("{name} is not recorded: map its channel, or let preparation.angular_acceleration differentiate {rate}").into());
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
    warnings: Vec<String>,
}

fn aero_data(
    window: &WindowContext,
    path: &Reconstruction,
    aircraft: &AircraftData,
    preparation: &Preparation,
) -> StageResult<Formed> {
    let mut warnings = Vec::new();
    let Motion { airspeed_m_s, alpha_rad, beta_rad, biases, down_m } = motion(window.first, path, preparation.path)?;
    let time_s = Arc::clone(&window.time_s);
    // The filter has the specific force moved to the centre of gravity; here it is wanted as measured, to be moved with the
    // centre of gravity of each sample and the differentiation of the coefficients.
    let accelerometer = aircraft.accelerometer.filter(|_| preparation.correct_accelerometer);
    let [ax, ay, az, p, q, r] = unbiased_inputs(window, &biases)?;
    let rates_rad_s = [p, q, r];
    let origin_m = preparation.origin_altitude_m;
    let (altitude_m, standard): (Arc<[f64]>, _) = match window.values(Role::Altitude)? {
        Some(altitude) => (altitude, AirDensity::RecordedAltitude),
        None => altitude_without_channel(window, &down_m, origin_m)?,
    };
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
    let (density_kg_m3, air_density) = air_density(window, &altitude_m, standard)?;
    match air_density {
        AirDensity::RecordedAltitude => {
            warnings.push("air density comes from the standard atmosphere at the recorded altitude".to_owned());
        }
        AirDensity::AssumedAltitude(origin_m) => warnings.push(format!(
            "air density is assumed: standard atmosphere at an assumed altitude, {origin_m:.0} m and the climb of the path"
        )),
        AirDensity::Pressure => {
            warnings.push("air density comes from the recorded pressure at standard temperature".to_owned());
        }
        AirDensity::SatelliteAltitude => {
            warnings.push("air density comes from the standard atmosphere at the satellite altitude".to_owned());
        }
        AirDensity::Recorded | AirDensity::PressureAndTemperature => {}
    }
    let air = Air {
        time_s: &time_s,
        airspeed_m_s: &airspeed_m_s,
        altitude_m: &altitude_m,
        temperature_k: &air_temperature(window, &altitude_m)?,
        density_kg_m3: &density_kg_m3,
    };
    let engines = engines(window, aircraft, &air)?;
    if preparation.thrust != ThrustTreatment::Included && engines.engines.is_empty() {
        return Err("thrust cannot be removed: it is neither recorded nor modelled by the aircraft's engines; set preparation.remove_thrust to false".into());
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
        density_kg_m3,
        controls,
        mass: window.mass.clone()?,
        engines: engines.engines,
        propeller_pressure: engines.propeller_pressure,
        mach: window.values(Role::Mach)?,
        altitude_m: Some(altitude_m),
        time_s,
    };
    let (unknown_thrust, extrapolated_thrust) = (engines.unknown, engines.extrapolated);
    Ok(Formed { data, air_density, unknown_thrust, extrapolated_thrust, warnings })
}

/// Altitude of a recording without a pressure altitude: that of its static pressure, else of the satellites, else an assumed one.
fn altitude_without_channel(
    window: &WindowContext,
    down_m: &[f64],
    origin_m: f64,
) -> StageResult<(Arc<[f64]>, AirDensity)> {
    if let Some(pressure) = window.values(Role::StaticPressure)? {
        let altitude = pressure.iter().map(|&pressure| Atmosphere::STANDARD.altitude_m(pressure));
        return Ok((altitude.collect::<Result<_, _>>()?, AirDensity::Pressure));
    }
    if let Some(altitude) = window.values(Role::GpsAltitude)? {
        return Ok((altitude, AirDensity::SatelliteAltitude));
    }
    Ok((down_m.iter().map(|down| origin_m - down).collect(), AirDensity::AssumedAltitude(origin_m)))
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
            .ok_or("the path was not smoothed: set preparation.path to 'filtered'".into()),
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

fn air_temperature(window: &WindowContext, altitude_m: &[f64]) -> StageResult<Arc<[f64]>> {
    if let Some(temperature) = window.values(Role::AirTemperature)? {
        return Ok(temperature);
    }
    let standard = |&altitude: &f64| Ok(Atmosphere::STANDARD.temperature_k(altitude)?);
    altitude_m.iter().map(standard).collect()
}

/// Air density, and where it comes from: `standard` where nothing but an altitude is known.
fn air_density(
    window: &WindowContext,
    altitude_m: &[f64],
    standard: AirDensity,
) -> StageResult<(Arc<[f64]>, AirDensity)> {
    if let Some(density) = window.values(Role::AirDensity)? {
        return Ok((density, AirDensity::Recorded));
    }
    let pressure = window.values(Role::StaticPressure)?;
    let temperature = window.values(Role::AirTemperature)?;
    if let (Some(pressure), Some(temperature)) = (pressure, temperature) {
        let pairs = pressure.iter().zip(temperature.iter());
        let density = pairs.map(|(&p, &t)| density_kg_m3(p, t));
        return Ok((density.collect::<Result<_, _>>()?, AirDensity::PressureAndTemperature));
    }
    let at = |&altitude: &f64| Atmosphere::STANDARD.density_kg_m3(altitude);
    Ok((altitude_m.iter().map(at).collect::<Result<_, _>>()?, standard))
}
