//! A closer look at results there already are, computed after them and for what is on screen alone.

use std::sync::Arc;

use doublet_core::model::Term;
use doublet_core::reconstruct::Method;
use doublet_core::series::Series;

use super::control::{Cancelled, Control};
use super::snapshot::Snapshot;
use crate::session::{PathSource, Preparation, Session};
use crate::stage::{self, BiasTable, CoefficientStudy, Contributions, KindSummary, ResidualStudy, WindowPath};

/// Iterations and tolerance of the iterated filter where the session does not use it.
const ITERATED: Method = Method::Iekf { max_iterations: 10, tolerance: 1e-3 };

/// What a front end looks at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wanted {
    /// Window looked at.
    pub window: Option<String>,
    /// Flight whose track over ground is drawn from its velocity.
    pub track: Option<String>,
    /// Its path by every filter is compared.
    pub filters: bool,
    /// The model is looked at, with these terms beside its own.
    pub terms: Option<Vec<Term>>,
}

/// What was found.
#[derive(Clone, Debug, Default)]
pub struct Details {
    /// The window looked at.
    pub window: Option<WindowDetails>,
    /// Terms of the model and candidates, where they were looked at.
    pub model: Vec<CoefficientStudy>,
    /// North and east positions of the flight whose track was wanted.
    pub track: Option<[Series; 2]>,
    /// Biases and wind of all windows.
    pub biases: BiasTable,
    /// Derivatives over all identification windows, then over those of each kind of input.
    pub kinds: Vec<KindSummary>,
}

/// A closer look at one window.
#[derive(Clone, Debug)]
pub struct WindowDetails {
    /// Its name.
    pub name: String,
    /// Residuals of its own fits.
    pub residuals: Vec<ResidualStudy>,
    /// Parts of its fitted coefficients.
    pub contributions: Vec<Contributions>,
    /// Its path by the plain and by the iterated filter, both smoothed, or why it has none; `None` where it was not wanted.
    pub filters: Option<Result<[Arc<WindowPath>; 2], String>>,
}

/// Looks closer at the results of `snapshot`.
///
/// # Errors
/// [`Cancelled`] once `control` says so: between its parts, and inside the filter.
pub fn details(
    session: &Session,
    snapshot: &Snapshot,
    wanted: &Wanted,
    control: &Control,
) -> Result<Details, Cancelled> {
    let results = |name: &str| snapshot.windows.get(name);
    let aero =
        session.windows.iter().filter_map(|window| Some((window, Arc::clone(results(&window.name)?.aero.latest()?))));
    let aero: Vec<_> = aero.collect();
    let paths = session.windows.iter().filter_map(|window| Some((window, results(&window.name)?.path.latest()?)));
    let fits = session.windows.iter().filter_map(|window| Some((window, results(&window.name)?.fits.latest()?)));
    let window = wanted.window.as_deref().and_then(|name| window(session, snapshot, (name, wanted.filters), control));
    control.checkpoint()?;
    let model =
        wanted.terms.as_ref().map(|terms| stage::model_study(&aero, &session.structure, terms, &session.estimation));
    control.checkpoint()?;
    let track = wanted
        .track
        .as_ref()
        .and_then(|name| stage::track_from_velocity(&snapshot.flights.get(name)?.latest()?.recording));
    control.checkpoint()?;
    Ok(Details {
        window,
        model: model.unwrap_or_default(),
        track,
        biases: stage::bias_table(paths.map(|(window, path)| (window.name.as_str(), path.as_ref()))),
        kinds: stage::kind_summaries(fits.map(|(window, fits)| (window, fits.as_ref()))),
    })
}

fn window(
    session: &Session,
    snapshot: &Snapshot,
    (name, filters): (&str, bool),
    control: &Control,
) -> Option<WindowDetails> {
    let (manoeuvre, results) = (session.window(name)?, snapshot.windows.get(name)?);
    let fits = results.fits.latest();
    let parts = results
        .aero
        .latest()
        .zip(fits)
        .map(|(aero, fits)| stage::contributions(manoeuvre, aero, fits, &session.structure, &session.estimation));
    Some(WindowDetails {
        name: name.to_owned(),
        residuals: fits.map(|fits| stage::residual_studies(fits)).unwrap_or_default(),
        contributions: parts.unwrap_or_default(),
        filters: filters.then(|| by_every_filter(session, snapshot, name, control)),
    })
}

/// The path of one window by the plain and by the iterated filter, from the samples the session's own filter gets.
fn by_every_filter(
    session: &Session,
    snapshot: &Snapshot,
    name: &str,
    control: &Control,
) -> Result<[Arc<WindowPath>; 2], String> {
    let manoeuvre = session.window(name).ok_or("the window is gone")?;
    let flight =
        snapshot.flights.get(&manoeuvre.flight).and_then(|slot| slot.latest()).ok_or("its flight is not read")?;
    let aircraft = snapshot.aircraft.latest();
    let aircraft = aircraft.map(|aircraft| stage::aircraft_data(Arc::clone(aircraft), session.loading.as_ref()));
    let aircraft = aircraft.transpose()?;
    let samples = stage::samples(&flight.recording, manoeuvre.window, aircraft.as_ref(), &session.preparation)?;
    let samples = Arc::new(samples);
    let iterated = if matches!(session.filter.method, Method::Iekf { .. }) { session.filter.method } else { ITERATED };
    let by = |method: Method| {
        let mut other =
            snapshot.gravity.as_ref().map_or_else(|| session.clone(), |used| stage::with_gravity(session, used));
        other.filter.method = method;
        other.preparation = Preparation { path: PathSource::Smoothed, ..session.preparation.clone() };
        let path = stage::paths(std::slice::from_ref(&samples), &other, control).into_iter().next();
        path.unwrap_or_else(|| Err("the filter gave nothing".to_owned())).map(Arc::new)
    };
    Ok([by(Method::Ekf)?, by(iterated)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{builtin, session};

    #[test]
    fn a_look_that_nobody_wants_any_more_ends() {
        let session = session::parse(builtin::session("demo").unwrap()).unwrap();
        let (snapshot, wanted) = (Snapshot::default(), Wanted::default());
        let control = Control::default();
        assert!(details(&session, &snapshot, &wanted, &control).is_ok());
        control.cancel();
        assert_eq!(details(&session, &snapshot, &wanted, &control).err(), Some(Cancelled));
    }
}
