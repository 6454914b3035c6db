//! Data compatibility: whether the channels of a recording fit each other, before any statistics.
//!
//! Rates are compared with attitudes, specific forces with gravity and the turning of the path, velocities with positions and altitudes,
//! airspeed with the ground velocity and the other air data, flow angles with attitude and path, deflections with what follows from
//! them, the clock with all of them, and the clocks of several recorders with each other (`docs/conventions.md`). Where a relation does
//! not hold, the mistake of a channel map is looked for that makes it hold: a sign, a unit, an offset, exchanged channels, percent for
//! an angle, ticks of another length, stamps that are late.

mod accelerometer;
mod air;
mod changes;
mod clock;
mod controls;
mod gravity;
mod line;
mod motion;
mod mounting;
mod offsets;
mod outcome;
mod relations;
mod rows;
mod search;
mod shift;
mod sizes;
mod speeds;
mod traces;
mod travels;

use crate::series::Recording;

pub use accelerometer::{AccelerometerPlace, TellingVelocity};
pub use changes::ChannelFix;
pub use gravity::{GravityExplanation, gravity_explains};
pub use mounting::RateErrors;
pub use rows::{Agreement, Compatibility, CompatibilityRow};
pub use traces::{Curves, Trace};
pub use travels::TravelForm;

/// Compares the channels of `recording` that play a role with each other, in flight and in SI as the channel map made them.
pub fn check(recording: &Recording) -> Compatibility {
    let relations = outcome::relations();
    let clocked = clock::judge(recording, &relations);
    let mut rows = clocked.rows;
    let (mut place, mut rates) = (None, None);
    if let Some(motion) = clocked.motion {
        if clocked.factor == 1.0 {
            rates = mounting::estimate_rate_errors(recording, &motion);
        }
        let (shifts, motion) = shift::find(recording, clocked.factor, motion, &relations);
        rows.extend(shifts);
        let (turned, motion) = search::turn_force(motion, &relations);
        rows.extend(turned);
        place =
            accelerometer::has_fast_attitude(recording).then(|| accelerometer::estimate_position(&motion)).flatten();
        // What accelerometers feel far from the centre of gravity looks like a mistake of their channels.
        let motion = match place.filter(AccelerometerPlace::is_clear) {
            Some(place) => place.moved(motion),
            None => motion,
        };
        let mut compared = rows::rows(&search::search(motion.clone(), &relations));
        if compared.iter().any(CompatibilityRow::is_unexplained)
            && let Some(punctual) = place.and_then(|place| place.with_punctual_velocities(&motion))
        {
            rows::explain_by_delay(&mut compared, &rows::rows(&search::search(punctual, &relations)));
        }
        rows.extend(speeds::in_knots(&compared).or_else(|| speeds::scaled(&compared, &motion)));
        rows.extend(compared);
    }
    // Channels that contradict each other tell no place.
    let accelerometer = place.filter(|_| rows.iter().all(|row| row.agreement != Agreement::Contradicts));
    // A wrong sign, unit or clock of rates or attitude is neither a mounting nor a scale factor.
    let is_wrong = |row: &CompatibilityRow| row.agreement == Agreement::Contradicts && mounting::is_part(&row.channel);
    let rates = rates.filter(|_| !rows.iter().any(is_wrong));
    Compatibility { rows, accelerometer, rates }
}
