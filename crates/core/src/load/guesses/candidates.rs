//! Channels that may play a role: what their names and units say, and the row that one of them starts as.

use std::collections::BTreeMap;

use crate::load::contents::{ChannelInfo, Probe, Source};
use crate::load::maps::by_hand::{By, ChannelName, ManualChannel};
use crate::load::names::foreign_names::is_role_name;
use crate::load::names::role_names::{NAMES, names_of};
use crate::load::names::stated_unit::{is_count, is_signal_unit, name_and_unit, split_unit, stated_unit};
use crate::load::names::tokens::{essence, tokens};
use crate::load::names::words::{is_commanded, join_words, plain_letters};
use crate::quantity::{Dimension, Role, Unit};

/// An angle larger than this in radians is taken for degrees: angles of flow and controls, and of attitude.
const LARGEST_FLOW_RAD: f64 = 1.6;
const LARGEST_ATTITUDE_RAD: f64 = 6.4;
/// A rate larger than this in rad/s is taken for degrees per second.
const LARGEST_RATE_RAD_S: f64 = 3.5;
/// Sources that hold no measurement of the aircraft, and sources and channels whose names mislead: accelerations in axes of the Earth.
const NOT_MEASURED: &[&str] = &["setpoint", "localpositionax", "localpositionay", "localpositionaz"];

/// A channel that may play a role.
#[derive(Clone)]
pub(crate) struct Candidate<'p> {
    pub from: ChannelName,
    /// Letters and digits of its name without a unit, small and without accents.
    pub plain: String,
    /// The same without articles.
    pub words: String,
    /// The same in tokens.
    pub tokens: Vec<String>,
    /// Tokens without those that name no quantity, joined; where a remark follows a dash, those before it.
    pub essence: String,
    /// Letters and digits of the last part of a name that is a path; empty where it is none.
    pub leaf: String,
    /// Name of the source without its number, then that of the channel.
    pub full: String,
    pub unit: Option<Unit>,
    pub channel: &'p ChannelInfo,
}

/// Channels that may play a role, but for those that hold no measurement of the aircraft.
pub(crate) fn candidates(probes: &[Probe]) -> Vec<Candidate<'_>> {
    let mut found = all(probes);
    let sources: BTreeMap<&str, &Source> =
        probes.iter().flat_map(|probe| &probe.sources).map(|source| (source.name.as_str(), source)).collect();
    found.retain(|candidate| {
        let is_beside_others = sources.get(candidate.from.source.as_str()).is_some_and(|source| {
            is_uncertainty(source, &candidate.channel.name) || is_derivative(source, &candidate.channel.name)
        });
        !NOT_MEASURED.iter().any(|name| candidate.full.contains(name))
            && !is_commanded(&candidate.channel.name)
            && !is_beside_others
    });
    found
}

/// Whether a channel is the rate of change of a letter: `dr` beside `dp` and `dq` is of the yaw rate, no rudder.
fn is_derivative(source: &Source, name: &str) -> bool {
    let rates = ["dp", "dq", "dr"];
    rates.contains(&name) && rates.iter().all(|rate| source.has_channel(rate))
}

/// What a channel would be the uncertainty of: `yaw` of `yaw_u`.
fn uncertain_quantity(name: &str) -> Option<&str> {
    name.strip_suffix("_u").or_else(|| name.strip_suffix("_U"))
}

/// Whether a channel is an uncertainty: a source that names two or more beside their quantities (`roll_u`) has no upward velocity `vel_u`.
fn is_uncertainty(source: &Source, name: &str) -> bool {
    let is_beside =
        |channel: &&ChannelInfo| uncertain_quantity(&channel.name).is_some_and(|name| source.has_channel(name));
    uncertain_quantity(name).is_some() && source.channels.iter().filter(is_beside).count() >= 2
}

