//! The aircraft as the analysis uses it: reference geometry, mass properties, places of sensors, engines.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use doublet_core::airframe::{Aircraft, FuelSplit, Loading, MassHistory, MassProperties, Tank};
use doublet_core::load::aircraft::{self as aircraft_file, AircraftFileError};
use doublet_core::load::propulsion_maps::parse_propulsion_section;
use doublet_core::model::Position;
use doublet_core::prep::{Interpolation, fuel_from_flow, resample};
use doublet_core::propulsion::Powerplant;
use doublet_core::quantity::Role;
use doublet_core::series::{Recording, Series};
use doublet_core::statistics::extent;

use super::instruments::tank_channel;
use super::mass::{FuelRecord, FuelSource};
use super::samples::channel_at;
use crate::builtin;
use crate::graph::{Context, Footprint, Keyed, Stage, StageError, StageResult};
use crate::keep::hash_bytes;
use crate::session::{AircraftChanges, Session};

/// An aircraft file as read.
#[derive(Clone, Debug)]
pub struct LoadedAircraft {
    /// Airframe.
    pub aircraft: Aircraft,
    /// Engines with their charts and maps.
    pub powerplant: Powerplant,
    /// SHA-256 of its file, before the changes of the session.
    pub sha256: String,
}

impl Footprint for LoadedAircraft {
    fn bytes(&self) -> usize {
        1 << 18
    }
}

/// What to say where there is no aircraft to form coefficients with.
pub const NO_AIRCRAFT: &str =
    "no aircraft: only flight paths are computed; choose an aircraft file or a shipped aircraft";

/// Reads an aircraft as its file says.
pub fn load_aircraft(context: &Context<'_>, path: &str) -> StageResult<Keyed<LoadedAircraft>> {
    context.get::<LoadedAircraft>((path, &AircraftChanges::default()), ())
}

/// Reads the aircraft of a session, with its changes.
pub fn aircraft_of(context: &Context<'_>, session: &Session) -> StageResult<Keyed<LoadedAircraft>> {
    let path = session.aircraft.as_deref().ok_or(StageError::NotApplicable)?;
    context.get::<LoadedAircraft>((path, &session.aircraft_changes), ())
}

/// An aircraft from the text of its file, `named` in errors, with the changes of a session. Propulsion maps that it names are
/// read from the working folder.
pub fn parse_aircraft(named: &str, text: &str, changes: &AircraftChanges) -> StageResult<LoadedAircraft> {
    let context = Context::new(Path::new(""));
    LoadedAircraft::parse((named, text), changes, (Path::new(named), Path::new("")), &context)
}

impl LoadedAircraft {
    /// The aircraft of the text of its file, with changes; propulsion maps lie in the folder `maps`.
    fn parse(
        (path, text): (&str, &str),
        changes: &AircraftChanges,
        (file, maps): (&Path, &Path),
        context: &Context<'_>,
    ) -> StageResult<Self> {
        let sha256 = hash_bytes(text.as_bytes());
        let edited = if changes.is_empty() { "" } else { ", with the session's changes" };
        let named = |error: &dyn std::fmt::Display| format!("{path}{edited}: {error}");
        let text = if changes.is_empty() {
            Cow::Borrowed(text)
        } else {
            Cow::Owned(changes.apply(text).map_err(|error| named(&error))?)
        };
        let mut aircraft = aircraft_file::parse(&text).map_err(|error| match error {
            AircraftFileError::Impossible { errors } => {
                StageError::Aircraft { named: format!("{path}{edited}"), errors }
            }
            error => named(&error).into(),
        })?;
        aircraft.notes.extend(note(changes));
        let section = parse_propulsion_section(&text, file).map_err(|error| named(&error))?;
        let powerplant = section.powerplant(&aircraft.engines, maps, |map| context.read_text(map));
        Ok(Self { powerplant: powerplant.map_err(|error| named(&error))?, aircraft, sha256 })
    }
}

impl Stage for LoadedAircraft {
    type Params<'a> = (&'a str, &'a AircraftChanges);
    type Inputs<'a> = ();
    type Output = Self;
    const NAME: &'static str = "aircraft";

    fn run((path, changes): (&str, &AircraftChanges), (): (), context: &Context<'_>) -> StageResult<Self> {
        let text = context.text(path, "aircraft")?;
        let (file, maps) = match path.strip_prefix(builtin::PREFIX) {
            Some(_) => (PathBuf::from(path), builtin::on_disk("propulsion")?),
            None => {
                let file = context.locate(path)?;
                let maps = file.parent().unwrap_or(Path::new(".")).to_path_buf();
                (file, maps)
            }
        };
        Self::parse((path, &text), changes, (&file, &maps), context)
    }
}

