//! Channels of a recording in flight on even steps, cut into segments.

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use crate::prep::{between_samples, finest_step, stretches};
use crate::quantity::{Dimension, Role};
use crate::series::{Channel, Recording, Series, TimeRange, gap_threshold_s};
use crate::statistics::{extent, median_step, ranked};

/// Longest segment, s.
const LONGEST_SEGMENT_S: f64 = 40.0;
/// Shortest segment, s: cut manoeuvres of small aircraft are hardly longer.
const SHORTEST_SEGMENT_S: f64 = 2.0;
/// Finest step, s: manoeuvres take tenths of a second.
const FINEST_STEP_S: f64 = 0.04;
/// Segments kept of each channel: those in which it moves most.
const KEPT_PER_CHANNEL: usize = 3;
/// An aircraft flies where its speed is above this part of what it has most of the time.
const FLYING: f64 = 0.5;

/// Roles whose channels are compared; the others play no part in any relation.
pub(super) const COMPARED: [Role; 28] = [
    Role::SpecificForceX,
    Role::SpecificForceY,
    Role::SpecificForceZ,
    Role::RollRate,
    Role::PitchRate,
    Role::YawRate,
    Role::BankAngle,
    Role::PitchAngle,
    Role::HeadingAngle,
    Role::VelocityNorth,
    Role::VelocityEast,
    Role::VelocityDown,
    Role::PositionNorth,
    Role::PositionEast,
    Role::PositionDown,
    Role::TrueAirspeed,
    Role::AngleOfAttack,
    Role::Sideslip,
    Role::Aileron,
    Role::Elevator,
    Role::Rudder,
    Role::Altitude,
    Role::GpsAltitude,
    Role::CalibratedAirspeed,
    Role::Mach,
    Role::StaticPressure,
    Role::AirTemperature,
    Role::AirDensity,
];

/// Roles whose samples set the step, those that move fastest first.
const FAST: [Role; 15] = [
    Role::RollRate,
    Role::PitchRate,
    Role::YawRate,
    Role::SpecificForceX,
    Role::SpecificForceY,
    Role::SpecificForceZ,
    Role::BankAngle,
    Role::PitchAngle,
    Role::HeadingAngle,
    Role::Elevator,
    Role::Aileron,
    Role::TrueAirspeed,
    Role::VelocityNorth,
    Role::Altitude,
    Role::AngleOfAttack,
];

/// Angles whose sine and cosine enter the relations.
const ANGLES: [Role; 5] = [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle, Role::AngleOfAttack, Role::Sideslip];

/// Finest step between samples, as a part of the range of a column, from which the rounding of a recorder matters.
const COARSE: f64 = 1.0 / 256.0;

/// A number of steps this near to a whole one is that.
const WHOLE_STEP: f64 = 1e-9;

/// Sine and cosine at every step, formed when they are first asked for.
type Sines = OnceLock<Arc<[(f64, f64)]>>;

/// Compared channels on even steps, segment after segment.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    pub step_s: f64,
    /// Steps of each segment.
    pub segments: Vec<Range<usize>>,
    /// Time of every step, s.
    pub time_s: Arc<[f64]>,
    /// Columns by role, not a number where nothing was recorded; headings and bank angles run on past a turn.
    columns: Vec<Option<Arc<[f64]>>>,
    /// Those of [`ANGLES`].
    sines: [Sines; ANGLES.len()],
    /// Finest step between samples by role, where it is more than [`COARSE`] of the range of the column; zero elsewhere.
    resolutions: Vec<f64>,
    /// The turn that the recorded bank covers, as it was read; its column runs on beyond that.
    bank_turn: Option<f64>,
    /// Velocity over the ground as it was recorded, north, east and down.
    ground_velocity: [Option<Series>; 3],
}

/// Rate and length of the clock everything is compared on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pace {
    /// Samples per second of the fastest channel that matters.
    pub rate_hz: f64,
    /// From its first to its last sample, s.
    pub span_s: f64,
}

/// The channel whose stamps set the step.
pub(super) fn reference(recording: &Recording) -> Option<&Channel> {
    let mut present = FAST.iter().chain(&COMPARED).filter_map(|role| recording.role(*role));
    present.find(|channel| channel.series.time_s.len() > 1)
}

