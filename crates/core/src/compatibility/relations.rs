//! Kinematics: what one channel should be by what others say, over short lags.
//!
//! Every relation compares means over a lag `T`: `y = mean(f_y) + (g_y(t + T) - g_y(t)) / T` with the same of `x`. A rate is so
//! compared with the change of its angle without differentiating or integrating over longer than `T`: biases become an offset, noise
//! stays small. Equations are those of a rigid body over a flat Earth, `docs/conventions.md`.

use super::line::{Figures, Line};
use super::motion::{Motion, air_velocity, in_north_east_down};
use super::traces::{Trace, most_telling};
use crate::atmos::STANDARD_GRAVITY_M_S2 as GRAVITY_M_S2;
use crate::quantity::Role::{self, *};

/// Value of a quantity at a step.
type Value = fn(&Motion, usize) -> f64;

/// One side of a relation: the mean of the first over the lag and the change of the second by the lag.
type Side = (Value, Value);

/// What a clock that runs `k` times too fast does to the slope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ClockEffect {
    /// The prediction is a slope in time: the slope of the line is multiplied by `k`.
    Multiplies,
    /// The compared channel is a slope in time: it is divided by `k`.
    Divides,
    /// Time enters in no such way.
    None,
}

/// A relation between channels by kinematics.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kinematic {
    /// The channel that is compared.
    pub compared: Role,
    /// With what, in words.
    pub with: &'static str,
    /// Roles without which there is no relation.
    pub needs: &'static [Role],
    /// Roles that enter where they are recorded; zero where not.
    pub uses: &'static [Role],
    lag_s: f64,
    /// Standard deviation of a comparison in flight with ordinary sensors, unit of the channel or of its mean slope.
    noise: f64,
    /// Whether the offset is zero, too.
    origin: bool,
    /// Whether neither wind nor gusts nor the place of a sensor enter.
    pub exact: bool,
    /// Effect of a wrong clock.
    pub clock: ClockEffect,
    y: Side,
    x: Side,
}

fn nothing(_: &Motion, _: usize) -> f64 {
    0.0
}

fn turns(m: &Motion, k: usize) -> (f64, f64, f64) {
    (m.at(RollRate, k), m.at(PitchRate, k), m.at(YawRate, k))
}

/// Gravity in body axes at a step, m/s².
pub(super) fn gravity(m: &Motion, k: usize) -> [f64; 3] {
    let (sin_theta, cos_theta) = m.sin_cos(PitchAngle, k);
    let (sin_phi, cos_phi) = m.sin_cos(BankAngle, k);
    [-GRAVITY_M_S2 * sin_theta, GRAVITY_M_S2 * cos_theta * sin_phi, GRAVITY_M_S2 * cos_theta * cos_phi]
}

/// `w x v` at a step, of the velocity relative to the air, m/s².
fn centripetal(m: &Motion, k: usize) -> [f64; 3] {
    let ((p, q, r), [u, v, w]) = (turns(m, k), air_velocity(m, k));
    [q * w - r * v, r * u - p * w, p * v - q * u]
}

/// Acceleration over the ground in north, east and down, m/s².
fn acceleration(m: &Motion, k: usize) -> [f64; 3] {
    let force = [m.at(SpecificForceX, k), m.at(SpecificForceY, k), m.at(SpecificForceZ, k)];
    let [north, east, down] = in_north_east_down(m, k, force);
    [north, east, down + GRAVITY_M_S2]
}

/// Velocity relative to the air in north, east and down, m/s.
pub(super) fn air_over_ground(m: &Motion, k: usize) -> [f64; 3] {
    in_north_east_down(m, k, air_velocity(m, k))
}

/// A value in wings-level flight, not a number in banks above 15 degrees.
fn level(m: &Motion, k: usize, value: f64) -> f64 {
    if m.at(BankAngle, k).abs() < 0.26 { value } else { f64::NAN }
}

