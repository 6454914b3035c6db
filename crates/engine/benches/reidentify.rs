//! From one changed noise entry to new derivatives of every window of the shipped flight: the time a drag of a slider takes.
//!
//! Prints the median of several changes, nothing read or aligned again, and where the time of one core goes. Changes with a manoeuvre looked
//! at, which is computed and published first, and changes without one take turns.

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use doublet_core::reconstruct::Input;
use doublet_engine::builtin;
use doublet_engine::graph::{Cache, Context, Keyed, Stage, StageResult};
use doublet_engine::run::{CACHE_BYTES, Control, Scope, Snapshot, run};
use doublet_engine::session::{Edit, NoiseChannel, PathSource, Session, parse};
use doublet_engine::stage::{
    self, AeroWindow, AircraftData, ProofOfMatch, Samples, StudyWindow, WindowAero, load_aircraft, paths, pooled_fits,
    reconstructions, window_fits,
};
use doublet_engine::verdict::judge;
use rayon::ThreadPoolBuilder;

/// Changes timed; so many that the results of the first leave the cache, and memory is used again as after minutes of work.
const CHANGES: usize = 82;
/// Times each stage is done by itself.
const ROUNDS: usize = 15;
/// Place of the manoeuvre looked at among those of the session.
const LOOKED_AT: usize = 12;

/// What a change is timed to.
const STOPS: [&str; 3] =
    ["manoeuvre looked at", "derivatives, corrected errors, predictions", "the same with proof and verdict"];

fn main() {
    let Some(mut session) = builtin::session("demo").and_then(|text| parse(text).ok()) else { return };
    let Some(name) = session.active_windows().nth(LOOKED_AT).map(|window| window.name.clone()) else { return };
    let cache = Cache::new(CACHE_BYTES);
    let mut latest = Snapshot::default();
    // By whether a manoeuvre was looked at, then by what was timed.
    let mut times: [[Vec<f64>; 3]; 2] = Default::default();
    for change in 0..=CHANGES {
        let noise = 4e-4 * (1.0 + 0.01 * change as f64);
        let Ok(edited) = Edit::noise(NoiseChannel::Input(Input::RollRate), noise).apply(&session) else { return };
        session = edited;
        let looks = change % 2;
        let first = Some(name.as_str()).filter(|_| looks == 1);
        let (snapshot, stops) = time_change(&session, (&name, first), change, &latest, &cache);
        if let Some((place, error)) = snapshot.failures().first() {
            return report(&format!("{place}: {error}"));
        }
        latest = snapshot;
        if change == 0 {
            let [_, derivatives, everything] = stops;
            report(&format!(
                "shipped flight from files to derivatives   {derivatives:16.1} ms, everything {everything:.1} ms"
            ));
        } else {
            times[looks].iter_mut().zip(stops).for_each(|(times, stop)| times.push(stop));
        }
    }
    for (order, times) in ["in the order of the session", "with the manoeuvre looked at first"].iter().zip(&mut times) {
        report(&format!("noise entry, {order}, to"));
        for (name, times) in STOPS.iter().zip(times) {
            times.sort_by(f64::total_cmp);
            let (least, median, most) = (times[0], times[times.len() / 2], times[times.len() - 1]);
            report(&format!("  {name:43}{median:8.1} ms median, {least:.1} to {most:.1} ms"));
        }
    }
    let Ok(one_thread) = ThreadPoolBuilder::new().num_threads(1).build() else { return };
    if let Err(error) = one_thread.install(|| stages(&session, &latest, &cache)) {
        report(&error.to_string());
    }
}

/// Runs a changed session; ms until the manoeuvre `name`, all derivatives, and everything were published.
fn time_change(
    session: &Session,
    (name, first): (&str, Option<&str>),
    change: usize,
    previous: &Snapshot,
    cache: &Cache,
) -> (Snapshot, [f64; 3]) {
    let generation = change as u64;
    let scope = Scope { session, folder: Path::new("."), first, studies: &[], cause: "bench", generation };
    let key = |snapshot: &Snapshot| snapshot.windows.get(name).and_then(|window| window.fits.keyed().map(Keyed::key));
    let old = key(previous);
    let start = Instant::now();
    let elapsed_ms = || start.elapsed().as_secs_f64() * 1e3;
    let shown = Mutex::new([None; 2]);
    let publish = |snapshot: Snapshot| {
        let Ok(mut shown) = shown.lock() else { return };
        if snapshot.windows.get(name).is_some_and(|window| window.fits.ready().is_some()) && key(&snapshot) != old {
            shown[0].get_or_insert(elapsed_ms());
        }
        if snapshot.generation == generation && snapshot.pooled.ready().is_some() {
            shown[1].get_or_insert(elapsed_ms());
        }
    };
    let snapshot = run(&scope, previous, cache, &Control::default(), &publish);
    let everything = elapsed_ms();
    let [looked_at, derivatives] = shown.into_inner().unwrap_or_default();
    (snapshot, [looked_at.unwrap_or(f64::NAN), derivatives.unwrap_or(f64::NAN), everything])
}

