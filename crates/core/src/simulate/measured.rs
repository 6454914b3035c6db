//! A flight as white noise shows it: what the recorders would give were their errors exactly those a filter is told.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::instrument_errors::column_errors;
use super::run::Flight;
use super::truth::Truth;
use crate::airframe::frames;
use crate::prep::accelerometer_at;
use crate::quantity::Role;
use crate::reconstruct::{FilterSettings, Input, Measurement};
use crate::series::{Channel, Recording, Series};

/// Standard deviations of aileron, elevator and rudder deflections found from the control sensors, rad: attitudes of thesis
/// Table 4.6 through the linkage.
pub(crate) const DEFLECTION_NOISE_RAD: [f64; 3] = [2.5e-4, 2.5e-4, 1.0e-4];

/// Intervals of the recorders, s (thesis Table 4.13).
const INERTIAL_S: f64 = 0.02;
const HEADING_S: f64 = 0.04;
const AIR_DATA_S: f64 = 0.08;
const SLOW_S: f64 = 0.2;

impl Flight {
    /// The flight's motion as recorded by instruments with the constant errors of [`Truth::biases`] and white noise of the
    /// deviations the filter's settings state, with the errors drawn for it ([`Flight::instrument_errors`], of a truth kept throughout): inertial data at `accelerometer_from_datum_m`, measurements, deflections. Air density,
    /// thrust and the fuel of each tank (channel `tank_channel(tank)`) come without error. Another `seed` gives other noise.
    pub fn measured(
        &self,
        noise: &FilterSettings,
        accelerometer_from_datum_m: [f64; 3],
        tank_channel: impl Fn(&str) -> String,
        seed: u64,
    ) -> Recording {
        let mut measured =
            Measured { flight: self, rng: ChaCha8Rng::seed_from_u64(seed), recording: Recording::default() };
        let biases = Truth::biases();
        for (input, column) in Input::ALL.into_iter().zip(self.inertial(accelerometer_from_datum_m)) {
            let bias = biases.iter().find(|(name, ..)| name.strip_prefix("bias_") == Some(input.name()));
            let bias = bias.map_or(0.0, |(_, value, _)| *value);
            measured.role(input.role(), INERTIAL_S, noise.process_noise[input as usize], |k| column[k] + bias);
        }
        for measurement in Measurement::ALL {
            let interval_s = match measurement {
                Measurement::BankAngle | Measurement::PitchAngle => INERTIAL_S,
                Measurement::HeadingAngle => HEADING_S,
                Measurement::Airspeed => AIR_DATA_S,
                _ => SLOW_S,
            };
            let name = measurement.name();
            measured.column(measurement.role(), name, interval_s, noise.measurement_noise[measurement as usize]);
        }
        let deflections = [(Role::Aileron, "delta_a"), (Role::Elevator, "delta_e"), (Role::Rudder, "delta_r")];
        for ((role, name), deviation) in deflections.into_iter().zip(DEFLECTION_NOISE_RAD) {
            measured.column(role, name, INERTIAL_S, deviation);
        }
        for (role, name) in
            [(Role::AirDensity, "air_density"), (Role::Thrust1, "thrust_1"), (Role::Thrust2, "thrust_2")]
        {
            measured.column(role, name, INERTIAL_S, 0.0);
        }
        measured.fuel(tank_channel);
        measured.recording
    }

    /// Column of the truth; empty where there is none.
    fn true_column(&self, name: &str) -> Vec<f64> {
        self.truth.column(name).unwrap_or_default().iter().map(|&value| f64::from(value)).collect()
    }

    /// Specific force at a place and rates, of every sample of the truth.
    fn inertial(&self, place_from_datum_m: [f64; 3]) -> [Vec<f64>; 6] {
        let columns = ["ax", "ay", "az", "p", "q", "r", "p_dot", "q_dot", "r_dot"].map(|name| self.true_column(name));
        let arm = frames::body_from_datum(place_from_datum_m, self.truth.loading_cg_at_start());
        let mut inertial: [Vec<f64>; 6] = Default::default();
        for k in 0..self.truth.time_s.len() {
            let at = |first: usize| [columns[first][k], columns[first + 1][k], columns[first + 2][k]];
            let force = accelerometer_at(arm, at(0), at(3), at(6));
            inertial.iter_mut().zip(force.into_iter().chain(at(3))).for_each(|(column, value)| column.push(value));
        }
        inertial
    }
}

/// The recording under construction.
struct Measured<'a> {
    flight: &'a Flight,
    rng: ChaCha8Rng,
    recording: Recording,
}

impl Measured<'_> {
    /// A role from a column of the truth; nothing where the truth has no such column.
    fn column(&mut self, role: Role, name: &str, interval_s: f64, deviation: f64) {
        let column = self.flight.true_column(name);
        if column.is_empty() {
            return;
        }
        let [offset, scale, delay_s] = column_errors(name, &self.flight.instrument_errors);
        let late = delay_s / self.flight.scenario.step_s;
        let shown = |k: usize| {
            let at = (k as f64 - late).clamp(0.0, (column.len() - 1) as f64);
            let (before, part) = (at as usize, at.fract());
            let value = match column.get(before + 1).filter(|_| part > 0.0) {
                Some(after) => column[before] + part * (after - column[before]),
                None => column[before],
            };
            (1.0 + scale) * value + offset
        };
        self.role(role, interval_s, deviation, shown);
    }

    /// A role from the samples of the truth nearest to every interval.
    fn role(&mut self, role: Role, interval_s: f64, deviation: f64, value: impl Fn(usize) -> f64) {
        let time = &self.flight.truth.time_s;
        let every = (interval_s / self.flight.scenario.step_s).round().max(1.0) as usize;
        let picked = (0..time.len()).step_by(every);
        let values = picked.clone().map(|k| value(k) + deviation * self.rng.sample::<f64, _>(StandardNormal));
        let (values, time_s): (Vec<f64>, Vec<f64>) = (values.collect(), picked.map(|k| time[k]).collect());
        self.recording.roles.insert(role, self.recording.channels.len());
        self.add(role.name().to_owned(), role, time_s, values);
    }

    fn add(&mut self, name: String, role: Role, time_s: Vec<f64>, values: Vec<f64>) {
        self.recording.channels.push(Channel {
            source: "simulated".to_owned(),
            name,
            unit: role.dimension().si_symbol().to_owned(),
            series: Series { time_s: Arc::from(time_s), values: Arc::from(values) },
        });
    }

    /// Fuel of each tank and in all, once a second.
    fn fuel(&mut self, tank_channel: impl Fn(&str) -> String) {
        /// First of the columns of the loading that hold the fuel of a tank, in the order of the aircraft file.
        const FIRST_TANK: usize = 8;
        let truth = &self.flight.truth;
        let mut total = vec![0.0; truth.loading_time_s.len()];
        for (tank, fuel) in self.flight.scenario.vehicle.aircraft.tanks.iter().zip(&truth.loading[FIRST_TANK..]) {
            total.iter_mut().zip(fuel).for_each(|(sum, fuel)| *sum += fuel);
            self.add(tank_channel(&tank.name), Role::FuelMass, truth.loading_time_s.clone(), fuel.clone());
        }
        self.recording.roles.insert(Role::FuelMass, self.recording.channels.len());
        self.add(Role::FuelMass.name().to_owned(), Role::FuelMass, truth.loading_time_s.clone(), total);
    }
}
