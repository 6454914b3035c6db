//! Roles by physics alone, where names say nothing: attitude and rates by Euler's kinematics first, then what hangs on them.

use super::Probe;
use super::by_hand::{By, ManualChannel, ManualChannelMap};
use super::candidates::Candidate;
use super::slopes::{compare, stamps_of};
use super::stated_unit::is_count;
use crate::quantity::{Role, Unit};
use crate::statistics::median;

/// Most roles that names gave where physics alone is asked, and fewest channels of one clock.
const MOST_NAMED: usize = 1;
const FEWEST_CHANNELS: usize = 6;
/// Most samples and channels that are looked at.
const MOST_SAMPLES: usize = 3000;
const MOST_CHANNELS: usize = 150;
/// Most pairs of an angle and its rate that are combined, and their least correlation.
const MOST_LINKS: usize = 16;
const LINK_CORRELATION: f64 = 0.6;
/// Slopes and least squared correlation of Euler's kinematics.
const EULER_SLOPE: std::ops::RangeInclusive<f64> = 0.85..=1.15;
const EULER_R2: f64 = 0.85;
/// Degrees of a radian, largest attitude and rate in radians.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;
const LARGEST_RAD: f64 = 6.4;
const LARGEST_RAD_S: f64 = 4.5;
/// Mean radius of the Earth, m.
const EARTH_M: f64 = 6.371e6;
/// Slopes and least correlation of a place and its velocity.
const SAME_SLOPE: std::ops::RangeInclusive<f64> = 0.9..=1.1;
const SAME_CORRELATION: f64 = 0.95;
/// Least cosine between track and heading, and least range of headings that tells north from east, rad.
const TRACK_COSINE: f64 = 0.95;
const LEAST_TURN_RAD: f64 = 0.5;
/// Gravity in the units of accelerations.
const GRAVITIES: [(&str, f64); 3] = [("m/s^2", 9.806_65), ("g", 1.0), ("ft/s^2", 32.174)];

/// Channels of one clock.
struct Table {
    time_s: Vec<f64>,
    /// Candidate and its samples.
    columns: Vec<(usize, Vec<f64>)>,
}

/// An angle and its rate, by their columns, and the slope between them.
#[derive(Clone, Copy)]
struct Link {
    angle: usize,
    rate: usize,
    slope: f64,
    correlation: f64,
}

/// Bank, pitch and heading with their rates, and the factors to radians of both.
struct Attitude {
    links: [Link; 3],
    to_rad: [f64; 2],
    score: f64,
}

