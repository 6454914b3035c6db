//! Recorders: streams of samples, each at its own rate, on its own clock, with its own errors.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::instrument_errors::QuantityError;
use super::instruments::{Mount, QUANTITIES, Quantities, Quantity, monitor_power_w, pod_number, probe_display_lb};
use super::pilot::wrap;
use crate::propulsion::EngineInput;

/// A recorder's clock: `t_bus = offset + (1 + drift) t_own` (thesis Table 4.14).
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct Clock {
    pub offset_s: f64,
    pub drift: f64,
}

impl Clock {
    /// The bus's own clock.
    pub const REFERENCE: Self = Self { offset_s: 0.0, drift: 0.0 };

    /// Its reading at a bus time, s.
    pub(crate) fn reading_s(&self, bus_s: f64) -> f64 {
        (bus_s - self.offset_s) / (1.0 + self.drift)
    }

    /// Bus time of one of its readings, s.
    pub fn bus_s(&self, reading_s: f64) -> f64 {
        self.offset_s + (1.0 + self.drift) * reading_s
    }
}

/// How a channel's value is made from the quantities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// A quantity as it is.
    Plain(Quantity),
    /// The vertical acceleration the bus gives: `az / g + 1`, zero in level flight.
    NormalisedZ,
    /// Magnetic heading from 0 to 360 deg; the declination (rad, positive east) is taken off.
    MagneticHeading(f64),
    /// The pod's number for the angle of attack.
    Pod,
    /// What a fuel probe shows, kg; the tank by its place.
    Fuel(usize),
    /// The monitor's estimate of an engine's power.
    MonitorPower(usize),
    /// Bank, pitch or heading (0, 1, 2) of a control sensor.
    SensorAngle(Mount, usize),
}

/// A channel: unit, errors, resolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelSpec {
    /// Name in the file.
    pub name: &'static str,
    /// Unit symbol.
    pub unit: &'static str,
    /// SI value of one unit.
    pub scale: f64,
    /// SI value of zero in this unit.
    pub origin: f64,
    /// What it reads.
    pub reading: Reading,
    /// Constant error, SI.
    pub bias: f64,
    /// Standard deviation of its white noise, SI.
    pub noise: f64,
    /// Least step of the recorded number, in its unit.
    pub resolution: f64,
}

/// A stream: channels sampled together.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct StreamSpec {
    /// Name of its group or file.
    pub name: &'static str,
    pub clock: Clock,
    /// Samples per second of its own clock, Hz.
    pub rate_hz: f64,
    /// Age of what it reads when it stamps it, s.
    pub delay_s: f64,
    /// Standard deviation of the stamps, s.
    pub stamp_noise_s: f64,
    /// Records only around the manoeuvres.
    pub only_manoeuvres: bool,
    pub channels: &'static [ChannelSpec],
}

/// A recorded stream.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    /// What it is.
    pub spec: StreamSpec,
    /// Stamp of each sample by its own clock, s.
    pub time_s: Vec<f64>,
    /// Samples of each channel, in its unit.
    pub values: Vec<Vec<f32>>,
    next: u64,
    rng: ChaCha8Rng,
    exact: bool,
    errors: Vec<QuantityError>,
}

/// Number of past instants kept, for delays up to this many steps: at steps of 0.01 s, 0.03 s of a control sensor and a drawn delay of up
/// to six of its largest standard deviations, 0.1 s.
const HISTORY: usize = 64;

/// The last instants of the flight, for samples that fall between two of them or lag behind.
#[derive(Clone, Debug)]
pub struct History {
    step_s: f64,
    newest_s: f64,
    ring: Vec<Quantities>,
    /// Place of the newest.
    newest: usize,
    count: usize,
}

impl History {
    /// An empty history of instants `step_s` apart.
    pub fn new(step_s: f64) -> Self {
        Self { step_s, newest_s: f64::NEG_INFINITY, ring: vec![[0.0; QUANTITIES]; HISTORY], newest: 0, count: 0 }
    }

    /// Adds an instant.
    pub fn push(&mut self, time_s: f64, values: Quantities) {
        self.newest = (self.newest + 1) % HISTORY;
        self.ring[self.newest] = values;
        self.newest_s = time_s;
        self.count = (self.count + 1).min(HISTORY);
    }

    /// Quantities at a time in the history, by linear interpolation; the oldest ones before it.
    pub fn at(&self, time_s: f64) -> Quantities {
        let steps = ((self.newest_s - time_s) / self.step_s).max(0.0);
        let newer = (steps as usize).min(self.count.saturating_sub(1));
        let older = (newer + 1).min(self.count.saturating_sub(1));
        let fraction = steps - newer as f64;
        // Samples on the grid are taken as they are: round-off of the grid's times is no reason to interpolate.
        let (newer_values, older_values) = (self.back(newer), self.back(older));
        if fraction < 1e-6 || newer == older {
            return *newer_values;
        }
        std::array::from_fn(|i| newer_values[i] + (older_values[i] - newer_values[i]) * fraction)
    }

    /// The instant so many steps before the newest.
    fn back(&self, steps: usize) -> &Quantities {
        &self.ring[(self.newest + HISTORY - steps) % HISTORY]
    }
}

