//! Clocks of recorders that are merged into one flight, from the quantities that two of them record.

use std::path::PathBuf;

use doublet_core::align::{ClockFitSettings, ClockPair, clock_fit_pairs};
use doublet_core::load::{ManualChannel, Plan, Probe, guess, inspect, read};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::Input;
use doublet_core::series::{Channel, Recording};

use super::Inspected;
use crate::session::{ClockPairSetting, ClockSetting, Flight};
use crate::stage::{FlightPhysics, align, physics_of};

/// Roles of a quantity that two recorders may both have, and the smallest clock offset that it can show, s. Air data and receivers are filtered:
/// their delay of up to 0.5 s is no clock offset.
const SHARED: [(&[Role], f64); 14] = [
    (&[Role::RollRate], FAST_S),
    (&[Role::PitchRate], FAST_S),
    (&[Role::YawRate], FAST_S),
    (&[Role::BankAngle], FAST_S),
    (&[Role::PitchAngle], FAST_S),
    (&[Role::SpecificForceZ], FAST_S),
    (&[Role::SpecificForceY], FAST_S),
    (&[Role::Aileron], FAST_S),
    (&[Role::Elevator], FAST_S),
    (&[Role::Rudder], FAST_S),
    (&[Role::HeadingAngle], SLOW_S),
    (&Role::AIRSPEEDS, SLOW_S),
    (&[Role::VelocityDown], SLOW_S),
    (&[Role::Altitude, Role::GpsAltitude], SLOW_S),
];
/// Smallest shifts that are believed, s.
const FAST_S: f64 = 0.1;
const SLOW_S: f64 = 1.0;
/// Most pairs of channels that a clock is fitted to.
const MOST_PAIRS: usize = 4;
/// Largest standard error of a shift that is believed, s.
const LARGEST_ERROR_S: f64 = 0.5;

/// A recording of `inspected` files on one time line, and the clocks that the quantities recorded twice show to be off.
pub fn align_recorders(inspected: &Inspected, recording: Recording) -> Result<(Recording, Vec<ClockSetting>), String> {
    let clocks = find_clocks(inspected, &recording);
    if clocks.is_empty() {
        return Ok((recording, clocks));
    }
    let flight = Flight { clocks, ..Flight::new(String::new(), Vec::new()) };
    let (aligned, ..) = align(&recording, &flight).map_err(|error| error.to_string())?;
    Ok((aligned, flight.clocks))
}

/// The channels that `plan` reads, on one time line and against each other, with the clocks of recorders that were found to be off.
pub fn read_and_compare(
    inspected: &Inspected,
    plan: &Plan,
) -> Result<(Recording, FlightPhysics, Vec<ClockSetting>), String> {
    let recording = read(plan).map_err(|error| error.to_string())?;
    let (recording, clocks) = align_recorders(inspected, recording)?;
    let physics = physics_of(&recording, "the map");
    Ok((recording, physics, clocks))
}

/// Most recordings that are looked at together before a session is made.
const MOST_RECORDERS: usize = 8;

/// Whether recordings are of recorders of one flight: no two of them have all rates and specific forces, together they have them.
pub fn are_of_one_flight(paths: &[PathBuf]) -> Result<bool, String> {
    if !(2..=MOST_RECORDERS).contains(&paths.len()) {
        return Ok(false);
    }
    let probes: Result<Vec<Probe>, String> =
        paths.iter().map(|path| inspect(path).map_err(|error| error.to_string())).collect();
    Ok(is_one_flight(&probes?))
}

/// The same of recordings that were looked at.
pub(super) fn is_one_flight(probes: &[Probe]) -> bool {
    let has_inputs = |probes: &[Probe]| {
        let guess = guess(probes);
        Input::ALL.iter().all(|input| guess.row(input.role()).is_some())
    };
    match probes.iter().filter(|probe| has_inputs(std::slice::from_ref(probe))).take(2).count() {
        0 => has_inputs(probes),
        complete => complete == 1,
    }
}

