//! What was on board when it was flown: at the start and the end of each flight, and in the middle of its windows.

use doublet_core::airframe::{LoadedState, Loading};

use super::aircraft::AircraftData;
use super::recording::LoadedFlight;
use crate::graph::{Context, Footprint, Keyed, Stage, StageResult};
use crate::session::Manoeuvre;

/// The aircraft at one time of a flight.
#[derive(Clone, Debug)]
pub struct FlownState {
    pub time_s: f64,
    /// What was on board.
    pub loading: Loading,
    /// Mass properties, and where they lie in the envelope.
    pub state: LoadedState,
}

/// What a recording tells of the fuel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FuelRecord {
    /// Fuel of each tank.
    Tanks,
    /// Fuel in all.
    Total,
    Flow,
    /// Nothing.
    None,
}

/// Where the fuel of a flight comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct FuelSource {
    /// What is recorded and used; nothing where the loading has no fuel.
    pub record: FuelRecord,
    /// Whether the session states what was on board at the first record.
    pub is_stated: bool,
    /// What the session's statement adds to the recorded fuel, tank by tank or, without a tank, in all, kg; those that it changes.
    pub shifts_kg: Vec<(Option<String>, f64)>,
    /// Highest minus lowest recorded fuel, where no record of it is used, kg.
    pub unused_range_kg: Option<f64>,
}

impl FuelSource {
    /// In words.
    pub fn description(&self) -> &'static str {
        match (self.record, self.is_stated) {
            (FuelRecord::Tanks, false) => "recorded fuel of each tank",
            (FuelRecord::Tanks, true) => "recorded fuel of each tank, shifted to the stated fuel at the first record",
            (FuelRecord::Total, false) => "recorded total fuel, divided among the tanks as in the loading",
            (FuelRecord::Total, true) => "stated fuel at the first record minus the recorded burn",
            (FuelRecord::Flow, _) => "fuel of the loading at the first record minus the recorded flow",
            (FuelRecord::None, _) => "fuel of the loading, constant",
        }
    }

    /// Whether the fuel was measured, stated or assumed.
    pub fn basis(&self) -> &'static str {
        match (self.record, self.is_stated) {
            (FuelRecord::Tanks | FuelRecord::Total, false) => "measured",
            (FuelRecord::Tanks, true) => "measured, shifted by the session",
            (FuelRecord::Total | FuelRecord::Flow, true) => "initial fuel stated, burn measured",
            (FuelRecord::Flow, false) => "initial fuel assumed, burn measured",
            (FuelRecord::None, true) => "stated, not measured",
            (FuelRecord::None, false) => "assumed, not measured",
        }
    }
}

/// The aircraft over one flight.
#[derive(Clone, Debug)]
pub struct FlownMass {
    /// Where the fuel comes from.
    pub fuel: FuelSource,
    /// At the first record.
    pub start: FlownState,
    /// In the middle of each window that is not ignored, by its name.
    pub windows: Vec<(String, FlownState)>,
    /// At the last record.
    pub end: FlownState,
}

impl Footprint for FlownMass {
    fn bytes(&self) -> usize {
        (self.windows.len() + 2) * 2048
    }
}

/// Over a flight with the fuel the analysis takes, and in the middle of its windows.
impl Stage for FlownMass {
    type Params<'a> = &'a [&'a Manoeuvre];
    type Inputs<'a> = (&'a Keyed<AircraftData>, &'a Keyed<LoadedFlight>);
    type Output = Self;
    const NAME: &'static str = "mass over a flight";

    fn run(windows: Self::Params<'_>, inputs: Self::Inputs<'_>, _: &Context<'_>) -> StageResult<Self> {
        let (aircraft, LoadedFlight { recording, .. }) = (inputs.0, &**inputs.1);
        let span = aircraft.fuel_span_s(recording);
        let (first, last) = span.ok_or("mass over time is unknown: neither fuel nor specific force is recorded")?;
        let at = |name: &str, time_s: f64| -> StageResult<FlownState> {
            let loading = aircraft.loading_at(recording, time_s)?;
            let state = LoadedState::new(name, &aircraft.loaded.aircraft, &loading);
            Ok(FlownState { time_s, loading, state })
        };
        // A window whose fuel has a gap says so itself.
        let windows = windows.iter().filter_map(|manoeuvre| {
            let state = at(&manoeuvre.name, manoeuvre.middle_s()).ok()?;
            Some((manoeuvre.name.clone(), state))
        });
        Ok(FlownMass {
            fuel: aircraft.fuel_source(recording),
            start: at("start", first)?,
            windows: windows.collect(),
            end: at("end", last)?,
        })
    }
}
