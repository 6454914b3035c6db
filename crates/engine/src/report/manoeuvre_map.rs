//! Manoeuvres and candidates with their flight condition, their input and what became of them: the rows behind the manoeuvre map.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::atmos::Atmosphere;
use doublet_core::model::{Coefficient, is_constant_name};
use doublet_core::quantity::{Dimension, Role};
use doublet_core::reconstruct::{Measurement, State};
use doublet_core::series::{Recording, Statistics, TimeRange};
use doublet_core::statistics::{median, squares_about_mean};
use serde::Serialize;

use super::results::Results;
use super::table::{Table, TableOf};
use crate::session::{Level, Manoeuvre, Session};
use crate::snapshot::{Slot, Snapshot};
use crate::stage::{
    CONDITION_NOTE, FlownMass, WindowAero, WindowFits, WindowPath, WindowProposal, find_open_candidates,
    mean_of_finite, measure_condition, measure_steadiness, movement, significance,
};

/// Use of a manoeuvre that was found and is not in the session.
pub const CANDIDATE: &str = "candidate";

/// One manoeuvre or candidate.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MapRow {
    /// Name; of a candidate the proposed name.
    pub name: String,
    pub flight: String,
    /// Use; `candidate` if it is not in the session.
    #[serde(rename = "use")]
    pub role: &'static str,
    /// Surface moved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<&'static str>,
    /// Kind of input in words.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub kind: String,
    /// Level of its verdict.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<Level>,
    /// First instant, s.
    pub start_s: f64,
    pub duration_s: f64,
    /// True airspeed of its condition (mean before the input, of all of it without a steady part there), m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub airspeed_m_s: Option<f64>,
    /// Altitude of its condition, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub altitude_m: Option<f64>,
    /// Dynamic pressure of its condition, Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dynamic_pressure_pa: Option<f64>,
    /// Angle of attack of its condition, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alpha_rad: Option<f64>,
    /// Largest minus smallest angle of sideslip, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sideslip_range_rad: Option<f64>,
    /// Largest deflection of its surface from its initial value, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deflection_rad: Option<f64>,
    /// Mass in its middle, kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Centre of gravity in its middle, aft of the datum, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cg_x_m: Option<f64>,
    /// Centre of gravity in its middle as a part of the mean aerodynamic chord.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cg_chord: Option<f64>,
    /// Slope of the airspeed before the input, m/s².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub airspeed_slope_m_s2: Option<f64>,
    /// Mean horizontal speed of the reconstructed wind, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wind_m_s: Option<f64>,
    /// Standard deviation of the reconstructed wind, all three components together, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wind_deviation_m_s: Option<f64>,
    /// Mean NIS over its expectation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nis_ratio: Option<f64>,
    /// Root mean square of the innovations of each measurement over the predicted standard deviation.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub innovation_ratio: BTreeMap<&'static str, f64>,
    /// Coefficient of determination of each coefficient's fit to this manoeuvre alone.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub r_squared: BTreeMap<&'static str, f64>,
    /// Median over the derivatives from this manoeuvre alone of estimate over corrected standard error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub information: Option<f64>,
    /// Agreement of a candidate's input with the ideal shape, from 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
}

/// A quantity of manoeuvres that a map is drawn over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapQuantity {
    /// First instant.
    Start,
    Duration,
    /// True airspeed of the condition.
    Airspeed,
    /// Altitude of the condition.
    Altitude,
    /// Dynamic pressure of the condition.
    DynamicPressure,
    /// Angle of attack of the condition.
    AngleOfAttack,
    /// Range of the angle of sideslip.
    SideslipRange,
    /// Largest deflection.
    Deflection,
    Mass,
    /// Centre of gravity from the datum.
    CentreOfGravity,
    /// Centre of gravity on the mean chord.
    CentreOfGravityOnChord,
    /// Slope of the airspeed before the input.
    AirspeedSlope,
    WindDeviation,
    /// Mean NIS over its expectation.
    NisRatio,
    /// Innovations of one measurement over their prediction.
    InnovationRatio(Measurement),
    /// The least coefficient of determination.
    WorstRSquared,
    RSquared(Coefficient),
    /// Estimate over standard error, median.
    Information,
    /// Confidence of a candidate.
    Confidence,
}

