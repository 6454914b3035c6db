//! Roles by the words of channel names: passes from a role's own name to a name that only ends on it.

use crate::load::guesses::candidates::{Candidate, LEFT, RIGHT, best, row};
use crate::load::guesses::guess_frames::is_track;
use crate::load::guesses::other_quantities::is_other_quantity;
use crate::load::guesses::vectors;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap, NameFit, OtherSide};
use crate::load::names::foreign_names::{FOREIGN_NAMES, FRENCH_CONTROLS, NEEDS, Need, ends_on};
use crate::load::names::role_names::{NAMES, RoleNames, names_of};
use crate::load::names::stated_unit::is_signal_unit;
use crate::load::names::tokens::end_on;
use crate::quantity::Role;
use crate::statistics::median;

/// Names that stand for a role as a whole name alone: behind other words they are other quantities.
const WHOLE: [&str; 5] = ["pressure", "press", "height", "alf", "bet"];

/// Roles of which only a recording without an airspeed has use, the best first.
const INSTEAD_OF_AIRSPEED: [Role; 2] = [Role::EquivalentAirspeed, Role::ImpactPressure];

impl NameFit {
    fn names(self) -> &'static [RoleNames] {
        match self {
            Self::Foreign | Self::ForeignEnd => &FOREIGN_NAMES,
            _ => &NAMES,
        }
    }

    /// Whether a channel goes by a name of a role so.
    fn fits(self, candidate: &Candidate<'_>, name: &str, role: Role) -> bool {
        let is_long = || name.len() > 2 && !WHOLE.contains(&name) && !is_other_side(&candidate.plain, name);
        let is_other = || is_other_quantity(role, &candidate.tokens, name);
        match self {
            Self::Whole => candidate.plain == name,
            Self::Foreign => candidate.words == name,
            Self::Essence => candidate.essence == name && !is_other(),
            Self::Leaf => candidate.leaf == name && !["x", "y", "z", "u", "v", "w"].contains(&name) && !is_other(),
            Self::End => is_long() && end_on(&candidate.tokens, name) && !is_other(),
            Self::Begin => {
                is_long()
                    && (begins_on(&candidate.tokens, name) || begins_on(find_leaf(candidate), name))
                    && !is_other()
            }
            Self::ForeignEnd => ends_on(&candidate.words, name) && !is_other_side(&candidate.plain, name),
        }
    }
}

