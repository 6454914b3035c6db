//! Step 2: coefficients of windows, derivatives fitted to them, and what follows from these.

use std::sync::Arc;

use doublet_core::estimate::Constraint;
use doublet_core::model::{Coefficient, Structure, Term, Variable, regressors};
use doublet_core::prep::did_you_mean;
use doublet_engine::graph::{Context, Control, Key, Keyed, Stage, StageError, StageResult};
use doublet_engine::report::dynamics_row;
use doublet_engine::session::{
    Estimation, Manoeuvre, PooledConstants, PredictionParameters, Preparation, ResidualWeights, Settings,
    TermConstraint, WindowRole,
};
use doublet_engine::stage::{
    AeroWindow, ErrorWindow, PooledFits, ReplayWindow, StudyWindow, WindowAero, WindowFits, WindowPath, aero,
    describe_origin, path_errors, pooled_fits, window_fits,
};
use doublet_engine::study::dynamics::{pooled_model, propagate_expression, window_key};
use doublet_engine::study::{DynamicsRequest, DynamicsStudy, StudyInput};
use doublet_engine::verdict::Verdicts;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::attend::{Show, attend, detached, refuse};
use crate::columns::{matrix, owned, shared};
use crate::judged::{self, JudgedWindow, session_json, session_of_arrays};
use crate::path::{FLIGHT, Path, Reconstructed};
use crate::settings::preparation_with;
use crate::{output_error, predicted};

/// What is known of a derivative beforehand, as Python gives it: coefficient, term, kind, two numbers.
type ConstraintGiven = (String, String, String, f64, f64);

/// Coefficients of the windows of a path, and the variables they depend on.
#[pyclass(frozen, module = "doublet")]
pub struct Coefficients {
    path: Arc<Reconstructed>,
    preparation: Arc<Preparation>,
    windows: Arc<Vec<(Manoeuvre, Keyed<WindowAero>)>>,
}

#[pymethods]
impl Coefficients {
    /// Forms the coefficients of every window of a path; `settings` are the table `preparation` of a session as JSON, with those of the path.
    /// Known errors of the sensors are those of the path.
    #[staticmethod]
    fn form(py: Python<'_>, path: &Path, settings: &str) -> PyResult<Self> {
        let path = Arc::clone(&path.inner);
        let known_errors = path.preparation.known_errors.clone();
        let preparation = Arc::new(Preparation { known_errors, ..preparation_with(settings)? });
        let aircraft = path.aircraft.clone().ok_or_else(|| {
            refuse("coefficients need an aircraft: give reconstruct one, by doublet.aircraft(name) or doublet.Aircraft(...)")
        })?;
        let form_window = |window: &crate::path::PathWindow| -> StageResult<(Manoeuvre, Keyed<WindowAero>)> {
            let found = &window.path;
            let of_path = (&*found.data, &found.reconstruction);
            let aircraft = (&*aircraft, &*window.manoeuvre.excluded);
            let formed = aero(&path.flight.loaded.recording, of_path, aircraft, &preparation);
            let formed = formed.map_err(|error| error.at(format!("manoeuvre '{}'", window.manoeuvre.name)))?;
            Ok((window.manoeuvre.clone(), Keyed::new(Arc::new(formed), Key::unique())))
        };
        let windows =
            detached(py, "coefficients", || path.windows.iter().map(form_window).collect::<StageResult<Vec<_>>>())?;
        Ok(Self { path, preparation, windows: Arc::new(windows) })
    }

    /// Names of the windows.
    fn windows(&self) -> Vec<&str> {
        self.windows.iter().map(|(window, _)| &*window.name).collect()
    }

    /// The session of the same manoeuvres and settings, without its recordings: JSON.
    fn session(&self) -> PyResult<String> {
        let windows = self.windows.iter().map(|(manoeuvre, _)| (manoeuvre, &*self.path));
        session_json(&session_of_arrays(&windows.collect::<Vec<_>>(), &self.preparation, None))
    }

