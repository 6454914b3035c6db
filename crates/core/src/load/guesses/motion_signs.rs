//! Signs that the motion decides: attitude against rates and climb, climb against height, velocity against place. A row that its recorder
//! defines stays as it is.

use std::f64::consts::{PI, TAU};

use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::load::contents::Probe;
use crate::load::guesses::motion::{
    FEWEST_PAIRS, MOST_PAIRS, PLACE_CORRELATION, RATE_CORRELATION, ask, change_correlation, fit_line, height, is_free,
    set_sign, slope_of, speed, turn, turning,
};
use crate::load::guesses::motion_axes::turn_left_up;
use crate::load::guesses::motion_ground::{fit_track_to_bank, settle_heading, settle_horizontal, track};
use crate::load::guesses::trace::Trace;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap};
use crate::load::names::tokens::tokens;
use crate::quantity::Role;
use crate::statistics::{extent, median};

/// Correlation, either way, of an angle with a climb that decides.
const ANGLE_CORRELATION: f64 = 0.6;
/// The same of a bank with the change of the track.
const TRACK_CORRELATION: f64 = 0.8;
/// Range of a rate in which a vane must move, rad/s: 3 deg/s.
const TURNS_RAD_S: f64 = 0.05;
/// Least speed of an aeroplane whose bank turns it, m/s.
const LEAST_SPEED: f64 = 8.0;

/// Settles signs; true where that of the position down, or of the speed down beside none, is settled.
pub(crate) fn settle(map: &mut ManualChannelMap, probes: &[Probe]) -> bool {
    drop_track(map, probes);
    drop_resting_vanes(map, probes);
    let is_down_known = settle_down(map, probes);
    settle_horizontal(map, probes);
    settle_attitude(map, probes);
    is_down_known
}

/// Whether the name of a row says up or down.
fn says_direction(row: &ManualChannel) -> bool {
    const WORDS: [&str; 18] = [
        "vd", "veld", "pd", "posd", "down", "up", "climb", "vario", "vsi", "vvi", "vs", "roc", "d", "alt", "altitude",
        "vspd", "hdot", "vu",
    ];
    let all = tokens(&row.from.channel);
    all.iter().any(|token| WORDS.contains(&token.as_str()) || token.starts_with("vert"))
}

/// Signs of speed and position down by the height recorded beside them, by each other, or by the pitch attitude of what flies.
fn settle_down(map: &mut ManualChannelMap, probes: &[Probe]) -> bool {
    let height = height(map, probes);
    let open =
        |map: &ManualChannelMap, role: Role| map.row(role).filter(|row| is_free(row) && !says_direction(row)).cloned();
    let mut is_known = false;
    if let Some(row) = open(map, Role::PositionDown) {
        let place = Trace::read(&ManualChannel { turned: false, ..row.clone() }, probes);
        let by_height = || Some(change_correlation(height.as_ref()?, place.clone()?)?.1);
        let by_speed = || {
            let speed = map.row(Role::VelocityDown).filter(|row| says_direction(row) || row.by == By::Recorder)?;
            Some(-slope_of(place.as_ref()?, Trace::read(speed, probes)?)?.1)
        };
        let by_pitch = || {
            let pitch = Trace::for_role(map, Role::PitchAngle, probes)?;
            Role::AIRSPEEDS.into_iter().find_map(|role| map.row(role))?;
            let (_, correlation) = slope_of(place.as_ref()?, pitch)?;
            (correlation.abs() > ANGLE_CORRELATION).then_some(correlation.signum())
        };
        let found = by_height().or_else(by_speed).filter(|correlation| correlation.abs() > PLACE_CORRELATION);
        if let Some(correlation) = found.or_else(by_pitch) {
            set_sign(map, Role::PositionDown, correlation > 0.0);
            is_known = true;
        }
    }
    if let Some(row) = open(map, Role::VelocityDown) {
        let speed = || Trace::read(&ManualChannel { turned: false, ..row.clone() }, probes);
        let by_height = || slope_of(height.as_ref()?, speed()?).map(|(_, correlation)| correlation);
        let by_place = || {
            let place = Trace::for_role(map, Role::PositionDown, probes).filter(|_| is_known)?;
            slope_of(&place, speed()?).map(|(_, correlation)| -correlation)
        };
        let strong = |correlation: &f64| correlation.abs() > PLACE_CORRELATION;
        if let Some(correlation) = by_height().filter(strong).or_else(|| by_place().filter(strong)) {
            set_sign(map, Role::VelocityDown, correlation > 0.0);
            is_known |= map.row(Role::PositionDown).is_none();
        }
    }
    is_known
}

