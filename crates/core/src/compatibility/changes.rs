//! Mistakes of a channel map that are tried as explanations, and what each does to the channels.

use super::air::true_of_calibrated;
use super::motion::{Motion, is_signed};
use super::offsets::offset_of;
use super::relations::gravity;
use super::travels::{TravelForm, travel_form};
use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::quantity::Role::{self, *};
use crate::quantity::{Dimension, Unit};
use crate::statistics::extent;

/// What removes a contradiction, for one channel.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub enum ChannelFix {
    /// SI values become `factor * value + offset`; `unit` is the unit the recorded numbers are in, where that is what was wrong, and
    /// `was` the one they were taken for.
    Scale {
        /// Role of the channel.
        role: Role,
        /// Factor, negative where the sign is turned.
        factor: f64,
        /// Added after the factor, SI.
        offset: f64,
        /// Unit the numbers are in and the one they were taken for.
        units: Option<(&'static str, &'static str)>,
    },
    /// The channels of two roles are exchanged.
    Swap { one: Role, other: Role },
    /// The channel plays another role.
    Reassign {
        /// Role it was given.
        from: Role,
        /// Role it plays.
        to: Role,
    },
    /// Time stamps are multiplied by a factor: they are in `unit`, where there is one of that size.
    Clock {
        /// Factor on the seconds as read.
        factor: f64,
        /// Unit of the numbers that were read as seconds.
        unit: Option<&'static str>,
    },
    /// The stamps of one source are shifted against those of the others.
    Shift {
        source: String,
        /// Its stamps are late by this, s.
        late_s: f64,
    },
    /// A deflection is recorded as a part of the full travel: the angle at full travel must be stated.
    Travel {
        /// Role of the channel.
        role: Role,
        /// How its numbers are written.
        form: TravelForm,
        /// Factor that makes angles of about the right size.
        likely_factor: f64,
    },
}

impl ChannelFix {
    /// Roles whose channels it changes; none for the clock.
    pub fn roles(&self) -> Vec<Role> {
        match self {
            Self::Scale { role, .. } | Self::Travel { role, .. } => vec![*role],
            Self::Swap { one, other } => vec![*one, *other],
            Self::Reassign { from, .. } => vec![*from],
            Self::Clock { .. } | Self::Shift { .. } => Vec::new(),
        }
    }

    /// Whether a channel map can hold it as it is: a shift belongs to the clocks of a flight, a travel needs an angle nobody recorded.
    pub fn is_of_map(&self) -> bool {
        !matches!(self, Self::Shift { .. } | Self::Travel { .. } | Self::Clock { unit: None, .. })
    }

    /// What is wrong, in words, for example `sign reversed` or `degrees per second, not radians`.
    pub fn hypothesis(&self) -> String {
        match self {
            Self::Scale { factor, offset, units, role } => {
                let mut words = Vec::new();
                if *factor < 0.0 {
                    words.push("sign reversed".to_owned());
                }
                words.extend(units.map(unit_words));
                if *offset != 0.0 {
                    words.push(match role {
                        SpecificForceZ => "gravity removed".to_owned(),
                        AirTemperature => "degrees Celsius, not kelvin".to_owned(),
                        _ => format!("offset {:+.1} deg", -offset.to_degrees()),
                    });
                }
                words.join(" and ")
            }
            Self::Swap { one, other } => format!("swapped with {}", if *one < *other { other } else { one }.name()),
            Self::Reassign { to: CalibratedAirspeed, .. } => "calibrated, not true airspeed".to_owned(),
            Self::Reassign { to, .. } => format!("plays {}", to.name()),
            Self::Clock { unit: Some("s"), factor } => {
                let taken = if *factor < 1e4 {
                    "ms"
                } else if *factor < 1e7 {
                    "us"
                } else {
                    "ns"
                };
                format!("seconds, not {}", long_name(taken))
            }
            Self::Clock { unit: Some(unit), .. } => long_name(unit).to_owned(),
            Self::Clock { factor, unit: None } => {
                let percent = 100.0 * (1.0 / factor - 1.0);
                format!("runs {:.1} % {}", percent.abs(), if percent > 0.0 { "fast" } else { "slow" })
            }
            Self::Shift { source, late_s } => {
                format!("source {source} is {:.2} s {}", late_s.abs(), if *late_s > 0.0 { "late" } else { "early" })
            }
            Self::Travel { form, .. } => form.hypothesis(),
        }
    }

