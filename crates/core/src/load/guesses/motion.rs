//! Values of a guess against each other: changes of a place on a speed, turns of the attitude on the rates.

use crate::load::contents::Probe;
use crate::load::guesses::candidates::{Candidate, row};
use crate::load::guesses::ranges::EARTH_M;
use crate::load::guesses::slopes::compare_over;
use crate::load::guesses::trace::Trace;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap};
use crate::load::names::tokens::end_on;
use crate::quantity::Role;
use crate::statistics::median;

/// Span over which turns are compared, s.
const SPAN_S: f64 = 0.5;
/// Most comparisons of one pair, and the fewest that say something.
pub(crate) const MOST_PAIRS: usize = 4000;
pub(crate) const FEWEST_PAIRS: usize = 30;
/// Correlations, either way, that decide: of a rate with the turning of the attitude, of a speed with a place.
pub(crate) const RATE_CORRELATION: f64 = 0.7;
pub(crate) const PLACE_CORRELATION: f64 = 0.8;

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
pub(crate) fn is_free(row: &ManualChannel) -> bool {
    row.by != By::Recorder || row.asks_sign
}

/// Turns the row of a role, whose sign is then known.
pub(crate) fn set_sign(map: &mut ManualChannelMap, role: Role, turned: bool) {
    if let Some((_, row)) = map.rows.iter_mut().find(|(other, row)| *other == role && is_free(row)) {
        row.turned = turned;
        row.asks_sign = false;
    }
}

pub(crate) fn turn(map: &mut ManualChannelMap, role: Role) {
    if let Some(turned) = map.row(role).map(|row| row.turned) {
        set_sign(map, role, !turned);
    }
}

/// Names of vertical speeds that say no direction.
const VERTICAL: [&str; 6] = ["vz", "velz", "velocityz", "zdot", "speedz", "zspeed"];

/// Gives the speed down that has no channel yet one by such a name, where it is the change of the height.
pub(crate) fn add_climb(map: &mut ManualChannelMap, candidates: &[Candidate<'_>], probes: &[Probe]) {
    let Some(height) = height(map, probes).filter(|_| map.row(Role::VelocityDown).is_none()) else { return };
    let fits = |candidate: &&Candidate<'_>| {
        let has_unit = candidate.unit.is_none_or(|unit| unit.dimension == Role::VelocityDown.dimension());
        has_unit && VERTICAL.iter().any(|name| end_on(&candidate.tokens, name))
    };
    let compared = candidates.iter().filter(fits).filter_map(|candidate| {
        let found = row(candidate, Role::VelocityDown);
        let (_, correlation) = slope_of(&height, Trace::read(&found, probes)?)?;
        Some((found, correlation))
    });
    let best = compared.max_by(|(_, one), (_, other)| one.abs().total_cmp(&other.abs()));
    if let Some((found, correlation)) = best.filter(|(_, correlation)| correlation.abs() > PLACE_CORRELATION) {
        map.set(Role::VelocityDown, Some(ManualChannel { turned: correlation > 0.0, ..found }));
    }
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
pub(crate) fn lag_of(time_s: &[f64], span_s: f64) -> Option<usize> {
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

/// Asks for the sign of roles.
pub(crate) fn ask(map: &mut ManualChannelMap, roles: &[Role]) {
    for (role, row) in &mut map.rows {
        if roles.contains(role) && row.by != By::Recorder {
            row.asks_sign = true;
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
    let over_earth = || {
        let mut all = ground_speed(map, probes, false)?.values;
        all.retain(|value| value.is_finite());
        median(&mut all)
    };
    Role::AIRSPEEDS.into_iter().find_map(middle).or_else(over_earth)
}

/// Speed over the Earth, of velocities, whose unit is known where it must be, or of places.
pub(crate) fn ground_speed(map: &ManualChannelMap, probes: &[Probe], must_be_known: bool) -> Option<Trace> {
    let known = |role: Role| {
        let row = map.row(role).filter(|row| !must_be_known || !row.is_unit_open(probes))?;
        Trace::read(row, probes)
    };
    if let (Some(north), Some(east)) = (known(Role::VelocityNorth), known(Role::VelocityEast)) {
        let east = east.at(&north.time_s)?;
        let values = north.values.iter().zip(&east.values).map(|(north, east)| north.hypot(*east)).collect();
        return Some(Trace { values, ..north });
    }
    way_of(&places(map, probes)?)
}

/// Speed along the way of a place north and east over two seconds.
pub(crate) fn way_of([north, east]: &[Trace; 2]) -> Option<Trace> {
    let span_s = north.time_s.last()? - north.time_s.first()?;
    let count = north.values.len();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, at most the count of samples"
    )]
    let lag = ((2.0 * count as f64 / span_s).round() as usize).max(1);
    let speed = |k: usize| {
        let way = (north.values[k + lag] - north.values[k]).hypot(east.values[k + lag] - east.values[k]);
        way / (north.time_s[k + lag] - north.time_s[k])
    };
    let values: Vec<f64> = (0..count.checked_sub(lag)?).map(speed).collect();
    Some(Trace { time_s: north.time_s[..values.len()].to_vec(), values })
}