    /// Verdict of the windows as JSON: that of a session of the same windows.
    fn verdict(&self, py: Python<'_>) -> PyResult<String> {
        let found = detached(py, "verdict", || {
            let windows = self.windows.iter().zip(&self.path.windows);
            let judged = windows.map(|((manoeuvre, aero), window)| JudgedWindow {
                manoeuvre,
                source: &self.path,
                path: &window.path,
                aero: Some(aero),
                fits: None,
            });
            Ok::<_, StageError>(judged::verdicts(judged.collect(), &self.preparation, None))
        })?;
        judged::json(&found)
    }

    /// Time, s, of a window, its coefficients and its variables by name.
    #[expect(clippy::type_complexity, reason = "a tuple of Python")]
    fn columns<'py>(
        &self,
        py: Python<'py>,
        index: usize,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyDict>, Bound<'py, PyDict>)> {
        let (_, aero) = self.windows.get(index).ok_or_else(|| refuse("manoeuvre not found"))?;
        let coefficients = PyDict::new(py);
        for coefficient in Coefficient::ALL {
            coefficients.set_item(coefficient.name(), shared(py, &aero.series[coefficient as usize].values)?)?;
        }
        let variables = PyDict::new(py);
        for &variable in Variable::ALL {
            // As the fit has them: smoothed as the angular acceleration is.
            if let Ok(column) = regressors(&[Term::from(variable)], &aero.variables) {
                variables.set_item(variable.name(), owned(py, column.iter().copied().collect()))?;
            }
        }
        Ok((shared(py, &aero.series[0].time_s)?, coefficients, variables))
    }

    /// Columns of terms of a window, samples by terms.
    fn regressors<'py>(
        &self,
        py: Python<'py>,
        index: usize,
        terms: Vec<String>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (_, aero) = self.windows.get(index).ok_or_else(|| refuse("manoeuvre not found"))?;
        let terms = terms.iter().map(|term| Term::parse(term).map_err(refuse)).collect::<PyResult<Vec<_>>>()?;
        Ok(matrix(py, &regressors(&terms, &aero.variables).map_err(refuse)?))
    }

    /// Findings of a window.
    fn warnings(&self, index: usize) -> PyResult<Vec<String>> {
        let (_, aero) = self.windows.get(index).ok_or_else(|| refuse("manoeuvre not found"))?;
        Ok(aero.warnings.iter().map(ToString::to_string).collect())
    }
}

/// A structure as Python gives it: each coefficient with its terms.
fn structure(models: Vec<(String, Vec<String>)>) -> PyResult<Structure> {
    let structure = Structure { models: models.into_iter().map(parse_model).collect::<PyResult<_>>()? };
    structure.check().map_err(refuse)?;
    Ok(structure)
}

fn parse_model((name, terms): (String, Vec<String>)) -> PyResult<(Coefficient, Vec<Term>)> {
    let known = || Coefficient::ALL.map(Coefficient::name).join(", ");
    let coefficient = Coefficient::from_name(&name)
        .ok_or_else(|| refuse(format!("'{name}' is not a coefficient: use one of {}", known())))?;
    let terms = terms.iter().map(|term| Term::parse(term).map_err(|error| refuse(format!("{name}: {error}"))));
    Ok((coefficient, terms.collect::<PyResult<Vec<_>>>()?))
}

/// Each term as it is written in full, with the name of the derivative of a coefficient by it.
#[pyfunction]
pub fn derivative_names(coefficient: String, terms: Vec<String>) -> PyResult<Vec<(String, String)>> {
    let structure = structure(vec![(coefficient, terms)])?;
    let rows = structure.models.iter().flat_map(|(coefficient, terms)| {
        terms.iter().map(|term| (term.to_string(), term.derivative_name(*coefficient)))
    });
    Ok(rows.collect())
}