    /// Whether it says that the numbers are in `unit`.
    fn is_in(&self, unit: &str) -> bool {
        matches!(self, Self::Scale { units: Some((is, _)), .. } if *is == unit)
    }

    /// The motion after the fix; the clock is not part of it.
    pub(super) fn applied(&self, motion: Motion) -> Motion {
        match *self {
            Self::Scale { role, factor, offset, .. } => {
                let is_of_both = role == Altitude && is_down_of_altitude(&motion);
                let motion = motion.changed(role, |value| factor * value + offset);
                if is_of_both { motion.changed(PositionDown, |value| factor * value - offset) } else { motion }
            }
            Self::Swap { one, other } => motion.swapped(one, other),
            Self::Reassign { .. } => {
                let speed = motion.column(TrueAirspeed).map(<[f64]>::to_vec).unwrap_or_default();
                let turned: Vec<f64> =
                    speed.iter().enumerate().map(|(k, value)| true_of_calibrated(&motion, k, *value)).collect();
                motion.with(TrueAirspeed, turned)
            }
            Self::Travel { role, likely_factor, .. } => motion.changed(role, |value| likely_factor * value),
            Self::Clock { .. } | Self::Shift { .. } => motion,
        }
    }
}

/// Whether the position down is the altitude turned, from an origin of its own: both are of one channel.
fn is_down_of_altitude(motion: &Motion) -> bool {
    let (Some(down), Some(altitude)) = (motion.column(PositionDown), motion.column(Altitude)) else { return false };
    let sum: Vec<f64> = down.iter().zip(altitude).map(|(down, altitude)| down + altitude).collect();
    let (Some([least, greatest]), Some([lowest, highest])) = (extent(&sum), extent(altitude)) else { return false };
    greatest - least <= SAME_CHANNEL * (highest - lowest)
}

/// Name of a unit written out.
fn long_name(symbol: &str) -> &str {
    const NAMES: [(&str, &str); 24] = [
        ("deg", "degrees"),
        ("rad", "radians"),
        ("deg/s", "degrees per second"),
        ("rad/s", "radians per second"),
        ("kt", "knots"),
        ("km/h", "kilometres per hour"),
        ("mph", "miles per hour"),
        ("ft/s", "feet per second"),
        ("ft/min", "feet per minute"),
        ("m/s", "metres per second"),
        ("ft", "feet"),
        ("km", "kilometres"),
        ("FL", "flight levels"),
        ("m", "metres"),
        ("g", "in g"),
        ("ft/s^2", "feet per second squared"),
        ("m/s^2", "metres per second squared"),
        ("ms", "milliseconds"),
        ("us", "microseconds"),
        ("ns", "nanoseconds"),
        ("min", "minutes"),
        ("h", "hours"),
        ("d", "days"),
        ("s", "seconds"),
    ];
    NAMES.iter().find(|(name, _)| *name == symbol).map_or(symbol, |(_, long)| long)
}

/// `degrees per second, not radians`; `knots` where the numbers were taken for SI.
fn unit_words((is, was): (&'static str, &'static str)) -> String {
    match (is, was) {
        ("deg" | "deg/s" | "deg/s^2", _) => format!("{}, not radians", long_name(is)),
        ("rad" | "rad/s" | "rad/s^2", _) => format!("{}, not degrees", long_name(is)),
        (_, "m/s" | "m/s^2" | "m" | "Pa" | "K") => long_name(is).to_owned(),
        _ => format!("{}, not {}", long_name(is), long_name(was)),
    }
}