/// Gives the roles that are still open the channels that go by their names.
pub(crate) fn add_names(map: &mut ManualChannelMap, candidates: &[Candidate<'_>], taken: &mut Vec<usize>) {
    for fit in NameFit::ALL {
        for &(role, _) in fit.names() {
            if map.row(role).is_some() || INSTEAD_OF_AIRSPEED.contains(&role) {
                continue;
            }
            if let Some(index) = named(fit, role, map, candidates, taken) {
                give(role, (index, fit), map, candidates, taken);
            }
        }
    }
}

/// Gives the rates that are still open the channels that go by the names of angles and state the unit of a rate: `roll [deg/s]`.
pub(crate) fn add_rates_in_their_unit(
    map: &mut ManualChannelMap,
    candidates: &[Candidate<'_>],
    taken: &mut Vec<usize>,
) {
    const RATES: [(Role, Role); 3] =
        [(Role::RollRate, Role::BankAngle), (Role::PitchRate, Role::PitchAngle), (Role::YawRate, Role::HeadingAngle)];
    for (rate, angle) in RATES {
        let is_rate = |candidate: &Candidate<'_>| candidate.unit.is_some_and(|unit| unit.dimension == rate.dimension());
        let named = |fit: NameFit| {
            let (_, names) = fit.names().iter().find(|(role, _)| *role == angle)?;
            let goes_by = |candidate: &Candidate<'_>, name: &str| is_rate(candidate) && fit.fits(candidate, name, rate);
            Some((best(candidates, taken, rate, names, &goes_by)?, fit))
        };
        if map.row(rate).is_none()
            && let Some(found) = NameFit::ALL.into_iter().find_map(named)
        {
            give(rate, found, map, candidates, taken);
        }
    }
}

/// Gives a role the channel at an index, whose name fits it so.
fn give(
    role: Role,
    (index, fit): (usize, NameFit),
    map: &mut ManualChannelMap,
    candidates: &[Candidate<'_>],
    taken: &mut Vec<usize>,
) {
    taken.push(index);
    map.set(role, Some(ManualChannel { fit: Some(fit), ..row(&candidates[index], role) }));
}

/// The best channel, but for those taken, of all fits of names.
pub(crate) fn named_by_any(
    role: Role,
    map: &ManualChannelMap,
    candidates: &[Candidate<'_>],
    taken: &[usize],
) -> Option<(usize, NameFit)> {
    NameFit::ALL.into_iter().find_map(|fit| Some((named(fit, role, map, candidates, taken)?, fit)))
}

/// Gives a recording without an airspeed what goes by the name of an equivalent one, or of the impact pressure: beside an airspeed they play
/// no role.
pub(crate) fn add_instead_of_airspeed(
    map: &mut ManualChannelMap,
    candidates: &[Candidate<'_>],
    taken: &mut Vec<usize>,
) {
    for role in INSTEAD_OF_AIRSPEED {
        if !has_airspeed(map) {
            give_named(role, map, candidates, taken);
        }
    }
}

fn has_airspeed(map: &ManualChannelMap) -> bool {
    let speeds = [Role::TrueAirspeed, Role::CalibratedAirspeed, Role::Mach].into_iter().chain(INSTEAD_OF_AIRSPEED);
    speeds.into_iter().any(|speed| map.row(speed).is_some())
}

/// Gives a role the best channel, but for those taken, of all fits of names.
pub(crate) fn give_named(role: Role, map: &mut ManualChannelMap, candidates: &[Candidate<'_>], taken: &mut Vec<usize>) {
    if let Some(found) = named_by_any(role, map, candidates, taken) {
        give(role, found, map, candidates, taken);
    }
}

/// Gives a recording without an airspeed the total pressure less the static one beside it.
pub(crate) fn add_total_pressure(map: &mut ManualChannelMap, candidates: &[Candidate<'_>], taken: &mut Vec<usize>) {
    const NAMES: [&str; 8] = [
        "pt", "ptot", "ptotal", "totalpressure", "totalpress", "pressuretotal", "pitottotalpressure",
        "totalpressurepitot",
    ];
    /// Largest impact pressure, in parts of the static one: at Mach 1.2.
    const MOST: f64 = 1.4;
    let Some(below) = map.row(Role::StaticPressure).cloned() else { return };
    let Some(other) = candidates.iter().find(|candidate| candidate.from == below.from) else { return };
    let is_beside = |candidate: &Candidate<'_>| {
        candidate.from.source == other.from.source
            && candidate.channel.clock == other.channel.clock
            && candidate.unit == other.unit
    };
    let is_total = |(index, candidate): &(usize, &Candidate<'_>)| {
        let is_named = [&candidate.plain, &candidate.essence].iter().any(|name| NAMES.contains(&name.as_str()));
        let pairs = candidate.channel.values().iter().zip(other.channel.values());
        let mut parts: Vec<f64> =
            pairs.map(|(total, below)| total / below - 1.0).filter(|part| part.is_finite()).collect();
        is_named
            && !taken.contains(index)
            && is_beside(candidate)
            && median(&mut parts).is_some_and(|part| (0.0..MOST).contains(&part))
    };
    if has_airspeed(map) {
        return;
    }
    if let Some((index, candidate)) = candidates.iter().enumerate().find(is_total) {
        taken.push(index);
        // Twice the half of the difference.
        let other_side = Some(OtherSide { channel: below.from.channel.clone(), sign: -1.0 });
        let made = ManualChannel { other_side, scale: 2.0, unit: below.unit, ..row(candidate, Role::ImpactPressure) };
        map.set(Role::ImpactPressure, Some(made));
    }
}

/// Flow angles in volts or counts, which play no role before they are calibrated.
pub(crate) fn leave_out_signals(map: &mut ManualChannelMap, candidates: &[Candidate<'_>]) {
    for role in [Role::AngleOfAttack, Role::Sideslip] {
        let is_named =
            |candidate: &&Candidate<'_>| goes_by_whole_name(candidate, role) || names_sensor_of(candidate, role);
        let signal = |candidate: &Candidate<'_>| candidate.channel.unit.clone().filter(|unit| is_signal_unit(unit));
        if map.row(role).is_some() {
            continue;
        }
        for candidate in candidates.iter().filter(is_named) {
            if let Some(unit) = signal(candidate) {
                let why =
                    format!("in {unit}, not an angle: state degrees per {unit} with --role {}=CHANNEL", role.name());
                map.left_out.push((candidate.from.clone(), why));
            }
        }
    }
}

/// The best channel, but for those taken, whose name fits a role so.
fn named(
    fit: NameFit,
    role: Role,
    map: &ManualChannelMap,
    candidates: &[Candidate<'_>],
    taken: &[usize],
) -> Option<usize> {
    let (_, names) = fit.names().iter().find(|(other, _)| *other == role)?;
    let goes_by = |candidate: &Candidate<'_>, name: &str| {
        fit.fits(candidate, name, role)
            && !(role == Role::HeadingAngle && is_track(&candidate.plain))
            && has_one_reading((name, role), candidate, map, candidates)
            && vectors::has_brothers(name, role, candidate, candidates)
    };
    best(candidates, taken, role, names, &goes_by)
}

/// Vectors that one sensor measures.
const OF_ONE_SENSOR: [[Role; 3]; 2] = [
    [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ],
    [Role::RollRate, Role::PitchRate, Role::YawRate],
];

/// Takes the three parts of a vector from one source, where their names were found in several and one of those has all three.
pub(crate) fn take_vectors_from_one_source(
    map: &mut ManualChannelMap,
    candidates: &[Candidate<'_>],
    taken: &mut Vec<usize>,
) {
    for roles in OF_ONE_SENSOR {
        let rows: Vec<ManualChannel> = roles.iter().filter_map(|role| map.row(*role).cloned()).collect();
        let is_one = rows.iter().all(|row| row.from.source == rows[0].from.source);
        if rows.len() < 3 || is_one || rows.iter().any(|row| row.by != By::Name) {
            continue;
        }
        taken.retain(|index| rows.iter().all(|row| candidates[*index].from != row.from));
        let parts_of = |source: &str| -> Option<Vec<(usize, NameFit)>> {
            let others: Vec<usize> =
                (0..candidates.len()).filter(|k| taken.contains(k) || candidates[*k].from.source != source).collect();
            roles.iter().map(|role| named_by_any(*role, map, candidates, &others)).collect()
        };
        let as_found = || {
            let index = |row: &ManualChannel| candidates.iter().position(|candidate| candidate.from == row.from);
            rows.iter().map(|row| Some((index(row)?, row.fit?))).collect()
        };
        let parts: Option<Vec<(usize, NameFit)>> =
            rows.iter().find_map(|row| parts_of(&row.from.source)).or_else(as_found);
        for (role, found) in roles.into_iter().zip(parts.into_iter().flatten()) {
            give(role, found, map, candidates, taken);
        }
    }
}

/// Whether the whole name of a channel, in any language, is one of a role.
pub(crate) fn goes_by_whole_name(candidate: &Candidate<'_>, role: Role) -> bool {
    [NameFit::Whole, NameFit::Foreign, NameFit::Essence].into_iter().any(|fit| {
        let mut of_role = fit.names().iter().filter(|(other, _)| *other == role).flat_map(|(_, names)| *names);
        of_role.any(|name| NEEDS.iter().all(|(known, _)| known != name) && fit.fits(candidate, name, role))
    })
}

/// Whether the name of a channel is a role's and, behind it, that of a sensor of deflections: `Elevator pot`.
pub(crate) fn names_sensor_of(candidate: &Candidate<'_>, role: Role) -> bool {
    const SENSORS: [&str; 9] =
        ["pot", "potentiometer", "lvdt", "rvdt", "string", "transducer", "sensor", "pos", "position"];
    let end = candidate.tokens.iter().rposition(|token| !SENSORS.contains(&token.as_str())).map_or(0, |last| last + 1);
    let head = candidate.tokens[..end].concat();
    let is_name = |(other, names): &RoleNames| *other == role && names.contains(&head.as_str());
    end < candidate.tokens.len() && NAMES.iter().chain(&*FOREIGN_NAMES).any(is_name)
}

/// Tokens behind a name that say where it was measured, not what.
const QUALIFIERS: [&str; 52] = [
    "l", "r", "lh", "rh", "left", "right", "1", "2", "3", "01", "02", "03", "main", "primary", "pri", "avg", "mean",
    "average", "true", "att", "nb", "boom", "vane", "probe", "body", "cg", "gps", "imu", "ins", "ahrs", "adc", "air",
    "filt", "filtered", "meas", "measured", "sensor", "pos", "upper", "lower", "fused", "kf", "ekf", "cf", "mahony",
    "hat", "bmp", "bme", "ms", "5611", "180", "280",
];

/// Tokens of the last part of a name that is a path; none where it is no path.
fn find_leaf<'a>(candidate: &'a Candidate<'_>) -> &'a [String] {
    let tokens = &candidate.tokens;
    let from = (1..tokens.len()).find(|from| tokens[*from..].concat() == candidate.leaf);
    &tokens[from.unwrap_or(tokens.len())..]
}

/// Whether a name of these tokens is `name` with a word behind it that says where it was measured.
fn begins_on(tokens: &[String], name: &str) -> bool {
    (1..tokens.len()).any(|end| {
        tokens[..end].concat() == name && tokens[end..].iter().all(|token| QUALIFIERS.contains(&token.as_str()))
    })
}

/// Whether a channel's name says a side and `name`, of ailerons, which it ends on, does not: one of a pair is not their common deflection.
fn is_other_side(plain: &str, name: &str) -> bool {
    let is_aileron = [&NAMES, &FOREIGN_NAMES].iter().any(|all| names_of(all, Role::Aileron).contains(&name));
    let is_short = |side: &str| plain == format!("{side}{name}") || plain == format!("{name}{side}");
    let has_short_side = ["l", "r", "lh", "rh"].iter().any(|side| is_short(side));
    let has_word = || LEFT.iter().chain(&RIGHT).any(|side| plain.contains(side) && !name.contains(side));
    is_aileron && (has_short_side || has_word())
}

/// Whether `candidate`, which goes by `name`, can be `role` alone, beside the rows that `map` has and all other candidates.
fn has_one_reading(
    (name, role): (&str, Role),
    candidate: &Candidate<'_>,
    map: &ManualChannelMap,
    candidates: &[Candidate<'_>],
) -> bool {
    let Some((_, need)) = NEEDS.iter().find(|(known, _)| *known == name) else { return true };
    let has_unit = candidate.unit.is_some_and(|unit| unit.dimension == role.dimension());
    let is_beside = |names: &[&str]| {
        candidate.unit.is_none() && candidates.iter().any(|other| names.contains(&other.words.as_str()))
    };
    match *need {
        Need::Unit => has_unit,
        Need::UnitOrRate(rate) => has_unit || (rate != role && map.row(rate).is_some()),
        Need::OneOf(units) => candidate.unit.is_some_and(|unit| units.contains(&unit.symbol)),
        Need::FrenchControl => {
            candidates.iter().any(|other| FRENCH_CONTROLS.iter().any(|control| other.words.contains(control)))
        }
        Need::AllOf(names) => names.iter().all(|name| candidates.iter().any(|other| other.words == *name)),
        Need::UnitUnless(other, names) => role == other || has_unit || is_beside(names),
        Need::Accent => !candidate.channel.name.is_ascii(),
        Need::UnitOrBeside(names) => has_unit || is_beside(names),
        Need::ByRole(needs) => needs
            .iter()
            .find(|(other, _)| *other == role)
            .is_some_and(|(_, names)| names.iter().all(|name| candidates.iter().any(|other| other.words == *name))),
    }
}
