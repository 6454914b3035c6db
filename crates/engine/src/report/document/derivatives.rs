//! Sections on the aerodynamic model.

use doublet_core::statistics::NORMAL_95;

use super::figure::points_with_bars;
use super::{Axis, Block, Colour, Contents, Figure, Mark, Matrix, Panel, Parts, Plot, numbers_of, paragraph};
use crate::notation;
use crate::report::results::{DerivativeRow, DerivativeSummaryRow, FitRow, RegressorRow};
use crate::report::table::{Cell, Column, Table, TableOf};
use crate::report::tables;
use crate::session::{PooledConstants, WindowRole};

/// Magnitude of a correlation from which on two parameters are said to move together.
const CLOSE: f64 = 0.9;

/// Terms of each coefficient, and the correlation of their parameters in the pooled estimate.
pub fn model(contents: &Contents<'_>) -> Vec<Block> {
    let (session, results) = (contents.session, contents.results);
    let formulas = session.structure.models.iter().map(|(coefficient, terms)| {
        let sum = terms.iter().map(|term| {
            let derivative = notation::derivative(&term.derivative_name(*coefficient));
            if term.is_constant() { derivative } else { format!("{derivative} {}", notation::term(&term.to_string())) }
        });
        (coefficient.name().to_owned(), sum.collect::<Vec<_>>().join(" + "))
    });
    let surfaces = if session.estimation.by_surface {
        "Symmetric coefficients are estimated from manoeuvres of the elevator, asymmetric ones from those of aileron and rudder."
    } else {
        "Every coefficient is estimated from every manoeuvre."
    };
    let constants = match session.estimation.constants {
        PooledConstants::PerManoeuvre => "The pooled estimate has one constant per manoeuvre.",
        PooledConstants::Common => "The pooled estimate has one constant for all manoeuvres.",
    };
    let mut blocks = vec![Block::Facts(formulas.collect()), Block::Paragraph(format!("{surfaces} {constants}"))];
    let known = session.estimation.constraints.iter();
    let known: Vec<_> =
        known.map(|known| format!("{} {}", notation::derivative(&known.derivative()), known.summary())).collect();
    if !known.is_empty() {
        let words = "Known beforehand: ".to_owned() + &known.join(", ");
        blocks.push(Block::Paragraph(format!(
            "{words}. Derivatives that are fixed or at a bound have no standard error; priors are weighted against white residuals."
        )));
    }
    let fits: Vec<&FitRow> = results.pooled.iter().filter(|fit| fit.error.is_none()).collect();
    let panels: Vec<Panel> = fits.iter().map(|fit| correlation(fit)).collect();
    if !panels.is_empty() {
        blocks.push(Block::Figure(Figure::new(
            "correlation",
            "Correlation of the parameters in the pooled estimate, without the constants of single manoeuvres.",
            (3, 36.0),
            panels,
        )));
    }
    blocks.extend(regressors(contents));
    let pairs = close_pairs(&fits);
    blocks.push(if pairs.rows.is_empty() {
        Block::Paragraph(format!("No two derivatives are correlated by {CLOSE} or more."))
    } else {
        Block::Table(pairs)
    });
    let quality = tables::fits(results).only("window", |cell| *cell == Cell::text("pooled")).select(&[
        "coefficient", "samples", "r_squared", "rms_relative_percent", "residual_deviation", "condition_number",
    ]);
    if !quality.rows.is_empty() {
        blocks.push(Block::Table(quality.captioned("Quality of the pooled fits.")));
    }
    blocks
}

/// Correlation of the regressors of every coefficient (thesis 4.4.3).
fn regressors(contents: &Contents<'_>) -> Option<Block> {
    // A single regressor has nothing to be correlated with.
    let several = contents.results.regressor_correlation.iter().filter(|row| row.derivatives.len() > 1);
    let panels: Vec<Panel> = several.map(draw_matrix).collect();
    (!panels.is_empty()).then(|| {
        Block::Figure(Figure::new(
            "regressors",
            "Correlation of the regressors over the identification manoeuvres, named by their derivatives.",
            (3, 36.0),
            panels,
        ))
    })
}

fn draw_matrix(row: &RegressorRow) -> Panel {
    Panel::Matrix(Matrix {
        title: row.coefficient.to_owned(),
        names: row.derivatives.iter().map(|name| notation::derivative(name)).collect(),
        values: row.correlation.clone(),
        full_scale: 1.0,
    })
}

