//! Engines over a whole flight: modelled power, thrust and total-pressure rise, beside the power their monitor reports.

use std::sync::Arc;

use doublet_core::atmos::{Atmosphere, AtmosphereError, density_kg_m3};
use doublet_core::message;
use doublet_core::message::{Message, quoted};
use doublet_core::propulsion::{
    Correlation, Engine, EngineColumns, EngineModel, EnginePoint, PhaseOfFlight, PhaseRow, PowerComparison, Powerplant,
    compare_power, difference_correlation, phase_table,
};
use doublet_core::quantity::Role;
use doublet_core::series::{Recording, Series, TimeRange};
use doublet_core::statistics::median;
use rayon::prelude::*;

use super::aircraft::LoadedAircraft;
use super::engine_charts::{PropellerCurves, propeller_curves};
use super::engines::{ENGINES, EngineRoles};
use super::phases::{GROUND_AIRSPEED_M_S, phases};
use super::recording::LoadedFlight;
use super::samples::values_where_recorded;
use crate::graph::{Context, Footprint, Keyed, Stage, StageError, StageResult};

/// Interval of the grid the engines are modelled on, s.
const STEP_S: f64 = 0.5;
/// Longest time that counts as one flight, s: two days. A recording over more has a faulty clock.
const LONGEST_S: f64 = 172_800.0;

/// Both engines over a flight, every 0.5 s.
#[derive(Clone, Debug)]
pub struct FlightEngines {
    /// The engines that have a chart, a propeller map and their speed and manifold pressure recorded.
    pub engines: Vec<EngineOverFlight>,
    /// Phases of the flight in their order in time.
    pub phases: Vec<PhaseOfFlight>,
    /// Findings, one line each, with the engine where it is about one.
    pub warnings: Vec<(Option<String>, Message)>,
}

/// One engine over a flight; all series share one time and are not a number where an input pauses.
#[derive(Clone, Debug)]
pub struct EngineOverFlight {
    /// Name of its station on the aircraft.
    pub name: String,
    /// Recorded speed of the crankshaft, rad/s.
    pub speed_rad_s: Series,
    /// Recorded manifold pressure, Pa.
    pub manifold_pressure_pa: Series,
    /// Power of the chart, W.
    pub power_w: Series,
    /// Thrust of the propeller map, N.
    pub thrust_n: Series,
    /// Efficiency of the propeller.
    pub efficiency: Series,
    /// Advance ratio `J = V / (n D)` of the propeller; not a number below 40 kt.
    pub advance_ratio: Series,
    /// Thrust coefficient `C_T = T / (rho n² D⁴)`; not a number below 40 kt.
    pub thrust_coefficient: Series,
    /// Propeller map at the speed and altitude of [`Self::typical`].
    pub curves: PropellerCurves,
    /// Medians of the inputs above 40 kt, or over all samples where it never is that fast.
    pub typical: EnginePoint,
    /// Total-pressure rise over dynamic pressure; not a number below 40 kt, where it grows without bound.
    pub total_pressure_rise: Series,
    /// Power its monitor reports, W, where recorded.
    pub monitor_power_w: Option<Series>,
    /// How the two powers agree, where the monitor's is recorded.
    pub agreement: Option<PowerAgreement>,
}

/// Modelled power beside that of the monitor (thesis 6.3).
#[derive(Clone, Debug, PartialEq)]
pub struct PowerAgreement {
    /// Over the whole flight (thesis Table 6.12).
    pub whole: PowerComparison,
    /// Correlation of the difference with seven variables (thesis Table 6.13).
    pub correlations: Vec<Correlation>,
    /// In each phase of the flight, in the order of [`FlightEngines::phases`].
    pub phases: Vec<PhaseRow>,
}

impl Footprint for FlightEngines {
    fn bytes(&self) -> usize {
        self.engines.iter().map(|engine| 8 * 10 * engine.power_w.values.len() + 1024).sum()
    }
}

/// Not applicable where nothing models the engines of this recording.
impl Stage for FlightEngines {
    type Params<'a> = ();
    type Inputs<'a> = (&'a Keyed<LoadedFlight>, &'a Keyed<LoadedAircraft>);
    type Output = Self;
    const NAME: &'static str = "engines of flight";

    fn run((): (), (flight, aircraft): Self::Inputs<'_>, _: &Context<'_>) -> StageResult<Self> {
        flight_engines(&flight.recording, &aircraft.powerplant)?.ok_or(StageError::NotApplicable)
    }
}

/// Air of the flight on the grid, not a number where an input pauses.
struct FlightAir {
    time_s: Arc<[f64]>,
    airspeed_m_s: Vec<f64>,
    altitude_m: Vec<f64>,
    pressure_pa: Vec<f64>,
    temperature_k: Vec<f64>,
    density_kg_m3: Vec<f64>,
}