/// Cosine of 60 degrees of pitch, above which the other Euler angles turn fast; at 90 degrees they jump.
const STEEP_COSINE: f64 = 0.5;
/// Pitch rate, rad/s, from which the centripetal acceleration matters beside gravity: 3 m/s² at 30 m/s, more in a fast aircraft.
const PULL_UP_RAD_S: f64 = 0.1;

/// A value, not a number in steep climbs and dives.
fn drop_steep(m: &Motion, k: usize, value: f64) -> f64 {
    if m.sin_cos(PitchAngle, k).1 > STEEP_COSINE { value } else { f64::NAN }
}

/// A value; where no airspeed gives the centripetal acceleration, not a number in banks and pull-ups.
fn drop_curved(m: &Motion, k: usize, value: f64) -> f64 {
    match (m.has(TrueAirspeed), m.at(PitchRate, k).abs() < PULL_UP_RAD_S) {
        (true, _) => value,
        (false, true) => level(m, k, value),
        (false, false) => f64::NAN,
    }
}

/// Relation whose lag is a second and whose offset is free, of channels that no wind touches.
const EXACT: Kinematic = Kinematic {
    compared: RollRate,
    with: "",
    needs: &[],
    uses: &[],
    lag_s: 1.0,
    noise: 0.01,
    origin: false,
    exact: true,
    clock: ClockEffect::None,
    y: (nothing, nothing),
    x: (nothing, nothing),
};

/// The same of motion relative to the air, into which gusts and upwash enter.
const IN_AIR: Kinematic = Kinematic { exact: false, noise: 0.3, ..EXACT };

