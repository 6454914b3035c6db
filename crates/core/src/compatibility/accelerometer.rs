//! Where the accelerometers are, by what the velocities say.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::motion::{Motion, air_velocity, in_north_east_down};
use super::relations::air_over_ground;
use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::prep::white_noise_deviation;
use crate::quantity::Role;
use crate::series::{Recording, Series};
use crate::statistics::{median_step, student_widening};

/// Lag over which velocities change, s: long for their noise, short for that of the attitude.
const LAG_S: f64 = 0.6;
/// Longest lag of a velocity that is recorded less often, s.
const LONGEST_LAG_S: f64 = 2.5;
/// Lags per lag: neighbours overlap.
const OVERLAP: f64 = 4.0;
/// Times this near to each other are the same, s.
const TOLERANCE_S: f64 = 1e-6;
/// Steps in which the delay of the ground velocity is found, the change below which no further one is taken, and the largest delay, s.
const DELAY_STEPS: usize = 4;
const CONVERGED_S: f64 = 0.002;
const LARGEST_DELAY_S: f64 = 1.0;
/// Delays from which it is sought beside none, s.
const TRIED_DELAYS_S: [f64; 7] = [-0.1, 0.05, 0.1, 0.2, 0.3, 0.45, 0.6];
/// Least delay of the ground velocity that is taken off it for a comparison with other channels, s.
const LEAST_DELAY_S: f64 = 0.05;
/// Rows that share their errors, s: the standard errors are of blocks this long.
const BLOCK_S: f64 = 10.0;
/// Least blocks: fewer do not tell how the estimate scatters.
const LEAST_BLOCKS: usize = 4;
/// Unknowns: place, bias, delay of the velocities.
const UNKNOWNS: usize = 7;

/// Least ratio of the deviations without and with the place that leaves no doubt of it.
const CLEAR_RATIO: f64 = 1.5;
/// Standard errors within which a place is none.
const SIGNIFICANT: f64 = 5.0;

/// Ratio of the deviations with a specific force reversed and as recorded, below which its recorded sign is wrong. On three aircraft it was
/// 1.15 to 5.3 without a fault and 0.34, 0.51 and 0.74 with `ay` reversed; slopes show the last of these.
const REVERSED_RATIO: f64 = 0.7;

/// Roles without which there is no estimate, beside one velocity.
const NEEDED: [Role; 9] = [
    Role::SpecificForceX,
    Role::SpecificForceY,
    Role::SpecificForceZ,
    Role::RollRate,
    Role::PitchRate,
    Role::YawRate,
    Role::BankAngle,
    Role::PitchAngle,
    Role::HeadingAngle,
];
/// Specific force along the body axes.
const FORCES: [Role; 3] = [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ];
/// Ground velocity, north, east and down.
const VELOCITIES: [Role; 3] = [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown];
/// Slowest attitude from which a position is estimated, Hz.
const SLOWEST_ATTITUDE_HZ: f64 = 4.0;
/// Velocity relative to the air.
const AIR: [Role; 3] = [Role::TrueAirspeed, Role::AngleOfAttack, Role::Sideslip];

/// The velocity that tells the place of the accelerometers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TellingVelocity {
    /// Over the ground, of the antenna.
    Ground,
    /// Relative to the air, of pitot tube and vanes; the wind is taken as constant over a lag.
    Air,
}

/// Place of the accelerometers from the point whose velocity is recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerometerPlace {
    /// Which velocity that is.
    pub by: TellingVelocity,
    /// Body axes, m.
    pub from_velocity_m: [f64; 3],
    /// Standard errors, m.
    pub errors_m: [f64; 3],
    /// Place and standard errors by the velocity relative to the air, m, where that is recorded beside the one over the ground.
    pub second: Option<([f64; 3], [f64; 3])>,
    /// Deviation of the changes of velocity over a lag from what specific force and attitude say, m/s, with the accelerometers there.
    pub residual_m_s: f64,
    /// The same with the accelerometers where the velocity is of.
    pub residual_without_m_s: f64,
    /// Deviation of what they feel of the turning over that of the specific force, across the flight.
    pub felt_part: f64,
    /// Delay of the velocity and its standard error, s.
    pub delay_s: (f64, f64),
}

