//! Signs that the motion decides: attitude against rates and climb, climb against height, velocity against place. A row that its recorder
//! defines stays as it is.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::load::contents::Probe;
use crate::load::guesses::candidates::{Candidate, row};
use crate::load::guesses::ranges::EARTH_M;
use crate::load::guesses::slopes::compare_over;
use crate::load::guesses::trace::Trace;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap};
use crate::load::names::tokens::tokens;
use crate::quantity::Role;
use crate::statistics::median;

/// Span over which turns are compared, s.
const SPAN_S: f64 = 0.5;
/// Most comparisons of one pair, and the fewest that say something.
const MOST_PAIRS: usize = 4000;
const FEWEST_PAIRS: usize = 30;
/// Correlations, either way, that decide: of a rate with the turning of the attitude, of a speed with a place, of an angle with a climb.
const RATE_CORRELATION: f64 = 0.7;
const PLACE_CORRELATION: f64 = 0.8;
const ANGLE_CORRELATION: f64 = 0.6;
/// Least speed of an aeroplane whose bank turns it, m/s.
const LEAST_SPEED: f64 = 8.0;

/// Slope and correlation of the change of a place on a speed.
pub(crate) fn slope_of(place: &Trace, speed: Trace) -> Option<(f64, f64)> {
    let speed = speed.at(&place.time_s)?;
    let over = |lag_s: f64| compare_over(lag_s, &place.time_s, &place.values, &speed.values);
    // A longer lag drowns the noise of a place.
    LAGS_S.into_iter().filter_map(over).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}

/// Lags over which places are compared with speeds, s.
const LAGS_S: [f64; 2] = [1.0, 4.0];

/// Height in metres, whose sign is known.
pub(crate) fn height(map: &ManualChannelMap, probes: &[Probe]) -> Option<Trace> {
    let varies = |trace: &Trace| trace.values.iter().any(|value| (value - trace.values[0]).abs() > 1e-3);
    [Role::Altitude, Role::GpsAltitude].iter().filter_map(|role| Trace::for_role(map, *role, probes)).find(varies)
}

/// Whether a row may be turned.
fn is_free(row: &ManualChannel) -> bool {
    row.by != By::Recorder || row.asks_sign
}

/// Turns the row of a role, whose sign is then known.
fn set_sign(map: &mut ManualChannelMap, role: Role, turned: bool) {
    if let Some((_, row)) = map.rows.iter_mut().find(|(other, row)| *other == role && is_free(row)) {
        row.turned = turned;
        row.asks_sign = false;
    }
}

fn turn(map: &mut ManualChannelMap, role: Role) {
    if let Some(turned) = map.row(role).map(|row| row.turned) {
        set_sign(map, role, !turned);
    }
}

/// Settles signs; true where that of the position down, or of the speed down beside none, is settled.
pub(crate) fn settle(map: &mut ManualChannelMap, probes: &[Probe]) -> bool {
    drop_track(map, probes);
    let is_down_known = settle_down(map, probes);
    settle_horizontal(map, probes);
    settle_attitude(map, probes);
    is_down_known
}

/// Names of vertical speeds that say no direction.
const VERTICAL: [&str; 6] = ["vz", "velz", "velocityz", "zdot", "speedz", "zspeed"];

/// Gives the speed down that has no channel yet one by such a name, where it is the change of the height.
pub(crate) fn add_climb(map: &mut ManualChannelMap, candidates: &[Candidate<'_>], probes: &[Probe]) {
    let Some(height) = height(map, probes).filter(|_| map.row(Role::VelocityDown).is_none()) else { return };
    let fits = |candidate: &&Candidate<'_>| {
        let has_unit = candidate.unit.is_none_or(|unit| unit.dimension == Role::VelocityDown.dimension());
        has_unit && VERTICAL.contains(&candidate.plain.as_str())
    };
    let Some(candidate) = candidates.iter().find(fits) else { return };
    let mut found = row(candidate, Role::VelocityDown);
    let Some((_, correlation)) = Trace::read(&found, probes).and_then(|speed| slope_of(&height, speed)) else { return };
    if correlation.abs() > PLACE_CORRELATION {
        found.turned = correlation > 0.0;
        map.set(Role::VelocityDown, Some(found));
    }
}