impl MapQuantity {
    /// Every quantity, in the order of menus.
    pub fn all() -> Vec<Self> {
        let condition = [
            Self::Start,
            Self::Duration,
            Self::Airspeed,
            Self::Altitude,
            Self::DynamicPressure,
            Self::AngleOfAttack,
            Self::SideslipRange,
            Self::Deflection,
            Self::Mass,
            Self::CentreOfGravity,
            Self::CentreOfGravityOnChord,
            Self::AirspeedSlope,
            Self::WindDeviation,
            Self::Information,
            Self::Confidence,
            Self::NisRatio,
        ];
        let innovations = Measurement::ALL.into_iter().map(Self::InnovationRatio);
        let fits = Coefficient::ALL.into_iter().map(Self::RSquared);
        condition.into_iter().chain(innovations).chain([Self::WorstRSquared]).chain(fits).collect()
    }

    /// Its name in words.
    pub fn title(self) -> String {
        match self {
            Self::Start => "Start".to_owned(),
            Self::Duration => "Duration".to_owned(),
            Self::Airspeed => "True airspeed".to_owned(),
            Self::Altitude => "Altitude".to_owned(),
            Self::DynamicPressure => "Dynamic pressure".to_owned(),
            Self::AngleOfAttack => "Angle of attack".to_owned(),
            Self::SideslipRange => "Sideslip, range".to_owned(),
            Self::Deflection => "Largest deflection".to_owned(),
            Self::Mass => "Mass".to_owned(),
            Self::CentreOfGravity => "Centre of gravity, aft of datum".to_owned(),
            Self::CentreOfGravityOnChord => "Centre of gravity, part of chord".to_owned(),
            Self::AirspeedSlope => "Airspeed slope before input".to_owned(),
            Self::WindDeviation => "Wind, standard deviation".to_owned(),
            Self::NisRatio => "NIS over expected".to_owned(),
            Self::InnovationRatio(measurement) => format!("Innovations over predicted, {}", measurement.name()),
            Self::WorstRSquared => "R², worst coefficient".to_owned(),
            Self::RSquared(coefficient) => format!("R² of {}", coefficient.name()),
            Self::Information => "Estimate over standard error, median".to_owned(),
            Self::Confidence => "Confidence of candidate".to_owned(),
        }
    }

    /// Its dimension; values are in SI units and radians.
    pub fn dimension(self) -> Dimension {
        match self {
            Self::Start | Self::Duration => Dimension::Time,
            Self::Airspeed | Self::WindDeviation => Dimension::Speed,
            Self::Altitude | Self::CentreOfGravity => Dimension::Length,
            Self::DynamicPressure => Dimension::Pressure,
            Self::AngleOfAttack | Self::SideslipRange | Self::Deflection => Dimension::Angle,
            Self::Mass => Dimension::Mass,
            Self::AirspeedSlope => Dimension::Acceleration,
            _ => Dimension::Dimensionless,
        }
    }

    /// Its value for a manoeuvre, where it is known.
    pub fn value(self, row: &MapRow) -> Option<f64> {
        match self {
            Self::Start => Some(row.start_s),
            Self::Duration => Some(row.duration_s),
            Self::Airspeed => row.airspeed_m_s,
            Self::Altitude => row.altitude_m,
            Self::DynamicPressure => row.dynamic_pressure_pa,
            Self::AngleOfAttack => row.alpha_rad,
            Self::SideslipRange => row.sideslip_range_rad,
            Self::Deflection => row.deflection_rad,
            Self::Mass => row.mass_kg,
            Self::CentreOfGravity => row.cg_x_m,
            Self::CentreOfGravityOnChord => row.cg_chord,
            Self::AirspeedSlope => row.airspeed_slope_m_s2,
            Self::WindDeviation => row.wind_deviation_m_s,
            Self::NisRatio => row.nis_ratio,
            Self::InnovationRatio(measurement) => row.innovation_ratio.get(measurement.name()).copied(),
            Self::WorstRSquared => row.worst_r_squared(),
            Self::RSquared(coefficient) => row.r_squared.get(coefficient.name()).copied(),
            Self::Information => row.information,
            Self::Confidence => row.confidence,
        }
    }
}

impl MapRow {
    /// Whether it is not in the session.
    pub fn is_candidate(&self) -> bool {
        self.role == CANDIDATE
    }

    /// The least coefficient of determination of its own fits.
    pub fn worst_r_squared(&self) -> Option<f64> {
        self.r_squared.values().copied().reduce(f64::min)
    }

    /// Name, interval and input of a manoeuvre.
    fn new(window: &Manoeuvre, role: &'static str) -> Self {
        Self {
            name: window.name.clone(),
            flight: window.flight.clone(),
            role,
            surface: window.surface_name(),
            kind: window.kind.clone(),
            start_s: window.window.start_s,
            duration_s: window.window.length_s(),
            ..Self::default()
        }
    }

