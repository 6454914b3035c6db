//! What a flight itself shows: manoeuvre windows, steady parts, spectra of its signals.

use std::borrow::Cow;
use std::collections::BTreeMap;

use doublet_core::prep::{
    Manoeuvre as Found, ManoeuvreSearch, ManoeuvreSettings, PassedOver, PrepError, Spectrum, SteadySearch,
    SteadySettings, SteadySignal, airborne, find_manoeuvres, find_steady, intersect, spectrum,
};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{Input, Measurement};
use doublet_core::series::{Recording, Series, TimeRange};
use doublet_core::statistics;

use super::LoadedFlight;
use crate::graph::{Context, Footprint, Keyed, Stage, StageResult};
use crate::session::{Manoeuvre, Session, SteadyWindow, Surface};

/// What a flight shows and proposes.
#[derive(Clone, Debug, Default)]
pub struct FlightProposals {
    /// Manoeuvres, in order of time.
    pub windows: Vec<WindowProposal>,
    /// Steady parts: those in flight for inertial samples and air data, those on the ground for attitude and navigation.
    pub steady: Vec<SteadyWindow>,
    /// Spectra of everything that enters the filter and of the control deflections.
    pub spectra: Vec<SignalSpectrum>,
    /// Why something could not be looked for or was not found, one line each.
    pub findings: Vec<String>,
    /// Why there is no steady part, where there is none.
    pub no_steady: Option<String>,
}

impl Footprint for FlightProposals {
    fn bytes(&self) -> usize {
        1000 * (self.windows.len() + self.steady.len()) + 16_000 * self.spectra.len()
    }
}

impl Stage for FlightProposals {
    type Params<'a> = &'a str;
    type Inputs<'a> = &'a Keyed<LoadedFlight>;
    type Output = Self;
    const NAME: &'static str = "proposals";

    fn run(name: &str, flight: &Keyed<LoadedFlight>, _: &Context<'_>) -> StageResult<Self> {
        Ok(proposals(name, flight))
    }
}

/// Spectrum of the signal of a role.
#[derive(Clone, Debug)]
pub struct SignalSpectrum {
    pub role: Role,
    pub recorded: Spectrum,
    /// As smoothed and resampled, where it was.
    pub treated: Option<Spectrum>,
}

/// A manoeuvre window proposed.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowProposal {
    /// The window as it would stand in the session.
    pub manoeuvre: Manoeuvre,
    /// How near its shape is to the ideal and how still the other controls were, from 0 to 1.
    pub confidence: f64,
    /// First movement of the control, s.
    pub onset_s: f64,
    /// Return of the control, s.
    pub input_end_s: f64,
    /// Amplitude with the sign of the first pulse, rad.
    pub amplitude_rad: f64,
    /// Length of the shortest ideal pulse, s.
    pub base_time_s: f64,
}

/// Time by which a manoeuvre may start after its input or end before it without cutting it, s.
const CUT_S: f64 = 0.1;

impl FlightProposals {
    /// The input, of the surface of a manoeuvre where that is stated, that the manoeuvre starts or ends within.
    pub fn cut_input(&self, manoeuvre: &Manoeuvre) -> Option<&WindowProposal> {
        let is_of = |found: &&WindowProposal| {
            let surfaces = manoeuvre.surface.zip(found.manoeuvre.surface);
            found.manoeuvre.flight == manoeuvre.flight && surfaces.is_none_or(|(own, other)| own == other)
        };
        let TimeRange { start_s, end_s } = manoeuvre.window;
        let is_cut = |found: &&WindowProposal| {
            let holds = |time_s: f64| found.onset_s + CUT_S < time_s && time_s < found.input_end_s - CUT_S;
            holds(start_s) || holds(end_s)
        };
        self.windows.iter().filter(is_of).find(is_cut)
    }
}

