//! Whether the aircraft flies: its airspeed against that at which the wing carries the load.

use doublet_core::airframe::SEA_LEVEL_KG_M3;
use doublet_core::quantity::Role;

use super::limits::Limit;
use crate::stage::AircraftData;

/// Part of the carrying airspeed above which an aircraft on the ground takes off, and below which one in flight has landed.
const TAKES_OFF: f64 = 1.1;
const HAS_LANDED: f64 = 0.8;
/// Part of the carrying airspeed below which the altitude is that of the ground, whatever the wind.
const STANDS: f64 = 0.5;
/// Height above the ground of the take-off up to which a landing needs no lower airspeed than that of a take-off, m.
const LOW_M: f64 = 15.0;
/// How long the airspeed must stay there, s.
const STAYS_S: f64 = 2.0;
/// Lift coefficient at the carrying airspeed of an aircraft whose file states no stall.
const CARRYING_LIFT: f64 = 1.5;
/// Carrying airspeed without an aircraft and without a lower limit of the airspeed, m/s.
const CARRYING_M_S: f64 = 15.0;
/// Time constant of the load factor, s: bumps of the runway and of gusts are shorter.
const SMOOTHING_S: f64 = 1.0;
/// Least load factor: a push-over lowers the carrying airspeed no further.
const LEAST_LOAD_FACTOR: f64 = 0.25;

/// What decides whether the aircraft flies.
#[derive(Debug)]
pub struct Airborne {
    /// Calibrated airspeed at which the wing carries the weight at a load factor of one, m/s.
    carrying_m_s: f64,
    load_factor: f64,
    last_s: f64,
    /// When the airspeed went to where the other state begins, s.
    since_s: Option<f64>,
    /// Altitude of the ground, m.
    ground_m: Option<f64>,
    is_airborne: bool,
}

/// What is known at one sample.
#[derive(Clone, Copy, Debug)]
pub struct Flown {
    pub time_s: f64,
    /// Calibrated airspeed, m/s.
    pub calibrated_m_s: f64,
    pub load_factor: f64,
    pub altitude_m: Option<f64>,
    /// Whether weight is on the wheels; false where that is not recorded.
    pub is_on_wheels: bool,
}

impl Airborne {
    /// On the ground, by the stall that the aircraft file states; without one by a usual lift coefficient.
    pub fn new(aircraft: &AircraftData, gravity_m_s2: f64) -> Self {
        let own = &aircraft.loaded.aircraft;
        let mass_kg = aircraft.mass.mass_kg;
        let by_lift =
            || (2.0 * mass_kg * gravity_m_s2 / (SEA_LEVEL_KG_M3 * own.reference.area_m2 * CARRYING_LIFT)).sqrt();
        let carrying_m_s = own.flight_envelope.stall_at(1.0, mass_kg).unwrap_or_else(by_lift);
        Self::standing(carrying_m_s)
    }

    /// On the ground, by the lower limit of the airspeed, which stands for the stall; without one by 15 m/s.
    pub fn without_aircraft(limits: &[Limit]) -> Self {
        let low = |role: Role| limits.iter().find(|limit| limit.quantity == role.name()).and_then(|limit| limit.low);
        let low_m_s =
            low(Role::CalibratedAirspeed).or_else(|| low(Role::TrueAirspeed)).filter(|low_m_s| *low_m_s > 0.0);
        Self::standing(low_m_s.unwrap_or(CARRYING_M_S))
    }

    fn standing(carrying_m_s: f64) -> Self {
        let (load_factor, last_s) = (1.0, f64::NEG_INFINITY);
        Self { carrying_m_s, load_factor, last_s, since_s: None, ground_m: None, is_airborne: false }
    }