/// What an aircraft's notes say of the changes of a session.
fn note(changes: &AircraftChanges) -> Option<String> {
    let all: Vec<_> = changes.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    (!all.is_empty()).then(|| format!("Changed in the session: {}.", all.join("; ")))
}

impl Stage for AircraftData {
    type Params<'a> = Option<&'a Loading>;
    type Inputs<'a> = &'a Keyed<LoadedAircraft>;
    type Output = Self;
    const NAME: &'static str = "aircraft as loaded";

    fn run(loading: Option<&Loading>, aircraft: &Keyed<LoadedAircraft>, _: &Context<'_>) -> StageResult<Self> {
        Ok(aircraft_data(Arc::clone(aircraft.shared()), loading))
    }
}

impl Footprint for AircraftData {
    fn bytes(&self) -> usize {
        1 << 12
    }
}

/// What the later stages need of an aircraft and its loading.
#[derive(Clone, Debug)]
pub struct AircraftData {
    /// Everything its file says.
    pub loaded: Arc<LoadedAircraft>,
    /// What is on board at the start.
    pub loading: Loading,
    /// Whether the session states the fuel: what is recorded then tells the burn only, not how much there was.
    pub fuel_is_stated: bool,
    /// Mass properties of the loading.
    pub mass: MassProperties,
    /// What to add to the mass properties at every instant; part of `mass` already.
    pub mass_change: Option<MassProperties>,
    /// Place of the accelerometers.
    pub accelerometer: Option<Position>,
    /// Places of the vanes of angle of attack and sideslip; one stands for both where only one is stated.
    pub vanes: Option<[Position; 2]>,
    /// Place of the satellite receiver's antenna.
    pub antenna: Option<Position>,
    /// Point the moment coefficients are about; the centre of gravity when there is none.
    pub moment_reference_from_datum_m: Option<[f64; 3]>,
}

/// The loading a session states with what it leaves open: the standard loading of the aircraft, its standard fuel.
pub fn loading_on_board(aircraft: &Aircraft, stated: Option<&Loading>) -> Loading {
    let mut loading = stated.unwrap_or(&aircraft.standard_loading).clone();
    if loading.fuel_kg.is_empty() {
        loading.fuel_kg.clone_from(&aircraft.standard_loading.fuel_kg);
    }
    loading
}

/// What the analysis uses of an aircraft with `loading` on board; its standard loading when there is none, its standard fuel when
/// the loading states none.
pub fn aircraft_data(loaded: Arc<LoadedAircraft>, loading: Option<&Loading>) -> AircraftData {
    let aircraft = &loaded.aircraft;
    let fuel_is_stated = loading.is_some_and(|loading| !loading.fuel_kg.is_empty());
    let loading = loading_on_board(aircraft, loading);
    let sensors = aircraft.sensors;
    let (alpha_vane, beta_vane) = (sensors.alpha_vane_from_datum_m, sensors.beta_vane_from_datum_m);
    AircraftData {
        mass: loading.mass_properties(aircraft),
        mass_change: None,
        accelerometer: sensors.accelerometer_from_datum_m.map(Position::Datum),
        vanes: alpha_vane
            .or(beta_vane)
            .zip(beta_vane.or(alpha_vane))
            .map(|(alpha, beta)| [alpha, beta].map(Position::Datum)),
        antenna: sensors.antenna_from_datum_m.map(Position::Datum),
        moment_reference_from_datum_m: aircraft.moment_reference_from_datum_m,
        loading,
        fuel_is_stated,
        loaded,
    }
}

impl AircraftData {
    /// The aircraft with `change` added to its mass properties.
    #[must_use]
    pub(crate) fn with_mass_change(&self, change: MassProperties) -> Self {
        Self { mass: self.mass.plus(&change), mass_change: Some(change), ..self.clone() }
    }

    /// Mass properties over a window, with the fuel of the flight.
    pub(crate) fn mass_history(&self, recording: &Recording, time_s: &[f64]) -> StageResult<MassHistory> {
        let aircraft = &self.loaded.aircraft;
        let history = match self.fuel(recording, time_s)? {
            Fuel::Constant => return Ok(MassHistory::Constant(self.mass)),
            Fuel::Total(fuel_kg) => {
                MassHistory::from_total_fuel(aircraft, &self.loading, time_s, &fuel_kg, &FuelSplit::Proportional)
            }
            Fuel::Tanks(tanks) => {
                let columns: Vec<_> = tanks.iter().map(|(name, fuel)| (name.clone(), fuel.as_slice())).collect();
                MassHistory::from_tanks(aircraft, &self.loading, time_s, &columns)
            }
        };
        let history = history?;
        Ok(match &self.mass_change {
            Some(change) => history.plus(change),
            None => history,
        })
    }