impl WindowProposal {
    /// The session's window that covers the input of this one already.
    pub fn covering_window<'a>(&self, session: &'a Session) -> Option<&'a Manoeuvre> {
        session.windows.iter().find(|window| {
            window.flight == self.manoeuvre.flight
                && window.window.start_s < self.input_end_s
                && window.window.end_s > self.onset_s
        })
    }
}

/// A proposed window that a session lacks, under a name it does not have yet, and its proposal.
pub type Candidate<'a> = (Manoeuvre, &'a WindowProposal);

/// The proposed windows a session lacks, those it refused among them.
pub fn find_candidates<'a>(session: &Session, proposals: &'a FlightProposals) -> Vec<Candidate<'a>> {
    let mut named: Vec<String> = session.windows.iter().map(|window| window.name.clone()).collect();
    let missing = proposals.windows.iter().filter(|proposal| proposal.covering_window(session).is_none());
    missing
        .map(|proposal| {
            let mut window = proposal.manoeuvre.clone();
            let base = window.name.clone();
            let mut number = 2;
            while named.contains(&window.name) {
                window.name = format!("{base} ({number})");
                number += 1;
            }
            named.push(window.name.clone());
            (window, proposal)
        })
        .collect()
}

/// The candidates that a session has not refused.
pub fn find_open_candidates<'a>(
    session: &Session,
    proposals: &'a FlightProposals,
) -> impl Iterator<Item = Candidate<'a>> {
    find_candidates(session, proposals).into_iter().filter(|(window, _)| !session.has_refused(window))
}

/// The proposed windows that a session neither has nor refused.
pub fn open_windows(session: &Session, proposals: &FlightProposals) -> Vec<Manoeuvre> {
    find_open_candidates(session, proposals).map(|(window, _)| window).collect()
}

/// Share of the median dynamic pressure in flight below which no manoeuvre is proposed: half of the airspeed.
pub const LEAST_PRESSURE_SHARE: f64 = 0.25;

/// Looks through a flight on its time line.
pub fn proposals(flight: &str, loaded: &LoadedFlight) -> FlightProposals {
    proposals_above(flight, loaded, LEAST_PRESSURE_SHARE)
}

/// Looks through a flight on its time line; manoeuvres are proposed above a share of the median dynamic pressure in flight.
pub fn proposals_above(flight: &str, loaded: &LoadedFlight, least_pressure_share: f64) -> FlightProposals {
    let recording = &loaded.recording;
    let mut found = FlightProposals::default();
    match manoeuvres(recording, least_pressure_share) {
        Ok((search, least_airspeed_m_s)) => {
            found.findings.extend(none_found(&search, least_airspeed_m_s));
            let moved = search.found.into_iter().enumerate();
            found.windows = moved.map(|(index, one)| window_proposal(flight, index, one)).collect();
        }
        Err(reason) => found.findings.push(reason.to_string()),
    }
    let inputs: Vec<TimeRange> = found.windows.iter().map(|proposal| proposal.manoeuvre.window).collect();
    match steady(flight, recording, &inputs) {
        Ok((steady, reason)) => (found.steady, found.no_steady) = (steady, reason),
        Err(error) => found.no_steady = Some(format!("steady parts: {error}")),
    }
    found.findings.extend(found.no_steady.clone());
    found.spectra = spectra(loaded);
    found
}

/// The series of some roles without their blanks: a channel slower than its table has one in most rows.
fn sampled<'r>(recording: &'r Recording, roles: &[Role]) -> Vec<(Role, Cow<'r, Series>)> {
    let filled = |(role, series): (Role, &'r Series)| {
        let has_blanks = series.values.iter().any(|value| !value.is_finite());
        (role, if has_blanks { Cow::Owned(series.finite()) } else { Cow::Borrowed(series) })
    };
    series(recording, roles).into_iter().map(filled).collect()
}

