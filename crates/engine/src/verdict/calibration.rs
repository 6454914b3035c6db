//! Whether the levels are right: simulated flights of known truth, sound, in gusts and with one fault each, judged as a session is.

use std::f64::consts::TAU;
use std::sync::Arc;

use doublet_core::model::is_constant_name;
use doublet_core::prep::first_order_lag;
use doublet_core::quantity::Role;
use doublet_core::series::{Recording, Series};
use doublet_core::simulate::Scenario;
use rayon::prelude::*;
use serde::Serialize;

use super::{Finding, FitVerdict, Level, Verdicts, fly_and_judge};
use crate::graph::{Context, StageResult};
use crate::session::{Place, Session};
use crate::stage::PooledFits;

/// An estimate is right within this part of the truth, or within so many of its corrected standard errors.
const RIGHT_PART: f64 = 0.15;
const RIGHT_ERRORS: f64 = 3.0;
/// A wrong one matters where it moves its coefficient by more than this part of the coefficient's motion.
const MATTERS: f64 = 0.03;
/// Gusts of the second case, m/s.
const GUSTS_M_S: f64 = 0.7;
/// Corner frequency of the filters of inertial sensors, Hz.
const FILTER_HZ: f64 = 3.0;

/// What is done to a recording.
type Spoil = fn(&mut Recording);

/// A case: its name, its gusts where they are not the scenario's, what is done to the recording, and the findings that name it.
struct Case {
    name: &'static str,
    gusts_m_s: Option<f64>,
    spoil: Spoil,
    names: fn(&Finding) -> bool,
}

const CASES: [Case; 11] = [
    Case { name: "sound", gusts_m_s: None, spoil: |_| (), names: |_| false },
    Case { name: "gusts", gusts_m_s: Some(GUSTS_M_S), spoil: |_| (), names: |_| false },
    Case {
        name: "elevator 0.12 s late",
        gusts_m_s: None,
        spoil: |recording| later(recording, &[Role::Elevator], 0.12),
        names: |finding| finding.code == "timing",
    },
    Case {
        name: "ground velocity 0.3 s late",
        gusts_m_s: None,
        spoil: |recording| later(recording, &[Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown], 0.3),
        names: is_about_ground_velocity,
    },
    Case {
        name: "gyros behind a filter of 3 Hz",
        gusts_m_s: None,
        spoil: |recording| filtered(recording, &[Role::RollRate, Role::PitchRate, Role::YawRate]),
        names: |finding| finding.code == "timing" && finding.place.is_named("gyros"),
    },
    Case {
        name: "accelerometers behind a filter of 3 Hz",
        gusts_m_s: None,
        spoil: |recording| {
            filtered(recording, &[Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ]);
        },
        names: |finding| finding.code == "timing" && finding.place.is_named("accelerometers"),
    },
    Case {
        name: "pitch rate reversed",
        gusts_m_s: None,
        spoil: |recording| times(recording, Role::PitchRate, -1.0),
        names: |finding| is_about(finding, Role::PitchRate),
    },
    Case {
        name: "ay reversed",
        gusts_m_s: None,
        spoil: |recording| times(recording, Role::SpecificForceY, -1.0),
        names: |finding| is_about(finding, Role::SpecificForceY),
    },
    Case {
        name: "airspeed 12 % small",
        gusts_m_s: None,
        spoil: |recording| times(recording, Role::TrueAirspeed, 0.88),
        names: |finding| is_about(finding, Role::TrueAirspeed),
    },
    Case {
        name: "p and r exchanged",
        gusts_m_s: None,
        spoil: exchange_p_and_r,
        names: |finding| is_about(finding, Role::RollRate) || is_about(finding, Role::YawRate),
    },
    Case {
        name: "elevator 20 % large (not visible)",
        gusts_m_s: None,
        spoil: |recording| times(recording, Role::Elevator, 1.2),
        names: |finding| is_about(finding, Role::Elevator),
    },
];

/// What became of the flights of one case.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CaseCounts {
    /// Case.
    pub name: &'static str,
    /// Flights flown.
    pub flights: usize,
    /// Flights by the level of the session: good, caution, bad.
    pub sessions: [usize; 3],
    /// Derivatives by their level, the worse of their own and their fit's: right ones.
    pub right: [usize; 3],
    /// Wrong ones.
    pub wrong: [usize; 3],
    /// Wrong ones under good that move their coefficient.
    pub wrong_that_matter: usize,
    /// Flights whose fault is named, noticed under another cause, or silent: a wrong derivative that matters is good.
    pub faults: [usize; 3],
}