/// A heading that is the direction of the velocity to a fraction of a degree, of a receiver that gives no attitude, is a track.
fn drop_track(map: &mut ManualChannelMap, probes: &[Probe]) {
    const SAME_RAD: f64 = 5e-3;
    let Some(row) = map.row(Role::HeadingAngle).filter(|row| row.by != By::Recorder).cloned() else { return };
    let is_of_source = |role: &Role| map.row(*role).is_some_and(|other| other.from.source == row.from.source);
    let is_alone = ![Role::BankAngle, Role::PitchAngle].iter().any(is_of_source)
        && [Role::VelocityNorth, Role::Latitude].iter().any(is_of_source);
    let apart = || {
        let track = track(map, probes)?;
        let heading = Trace::read(&row, probes)?.at(&track.time_s)?;
        let apart = |(a, b): (&f64, &f64)| ((a - b + PI).rem_euclid(TAU) - PI).abs();
        let mut all: Vec<f64> = heading.values.iter().zip(&track.values).map(apart).filter(|d| d.is_finite()).collect();
        (all.len() >= FEWEST_PAIRS).then(|| median(&mut all))?
    };
    if is_alone && apart().is_some_and(|apart| apart < SAME_RAD) {
        map.left_out.push((row.from, "the direction of the velocity, not the heading".to_owned()));
        map.set(Role::HeadingAngle, None);
    }
}

/// A flow angle that never changes while the aircraft turns about the same axis was not recorded: recorders write zero for it.
fn drop_resting_vanes(map: &mut ManualChannelMap, probes: &[Probe]) {
    for (vane, rate) in [(Role::AngleOfAttack, Role::PitchRate), (Role::Sideslip, Role::YawRate)] {
        let range = |role: Role| {
            let trace = Trace::for_role(map, role, probes)?;
            let [least, greatest] = extent(&trace.values).filter(|_| trace.values.len() >= FEWEST_PAIRS)?;
            Some(greatest - least)
        };
        let (rests, turns) = (range(vane) == Some(0.0), range(rate).is_some_and(|range| range > TURNS_RAD_S));
        if rests
            && turns
            && let Some(row) = map.row(vane).cloned()
        {
            map.left_out.push((row.from, "never changes while the aircraft turns: not recorded".to_owned()));
            map.set(vane, None);
        }
    }
}

/// Correlation of a turn with the bank; `by_bank` holds slope, rad/s, and correlation of the rate of turn on the tangent of the bank. None
/// where the slope is far from `g / V`, that of an aeroplane's turn.
fn correlate_turn_with_bank(map: &ManualChannelMap, probes: &[Probe], by_bank: Option<(f64, f64)>) -> Option<f64> {
    let speed = speed(map, probes).filter(|speed| *speed > LEAST_SPEED)?;
    let (slope, correlation) = by_bank?;
    (0.4..2.5).contains(&(slope.abs() * speed / STANDARD_GRAVITY_M_S2)).then_some(correlation)
}

/// Sign of a correlation that decides; zero where it does not.
fn decide(correlation: Option<f64>, least: f64) -> f64 {
    correlation.filter(|correlation| correlation.abs() > least).map_or(0.0, f64::signum)
}