/// Places of the parameters that are shared by all windows.
fn shared(fit: &FitRow) -> Vec<usize> {
    (0..fit.derivatives.len()).filter(|&index| !fit.derivatives[index].name.contains('[')).collect()
}

fn correlation(fit: &FitRow) -> Panel {
    let shared = shared(fit);
    Panel::Matrix(Matrix {
        title: fit.coefficient.to_owned(),
        names: shared.iter().map(|&index| notation::derivative(&fit.derivatives[index].name)).collect(),
        values: shared
            .iter()
            .map(|&row| shared.iter().map(|&column| fit.parameter_correlation[row][column]).collect())
            .collect(),
        full_scale: 1.0,
    })
}

fn close_pairs(fits: &[&FitRow]) -> Table {
    let mut rows = Vec::new();
    for fit in fits {
        let shared = shared(fit);
        for (place, &first) in shared.iter().enumerate() {
            for &second in &shared[..place] {
                let value = fit.parameter_correlation[first][second];
                if value.abs() >= CLOSE {
                    let symbol = |index: usize| Cell::Symbol(fit.derivatives[index].name.clone());
                    rows.push(vec![symbol(second), symbol(first), Cell::Number(value)]);
                }
            }
        }
    }
    Table {
        name: "correlated".to_owned(),
        caption: format!(
            "Derivatives with a correlation of {CLOSE} or more: an error of one goes with an error of the other. The intervals of both allow for it."
        ),
        columns: vec![
            Column::new("first", "Derivative"),
            Column::new("second", "with"),
            Column::number("correlation", "Correlation", "", 3),
        ],
        rows,
    }
}

/// All pooled derivatives with their intervals; in the appendix one table and one figure per coefficient (thesis Tables 6.4 to 6.9).
pub fn derivatives(contents: &Contents<'_>) -> Parts {
    let results = contents.results;
    if results.derivative_summary.is_empty() {
        return Parts::default();
    }
    let body = vec![
        paragraph(
            "Estimates from all identification manoeuvres. The interval follows from the standard error corrected for correlated residuals. Scatter is the standard deviation of the single-manoeuvre estimates.",
        ),
        Block::Table(pooled(contents)),
        Block::Table(coefficients(contents)),
        Block::Table(stated_values(contents)),
    ];
    let mut appendix = vec![paragraph(
        "Pooled: estimate from all identification manoeuvres, with the standard error for white residuals and the one corrected for correlated residuals. Scatter: standard deviation of the single-manoeuvre estimates. Mean, minimum, maximum and variances are those of single manoeuvres.",
    )];
    let mut coefficients: Vec<&str> = results.derivative_summary.iter().map(|row| row.coefficient).collect();
    coefficients.dedup();
    coefficients.into_iter().for_each(|coefficient| appendix.extend(one_coefficient(contents, coefficient)));
    Parts { body, appendix }
}

fn pooled(contents: &Contents<'_>) -> Table {
    let results = contents.results;
    let rows = results.pooled.iter().flat_map(|fit| fit.derivatives.iter()).filter(|row| !row.name.contains('['));
    let scatter = |name: &str| results.derivative_summary.iter().find(|row| row.name == name);
    TableOf::new("pooled", "Aerodynamic and control derivatives, per radian.", rows)
        .symbol("derivative", "Derivative", |row| &row.name)
        .number("estimate", "Estimate", "", 4, |row| row.estimate)
        .maybe("low", "95 % from", "", 4, |row| row.interval_95.map(|ends| ends[0]))
        .maybe("high", "to", "", 4, |row| row.interval_95.map(|ends| ends[1]))
        .number("corrected_standard_error", "Corrected", "", 2, |row| row.corrected_standard_error)
        .number("relative_error_percent", "Relative", "%", 2, |row| row.relative_error_percent)
        .maybe("scatter", "Scatter", "", 2, |row| scatter(&row.name).map(|row| row.scatter))
        .optional("verdict", "Verdict", |row| row.verdict.as_ref().map(|verdict| verdict.level.name()))
        .done()
}

