//! Bandwidth, phase delay and margins of a response or a model.

use super::transfer::TransferFunction;

/// Step of the phase rate as a fraction of the frequency.
const PHASE_RATE_STEP: f64 = 0.05;

/// Gain and phase over frequency, phase without jumps.
#[derive(Clone, Debug, PartialEq)]
pub struct BodeCurve {
    /// Angular frequencies, rad/s, rising.
    pub omega_rad_s: Vec<f64>,
    /// Gains, dB.
    pub gain_db: Vec<f64>,
    /// Phases, rad.
    pub phase_rad: Vec<f64>,
}

/// Bandwidth of an attitude response (MIL-STD-1797A, 4.2.1.2 and appendix).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bandwidth {
    /// Frequency of phase -180 deg, rad/s.
    pub omega_180_rad_s: f64,
    /// Frequency of phase -135 deg, 45 deg of phase margin, rad/s.
    pub phase_limited_rad_s: Option<f64>,
    /// Frequency at which the gain is 6 dB above that at -180 deg, rad/s.
    pub gain_limited_rad_s: Option<f64>,
    /// `-(phase(2 omega_180) + pi) / (2 omega_180)`, s.
    pub phase_delay_s: Option<f64>,
    /// Phase rate `-d phase / d omega` at -180 deg, rad per rad/s, from the phases 5 % to either side.
    pub phase_rate_s: Option<f64>,
}

impl Bandwidth {
    /// The lower of both frequencies, rad/s; the one there is where the other lies outside the curve.
    pub fn bandwidth_rad_s(&self) -> Option<f64> {
        match (self.phase_limited_rad_s, self.gain_limited_rad_s) {
            (Some(phase), Some(gain)) => Some(phase.min(gain)),
            (one, other) => one.or(other),
        }
    }

    /// Average phase rate from `omega_180` to twice that, `-(phase(2 omega_180) + pi) / omega_180`, rad per rad/s: twice the phase delay
    /// (J. C. Gibson, Development of a Methodology for Excellence in Handling Qualities Design, TU Delft, 1999).
    pub fn average_phase_rate_s(&self) -> Option<f64> {
        self.phase_delay_s.map(|delay| 2.0 * delay)
    }
}

/// Margins of a loop that is closed over the response with a gain of minus one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// First frequency of phase -180 deg, rad/s, and the gain below one there, dB.
    pub gain: Option<(f64, f64)>,
    /// Last frequency of gain one, rad/s, and the phase above -180 deg there, rad.
    pub phase: Option<(f64, f64)>,
}

impl BodeCurve {
    /// Curve of a model with positive gain at the frequencies given, rising.
    pub fn of_model(model: &TransferFunction, omega_rad_s: &[f64]) -> Self {
        Self {
            omega_rad_s: omega_rad_s.to_vec(),
            gain_db: omega_rad_s.iter().map(|&omega| 20.0 * model.at(omega).norm().log10()).collect(),
            phase_rad: omega_rad_s.iter().map(|&omega| model.phase_rad(omega)).collect(),
        }
    }

    /// The curve of the integral of the output: over `j omega`.
    pub fn integrated(&self) -> Self {
        let gains = self.gain_db.iter().zip(&self.omega_rad_s);
        Self {
            omega_rad_s: self.omega_rad_s.clone(),
            gain_db: gains.map(|(gain, omega)| gain - 20.0 * omega.log10()).collect(),
            phase_rad: self.phase_rad.iter().map(|phase| phase - std::f64::consts::FRAC_PI_2).collect(),
        }
    }

    /// Bandwidth of the curve of an attitude; `None` where the phase does not reach -180 deg.
    pub fn bandwidth(&self) -> Option<Bandwidth> {
        use std::f64::consts::PI;
        let omega_180_rad_s = self.crossings(&self.phase_rad, -PI).next()?;
        let gain_180 = self.value(&self.gain_db, omega_180_rad_s)?;
        let below = |omega: &f64| *omega < omega_180_rad_s;
        let twice = self.value(&self.phase_rad, 2.0 * omega_180_rad_s);
        let beside = |part: f64| self.value(&self.phase_rad, part * omega_180_rad_s);
        let rise = beside(1.0 - PHASE_RATE_STEP).zip(beside(1.0 + PHASE_RATE_STEP)).map(|(low, high)| low - high);
        Some(Bandwidth {
            phase_rate_s: rise.map(|rise| rise / (2.0 * PHASE_RATE_STEP * omega_180_rad_s)),
            omega_180_rad_s,
            phase_limited_rad_s: self.crossings(&self.phase_rad, -0.75 * PI).find(below),
            gain_limited_rad_s: self.crossings(&self.gain_db, gain_180 + 6.0).find(below),
            phase_delay_s: twice.map(|phase| -(phase + PI) / (2.0 * omega_180_rad_s)),
        })
    }

    /// First frequency at which the phase falls through a value, rad/s.
    pub fn frequency_of_phase(&self, phase_rad: f64) -> Option<f64> {
        self.crossings(&self.phase_rad, phase_rad).next()
    }

    /// Gain, dB, and phase, rad, at a frequency inside the curve.
    pub fn at(&self, omega_rad_s: f64) -> Option<(f64, f64)> {
        Some((self.value(&self.gain_db, omega_rad_s)?, self.value(&self.phase_rad, omega_rad_s)?))
    }

    /// Gain and phase margin, where the curve reaches them.
    pub fn margins(&self) -> Margins {
        use std::f64::consts::PI;
        let omega_180 = self.crossings(&self.phase_rad, -PI).next();
        let crossover = self.crossings(&self.gain_db, 0.0).last();
        Margins {
            gain: omega_180.and_then(|omega| Some((omega, -self.value(&self.gain_db, omega)?))),
            phase: crossover.and_then(|omega| Some((omega, self.value(&self.phase_rad, omega)? + PI))),
        }
    }

    /// Frequencies at which `values` fall through `level`, straight in the logarithm of frequency.
    fn crossings<'v>(&'v self, values: &'v [f64], level: f64) -> impl Iterator<Item = f64> + 'v {
        let pairs = self.omega_rad_s.windows(2).zip(values.windows(2));
        pairs.filter(move |(_, v)| v[0] > level && v[1] <= level).map(move |(omega, v)| {
            let part = (v[0] - level) / (v[0] - v[1]);
            omega[0] * (omega[1] / omega[0]).powf(part)
        })
    }

    /// Value at a frequency inside the curve.
    fn value(&self, values: &[f64], omega: f64) -> Option<f64> {
        let above = self.omega_rad_s.partition_point(|&other| other < omega);
        let (low, high) = (above.checked_sub(1).unwrap_or(above), above);
        let (left, right) = (*self.omega_rad_s.get(low)?, *self.omega_rad_s.get(high)?);
        if low == high {
            return (left == omega).then(|| values[low]);
        }
        let part = (omega / left).ln() / (right / left).ln();
        Some(values[low] + part * (values[high] - values[low]))
    }
}
