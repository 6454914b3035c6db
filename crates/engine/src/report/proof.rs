//! The proof of match as rows, and as the tables `match` and `match_theil`.

use doublet_core::validate::{BandResult, TestResult};
use serde::Serialize;

use super::table::{Cell, Column, Table, TableOf};
use crate::graph::StageResult;
use crate::stage::{ProofOfMatch, WindowReplay};

/// Validation windows flown again.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ProofRow {
    /// Name of the tolerances.
    pub tolerances: String,
    /// One entry per validation manoeuvre.
    pub windows: Vec<ReplayRow>,
}

/// One window flown again.
#[derive(Clone, Debug, Serialize)]
pub struct ReplayRow {
    /// Manoeuvre.
    pub window: String,
    /// Why the simulation failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Tests of the tolerances that apply.
    pub tests: Vec<TestRow>,
    /// Theil's coefficient of each signal.
    pub theil: Vec<TheilRow>,
}

/// One test.
#[derive(Clone, Debug, Serialize)]
pub struct TestRow {
    /// Number in the rule.
    pub id: String,
    pub name: String,
    /// Whether every requirement is met by one of its bands.
    pub passed: bool,
    pub bands: Vec<BandRow>,
}

/// One band of a test.
#[derive(Clone, Debug, Serialize)]
pub struct BandRow {
    /// Its requirement, counted from 1: one band of each must hold.
    pub requirement: usize,
    pub signal: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// Whether the simulation stays inside throughout.
    pub passed: bool,
    /// Largest difference over the half width there.
    pub worst_ratio: f64,
    /// Simulated minus measured there, SI.
    pub worst_error: f64,
    /// Time of it, s.
    pub worst_time_s: f64,
    /// Share of the samples inside.
    pub share_inside: f64,
}

/// Theil's coefficient and the parts of the mean square error.
#[derive(Clone, Debug, Serialize)]
pub struct TheilRow {
    pub signal: &'static str,
    /// Coefficient: 0 perfect, 1 none.
    pub coefficient: f64,
    /// Share from a difference of means.
    pub bias: f64,
    /// Share from a difference of standard deviations.
    pub variance: f64,
    /// Share from imperfect correlation.
    pub covariance: f64,
}

pub fn rows(proof: &ProofOfMatch) -> ProofRow {
    let windows = proof.windows.iter().map(|(window, replay)| replay_row(window, replay));
    ProofRow { tolerances: proof.tolerances.clone(), windows: windows.collect() }
}

fn replay_row(window: &str, replay: &StageResult<std::sync::Arc<WindowReplay>>) -> ReplayRow {
    let (tests, theil) = match replay {
        Ok(replay) => (replay.tests.iter().map(test_row).collect(), theil_rows(replay)),
        Err(_) => Default::default(),
    };
    ReplayRow { window: window.to_owned(), error: replay.as_ref().err().map(ToString::to_string), tests, theil }
}

fn test_row(test: &TestResult) -> TestRow {
    let numbered = test.requirements.iter().enumerate();
    let bands = numbered.flat_map(|(index, bands)| bands.iter().map(move |band| band_row(index + 1, band)));
    TestRow { id: test.id.clone(), name: test.name.clone(), passed: test.passed(), bands: bands.collect() }
}

fn band_row(requirement: usize, band: &BandResult) -> BandRow {
    let signal = band.tolerance.signal;
    BandRow {
        requirement,
        signal: signal.name(),
        unit: signal.dimension().si_symbol(),
        passed: band.passed(),
        worst_ratio: band.worst_ratio,
        worst_error: band.worst_error,
        worst_time_s: band.worst_time_s,
        share_inside: band.share_inside,
    }
}

fn theil_rows(replay: &WindowReplay) -> Vec<TheilRow> {
    replay.theil.iter().map(theil_row).collect()
}

fn theil_row((signal, theil): &(doublet_core::validate::Signal, doublet_core::validate::Theil)) -> TheilRow {
    TheilRow {
        signal: signal.name(),
        coefficient: theil.coefficient,
        bias: theil.bias,
        variance: theil.variance,
        covariance: theil.covariance,
    }
}

