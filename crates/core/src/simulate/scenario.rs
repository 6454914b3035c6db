//! Scenarios: what is flown, in which air, with which instruments.

use nalgebra::Vector3;

use super::SimulateError;
use super::flight_plan;
use super::plan::{Manoeuvre, Segment};
use super::trim::TrimCondition;
use super::vehicle::Vehicle;
use crate::airframe::Loading;
use crate::atmos::Atmosphere;

/// Where a flight begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// On the ground with engines running.
    Parked,
    /// In steady level flight.
    Trimmed(TrimCondition),
}

/// How much of the truth is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TruthExtent {
    /// Every step.
    Whole,
    /// Every so many steps, within the recorded intervals of the manoeuvres only, positions in single precision and all else
    /// to 16 significant bits.
    Manoeuvres {
        /// Steps from one sample to the next.
        every: usize,
    },
}

/// Everything that makes a flight, but the seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Name.
    pub name: &'static str,
    /// One line on it.
    pub description: &'static str,
    /// Aircraft with its truth.
    pub vehicle: Vehicle,
    /// Loading at the start.
    pub loading: Loading,
    /// The day's atmosphere.
    pub atmosphere: Atmosphere,
    /// Steady wind, m/s.
    pub wind_ned_m_s: Vector3<f64>,
    /// Standard deviation of the gusts, m/s.
    pub gust_m_s: f64,
    /// Altitude of the ground, m.
    pub ground_m: f64,
    /// Start.
    pub start: Start,
    /// Segments in order of time.
    pub segments: Vec<Segment>,
    /// Manoeuvres in order of time.
    pub manoeuvres: Vec<Manoeuvre>,
    /// End, s.
    pub duration_s: f64,
    /// Step of the integration, s.
    pub step_s: f64,
    /// Time constant of each control's stretching cable or actuator, s.
    pub control_lag_s: f64,
    /// Largest unsteadiness of the vertical speed the pilot leaves before a manoeuvre, m/s.
    pub unsteadiness_m_s: f64,
    /// Rate of the air-data pod, Hz: 5, or the 1 it falls back to.
    pub pod_rate_hz: f64,
    /// Without noise, bias and resolution.
    pub exact_instruments: bool,
    /// Truth kept.
    pub truth: TruthExtent,
    /// UTC at bus time zero, as written in the pod's and the sensors' files, s of the day.
    pub utc_start_s: f64,
}

/// A scenario that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Name.
    pub name: &'static str,
    /// One line on it.
    pub description: &'static str,
}

/// Shipped scenarios.
const LISTED: [Listed; 8] = [
    Listed {
        name: "ft1",
        description: "C337F, 90 minutes from taxi to landing: 23 manoeuvres at 4,000 ft and 90 kt, six each at two more test points; truth at 100 Hz throughout",
    },
    Listed {
        name: "demo",
        description: "the same flight as shipped: without the waiting, truth to 16 bits and around the manoeuvres only",
    },
    Listed {
        name: "test-point",
        description: "C337F, from trim at 4,000 ft and 90 kt: six manoeuvres in four and a half minutes",
    },
    Listed {
        name: "test-point-1hz",
        description: "the same with the air-data pod at the 1 Hz it falls back to after a calibration",
    },
    Listed {
        name: "coverage",
        description: "C337F, from trim at 4,000 ft and 90 kt: the six manoeuvres of a test point twice over, 25 s apart",
    },
    Listed {
        name: "inputs",
        description: "C337F, from trim at 4,000 ft and 90 kt: every shape of input on the elevator",
    },
    Listed {
        name: "multisine",
        description: "C337F, from trim at 4,000 ft and 90 kt: orthogonal multisines on all three controls at once",
    },
    Listed {
        name: "sweeps",
        description: "C337F, from trim at 4,000 ft and 90 kt: sweeps of frequency on each control in turn",
    },
];

/// Shipped scenarios.
pub fn list() -> &'static [Listed] {
    &LISTED
}

/// Aircraft with an aerodynamic truth.
pub fn aircraft() -> &'static [&'static str] {
    &["c337f"]
}

/// The shipped scenario called `name`.
///
/// # Errors
/// [`SimulateError::UnknownScenario`]; for an aircraft, map or truth file that is not valid, its own error.
pub fn build(name: &str) -> Result<Scenario, SimulateError> {
    let Some(listed) = LISTED.iter().find(|listed| listed.name == name) else {
        let known = LISTED.iter().map(|listed| listed.name).collect();
        return Err(SimulateError::UnknownScenario { name: name.to_owned(), known });
    };
    let mut scenario = match listed.name {
        "test-point" | "test-point-1hz" => flight_plan::test_point(*listed)?,
        "coverage" => flight_plan::test_point_twice(*listed)?,
        "inputs" => flight_plan::all_inputs(*listed)?,
        "multisine" => flight_plan::multisine(*listed)?,
        "sweeps" => flight_plan::sweeps(*listed)?,
        _ => flight_plan::whole_flight(*listed)?,
    };
    match listed.name {
        "demo" => {
            flight_plan::shorten(&mut scenario);
            scenario.truth = TruthExtent::Manoeuvres { every: 1 };
        }
        "test-point-1hz" => scenario.pod_rate_hz = 1.0,
        _ => {}
    }
    Ok(scenario)
}