fn median_step_s(time_s: &[f64]) -> Option<f64> {
    median_step(time_s).filter(|step| *step > 0.0)
}

/// Rate and span of a recording's clock; `None` without a channel of two samples.
pub(super) fn pace(recording: &Recording) -> Option<Pace> {
    let time_s = &reference(recording)?.series.time_s;
    let span_s = time_s[time_s.len() - 1] - time_s[0];
    Some(Pace { rate_hz: 1.0 / median_step_s(time_s)?, span_s })
}

impl Motion {
    /// The channels of `recording` in flight, every stamp multiplied by `time_factor`; `None` where nothing is long enough.
    pub(super) fn new(recording: &Recording, time_factor: f64) -> Option<Self> {
        let scaled = |series: &Series| Series {
            time_s: if time_factor == 1.0 {
                Arc::clone(&series.time_s)
            } else {
                series.time_s.iter().map(|t| t * time_factor).collect()
            },
            values: Arc::clone(&series.values),
        };
        let stamps = scaled(&reference(recording)?.series).time_s;
        let step_s = median_step_s(&stamps)?.max(FINEST_STEP_S);
        let starts = segments(&stamps, step_s, |role| recording.role(role).map(|channel| scaled(&channel.series)));
        let mut at_s = Vec::new();
        let mut ranges = Vec::new();
        for (start_s, steps) in starts {
            ranges.push(at_s.len()..at_s.len() + steps);
            at_s.extend((0..steps).map(|k| start_s + step_s * k as f64));
        }
        if ranges.is_empty() {
            return None;
        }
        let mut columns = vec![None; Role::ALL.len()];
        let mut resolutions = vec![0.0; Role::ALL.len()];
        for role in COMPARED {
            let Some(channel) = recording.role(role) else { continue };
            let mut series = scaled(&channel.series);
            if matches!(role, Role::BankAngle | Role::HeadingAngle) {
                series.values = unwrapped(&series.values).into();
            }
            let column = between_samples(&series, &at_s, recording.max_gap_s, false);
            if column.iter().any(|value| value.is_finite()) {
                resolutions[role as usize] = coarse_step(&series.values, &column);
                columns[role as usize] = Some(column.into());
            }
        }
        let moving = most_moving(&columns, &ranges);
        let segments = if moving.is_empty() { ranges } else { moving };
        let ground_velocity = [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown];
        let ground_velocity = ground_velocity.map(|role| recording.role(role).map(|channel| scaled(&channel.series)));
        let bank_turn = recording.role(Role::BankAngle).and_then(|channel| find_turn(&channel.series.values));
        let (time_s, sines) = (at_s.into(), Default::default());
        Some(Self { step_s, segments, time_s, columns, sines, resolutions, bank_turn, ground_velocity })
    }

    /// Finest step between samples of a role that a recorder rounds coarsely; zero of any other.
    pub(super) fn resolution(&self, role: Role) -> f64 {
        self.resolutions[role as usize]
    }

    /// Time, s, and value, m/s, of the samples of a component of the velocity over the ground between two times, as it was recorded.
    pub(super) fn ground_velocity(&self, axis: usize, (start_s, end_s): (f64, f64)) -> Vec<[f64; 2]> {
        let Some(series) = &self.ground_velocity[axis] else { return Vec::new() };
        let range = TimeRange { start_s, end_s }.indices(&series.time_s);
        let samples = series.time_s[range.clone()].iter().zip(&series.values[range]);
        samples.filter(|(_, value)| value.is_finite()).map(|(time_s, value)| [*time_s, *value]).collect()
    }

    /// The turn that an angle covers whose column runs on beyond it, as it was read.
    pub(super) fn turn(&self, role: Role) -> Option<f64> {
        self.bank_turn.filter(|_| role == Role::BankAngle)
    }

    /// Whether `role` is recorded.
    pub(super) fn has(&self, role: Role) -> bool {
        self.columns[role as usize].is_some()
    }

    /// Column of `role`.
    pub(super) fn column(&self, role: Role) -> Option<&[f64]> {
        self.columns[role as usize].as_deref()
    }