/// Bands of every test, and Theil's coefficients.
pub fn tables(proof: &ProofRow) -> [Table; 2] {
    [bands(proof), theil(proof)]
}

/// Every test, the bands of every test as people read them, and Theil's coefficients.
pub fn shown_tables(proof: &ProofRow) -> [Table; 3] {
    [tests(proof), bands(proof).select(&BANDS), theil(proof)]
}

/// Columns of the bands that people read.
const BANDS: [&str; 10] = [
    "window", "test", "requirement", "signal", "unit", "band_passed", "worst_ratio", "worst_error", "worst_time_s",
    "share_inside",
];

/// One row per test.
fn tests(proof: &ProofRow) -> Table {
    let rows = proof.windows.iter().flat_map(|window| window.tests.iter().map(move |test| (window, test)));
    let caption = "Tests: largest difference as a fraction of the half-width of the band (limit 1).";
    TableOf::new("match_tests", caption, rows)
        .text("window", "Manoeuvre", |(window, _)| &window.window)
        .text("test", "Test", |(_, test)| &test.id)
        .text("name", "Name", |(_, test)| &test.name)
        .text("verdict", "Verdict", |(_, test)| if test.passed { "pass" } else { "fail" })
        .number("used", "Over half width", "", 3, |(_, test)| used(test))
        .done()
}

/// Largest ratio over the requirements, of the best band of each.
fn used(test: &TestRow) -> f64 {
    let last = test.bands.iter().map(|band| band.requirement).max().unwrap_or(0);
    let best = (1..=last).map(|requirement| {
        let bands = test.bands.iter().filter(|band| band.requirement == requirement);
        bands.map(|band| band.worst_ratio).fold(f64::NAN, f64::min)
    });
    best.fold(f64::NAN, f64::max)
}

/// Every band of every test.
fn bands(proof: &ProofRow) -> Table {
    let tests = proof.windows.iter().flat_map(|window| window.tests.iter().map(move |test| (window, test)));
    let rows = tests.flat_map(|(window, test)| test.bands.iter().map(move |band| (window, test, band)));
    let caption = "Bands of every test: largest difference (simulated minus measured) and its time.";
    TableOf::new("match", caption, rows)
        .text("window", "Manoeuvre", |(window, ..)| &window.window)
        .text("test", "Test", |(_, test, _)| &test.id)
        .text("name", "Name", |(_, test, _)| &test.name)
        .column(Column::new("test_passed", "Test passed"), |(_, test, _)| Cell::Flag(test.passed))
        .count("requirement", "Requirement", |(.., band)| band.requirement)
        .text("signal", "Signal", |(.., band)| band.signal)
        .text("unit", "Unit", |(.., band)| band.unit)
        .column(Column::new("band_passed", "Inside"), |(.., band)| Cell::Flag(band.passed))
        .number("worst_ratio", "Over half width", "", 3, |(.., band)| band.worst_ratio)
        .number("worst_error", "Difference", "", 3, |(.., band)| band.worst_error)
        .number("worst_time_s", "At", "s", 5, |(.., band)| band.worst_time_s)
        .number("share_inside", "Share inside", "", 3, |(.., band)| band.share_inside)
        .done()
}

/// Theil's coefficient of each signal of each window.
fn theil(proof: &ProofRow) -> Table {
    let rows = proof.windows.iter().flat_map(|window| window.theil.iter().map(move |row| (window, row)));
    let caption = "Theil's inequality coefficient, 0 perfect and 1 none, and the shares of the mean square error.";
    TableOf::new("match_theil", caption, rows)
        .text("window", "Manoeuvre", |(window, _)| &window.window)
        .text("signal", "Signal", |(_, row)| row.signal)
        .number("theil", "Theil", "", 3, |(_, row)| row.coefficient)
        .number("bias", "Bias", "", 3, |(_, row)| row.bias)
        .number("variance", "Variance", "", 3, |(_, row)| row.variance)
        .number("covariance", "Covariance", "", 3, |(_, row)| row.covariance)
        .done()
}
