//! A campaign: test points in their order, each with the loading it will be flown at, and what of it the windows of a session hold.

use std::path::Path;

use doublet_core::airframe::{Aircraft, FlightMargin, Loading, calibrated_m_s};
use doublet_core::atmos::Atmosphere;
use doublet_core::statistics::median;
use serde::{Deserialize, Serialize};

use super::evaluation::{SlopeRow, evaluate, is_acceleration};
use super::safety::{EntryGate, Risk, WindBox, entry, worst_hazard};
use crate::graph::StageResult;
use crate::live::Limit;
use crate::notation::significant;
use crate::session::{Level, Manoeuvre, Session, Surface, WindowRole};
use crate::snapshot::Snapshot;
use crate::{builtin, toml_file};

/// Value of the `format` key.
pub(crate) const FORMAT: &str = "doublet campaign";
/// Version of the form.
pub(crate) const VERSION: u32 = 1;
/// Folder of the campaigns that come with the program.
const FOLDER: &str = "campaigns";

/// A campaign as its file states it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Campaign {
    format: String,
    version: u32,
    pub title: String,
    /// Aircraft: a file, or `builtin:` and a name.
    pub aircraft: String,
    /// Registration, flight number and the like, as the cover shows them.
    #[serde(default)]
    pub facts: std::collections::BTreeMap<String, String>,
    /// What the campaign is for.
    #[serde(default)]
    pub objectives: Vec<String>,
    /// What is not to be done.
    #[serde(default)]
    pub restrictions: Vec<String>,
    /// When any point ends.
    #[serde(default)]
    pub knock_off: Vec<String>,
    /// What is watched in flight and not to be passed, as `doublet live --limit` has it: `n_z=0:2`, `phi=-45deg:45deg`.
    #[serde(default, deserialize_with = "limits")]
    pub limits: Vec<Limit>,
    /// What is done at every point.
    #[serde(default)]
    pub procedure: Vec<String>,
    /// Order of the points.
    #[serde(default)]
    pub order: Order,
    /// Fuel at the first point and what is burnt on the way.
    pub fuel: Fuel,
    /// How near to a point a window counts as flown there.
    #[serde(default)]
    pub tolerance: Tolerance,
    /// Airspeed over that of the stall, at the mass of the card, below which a point ends.
    #[serde(default = "stall_ratio")]
    pub stall_ratio: f64,
    /// What holds before an input begins.
    #[serde(default)]
    pub entry: EntryGate,
    /// Wind in which points are flown.
    #[serde(default)]
    pub wind: WindBox,
    /// Hazards of every point.
    #[serde(default, rename = "risk")]
    pub risks: Vec<Risk>,
    #[serde(rename = "point")]
    pub points: Vec<TestPoint>,
}

/// Order in which points are flown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// By condition, the one furthest from the stall first; there by amplitude, the smallest first.
    #[default]
    BuildUp,
    /// As the file lists them.
    AsListed,
}

/// Fuel over the campaign.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fuel {
    /// On board at the first point in all, kg; shared among the tanks as in the loading.
    pub start_kg: f64,
    /// Burnt, kg/s.
    pub burn_kg_s: f64,
    /// Time from one condition to the next, s.
    #[serde(default)]
    pub transit_s: f64,
}

