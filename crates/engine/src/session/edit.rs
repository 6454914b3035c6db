//! Edits: the only way a session changes.

use doublet_core::airframe::Loading;
use doublet_core::estimate::Constraint;
use doublet_core::model::{Coefficient, Lag, Structure, Term};
use doublet_core::reconstruct::{AirState, InputHold, Measurement, Method, State};
use doublet_core::series::TimeRange;
use thiserror::Error;

use super::{
    AircraftEdit, AnnotationEdit, CandidateEdit, DelaySource, ExperimentEdit, ExpressionEdit, Flight, GravitySource,
    GustSource, NoiseEdit, PathSource, PooledConstants, PredictionParameters, Preparation, ReportFigureEdit,
    ResidualWeights, Session, SignalEdit, Surface, TermConstraint, WindowEdit,
};

/// A change of the session, grouped by area.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// New title.
    Title(String),
    Aircraft(AircraftEdit),
    /// What is on board.
    Loading(LoadingEdit),
    Window(WindowEdit),
    /// Manoeuvres found in the recordings that are refused.
    Candidate(CandidateEdit),
    /// Clocks, smoothing and resampling.
    Signal(SignalEdit),
    /// Channels by expression.
    Expression(ExpressionEdit),
    /// Steady parts and the noise entries that follow from them.
    Noise(NoiseEdit),
    /// Flight path reconstruction.
    Filter(FilterEdit),
    /// Coefficients and estimate.
    Estimation(EstimationEdit),
    /// Terms of the aerodynamic model.
    Model(ModelEdit),
    /// Configurations kept by name.
    Experiment(ExperimentEdit),
    /// Words at instants of a flight.
    Annotation(AnnotationEdit),
    /// What the flights were for, as the report states it.
    ReportPurpose(String),
    /// Derivatives that the report answers, by name.
    ReportAsked(Vec<String>),
    /// Notes of the author for the report.
    ReportNotes(String),
    /// Day and crew of a flight.
    FlightLog {
        flight: String,
        /// Day it was flown.
        date: String,
        /// Who flew it.
        crew: String,
    },
    /// Figures of the author's choice for the report.
    ReportFigure(ReportFigureEdit),
    /// Where a recording of a flight lies, as when it was moved.
    RecordingPath {
        flight: String,
        /// Place of the recording among those of the flight.
        index: usize,
        /// File or folder, relative to the session file.
        path: String,
    },
}

/// A change of what is on board.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadingEdit {
    /// Back to the aircraft's standard loading.
    Standard,
    /// The whole loading.
    All(Loading),
    /// The loading of one flight; `None` for the session's.
    OfFlight { flight: String, loading: Option<Loading> },
}

/// A change of the filter settings.
#[derive(Clone, Debug, PartialEq)]
pub enum FilterEdit {
    /// Initial standard deviation of a state, SI.
    InitialDeviation(State, f64),
    /// Random walk of a state, SI per square root of a second.
    RandomWalk(State, f64),
    Method(Method),
    /// Input between samples.
    Hold(InputHold),
    /// Gravity, m/s².
    Gravity(f64),
    /// Standard deviation of an air-data state; zero leaves it out. Dimensionless or rad.
    AirDataDeviation(AirState, f64),
    /// Delay of a measurement, s.
    MeasurementDelay(Measurement, f64),
    /// Passes of the smoother at most.
    SmootherPasses(usize),
    /// Limit of outliers, deviations; zero for none.
    OutlierLimit(f64),
    /// Innovation beyond which a measurement weighs less, deviations; zero for none.
    RobustLimit(f64),
    /// Where the random walk of the wind comes from.
    Gusts(GustSource),
    /// Where the delays of the measurements come from.
    Delays(DelaySource),
}

/// A change of how coefficients are formed and derivatives estimated.
#[derive(Clone, Debug, PartialEq)]
pub enum EstimationEdit {
    /// States used.
    Path(PathSource),
    /// All settings of the preparation at once.
    Preparation(Preparation),
    /// Coefficients by the surface moved.
    BySurface(bool),
    /// Constants of the pooled estimate.
    Constants(PooledConstants),
    /// What windows are predicted with.
    PredictWith(PredictionParameters),
    /// What the residuals weigh.
    Weights(ResidualWeights),
    /// Lag and delay of a control.
    ControlLag(Surface, Lag),
    /// What is known of a derivative beforehand.
    Constrain(TermConstraint),
}