/// The place `r` of the accelerometers in body axes, from the point the velocity `v` is of, by least squares over lags `T`:
/// `v(t + T) - v(t) = int C (f - b) + g dt - [C (w x r)]_t^(t + T) - d [C f + g]_t^(t + T)`, since `C (w' x r + w x (w x r))` is the
/// slope of `C (w x r)`; without a velocity over the ground `v` is that relative to the air; `b` are biases, `d` the delay of the velocities,
/// of those relative to the air in body axes: there `C (w x v)` is taken off the slope.
/// Errors are those of leaving out blocks of rows in turn. `None` where a channel is missing or the segments are too few.
pub(super) fn estimate_position(motion: &Motion) -> Option<AccelerometerPlace> {
    if !NEEDED.iter().all(|role| motion.has(*role)) {
        return None;
    }
    let over_ground = VELOCITIES.iter().any(|role| motion.has(*role));
    let in_air = AIR.iter().all(|role| motion.has(*role));
    let by_air = || in_air.then(|| place_by(motion, TellingVelocity::Air)).flatten();
    if !over_ground {
        return by_air();
    }
    let found = place_by(motion, TellingVelocity::Ground)?;
    let second = by_air().map(|second| (second.from_velocity_m, second.errors_m));
    Some(AccelerometerPlace { second, ..found })
}

/// Whether bank and pitch have samples often enough to turn specific forces by: between samples farther apart the error of the attitude
/// follows the motion, as the effect of a position does.
pub(super) fn has_fast_attitude(recording: &Recording) -> bool {
    [Role::BankAngle, Role::PitchAngle].iter().all(|role| {
        let Some(channel) = recording.role(*role) else { return false };
        let Series { time_s, .. } = channel.series.finite();
        median_step(&time_s).is_some_and(|step_s| step_s * SLOWEST_ATTITUDE_HZ < 1.0)
    })
}

/// Deviations of the changes of ground velocity, m/s, with a specific force as recorded and reversed, each with the accelerometers where it
/// leaves least; none unless they are clearly less reversed. As recorded another place hides a part of the sign, not all of it.
pub(super) fn reversed_residuals(motion: &Motion, force: Role) -> Option<[f64; 2]> {
    if !NEEDED.iter().chain(&VELOCITIES).all(|role| motion.has(*role)) {
        return None;
    }
    let residual = |motion: &Motion| Some(place_by(motion, TellingVelocity::Ground)?.residual_m_s);
    let residuals = [residual(motion)?, residual(&motion.clone().changed(force, |value| -value))?];
    (residuals[1] < REVERSED_RATIO * residuals[0]).then_some(residuals)
}

/// The same by one of the velocities.
fn place_by(motion: &Motion, by: TellingVelocity) -> Option<AccelerometerPlace> {
    let velocities = SegmentVelocity::of_segments(motion, by);
    let noise = arm_noise(motion);
    let mut found = place_at(&velocities, noise, 0.0)?;
    let mut delay_s = 0.0;
    // The delay of the ground velocity is too long for its slope alone, and in slow turns another place leaves little more than the delay does.
    if by == TellingVelocity::Ground {
        for tried_s in TRIED_DELAYS_S {
            if let Some(tried) =
                place_at(&velocities, noise, tried_s).filter(|tried| tried.residual_m_s < found.residual_m_s)
            {
                (delay_s, found) = (tried_s, tried);
            }
        }
        for _ in 0..DELAY_STEPS {
            if found.delay_s.abs() < CONVERGED_S {
                break;
            }
            delay_s = (delay_s + found.delay_s).clamp(-LARGEST_DELAY_S, LARGEST_DELAY_S);
            found = place_at(&velocities, noise, delay_s)?;
        }
    }
    let Fitted { from_velocity_m, errors_m, residual_m_s, residual_without_m_s, .. } = found;
    let felt_part = felt_part(motion, from_velocity_m);
    Some(AccelerometerPlace {
        by,
        from_velocity_m,
        errors_m,
        second: None,
        residual_m_s,
        residual_without_m_s,
        felt_part,
        delay_s: (delay_s + found.delay_s, found.delay_error_s),
    })
}