/// A constraint as Python gives it.
pub fn constraint(kind: &str, first: f64, second: f64) -> PyResult<Constraint> {
    match kind {
        "fixed" => Ok(Constraint::Fixed(first)),
        "bounds" => Ok(Constraint::Bounds { lower: first, upper: second }),
        "prior" => Ok(Constraint::Prior { mean: first, deviation: second }),
        other => Err(refuse(format!("'{other}' is not a constraint: use fixed, bounds or prior"))),
    }
}

fn constraints(given: Vec<ConstraintGiven>) -> PyResult<Vec<TermConstraint>> {
    let one = |(name, term, kind, first, second): ConstraintGiven| {
        let coefficient =
            Coefficient::from_name(&name).ok_or_else(|| refuse(format!("'{name}' is not a coefficient")))?;
        let term = Term::parse(&term).map_err(|error| refuse(format!("{name}: {error}")))?;
        Ok(TermConstraint { coefficient, term, known: constraint(&kind, first, second)? })
    };
    given.into_iter().map(one).collect()
}

/// A window of a fit, with everything its coefficients were made from.
struct FitWindow {
    manoeuvre: Manoeuvre,
    source: Arc<Reconstructed>,
    path: Keyed<WindowPath>,
    aero: Keyed<WindowAero>,
}

impl FitWindow {
    /// What the errors of the path need of it.
    fn error_window(&self) -> ErrorWindow<'_> {
        (&self.manoeuvre, (&*self.path.data, &self.path.reconstruction), self.aero.shared())
    }
}

/// Everything a fit was made from, and the fit.
pub struct Fitted {
    preparation: Arc<Preparation>,
    structure: Structure,
    estimation: Estimation,
    windows: Vec<FitWindow>,
    pooled: Keyed<PooledFits>,
}

impl Fitted {
    fn aero(&self) -> Vec<AeroWindow<'_>> {
        aero_windows(&self.windows)
    }

    /// The fit with the errors of the flight path in its corrected standard errors, as in a session; as it is where they cannot be formed,
    /// and where flights have different filters: the errors are found by the filter that all paths have.
    fn with_path_errors(mut self, control: &Control) -> StageResult<Self> {
        let Some(first) = self.windows.first().map(|window| Arc::clone(&window.source)) else { return Ok(self) };
        if self.windows.iter().any(|window| window.source.filter != first.filter) {
            return Ok(self);
        }
        let windows: Vec<ErrorWindow<'_>> = self.windows.iter().map(FitWindow::error_window).collect();
        match path_errors(&windows, self.settings(&first), control) {
            Err(StageError::Cancelled) => Err(StageError::Cancelled),
            Err(_) => Ok(self),
            Ok(errors) => {
                self.pooled = Keyed::new(Arc::new(Arc::new(errors).widen(&self.pooled)), Key::unique());
                Ok(self)
            }
        }
    }

    /// Settings of the fit, the filter being that of the path of `source`.
    fn settings<'a>(&'a self, source: &'a Reconstructed) -> Settings<'a> {
        let Self { preparation, structure, estimation, .. } = self;
        Settings { filter: &source.filter, preparation, structure, estimation }
    }

    fn own_fits(&self, window: &FitWindow) -> WindowFits {
        window_fits(&window.manoeuvre, window.aero.shared(), &self.structure, &self.estimation)
    }

    /// Does `work` with what a study looks at.
    pub fn study<R>(&self, work: impl FnOnce(&StudyInput<'_>) -> StageResult<R>) -> StageResult<R> {
        let no_aircraft = || StageError::from("no aircraft");
        let first = self.windows.first().map(|window| &window.source).ok_or("the fit has no manoeuvre")?;
        let aircraft = first.aircraft.as_ref().ok_or_else(no_aircraft)?;
        let windows = self.windows.iter().map(|window| StudyWindow {
            manoeuvre: &window.manoeuvre,
            flight: window.source.flight.loaded.clone(),
            aircraft: window.source.aircraft.as_ref().unwrap_or(aircraft).clone(),
            path: window.path.clone(),
            aero: window.aero.clone(),
            fits: Keyed::new(Arc::new(self.own_fits(window)), Key::unique()),
        });
        let windows: Vec<_> = windows.collect();
        work(&StudyInput { settings: self.settings(first), aircraft, windows: &windows, pooled: &self.pooled })
    }

    fn verdicts(&self) -> Verdicts {
        let windows = self.windows.iter().map(|window| JudgedWindow {
            manoeuvre: &window.manoeuvre,
            source: &window.source,
            path: &window.path,
            aero: Some(&window.aero),
            fits: Some(self.own_fits(window)),
        });
        let fit = (&self.structure, &self.estimation, &self.pooled);
        judged::verdicts(windows.collect(), &self.preparation, Some(fit))
    }
}