/// Every relation; the first that fails is looked at first.
pub(super) const RELATIONS: &[Kinematic] = &[
    // p = phi' - tan(theta) (q sin(phi) + r cos(phi))
    Kinematic {
        compared: RollRate,
        with: "the rate of change of phi",
        needs: &[RollRate, BankAngle],
        uses: &[PitchAngle, PitchRate, YawRate],
        clock: ClockEffect::Multiplies,
        y: (|m, k| drop_steep(m, k, m.at(RollRate, k)), nothing),
        x: (
            |m, k| {
                let (sin_phi, cos_phi) = m.sin_cos(BankAngle, k);
                -m.at(PitchAngle, k).tan() * (m.at(PitchRate, k) * sin_phi + m.at(YawRate, k) * cos_phi)
            },
            |m, k| m.at(BankAngle, k),
        ),
        ..EXACT
    },
    // q cos(phi) = theta' + r sin(phi)
    Kinematic {
        compared: PitchRate,
        with: "the rate of change of theta",
        needs: &[PitchRate, PitchAngle],
        uses: &[BankAngle, YawRate],
        clock: ClockEffect::Multiplies,
        y: (|m, k| m.at(PitchRate, k) * m.sin_cos(BankAngle, k).1, nothing),
        x: (|m, k| m.at(YawRate, k) * m.sin_cos(BankAngle, k).0, |m, k| m.at(PitchAngle, k)),
        ..EXACT
    },
    // r cos(phi) / cos(theta) = psi' - q sin(phi) / cos(theta)
    Kinematic {
        compared: YawRate,
        with: "the rate of change of psi",
        needs: &[YawRate, HeadingAngle],
        uses: &[BankAngle, PitchAngle, PitchRate],
        clock: ClockEffect::Multiplies,
        y: (
            |m, k| {
                let value = m.at(YawRate, k) * m.sin_cos(BankAngle, k).1 / m.sin_cos(PitchAngle, k).1;
                drop_steep(m, k, value)
            },
            nothing,
        ),
        x: (
            |m, k| -m.at(PitchRate, k) * m.sin_cos(BankAngle, k).0 / m.sin_cos(PitchAngle, k).1,
            |m, k| m.at(HeadingAngle, k),
        ),
        ..EXACT
    },
    // v_north', v_east', v_down' = C f + g
    Kinematic {
        compared: VelocityNorth,
        with: "specific force and attitude",
        needs: &[VelocityNorth, SpecificForceX, SpecificForceY, SpecificForceZ, BankAngle, PitchAngle, HeadingAngle],
        clock: ClockEffect::Divides,
        noise: 0.15,
        y: (nothing, |m, k| m.at(VelocityNorth, k)),
        x: (|m, k| acceleration(m, k)[0], nothing),
        ..EXACT
    },
    Kinematic {
        compared: VelocityEast,
        with: "specific force and attitude",
        needs: &[VelocityEast, SpecificForceX, SpecificForceY, SpecificForceZ, BankAngle, PitchAngle, HeadingAngle],
        clock: ClockEffect::Divides,
        noise: 0.15,
        y: (nothing, |m, k| m.at(VelocityEast, k)),
        x: (|m, k| acceleration(m, k)[1], nothing),
        ..EXACT
    },
    Kinematic {
        compared: VelocityDown,
        with: "specific force and attitude",
        needs: &[VelocityDown, SpecificForceX, SpecificForceY, SpecificForceZ, BankAngle, PitchAngle],
        clock: ClockEffect::Divides,
        noise: 0.15,
        y: (nothing, |m, k| m.at(VelocityDown, k)),
        x: (|m, k| acceleration(m, k)[2], nothing),
        ..EXACT
    },
    // v_down = -h', z'
    Kinematic {
        compared: VelocityDown,
        with: "the rate of change of z",
        needs: &[VelocityDown, PositionDown],
        clock: ClockEffect::Multiplies,
        lag_s: 3.0,
        noise: 0.3,
        y: (|m, k| m.at(VelocityDown, k), nothing),
        x: (nothing, |m, k| m.at(PositionDown, k)),
        ..EXACT
    },
    Kinematic {
        compared: VelocityDown,
        with: "the rate of change of altitude",
        needs: &[VelocityDown, Altitude],
        clock: ClockEffect::Multiplies,
        lag_s: 4.0,
        noise: 0.3,
        y: (|m, k| m.at(VelocityDown, k), nothing),
        x: (nothing, |m, k| -m.at(Altitude, k)),
        ..EXACT
    },
    Kinematic {
        compared: VelocityDown,
        with: "the rate of change of gps_altitude",
        needs: &[VelocityDown, GpsAltitude],
        clock: ClockEffect::Multiplies,
        lag_s: 4.0,
        noise: 0.3,
        y: (|m, k| m.at(VelocityDown, k), nothing),
        x: (nothing, |m, k| -m.at(GpsAltitude, k)),
        ..EXACT
    },
    Kinematic {
        compared: PositionDown,
        with: "altitude",
        needs: &[PositionDown, Altitude],
        lag_s: 4.0,
        noise: 0.3,
        y: (nothing, |m, k| m.at(PositionDown, k)),
        x: (nothing, |m, k| -m.at(Altitude, k)),
        ..EXACT
    },
    Kinematic {
        compared: Altitude,
        with: "gps_altitude",
        needs: &[Altitude, GpsAltitude],
        lag_s: 4.0,
        noise: 0.3,
        y: (nothing, |m, k| m.at(Altitude, k)),
        x: (nothing, |m, k| m.at(GpsAltitude, k)),
        ..EXACT
    },
    // x' = v_north, y' = v_east
    Kinematic {
        compared: PositionNorth,
        with: "v_north",
        needs: &[PositionNorth, VelocityNorth],
        clock: ClockEffect::Divides,
        lag_s: 2.0,
        noise: 0.5,
        y: (nothing, |m, k| m.at(PositionNorth, k)),
        x: (|m, k| m.at(VelocityNorth, k), nothing),
        ..EXACT
    },
    Kinematic {
        compared: PositionEast,
        with: "v_east",
        needs: &[PositionEast, VelocityEast],
        clock: ClockEffect::Divides,
        lag_s: 2.0,
        noise: 0.5,
        y: (nothing, |m, k| m.at(PositionEast, k)),
        x: (|m, k| m.at(VelocityEast, k), nothing),
        ..EXACT
    },
    // az = w' + p v - q u - g cos(theta) cos(phi)
    Kinematic {
        compared: SpecificForceZ,
        with: "gravity and centripetal acceleration",
        needs: &[SpecificForceZ],
        uses: &[BankAngle, PitchAngle, TrueAirspeed, AngleOfAttack, Sideslip, RollRate, PitchRate],
        origin: true,
        noise: 1.0,
        y: (|m, k| drop_curved(m, k, m.at(SpecificForceZ, k)), nothing),
        x: (|m, k| centripetal(m, k)[2] - gravity(m, k)[2], |m, k| air_velocity(m, k)[2]),
        ..EXACT
    },
    // ax = u' + q w - r v + g sin(theta)
    Kinematic {
        compared: SpecificForceX,
        with: "gravity and the change of airspeed",
        needs: &[SpecificForceX, PitchAngle, TrueAirspeed],
        uses: &[AngleOfAttack, Sideslip, PitchRate, YawRate],
        noise: 0.15,
        y: (|m, k| m.at(SpecificForceX, k), nothing),
        x: (|m, k| centripetal(m, k)[0] - gravity(m, k)[0], |m, k| air_velocity(m, k)[0]),
        ..IN_AIR
    },
    // ay = v' + r u - p w - g cos(theta) sin(phi)
    Kinematic {
        compared: SpecificForceY,
        with: "gravity and centripetal acceleration",
        needs: &[SpecificForceY, BankAngle, YawRate, TrueAirspeed, Sideslip],
        uses: &[PitchAngle, AngleOfAttack, RollRate],
        y: (|m, k| m.at(SpecificForceY, k), nothing),
        x: (|m, k| centripetal(m, k)[1] - gravity(m, k)[1], |m, k| air_velocity(m, k)[1]),
        ..IN_AIR
    },
    // r u - p w = ay + g cos(theta) sin(phi) - v': a turn
    Kinematic {
        compared: YawRate,
        with: "bank and airspeed in turns",
        needs: &[YawRate, BankAngle, TrueAirspeed],
        uses: &[SpecificForceY, PitchAngle, RollRate, AngleOfAttack, Sideslip],
        y: (|m, k| centripetal(m, k)[1], nothing),
        x: (|m, k| m.at(SpecificForceY, k) + gravity(m, k)[1], |m, k| -air_velocity(m, k)[1]),
        ..IN_AIR
    },
    // w' - q u + p v = az + g cos(theta) cos(phi)
    Kinematic {
        compared: TrueAirspeed,
        with: "az and pitch rate",
        needs: &[TrueAirspeed, PitchRate, SpecificForceZ, AngleOfAttack],
        uses: &[BankAngle, PitchAngle, RollRate, Sideslip],
        y: (|m, k| centripetal(m, k)[2], |m, k| air_velocity(m, k)[2]),
        x: (|m, k| m.at(SpecificForceZ, k) + gravity(m, k)[2], nothing),
        ..IN_AIR
    },
    // w' = az + g cos(theta) cos(phi) + q u - p v
    Kinematic {
        compared: AngleOfAttack,
        with: "az and pitch rate",
        needs: &[AngleOfAttack, TrueAirspeed, PitchRate, SpecificForceZ],
        uses: &[BankAngle, PitchAngle, RollRate, Sideslip],
        noise: 0.5,
        y: (nothing, |m, k| air_velocity(m, k)[2]),
        x: (|m, k| m.at(SpecificForceZ, k) + gravity(m, k)[2] - centripetal(m, k)[2], nothing),
        ..IN_AIR
    },
    // v' = ay + g cos(theta) sin(phi) - r u + p w
    Kinematic {
        compared: Sideslip,
        with: "ay, bank and yaw rate",
        needs: &[Sideslip, TrueAirspeed, YawRate, BankAngle, SpecificForceY],
        uses: &[PitchAngle, RollRate, AngleOfAttack],
        noise: 0.5,
        y: (nothing, |m, k| air_velocity(m, k)[1]),
        x: (|m, k| m.at(SpecificForceY, k) + gravity(m, k)[1] - centripetal(m, k)[1], nothing),
        ..IN_AIR
    },
    // V alpha = V theta + v_down, V theta - h' with wings level and small angles
    Kinematic {
        compared: AngleOfAttack,
        with: "theta minus the flight-path angle from v_down",
        needs: &[AngleOfAttack, PitchAngle, TrueAirspeed, VelocityDown, BankAngle],
        noise: 0.5,
        y: (|m, k| level(m, k, m.at(TrueAirspeed, k) * m.at(AngleOfAttack, k)), nothing),
        x: (|m, k| m.at(TrueAirspeed, k) * m.at(PitchAngle, k) + m.at(VelocityDown, k), nothing),
        ..IN_AIR
    },
    Kinematic {
        compared: AngleOfAttack,
        with: "theta minus the flight-path angle from altitude",
        needs: &[AngleOfAttack, PitchAngle, TrueAirspeed, Altitude, BankAngle],
        lag_s: 3.0,
        noise: 0.5,
        y: (|m, k| level(m, k, m.at(TrueAirspeed, k) * m.at(AngleOfAttack, k)), nothing),
        x: (|m, k| m.at(TrueAirspeed, k) * m.at(PitchAngle, k), |m, k| -m.at(Altitude, k)),
        ..IN_AIR
    },
    // -v_down, h' = u sin(theta) - v sin(phi) cos(theta) - w cos(phi) cos(theta)
    Kinematic {
        compared: VelocityDown,
        with: "airspeed, theta and alpha",
        needs: &[VelocityDown, TrueAirspeed, PitchAngle, AngleOfAttack],
        uses: &[BankAngle, Sideslip],
        lag_s: 2.0,
        noise: 0.7,
        y: (|m, k| m.at(VelocityDown, k), nothing),
        x: (|m, k| air_over_ground(m, k)[2], nothing),
        ..IN_AIR
    },
    Kinematic {
        compared: Altitude,
        with: "airspeed, theta and alpha",
        needs: &[Altitude, TrueAirspeed, PitchAngle, AngleOfAttack],
        uses: &[BankAngle, Sideslip],
        clock: ClockEffect::Divides,
        lag_s: 4.0,
        noise: 0.7,
        y: (nothing, |m, k| m.at(Altitude, k)),
        x: (|m, k| -air_over_ground(m, k)[2], nothing),
        ..IN_AIR
    },
    // velocity over the ground less that relative to the air is the wind
    Kinematic {
        compared: TrueAirspeed,
        with: "v_north over turns",
        needs: &[TrueAirspeed, VelocityNorth, HeadingAngle],
        uses: &[PitchAngle, BankAngle, AngleOfAttack, Sideslip],
        lag_s: 2.0,
        noise: 2.0,
        y: (|m, k| air_over_ground(m, k)[0], nothing),
        x: (|m, k| m.at(VelocityNorth, k), nothing),
        ..IN_AIR
    },
    Kinematic {
        compared: TrueAirspeed,
        with: "v_east over turns",
        needs: &[TrueAirspeed, VelocityEast, HeadingAngle],
        uses: &[PitchAngle, BankAngle, AngleOfAttack, Sideslip],
        lag_s: 2.0,
        noise: 2.0,
        y: (|m, k| air_over_ground(m, k)[1], nothing),
        x: (|m, k| m.at(VelocityEast, k), nothing),
        ..IN_AIR
    },
];