/// How near to a point a window counts.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerance {
    /// True airspeed, m/s.
    pub airspeed_m_s: f64,
    pub altitude_m: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { airspeed_m_s: 4.0, altitude_m: 150.0 }
    }
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TestPoint {
    /// Number on its card.
    pub id: String,
    /// True airspeed, m/s.
    pub airspeed_m_s: f64,
    pub altitude_m: f64,
    /// Flaps, gear, power.
    #[serde(default)]
    pub configuration: String,
    /// Kind of input, as windows name it.
    pub kind: String,
    /// Surface it moves; empty where several.
    #[serde(default)]
    pub surface: String,
    /// Which way it begins.
    #[serde(default)]
    pub direction: String,
    #[serde(default)]
    pub amplitude_deg: f64,
    /// Change of the manifold pressure, inHg, of an input by the throttles.
    pub amplitude_inhg: Option<f64>,
    /// How often it is flown.
    #[serde(default = "once")]
    pub repeats: usize,
    /// Time of one run with the way back to trim, s.
    #[serde(default = "minute")]
    pub duration_s: f64,
    /// Hazard category.
    #[serde(default)]
    pub hazard: String,
    /// When this point ends.
    #[serde(default)]
    pub knock_off: Vec<String>,
    /// What is done at this point, before what is done at every point.
    #[serde(default)]
    pub procedure: Vec<String>,
    /// Time unit of the input, s: that of one pulse of a doublet, of the shortest of a 3-2-1-1.
    pub step_s: Option<f64>,
    /// Engine speed, rev/min.
    pub engine_speed_rpm: Option<f64>,
    /// Manifold pressure, inHg.
    pub manifold_pressure_inhg: Option<f64>,
    /// Airspeed over that of the stall below which this point ends; that of the campaign where none is given.
    pub stall_ratio: Option<f64>,
    /// Greatest bank the manoeuvre holds, deg.
    pub bank_deg: Option<f64>,
    /// Load factor the manoeuvre holds; that of a level turn at its bank where none is given.
    pub load_factor: Option<f64>,
    /// Power in words, where it is not that of the steady flight before the input.
    #[serde(default)]
    pub power: String,
    /// Greatest calibrated airspeed of this point, m/s: that of flaps or gear, for example.
    pub greatest_m_s: Option<f64>,
    /// Airspeed this manoeuvre may lose, m/s; that of the entry of the campaign where none is given.
    pub loss_m_s: Option<f64>,
    /// Hazards of this point besides those of every point.
    #[serde(default, rename = "risk")]
    pub risks: Vec<Risk>,
    /// What a judgement of the records says, in place of what the windows of a session that fit say.
    pub judged: Option<Flown>,
}

impl TestPoint {
    /// Numbers of a point with the range each must be in.
    fn numbers(&self) -> [(&'static str, Option<f64>, std::ops::RangeInclusive<f64>, &'static str); 12] {
        [
            ("airspeed_m_s", Some(self.airspeed_m_s), 1.0..=1000.0, "1 to 1000 m/s"),
            ("altitude_m", Some(self.altitude_m), -500.0..=20_000.0, "-500 to 20000 m"),
            ("duration_s", Some(self.duration_s), 1.0..=7200.0, "1 to 7200 s"),
            ("repeats", Some(self.repeats as f64), 1.0..=100.0, "1 to 100"),
            ("step_s", self.step_s, 0.01..=600.0, "0.01 to 600 s"),
            ("engine_speed_rpm", self.engine_speed_rpm, 1.0..=1e5, "1 to 100000 rev/min"),
            ("manifold_pressure_inhg", self.manifold_pressure_inhg, 0.1..=100.0, "0.1 to 100 inHg"),
            ("stall_ratio", self.stall_ratio, 1.0..=3.0, "1 to 3"),
            ("bank_deg", self.bank_deg, 0.0..=80.0, "0 to 80 deg"),
            ("load_factor", self.load_factor, -5.0..=10.0, "-5 to 10"),
            ("greatest_m_s", self.greatest_m_s, 1.0..=1000.0, "1 to 1000 m/s"),
            ("loss_m_s", self.loss_m_s, 0.0..=100.0, "0 to 100 m/s"),
        ]
    }
}

/// Place of the steady time of the entry, s, in a step of a procedure.
const STEADY_TIME: &str = "{steady_s}";

fn stall_ratio() -> f64 {
    1.2
}

fn limits<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Vec<Limit>, D::Error> {
    let texts = Vec::<String>::deserialize(from)?;
    texts.iter().map(|text| text.parse().map_err(serde::de::Error::custom)).collect()
}

fn once() -> usize {
    1
}

fn minute() -> f64 {
    60.0
}

