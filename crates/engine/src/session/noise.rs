//! Steady parts, and noise entries with the reasons for what they are.

use doublet_core::quantity::Role;
use doublet_core::reconstruct::{Input, Measurement};
use doublet_core::series::TimeRange;
use serde::{Deserialize, Serialize};

use super::edit::{check_interval, positive};
use super::schema::SteadyTable;
use super::{Edit, EditError, Session};

/// A part in which what the channels still do is noise.
#[derive(Clone, Debug, PartialEq, Hash, Serialize, Deserialize)]
#[serde(from = "SteadyTable", into = "SteadyTable")]
pub struct SteadyWindow {
    /// Flight it lies in.
    pub flight: String,
    /// First and last instant on the flight's time line.
    pub window: TimeRange,
    /// Roles it speaks for; empty for all.
    pub roles: Vec<Role>,
}

/// An entry of the process or measurement noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NoiseChannel {
    /// Inertial sample: the diagonal of Q.
    Input(Input),
    /// Measurement: the diagonal of R.
    Measurement(Measurement),
}

impl NoiseChannel {
    /// Every entry, inputs first.
    pub fn all() -> impl Iterator<Item = Self> {
        Input::ALL.into_iter().map(Self::Input).chain(Measurement::ALL.into_iter().map(Self::Measurement))
    }

    /// Name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Input(input) => input.name(),
            Self::Measurement(measurement) => measurement.name(),
        }
    }

    /// The entry of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|channel| channel.name() == name)
    }

    /// The recorded role it is the noise of.
    pub fn role(self) -> Role {
        match self {
            Self::Input(input) => input.role(),
            Self::Measurement(measurement) => measurement.role(),
        }
    }

    /// Its standard deviation in a session, SI.
    pub fn std(self, session: &Session) -> f64 {
        match self {
            Self::Input(input) => session.filter.process_noise[input as usize],
            Self::Measurement(measurement) => session.filter.measurement_noise[measurement as usize],
        }
    }
}

/// A standard deviation for one entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseEntry {
    pub channel: NoiseChannel,
    /// Standard deviation, SI.
    pub std: f64,
}

/// A change of steady parts or noise entries.
#[derive(Clone, Debug, PartialEq)]
pub enum NoiseEdit {
    /// All steady parts of a flight.
    Steady { flight: String, windows: Vec<SteadyWindow> },
    /// Sets entries, and why they are not what the recording says; a reason given earlier goes.
    Set {
        /// Entries and their standard deviations.
        entries: Vec<NoiseEntry>,
        /// Why they differ from the recording; empty where they do not or nobody says.
        reason: String,
    },
}

impl Edit {
    /// Sets one entry without a reason.
    pub fn noise(channel: NoiseChannel, std: f64) -> Self {
        Self::Noise(NoiseEdit::Set { entries: vec![NoiseEntry { channel, std }], reason: String::new() })
    }
}

impl NoiseEdit {
    pub(super) fn label(&self) -> String {
        match self {
            Self::Steady { flight, .. } => format!("mark steady parts of {flight}"),
            Self::Set { entries, .. } => match entries[..] {
                [entry] => format!("set noise of {}", entry.channel.name()),
                _ => "take recorded noise".to_owned(),
            },
        }
    }

    pub(super) fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        match self {
            Self::Steady { flight, windows } => {
                if session.flight(flight).is_none() {
                    return Err(EditError::NoFlight(flight.clone()));
                }
                windows.iter().try_for_each(|steady| check_interval(steady.window))?;
                session.steady.retain(|steady| steady.flight != *flight);
                session.steady.extend(windows.iter().cloned());
            }
            Self::Set { entries, reason } => {
                for entry in entries {
                    set(session, *entry)?;
                    let (name, reason) = (entry.channel.name(), reason.trim());
                    session.noise_reasons.remove(name);
                    if !reason.is_empty() {
                        session.noise_reasons.insert(name.to_owned(), reason.to_owned());
                    }
                }
            }
        }
        Ok(())
    }
}

fn set(session: &mut Session, NoiseEntry { channel, std }: NoiseEntry) -> Result<(), EditError> {
    let std = positive("noise of", channel.name(), std)?;
    match channel {
        NoiseChannel::Input(input) => session.filter.process_noise[input as usize] = std,
        NoiseChannel::Measurement(measurement) => session.filter.measurement_noise[measurement as usize] = std,
    }
    Ok(())
}