/// A place with the delay of the velocities beside the one they are taken with, s.
struct Fitted {
    from_velocity_m: [f64; 3],
    errors_m: [f64; 3],
    delay_s: f64,
    delay_error_s: f64,
    residual_m_s: f64,
    residual_without_m_s: f64,
}

fn place_at(velocities: &[SegmentVelocity], noise: [f64; 3], delay_s: f64) -> Option<Fitted> {
    let rows = Rows::collect(velocities, delay_s);
    if rows.blocks.last().is_none_or(|last| last + 1 < LEAST_BLOCKS) || rows.change.len() < 10 * UNKNOWNS {
        return None;
    }
    let regressors = DMatrix::from_row_iterator(rows.change.len(), UNKNOWNS, rows.regressors.iter().flatten().copied());
    let change = DVector::from_vec(rows.change);
    let blocks = Blocks::new(&regressors, &change, &rows.blocks, noise);
    let found = blocks.estimate(None)?;
    let errors = blocks.errors(&found)?;
    let residual = &change - &regressors * &found;
    let others = regressors.columns_range(3..).into_owned();
    let without = (others.transpose() * &others).cholesky()?.solve(&(others.transpose() * &change));
    let deviation = |residual: &DVector<f64>| (residual.norm_squared() / residual.len() as f64).sqrt();
    Some(Fitted {
        from_velocity_m: std::array::from_fn(|axis| found[axis]),
        errors_m: std::array::from_fn(|axis| errors[axis]),
        delay_s: -found[UNKNOWNS - 1],
        delay_error_s: errors[UNKNOWNS - 1],
        residual_m_s: deviation(&residual),
        residual_without_m_s: deviation(&(&change - others * without)),
    })
}

/// Square of the noise of a row's regressor by each coordinate of the place, in the mean of the three components of the velocity: of
/// `C (w x e)` at both ends of the lag.
fn arm_noise(motion: &Motion) -> [f64; 3] {
    let variance = |role: Role| {
        let rates = motion.column(role).unwrap_or_default();
        let series = Series { time_s: motion.time_s.clone(), values: rates.into() };
        white_noise_deviation(&series, false).map_or(0.0, |deviation| deviation.powi(2))
    };
    let [p, q, r] = [Role::RollRate, Role::PitchRate, Role::YawRate].map(variance);
    [q + r, p + r, p + q].map(|across| 2.0 / 3.0 * across)
}

/// Normal equations of blocks of rows that share their errors.
struct Blocks {
    each: Vec<(DMatrix<f64>, DVector<f64>)>,
}

impl Blocks {
    /// With the squares of the noise of the first regressors taken off: in slow turns the place hangs together with the delay, and the noise of
    /// the rates alone would make it too short.
    fn new(regressors: &DMatrix<f64>, change: &DVector<f64>, blocks: &[usize], noise: [f64; 3]) -> Self {
        let mut start = 0;
        let block = |block: &[usize]| {
            let (x, z) = (regressors.rows(start, block.len()), change.rows(start, block.len()));
            start += block.len();
            let mut square = x.tr_mul(&x);
            (0..3).for_each(|axis| square[(axis, axis)] -= noise[axis] * block.len() as f64);
            (square, x.tr_mul(&z))
        };
        Self { each: blocks.chunk_by(|a, b| a == b).map(block).collect() }
    }

    /// The estimate of all blocks but one; none where they do not determine it.
    fn estimate(&self, without: Option<usize>) -> Option<DVector<f64>> {
        let mut normal = DMatrix::zeros(UNKNOWNS, UNKNOWNS);
        let mut right = DVector::zeros(UNKNOWNS);
        for (index, (square, product)) in self.each.iter().enumerate() {
            if Some(index) != without {
                normal += square;
                right += product;
            }
        }
        Some(normal.cholesky()?.solve(&right))
    }