/// Whether a point was flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Flown {
    /// As often as wanted.
    Flown,
    /// Records pass a part of what the point is for: it stays to be flown.
    Partly,
    /// Less often than wanted, or with windows whose verdict is bad.
    Repeat,
    /// No window fits.
    Missing,
}

impl Flown {
    doublet_core::variant_texts! {
        /// Name in tables.
        pub name: Flown "flown", Partly "partly passed", Repeat "repeat", Missing "missing"
    }
}

/// A point in its place: loading, margins, and what was flown of it.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedPoint {
    pub id: String,
    pub airspeed_m_s: f64,
    pub calibrated_m_s: f64,
    pub altitude_m: f64,
    pub configuration: String,
    pub kind: String,
    pub surface: String,
    pub direction: String,
    pub amplitude_deg: f64,
    pub amplitude_inhg: Option<f64>,
    pub repeats: usize,
    pub duration_s: f64,
    pub hazard: String,
    pub knock_off: Vec<String>,
    pub procedure: Vec<String>,
    pub entry_note: Option<String>,
    pub stall_m_s: Option<f64>,
    pub least_airspeed_m_s: Option<f64>,
    pub bank_deg: Option<f64>,
    pub load_factor: f64,
    pub power: String,
    pub step_s: Option<f64>,
    pub engine_speed_rpm: Option<f64>,
    pub manifold_pressure_inhg: Option<f64>,
    pub risks: Vec<Risk>,
    pub start_s: f64,
    pub fuel_kg: f64,
    pub mass_kg: f64,
    pub cg_x_m: f64,
    pub cg_margin_m: Option<f64>,
    pub nearest_limit: Option<String>,
    pub nearest_margin: Option<f64>,
    pub windows: Vec<String>,
    pub status: Flown,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub evaluation: Vec<SlopeRow>,
}

/// A window flown, for the envelope.
#[derive(Clone, Debug, Serialize)]
pub struct FlownPoint {
    pub window: String,
    pub airspeed_m_s: f64,
    pub calibrated_m_s: f64,
    pub altitude_m: f64,
    pub load_factor_low: f64,
    pub load_factor_high: f64,
    pub mass_kg: f64,
    pub share_of_information: f64,
}

impl Campaign {
    /// Reads a file, or a campaign that comes with the program.
    pub fn open(path: &Path) -> Result<Self, String> {
        let Some(name) = path.to_str().and_then(|name| name.strip_prefix(builtin::PREFIX)) else {
            return toml_file::open(path, Self::parse);
        };
        let text = builtin::text(FOLDER, name).ok_or_else(|| format!("{}: campaign not found", path.display()))?;
        Self::parse(text).map_err(|error| format!("{}: {error}", path.display()))
    }

    /// Reads the text of a file.
    pub fn parse(text: &str) -> StageResult<Self> {
        let mut campaign: Self = toml_file::parse(text, (FORMAT, VERSION), |file: &Self| (&file.format, file.version))?;
        if campaign.points.is_empty() {
            return Err("it has no test point: add one".into());
        }
        for point in &campaign.points {
            let id = &point.id;
            for (key, value, range, allowed) in point.numbers() {
                if let Some(value) = value.filter(|value| !range.contains(value)) {
                    return Err(format!("point {id}: {key} is {value}, allowed is {allowed}").into());
                }
            }
            let is_hazardous = ["medium", "high"].contains(&point.hazard.as_str());
            if is_hazardous && point.risks.is_empty() && campaign.risks.is_empty() {
                let hazard = &point.hazard;
                return Err(format!("point {id}: hazard is {hazard}: add a risk with its mitigation").into());
            }
            if campaign.points.iter().filter(|other| other.id == *id).count() > 1 {
                return Err(format!("point {id} appears twice: give each its own id").into());
            }
        }
        campaign.entry.check()?;
        campaign.fill_steady_time();
        if !(1.0..=3.0).contains(&campaign.stall_ratio) {
            return Err(format!("stall_ratio is {}, allowed is 1 to 3", campaign.stall_ratio).into());
        }
        let Fuel { start_kg, burn_kg_s, transit_s } = campaign.fuel;
        for (key, value) in [("start_kg", start_kg), ("burn_kg_s", burn_kg_s), ("transit_s", transit_s)] {
            if !(0.0..=1e6).contains(&value) {
                return Err(format!("fuel.{key} is {value}, allowed is 0 to 1000000").into());
            }
        }
        Ok(campaign)
    }