/// Gives roles to the channels of recordings whose names say nothing.
pub(super) fn add_by_physics(map: &mut ManualChannelMap, candidates: &[Candidate<'_>], probes: &[Probe]) {
    if map.rows.len() > MOST_NAMED || map.attitude.is_some() || !map.recorders.is_empty() {
        return;
    }
    let Some(table) = Table::new(candidates, probes) else { return };
    let Some(attitude) = find_attitude(&table) else { return };
    let roles =
        [[Role::BankAngle, Role::PitchAngle, Role::HeadingAngle], [Role::RollRate, Role::PitchRate, Role::YawRate]];
    let mut search = Search { table, candidates, map };
    let symbols = |of_rate: usize| match (attitude.to_rad[of_rate] < 1.0, of_rate) {
        (true, 0) => "deg",
        (false, 0) => "rad",
        (true, _) => "deg/s",
        (false, _) => "rad/s",
    };
    for axis in 0..3 {
        search.take(roles[0][axis], attitude.links[axis].angle, symbols(0), false);
        search.take(roles[1][axis], attitude.links[axis].rate, symbols(1), false);
    }
    search.add_velocity(&attitude);
    search.add_heights();
    search.add_forces(&attitude);
}

impl Table {
    /// The channels of the clock that most free channels share.
    fn new(candidates: &[Candidate<'_>], probes: &[Probe]) -> Option<Self> {
        let key = |candidate: &Candidate<'_>| (candidate.from.source.clone(), candidate.channel.clock);
        let count = |first: &Candidate<'_>| candidates.iter().filter(|other| key(other) == key(first)).count();
        let first = candidates.iter().take(MOST_CHANNELS).max_by_key(|candidate| count(candidate))?;
        if count(first) < FEWEST_CHANNELS || first.channel.clock.is_none() {
            return None;
        }
        let stamps = stamps_of(&first.from, probes)?;
        let stride = stamps.len().div_ceil(MOST_SAMPLES).max(1);
        let thin = |values: &[f64]| values.iter().step_by(stride).copied().collect::<Vec<f64>>();
        let time_s = thin(&stamps);
        let of_clock = candidates.iter().enumerate().filter(|(_, candidate)| key(candidate) == key(first));
        let columns = of_clock
            .take(MOST_CHANNELS)
            .map(|(index, candidate)| (index, thin(candidate.channel.values())))
            .filter(|(_, values)| values.len() == time_s.len() && largest(values) > 0.0)
            .collect();
        Some(Self { time_s, columns })
    }

    fn values(&self, column: usize) -> &[f64] {
        &self.columns[column].1
    }

    /// Values in another unit.
    fn scaled(&self, column: usize, factor: f64) -> Vec<f64> {
        self.values(column).iter().map(|value| factor * value).collect()
    }
}

/// Largest magnitude.
fn largest(values: &[f64]) -> f64 {
    values.iter().filter(|value| value.is_finite()).fold(0.0, |most, value| most.max(value.abs()))
}

/// An angle without the jumps of a whole turn.
fn unwrap(values: &[f64], turn: f64) -> Vec<f64> {
    let mut turns = 0.0;
    let mut last = f64::NAN;
    let step = |value: &f64| {
        if (value - last).abs() > 0.6 * turn {
            turns -= turn * (value - last).signum();
        }
        last = *value;
        value + turns
    };
    values.iter().map(step).collect()
}

/// The three pairs of an angle and a rate that Euler's kinematics hold for.
fn find_attitude(table: &Table) -> Option<Attitude> {
    let columns = 0..table.columns.len();
    let mut links: Vec<Link> = Vec::new();
    for angle in columns.clone() {
        let turn = if largest(table.values(angle)) > LARGEST_RAD { 360.0 } else { std::f64::consts::TAU };
        let smooth = unwrap(table.values(angle), turn);
        for rate in columns.clone().filter(|rate| *rate != angle) {
            let Some((slope, correlation)) = compare(&table.time_s, &smooth, table.values(rate)) else { continue };
            if correlation > LINK_CORRELATION {
                links.push(Link { angle, rate, slope, correlation });
            }
        }
    }
    let units = [1.0, 1.0 / DEGREES];
    let combinations = units.iter().flat_map(|angle| units.iter().map(move |rate| [*angle, *rate]));
    combinations.filter_map(|to_rad| best_triple(table, &links, to_rad)).max_by(|a, b| a.score.total_cmp(&b.score))
}

/// The best three pairs where angles and rates are in some units.
fn best_triple(table: &Table, links: &[Link], to_rad: [f64; 2]) -> Option<Attitude> {
    let fits = |link: &&Link| {
        let slope = link.slope * to_rad[0] / to_rad[1];
        let is_small = largest(table.values(link.angle)) * to_rad[0] <= 2.0 * LARGEST_RAD
            && largest(table.values(link.rate)) * to_rad[1] <= LARGEST_RAD_S;
        (0.6..=1.6).contains(&slope) && is_small
    };
    let mut fitting: Vec<Link> = links.iter().filter(fits).copied().collect();
    fitting.sort_by(|a, b| b.correlation.total_cmp(&a.correlation));
    fitting.truncate(MOST_LINKS);
    let mut best: Option<Attitude> = None;
    for bank in &fitting {
        for pitch in fitting.iter().filter(|pitch| is_apart(bank, pitch)) {
            for heading in fitting.iter().filter(|heading| is_apart(bank, heading) && is_apart(pitch, heading)) {
                let links = [*bank, *pitch, *heading];
                let Some(score) = judge_triple(table, &links, to_rad) else { continue };
                if best.as_ref().is_none_or(|best| score > best.score) {
                    best = Some(Attitude { links, to_rad, score });
                }
            }
        }
    }
    best
}

/// Whether two pairs share no channel.
fn is_apart(one: &Link, other: &Link) -> bool {
    let own = [one.angle, one.rate];
    !own.contains(&other.angle) && !own.contains(&other.rate)
}

/// How well Euler's kinematics hold for a triple, and how much banks are turns; none where they do not hold.
fn judge_triple(table: &Table, links: &[Link; 3], to_rad: [f64; 2]) -> Option<f64> {
    let angles = links.map(|link| table.scaled(link.angle, to_rad[0]));
    let rates = links.map(|link| table.scaled(link.rate, to_rad[1]));
    let [phi, theta, psi] = [&angles[0], &angles[1], &angles[2]];
    if largest(theta) > std::f64::consts::FRAC_PI_2 + 0.01 {
        return None;
    }
    let [p, q, r] = [&rates[0], &rates[1], &rates[2]];
    let count = table.time_s.len();
    let turning = |k: usize| q[k] * phi[k].sin() + r[k] * phi[k].cos();
    let predicted: [Vec<f64>; 3] = [
        (0..count).map(|k| p[k] + theta[k].tan() * turning(k)).collect(),
        (0..count).map(|k| q[k] * phi[k].cos() - r[k] * phi[k].sin()).collect(),
        (0..count).map(|k| turning(k) / theta[k].cos()).collect(),
    ];
    let smooth = [phi, theta, psi].map(|angle| unwrap(angle, std::f64::consts::TAU));
    let mut score = 0.0;
    for (angle, rate) in smooth.iter().zip(&predicted) {
        let (slope, correlation) = compare(&table.time_s, angle, rate)?;
        if !EULER_SLOPE.contains(&slope) || correlation < 0.0 || correlation * correlation < EULER_R2 {
            return None;
        }
        score += correlation * correlation;
    }
    // A banked aeroplane turns; one that pitches does not.
    let turn = |angle: &[f64]| compare(&table.time_s, &smooth[2], angle).map_or(0.0, |(_, correlation)| correlation);
    Some(score + 0.5 * turn(phi) - 0.25 * turn(theta).abs())
}

/// Channels that are still free, beside those that have a role.
struct Search<'s, 'c, 'p> {
    table: Table,
    candidates: &'c [Candidate<'p>],
    map: &'s mut ManualChannelMap,
}

