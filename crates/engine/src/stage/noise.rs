//! Noise of every input and measurement over steady parts, and what it proposes for Q and R.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::airframe::instruments::StatedNoise;
use doublet_core::prep::{
    NoiseChoice, NoiseOrigin, NoiseStatistics, NoiseSums, gusts_along_path, noise_proposal, white_noise_deviation,
};
use doublet_core::quantity::{Dimension, Role};
use doublet_core::reconstruct::FilterSettings;
use doublet_core::series::{Recording, TimeRange};
use doublet_core::statistics::median;

use super::{FlightProposals, LoadedFlight};
use crate::graph::{Context, Footprint, Keyed, Stage, StageResult};
use crate::session::{NoiseChannel, NoiseEntry, Session, SteadyWindow};

/// Degree of the trend taken off every window: a steady aircraft still drifts.
const TREND_DEGREE: usize = 2;

/// Noise of a session's flights, shown beside one of them.
#[derive(Clone, Debug, Default)]
pub struct FlightNoise {
    pub windows: Vec<SteadyWindow>,
    /// Whether they were marked by hand; otherwise they were found.
    pub marked: bool,
    /// One row per input and measurement of the filter, over the windows of all flights.
    pub rows: Vec<NoiseRow>,
}

impl Footprint for FlightNoise {
    fn bytes(&self) -> usize {
        300 * (self.windows.len() + self.rows.len())
    }
}

/// Noise of a session's flights, in their order.
#[derive(Debug)]
pub struct SessionNoise(pub Vec<Arc<FlightNoise>>);

impl Footprint for SessionNoise {
    fn bytes(&self) -> usize {
        self.0.iter().map(|noise| noise.bytes()).sum()
    }
}

