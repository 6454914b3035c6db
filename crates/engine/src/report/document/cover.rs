//! The first page: what was analysed, what came out, and whether to believe it.

use super::findings;
use super::{Block, Contents};
use crate::date;
use crate::notation::significant;
use crate::report::results::{DerivativeRow, FitRow, WindowRow};
use crate::report::table::{Cell, Column, Table};
use crate::report::tables;
use crate::session::WindowRole;
use crate::verdict::{self, Level};

/// Recordings there is room for.
const RECORDINGS: usize = 14;

/// Reasons of the verdict there is room for.
const REASONS: usize = 5;

/// Facts, recordings and summary.
pub fn cover(contents: &Contents<'_>) -> Vec<Block> {
    let (session, results) = (contents.session, contents.results);
    let flights = results.flights.iter().map(|flight| match &flight.date {
        Some(date) => format!("{}, flown {date}", flight.name),
        None => format!("{}, date not recorded", flight.name),
    });
    let mut facts = vec![
        ("Aircraft", results.aircraft.clone()),
        ("Flight", flights.collect::<Vec<_>>().join("; ")),
        ("Date of this report", date::today()),
        ("Program", results.app.clone()),
        ("Session SHA-256", results.session_sha256.clone()),
    ];
    if results.recordings.len() > RECORDINGS {
        facts.push(("Recordings", format!("{}, listed with their hashes in the overview", results.recordings.len())));
    }
    let mut blocks = vec![facts_of(facts)];
    blocks.extend(recordings(contents, true));
    blocks.push(Block::Heading("Summary".to_owned()));
    let used = |role: WindowRole| session.windows.iter().filter(|window| window.role == role).count();
    let windows = format!(
        "{} for identification, {} for validation, {} ignored",
        used(WindowRole::Identification),
        used(WindowRole::Validation),
        used(WindowRole::Ignored)
    );
    let mut summary = vec![
        ("Verdict", verdict_line(contents)),
        ("Manoeuvres", windows),
        ("Filter", consistency(&results.windows)),
        ("Proof of match", proof(contents)),
        ("Findings", format!("{}, listed at the end", findings::counted(contents))),
    ];
    let failed = contents.snapshot.failures().len() + contents.snapshot.failed_fits().len();
    if failed > 0 {
        summary.push((
            "Not computed",
            format!("{failed} stages or coefficients: see the findings and the quality of the fits"),
        ));
    }
    blocks.push(facts_of(summary));
    blocks.extend(reasons(contents));
    let table = coefficients(contents);
    blocks.extend((!table.rows.is_empty()).then_some(Block::Table(table)));
    blocks
}

/// The recordings with their hashes: on the first page, or in the overview where they are too many for it.
pub fn recordings(contents: &Contents<'_>, first_page: bool) -> Option<Block> {
    let table = tables::recordings(contents.results);
    let count = table.rows.len();
    (count > 0 && (count <= RECORDINGS) == first_page).then_some(Block::Table(table))
}

fn facts_of(facts: Vec<(&str, String)>) -> Block {
    Block::Facts(facts.into_iter().map(|(name, text)| (name.to_owned(), text)).collect())
}

/// The verdict in one line.
fn verdict_line(contents: &Contents<'_>) -> String {
    contents.snapshot.verdicts.ready().map_or("not judged".to_owned(), |verdicts| verdicts.headline())
}

/// What the verdict rests on, the worst lines.
fn reasons(contents: &Contents<'_>) -> Option<Block> {
    let found = verdict::folded(contents.session, contents.snapshot);
    let against = found.iter().filter(|line| line.level > Level::Good).take(REASONS);
    let lines: Vec<String> = against.map(|line| format!("{}: {line}", line.level.name())).collect();
    (!lines.is_empty()).then_some(Block::List(lines))
}

