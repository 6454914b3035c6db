//! Accelerometers that are not where the aircraft file has them, by what the ground velocity says.

use doublet_core::airframe::SensorStations;
use doublet_core::compatibility::{AccelerometerPlace, RateErrors, TellingVelocity};
use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::model::Position;

use super::{Finding, Level};
use crate::session::{AircraftEdit, ChangedValue, Edit, EstimationEdit, Fix, Place, Preparation, Session};
use crate::snapshot::Snapshot;

/// Difference between the place found and the place taken, in standard errors.
const SIGNIFICANT: f64 = 5.0;
/// The same, m: less does not show beside the flexing of an airframe and the travel of the centre of gravity; of a small aircraft this part
/// of the chord.
const WORTH_SAYING_M: f64 = 0.3;
const WORTH_SAYING_CHORDS: f64 = 0.15;
/// What they feel of the turning, part of how the forces across the flight vary: beyond, the derivatives of these are wrong by as much.
const BAD_PART: f64 = 0.15;
/// The same beyond which the velocity is of another place than it is taken for. Forces of the air and what is felt of the turning may cancel,
/// so that more is felt than recorded, but not many times as much.
const FELT_AT_MOST: f64 = 2.0;

/// Delay of bank or pitch behind the rates, s, beyond which a place is not used: gravity in late axes looks like another place, by some 0.4 m in
/// 0.1 s.
const LATE_ATTITUDE_S: f64 = 0.05;

/// Standard errors within which two velocities give the same place, and beyond which the second is not zero.
const CONFIRMED: f64 = 3.0;

/// Directions of the body axes, positive and negative.
const DIRECTIONS: [[&str; 2]; 3] = [["ahead of", "behind"], ["right of", "left of"], ["below", "above"]];

/// One finding per flight whose accelerometers are elsewhere than where the analysis takes them, where the recording can tell.
pub(crate) fn findings(session: &Session, snapshot: &Snapshot) -> Vec<Finding> {
    session.flights.iter().filter_map(|flight| position_finding(session, snapshot, &flight.name)).collect()
}

/// Place of the accelerometers found, and the one taken, from the centre of gravity, body axes, m; none where they are not found
/// elsewhere.
pub(super) fn found_and_taken_m(session: &Session, snapshot: &Snapshot, flight: &str) -> Option<[[f64; 3]; 2]> {
    position_finding(session, snapshot, flight)?;
    let places = Places::find(session, snapshot, flight)?;
    Some([places.place_m, places.taken_m])
}

/// States the place found of the accelerometers of a flight; none where the centre of gravity is not known in datum axes.
pub(super) fn fix(session: &Session, snapshot: &Snapshot, flight: &str) -> Option<Fix> {
    let places = Places::find(session, snapshot, flight)?;
    Some(place_fix(session, datum_m(places.place_m, places.cg_m?)))
}

/// Places of the accelerometers of a flight from its centre of gravity, body axes, m.
struct Places {
    found: AccelerometerPlace,
    cg_m: Option<[f64; 3]>,
    taken_m: [f64; 3],
    place_m: [f64; 3],
}

impl Places {
    fn find(session: &Session, snapshot: &Snapshot, flight: &str) -> Option<Self> {
        let physics = snapshot.physics.get(flight)?.ready()?;
        let found = physics.accelerometer.filter(|found| found.felt_part < FELT_AT_MOST)?;
        let is_late = |rates: &RateErrors| rates.delay_s[..2].iter().any(|delay_s| delay_s.abs() > LATE_ATTITUDE_S);
        // The accelerometers feel gusts that the velocity relative to the air contains.
        let has_gusts = snapshot.delays_and_gusts.gusts.as_ref().is_some_and(|gusts| gusts.is_significant());
        if physics.rates.as_ref().is_some_and(is_late) || (found.by == TellingVelocity::Air && has_gusts) {
            return None;
        }
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
        let taken_m = from_cg(|sensors| sensors.accelerometer_from_datum_m, preparation.correct_accelerometer);
        let velocity_m = match found.by {
            TellingVelocity::Ground => from_cg(|sensors| sensors.antenna_from_datum_m, preparation.correct_antenna),
            TellingVelocity::Air => from_cg(
                |sensors| sensors.alpha_vane_from_datum_m.or(sensors.beta_vane_from_datum_m),
                preparation.correct_vanes,
            ),
        };
        let place_m = std::array::from_fn(|axis| velocity_m[axis] + found.from_velocity_m[axis]);
        Some(Self { found, cg_m, taken_m, place_m })
    }
}

