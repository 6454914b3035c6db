//! `doublet lags`: lag and delay of every control by the fit, taken into the session where asked.

use doublet_engine::report::StudyResults;
use doublet_engine::session::{self, Edit, EstimationEdit, Surface};
use doublet_engine::study::{LagKind, Study};

use crate::arguments::LagArguments;
use crate::run::computed;
use crate::study::shown;
use crate::text;

/// Reads `CONTROL=KIND`.
pub fn taken(text: &str) -> Result<(Surface, LagKind), String> {
    let (control, kind) = text.split_once('=').ok_or("write it as CONTROL=KIND, for example elevator=delay")?;
    let surface = Surface::ALL.into_iter().find(|surface| surface.name() == control.trim());
    let surface = surface.ok_or_else(|| format!("control '{control}' not found: use elevator, aileron or rudder"))?;
    let kind = match kind.trim() {
        "delay" => LagKind::Delay,
        "lag" => LagKind::FirstOrder,
        other => return Err(format!("'{other}' is neither delay nor lag")),
    };
    Ok((surface, kind))
}

/// Finds lags and delays, prints them, takes those asked for.
///
/// # Errors
/// One line: what is wrong with the session, its windows, or with what is to be taken.
pub fn lags(arguments: &LagArguments) -> Result<(), String> {
    let (session, snapshot) = computed(&arguments.study.session, &[Study::Lags])?;
    shown(Study::Lags, &session, &snapshot, &arguments.study)?;
    if arguments.take.is_empty() {
        return Ok(());
    }
    let found = snapshot.studies.lags.ready().ok_or("lags were not determined")?;
    let mut next = session;
    for &(surface, kind) in &arguments.take {
        let name = format!("{} of the {}", kind.name(), surface.name());
        let row =
            found.get(surface, kind).ok_or_else(|| format!("{name}: no coefficient has a term of this control"))?;
        let (value_s, _) = row.found_s().map_err(|error| format!("{name}: {error}"))?;
        let lag = kind.set(next.preparation.control_lags.get(surface), value_s);
        let edit = Edit::Estimation(EstimationEdit::ControlLag(surface, lag));
        next = edit.apply(&next).map_err(|error| error.to_string())?;
    }
    session::save(&next, &arguments.study.session).map_err(|error| error.to_string())?;
    text::line(&format!(
        "{} now has the control lags: {}; the old file is kept as *.bak",
        arguments.study.session.display(),
        next.preparation.control_lags.summary()
    ));
    Ok(())
}

/// Prints what was found.
pub fn print(results: &StudyResults) {
    let milliseconds = |seconds: f64, digits| text::number(1000.0 * seconds, digits);
    let cells = results.lags.iter().map(|row| {
        vec![
            format!("{} of {}", row.kind, row.control),
            if row.coefficient.is_empty() { "all" } else { row.coefficient }.to_owned(),
            milliseconds(row.value_s, 3),
            milliseconds(row.standard_error_s, 2),
            text::number(row.r_squared, 6),
            row.error.clone().unwrap_or_default(),
        ]
    });
    text::table(&["", "from", "ms", "std error", "R2", ""], &cells.collect::<Vec<_>>());
}