/// A recorder: its only source with roles and the roles its channels would play alone.
struct Recorder {
    source: String,
    rows: Vec<(Role, ManualChannel)>,
}

impl Recorder {
    /// None where the file holds several sources, which share the clock of its recorder.
    fn read(probe: &Probe) -> Option<Self> {
        let [source] = probe.sources.as_slice() else { return None };
        let rows = guess(std::slice::from_ref(probe)).rows;
        Some(Self { source: source.name.clone(), rows })
    }

    fn row(&self, roles: &[Role]) -> Option<&ManualChannel> {
        self.rows.iter().find(|(role, _)| roles.contains(role)).map(|(_, row)| row)
    }

    /// Channels of the quantities that this one and another record, with the smallest shift that is believed of each.
    fn pairs_with<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = (&'a ManualChannel, &'a ManualChannel, f64)> {
        SHARED.iter().filter_map(|(roles, least_s)| Some((self.row(roles)?, other.row(roles)?, *least_s)))
    }
}

/// Clocks of the recorders of one flight that shared quantities show to be off the time line, which is that of the recorder that shares most
/// quantities with the others. The session fits them anew to the same channels. None where the recordings are one file or share nothing.
fn find_clocks(inspected: &Inspected, recording: &Recording) -> Vec<ClockSetting> {
    if inspected.probes.len() < 2 {
        return Vec::new();
    }
    let recorders: Vec<Recorder> = inspected.probes.iter().filter_map(Recorder::read).collect();
    let partners = |own: &Recorder| {
        recorders.iter().filter(|other| other.source != own.source && own.pairs_with(other).next().is_some()).count()
    };
    // The first of those that share most.
    let Some(reference) = recorders.iter().rev().max_by_key(|recorder| partners(recorder)) else { return Vec::new() };
    let is_open =
        |other: &&Recorder| other.source != reference.source && !inspected.trusted_clocks.contains(&other.source);
    let others = recorders.iter().filter(is_open);
    others.filter_map(|other| find_clock(reference, other, recording)).collect()
}

fn find_clock(reference: &Recorder, other: &Recorder, recording: &Recording) -> Option<ClockSetting> {
    let channel = |row: &ManualChannel| -> Option<&Channel> {
        let is_it = |channel: &&Channel| channel.source == row.from.source && channel.name == row.from.channel;
        recording.channels.iter().find(is_it)
    };
    let mut setting = ClockSetting::new(&other.source);
    let (mut pairs, mut least_s) = (Vec::new(), f64::INFINITY);
    for (own, theirs, least_of_pair_s) in reference.pairs_with(other) {
        let (Some(reference), Some(channel)) = (channel(own), channel(theirs)) else { continue };
        let inverted = own.turned != theirs.turned;
        let pair = ClockPair { name: "shared", reference: &reference.series, other: &channel.series, inverted };
        // Slow quantities where no fast one does; what does not move, or one of them has otherwise, says nothing.
        let is_enough = pairs.len() == MOST_PAIRS || least_of_pair_s > least_s;
        if is_enough || clock_fit_pairs(&[pair], &ClockFitSettings::default()).is_err() {
            continue;
        }
        pairs.push(pair);
        least_s = least_s.min(least_of_pair_s);
        let path = |channel: &Channel| format!("{}/{}", channel.source, channel.name);
        setting.fit.push(ClockPairSetting { reference: path(reference), other: path(channel), inverted });
    }
    let estimate = clock_fit_pairs(&pairs, &ClockFitSettings::default()).ok()?;
    let (own_s, error_s) = estimate.best_known;
    let shift_s = estimate.model.reference_s(own_s) - own_s;
    // Where the search of the session starts, which finds the rest.
    setting.offset_s = (10.0 * shift_s).round() / 10.0;
    (error_s < LARGEST_ERROR_S && shift_s.abs() > least_s).then_some(setting)
}