    /// The points in the order they are flown, fuel burnt on the way, matched with the windows of a session where there is one.
    pub fn plan(
        &self,
        aircraft: &Aircraft,
        loading: &Loading,
        session: Option<(&Session, &Snapshot)>,
    ) -> StageResult<Vec<PlannedPoint>> {
        let ordered = self.ordered(aircraft)?;
        let mut taken: Vec<&str> = Vec::new();
        let mut time_s = 0.0;
        let mut before: Option<(f64, f64)> = None;
        let mut planned = Vec::with_capacity(ordered.len());
        for point in ordered {
            let condition = (point.airspeed_m_s, point.altitude_m);
            if before.is_some_and(|before| before != condition) {
                time_s += self.fuel.transit_s;
            }
            before = Some(condition);
            let mut row = self.point(point, aircraft, loading, time_s)?;
            if let Some((session, snapshot)) = session {
                self.find_windows(&mut row, session, snapshot, &mut taken);
                row.status = point.judged.unwrap_or(row.status);
                row.evaluation = evaluate(&row, session, snapshot);
            }
            time_s += point.repeats as f64 * point.duration_s;
            planned.push(row);
        }
        Ok(planned)
    }

    /// Points in the order they are flown.
    fn ordered(&self, aircraft: &Aircraft) -> StageResult<Vec<&TestPoint>> {
        let mut points: Vec<&TestPoint> = self.points.iter().collect();
        if self.order == Order::AsListed {
            return Ok(points);
        }
        let mut keys = Vec::with_capacity(points.len());
        for point in &points {
            let density = Atmosphere::STANDARD.density_kg_m3(point.altitude_m)?;
            let calibrated = calibrated_m_s(point.airspeed_m_s, density);
            let stall = aircraft.flight_envelope.stall_m_s.unwrap_or(0.0);
            keys.push((point.id.clone(), calibrated - stall));
        }
        let margin = |point: &TestPoint| keys.iter().find(|key| key.0 == point.id).map_or(0.0, |key| key.1);
        // Points of one condition stay together: the condition counts, then the amplitude, then the order of the file.
        points.sort_by(|a, b| {
            margin(b)
                .total_cmp(&margin(a))
                .then(a.altitude_m.total_cmp(&b.altitude_m))
                .then(a.amplitude_deg.abs().total_cmp(&b.amplitude_deg.abs()))
        });
        Ok(points)
    }

