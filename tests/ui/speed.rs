//! What the workbench costs: first frame, frames while panning, from a slider to new derivatives. Measured without drawing
//! pixels; run alone: `cargo test --release --test ui speed -- --ignored --nocapture --test-threads 1`.

use std::time::{Duration, Instant};

use doublet::app::{Document, Workbench};
use doublet_core::reconstruct::Input;
use doublet_engine::session::{Edit, FilterEdit};

use crate::builder;

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

#[test]
#[ignore = "measures time: run alone"]
fn speed_of_the_workbench_on_the_shipped_flight() {
    let started = Instant::now();
    let mut harness = builder(1600.0, 1000.0).with_accessibility_check(false).build_eframe(|cc| {
        Workbench::new(cc, Document::shipped().expect("a session is shipped")).expect("a thread starts")
    });
    harness.step();
    println!("first frame after {:.0} ms", 1e3 * started.elapsed().as_secs_f64());
    let settle = |harness: &mut egui_kittest::Harness<'_, Workbench>| {
        let waiting = Instant::now();
        while harness.state().is_busy() {
            assert!(waiting.elapsed() < PATIENCE, "results come");
            std::thread::sleep(Duration::from_millis(1));
            harness.step();
        }
    };
    settle(&mut harness);
    println!("everything computed after {:.0} ms", 1e3 * started.elapsed().as_secs_f64());
    let full = harness.state().state.time.full();
    let mut frames: Vec<Duration> = (0..FRAMES)
        .map(|k| {
            let time = &mut harness.state_mut().state.time;
            time.zoom_to(full);
            time.zoom(1.3, full.start_s, k as f64);
            time.pan(full.length_s() * 0.2 * (k as f64 / FRAMES as f64), k as f64);
            let at = Instant::now();
            harness.step();
            at.elapsed()
        })
        .collect();
    let (median, slow) = (quantile_ms(&mut frames, 0.5), quantile_ms(&mut frames, 0.99));
    println!("frame while panning the flight: median {median:.1} ms, 99 % below {slow:.1} ms");
    let mut moves: Vec<Duration> = (0..MOVES)
        .map(|k| {
            let noise = 1e-4 * (1.0 + 0.1 * k as f64);
            let at = Instant::now();
            harness.state_mut().apply(&Edit::Filter(FilterEdit::ProcessNoise(Input::PitchRate, noise)));
            harness.step();
            settle(&mut harness);
            at.elapsed()
        })
        .collect();
    let windows = harness.state().snapshot().windows.len();
    println!(
        "from a Q entry to derivatives of {windows} windows on screen: median {:.0} ms",
        quantile_ms(&mut moves, 0.5)
    );
    assert!(harness.state().snapshot().pooled.ready().is_some());
}
