//! Accelerometers that are not where the aircraft file has them, by what the ground velocity says.

use doublet_core::model::Position;

use super::judge::Evidence;
use super::{Finding, Level};

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
pub(super) fn findings(evidence: Evidence<'_>) -> Vec<Finding> {
    let flights = evidence.session.flights.iter();
    flights.filter_map(|flight| of_flight(evidence, &flight.name)).collect()
}

fn of_flight(evidence: Evidence<'_>, flight: &str) -> Option<Finding> {
    let found = evidence.snapshot.physics.get(flight)?.ready()?.accelerometer?;
    let cg_m = evidence.snapshot.flown.get(flight)?.ready()?.start.state.properties.cg_from_datum_m;
    let sensors = evidence.snapshot.aircraft.ready()?.aircraft.sensors;
    let preparation = &evidence.session.preparation;
    let from_cg = |stated: Option<[f64; 3]>, moved: bool| {
        stated.filter(|_| moved).map_or([0.0; 3], |place| Position::Datum(place).body_from_cg_m(cg_m))
    };
    let taken = from_cg(sensors.accelerometer_from_datum_m, preparation.correct_accelerometer);
    let antenna = from_cg(sensors.antenna_from_datum_m, preparation.correct_antenna);
    let place: [f64; 3] = std::array::from_fn(|axis| antenna[axis] + found.from_velocity_m[axis]);
    let is_elsewhere = |axis: &usize| {
        let (off_m, error_m) = ((place[*axis] - taken[*axis]).abs(), found.errors_m[*axis]);
        // Velocities of the accelerometers' own place say nothing about where that is.
        let told_m = found.from_velocity_m[*axis].abs();
        off_m.min(told_m) > (SIGNIFICANT * error_m).max(WORTH_SAYING_M)
    };
    let elsewhere: Vec<usize> = (0..3).filter(is_elsewhere).collect();
    let most_m = elsewhere.iter().map(|axis| (place[*axis] - taken[*axis]).abs()).reduce(f64::max)?;
    let one = |axis: &usize| {
        let direction = DIRECTIONS[*axis][usize::from(place[*axis] < 0.0)];
        format!("{:.2} ± {:.2} m {direction}", place[*axis].abs(), found.errors_m[*axis])
    };
    let words: Vec<String> = elsewhere.iter().map(one).collect();
    let [x, y, z] = taken;
    let taken = if taken == [0.0; 3] {
        "is taken there".to_owned()
    } else {
        format!("is taken at {x:.2}, {y:.2}, {z:.2} m forward, right and down of it")
    };
    let ratio = found.residual_without_m_s / found.residual_m_s;
    let text = format!(
        "the accelerometers are {} the centre of gravity by what the ground velocity says, and their signal {taken}: it turns with the \
         aircraft, and forces, damping and flow angles are wrong by it",
        words.join(" and ")
    );
    let level = if ratio > BAD_RATIO { Level::Bad } else { Level::Caution };
    let datum: Vec<String> =
        [cg_m[0] - place[0], cg_m[1] + place[1], cg_m[2] - place[2]].map(|value| format!("{value:.2}")).into();
    let cure = format!(
        "state their place in the aircraft file: by this estimate [sensors] accelerometer_datum_m = [{}]",
        datum.join(", ")
    );
    let finding =
        Finding::new(level, "accelerometer", format!("flight '{flight}'"), text).with_figure(most_m, WORTH_SAYING_M);
    Some(finding.with_cure(cure).with_setting("Airframe", "aircraft"))
}