    /// What was on board at one time of a flight.
    pub(crate) fn loading_at(&self, recording: &Recording, time_s: f64) -> StageResult<Loading> {
        let mut loading = self.loading.clone();
        match self.fuel(recording, &[time_s])? {
            Fuel::Constant => {}
            Fuel::Total(fuel_kg) => {
                let part = fuel_kg[0] / self.stated_kg();
                loading.fuel_kg.values_mut().for_each(|fuel| *fuel *= part);
            }
            Fuel::Tanks(tanks) => loading.fuel_kg.extend(tanks.into_iter().map(|(name, fuel)| (name, fuel[0]))),
        }
        Ok(loading)
    }

    /// Fuel of the loading, kg.
    fn stated_kg(&self) -> f64 {
        self.loading.fuel_kg.values().sum()
    }

    /// Fuel on board. Recorded fuel of each tank tells it, or else the recorded fuel in all, shared among the tanks as in the
    /// loading. Where the session states the fuel, that is what was on board at the first record of the flight: what is recorded is
    /// shifted by the difference, tank by tank or in all, and so tells the burn. Without recorded fuel the fuel flow since the first
    /// record does. Without either, or without fuel in the loading, it is constant.
    fn fuel(&self, recording: &Recording, time_s: &[f64]) -> StageResult<Fuel> {
        let stated_kg = self.stated_kg();
        let channel = |role| recording.role(role).filter(|_| stated_kg > 0.0);
        let Some(channel) = channel(Role::FuelMass) else {
            let flow = channel(Role::FuelFlow);
            return flow.map_or(Ok(Fuel::Constant), |flow| {
                Ok(Fuel::Total(self.fuel_by_flow(&flow.series, stated_kg, time_s)?))
            });
        };
        let tanks = self.recorded_tanks(recording, time_s)?;
        if !tanks.is_empty() {
            return Ok(Fuel::Tanks(tanks));
        }
        let mut fuel_kg = channel_at(recording, channel, Role::FuelMass.name(), time_s)?.to_vec();
        if self.fuel_is_stated {
            let at_start_kg = first_finite(&channel.series);
            fuel_kg.iter_mut().for_each(|fuel| *fuel = (stated_kg - (at_start_kg - *fuel)).clamp(0.0, stated_kg));
        }
        Ok(Fuel::Total(fuel_kg))
    }

    /// Fuel on board from the fuel flow, kg: what the loading has at the first record of the flight, less what was burnt since. A
    /// sample that is not finite burns nothing of its own.
    fn fuel_by_flow(&self, flow: &Series, stated_kg: f64, time_s: &[f64]) -> StageResult<Vec<f64>> {
        let with_channel_name = |error: doublet_core::prep::PrepError| format!("{}: {error}", Role::FuelFlow.name());
        let (own_s, rate): (Vec<f64>, Vec<f64>) =
            flow.time_s.iter().zip(flow.values.iter()).filter(|(_, rate)| rate.is_finite()).unzip();
        let (Some(&first), Some(&last)) = (own_s.first(), own_s.last()) else {
            return Ok(vec![stated_kg; time_s.len()]);
        };
        let left_kg = fuel_from_flow(&own_s, &rate, stated_kg).map_err(with_channel_name)?;
        let at: Vec<f64> = time_s.iter().map(|time| time.clamp(first, last)).collect();
        let left_kg = resample(&own_s, &left_kg, &at, Interpolation::Linear).map_err(with_channel_name)?;
        Ok(left_kg.into_iter().map(|fuel| fuel.clamp(0.0, stated_kg)).collect())
    }

    /// Fuel of every tank there is a record of, between none and its capacity, kg; shifted to what the session states.
    fn recorded_tanks(&self, recording: &Recording, time_s: &[f64]) -> StageResult<Vec<(String, Vec<f64>)>> {
        let mut tanks = Vec::new();
        for tank in &self.loaded.aircraft.tanks {
            let name = tank_channel(&tank.name);
            let Some(channel) = recording.channels.iter().find(|channel| channel.name == name) else { continue };
            let mut fuel_kg = channel_at(recording, channel, &name, time_s)?.to_vec();
            let shift_kg = self.tank_shift_kg(tank, &channel.series);
            fuel_kg.iter_mut().for_each(|fuel| {
                *fuel = fuel.min(tank.capacity_kg);
                if let Some(shift_kg) = shift_kg {
                    *fuel = (*fuel + shift_kg).clamp(0.0, tank.capacity_kg);
                }
            });
            tanks.push((tank.name.clone(), fuel_kg));
        }
        Ok(tanks)
    }

