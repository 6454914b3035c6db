//! Many edits over one window: the memory that the program holds stays what it is once its cache is full.

use doublet::app::{Document, Workbench};
use doublet_core::series::TimeRange;
use doublet_engine::session::{Edit, WindowEdit};

use crate::builder;

/// Edits before the memory is looked at: what they leave fills the cache.
const FILLING: usize = 10_000;
/// Edits after these, unless `DOUBLET_SOAK_EDITS` says otherwise.
const EDITS: usize = 10_000;
/// Part by which the memory may grow with them.
const GROWTH: f64 = 0.05;

/// Resident memory of this program, kB; `None` where the system does not say.
fn resident_kb() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok()
}

#[test]
#[ignore = "takes long: tests/soak/edits.sh"]
fn memory_is_flat_over_many_edits() {
    let edits = std::env::var("DOUBLET_SOAK_EDITS").ok().and_then(|text| text.parse().ok()).unwrap_or(EDITS);
    let folder = tempfile::tempdir().unwrap();
    let autosaves = folder.path().join("autosave");
    let mut harness = builder(1280.0, 800.0)
        .build_eframe(move |cc| Workbench::new(cc, Document::open_demo().unwrap()).unwrap().keeping_work_in(autosaves));
    harness.run_steps(3);
    let first = harness.state().document.session().windows[0].clone();
    let mut full = None;
    for edit in 0..FILLING + edits {
        // Every edit is another window, so that nothing of it was computed before.
        let shift_s = 1e-4 * edit as f64;
        let window = TimeRange { start_s: first.window.start_s + shift_s, end_s: first.window.end_s + shift_s };
        harness.state_mut().apply(&Edit::Window(WindowEdit::Place { name: first.name.clone(), window }));
        harness.run_steps(2);
        if edit + 1 == FILLING {
            full = resident_kb();
        }
    }
    let (Some(full), Some(end)) = (full, resident_kb()) else { return };
    println!("{edits} edits: {:.0} MB with a full cache, {:.0} MB at the end", full / 1e3, end / 1e3);
    assert!(end <= (1.0 + GROWTH) * full, "{full} kB with a full cache, {end} kB after {edits} edits");
}
