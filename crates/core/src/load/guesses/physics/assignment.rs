//! A whole assignment: what follows from a hypothesis of attitude and rates, relation by relation.

use super::fit::line;
use super::kinematics::{Motion, TURNED, Taken, log_likelihood};
use super::windows::{Column, Windows};
use super::{Found, air, air_data, air_velocity, climb_angle, earth, laws, pressures, surfaces, tracks};
use crate::quantity::Role;

/// Least share of the likelihood that one channel must have of all that fit a role.
const LEAST_SHARE: f64 = 0.9;

/// Squared correlation of two records of one quantity, and by how much the likelihood of one must then exceed the other's.
const ALIKE_R2: f64 = 0.9;
const ALIKE_COUNT: f64 = 40.0;
const ALIKE_LEAD: f64 = 8.0;

/// Roles found so far, with the quantities that relations need, in SI and for every window.
#[derive(Clone)]
pub struct Assignment<'w> {
    pub windows: &'w Windows,
    /// Attitude and rates that it follows from.
    pub motion: Motion,
    pub found: Vec<Found>,
    /// Logarithm of the likelihood of all relations.
    pub score: f64,
    pub phi: Vec<f64>,
    pub theta: Vec<f64>,
    pub psi: Option<Vec<f64>>,
    pub p: Vec<f64>,
    pub q: Vec<f64>,
    pub r: Vec<f64>,
    pub speed: Option<Taken>,
    pub airspeed: Option<Vec<f64>>,
    /// Its change, m/s^2.
    pub acceleration: Option<Vec<f64>>,
    /// Angle of attack and its change.
    pub alpha: Option<[Vec<f64>; 2]>,
    pub beta: Option<[Vec<f64>; 2]>,
    /// Height and its change.
    pub height: Option<[Vec<f64>; 2]>,
    /// Climb as it is recorded, m/s.
    pub climb: Option<Vec<f64>>,
    /// Velocity over the ground, north and east, m/s.
    pub ground: Option<[Vec<f64>; 2]>,
    /// Wind, north and east, m/s.
    pub wind: Option<[f64; 2]>,
    used: Vec<usize>,
}

impl<'w> Assignment<'w> {
    pub fn column(&self, index: usize) -> &'w Column {
        &self.windows.columns[index]
    }

    /// One number for every window.
    pub fn each(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.windows.count).map(value).collect()
    }

    /// A channel in SI.
    pub fn mean_of(&self, taken: Taken) -> Vec<f64> {
        self.column(taken.column).mean.iter().map(|value| taken.factor * value).collect()
    }

    /// Its change per second.
    pub fn slope_of(&self, taken: Taken) -> Vec<f64> {
        self.column(taken.column).slope.iter().map(|value| taken.factor * value).collect()
    }

    /// Channels that vary and have no role yet.
    pub fn free(&self) -> Vec<usize> {
        (0..self.windows.columns.len()).filter(|i| self.column(*i).varies() && !self.used.contains(i)).collect()
    }

    /// The channel that fits best, with its share of the likelihood of all, and the one that fits next best.
    fn choose(&self, fits: impl Fn(&Self, usize) -> Option<Taken>) -> Option<(Taken, f64, Option<Taken>)> {
        let all: Vec<Taken> = self.free().into_iter().filter_map(|i| fits(self, i)).collect();
        let best = *all.iter().max_by(|a, b| a.r2.total_cmp(&b.r2))?;
        let likelihood = |taken: &Taken| log_likelihood(taken.r2, self.windows.independent);
        // Another place or filter of the same quantity must fit clearly worse.
        let is_alike = |other: &&Taken| {
            other.column != best.column
                && line(&self.column(other.column).mean, &self.column(best.column).mean)
                    .is_some_and(|(_, r2)| r2 > ALIKE_R2)
        };
        let close = all
            .iter()
            .filter(is_alike)
            .any(|other| log_likelihood(best.r2, ALIKE_COUNT) - log_likelihood(other.r2, ALIKE_COUNT) < ALIKE_LEAD);
        let sum: f64 = all.iter().map(|taken| (likelihood(taken) - likelihood(&best)).exp()).sum();
        if close {
            return None;
        }
        let others = all.iter().filter(|other| other.column != best.column);
        Some((best, 1.0 / sum, others.max_by(|a, b| a.r2.total_cmp(&b.r2)).copied()))
    }

    /// Gives a role a channel.
    pub fn take(&mut self, role: Role, taken: Taken, relation: &str) {
        self.used.push(taken.column);
        self.score +=
            log_likelihood(taken.r2, self.windows.independent) - if taken.factor < 0.0 { TURNED } else { 0.0 };
        self.found.push(Found {
            role,
            column: taken.column,
            unit: (!taken.unit.is_empty()).then_some(taken.unit),
            turned: taken.factor < 0.0,
            offset: 0.0,
            evidence: format!("{relation}, R2 {:.3}", taken.r2),
            share: 1.0,
            runner_up: None,
        });
    }

    /// Adds what other windows show of roles and channels that are still free.
    pub fn merge(&mut self, other: &[Found]) {
        let heights = [Role::Altitude, Role::PositionDown];
        for found in other {
            let has_height = heights.contains(&found.role) && self.found.iter().any(|one| heights.contains(&one.role));
            if !has_height && self.found.iter().all(|one| one.role != found.role && one.column != found.column) {
                self.found.push(found.clone());
            }
        }
    }

    /// The same of the channel that fits best, where none fits as well.
    pub fn take_best(
        &mut self,
        role: Role,
        relation: &str,
        fits: impl Fn(&Self, usize) -> Option<Taken>,
    ) -> Option<Taken> {
        let (taken, share, next) = self.choose(fits).filter(|(_, share, _)| *share > LEAST_SHARE)?;
        self.take(role, taken, relation);
        if let Some(found) = self.found.last_mut() {
            found.share = share;
            found.runner_up = next.map(|next| (next.column, format!("R2 {:.3} against {:.3}", next.r2, taken.r2)));
        }
        Some(taken)
    }

    /// The same of the channel that fits best, whatever else records the quantity.
    pub fn take_nearest(
        &mut self,
        role: Role,
        relation: &str,
        fits: impl Fn(&Self, usize) -> Option<Taken>,
    ) -> Option<Taken> {
        let mut all: Vec<Taken> = self.free().into_iter().filter_map(|i| fits(self, i)).collect();
        all.sort_by(|a, b| b.r2.total_cmp(&a.r2));
        let best = *all.first()?;
        self.take(role, best, relation);
        if let Some(found) = self.found.last_mut() {
            found.runner_up = all.get(1).map(|next| (next.column, format!("R2 {:.3} against {:.3}", next.r2, best.r2)));
        }
        Some(best)
    }
}