fn aero_windows(windows: &[FitWindow]) -> Vec<AeroWindow<'_>> {
    windows.iter().map(|window| (&window.manoeuvre, Arc::clone(window.aero.shared()))).collect()
}

/// Windows of coefficients of one flight or several; of several each flight has its number, as a name has that is there already.
fn pooled_windows(several: &[PyRef<'_, Coefficients>]) -> PyResult<Vec<FitWindow>> {
    let mut windows: Vec<FitWindow> = Vec::new();
    for (index, coefficients) in several.iter().enumerate() {
        if coefficients.preparation != several[0].preparation {
            return Err(refuse("the coefficients differ in axes, thrust or other settings: form all of them alike"));
        }
        if coefficients.path.stated.aircraft_changes != several[0].path.stated.aircraft_changes {
            return Err(refuse("the flights differ in aircraft_changes: reconstruct all flights with the same"));
        }
        for ((manoeuvre, aero), window) in coefficients.windows.iter().zip(&coefficients.path.windows) {
            let mut manoeuvre = manoeuvre.clone();
            if index > 0 {
                manoeuvre.flight = format!("{FLIGHT} {}", index + 1);
            }
            if windows.iter().any(|known| known.manoeuvre.name == manoeuvre.name) {
                manoeuvre.name = format!("{} (flight {})", manoeuvre.name, index + 1);
            }
            let (source, path) = (Arc::clone(&coefficients.path), window.path.clone());
            windows.push(FitWindow { manoeuvre, source, path, aero: aero.clone() });
        }
    }
    Ok(windows)
}

/// Derivatives fitted over windows.
#[pyclass(frozen, module = "doublet")]
pub struct Fit {
    pub(crate) inner: Arc<Fitted>,
}

/// Quantities of a trim.
const TRIM: [&str; 10] =
    ["airspeed", "altitude", "gamma", "load_factor", "pull_up", "mass", "fuel", "stick_delay", "aileron", "window"];

/// A trim as Python gives it, by names of [`DynamicsRequest`].
pub fn request(trim: &Bound<'_, PyDict>, samples: usize, seed: u64) -> PyResult<DynamicsRequest> {
    let mut request = DynamicsRequest { samples, seed, ..DynamicsRequest::default() };
    for (key, value) in trim {
        let key: String = key.extract()?;
        let number = || value.extract::<f64>();
        match key.as_str() {
            "airspeed" => request.airspeed_m_s = Some(number()?),
            "altitude" => request.altitude_m = Some(number()?),
            "gamma" => request.gamma_rad = Some(number()?),
            "load_factor" => request.load_factor = Some(number()?),
            "pull_up" => request.pull_up = value.extract()?,
            "mass" => request.mass_kg = Some(number()?),
            "fuel" => request.fuel_kg = Some(number()?),
            "stick_delay" => request.stick_delay_s = Some(number()?),
            "aileron" => request.aileron_rad = Some(number()?),
            "window" => request.window = Some(window_key(&value.extract::<String>()?)),
            other => {
                let hint = did_you_mean(other, TRIM.into_iter(), &format!("use {}", TRIM.join(", ")));
                return Err(refuse(format!("'{other}' is not a quantity of a trim: {hint}")));
            }
        }
    }
    Ok(request)
}

impl Fit {
    fn window(&self, name: &str) -> Option<&FitWindow> {
        self.inner.windows.iter().find(|window| window.manoeuvre.name == name)
    }

    /// Observed coefficient over the windows it was fitted in.
    fn observed(&self, fit: &doublet_engine::stage::CoefficientFit) -> Vec<f64> {
        let used = fit.windows.iter().filter_map(|(name, _)| self.window(name));
        used.flat_map(|window| window.aero.coefficients.get(fit.coefficient)).copied().collect()
    }

    /// Estimates of a coefficient and what is said about them, or why there are none.
    fn row<'py>(&self, py: Python<'py>, fit: &doublet_engine::stage::CoefficientFit) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        all.set_item("coefficient", fit.coefficient.name())?;
        all.set_item("windows", fit.windows.iter().map(|(name, _)| name).collect::<Vec<_>>())?;
        let dropped = fit.dropped.iter().map(|term| (&*term.derivative, &*term.reason)).collect::<Vec<_>>();
        all.set_item("dropped", dropped)?;
        match &fit.fit {
            Err(error) => all.set_item("error", error.to_string())?,
            Ok(found) => {
                all.set_item("names", &found.names)?;
                all.set_item("estimates", owned(py, found.estimates.clone()))?;
                all.set_item("white", owned(py, found.standard_errors.clone()))?;
                all.set_item("coloured", owned(py, fit.corrected_errors.clone()))?;
                all.set_item("held", found.origins.iter().map(|&origin| describe_origin(origin)).collect::<Vec<_>>())?;
                all.set_item("covariance", matrix(py, &found.covariance))?;
                all.set_item("correlation", matrix(py, &found.correlation))?;
                all.set_item("residuals", shared(py, &found.residuals)?)?;
                all.set_item("fitted", owned(py, found.fitted(&self.observed(fit))))?;
                all.set_item("r2", found.quality.r_squared)?;
                all.set_item("rms_relative_percent", found.quality.rms_relative_percent)?;
                all.set_item("residual_std", found.residual_std)?;
                all.set_item("condition", found.condition_number)?;
            }
        }
        Ok(all)
    }
}

