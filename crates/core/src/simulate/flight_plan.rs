//! The shipped flights: aircraft, loading, segments and manoeuvres.

use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;

use super::SimulateError;
use super::inputs::{Hand, InputKind};
use super::instrument_errors::InstrumentErrors;
use super::plan::{DesignedInput, Manoeuvre, Power, Segment, Task};
use super::scenario::{Listed, Scenario, Start, TruthExtent};
use super::trim::TrimCondition;
use super::vehicle::{Surface, Vehicle};
use crate::airframe::{Aircraft, Loading};
use crate::atmos::Atmosphere;
use crate::load;
use crate::propulsion::{Engine, EngineInput, EngineModel, Powerplant, Rotation};

const AIRCRAFT: &str = include_str!("../../../../assets/aircraft/c337f.toml");
const TRUTH: &str = include_str!("../../../../assets/aircraft/c337f_truth.toml");
const CHART: &str = include_str!("../../../../assets/propulsion/io360_chart.toml");
const PROPELLER: &str = include_str!("../../../../assets/propulsion/mtv12_propeller.toml");

/// Rotating inertia of a propeller about its axis, kg m² (thesis section 5.2.1).
const ROTOR_INERTIA_KG_M2: f64 = 7.7;
/// Angular speed of one revolution per minute, rad/s.
const RPM: f64 = std::f64::consts::TAU / 60.0;
/// Pressure of an inch of mercury, Pa.
const IN_HG: f64 = 3386.389;
/// Length of a foot, m.
const FT: f64 = 0.3048;
/// Speed of a knot, m/s.
const KT: f64 = 1852.0 / 3600.0;
/// Engine speed of level flight, rev/min: that of the test points of thesis Table 6.11, 2350, is below the propeller map, which begins
/// at 2400.
const LEVEL_RPM: f64 = 2420.0;
/// Sea-level temperature of the day (thesis Table 7.14), K.
const SEA_LEVEL_K: f64 = 296.65;

/// The C337F with the shipped truth.
pub fn c337f() -> Result<(Vehicle, Loading), SimulateError> {
    let invalid = |what, reason: String| SimulateError::Model { what, reason };
    let aircraft: Aircraft =
        load::aircraft::parse(AIRCRAFT).map_err(|error| invalid("aircraft file", error.to_string()))?;
    let chart = load::propulsion_maps::parse_engine_chart(CHART, Path::new("io360_chart.toml"))
        .map_err(|error| invalid("engine chart", error.to_string()))?;
    let propeller = load::propulsion_maps::parse_propeller_map(PROPELLER, Path::new("mtv12_propeller.toml"))
        .map_err(|error| invalid("propeller map", error.to_string()))?;
    let model = EngineModel { chart: Arc::new(chart), propeller: Arc::new(propeller) };
    let rotations = [Rotation::Clockwise, Rotation::CounterClockwise];
    let engines = aircraft.engines.iter().zip(rotations).map(|(station, rotation)| Engine {
        station: station.clone(),
        rotation,
        rotor_inertia_kg_m2: ROTOR_INERTIA_KG_M2,
        model: Some(model.clone()),
    });
    let powerplant = Powerplant { engines: engines.collect() };
    let mut loading = aircraft.standard_loading.clone();
    // Flight FT1.0: four aboard, mains and auxiliaries so that mass and fuel of the test points come out (thesis 7.2.1).
    for tank in &aircraft.tanks {
        let fuel_kg = if tank.capacity_kg > 100.0 { 127.0 } else { 50.45 };
        loading.fuel_kg.insert(tank.name.clone(), fuel_kg);
    }
    for seat in &aircraft.seats {
        loading.seats_kg.insert(seat.name.clone(), 74.7);
    }
    for bay in &aircraft.luggage {
        loading.luggage_kg.insert(bay.name.clone(), 21.0);
    }
    Ok((Vehicle::new(aircraft, powerplant, TRUTH)?, loading))
}

/// Inputs of both engines from rpm and inHg.
fn engines(rpm: [f64; 2], in_hg: [f64; 2]) -> [EngineInput; 2] {
    [0, 1].map(|i| EngineInput { speed_rad_s: rpm[i] * RPM, manifold_pressure_pa: in_hg[i] * IN_HG })
}

