//! Indication of change: what the shipped sessions give, to the last bit, against stored tables.
//!
//! The tables under `tests/indication/` hold one line per number or group of numbers, 17 significant digits, which is every bit of a
//! double; `bits` lines hold a hash over all bits of a window's path. A change of any of them is either a mistake or a change of
//! results that belongs into CHANGELOG.md under Numerics; only in the second case are the tables written anew:
//!
//! ```text
//! DOUBLET_BLESS=1 cargo test --workspace --test engine indication
//! ```
//!
//! What is chosen by the machine at run time: the width of the filter's vectors, nalgebra's products of matrices, rustfft's transforms
//! and sine, cosine and the like of the C library. All of them know a form with fused multiplication and addition (AVX2 and AVX-512
//! alike) and one without, which differ in the last bits. So the tables are those of machines with fused arithmetic, on which AVX2 and
//! AVX-512 are shown to give the same paths; they hold the paths of the filter's portable form as well. A machine without fused
//! arithmetic has no table here, and a C library of another make may round its functions otherwise.

use crate::compute;
use crate::shared;
use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use doublet_core::reconstruct::tuning::noise::likelihood;
use doublet_core::reconstruct::{
    Deviations, FilterData, FilterSettings, Method, Reconstruction, State, ValidSettings, Width, lanes,
    reconstruct_with,
};
use doublet_engine::run::Snapshot;
use doublet_engine::session::{self, PathSource, Session};
use doublet_engine::stage::{CoefficientFit, WindowPath, with_gravity};
use xxhash_rust::xxh3::Xxh3;

/// Set to write the tables anew.
const BLESS: &str = "DOUBLET_BLESS";
/// Lines of a difference that are shown.
const SHOWN: usize = 20;

/// The table of one session, line by line.
struct Table(String);

impl Table {
    fn numbers(&mut self, name: &str, values: &[f64]) {
        self.0.push_str(name);
        values.iter().for_each(|value| write!(self.0, " {value:.16e}").unwrap());
        self.0.push('\n');
    }

    fn bits<'a>(&mut self, name: &str, columns: impl IntoIterator<Item = &'a [f64]>) {
        let mut hash = Xxh3::new();
        let mut numbers = 0;
        for column in columns {
            numbers += column.len();
            // which of the many NaNs it is depends on the machine
            let bits = column.iter().map(|value| if value.is_nan() { f64::NAN } else { *value }.to_bits());
            bits.for_each(|bits| hash.update(&bits.to_le_bytes()));
        }
        writeln!(self.0, "{name}: bits {:016x} of {numbers} numbers", hash.digest()).unwrap();
    }

    /// Everything a reconstruction holds.
    fn path(&mut self, name: &str, run: &Reconstruction) {
        let deviations = |columns: &[Deviations]| columns.iter().map(Deviations::to_vec).collect::<Vec<_>>();
        let mut columns: Vec<Vec<f64>> = [&run.states[..], &deviations(&run.deviations)].concat();
        let absent = vec![f64::NAN; run.update_time_s.len()];
        let innovations = [&run.innovations[..], &deviations(&run.innovation_deviations)].concat();
        columns.extend(innovations.into_iter().map(|column| if column.is_empty() { absent.clone() } else { column }));
        columns.extend([run.nis.clone(), run.final_covariance.as_slice().to_vec(), vec![run.log_likelihood]]);
        let air_data = run.air_data.iter().chain(run.smoothed.iter().filter_map(|smoothed| smoothed.air_data.as_ref()));
        for found in air_data {
            columns.extend(found.states.iter().chain(&found.deviations).cloned());
        }
        if let Some(smoothed) = &run.smoothed {
            columns.extend([&smoothed.states[..], &deviations(&smoothed.deviations)].concat());
            columns.push(smoothed.costs.clone());
        }
        self.bits(name, columns.iter().map(Vec::as_slice));
    }

    fn fits(&mut self, place: &str, fits: &[CoefficientFit]) {
        for found in fits {
            let coefficient = found.coefficient.name();
            let Ok(fit) = &found.fit else {
                writeln!(self.0, "{place} {coefficient}: none").unwrap();
                continue;
            };
            for (k, name) in fit.names.iter().enumerate() {
                let corrected = found.corrected_errors.get(k).copied().unwrap_or(f64::NAN);
                self.numbers(&format!("{place} {name}:"), &[fit.estimates[k], fit.standard_errors[k], corrected]);
            }
        }
    }

    /// NIS, and states in the middle and at the end: filtered, their deviations, smoothed.
    fn states(&mut self, name: &str, path: &WindowPath) {
        let run = &path.reconstruction;
        let nis = path.assessment().consistency.as_ref().map_or(f64::NAN, |found| found.nis_ratio);
        self.numbers(&format!("{name} NIS over degrees, log likelihood:"), &[nis, run.log_likelihood]);
        for row in [run.time_s.len() / 2, run.time_s.len() - 1] {
            for state in State::ALL {
                let k = state as usize;
                let mut values = vec![run.states[k][row], run.deviations[k].at(row)];
                values.extend(run.smoothed.iter().map(|smoothed| smoothed.states[k][row]));
                self.numbers(&format!("{name} {} at {row}:", state.name()), &values);
            }
        }
    }
}