    /// Value of `role` at a step; zero where the recording lacks the role.
    pub(super) fn at(&self, role: Role, step: usize) -> f64 {
        self.columns[role as usize].as_ref().map_or(0.0, |column| column[step])
    }

    /// Sine and cosine of an angle at a step of a segment; those of zero where the recording lacks the role.
    pub(super) fn sin_cos(&self, role: Role, step: usize) -> (f64, f64) {
        let Some(column) = &self.columns[role as usize] else { return (0.0, 1.0) };
        let Some(index) = ANGLES.iter().position(|angle| *angle == role) else { return column[step].sin_cos() };
        self.sines_of(index, column)[step]
    }

    /// Sines and cosines of one of [`ANGLES`], not numbers outside the segments.
    fn sines_of(&self, index: usize, column: &[f64]) -> &Arc<[(f64, f64)]> {
        self.sines[index].get_or_init(|| {
            let mut formed = vec![(f64::NAN, f64::NAN); column.len()];
            for step in self.segments.iter().flat_map(Clone::clone) {
                formed[step] = column[step].sin_cos();
            }
            formed.into()
        })
    }

    fn set(&mut self, role: Role, column: Option<Arc<[f64]>>) {
        self.columns[role as usize] = column;
        if let Some(index) = ANGLES.iter().position(|angle| *angle == role) {
            self.sines[index] = Sines::new();
        }
    }

    /// The same with the column of `role` put through `change`.
    pub(super) fn changed(mut self, role: Role, change: impl Fn(f64) -> f64) -> Self {
        let column = self.column(role).map(|column| column.iter().map(|value| change(*value)).collect());
        self.set(role, column);
        let scaled = |length: f64| (change(length) - change(0.0)).abs();
        let step = &mut self.resolutions[role as usize];
        *step = scaled(*step);
        if role == Role::BankAngle {
            self.bank_turn = self.bank_turn.map(scaled);
        }
        self
    }

    /// The same with another column for `role`.
    pub(super) fn with(mut self, role: Role, column: Vec<f64>) -> Self {
        self.set(role, Some(column.into()));
        self
    }

    /// The steps of some ranges alone, one range behind the other; each is a segment.
    pub(super) fn part(&self, ranges: &[Range<usize>]) -> Self {
        let select = |column: &[f64]| -> Arc<[f64]> {
            ranges.iter().flat_map(|range| &column[range.clone()]).copied().collect()
        };
        let mut end = 0;
        let segments = ranges.iter().map(|range| {
            end += range.len();
            end - range.len()..end
        });
        let part = Self {
            step_s: self.step_s,
            segments: segments.collect(),
            time_s: select(&self.time_s),
            columns: self.columns.iter().map(|column| column.as_deref().map(select)).collect(),
            sines: Default::default(),
            resolutions: self.resolutions.clone(),
            bank_turn: self.bank_turn,
            ground_velocity: [const { None }; 3],
        };
        // What is moved against the rest many times shares the sines of the rest.
        for (index, role) in ANGLES.into_iter().enumerate() {
            part.column(role).into_iter().for_each(|column| drop(part.sines_of(index, column).clone()));
        }
        part
    }

    /// This [`part`](Self::part) of `whole` over `ranges` with the samples of some roles taken `steps` later, so that stamps too late
    /// by as much are right again; not a number where there is no sample.
    pub(super) fn earlier(&self, whole: &Self, ranges: &[Range<usize>], roles: &[Role], steps: f64) -> Self {
        let mut moved = self.clone();
        let whole_steps = (steps + WHOLE_STEP).floor();
        let part = if steps - whole_steps < WHOLE_STEP { 0.0 } else { steps - whole_steps };
        #[expect(clippy::cast_possible_truncation, reason = "a few seconds over steps of more than 0.01 s")]
        let by = whole_steps as isize;
        for role in roles {
            let Some(column) = whole.column(*role) else { continue };
            let at = |k: usize, by: isize| k.checked_add_signed(by).and_then(|k| column.get(k)).copied();
            let between = |k: usize| {
                let first = at(k, by)?;
                if part == 0.0 { Some(first) } else { Some(first + part * (at(k, by + 1)? - first)) }
            };
            let steps = || ranges.iter().flat_map(Clone::clone);
            let values: Arc<[f64]> = steps().map(|k| between(k).unwrap_or(f64::NAN)).collect();
            moved.set(*role, Some(Arc::clone(&values)));
            let angle = ANGLES.iter().position(|angle| angle == role).filter(|_| part == 0.0);
            if let Some(index) = angle {
                let sines = whole.sines_of(index, column);
                let known =
                    |k: usize| k.checked_add_signed(by).and_then(|k| sines.get(k)).filter(|(sin, _)| sin.is_finite());
                let pairs = steps().zip(values.iter());
                let pairs = pairs.map(|(k, value)| known(k).copied().unwrap_or_else(|| value.sin_cos()));
                moved.sines[index] = Sines::from(pairs.collect::<Arc<_>>());
            }
        }
        moved
    }