/// Units that numbers are in when they were taken for SI, or were taken for when they are in SI.
fn confused_units(role: Role) -> &'static [&'static str] {
    match role.dimension() {
        Dimension::Angle => &["deg"],
        Dimension::AngularRate => &["deg/s"],
        Dimension::Acceleration => &["g", "ft/s^2"],
        Dimension::Speed if role == VelocityDown => &["kt", "km/h", "mph", "ft/s", "ft/min"],
        Dimension::Speed => &["kt", "km/h", "mph", "ft/s"],
        Dimension::Length if matches!(role, Altitude | GpsAltitude) => &["ft", "km", "FL"],
        Dimension::Length => &["ft"],
        Dimension::Pressure => &["hPa", "inHg", "kPa"],
        _ => &[],
    }
}

/// One or several changes that are made together, and how far-fetched that is.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    /// What is changed.
    pub fixes: Vec<ChannelFix>,
    /// One for a single mistake of one channel; more for mistakes that need more to be wrong.
    pub cost: f64,
    /// Whether the accelerometers are without gravity by the attitude: all of them are changed, which no channel map can do.
    pub is_linear: bool,
}

impl Candidate {
    fn new(fixes: Vec<ChannelFix>, cost: f64) -> Self {
        Self { fixes, cost, is_linear: false }
    }

    /// A channel with its sign turned.
    pub(super) fn turned(role: Role) -> Self {
        Self::new(vec![ChannelFix::Scale { role, factor: -1.0, offset: 0.0, units: None }], 1.0)
    }

    pub(super) fn roles(&self) -> Vec<Role> {
        if self.is_linear { SPECIFIC_FORCE.to_vec() } else { self.fixes.iter().flat_map(ChannelFix::roles).collect() }
    }

    pub(super) fn roles_of_units(&self) -> Vec<Role> {
        let converted_role = |fix: &ChannelFix| {
            if let ChannelFix::Scale { role, units: Some(_), .. } = fix { Some(*role) } else { None }
        };
        self.fixes.iter().filter_map(converted_role).collect()
    }

    /// The motion after it.
    pub(super) fn applied(&self, motion: &Motion) -> Motion {
        if self.is_linear {
            return with_gravity(motion);
        }
        self.fixes.iter().fold(motion.clone(), |motion, fix| fix.applied(motion))
    }
}

/// The accelerometers.
pub(super) const SPECIFIC_FORCE: [Role; 3] = [SpecificForceX, SpecificForceY, SpecificForceZ];

/// The motion with gravity by the attitude taken off the accelerometers again, which were without it.
fn with_gravity(motion: &Motion) -> Motion {
    let mut found = motion.clone();
    for (axis, role) in SPECIFIC_FORCE.into_iter().enumerate() {
        let Some(column) = motion.column(role) else { continue };
        let mut given = vec![f64::NAN; column.len()];
        for k in motion.segments.iter().flat_map(Clone::clone) {
            given[k] = column[k] - gravity(motion, k)[axis];
        }
        found = found.with(role, given);
    }
    found
}

/// Fixes of the sign and the unit of one channel.
fn candidate_fixes(role: Role) -> Vec<(ChannelFix, f64)> {
    let scale = |factor, offset, units| ChannelFix::Scale { role, factor, offset, units };
    let si = role.dimension().si_symbol();
    let mut fixes = Vec::new();
    for sign in [1.0, -1.0] {
        let turned = sign < 0.0;
        if turned && !is_signed(role) {
            continue;
        }
        let dearer = if turned { 0.6 } else { 0.0 };
        if turned {
            fixes.push((scale(-1.0, 0.0, None), 1.0));
        }
        for symbol in confused_units(role) {
            let Ok(unit) = Unit::parse(symbol) else { continue };
            fixes.push((scale(sign * unit.scale, 0.0, Some((unit.symbol, si))), 1.1 + dearer));
            fixes.push((scale(sign / unit.scale, 0.0, Some((si, unit.symbol))), 1.2 + dearer));
        }
    }
    if role == SpecificForceZ {
        let g = STANDARD_GRAVITY_M_S2;
        fixes.push((scale(1.0, -g, None), 1.5));
        fixes.push((scale(-1.0, -g, None), 1.6));
        fixes.push((scale(g, -g, Some(("g", si))), 1.7));
        fixes.push((scale(-g, -g, Some(("g", si))), 1.8));
    }
    if role == AirTemperature {
        fixes.push((scale(1.0, 273.15, None), 1.0));
    }
    fixes
}

