//! The condition of a trim: what is asked for, the rest as flown.

use std::ops::Range;

use doublet_core::airframe::{InertiaTensor, MassProperties};
use doublet_core::atmos::Atmosphere;
use doublet_core::model::{Gyroscopic, Position, RECORDED, angular_momentum};
use doublet_core::propulsion::{Ambient, Engine, EngineModel};
use doublet_core::statistics::median;
use doublet_dynamics::linear::{Condition, FlightModel, SteadyFlight, UncertainModel, trim};

use super::{DynamicsRequest, ModelToTrim, StudyInput, window_key};
use crate::graph::{Context, StageResult};
use crate::session::WindowRole;
use crate::stage::{AircraftData, StudyWindow, WindowAero, condition_samples, mean_of_finite};

/// The condition that is asked for, what is left open being the median of the windows' conditions, and their names. A model about
/// the centre of gravity is one about that of these windows from here on.
pub fn condition(
    request: &DynamicsRequest,
    input: &StudyInput<'_>,
    model: &mut UncertainModel,
    notes: &mut Vec<String>,
) -> StageResult<(Condition, Vec<String>)> {
    let windows = windows(request, input)?;
    let flown = Flown::new(windows.iter().map(|window| &*window.aero));
    let gamma_rad = request.gamma_rad.or(model.model.has_thrust().then_some(0.0));
    let mut as_flown = flown.condition(input.settings.filter.gravity_m_s2, gamma_rad)?;
    model.model.moment_reference.get_or_insert(Position::Datum(as_flown.mass.cg_from_datum_m));
    let aircraft = windows.first().map_or(input.aircraft, |window| &window.aircraft);
    as_flown.mass = asked_mass(request, aircraft, as_flown.mass)?;
    let flight = match request.load_factor {
        None => SteadyFlight::Straight,
        Some(load_factor) if request.pull_up => SteadyFlight::PullUp(load_factor),
        Some(load_factor) => SteadyFlight::Turn(load_factor),
    };
    as_flown.flight = flight;
    let mut condition = as_flown.at_altitude(request.altitude_m.unwrap_or(as_flown.altitude_m));
    condition.airspeed_m_s = request.airspeed_m_s.unwrap_or(as_flown.airspeed_m_s);
    if model.model.has_thrust() {
        let engines = &input.aircraft.loaded.powerplant.engines;
        if !flown.set_thrust_slope(&model.model, engines, &mut condition)? {
            notes.push("thrust is constant over airspeed: no propeller map".to_owned());
        }
    } else {
        notes.push(
            "coefficients include thrust: the flight path follows from the power flown; phugoid, derivatives of \
             airspeed (CX_V, X_u) and stability of speed are not judged"
                .to_owned(),
        );
    }
    let lags = input.settings.preparation.control_lags;
    if lags != crate::session::ControlLags::default() {
        notes.push("inputs are deflections after the control lags, which the model omits".to_owned());
    }
    Ok((condition, windows.iter().map(|window| window.manoeuvre.name.clone()).collect()))
}

/// The identified model of a study and the median condition of its identification windows, level where the thrust is known.
pub fn level_model(input: &StudyInput<'_>, context: &Context<'_>) -> StageResult<(UncertainModel, Condition)> {
    let mut model = context.get::<ModelToTrim>((), input)?.model.clone();
    let (condition, _) = condition(&DynamicsRequest::default(), input, &mut model, &mut Vec::new())?;
    Ok((model, condition))
}

/// What a window without samples says.
const EMPTY: &str = "the manoeuvres of the trim have no samples";

fn windows<'a, 'b>(request: &DynamicsRequest, input: &'a StudyInput<'b>) -> StageResult<Vec<&'a StudyWindow<'b>>> {
    if let Some(key) = request.window {
        let window = input.windows.iter().find(|window| window_key(&window.manoeuvre.name) == key);
        return Ok(vec![window.ok_or_else(|| "the manoeuvre of the trim has no coefficients".to_owned())?]);
    }
    let used = input.windows.iter().filter(|window| window.manoeuvre.role == WindowRole::Identification);
    let used: Vec<_> = used.collect();
    if used.is_empty() { Err("no model: mark at least one manoeuvre as identification".into()) } else { Ok(used) }
}