/// Pairs of a segment, if it has as many steps.
const FEWEST_STARTS: usize = 12;
/// The prediction varies enough to tell anything when it does by this many deviations of the noise.
const TELLS: f64 = 3.0;
/// A line with this squared correlation tells as well: what is left about it is a third of what it explains.
const CLEAR_R2: f64 = 0.9;
/// Such a line varies by this part of the noise at least: slow drifts alone correlate by chance.
const CLEAR: f64 = 0.2;
/// A slope other than one must be so by as many standard errors, of a channel that follows the others with this squared correlation.
const SIGNIFICANT: f64 = 2.5;
const FOLLOWS_R2: f64 = 0.5;
/// Neighbours by which the noise of a level is seen lie this part of a lag apart: near enough that no motion bends between them.
const NEIGHBOURS_PER_LAG: usize = 16;
/// One in so many of them, the farthest, is left out as a spike, and the part of the variance of normal noise that the rest has.
const SPIKES: usize = 20;
const REST_OF_VARIANCE: f64 = 0.76;

impl Kinematic {
    /// Whether every channel it needs is there.
    pub(super) fn applies(&self, motion: &Motion) -> bool {
        self.needs.iter().all(|role| motion.has(*role))
    }

    /// Whether the channel of `role` enters.
    pub(super) fn involves(&self, role: Role) -> bool {
        self.needs.contains(&role) || self.uses.contains(&role)
    }

