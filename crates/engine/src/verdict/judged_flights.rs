//! Whether the verdict can be believed: simulated flights through both steps, judged as a session is.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use doublet_core::series::Recording;
use doublet_core::simulate::{self, Scenario};
use rayon::prelude::*;

use super::{Finding, Level, Verdict, Verdicts, judge};
use crate::graph::{Context, Keyed, StageError, StageResult};
use crate::session::{Manoeuvre, Session, WindowRole};
use crate::snapshot::{Slot, Snapshot};
use crate::stage::{self, AeroWindow, AircraftData, LoadedFlight, Samples};
use crate::study::{flown_loading, record_flight, windows};

/// Verdicts on flights whose every sensor is as stated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JudgedFlights {
    /// Flights flown and judged.
    pub flights: usize,
    pub manoeuvres: usize,
    /// Flights by the level of the session: good, caution, bad.
    pub sessions: [usize; 3],
    /// Flights with a bad anywhere: the session, a window, a fit or a derivative, of single windows too.
    pub bad_anywhere: usize,
    /// Flights in which a kind of finding fired, by level and code.
    pub codes: BTreeMap<(Level, &'static str), usize>,
    /// Of each kind the first finding there was, with the seed of its flight.
    pub examples: BTreeMap<(Level, &'static str), (u64, Finding)>,
}

/// Flies `scenario` once for each seed from `first_seed` on, records it by instruments that are as the filter of `session` describes them
/// ([`simulate::Flight::measured`]) and judges what both steps make of it. Of a manoeuvre flown more than once the last repetitions
/// are validation windows.
pub fn judged_flights(
    session: &Session,
    scenario: &Scenario,
    (flights, first_seed): (usize, u64),
    context: &Context<'_>,
) -> StageResult<JudgedFlights> {
    let context = context.parts(flights);
    let one = |index: usize| -> StageResult<(u64, Vec<Finding>, Level)> {
        context.checkpoint()?;
        let seed = first_seed + index as u64;
        let (_, snapshot) = fly_and_judge(session, scenario, seed, &|_| (), &context)?;
        context.step();
        let Some(verdicts) = snapshot.verdicts.ready() else { return Ok((seed, Vec::new(), Level::Good)) };
        Ok((seed, everywhere(verdicts), verdicts.session.level))
    };
    let found = (0..flights).into_par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
    let mut judged = JudgedFlights { flights, manoeuvres: windows(scenario).len(), ..JudgedFlights::default() };
    for (seed, findings, level) in found {
        judged.sessions[level as usize] += 1;
        judged.bad_anywhere += usize::from(findings.iter().any(|finding| finding.level == Level::Bad));
        let kinds: BTreeSet<_> = findings.iter().map(|finding| (finding.level, finding.code)).collect();
        kinds.into_iter().for_each(|kind| *judged.codes.entry(kind).or_default() += 1);
        for finding in findings {
            judged.examples.entry((finding.level, finding.code)).or_insert((seed, finding));
        }
    }
    Ok(judged)
}

/// Reasons of the session, of every window, fit and derivative.
fn everywhere(verdicts: &Verdicts) -> Vec<Finding> {
    let fits = || verdicts.windows.values().flat_map(|window| &window.fits).chain(&verdicts.pooled);
    let derivatives = fits().flat_map(|fit| fit.derivatives.iter().map(|derivative| &derivative.verdict));
    let all = std::iter::once(&verdicts.session)
        .chain(verdicts.windows.values().map(|window| &window.verdict))
        .chain(fits().map(|fit| &fit.verdict))
        .chain(derivatives);
    all.flat_map(|verdict: &Verdict| verdict.reasons.iter().cloned()).collect()
}

/// One flight of `scenario` through both steps, with the session that was identified and the snapshot of its results. `spoil` changes the
/// recording first: the flight of a faulty instrument.
pub fn fly_and_judge(
    session: &Session,
    scenario: &Scenario,
    seed: u64,
    spoil: &(dyn Fn(&mut Recording) + Sync),
    context: &Context<'_>,
) -> StageResult<(Session, Snapshot)> {
    let named = |error: StageError| error.at(format!("seed {seed}"));
    let loading = flown_loading(scenario);
    session.aircraft.as_ref().ok_or("the session has no aircraft: choose one")?;
    let loaded = stage::aircraft_of(context, session)?;
    let aircraft = context.get::<AircraftData>(Some(&loading), &loaded)?;
    let fly = simulate::run(scenario, seed, &mut |_| !context.control().is_cancelled());
    context.checkpoint()?;
    let mut recording = record_flight(&fly.map_err(|error| named(error.into()))?, session, &aircraft, seed);
    spoil(&mut recording);

    let mut session = Session { loading: Some(loading), windows: windows(scenario), ..session.clone() };
    let (surfaces, kinds): (Vec<_>, Vec<_>) =
        session.windows.iter().map(|window| (window.surface, window.kind.clone())).unzip();
    for (index, window) in session.windows.iter_mut().enumerate() {
        let same = |other: &usize| surfaces[*other] == window.surface && kinds[*other] == window.kind;
        if (0..index).any(|other| same(&other)) {
            window.role = WindowRole::Validation;
        }
    }
    let mut snapshot = Snapshot { aircraft: Slot::Ready(loaded), ..Snapshot::default() };
    let samples = |window: &Manoeuvre| {
        stage::samples(&recording, window.samples(), Some(&aircraft), &session.preparation).map_err(named)
    };
    let samples: Vec<Samples> = session.windows.iter().map(samples).collect::<Result<_, _>>()?;
    let data: Vec<_> = samples.iter().map(|samples| &*samples.data).collect();
    snapshot.delays_and_gusts = stage::estimate_delays_and_gusts(&session, &data, context.control())?;
    let filter = snapshot.delays_and_gusts.added_to(&session.filter);
    let by = (&filter, session.preparation.path);
    let paths = stage::paths(&samples.iter().collect::<Vec<_>>(), by, context.control());
    let mut formed: Vec<AeroWindow<'_>> = Vec::with_capacity(samples.len());
    for ((window, samples), path) in session.windows.iter().zip(&samples).zip(paths) {
        context.checkpoint()?;
        let results = snapshot.windows.entry(window.name.clone()).or_default();
        let aero = path.and_then(|path| {
            let found = (&*samples.data, &path.reconstruction);
            let aero = stage::aero(&recording, found, (&aircraft, &window.excluded), &session.preparation);
            results.path = path.into();
            Ok(Keyed::from(aero?))
        });
        match aero {
            Err(error) => results.path.finish(Err(error)),
            Ok(aero) => {
                formed.push((window, Arc::clone(aero.shared())));
                results.fits =
                    stage::window_fits(window, aero.shared(), &session.structure, &session.estimation).into();
                results.aero = Slot::Ready(aero);
            }
        }
    }
    let pooled = stage::pooled_fits(&formed, &session.structure, &session.estimation);
    snapshot.pooled = pooled.into();
    let physics = stage::physics_of(&recording, "as flown");
    snapshot.physics.insert(scenario.name.to_owned(), physics.into());
    let flight = LoadedFlight { recording, ..LoadedFlight::default() }.with_stalls();
    snapshot.flights.insert(scenario.name.to_owned(), flight.into());
    drop(formed);
    snapshot.verdicts = judge(&session, &snapshot).into();
    Ok((session, snapshot))
}
