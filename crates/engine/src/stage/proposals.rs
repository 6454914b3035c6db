//! What a flight itself shows: manoeuvre windows, steady windows, spectra of its signals.

use doublet_core::prep::{
    Manoeuvre as Found, ManoeuvreSettings, Spectrum, SteadySettings, find_manoeuvres, find_steady, spectrum,
};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{Input, Measurement};
use doublet_core::series::{Recording, Series, Window};

use super::LoadedFlight;
use crate::graph::Footprint;
use crate::session::{Manoeuvre, Session, SteadyWindow, Surface};

/// What a flight shows and proposes.
#[derive(Clone, Debug, Default)]
pub struct FlightProposals {
    /// Manoeuvres, in order of time.
    pub windows: Vec<WindowProposal>,
    /// Steady windows: those in flight for inertial samples and air data, those on the ground for attitude and navigation.
    pub steady: Vec<SteadyWindow>,
    /// Spectra of everything that enters the filter and of the control deflections.
    pub spectra: Vec<SignalSpectrum>,
    /// Why something could not be looked for, one line each.
    pub findings: Vec<String>,
}

impl Footprint for FlightProposals {
    fn bytes(&self) -> usize {
        1000 * (self.windows.len() + self.steady.len()) + 16_000 * self.spectra.len()
    }
}

/// Spectrum of the signal of a role.
#[derive(Clone, Debug)]
pub struct SignalSpectrum {
    /// Role.
    pub role: Role,
    /// As recorded.
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

impl WindowProposal {
    /// The session's window that covers the input of this one already.
    pub fn taken<'a>(&self, session: &'a Session) -> Option<&'a Manoeuvre> {
        session.windows.iter().find(|window| {
            window.flight == self.manoeuvre.flight
                && window.window.start_s < self.input_end_s
                && window.window.end_s > self.onset_s
        })
    }
}

/// The proposed windows a session lacks, with names it does not have yet.
pub fn open_windows(session: &Session, proposals: &FlightProposals) -> Vec<Manoeuvre> {
    let mut named: Vec<String> = session.windows.iter().map(|window| window.name.clone()).collect();
    let open = proposals.windows.iter().filter(|proposal| proposal.taken(session).is_none());
    open.map(|proposal| {
        let mut window = proposal.manoeuvre.clone();
        let base = window.name.clone();
        let mut number = 2;
        while named.contains(&window.name) {
            window.name = format!("{base} ({number})");
            number += 1;
        }
        named.push(window.name.clone());
        window
    })
    .collect()
}

/// Looks through a flight on its time line.
pub fn proposals(flight: &str, loaded: &LoadedFlight) -> FlightProposals {
    let recording = &loaded.recording;
    let mut found = FlightProposals::default();
    let controls = series(recording, &[Role::Aileron, Role::Elevator, Role::Rudder]);
    if controls.is_empty() {
        found.findings.push("no manoeuvres are looked for: the recording has no control deflections".to_owned());
    }
    let rates = series(recording, &[Role::RollRate, Role::PitchRate, Role::YawRate]);
    match find_manoeuvres(&controls, &rates, &ManoeuvreSettings::default()) {
        Ok(manoeuvres) => {
            found.windows =
                manoeuvres.into_iter().enumerate().map(|(index, one)| window_proposal(flight, index, one)).collect();
        }
        Err(error) => found.findings.push(format!("manoeuvres: {error}")),
    }
    match steady(flight, recording) {
        Ok(steady) => found.steady = steady,
        Err(error) => found.findings.push(format!("steady windows: {error}")),
    }
    found.spectra = spectra(loaded);
    found
}

fn spectra(loaded: &LoadedFlight) -> Vec<SignalSpectrum> {
    let recording = &loaded.recording;
    let measured = Measurement::ALL.into_iter().map(Measurement::role);
    let controls = [Role::Aileron, Role::Elevator, Role::Rudder];
    let roles = Input::ALL.into_iter().map(Input::role).chain(measured).chain(controls);
    let one = |role: Role| {
        let used = &recording.role(role)?.series;
        let treated = loaded.treated.iter().find(|signal| signal.role == role);
        let recorded = treated.map_or(used, |signal| &recording.channels[signal.recorded].series);
        let after = treated.and_then(|_| spectrum(used));
        Some(SignalSpectrum { role, recorded: spectrum(recorded)?, treated: after })
    };
    roles.filter_map(one).collect()
}