/// Channels that have a clock and samples.
pub(crate) fn all(probes: &[Probe]) -> Vec<Candidate<'_>> {
    let sources = probes.iter().flat_map(|probe| &probe.sources);
    let channels = sources.flat_map(|source| source.channels.iter().map(move |channel| (source, channel)));
    let usable = channels.filter(|(source, channel)| {
        !channel.is_time && channel.samples > 1 && (channel.clock.is_some() || source.clocks.is_empty())
    });
    usable
        .map(|(source, channel)| {
            let (name, _) = split_unit(channel.label());
            let (own, unit) = (own_name(source, channel), stated_unit(channel));
            let (stem, ending) = name_and_unit(own);
            // `Euler_psi` in deg ends on no unit of pressure.
            let is_no_unit = unit.zip(ending).is_some_and(|(unit, ending)| unit.dimension != ending.dimension);
            let stem = if is_no_unit { own.to_owned() } else { stem };
            let (plain, words) = (plain_letters(&stem), join_words(&stem));
            let head = stem.split_once(" - ").map_or(stem.as_str(), |(head, _)| head);
            let (tokens, essence) = (tokens(&stem), essence(&tokens(head)));
            let leaf = stem.rsplit_once(['/', '.', ':', '>']).map_or_else(String::new, |(_, leaf)| plain_letters(leaf));
            let place = plain_letters(source.name.trim_end_matches(|last: char| !last.is_alphabetic()));
            let full = place + &plain_letters(&name);
            let from = ChannelName { source: source.name.clone(), channel: channel.name.clone() };
            Candidate { from, plain, words, tokens, essence, leaf, full, unit, channel }
        })
        .collect()
}

/// Whether a text of a struct is the name of its data: `label` of a signal that Simulink logs.
fn is_label(key: &str) -> bool {
    const LABELS: [&str; 5] = ["label", "name", "signalname", "signal_name", "channel_name"];
    LABELS.contains(&key.to_lowercase().as_str())
}

/// Name of a channel; the label or the name of its group or struct where this holds nothing else and the channel is called no more than
/// its data.
fn own_name<'s>(source: &'s Source, channel: &'s ChannelInfo) -> &'s str {
    const DATA: [&str; 6] = ["data", "value", "values", "signal", "samples", "y"];
    let is_alone = || source.channels.iter().filter(|other| !other.is_time && other.samples > 1).count() == 1;
    if DATA.contains(&channel.name.to_lowercase().as_str()) && is_alone() {
        let label = source.notes.iter().find(|(key, text)| is_label(key) && !text.trim().is_empty());
        let of_source = source.name.rsplit(['/', '.']).next();
        let called = label.map(|(_, text)| text.as_str());
        return of_source.filter(|name| is_role_name(name)).or(called).or(of_source).unwrap_or(&channel.name);
    }
    // `rollrate\XCP:1`: the device follows the signal.
    let parts = channel.label().split_once('\\').filter(|(_, device)| device.contains(':'));
    parts.map(|(signal, _)| signal).filter(|signal| !signal.is_empty()).unwrap_or(channel.label())
}

