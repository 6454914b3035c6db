//! Where the accelerometers are, by what the velocities say.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::motion::{Motion, in_north_east_down};
use super::relations::air_over_ground;
use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::quantity::Role;
use crate::statistics::student_widening;

/// Lag over which velocities change, s: long for their noise, short for that of the attitude.
const LAG_S: f64 = 0.6;
/// Lags per lag: neighbours overlap.
const OVERLAP: usize = 4;
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
}

/// The place `r` of the accelerometers in body axes, from the point the velocity `v` is of, by least squares over lags `T`:
/// `v(t + T) - v(t) = int C (f - b) + g dt - [C (w x r)]_t^(t + T) - d [C f + g]_t^(t + T)`, since `C (w' x r + w x (w x r))` is the
/// slope of `C (w x r)`; without a velocity over the ground `v` is that relative to the air; `b` are biases, `d` the delay of the velocities.
/// Errors are those of leaving out blocks of rows in turn. `None` where a channel is missing or the segments are too few.
pub(super) fn place(motion: &Motion) -> Option<AccelerometerPlace> {
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

/// The same by one of the velocities.
fn place_by(motion: &Motion, by: TellingVelocity) -> Option<AccelerometerPlace> {
    let rows = Rows::of(motion, by);
    if rows.blocks.last().is_none_or(|last| last + 1 < LEAST_BLOCKS) || rows.change.len() < 10 * UNKNOWNS {
        return None;
    }
    let regressors = DMatrix::from_row_iterator(rows.change.len(), UNKNOWNS, rows.regressors.iter().flatten().copied());
    let change = DVector::from_vec(rows.change);
    let blocks = Blocks::new(&regressors, &change, &rows.blocks);
    let found = blocks.estimate(None)?;
    let errors = blocks.errors(&found)?;
    let residual = &change - &regressors * &found;
    let others = regressors.columns_range(3..).into_owned();
    let without = (others.transpose() * &others).cholesky()?.solve(&(others.transpose() * &change));
    let deviation = |residual: &DVector<f64>| (residual.norm_squared() / residual.len() as f64).sqrt();
    let from_velocity_m = std::array::from_fn(|axis| found[axis]);
    Some(AccelerometerPlace {
        by,
        from_velocity_m,
        felt_part: felt_part(motion, from_velocity_m),
        errors_m: std::array::from_fn(|axis| errors[axis]),
        second: None,
        residual_m_s: deviation(&residual),
        residual_without_m_s: deviation(&(&change - others * without)),
    })
}

/// Normal equations of blocks of rows that share their errors.
struct Blocks {
    each: Vec<(DMatrix<f64>, DVector<f64>)>,
}

impl Blocks {
    fn new(regressors: &DMatrix<f64>, change: &DVector<f64>, blocks: &[usize]) -> Self {
        let mut start = 0;
        let block = |block: &[usize]| {
            let (x, z) = (regressors.rows(start, block.len()), change.rows(start, block.len()));
            start += block.len();
            (x.tr_mul(&x), x.tr_mul(&z))
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
    let deviation = |values: &[f64]| {
        let steps = motion.segments.iter().flat_map(Clone::clone).map(|k| values[k]).filter(|value| value.is_finite());
        let values: Vec<f64> = steps.collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    };
    let felt = felt(motion, arm);
    let part = |axis: usize| deviation(&felt[axis]) / deviation(motion.column(FORCES[axis]).unwrap_or_default());
    (1..3).map(part).fold(0.0, f64::max)
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
    fn of(motion: &Motion, by: TellingVelocity) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a lag over steps of at least 0.04 s"
        )]
        let steps = |length_s: f64| (length_s / motion.step_s).round().max(1.0) as usize;
        let (lag, block) = (steps(LAG_S), steps(BLOCK_S));
        let mut rows = Self::default();
        let mut first_block = 0;
        for segment in &motion.segments {
            let steps: Vec<Step> = segment.clone().map(|k| Step::of(motion, k)).collect();
            for start in (0..steps.len().saturating_sub(lag)).step_by(lag.div_ceil(OVERLAP)) {
                let first = segment.start + start;
                let (before, after) = (velocity(motion, by, first), velocity(motion, by, first + lag));
                let changed =
                    std::array::from_fn(|axis| after[axis].zip(before[axis]).map(|(after, before)| after - before));
                rows.add(&steps[start..=start + lag], changed, motion.step_s, first_block + start / block);
            }
            first_block = rows.blocks.last().map_or(first_block, |last| last + 1);
        }
        rows
    }

    /// Rows of one lag: one per recorded component of the velocity, which `changed` over it.
    fn add(&mut self, steps: &[Step], changed: [Option<f64>; 3], step_s: f64, block: usize) {
        let [first, .., last] = steps else { return };
        let weight = |k: usize| if k == 0 || k + 1 == steps.len() { 0.5 * step_s } else { step_s };
        let (mut gained, mut turned) = (Vector3::zeros(), Matrix3::zeros());
        for (k, step) in steps.iter().enumerate() {
            gained += step.acceleration * weight(k);
            turned += step.rotation * weight(k);
        }
        let arm = last.arm - first.arm;
        let delayed = last.acceleration - first.acceleration;
        for (axis, changed) in changed.into_iter().enumerate().filter_map(|(axis, changed)| Some((axis, changed?))) {
            let change = changed - gained[axis];
            let row: [f64; UNKNOWNS] = std::array::from_fn(|k| match k {
                0..3 => -arm[(axis, k)],
                3..6 => turned[(axis, k - 3)],
                _ => delayed[axis],
            });
            if change.is_finite() && row.iter().all(|value| value.is_finite()) {
                self.change.push(change);
                self.regressors.push(row);
                self.blocks.push(block);
            }
        }
    }
}

/// The velocity that tells, north, east and down, m/s, as far as it is recorded.
fn velocity(motion: &Motion, by: TellingVelocity, k: usize) -> [Option<f64>; 3] {
    match by {
        TellingVelocity::Ground => VELOCITIES.map(|role| motion.has(role).then(|| motion.at(role, k))),
        TellingVelocity::Air => air_over_ground(motion, k).map(Some),
    }
}

/// What the recording tells at one step.
struct Step {
    /// From body axes to north, east and down.
    rotation: Matrix3<f64>,
    /// Acceleration over the ground of where the accelerometers are, north, east and down, m/s².
    acceleration: Vector3<f64>,
    /// The matrix of `C (w x r)`, rad/s.
    arm: Matrix3<f64>,
}

impl Step {
    fn of(motion: &Motion, k: usize) -> Self {
        let in_earth = |axis: [f64; 3]| Vector3::from(in_north_east_down(motion, k, axis));
        let rotation = Matrix3::from_columns(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(in_earth));
        let at = |roles: [Role; 3]| roles.map(|role| motion.at(role, k));
        let force = at(FORCES);
        let rates = Vector3::from(at([Role::RollRate, Role::PitchRate, Role::YawRate]));
        Self {
            rotation,
            acceleration: in_earth(force) + Vector3::new(0.0, 0.0, STANDARD_GRAVITY_M_S2),
            arm: rotation * rates.cross_matrix(),
        }
    }
}
