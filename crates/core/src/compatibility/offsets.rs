//! Angles that are off by a constant: an angle of attack against attitude and path, a sideslip without side force, a heading against the
//! direction in which the velocity changes or the aircraft flies.

use nalgebra::{SMatrix, SVector};

use super::line::{Figures, Line};
use super::motion::{Motion, air_velocity, in_north_east_down};
use super::outcome::Outcome;
use super::traces::{Trace, most_telling};
use crate::quantity::Role::{self, *};
use crate::statistics::{median, student_widening};

/// Least offset that is named, rad: 2 deg of an angle of attack, since upwash, position error and vertical wind hide one; 3 deg of a
/// heading; 5 deg of one by airspeed, into which sideslip enters, and of a sideslip.
const LEAST_PATH_RAD: f64 = 0.0349;
const LEAST_TURNING_RAD: f64 = 0.0524;
const LEAST_RAD: f64 = 0.0873;
/// Offset of an angle of attack that nothing but a mistake makes, rad: 5 deg. Mounting and upwash stay below.
const CERTAIN_RAD: f64 = 0.0873;
/// Vertical wind that no air has for as long as a manoeuvre takes, m/s, and in the mean of a long flight.
const LASTING_WIND_M_S: f64 = 20.0;
const MEAN_WIND_M_S: f64 = 5.0;
/// A long flight: time from its first segment to its last, s, and segments that show the same.
const LONG_FLIGHT_S: f64 = 600.0;
const LONG_FLIGHT_SEGMENTS: usize = 4;
/// Largest offset that is named, rad: 45 deg. What is farther off is another mistake.
const LARGEST_RAD: f64 = 0.786;
/// Bank up to which the wings count as level, rad.
const LEVEL_RAD: f64 = 0.26;
/// Half the time over which the slope of altitude is taken, s.
const HALF_CLIMB_S: f64 = 1.5;
/// The comparison scatters less than this part of an offset that is one.
const SCATTER: f64 = 0.5;
/// An offset is this many standard errors.
const SIGNIFICANT: f64 = 3.0;
/// Standard error of a median of normal variables, in median deviations over the root of their number.
const ERROR_OF_MEDIAN: f64 = 1.858;
/// A sideslip and the side force belong together from this squared correlation on.
const SIDE_FORCE_R2: f64 = 0.5;
/// From this one on a slope is known well enough to tell a scale from an offset.
const SCALE_R2: f64 = 0.8;
/// From this one on two directions belong together.
const DIRECTION_R2: f64 = 0.9;
/// Pairs are taken this far apart, s.
const EVERY_S: f64 = 0.2;
/// Pairs that share their errors: 5 s of them, and the fewest of these.
const BLOCK: usize = 25;
const FEWEST_IN_BLOCK: usize = 8;
/// Fewest such blocks.
const FEWEST_BLOCKS: usize = 4;
/// Lag over which a velocity changes, s.
const LAG_S: f64 = 1.0;
/// Unknowns of a comparison of directions: the offset and three of which it is to be free.
const UNKNOWNS: usize = 4;

/// What an angle is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Comparison {
    /// `alpha = theta - asin(climb / V)`, wings level.
    Path,
    /// `beta = ay / (ay per beta)`: no side force without sideslip.
    SideForce,
    /// `(v_north, v_east)' = C f`: the specific force turned by the heading.
    Turning,
    /// `(v_north, v_east) = C V + wind`: the airspeed turned by the heading.
    Flight,
}

/// An angle and what it should be but for a constant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offset {
    /// The channel.
    pub role: Role,
    /// With what it is compared, in words.
    pub with: &'static str,
    needs: &'static [Role],
    one_of: &'static [Role],
    by: Comparison,
    least_rad: f64,
}