/// Manoeuvres of the deflections, and the least airspeed at which they were looked for, where one is recorded.
fn manoeuvres(recording: &Recording, least_pressure_share: f64) -> StageResult<(ManoeuvreSearch, Option<f64>)> {
    let controls = sampled(recording, &[Role::Aileron, Role::Elevator, Role::Rudder]);
    if controls.is_empty() {
        return Err("no manoeuvre search: the recording has no control deflections".into());
    }
    let rates = sampled(recording, &[Role::RollRate, Role::PitchRate, Role::YawRate]);
    let [controls, rates] =
        [&controls, &rates].map(|all| all.iter().map(|(role, series)| (*role, &**series)).collect::<Vec<_>>());
    let role = |role: Role| recording.role(role).map(|channel| &channel.series);
    let airspeed = role(Role::CalibratedAirspeed).or(role(Role::TrueAirspeed));
    let flown = airspeed.and_then(|airspeed| airborne(airspeed, role(Role::WeightOnWheels), least_pressure_share));
    let always = [TimeRange { start_s: f64::NEG_INFINITY, end_s: f64::INFINITY }];
    let spans = flown.as_ref().map_or(&always[..], |flown| &flown.spans);
    let found = find_manoeuvres(&controls, &rates, spans, &ManoeuvreSettings::default());
    let found = found.map_err(|error| format!("manoeuvres: {error}"))?;
    Ok((found, flown.map(|flown| flown.least_airspeed_m_s)))
}

/// Why no manoeuvre was found, where none was.
fn none_found(search: &ManoeuvreSearch, least_airspeed_m_s: Option<f64>) -> Option<String> {
    if !search.found.is_empty() {
        return None;
    }
    let mut reasons: BTreeMap<PassedOver, (usize, f64)> = BTreeMap::new();
    for (_, _, highest, why) in &search.passed_over {
        let (count, most) = reasons.entry(*why).or_default();
        (*count, *most) = (*count + 1, most.max(*highest));
    }
    let least = ManoeuvreSettings::default().least_amplitude_rad.to_degrees();
    let part = |(why, (count, most)): (&PassedOver, &(usize, f64))| {
        let more = match (why, least_airspeed_m_s) {
            (PassedOver::Small, _) => format!(" (up to {:.2} deg, limit {least} deg)", most.to_degrees()),
            (PassedOver::OnGround, Some(least)) => format!(" (below {least:.0} m/s)"),
            _ => String::new(),
        };
        format!("{count} {}{more}", why.reason())
    };
    let parts: Vec<String> = reasons.iter().map(part).collect();
    let why = match parts.is_empty() {
        true => format!("no control moves by {:.2} deg", 0.5 * least),
        false => format!("of the inputs are {}", parts.join(", ")),
    };
    Some(format!("no manoeuvre found: {why}; mark manoeuvres by hand"))
}

fn spectra(loaded: &LoadedFlight) -> Vec<SignalSpectrum> {
    let measured = Measurement::ALL.into_iter().map(Measurement::role);
    let controls = [Role::Aileron, Role::Elevator, Role::Rudder];
    let roles = Input::ALL.into_iter().map(Input::role).chain(measured).chain(controls);
    roles.filter_map(|role| signal_spectrum(loaded, role)).collect()
}

fn signal_spectrum(loaded: &LoadedFlight, role: Role) -> Option<SignalSpectrum> {
    let recording = &loaded.recording;
    let used = &recording.role(role)?.series;
    let treated = loaded.treated.iter().find(|signal| signal.role == role);
    let recorded = treated.map_or(used, |signal| &recording.channels[signal.recorded].series);
    let after = treated.and_then(|_| spectrum(used));
    Some(SignalSpectrum { role, recorded: spectrum(recorded)?, treated: after })
}

fn series<'a>(recording: &'a Recording, roles: &[Role]) -> Vec<(Role, &'a Series)> {
    roles.iter().filter_map(|&role| Some((role, &recording.role(role)?.series))).collect()
}

