//! How the identified aircraft flies: linear model about a trim, natural modes and levels of flying qualities, each with its interval.

mod covariance;
mod function;
mod level_map;
mod measured;
mod model;
mod trim;

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use doublet_core::hash_fields;
use doublet_core::model::Coefficient;
use doublet_dynamics::linear::{Condition, Linearised, UncertainModel};
use doublet_dynamics::modes::{ModeStudy, mode_study};
use doublet_dynamics::qualities::{
    Airplane, Controls, Judgement, LevelShares, Limits, Measures, judge, judge_samples, measures,
};

use super::StudyInput;
use crate::builtin;
use crate::graph::{Context, Footprint, Stage, StageResult};
use crate::session::Session;

pub use covariance::joint_covariance;
pub use function::{Named, named_values, propagate_expression};
pub use level_map::MapPoint;
pub use measured::{MeasuredWindow, measured_modes};
pub use model::{ModelToTrim, pooled_model};
pub use trim::{Flown, level_model};

/// Why phugoid and stability of speed are not judged: a thrust inside CX is taken as proportional to dynamic pressure.
pub const THRUST_NOT_KNOWN: &str = "not judged: it depends on thrust over airspeed, which the model lacks; record the thrust or describe the engines, and remove it from the coefficients";

/// Folder of the limits that come with the program.
const LIMITS: &str = "flying_qualities";
/// Flying-qualities criteria.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Standard {
    /// MIL-F-8785C.
    #[default]
    MilF8785c,
    /// MIL-STD-1797A.
    MilStd1797a,
}

impl Standard {
    pub const ALL: [Self; 2] = [Self::MilF8785c, Self::MilStd1797a];

    doublet_core::variant_texts! {
        /// Name of its file.
        pub name: MilF8785c "mil_f_8785c", MilStd1797a "mil_std_1797a"
    }

    doublet_core::variant_texts! {
        /// Title as the document has it.
        pub title: MilF8785c "MIL-F-8785C", MilStd1797a "MIL-STD-1797A"
    }
}

/// Limits that are shown beside them, of criteria they do not have.
const BESIDE: [&str; 4] = ["mil_std_1797a", "gibson", "smith_geddes", "pio_phase_delay"];

/// A trim that is asked for, and who judges. What is left open follows from the windows: the median of their conditions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicsRequest {
    /// True airspeed, m/s.
    pub airspeed_m_s: Option<f64>,
    pub altitude_m: Option<f64>,
    /// Angle of the flight path, rad; level unless given.
    pub gamma_rad: Option<f64>,
    pub load_factor: Option<f64>,
    /// Whether that of a pull-up with the wings level; else of a turn.
    pub pull_up: bool,
    /// Mass, kg; inertia as flown.
    pub mass_kg: Option<f64>,
    /// Centre of gravity along the datum's x axis, m.
    pub cg_x_m: Option<f64>,
    /// Fuel on board in all, kg, shared among the tanks as in the loading: mass, centre of gravity and inertia follow.
    pub fuel_kg: Option<f64>,
    /// Window whose conditions are taken, by [`window_key`] of its name; all identification windows unless given.
    pub window: Option<u64>,
    /// Limits that judge.
    pub standard: Standard,
    /// Class of the aircraft in flying qualities, by its place in [`CLASSES`]; that of its mass unless given.
    pub class: Option<usize>,
    /// Category of the flight phase, by its place in [`CATEGORIES`]; B unless given.
    pub category: Option<usize>,
    /// Delay from stick to surfaces, s: bandwidth, phase delay and the pilot's loop are judged with it only.
    pub stick_delay_s: Option<f64>,
    /// Aileron deflection available from the trim, rad: roll performance is judged with it only.
    pub aileron_rad: Option<f64>,
    /// Draws of the derivatives.
    pub samples: usize,
    /// Seed of the draws.
    pub seed: u64,
}

