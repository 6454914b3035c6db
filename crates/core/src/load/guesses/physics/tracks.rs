//! Latitude and longitude by the heading, and what else is recorded of the velocity over the ground that they make: the direction of the path
//! is the heading but for wind and sideslip, its speed that of flight.

use std::f64::consts::{PI, TAU};

use super::air::{SPEEDS, taken};
use super::air_data::average;
use super::assignment::Assignment;
use super::earth::{EARTH_M, LENGTHS};
use super::kinematics::{ANGLES, Taken};
use crate::quantity::Role;

/// Largest mean angle between path and heading, and its largest deviation, rad.
const DRIFT: f64 = 0.4;
const SCATTER: f64 = 0.25;
/// Deviation of the heading from which it tells axes apart, rad.
const TURN: f64 = 0.25;
/// Speeds of flight, m/s, and the largest ratio of ground speed to airspeed, either way.
const SPEEDS_M_S: std::ops::Range<f64> = 5.0..350.0;
const OF_AIRSPEED: f64 = 1.5;
/// Largest deviation of the ground speed on a constant heading, as a part of it.
const UNEVEN: f64 = 0.2;
/// Largest deviation of a record of the ground velocity from it, as a part of the speed.
const APART: f64 = 0.15;
/// Squares of the parts of the ground speed along one axis that are compared.
const PARTS: std::ops::Range<f64> = 0.1..0.8;
/// Least part of the square of the speed along an axis, and largest deviation as a part of it, of a record that is the change of the place.
const LEAST_PART: f64 = 0.01;
const CLOSE: f64 = 0.005;
/// Largest latitude and longitude, and their largest change in a flight, degrees.
const LARGEST: [f64; 2] = [85.0, 181.0];
const LARGEST_CHANGE: f64 = 15.0;
/// Largest ratio of a record's size to that of its unit, either way.
const RATIO: f64 = 1.1;
/// Most channels that are compared as places.
const MOST: usize = 60;

/// A pair of places that follows the heading.
struct Track {
    places: [Taken; 2],
    /// North and east, m/s.
    velocity: [Vec<f64>; 2],
    scatter: f64,
}

/// Finds latitude and longitude, then other records of the ground velocity.
pub fn complete(whole: &mut Assignment<'_>) {
    if whole.ground.is_none() {
        let Some(track) = find_places(whole) else { return };
        let relation = "the resulting path follows the heading";
        for (role, place) in [Role::Latitude, Role::Longitude].into_iter().zip(track.places) {
            whole.take(role, place, relation);
        }
        whole.ground = Some(track.velocity);
    }
    let Some(ground) = whole.ground.clone() else { return };
    let speed = average(&(0..whole.windows.count).map(|k| ground[0][k].hypot(ground[1][k])).collect::<Vec<_>>());
    let positions = [Role::PositionNorth, Role::PositionEast];
    let velocities = [Role::VelocityNorth, Role::VelocityEast];
    for axis in 0..2 {
        let wanted = &ground[axis];
        take(whole, velocities[axis], "the rate of change of position", |whole, i| {
            is_record(&whole.column(i).mean, wanted, speed, &SPEEDS, i)
        });
        take(whole, positions[axis], "its rate of change is that of position", |whole, i| {
            is_record(&whole.column(i).slope, wanted, speed, &LENGTHS, i)
        });
    }
}