/// Every such angle.
pub(super) const OFFSETS: &[Offset] = &[
    Offset {
        role: AngleOfAttack,
        with: "theta minus the flight-path angle, on average",
        needs: &[AngleOfAttack, PitchAngle, TrueAirspeed],
        one_of: &[VelocityDown, Altitude],
        by: Comparison::Path,
        least_rad: LEAST_PATH_RAD,
    },
    Offset {
        role: Sideslip,
        with: "the sideslip at zero side force",
        needs: &[Sideslip],
        one_of: &[SpecificForceY],
        by: Comparison::SideForce,
        least_rad: LEAST_RAD,
    },
    Offset {
        role: HeadingAngle,
        with: "the heading from specific force and ground velocity",
        needs: &[
            HeadingAngle, PitchAngle, BankAngle, SpecificForceX, SpecificForceY, SpecificForceZ, VelocityNorth,
            VelocityEast,
        ],
        one_of: &[HeadingAngle],
        by: Comparison::Turning,
        least_rad: LEAST_TURNING_RAD,
    },
    Offset {
        role: HeadingAngle,
        with: "the heading from airspeed and ground velocity",
        needs: &[HeadingAngle, TrueAirspeed, VelocityNorth, VelocityEast],
        one_of: &[HeadingAngle],
        by: Comparison::Flight,
        least_rad: LEAST_RAD,
    },
];

/// An offset as a recording shows it.
struct Estimate {
    /// The angle as recorded less what it should be, rad.
    offset: f64,
    /// Standard error, rad.
    error: f64,
    /// Whether what it is compared with follows it otherwise.
    is_constant: bool,
    segments: usize,
}

impl Offset {
    /// Whether every channel it needs is there.
    fn applies(&self, motion: &Motion) -> bool {
        self.needs.iter().all(|role| motion.has(*role)) && self.one_of.iter().any(|role| motion.has(*role))
    }

    /// Whether the channel of `role` enters.
    pub(super) fn involves(&self, role: Role) -> bool {
        self.needs.contains(&role) || self.one_of.contains(&role)
    }

    fn is_of_directions(&self) -> bool {
        matches!(self.by, Comparison::Turning | Comparison::Flight)
    }

    /// What the recording shows; `None` where nothing tells.
    fn estimate(&self, motion: &Motion) -> Option<Estimate> {
        if self.is_of_directions() { self.of_directions(motion) } else { self.of_means(motion) }
    }