/// Settings shared by the shipped flights.
fn common(listed: Listed) -> Result<Scenario, SimulateError> {
    let (vehicle, loading) = c337f()?;
    let atmosphere = Atmosphere::new(101_325.0, SEA_LEVEL_K)
        .map_err(|error| SimulateError::Model { what: "atmosphere", reason: error.to_string() })?;
    Ok(Scenario {
        name: listed.name,
        description: listed.description,
        vehicle,
        loading,
        atmosphere,
        wind_ned_m_s: Vector3::new(3.0, -4.0, 0.0),
        gust_m_s: 0.05,
        ground_m: 5.0,
        start: Start::Parked,
        segments: Vec::new(),
        manoeuvres: Vec::new(),
        duration_s: 0.0,
        step_s: 0.01,
        control_lag_s: 0.0,
        unsteadiness_m_s: 0.8,
        pod_rate_hz: 5.0,
        exact_instruments: false,
        sensor_accuracy: InstrumentErrors::default(),
        truth: TruthExtent::Whole,
        utc_start_s: 13.0 * 3600.0 + 42.0 * 60.0 + 7.25,
    })
}

/// A manoeuvre by surface and shape; the sign of `amplitude_deg` is that of the first pulse.
fn manoeuvre(surface: Surface, kind: InputKind, amplitude_deg: f64, onset_s: f64, test_point: u8) -> Manoeuvre {
    let dt_s = match (surface, kind) {
        (Surface::Elevator, InputKind::Doublet) => 0.9,
        (Surface::Elevator, _) => 0.6,
        (Surface::Aileron, InputKind::Doublet) => 1.0,
        (Surface::Aileron, _) => 0.6,
        (Surface::Rudder, InputKind::Doublet) => 1.4,
        (Surface::Rudder, _) => 0.9,
    };
    let amplitude_rad = amplitude_deg.to_radians();
    Manoeuvre {
        surface,
        kind,
        amplitude_rad,
        dt_s,
        onset_s,
        hand: Hand::PILOT,
        spoilt: false,
        test_point,
        designed: None,
    }
}

use InputKind::{Doublet, ThreeTwoOneOne};
use Surface::{Aileron, Elevator, Rudder};

/// The six manoeuvres of one test point (thesis section 4.4.1).
const SIX: [(Surface, InputKind, f64); 6] = [
    (Aileron, Doublet, 4.0),
    (Aileron, ThreeTwoOneOne, -3.5),
    (Elevator, Doublet, 2.0),
    (Elevator, ThreeTwoOneOne, 1.8),
    (Rudder, Doublet, 2.8),
    (Rudder, ThreeTwoOneOne, -2.5),
];

/// The manoeuvres of flight FT1.0 (thesis section 4.4.2): three doublets each, three, five and five 3-2-1-1 used, and one
/// aileron 3-2-1-1 flown badly and discarded (the tenth).
const FT1: [(Surface, InputKind, f64); 23] = [
    (Aileron, Doublet, 4.0),
    (Aileron, Doublet, -4.0),
    (Elevator, Doublet, 2.0),
    (Elevator, Doublet, 1.8),
    (Rudder, Doublet, 2.8),
    (Rudder, Doublet, -2.8),
    (Elevator, ThreeTwoOneOne, 1.8),
    (Elevator, ThreeTwoOneOne, 1.6),
    (Aileron, ThreeTwoOneOne, 3.5),
    (Aileron, ThreeTwoOneOne, -3.5),
    (Aileron, ThreeTwoOneOne, -3.5),
    (Rudder, ThreeTwoOneOne, 2.5),
    (Rudder, ThreeTwoOneOne, -2.5),
    (Aileron, Doublet, 4.5),
    (Elevator, Doublet, -2.0),
    (Rudder, Doublet, 2.5),
    (Elevator, ThreeTwoOneOne, 1.8),
    (Elevator, ThreeTwoOneOne, -1.6),
    (Elevator, ThreeTwoOneOne, 1.7),
    (Aileron, ThreeTwoOneOne, 3.2),
    (Rudder, ThreeTwoOneOne, 2.6),
    (Rudder, ThreeTwoOneOne, -2.4),
    (Rudder, ThreeTwoOneOne, 2.2),
];
/// Which of them is spoilt.
const SPOILT: usize = 9;

