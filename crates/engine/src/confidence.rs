//! How certain each row of a guessed channel map is, by words, units and relations between channels.
//!
//! `confidence = 1 / (1 + exp(-s))`, with `s` the sum of log odds of naive Bayes. They come from counts of rows right and wrong in role, unit
//! or sign, one added to each, over the open part of the annotated public recordings (497 right, 19 wrong; `docs/fidelity.md`). A row of a
//! recording without names has its share of the likelihood instead, times the part of such rows that is right.

use doublet_core::load::{By, ManualChannel, ManualChannelMap, NameFit, Probe, RunnerUp};
use doublet_core::quantity::{Dimension, Role};

use crate::begin;
use crate::stage::{FlightPhysics, PhysicsRow};
use crate::verdict::Level;

/// Log odds of any row: 498 to 20.
const ANY: f64 = 3.21;
/// Unit documented, stated or decided by what values can be (337 right to 1 wrong), or as large as the values (162 to 20).
const UNIT_KNOWN: f64 = 2.65;
const UNIT_BY_SIZE: f64 = -1.08;
/// Sign not documented: 3 to 2.
const SIGN_OPEN: f64 = -2.76;
/// Relations to other channels that hold: none (298 to 17), one (105 to 4), more (97 to 1).
const RELATIONS: [f64; 3] = [-0.26, 0.14, 1.45];
/// Whether a relation contradicts the row: 29 to 5, or none does: 470 to 16.
const CONTRADICTED: f64 = -1.41;
const NOT_CONTRADICTED: f64 = 0.21;
/// How it was found: 190 to 4, 70 to 1, 217 to 17, 17 to 1, 8 to 1.
const BY_RECORDER: f64 = 0.82;
const BY_AXES: f64 = 1.21;
const BY_WHOLE_NAME: f64 = -0.49;
const BY_PART_OF_NAME: f64 = -0.21;
const BY_CHANNELS: f64 = -0.96;
/// Part of the rows that values alone gave a role which is right, 154 of 164.
const RIGHT_BY_VALUES: f64 = 0.94;

/// One row of a guess, weighed.
#[derive(Clone, Debug, PartialEq)]
pub struct WeighedRole {
    pub role: Role,
    /// Probability that channel, unit and sign are right, 0 to 1.
    pub confidence: f64,
    /// What speaks for and against it.
    pub evidence: String,
    /// The channel that would play the role otherwise.
    pub runner_up: Option<RunnerUp>,
}

/// The rows of a guess by their evidence; `physics` is the comparison of its channels, where they could be read.
pub fn weigh(probes: &[Probe], guess: &ManualChannelMap, physics: Option<&FlightPhysics>) -> Vec<WeighedRole> {
    let rows = physics.map_or(&[][..], |physics| &physics.rows);
    let weigh = |(role, row): &(Role, ManualChannel)| {
        let (confidence, evidence) = weigh_row(*role, row, probes, rows);
        WeighedRole { role: *role, confidence, evidence, runner_up: guess.runner_up(*role).cloned() }
    };
    guess.rows.iter().map(weigh).collect()
}

/// Confidence and evidence of one row.
fn weigh_row(role: Role, row: &ManualChannel, probes: &[Probe], rows: &[PhysicsRow]) -> (f64, String) {
    let (words, of_words) = weigh_words(row);
    let is_open = row.is_unit_open(probes) && role.dimension() != Dimension::Dimensionless;
    let holding: Vec<&PhysicsRow> = rows.iter().filter(|other| other.fits && other.needed.contains(&role)).collect();
    let against = rows.iter().find(|other| other.level > Level::Good && other.needed.contains(&role));
    let mut evidence = vec![words, format!("unit {}", begin::unit_reason(row, probes))];
    let own = holding.iter().find(|other| other.channel == role.name()).or(holding.first());
    evidence.extend(own.map(|other| other.evidence.clone()));
    evidence.extend(against.map(|other| format!("against it: {}", other.headline)));
    let sum = ANY
        + of_words
        + if is_open { UNIT_BY_SIZE } else { UNIT_KNOWN }
        + if row.asks_sign { SIGN_OPEN } else { 0.0 }
        + RELATIONS[holding.len().min(2)]
        + if against.is_some() { CONTRADICTED } else { NOT_CONTRADICTED };
    let confidence = match (row.by, row.share) {
        (By::Hand, _) => 1.0,
        (_, Some(share)) => RIGHT_BY_VALUES * share,
        _ => 1.0 / (1.0 + (-sum).exp()),
    };
    (confidence, evidence.join("; "))
}

/// How a row was found, and the log odds of that.
fn weigh_words(row: &ManualChannel) -> (String, f64) {
    let plain = |odds: f64| (row.by.description().to_owned(), odds);
    match (row.by, row.fit) {
        (By::Hand | By::File, _) => plain(0.0),
        (By::Recorder, _) => plain(BY_RECORDER),
        (By::Axes, _) => plain(BY_AXES),
        (By::Physics | By::Layout, _) => {
            (row.evidence.clone().unwrap_or_else(|| row.by.description().to_owned()), BY_CHANNELS)
        }
        (By::Name, fit) => match fit {
            Some(fit @ (NameFit::Whole | NameFit::Foreign)) => (fit.description().to_owned(), BY_WHOLE_NAME),
            Some(fit) => (fit.description().to_owned(), BY_PART_OF_NAME),
            None => plain(BY_PART_OF_NAME),
        },
    }
}