    fn point(
        &self,
        point: &TestPoint,
        aircraft: &Aircraft,
        loading: &Loading,
        time_s: f64,
    ) -> StageResult<PlannedPoint> {
        let fuel_kg = self.fuel.start_kg - self.fuel.burn_kg_s * time_s;
        if fuel_kg <= 0.0 {
            return Err(format!(
                "point {}: no fuel is left after {:.0} min; start with more or fly fewer points",
                point.id,
                time_s / 60.0
            )
            .into());
        }
        let mut loading = loading.clone();
        let stated: f64 = loading.fuel_kg.values().sum();
        if stated <= 0.0 {
            return Err("the loading has no fuel to burn: state its tanks".into());
        }
        loading.fuel_kg.values_mut().for_each(|fuel| *fuel *= fuel_kg / stated);
        let mass = loading.mass_properties(aircraft);
        if let Some(issue) = loading.issues(aircraft, &mass).iter().find(|issue| issue.is_impossible()) {
            return Err(format!("point {}: {issue}", point.id).into());
        }
        let density = Atmosphere::STANDARD.density_kg_m3(point.altitude_m)?;
        let entry = entry(self, point, aircraft, &mass, density)?;
        let calibrated = entry.calibrated_m_s;
        let margins =
            aircraft.flight_envelope.margins(calibrated, point.altitude_m, entry.load_factor.max(1.0), mass.mass_kg);
        // Airspeeds only: those are what a point is chosen by.
        let speeds = margins.iter().filter(|own| ["stall", "buffet", "VNE"].contains(&own.limit));
        let nearest: Option<&FlightMargin> = speeds.min_by(|a, b| a.margin.total_cmp(&b.margin));
        let cg = mass.cg_from_datum_m[0];
        let own = aircraft.envelope.as_ref().and_then(|envelope| envelope.margin(mass.mass_kg, cg));
        let stated = self.knock_off.iter().chain(&point.knock_off).cloned();
        let risks: Vec<Risk> = self.risks.iter().chain(&point.risks).cloned().collect();
        Ok(PlannedPoint {
            id: point.id.clone(),
            airspeed_m_s: entry.airspeed_m_s,
            calibrated_m_s: calibrated,
            entry_note: entry.note,
            stall_m_s: entry.stall_m_s,
            least_airspeed_m_s: entry.least_m_s,
            bank_deg: point.bank_deg,
            load_factor: entry.load_factor,
            power: point.power.clone(),
            altitude_m: point.altitude_m,
            configuration: point.configuration.clone(),
            kind: point.kind.clone(),
            surface: point.surface.clone(),
            direction: point.direction.clone(),
            amplitude_deg: point.amplitude_deg,
            amplitude_inhg: point.amplitude_inhg,
            repeats: point.repeats,
            duration_s: point.duration_s,
            hazard: worst_hazard(&point.hazard, &risks),
            knock_off: entry.knock_off.into_iter().chain(stated).collect(),
            procedure: point.procedure.clone(),
            step_s: point.step_s,
            engine_speed_rpm: point.engine_speed_rpm,
            manifold_pressure_inhg: point.manifold_pressure_inhg,
            risks,
            start_s: time_s,
            fuel_kg,
            mass_kg: mass.mass_kg,
            cg_x_m: cg,
            cg_margin_m: own.map(|own| own.nearest_m()),
            nearest_limit: nearest.map(|own| own.limit.to_owned()),
            nearest_margin: nearest.map(|own| own.margin),
            windows: Vec::new(),
            status: Flown::Missing,
            evaluation: Vec::new(),
        })
    }

    /// Writes the steady time of the entry into the steps of the procedures.
    fn fill_steady_time(&mut self) {
        let time_s = significant(self.entry.steady_s, 2);
        let steps = self.points.iter_mut().flat_map(|point| &mut point.procedure).chain(&mut self.procedure);
        steps.for_each(|step| *step = step.replace(STEADY_TIME, &time_s));
    }

    /// Windows that no earlier point took, of this point's surface, kind and condition.
    fn find_windows<'s>(
        &self,
        row: &mut PlannedPoint,
        session: &'s Session,
        snapshot: &Snapshot,
        taken: &mut Vec<&'s str>,
    ) {
        let fits = |window: &&Manoeuvre| {
            let surfaces: Vec<&str> = window.surface.into_iter().chain(window.also).map(Surface::name).collect();
            surfaces.join(" and ") == row.surface_of_window()
                && window.kind.eq_ignore_ascii_case(&row.kind_of_window())
                && !taken.contains(&window.name.as_str())
                && self.is_near(row, window, snapshot)
        };
        let found: Vec<&Manoeuvre> = session.windows.iter().filter(fits).take(row.repeats).collect();
        taken.extend(found.iter().map(|window| window.name.as_str()));
        let usable = |window: &&&Manoeuvre| {
            let verdicts = snapshot.verdicts.ready();
            let level = verdicts.and_then(|verdicts| Some(verdicts.windows.get(&window.name)?.verdict.level));
            window.role != WindowRole::Ignored && level != Some(Level::Bad)
        };
        let good = found.iter().filter(usable).count();
        row.status = match (found.len(), good) {
            (0, _) => Flown::Missing,
            (_, good) if good >= row.repeats => Flown::Flown,
            _ => Flown::Repeat,
        };
        row.windows = found.into_iter().map(|window| window.name.clone()).collect();
    }

    fn is_near(&self, row: &PlannedPoint, window: &Manoeuvre, snapshot: &Snapshot) -> bool {
        let condition = match is_acceleration(&row.kind) {
            true => entry_of(window, snapshot),
            false => condition_of(window, snapshot),
        };
        condition.is_some_and(|(airspeed, altitude, _)| {
            let speed = (airspeed - row.airspeed_m_s).abs() <= self.tolerance.airspeed_m_s;
            speed && altitude.is_none_or(|own| (own - row.altitude_m).abs() <= self.tolerance.altitude_m)
        })
    }
}