/// The engines of `powerplant` over the flight of `recording`; `None` where the recording has no engine speed and manifold
/// pressure of an engine with a model, no true airspeed, or neither pressure altitude nor static pressure.
///
/// Inputs are taken on a grid of 2 Hz by straight lines between their samples; no line bridges a gap. The static pressure is the
/// recorded one, else that of the pressure altitude; temperature and density are those recorded, else of the gas law, else of the
/// standard atmosphere.
pub fn flight_engines(recording: &Recording, powerplant: &Powerplant) -> StageResult<Option<FlightEngines>> {
    let has = |role: Role| recording.role(role).is_some();
    let known: Vec<_> = powerplant
        .engines
        .iter()
        .zip(&ENGINES)
        .filter_map(|(engine, roles)| {
            let model = engine.model.as_ref()?;
            (has(roles.speed) && has(roles.manifold_pressure)).then_some((engine, model, roles))
        })
        .collect();
    if known.is_empty() || !has(Role::TrueAirspeed) || !(has(Role::Altitude) || has(Role::StaticPressure)) {
        return Ok(None);
    }
    let time_s = grid(recording, known.iter().map(|(_, _, roles)| roles.speed))?;
    let mut of_air = Vec::new();
    let Some(air) = air(recording, time_s, &mut of_air) else { return Ok(None) };
    let mut warnings: Vec<(Option<String>, Message)> = of_air.into_iter().map(|warning| (None, warning)).collect();
    let phases = phases(&air.time_s, &air.altitude_m, &air.airspeed_m_s);
    let found = known.into_par_iter().map(|known| {
        let mut own = Vec::new();
        let engine = over_flight(recording, known, &air, &phases, &mut own)?;
        let name = &known.0.station.name;
        Ok((engine, own.into_iter().map(|warning| (Some(name.clone()), warning)).collect::<Vec<_>>()))
    });
    let mut engines = Vec::new();
    for (engine, own) in found.collect::<StageResult<Vec<_>>>()? {
        engines.extend(engine);
        warnings.extend(own);
    }
    Ok(Some(FlightEngines { engines, phases, warnings }))
}

/// Multiples of the step from the first to the last sample of any of `roles`.
fn grid(recording: &Recording, roles: impl Iterator<Item = Role>) -> StageResult<Arc<[f64]>> {
    let mut span = TimeRange { start_s: f64::INFINITY, end_s: f64::NEG_INFINITY };
    for channel in roles.filter_map(|role| recording.role(role)) {
        if let [first, .., last] = *channel.series.time_s {
            span = TimeRange { start_s: span.start_s.min(first), end_s: span.end_s.max(last) };
        }
    }
    if span.end_s - span.start_s > LONGEST_S {
        return Err(format!(
            "the engine channels span {:.0} s to {:.0} s, more than two days: correct their clock in the channel map",
            span.start_s, span.end_s
        )
        .into());
    }
    let first = (span.start_s / STEP_S).ceil();
    let steps = ((span.end_s / STEP_S).floor() - first).max(-1.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "two days of steps at most")]
    let samples = (steps + 1.0) as usize;
    Ok((0..samples).map(|k| STEP_S * (first + k as f64)).collect())
}

fn air(recording: &Recording, time_s: Arc<[f64]>, warnings: &mut Vec<Message>) -> Option<FlightAir> {
    let recorded = |role: Role| values_where_recorded(recording, role, &time_s);
    let standard = Atmosphere::STANDARD;
    let airspeed_m_s = recorded(Role::TrueAirspeed)?;
    let pressure = recorded(Role::StaticPressure);
    let altitude_m = match recorded(Role::Altitude) {
        Some(altitude) => altitude,
        None => property_at_each(pressure.as_ref()?, |pressure| standard.altitude_m(pressure)),
    };
    let pressure_is_recorded = pressure.is_some();
    let pressure_pa =
        pressure.unwrap_or_else(|| property_at_each(&altitude_m, |altitude| standard.pressure_pa(altitude)));
    let temperature = recorded(Role::AirTemperature);
    if temperature.is_none() {
        warnings.push(message!("engines: air temperature not recorded; the standard atmosphere is used"));
    } else if !pressure_is_recorded {
        warnings.push(message!("engines: static pressure not recorded; it is computed from pressure altitude"));
    }
    let temperature_k =
        temperature.unwrap_or_else(|| property_at_each(&altitude_m, |altitude| standard.temperature_k(altitude)));
    let density_kg_m3 = recorded(Role::AirDensity).unwrap_or_else(|| {
        let pairs = pressure_pa.iter().zip(&temperature_k);
        pairs.map(|(&pressure, &temperature)| density_kg_m3(pressure, temperature).unwrap_or(f64::NAN)).collect()
    });
    Some(FlightAir { time_s, airspeed_m_s, altitude_m, pressure_pa, temperature_k, density_kg_m3 })
}

/// A property of the atmosphere at each value; not a number where it has none, as outside the troposphere or in a gap.
fn property_at_each(values: &[f64], property: impl Fn(f64) -> Result<f64, AtmosphereError>) -> Vec<f64> {
    values.iter().map(|&value| property(value).unwrap_or(f64::NAN)).collect()
}

