//! A closer look at results there already are, computed after them and for what is on screen alone.

use std::hash::{Hash, Hasher};
use std::sync::Arc;

use doublet_core::airframe::Loading;
use doublet_core::model::Term;
use doublet_core::reconstruct::{FilterSettings, Measurement, Method};

use super::inquiries::InquiryRequest;
use crate::graph::{Context, Keyed, Stage, StageError, StageResult};
use crate::session::{Manoeuvre, PathSource, Session, Settings, WindowRole};
use crate::snapshot::{Details, Snapshot, WindowDetails, WindowResults};
use crate::stage::{
    self, AircraftData, FlightNoise, LoadedAircraft, LoadedFlight, MisfitPlace, Samples, WindowAero, WindowFits,
    WindowPath,
};

/// Iterations and tolerance of the iterated filter where the session does not use it.
const ITERATED: Method = Method::Iekf { max_iterations: 10, tolerance: 1e-3 };

/// What a front end looks at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DetailRequest {
    /// Window looked at.
    pub window: Option<String>,
    /// Flight whose track over ground is drawn from its velocity.
    pub track: Option<String>,
    /// Its path by every filter is compared.
    pub filters: bool,
    /// The model is looked at, with these terms beside its own.
    pub terms: Option<Vec<Term>>,
    /// The regressors are looked at: of the window where the first is set, over all identification windows else.
    pub regressors: Option<bool>,
    /// Where the residual of the window is looked at.
    pub misfit: Option<MisfitPlace>,
    /// What is asked of the identified model; answered behind the rest, each by itself.
    pub inquiry: InquiryRequest,
}

impl Hash for DetailRequest {
    /// Without what is asked of the model, on which the closer look does not depend.
    fn hash<H: Hasher>(&self, state: &mut H) {
        let Self { window, track, filters, terms, regressors, misfit, inquiry: _ } = self;
        (window, track, filters, terms, regressors, misfit).hash(state);
    }
}

/// What a closer look depends on: what is asked, settings and loading of the session.
type DetailParams<'a> = (&'a DetailRequest, Settings<'a>, Option<&'a Loading>);

/// A window with the newest results there are of it.
#[derive(Hash)]
struct KnownWindow<'a> {
    manoeuvre: &'a Manoeuvre,
    path: Option<&'a Keyed<WindowPath>>,
    aero: Option<&'a Keyed<WindowAero>>,
    fits: Option<&'a Keyed<WindowFits>>,
}

/// The results that are looked at.
#[derive(Hash)]
pub struct DetailInputs<'a> {
    windows: Vec<KnownWindow<'a>>,
    /// Flight of the window looked at.
    flight: Option<&'a Keyed<LoadedFlight>>,
    /// Flight whose track is drawn.
    track: Option<&'a Keyed<LoadedFlight>>,
    aircraft: Option<&'a Keyed<LoadedAircraft>>,
    /// Noise of the flight of the window looked at.
    noise: Option<&'a Keyed<FlightNoise>>,
}

/// Looks closer at the results of `snapshot`.
pub(super) fn details(
    session: &Session,
    snapshot: &Snapshot,
    request: &DetailRequest,
    context: &Context<'_>,
) -> StageResult<Keyed<Details>> {
    let used = snapshot.gravity.as_ref().map_or_else(|| session.clone(), |used| stage::with_gravity(session, used));
    let windows = session.windows.iter().filter_map(|manoeuvre| {
        let WindowResults { path, aero, fits } = snapshot.windows.get(&manoeuvre.name)?;
        Some(KnownWindow { manoeuvre, path: path.keyed(), aero: aero.keyed(), fits: fits.keyed() })
    });
    let flight = |name: &String| snapshot.flights.get(name)?.keyed();
    let window = request.window.as_deref().and_then(|name| session.window(name));
    let inputs = DetailInputs {
        windows: windows.collect(),
        flight: window.and_then(|window| flight(&window.flight)),
        track: request.track.as_ref().and_then(flight),
        aircraft: snapshot.aircraft.keyed(),
        noise: window.and_then(|window| snapshot.noise.get(&window.flight)?.keyed()),
    };
    let loading = window.map_or(session.loading.as_ref(), |window| session.loading_in(&window.flight));
    context.get::<Details>((request, used.settings(), loading), &inputs)
}

impl Stage for Details {
    type Params<'a> = DetailParams<'a>;
    type Inputs<'a> = &'a DetailInputs<'a>;
    type Output = Self;
    const NAME: &'static str = "closer look";