    /// The same with the columns of two roles exchanged.
    pub(super) fn swapped(mut self, one: Role, other: Role) -> Self {
        let [of_one, of_other] = [one, other].map(|role| self.columns[role as usize].take());
        self.set(one, of_other);
        self.set(other, of_one);
        self.resolutions.swap(one as usize, other as usize);
        self
    }
}

/// Finest step between samples where it is coarse against the range of the column; zero elsewhere.
fn coarse_step(samples: &[f64], column: &[f64]) -> f64 {
    let Some([least, greatest]) = extent(column) else { return 0.0 };
    let step = finest_step(samples);
    if step.is_finite() && step > COARSE * (greatest - least) { step } else { 0.0 }
}

/// Starts and numbers of steps of the segments of a flight.
fn segments(stamps: &[f64], step_s: f64, series: impl Fn(Role) -> Option<Series>) -> Vec<(f64, usize)> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive and far below the limits")]
    let steps_of = |length_s: f64| (length_s / step_s).floor() as usize;
    let (longest, shortest) = (steps_of(LONGEST_SEGMENT_S).max(200), steps_of(SHORTEST_SEGMENT_S).max(50));
    let speed = Role::AIRSPEEDS.into_iter().find_map(&series);
    let mut found = Vec::new();
    for stretch in stretches(stamps, gap_threshold_s(stamps).max(4.0 * step_s)) {
        let (start_s, end_s) = (stamps[stretch.start], stamps[stretch.end - 1]);
        let steps = steps_of(end_s - start_s) + 1;
        let parts = steps.div_ceil(longest).max(1);
        let length = steps / parts;
        if length >= shortest {
            found.extend((0..parts).map(|part| (start_s + step_s * (part * length) as f64, length)));
        }
    }
    if let Some(speed) = speed {
        flying_only(&mut found, step_s, &speed);
    }
    found
}

/// Segments in which some channel moves as much as in hardly any other one.
fn most_moving(columns: &[Option<Arc<[f64]>>], segments: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut kept = vec![false; segments.len()];
    for column in columns.iter().flatten() {
        let mut ranked: Vec<(f64, usize)> =
            segments.iter().enumerate().map(|(index, segment)| (measure_spread(column, segment), index)).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let moving = ranked.iter().filter(|(spread, _)| *spread > 0.0);
        moving.take(KEPT_PER_CHANNEL).for_each(|(_, index)| kept[*index] = true);
    }
    segments.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(segment, _)| segment.clone()).collect()
}

fn measure_spread(column: &[f64], segment: &Range<usize>) -> f64 {
    let mut values: Vec<f64> = column[segment.clone()].iter().copied().filter(|v| v.is_finite()).collect();
    if values.len() * 2 < segment.len() {
        return 0.0;
    }
    let (low, high) = (values.len() / 20, values.len() * 19 / 20);
    let mut at = |rank| ranked(&mut values, rank).unwrap_or(0.0);
    let lowest = at(low);
    at(high) - lowest
}

/// Leaves out the segments in which the aircraft stands or rolls; all stay where that would leave none.
fn flying_only(found: &mut Vec<(f64, usize)>, step_s: f64, speed: &Series) {
    let mut sizes: Vec<f64> = speed.values.iter().filter(|value| value.is_finite()).map(|value| value.abs()).collect();
    let most = sizes.len() * 9 / 10;
    let Some(usual) = ranked(&mut sizes, most) else { return };
    let level = FLYING * usual;
    let flies = |&(start_s, steps): &(f64, usize)| is_flying(speed, level, start_s, start_s + step_s * steps as f64);
    if found.iter().any(flies) {
        found.retain(flies);
    }
}