impl Search<'_, '_, '_> {
    fn is_free(&self, column: usize) -> bool {
        let candidate = &self.candidates[self.table.columns[column].0];
        self.map.rows.iter().all(|(_, row)| row.from != candidate.from)
    }

    fn free(&self) -> Vec<usize> {
        (0..self.table.columns.len()).filter(|column| self.is_free(*column)).collect()
    }

    /// Gives a role a column, in the unit it states or else in the one of `symbol`.
    fn take(&mut self, role: Role, column: usize, symbol: &str, turned: bool) {
        let candidate = &self.candidates[self.table.columns[column].0];
        if self.map.row(role).is_some() {
            return;
        }
        let stated = candidate.unit.filter(|unit| unit.dimension == role.dimension());
        if candidate.unit.is_some_and(|unit| !is_count(unit)) && stated.is_none() {
            return;
        }
        let mut row = ManualChannel::new(candidate.from.clone(), stated.or_else(|| Unit::parse(symbol).ok()));
        (row.by, row.turned) = (By::Physics, turned);
        self.map.set(role, Some(row));
    }

    /// Velocity north and east as the pair that points where the nose does, and the places of which they are the slopes.
    fn add_velocity(&mut self, attitude: &Attitude) {
        let psi = self.table.scaled(attitude.links[2].angle, attitude.to_rad[0]);
        let smooth = unwrap(&psi, std::f64::consts::TAU);
        let finite = || smooth.iter().filter(|value| value.is_finite());
        let range =
            finite().copied().fold(f64::NEG_INFINITY, f64::max) - finite().copied().fold(f64::INFINITY, f64::min);
        if range < LEAST_TURN_RAD {
            return;
        }
        let free = self.free();
        let cosine = |north: usize, east: usize| {
            let (north, east) = (self.table.values(north), self.table.values(east));
            let one = |k: usize| {
                let speed = north[k].hypot(east[k]);
                (speed > 1.0).then(|| (north[k] * psi[k].cos() + east[k] * psi[k].sin()) / speed)
            };
            let mut all: Vec<f64> = (0..psi.len()).filter_map(one).filter(|cosine| cosine.is_finite()).collect();
            if all.len() * 2 < psi.len() { None } else { median(&mut all) }
        };
        let pairs = free.iter().flat_map(|north| free.iter().map(move |east| (*north, *east)));
        let scored = pairs.filter(|(a, b)| a != b).filter_map(|(a, b)| Some((a, b, cosine(a, b)?)));
        let found = scored.filter(|(.., cosine)| *cosine > TRACK_COSINE).max_by(|a, b| a.2.total_cmp(&b.2));
        let Some((north, east, _)) = found else { return };
        let places = [self.find_place(north, 1.0), self.find_place(east, 1.0)];
        self.take(Role::VelocityNorth, north, "m/s", false);
        self.take(Role::VelocityEast, east, "m/s", false);
        for (role, place) in [Role::PositionNorth, Role::PositionEast].into_iter().zip(places) {
            if let Some(place) = place {
                self.take(role, place, "m", false);
            }
        }
        self.add_fixes(north, east);
    }

    /// The free column whose slope is `factor` times a velocity.
    fn find_place(&self, velocity: usize, factor: f64) -> Option<usize> {
        let speed = self.table.values(velocity);
        let fit = |place: usize| {
            let (slope, correlation) = compare(&self.table.time_s, self.table.values(place), speed)?;
            let fits = SAME_SLOPE.contains(&(slope / factor)) && correlation > SAME_CORRELATION;
            fits.then_some((place, correlation))
        };
        let fitting = self.free().into_iter().filter(|place| *place != velocity).filter_map(fit);
        fitting.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(place, _)| place)
    }

    /// Latitude and longitude by the velocity, in degrees or radians.
    fn add_fixes(&mut self, north: usize, east: usize) {
        for (symbol, to_unit) in [("deg", DEGREES), ("rad", 1.0)] {
            let Some(latitude) = self.find_place(north, to_unit / EARTH_M) else { continue };
            let mut values = self.table.values(latitude).to_vec();
            let Some(middle) = median(&mut values) else { continue };
            let longitude = self.find_place(east, to_unit / EARTH_M / (middle / to_unit).cos());
            self.take(Role::Latitude, latitude, symbol, false);
            if let Some(longitude) = longitude {
                self.take(Role::Longitude, longitude, symbol, false);
            }
            return;
        }
    }

    /// Altitude, or depth, and the vertical velocity that is its slope.
    fn add_heights(&mut self) {
        let free = self.free();
        let mut best: Option<(f64, usize, usize, f64)> = None;
        for place in &free {
            for speed in free.iter().filter(|speed| *speed != place) {
                let (place, speed) = (*place, *speed);
                let found = compare(&self.table.time_s, self.table.values(place), self.table.values(speed));
                let Some((slope, correlation)) = found else { continue };
                let is_same = SAME_SLOPE.contains(&slope.abs()) || SAME_SLOPE.contains(&(60.0 * slope.abs()));
                let is_better = best.as_ref().is_none_or(|best| correlation.abs() > best.0);
                if is_same && correlation.abs() > SAME_CORRELATION && is_better {
                    best = Some((correlation.abs(), place, speed, slope));
                }
            }
        }
        let Some((_, place, speed, slope)) = best else { return };
        let mut values = self.table.values(place).to_vec();
        let is_depth = median(&mut values).is_some_and(|middle| middle < 0.0);
        let in_feet = slope.abs() < 0.5;
        let (length, climb) = if in_feet { ("ft", "ft/min") } else { ("m", "m/s") };
        let role = if is_depth { Role::PositionDown } else { Role::Altitude };
        self.take(role, place, length, false);
        // Down is the slope of a depth, and against that of a height.
        self.take(Role::VelocityDown, speed, climb, (slope > 0.0) != is_depth);
    }

    /// Specific force: along z one g on the mean, along x with the pitch angle, along y between them.
    fn add_forces(&mut self, attitude: &Attitude) {
        /// Largest relative distance of a mean from one g.
        const NEAR: f64 = 0.12;
        /// Least correlation along x with the sine of the pitch angle.
        const PITCH_CORRELATION: f64 = 0.5;
        let middle = |column: usize| {
            let mut values = self.table.values(column).to_vec();
            median(&mut values)
        };
        let near = |column: usize| {
            let middle = middle(column)?;
            let apart = |one: f64| (middle.abs() / one - 1.0).abs();
            let (symbol, one) = GRAVITIES.into_iter().min_by(|a, b| apart(a.1).total_cmp(&apart(b.1)))?;
            (apart(one) < NEAR).then_some((column, symbol, one, middle > 0.0, apart(one)))
        };
        let found = self.free().into_iter().filter_map(near).min_by(|a, b| a.4.total_cmp(&b.4));
        let Some((down, symbol, one, turned, _)) = found else { return };
        let pitch: Vec<f64> =
            self.table.scaled(attitude.links[1].angle, attitude.to_rad[0]).into_iter().map(f64::sin).collect();
        let along = |column: &usize| {
            let correlation = correlate(self.table.values(*column), &pitch);
            let is_force = largest(self.table.values(*column)) < 4.0 * one;
            (is_force && *column != down && correlation > PITCH_CORRELATION).then_some((*column, correlation))
        };
        let forward = self.free().iter().filter_map(along).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(column, _)| column);
        self.take(Role::SpecificForceZ, down, symbol, turned);
        let Some(forward) = forward else { return };
        self.take(Role::SpecificForceX, forward, symbol, false);
        if down == forward + 2 && self.is_free(forward + 1) && largest(self.table.values(forward + 1)) < 4.0 * one {
            self.take(Role::SpecificForceY, forward + 1, symbol, false);
        }
    }
}