/// Flies every case once for each seed from `first_seed` on.
pub fn calibrate_levels(
    session: &Session,
    scenario: &Scenario,
    (flights, first_seed): (usize, u64),
    context: &Context<'_>,
) -> StageResult<Vec<CaseCounts>> {
    let context = context.parts(CASES.len() * flights);
    let one = |index: usize| -> StageResult<(usize, CaseCounts)> {
        context.checkpoint()?;
        let (at, seed) = (index / flights, first_seed + (index % flights) as u64);
        let case = &CASES[at];
        let mut scenario = scenario.clone();
        scenario.gust_m_s = case.gusts_m_s.unwrap_or(scenario.gust_m_s);
        let (_, snapshot) = fly_and_judge(session, &scenario, seed, &case.spoil, &context)?;
        context.step();
        let judged = snapshot.verdicts.ready().zip(snapshot.pooled.ready());
        let counts =
            judged.map_or_else(CaseCounts::default, |(verdicts, fits)| counted(case, verdicts, fits, &scenario));
        Ok((at, counts))
    };
    let found = (0..CASES.len() * flights).into_par_iter().map(one).collect::<StageResult<Vec<_>>>()?;
    let mut rows: Vec<CaseCounts> =
        CASES.iter().map(|case| CaseCounts { name: case.name, flights, ..CaseCounts::default() }).collect();
    for (at, counts) in found {
        let row = &mut rows[at];
        let add = |sum: &mut [usize; 3], own: [usize; 3]| sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        add(&mut row.sessions, counts.sessions);
        add(&mut row.right, counts.right);
        add(&mut row.wrong, counts.wrong);
        add(&mut row.faults, counts.faults);
        row.wrong_that_matter += counts.wrong_that_matter;
    }
    Ok(rows)
}

fn counted(case: &Case, verdicts: &Verdicts, fits: &PooledFits, scenario: &Scenario) -> CaseCounts {
    let mut counts = CaseCounts::default();
    counts.sessions[verdicts.session.level as usize] += 1;
    for fit in &fits.fits {
        let (Ok(estimate), Some(judged)) = (&fit.fit, verdicts.fit(None, fit.coefficient)) else { continue };
        for (index, name) in estimate.names.iter().enumerate().filter(|(_, name)| !is_constant_name(name)) {
            let Some(truth) = scenario.vehicle.aero.value(name) else { continue };
            let error = fit.corrected_errors.get(index).copied().unwrap_or(0.0);
            let off = (estimate.estimates[index] - truth).abs();
            let is_right = off <= (RIGHT_PART * truth.abs()).max(RIGHT_ERRORS * error);
            let level = level_of(judged, name);
            let row = if is_right { &mut counts.right } else { &mut counts.wrong };
            row[level as usize] += 1;
            let moves = judged.consequence(name).map_or(0.0, |found| off * found.motion_ratio);
            counts.wrong_that_matter += usize::from(!is_right && level == Level::Good && moves > MATTERS);
        }
    }
    let derivatives = verdicts.pooled.iter().flat_map(|fit| &fit.derivatives).map(|one| &one.verdict);
    let mut all = std::iter::once(&verdicts.session).chain(derivatives).flat_map(|verdict| &verdict.reasons);
    let fate = match (all.any(case.names), counts.wrong_that_matter) {
        (true, _) => 0,
        (false, 0) => 1,
        (false, _) => 2,
    };
    counts.faults[fate] += 1;
    counts
}

/// The worse of the levels of a derivative and of its fit.
fn level_of(judged: &FitVerdict, name: &str) -> Level {
    let own = judged.derivative(name).map_or(Level::Good, |verdict| verdict.level);
    own.max(judged.verdict.level)
}

/// Whether a finding is about the velocity over the ground.
fn is_about_ground_velocity(finding: &Finding) -> bool {
    [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown].into_iter().any(|role| is_about(finding, role))
}

fn is_about(finding: &Finding, role: Role) -> bool {
    let is_part = |place: &Place| matches!(place, Place::Flight { part: Some(part), .. } if part == role.name());
    finding.code == "physics" && is_part(&finding.place)
}

fn changed(recording: &mut Recording, role: Role, change: impl FnOnce(&Series) -> Series) {
    let Some(index) = recording.roles.get(&role).copied() else { return };
    if let Some(channel) = recording.channels.get_mut(index) {
        channel.series = change(&channel.series);
    }
}

fn later(recording: &mut Recording, roles: &[Role], by_s: f64) {
    for role in roles {
        changed(recording, *role, |series| Series {
            time_s: series.time_s.iter().map(|time_s| time_s + by_s).collect(),
            values: series.values.clone(),
        });
    }
}

/// Channels behind a first-order lag; one whose time does not increase stays as it is.
fn filtered(recording: &mut Recording, roles: &[Role]) {
    let time_constant_s = 1.0 / (TAU * FILTER_HZ);
    for role in roles {
        changed(recording, *role, |series| {
            let values = first_order_lag(&series.time_s, &series.values, time_constant_s);
            let values = values.map_or_else(|_| Arc::clone(&series.values), Arc::from);
            Series { time_s: Arc::clone(&series.time_s), values }
        });
    }
}

fn times(recording: &mut Recording, role: Role, factor: f64) {
    changed(recording, role, |series| Series {
        time_s: series.time_s.clone(),
        values: series.values.iter().map(|value| factor * value).collect(),
    });
}

fn exchange_p_and_r(recording: &mut Recording) {
    let [p, r] = [Role::RollRate, Role::YawRate].map(|role| recording.roles.get(&role).copied());
    if let Some((p, r)) = p.zip(r) {
        recording.roles.insert(Role::RollRate, r);
        recording.roles.insert(Role::YawRate, p);
    }
}
