//! Channels that may play a role: what their names and units say, and the row that one of them starts as.

use super::by_hand::{ChannelName, ManualChannel};
use super::contents::{ChannelInfo, Probe};
use super::text_layout::split_unit;
use crate::quantity::{Dimension, Role, Unit};

/// Ends of names that tell a unit, in small letters, longest first.
const UNIT_ENDINGS: &[(&str, &str)] = &[
    ("_rad_s2", "rad/s^2"),
    ("_deg_s2", "deg/s^2"),
    ("_rad_s", "rad/s"),
    ("_deg_s", "deg/s"),
    ("_radps", "rad/s"),
    ("_degps", "deg/s"),
    ("_dps", "deg/s"),
    ("_m_s2", "m/s^2"),
    ("_mps2", "m/s^2"),
    ("_ft_s2", "ft/s^2"),
    ("_m_s", "m/s"),
    ("_mps", "m/s"),
    ("_ft_s", "ft/s"),
    ("_fps", "ft/s"),
    ("_fpm", "ft/min"),
    ("_degc", "degC"),
    ("_inhg", "inHg"),
    ("_mbar", "mbar"),
    ("_hpa", "hPa"),
    ("_kpa", "kPa"),
    ("_rad", "rad"),
    ("_deg", "deg"),
    ("_kts", "kt"),
    ("_kt", "kt"),
    ("_pa", "Pa"),
    ("_psi", "psi"),
    ("_rpm", "rpm"),
    ("_ft", "ft"),
    ("_kg", "kg"),
    ("_lb", "lb"),
    ("_k", "K"),
    ("_g", "g"),
    ("_m", "m"),
    ("_n", "N"),
    ("_w", "W"),
];

/// Ends of names that look like a unit and are a direction or an angle.
const NO_UNITS: &[&str] = &["v_n", "vel_n", "velocity_n", "pos_n", "position_n", "angle_psi", "heading_psi", "yaw_psi"];

/// An angle larger than this in radians is taken for degrees: angles of flow and controls, and of attitude.
const LARGEST_FLOW_RAD: f64 = 1.6;
const LARGEST_ATTITUDE_RAD: f64 = 6.4;
/// A rate larger than this in rad/s is taken for degrees per second.
const LARGEST_RATE_RAD_S: f64 = 3.5;
/// Sources that hold no measurement of the aircraft, and sources and channels whose names mislead: accelerations in axes of the Earth.
const NOT_MEASURED: &[&str] = &["setpoint", "localpositionax", "localpositionay", "localpositionaz"];

/// A channel that may play a role.
pub(super) struct Candidate<'p> {
    pub from: ChannelName,
    pub plain: String,
    /// Name of the source without its number, then that of the channel.
    pub full: String,
    pub unit: Option<Unit>,
    pub channel: &'p ChannelInfo,
}

/// Channels that may play a role.
pub(super) fn candidates(probes: &[Probe]) -> Vec<Candidate<'_>> {
    let sources = probes.iter().flat_map(|probe| &probe.sources);
    let channels = sources.flat_map(|source| source.channels.iter().map(move |channel| (source, channel)));
    let usable = channels.filter(|(source, channel)| {
        !channel.is_time && channel.samples > 1 && (channel.clock.is_some() || source.clocks.is_empty())
    });
    usable
        .map(|(source, channel)| {
            let (name, _) = split_unit(&channel.name);
            let (stem, _) = stem_and_unit(&name);
            let plain = letters(stem);
            let full = letters(source.name.trim_end_matches(|last: char| !last.is_alphabetic())) + &letters(&name);
            let from = ChannelName { source: source.name.clone(), channel: channel.name.clone() };
            Candidate { from, plain, full, unit: stated_unit(channel), channel }
        })
        .filter(|candidate| !NOT_MEASURED.iter().any(|name| candidate.full.contains(name)))
        .collect()
}

/// Letters and digits of a name, small.
fn letters(name: &str) -> String {
    name.to_lowercase().chars().filter(|letter| letter.is_alphanumeric()).collect()
}