/// Correlation of two columns; none is zero.
fn correlate(one: &[f64], other: &[f64]) -> f64 {
    let pairs: Vec<(f64, f64)> =
        one.iter().zip(other).filter(|(a, b)| a.is_finite() && b.is_finite()).map(|(a, b)| (*a, *b)).collect();
    let number = pairs.len().max(1) as f64;
    let mean = |part: fn(&(f64, f64)) -> f64| pairs.iter().map(part).sum::<f64>() / number;
    let (mean_a, mean_b) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let sums = pairs.iter().fold((0.0, 0.0, 0.0), |(aa, ab, bb), (a, b)| {
        let (a, b) = (a - mean_a, b - mean_b);
        (aa + a * a, ab + a * b, bb + b * b)
    });
    if sums.0 > 0.0 && sums.2 > 0.0 { sums.1 / (sums.0 * sums.2).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::{guess, inspect};
    use super::*;

    /// Roles of the columns of [`flight`], in their order.
    const ROLES: [Role; 15] = [
        Role::HeadingAngle,
        Role::VelocityEast,
        Role::PitchRate,
        Role::PositionNorth,
        Role::BankAngle,
        Role::SpecificForceX,
        Role::SpecificForceY,
        Role::SpecificForceZ,
        Role::YawRate,
        Role::Altitude,
        Role::PitchAngle,
        Role::VelocityDown,
        Role::RollRate,
        Role::VelocityNorth,
        Role::PositionEast,
    ];

    /// A flight in turns and climbs, its angles in degrees or radians.
    fn flight(degrees: bool) -> String {
        let (speed, step, mut psi) = (40.0_f64, 0.02_f64, 0.3_f64);
        let [mut x, mut y, mut height] = [0.0_f64, 0.0, 800.0];
        let angle = |value: f64| if degrees { value.to_degrees() } else { value };
        let mut text = format!("time{}\n", (1..=ROLES.len()).map(|k| format!(",ch{k}")).collect::<String>());
        for k in 0..3000 {
            let t = step * f64::from(k);
            let (phi, phi_dot) =
                (0.5 * (0.3 * t).sin() + 0.2 * (1.1 * t).sin(), 0.15 * (0.3 * t).cos() + 0.22 * (1.1 * t).cos());
            let (theta, theta_dot) = (
                0.05 + 0.1 * (0.7 * t).sin() + 0.03 * (2.1 * t).cos(),
                0.07 * (0.7 * t).cos() - 0.063 * (2.1 * t).sin(),
            );
            let psi_dot = 9.806_65 / speed * phi.tan();
            let p = phi_dot - psi_dot * theta.sin();
            let q = theta_dot * phi.cos() + psi_dot * theta.cos() * phi.sin();
            let r = psi_dot * theta.cos() * phi.cos() - theta_dot * phi.sin();
            let (north, east, down) =
                (speed * theta.cos() * psi.cos(), speed * theta.cos() * psi.sin(), -speed * theta.sin());
            let force = [
                9.806_65 * theta.sin(),
                0.1 * (0.9 * t).sin(),
                -9.806_65 * theta.cos() * phi.cos() - speed * theta_dot,
            ];
            let row = [
                angle(psi),
                east,
                angle(q),
                x,
                angle(phi),
                force[0],
                force[1],
                force[2],
                angle(r),
                height,
                angle(theta),
                down,
                angle(p),
                north,
                y,
            ];
            text += &format!("{t:.2}{}\n", row.iter().map(|value| format!(",{value:.6}")).collect::<String>());
            (x, y, height, psi) = (x + step * north, y + step * east, height - step * down, psi + step * psi_dot);
        }
        text
    }

    #[test]
    fn roles_of_channels_without_names_are_found_by_physics() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.csv");
        for degrees in [true, false] {
            std::fs::write(&path, flight(degrees)).unwrap();
            let map = guess(&[inspect(&path).unwrap()]);
            let wanted = |channel: &str| channel.strip_prefix("ch")?.parse::<usize>().ok().map(|k| ROLES[k - 1]);
            // Position down of the altitude is of the same channel.
            let found = |role: Role, row: &ManualChannel| row.by == By::Physics && role != Role::PositionDown;
            for (role, row) in map.rows.iter().filter(|(role, row)| found(*role, row)) {
                assert_eq!(wanted(&row.from.channel), Some(*role), "degrees {degrees}");
                let is_angle = row.unit.is_some_and(|unit| unit.symbol.starts_with("deg"));
                let of_angle = row.unit.is_some_and(|unit| is_angle || unit.symbol.starts_with("rad"));
                assert!(!of_angle || is_angle == degrees, "{}", role.name());
                assert!(!row.turned, "{}", role.name());
            }
            let found = map.rows.iter().filter(|(role, row)| found(*role, row)).count();
            assert!(10 * found >= 8 * ROLES.len(), "{found} of {} roles", ROLES.len());
        }
    }
}