    /// Standard errors by the jackknife, widened so that two of them hold 95 % with as few blocks as there are (Student).
    fn errors(&self, found: &DVector<f64>) -> Option<DVector<f64>> {
        let count = self.each.len();
        let mut squares = DVector::zeros(UNKNOWNS);
        for without in 0..count {
            squares += (self.estimate(Some(without))? - found).map(|apart| apart * apart);
        }
        let share = (count - 1) as f64 / count as f64;
        let widening = student_widening(count)?;
        Some(squares.map(|square| widening * (share * square).sqrt()))
    }
}

impl AccelerometerPlace {
    /// Whether the velocity over the ground shows it so clearly that nothing else can be meant.
    pub(super) fn is_clear(&self) -> bool {
        let is_significant = |(place, error): (&f64, &f64)| place.abs() > SIGNIFICANT * error;
        self.by == TellingVelocity::Ground
            && self.residual_without_m_s > CLEAR_RATIO * self.residual_m_s
            && self.from_velocity_m.iter().zip(&self.errors_m).any(is_significant)
    }

    /// The motion with the velocities over the ground as early as they are late; none where that is not significant or short.
    pub(super) fn with_punctual_velocities(&self, motion: &Motion) -> Option<Motion> {
        let (delay_s, error_s) = self.delay_s;
        let is_late = delay_s.abs() > (SIGNIFICANT * error_s).max(LEAST_DELAY_S);
        let whole = 0..motion.time_s.len();
        (self.by == TellingVelocity::Ground && is_late)
            .then(|| motion.earlier(motion, std::slice::from_ref(&whole), &VELOCITIES, delay_s / motion.step_s))
    }

    /// The motion with the specific force of the point whose velocity is recorded.
    pub(super) fn moved(&self, motion: Motion) -> Motion {
        let columns = felt(&motion, self.from_velocity_m);
        FORCES.into_iter().zip(columns).fold(motion, |motion, (role, felt)| {
            let force = motion.column(role).unwrap_or_default();
            let moved = force.iter().zip(felt).map(|(force, felt)| force - felt).collect();
            motion.with(role, moved)
        })
    }
}

/// What accelerometers at `arm` feel of the turning, `w' x r + w x (w x r)`, m/s², along the body axes; not a number outside the segments.
fn felt(motion: &Motion, arm: [f64; 3]) -> [Vec<f64>; 3] {
    let arm = Vector3::from(arm);
    let rates =
        |k: usize| Vector3::from([Role::RollRate, Role::PitchRate, Role::YawRate].map(|role| motion.at(role, k)));
    let mut columns = [const { Vec::new() }; 3];
    columns.iter_mut().for_each(|column| column.resize(motion.time_s.len(), f64::NAN));
    for segment in &motion.segments {
        for k in segment.clone() {
            let (before, after) = (k.saturating_sub(1).max(segment.start), (k + 1).min(segment.end - 1));
            let length_s = motion.step_s * (after - before).max(1) as f64;
            let (turn, slope) = (rates(k), (rates(after) - rates(before)) / length_s);
            let felt = slope.cross(&arm) + turn.cross(&turn.cross(&arm));
            (0..3).for_each(|axis| columns[axis][k] = felt[axis]);
        }
    }
    columns
}

/// Deviation of what accelerometers at `arm` feel of the turning over that of the specific force, of the two axes across the flight the
/// larger.
fn felt_part(motion: &Motion, arm: [f64; 3]) -> f64 {
    let felt = felt(motion, arm);
    let part = |axis: usize| {
        deviation_in_flight(motion, &felt[axis])
            / deviation_in_flight(motion, motion.column(FORCES[axis]).unwrap_or_default())
    };
    (1..3).map(part).fold(0.0, f64::max)
}

