//! From one changed noise entry to new derivatives of every window of the shipped flight: the time a drag of a slider takes.
//!
//! Prints the median of several changes, nothing read or aligned again, and where the time of one core goes.

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
const CHANGES: usize = 41;
/// Times each stage is done by itself.
const ROUNDS: usize = 15;

fn main() {
    let Some(mut session) = builtin::session("demo").and_then(|text| parse(text).ok()) else { return };
    let cache = Cache::new(CACHE_BYTES);
    let latest = Mutex::new(Snapshot::default());
    let (mut derivatives, mut times) = (Vec::new(), Vec::new());
    for change in 0..=CHANGES {
        let noise = 4e-4 * (1.0 + 0.01 * change as f64);
        let Ok(edited) = Edit::noise(NoiseChannel::Input(Input::RollRate), noise).apply(&session) else { return };
        session = edited;
        let scope = Scope {
            session: &session,
            folder: Path::new("."),
            first: None,
            studies: &[],
            cause: "bench",
            generation: change as u64,
        };
        let previous = latest.lock().map(|snapshot| snapshot.clone()).unwrap_or_default();
        let start = Instant::now();
        let elapsed_ms = || start.elapsed().as_secs_f64() * 1e3;
        let shown = Mutex::new(None);
        let publish = |snapshot: Snapshot| {
            if let (Ok(mut shown), Some(_)) = (shown.lock(), snapshot.pooled.ready()) {
                shown.get_or_insert(elapsed_ms());
            }
        };
        let snapshot = run(&scope, &previous, &cache, &Control::default(), &publish);
        times.push(elapsed_ms());
        derivatives.extend(shown.into_inner().ok().flatten());
        if let Some((place, error)) = snapshot.failures().first() {
            report(&format!("{place}: {error}"));
            return;
        }
        if let Ok(mut latest) = latest.lock() {
            *latest = snapshot;
        }
    }
    let (first, whole) = (derivatives.remove(0), times.remove(0));
    report(&format!("shipped flight from files to derivatives   {first:16.1} ms, everything {whole:.1} ms"));
    for (name, mut times) in
        [("derivatives, corrected errors, predictions", derivatives), ("the same with proof and verdict", times)]
    {
        times.sort_by(f64::total_cmp);
        let (least, median, most) = (times[0], times[times.len() / 2], times[times.len() - 1]);
        report(&format!("noise entry to {name:43}{median:8.1} ms median, {least:.1} to {most:.1} ms"));
    }
    let snapshot = latest.into_inner().unwrap_or_default();
    let Ok(one_thread) = ThreadPoolBuilder::new().num_threads(1).build() else { return };
    if let Err(error) = one_thread.install(|| stages(&session, &snapshot, &cache)) {
        report(&error.to_string());
    }
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