/// A flight from trim at the main test point.
fn from_trim(listed: Listed, duration_s: f64, manoeuvres: Vec<Manoeuvre>) -> Result<Scenario, SimulateError> {
    let mut scenario = common(listed)?;
    let (altitude_m, airspeed_m_s, speed_rad_s) = (4000.0 * FT, 90.0 * KT, LEVEL_RPM * RPM);
    scenario.start = Start::Trimmed(TrimCondition {
        airspeed_m_s,
        altitude_m,
        heading_rad: 0.0,
        engine_speed_rad_s: speed_rad_s,
        wind_ned_m_s: scenario.wind_ned_m_s,
    });
    let power = Power::Airspeed { airspeed_m_s, speed_rad_s };
    let task = Task::Level { altitude_m, rate_m_s: 2.5, power };
    scenario.segments = vec![Segment { start_s: 0.0, phase: "testing", task, heading_rad: 0.0 }];
    scenario.manoeuvres = manoeuvres;
    scenario.duration_s = duration_s;
    Ok(scenario)
}

/// Manoeuvres 45 s apart, the first at `first_s`.
fn series(
    what: &[(Surface, InputKind, f64)],
    first_s: f64,
    scale: f64,
    test_point: u8,
) -> impl Iterator<Item = Manoeuvre> + '_ {
    let numbered = what.iter().zip(0u32..);
    numbered.map(move |(&(surface, kind, deg), k)| {
        manoeuvre(surface, kind, scale * deg, first_s + 45.0 * f64::from(k), test_point)
    })
}

/// Six manoeuvres from trim at the main test point.
pub fn test_point(listed: Listed) -> Result<Scenario, SimulateError> {
    from_trim(listed, 270.0, series(&SIX, 20.0, 1.0, 1).collect())
}

/// The six manoeuvres of a test point twice over, the second time with the other sign, as close together as the pilot can fly them.
pub(crate) fn test_point_twice(listed: Listed) -> Result<Scenario, SimulateError> {
    /// From one onset to the next, s: the held controls and as long again to come back to trim.
    const INTERVAL_S: f64 = 25.0;
    let again = SIX.map(|(surface, kind, deg)| (surface, kind, -deg));
    let both: Vec<_> = SIX.into_iter().chain(again).collect();
    let mut manoeuvres: Vec<Manoeuvre> = series(&both, 0.0, 1.0, 1).collect();
    for (manoeuvre, k) in manoeuvres.iter_mut().zip(0u32..) {
        manoeuvre.onset_s = 10.0 + INTERVAL_S * f64::from(k);
    }
    from_trim(listed, 10.0 + INTERVAL_S * both.len() as f64, manoeuvres)
}

/// Designed inputs one after the other from trim at a true airspeed (m/s) and altitude (m), `rest_s` between them, each at a condition of its
/// own, to which the pilot goes before it.
pub fn designed(
    listed: Listed,
    base: (f64, f64),
    inputs: Vec<((f64, f64), DesignedInput)>,
    rest_s: f64,
) -> Result<Scenario, SimulateError> {
    let (mut onset_s, mut end_s, mut about) = (FIRST_ONSET_S, 0.0, base);
    let (mut manoeuvres, mut changes) = (Vec::with_capacity(inputs.len()), Vec::new());
    for (condition, input) in inputs {
        if condition != about {
            changes.push((end_s, condition));
            onset_s += transit_s(about, condition);
            about = condition;
        }
        let surface = input.surfaces().next().unwrap_or(Elevator);
        let held_s = input.held_s;
        let own = manoeuvre(surface, InputKind::Designed, 0.0, onset_s, 1);
        manoeuvres.push(Manoeuvre { hand: Hand::PERFECT, designed: Some(Arc::new(input)), ..own });
        end_s = onset_s + held_s + Manoeuvre::MARGIN_S;
        onset_s += held_s + rest_s.max(2.0 * Manoeuvre::MARGIN_S);
    }
    let mut scenario = from_trim(listed, onset_s, manoeuvres)?;
    let Start::Trimmed(condition) = &mut scenario.start else { return Ok(scenario) };
    (condition.airspeed_m_s, condition.altitude_m) = base;
    let speed_rad_s = condition.engine_speed_rad_s;
    let segment = |(start_s, (airspeed_m_s, altitude_m))| {
        let power = Power::Airspeed { airspeed_m_s, speed_rad_s };
        let task = Task::Level { altitude_m, rate_m_s: LEVEL_RATE_M_S, power };
        Segment { start_s, phase: "testing", task, heading_rad: 0.0 }
    };
    scenario.segments = std::iter::once((0.0, base)).chain(changes).map(segment).collect();
    Ok(scenario)
}

