//! `doublet lags`: lag and delay of every control by the fit, taken into the session where asked.

use clap::Args;
use doublet_engine::session::{self, Edit, EstimationEdit, Surface};
use doublet_engine::study::{LagKind, Study};

use crate::run::computed;
use crate::study::{StudyArguments, shown};
use crate::text;

#[derive(Debug, Args)]
pub struct LagArguments {
    /// Options of every study.
    #[command(flatten)]
    pub study: StudyArguments,
    /// Save the result to the session: CONTROL=delay or CONTROL=lag.
    #[arg(long, value_name = "CONTROL=KIND", value_parser = taken)]
    pub take: Vec<(Surface, LagKind)>,
}

/// Reads `CONTROL=KIND`.
pub fn taken(text: &str) -> Result<(Surface, LagKind), String> {
    let (control, kind) = text.split_once('=').ok_or("write it as CONTROL=KIND, for example elevator=delay")?;
    let surface = Surface::from_name(control.trim());
    let surface = surface.ok_or_else(|| format!("control '{control}' not found: use elevator, aileron or rudder"))?;
    let kind = match kind.trim() {
        "delay" => LagKind::Delay,
        "lag" => LagKind::FirstOrder,
        other => return Err(format!("'{other}' is neither delay nor lag")),
    };
    Ok((surface, kind))
}

/// Finds lags and delays, prints them, takes those asked for.
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