/// Whether the name of a row says up or down.
fn says_direction(row: &ManualChannel) -> bool {
    const WORDS: [&str; 17] = [
        "vd", "veld", "pd", "posd", "down", "up", "climb", "vario", "vsi", "vvi", "vs", "roc", "d", "alt", "altitude",
        "vspd", "hdot",
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
            map.row(Role::TrueAirspeed).or(map.row(Role::CalibratedAirspeed))?;
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

/// Slope and correlation of the change of one place on that of another.
pub(crate) fn change_correlation(one: &Trace, other: Trace) -> Option<(f64, f64)> {
    let other = other.at(&one.time_s)?;
    let count = one.time_s.len();
    let lag = lag_of(&one.time_s, 1.0)?;
    let step = (count / MOST_PAIRS).max(1);
    let pair = |k: usize| (other.values[k + lag] - other.values[k], one.values[k + lag] - one.values[k]);
    let pairs: Vec<(f64, f64)> = (0..count - lag).step_by(step).map(pair).collect();
    fit_line(&pairs)
}

/// Samples in a span.
fn lag_of(time_s: &[f64], span_s: f64) -> Option<usize> {
    let count = time_s.len();
    let whole_s = time_s.last()? - time_s.first()?;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, at most the count of samples"
    )]
    let lag = ((span_s * (count - 1) as f64 / whole_s).round() as usize).max(1);
    (whole_s > span_s && lag < count).then_some(lag)
}

/// Slope through the means and correlation of pairs `x, y`.
pub(crate) fn fit_line(pairs: &[(f64, f64)]) -> Option<(f64, f64)> {
    let finite = || pairs.iter().filter(|(x, y)| x.is_finite() && y.is_finite());
    let number = finite().count();
    if number < FEWEST_PAIRS {
        return None;
    }
    let (sum_x, sum_y) = finite().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    let (mean_x, mean_y) = (sum_x / number as f64, sum_y / number as f64);
    let add = |(xx, xy, yy): (f64, f64, f64), (x, y): &(f64, f64)| {
        let (x, y) = (x - mean_x, y - mean_y);
        (xx + x * x, xy + x * y, yy + y * y)
    };
    let (xx, xy, yy) = finite().fold((0.0, 0.0, 0.0), add);
    (xx > 0.0 && yy > 0.0).then(|| (xy / xx, xy / (xx * yy).sqrt()))
}

/// Place north and east in metres of latitude and longitude.
pub(crate) fn places(map: &ManualChannelMap, probes: &[Probe]) -> Option<[Trace; 2]> {
    let latitude = Trace::for_role(map, Role::Latitude, probes)?;
    let longitude = Trace::for_role(map, Role::Longitude, probes)?.at(&latitude.time_s)?.unwrapped();
    let first = *latitude.values.iter().find(|value| value.is_finite() && **value != 0.0)?;
    let (east, north) = (longitude.map(|angle| EARTH_M * first.cos() * angle), latitude.map(|angle| EARTH_M * angle));
    Some([north, east])
}