    /// What is added to the recorded fuel of a tank, kg; none where the session states no fuel.
    fn tank_shift_kg(&self, tank: &Tank, recorded: &Series) -> Option<f64> {
        let stated_kg = || self.loading.fuel_kg.get(&tank.name).copied().unwrap_or(0.0);
        self.fuel_is_stated.then(|| stated_kg() - first_finite(recorded).min(tank.capacity_kg))
    }

    /// Where the fuel of a flight comes from.
    pub(super) fn fuel_source(&self, recording: &Recording) -> FuelSource {
        let has = |role| self.stated_kg() > 0.0 && recording.role(role).is_some();
        let record_of =
            |tank: &Tank| recording.channels.iter().find(|channel| channel.name == tank_channel(&tank.name));
        let by_tank: Vec<_> =
            self.loaded.aircraft.tanks.iter().filter_map(|tank| Some((tank, &record_of(tank)?.series))).collect();
        let record = match (has(Role::FuelMass), has(Role::FuelFlow)) {
            (true, _) if !by_tank.is_empty() => FuelRecord::Tanks,
            (true, _) => FuelRecord::Total,
            (false, true) => FuelRecord::Flow,
            (false, false) => FuelRecord::None,
        };
        let shifts: Vec<(Option<String>, f64)> = match record {
            FuelRecord::Tanks => by_tank
                .into_iter()
                .filter_map(|(tank, series)| Some((Some(tank.name.clone()), self.tank_shift_kg(tank, series)?)))
                .collect(),
            FuelRecord::Total if self.fuel_is_stated => {
                let recorded = recording.role(Role::FuelMass).map(|channel| first_finite(&channel.series));
                recorded.map(|recorded_kg| (None, self.stated_kg() - recorded_kg)).into_iter().collect()
            }
            _ => Vec::new(),
        };
        let shifts_kg = shifts.into_iter().filter(|(_, shift_kg)| shift_kg.abs() > SMALLEST_SHIFT_KG).collect();
        let unused = recording.role(Role::FuelMass).filter(|_| record == FuelRecord::None);
        let unused_range_kg =
            unused.and_then(|channel| extent(&*channel.series.values)).map(|[least, greatest]| greatest - least);
        FuelSource { record, is_stated: self.fuel_is_stated, shifts_kg, unused_range_kg }
    }

    /// First and last time at which the fuel is known, of the inertial samples where it is constant.
    pub(super) fn fuel_span_s(&self, recording: &Recording) -> Option<(f64, f64)> {
        let tanks = self.loaded.aircraft.tanks.iter().map(|tank| tank_channel(&tank.name));
        let tanks = tanks.filter_map(|name| recording.channels.iter().find(|channel| channel.name == name));
        let mut spans: Vec<_> = tanks.filter_map(|channel| finite_span(&channel.series)).collect();
        let others = [Role::FuelMass, Role::FuelFlow, Role::SpecificForceX].into_iter();
        if spans.is_empty() {
            spans.extend(others.filter_map(|role| finite_span(&recording.role(role)?.series)).next());
        }
        spans.into_iter().reduce(|all, one| (all.0.max(one.0), all.1.min(one.1)))
    }
}

/// Difference of stated and recorded fuel that is rounding, kg.
const SMALLEST_SHIFT_KG: f64 = 1e-3;

/// Fuel on board over time, kg.
enum Fuel {
    /// That of the loading.
    Constant,
    /// In all tanks together.
    Total(Vec<f64>),
    /// Of the tanks there is a record of.
    Tanks(Vec<(String, Vec<f64>)>),
}

/// First value of a record; zero where it has none.
fn first_finite(series: &Series) -> f64 {
    series.values.iter().copied().find(|value| value.is_finite()).unwrap_or(0.0)
}

/// Times of the first and the last value of a record.
fn finite_span(series: &Series) -> Option<(f64, f64)> {
    let mut known = series.time_s.iter().zip(series.values.iter()).filter(|(_, value)| value.is_finite());
    let first = known.next()?.0;
    Some((*first, *known.next_back().map_or(first, |last| last.0)))
}