/// Classes of aircraft in flying qualities.
pub const CLASSES: [&str; 5] = ["I", "II-L", "II-C", "III", "IV"];
/// Greatest masses of classes I and II, kg: those above which an aeroplane is neither small (12,500 lb, 14 CFR 1.1) nor of medium weight
/// (60,000 lb). The specification names kinds of aircraft, not masses; class IV, of high manoeuvrability, does not follow from one.
const CLASS_MASSES_KG: [(f64, &str); 2] = [(5_670.0, "I"), (27_200.0, "II-L")];
/// Class above these.
const HEAVY_CLASS: &str = "III";
/// Category that judges unless another is asked for: climb, cruise, descent and loiter.
pub const USUAL_CATEGORY: &str = "B";
/// Categories of flight phases.
pub const CATEGORIES: [&str; 3] = ["A", "B", "C"];

/// Key of a window's name, so that requests can be copied.
pub fn window_key(name: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    name.hash(&mut hasher);
    hasher.finish()
}

// None of its numbers is ever "not a number": requests are made of numbers that were read.
impl Eq for DynamicsRequest {}

hash_fields!(DynamicsRequest {
    pull_up, window, standard, class, category, samples, seed;
    airspeed_m_s, altitude_m, gamma_rad, load_factor, mass_kg, cg_x_m, fuel_kg, stick_delay_s, aileron_rad
});

impl Default for DynamicsRequest {
    fn default() -> Self {
        Self {
            airspeed_m_s: None,
            altitude_m: None,
            gamma_rad: None,
            load_factor: None,
            pull_up: false,
            mass_kg: None,
            cg_x_m: None,
            fuel_kg: None,
            window: None,
            standard: Standard::default(),
            class: None,
            category: None,
            stick_delay_s: None,
            aileron_rad: None,
            samples: 500,
            seed: 1,
        }
    }
}

/// How an aircraft flies at one trim.
#[derive(Clone, Debug)]
pub struct DynamicsStudy {
    /// What was asked for.
    pub request: DynamicsRequest,
    /// The model with the covariance of its derivatives.
    pub model: Arc<UncertainModel>,
    /// The condition, everything that was left open filled in.
    pub condition: Condition,
    /// Linear model, modes and samples.
    pub modes: ModeStudy,
    /// Class and category.
    pub airplane: Airplane,
    /// Where they come from, in words.
    pub airplane_from: String,
    /// Limits that judge.
    pub limits: Arc<Limits>,
    /// Measures of the flying qualities.
    pub measures: Measures,
    pub sampled: Vec<Measures>,
    /// Their levels.
    pub judgement: Judgement,
    /// How likely each level is.
    pub shares: Vec<LevelShares>,
    /// Levels at every condition that was flown.
    pub map: Vec<MapPoint>,
    /// Why phugoid and stability of speed are not judged, where they are not.
    pub speed_not_judged: Option<&'static str>,
    /// Modes in the free responses of the windows.
    pub measured: Vec<MeasuredWindow>,
    /// Windows whose median conditions fill what was left open.
    pub windows: Vec<String>,
    /// What is to be known of it, one line each.
    pub notes: Vec<String>,
}

impl Footprint for DynamicsStudy {
    fn bytes(&self) -> usize {
        8192 * (self.modes.samples.len() + 2 * self.model.names.len() + 1)
    }
}

impl Stage for DynamicsStudy {
    type Params<'a> = DynamicsRequest;
    type Inputs<'a> = &'a StudyInput<'a>;
    type Output = Self;
    const NAME: &'static str = "linear model and modes";

    fn run(request: DynamicsRequest, input: &StudyInput<'_>, context: &Context<'_>) -> StageResult<Self> {
        let ModelToTrim { mut model, mut notes } = ModelToTrim::clone(&*context.get::<ModelToTrim>((), input)?);
        let (condition, windows) = trim::condition(&request, input, &mut model, &mut notes)?;
        context.checkpoint()?;
        let line = |error: doublet_dynamics::linear::LinearError| error.to_string();
        let modes = mode_study(&model, &condition, request.samples, request.seed).map_err(line)?;
        context.checkpoint()?;
        let limits = joined_limits(request.standard)?;
        let (airplane, airplane_from) = airplane(&request, greatest_mass_kg(input, condition.mass.mass_kg))?;
        let controls = Controls {
            stick_delay_s: request.stick_delay_s,
            aileron_rad: request.aileron_rad,
            task: limits.pilot_task(&airplane),
        };
        let speed_not_judged = (!model.model.has_thrust()).then_some(THRUST_NOT_KNOWN);
        let judged = |linearised: &Linearised| {
            let mut found = measures(linearised, &controls);
            if speed_not_judged.is_some() {
                found.remove_speed();
            }
            found
        };
        let measured = judged(&modes.linearised);
        let nominal: Vec<_> = modes.modes.iter().map(|estimate| estimate.mode.clone()).collect();
        let sampled: Vec<Measures> = modes.samples.iter().map(judged).collect();
        context.checkpoint()?;
        let map = level_map::level_map(input, &model.model, (&limits, &airplane), &judged);
        if modes.without_trim > 0 {
            notes
                .push(format!("{} of {} samples of the derivatives have no trim", modes.without_trim, request.samples));
        }
        Ok(Self {
            measured: measured_modes(input.windows, &nominal),
            judgement: judge(&limits, &airplane, &measured),
            shares: judge_samples(&limits, &airplane, &sampled),
            measures: measured,
            sampled,
            map,
            speed_not_judged,
            model: Arc::new(model),
            limits: Arc::new(limits),
            request,
            condition,
            modes,
            airplane,
            airplane_from,
            windows,
            notes,
        })
    }
}

