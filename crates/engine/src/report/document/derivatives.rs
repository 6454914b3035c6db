//! Sections on the aerodynamic model.

use super::{Axis, Block, Colour, Contents, Figure, LineStyle, Mark, Matrix, Panel, Plot, numbers_of, paragraph};
use crate::notation;
use crate::report::results::{DerivativeSummaryRow, FitRow};
use crate::report::table::{Cell, Column, Table};
use crate::report::tables;
use crate::session::{PooledConstants, WindowRole};

/// Magnitude of a correlation from which on two parameters are said to move together.
const CLOSE: f64 = 0.9;
/// Quantile of the normal distribution for 95 % intervals.
const NORMAL_95: f64 = 1.96;

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
        PooledConstants::PerWindow => "The pooled estimate has one constant per manoeuvre.",
        PooledConstants::Common => "The pooled estimate has one constant for all manoeuvres.",
    };
    let mut blocks = vec![Block::Facts(formulas.collect()), Block::Paragraph(format!("{surfaces} {constants}"))];
    let known = session.estimation.constraints.iter();
    let known: Vec<_> =
        known.map(|known| format!("{} {}", notation::derivative(&known.derivative()), known.words())).collect();
    if !known.is_empty() {
        let words = "Known beforehand: ".to_owned() + &known.join(", ");
        blocks.push(Block::Paragraph(format!(
            "{words}. Derivatives that are fixed or at a bound have no standard error; priors are weighted against white residuals."
        )));
    }
    let fits: Vec<&FitRow> = results.pooled.iter().filter(|fit| fit.error.is_none()).collect();
    let panels: Vec<Panel> = fits.iter().map(|fit| correlation(fit)).collect();
    if !panels.is_empty() {
        blocks.push(Block::Figure(Figure {
            name: "correlation".to_owned(),
            caption:
                "Correlation of the parameters in the pooled estimate, without the constants of single manoeuvres."
                    .to_owned(),
            columns: 3,
            panel_height_mm: 40.0,
            panels,
        }));
    }
    let pairs = close_pairs(&fits);
    blocks.push(if pairs.rows.is_empty() {
        Block::Paragraph(format!("No two derivatives are correlated by {CLOSE} or more."))
    } else {
        Block::Table(pairs)
    });
    let quality = tables::fits(results).only("window", |cell| *cell == Cell::text("pooled")).select(&[
        "coefficient",
        "samples",
        "r_squared",
        "rms_relative_percent",
        "residual_deviation",
        "condition_number",
    ]);
    if !quality.rows.is_empty() {
        blocks.push(Block::Table(quality.captioned("Quality of the pooled fits.")));
    }
    blocks
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
        caption: format!("Derivatives with a correlation of {CLOSE} or more: they cannot be separated."),
        columns: vec![
            Column::new("first", "Derivative"),
            Column::new("second", "with"),
            Column::number("correlation", "Correlation", "", 3),
        ],
        rows,
    }
}

/// One table and one figure per coefficient (thesis Tables 6.4 to 6.9).
pub fn derivatives(contents: &Contents<'_>) -> Vec<Block> {
    let results = contents.results;
    if results.derivative_summary.is_empty() {
        return vec![paragraph("No estimate.")];
    }
    let mut blocks = vec![paragraph(
        "Pooled: estimate from all identification manoeuvres, with the standard error for white residuals and the one corrected for correlated residuals. Scatter: standard deviation of the single-manoeuvre estimates. Mean, minimum, maximum and variances are those of single manoeuvres.",
    )];
    let mut coefficients: Vec<&str> = results.derivative_summary.iter().map(|row| row.coefficient).collect();
    coefficients.dedup();
    for coefficient in coefficients {
        let table = tables::derivative_summary(results)
            .only("coefficient", |cell| *cell == Cell::Symbol(coefficient.to_owned()))
            .select(&[
                "derivative",
                "pooled",
                "standard_error",
                "corrected_standard_error",
                "scatter",
                "windows",
                "mean",
                "minimum",
                "maximum",
                "mean_variance",
                "minimum_variance",
                "maximum_variance",
            ]);
        let held = contents.results.derivative_summary.iter().filter(|row| row.coefficient == coefficient);
        let held = held.filter_map(|row| Some(format!(" {}: {}.", notation::derivative(&row.name), row.held?)));
        let caption = format!("Estimated parameters of the {coefficient} model.{}", held.collect::<String>());
        blocks.push(Block::Table(table.captioned(caption)));
        let of_this = results.derivative_summary.iter().filter(|row| row.coefficient == coefficient && row.windows > 1);
        let panels: Vec<Panel> =
            of_this.filter(|row| !row.name.ends_with("_0")).map(|row| scatter(contents, row)).collect();
        if !panels.is_empty() {
            blocks.push(Block::Figure(Figure {
                name: format!("derivatives {coefficient}"),
                caption: format!("Derivatives of {coefficient} by number of the identification manoeuvre."),
                columns: 3,
                panel_height_mm: 26.0,
                panels,
            }));
        }
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
        marks.push(Mark::Level { label: "pooled, 95 %".into(), colour: Colour::of(1), value, band });
    }
    marks.push(Mark::Points {
        label: "one manoeuvre, 95 %".into(),
        colour: Colour::of(0),
        style: LineStyle::Dots,
        points: points.collect(),
    });
    let label = notation::derivative(&summary.name);
    Panel::Plot(Plot { x: Axis::new("window", ""), y: Axis::new(label, ""), marks })
}
