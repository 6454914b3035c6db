//! Experiments: whole configurations of the analysis kept by name, to compare and to take up again.

use std::sync::Arc;

use doublet_core::model::{Coefficient, Structure, Term};
use doublet_core::reconstruct::{FilterSettings, Method};
use doublet_core::series::TimeRange;

use super::{
    DelaySource, EditError, Estimation, GravitySource, GustSource, PathSource, Preparation, SensorErrors, Session,
    WindowRole,
};

pub const MOST_EXPERIMENTS: usize = 100;
/// Factors on the noise of all measurements of [`noise_experiments`].
const NOISE_FACTORS: [f64; 2] = [0.5, 2.0];

/// A configuration with the name it is kept under.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Name, unique in the session.
    pub name: String,
    /// Configuration, shared by the sessions of the undo history.
    pub configuration: Arc<Configuration>,
}

/// Everything of a session that an analyst chooses: filter, noise, structure, manoeuvres, estimator. Recordings, aircraft and loading
/// are shared by all experiments.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// Settings of the flight path reconstruction.
    pub filter: FilterSettings,
    /// Source of the acceleration of gravity.
    pub gravity: GravitySource,
    /// Source of the random walk of the wind.
    pub gusts: GustSource,
    /// Source of the delays of the measurements.
    pub delays: DelaySource,
    /// How coefficients are formed.
    pub preparation: Preparation,
    /// Sensor errors that are estimated.
    pub sensor_errors: SensorErrors,
    /// How derivatives are estimated.
    pub estimation: Estimation,
    /// Terms of each coefficient.
    pub structure: Structure,
    /// Use of every manoeuvre, in the order of the session.
    pub manoeuvres: Vec<ManoeuvreUse>,
}

/// How a configuration uses a manoeuvre.
#[derive(Clone, Debug, PartialEq)]
pub struct ManoeuvreUse {
    pub name: String,
    /// First and last instant.
    pub window: TimeRange,
    pub role: WindowRole,
    /// Excluded parts.
    pub excluded: Vec<TimeRange>,
}

/// A change of the experiments.
#[derive(Clone, Debug, PartialEq)]
pub enum ExperimentEdit {
    /// Keeps the present configuration under a name, which is numbered where it is taken.
    Keep(String),
    /// Adds experiments, each under its name, which is numbered where it is taken. One that is there already is not added again.
    Add(Vec<Experiment>),
    /// Removes an experiment.
    Drop(String),
    Rename {
        /// Present name.
        from: String,
        /// New name.
        to: String,
    },
    /// Makes the configuration of an experiment the present one.
    Apply(String),
}

impl Configuration {
    /// The present configuration of a session.
    pub fn from_session(session: &Session) -> Self {
        let manoeuvres = session.windows.iter().map(|window| ManoeuvreUse {
            name: window.name.clone(),
            window: window.window,
            role: window.role,
            excluded: window.excluded.clone(),
        });
        Self {
            filter: session.filter.clone(),
            gravity: session.gravity,
            gusts: session.gusts,
            delays: session.delays,
            preparation: session.preparation.clone(),
            sensor_errors: session.sensor_errors.clone(),
            estimation: session.estimation.clone(),
            structure: session.structure.clone(),
            manoeuvres: manoeuvres.collect(),
        }
    }

    /// The session with this configuration; its experiments stay.
    #[must_use]
    pub fn applied_to(&self, session: &Session) -> Session {
        let mut next = session.clone();
        next.filter.clone_from(&self.filter);
        (next.gravity, next.gusts, next.delays) = (self.gravity, self.gusts, self.delays);
        next.preparation.clone_from(&self.preparation);
        next.sensor_errors.clone_from(&self.sensor_errors);
        next.estimation.clone_from(&self.estimation);
        next.structure.clone_from(&self.structure);
        for window in &mut next.windows {
            if let Some(used) = self.manoeuvres.iter().find(|used| used.name == window.name) {
                (window.window, window.role) = (used.window, used.role);
                window.excluded.clone_from(&used.excluded);
            }
        }
        next
    }

    /// Whether both fit the same samples, so that information criteria can be compared: they differ in structure and estimator alone.
    pub fn has_data_of(&self, other: &Self) -> bool {
        let structure = other.structure.clone();
        let estimation = Estimation { by_surface: self.estimation.by_surface, ..other.estimation.clone() };
        *other == Self { structure, estimation, ..self.clone() }
    }
}

impl Session {
    /// The experiment called `name`.
    pub fn experiment(&self, name: &str) -> Option<&Experiment> {
        self.experiments.iter().find(|experiment| experiment.name == name)
    }

