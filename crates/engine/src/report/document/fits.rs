//! Sections on fits, residuals and predictions.

use doublet_core::series::{Series, TimeRange};

use super::figure::line;
use super::{Axis, Block, Contents, Figure, Mark, Panel, Parts, Plot};
use crate::report::table::Cell;
use crate::report::tables;
use crate::session::{Manoeuvre, PredictionParameters, WindowRole};

/// Fit and residual of every coefficient of every window.
pub fn fits(contents: &Contents<'_>) -> Parts {
    let results = contents.results;
    let summary = tables::residual_summary(results);
    if summary.rows.is_empty() {
        return Parts::default();
    }
    let mut blocks = Vec::new();
    let quality = tables::fits(results).only("window", |cell| *cell != Cell::text("pooled")).select(&[
        "window", "coefficient", "samples", "r_squared", "rms_relative_percent", "residual_deviation", "error",
    ]);
    if !quality.rows.is_empty() {
        blocks.push(Block::Table(quality.captioned("Quality of the fits of single manoeuvres.")));
    }
    for window in contents.session.active_windows() {
        let Some(found) = contents.snapshot.windows.get(&window.name) else { continue };
        let (Some(aero), Some(fits)) = (found.aero.ready(), found.fits.ready()) else { continue };
        let rows = fits.fits.iter().filter_map(|fit| {
            let series = fit.series.as_ref()?;
            let observed = &aero.series[fit.coefficient as usize];
            Some((fit.coefficient.name(), observed, vec![("fit", series.fitted())], &series.residual))
        });
        let caption = format!("{}: measured coefficients, fits of this manoeuvre alone, residuals.", described(window));
        blocks.extend(pairs(format!("fits {}", window.name), (caption, &window.excluded), rows));
    }
    let first = first_figure(&mut blocks);
    Parts { body: std::iter::once(Block::Table(summary)).chain(first).collect(), appendix: blocks }
}

/// Takes the first figure out: the example of the body.
fn first_figure(blocks: &mut Vec<Block>) -> Option<Block> {
    let place = blocks.iter().position(|block| matches!(block, Block::Figure(_)))?;
    Some(blocks.remove(place))
}

/// Predictions of the validation windows by the pooled derivatives (thesis Table 7.1).
pub fn validation(contents: &Contents<'_>) -> Parts {
    let results = contents.results;
    let summary = tables::validation(results);
    let rows =
        tables::predictions(results).only("role", |cell| *cell == Cell::text(WindowRole::Validation.name())).select(&[
            "window",
            "coefficient",
            "r_squared_identified_constants",
            "rms_relative_percent_identified_constants",
            "r_squared_own_constant",
            "rms_relative_percent_own_constant",
        ]);
    if rows.rows.is_empty() {
        return Parts::default();
    }
    let by = match contents.session.estimation.predict_with {
        PredictionParameters::Pooled => "the pooled estimate",
        PredictionParameters::ManoeuvreMeans => "the means over the estimates of single manoeuvres",
    };
    let caption = format!("Prediction of each validation manoeuvre by {by}. {}", tables::CONSTANTS);
    let mut body = vec![Block::Table(summary)];
    let mut blocks = vec![Block::Table(rows.captioned(caption))];
    let Some(pooled) = contents.snapshot.pooled.ready() else { return Parts { body, appendix: blocks } };
    for window in contents.session.windows.iter().filter(|window| window.role == WindowRole::Validation) {
        let Some(aero) = contents.snapshot.windows.get(&window.name).and_then(|found| found.aero.ready()) else {
            continue;
        };
        let predictions = pooled.predictions.iter().filter(|prediction| prediction.window == window.name);
        let predictions: Vec<_> = predictions.map(|prediction| (prediction, prediction.residual())).collect();
        let rows = predictions.iter().map(|(prediction, residual)| {
            let observed = &aero.series[prediction.coefficient as usize];
            let name = prediction.coefficient.name();
            let lines = [("own constant", &prediction.own_constant), ("identified", &prediction.identified)];
            (name, observed, lines.to_vec(), residual)
        });
        let caption = format!(
            "{}: measured coefficients, predictions with own and with identified constant, residuals with the own constant.",
            described(window)
        );
        blocks.extend(pairs(format!("validation {}", window.name), (caption, &window.excluded), rows));
    }
    body.extend(first_figure(&mut blocks));
    Parts { body, appendix: blocks }
}

/// Name and input of a window.
fn described(window: &Manoeuvre) -> String {
    if window.kind.is_empty() || window.name.contains(&window.kind) {
        format!("Manoeuvre {}", window.name)
    } else {
        format!("Manoeuvre {} ({})", window.name, window.kind)
    }
}

/// Observation and model on the left, residual on the right, one row per coefficient, over the parts left out.
fn pairs<'a>(
    name: String,
    (caption, excluded): (String, &[TimeRange]),
    rows: impl Iterator<Item = (&'static str, &'a Series, Vec<(&'static str, &'a Series)>, &'a Series)>,
) -> Option<Block> {
    let panels: Vec<Panel> = rows
        .flat_map(|(coefficient, observed, modelled, residual)| {
            let modelled =
                modelled.into_iter().zip([0, 2]).map(|((name, series), color)| line(name, color, series, 1.0));
            let panel =
                |label: String, marks: Vec<Mark>| Panel::Plot(Plot { x: Axis::time(), y: Axis::new(label, ""), marks });
            [
                panel(
                    coefficient.to_owned(),
                    [line("observed", 1, observed, 1.0)].into_iter().chain(modelled).collect(),
                ),
                panel(format!("Δ{coefficient}"), vec![line("residual", 7, residual, 1.0)]),
            ]
        })
        .collect();
    let figure = Figure::new(name, caption, (2, 22.0), panels);
    (!figure.panels.is_empty()).then(|| Block::Figure(figure.with_excluded(excluded)))
}