fn is_flying(speed: &Series, level: f64, start_s: f64, end_s: f64) -> bool {
    let first = speed.time_s.partition_point(|t| *t < start_s);
    let end = speed.time_s.partition_point(|t| *t <= end_s);
    let inside = speed.values[first..end].iter().filter(|value| value.is_finite());
    let (above, all) = inside.fold((0, 0), |(above, all), value| (above + usize::from(value.abs() > level), all + 1));
    all == 0 || above * 10 >= all * 9
}

/// The turn that an angle is recorded within, in whichever unit; none where it does not cover one.
fn find_turn(values: &[f64]) -> Option<f64> {
    let [least, greatest] = extent(values)?;
    let range = greatest - least;
    [TAU.to_radians(), TAU, 360.0].into_iter().find(|turn| range > 0.9 * turn && range < 1.02 * turn)
}

/// An angle that runs on where it is recorded within one turn.
fn unwrapped(values: &[f64]) -> Vec<f64> {
    let Some(turn) = find_turn(values) else { return values.to_vec() };
    let (mut added, mut last) = (0.0, f64::NAN);
    let mut unwrapped = Vec::with_capacity(values.len());
    for &value in values {
        if value.is_finite() {
            if (value - last).abs() > 0.5 * turn {
                added -= turn.copysign(value - last);
            }
            last = value;
        }
        unwrapped.push(value + added);
    }
    unwrapped
}

/// Velocity relative to the air in body axes at a step: `u, v, w` of airspeed, angle of attack and sideslip, m/s.
pub(super) fn air_velocity(motion: &Motion, step: usize) -> [f64; 3] {
    let speed = motion.at(Role::TrueAirspeed, step);
    let (sin_alpha, cos_alpha) = motion.sin_cos(Role::AngleOfAttack, step);
    let (sin_beta, cos_beta) = motion.sin_cos(Role::Sideslip, step);
    [speed * cos_alpha * cos_beta, speed * sin_beta, speed * sin_alpha * cos_beta]
}

/// A vector of body axes in north, east and down at a step.
pub(super) fn in_north_east_down(motion: &Motion, step: usize, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let (sin_phi, cos_phi) = motion.sin_cos(Role::BankAngle, step);
    let (sin_theta, cos_theta) = motion.sin_cos(Role::PitchAngle, step);
    let (sin_psi, cos_psi) = motion.sin_cos(Role::HeadingAngle, step);
    let (across, below) = (y * cos_phi - z * sin_phi, y * sin_phi + z * cos_phi);
    let ahead = x * cos_theta + below * sin_theta;
    [ahead * cos_psi - across * sin_psi, ahead * sin_psi + across * cos_psi, below * cos_theta - x * sin_theta]
}

/// Whether a role's sign can be turned at all: speeds, pressures and temperatures are never below zero.
pub(super) fn is_signed(role: Role) -> bool {
    match role {
        Role::TrueAirspeed
        | Role::CalibratedAirspeed
        | Role::EquivalentAirspeed
        | Role::Altitude
        | Role::GpsAltitude => false,
        _ => matches!(
            role.dimension(),
            Dimension::Angle | Dimension::AngularRate | Dimension::Acceleration | Dimension::Speed | Dimension::Length
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heading_runs_on_past_north_in_radians_and_in_degrees() {
        for turn in [TAU, 360.0] {
            let true_heading: Vec<f64> = (0..400).map(|k| turn * (0.9 + f64::from(k) * 0.005)).collect();
            let recorded: Vec<f64> = true_heading.iter().map(|value| value.rem_euclid(turn)).collect();
            let found = unwrapped(&recorded);
            for (found, truth) in found.iter().zip(&true_heading) {
                approx::assert_relative_eq!(*found, *truth, epsilon = 1e-9 * turn);
            }
        }
        assert_eq!(unwrapped(&[0.1, -0.7, 0.3]), [0.1, -0.7, 0.3], "less than a turn is left alone");
    }
}