    /// The session without its experiments, as one of them is run.
    #[must_use]
    pub fn without_experiments(&self) -> Self {
        Self { experiments: Vec::new(), ..self.clone() }
    }

    /// The session with further experiments, for its own manoeuvres; those it has already or has no room for are left out.
    #[must_use]
    pub(crate) fn with_experiments(&self, added: &[Experiment]) -> Self {
        let mut next = self.clone();
        for experiment in added {
            if !next.has_experiment(experiment) {
                let _ = next.keep(experiment.clone());
            }
        }
        next.follow_manoeuvres();
        next
    }

    /// Gives every experiment the manoeuvres of the session: those marked since as they are, those removed no more.
    pub(super) fn follow_manoeuvres(&mut self) {
        let present = Configuration::from_session(self).manoeuvres;
        for Experiment { configuration, .. } in &mut self.experiments {
            let manoeuvres = uses_of(&present, &configuration.manoeuvres);
            Arc::make_mut(configuration).manoeuvres = manoeuvres;
        }
    }

    /// Calls a manoeuvre otherwise in every experiment.
    pub(super) fn rename_in_experiments(&mut self, from: &str, to: &str) {
        for Experiment { configuration, .. } in &mut self.experiments {
            let used = Arc::make_mut(configuration).manoeuvres.iter_mut().filter(|used| used.name == from);
            used.for_each(|used| to.clone_into(&mut used.name));
        }
    }

    /// A name for an experiment that none has: `name`, or `name 2` and so on where one is called so.
    pub fn free_experiment_name(&self, name: &str) -> String {
        let numbered = (2..).map(|number| format!("{name} {number}"));
        let mut names = std::iter::once(name.to_owned()).chain(numbered);
        names.find(|name| self.experiment(name).is_none()).unwrap_or_default()
    }

    /// Whether it has this configuration under this name, or under the name with a number.
    fn has_experiment(&self, experiment: &Experiment) -> bool {
        self.experiments
            .iter()
            .any(|one| Self::is_numbered(&one.name, &experiment.name) && one.configuration == experiment.configuration)
    }

    /// Whether it is the name, or the name with a number behind it.
    fn is_numbered(name: &str, base: &str) -> bool {
        let rest = name.strip_prefix(base);
        rest.is_some_and(|rest| {
            rest.is_empty() || rest.strip_prefix(' ').is_some_and(|number| number.parse::<u32>().is_ok())
        })
    }

    fn keep(&mut self, experiment: Experiment) -> Result<(), EditError> {
        let experiment = Experiment { name: self.free_experiment_name(&experiment.name), ..experiment };
        check_name(&experiment.name)?;
        if self.experiments.len() == MOST_EXPERIMENTS {
            let text = format!("the session has {MOST_EXPERIMENTS} experiments (limit {MOST_EXPERIMENTS}): remove one");
            return Err(EditError::Name(text));
        }
        self.experiments.push(experiment);
        Ok(())
    }
}

/// The uses of the manoeuvres of `present`: those of `known` where it has them.
pub(super) fn uses_of(present: &[ManoeuvreUse], known: &[ManoeuvreUse]) -> Vec<ManoeuvreUse> {
    let by_name = |name: &str| known.iter().find(|used| used.name == name);
    present.iter().map(|present| by_name(&present.name).unwrap_or(present).clone()).collect()
}

fn check_name(name: &str) -> Result<(), EditError> {
    if name.trim().is_empty() {
        return Err(EditError::Name("the name of an experiment cannot be empty: enter one".to_owned()));
    }
    super::check::name_fits("experiment", name).map_err(EditError::Name)
}

impl ExperimentEdit {
    pub(super) fn label(&self) -> String {
        match self {
            Self::Keep(name) => format!("keep experiment {name}"),
            Self::Add(experiments) => match experiments.as_slice() {
                [one] => format!("add experiment {}", one.name),
                several => format!("add {} experiments", several.len()),
            },
            Self::Drop(name) => format!("remove experiment {name}"),
            Self::Rename { from, to } => format!("rename experiment {from} to {to}"),
            Self::Apply(name) => format!("make experiment {name} current"),
        }
    }

