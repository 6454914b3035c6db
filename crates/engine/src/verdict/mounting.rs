//! Rates that differ from the attitude by the mounting of the inertial unit or the scale of its gyros.

use doublet_core::compatibility::RateErrors;
use doublet_core::estimate::{Sensor, SensorError};
use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::reconstruct::Input;

use super::{Finding, Level};
use crate::session::{Edit, ErrorValues, EstimationEdit, Fix, Place, Preparation, Session};
use crate::snapshot::Snapshot;

/// A difference counts beyond this many standard errors, and beyond 1 deg or 3 %.
const SIGNIFICANT: f64 = 5.0;
const MOUNTING_RAD: f64 = std::f64::consts::PI / 180.0;
const SCALE: f64 = 0.03;
/// A filter of delay `d` reduces motion of this frequency, rad/s, by `(omega d)^2 / 2`, as a scale factor would.
const FAST_RAD_S: f64 = 6.0;
/// Body axes, and the rates about them.
const AXES: [&str; 3] = ["roll", "pitch", "yaw"];
const RATES: [Input; 3] = [Input::RollRate, Input::PitchRate, Input::YawRate];

/// An error of one axis beyond its limit.
struct Excess {
    axis: usize,
    error: SensorError,
    /// What the recording shows in all, and what the session does not yet correct.
    value: f64,
    off: f64,
    limit: f64,
}

/// Up to two findings per flight: mounting of the inertial unit against the attitude, and scale factors of the gyros.
pub(crate) fn findings(session: &Session, snapshot: &Snapshot) -> Vec<Finding> {
    let of_flight = |name: &str| {
        let found = snapshot.physics.get(name)?.ready()?.rates.as_ref()?;
        let place = Place::in_flight(name, "rates");
        Some([mounting_finding(session, found, &place), scale_finding(session, found, &place)])
    };
    session.flights.iter().filter_map(|flight| of_flight(&flight.name)).flatten().flatten().collect()
}

fn mounting_finding(session: &Session, found: &RateErrors, place: &Place) -> Option<Finding> {
    let error = SensorError::Misalignment;
    let excesses = excesses(session, error, (found.mounting_rad, found.mounting_errors_rad), MOUNTING_RAD);
    let worst = worst(&excesses)?;
    let one = |excess: &Excess| message!("{:.1} deg in {}", excess.off.abs().to_degrees(), AXES[excess.axis]);
    let differences = Message::join(excesses.iter().map(one), ", ");
    let limit_deg = worst.limit.to_degrees();
    let text = message!("Rates and attitude differ by {} (limit {:.1} deg).", differences, limit_deg);
    let finding = Finding::new(Level::Caution, "physics", place, text);
    let finding = finding.with_figure(worst.off.to_degrees(), limit_deg);
    let finding = finding.with_fix_text("Correct the misalignment of the inertial unit, or align the attitude.");
    Some(with_fix(finding, session, "correct the misalignment of the inertial unit", &excesses))
}

fn scale_finding(session: &Session, found: &RateErrors, place: &Place) -> Option<Finding> {
    let error = |axis: usize| SensorError::Scale(Sensor::Input(RATES[axis]));
    let delay_s = found.delay_s.iter().fold(0.0_f64, |most, delay_s| most.max(delay_s.abs()));
    // A rotation reduces the diagonal by the cosine.
    let rotation = 0.5 * found.mounting_rad.iter().map(|angle| angle * angle).sum::<f64>();
    let least = SCALE.max(0.5 * (FAST_RAD_S * delay_s).powi(2)).max(2.0 * rotation);
    let excesses = excesses(session, error, (found.scale, found.scale_errors), least);
    let worst = worst(&excesses)?;
    let one = |excess: &Excess| message!("{:+.1} % in {}", 100.0 * excess.off, AXES[excess.axis]);
    let differences = Message::join(excesses.iter().map(one), ", ");
    let limit = 100.0 * worst.limit;
    let text = message!("Rates and attitude differ in scale: {} (limit {:.1} %).", differences, limit);
    let finding = Finding::new(Level::Caution, "physics", place, text);
    let finding = finding.with_figure(100.0 * worst.off, limit);
    let finding = finding.with_fix_text("Correct the scale factors of the gyros.");
    Some(with_fix(finding, session, "correct the scale factors of the gyros", &excesses))
}