/// Settings of every form of filter and smoother, for a window that the session runs with `settings`.
fn variants(settings: &FilterSettings) -> Vec<(&'static str, FilterSettings)> {
    let usual = FilterSettings { smooth: true, smoother_passes: 1, ..settings.clone() };
    let ukf = Method::Ukf { spread: Method::USUAL_SPREAD };
    let mut walking = usual.clone();
    walking.random_walk.iter_mut().skip(9).for_each(|walk| *walk = walk.max(1e-4));
    // Beside noise so small every sample is an outlier.
    let mut ill_conditioned = FilterSettings { outlier_limit: 0.0, ..usual.clone() };
    ill_conditioned.measurement_noise.iter_mut().for_each(|noise| *noise = (*noise * 1e-4).max(1e-9));
    ill_conditioned.initial_deviation.iter_mut().for_each(|deviation| *deviation = (*deviation * 1e5).min(9e5));
    vec![
        ("extended", FilterSettings { method: Method::Ekf, ..usual.clone() }),
        ("unscented", FilterSettings { method: ukf, ..usual.clone() }),
        ("air data", FilterSettings { air_data_deviation: [0.01, 0.01, 0.05, 0.02, 0.0], ..usual.clone() }),
        ("three passes", FilterSettings { smoother_passes: 3, ..usual.clone() }),
        ("three passes, unscented", FilterSettings { method: ukf, smoother_passes: 3, ..usual.clone() }),
        ("random walks", walking),
        ("ill-conditioned", ill_conditioned),
    ]
}

/// Paths of every width of vector and, of the shortest window, of every form of the filter.
fn other_paths(table: &mut Table, settings: &FilterSettings, windows: &[(&str, &WindowPath)]) {
    let all: Vec<&FilterData> = windows.iter().map(|(_, path)| &*path.data).collect();
    let valid = settings.check().unwrap();
    let together = |width: Width, data: &[&FilterData], settings: &ValidSettings| {
        reconstruct_with(width, data, settings, &mut |_| ControlFlow::Continue(()))
    };
    for width in [Width::Two, Width::Four, Width::Eight].into_iter().filter(|width| width.lanes() <= lanes()) {
        for ((name, path), found) in windows.iter().zip(together(width, &all, &valid)) {
            let found = found.unwrap();
            let is_same = found.states == path.reconstruction.states;
            assert!(is_same || width == Width::Two, "{name}: {width:?} lanes give other bits than the session");
            table.path(&format!("lanes {} window '{name}'", width.lanes()), &found);
        }
    }
    let Some((name, shortest)) = windows.iter().min_by_key(|(_, path)| path.data.inputs.time_s.len()) else { return };
    for (variant, settings) in variants(settings) {
        match together(Width::Eight, &[&shortest.data], &settings.check().unwrap()).remove(0) {
            Ok(found) => table.path(&format!("window '{name}' {variant}"), &found),
            Err(error) => writeln!(table.0, "window '{name}' {variant}: {error}").unwrap(),
        }
    }
    let smoothed = FilterSettings { smooth: true, ..settings.clone() }.check().unwrap();
    match likelihood(&[&shortest.data], &smoothed, &mut |_| ControlFlow::Continue(())) {
        Ok(found) => {
            table.numbers(&format!("window '{name}' process noise:"), &found.moments.process);
            table.numbers(&format!("window '{name}' measurement noise:"), &found.moments.measurement);
        }
        Err(error) => writeln!(table.0, "window '{name}' noise: {error}").unwrap(),
    }
}

fn table(session: &Session, snapshot: &Snapshot) -> Table {
    let mut table = Table(String::new());
    table.fits("pooled", &snapshot.pooled.ready().unwrap().fits);
    let named = session.windows.iter().filter_map(|window| Some((window, snapshot.windows.get(&window.name)?)));
    let mut paths: Vec<(&str, &WindowPath)> = Vec::new();
    for (window, results) in named {
        let (name, path) = (format!("window '{}'", window.name), results.path.ready().unwrap());
        table.states(&name, path);
        table.path(&name, &path.reconstruction);
        table.fits(&name, results.fits.ready().map_or(&[], |fits| &fits.fits));
        paths.push((&window.name, path));
    }
    let gravity = snapshot.gravity.as_ref().unwrap();
    let smooth = session.preparation.path == PathSource::Smoothed;
    let settings = FilterSettings { smooth, ..with_gravity(session, gravity).filter };
    other_paths(&mut table, &settings, &paths);
    table
}