/// Mass properties that are asked for.
fn asked_mass(
    request: &DynamicsRequest,
    aircraft: &AircraftData,
    flown: MassProperties,
) -> StageResult<MassProperties> {
    let mut mass = flown;
    if let Some(fuel_kg) = request.fuel_kg {
        let mut loading = aircraft.loading.clone();
        if loading.fuel_kg.values().sum::<f64>() <= 0.0 {
            // The session leaves the fuel to its recording: its parts are those of the standard loading.
            loading.fuel_kg.clone_from(&aircraft.loaded.aircraft.standard_loading.fuel_kg);
        }
        let stated: f64 = loading.fuel_kg.values().sum();
        if stated <= 0.0 {
            return Err("neither the loading nor the standard loading has fuel to change: state its tanks".into());
        }
        loading.fuel_kg.values_mut().for_each(|fuel| *fuel *= fuel_kg / stated);
        mass = loading.mass_properties(&aircraft.loaded.aircraft);
        if let Some(change) = &aircraft.mass_change {
            mass = mass.plus(change);
        }
        if let Some(issue) = loading.issues(&aircraft.loaded.aircraft, &mass).iter().find(|issue| issue.is_impossible())
        {
            return Err(issue.to_string().into());
        }
    }
    mass.mass_kg = request.mass_kg.unwrap_or(mass.mass_kg);
    mass.cg_from_datum_m[0] = request.cg_x_m.unwrap_or(mass.cg_from_datum_m[0]);
    Ok(mass)
}

/// Manoeuvres together, each with the samples of its flight condition.
pub struct Flown<'a> {
    windows: Vec<(&'a WindowAero, Range<usize>)>,
}

impl<'a> Flown<'a> {
    /// Manoeuvres by their coefficients.
    pub fn new(windows: impl IntoIterator<Item = &'a WindowAero>) -> Self {
        Self { windows: windows.into_iter().map(|aero| (aero, condition_samples(aero))).collect() }
    }

    /// The median condition, straight flight, thrust held.
    pub fn condition(&self, gravity_m_s2: f64, gamma_rad: Option<f64>) -> StageResult<Condition> {
        let altitude_m = self.column(|aero| aero.data.altitude_m.as_deref()).unwrap_or(0.0);
        let density_kg_m3 = self.column(|aero| Some(&aero.data.density_kg_m3)).ok_or(EMPTY)?;
        let airspeed_m_s = self.column(|aero| Some(&aero.data.airspeed_m_s)).ok_or(EMPTY)?;
        let speed_of_sound_m_s = match self.column(|aero| aero.data.mach.as_deref()) {
            Some(mach) if mach > 0.0 => airspeed_m_s / mach,
            _ => Atmosphere::STANDARD.speed_of_sound_m_s(altitude_m)?,
        };
        Ok(Condition {
            airspeed_m_s,
            altitude_m,
            density_kg_m3,
            speed_of_sound_m_s,
            gravity_m_s2,
            gamma_rad,
            flight: SteadyFlight::Straight,
            mass: self.mass(),
            thrust_slope_n_s_m: 0.0,
            pressure_rise_pa: self.pressure_rise_pa(),
            rotor_momentum_n_m_s: self.rotor_momentum(),
            recorded: RECORDED.map(|(_, role)| {
                self.column(|aero| aero.data.controls.get(&role).map(|column| &**column)).unwrap_or(0.0)
            }),
        })
    }

    /// Median over the manoeuvres of the mean of a value over the samples of each one's condition; none where no manoeuvre has it.
    fn median(&self, value: impl Fn(&WindowAero, usize) -> Option<f64>) -> Option<f64> {
        let means = self
            .windows
            .iter()
            .filter_map(|(aero, samples)| mean_of_finite(samples.clone().filter_map(|sample| value(aero, sample))));
        median(&mut means.collect::<Vec<f64>>())
    }

    /// The same of a column.
    fn column(&self, column: impl Fn(&WindowAero) -> Option<&[f64]>) -> Option<f64> {
        self.median(|aero, sample| column(aero)?.get(sample).copied())
    }

    /// Median of each mass property.
    fn mass(&self) -> MassProperties {
        let of = |value: &dyn Fn(&MassProperties) -> f64| {
            self.median(|aero, sample| Some(value(aero.data.mass.at(sample)))).unwrap_or(0.0)
        };
        MassProperties {
            mass_kg: of(&|mass| mass.mass_kg),
            cg_from_datum_m: [0, 1, 2].map(|axis| of(&|mass| mass.cg_from_datum_m[axis])),
            inertia: InertiaTensor {
                xx: of(&|mass| mass.inertia.xx),
                yy: of(&|mass| mass.inertia.yy),
                zz: of(&|mass| mass.inertia.zz),
                xz: of(&|mass| mass.inertia.xz),
                xy: of(&|mass| mass.inertia.xy),
                yz: of(&|mass| mass.inertia.yz),
            },
        }
    }

