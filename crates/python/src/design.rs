//! Inputs of the next flight, designed from a fit.

use std::sync::Arc;

use doublet_dynamics::design::{Criterion, DesignKind, Quantity, Request, SURFACE_NAMES, design};
use doublet_engine::graph::{Control, Stage, StageResult};
use doublet_engine::planning::{
    DesignOptions, DesignRow, FlownWindow, PathShare, SEARCH_SAMPLES, basis, design_basis, design_csv, design_row,
};
use doublet_engine::run::Snapshot;
use doublet_engine::session::Session;
use doublet_engine::study::{DynamicsRequest, DynamicsStudy};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::attend::{Show, attend, refuse};
use crate::fits::{Fit, Fitted, context, request as trim_request};
use crate::session::Results;

/// What an input is designed from.
#[derive(FromPyObject)]
pub enum Identified<'py> {
    Fit(PyRef<'py, Fit>),
    /// Results of a session that was run with the study of its dynamics.
    Results(PyRef<'py, Results>),
}

/// The same, to be taken to another thread.
enum Source {
    Fit(Arc<Fitted>, Box<DynamicsRequest>),
    Results(Arc<Session>, Box<Snapshot>),
}

/// Designs inputs for an identified model about a trim: the row that `doublet design --json` prints, as JSON, and its nodes as CSV.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "what the Python function has by name")]
pub fn design_input(
    py: Python<'_>,
    identified: Identified<'_>,
    trim: &Bound<'_, PyDict>,
    surfaces: Vec<String>,
    kind: &str,
    criterion: &str,
    time_s: f64,
    usage: f64,
    peak_rad: Option<f64>,
    rate_rad_s: f64,
    peak_thrust_n: Option<f64>,
    gust_m_s: Option<f64>,
    limits: Vec<(String, f64, f64)>,
    rounds: usize,
    samples: usize,
    seed: u64,
    with_flown: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(String, String)> {
    let kinds = || DesignKind::ALL.map(|kind| kind.name().replace(' ', "-")).join(", ");
    let criteria = || Criterion::ALL.map(Criterion::name).join(", ");
    let request = Request {
        surfaces: places(&surfaces)?,
        time_s: positive("duration", time_s)?,
        kind: DesignKind::from_name(kind)
            .ok_or_else(|| refuse(format!("'{kind}' is not a kind of input: use one of {}", kinds())))?,
        criterion: Criterion::ALL
            .into_iter()
            .find(|known| known.name() == criterion)
            .ok_or_else(|| refuse(format!("'{criterion}' is not a criterion: use one of {}", criteria())))?,
        rounds,
        search_samples: SEARCH_SAMPLES,
        samples,
        usage: if (0.05..=1.0).contains(&usage) {
            usage
        } else {
            return Err(refuse(format!("usage {usage} must lie between 0.05 and 1")));
        },
        seed,
        with_flown,
    };
    let options = DesignOptions {
        peak_rad: peak_rad.map(|peak| positive("peak", peak)).transpose()?,
        rate_rad_s: positive("rate", rate_rad_s)?,
        peak_thrust_n: peak_thrust_n.map(|peak| positive("peak_thrust", peak)).transpose()?,
        limits: limits.into_iter().map(limit).collect::<PyResult<_>>()?,
        gust_m_s,
    };
    if gust_m_s.is_some_and(|gust| !gust.is_finite() || gust < 0.0) {
        return Err(refuse("gusts must be zero or more"));
    }
    let source = match identified {
        // Modes are not asked for here: the fewest draws.
        Identified::Fit(fit) => {
            Source::Fit(Arc::clone(&fit.inner), Box::new(trim_request(trim, 2, DynamicsRequest::default().seed)?))
        }
        Identified::Results(results) if results.snapshot.studies.dynamics.ready().is_none() => {
            let failed = results.snapshot.studies.dynamics.error();
            return Err(refuse(
                failed.unwrap_or("no model to design with: run the session with studies=[\"dynamics\"]"),
            ));
        }
        Identified::Results(_) if !trim.is_empty() => {
            return Err(refuse("results have the trim they were run with: give a fit to choose another"));
        }
        Identified::Results(results) => {
            Source::Results(Arc::clone(&results.settings), Box::new(results.snapshot.clone()))
        }
    };
    let work = move |control: &Control, _: Show<'_>| row(&source, &request, &options, control);
    let row = attend(py, "design", progress, work)?;
    Ok((serde_json::to_string(&row).map_err(refuse)?, design_csv(&row)))
}

fn row(source: &Source, request: &Request, options: &DesignOptions, control: &Control) -> StageResult<DesignRow> {
    let basis = match source {
        Source::Results(session, snapshot) => design_basis(session, snapshot, options)?,
        Source::Fit(fitted, trim) => fitted.study(|input| {
            let study = DynamicsStudy::run(**trim, input, &context(control))?;
            let windows = input.windows.iter();
            let windows: Vec<FlownWindow<'_>> =
                windows.map(|one| ((one.manoeuvre, Arc::clone(one.aero.shared())), &one.path.reconstruction)).collect();
            basis(input.settings, &windows, (&study.model, &study.condition), options)
        })?,
    };
    let designed = design(&basis, request).map_err(|error| error.to_string())?;
    let mut row = design_row(&basis, request, &designed);
    if let Source::Results(session, snapshot) = source {
        let share = PathShare::measure((session, snapshot), &designed, request.with_flown, control);
        share.iter().for_each(|share| row.add_path(share));
    }
    Ok(row)
}

/// Places of surfaces in their order, each once.
fn places(names: &[String]) -> PyResult<Vec<usize>> {
    let place = |name: &String| {
        let found = SURFACE_NAMES.iter().position(|known| known == name);
        found.ok_or_else(|| refuse(format!("'{name}' is not a surface: use one of {}", SURFACE_NAMES.join(", "))))
    };
    let mut places = names.iter().map(place).collect::<PyResult<Vec<_>>>()?;
    places.sort_unstable();
    places.dedup();
    Ok(places)
}

fn limit((name, low, high): (String, f64, f64)) -> PyResult<(Quantity, f64, f64)> {
    let known = || Quantity::ALL.map(Quantity::name).join(", ");
    let quantity = Quantity::from_name(&name)
        .ok_or_else(|| refuse(format!("'{name}' is nothing an envelope limits: use one of {}", known())))?;
    if !(low.is_finite() && high.is_finite() && low < high) {
        return Err(refuse(format!("the limits of {name} are {low} and {high}: give a lower and a higher one")));
    }
    Ok((quantity, low, high))
}

fn positive(name: &str, value: f64) -> PyResult<f64> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(refuse(format!("{name} {value} must be above zero"))) }
}