impl Stream {
    /// An empty stream for a flight of `duration_s` that begins at bus time zero. `exact` leaves out noise, bias and
    /// resolution.
    pub fn new(spec: StreamSpec, duration_s: f64, exact: bool, rng: ChaCha8Rng) -> Self {
        let expected = (duration_s * spec.rate_hz * if spec.only_manoeuvres { 0.25 } else { 1.0 }) as usize + 16;
        // A recorder with its own clock starts sampling at the first of its ticks within the flight.
        let first = (spec.clock.reading_s(0.0) * spec.rate_hz).ceil().max(0.0);
        let values = spec.channels.iter().map(|_| Vec::with_capacity(expected)).collect();
        Self { spec, time_s: Vec::with_capacity(expected), values, next: first as u64, rng, exact, errors: Vec::new() }
    }

    /// The stream with constant errors of what it reads; an exact one has none.
    #[must_use]
    pub(super) fn with_errors(self, errors: Vec<QuantityError>) -> Self {
        match self.exact {
            true => self,
            false => Self { errors, ..self },
        }
    }

    /// Quantities as the instruments show them at a time.
    fn shown(&self, history: &History, time_s: f64) -> Quantities {
        let mut values = history.at(time_s);
        for error in &self.errors {
            let index = error.quantity as usize;
            let value = match error.delay_s == 0.0 {
                true => values[index],
                false => history.at(time_s - error.delay_s)[index],
            };
            values[index] = (1.0 + error.scale) * value + error.offset;
        }
        values
    }

    /// Takes all samples due up to the newest instant of the history.
    pub fn sample(&mut self, history: &History, recording: bool) {
        // What is early reads instants that are still to come.
        let lead_s = self.errors.iter().map(|error| -error.delay_s).fold(0.0, f64::max);
        loop {
            let own_s = self.next as f64 / self.spec.rate_hz;
            let bus_s = self.spec.clock.bus_s(own_s);
            if bus_s + lead_s > history.newest_s + 1e-9 {
                return;
            }
            self.next += 1;
            if self.spec.only_manoeuvres && !recording {
                continue;
            }
            let values = self.shown(history, bus_s - self.spec.delay_s);
            let stamp = own_s + self.error(self.spec.stamp_noise_s);
            self.time_s.push(stamp);
            for index in 0..self.spec.channels.len() {
                let channel = self.spec.channels[index];
                let error = self.error(channel.noise);
                let value = if self.exact { 0.0 } else { channel.bias } + read(channel.reading, &values) + error;
                let number = self.number(&channel, value);
                self.values[index].push(number);
            }
        }
    }

    /// White noise.
    fn error(&mut self, deviation: f64) -> f64 {
        if deviation == 0.0 || self.exact {
            return 0.0;
        }
        deviation * self.rng.sample::<f64, _>(StandardNormal)
    }

    fn number(&self, channel: &ChannelSpec, si: f64) -> f32 {
        let mut number = (si - channel.origin) / channel.scale;
        if let Reading::MagneticHeading(_) = channel.reading {
            number = number.rem_euclid(360.0);
        }
        if channel.resolution > 0.0 && !self.exact {
            number = (number / channel.resolution).round() * channel.resolution;
        }
        if channel.reading == Reading::Pod {
            number = number.clamp(0.0, 100.0);
        }
        number as f32
    }
}

/// Value of a reading in SI (the pod's number as it is), before errors.
fn read(reading: Reading, values: &Quantities) -> f64 {
    let value_of = |quantity: Quantity| values[quantity as usize];
    match reading {
        Reading::Plain(quantity) => value_of(quantity),
        Reading::NormalisedZ => value_of(Quantity::SensorForceZ) + crate::atmos::STANDARD_GRAVITY_M_S2,
        Reading::MagneticHeading(declination_rad) => value_of(Quantity::HeadingUnwrapped) - declination_rad,
        Reading::Pod => pod_number(value_of(Quantity::Alpha)),
        Reading::Fuel(tank) => {
            const POUND_KG: f64 = 0.453_592_37;
            let tanks =
                [Quantity::TankMainRight, Quantity::TankMainLeft, Quantity::TankAuxRight, Quantity::TankAuxLeft];
            probe_display_lb(tank, value_of(tanks[tank.min(3)]) / POUND_KG) * POUND_KG
        }
        Reading::MonitorPower(engine) => {
            let (speed, pressure) = match engine {
                0 => (Quantity::Speed1, Quantity::Manifold1),
                _ => (Quantity::Speed2, Quantity::Manifold2),
            };
            monitor_power_w(EngineInput { speed_rad_s: value_of(speed), manifold_pressure_pa: value_of(pressure) })
        }
        Reading::SensorAngle(mount, axis) => wrap(mount.euler_rad(values)[axis.min(2)]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clock_reads_and_returns_the_bus_time() {
        let clock = Clock { offset_s: -258.81, drift: -1.43e-4 };
        assert!((clock.bus_s(clock.reading_s(3000.0)) - 3000.0).abs() < 1e-9);
        assert!(clock.reading_s(0.0) > 258.8);
    }

    #[test]
    fn history_interpolates_between_instants() {
        let mut history = History::new(0.01);
        for (k, value) in [1.0, 2.0, 4.0].into_iter().enumerate() {
            history.push(k as f64 * 0.01, [value; QUANTITIES]);
        }
        for (time, expected) in [(0.02, 4.0), (0.01, 2.0), (0.015, 3.0), (0.0, 1.0), (-1.0, 1.0)] {
            assert!((history.at(time)[0] - expected).abs() < 1e-9, "{time}");
        }
    }
}
