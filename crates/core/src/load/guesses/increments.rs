//! Increments of inertial units: the angle and the velocity gained since the sample before, read as rates and specific forces.

use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::load::contents::Probe;
use crate::load::guesses::candidates::{Candidate, candidates, row};
use crate::load::guesses::slopes::stamps_of;
use crate::load::guesses::vectors::find_axes;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap};
use crate::quantity::{Dimension, Role, Unit};
use crate::statistics::{median, median_step};

/// What increments are of.
struct Increments {
    roles: [Role; 3],
    /// Dimension of an increment, and the units that it and its rate have.
    dimension: Dimension,
    units: &'static [(&'static str, &'static str)],
    /// Names without the axis.
    stems: &'static [&'static str],
}

const ALL: [Increments; 2] = [
    Increments {
        roles: [Role::RollRate, Role::PitchRate, Role::YawRate],
        dimension: Dimension::Angle,
        units: &[("rad", "rad/s"), ("deg", "deg/s")],
        stems: &[
            "deltatheta", "dtheta", "deltaangle", "deltaang", "deltang", "delang", "dang", "dangle", "delangle",
            "angleincrement", "angularincrement", "angincrement", "angleinc", "anginc", "incangle", "deltarotation",
            "thetaincrement", "gyroincrement", "gyrodelta", "deltagyro", "rotationincrement",
        ],
    },
    Increments {
        roles: [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ],
        dimension: Dimension::Speed,
        units: &[("m/s", "m/s^2"), ("ft/s", "ft/s^2")],
        stems: &[
            "deltavel", "deltavelocity", "deltav", "dvel", "dv", "dvelocity", "delvel", "delv", "velincrement",
            "velocityincrement", "velinc", "incvel", "incvelocity", "accelincrement", "acceldelta", "deltaaccel",
        ],
    },
];
/// Largest ratio of the median specific force of a flight to one g, either way.
const GRAVITY_RATIO: f64 = 1.35;

/// Gives rates and specific forces that have no channel yet the increments of an inertial unit over its sample interval.
pub(crate) fn add_increments(map: &mut ManualChannelMap, probes: &[Probe]) {
    if !map.recorders.is_empty() {
        return;
    }
    let candidates = candidates(probes);
    for increments in &ALL {
        if increments.roles.iter().any(|role| map.row(*role).is_some()) {
            continue;
        }
        let find = |stem: &&str| find_axes(stem, increments.dimension, false, &candidates);
        let Some(found) = increments.stems.iter().find_map(find).map(|found| found.map(|index| &candidates[index]))
        else {
            continue;
        };
        let Some(interval_s) = stamps_of(&found[0].from, probes).and_then(|time_s| median_step(&time_s)) else {
            continue;
        };
        match increments.read(found, interval_s) {
            Some(rows) => {
                map.left_out_by_name.retain(|(from, _)| rows.iter().all(|row| row.from != *from));
                increments.roles.into_iter().zip(rows).for_each(|(role, row)| map.set(role, Some(row)));
            }
            None => {
                let why = "increments that do not add up to gravity over the sample interval";
                map.left_out_by_name.retain(|(from, _)| found.iter().all(|one| one.from != *from));
                map.left_out.extend(found.map(|one| (one.from.clone(), why.to_owned())));
            }
        }
    }
}

impl Increments {
    /// The rows of three increments over an interval; none of velocities that are not gravity in it, whatever their unit.
    fn read(&self, found: [&Candidate<'_>; 3], interval_s: f64) -> Option<[ManualChannel; 3]> {
        let stated = found[0].unit.filter(|unit| unit.dimension == self.dimension);
        let is_of = |(increment, _): &&(&str, &str)| stated.is_none_or(|unit| unit.symbol == *increment);
        let mut units = self.units.iter().filter(is_of);
        let is_gravity = |(_, rate): &&(&str, &str)| {
            let unit = Unit::parse(rate).ok();
            let size = unit.and_then(|unit| Some(unit.scale * median_length(found)? / interval_s));
            size.is_some_and(|size| (size / STANDARD_GRAVITY_M_S2).ln().abs() < GRAVITY_RATIO.ln())
        };
        let (_, rate) = match self.dimension {
            Dimension::Speed => units.find(is_gravity)?,
            _ => units.next()?,
        };
        let unit = Unit::parse(rate).ok()?;
        // Gravity along z says its sign.
        let middle = |one: &Candidate<'_>| {
            median(&mut one.channel.values().iter().copied().filter(|value| value.is_finite()).collect::<Vec<_>>())
        };
        let is_known = stated.is_some() || self.dimension == Dimension::Speed;
        let made = |(role, one): (Role, &Candidate<'_>)| ManualChannel {
            by: By::Axes,
            unit: Some(unit),
            scale: 1.0 / interval_s,
            turned: role == Role::SpecificForceZ && middle(one).is_some_and(|middle| middle > 0.0),
            is_unit_known: is_known,
            evidence: Some(format!("increments over {interval_s:.4} s")),
            ..row(one, role)
        };
        let [x, y, z] = self.roles;
        let [one, two, three] = found;
        Some([made((x, one)), made((y, two)), made((z, three))])
    }
}