    /// Pairs of one segment, half a lag apart, nearer in a short one.
    pub(super) fn pairs(&self, motion: &Motion, segment: &std::ops::Range<usize>) -> Vec<(f64, f64)> {
        self.timed_pairs(motion, segment).into_iter().map(|(_, x, y)| (x, y)).collect()
    }

    /// What the channel is and what the others say over the segment in which they vary most; means taken off unless there is an origin.
    pub(super) fn trace(&self, motion: &Motion) -> Option<Trace> {
        if !self.applies(motion) {
            return None;
        }
        let segment = most_telling(motion, |segment| {
            Line::of_all(&self.pairs(motion, segment)).map_or(f64::NAN, |line| line.spread_x.max(line.spread_y))
        })?;
        let pairs = self.timed_pairs(motion, &segment).into_iter();
        let trace = Trace::new(pairs.map(|(time_s, x, y)| (time_s, y, x)));
        Some(if self.origin { trace } else { trace.without_means() })
    }

    /// Whether a segment varies enough to tell anything, whatever the fit, and by how much it does.
    pub(super) fn variation(&self, motion: &Motion, segment: &std::ops::Range<usize>) -> Option<f64> {
        let line = Line::of_all(&self.pairs(motion, segment))?;
        let variation = line.spread_x.max(line.spread_y) / self.noise;
        (variation > TELLS).then_some(variation)
    }

