//! Rows of the engines over each flight.

use doublet_core::propulsion::PowerComparison;

use super::results::{AgreementRow, CorrelationRow, EngineRow, MonitorRow, PhaseRow};
use crate::session::Session;
use crate::snapshot::Snapshot;
use crate::stage::{EngineOverFlight, FlightEngines, PowerAgreement};

/// One row per flight and engine, in the order of the session.
pub fn rows(session: &Session, snapshot: &Snapshot) -> Vec<EngineRow> {
    let flights = session
        .flights
        .iter()
        .filter_map(|flight| Some((flight.name.as_str(), snapshot.engines.get(&flight.name)?.ready()?)));
    flights.flat_map(|(name, found)| found.engines.iter().map(move |engine| row(name, found, engine))).collect()
}

fn row(flight: &str, found: &FlightEngines, engine: &EngineOverFlight) -> EngineRow {
    let own = found.warnings.iter().filter(|(name, _)| name.as_ref().is_none_or(|name| *name == engine.name));
    let (samples, mean_power_w) = mean(&engine.power_w.values);
    EngineRow {
        flight: flight.to_owned(),
        engine: engine.name.clone(),
        samples,
        mean_power_w,
        mean_thrust_n: mean(&engine.thrust_n.values).1,
        monitor: engine.agreement.as_ref().map(|agreement| monitor(found, agreement)),
        warnings: own.map(|(_, warning)| warning.to_string()).collect(),
    }
}

/// Number and mean of the finite values.
fn mean(values: &[f64]) -> (usize, f64) {
    let finite = || values.iter().filter(|value| value.is_finite());
    let samples = finite().count();
    (samples, finite().sum::<f64>() / samples as f64)
}

fn monitor(found: &FlightEngines, agreement: &PowerAgreement) -> MonitorRow {
    let correlations = agreement.correlations.iter().map(|correlation| CorrelationRow {
        variable: correlation.variable.clone(),
        coefficient: correlation.coefficient,
    });
    let phases = found.phases.iter().zip(&agreement.phases).map(|(phase, row)| PhaseRow {
        phase: phase.name.clone(),
        start_s: phase.window.start_s,
        end_s: phase.window.end_s,
        agreement: agreement_row(&row.comparison),
    });
    MonitorRow {
        whole: agreement_row(&agreement.whole),
        correlations: correlations.collect(),
        phases: phases.collect(),
    }
}

fn agreement_row(comparison: &PowerComparison) -> AgreementRow {
    AgreementRow {
        samples: comparison.samples,
        mean_modelled_w: comparison.mean_modelled_w,
        mean_monitor_w: comparison.mean_monitor_w,
        r_squared: comparison.r_squared,
        rms_w: comparison.rms_w,
    }
}
