//! The proof of match as rows, and as the tables `match.csv` and `match_theil.csv`.

use std::path::Path;

use doublet_core::validate::{BandResult, TestResult};

use super::ReportError;
use super::results::{BandRow, ProofRow, ReplayRow, TestRow, TheilRow};
use super::tables::{number, table};
use crate::stage::{ProofOfMatch, WindowReplay};

/// Rows of a proof of match.
pub fn rows(proof: &ProofOfMatch) -> ProofRow {
    let one = |(window, replay): &(String, Result<std::sync::Arc<WindowReplay>, String>)| {
        let (tests, theil) = match replay {
            Ok(replay) => (replay.tests.iter().map(test_row).collect(), theil_rows(replay)),
            Err(_) => Default::default(),
        };
        ReplayRow { window: window.clone(), error: replay.as_ref().err().cloned(), tests, theil }
    };
    ProofRow { tolerances: proof.tolerances.clone(), windows: proof.windows.iter().map(one).collect() }
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
    let row = |(signal, theil): &(doublet_core::validate::Signal, doublet_core::validate::Theil)| TheilRow {
        signal: signal.name(),
        coefficient: theil.coefficient,
        bias: theil.bias,
        variance: theil.variance,
        covariance: theil.covariance,
    };
    replay.theil.iter().map(row).collect()
}

/// Writes the tables.
pub fn write(proof: &ProofRow, folder: &Path) -> Result<(), ReportError> {
    table(
        &folder.join("match.csv"),
        &[
            "window",
            "test",
            "name",
            "test_passed",
            "requirement",
            "signal",
            "unit",
            "band_passed",
            "worst_ratio",
            "worst_error",
            "worst_time_s",
            "share_inside",
        ],
        proof.windows.iter().flat_map(|window| {
            window.tests.iter().flat_map(|test| {
                test.bands.iter().map(|band| {
                    vec![
                        window.window.clone(),
                        test.id.clone(),
                        test.name.clone(),
                        test.passed.to_string(),
                        band.requirement.to_string(),
                        band.signal.to_owned(),
                        band.unit.to_owned(),
                        band.passed.to_string(),
                        number(band.worst_ratio),
                        number(band.worst_error),
                        number(band.worst_time_s),
                        number(band.share_inside),
                    ]
                })
            })
        }),
    )?;
    table(
        &folder.join("match_theil.csv"),
        &["window", "signal", "theil", "bias", "variance", "covariance"],
        proof.windows.iter().flat_map(|window| {
            window.theil.iter().map(|row| {
                vec![
                    window.window.clone(),
                    row.signal.to_owned(),
                    number(row.coefficient),
                    number(row.bias),
                    number(row.variance),
                    number(row.covariance),
                ]
            })
        }),
    )
}