    /// Steps of the lag.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a lag of seconds over steps of more than 0.01 s"
    )]
    fn lag(&self, motion: &Motion) -> usize {
        ((self.lag_s / motion.step_s).round() as usize).max(2)
    }

    /// Pairs of one segment with the time of their middle.
    fn timed_pairs(&self, motion: &Motion, segment: &std::ops::Range<usize>) -> Vec<(f64, f64, f64)> {
        let lag = self.lag(motion);
        if segment.len() <= lag {
            return Vec::new();
        }
        let length_s = motion.step_s * lag as f64;
        let side = |(mean, change): Side| {
            let means: Vec<f64> = segment.clone().map(|k| mean(motion, k)).collect();
            move |first: usize| {
                let of_lag = &means[first - segment.start..][..=lag];
                let ends = 0.5 * (of_lag[0] + of_lag[lag]);
                let inside: f64 = of_lag[1..lag].iter().sum();
                (ends + inside) / lag as f64 + (change(motion, first + lag) - change(motion, first)) / length_s
            }
        };
        let (x, y) = (side(self.x), side(self.y));
        let free = segment.len() - lag;
        let starts = (segment.start..segment.end - lag).step_by((lag / 2).min(free / FEWEST_STARTS).max(1));
        let pairs = starts.map(|first| (motion.time_s[first] + 0.5 * length_s, x(first), y(first)));
        pairs.filter(|(_, x, y)| x.is_finite() && y.is_finite()).collect()
    }

    /// Standard deviation of a comparison in one segment: that of ordinary sensors, or the noise its levels have at both ends of a lag
    /// where that is larger, or what the rounding of a coarse recorder does to both sides.
    fn noise_in(&self, motion: &Motion, segment: &std::ops::Range<usize>) -> f64 {
        let lag = self.lag(motion);
        let length_s = motion.step_s * lag as f64;
        let slope_noise =
            |(_, level): Side| std::f64::consts::SQRT_2 * level_noise(motion, segment, level, lag) / length_s;
        let middle = segment.start + segment.len() / 2;
        let rounding = self.measure_rounding(motion, middle, length_s);
        self.noise.max(slope_noise(self.x).hypot(slope_noise(self.y))).max(rounding)
    }

    /// Standard deviation of a comparison by the rounding of coarse channels: a step over the root of twelve, in a mean and at both ends
    /// of a lag, with the effect that the channels have at one time.
    fn measure_rounding(&self, motion: &Motion, at: usize, length_s: f64) -> f64 {
        let of_side = |coarse: &Motion, (mean, level): Side| {
            let moved = |value: Value| value(coarse, at) - value(motion, at);
            moved(mean).powi(2) + 2.0 * (moved(level) / length_s).powi(2)
        };
        let involved = self.needs.iter().chain(self.uses).filter(|role| motion.resolution(**role) > 0.0);
        let squares = involved.map(|role| {
            let coarse = motion.clone().changed(*role, |value| value + motion.resolution(*role));
            of_side(&coarse, self.x) + of_side(&coarse, self.y)
        });
        (squares.filter(|square| square.is_finite()).sum::<f64>() / 12.0).sqrt()
    }

    /// Compares over all segments; `None` where none tells.
    pub(super) fn compare(&self, motion: &Motion) -> Option<Figures> {
        let through = |one| Some((Line::through(&self.pairs(motion, one), self.origin)?, self.noise_in(motion, one)));
        let lines: Vec<(Line, f64)> = motion.segments.iter().filter_map(through).collect();
        let moves = |(line, noise): &&(Line, f64)| line.spread_x > TELLS * noise;
        let moving = lines.iter().any(|line| moves(&line));
        let is_clear =
            |(line, noise): &&(Line, f64)| line.r2 > CLEAR_R2 && line.spread_x.max(line.spread_y) > CLEAR * noise;
        let mut decisive: Vec<_> = lines.iter().filter(|line| moves(line) || is_clear(line)).collect();
        if decisive.is_empty() {
            decisive = lines.iter().filter(|(line, noise)| line.spread_y > TELLS * noise).collect();
        }
        let median_of = |value: fn(&Line) -> f64| {
            crate::statistics::median(&mut decisive.iter().map(|(line, _)| value(line)).collect::<Vec<_>>())
        };
        let (slope, r2) = (median_of(|line| line.slope)?, median_of(|line| line.r2)?);
        // Pairs overlap by half a lag. Standard error of the logarithm of the slope of a reduced major axis.
        let pairs: usize = decisive.iter().map(|(line, _)| line.pairs).sum();
        let error = ((1.0 - r2).max(0.0) / (0.5 * pairs as f64)).sqrt();
        let is_one = slope > 0.0 && r2 > FOLLOWS_R2 && slope.ln().abs() < SIGNIFICANT * error;
        Some(Figures {
            slope,
            r2,
            disagreement: median_of(|line| line.disagreement)?,
            segments: decisive.len(),
            predicted: moving && !is_one,
        })
    }
}

/// White noise of a level over a segment, by how far it lies from the middle of its neighbours; the largest such distances are left out
/// as spikes.
fn level_noise(motion: &Motion, segment: &std::ops::Range<usize>, level: Value, lag: usize) -> f64 {
    let apart = (lag / NEIGHBOURS_PER_LAG).max(1);
    if segment.len() <= 2 * apart {
        return 0.0;
    }
    let levels: Vec<f64> = segment.clone().map(|k| level(motion, k)).collect();
    let bend = |k: usize| levels[k] - 0.5 * (levels[k - apart] + levels[k + apart]);
    let bends = (apart..levels.len() - apart).map(|k| bend(k).powi(2)).filter(|square| square.is_finite());
    let mut squares: Vec<f64> = bends.collect();
    let kept = squares.len() - squares.len() / SPIKES;
    if kept < squares.len() {
        squares.select_nth_unstable_by(kept, f64::total_cmp);
        squares.truncate(kept);
    }
    // Of white noise the difference from the middle of two neighbours has one and a half times the variance.
    let times = 1.5 * REST_OF_VARIANCE * squares.len().max(1) as f64;
    (squares.iter().sum::<f64>() / times).sqrt()
}