/// Errors beyond their limits, after those that the session already corrects.
fn excesses(
    session: &Session,
    error: impl Fn(usize) -> SensorError,
    (values, errors): ([f64; 3], [f64; 3]),
    least: f64,
) -> Vec<Excess> {
    let known = &session.preparation.known_errors.0;
    let one = |axis: usize| {
        let (error, value) = (error(axis), values[axis]);
        let off = value - known.get(&error).copied().unwrap_or(0.0);
        Excess { axis, error, value, off, limit: least.max(SIGNIFICANT * errors[axis]) }
    };
    (0..3).map(one).filter(|excess| excess.off.abs() > excess.limit).collect()
}

/// The one farthest beyond its limit.
fn worst(excesses: &[Excess]) -> Option<&Excess> {
    excesses.iter().max_by(|a, b| (a.off.abs() / a.limit).total_cmp(&(b.off.abs() / b.limit)))
}

fn with_fix(finding: Finding, session: &Session, label: &str, excesses: &[Excess]) -> Finding {
    let errors: Vec<(SensorError, f64)> = excesses.iter().map(|excess| (excess.error, excess.value)).collect();
    with_known_errors(finding, session, label, &errors)
}

/// With the known sensor errors that remove it; errors that the session estimates cannot be known as well.
pub(super) fn with_known_errors(
    finding: Finding,
    session: &Session,
    label: &str,
    errors: &[(SensorError, f64)],
) -> Finding {
    let asked = &session.sensor_errors;
    let finding = finding.with_setting("Noise and filter", "sensor_errors.known");
    if errors.iter().any(|(error, _)| asked.free.contains(error) || asked.per_window.contains(error)) {
        return finding;
    }
    let mut known = session.preparation.known_errors.0.clone();
    known.extend(errors.iter().map(|(error, value)| (*error, (1e4 * value).round() / 1e4)));
    let entries: Vec<String> = known.iter().map(|(error, value)| format!("{error} = {value:?}")).collect();
    let preparation = Preparation { known_errors: ErrorValues(known), ..session.preparation.clone() };
    let fix = Fix::new(label, Edit::Estimation(EstimationEdit::Preparation(preparation)));
    finding.with_value(format!("{{ {} }}", entries.join(", "))).with_fix(fix)
}

#[cfg(test)]
mod tests {
    use super::{mounting_finding, scale_finding};
    use crate::begin::empty_session;
    use crate::session::{Edit, EstimationEdit, Level, Place};
    use doublet_core::compatibility::RateErrors;

    const FOUND: RateErrors = RateErrors {
        mounting_rad: [0.002, 0.0689, 0.03],
        mounting_errors_rad: [0.003, 0.0028, 0.01],
        scale: [0.05, 0.031, 0.02],
        scale_errors: [0.003, 0.007, 0.001],
        delay_s: [0.0; 3],
    };

    #[test]
    fn mounting_and_scale_beyond_their_limits_are_cautions_until_the_session_corrects_them() {
        let mut session = empty_session("", None);
        let mounting = mounting_finding(&session, &FOUND, &Place::in_flight("a", "rates")).unwrap();
        assert_eq!((mounting.level, mounting.code), (Level::Caution, "physics"));
        assert_eq!(mounting.text.to_string(), "Rates and attitude differ by 3.9 deg in pitch (limit 1.0 deg).");
        assert_eq!(mounting.value.as_deref(), Some("{ misalignment_y = 0.0689 }"));
        let scale = scale_finding(&session, &FOUND, &Place::in_flight("a", "rates")).unwrap();
        assert_eq!(scale.value.as_deref(), Some("{ scale_p = 0.05 }"), "3.1 % are within five standard errors");
        for fix in [mounting.fix.unwrap(), scale.fix.unwrap()] {
            let [Edit::Estimation(EstimationEdit::Preparation(preparation))] = &fix.edits[..] else {
                panic!("{fix:?}")
            };
            session.preparation.known_errors.0.extend(preparation.known_errors.0.clone());
        }
        let filtered = RateErrors { delay_s: [0.06; 3], ..FOUND };
        assert_eq!(
            scale_finding(&empty_session("", None), &filtered, &"".into()),
            None,
            "a filter of 0.06 s may look the same"
        );
        assert_eq!(mounting_finding(&session, &FOUND, &"".into()), None);
        assert_eq!(scale_finding(&session, &FOUND, &"".into()), None);
    }
}
