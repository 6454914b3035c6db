//! What a run says on the terminal: the verdict, the fits with their derivatives and what to look at first, or everything.

use doublet_core::model::is_constant_name;
use doublet_engine::report::{self, DerivativeRow, EngineRow, FitRow, Results};
use doublet_engine::run::Snapshot;
use doublet_engine::session::Session;
use doublet_engine::verdict::{self, Folded, Level};

use crate::text;

/// Things to look at that are named; the others are counted.
const NAMED: usize = 3;
/// Width of a line of derivatives.
const WIDTH: usize = 110;
const FINDING_WIDTH: usize = 150;

/// Prints the verdict, every coefficient and what to look at; with `verbose` everything that was found.
pub fn print(session: &Session, snapshot: &Snapshot, verbose: bool) {
    let results = report::build(session, snapshot);
    let found = verdict::folded(session, snapshot);
    if verbose {
        print_all(&results);
        text::line("");
        for line in &found {
            let lines = text::wrapped(&format!("{}: {line}", name(line.level)), FINDING_WIDTH);
            lines.iter().for_each(|line| text::line(line));
        }
        text::line("");
    }
    if let Some(verdicts) = snapshot.verdicts.ready() {
        text::line(&format!("verdict {}", verdicts.headline()));
    }
    if let Some(words) = report::applied_delays(&results.sensor_delays) {
        text::line(&format!("delays applied: {words}"));
    }
    if let Some(gusts) = results.gusts.as_ref().filter(|gusts| gusts.applied) {
        text::line(&format!("gusts {}", gusts.summary()));
    }
    if !verbose {
        if !results.pooled.is_empty() {
            text::line("derivatives ± corrected standard error (1 sigma), angles in rad; ! caution, !! bad");
        }
        results.pooled.iter().for_each(|fit| print_fit(fit, &results));
        print_stated_quantities(&results);
        print_accelerometer_position(&results);
        print_first(&found);
    }
}

fn name(level: Level) -> &'static str {
    if level == Level::Good { "note" } else { level.name() }
}

/// One coefficient: its verdict, how well it fits and predicts, and its derivatives with their corrected errors.
fn print_fit(fit: &FitRow, results: &Results) {
    let level = fit.verdict.as_ref().map_or("-", |verdict| verdict.level.name());
    let head = format!("{} {level}", fit.coefficient);
    if let Some(error) = &fit.error {
        text::line(&format!("{head}: no estimate, {error}"));
        return;
    }
    let validation = results.validation.iter().find(|row| row.coefficient == fit.coefficient);
    let validation =
        validation.map(|row| format!(", validation {}", text::number(row.agreement.r_squared_identified_constants, 3)));
    let dropped: Vec<&str> = fit.dropped.iter().map(|term| term.name.as_str()).collect();
    let dropped = if dropped.is_empty() { String::new() } else { format!("; dropped {}", dropped.join(", ")) };
    text::line(&format!(
        "{head}: R2 {}{} from {}{dropped}",
        text::number(fit.r_squared, 4),
        validation.unwrap_or_default(),
        windows(&fit.windows)
    ));
    // Constants are trim, not derivatives; the tables have them.
    let shared = fit.derivatives.iter().filter(|row| !is_constant_name(&row.name));
    let mut line = String::from(" ");
    for cell in shared.map(derivative) {
        if line.chars().count() + cell.chars().count() > WIDTH {
            text::line(&line);
            line = String::from(" ");
        }
        line.push_str(&format!(" {cell}"));
    }
    if line.len() > 1 {
        text::line(&line);
    }
}

/// Stated numbers that the derivatives follow one to one: no flight shows them wrong.
fn print_stated_quantities(results: &Results) {
    let mut by_text: Vec<(String, Vec<&str>)> = Vec::new();
    let mut source = None;
    for (fit, follows) in results.pooled.iter().filter_map(|fit| Some((fit, fit.follows.as_ref()?))) {
        source = source.or(Some(follows.source));
        let text = follows.to_string();
        match by_text.iter_mut().find(|(other, _)| *other == text) {
            Some((_, coefficients)) => coefficients.push(fit.coefficient),
            None => by_text.push((text, vec![fit.coefficient])),
        }
    }
    let parts: Vec<String> =
        by_text.iter().map(|(text, coefficients)| format!("{} {text}", coefficients.join(" "))).collect();
    if let Some(source) = source {
        text::line(&format!("derivatives proportional to: {} ({source})", parts.join(", ")));
    }
}

/// Force derivatives that change most with the stated position of the accelerometers.
fn print_accelerometer_position(results: &Results) {
    /// Smallest change that is printed, per cent.
    const LEAST_PERCENT: f64 = 5.0;
    let moved = results.pooled.iter().filter_map(FitRow::find_most_moved);
    let moved = moved.filter(|(_, dependence)| dependence.change_percent.abs() >= LEAST_PERCENT);
    let parts: Vec<String> = moved
        .map(|(row, dependence)| {
            let axis = dependence.axis.unwrap_or_default();
            format!("{} {:+.0} % ({axis})", row.name, dependence.change_percent)
        })
        .collect();
    if !parts.is_empty() {
        text::line(&format!("sensitivity to 0.1 m of accelerometer position: {}", parts.join(", ")));
    }
}