    /// The flight condition by the recording alone.
    fn add_recorded(&mut self, recording: &Recording, window: TimeRange) {
        let of_role = |role| recording.role(role)?.series.statistics(window);
        let mean = |role| of_role(role).map(|found: Statistics| found.mean);
        self.airspeed_m_s = mean(Role::TrueAirspeed);
        self.altitude_m = mean(Role::Altitude).or(mean(Role::GpsAltitude));
        self.alpha_rad = mean(Role::AngleOfAttack);
        self.sideslip_range_rad = of_role(Role::Sideslip).map(|found| found.max - found.min);
        let standard = || Atmosphere::default().density_kg_m3(self.altitude_m?).ok();
        let density_kg_m3 = mean(Role::AirDensity).or_else(standard);
        self.dynamic_pressure_pa = self.airspeed_m_s.zip(density_kg_m3).map(|(speed, rho)| 0.5 * rho * speed * speed);
    }

    /// The flight condition and the input by the reconstructed path.
    fn add_aero(&mut self, window: &Manoeuvre, aero: &WindowAero) {
        if let Some(found) = measure_condition(aero) {
            self.airspeed_m_s = Some(found.airspeed_m_s);
            self.altitude_m = found.altitude_m.or(self.altitude_m);
            self.alpha_rad = Some(found.alpha_rad);
            self.dynamic_pressure_pa = Some(found.dynamic_pressure_pa);
        }
        self.sideslip_range_rad = range(&aero.data.beta_rad);
        self.deflection_rad = movement(window, aero).map(|moved| moved.largest_rad.abs());
        self.airspeed_slope_m_s2 = measure_steadiness(aero).map(|before| before.airspeed_slope_m_s2);
    }

    /// Consistency of the flight path and motion of the air.
    fn add_path(&mut self, path: &WindowPath) {
        if path.tells_wind() {
            let states = &path.reconstruction.states;
            let winds = [State::WindNorth, State::WindEast, State::WindDown].map(|wind| &states[wind as usize]);
            let [north, east] =
                [winds[0], winds[1]].map(|wind| mean_of_finite(wind.iter().copied()).unwrap_or(f64::NAN));
            self.wind_m_s = finite(north.hypot(east));
            let squares: f64 = winds.iter().map(|wind| squares_about_mean(wind)).sum();
            self.wind_deviation_m_s = finite((squares / winds[0].len() as f64).sqrt());
        }
        let Some(consistency) = path.assessed().and_then(|assessed| assessed.consistency.as_ref()) else { return };
        self.nis_ratio = finite(consistency.nis_ratio);
        let ratios = consistency.channels.iter().map(|channel| (channel.measurement.name(), channel.deviation_ratio));
        self.innovation_ratio = ratios.filter(|(_, ratio)| ratio.is_finite()).collect();
    }

    /// How well the fits to this manoeuvre alone explain it, and how well it determines their derivatives.
    fn add_fits(&mut self, fits: &WindowFits) {
        let mut times = Vec::new();
        for fit in &fits.fits {
            let Ok(estimate) = &fit.fit else { continue };
            if estimate.quality.r_squared.is_finite() {
                self.r_squared.insert(fit.coefficient.name(), estimate.quality.r_squared);
            }
            let shared = (0..estimate.parameters()).filter(|&at| !is_constant_name(&estimate.names[at]));
            times.extend(shared.map(|at| significance(estimate, &fit.corrected_errors, at).1.abs()));
        }
        times.retain(|times| times.is_finite());
        self.information = median(&mut times);
    }