/// One engine; `None` where no instant has all its inputs.
fn over_flight(
    recording: &Recording,
    (engine, model, roles): (&Engine, &EngineModel, &EngineRoles),
    air: &FlightAir,
    phases: &[PhaseOfFlight],
    warnings: &mut Vec<Message>,
) -> StageResult<Option<EngineOverFlight>> {
    let name = &engine.station.name;
    let recorded = |role: Role| values_where_recorded(recording, role, &air.time_s);
    let (Some(speed), Some(pressure)) = (recorded(roles.speed), recorded(roles.manifold_pressure)) else {
        warnings.push(message!("engine {}: its speed or manifold pressure has no finite sample", quoted(name)));
        return Ok(None);
    };
    let history = model
        .history(&EngineColumns {
            speed_rad_s: &speed,
            manifold_pressure_pa: &pressure,
            airspeed_m_s: &air.airspeed_m_s,
            pressure_altitude_m: &air.altitude_m,
            air_temperature_k: &air.temperature_k,
            density_kg_m3: &air.density_kg_m3,
        })
        .map_err(|error| format!("engine '{name}': {error}"))?;
    let missing = history.thrust_n.iter().filter(|thrust| !thrust.is_finite()).count();
    if missing == history.thrust_n.len() {
        warnings.push(message!(
            "engine {}: speed, manifold pressure and air data are never recorded at the same time",
            quoted(name)
        ));
        return Ok(None);
    }
    if missing > 0 {
        warnings.push(message!(
            "engine {}: {} of {} samples omitted because an input is missing",
            quoted(name),
            missing,
            history.thrust_n.len()
        ));
    }
    for (finding, samples) in &history.off_range {
        warnings.push(message!("engine {}: {}, {} samples", quoted(name), finding.message(), *samples));
    }
    let monitor = recorded(roles.power);
    let agreement =
        monitor.as_ref().map(|monitor| agreement((&speed, &pressure, &history.power_w), monitor, air, phases));
    let in_flight = |values: &[f64]| -> Vec<f64> {
        let is_slow = air.airspeed_m_s.iter().map(|airspeed| *airspeed < GROUND_AIRSPEED_M_S);
        values.iter().zip(is_slow).map(|(&value, is_slow)| if is_slow { f64::NAN } else { value }).collect()
    };
    let typical = typical(&speed, &pressure, air);
    let series = |values: Vec<f64>| Series { time_s: Arc::clone(&air.time_s), values: values.into() };
    Ok(Some(EngineOverFlight {
        name: name.clone(),
        speed_rad_s: series(speed),
        manifold_pressure_pa: series(pressure),
        power_w: series(history.power_w),
        thrust_n: series(history.thrust_n),
        efficiency: series(history.efficiency),
        advance_ratio: series(in_flight(&history.advance_ratio)),
        thrust_coefficient: series(in_flight(&history.thrust_coefficient)),
        curves: propeller_curves(&model.propeller, typical.speed_rad_s, typical.pressure_altitude_m),
        typical,
        total_pressure_rise: series(in_flight(&history.total_pressure_rise)),
        monitor_power_w: monitor.map(series),
        agreement,
    }))
}

/// Medians of the inputs while the aircraft is fast.
fn typical(speed: &[f64], manifold_pressure: &[f64], air: &FlightAir) -> EnginePoint {
    let columns = [speed, manifold_pressure, &air.temperature_k, &air.altitude_m, &air.airspeed_m_s];
    let usable = |k: &usize| columns.iter().all(|column| column[*k].is_finite());
    let fast: Vec<usize> =
        (0..speed.len()).filter(usable).filter(|&k| air.airspeed_m_s[k] >= GROUND_AIRSPEED_M_S).collect();
    let used = if fast.is_empty() { (0..speed.len()).filter(usable).collect() } else { fast };
    let [speed_rad_s, manifold_pressure_pa, temperature_k, pressure_altitude_m, airspeed_m_s] =
        columns.map(|column| median(&mut used.iter().map(|&k| column[k]).collect::<Vec<f64>>()).unwrap_or(f64::NAN));
    let standard = Atmosphere::STANDARD;
    let standard_k = standard.temperature_k(pressure_altitude_m).unwrap_or(f64::NAN);
    let sea_level_temperature_k = standard.sea_level_temperature_k() + temperature_k - standard_k;
    EnginePoint { speed_rad_s, manifold_pressure_pa, sea_level_temperature_k, pressure_altitude_m, airspeed_m_s }
}

fn agreement(
    (speed, manifold_pressure, power): (&[f64], &[f64], &[f64]),
    monitor: &[f64],
    air: &FlightAir,
    phases: &[PhaseOfFlight],
) -> PowerAgreement {
    let variables: [(&str, &[f64]); 7] = [
        ("modelled_power", power),
        ("manifold_pressure", manifold_pressure),
        ("static_pressure", &air.pressure_pa),
        ("air_temperature", &air.temperature_k),
        ("engine_speed", speed),
        ("airspeed", &air.airspeed_m_s),
        ("altitude", &air.altitude_m),
    ];
    PowerAgreement {
        whole: compare_power(power, monitor),
        correlations: difference_correlation(power, monitor, &variables),
        phases: phase_table(&air.time_s, power, monitor, phases),
    }
}
