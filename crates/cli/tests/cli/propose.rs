//! `doublet propose` as a user runs it.

use std::path::Path;

use doublet_engine::session::{self, NoiseChannel};

use crate::common::at_root::printed;

/// Runs the command on a session file and returns what it printed.
fn propose(what: &str, session: &Path) -> String {
    printed(&["propose", what, session.to_str().unwrap(), "--apply"])
}

#[test]
fn proposals_are_written_into_a_session_that_then_has_nothing_open() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions/demo.toml");
    let mut session = session::open(&shipped).unwrap().session;
    let flown = session.windows.clone();
    session.windows.clear();
    session.noise_reasons.insert("az".to_owned(), "vibrates at cruise power".to_owned());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    session::save(&session, &path).unwrap();

    let printed = propose("manoeuvres", &path);
    let after = session::open(&path).unwrap().session;
    assert_eq!(after.windows.len(), flown.len());
    assert!(printed.contains("10 aileron irregular") && printed.contains("12 rudder 3-2-1-1"), "{printed}");
    for (found, flown) in after.windows.iter().zip(&flown) {
        // The input lies well inside both; they may take more or less of the free motion.
        assert!((found.window.start_s - flown.window.start_s).abs() < 0.5 && found.surface == flown.surface);
    }
    let again = propose("windows", &path);
    assert!(again.contains("nothing to change"), "{again}");

    let printed = propose("noise", &path);
    let noisy = session::open(&path).unwrap().session;
    let std = |name: &str| NoiseChannel::from_name(name).unwrap().std(&noisy);
    // Thesis Table 4.15, which the simulated gyro follows, with the recorder's step of 1/32 deg/s: 1.210e-3, to a tenth.
    assert!((std("q") / 1.210e-3 - 1.0).abs() < 0.1, "{}", std("q"));
    assert_eq!(std("az"), session.filter.process_noise[2]);
    assert!(printed.contains("kept as set: vibrates at cruise power"), "{printed}");
    // Nothing was recorded of it, so nothing is changed.
    assert_eq!(std("x"), session.filter.measurement_noise[0]);
}