    /// Mass properties in its middle.
    fn add_mass(&mut self, flown: &FlownMass) {
        let Some((_, flown)) = flown.windows.iter().find(|(name, _)| *name == self.name) else { return };
        let place = flown.state.properties.cg_from_datum_m;
        self.mass_kg = finite(flown.state.properties.mass_kg);
        self.cg_x_m = (place != [0.0; 3]).then_some(place[0]);
        self.cg_chord = flown.state.mean_chord_fraction;
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// Largest less smallest of the finite values.
fn range(values: &[f64]) -> Option<f64> {
    let finite_values = values.iter().copied().filter(|value| value.is_finite());
    let ends = finite_values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    finite(ends.1 - ends.0)
}

/// Which outputs of a snapshot a map shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapOf {
    /// Those that are up to date.
    Ready,
    /// The newest there are: a map on screen keeps its marks while something is computed.
    Latest,
}

impl MapOf {
    fn get<T>(self, slot: &Slot<T>) -> Option<&Arc<T>> {
        match self {
            Self::Ready => slot.ready(),
            Self::Latest => slot.latest().filter(|_| slot.error().is_none()),
        }
    }
}

/// Every manoeuvre of a session in its order, then the candidates of each flight.
pub fn manoeuvre_map(session: &Session, snapshot: &Snapshot, of: MapOf) -> Vec<MapRow> {
    let proposals = session.flights.iter().filter_map(|flight| of.get(snapshot.proposals.get(&flight.name)?));
    let candidates = proposals.flat_map(|found| find_open_candidates(session, found));
    let manoeuvres = session.windows.iter().map(|window| manoeuvre_row(window, snapshot, of));
    manoeuvres.chain(candidates.map(|(window, found)| candidate_row(&window, found, snapshot, of))).collect()
}

fn candidate_row(window: &Manoeuvre, found: &WindowProposal, snapshot: &Snapshot, of: MapOf) -> MapRow {
    let mut row = MapRow::new(window, CANDIDATE);
    if let Some(recording) = recording(&window.flight, snapshot, of) {
        row.add_recorded(recording, window.window);
    }
    row.deflection_rad = Some(found.amplitude_rad.abs());
    row.confidence = Some(found.confidence);
    row
}

fn manoeuvre_row(window: &Manoeuvre, snapshot: &Snapshot, of: MapOf) -> MapRow {
    let mut row = MapRow::new(window, window.role.name());
    if let Some(recording) = recording(&window.flight, snapshot, of) {
        row.add_recorded(recording, window.window);
    }
    row.level = of.get(&snapshot.verdicts).and_then(|found| Some(found.windows.get(&window.name)?.verdict.level));
    if let Some(flown) = snapshot.flown.get(&window.flight).and_then(|slot| of.get(slot)) {
        row.add_mass(flown);
    }
    let Some(results) = snapshot.windows.get(&window.name) else { return row };
    if let Some(path) = of.get(&results.path) {
        row.add_path(path);
    }
    if let Some(aero) = of.get(&results.aero) {
        row.add_aero(window, aero);
    }
    if let Some(fits) = of.get(&results.fits) {
        row.add_fits(fits);
    }
    row
}

fn recording<'s>(flight: &str, snapshot: &'s Snapshot, of: MapOf) -> Option<&'s Recording> {
    of.get(snapshot.flights.get(flight)?).map(|loaded| &loaded.recording)
}

/// The rows as a table, without innovations and fits one by one.
pub fn table(results: &Results) -> Table {
    let caption =
        format!("Manoeuvres and candidates: flight condition, input and consistency of results. {CONDITION_NOTE}");
    TableOf::new("manoeuvre_map", caption, &results.manoeuvre_map)
        .text("name", "Name", |row| &row.name)
        .text("flight", "Flight", |row| &row.flight)
        .text("use", "Use", |row| row.role)
        .optional("surface", "Surface", |row| row.surface)
        .optional("level", "Verdict", |row| row.level.map(Level::name))
        .number("start_s", "Start", "s", 6, |row| row.start_s)
        .number("duration_s", "Duration", "s", 4, |row| row.duration_s)
        .maybe("airspeed_m_s", "Airspeed", "m/s", 4, |row| row.airspeed_m_s)
        .maybe("altitude_m", "Altitude", "m", 4, |row| row.altitude_m)
        .maybe("dynamic_pressure_pa", "Dynamic pressure", "Pa", 4, |row| row.dynamic_pressure_pa)
        .maybe("alpha_rad", "Alpha", "rad", 3, |row| row.alpha_rad)
        .maybe("sideslip_range_rad", "Sideslip range", "rad", 3, |row| row.sideslip_range_rad)
        .maybe("deflection_rad", "Deflection", "rad", 3, |row| row.deflection_rad)
        .maybe("mass_kg", "Mass", "kg", 5, |row| row.mass_kg)
        .maybe("cg_x_m", "x CG", "m", 4, |row| row.cg_x_m)
        .maybe("cg_chord", "On the chord", "", 4, |row| row.cg_chord)
        .maybe("airspeed_slope_m_s2", "Slope of airspeed", "m/s²", 3, |row| row.airspeed_slope_m_s2)
        .maybe("wind_m_s", "Wind", "m/s", 3, |row| row.wind_m_s)
        .maybe("wind_deviation_m_s", "Wind deviation", "m/s", 3, |row| row.wind_deviation_m_s)
        .maybe("nis_ratio", "NIS over expected", "", 3, |row| row.nis_ratio)
        .maybe("worst_r_squared", "Worst R²", "", 4, |row| row.worst_r_squared())
        .maybe("information", "Estimate over error", "", 3, |row| row.information)
        .maybe("confidence", "Confidence", "", 2, |row| row.confidence)
        .done()
}