    /// Takes in a sample; weight on the wheels is the ground, whatever the airspeed.
    pub fn take(&mut self, flown: Flown) {
        let Flown { time_s, calibrated_m_s, load_factor, altitude_m, is_on_wheels } = flown;
        let step_s = (time_s - self.last_s).clamp(0.0, SMOOTHING_S);
        self.last_s = time_s;
        self.load_factor += (load_factor - self.load_factor) * step_s / (SMOOTHING_S + step_s);
        if is_on_wheels {
            (self.is_airborne, self.since_s) = (false, None);
            return;
        }
        let carrying_m_s = self.carrying_m_s * self.load_factor.abs().max(LEAST_LOAD_FACTOR).sqrt();
        if !self.is_airborne && calibrated_m_s < STANDS * carrying_m_s {
            self.ground_m = altitude_m;
        }
        let height_m = altitude_m.zip(self.ground_m).map(|(altitude_m, ground_m)| altitude_m - ground_m);
        let is_high = height_m.is_none_or(|height_m| height_m > LOW_M);
        let least = if self.is_airborne && is_high { HAS_LANDED } else { TAKES_OFF };
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

    fn flown(time_s: f64, calibrated_m_s: f64) -> Flown {
        Flown { time_s, calibrated_m_s, load_factor: 1.0, altitude_m: None, is_on_wheels: false }
    }

    /// Whether it flies after each second at an airspeed and an altitude.
    fn after(airborne: &mut Airborne, start_s: u32, airspeeds: &[f64], altitude_m: f64) -> Vec<bool> {
        let second = |(k, airspeed): (usize, &f64)| {
            for tenth in 0..10 {
                let time_s = f64::from(start_s) + k as f64 + 0.1 * f64::from(tenth);
                airborne.take(Flown { altitude_m: Some(altitude_m), ..flown(time_s, *airspeed) });
            }
            airborne.is_airborne()
        };
        airspeeds.iter().enumerate().map(second).collect()
    }

    #[test]
    fn it_flies_above_the_stall_and_does_not_land_in_one() {
        let mut airborne = Airborne::standing(36.0);
        // The take-off run, through the stalling airspeed.
        let run = after(&mut airborne, 0, &[10.0, 30.0, 37.0, 39.0, 45.0, 50.0, 50.0], 400.0);
        assert_eq!(run, [false, false, false, false, false, false, true]);
        // A stall: below the stated airspeed for long, still in flight, so that its limit is watched.
        let stall = after(&mut airborne, 7, &[36.0, 34.0, 32.0, 31.0, 31.0, 31.0], 900.0);
        assert!(stall.iter().all(|flies| *flies));
        // A landing on the ground it left is one from the flare on, elsewhere when the wing can carry it no more.
        let mut other = Airborne { ground_m: Some(100.0), is_airborne: true, ..Airborne::standing(36.0) };
        let speeds = [38.0, 38.0, 38.0, 36.0, 30.0, 20.0, 10.0, 5.0];
        let landing = after(&mut airborne, 13, &speeds, 402.0).iter().filter(|flies| **flies).count();
        let elsewhere = after(&mut other, 13, &speeds, 402.0).iter().filter(|flies| **flies).count();
        assert_eq!((landing, elsewhere), (2, 7));
    }

    #[test]
    fn without_an_aircraft_a_lower_limit_of_the_airspeed_or_a_stated_one_decides() {
        let limits = |text: &str| vec![text.parse::<Limit>().unwrap()];
        for (limits, taxi_m_s, flight_m_s) in
            [(vec![], 16.0, 17.0), (limits("airspeed=30:80"), 32.0, 34.0), (limits("alpha=:0.2"), 16.0, 17.0)]
        {
            let mut airborne = Airborne::without_aircraft(&limits);
            assert_eq!(after(&mut airborne, 0, &[taxi_m_s; 4], 100.0), [false; 4]);
            assert_eq!(after(&mut airborne, 4, &[flight_m_s; 3], 100.0), [false, false, true]);
        }
    }

    #[test]
    fn a_turn_at_three_times_the_weight_flies_and_wheels_on_the_ground_do_not() {
        let mut airborne = Airborne { is_airborne: true, ..Airborne::standing(36.0) };
        for tenth in 0..50 {
            airborne.take(Flown { load_factor: 3.0, ..flown(0.1 * f64::from(tenth), 60.0) });
        }
        assert!(airborne.is_airborne());
        airborne.take(Flown { is_on_wheels: true, ..flown(10.0, 60.0) });
        assert!(!airborne.is_airborne());
    }
}