/// Greatest mass the aircraft file has in its envelope, or else the mass given, kg.
fn greatest_mass_kg(input: &StudyInput<'_>, mass_kg: f64) -> f64 {
    let envelope = input.aircraft.loaded.aircraft.envelope.as_ref();
    let heaviest = envelope.and_then(|envelope| envelope.rows.last());
    heaviest.map_or(mass_kg, |row| row.mass_kg)
}

/// Class and category by default of an aircraft that has no linear model, and their source; none without a mass.
pub(super) fn airplane_by_default(input: &StudyInput<'_>) -> StageResult<Option<(Airplane, String)>> {
    let mass_kg = greatest_mass_kg(input, input.aircraft.mass.mass_kg);
    (mass_kg > 0.0).then(|| airplane(&DynamicsRequest::default(), mass_kg)).transpose()
}

/// Class and category as asked for, those nobody asked for by the greatest mass and the usual one; and where they come from.
fn airplane(request: &DynamicsRequest, mass_kg: f64) -> StageResult<(Airplane, String)> {
    let by_mass = CLASS_MASSES_KG.iter().find(|(greatest_kg, _)| mass_kg <= *greatest_kg);
    let by_mass = by_mass.map_or(HEAVY_CLASS, |(_, class)| *class);
    let class = request.class.and_then(|place| CLASSES.get(place).copied());
    let category = request.category.and_then(|place| CATEGORIES.get(place).copied());
    let airplane = Airplane::new(class.unwrap_or(by_mass), category.unwrap_or(USUAL_CATEGORY));
    let airplane = airplane.map_err(|error| error.to_string())?;
    let class = match class {
        Some(class) => format!("class {class} as requested"),
        None => format!("class {by_mass} by its maximum mass of {mass_kg:.0} kg"),
    };
    let category = match category {
        Some(category) => format!("category {category} as requested"),
        None => format!("category {USUAL_CATEGORY} by default"),
    };
    Ok((airplane, format!("{class}; {category}")))
}

/// Whether a session asks for a model that can be trimmed: an aircraft, both forces of the plane of symmetry and the pitching moment.
pub fn is_modelled(session: &Session) -> bool {
    let has = |coefficient| session.structure.terms(coefficient).is_some();
    let forces = (has(Coefficient::CX) && has(Coefficient::CZ)) || (has(Coefficient::CD) && has(Coefficient::CL));
    session.aircraft.is_some() && forces && has(Coefficient::Cm)
}

/// The limits of a standard with those shown beside them.
pub(super) fn joined_limits(standard: Standard) -> StageResult<Limits> {
    let name = standard.name();
    let beside = BESIDE.into_iter().filter(|beside| *beside != name);
    beside.map(limits).try_fold(limits(name)?, |joined, beside| Ok(joined.with(beside?)))
}

/// Limits that come with the program, by name.
pub fn limits(name: &str) -> StageResult<Limits> {
    let known = || builtin::names(LIMITS).join(", ");
    let text = builtin::text(LIMITS, name);
    let text = text.ok_or_else(|| format!("no limits are called '{name}': use one of {}", known()))?;
    Ok(Limits::parse(text).map_err(|error| format!("{name}: {error}"))?)
}
