//! Roles of channels whose names say nothing, by the relations between their values alone.
//!
//! Hypotheses of attitude and rates come first (Euler kinematics need nothing else), then forces, airspeed and flow angles by the equations of
//! motion, heights and velocities over the Earth, and controls by the angular accelerations that they start.

mod air;
mod air_data;
mod air_velocity;
mod assignment;
mod climb_angle;
mod coarse;
mod earth;
mod fit;
#[cfg(test)]
mod flight_tests;
mod kinematics;
mod laws;
mod pressures;
mod recorded;
mod surfaces;
mod tracks;
mod windows;

use crate::quantity::Role;
use assignment::Assignment;
use kinematics::Motion;
pub use windows::Series;
use windows::{Windows, cut_fastest};

/// A channel that the values of others make a role.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The role.
    pub role: Role,
    /// Index of its channel.
    pub column: usize,
    /// Its unit, where the relations decide it.
    pub unit: Option<&'static str>,
    /// Its sign is turned.
    pub turned: bool,
    /// Added to its values as recorded.
    pub offset: f64,
    /// The relation that it was found by, and its R2.
    pub evidence: String,
    /// Share of the likelihood of all channels and hypotheses that were compared.
    pub share: f64,
    /// Index of the channel that fits next best, and why it is not taken.
    pub runner_up: Option<(usize, String)>,
}

/// Every channel in windows, longer by a factor, with the channels that are copies of others.
fn cut(series: &[Series<'_>], factor: f64) -> Windows {
    with_copies(windows::cut(series, factor))
}

fn with_copies(windows: Windows) -> Windows {
    Windows { copies: kinematics::find_copies(&windows), ..windows }
}

/// Roles of the channels of a recording; none where no attitude and rates fit each other.
pub fn search(series: &[Series<'_>]) -> Vec<Found> {
    let mut short = cut(series, 1.0);
    if short.count == 0 {
        return Vec::new();
    }
    let mut hypotheses = kinematics::hypotheses(&short);
    let is_even = !hypotheses.is_empty();
    if !is_even {
        // Recorders that stamp late and unevenly fit each other over longer windows only.
        short = cut(series, LONG);
        hypotheses = kinematics::hypotheses(&short);
    }
    if hypotheses.is_empty() {
        return Vec::new();
    }
    let long = cut(series, if is_even { LONG } else { LONG * LONG });
    let mut all: Vec<Assignment<'_>> =
        hypotheses.iter().map(|motion| complete(&short, &long, motion.clone())).collect();
    let has_ground = all.iter().any(|whole| whole.ground.is_some());
    if let Some(motion) = hypotheses.first().filter(|motion| !has_ground && motion.angles[2].is_some()) {
        // Axes of the body may point left and up: the path over the ground shows it.
        let turned = complete(&short, &long, motion.about_x());
        if turned.ground.is_some() {
            all.clear();
            all.push(turned);
        }
    }
    all.sort_by(|a, b| b.score.total_cmp(&a.score));
    let Some(best) = all.first() else { return Vec::new() };
    let rates: Vec<usize> = best.motion.rates.iter().flatten().map(|rate| rate.column).collect();
    let fastest = with_copies(cut_fastest(series, &short, &rates));
    if fastest.count > 0 {
        // Controls and flow angles show where a long flight is flown hardest.
        let other = assignment::complete(&fastest, best.motion.clone(), best.speed);
        let found = other.found;
        if let Some(best) = all.first_mut() {
            best.merge(&found);
        }
    }
    let Some(best) = all.first() else { return Vec::new() };
    let mut found: Vec<Found> = best.found.iter().map(|found| compare(found, &all)).collect();
    recorded::prefer_recorded(&mut found, best.windows);
    found
}

/// What was found, with its share of the likelihood of all hypotheses, the best first, and what the next that differs takes instead.
fn compare(found: &Found, all: &[Assignment<'_>]) -> Found {
    let best = all.first().map_or(0.0, |whole| whole.score);
    let is_same = |other: &Found| other.column == found.column && other.turned == found.turned;
    let (mut agreeing, mut sum) = (0.0, 0.0);
    let mut runner_up = found.runner_up.clone();
    for whole in all {
        let likelihood = (whole.score - best).exp();
        let other = whole.found.iter().find(|other| other.role == found.role);
        sum += likelihood;
        agreeing += if other.is_some_and(is_same) { likelihood } else { 0.0 };
        if let Some(other) = other.filter(|other| runner_up.is_none() && other.column != found.column) {
            let less = best - whole.score;
            runner_up = Some((other.column, format!("all roles together less likely by a factor of exp({less:.0})")));
        }
    }
    Found { share: found.share * agreeing / sum, runner_up, ..found.clone() }
}

/// Windows for what is slow and noisy, as many times as long.
const LONG: f64 = 4.0;

/// The whole assignment of a hypothesis: what only longer windows show of the airspeed is taken from those.
fn complete<'w>(short: &'w Windows, long: &'w Windows, motion: Motion) -> Assignment<'w> {
    let plain = assignment::complete(short, motion.clone(), None);
    if long.count < LEAST_LONG {
        return plain;
    }
    let slow = assignment::complete(long, motion.clone(), plain.speed);
    let mut whole = if plain.speed.is_none() && slow.speed.is_some() {
        assignment::complete(short, motion, slow.speed)
    } else {
        plain
    };
    whole.merge(&slow.found);
    whole
}

/// Fewest of the longer windows.
const LEAST_LONG: usize = 40;