#[pymethods]
impl Fit {
    /// Fits the derivatives of a structure over the windows of coefficients of one flight or several.
    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "what the Python function has by name")]
    #[expect(clippy::self_named_constructors, reason = "the name of the Python function")]
    fn fit(
        py: Python<'_>,
        coefficients: Vec<PyRef<'_, Coefficients>>,
        models: Vec<(String, Vec<String>)>,
        windows: Option<Vec<String>>,
        given: Vec<ConstraintGiven>,
        by_surface: bool,
        common_constant: bool,
        is_huber: bool,
        order: Option<usize>,
        by_means: bool,
    ) -> PyResult<Self> {
        let structure = structure(models)?;
        let constants = if common_constant { PooledConstants::Common } else { PooledConstants::PerManoeuvre };
        let weights = match (is_huber, order) {
            (false, None) => ResidualWeights::Equal,
            (true, None) => ResidualWeights::Huber,
            (false, Some(order)) => ResidualWeights::Autoregression(order),
            (true, Some(_)) => {
                return Err(refuse("method gls and Huber's weights exclude each other: give one of them"));
            }
        };
        let constraints = constraints(given)?;
        let predict_with = if by_means { PredictionParameters::ManoeuvreMeans } else { PredictionParameters::Pooled };
        let estimation = Estimation { by_surface, constants, predict_with, weights, constraints };
        let preparation = coefficients.first().map(|first| Arc::clone(&first.preparation));
        let preparation = preparation.ok_or_else(|| refuse("no coefficients were given: give those of one flight"))?;
        let mut used = pooled_windows(&coefficients)?;
        if let Some(names) = &windows {
            if let Some(unknown) = names.iter().find(|name| !used.iter().any(|one| one.manoeuvre.name == **name)) {
                let known: Vec<_> = used.iter().map(|one| &*one.manoeuvre.name).collect();
                return Err(refuse(format!("no manoeuvre is called '{unknown}': there are {}", known.join(", "))));
            }
            for FitWindow { manoeuvre, .. } in &mut used {
                let is_named = names.contains(&manoeuvre.name);
                manoeuvre.role = if is_named { WindowRole::Identification } else { WindowRole::Validation };
            }
        }
        let work = move |control: &Control, _: Show<'_>| -> StageResult<Fitted> {
            let pooled = pooled_fits(&aero_windows(&used), &structure, &estimation);
            let pooled = Keyed::new(Arc::new(pooled), Key::unique());
            Fitted { preparation, structure, estimation, windows: used, pooled }.with_path_errors(control)
        };
        Ok(Self { inner: Arc::new(attend(py, "fit", None, work)?) })
    }

    /// Names of the windows, in order.
    fn windows(&self) -> Vec<&str> {
        self.inner.windows.iter().map(|window| &*window.manoeuvre.name).collect()
    }

    /// Time of the samples of a window, s, as its coefficients have it.
    fn time<'py>(&self, py: Python<'py>, window: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = self.window(window).ok_or_else(|| refuse("manoeuvre not found"))?;
        shared(py, &found.aero.series[0].time_s)
    }

    /// The session of the same manoeuvres and settings, without its recordings: JSON.
    fn session(&self) -> PyResult<String> {
        let Fitted { windows, preparation, structure, estimation, .. } = &*self.inner;
        let windows: Vec<_> = windows.iter().map(|window| (&window.manoeuvre, &*window.source)).collect();
        session_json(&session_of_arrays(&windows, preparation, Some((structure, estimation))))
    }

    /// Verdict of the fit as JSON: that of a session of the same windows and structure.
    fn verdict(&self, py: Python<'_>) -> PyResult<String> {
        let found = detached(py, "verdict", || Ok::<_, StageError>(self.inner.verdicts()))?;
        judged::json(&found)
    }

    /// Each coefficient: its estimates and what is said about them, or why there are none.
    fn rows<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.inner.pooled.fits.iter().map(|fit| self.row(py, fit)).collect()
    }

    /// How well the estimate predicts each window: window, role, coefficient, R2 with the constants of the identification and with its own.
    fn predictions(&self) -> Vec<(&str, &'static str, &'static str, f64, f64)> {
        let rows = self.inner.pooled.predictions.iter();
        rows.map(|row| {
            let quality = (row.quality_identified.r_squared, row.quality_own_constant.r_squared);
            (&*row.window, row.role.name(), row.coefficient.name(), quality.0, quality.1)
        })
        .collect()
    }

    /// Predictions of a coefficient by window: time (s), observation, prediction with the constants of the identification and with its own.
    #[expect(clippy::type_complexity, reason = "a tuple of Python")]
    fn predicted<'py>(
        &self,
        py: Python<'py>,
        coefficient: &str,
    ) -> PyResult<Vec<(&str, [Bound<'py, PyArray1<f64>>; 4])>> {
        let rows = self.inner.pooled.predictions.iter().filter(|row| row.coefficient.name() == coefficient);
        rows.map(|row| {
            let values = [&row.observed.time_s, &row.observed.values, &row.identified.values, &row.own_constant.values];
            let [time, observed, identified, own] = values.map(|column| shared(py, column));
            Ok((&*row.window, [time?, observed?, identified?, own?]))
        })
        .collect()
    }

    /// Trim, linear models, modes and levels, as `dynamics` of results.json: JSON.
    fn dynamics(
        &self,
        py: Python<'_>,
        trim: &Bound<'_, PyDict>,
        samples: usize,
        seed: u64,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        let (request, inner) = (request(trim, samples, seed)?, Arc::clone(&self.inner));
        let work = move |control: &Control, _: Show<'_>| {
            inner.study(|input| DynamicsStudy::run(request, input, &context(control)))
        };
        let study = attend(py, "linear model", progress, work)?;
        serde_json::to_string(&dynamics_row(&study)).map_err(refuse)
    }

    /// Names, estimates, covariance and draws (rows) of the derivatives.
    #[allow(clippy::type_complexity, reason = "what a distribution is made from")]
    fn draws<'py>(
        &self,
        py: Python<'py>,
        samples: usize,
        seed: u64,
    ) -> PyResult<(Vec<String>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
        let inner = &self.inner;
        let (model, draws) = detached(py, "draws", || {
            let model =
                pooled_model(&inner.pooled, (&inner.structure, &inner.estimation), &inner.aero(), &mut Vec::new())?;
            let draws = model.samples(samples, seed);
            Ok::<_, StageError>((model, draws))
        })?;
        let values = model.values();
        let drawn = nalgebra::DMatrix::from_fn(draws.len(), values.len(), |row, column| draws[row][column]);
        let estimates = owned(py, values.iter().copied().collect());
        Ok((model.names.clone(), estimates, matrix(py, &model.covariance), matrix(py, &drawn)))
    }

    /// Covariance of all estimates by corrected errors, in order.
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let Fitted { pooled, structure, estimation, .. } = &*self.inner;
        let found = detached(py, "covariance", || {
            Ok::<_, StageError>(predicted::covariance(pooled, &self.inner.aero(), (structure, estimation)))
        })?;
        Ok(matrix(py, &found))
    }

    /// A manoeuvre flown by the model: by signal time (s), reconstructed and simulated values.
    fn simulated<'py>(&self, py: Python<'py>, window: &str) -> PyResult<Bound<'py, PyDict>> {
        let FitWindow { manoeuvre, source, path, aero } =
            self.window(window).ok_or_else(|| refuse("manoeuvre not found"))?;
        let Fitted { pooled, structure, preparation, .. } = &*self.inner;
        let window = ReplayWindow { manoeuvre, path, aero };
        predicted::simulated(py, &window, (pooled, structure), (preparation, source.filter.gravity_m_s2))
    }

    /// Value of an expression of derivatives and of S, b, c, V, rho, qbar, mass, Ixx, Iyy, Izz, Ixz about a trim: value, and standard
    /// error, low and high end by slopes and by draws.
    #[allow(clippy::type_complexity, reason = "a value with two intervals")]
    fn propagate(
        &self,
        py: Python<'_>,
        expression: String,
        trim: &Bound<'_, PyDict>,
        samples: usize,
        seed: u64,
    ) -> PyResult<(f64, Option<[f64; 3]>, Option<[f64; 3]>)> {
        let (request, inner) = (request(trim, 2, seed)?, Arc::clone(&self.inner));
        let work = move |control: &Control, _: Show<'_>| {
            let study = inner.study(|input| DynamicsStudy::run(request, input, &context(control)))?;
            propagate_expression(&study, &expression, samples, seed)
        };
        let found = attend(py, "propagate", None, work)?.result;
        let ends =
            |interval: doublet_dynamics::propagate::Interval| [interval.standard_error, interval.low, interval.high];
        Ok((found.value, found.delta.map(ends), found.sampled.map(ends)))
    }

    /// Output error of every window, a row each.
    fn output_error<'py>(
        &self,
        py: Python<'py>,
        axis: Option<&str>,
        filter_error: bool,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<Bound<'py, PyDict>>> {
        output_error::rows(py, &self.inner, (axis, filter_error), progress)
    }
}

/// A context that reads no file.
pub fn context(control: &Control) -> Context<'static> {
    Context::new(std::path::Path::new("")).with_control(control, &|_| {})
}