/// Whether the velocity relative to the air gives the same place along an axis.
fn is_confirmed(found: &AccelerometerPlace, axis: usize) -> bool {
    found.second.is_some_and(|(place, errors)| {
        let apart = (place[axis] - found.from_velocity_m[axis]).abs();
        place[axis].abs() > CONFIRMED * errors[axis] && apart < CONFIRMED * errors[axis].hypot(found.errors_m[axis])
    })
}

fn position_finding(session: &Session, snapshot: &Snapshot, flight: &str) -> Option<Finding> {
    let Places { found, cg_m, taken_m: taken, place_m: place } = Places::find(session, snapshot, flight)?;
    let aircraft = snapshot.aircraft.ready().map(|loaded| &loaded.aircraft);
    let chord_m = aircraft.map_or(f64::INFINITY, |aircraft| aircraft.reference.chord_m);
    let worth_saying_m = WORTH_SAYING_M.min(WORTH_SAYING_CHORDS * chord_m);
    let is_elsewhere = |axis: &usize| {
        // Velocities of the accelerometers' own place say nothing about where that is.
        let off_m = (place[*axis] - taken[*axis]).abs().min(found.from_velocity_m[*axis].abs());
        off_m > (SIGNIFICANT * found.errors_m[*axis]).max(worth_saying_m)
    };
    let elsewhere: Vec<usize> = (0..3).filter(is_elsewhere).collect();
    let most_m = elsewhere.iter().map(|axis| (place[*axis] - taken[*axis]).abs()).reduce(f64::max)?;
    let one = |axis: &usize| {
        let direction = DIRECTIONS[*axis][usize::from(place[*axis] < 0.0)];
        message!("{:.2} ± {:.2} m {}", place[*axis].abs(), found.errors_m[*axis], direction)
    };
    let taken_at = match taken {
        [0.0, 0.0, 0.0] => message!("at it"),
        [x, y, z] => message!("{:.2}, {:.2}, {:.2} m forward, right and down of it", x, y, z),
    };
    let text = message!(
        "Accelerometers are {} the centre of gravity by {}, not {}.",
        Message::join(elsewhere.iter().map(one), " and "),
        match found.by {
            TellingVelocity::Ground => "ground velocity",
            TellingVelocity::Air => "airspeed and vanes",
        },
        taken_at
    );
    // Without an aircraft there is a path, and no force that could be wrong.
    let is_confirmed = elsewhere.iter().all(|axis| is_confirmed(&found, *axis));
    let level = match found.felt_part > BAD_PART && aircraft.is_some() && is_confirmed {
        true => Level::Bad,
        false => Level::Caution,
    };
    let finding = Finding::new(level, "accelerometer", Place::flight(flight), text);
    let finding = finding.with_figure(most_m, worth_saying_m).with_fix_text(fix_text(place, cg_m));
    let fix = cg_m.map(|cg_m| place_fix(session, datum_m(place, cg_m)));
    Some(finding.with_setting("Airframe", "aircraft").with_fix(fix))
}

/// What to state where, in datum axes where the centre of gravity is known in them.
fn fix_text(place: [f64; 3], cg_m: Option<[f64; 3]>) -> String {
    match cg_m {
        None => "Choose an aircraft file that states their position.".to_owned(),
        Some(cg_m) => {
            let [x, y, z] = datum_m(place, cg_m);
            format!("State their position in the aircraft file: {x:.2}, {y:.2}, {z:.2} m from the datum.")
        }
    }
}

/// A place from the centre of gravity, body axes, in datum axes (x aft, y right, z up), m.
fn datum_m([x, y, z]: [f64; 3], cg_m: [f64; 3]) -> [f64; 3] {
    [cg_m[0] - x, cg_m[1] + y, cg_m[2] - z]
}

/// States the place of the accelerometers, datum axes, m.
fn place_fix(session: &Session, datum_m: [f64; 3]) -> Fix {
    let datum_m = datum_m.map(|part| (1000.0 * part).round() / 1000.0);
    let value = ChangedValue::Triple(datum_m);
    let edit = AircraftEdit::set("position of the accelerometers", "sensors.accelerometer_datum_m", value);
    let [x, y, z] = datum_m;
    let label = format!("place the accelerometers {x:.2}, {y:.2}, {z:.2} m from the datum");
    let mut fix = Fix::new(label, Edit::Aircraft(edit));
    if !session.preparation.correct_accelerometer {
        let preparation = Preparation { correct_accelerometer: true, ..session.preparation.clone() };
        fix.edits.push(Edit::Estimation(EstimationEdit::Preparation(preparation)));
    }
    fix
}