/// Each stage of a changed noise entry by itself over all windows, on one thread.
fn stages(session: &Session, snapshot: &Snapshot, cache: &Cache) -> StageResult<()> {
    let control = Control::default();
    let gravity = snapshot.gravity.as_ref().ok_or("no gravity")?;
    let session = &stage::with_gravity(session, gravity);
    let context = Context::new(Path::new(".")).with_cache(cache);
    let loaded = load_aircraft(&context, session.aircraft.as_deref().unwrap_or_default())?;
    let aircraft = context.get::<AircraftData>(session.loading.as_ref(), &loaded)?;
    let mut windows = Vec::new();
    for manoeuvre in session.active_windows() {
        let results = snapshot.windows.get(&manoeuvre.name).ok_or("a window was not computed")?;
        let flight = snapshot.flights.get(&manoeuvre.flight).and_then(|slot| slot.keyed()).ok_or("no flight")?.clone();
        let samples =
            context.get::<Samples>((manoeuvre.samples(), &session.preparation), (&flight, Some(&aircraft)))?;
        let path = results.path.keyed().ok_or("a window has no path")?.clone();
        let aero = results.aero.keyed().ok_or("a window has no coefficients")?.clone();
        let fits = results.fits.keyed().ok_or("a window has no fits")?.clone();
        windows.push((samples, StudyWindow { manoeuvre, flight, aircraft: aircraft.clone(), path, aero, fits }));
    }
    let samples: Vec<&Samples> = windows.iter().map(|(samples, _)| &**samples).collect();
    let data: Vec<_> = samples.iter().map(|samples| &*samples.data).collect();
    let found: Vec<AeroWindow<'_>> =
        windows.iter().map(|(_, window)| (window.manoeuvre, Arc::clone(window.aero.shared()))).collect();
    let (_, study): (Vec<_>, Vec<StudyWindow<'_>>) = windows.iter().cloned().unzip();
    let by = |source| (&session.filter, source);
    let pooled: Keyed<_> = pooled_fits(&found, &session.structure, &session.estimation).into();
    let reconstruct = |source| {
        timed(|| reconstructions(&data, by(source), &control).into_iter().try_for_each(|path| path.map(|_| ())))
    };
    let (filter, smoothed) = (reconstruct(PathSource::Filtered)?, reconstruct(PathSource::Smoothed)?);
    let path = timed(|| {
        let found = paths(&samples, by(PathSource::Smoothed), &control);
        found.into_iter().try_for_each(|path| path.map(|path| _ = path.assessment()))
    })?;
    let aero = timed(|| {
        let one = |(samples, window): &(Keyed<Samples>, StudyWindow<'_>)| {
            let inputs = (&window.flight, samples, &window.path, &aircraft);
            WindowAero::run(&session.preparation, inputs, &context).map(|_| ())
        };
        windows.iter().try_for_each(one)
    })?;
    let single = timed(|| {
        let one = |(window, aero): &AeroWindow<'_>| window_fits(window, aero, &session.structure, &session.estimation);
        found.iter().map(one).for_each(drop);
        Ok(())
    })?;
    let together = timed(|| {
        drop(pooled_fits(&found, &session.structure, &session.estimation));
        Ok(())
    })?;
    let proof = timed(|| ProofOfMatch::run(session.settings(), (&study, &pooled), &context).map(|_| ()))?;
    let verdict = timed(|| {
        drop(judge(session, snapshot));
        Ok(())
    })?;
    let rows = [
        ("filter", filter),
        ("smoother", smoothed - filter),
        ("consistency, observability, truth", path - smoothed),
        ("coefficients", aero),
        ("single fits", single),
        ("pooled fits, predictions", together),
        ("proof of match", proof),
        ("verdict", verdict),
    ];
    rows.iter().for_each(|(name, time)| report(&format!("  {name:34}{time:6.2} ms")));
    report(&format!("  {:34}{:6.2} ms", "together", rows.iter().map(|(_, time)| time).sum::<f64>()));
    Ok(())
}

/// The shortest of several times, ms.
fn timed(work: impl Fn() -> StageResult<()>) -> StageResult<f64> {
    let mut least = f64::INFINITY;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        work()?;
        least = least.min(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(least)
}

#[expect(clippy::print_stdout, reason = "a bench prints its result")]
fn report(line: &str) {
    println!("{line}");
}