    pub(super) fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        let missing = |name: &str| EditError::NoExperiment(name.to_owned());
        match self {
            Self::Keep(name) => {
                session.keep(Experiment {
                    name: name.clone(),
                    configuration: Configuration::from_session(session).into(),
                })?;
            }
            Self::Add(experiments) => {
                for one in experiments {
                    if !session.has_experiment(one) {
                        session.keep(one.clone())?;
                    }
                }
            }
            Self::Drop(name) => {
                session.experiment(name).ok_or_else(|| missing(name))?;
                session.experiments.retain(|experiment| experiment.name != *name);
            }
            Self::Rename { from, to } => {
                if from != to && session.experiment(to).is_some() {
                    return Err(EditError::Name(format!("experiment '{to}' exists already: choose another name")));
                }
                check_name(to)?;
                let found = session.experiments.iter_mut().find(|experiment| experiment.name == *from);
                found.ok_or_else(|| missing(from))?.name.clone_from(to);
            }
            Self::Apply(name) => {
                let experiment = session.experiment(name).ok_or_else(|| missing(name))?;
                *session = experiment.configuration.applied_to(session);
            }
        }
        Ok(())
    }
}

/// The usual filters: extended, iterated and unscented, each with the smoothed and the filtered path, and the path as measured.
pub fn filter_experiments(session: &Session) -> Vec<Experiment> {
    let present = Configuration::from_session(session);
    let iterated = match present.filter.method {
        method @ Method::Iekf { .. } => method,
        _ => Method::USUAL_IEKF,
    };
    let unscented = match present.filter.method {
        method @ Method::Ukf { .. } => method,
        _ => Method::Ukf { spread: Method::USUAL_SPREAD },
    };
    let methods = [("EKF", Method::Ekf), ("Iterated EKF", iterated), ("Unscented", unscented)];
    let paths = [("smoothed", PathSource::Smoothed), ("filtered", PathSource::Filtered)];
    let one = |name: String, method: Method, path: PathSource| {
        let mut configuration = present.clone();
        configuration.filter.method = method;
        configuration.preparation.path = path;
        Experiment { name, configuration: configuration.into() }
    };
    let filters = methods.into_iter().flat_map(|(filter, method)| {
        paths.into_iter().map(move |(word, path)| one(format!("{filter}, {word}"), method, path))
    });
    filters.chain([one("Measured path".to_owned(), present.filter.method, PathSource::Measured)]).collect()
}

/// The present configuration with half and twice the noise of all measurements.
pub fn noise_experiments(session: &Session) -> Vec<Experiment> {
    let one = |factor: f64| {
        let mut configuration = Configuration::from_session(session);
        configuration.filter.measurement_noise.iter_mut().for_each(|noise| *noise *= factor);
        Experiment { name: format!("{factor} x measurement noise"), configuration: configuration.into() }
    };
    NOISE_FACTORS.map(one).into()
}

/// The present configuration with every second manoeuvre: those of odd number, then those of even number identify, the others validate.
/// Manoeuvres that are ignored stay so.
pub fn manoeuvre_experiments(session: &Session) -> Vec<Experiment> {
    [("Odd manoeuvres", 0), ("Even manoeuvres", 1)]
        .map(|(name, first)| identify_every_second(session, name, first))
        .into()
}

fn identify_every_second(session: &Session, name: &str, first: usize) -> Experiment {
    let mut configuration = Configuration::from_session(session);
    let used = configuration.manoeuvres.iter_mut().filter(|used| used.role != WindowRole::Ignored);
    for (place, used) in used.enumerate() {
        used.role = if place % 2 == first { WindowRole::Identification } else { WindowRole::Validation };
    }
    Experiment { name: name.to_owned(), configuration: configuration.into() }
}

/// Every configuration with every set of manoeuvres: each of `configurations` with the manoeuvres of each of `sets`.
pub fn cross_experiments(configurations: &[Experiment], sets: &[Experiment]) -> Vec<Experiment> {
    configurations.iter().flat_map(|configuration| sets.iter().map(move |set| cross(configuration, set))).collect()
}

fn cross(configuration: &Experiment, set: &Experiment) -> Experiment {
    let manoeuvres = set.configuration.manoeuvres.clone();
    let crossed = Configuration { manoeuvres, ..Configuration::clone(&configuration.configuration) };
    Experiment { name: format!("{}, {}", configuration.name, set.name), configuration: crossed.into() }
}

/// The present configuration without one term of a coefficient each; the constant stays.
pub fn structure_experiments(session: &Session, coefficient: Coefficient) -> Vec<Experiment> {
    let terms = session.structure.terms(coefficient).unwrap_or_default();
    terms.iter().filter(|term| !term.is_constant()).map(|term| leave_out(session, coefficient, term)).collect()
}

fn leave_out(session: &Session, coefficient: Coefficient, term: &Term) -> Experiment {
    let mut next = session.clone();
    super::edit::set_term(&mut next.structure, coefficient, term, false);
    next.forget_lost_terms();
    let name = format!("Without {}", term.derivative_name(coefficient));
    Experiment { name, configuration: Configuration::from_session(&next).into() }
}