fn window_proposal(flight: &str, index: usize, found: Found) -> WindowProposal {
    let mut surfaces = Surface::ALL.into_iter().filter(|surface| found.surfaces.contains(&surface.role()));
    let (surface, also) = match found.surfaces.len() {
        1 | 2 => (surfaces.next(), surfaces.next()),
        _ => (None, None),
    };
    let kind = found.shape.name();
    // Tenths of a second are what an eye would set.
    let round = |time: f64| (time * 10.0).round() / 10.0;
    let window = TimeRange { start_s: round(found.window.start_s), end_s: round(found.window.end_s) };
    let mut manoeuvre =
        Manoeuvre { surface, also, kind: kind.to_owned(), ..Manoeuvre::new(String::new(), flight.to_owned(), window) };
    manoeuvre.name = format!("{:02} {} {kind}", index + 1, manoeuvre.surface_name().unwrap_or("several"));
    WindowProposal {
        manoeuvre,
        confidence: found.confidence,
        onset_s: found.onset_s,
        input_end_s: found.input_end_s,
        amplitude_rad: found.amplitude_rad,
        base_time_s: found.base_time_s,
    }
}

/// Roles whose noise shows best on the ground: in flight the aircraft's own motion hides it (thesis section 4.4.3).
fn is_ground_role(measurement: Measurement) -> bool {
    !matches!(measurement, Measurement::Airspeed | Measurement::AngleOfAttack | Measurement::Sideslip)
}

/// How far a signal may move in a steady part: the deviation of its means over half a second, and its drift.
const STILL: [(Role, f64, f64); 8] = [
    (Role::RollRate, 0.02, 0.05),
    (Role::PitchRate, 0.02, 0.05),
    (Role::YawRate, 0.02, 0.05),
    (Role::SpecificForceZ, 0.5, 1.0),
    (Role::BankAngle, f64::INFINITY, 0.1),
    (Role::PitchAngle, f64::INFINITY, 0.1),
    (Role::VelocityNorth, 0.5, 1.0),
    (Role::VelocityEast, 0.5, 1.0),
];

/// Steady parts in flight, apart from manoeuvres, and, where the flight has time on the ground, there; and why there are none.
fn steady(
    flight: &str,
    recording: &Recording,
    inputs: &[TimeRange],
) -> StageResult<(Vec<SteadyWindow>, Option<String>)> {
    let [flying, parked] = spans(recording);
    let settings = SteadySettings::default();
    let rates = [Role::RollRate, Role::PitchRate, Role::YawRate];
    let [airborne, ground] = [
        [Role::SpecificForceZ, Role::BankAngle, Role::PitchAngle].as_slice(),
        [Role::VelocityNorth, Role::VelocityEast].as_slice(),
    ]
    .map(|others| [&rates[..], others].concat());
    let in_flight = find_rest(recording, &airborne, &intersect(&flying, &between(inputs)), &settings)?;
    let on_ground = find_rest(recording, &ground, &parked, &settings)?;
    let reason = (in_flight.found.is_empty() && on_ground.found.is_empty()).then(|| no_steady(&in_flight, &settings));
    let whole = on_ground.found.is_empty();
    let window = |window: TimeRange, roles: Vec<Role>| SteadyWindow { flight: flight.to_owned(), window, roles };
    let mut found: Vec<SteadyWindow> =
        on_ground.found.iter().map(|part| window(part.window, steady_roles(true))).collect();
    found
        .extend(in_flight.found.iter().map(|s| window(s.window, if whole { Vec::new() } else { steady_roles(false) })));
    found.sort_by(|a, b| a.window.start_s.total_cmp(&b.window.start_s));
    Ok((found, reason))
}

fn steady_roles(measurements: bool) -> Vec<Role> {
    let wanted = Measurement::ALL.into_iter().filter(|m| is_ground_role(*m) == measurements);
    let inputs = Input::ALL.into_iter().filter(|_| !measurements).map(Input::role);
    inputs.chain(wanted.map(Measurement::role)).collect()
}

