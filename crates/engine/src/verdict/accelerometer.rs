//! Accelerometers that are not where the aircraft file has them, by what the ground velocity says.

use doublet_core::airframe::SensorStations;
use doublet_core::model::Position;

use super::{Finding, Level};
use crate::run::Snapshot;
use crate::session::Session;

/// Difference between the place found and the place taken, in standard errors.
const SIGNIFICANT: f64 = 5.0;
/// The same, m: less does not show beside the flexing of an airframe and the travel of the centre of gravity.
const WORTH_SAYING_M: f64 = 0.3;
/// Deviation of the changes of velocity over the one with the accelerometers where they were found: beyond, forces are wrong by as much
/// as they vary.
const BAD_RATIO: f64 = 1.5;

/// Directions of the body axes, positive and negative.
const DIRECTIONS: [[&str; 2]; 3] = [["ahead of", "behind"], ["right of", "left of"], ["below", "above"]];

/// One finding per flight whose accelerometers are elsewhere than where the analysis takes them, where the recording can tell.
pub(super) fn findings(session: &Session, snapshot: &Snapshot) -> Vec<Finding> {
    session.flights.iter().filter_map(|flight| of_flight(session, snapshot, &flight.name)).collect()
}

fn of_flight(session: &Session, snapshot: &Snapshot, flight: &str) -> Option<Finding> {
    let found = snapshot.physics.get(flight)?.ready()?.accelerometer?;
    let aircraft = snapshot.aircraft.ready().map(|loaded| &loaded.aircraft);
    let flown = snapshot.flown.get(flight).and_then(|slot| slot.ready());
    let cg_m = flown.map(|flown| flown.start.state.properties.cg_from_datum_m);
    if aircraft.is_some() && cg_m.is_none() {
        return None;
    }
    let from_cg = |place: fn(&SensorStations) -> Option<[f64; 3]>, moved: bool| {
        let stated = aircraft.filter(|_| moved).and_then(|aircraft| place(&aircraft.sensors)).zip(cg_m);
        stated.map_or([0.0; 3], |(place, cg_m)| Position::Datum(place).body_from_cg_m(cg_m))
    };
    let preparation = &session.preparation;
    let taken = from_cg(|sensors| sensors.accelerometer_from_datum_m, preparation.correct_accelerometer);
    let antenna = from_cg(|sensors| sensors.antenna_from_datum_m, preparation.correct_antenna);
    let place: [f64; 3] = std::array::from_fn(|axis| antenna[axis] + found.from_velocity_m[axis]);
    let is_elsewhere = |axis: &usize| {
        // Velocities of the accelerometers' own place say nothing about where that is.
        let off_m = (place[*axis] - taken[*axis]).abs().min(found.from_velocity_m[*axis].abs());
        off_m > (SIGNIFICANT * found.errors_m[*axis]).max(WORTH_SAYING_M)
    };
    let elsewhere: Vec<usize> = (0..3).filter(is_elsewhere).collect();
    let most_m = elsewhere.iter().map(|axis| (place[*axis] - taken[*axis]).abs()).reduce(f64::max)?;
    let one = |axis: &usize| {
        let direction = DIRECTIONS[*axis][usize::from(place[*axis] < 0.0)];
        format!("{:.2} ± {:.2} m {direction}", place[*axis].abs(), found.errors_m[*axis])
    };
    let words: Vec<String> = elsewhere.iter().map(one).collect();
    let taken_at = match taken {
        [0.0, 0.0, 0.0] => "there".to_owned(),
        [x, y, z] => format!("{x:.2}, {y:.2}, {z:.2} m forward, right and down of it"),
    };
    let text = format!(
        "the accelerometers are {} the centre of gravity by what the ground velocity says, not {taken_at}: they feel the turning of the \
         aircraft, which forces, damping and flow angles then contain",
        words.join(" and ")
    );
    let is_bad = found.residual_without_m_s > BAD_RATIO * found.residual_m_s;
    let level = if is_bad { Level::Bad } else { Level::Caution };
    let finding = Finding::new(level, "accelerometer", format!("flight '{flight}'"), text);
    let finding = finding.with_figure(most_m, WORTH_SAYING_M).with_cure(cure(place, cg_m));
    Some(finding.with_setting("Airframe", "aircraft"))
}

/// What to state where, in datum axes where the centre of gravity is known in them.
fn cure([x, y, z]: [f64; 3], cg_m: Option<[f64; 3]>) -> String {
    match cg_m {
        None => "name an aircraft that states their place".to_owned(),
        Some(cg_m) => format!(
            "state their place in the aircraft file, by this estimate accelerometer_datum_m = [{:.2}, {:.2}, {:.2}] of [sensors]",
            cg_m[0] - x,
            cg_m[1] + y,
            cg_m[2] - z
        ),
    }
}