fn series<'a>(recording: &'a Recording, roles: &[Role]) -> Vec<(Role, &'a Series)> {
    roles.iter().filter_map(|&role| Some((role, &recording.role(role)?.series))).collect()
}

fn window_proposal(flight: &str, index: usize, found: Found) -> WindowProposal {
    let surface = match found.surface {
        Role::Elevator => Surface::Elevator,
        Role::Aileron => Surface::Aileron,
        _ => Surface::Rudder,
    };
    let kind = found.shape.name();
    // Tenths of a second are what an eye would set.
    let round = |time: f64| (time * 10.0).round() / 10.0;
    let window = Window { start_s: round(found.window.start_s), end_s: round(found.window.end_s) };
    WindowProposal {
        manoeuvre: Manoeuvre {
            surface: Some(surface),
            kind: kind.to_owned(),
            ..Manoeuvre::new(format!("{:02} {} {kind}", index + 1, surface.name()), flight.to_owned(), window)
        },
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

/// Steady windows in flight and, where the flight has time on the ground, there.
fn steady(flight: &str, recording: &Recording) -> Result<Vec<SteadyWindow>, String> {
    let [flying, parked] = spans(recording);
    let settings = SteadySettings::default();
    let look = |roles: &[Role], within: &[Window]| {
        let signals: Vec<&Series> = series(recording, roles).into_iter().map(|(_, series)| series).collect();
        if signals.is_empty() {
            return Ok(Vec::new());
        }
        find_steady(&signals, within, &settings).map_err(|error| error.to_string())
    };
    let rates = [Role::RollRate, Role::PitchRate, Role::YawRate];
    let in_flight = look(&[rates[0], rates[1], rates[2], Role::SpecificForceZ], &flying)?;
    let on_ground = look(&[rates[0], rates[1], rates[2], Role::VelocityNorth, Role::VelocityEast], &parked)?;
    let of = |measurements: bool| -> Vec<Role> {
        let wanted = Measurement::ALL.into_iter().filter(|m| is_ground_role(*m) == measurements);
        let inputs = Input::ALL.into_iter().filter(|_| !measurements).map(Input::role);
        inputs.chain(wanted.map(Measurement::role)).collect()
    };
    let whole = on_ground.is_empty();
    let window = |window: Window, roles: Vec<Role>| SteadyWindow { flight: flight.to_owned(), window, roles };
    let mut found: Vec<SteadyWindow> = on_ground.into_iter().map(|stretch| window(stretch.window, of(true))).collect();
    found.extend(in_flight.into_iter().map(|s| window(s.window, if whole { Vec::new() } else { of(false) })));
    found.sort_by(|a, b| a.window.start_s.total_cmp(&b.window.start_s));
    Ok(found)
}

/// Spans in flight and on the ground by true airspeed: above and below half of what nine tenths of the samples stay below. All of
/// it counts as flight where no airspeed is recorded.
fn spans(recording: &Recording) -> [Vec<Window>; 2] {
    /// Spans shorter than this are no phase of a flight, s.
    const LEAST_S: f64 = 20.0;
    let base = recording.role(Role::RollRate).map(|channel| &channel.series.time_s);
    let (Some(&start_s), Some(&end_s)) = (base.and_then(|t| t.first()), base.and_then(|t| t.last())) else {
        return [Vec::new(), Vec::new()];
    };
    let Some(airspeed) = recording.role(Role::TrueAirspeed).map(|channel| &channel.series) else {
        return [vec![Window { start_s, end_s }], Vec::new()];
    };
    let mut sorted: Vec<f64> = airspeed.values.iter().copied().filter(|value| value.is_finite()).collect();
    if sorted.is_empty() {
        return [vec![Window { start_s, end_s }], Vec::new()];
    }
    let place = (sorted.len() - 1) * 9 / 10;
    let limit = 0.5 * *sorted.select_nth_unstable_by(place, f64::total_cmp).1;
    let mut spans: [Vec<Window>; 2] = Default::default();
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

fn close(spans: &mut [Vec<Window>; 2], open: Option<(bool, f64)>, end_s: f64, least_s: f64) {
    if let Some((flying, start_s)) = open
        && end_s - start_s >= least_s
    {
        spans[usize::from(!flying)].push(Window { start_s, end_s });
    }
}