/// Channels that are exchanged by mistake.
const SWAPS: [(Role, Role); 15] = [
    (BankAngle, PitchAngle),
    (BankAngle, HeadingAngle),
    (PitchAngle, HeadingAngle),
    (AngleOfAttack, Sideslip),
    (RollRate, YawRate),
    (RollRate, PitchRate),
    (PitchRate, YawRate),
    (SpecificForceX, SpecificForceZ),
    (SpecificForceX, SpecificForceY),
    (SpecificForceY, SpecificForceZ),
    (VelocityNorth, VelocityEast),
    (PositionNorth, PositionEast),
    (Aileron, Elevator),
    (Aileron, Rudder),
    (Elevator, Rudder),
];

/// Channels that come from one box and are in one unit.
const GROUPS: [&[Role]; 7] = [
    &[RollRate, PitchRate, YawRate],
    &[BankAngle, PitchAngle, HeadingAngle],
    &[AngleOfAttack, Sideslip],
    &[SpecificForceX, SpecificForceY, SpecificForceZ],
    &[VelocityNorth, VelocityEast, VelocityDown],
    &[PositionNorth, PositionEast, PositionDown],
    &[Aileron, Elevator, Rudder],
];

/// Channels that are exchanged together: a box with gyroscopes and accelerometers that is mounted a quarter turn about.
const SWAPS_OF_A_BOX: [[(Role, Role); 2]; 3] = [
    [(RollRate, PitchRate), (SpecificForceX, SpecificForceY)],
    [(RollRate, YawRate), (SpecificForceX, SpecificForceZ)],
    [(PitchRate, YawRate), (SpecificForceY, SpecificForceZ)],
];

/// What is left of an altitude when the position down of the same channel is added to it: rounding, part of its range.
const SAME_CHANNEL: f64 = 1e-3;
/// Most channels whose signs are turned in every combination.
const MOST_COMBINED: usize = 5;

/// Candidates that change at least one of the channels `suspects`, all of them recorded.
pub(super) fn candidates(motion: &Motion, suspects: &[Role]) -> Vec<Candidate> {
    let mut found = Vec::new();
    for &role in suspects.iter().filter(|role| motion.has(**role)) {
        // Another unit makes a part of full travel as small as an angle.
        let is_part = travel_form(role, motion).is_some();
        let own = candidate_fixes(role)
            .into_iter()
            .filter(|(fix, _)| !is_part || !matches!(fix, ChannelFix::Scale { units: Some(_), .. }));
        found.extend(own.map(|(fix, cost)| Candidate::new(vec![fix], cost)));
        if let Some(offset) = offset_of(role, motion) {
            let fix = ChannelFix::Scale { role, factor: 1.0, offset: -offset, units: None };
            found.push(Candidate::new(vec![fix], 1.3));
        }
        if let Some((form, likely_factor)) = travel_form(role, motion) {
            found.push(Candidate::new(vec![ChannelFix::Travel { role, form, likely_factor }], 1.3));
        }
    }
    let is_there = |(one, other): (Role, Role)| motion.has(one) && motion.has(other);
    let is_suspect = |(one, other): (Role, Role)| suspects.contains(&one) || suspects.contains(&other);
    let swap = |(one, other)| ChannelFix::Swap { one, other };
    found.extend(
        SWAPS
            .into_iter()
            .filter(|pair| is_there(*pair) && is_suspect(*pair))
            .map(|pair| Candidate::new(vec![swap(pair)], 1.3)),
    );
    let boxes =
        SWAPS_OF_A_BOX.into_iter().filter(|pairs| pairs.iter().all(|pair| is_there(*pair)) && is_suspect(pairs[0]));
    found.extend(boxes.map(|pairs| Candidate::new(pairs.map(swap).to_vec(), 1.4)));
    found.extend(in_other_units(motion, suspects));
    if [SpecificForceZ, PitchAngle, BankAngle].iter().all(|role| motion.has(*role))
        && SPECIFIC_FORCE.iter().any(|role| suspects.contains(role))
    {
        let fix = ChannelFix::Scale { role: SpecificForceZ, factor: 1.0, offset: -STANDARD_GRAVITY_M_S2, units: None };
        found.push(Candidate { fixes: vec![fix], cost: 1.5, is_linear: true });
    }
    if motion.has(TrueAirspeed) && suspects.contains(&TrueAirspeed) && !motion.has(CalibratedAirspeed) {
        found.push(Candidate::new(vec![ChannelFix::Reassign { from: TrueAirspeed, to: CalibratedAirspeed }], 1.1));
    }
    found
}