/// A change of the aerodynamic model.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelEdit {
    /// Adds or removes one term of one coefficient.
    SetTerm {
        coefficient: Coefficient,
        term: Term,
        /// Whether the model has it.
        on: bool,
    },
    /// Replaces the whole structure.
    Structure(Structure),
}

/// An edit that cannot be applied.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EditError {
    #[error("no manoeuvre is called '{0}'")]
    NoWindow(String),
    #[error("manoeuvre '{0}' exists already: choose another name")]
    WindowExists(String),
    /// A name that no file of results can have.
    #[error("{0}")]
    Name(String),
    /// The window's flight is not in the session.
    #[error("no flight is called '{0}'")]
    NoFlight(String),
    #[error("no experiment is called '{0}'")]
    NoExperiment(String),
    #[error("manoeuvre from {start_s} s to {end_s} s: set its end after its start")]
    EmptyWindow { start_s: f64, end_s: f64 },
    #[error("excluded part from {start_s} s to {end_s} s: set its end after its start")]
    EmptyPart { start_s: f64, end_s: f64 },
    /// Smoothing or resampling that cannot be done.
    #[error("{0}")]
    Signals(String),
    /// A channel by expression that cannot be.
    #[error("{0}")]
    Expression(String),
    /// A value that is not a usable number.
    #[error("{field} cannot be {value}: {allowed}")]
    Value { field: String, value: f64, allowed: &'static str },
}

impl Edit {
    /// Whether it keeps experiments, which are results: it is no step of undo.
    pub(crate) fn keeps_experiments(&self) -> bool {
        matches!(self, Self::Experiment(ExperimentEdit::Keep(_) | ExperimentEdit::Add(_)))
    }

    /// Name of the step in the undo list.
    pub fn label(&self) -> String {
        match self {
            Self::Title(_) => "change title".to_owned(),
            Self::Aircraft(edit) => edit.label(),
            Self::Loading(edit) => edit.label(),
            Self::Window(edit) => edit.label(),
            Self::Candidate(edit) => edit.label(),
            Self::Signal(edit) => edit.label(),
            Self::Expression(edit) => edit.label(),
            Self::Noise(edit) => edit.label(),
            Self::Filter(edit) => edit.label(),
            Self::Estimation(edit) => edit.label(),
            Self::Annotation(edit) => edit.label(),
            Self::ReportPurpose(_) => "change purpose of the report".to_owned(),
            Self::ReportAsked(_) => "change derivatives asked for".to_owned(),
            Self::ReportNotes(_) => "change notes of the report".to_owned(),
            Self::FlightLog { flight, .. } => format!("change date or crew of {flight}"),
            Self::ReportFigure(edit) => edit.label().to_owned(),
            Self::RecordingPath { flight, .. } => format!("find a recording of {flight}"),
            Self::Model(edit) => edit.label(),
            Self::Experiment(edit) => edit.label(),
        }
    }

    /// The session after this edit.
    pub fn apply(&self, session: &Session) -> Result<Session, EditError> {
        let mut next = session.clone();
        match self {
            Self::Title(title) => {
                super::check::name_fits("title", title).map_err(EditError::Name)?;
                next.title.clone_from(title);
            }
            Self::Aircraft(edit) => edit.apply(&mut next)?,
            Self::Loading(edit) => edit.apply(&mut next)?,
            Self::Window(edit) => edit.apply(&mut next)?,
            Self::Candidate(edit) => edit.apply(&mut next)?,
            Self::Signal(edit) => edit.apply(&mut next)?,
            Self::Expression(edit) => edit.apply(&mut next)?,
            Self::Noise(edit) => edit.apply(&mut next)?,
            Self::Filter(edit) => edit.apply(&mut next)?,
            Self::Estimation(edit) => edit.apply(&mut next)?,
            Self::Annotation(edit) => edit.apply(&mut next)?,
            Self::ReportPurpose(purpose) => next.report_purpose.clone_from(purpose),
            Self::ReportAsked(asked) => next.report_asked.clone_from(asked),
            Self::ReportNotes(notes) => next.report_notes.clone_from(notes),
            Self::FlightLog { flight, date, crew } => {
                for (what, text) in [("date", date), ("crew", crew)] {
                    super::check::name_fits(what, text).map_err(EditError::Name)?;
                }
                let found = flight_mut(&mut next, flight)?;
                found.date.clone_from(date);
                found.crew.clone_from(crew);
            }
            Self::ReportFigure(edit) => edit.apply(&mut next)?,
            Self::RecordingPath { flight, index, path } => {
                let found = flight_mut(&mut next, flight)?;
                if let Some(recording) = found.recordings.get_mut(*index) {
                    recording.path.clone_from(path);
                }
            }
            Self::Model(edit) => edit.apply(&mut next),
            Self::Experiment(edit) => edit.apply(&mut next)?,
        }
        Ok(next)
    }
}