fn deviation_in_flight(motion: &Motion, values: &[f64]) -> f64 {
    let steps = motion.segments.iter().flat_map(Clone::clone).map(|k| values[k]).filter(|value| value.is_finite());
    let values: Vec<f64> = steps.collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Rows of the regression: what the velocity changed by beyond the specific force, and what that hangs on.
#[derive(Default)]
struct Rows {
    change: Vec<f64>,
    regressors: Vec<[f64; UNKNOWNS]>,
    /// Block of each row, counted from zero.
    blocks: Vec<usize>,
}

impl Rows {
    /// Those of velocities that are late by `delay_s`.
    fn collect(velocities: &[SegmentVelocity], delay_s: f64) -> Self {
        let mut rows = Self::default();
        for segment in velocities {
            let first_block = rows.blocks.last().map_or(0, |last| last + 1);
            for (axis, samples) in segment.samples.iter().enumerate() {
                rows.add(&segment.inertial, (axis, samples), delay_s, first_block);
            }
        }
        rows.sort();
        rows
    }

    /// Rows of the samples of one component of the velocity.
    fn add(&mut self, inertial: &Inertial, (axis, samples): (usize, &[[f64; 2]]), delay_s: f64, first_block: usize) {
        let mut next_s = f64::NEG_INFINITY;
        for (index, [start_s, before]) in samples.iter().enumerate() {
            if *start_s < next_s {
                continue;
            }
            let later = samples[index..].iter().find(|[time_s, _]| *time_s > start_s + LAG_S - TOLERANCE_S);
            let Some([end_s, after]) = later.filter(|[end_s, _]| *end_s < start_s + LONGEST_LAG_S) else { continue };
            next_s = start_s + LAG_S / OVERLAP - TOLERANCE_S;
            let Some((first, last)) = inertial.at(start_s - delay_s).zip(inertial.at(end_s - delay_s)) else {
                continue;
            };
            let change = after - before - (last.gained - first.gained)[axis];
            let (arm, turned) = (last.arm - first.arm, last.turned - first.turned);
            let row: [f64; UNKNOWNS] = std::array::from_fn(|k| match k {
                0..3 => -arm[(axis, k)],
                3..6 => turned[(axis, k - 3)],
                _ => (last.delayed - first.delayed)[axis],
            });
            if first.pauses == last.pauses && change.is_finite() && row.iter().all(|value| value.is_finite()) {
                self.change.push(change);
                self.regressors.push(row);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a few blocks of a segment"
                )]
                self.blocks.push(first_block + ((start_s - inertial.start_s) / BLOCK_S) as usize);
            }
        }
    }

    /// Block after block.
    fn sort(&mut self) {
        let mut order: Vec<usize> = (0..self.blocks.len()).collect();
        order.sort_by_key(|row| self.blocks[*row]);
        self.change = order.iter().map(|row| self.change[*row]).collect();
        self.regressors = order.iter().map(|row| self.regressors[*row]).collect();
        self.blocks = order.iter().map(|row| self.blocks[*row]).collect();
    }
}

/// Samples of a velocity in one segment, and what the inertial channels say there.
struct SegmentVelocity {
    inertial: Inertial,
    /// Time, s, and value, m/s, of each component, north, east and down.
    samples: [Vec<[f64; 2]>; 3],
}

impl SegmentVelocity {
    /// Of each segment: over the ground the samples as they were recorded, for straight lines between them are not what was flown.
    fn of_segments(motion: &Motion, by: TellingVelocity) -> Vec<Self> {
        motion
            .segments
            .iter()
            .filter(|segment| !segment.is_empty())
            .map(|segment| Self::of_segment(motion, by, segment))
            .collect()
    }

    fn of_segment(motion: &Motion, by: TellingVelocity, segment: &std::ops::Range<usize>) -> Self {
        let times = &motion.time_s[segment.clone()];
        let within = |axis: usize| -> Vec<[f64; 2]> {
            match by {
                TellingVelocity::Ground => motion.ground_velocity(axis, (times[0], times[times.len() - 1])),
                TellingVelocity::Air => {
                    segment.clone().map(|k| [motion.time_s[k], air_over_ground(motion, k)[axis]]).collect()
                }
            }
        };
        Self { inertial: Inertial::new(motion, by, segment.clone()), samples: std::array::from_fn(within) }
    }
}

