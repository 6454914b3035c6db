//! What was done to the signals of a flight, and what the flight proposes.

use serde::Serialize;

use crate::notation::significant;
use crate::session::{AngularAcceleration, Preparation, Session};
use crate::snapshot::Snapshot;
use crate::stage::{FlightNoise, FlightProposals, LoadedFlight, TreatedSignal};

/// A signal that was smoothed or resampled.
#[derive(Clone, Debug, Serialize)]
pub struct SignalRow {
    pub role: &'static str,
    /// Recorded channel, `source/name`.
    pub recorded: String,
    /// Treatment, in order.
    pub steps: Vec<String>,
    /// Samples as recorded.
    pub samples_recorded: usize,
    /// Samples as used.
    pub samples: usize,
    /// Segments between gaps, each treated separately.
    pub stretches: usize,
}

/// Noise of an input or measurement over steady parts.
#[derive(Clone, Debug, Serialize)]
pub struct NoiseRow {
    /// Entry of Q or R.
    pub entry: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Standard deviation the filter used, SI.
    pub used: f64,
    /// Standard deviation proposed, SI; absent without a proposal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proposed: Option<f64>,
    /// Source of the proposal, or why it is absent.
    pub origin: String,
    /// Reason of the value used, if the session states one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Standard deviation about the trend of each steady part, SI; absent like the next without samples in them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviation: Option<f64>,
    /// Samples used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples: Option<usize>,
    /// Correlation of successive residuals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lag_one: Option<f64>,
    /// Probability that white noise looks less white.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub whiteness: Option<f64>,
}

/// A manoeuvre found in the control deflections.
#[derive(Clone, Debug, Serialize)]
pub struct ProposalRow {
    /// Proposed name.
    pub name: String,
    /// First instant, s.
    pub start_s: f64,
    /// Last instant, s.
    pub end_s: f64,
    /// Surface moved, `several` for more than one.
    pub surface: &'static str,
    /// Shape of the input.
    pub kind: String,
    /// From 0 to 1.
    pub confidence: f64,
    /// Manoeuvre of the session that covers it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<String>,
}

/// The differentiation of rates in words.
pub fn differentiation(preparation: &Preparation) -> String {
    match preparation.angular_acceleration {
        AngularAcceleration::Smoother => return "a smoother with the angular acceleration as a state".to_owned(),
        AngularAcceleration::Recorded => return "recorded angular acceleration".to_owned(),
        AngularAcceleration::Differentiated => {}
    }
    preparation.differentiation_half_width_s.map_or_else(
        || "central difference of order four".to_owned(),
        |half| format!("local quadratic fit over ±{} s", significant(half, 3)),
    )
}

/// One row per treated signal.
pub(crate) fn signal_rows(loaded: &LoadedFlight) -> Vec<SignalRow> {
    loaded.treated.iter().filter_map(|signal| signal_row(loaded, signal)).collect()
}

fn signal_row(loaded: &LoadedFlight, signal: &TreatedSignal) -> Option<SignalRow> {
    let recorded = loaded.recording.channels.get(signal.recorded)?;
    Some(SignalRow {
        role: signal.role.name(),
        recorded: recorded.full_name(),
        steps: signal.steps.clone(),
        samples_recorded: signal.samples[0],
        samples: signal.samples[1],
        stretches: signal.stretches,
    })
}

/// One row per entry of the noise.
fn noise_rows(session: &Session, noise: &FlightNoise) -> Vec<NoiseRow> {
    let rows = noise.rows.iter().map(|row| NoiseRow {
        entry: row.channel.name(),
        unit: row.channel.role().dimension().si_symbol(),
        used: row.channel.std(session),
        proposed: row.proposed(),
        origin: row.origin(),
        reason: session.noise_reasons.get(row.channel.name()).cloned(),
        deviation: row.statistics.map(|found| found.std),
        samples: row.statistics.map(|found| found.samples),
        lag_one: row.statistics.map(|found| found.lag_one),
        whiteness: row.statistics.map(|found| found.whiteness),
    });
    rows.collect()
}

/// One row per manoeuvre found.
fn proposal_rows(session: &Session, proposals: &FlightProposals) -> Vec<ProposalRow> {
    let rows = proposals.windows.iter().map(|proposal| ProposalRow {
        name: proposal.manoeuvre.name.clone(),
        start_s: proposal.manoeuvre.window.start_s,
        end_s: proposal.manoeuvre.window.end_s,
        surface: proposal.manoeuvre.surface_name().unwrap_or("several"),
        kind: proposal.manoeuvre.kind.clone(),
        confidence: proposal.confidence,
        window: proposal.covering_window(session).map(|window| window.name.clone()),
    });
    rows.collect()
}

/// Noise and proposals of one flight, empty where they are not there.
pub fn rows(session: &Session, snapshot: &Snapshot, flight: &str) -> (Vec<NoiseRow>, Vec<ProposalRow>) {
    let noise = snapshot.noise.get(flight).and_then(|slot| slot.ready());
    let proposals = snapshot.proposals.get(flight).and_then(|slot| slot.ready());
    (
        noise.map(|noise| noise_rows(session, noise)).unwrap_or_default(),
        proposals.map(|proposals| proposal_rows(session, proposals)).unwrap_or_default(),
    )
}