/// Signs of attitude and rates: of the pitch by the climb or the specific force, of the bank by the track, of the heading by the track or the
/// bank, of the rates by the attitude.
fn settle_attitude(map: &mut ManualChannelMap, probes: &[Probe]) {
    let pitch = decide(pitch_sign(map, probes), ANGLE_CORRELATION);
    if pitch < 0.0 {
        turn(map, Role::PitchAngle);
    }
    let is_tracked = settle_heading(map, probes);
    let Some(turning) = turning(map, probes) else {
        turn_left_up(map, probes, [0.0; 3], [false; 3]);
        return;
    };
    let by_track = decide(correlate_turn_with_bank(map, probes, fit_track_to_bank(map, probes)), TRACK_CORRELATION);
    if by_track < 0.0 {
        turn(map, Role::BankAngle);
    }
    let of_heading = decide(correlate_turn_with_bank(map, probes, turning.heading_by_bank), ANGLE_CORRELATION);
    let by_bank = if by_track < 0.0 { -of_heading } else { of_heading };
    let roll = decide(turning.rates[0].map(|(_, correlation)| correlation), RATE_CORRELATION);
    // A bank that is known, or that agrees with its rate, and disagrees with the heading leaves the heading turned.
    match (is_tracked, by_bank < 0.0) {
        (true, true) if by_track == 0.0 => turn(map, Role::BankAngle),
        (false, true) if by_track != 0.0 || roll > 0.0 => turn(map, Role::HeadingAngle),
        (false, true) => ask(map, &[Role::BankAngle, Role::HeadingAngle]),
        _ => {}
    }
    let is_bank_known = by_track != 0.0 || (is_tracked && by_bank != 0.0);
    let is_known = [is_bank_known, pitch != 0.0, is_tracked || by_bank != 0.0];
    settle_rates(map, probes, is_known);
}

/// Signs of the rates by the attitude; where that of the attitude is not known either, both are asked for.
fn settle_rates(map: &mut ManualChannelMap, probes: &[Probe], is_known: [bool; 3]) {
    let Some(turning) = turning(map, probes) else { return };
    let pairs =
        [(Role::RollRate, Role::BankAngle), (Role::PitchRate, Role::PitchAngle), (Role::YawRate, Role::HeadingAngle)];
    let signs = turning.rates.map(|rate| decide(rate.map(|(_, correlation)| correlation), RATE_CORRELATION));
    for (((rate, angle), sign), is_known) in pairs.into_iter().zip(signs).zip(is_known) {
        if sign < 0.0 {
            turn(map, rate);
            if !is_known {
                ask(map, &[rate, angle]);
            }
        } else if sign > 0.0 {
            let turned = map.row(rate).is_some_and(|row| row.turned);
            set_sign(map, rate, turned);
        }
    }
    turn_left_up(map, probes, signs, is_known);
}

/// Correlation of the pitch with the climb, or with the specific force along x.
fn pitch_sign(map: &ManualChannelMap, probes: &[Probe]) -> Option<f64> {
    let pitch = Trace::for_role(map, Role::PitchAngle, probes)?;
    let speed = speed(map, probes).filter(|speed| *speed > LEAST_SPEED)?;
    // A pitch of an aeroplane makes a climb of about its speed.
    let by_climb = || {
        let (slope, correlation) = slope_of(&height(map, probes)?, pitch.clone())?;
        (0.25..4.0).contains(&(slope.abs() / speed)).then_some(correlation)
    };
    by_climb()
        .filter(|correlation| correlation.abs() > ANGLE_CORRELATION)
        .or_else(|| correlate_with_force(map, probes, &pitch))
}

/// Correlation of the pitch with the specific force along x.
fn correlate_with_force(map: &ManualChannelMap, probes: &[Probe], pitch: &Trace) -> Option<f64> {
    let force = Trace::for_role(map, Role::SpecificForceX, probes)?.at(&pitch.time_s)?;
    let step = (pitch.values.len() / MOST_PAIRS).max(1);
    let pairs: Vec<(f64, f64)> = pitch
        .values
        .iter()
        .zip(&force.values)
        .step_by(step)
        .map(|(pitch, force)| (STANDARD_GRAVITY_M_S2 * pitch.sin(), *force))
        .collect();
    let (slope, correlation) = fit_line(&pairs)?;
    (0.5..2.0).contains(&slope.abs()).then_some(correlation)
}