/// What the inertial channels say over one segment, on even steps.
struct Inertial {
    start_s: f64,
    step_s: f64,
    sums: Vec<Integrals>,
}

/// The same up to one time.
#[derive(Clone, Copy)]
struct Integrals {
    /// Integral of the acceleration, m/s.
    gained: Vector3<f64>,
    /// Integral of the rotation from body axes, s.
    turned: Matrix3<f64>,
    /// The matrix of `C (w x r)`, rad/s.
    arm: Matrix3<f64>,
    /// Slope of the velocity as its sensors show it, north, east and down, m/s²: a delay shows this times its length too little.
    delayed: Vector3<f64>,
    /// Pauses of the recording so far.
    pauses: usize,
}

impl Inertial {
    fn new(motion: &Motion, by: TellingVelocity, segment: std::ops::Range<usize>) -> Self {
        let steps: Vec<Step> = segment.clone().map(|k| Step::measure(motion, by, k)).collect();
        let (mut gained, mut turned, mut pauses) = (Vector3::zeros(), Matrix3::zeros(), 0);
        let mut sums: Vec<Integrals> = Vec::with_capacity(steps.len());
        for (k, step) in steps.iter().enumerate() {
            if let Some(before) = k.checked_sub(1).map(|before| &steps[before]) {
                let gain = 0.5 * motion.step_s * (before.acceleration + step.acceleration);
                if gain.iter().all(|value| value.is_finite()) {
                    gained += gain;
                    turned += 0.5 * motion.step_s * (before.rotation + step.rotation);
                } else {
                    pauses += 1;
                }
            }
            sums.push(Integrals { gained, turned, arm: step.arm, delayed: step.delayed, pauses });
        }
        Self { start_s: motion.time_s[segment.start], step_s: motion.step_s, sums }
    }

    /// At a time, between two steps by a straight line; none outside the segment.
    fn at(&self, time_s: f64) -> Option<Integrals> {
        let steps = (time_s - self.start_s) / self.step_s;
        if steps.is_nan() || steps < -TOLERANCE_S {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a step of the segment")]
        let before = (steps + TOLERANCE_S) as usize;
        let part = (steps - before as f64).max(0.0);
        let first = self.sums.get(before)?;
        if part < TOLERANCE_S {
            return Some(*first);
        }
        let next = self.sums.get(before + 1)?;
        Some(Integrals {
            gained: first.gained.lerp(&next.gained, part),
            turned: first.turned + part * (next.turned - first.turned),
            arm: first.arm + part * (next.arm - first.arm),
            delayed: first.delayed.lerp(&next.delayed, part),
            pauses: next.pauses,
        })
    }
}

/// What the recording tells at one step.
struct Step {
    /// From body axes to north, east and down.
    rotation: Matrix3<f64>,
    /// Acceleration over the ground of where the accelerometers are, north, east and down, m/s².
    acceleration: Vector3<f64>,
    /// Slope of the velocity as its sensors show it, north, east and down, m/s².
    delayed: Vector3<f64>,
    /// The matrix of `C (w x r)`, rad/s.
    arm: Matrix3<f64>,
}

impl Step {
    fn measure(motion: &Motion, by: TellingVelocity, k: usize) -> Self {
        let in_earth = |axis: [f64; 3]| Vector3::from(in_north_east_down(motion, k, axis));
        let rotation = Matrix3::from_columns(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(in_earth));
        let at = |roles: [Role; 3]| roles.map(|role| motion.at(role, k));
        let force = at(FORCES);
        let rates = Vector3::from(at([Role::RollRate, Role::PitchRate, Role::YawRate]));
        let acceleration = in_earth(force) + Vector3::new(0.0, 0.0, STANDARD_GRAVITY_M_S2);
        // Vanes and airspeed are late in body axes, which turn in the meantime.
        let turning = match by {
            TellingVelocity::Ground => Vector3::zeros(),
            TellingVelocity::Air => rotation * rates.cross(&Vector3::from(air_velocity(motion, k))),
        };
        Self { rotation, acceleration, delayed: acceleration - turning, arm: rotation * rates.cross_matrix() }
    }
}