impl LoadingEdit {
    fn label(&self) -> String {
        match self {
            Self::Standard => "return to the standard loading".to_owned(),
            Self::All(_) => "change loading".to_owned(),
            Self::OfFlight { flight, .. } => format!("change loading of flight {flight}"),
        }
    }

    fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        let (Self::All(stated) | Self::OfFlight { loading: Some(stated), .. }) = self else {
            *self.loading_mut(session)? = None;
            return Ok(());
        };
        let places = [&stated.fuel_kg, &stated.seats_kg, &stated.luggage_kg];
        for (name, &mass) in places.into_iter().flatten() {
            not_negative("mass of", name, mass)?;
        }
        *self.loading_mut(session)? = Some(stated.clone());
        Ok(())
    }

    /// The loading it changes.
    fn loading_mut<'a>(&self, session: &'a mut Session) -> Result<&'a mut Option<Loading>, EditError> {
        let Self::OfFlight { flight: name, .. } = self else { return Ok(&mut session.loading) };
        Ok(&mut flight_mut(session, name)?.loading)
    }
}

/// The flight called `name`, to change it.
pub(super) fn flight_mut<'a>(session: &'a mut Session, name: &str) -> Result<&'a mut Flight, EditError> {
    let found = session.flights.iter_mut().find(|flight| flight.name == name);
    found.ok_or_else(|| EditError::NoFlight(name.to_owned()))
}

pub(super) fn check_interval(window: TimeRange) -> Result<(), EditError> {
    let TimeRange { start_s, end_s } = window;
    if start_s.is_finite() && end_s.is_finite() && end_s > start_s {
        Ok(())
    } else {
        Err(EditError::EmptyWindow { start_s, end_s })
    }
}

impl FilterEdit {
    fn label(&self) -> String {
        match self {
            Self::InitialDeviation(state, _) => format!("change initial standard deviation of {}", state.name()),
            Self::RandomWalk(state, _) => format!("change random walk of {}", state.name()),
            Self::Method(_) => "change filter".to_owned(),
            Self::Hold(_) => "change input hold".to_owned(),
            Self::Gravity(_) => "change gravity".to_owned(),
            Self::AirDataDeviation(state, _) => format!("change initial standard deviation of {}", state.name()),
            Self::MeasurementDelay(measurement, _) => format!("change delay of {}", measurement.name()),
            Self::SmootherPasses(_) => "change passes of the smoother".to_owned(),
            Self::OutlierLimit(_) => "change limit of outliers".to_owned(),
            Self::RobustLimit(_) => "change limit of Huber's weights".to_owned(),
            Self::Gusts(_) => "change gusts".to_owned(),
            Self::Delays(_) => "change source of the measurement delays".to_owned(),
        }
    }

    fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        let filter = &mut session.filter;
        match *self {
            Self::InitialDeviation(state, value) => {
                filter.initial_deviation[state as usize] = not_negative("initial deviation", state.name(), value)?;
            }
            Self::RandomWalk(state, value) => {
                filter.random_walk[state as usize] = not_negative("random walk", state.name(), value)?;
            }
            Self::Method(method) => filter.method = method,
            Self::Hold(hold) => filter.hold = hold,
            Self::Gravity(value) => {
                filter.gravity_m_s2 = positive("gravity", "", value)?;
                session.gravity = GravitySource::Stated;
            }
            Self::AirDataDeviation(state, value) => {
                filter.air_data_deviation[state as usize] = not_negative("initial deviation", state.name(), value)?;
            }
            Self::MeasurementDelay(measurement, value) => {
                if !value.is_finite() {
                    let field = format!("delay {}", measurement.name());
                    return Err(EditError::Value { field, value, allowed: "it must be a number of seconds" });
                }
                filter.measurement_delay_s[measurement as usize] = value;
            }
            Self::SmootherPasses(value) => filter.smoother_passes = value.clamp(1, 100),
            Self::OutlierLimit(value) => filter.outlier_limit = not_negative("limit of outliers", "", value)?,
            Self::RobustLimit(value) => filter.robust_limit = not_negative("limit of Huber's weights", "", value)?,
            Self::Gusts(source) => session.gusts = source,
            Self::Delays(source) => session.delays = source,
        }
        Ok(())
    }
}