/// Time to go from one airspeed (m/s) and altitude (m) to another and to settle there, s.
fn transit_s(from: (f64, f64), to: (f64, f64)) -> f64 {
    /// Time to settle, s; and per change of airspeed, s²/m.
    const SETTLE: (f64, f64) = (45.0, 5.0);
    SETTLE.0 + SETTLE.1 * (to.0 - from.0).abs() + 1.25 * (to.1 - from.1).abs() / LEVEL_RATE_M_S
}

/// Greatest rate of climb or descent between designed inputs, m/s.
const LEVEL_RATE_M_S: f64 = 2.5;
/// Onset of the first of designed inputs, s.
const FIRST_ONSET_S: f64 = 20.0;

/// Every shape on the elevator, flown perfectly.
pub(crate) fn all_inputs(listed: Listed) -> Result<Scenario, SimulateError> {
    let one_surface = InputKind::ALL.iter().filter(|&&kind| kind != InputKind::Multisine && !kind.is_sweep());
    let shapes: Vec<_> = one_surface.map(|&kind| (Elevator, kind, 1.5)).collect();
    let perfect = series(&shapes, 20.0, 1.0, 1).map(|manoeuvre| Manoeuvre { hand: Hand::PERFECT, ..manoeuvre });
    from_trim(listed, 320.0, perfect.collect())
}

/// Orthogonal multisines on all controls.
pub fn multisine(listed: Listed) -> Result<Scenario, SimulateError> {
    let all = manoeuvre(Elevator, InputKind::Multisine, 1.5, 20.0, 1);
    from_trim(listed, 55.0, vec![Manoeuvre { dt_s: 1.0, hand: Hand::PERFECT, ..all }])
}

/// Sweeps on each control in turn, flown perfectly: by factors on all three, then by differences on the elevator.
pub fn sweeps(listed: Listed) -> Result<Scenario, SimulateError> {
    /// From one onset to the next, s: the sweep, its rest and the way back to trim.
    const INTERVAL_S: f64 = 95.0;
    use InputKind::{LinearSweep, LogarithmicSweep};
    let shapes = [
        (Elevator, LogarithmicSweep, 0.8),
        (Aileron, LogarithmicSweep, 1.0),
        (Rudder, LogarithmicSweep, 1.0),
        (Elevator, LinearSweep, 0.8),
    ];
    let flown = shapes.into_iter().zip(0u32..).map(|((surface, kind, deg), k)| Manoeuvre {
        dt_s: 1.0,
        hand: Hand::PERFECT,
        ..manoeuvre(surface, kind, deg, 20.0 + INTERVAL_S * f64::from(k), 1)
    });
    from_trim(listed, 20.0 + INTERVAL_S * shapes.len() as f64, flown.collect())
}

/// Taxi to landing (thesis section 4.4.2, phases of Table 6.11).
pub(crate) fn whole_flight(listed: Listed) -> Result<Scenario, SimulateError> {
    let mut scenario = common(listed)?;
    scenario.segments = segments();
    let main = FT1
        .iter()
        .zip(0u32..)
        .map(|(&(surface, kind, deg), k)| manoeuvre(surface, kind, deg, 1760.0 + 60.0 * f64::from(k), 1));
    scenario.manoeuvres = main.collect();
    scenario.manoeuvres[SPOILT].spoilt = true;
    scenario.manoeuvres[SPOILT].hand = Hand { time_spread: 0.45, amplitude_spread: 0.4, transition_s: 0.6 };
    for (test_point, first_s) in [(2, 3420.0), (3, 4060.0)] {
        scenario.manoeuvres.extend(series(&SIX, first_s, 0.8, test_point));
    }
    scenario.duration_s = 5400.0;
    Ok(scenario)
}