/// Velocities and positions whose names say axes alone: exchanged where latitude and longitude say that x is east, left out where they are
/// no velocity over the Earth.
fn settle_horizontal(map: &mut ManualChannelMap, probes: &[Probe]) {
    let Some([north, east]) = places(map, probes) else { return };
    for (roles, is_speed) in
        [([Role::VelocityNorth, Role::VelocityEast], true), ([Role::PositionNorth, Role::PositionEast], false)]
    {
        let [Some(x), Some(y)] = roles.map(|role| map.row(role).cloned()) else { continue };
        let names_axis = |row: &ManualChannel| {
            let all = tokens(&row.from.channel);
            ["north", "east", "n", "e", "vn", "ve", "pn", "pe"].iter().any(|word| all.iter().any(|token| token == word))
        };
        if [&x, &y].iter().any(|row| row.by == By::Recorder || names_axis(row)) {
            continue;
        }
        let against = |place: &Trace, row: &ManualChannel| {
            let other = Trace::read(row, probes)?;
            let found = if is_speed { slope_of(place, other) } else { change_correlation(place, other) };
            found.map(|(_, correlation)| correlation)
        };
        let all = [against(&north, &x), against(&north, &y), against(&east, &x), against(&east, &y)];
        let [Some(nx), Some(ny), Some(ex), Some(ey)] = all else { continue };
        let strong = |correlation: f64| correlation.abs() > PLACE_CORRELATION;
        if strong(nx) && strong(ey) && nx.abs() + ey.abs() >= ny.abs() + ex.abs() {
            if nx < 0.0 {
                turn(map, roles[0]);
            }
            if ey < 0.0 {
                turn(map, roles[1]);
            }
        } else if strong(ny) && strong(ex) {
            map.set(roles[0], Some(ManualChannel { turned: y.turned ^ (ny < 0.0), ..y }));
            map.set(roles[1], Some(ManualChannel { turned: x.turned ^ (ex < 0.0), ..x }));
        } else if is_speed
            && x.by == By::Axes
            && [nx, ny, ex, ey].iter().all(|one| one.abs() < 0.5)
            && [(&north, &x), (&east, &y)].into_iter().any(|(place, row)| is_far(place, row, probes))
        {
            for role in [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown] {
                if let Some(row) = map.row(role).filter(|row| row.by == By::Axes).cloned() {
                    map.left_out.push((row.from, "not the change of latitude and longitude".to_owned()));
                    map.set(role, None);
                }
            }
        }
    }
}

/// Whether a velocity is not near the slope of a place, which it need not follow where both are constant.
fn is_far(place: &Trace, row: &ManualChannel, probes: &[Probe]) -> bool {
    let apart = || {
        let speed = Trace::read(row, probes)?.at(&place.time_s)?;
        let lag = lag_of(&place.time_s, 2.0)?;
        let slope = |k: usize| (place.values[k + lag] - place.values[k]) / (place.time_s[k + lag] - place.time_s[k]);
        let pairs = (0..place.values.len() - lag).map(|k| (slope(k), speed.values[k + lag / 2]));
        let (mut apart, mut sizes): (Vec<f64>, Vec<f64>) =
            pairs.filter(|(a, b)| a.is_finite() && b.is_finite()).map(|(a, b)| ((a - b).abs(), a.abs())).unzip();
        Some((median(&mut apart)?, median(&mut sizes)?))
    };
    apart().is_some_and(|(apart, size)| apart > 0.3 * size + 2.0)
}

/// Direction of flight over the Earth, rad from north to the east.
fn track(map: &ManualChannelMap, probes: &[Probe]) -> Option<Trace> {
    let north = Trace::for_role(map, Role::VelocityNorth, probes)?;
    let east = Trace::for_role(map, Role::VelocityEast, probes)?.at(&north.time_s)?;
    let angle = |(north, east): (&f64, &f64)| if north.hypot(*east) > 2.0 { east.atan2(*north) } else { f64::NAN };
    let values = north.values.iter().zip(&east.values).map(angle).collect();
    Some(Trace { values, ..north })
}