/// Whether a channel goes by a name.
pub(crate) type Fits<'f> = &'f dyn Fn(&Candidate<'_>, &str) -> bool;

/// The free channel that goes by one of `names`, the best first.
pub(crate) fn best(
    candidates: &[Candidate<'_>],
    taken: &[usize],
    role: Role,
    names: &[&str],
    goes_by: Fits<'_>,
) -> Option<usize> {
    let free = |index: &usize| {
        let candidate = &candidates[*index];
        let fits = candidate.unit.is_none_or(|unit| unit.dimension == role.dimension() || is_count(unit));
        // What is still to be calibrated is asked for of a control alone.
        let is_signal = || candidate.channel.unit.as_deref().is_some_and(is_signal_unit);
        let is_control = matches!(role, Role::Aileron | Role::Elevator | Role::Rudder);
        fits && !taken.contains(index) && (is_control || !is_signal())
    };
    names.iter().find_map(|name| (0..candidates.len()).filter(free).find(|&index| goes_by(&candidates[index], name)))
}

pub(crate) fn row(candidate: &Candidate<'_>, role: Role) -> ManualChannel {
    let known = candidate.unit.filter(|unit| unit.dimension == role.dimension());
    let mut row = ManualChannel::new(
        candidate.from.clone(),
        Some(known.unwrap_or_else(|| unit_by_size(candidate.channel, role))),
    );
    // Altitude and climb are up, position and velocity down.
    row.by = By::Name;
    row.turned = match role {
        Role::PositionDown => is_height(candidate) || candidate.plain.ends_with("up"),
        Role::VelocityDown => is_climb(candidate),
        // Right trailing edge down is positive.
        Role::Aileron => {
            LEFT.iter().any(|left| candidate.plain.contains(left))
                || ["aill", "daill", "dal", "deltaal"].contains(&candidate.plain.as_str())
                || is_left_aileron(candidate)
        }
        // Trailing edge down is positive.
        Role::Elevator => is_edge_up(candidate.channel),
        _ => false,
    };
    row
}

/// Whether the name of a place is that of a height.
fn is_height(candidate: &Candidate<'_>) -> bool {
    let heights = [Role::Altitude, Role::GpsAltitude].map(|role| names_of(&NAMES, role));
    let is_name = |text: &str| heights.iter().any(|names| names.contains(&text));
    let is_word = |token: &String| token.contains("alt") || token.starts_with("height") || is_name(token);
    candidate.plain.contains("alt") || is_name(&candidate.plain) || candidate.tokens.iter().any(is_word)
}

/// Whether the name of an aileron says left by a letter of its own.
fn is_left_aileron(candidate: &Candidate<'_>) -> bool {
    let has = |words: &[&str]| candidate.tokens.iter().any(|token| words.contains(&token.as_str()));
    has(&["laileron", "aileronl"]) || (has(&["l", "lh"]) && has(&["aileron", "ailerons", "ail", "dail"]))
}

/// Whether the name or the unit of a surface says that its trailing edge up is positive: `Elevator TE up`, `TEU`.
fn is_edge_up(channel: &ChannelInfo) -> bool {
    let says = |text: &str| {
        let all = tokens(text);
        let has = |words: &[&str]| all.windows(words.len()).any(|few| few == words);
        has(&["teu"]) || has(&["te", "up"]) || has(&["trailing", "edge", "up"])
    };
    says(&channel.name) || channel.unit.as_deref().is_some_and(says)
}

/// Words for the left and for the right side.
pub(crate) const LEFT: [&str; 5] = ["left", "links", "linkes", "gauche", "sinistro"];
pub(crate) const RIGHT: [&str; 5] = ["right", "rechts", "rechtes", "droit", "destro"];

/// Parts and ends of names of vertical speeds that are positive upwards.
const CLIMBS: [&str; 17] = [
    "vsi", "vertspeed", "vertvel", "vertspd", "climb", "vertical", "vertikal", "vspd", "vvi", "ivv", "hdot",
    "altituderate", "altrate", "steig", "vario", "ascension", "montee",
];
const CLIMB_ENDS: [&str; 12] = [
    "vs",
    "velu",
    "roc",
    "up",
    "altdot",
    "vspeed",
    "vertrate",
    "вертикальнаяскорость",
    "升降速度",
    "垂直速度",
    "爬升率",
    "vertspd",
];

/// Whether a vertical speed of this name is positive upwards; `Vz` is where it is in feet per minute.
pub(crate) fn is_climb(candidate: &Candidate<'_>) -> bool {
    let plain = &candidate.plain;
    let in_feet = candidate.unit.is_some_and(|unit| unit.symbol == "ft/min");
    CLIMBS.iter().any(|up| plain.contains(up))
        || CLIMB_ENDS.iter().any(|up| plain.ends_with(up))
        || (plain == "vz" && in_feet)
        || [plain, &candidate.leaf].iter().any(|name| *name == "vu")
}

/// The unit values of this size have: degrees where radians would be more than a turn, otherwise SI.
pub(crate) fn unit_by_size(channel: &ChannelInfo, role: Role) -> Unit {
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
