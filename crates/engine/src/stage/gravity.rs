//! The acceleration of gravity a session's filter and flights again go by.

use doublet_core::atmos::{STANDARD_GRAVITY_M_S2, gravity_m_s2};
use doublet_core::quantity::Role;
use doublet_core::series::Recording;

use crate::session::{GravitySource, Session};

/// Gravity and where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Gravity {
    /// Acceleration of gravity, m/s².
    pub m_s2: f64,
    /// Where it comes from, in words.
    pub origin: String,
}

/// Gravity of a session whose flights are `recordings`, by name: as stated, otherwise that of the ellipsoid at the mean latitude and
/// altitude of the windows in use, otherwise the standard.
pub fn gravity<'a>(session: &Session, recording: impl Fn(&str) -> Option<&'a Recording>) -> Gravity {
    if session.gravity == GravitySource::Stated {
        return Gravity { m_s2: session.filter.gravity_m_s2, origin: "stated in the session".to_owned() };
    }
    let altitude_m = mean_over_windows(session, &recording, &[Role::GpsAltitude, Role::Altitude]);
    let above = altitude_m.unwrap_or(session.preparation.origin_altitude_m);
    let latitude = mean_over_windows(session, &recording, &[Role::Latitude]);
    let here = latitude.and_then(|latitude| Some((latitude, gravity_m_s2(latitude, above).ok()?)));
    match here {
        Some((latitude, m_s2)) => {
            let assumed = if altitude_m.is_some() { "" } else { " (assumed)" };
            let origin = format!("by latitude {:.3} deg and altitude {above:.0} m{assumed}", latitude.to_degrees());
            Gravity { m_s2, origin }
        }
        None => Gravity { m_s2: STANDARD_GRAVITY_M_S2, origin: "standard: latitude not recorded".to_owned() },
    }
}

fn mean_over_windows<'a>(
    session: &Session,
    recording: impl Fn(&str) -> Option<&'a Recording>,
    roles: &[Role],
) -> Option<f64> {
    let active = session.active_windows();
    let means = active.filter_map(|window| {
        let channels = recording(&window.flight)?;
        let channel = roles.iter().find_map(|role| channels.role(*role))?;
        let found = channel.series.statistics(window.window)?;
        Some((found.mean * found.samples as f64, found.samples as f64))
    });
    let (sum, count) = means.fold((0.0, 0.0), |(sum, count), (add, n)| (sum + add, count + n));
    (count > 0.0).then_some(sum / count)
}

/// The session with this gravity in its filter.
pub fn with_gravity(session: &Session, gravity: &Gravity) -> Session {
    let mut session = session.clone();
    session.filter.gravity_m_s2 = gravity.m_s2;
    session
}

#[cfg(test)]
pub(super) mod tests {
    use doublet_core::series::{Channel, Series, TimeRange};

    use super::*;
    use crate::begin::empty_session;
    use crate::session::Manoeuvre;

    #[test]
    fn gravity_is_stated_or_that_of_the_place_or_standard() {
        let mut session = empty_session("t", Some("a"));
        session.windows.push(Manoeuvre::new("w".to_owned(), "f".to_owned(), TimeRange { start_s: 1.0, end_s: 2.0 }));
        let delft = at(&[(Role::Latitude, 52f64.to_radians()), (Role::Altitude, 3000.0)]);
        let found = gravity(&session, |_| Some(&delft));
        // Somigliana at 52 deg: 9.81247 m/s2, less 3.086e-6 a metre.
        assert!((found.m_s2 - (9.812_47 - 3.086e-6 * 3000.0)).abs() < 3e-5, "{found:?}");
        assert_eq!(found.origin, "by latitude 52.000 deg and altitude 3000 m");
        let nowhere = at(&[(Role::Altitude, 3000.0)]);
        assert_eq!(gravity(&session, |_| Some(&nowhere)).m_s2, STANDARD_GRAVITY_M_S2);
        session.gravity = GravitySource::Stated;
        session.filter.gravity_m_s2 = 9.79;
        assert_eq!(gravity(&session, |_| Some(&delft)).m_s2, 9.79);
    }

    /// Zero before and behind the manoeuvre.
    fn at(roles: &[(Role, f64)]) -> Recording {
        recording_of(roles, |value| [0.0, value, value, 0.0].to_vec())
    }

    /// A recording of a channel each second of each role.
    pub(crate) fn recording_of(roles: &[(Role, f64)], values: impl Fn(f64) -> Vec<f64>) -> Recording {
        let channel = |values: Vec<f64>| Channel {
            source: String::new(),
            name: String::new(),
            unit: String::new(),
            series: Series { time_s: (0..4).map(f64::from).collect(), values: values.into() },
        };
        Recording {
            channels: roles.iter().map(|(_, value)| channel(values(*value))).collect(),
            roles: roles.iter().enumerate().map(|(index, (role, _))| (*role, index)).collect(),
            ..Recording::default()
        }
    }
}