    /// Median of the total-pressure rise through the propellers, Pa; zero where it is not known.
    fn pressure_rise_pa(&self) -> f64 {
        let rise = |aero: &WindowAero, sample: usize| {
            let over = aero.data.propeller_pressure.as_ref()?.get(sample)?;
            Some(0.5 * over * aero.data.density_kg_m3[sample] * aero.data.airspeed_m_s[sample].powi(2))
        };
        self.median(rise).unwrap_or(0.0)
    }

    /// Median angular momentum of the rotors along body x, as the coefficients were formed with it, kg m²/s.
    fn rotor_momentum(&self) -> f64 {
        let momentum = |aero: &WindowAero, sample: usize| {
            let gyroscopic = aero.settings.gyroscopic;
            (gyroscopic != Gyroscopic::Ignored).then(|| angular_momentum(&aero.data.engines, gyroscopic, sample))
        };
        self.median(momentum).unwrap_or(0.0)
    }

    /// Median speed of the crankshaft of an engine, rad/s.
    fn engine_speed(&self, engine: usize) -> Option<f64> {
        self.median(|aero, sample| Some(aero.data.engines.get(engine)?.speed_rad_s.get(sample)?.abs()))
    }

    /// The median condition in level flight, thrust falling with airspeed as it does about the trim of `model` there.
    pub(crate) fn level_condition(
        &self,
        model: &FlightModel,
        engines: &[Engine],
        gravity_m_s2: f64,
    ) -> StageResult<Condition> {
        let mut condition = self.condition(gravity_m_s2, Some(0.0))?;
        self.set_thrust_slope(model, engines, &mut condition)?;
        Ok(condition)
    }

    /// Lets the thrust of a condition fall with airspeed as it does about the trim of `model` there; whether propeller maps say how, the
    /// thrust being held otherwise.
    pub(super) fn set_thrust_slope(
        &self,
        model: &FlightModel,
        engines: &[Engine],
        condition: &mut Condition,
    ) -> StageResult<bool> {
        let thrust_n = trim(model, condition).map_err(|error| error.to_string())?.thrust_n;
        let slope = self.thrust_slope(engines, condition, thrust_n);
        condition.thrust_slope_n_s_m = slope.unwrap_or(0.0);
        Ok(slope.is_some())
    }

    /// How the thrust of a trim changes with airspeed at constant power and engine speed, N s/m, by the propeller maps; none where an
    /// engine has none.
    fn thrust_slope(&self, engines: &[Engine], condition: &Condition, thrust_n: f64) -> Option<f64> {
        let share_n = thrust_n / engines.len().max(1) as f64;
        let slopes: Option<Vec<f64>> = engines
            .iter()
            .enumerate()
            .map(|(index, engine)| {
                slope_at_constant_power(engine.model.as_ref()?, self.engine_speed(index)?, condition, share_n)
            })
            .collect();
        slopes.filter(|slopes| !slopes.is_empty()).map(|slopes| slopes.iter().sum())
    }
}

/// Slope of one engine's thrust over airspeed about `thrust_n`.
fn slope_at_constant_power(model: &EngineModel, speed_rad_s: f64, condition: &Condition, thrust_n: f64) -> Option<f64> {
    /// Half the interval of the slope, m/s.
    const HALF_M_S: f64 = 0.5;
    let thrust = |power_w: f64, airspeed_m_s: f64| -> Option<f64> {
        Some(model.state_at_power(power_w, speed_rad_s, &ambient(condition, airspeed_m_s)?).thrust_n)
    };
    let speed = condition.airspeed_m_s;
    // Thrust grows with power: bisection from none to what would be thrust at an efficiency of a tenth.
    let (mut low, mut high) = (0.0, 10.0 * thrust_n.abs() * speed + 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if thrust(middle, speed)? < thrust_n { low = middle } else { high = middle }
    }
    let slope = (thrust(high, speed + HALF_M_S)? - thrust(high, speed - HALF_M_S)?) / (2.0 * HALF_M_S);
    slope.is_finite().then_some(slope)
}

fn ambient(condition: &Condition, airspeed_m_s: f64) -> Option<Ambient> {
    Some(Ambient {
        airspeed_m_s,
        pressure_altitude_m: condition.altitude_m,
        air_temperature_k: Atmosphere::STANDARD.temperature_k(condition.altitude_m).ok()?,
        density_kg_m3: condition.density_kg_m3,
    })
}
