//! Thrust, rotor momentum and total-pressure rise of the engines over one window.

use std::sync::Arc;

use doublet_core::message;
use doublet_core::message::{Message, quoted};
use doublet_core::model::{Engine, Position};
use doublet_core::propulsion::{EngineColumns, OffRange};
use doublet_core::quantity::Role;

use super::aircraft::AircraftData;
use super::window_context::WindowContext;
use crate::graph::StageResult;

pub(super) struct EngineRoles {
    pub(super) thrust: Role,
    pub(super) speed: Role,
    pub(super) manifold_pressure: Role,
    pub(super) power: Role,
}

/// Roles of each engine, in the order of the aircraft's stations.
pub(super) const ENGINES: [EngineRoles; 2] = [
    EngineRoles {
        thrust: Role::Thrust1,
        speed: Role::EngineSpeed1,
        manifold_pressure: Role::ManifoldPressure1,
        power: Role::Power1,
    },
    EngineRoles {
        thrust: Role::Thrust2,
        speed: Role::EngineSpeed2,
        manifold_pressure: Role::ManifoldPressure2,
        power: Role::Power2,
    },
];

/// Air the propellers work in, one value per sample.
pub struct Air<'a> {
    pub time_s: &'a [f64],
    /// True airspeed, m/s.
    pub airspeed_m_s: &'a [f64],
    /// Pressure altitude, m.
    pub altitude_m: &'a [f64],
    /// Static temperature, K.
    pub temperature_k: &'a [f64],
    pub density_kg_m3: &'a [f64],
}

/// What the engines do over a window.
#[derive(Default)]
pub struct Engines {
    /// Each engine whose thrust is recorded, or follows from its speed and manifold pressure.
    pub engines: Vec<Engine>,
    /// Total-pressure rise through all propellers over dynamic pressure (thesis Eq. 3.25), mean of the engines.
    pub propeller_pressure: Option<Arc<[f64]>>,
    /// Engines of the aircraft whose thrust is neither recorded nor follows from their map, where it is of others.
    pub unknown: Vec<String>,
    /// Engines whose thrust a chart or map extrapolates.
    pub extrapolated: Vec<ExtrapolatedThrust>,
    /// Findings, one line each.
    pub warnings: Vec<Message>,
}

/// Thrust beyond the range of an engine chart or propeller map.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtrapolatedThrust {
    pub engine: String,
    /// Each input that left the range with its furthest excursion, and the number of its samples outside.
    pub off_range: Vec<(OffRange, usize)>,
    /// What the extrapolation adds to the thrust of the inputs held at the edge of the range, N, one value per sample.
    pub added_n: Vec<f64>,
}

/// Recorded thrust where there is one, else thrust from engine chart and propeller map.
pub fn engines(window: &WindowContext, aircraft: &AircraftData, air: &Air<'_>) -> StageResult<Engines> {
    let mut result = Engines::default();
    let mut rises: Vec<Vec<f64>> = Vec::new();
    for (engine, roles) in aircraft.loaded.powerplant.engines.iter().zip(ENGINES) {
        let speed_rad_s = window.values(roles.speed)?.unwrap_or_default();
        let mut thrust = window.values(roles.thrust)?;
        let pressure = window.values(roles.manifold_pressure)?;
        if let (Some(model), Some(pressure), false) = (&engine.model, pressure, speed_rad_s.is_empty()) {
            let columns = EngineColumns {
                speed_rad_s: &speed_rad_s,
                manifold_pressure_pa: &pressure,
                airspeed_m_s: air.airspeed_m_s,
                pressure_altitude_m: air.altitude_m,
                air_temperature_k: air.temperature_k,
                density_kg_m3: air.density_kg_m3,
            };
            let history = model.history(&columns).map_err(|error| error.to_string())?;
            for (finding, samples) in &history.off_range {
                result.warnings.push(message!(
                    "engine {}: {}, {} samples",
                    quoted(&engine.station.name),
                    finding.message(),
                    *samples
                ));
            }
            rises.push(history.total_pressure_rise);
            if thrust.is_none() && !history.off_range.is_empty() {
                let pairs = history.thrust_n.iter().zip(&history.thrust_at_edge_n);
                result.extrapolated.push(ExtrapolatedThrust {
                    engine: engine.station.name.clone(),
                    off_range: history.off_range,
                    added_n: pairs.map(|(thrust, at_edge)| thrust - at_edge).collect(),
                });
            }
            thrust = thrust.or_else(|| Some(history.thrust_n.into()));
        }
        let Some(thrust_n) = thrust else {
            result.unknown.push(engine.station.name.clone());
            continue;
        };
        result.engines.push(Engine {
            thrust_n,
            position: Position::Datum(engine.station.position_from_datum_m),
            direction_body: engine.thrust_direction_body().into(),
            rotor_inertia_kg_m2: engine.rotation.sign() * engine.rotor_inertia_kg_m2,
            speed_rad_s,
        });
    }
    if aircraft.loaded.powerplant.engines.is_empty() {
        for roles in &ENGINES {
            if let Some(thrust_n) = window.values(roles.thrust)? {
                let name = roles.thrust.name();
                result.warnings.push(message!(
                    "{} is assumed along body x through the centre of gravity: the aircraft file has no engine",
                    name
                ));
                result.engines.push(along_x(thrust_n));
            }
        }
    }
    if result.engines.is_empty()
        && let Some(coefficient) = window.values(Role::ThrustCoefficient)?
    {
        result.engines.push(engine_of_coefficient(&coefficient, aircraft, air));
        result.unknown.clear();
    }
    if !rises.is_empty() {
        let count = rises.len() as f64;
        let mean = |sample: usize| rises.iter().map(|rise| rise[sample]).sum::<f64>() / count;
        result.propeller_pressure = Some((0..air.time_s.len()).map(mean).collect());
    }
    Ok(result)
}

/// All engines as one thrust along body x through the centre of gravity: a coefficient says neither place nor direction.
fn engine_of_coefficient(coefficient: &[f64], aircraft: &AircraftData, air: &Air<'_>) -> Engine {
    let area_m2 = aircraft.loaded.aircraft.reference.area_m2;
    let thrust = |(k, tc): (usize, &f64)| tc * 0.5 * air.density_kg_m3[k] * air.airspeed_m_s[k].powi(2) * area_m2;
    along_x(coefficient.iter().enumerate().map(thrust).collect())
}

/// A thrust along body x through the centre of gravity.
fn along_x(thrust_n: Arc<[f64]>) -> Engine {
    Engine {
        thrust_n,
        position: Position::BodyFromCg([0.0; 3]),
        direction_body: [1.0, 0.0, 0.0],
        rotor_inertia_kg_m2: 0.0,
        speed_rad_s: Arc::default(),
    }
}