/// Whether the innovations are as large as the filter says.
fn consistency(windows: &[WindowRow]) -> String {
    let judged: Vec<&WindowRow> = windows.iter().filter(|window| window.mean_nis.is_finite()).collect();
    if judged.is_empty() {
        return "no manoeuvre was judged".to_owned();
    }
    let mean = |value: &dyn Fn(&WindowRow) -> f64| {
        significant(judged.iter().map(|window| value(window)).sum::<f64>() / judged.len() as f64, 3)
    };
    let inside = judged.iter().filter(|window| {
        let [low, high] = window.nis_band_correlated;
        (low..=high).contains(&window.mean_nis)
    });
    format!(
        "mean normalised innovation squared {}, expected {}; inside its 95 % band in {} of {} manoeuvres",
        mean(&|window| window.mean_nis),
        mean(&|window| window.expected_nis),
        inside.count(),
        judged.len()
    )
}

/// How many tests pass.
fn proof(contents: &Contents<'_>) -> String {
    let found = &contents.results.proof_of_match;
    let flown = found.windows.iter().filter(|window| window.error.is_none()).count();
    let tests: Vec<bool> =
        found.windows.iter().flat_map(|window| window.tests.iter().map(|test| test.passed)).collect();
    if tests.is_empty() {
        return format!("no test applies; {flown} of {} validation manoeuvres simulated", found.windows.len());
    }
    let passed = tests.iter().filter(|passed| **passed).count();
    format!(
        "{passed} of {} tests pass over {flown} of {} manoeuvres, {}",
        tests.len(),
        found.windows.len(),
        found.tolerances
    )
}

/// One row per coefficient: fit, prediction, and the derivative known least.
fn coefficients(contents: &Contents<'_>) -> Table {
    let results = contents.results;
    let rows = results.pooled.iter().filter(|fit| fit.error.is_none()).map(|fit| {
        let validation = results.validation.iter().find(|row| row.coefficient == fit.coefficient);
        let validation = validation.map(|row| row.agreement);
        let predicted = results
            .predictions
            .iter()
            .filter(|row| row.coefficient == fit.coefficient && row.role == WindowRole::Validation.name());
        let least = predicted.map(|row| row.agreement.r_squared_identified_constants).reduce(f64::min);
        let (count, weakest) = weakest(fit);
        let number = |value: &dyn Fn(&DerivativeRow) -> f64| Cell::maybe(weakest.map(value));
        vec![
            Cell::Symbol(fit.coefficient.to_owned()),
            Cell::Count(fit.windows.len()),
            Cell::Count(count),
            Cell::Number(fit.r_squared),
            Cell::maybe(validation.map(|agreement| agreement.r_squared_identified_constants)),
            Cell::maybe(least),
            Cell::maybe(validation.map(|agreement| agreement.r_squared_own_constant)),
            weakest.map_or(Cell::Empty, |row| Cell::Symbol(row.name.clone())),
            number(&|row| row.estimate),
            number(&|row| row.corrected_standard_error),
            number(&|row| row.relative_error_percent),
        ]
    });
    let r_squared = |key: &str, heading: &str| Column::number(key, heading, "", 4);
    Table {
        name: "summary".to_owned(),
        caption: "Pooled estimate of each coefficient; prediction of the validation manoeuvres (mean and smallest with the identified constants, mean with own constants); least certain derivative (error corrected for coloured residuals; derivatives per radian)."
            .to_owned(),
        columns: vec![
            Column::new("coefficient", "Coefficient"),
            Column::new("windows", "Manoeuvres"),
            Column::new("derivatives", "Derivatives"),
            r_squared("r_squared", "R² fit"),
            r_squared("validation_mean", "R² validation"),
            r_squared("validation_least", "least"),
            r_squared("validation_own", "own constant"),
            Column::new("derivative", "Known least"),
            Column::number("estimate", "Estimate", "", 4),
            Column::number("error", "Std error", "", 2),
            Column::number("relative", "Relative", "%", 2),
        ],
        rows: rows.collect(),
    }
}

/// Number of derivatives, and the one with the largest relative error; constants are trim, not derivatives.
fn weakest(fit: &FitRow) -> (usize, Option<&DerivativeRow>) {
    let constant = format!("{}_0", fit.coefficient);
    let derivatives = || fit.derivatives.iter().filter(|row| !row.name.starts_with(&constant));
    let weakest = derivatives().max_by(|a, b| a.relative_error_percent.total_cmp(&b.relative_error_percent));
    (derivatives().count(), weakest)
}