/// Leaves out waiting before take-off and transit before the pod's calibration: the same flight in 78 minutes.
pub fn shorten(scenario: &mut Scenario) {
    /// Time from which everything comes earlier, and by how much, s.
    const CUTS: [(f64, f64); 2] = [(690.0, 300.0), (1540.0, 400.0)];
    let earlier =
        |time_s: f64| -> f64 { time_s - CUTS.iter().filter(|cut| cut.0 <= time_s).map(|cut| cut.1).sum::<f64>() };
    scenario.segments.iter_mut().for_each(|segment| segment.start_s = earlier(segment.start_s));
    scenario.manoeuvres.iter_mut().for_each(|manoeuvre| manoeuvre.onset_s = earlier(manoeuvre.onset_s));
    scenario.duration_s = earlier(scenario.duration_s);
}

/// Segments of the whole flight; engine settings of thesis Table 6.11 but for level flight.
fn segments() -> Vec<Segment> {
    let heading = 25f64.to_radians();
    let idle = engines([1100.0, 1080.0], [17.1, 17.0]);
    let climb = engines([2509.0, 2510.0], [24.8, 24.6]);
    let climb_to = |altitude_ft: f64| Task::Climb { altitude_m: altitude_ft * FT, airspeed_m_s: 58.0, engines: climb };
    let taxi = Task::Ground { speed_m_s: 6.0, engines: engines([1180.0, 1180.0], [17.2, 16.2]) };
    let run_up = Task::Ground { speed_m_s: 0.0, engines: engines([1770.0, 1780.0], [18.9, 16.6]) };
    let stand = Task::Ground { speed_m_s: 0.0, engines: idle };
    let take_off = Task::TakeOff { engines: engines([2770.0, 2730.0], [27.9, 27.9]), rotate_m_s: 37.0 };
    let cruise = level_at_power(2500.0, 2.5, engines([2330.0, 2340.0], [24.7, 24.5]));
    let descent = level_at_power(1000.0, 2.5, engines([2300.0, 2290.0], [24.7, 24.8]));
    let landing = Task::Land { airspeed_m_s: 46.0, rate_m_s: 3.0, engines: engines([1960.0, 2174.0], [12.7, 15.2]) };
    [
        (0.0, "idle", stand, 0.0),
        (60.0, "taxi", taxi, 0.0),
        (220.0, "engine run up", run_up, 0.0),
        (320.0, "idle", stand, 0.0),
        (690.0, "take-off", take_off, 0.0),
        (740.0, "climb", climb_to(4000.0), 25.0),
        (1040.0, "transit", level(4000.0, 110.0), 205.0),
        (1540.0, "pod calibration", level(4000.0, 86.0), 205.0),
        (1680.0, "testing", level(4000.0, 90.0), 205.0),
        (3120.0, "climb", climb_to(6500.0), 25.0),
        (3320.0, "testing", level(6500.0, 117.0), 25.0),
        (3680.0, "transit", level(2500.0, 110.0), 25.0),
        (3990.0, "testing", level(2500.0, 101.0), 25.0),
        (4310.0, "cruise", cruise, 25.0),
        (4600.0, "descent", descent, 25.0),
        (4790.0, "approach", level(1000.0, 92.0), 0.0),
        (4910.0, "landing", landing, 0.0),
        (5110.0, "taxi", taxi, 0.0),
        (5290.0, "idle", stand, 0.0),
    ]
    .into_iter()
    .map(|(start_s, phase, task, degrees)| {
        let heading_rad = if degrees == 0.0 { heading } else { f64::to_radians(degrees) };
        Segment { start_s, phase, task, heading_rad }
    })
    .collect()
}

fn level_at_power(altitude_ft: f64, rate_m_s: f64, engines: [EngineInput; 2]) -> Task {
    Task::Level { altitude_m: altitude_ft * FT, rate_m_s, power: Power::Fixed(engines) }
}

fn level(altitude_ft: f64, airspeed_kt: f64) -> Task {
    Task::Level {
        altitude_m: altitude_ft * FT,
        rate_m_s: 4.0,
        power: Power::Airspeed { airspeed_m_s: airspeed_kt * KT, speed_rad_s: LEVEL_RPM * RPM },
    }
}
