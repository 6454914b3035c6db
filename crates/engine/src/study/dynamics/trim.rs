//! The condition of a trim: what is asked for, the rest as flown.

use doublet_core::airframe::{InertiaTensor, MassProperties};
use doublet_core::atmos::Atmosphere;
use doublet_core::model::{Gyroscopic, Position, RECORDED, angular_momentum};
use doublet_core::propulsion::{Ambient, Engine, EngineModel};
use doublet_core::statistics::median;
use doublet_dynamics::linear::{Condition, FlightModel, SteadyFlight, UncertainModel, trim};

use super::{DynamicsRequest, ModelToTrim, StudyInput, window_key};
use crate::graph::{Context, StageResult};
use crate::session::WindowRole;
use crate::stage::{AircraftData, StudyWindow, WindowAero};

/// The condition that is asked for, what is left open being the median over the samples of the windows, and their names. A model about
/// the centre of gravity is one about that of these windows from here on.
///
/// # Errors
/// One line: a window that is not there or has no coefficients, a loading that is impossible.
pub fn condition(
    request: &DynamicsRequest,
    input: &StudyInput<'_>,
    model: &mut UncertainModel,
    notes: &mut Vec<String>,
) -> StageResult<(Condition, Vec<String>)> {
    let windows = windows(request, input)?;
    let flown = Flown { windows: windows.iter().map(|window| &*window.aero).collect() };
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
///
/// # Errors
/// One line: no model, no trim.
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

/// Samples of windows together.
pub struct Flown<'a> {
    /// Coefficients of the windows.
    pub windows: Vec<&'a WindowAero>,
}

impl Flown<'_> {
    /// The median condition, straight flight, thrust held.
    ///
    /// # Errors
    /// One line: no samples, or an altitude beyond the standard atmosphere where no Mach number tells the speed of sound.
    pub fn condition(&self, gravity_m_s2: f64, gamma_rad: Option<f64>) -> StageResult<Condition> {
        let altitude_m = self.median(|aero| aero.data.altitude_m.as_deref()).unwrap_or(0.0);
        let density_kg_m3 = self.median(|aero| Some(&aero.data.density_kg_m3)).ok_or(EMPTY)?;
        let airspeed_m_s = self.median(|aero| Some(&aero.data.airspeed_m_s)).ok_or(EMPTY)?;
        let speed_of_sound_m_s = match self.median(|aero| aero.data.mach.as_deref()) {
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
                self.median(|aero| aero.data.controls.get(&role).map(|column| &**column)).unwrap_or(0.0)
            }),
        })
    }

    /// Median of a column over all windows that have it.
    fn median<'c>(&'c self, column: impl Fn(&'c WindowAero) -> Option<&'c [f64]>) -> Option<f64> {
        let mut values: Vec<f64> = self.windows.iter().filter_map(|aero| column(aero)).flatten().copied().collect();
        median(&mut values)
    }

    /// Median of each mass property.
    fn mass(&self) -> MassProperties {
        MassProperties {
            mass_kg: self.median_of(&|mass| mass.mass_kg),
            cg_from_datum_m: [0, 1, 2].map(|axis| self.median_of(&|mass| mass.cg_from_datum_m[axis])),
            inertia: InertiaTensor {
                xx: self.median_of(&|mass| mass.inertia.xx),
                yy: self.median_of(&|mass| mass.inertia.yy),
                zz: self.median_of(&|mass| mass.inertia.zz),
                xz: self.median_of(&|mass| mass.inertia.xz),
                xy: self.median_of(&|mass| mass.inertia.xy),
                yz: self.median_of(&|mass| mass.inertia.yz),
            },
        }
    }

    fn median_of(&self, value: &dyn Fn(&MassProperties) -> f64) -> f64 {
        let each = self
            .windows
            .iter()
            .flat_map(|aero| (0..aero.data.time_s.len()).map(|k| value(aero.data.mass.at(k))).collect::<Vec<_>>());
        median(&mut each.collect::<Vec<_>>()).unwrap_or(0.0)
    }

    /// Median of the total-pressure rise through the propellers, Pa; zero where it is not known.
    fn pressure_rise_pa(&self) -> f64 {
        let rises = self.windows.iter().filter_map(|aero| {
            let over = aero.data.propeller_pressure.as_ref()?;
            let pressure =
                aero.data.airspeed_m_s.iter().zip(aero.data.density_kg_m3.iter()).map(|(v, rho)| 0.5 * rho * v * v);
            Some(over.iter().zip(pressure).map(|(over, pressure)| over * pressure).collect::<Vec<_>>())
        });
        median(&mut rises.flatten().collect::<Vec<_>>()).unwrap_or(0.0)
    }

    /// Median angular momentum of the rotors along body x, as the coefficients were formed with it, kg m²/s.
    fn rotor_momentum(&self) -> f64 {
        let mut all = Vec::new();
        for aero in &self.windows {
            let gyroscopic = aero.settings.gyroscopic;
            if gyroscopic != Gyroscopic::Ignored {
                let samples = 0..aero.data.time_s.len();
                all.extend(samples.map(|k| angular_momentum(&aero.data.engines, gyroscopic, k)));
            }
        }
        median(&mut all).unwrap_or(0.0)
    }

    /// Median speed of the crankshaft of an engine, rad/s.
    fn engine_speed(&self, engine: usize) -> Option<f64> {
        let speeds = self.windows.iter().filter_map(|aero| aero.data.engines.get(engine));
        let mut values: Vec<f64> =
            speeds.flat_map(|engine| engine.speed_rad_s.iter().map(|speed| speed.abs())).collect();
        median(&mut values)
    }

    /// The median condition in level flight, thrust falling with airspeed as it does about the trim of `model` there.
    ///
    /// # Errors
    /// As [`Flown::condition`], and without a trim.
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
    ///
    /// # Errors
    /// One line without a trim.
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
