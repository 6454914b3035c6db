//! What the coefficients of a window need beside its path: recorded channels and mass properties at the samples of the filter.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::airframe::MassHistory;
use doublet_core::model::RECORDED;
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{FilterData, Input};
use doublet_core::series::{Recording, TimeRange};

use super::aero::CONTROLS;
use super::aircraft::AircraftData;
use super::engines::ENGINES;
use super::recording::LoadedFlight;
use super::samples::values_at;
use super::window_samples::Samples;
use crate::graph::{Context, Footprint, Keyed, Stage, StageResult};
use crate::session::{Preparation, Surface};

/// Channels of the air that the coefficients may need.
const AIR: [Role; 7] = [
    Role::Altitude,
    Role::GpsAltitude,
    Role::AirDensity,
    Role::StaticPressure,
    Role::AirTemperature,
    Role::Mach,
    Role::ThrustCoefficient,
];

/// Recorded angular accelerations, with the rates they belong to.
pub const ANGULAR_ACCELERATIONS: [(Role, Role); 3] = [
    (Role::RollAcceleration, Role::RollRate),
    (Role::PitchAcceleration, Role::PitchRate),
    (Role::YawAcceleration, Role::YawRate),
];

/// Recorded channels and mass properties over a window: no filter setting changes them.
#[derive(Clone, Debug)]
pub struct WindowContext {
    /// First sample of the filter behind the settling.
    pub first: usize,
    /// Times of the samples from there on, s.
    pub time_s: Arc<[f64]>,
    /// Parts that are left out.
    pub excluded: Arc<[TimeRange]>,
    /// Mass properties at these times, or why there are none.
    pub mass: StageResult<MassHistory>,
    channels: BTreeMap<Role, StageResult<Arc<[f64]>>>,
}

impl Footprint for WindowContext {
    fn bytes(&self) -> usize {
        let mass = if matches!(self.mass, Ok(MassHistory::PerSample(_))) { 10 } else { 0 };
        self.time_s.len() * (1 + self.channels.len() + mass) * 8
    }
}

impl Stage for WindowContext {
    type Params<'a> = &'a Preparation;
    type Inputs<'a> = (&'a Keyed<LoadedFlight>, &'a Keyed<Samples>, &'a Keyed<AircraftData>);
    type Output = Self;
    const NAME: &'static str = "window context";

    fn run(preparation: &Preparation, inputs: Self::Inputs<'_>, _: &Context<'_>) -> StageResult<Self> {
        let (flight, samples, aircraft) = inputs;
        Self::new(&flight.recording, (&samples.data, &samples.excluded), aircraft, preparation)
    }
}

impl WindowContext {
    /// What was recorded around the samples `data` of a window of which parts are left out.
    pub fn new(
        recording: &Recording,
        (data, excluded): (&FilterData, &[TimeRange]),
        aircraft: &AircraftData,
        preparation: &Preparation,
    ) -> StageResult<Self> {
        let times = &data.inputs.time_s;
        let start = times.first().copied().unwrap_or(0.0) + preparation.settle_s;
        let first = times.partition_point(|&time| time < start);
        if first >= times.len() {
            let settle_s = preparation.settle_s;
            return Err(format!("no samples left after {settle_s} s of settling: shorten the settling").into());
        }
        let time_s: Arc<[f64]> = if first == 0 { Arc::clone(times) } else { times[first..].into() };
        let engines = ENGINES.iter().flat_map(|engine| [engine.thrust, engine.speed, engine.manifold_pressure]);
        let accelerations = ANGULAR_ACCELERATIONS.map(|(acceleration, _)| acceleration);
        let motion = Input::ALL.into_iter().map(Input::role).chain(accelerations);
        let configuration = RECORDED.map(|(_, role)| role);
        let roles = motion.chain(CONTROLS.map(Surface::role)).chain(configuration).chain(AIR).chain(engines);
        let values = |role: Role| {
            let found = values_at(recording, role, &time_s).transpose()?;
            // What the filter has as it was recorded is kept once.
            let same = |values: &Arc<[f64]>| data.inputs.columns.iter().find(|column| *column == values).cloned();
            Some((role, found.map(|values| same(&values).unwrap_or(values))))
        };
        Ok(Self {
            first,
            excluded: excluded.into(),
            channels: roles.filter_map(values).collect(),
            mass: aircraft.mass_history(recording, &time_s),
            time_s,
        })
    }

    /// Values of `role` at the samples; `None` when it was not recorded.
    pub fn values(&self, role: Role) -> StageResult<Option<Arc<[f64]>>> {
        self.channels.get(&role).cloned().transpose()
    }
}