fn find_rest(
    recording: &Recording,
    roles: &[Role],
    within: &[TimeRange],
    settings: &SteadySettings,
) -> Result<SteadySearch, PrepError> {
    let still = STILL.iter().filter(|(role, ..)| roles.contains(role));
    let signals: Vec<SteadySignal<'_>> = still
        .filter_map(|&(role, max_deviation, max_drift)| {
            Some(SteadySignal { series: &recording.role(role)?.series, max_deviation, max_drift })
        })
        .collect();
    // Bank and pitch alone tell no motion.
    if signals.iter().all(|signal| signal.max_deviation.is_infinite()) {
        return Ok(SteadySearch::default());
    }
    find_steady(&signals, within, settings)
}

/// Why no window is steady.
fn no_steady(search: &SteadySearch, settings: &SteadySettings) -> String {
    let length_s = settings.length_s;
    let why = match search {
        SteadySearch { looked_at: 0, .. } => {
            format!("no {length_s} s outside the manoeuvres have all inertial signals")
        }
        SteadySearch { quiet: 0, .. } => {
            let limits: Vec<String> = STILL[..4]
                .iter()
                .map(|(role, most, _)| format!("{} {most} {}", role.name(), role.dimension().si_symbol()))
                .collect();
            format!("the aircraft is not steady for {length_s} s (limits: {}; attitude 0.1 rad)", limits.join(", "))
        }
        _ => "steady signals are not white noise: filtered, interpolated or repeated samples".to_owned(),
    };
    format!("no steady part: {why}; mark one by hand or state the noise")
}

/// The time before, between and after windows in order of time.
fn between(windows: &[TimeRange]) -> Vec<TimeRange> {
    let mut start_s = f64::NEG_INFINITY;
    let mut free = Vec::new();
    for window in windows {
        free.push(TimeRange { start_s, end_s: window.start_s });
        start_s = window.end_s.max(start_s);
    }
    free.push(TimeRange { start_s, end_s: f64::INFINITY });
    free.retain(|window| window.start_s < window.end_s);
    free
}

/// Spans in flight and on the ground by true airspeed: above and below half of what nine tenths of the samples stay below. All of
/// it counts as flight where no airspeed is recorded.
fn spans(recording: &Recording) -> [Vec<TimeRange>; 2] {
    /// Spans shorter than this are no phase of a flight, s.
    const LEAST_S: f64 = 20.0;
    let base = recording.role(Role::RollRate).map(|channel| &channel.series.time_s);
    let (Some(&start_s), Some(&end_s)) = (base.and_then(|t| t.first()), base.and_then(|t| t.last())) else {
        return [Vec::new(), Vec::new()];
    };
    let Some(airspeed) = recording.role(Role::TrueAirspeed).map(|channel| &channel.series) else {
        return [vec![TimeRange { start_s, end_s }], Vec::new()];
    };
    let mut sorted: Vec<f64> = airspeed.values.iter().copied().filter(|value| value.is_finite()).collect();
    let rank = sorted.len().saturating_sub(1) * 9 / 10;
    let Some(fast) = statistics::ranked(&mut sorted, rank) else {
        return [vec![TimeRange { start_s, end_s }], Vec::new()];
    };
    let limit = 0.5 * fast;
    let mut spans: [Vec<TimeRange>; 2] = Default::default();
    let mut open: Option<(bool, f64)> = None;
    let mut last = start_s;
    for (&time, &value) in airspeed.time_s.iter().zip(&*airspeed.values).filter(|(_, value)| value.is_finite()) {
        let fast = value > limit;
        match open {
            Some((flying, _)) if flying == fast => {}
            _ => {
                close(&mut spans, open, time, LEAST_S);
                open = Some((fast, time));
            }
        }
        last = time;
    }
    close(&mut spans, open, last, LEAST_S);
    spans
}

fn close(spans: &mut [Vec<TimeRange>; 2], open: Option<(bool, f64)>, end_s: f64, least_s: f64) {
    if let Some((flying, start_s)) = open
        && end_s - start_s >= least_s
    {
        spans[usize::from(!flying)].push(TimeRange { start_s, end_s });
    }
}