    fn run(params: DetailParams<'_>, inputs: &DetailInputs<'_>, context: &Context<'_>) -> StageResult<Self> {
        let (request, settings, _) = params;
        context.checkpoint()?;
        let known = || inputs.windows.iter();
        let looked_at = known().find(|window| Some(&window.manoeuvre.name) == request.window.as_ref());
        let window = looked_at.map(|window| window_details(window, params, inputs, context)).transpose()?;
        context.checkpoint()?;
        let aero: Vec<_> = known().filter_map(|w| Some((w.manoeuvre, Arc::clone(w.aero?.shared())))).collect();
        let model = request.terms.as_ref();
        let model = model.map(|terms| stage::model_study(&aero, settings.structure, terms, settings.estimation));
        context.checkpoint()?;
        let of_window = |alone: bool| request.window.as_deref().filter(|_| alone);
        let regressors = request.regressors.map(|alone| {
            stage::regressor_correlations(&aero, of_window(alone), settings.structure, settings.estimation)
        });
        let paths = known().filter_map(|w| Some((w.manoeuvre.name.as_str(), &**w.path?)));
        Ok(Self {
            window,
            model: model.unwrap_or_default(),
            regressors: regressors.unwrap_or_default(),
            track: inputs.track.and_then(|flight| stage::track_from_velocity(&flight.recording)),
            biases: stage::bias_table(paths),
            kinds: stage::kind_summaries(known().filter_map(|w| Some((w.manoeuvre, &**w.fits?)))),
        })
    }
}

fn window_details(
    KnownWindow { manoeuvre, path, aero, fits }: &KnownWindow<'_>,
    params: DetailParams<'_>,
    inputs: &DetailInputs<'_>,
    context: &Context<'_>,
) -> StageResult<WindowDetails> {
    let (request, Settings { structure, estimation, filter, .. }, _) = params;
    let parts = aero.zip(*fits).map(|(aero, fits)| stage::contributions(aero, fits, structure, estimation));
    let information = aero.zip(*fits).map(|(aero, fits)| stage::information(aero, fits, structure, estimation));
    let bands = aero.zip(*fits).map(|(aero, fits)| stage::observation_bands(aero, fits, structure, estimation));
    let noise =
        path.map(|path| stage::noise_advice(path, &filter.measurement_noise, inputs.noise.map(|noise| &**noise)));
    let active = inputs.windows.iter().filter(|window| window.manoeuvre.role != WindowRole::Ignored);
    let paths: Vec<&WindowPath> = active.filter_map(|window| Some(&**window.path?)).collect();
    let of_all = |measurement: Measurement| {
        let used = filter.measurement_noise[measurement as usize];
        Some((measurement, stage::noise_of_all(paths.iter().copied(), measurement, used)?))
    };
    let misfit = request.misfit.zip(inputs.flight).zip(*fits);
    let misfit = misfit.map(|((place, flight), fits)| stage::misfit(&flight.recording, fits, place));
    let filters = request.filters.then(|| by_every_filter(manoeuvre, params, inputs, context));
    Ok(WindowDetails {
        name: manoeuvre.name.clone(),
        residuals: fits.map(|fits| stage::residual_studies(fits)).unwrap_or_default(),
        noise: noise.unwrap_or_default(),
        noise_of_all: Measurement::ALL.into_iter().filter_map(of_all).collect(),
        bands: bands.unwrap_or_default(),
        misfit,
        contributions: parts.unwrap_or_default(),
        information: information.unwrap_or_default(),
        filters: match filters {
            Some(Err(StageError::Cancelled)) => return Err(StageError::Cancelled),
            found => found,
        },
    })
}

/// The path of one window by the plain and by the iterated filter, from the samples the session's own filter gets.
fn by_every_filter(
    manoeuvre: &Manoeuvre,
    (_, Settings { filter, preparation, .. }, loading): DetailParams<'_>,
    inputs: &DetailInputs<'_>,
    context: &Context<'_>,
) -> Result<[Arc<WindowPath>; 2], StageError> {
    let flight = inputs.flight.ok_or("its flight is not read")?;
    let aircraft = inputs.aircraft.map(|aircraft| context.get::<AircraftData>(loading, aircraft)).transpose()?;
    let samples = context.get::<Samples>((manoeuvre.samples(), preparation), (flight, aircraft.as_ref()))?;
    let iterated = if matches!(filter.method, Method::Iekf { .. }) { filter.method } else { ITERATED };
    let by = |method: Method| {
        let filter = FilterSettings { method, ..filter.clone() };
        let path = context.get::<WindowPath>((&filter, PathSource::Smoothed), &samples)?;
        Ok::<_, StageError>(Arc::clone(path.shared()))
    };
    Ok([by(Method::Ekf)?, by(iterated)?])
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::graph::Control;
    use crate::{builtin, session};

    #[test]
    fn a_look_that_nobody_wants_any_more_ends() {
        let session = session::parse(builtin::session("demo").unwrap()).unwrap();
        let (snapshot, request) = (Snapshot::default(), DetailRequest::default());
        let control = Control::default();
        let context = Context::new(Path::new("")).with_control(&control, &|_| ());
        assert!(details(&session, &snapshot, &request, &context).is_ok());
        control.cancel();
        assert_eq!(details(&session, &snapshot, &request, &context).err(), Some(StageError::Cancelled));
    }
}