/// Signs turned together, two or more of the channels `opposite`, which run against what they are compared with: of a recorder with z up,
/// each hides the other where the two are compared.
pub(super) fn turned_together(opposite: &[Role]) -> Vec<Candidate> {
    let count = opposite.len().min(MOST_COMBINED);
    let combinations = (0_u32..1 << count).filter(|set| set.count_ones() > 1);
    combinations.map(|set| turn_chosen(&opposite[..count], set)).collect()
}

fn turn_chosen(opposite: &[Role], set: u32) -> Candidate {
    let chosen = opposite.iter().enumerate().filter(|(index, _)| set >> index & 1 == 1);
    let fixes: Vec<ChannelFix> =
        chosen.map(|(_, role)| ChannelFix::Scale { role: *role, factor: -1.0, offset: 0.0, units: None }).collect();
    let cost = 1.0 + 0.1 * fixes.len() as f64;
    Candidate::new(fixes, cost)
}

/// Units of all channels of a box, and of those an air-data computer gives.
fn in_other_units(motion: &Motion, suspects: &[Role]) -> Vec<Candidate> {
    let mut found = Vec::new();
    for group in GROUPS {
        let there: Vec<Role> = group.iter().copied().filter(|role| motion.has(*role)).collect();
        let is_part = there.iter().any(|role| travel_form(*role, motion).is_some());
        if there.len() < 2 || is_part || !there.iter().any(|role| suspects.contains(role)) {
            continue;
        }
        for index in 0..candidate_fixes(there[0]).iter().filter(|(fix, _)| is_of_units(fix)).count() {
            let fixes = there.iter().filter_map(|role| {
                candidate_fixes(*role).into_iter().map(|(fix, _)| fix).filter(is_of_units).nth(index)
            });
            found.push(Candidate::new(fixes.collect(), 1.4));
        }
    }
    if motion.has(TrueAirspeed) && motion.has(Altitude) && suspects.contains(&Altitude) {
        // An air-data computer in knots and feet, of which a map without units makes SI.
        let fix_in =
            |role: Role, unit: &str| candidate_fixes(role).into_iter().map(|(fix, _)| fix).find(|fix| fix.is_in(unit));
        let fixes = fix_in(TrueAirspeed, "kt").into_iter().chain(fix_in(Altitude, "ft"));
        found.push(Candidate::new(fixes.collect(), 1.6));
    }
    found
}

/// Whether a fix changes the unit of a channel and nothing else.
fn is_of_units(fix: &ChannelFix) -> bool {
    matches!(fix, ChannelFix::Scale { factor, offset, units: Some(_), .. } if *factor > 0.0 && *offset == 0.0)
}
