//! Section on the independent checks: every window again in the frequency domain and by output error.

use doublet_core::model::is_constant_name;

use super::{Block, Contents, Parts, paragraph};
use crate::notation::{self, significant};
use crate::report::study_tables::{check_table, followed_table};
use crate::report::table::{Cell, Column, Table, TableOf};
use crate::study::{ESTIMATORS, Estimator, FollowedOutput};
use crate::verdict::{TWIN_CAUTION, TWIN_PART, compare_twins, fold};

/// What was expected and found, then what was found about it; in the appendix derivatives by every method and how well the flights of output
/// error follow.
pub fn checks(contents: &Contents<'_>) -> Parts {
    let studies = &contents.results.studies;
    if studies.checks.is_empty() {
        return Parts::default();
    }
    let (outputs, estimates): (Vec<_>, Vec<_>) =
        studies.checks.iter().partition(|row| row.largest_deviation.is_finite());
    let is_used = |estimator: &&Estimator| studies.checks.iter().any(|row| row.method == estimator.name);
    let methods: Vec<&str> = ESTIMATORS.iter().filter(is_used).map(|estimator| estimator.about).collect();
    let mut blocks = vec![paragraph(&format!("Each manoeuvre by other estimators. {}", methods.join(" ")))];
    let expected = table(&[derivative_checks(contents), output_checks(contents)].concat());
    blocks.extend((!expected.rows.is_empty()).then_some(Block::Table(expected)));
    let folded = fold(&studies.check_findings, &[]);
    let lines: Vec<String> =
        folded.iter().map(|found| format!("{}: {}: {}", found.level.name(), found.place, found.text)).collect();
    if lines.is_empty() {
        blocks.push(paragraph("No finding: the output-error simulations follow their recordings."));
    } else {
        blocks.push(Block::List(lines));
    }
    // Initial states and biases belong to one window and have no twin.
    let of_model = estimates.into_iter().filter(|row| !row.derivative.ends_with(']') && row.error.is_none());
    let columns =
        ["window", "method", "derivative", "estimate", "standard_error", "equation_error", "equation_standard_error"];
    let mut appendix = vec![Block::Table(check_table(of_model).select(&columns))];
    if !outputs.is_empty() {
        appendix.push(Block::Table(followed_table(outputs)));
    }
    Parts { body: blocks, appendix }
}

/// One check over all manoeuvres.
#[derive(Clone)]
struct Check {
    name: String,
    expected: String,
    /// The figure furthest from what is expected, and where.
    worst: (f64, String),
    within: usize,
    of: usize,
}

/// One figure of a check.
struct Judged {
    check: String,
    figure: f64,
    place: String,
    is_within: bool,
}

/// Gathers figures by their checks, in the order of first appearance; `sign` is positive where greater figures are worse.
fn gather(figures: impl Iterator<Item = Judged>, expected: &str, sign: f64) -> Vec<Check> {
    let mut checks: Vec<Check> = Vec::new();
    for Judged { check: name, figure, place, is_within } in figures {
        let index = checks.iter().position(|known| known.name == name).unwrap_or_else(|| {
            let worst = (f64::NEG_INFINITY * sign, String::new());
            checks.push(Check { name, expected: expected.to_owned(), worst, within: 0, of: 0 });
            checks.len() - 1
        });
        let check = &mut checks[index];
        check.of += 1;
        check.within += usize::from(is_within);
        if sign * figure > sign * check.worst.0 {
            check.worst = (figure, place);
        }
    }
    checks
}

/// Derivatives of each manoeuvre against the same by other methods, by coefficient and method.
fn derivative_checks(contents: &Contents<'_>) -> Vec<Check> {
    let part = significant(100.0 * TWIN_PART, 2);
    let expected = format!("at most {TWIN_CAUTION} joint std errors, or {part} %, apart");
    let twins = compare_twins(contents.snapshot);
    let figures =
        twins.iter().filter(|twin| twin.times().is_finite() && !is_constant_name(twin.name)).map(|twin| Judged {
            check: format!("{} by {}", twin.name.split('_').next().unwrap_or_default(), twin.method),
            figure: twin.times(),
            place: format!("{}, {}", notation::derivative(twin.name), twin.window),
            is_within: twin.times() <= TWIN_CAUTION,
        });
    gather(figures, &expected, 1.0)
}

/// Outputs of the simulations against their recordings.
fn output_checks(contents: &Contents<'_>) -> Vec<Check> {
    let expected = format!("R² at least {}", FollowedOutput::LEAST_R_SQUARED);
    let windows = contents.snapshot.studies.checks.ready().into_iter().flat_map(|study| &study.windows);
    let outputs = windows.flat_map(|window| {
        let outputs = window.flights().flat_map(|flight| &flight.outputs);
        outputs.map(|output| (window.window.as_str(), output))
    });
    let figures = outputs.filter(|(_, output)| output.r_squared.is_finite()).map(|(window, output)| Judged {
        check: format!("simulated {}", notation::role_symbol(output.output.name())),
        figure: output.r_squared,
        place: window.to_owned(),
        is_within: output.departure().is_none(),
    });
    gather(figures, &expected, -1.0)
}

fn table(checks: &[Check]) -> Table {
    let caption = "Checks over all manoeuvres: what is expected, the value furthest from it, and how many are within, without constants. Outputs that hardly move are within at any R².";
    let found = |check: &Check| match &check.worst {
        (figure, _) if *figure == 0.0 => format!("all within {} %", significant(100.0 * TWIN_PART, 2)),
        (figure, place) => format!("{} ({place})", significant(*figure, 3)),
    };
    TableOf::new("check_summary", caption, checks)
        .text("check", "Check", |check| &check.name)
        .text("expected", "Expected", |check| &check.expected)
        .column(Column::new("found", "Found"), |check| Cell::text(found(check)))
        .column(Column::new("within", "Within"), |check| Cell::text(format!("{} of {}", check.within, check.of)))
        .done()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(check: &str, figure: f64, place: &str, is_within: bool) -> Judged {
        Judged { check: check.to_owned(), figure, place: place.to_owned(), is_within }
    }

    #[test]
    fn the_table_of_checks_shows_the_worst_figure_and_how_many_are_within() {
        let apart = [
            judged("Cm by output error", 0.5, "Cmα, 01", true),
            judged("Cl by output error", 0.0, "Clp, 02", true),
            judged("Cm by output error", 4.2, "Cmq, 02", false),
            judged("Cm by output error", 1.5, "Cmq, 03", true),
        ];
        let followed = [judged("simulated q", 0.93, "01", true), judged("simulated q", 0.31, "02", false)];
        let checks =
            [gather(apart.into_iter(), "at most 2", 1.0), gather(followed.into_iter(), "R² at least 0.5", -1.0)];
        let found = table(&checks.concat());
        let rows: Vec<Vec<String>> =
            found.rows.iter().map(|row| row.iter().map(|cell| cell.readable(3)).collect()).collect();
        let within = format!("all within {} %", significant(100.0 * TWIN_PART, 2));
        assert_eq!(rows[0], ["Cm by output error", "at most 2", "4.20 (Cmq, 02)", "2 of 3"]);
        assert_eq!(rows[1], ["Cl by output error", "at most 2", within.as_str(), "1 of 1"]);
        assert_eq!(rows[2], ["simulated q", "R² at least 0.5", "0.310 (02)", "1 of 2"]);
    }
}