/// Airspeed (m/s) and altitude (m) of a window's condition, and its mass (kg).
fn condition_of(window: &Manoeuvre, snapshot: &Snapshot) -> Option<(f64, Option<f64>, f64)> {
    let aero = snapshot.windows.get(&window.name)?.aero.ready()?;
    let found = crate::stage::measure_condition(aero)?;
    Some((found.airspeed_m_s, found.altitude_m, aero.data.mass.first()?.mass_kg))
}

/// Airspeed (m/s), altitude (m) and mass (kg) at the beginning of a window.
fn entry_of(window: &Manoeuvre, snapshot: &Snapshot) -> Option<(f64, Option<f64>, f64)> {
    let data = &snapshot.windows.get(&window.name)?.aero.ready()?.data;
    let altitude_m = data.altitude_m.as_ref().and_then(|altitude_m| altitude_m.first().copied());
    Some((*data.airspeed_m_s.first()?, altitude_m, data.mass.first()?.mass_kg))
}

/// The windows of a session as points of the envelope, each with its share of what all of them tell: the mean over the derivatives of its part
/// of the sum of squares of the regressor.
pub fn flown_points(session: &Session, snapshot: &Snapshot) -> Vec<FlownPoint> {
    let windows = snapshot.aero(session);
    let regressions = crate::stage::pooled_regressions(&windows, &session.structure, &session.estimation);
    let mut shares: std::collections::BTreeMap<&str, (f64, usize)> = std::collections::BTreeMap::new();
    for regression in regressions.iter().flatten() {
        let pooled = &regression.pooled;
        for column in 0..pooled.names.len() {
            let all: f64 = pooled.windows.iter().map(|window| square_about_mean(window, column)).sum();
            if all <= 0.0 {
                continue;
            }
            for window in &pooled.windows {
                let (sum, count) = shares.entry(&window.label).or_insert((0.0, 0));
                *sum += square_about_mean(window, column) / all;
                *count += 1;
            }
        }
    }
    let share = |name: &str| shares.get(name).map_or(0.0, |(sum, count)| sum / *count as f64);
    let point = |own: &Manoeuvre| flown_point(own, snapshot, session.filter.gravity_m_s2, share(&own.name));
    session.windows.iter().filter_map(point).collect()
}

fn square_about_mean(window: &doublet_core::estimate::PooledWindow, column: usize) -> f64 {
    let values = window.x.column(column);
    let mean = values.mean();
    values.iter().map(|value| (value - mean).powi(2)).sum::<f64>()
}

fn flown_point(window: &Manoeuvre, snapshot: &Snapshot, gravity_m_s2: f64, share: f64) -> Option<FlownPoint> {
    let (airspeed_m_s, altitude_m, mass_kg) = condition_of(window, snapshot)?;
    let aero = snapshot.windows.get(&window.name)?.aero.ready()?;
    let density = median(&mut aero.data.density_kg_m3.to_vec())?;
    let force = doublet_core::model::specific_force_at_cg(&aero.data, &aero.settings).ok()?;
    let loads = force[2].iter().map(|z| -z / gravity_m_s2);
    let (low, high) = loads.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    Some(FlownPoint {
        window: window.name.clone(),
        airspeed_m_s,
        calibrated_m_s: calibrated_m_s(airspeed_m_s, density),
        altitude_m: altitude_m?,
        load_factor_low: low,
        load_factor_high: high,
        mass_kg,
        share_of_information: share,
    })
}