impl Stage for SessionNoise {
    type Params<'a> = &'a [SteadyWindow];
    type Inputs<'a> = &'a [(&'a str, &'a Keyed<LoadedFlight>, &'a Keyed<FlightProposals>)];
    type Output = Self;
    const NAME: &'static str = "noise";

    fn run(marked: &[SteadyWindow], flights: Self::Inputs<'_>, _: &Context<'_>) -> StageResult<Self> {
        let flights = flights.iter().map(|&(name, loaded, proposals)| NoiseFlight { name, loaded, proposals });
        Ok(Self(noise(&flights.collect::<Vec<_>>(), marked).into_iter().map(Arc::new).collect()))
    }
}

/// Noise of one input or measurement.
#[derive(Clone, Debug)]
pub struct NoiseRow {
    /// Entry of Q or R.
    pub channel: NoiseChannel,
    /// What the windows show; `None` where nothing was recorded in them.
    pub statistics: Option<NoiseStatistics>,
    /// What is proposed, or why nothing is.
    pub choice: Result<NoiseChoice, String>,
}

impl NoiseRow {
    /// The standard deviation proposed, SI, where one is.
    pub fn proposed(&self) -> Option<f64> {
        self.choice.as_ref().ok().map(|choice| choice.proposed)
    }

    /// Where the proposal comes from, or why there is none, in words.
    pub fn origin(&self) -> String {
        match self.choice.as_ref().map(|choice| &choice.origin) {
            Ok(NoiseOrigin::Windows(found)) => {
                format!("{} samples of {} steady parts", found.samples, found.windows)
            }
            Ok(NoiseOrigin::Resolution(_)) => "resolution of the recorder over the root of 12".to_owned(),
            Ok(NoiseOrigin::Stated(source)) => source.clone(),
            Ok(NoiseOrigin::Differences) => "second differences of the whole recording".to_owned(),
            Ok(NoiseOrigin::Gusts) => "gusts along the path: a flow vane is not recorded".to_owned(),
            Err(reason) => format!("none: {reason}"),
        }
    }

    /// Whether the recordings themselves say so.
    pub fn is_measured(&self) -> bool {
        matches!(
            self.choice.as_ref().map(|it| &it.origin),
            Ok(NoiseOrigin::Windows(_) | NoiseOrigin::Resolution(_) | NoiseOrigin::Differences | NoiseOrigin::Gusts)
        )
    }
}

/// A flight whose noise is taken.
#[derive(Clone, Copy, Debug)]
pub struct NoiseFlight<'a> {
    pub name: &'a str,
    /// Its content.
    pub loaded: &'a LoadedFlight,
    /// Steady parts found in it, and why there are none.
    pub proposals: &'a FlightProposals,
}

/// Noise of all flights together, each over the windows marked in the session for it, or over those found; one result per flight with
/// its own windows and the rows they share.
pub fn noise(flights: &[NoiseFlight<'_>], marked: &[SteadyWindow]) -> Vec<FlightNoise> {
    let mut found: Vec<FlightNoise> = flights.iter().map(|flight| windows_of(flight, marked)).collect();
    // Of several flights that state a role's noise the first counts.
    let stated = flights.iter().rev().flat_map(|flight| &flight.loaded.stated_noise);
    let stated: BTreeMap<Role, &StatedNoise> = stated.map(|(role, noise)| (*role, noise)).collect();
    let row = |channel: NoiseChannel| {
        let role = channel.role();
        let measured = measure(role, flights, &found);
        let choice = noise_proposal(measured.as_ref().map_err(ToString::to_string), stated.get(&role).copied());
        let choice = choice.or_else(|reason| propose_by_differences(channel, flights).ok_or(reason));
        let gusts = (role == Role::TrueAirspeed).then(|| propose_gusts(choice.as_ref().ok(), flights)).flatten();
        let choice = gusts.map_or(choice, Ok);
        NoiseRow { channel, statistics: measured.ok(), choice }
    };
    let rows: Vec<NoiseRow> = NoiseChannel::all().map(row).collect();
    found.iter_mut().for_each(|noise| noise.rows.clone_from(&rows));
    found
}

fn windows_of(flight: &NoiseFlight<'_>, marked: &[SteadyWindow]) -> FlightNoise {
    let own: Vec<SteadyWindow> = marked.iter().filter(|steady| steady.flight == flight.name).cloned().collect();
    let marked = !own.is_empty();
    let windows = if marked { own } else { flight.proposals.steady.clone() };
    FlightNoise { windows, marked, rows: Vec::new() }
}

/// Part of the built-in deviation below which second differences do not show the error of a channel: what an instrument filters is smooth
/// and may still be wrong.
const LEAST_PART: f64 = 0.1;

/// The proposal by second differences of the whole recordings: the median of the flights.
fn propose_by_differences(channel: NoiseChannel, flights: &[NoiseFlight<'_>]) -> Option<NoiseChoice> {
    let role = channel.role();
    let deviation = |flight: &NoiseFlight<'_>| {
        let series = &channel_of(&flight.loaded.recording, role)?.series;
        white_noise_deviation(series, role.dimension() == Dimension::Angle)
    };
    let least = LEAST_PART * built_in(channel);
    let found = flights.iter().filter_map(deviation).filter(|deviation| *deviation >= least);
    let proposed = median(&mut found.collect::<Vec<_>>())?;
    Some(NoiseChoice { proposed, origin: NoiseOrigin::Differences })
}

/// Least noise of the airspeed over the gusts along the path.
const LEAST_OVER_GUSTS: f64 = 2.0;

/// The gusts along the path as noise of the airspeed, for flights without both flow vanes whose instruments do not state it; none where more
/// is known. The filter would explain these gusts by velocities across the path, which no other measurement shows there: its flow angles
/// would then be wrong by many times what the gusts are.
fn propose_gusts(known: Option<&NoiseChoice>, flights: &[NoiseFlight<'_>]) -> Option<NoiseChoice> {
    let lacks_vane = |flight: &&NoiseFlight<'_>| {
        [Role::AngleOfAttack, Role::Sideslip].iter().any(|vane| flight.loaded.recording.role(*vane).is_none())
    };
    let gusts = flights.iter().filter(lacks_vane).filter_map(|flight| gusts_along_path(&flight.loaded.recording));
    let proposed = median(&mut gusts.map(|gusts| LEAST_OVER_GUSTS * gusts).collect::<Vec<_>>())?;
    let keeps = |known: &NoiseChoice| known.proposed >= proposed || matches!(known.origin, NoiseOrigin::Stated(_));
    (!known.is_some_and(keeps)).then_some(NoiseChoice { proposed, origin: NoiseOrigin::Gusts })
}

/// Standard deviation of an entry in the built-in settings.
fn built_in(channel: NoiseChannel) -> f64 {
    let settings = FilterSettings::default();
    match channel {
        NoiseChannel::Input(input) => settings.process_noise[input as usize],
        NoiseChannel::Measurement(measurement) => settings.measurement_noise[measurement as usize],
    }
}

/// What the windows of all flights that speak for a role show of it.
fn measure(role: Role, flights: &[NoiseFlight<'_>], found: &[FlightNoise]) -> StageResult<NoiseStatistics> {
    let mut sums = NoiseSums::new(TREND_DEGREE);
    let (mut is_recorded, mut has_windows) = (false, false);
    for (flight, noise) in flights.iter().zip(found) {
        let Some(channel) = channel_of(&flight.loaded.recording, role) else { continue };
        is_recorded = true;
        let speaks = |steady: &&SteadyWindow| steady.roles.is_empty() || steady.roles.contains(&role);
        let own: Vec<TimeRange> = noise.windows.iter().filter(speaks).map(|steady| steady.window).collect();
        has_windows |= !own.is_empty();
        sums.add(&channel.series, &own)?;
    }
    let refused = || flights.iter().find_map(|flight| flight.proposals.no_steady.clone());
    match (is_recorded, has_windows) {
        (false, _) => Err("not recorded".into()),
        (true, false) => Err(refused().unwrap_or_else(|| "no steady part has its samples".to_owned()).into()),
        (true, true) => Ok(sums.statistics()?),
    }
}

/// The channel of a role. Without a satellite position the pressure altitude tells the height.
fn channel_of(recording: &Recording, role: Role) -> Option<&doublet_core::series::Channel> {
    match role {
        Role::PositionDown => recording.role(role).or_else(|| recording.role(Role::Altitude)),
        _ => recording.role(role),
    }
}

/// The entries that steady parts or second differences give, and those stated whose channel was recorded in the windows; without what the
/// session has set for a reason of its own.
pub fn open_entries(session: &Session, noise: &FlightNoise) -> Vec<NoiseEntry> {
    let recorded = noise.rows.iter().filter(|row| row.statistics.is_some() || row.is_measured());
    let open = recorded.filter(|row| !session.noise_reasons.contains_key(row.channel.name()));
    open.filter_map(|row| Some(NoiseEntry { channel: row.channel, std: row.proposed()? })).collect()
}