/// What follows from a hypothesis of attitude and rates.
pub fn complete(windows: &Windows, motion: Motion, speed: Option<Taken>) -> Assignment<'_> {
    let copies = &windows.copies;
    let nothing = Vec::new;
    let mut whole = Assignment {
        windows,
        found: Vec::new(),
        score: motion.score,
        motion: motion.clone(),
        phi: nothing(),
        theta: nothing(),
        psi: None,
        p: nothing(),
        q: nothing(),
        r: nothing(),
        speed: None,
        airspeed: None,
        acceleration: None,
        alpha: None,
        beta: None,
        height: None,
        climb: None,
        ground: None,
        wind: None,
        used: (0..copies.len()).filter(|i| copies[*i].is_some()).collect(),
    };
    let roles = [
        (motion.angles, [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle], "rotates at the measured rates"),
        (motion.rates, [Role::RollRate, Role::PitchRate, Role::YawRate], "the rate of change of the attitude"),
    ];
    let score = whole.score;
    for (taken, role, relation) in roles
        .into_iter()
        .flat_map(|(taken, roles, relation)| taken.into_iter().zip(roles).map(move |(t, r)| (t, r, relation)))
    {
        if let Some(taken) = taken {
            whole.take(role, taken, relation);
        }
    }
    whole.score = score;
    let [phi, theta, psi] = motion.angles.map(|taken| taken.map(|taken| whole.mean_of(taken)));
    let (Some(phi), Some(theta)) = (phi, theta) else { return whole };
    (whole.phi, whole.theta, whole.psi) = (phi, theta, psi);
    let made = motion.body_rates(windows);
    let [p, q, r] =
        std::array::from_fn(|i| motion.rates[i].map_or_else(|| made[i].clone(), |taken| whole.mean_of(taken)));
    (whole.p, whole.q, whole.r) = (p, q, r);
    if speed.is_none() {
        air_data::complete(&mut whole);
        pressures::complete(&mut whole);
    }
    tracks::complete(&mut whole);
    if speed.is_none() {
        air_velocity::complete(&mut whole);
    }
    if speed.is_none() {
        climb_angle::complete(&mut whole);
    }
    air::complete(&mut whole, speed);
    tracks::complete(&mut whole);
    air_velocity::complete(&mut whole);
    earth::complete(&mut whole);
    air_velocity::complete(&mut whole);
    air_velocity::complete_forces(&mut whole);
    air::find_side(&mut whole);
    laws::complete(&mut whole);
    air::complete_forces(&mut whole);
    laws::complete(&mut whole);
    surfaces::complete(&mut whole);
    whole
}