/// Median length of a vector as recorded.
fn median_length(found: [&Candidate<'_>; 3]) -> Option<f64> {
    let [x, y, z] = found.map(|one| one.channel.values());
    let length = |((x, y), z): ((&f64, &f64), &f64)| x.hypot(*y).hypot(*z);
    let mut lengths: Vec<f64> = x.iter().zip(y).zip(z).map(length).filter(|length| length.is_finite()).collect();
    median(&mut lengths)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::guesses::guess::guess;
    use crate::load::maps::map::ChannelMap;
    use crate::load::maps::plan::plan;
    use crate::load::maps::read::read;
    use crate::load::probe_of;

    /// A banked weave at 50 Hz with the increments of rates and specific forces; angles and velocities in the units of `head`.
    fn recorded(head: &str, [per_rad, per_m_s]: [f64; 2], gravity: f64) -> String {
        let row = |k: u32| {
            let t = 0.02 * f64::from(k);
            let (phi, theta) = (0.4 * (0.9 * t).sin(), 0.1 * (0.6 * t).sin());
            let (p, q, r) = (0.36 * (0.9 * t).cos(), 0.06 * (0.6 * t).cos(), 0.05 * phi);
            let (ax, ay, az) = (9.8 * theta, 0.4 * phi, gravity * 9.8 * (1.0 + 0.05 * (1.1 * t).sin()));
            let angles = [p, q, r].map(|rate| format!("{:.9}", 0.02 * rate * per_rad)).join(",");
            let velocities = [ax, ay, az].map(|force| format!("{:.9}", 0.02 * force * per_m_s)).join(",");
            format!("{t:.2},{angles},{velocities},{:.5},{:.5}\n", phi.to_degrees(), theta.to_degrees())
        };
        format!("{head}\n{}", (0..1000).map(row).collect::<String>())
    }

    #[test]
    fn increments_are_read_as_rates_and_specific_forces() {
        let degrees = 180.0 / std::f64::consts::PI;
        for (head, units, gravity) in [
            (
                "time,DeltaThetaX [deg],DeltaThetaY [deg],DeltaThetaZ [deg],DeltaVelX [m/s],DeltaVelY [m/s],DeltaVelZ [m/s],\
                 Roll [deg],Pitch [deg]",
                [degrees, 1.0],
                -1.0,
            ),
            (
                "time,dtheta_x_rad,dtheta_y_rad,dtheta_z_rad,dvel_x,dvel_y,dvel_z,roll_deg,pitch_deg",
                [1.0, 1.0 / 0.3048],
                1.0,
            ),
            (
                "time,IMU dAng X,IMU dAng Y,IMU dAng Z,IMU dVx,IMU dVy,IMU dVz,Roll [deg],Pitch [deg]",
                [degrees, 1.0],
                -1.0,
            ),
        ] {
            let probe = probe_of(&recorded(head, units, gravity));
            let map = guess(std::slice::from_ref(&probe));
            let read = read(&plan(&probe, &ChannelMap::parse(&map.text().unwrap()).unwrap())).unwrap();
            let t = 0.02 * 300.0_f64;
            let phi = 0.4 * (0.9 * t).sin();
            for (role, wanted) in [
                (Role::RollRate, 0.36 * (0.9 * t).cos()),
                (Role::PitchRate, 0.06 * (0.6 * t).cos()),
                (Role::SpecificForceY, 0.4 * phi),
                (Role::SpecificForceZ, -9.8 * (1.0 + 0.05 * (1.1 * t).sin())),
            ] {
                let value = read.role(role).unwrap_or_else(|| panic!("{head}: {}", role.name())).series.values[300];
                assert!((value - wanted).abs() < 1e-5, "{head}: {} {value}, expected {wanted}", role.name());
            }
        }
    }

    #[test]
    fn increments_that_are_not_gravity_over_an_interval_are_left_out() {
        let head = "time,DeltaThetaX [deg],DeltaThetaY [deg],DeltaThetaZ [deg],DeltaVelX [m/s],DeltaVelY [m/s],DeltaVelZ [m/s],\
                    Roll [deg],Pitch [deg]";
        let probe = probe_of(&recorded(head, [57.3, 0.25], -1.0));
        let map = guess(std::slice::from_ref(&probe));
        assert!(map.row(Role::SpecificForceZ).is_none() && map.row(Role::PitchRate).is_some());
        assert!(map.left_out.iter().any(|(from, why)| from.channel == "DeltaVelZ" && why.contains("gravity")));
    }
}