/// A name without the unit it ends on, and that unit: `alpha` and degrees of `alpha_deg` or `alpha-deg`.
pub fn stem_and_unit(name: &str) -> (&str, Option<Unit>) {
    let lower = name.to_ascii_lowercase().replace('-', "_");
    let is_unit = !NO_UNITS.iter().any(|name| lower.ends_with(name));
    let known = |(ending, _): &&(&str, &str)| lower.len() > ending.len() && lower.ends_with(ending);
    let ending = UNIT_ENDINGS.iter().find(known).filter(|_| is_unit);
    ending.map_or((name, None), |(ending, unit)| (&name[..name.len() - ending.len()], Unit::parse(unit).ok()))
}

/// Unit of a channel as recorded, or else as its name ends; `None` where neither tells one that is known.
pub fn stated_unit(channel: &ChannelInfo) -> Option<Unit> {
    let recorded = channel.unit.as_deref().filter(|unit| !unit.is_empty());
    recorded.and_then(|unit| Unit::parse(unit).ok()).or_else(|| stem_and_unit(&channel.name).1)
}

/// Whether a channel goes by a name.
pub(super) type Fits<'f> = &'f dyn Fn(&Candidate<'_>, &str) -> bool;

/// The free channel that goes by one of `names`, the best first.
pub(super) fn best(
    candidates: &[Candidate<'_>],
    taken: &[usize],
    role: Role,
    names: &[&str],
    goes_by: Fits<'_>,
) -> Option<usize> {
    let free = |index: &usize| {
        let fits = candidates[*index].unit.is_none_or(|unit| unit.dimension == role.dimension() || is_count(unit));
        fits && !taken.contains(index)
    };
    names.iter().find_map(|name| (0..candidates.len()).filter(free).find(|&index| goes_by(&candidates[index], name)))
}

/// Whether a recorded unit says no more than that there is none.
pub(super) fn is_count(unit: Unit) -> bool {
    unit.dimension == Dimension::Dimensionless && unit.scale == 1.0
}

pub(super) fn row(candidate: &Candidate<'_>, role: Role) -> ManualChannel {
    let known = candidate.unit.filter(|unit| unit.dimension == role.dimension());
    let mut row = ManualChannel::new(
        candidate.from.clone(),
        Some(known.unwrap_or_else(|| unit_by_size(candidate.channel, role))),
    );
    // Altitude and climb are up, position and velocity down.
    row.turned = match role {
        Role::PositionDown => ["alt", "h"].iter().any(|up| candidate.plain.contains(up)),
        Role::VelocityDown => is_climb(&candidate.plain),
        // Right trailing edge down is positive.
        Role::Aileron => candidate.plain.contains("left") || candidate.plain == "aill",
        _ => false,
    };
    row
}

/// Whether a vertical speed of this name is positive upwards.
fn is_climb(plain: &str) -> bool {
    let within = ["climb", "vertical", "vspd", "vvi", "ivv", "hdot", "altituderate", "altrate", "steigrate"];
    let ends = ["vs", "roc"];
    within.iter().any(|up| plain.contains(up)) || ends.iter().any(|up| plain.ends_with(up))
}

/// The unit values of this size have: degrees where radians would be more than a turn, otherwise SI.
fn unit_by_size(channel: &ChannelInfo, role: Role) -> Unit {
    let largest = channel.values().iter().filter(|value| value.is_finite()).fold(0.0_f64, |most, v| most.max(v.abs()));
    let attitude = matches!(role, Role::BankAngle | Role::HeadingAngle | Role::Latitude | Role::Longitude);
    let name = match role.dimension() {
        Dimension::Angle if attitude && largest > LARGEST_ATTITUDE_RAD => "deg",
        Dimension::Angle if !attitude && largest > LARGEST_FLOW_RAD => "deg",
        Dimension::AngularRate if largest > LARGEST_RATE_RAD_S && !is_engine(role) => "deg/s",
        Dimension::AngularRate if is_engine(role) => "rpm",
        dimension => dimension.si_symbol(),
    };
    Unit::parse(name).unwrap_or(Unit::si(role.dimension()))
}

fn is_engine(role: Role) -> bool {
    matches!(role, Role::EngineSpeed1 | Role::EngineSpeed2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_at_the_end_of_a_name_is_no_unit() {
        for name in ["v_n", "gps_vel_n", "pos_N", "heading_psi"] {
            assert_eq!(stem_and_unit(name), (name, None));
        }
        let (stem, unit) = stem_and_unit("thrust_n");
        assert_eq!((stem, unit.map(|unit| unit.dimension)), ("thrust", Some(Dimension::Force)));
    }
}
