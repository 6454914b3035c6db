//! What the workbench costs: first frame, frames while panning, from a slider to new derivatives. Measured without drawing
//! pixels; run alone: `cargo test --release --test ui speed -- --ignored --nocapture --test-threads 1`.

use std::time::{Duration, Instant};

use doublet::app::{Document, Workbench};
use doublet::layouts::LayoutKey;
use doublet::step::Step;
use doublet_core::reconstruct::Input;
use doublet_engine::graph::{Key, Keyed};
use doublet_engine::session::{Edit, NoiseChannel};
use egui_kittest::Harness;

use crate::builder;
use crate::workbench::Bench;

/// Frames of each measurement.
const FRAMES: usize = 200;
/// Moves of the slider.
const MOVES: usize = 15;
/// Longest wait for results.
const PATIENCE: Duration = Duration::from_secs(120);

/// The value below which `part` of `times` lie, ms.
fn quantile_ms(times: &mut [Duration], part: f64) -> f64 {
    times.sort();
    1e3 * times[((times.len() - 1) as f64 * part).round() as usize].as_secs_f64()
}

/// Plots on screen while the flight is panned.
const PLOTS: usize = 12;
/// Session measured in place of the shipped one, for example of a longer flight.
const SESSION: &str = "DOUBLET_SPEED_SESSION";

/// Time this thread has spent on a processor: what others do on the machine does not count. `None` where the system does not say.
fn cpu_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse().ok().map(Duration::from_nanos)
}

/// Memory in use, MB.
fn memory_mb() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.split_whitespace().next()?.parse::<f64>().ok().map(|kb| kb / 1024.0)
}

/// Draws frames, as fast as they come, until one shows derivatives of every window and of all together that are newer than
/// generation `old`.
fn settle_derivatives(harness: &mut Harness<'_, Workbench>, old: u64) {
    let waiting = Instant::now();
    let shows = |harness: &Harness<'_, Workbench>| {
        let snapshot = harness.state().snapshot();
        snapshot.generation > old
            && snapshot.pooled.ready().is_some()
            && snapshot.windows.values().all(|window| window.fits.ready().is_some())
    };
    while !shows(harness) {
        assert!(waiting.elapsed() < PATIENCE, "results come");
        std::thread::sleep(Duration::from_millis(1));
        harness.step();
    }
}

/// Draws frames, as fast as they come, until one shows a fit of the window `name` other than `old`.
fn settle_window(harness: &mut Harness<'_, Workbench>, name: &str, old: Option<Key>) {
    let waiting = Instant::now();
    while fit_of(harness, name) == old {
        assert!(waiting.elapsed() < PATIENCE, "results come");
        std::thread::sleep(Duration::from_micros(200));
        harness.step();
    }
}

/// Which fit of a window is on screen.
fn fit_of(harness: &Harness<'_, Workbench>, name: &str) -> Option<Key> {
    harness.state().snapshot().windows.get(name)?.fits.keyed().map(Keyed::key)
}

/// Draws frames until everything is computed.
fn settle(harness: &mut Harness<'_, Workbench>) {
    let waiting = Instant::now();
    while harness.state().is_busy() {
        assert!(waiting.elapsed() < PATIENCE, "results come");
        std::thread::sleep(Duration::from_millis(1));
        harness.step();
    }
}