pub(super) fn positive(what: &str, name: &str, value: f64) -> Result<f64, EditError> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(EditError::Value { field: format!("{what} {name}").trim().to_owned(), value, allowed: "it must be above zero" })
}

fn not_negative(what: &str, name: &str, value: f64) -> Result<f64, EditError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    Err(EditError::Value { field: format!("{what} {name}"), value, allowed: "it must be zero or above" })
}

impl EstimationEdit {
    fn label(&self) -> String {
        match self {
            Self::Path(PathSource::Filtered) => "use the filtered path".to_owned(),
            Self::Path(PathSource::Smoothed) => "use the smoothed path".to_owned(),
            Self::Path(PathSource::Measured) => "use the path as measured".to_owned(),
            Self::Preparation(_) => "change preparation of coefficients".to_owned(),
            Self::BySurface(_) => "change assignment of coefficients to manoeuvres".to_owned(),
            Self::Constants(_) => "change constants of the pooled estimate".to_owned(),
            Self::PredictWith(_) => "change constants of predictions".to_owned(),
            Self::Weights(_) => "change weights of the residuals".to_owned(),
            Self::ControlLag(surface, _) => format!("change lag of the {}", surface.name()),
            Self::Constrain(constraint) => match constraint.known {
                Constraint::Free => format!("free {}", constraint.derivative()),
                _ => format!("constrain {}", constraint.derivative()),
            },
        }
    }

    fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        let estimation = &mut session.estimation;
        match self {
            Self::Path(path) => session.preparation.path = *path,
            Self::Preparation(preparation) => session.preparation = preparation.clone(),
            Self::BySurface(value) => estimation.by_surface = *value,
            Self::Constants(value) => estimation.constants = *value,
            Self::PredictWith(value) => estimation.predict_with = *value,
            Self::Weights(value) => estimation.weights = *value,
            Self::ControlLag(surface, lag) => {
                not_negative("lag of the", surface.name(), lag.time_constant_s)?;
                if !lag.delay_s.is_finite() {
                    let field = format!("delay of the {}", surface.name());
                    return Err(EditError::Value {
                        field,
                        value: lag.delay_s,
                        allowed: "it must be a number of seconds",
                    });
                }
                let lags = &mut session.preparation.control_lags;
                *lags = lags.with(*surface, *lag);
            }
            Self::Constrain(constraint) => estimation.constrain(constraint.clone())?,
        }
        Ok(())
    }
}

impl ModelEdit {
    fn label(&self) -> String {
        match self {
            Self::SetTerm { coefficient, term, on } => {
                let verb = if *on { "add" } else { "remove" };
                format!("{verb} {}", term.derivative_name(*coefficient))
            }
            Self::Structure(_) => "change model structure".to_owned(),
        }
    }

    fn apply(&self, session: &mut Session) {
        match self {
            Self::SetTerm { coefficient, term, on } => set_term(&mut session.structure, *coefficient, term, *on),
            Self::Structure(structure) => session.structure = structure.clone(),
        }
        session.forget_lost_terms();
    }
}

/// Adds or removes a term; a coefficient appears with its first term and leaves with its last.
pub(super) fn set_term(structure: &mut Structure, coefficient: Coefficient, term: &Term, on: bool) {
    let models = &mut structure.models;
    if on {
        if !models.iter().any(|(modelled, _)| *modelled == coefficient) {
            let place = models.partition_point(|(modelled, _)| *modelled < coefficient);
            models.insert(place, (coefficient, Vec::new()));
        }
        for (_, terms) in models.iter_mut().filter(|(modelled, _)| *modelled == coefficient) {
            if !terms.contains(term) {
                terms.push(term.clone());
            }
        }
    } else {
        models.iter_mut().filter(|(c, _)| *c == coefficient).for_each(|(_, terms)| terms.retain(|other| other != term));
        models.retain(|(_, terms)| !terms.is_empty());
    }
}