    fn of_means(&self, motion: &Motion) -> Option<Estimate> {
        let (mut differences, mut pairs, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
        let mut segments = 0;
        for segment in &motion.segments {
            let found = self.pairs(motion, segment);
            segments += usize::from(!found.is_empty());
            let apart: Vec<f64> = found.iter().map(|(_, should, is)| is - should).collect();
            let long = apart.chunks(BLOCK).filter(|block| block.len() >= FEWEST_IN_BLOCK);
            blocks.extend(long.filter_map(|block| median(&mut block.to_vec())));
            differences.extend(apart);
            pairs.extend(found.into_iter().map(|(_, should, is)| (should, is)));
        }
        if blocks.len() < FEWEST_BLOCKS {
            return None;
        }
        let offset = median(&mut differences)?;
        let middle = median(&mut blocks.clone())?;
        let scatter = median(&mut blocks.iter().map(|value| (value - middle).abs()).collect::<Vec<_>>())?;
        // An angle scaled by its upwash is off in the mean, too, but not where it is small.
        let line = Line::through(&pairs, false).filter(|line| line.r2 > SCALE_R2);
        let intercept = line.map_or(offset, |line| line.intercept());
        let kept = if intercept * offset > 0.0 { offset.abs().min(intercept.abs()).copysign(offset) } else { 0.0 };
        let offset = if kept.abs() > self.least_rad { offset } else { kept };
        let error = student_widening(blocks.len())? * ERROR_OF_MEDIAN * scatter / (blocks.len() as f64).sqrt();
        Some(Estimate { offset, error, is_constant: scatter < SCATTER * offset.abs(), segments })
    }

    /// `(step, what it should be, what it is)` of one segment.
    fn pairs(&self, motion: &Motion, segment: &std::ops::Range<usize>) -> Vec<(usize, f64, f64)> {
        let (half, every) = (steps_of(HALF_CLIMB_S, motion), steps_of(EVERY_S, motion));
        if segment.len() < 4 * half {
            return Vec::new();
        }
        let inner = (segment.start + half..segment.end - half).step_by(every);
        let pairs = match self.by {
            Comparison::SideForce => self.without_side_force(motion, inner.collect()),
            _ => inner.map(|k| (k, theta_less_path(motion, k, half), motion.at(self.role, k))).collect(),
        };
        let finite = |(_, should, is): &(usize, f64, f64)| should.is_finite() && is.is_finite();
        pairs.into_iter().filter(finite).collect()
    }

    /// Sideslip as the side force says, by the slope of the segment itself; nothing where they do not belong together.
    fn without_side_force(&self, motion: &Motion, steps: Vec<usize>) -> Vec<(usize, f64, f64)> {
        let pairs: Vec<_> = steps.iter().map(|k| (motion.at(Sideslip, *k), motion.at(SpecificForceY, *k))).collect();
        let pairs: Vec<_> = pairs.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        let Some(line) = Line::through(&pairs, false) else { return Vec::new() };
        if line.r2 < SIDE_FORCE_R2 || line.slope >= 0.0 {
            return Vec::new();
        }
        steps.iter().map(|k| (*k, motion.at(SpecificForceY, *k) / line.slope, motion.at(Sideslip, *k))).collect()
    }

    /// The angle by which one direction is turned against the other, over all segments.
    fn of_directions(&self, motion: &Motion) -> Option<Estimate> {
        let mut directions = Vec::new();
        let (mut block, mut segments) = (0, 0);
        for segment in &motion.segments {
            let found = self.directions(motion, segment);
            segments += usize::from(!found.is_empty());
            for part in found.chunks(BLOCK) {
                directions.extend(part.iter().map(|one| Directions { block, ..*one }));
                block += 1;
            }
        }
        if block < 2 * UNKNOWNS {
            return None;
        }
        let mut offset = turned_by(&directions);
        let mut turned = turn_of(&directions, offset)?;
        for _ in 0..2 {
            offset += turned.angle;
            turned = turn_of(&directions, offset)?;
        }
        (turned.r2 > DIRECTION_R2).then_some(Estimate { offset, error: turned.error, is_constant: true, segments })
    }

    /// Pairs of directions of one segment.
    fn directions(&self, motion: &Motion, segment: &std::ops::Range<usize>) -> Vec<Directions> {
        let (lag, every) = (steps_of(LAG_S, motion), steps_of(EVERY_S, motion));
        if segment.len() <= lag {
            return Vec::new();
        }
        let starts = (segment.start..segment.end - lag).step_by(every);
        let found: Vec<Directions> = match self.by {
            Comparison::Turning => {
                let forces: Vec<[f64; 2]> = segment.clone().map(|k| force_over_ground(motion, k)).collect();
                starts.map(|first| turning(motion, first, &forces[first - segment.start..][..=lag])).collect()
            }
            _ => starts.map(|k| flight(motion, k)).collect(),
        };
        found.into_iter().filter(Directions::is_finite).collect()
    }

    /// What the recording says.
    pub(super) fn judge(&self, motion: &Motion) -> Outcome {
        if !self.applies(motion) {
            return Outcome::Absent;
        }
        let Some(Estimate { offset, error, is_constant, segments }) = self.estimate(motion) else {
            return Outcome::Undetermined;
        };
        let figures = Figures { slope: offset, r2: 1.0, disagreement: 4.0, segments, predicted: true };
        match offset.abs() > self.least_rad {
            true if is_constant && offset.abs() > SIGNIFICANT * error && offset.abs() < LARGEST_RAD => {
                Outcome::Differs(figures)
            }
            true => Outcome::Undetermined,
            false => Outcome::Fits(figures),
        }
    }

    /// The angle and what it should be, over the longest segment that tells; of directions the side to the east.
    pub(super) fn trace(&self, motion: &Motion) -> Option<Trace> {
        if self.is_of_directions() {
            let segment = most_telling(motion, |segment| self.directions(motion, segment).len() as f64)?;
            let directions = self.directions(motion, &segment).into_iter();
            return Some(Trace::new(directions.map(|one| (one.time_s, one.says[1], one.is[1]))).without_means());
        }
        let segment = most_telling(motion, |segment| self.pairs(motion, segment).len() as f64)?;
        let pairs = self.pairs(motion, &segment).into_iter();
        Some(Trace::new(pairs.map(|(k, should, is)| (motion.time_s[k], is, should))))
    }
}

/// The offset of an angle that contradicts the others, rad.
pub(super) fn offset_of(role: Role, motion: &Motion) -> Option<f64> {
    let found = OFFSETS.iter().filter(|offset| offset.role == role).map(|offset| offset.judge(motion));
    let differing =
        found.filter_map(|outcome| if let Outcome::Differs(figures) = outcome { Some(figures) } else { None });
    differing.map(|figures| figures.slope).next()
}

/// Whether nothing but the vane explains an offset of an angle of attack, and what else may: a vertical wind, a pitch angle off by as much.
pub(super) fn beside_vane(offset: f64, motion: &Motion) -> (bool, String) {
    let speeds = motion.column(TrueAirspeed).unwrap_or_default();
    let inside = motion.segments.iter().flat_map(Clone::clone).map(|k| speeds[k]).filter(|speed| speed.is_finite());
    let wind_m_s = median(&mut inside.collect::<Vec<_>>()).unwrap_or(f64::NAN) * offset.sin();
    let ends = motion.segments.first().zip(motion.segments.last());
    let span_s = ends.map_or(0.0, |(first, last)| motion.time_s[last.end - 1] - motion.time_s[first.start]);
    let is_long = span_s > LONG_FLIGHT_S && motion.segments.len() >= LONG_FLIGHT_SEGMENTS;
    let least_m_s = if is_long { MEAN_WIND_M_S } else { LASTING_WIND_M_S };
    let degrees = offset.to_degrees();
    let side = if wind_m_s < 0.0 { "downward" } else { "upward" };
    let text = format!(
        "; one comparison: vane offset {degrees:+.1} deg, pitch offset {:+.1} deg or {side} wind {:.1} m/s",
        -degrees,
        wind_m_s.abs()
    );
    (offset.abs() > CERTAIN_RAD && wind_m_s.abs() > least_m_s, text)
}

/// What an offset of a heading looks like, in words.
pub(super) fn magnetic(offset: f64) -> String {
    let (degrees, side) = (offset.abs().to_degrees(), if offset > 0.0 { "west" } else { "east" });
    format!("probably a magnetic heading, not true, if the variation is {degrees:.1} deg {side}")
}

/// A vector to the north and the east, as it is and as the heading says, with what else may be between them.
#[derive(Clone, Copy, Debug)]
struct Directions {
    time_s: f64,
    is: [f64; 2],
    says: [f64; 2],
    /// Vectors of which a part may be in `is`: those turn with the heading for specific force, those of the wind do not.
    others: [[f64; 2]; UNKNOWNS - 1],
    /// Those before turn with the heading, the rest do not.
    turning: usize,
    block: usize,
}

impl Directions {
    fn is_finite(&self) -> bool {
        self.is.iter().chain(&self.says).chain(self.others.iter().flatten()).all(|value| value.is_finite())
    }
}

/// A vector of body axes to the north and the east.
fn over_ground(motion: &Motion, k: usize, body: [f64; 3]) -> [f64; 2] {
    let [north, east, _] = in_north_east_down(motion, k, body);
    [north, east]
}

/// Specific force to the north and the east.
fn force_over_ground(motion: &Motion, k: usize) -> [f64; 2] {
    over_ground(motion, k, [SpecificForceX, SpecificForceY, SpecificForceZ].map(|role| motion.at(role, k)))
}

/// The change of velocity over a lag and the mean of the specific `forces` of its steps; free of a delay of the velocity and of biases.
fn turning(motion: &Motion, first: usize, forces: &[[f64; 2]]) -> Directions {
    let lag = forces.len() - 1;
    let length_s = motion.step_s * lag as f64;
    let change = |role: Role| (motion.at(role, first + lag) - motion.at(role, first)) / length_s;
    let mean = |axis: usize| {
        let sum: f64 = forces.iter().map(|force| force[axis]).sum();
        (sum - 0.5 * (forces[0][axis] + forces[lag][axis])) / lag as f64
    };
    let middle = first + lag / 2;
    Directions {
        time_s: motion.time_s[middle],
        is: [change(VelocityNorth), change(VelocityEast)],
        says: [mean(0), mean(1)],
        others: [
            [0, 1].map(|axis| (forces[lag][axis] - forces[0][axis]) / length_s),
            over_ground(motion, middle, [1.0, 0.0, 0.0]),
            over_ground(motion, middle, [0.0, 1.0, 0.0]),
        ],
        turning: UNKNOWNS - 1,
        block: 0,
    }
}

/// The velocity over the ground and that relative to the air; free of a wind and of a factor on the airspeed.
fn flight(motion: &Motion, k: usize) -> Directions {
    let [north, east, _] = in_north_east_down(motion, k, air_velocity(motion, k));
    Directions {
        time_s: motion.time_s[k],
        is: [motion.at(VelocityNorth, k), motion.at(VelocityEast, k)],
        says: [north, east],
        others: [[north, east], [1.0, 0.0], [0.0, 1.0]],
        turning: 1,
        block: 0,
    }
}

/// The angle from one direction to the other about the means of both, rad.
fn turned_by(directions: &[Directions]) -> f64 {
    let count = directions.len() as f64;
    let mean = |of: fn(&Directions) -> [f64; 2]| {
        [0, 1].map(|axis| directions.iter().map(|one| of(one)[axis]).sum::<f64>() / count)
    };
    let (is, says) = (mean(|one| one.is), mean(|one| one.says));
    let (mut across, mut along) = (0.0, 0.0);
    for one in directions {
        let [a, b] = [[one.is[0] - is[0], one.is[1] - is[1]], [one.says[0] - says[0], one.says[1] - says[1]]];
        across += a[0] * b[1] - a[1] * b[0];
        along += a[0] * b[0] + a[1] * b[1];
    }
    across.atan2(along)
}

/// What is left of an angle between directions.
struct Turn {
    /// Angle, rad, and its standard error.
    angle: f64,
    error: f64,
    /// Squared correlation of the directions with it.
    r2: f64,
}

type Regressors = SMatrix<f64, 2, UNKNOWNS>;

/// The angle by which `says` is turned beyond `by`, by least squares with the other vectors; its error is that of blocks (sandwich).
fn turn_of(directions: &[Directions], by: f64) -> Option<Turn> {
    let turned = by.sin_cos();
    let rows: Vec<_> = directions.iter().map(|one| linearise(one, turned)).collect();
    let (mut normal, mut right) = (SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros(), SVector::<f64, UNKNOWNS>::zeros());
    for (regressors, apart) in &rows {
        normal += regressors.tr_mul(regressors);
        right += regressors.tr_mul(apart);
    }
    let inverse = normal.cholesky()?.inverse();
    let found = inverse * right;
    let (mut left, mut scatter) = (0.0, SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros());
    let residual = |(regressors, apart): &(Regressors, SVector<f64, 2>)| apart - regressors * found;
    let paired: Vec<_> = directions.iter().zip(&rows).collect();
    for block in paired.chunk_by(|a, b| a.0.block == b.0.block) {
        let mut score = SVector::<f64, UNKNOWNS>::zeros();
        for (_, row) in block {
            let residual = residual(row);
            left += residual.norm_squared();
            score += row.0.tr_mul(&residual);
        }
        scatter += score * score.transpose();
    }
    let covariance = inverse * scatter * inverse;
    let mean =
        directions.iter().map(|one| SVector::<f64, 2>::from(one.is)).sum::<SVector<f64, 2>>() / directions.len() as f64;
    let all: f64 = directions.iter().map(|one| (SVector::<f64, 2>::from(one.is) - mean).norm_squared()).sum();
    Some(Turn { angle: found[0], error: covariance[(0, 0)].max(0.0).sqrt(), r2: 1.0 - left / all })
}

/// Regressors of one pair of directions and what is left of it, both turned back by an angle with this sine and cosine.
fn linearise(one: &Directions, (sin, cos): (f64, f64)) -> (Regressors, SVector<f64, 2>) {
    let back = |[north, east]: [f64; 2]| SVector::from([cos * north + sin * east, cos * east - sin * north]);
    let says = back(one.says);
    let others: [SVector<f64, 2>; UNKNOWNS - 1] = std::array::from_fn(|index| {
        let other = one.others[index];
        if index < one.turning { back(other) } else { SVector::from(other) }
    });
    let across = SVector::from([says[1], -says[0]]);
    (Regressors::from_columns(&[across, others[0], others[1], others[2]]), SVector::from(one.is) - says)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "seconds over steps of more than 0.01 s")]
fn steps_of(seconds: f64, motion: &Motion) -> usize {
    ((seconds / motion.step_s).round() as usize).max(1)
}

/// `theta - asin(climb / V)` with wings level, rad; not a number in a bank.
fn theta_less_path(motion: &Motion, k: usize, half: usize) -> f64 {
    if motion.at(BankAngle, k).abs() > LEVEL_RAD {
        return f64::NAN;
    }
    let climb = if motion.has(VelocityDown) {
        -motion.at(VelocityDown, k)
    } else {
        let change = motion.at(Altitude, k + half) - motion.at(Altitude, k - half);
        change / (2.0 * half as f64 * motion.step_s)
    };
    motion.at(PitchAngle, k) - (climb / motion.at(TrueAirspeed, k)).asin()
}
