//! Whether the aircraft flies: its airspeed against that at which the wing carries the load.

use crate::stage::AircraftData;

/// Part of the carrying airspeed above which an aircraft on the ground takes off, and below which one in flight has landed.
const TAKES_OFF: f64 = 1.1;
const HAS_LANDED: f64 = 0.8;
/// How long the airspeed must stay there, s.
const STAYS_S: f64 = 2.0;
/// Lift coefficient at the carrying airspeed of an aircraft whose file states no stall.
const CARRYING_LIFT: f64 = 1.5;
/// Time constant of the load factor, s: bumps of the runway and of gusts are shorter.
const SMOOTHING_S: f64 = 1.0;
/// Least load factor: a push-over lowers the carrying airspeed no further.
const LEAST_LOAD_FACTOR: f64 = 0.25;
/// Density of the standard atmosphere at sea level, kg/m^3.
const SEA_LEVEL_KG_M3: f64 = 1.225;

/// What decides whether the aircraft flies.
#[derive(Debug)]
pub struct Airborne {
    /// Calibrated airspeed at which the wing carries the weight at a load factor of one, m/s.
    carrying_m_s: f64,
    load_factor: f64,
    last_s: f64,
    /// When the airspeed went to where the other state begins, s.
    since_s: Option<f64>,
    is_airborne: bool,
}

impl Airborne {
    /// On the ground, by the stall that the aircraft file states; without one by a usual lift coefficient.
    pub fn new(aircraft: &AircraftData, gravity_m_s2: f64) -> Self {
        let own = &aircraft.loaded.aircraft;
        let mass_kg = aircraft.mass.mass_kg;
        let by_lift =
            || (2.0 * mass_kg * gravity_m_s2 / (SEA_LEVEL_KG_M3 * own.reference.area_m2 * CARRYING_LIFT)).sqrt();
        let carrying_m_s = own.flight_envelope.stall_at(1.0, mass_kg).unwrap_or_else(by_lift);
        Self { carrying_m_s, load_factor: 1.0, last_s: f64::NEG_INFINITY, since_s: None, is_airborne: false }
    }

    /// Takes in a calibrated airspeed and a load factor; weight on the wheels is the ground, whatever the airspeed.
    pub fn take(&mut self, time_s: f64, calibrated_m_s: f64, load_factor: f64, is_on_wheels: bool) {
        let step_s = (time_s - self.last_s).clamp(0.0, SMOOTHING_S);
        self.last_s = time_s;
        self.load_factor += (load_factor - self.load_factor) * step_s / (SMOOTHING_S + step_s);
        if is_on_wheels {
            (self.is_airborne, self.since_s) = (false, None);
            return;
        }
        let carrying_m_s = self.carrying_m_s * self.load_factor.abs().max(LEAST_LOAD_FACTOR).sqrt();
        let least = if self.is_airborne { HAS_LANDED } else { TAKES_OFF };
        if (calibrated_m_s > least * carrying_m_s) == self.is_airborne {
            self.since_s = None;
        } else if time_s - *self.since_s.get_or_insert(time_s) >= STAYS_S {
            (self.is_airborne, self.since_s) = (!self.is_airborne, None);
        }
    }

    /// Whether it flies.
    pub fn is_airborne(&self) -> bool {
        self.is_airborne
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether it flies after each second at an airspeed, with a load factor of one.
    fn after(airborne: &mut Airborne, start_s: u32, airspeeds: &[f64]) -> Vec<bool> {
        let second = |(k, airspeed): (usize, &f64)| {
            for tenth in 0..10 {
                let time_s = f64::from(start_s) + k as f64 + 0.1 * f64::from(tenth);
                airborne.take(time_s, *airspeed, 1.0, false);
            }
            airborne.is_airborne()
        };
        airspeeds.iter().enumerate().map(second).collect()
    }

    fn stalling_at(carrying_m_s: f64) -> Airborne {
        Airborne { carrying_m_s, load_factor: 1.0, last_s: f64::NEG_INFINITY, since_s: None, is_airborne: false }
    }

    #[test]
    fn it_flies_above_the_stall_and_does_not_land_in_one() {
        let mut airborne = stalling_at(36.0);
        // The take-off run, through the stalling airspeed.
        assert_eq!(
            after(&mut airborne, 0, &[10.0, 30.0, 37.0, 39.0, 45.0, 50.0, 50.0]),
            [false, false, false, false, false, false, true]
        );
        // A stall: below the stated airspeed for long, still in flight, so that its limit is watched.
        assert!(after(&mut airborne, 7, &[36.0, 34.0, 32.0, 31.0, 31.0, 31.0]).iter().all(|flies| *flies));
        assert_eq!(after(&mut airborne, 13, &[20.0, 10.0, 5.0, 5.0]), [true, true, false, false]);
    }

    #[test]
    fn a_turn_at_three_times_the_weight_and_wheels_on_the_ground() {
        let mut airborne = stalling_at(36.0);
        after(&mut airborne, 0, &[60.0, 60.0, 60.0, 60.0]);
        assert!(airborne.is_airborne());
        for tenth in 0..50 {
            airborne.take(4.0 + 0.1 * f64::from(tenth), 60.0, 3.0, false);
        }
        assert!(airborne.is_airborne());
        airborne.take(10.0, 60.0, 1.0, true);
        assert!(!airborne.is_airborne());
    }
}