/// The table to write: a machine without all widths leaves the lines of the others, and changes no line of a width.
fn blessed(before: &str, found: &str) -> String {
    if lanes() == Width::Eight.lanes() {
        return found.to_owned();
    }
    let mut own = found.lines();
    let mut written = String::new();
    for line in before.lines() {
        let now = if is_comparable(line, lanes()) { own.next().unwrap() } else { line };
        assert!(now == line || !line.starts_with("lanes "), "only a machine with all widths can write changed paths");
        written += now;
        written.push('\n');
    }
    assert_eq!(own.next(), None, "only a machine with all widths can write further lines");
    written
}

/// Whether a machine with `lanes` lanes can compare a line.
fn is_comparable(line: &str, lanes: usize) -> bool {
    let wanted = line.strip_prefix("lanes ").and_then(|rest| rest.split(' ').next()?.parse::<usize>().ok());
    wanted.is_none_or(|wanted| wanted <= lanes)
}

/// Compares what the session of the given path in `sessions/` gives with its table, or writes that.
fn indicate(name: &str, recordings: &[&str]) {
    if recordings.iter().any(|recording| shared::shared(recording).is_none()) {
        return;
    }
    if lanes() < Width::Four.lanes() {
        assert!(std::env::var_os("CI").is_none_or(|ci| ci != "true"), "no table for machines without fused arithmetic");
        println!("skipped: no table for machines without fused arithmetic");
        return;
    }
    let session = session::parse(doublet_engine::builtin::session(name).unwrap()).unwrap();
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = here.join("../../sessions").join(name).parent().unwrap().to_owned();
    let snapshot = compute(&session, &folder);
    let found = table(&session, &snapshot).0;
    let place: PathBuf = here.join(format!("tests/indication/{name}.txt"));
    if std::env::var_os(BLESS).is_some() {
        let before = std::fs::read_to_string(&place).unwrap_or_default();
        std::fs::write(&place, blessed(&before, &found)).unwrap();
        return;
    }
    let expected = std::fs::read_to_string(&place).unwrap();
    let [expected, found] =
        [&expected, &found].map(|text| text.lines().filter(|line| is_comparable(line, lanes())).collect::<Vec<&str>>());
    assert!(!expected.is_empty());
    let changed: Vec<String> = expected
        .iter()
        .zip(&found)
        .filter(|(expected, found)| expected != found)
        .map(|(expected, found)| format!("was {expected}\nis  {found}"))
        .collect();
    let shown = changed.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join("\n");
    println!("{name}: {} lines, {} changed", expected.len(), changed.len());
    assert!(
        changed.is_empty() && expected.len() == found.len(),
        "{name}: {} of {} lines changed, now {}; if that is meant, say why in CHANGELOG.md under Numerics and set {BLESS}=1\n{shown}",
        changed.len(),
        expected.len(),
        found.len()
    );
}

#[test]
fn the_simulated_flight_gives_the_same_bits() {
    indicate("demo", &[]);
}

#[test]
fn the_simulated_flight_treated_as_in_the_thesis_gives_the_same_bits() {
    indicate("demo_thesis", &[]);
}

#[test]
fn the_flight_of_the_attas_gives_the_same_bits() {
    indicate("reference/attas", &["data/attas"]);
}

#[test]
fn the_simulated_citation_gives_the_same_bits() {
    indicate("reference/citation_aileron", &["data/citation_simulated"]);
}

#[test]
fn the_simulated_citation_with_zero_order_hold_gives_the_same_bits() {
    indicate("reference/citation_aileron_zero_order_hold", &["data/citation_simulated"]);
}

#[test]
fn the_flight_of_the_laboratory_citation_gives_the_same_bits() {
    indicate("reference/phlab_short_period", &["data/phlab_citation"]);
}

#[test]
fn a_changed_last_bit_changes_a_line() {
    let value: f64 = 0.1;
    let lines = [value, value.next_up()].map(|value| {
        let mut table = Table(String::new());
        table.numbers("number:", &[value]);
        table.bits("column", [[1.0, value].as_slice()]);
        table.0
    });
    for (line, changed) in lines[0].lines().zip(lines[1].lines()) {
        assert_ne!(line, changed);
    }
    assert!(is_comparable("lanes 4 window", 4) && !is_comparable("lanes 8 window", 4) && is_comparable("pooled", 4));
}