/// Gives a role that is still open the channel that fits best.
fn take(
    whole: &mut Assignment<'_>,
    role: Role,
    relation: &str,
    fits: impl Fn(&Assignment<'_>, usize) -> Option<Taken>,
) {
    if whole.found.iter().any(|found| found.role == role) {
        return;
    }
    let all = whole.free().into_iter().filter_map(|i| fits(whole, i));
    if let Some(best) = all.max_by(|a, b| a.r2.total_cmp(&b.r2)) {
        whole.take(role, best, relation);
    }
}

/// A record of one part of the ground velocity, which is that part itself, not only up to a line.
pub fn is_record(values: &[f64], wanted: &[f64], speed: f64, units: &[(&'static str, f64)], i: usize) -> Option<Taken> {
    let pairs = || values.iter().zip(wanted).filter(|(a, b)| a.is_finite() && b.is_finite());
    let (mut square, mut product, mut count) = (0.0, 0.0, 0.0);
    for (value, wanted) in pairs() {
        (square, product, count) = (square + wanted * wanted, product + value * wanted, count + 1.0);
    }
    // A part near zero has no size that shows a unit; one that is nearly all of the speed is separated from the airspeed by a closer fit.
    let is_part = PARTS.contains(&(square / (count * speed * speed)));
    let found = taken(i, product / square, units, RATIO, 0.0)?;
    let apart: f64 = pairs().map(|(value, wanted)| (found.factor * value - wanted).powi(2)).sum();
    let part = (apart / count).sqrt() / speed;
    let is_close = square > LEAST_PART * count * speed * speed && apart < CLOSE * CLOSE * square;
    ((is_close || is_part && part < APART) && found.factor > 0.0).then_some(Taken { r2: 1.0 - apart / square, ..found })
}

/// The pair of places that follows the heading best.
fn find_places(whole: &Assignment<'_>) -> Option<Track> {
    let psi = whole.psi.as_ref()?;
    let (_, turning) = direction(psi.iter().copied())?;
    let mut best: Option<Track> = None;
    for (unit, scale) in ANGLES {
        let fits = |&i: &usize| {
            let column = whole.column(i);
            let degrees = column.range.map(|value| (value / scale).to_degrees());
            let change = average(&column.slope.iter().map(|slope| (slope / scale * EARTH_M).abs()).collect::<Vec<_>>());
            column.turn.is_none()
                && degrees[1] - degrees[0] < LARGEST_CHANGE
                && degrees.iter().all(|value| value.abs() < LARGEST[1])
                && change < SPEEDS_M_S.end
        };
        let columns: Vec<usize> = whole.free().into_iter().filter(fits).take(MOST).collect();
        for &north in &columns {
            let latitude = average(&whole.column(north).mean) / scale;
            if latitude.to_degrees().abs() > LARGEST[0] {
                continue;
            }
            for &east in columns.iter().filter(|east| **east != north) {
                let part = |i: usize, along: f64| -> Vec<f64> {
                    whole.column(i).slope.iter().map(|slope| slope / scale * EARTH_M * along).collect()
                };
                let velocity = [part(north, 1.0), part(east, latitude.cos())];
                let Some(scatter) = follows(whole, psi, &velocity, turning) else { continue };
                if best.as_ref().is_none_or(|best| scatter < best.scatter) {
                    let place = |column| Taken { column, unit, factor: 1.0 / scale, r2: 1.0 - scatter * scatter };
                    best = Some(Track { places: [place(north), place(east)], velocity, scatter });
                }
            }
        }
    }
    best
}

/// Deviation of the path from the heading, where it follows it at a speed of flight.
fn follows(whole: &Assignment<'_>, psi: &[f64], [north, east]: &[Vec<f64>; 2], turning: f64) -> Option<f64> {
    let speeds: Vec<f64> = north.iter().zip(east).map(|(north, east)| north.hypot(*east)).collect();
    let speed = average(&speeds);
    if !SPEEDS_M_S.contains(&speed) {
        return None;
    }
    let airspeed = whole.airspeed.as_ref().map(|airspeed| average(airspeed));
    if airspeed.is_some_and(|airspeed| (speed / airspeed).ln().abs() > OF_AIRSPEED.ln()) {
        return None;
    }
    let uneven = average(&speeds.iter().map(|one| (one / speed - 1.0).powi(2)).collect::<Vec<_>>()).sqrt();
    // On a constant heading an even speed near the airspeed takes the place of the turn.
    if turning < TURN && (airspeed.is_none() || uneven > UNEVEN) {
        return None;
    }
    let apart = (0..psi.len()).map(|k| east[k].atan2(north[k]) - psi[k]);
    let (drift, scatter) = direction(apart)?;
    (drift.abs() < DRIFT && scatter < SCATTER && uneven < 2.0 * UNEVEN).then_some(scatter)
}

/// Mean of directions, -pi to pi, and their deviation from it.
fn direction(angles: impl Iterator<Item = f64> + Clone) -> Option<(f64, f64)> {
    let finite = angles.filter(|angle| angle.is_finite());
    let (sin, cos) = finite.clone().fold((0.0, 0.0), |(s, c), angle| (s + angle.sin(), c + angle.cos()));
    let mean = f64::atan2(sin, cos);
    let count = finite.clone().count();
    let wrapped = |angle: f64| (angle - mean + PI).rem_euclid(TAU) - PI;
    let square: f64 = finite.map(|angle| wrapped(angle).powi(2)).sum();
    (count > 20).then(|| (mean, (square / count as f64).sqrt()))
}