/// A heading that is the direction of the velocity to a fraction of a degree, of a receiver that gives no attitude, is a track.
fn drop_track(map: &mut ManualChannelMap, probes: &[Probe]) {
    const SAME_RAD: f64 = 5e-3;
    let Some(row) = map.row(Role::HeadingAngle).filter(|row| row.by != By::Recorder).cloned() else { return };
    let is_alone = [Role::BankAngle, Role::PitchAngle]
        .iter()
        .all(|role| map.row(*role).is_none_or(|other| other.from.source != row.from.source));
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

/// Rates of the body that the change of the attitude makes, with those recorded, in pairs.
pub(crate) struct Turning {
    /// Slope and correlation of the rate recorded on that of the attitude, for p, q, r.
    pub(crate) rates: [Option<(f64, f64)>; 3],
    /// Slope and correlation of the change of heading on the tangent of the bank.
    pub(crate) heading_by_bank: Option<(f64, f64)>,
}

/// Compares the attitude with the rates; without a heading rolling and pitching alone.
pub(crate) fn turning(map: &ManualChannelMap, probes: &[Probe]) -> Option<Turning> {
    let bank = Trace::for_role(map, Role::BankAngle, probes)?.unwrapped();
    let pitch = Trace::for_role(map, Role::PitchAngle, probes)?.at(&bank.time_s)?;
    let heading =
        Trace::for_role(map, Role::HeadingAngle, probes).map(Trace::unwrapped).and_then(|h| h.at(&bank.time_s));
    let rates = [Role::RollRate, Role::PitchRate, Role::YawRate]
        .map(|role| Trace::for_role(map, role, probes).and_then(|rate| rate.at(&bank.time_s)));
    let (count, lag) = (bank.time_s.len(), lag_of(&bank.time_s, SPAN_S)?);
    let step = (count / MOST_PAIRS).max(1);
    let mut pairs: [Vec<(f64, f64)>; 3] = Default::default();
    let mut turns = Vec::new();
    for k in (0..count - lag).step_by(step) {
        let seconds = bank.time_s[k + lag] - bank.time_s[k];
        let slope = |trace: &Trace| (trace.values[k + lag] - trace.values[k]) / seconds;
        let middle = k + lag / 2;
        let (phi, theta) = (bank.values[middle], pitch.values[middle]);
        let (rolling, pitching) = (slope(&bank), slope(&pitch));
        let yawing = heading.as_ref().map(slope);
        if seconds <= 0.0 || pitching.abs() > 10.0 || theta.abs() > 1.3 {
            continue;
        }
        if let Some(yawing) = yawing.filter(|_| phi.abs() < 1.2) {
            turns.push((phi.tan(), yawing));
        }
        let (turn, is_level) = (yawing.unwrap_or(0.0), phi.abs() < 0.2);
        let body = [
            Some(rolling - theta.sin() * turn),
            Some(phi.cos() * pitching + phi.sin() * theta.cos() * turn).filter(|_| yawing.is_some() || is_level),
            yawing.map(|turn| phi.cos() * theta.cos() * turn - phi.sin() * pitching),
        ];
        for ((pairs, rate), body) in pairs.iter_mut().zip(&rates).zip(body) {
            if let (Some(rate), Some(body)) = (rate, body) {
                let inside = &rate.values[k..=k + lag];
                let ends = 0.5 * (inside[0] + inside[lag]);
                pairs.push((body, (inside.iter().sum::<f64>() - ends) / lag as f64));
            }
        }
    }
    let rates = pairs.each_ref().map(|pairs| fit_line(pairs));
    Some(Turning { rates, heading_by_bank: fit_line(&turns) })
}

/// Correlation of the change of heading with the bank, where one makes the other as an aeroplane's turn does.
fn bank_of_turn(map: &ManualChannelMap, probes: &[Probe], turning: &Turning) -> Option<f64> {
    let speed = speed(map, probes).filter(|speed| *speed > LEAST_SPEED)?;
    let (slope, correlation) = turning.heading_by_bank?;
    (0.4..2.5).contains(&(slope.abs() * speed / STANDARD_GRAVITY_M_S2)).then_some(correlation)
}

/// Sign of a correlation that decides; zero where it does not.
fn decide(correlation: Option<f64>, least: f64) -> f64 {
    correlation.filter(|correlation| correlation.abs() > least).map_or(0.0, f64::signum)
}

/// Signs of attitude and rates: of the pitch by the climb or the specific force, of the heading by the track or the bank, of the rates by
/// the attitude.
fn settle_attitude(map: &mut ManualChannelMap, probes: &[Probe]) {
    let pitch = decide(pitch_sign(map, probes), ANGLE_CORRELATION);
    if pitch < 0.0 {
        turn(map, Role::PitchAngle);
    }
    let is_tracked = settle_heading(map, probes);
    let Some(turning) = turning(map, probes) else {
        turn_left_up(map, [0.0; 3], [false; 3]);
        return;
    };
    let by_bank = decide(bank_of_turn(map, probes, &turning), ANGLE_CORRELATION);
    let roll = decide(turning.rates[0].map(|(_, correlation)| correlation), RATE_CORRELATION);
    // A bank that agrees with its rate and disagrees with the heading leaves the heading turned.
    match (is_tracked, by_bank < 0.0) {
        (true, true) => turn(map, Role::BankAngle),
        (false, true) if roll > 0.0 => turn(map, Role::HeadingAngle),
        (false, true) => ask(map, &[Role::BankAngle, Role::HeadingAngle]),
        _ => {}
    }
    let is_known = [is_tracked && by_bank != 0.0, pitch != 0.0, is_tracked || by_bank != 0.0];
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
    turn_left_up(map, signs, is_known);
}

/// Asks for the sign of roles.
fn ask(map: &mut ManualChannelMap, roles: &[Role]) {
    for (role, row) in &mut map.rows {
        if roles.contains(role) && row.by != By::Recorder {
            row.asks_sign = true;
        }
    }
}

/// Whether a channel is named as one axis of a sensor of the words `sensors`: `acc_y`, `gyrZ`, `Y_Accel`.
fn is_axis_of(row: &ManualChannel, sensors: &[&str]) -> bool {
    let axes = ['x', 'y', 'z'];
    let all = tokens(&row.from.channel);
    let is_axis = all.last().is_some_and(|last| last.ends_with(axes))
        || all.first().is_some_and(|first| first.len() == 1 && first.ends_with(axes));
    is_axis && all.iter().any(|token| sensors.contains(&token.trim_end_matches(axes)))
}

/// A specific force that is positive upwards, of a sensor whose rates are recorded beside it: to the left where they are turned, or where
/// nothing says that they are not. Rates that agree with an attitude whose own sign is not known can both be turned: they are asked for.
/// Rates with names of their own can have other axes than the sensor's forces, whose side is asked for then.
fn turn_left_up(map: &mut ManualChannelMap, rates: [f64; 3], is_known: [bool; 3]) {
    const FORCES: [&str; 8] = ["acc", "accel", "accelerometer", "acceleration", "linear", "imu", "accelx", "a"];
    const GYROS: [&str; 8] = ["gyro", "gyr", "gyroscope", "g", "angular", "velocity", "omega", "w"];
    let forces = [Role::SpecificForceY, Role::SpecificForceZ];
    let [Some(side), Some(down)] = forces.map(|role| map.row(role).cloned()) else { return };
    if !down.turned || !is_free(&down) || ![&side, &down].into_iter().all(|row| is_axis_of(row, &FORCES)) {
        return;
    }
    let gyros = [Role::PitchRate, Role::YawRate].map(|role| map.row(role).cloned());
    if !gyros.iter().flatten().all(|row| is_free(row) && is_axis_of(row, &GYROS)) || gyros.contains(&None) {
        ask(map, &[Role::SpecificForceY]);
        return;
    }
    match (rates[1], rates[2]) {
        (pitch, yaw) if pitch < 0.0 && yaw <= 0.0 || yaw < 0.0 && pitch <= 0.0 => {
            for (role, sign) in [(Role::PitchRate, pitch), (Role::YawRate, yaw)] {
                if sign == 0.0 {
                    turn(map, role);
                }
            }
            set_sign(map, Role::SpecificForceY, true);
        }
        (0.0, 0.0) => {
            for role in [Role::SpecificForceY, Role::PitchRate, Role::YawRate] {
                set_sign(map, role, true);
            }
            // ROS defines its axes: forward, left, up (REP 103).
            if !down.from.channel.contains("linear_acceleration") {
                ask(map, &[Role::SpecificForceY, Role::PitchRate, Role::YawRate]);
            }
        }
        _ => {
            let pairs = [[Role::PitchRate, Role::PitchAngle], [Role::YawRate, Role::HeadingAngle]];
            for (pair, is_known) in pairs.iter().zip(&is_known[1..]) {
                if !is_known {
                    ask(map, pair);
                }
            }
            if is_known[1..] == [false; 2] {
                ask(map, &[Role::SpecificForceY]);
            }
        }
    }
}

/// Median speed, m/s, of the air or over the Earth.
pub(crate) fn speed(map: &ManualChannelMap, probes: &[Probe]) -> Option<f64> {
    let middle = |role: Role| {
        let mut values = Trace::for_role(map, role, probes)?.values;
        values.retain(|value| value.is_finite());
        median(&mut values)
    };
    middle(Role::TrueAirspeed).or_else(|| middle(Role::CalibratedAirspeed)).or_else(|| {
        let north = Trace::for_role(map, Role::VelocityNorth, probes)?;
        let east = Trace::for_role(map, Role::VelocityEast, probes)?.at(&north.time_s)?;
        let mut all: Vec<f64> = north.values.iter().zip(&east.values).map(|(n, e)| n.hypot(*e)).collect();
        all.retain(|value| value.is_finite());
        median(&mut all)
    })
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
    let by_force = || {
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
    };
    by_climb().filter(|correlation| correlation.abs() > ANGLE_CORRELATION).or_else(by_force)
}

/// Whether the heading follows the track; an angle of the mathematicians, from east to the north, is set so that it does, and asked for.
fn settle_heading(map: &mut ManualChannelMap, probes: &[Probe]) -> bool {
    /// Largest median distance of a heading from the track, rad.
    const DRIFT_RAD: f64 = 0.35;
    let read = || {
        let row = map.row(Role::HeadingAngle)?.clone();
        let track = track(map, probes)?;
        let heading = Trace::read(&row, probes)?.at(&track.time_s)?;
        Some((row, heading, track))
    };
    let Some((row, heading, track)) = read() else { return false };
    let apart = |sign: f64, offset: f64| {
        let one = |(heading, track): (&f64, &f64)| ((sign * heading + offset - track + PI).rem_euclid(TAU) - PI).abs();
        let mut all: Vec<f64> =
            heading.values.iter().zip(&track.values).map(one).filter(|apart| apart.is_finite()).collect();
        (all.len() >= FEWEST_PAIRS).then(|| median(&mut all)).flatten().unwrap_or(PI)
    };
    let (clockwise, mathematical) = (apart(1.0, 0.0), apart(-1.0, FRAC_PI_2));
    if clockwise < DRIFT_RAD && clockwise < 0.5 * mathematical {
        return true;
    }
    let unit = row.unit.filter(|_| is_free(&row) && !row.turned && row.offset == 0.0);
    if let Some(unit) = unit.filter(|_| mathematical < DRIFT_RAD && mathematical < 0.5 * clockwise) {
        // psi = -(raw - a quarter of a turn).
        let offset = -unit.from_si(FRAC_PI_2);
        map.set(Role::HeadingAngle, Some(ManualChannel { turned: true, offset, asks_sign: true, ..row }));
        return true;
    }
    false
}