fn derivative(row: &DerivativeRow) -> String {
    let error = match row.held {
        Some(held) if row.corrected_standard_error.is_nan() => format!("({held})"),
        _ => format!("± {}", text::number(row.corrected_standard_error, 2)),
    };
    let mark = match row.verdict.as_ref().map(|verdict| verdict.level) {
        Some(Level::Bad) => " !!",
        Some(Level::Caution) => " !",
        _ => "",
    };
    format!("{} {} {error}{mark} ", row.name, text::number(row.estimate, 4))
}

/// What speaks against the results, the worst first, and one note: an offset of the sideslip, otherwise the most frequent advice of
/// the innovations.
fn print_first(found: &[Folded]) {
    let against: Vec<&Folded> = found.iter().filter(|line| line.level > Level::Good).collect();
    let noted = |code: &str| found.iter().find(|line| line.code == code);
    let notes = noted("sideslip-offset").or_else(|| noted("innovation-advice"));
    let shown: Vec<&Folded> = against.iter().copied().take(NAMED).chain(notes).take(NAMED + 1).collect();
    if shown.is_empty() {
        return;
    }
    let others = match found.len() - shown.len() {
        0 => String::new(),
        others => format!(" ({others} more with --verbose)"),
    };
    text::line(&format!("main findings{others}"));
    shown.iter().flat_map(|line| in_brief(line)).for_each(|line| text::line(&line));
}

/// A finding and what to do about it, in one line where they fit, else in one line each.
fn in_brief(finding: &Folded) -> Vec<String> {
    let whole = format!("{}: {finding}", name(finding.level));
    let parts = match finding.fix.is_empty() || whole.chars().count() <= FINDING_WIDTH {
        true => vec![("  ", whole)],
        false => {
            let found = format!("{}: {}: {}", name(finding.level), finding.place, finding.text);
            vec![("  ", found), ("    ", finding.fix.clone())]
        }
    };
    let wrapped = |(indent, text): (&'static str, String)| {
        text::wrapped(&text, FINDING_WIDTH - indent.len()).into_iter().map(move |line| format!("{indent}{line}"))
    };
    parts.into_iter().flat_map(wrapped).collect()
}

/// Clocks, engines, windows and derivatives, and every finding.
fn print_all(results: &Results) {
    for flight in &results.flights {
        for clock in &flight.clocks {
            text::line(&format!(
                "{}: clock of {}: offset {} s, drift {} s per s",
                flight.name,
                clock.source,
                text::number(clock.offset_s, 7),
                text::number(clock.drift, 3)
            ));
        }
    }
    results.engines.iter().for_each(engine_summary);
    for window in results.windows.iter().filter(|window| window.samples > 0) {
        text::line(&format!(
            "{}: {} samples, mean NIS {} (expected {})",
            window.name,
            window.samples,
            text::number(window.mean_nis, 4),
            text::number(window.expected_nis, 4)
        ));
        if !window.missing_measurements.is_empty() {
            text::line(&format!("  not measured: {}", window.missing_measurements.join(", ")));
        }
    }
    for fit in results.pooled.iter().filter(|fit| fit.error.is_none()) {
        text::line("");
        text::line(&format!(
            "{} from {}: R2 {}, RMS {} %",
            fit.coefficient,
            windows(&fit.windows),
            text::number(fit.r_squared, 4),
            text::number(fit.rms_relative_percent, 3)
        ));
        // Constants of single windows are trim, not derivatives; the tables have them.
        let shared = fit.derivatives.iter().filter(|row| !row.name.ends_with(']'));
        let rows = shared.map(|row| {
            vec![
                row.name.clone(),
                text::number(row.estimate, 6),
                text::number(row.standard_error, 3),
                text::number(row.corrected_standard_error, 3),
                text::number(row.relative_error_percent, 3),
                row.held.unwrap_or_default().to_owned(),
            ]
        });
        text::table(&["derivative", "estimate", "std error", "corrected", "rel %", ""], &rows.collect::<Vec<_>>());
    }
}

fn engine_summary(engine: &EngineRow) {
    let kilowatts = |watts: f64, digits| text::number(watts / 1000.0, digits);
    let place = format!("{}: engine '{}'", engine.flight, engine.engine);
    text::line(&match &engine.monitor {
        Some(monitor) => format!(
            "{place}: modelled and monitor power: r2 {} (squared correlation), RMS difference {} kW over {} samples",
            text::number(monitor.whole.r_squared, 4),
            kilowatts(monitor.whole.rms_w, 3),
            monitor.whole.samples
        ),
        None => format!("{place}: mean power {} kW over {} samples", kilowatts(engine.mean_power_w, 4), engine.samples),
    });
}

/// Names of the windows, or how many there are.
fn windows(names: &[String]) -> String {
    if names.len() > 3 { format!("{} manoeuvres", names.len()) } else { names.join(", ") }
}