#[test]
#[ignore = "measures time: run alone"]
fn speed_of_the_workbench() {
    let started = Instant::now();
    let session = std::env::var_os(SESSION);
    let mut harness = builder(1600.0, 1000.0).with_accessibility_check(false).build_eframe(|cc| {
        let document = match &session {
            Some(path) => Document::open(path.as_ref()).expect("the session opens"),
            None => Document::open_demo().expect("a session is shipped"),
        };
        let mut app = Workbench::new(cc, document).expect("a thread starts");
        app.state.show_layout(LayoutKey::Step(Step::Recording));
        app
    });
    harness.step();
    println!("first frame after {:.0} ms", 1e3 * started.elapsed().as_secs_f64());
    settle_derivatives(&mut harness, 0);
    println!("derivatives on screen after {:.0} ms", 1e3 * started.elapsed().as_secs_f64());
    settle(&mut harness);
    println!("everything computed after {:.0} ms", 1e3 * started.elapsed().as_secs_f64());
    let flight =
        harness.state().snapshot().flights.values().next().and_then(|slot| slot.ready()).expect("read").clone();
    let roles = flight.recording.roles.keys().take(PLOTS).map(|role| vec![role.name().to_owned()]);
    harness.state_mut().state.flight_plots = Some(roles.collect());
    harness.run_steps(3);
    let full = harness.state().state.time.full();
    let mut frames: Vec<Duration> = (0..FRAMES)
        .map(|k| {
            let time = &mut harness.state_mut().state.time;
            time.zoom_to(full);
            time.zoom(1.3, full.start_s, k as f64);
            time.pan(full.length_s() * 0.2 * (k as f64 / FRAMES as f64), k as f64);
            let (at, before) = (Instant::now(), cpu_time());
            harness.step();
            cpu_time().zip(before).map_or_else(|| at.elapsed(), |(after, before)| after - before)
        })
        .collect();
    let (median, slow) = (quantile_ms(&mut frames, 0.5), quantile_ms(&mut frames, 0.99));
    let minutes = full.length_s() / 60.0;
    println!(
        "processor time of a frame while panning {PLOTS} plots of {minutes:.0} minutes: median {median:.1} ms, 99 % below {slow:.1} ms"
    );
    harness.state_mut().state.show_layout(LayoutKey::Step(Step::Model));
    harness.run_steps(3);
    let chosen = harness.state().state.selection.window.clone().expect("one is chosen");
    let mut first: Vec<Duration> = Vec::with_capacity(MOVES);
    let mut moves: Vec<Duration> = (0..MOVES)
        .map(|k| {
            let noise = 1e-4 * (1.0 + 0.1 * k as f64);
            let (at, old) = (Instant::now(), harness.state().snapshot().generation);
            let fit = fit_of(&harness, &chosen);
            harness.state_mut().apply(&Edit::noise(NoiseChannel::Input(Input::PitchRate), noise));
            harness.step();
            settle_window(&mut harness, &chosen, fit);
            first.push(at.elapsed());
            settle_derivatives(&mut harness, old);
            let shown = at.elapsed();
            settle(&mut harness);
            shown
        })
        .collect();
    let windows = harness.state().snapshot().windows.len();
    println!(
        "from a Q entry to path and fits of the chosen manoeuvre on screen: median {:.0} ms, quickest {:.0} ms",
        quantile_ms(&mut first, 0.5),
        quantile_ms(&mut first, 0.0)
    );
    println!(
        "from a Q entry to derivatives of {windows} manoeuvres on screen: median {:.0} ms, quickest {:.0} ms",
        quantile_ms(&mut moves, 0.5),
        quantile_ms(&mut moves, 0.0)
    );
    if let Some(memory) = memory_mb() {
        println!("memory in use: {memory:.0} MB");
    }
    assert!(harness.state().snapshot().pooled.ready().is_some());
}

#[test]
fn in_a_drag_a_newer_edit_starts_its_run_once_the_derivatives_of_the_former_are_shown() {
    let mut bench = Bench::shipped();
    let noise = |deviation: f64| Edit::noise(NoiseChannel::Input(Input::PitchRate), deviation);
    let former = bench.snapshot().generation;
    bench.harness.state_mut().document.history.begin("drag the noise of q");
    bench.harness.state_mut().apply(&noise(0.011));
    let is_pooled = |bench: &Bench<'_>| {
        let snapshot = bench.snapshot();
        snapshot.generation > former && snapshot.pooled.ready().is_some()
    };
    while !is_pooled(&bench) {
        bench.harness.step();
    }
    assert!(bench.snapshot().busy, "errors of the path, proof of match and verdict are still to come");
    bench.harness.state_mut().apply(&noise(0.012));
    bench.harness.run_steps(2);
    bench.harness.state_mut().document.history.commit();
    bench.settle();
    let ended: Vec<&str> = bench.snapshot().log.iter().map(|line| line.text.as_str()).collect();
    assert!(ended.contains(&"cancelled"), "{ended:?}");
    assert_eq!(bench.session().filter.process_noise[Input::PitchRate as usize], 0.012);
    assert!(bench.snapshot().verdicts.ready().is_some(), "the last run goes to its verdict");
}
