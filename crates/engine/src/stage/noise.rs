//! Noise of every input and measurement over steady windows, and what it proposes for Q and R.

use std::collections::BTreeMap;

use doublet_core::prep::{NoiseChoice, NoiseOrigin, NoiseStatistics, noise_proposals, noise_statistics};
use doublet_core::quantity::Role;
use doublet_core::series::{Recording, Window};

use crate::graph::Footprint;
use crate::session::{NoiseChannel, NoiseEntry, Session, SteadyWindow};

/// Degree of the trend taken off every window: a steady aircraft still drifts.
const TREND_DEGREE: usize = 2;

/// Noise of a flight.
#[derive(Clone, Debug, Default)]
pub struct FlightNoise {
    /// Windows used.
    pub windows: Vec<SteadyWindow>,
    /// Whether they were marked by hand; otherwise they were found.
    pub marked: bool,
    /// One row per input and measurement of the filter.
    pub rows: Vec<NoiseRow>,
}

impl Footprint for FlightNoise {
    fn bytes(&self) -> usize {
        300 * (self.windows.len() + self.rows.len())
    }
}

/// Noise of one input or measurement.
#[derive(Clone, Debug)]
pub struct NoiseRow {
    /// Entry of Q or R.
    pub channel: NoiseChannel,
    /// What its windows show; `None` where nothing was recorded in them.
    pub statistics: Option<NoiseStatistics>,
    /// What is proposed.
    pub choice: NoiseChoice,
}

impl NoiseRow {
    /// Where the proposal comes from, in words.
    pub fn origin(&self) -> String {
        match &self.choice.origin {
            NoiseOrigin::Windows(found) => {
                format!("{} samples of the {} steady windows that speak for it", found.samples, found.windows)
            }
            NoiseOrigin::Resolution(_) => "resolution of the recorder over the root of 12".to_owned(),
            NoiseOrigin::Published => "thesis Tables 4.15-4.16: no steady samples".to_owned(),
            NoiseOrigin::Judged => "thesis 4.4.3: judged, low rate".to_owned(),
        }
    }

    /// Whether the recording itself says so.
    pub fn is_measured(&self) -> bool {
        matches!(self.choice.origin, NoiseOrigin::Windows(_) | NoiseOrigin::Resolution(_))
    }
}

/// Noise over the windows marked in the session for this flight, or over those found.
pub fn noise(flight: &str, recording: &Recording, marked: &[SteadyWindow], found: &[SteadyWindow]) -> FlightNoise {
    let own: Vec<SteadyWindow> = marked.iter().filter(|steady| steady.flight == flight).cloned().collect();
    let marked = !own.is_empty();
    let windows = if marked { own } else { found.to_vec() };
    let mut measured = BTreeMap::new();
    for channel in NoiseChannel::all() {
        let role = channel.role();
        // Without a satellite position the pressure altitude tells the height.
        let recorded = match role {
            Role::PositionDown => recording.role(role).or_else(|| recording.role(Role::Altitude)),
            _ => recording.role(role),
        };
        let speaks = |steady: &&SteadyWindow| steady.roles.is_empty() || steady.roles.contains(&role);
        let own: Vec<Window> = windows.iter().filter(speaks).map(|steady| steady.window).collect();
        let statistics = recorded.and_then(|channel| noise_statistics(&channel.series, &own, TREND_DEGREE).ok());
        measured.extend(statistics.map(|found| (role, found)));
    }
    let mut proposals = noise_proposals(&measured);
    let rows = NoiseChannel::all().filter_map(|channel| {
        let choice = proposals.remove(&channel.role())?;
        Some(NoiseRow { channel, statistics: measured.get(&channel.role()).copied(), choice })
    });
    FlightNoise { rows: rows.collect(), windows, marked }
}

/// The entries of a flight's noise whose channel was recorded in the windows and that the session has not set for a reason of its
/// own.
pub fn open_entries(session: &Session, noise: &FlightNoise) -> Vec<NoiseEntry> {
    let recorded = noise.rows.iter().filter(|row| row.statistics.is_some());
    let open = recorded.filter(|row| !session.noise_reasons.contains_key(row.channel.name()));
    open.map(|row| NoiseEntry { channel: row.channel, std: row.choice.proposed }).collect()
}
