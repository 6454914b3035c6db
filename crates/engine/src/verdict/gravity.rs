//! A bias of az that a wrong gravity explains.

use doublet_core::compatibility::gravity_explains;
use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::quantity::Role;
use doublet_core::reconstruct::State;
use doublet_core::series::Recording;

use super::judge::Evidence;
use super::{Finding, Level};
use crate::session::{Edit, FilterEdit, Fix, Place};
use crate::stage::{BIAS_STATES, bias_table};

/// Least difference of gravity that is worth a word, m/s².
const WORTH_SAYING_M_S2: f64 = 0.005;
/// Gravity from the equator at 6 km to the poles at sea level, m/s² (WGS 84).
const ON_EARTH_M_S2: [f64; 2] = [9.76, 9.833];

/// What speaks against the gravity used: where the place is recorded, a bias of az that the gravity of the place explains; where it
/// is not, a gravity that no place has.
pub(super) fn findings(evidence: Evidence<'_>, used_m_s2: f64) -> Vec<Finding> {
    let flights = evidence.snapshot.flights.iter().filter_map(|(name, slot)| Some((name, slot.ready()?)));
    let findings = flights.filter_map(|(name, flight)| {
        let paths = evidence.windows().filter(|window| window.flight == *name).filter_map(|window| {
            let results = evidence.snapshot.windows.get(&window.name)?;
            Some((window.name.as_str(), &**results.path.ready()?))
        });
        let at = BIAS_STATES.iter().position(|state| *state == State::BiasAz)?;
        let bias = bias_table(paths).summary[0][at];
        let found = judge_gravity(&flight.recording, bias, used_m_s2)?;
        let finding = Finding::new(Level::Caution, "gravity", Place::in_flight(name, "bias_az"), found.text);
        let finding = finding.with_figure(found.off_m_s2, WORTH_SAYING_M_S2).with_fix_text(found.fix);
        let fix = found.gravity_m_s2.map(|gravity_m_s2| {
            let edit = Edit::Filter(FilterEdit::Gravity(gravity_m_s2));
            Fix::new(format!("use a gravity of {gravity_m_s2:.5} m/s2"), edit)
        });
        Some(finding.with_setting("Noise and filter", "filter.gravity_m_s2").with_fix(fix))
    });
    findings.collect()
}

/// What is wrong with a gravity.
struct Found {
    text: Message,
    off_m_s2: f64,
    fix: String,
    /// Gravity of the place, m/s², where it is recorded; by the bias otherwise, where a place has it.
    gravity_m_s2: Option<f64>,
}

fn judge_gravity(recording: &Recording, bias: f64, used_m_s2: f64) -> Option<Found> {
    if let Some(latitude) = mean(recording, Role::Latitude) {
        let altitude_m = [Role::GpsAltitude, Role::Altitude].into_iter().find_map(|role| mean(recording, role));
        let altitude_m = altitude_m.unwrap_or_default();
        let found = gravity_explains(bias, used_m_s2, latitude, altitude_m)?;
        let text = message!(
            "The gravity used, {:.5} m/s2, is off by {:+.4} m/s2, which explains the az bias of {:+.4} m/s2.",
            used_m_s2,
            found.difference_m_s2,
            bias
        );
        let fix = format!("Use {:.5} m/s2, from latitude and altitude.", found.gravity_m_s2);
        let gravity_m_s2 = Some(found.gravity_m_s2);
        return Some(Found { text, off_m_s2: found.difference_m_s2, fix, gravity_m_s2 });
    }
    let [least, most] = ON_EARTH_M_S2;
    let off_m_s2 = (used_m_s2 - most).max(least - used_m_s2);
    if off_m_s2 <= WORTH_SAYING_M_S2 {
        return None;
    }
    let text = message!(
        "The gravity used, {:.5} m/s2, is outside {} to {}; the az bias {:+.4} m/s2 suggests {:.4} m/s2.",
        used_m_s2,
        least,
        most,
        bias,
        used_m_s2 - bias
    );
    let fix = "State the local gravity, or the latitude.".to_owned();
    let suggested_m_s2 = used_m_s2 - bias;
    let gravity_m_s2 = (least..=most).contains(&suggested_m_s2).then_some(suggested_m_s2);
    Some(Found { text, off_m_s2, fix, gravity_m_s2 })
}

/// Mean of a channel over all its finite samples.
fn mean(recording: &Recording, role: Role) -> Option<f64> {
    let values = recording.role(role)?.series.values.iter().filter(|value| value.is_finite());
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::recording_of;

    fn at(place: &[(Role, f64)]) -> Recording {
        recording_of(place, |value| vec![value; 4])
    }

    #[test]
    fn gravity_of_the_place_explains_the_bias_it_makes() {
        // Somigliana at 52 deg: 9.81248 m/s2, less 3.086e-6 a metre.
        let right = 9.812_48 - 3.086e-6 * 3000.0;
        let delft = at(&[(Role::Latitude, 52f64.to_radians()), (Role::Altitude, 3000.0)]);
        let found = judge_gravity(&delft, 0.048, right + 0.05).unwrap();
        assert!(
            (found.off_m_s2 - 0.05).abs() < 3e-5 && found.fix.contains("9.8032"),
            "{} {}",
            found.off_m_s2,
            found.fix
        );
        assert!(judge_gravity(&delft, -0.048, right + 0.05).is_none(), "a bias the other way is the sensor's");
        assert!(judge_gravity(&delft, 0.03, right).is_none());
    }

    #[test]
    fn gravity_of_no_place_is_told_without_a_latitude() {
        let found = judge_gravity(&at(&[]), 0.05, 9.856_65).unwrap();
        assert!((found.gravity_m_s2.unwrap() - 9.806_65).abs() < 1e-9);
        assert!(judge_gravity(&at(&[]), -0.05, 9.756_65 - 0.005).is_some());
        assert!(judge_gravity(&at(&[]), 0.05, 9.806_65).is_none());
        let elsewhere = judge_gravity(&at(&[]), 0.2, 9.856_65).unwrap();
        assert_eq!(elsewhere.gravity_m_s2, None, "no place has 9.65665 m/s2");
    }
}