/// Table and figure of one coefficient.
fn one_coefficient(contents: &Contents<'_>, coefficient: &str) -> Vec<Block> {
    let results = contents.results;
    let table = tables::derivative_summary(results)
        .only("coefficient", |cell| *cell == Cell::Symbol(coefficient.to_owned()))
        .select(&[
            "derivative", "pooled", "standard_error", "corrected_standard_error", "scatter", "windows", "mean",
            "minimum", "maximum", "mean_variance", "minimum_variance", "maximum_variance",
        ]);
    let held = results.derivative_summary.iter().filter(|row| row.coefficient == coefficient);
    let held = held.filter_map(|row| Some(format!(" {}: {}.", notation::derivative(&row.name), row.held?)));
    let caption = format!("Estimated parameters of the {coefficient} model.{}", held.collect::<String>());
    let mut blocks = vec![Block::Table(table.captioned(caption))];
    let of_this = results.derivative_summary.iter().filter(|row| row.coefficient == coefficient && row.windows > 1);
    let panels: Vec<Panel> =
        of_this.filter(|row| !row.name.ends_with("_0")).map(|row| scatter(contents, row)).collect();
    if !panels.is_empty() {
        blocks.push(Block::Figure(Figure::new(
            format!("derivatives {coefficient}"),
            format!("Derivatives of {coefficient} by number of the identification manoeuvre."),
            (3, 26.0),
            panels,
        )));
    }
    blocks
}

/// Estimates of one derivative by window, over the pooled one.
fn scatter(contents: &Contents<'_>, summary: &DerivativeSummaryRow) -> Panel {
    let windows = contents.results.windows.iter().zip(numbers_of(&contents.results.windows));
    let points = windows.filter(|(window, _)| window.role == WindowRole::Identification.name()).filter_map(
        |(window, number)| {
            let row = window.fits.iter().flat_map(|fit| &fit.derivatives).find(|row| row.name == summary.name)?;
            Some([number, row.estimate, NORMAL_95 * row.corrected_standard_error])
        },
    );
    let mut marks = Vec::new();
    if let (Some(value), Some(error)) = (summary.pooled, summary.corrected_standard_error) {
        let band = [value - NORMAL_95 * error, value + NORMAL_95 * error];
        marks.push(Mark::Level { label: "pooled, 95 %".into(), colour: Colour::by_index(1), value, band });
    }
    marks.push(points_with_bars("one manoeuvre, 95 %", points));
    let label = notation::derivative(&summary.name);
    Panel::Plot(Plot { x: Axis::new("manoeuvre", ""), y: Axis::new(label, ""), marks })
}

/// What each coefficient depends on that no flight shows wrong, and its derivative that the position of the accelerometers changes most.
fn stated_values(contents: &Contents<'_>) -> Table {
    let rows =
        contents.results.pooled.iter().filter_map(|fit| Some((fit, fit.follows.as_ref()?, fit.find_most_moved())));
    let caption = "Stated values that flight data cannot verify. Derivatives are proportional to the mass or inertia, \
                   control derivatives also to the inverse of the deflection. Last columns: largest change of a significant \
                   derivative if the accelerometers are 0.1 m further along one axis.";
    TableOf::new("stated_values", caption, rows)
        .symbol("coefficient", "Coefficient", |(fit, ..)| fit.coefficient)
        .text("quantity", "Proportional to", |(_, follows, _)| follows.quantity)
        .number("value", "Value", "", 5, |(_, follows, _)| follows.value)
        .text("unit", "Unit", |(_, follows, _)| follows.unit)
        .text("source", "Source", |(_, follows, _)| follows.source)
        .column(Column::new("derivative", "Most changed"), |(.., moved)| {
            moved.map_or(Cell::Empty, |(row, _)| Cell::Symbol(row.name.clone()))
        })
        .optional("axis", "Accelerometers 0.1 m", |(.., moved)| moved.as_ref()?.1.axis)
        .maybe("change", "Change", "%", 2, |(.., moved)| Some(moved.as_ref()?.1.change_percent))
        .done()
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
        caption: "Pooled estimate of each coefficient; prediction of the validation manoeuvres, if any (mean and smallest with the identified constants, mean with own constants); least certain derivative with its corrected standard error, per radian."
            .to_owned(),
        columns: vec![
            Column::new("coefficient", "Coefficient"),
            Column::new("windows", "Manoeuvres"),
            Column::new("derivatives", "Derivatives"),
            r_squared("r_squared", "R² fit"),
            r_squared("validation_mean", "R² validation"),
            r_squared("validation_least", "lowest"),
            r_squared("validation_own", "own constant"),
            Column::new("derivative", "Least certain derivative"),
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
