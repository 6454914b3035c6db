//! Pitch response to the stick: bandwidth, phase delay, phase rate, dropback and overshoot.

use std::f64::consts::{PI, TAU};

use super::{Measure, Measures, PilotTask, neal_smith};
use crate::frequency::{BodeCurve, Section, TransferFunction, logarithmic_grid};
use crate::linear::StateSpace;

/// Frequencies of the curve of a model, rad/s: up to more than twice the frequency of -180 deg at a delay of 1 ms.
const BAND_RAD_S: [f64; 2] = [0.02, 200.0];
/// Points of the curve: linear interpolation between them errs by less than 1e-4 rad below the frequency of -180 deg.
const POINTS: usize = 400;

/// Pitch rate by elevator at constant speed, `q / delta = K (s + 1/T_theta2) exp(-tau s) / (s^2 + 2 zeta omega s + omega^2)`, from the model
/// `w q` of a short period (2 states, input `delta_e`) and the delay from stick to elevator, s. `K` is made positive: the stick is positive
/// where it raises the nose. None without elevator. (McRuer, Ashkenas, Graham, Aircraft Dynamics and Automatic Control, 1973, eq. 5-28.)
pub fn pitch_rate_by_elevator(short_period: &StateSpace, delay_s: f64) -> Option<TransferFunction> {
    let (q, elevator) = (short_period.state("q")?, short_period.input("delta_e")?);
    let mut rate_only = short_period.clone();
    rate_only.c = nalgebra::DMatrix::from_fn(1, short_period.a.ncols(), |_, column| f64::from(column == q));
    rate_only.d = nalgebra::DMatrix::zeros(1, short_period.b.ncols());
    let (denominator, numerator) = rate_only.transfer(0, elevator);
    let ([_, c1, c0], [_, gain, constant]) = (denominator.as_slice(), numerator.as_slice()) else { return None };
    let is_finite = [c1, c0, gain, constant].into_iter().all(|value| value.is_finite());
    (is_finite && *gain != 0.0).then(|| TransferFunction {
        gain: gain.abs(),
        numerator: vec![Section::First(constant / gain)],
        denominator: vec![Section::Second { c1: *c1, c0: *c0 }],
        delay_s,
    })
}

/// Dropback and overshoot of the pitch rate after a step of the stick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepResponse {
    /// Attitude that falls back after a step is taken out over the steady pitch rate, s; negative where it goes on.
    pub dropback_s: f64,
    /// Greatest pitch rate over the steady one.
    pub overshoot: f64,
}

/// Dropback `DB/q_ss = T_theta2 - 2 zeta / omega` and overshoot `q_max/q_ss` of `q / stick = K (s + 1/T_theta2) / (s^2 + 2 zeta omega s +
/// omega^2)`; the delay shifts both responses alike. The rate peaks where its slope `T cos(w t) + (1 - zeta omega T) sin(w t) / w` is zero,
/// `w = omega sqrt(1 - zeta^2)`; hyperbolic functions for `zeta > 1`. None unless the zero and both poles are stable. (J. C. Gibson, AGARD
/// CP-333, paper 10, 1982.)
pub fn step_response(rate: &TransferFunction) -> Option<StepResponse> {
    let ([Section::First(zero)], [Section::Second { c1, c0 }]) =
        (rate.numerator.as_slice(), rate.denominator.as_slice())
    else {
        return None;
    };
    if !(*zero > 0.0 && *c1 > 0.0 && *c0 > 0.0) {
        return None;
    }
    let (t_theta2, frequency) = (zero.recip(), c0.sqrt());
    let decay = 0.5 * c1;
    let square = c0 - decay * decay;
    // Below this the two poles are one within rounding.
    let damped = square.abs().sqrt().max(1e-6 * frequency);
    let (along, across) = (t_theta2 * damped, decay * t_theta2 - 1.0);
    let peak_s = if square > 0.0 {
        Some(along.atan2(across) / damped)
    } else {
        (across > along).then(|| (along / across).atanh() / damped)
    };
    let ratio = |time_s: f64| {
        let angle = damped * time_s;
        let (cosine, sine) = if square > 0.0 { (angle.cos(), angle.sin()) } else { (angle.cosh(), angle.sinh()) };
        1.0 - (-decay * time_s).exp() * (cosine + (decay - t_theta2 * c0) / damped * sine)
    };
    let overshoot = peak_s.map_or(1.0, |time_s| ratio(time_s).max(1.0));
    Some(StepResponse { dropback_s: t_theta2 - c1 / c0, overshoot })
}

/// Phase of a pitch attitude by stick at the criterion frequency, rad: `6 + 0.24 S` rad/s, `S` the mean slope of the gain from 1 to 6 rad/s in dB
/// per octave; none where the curve does not reach. (R. H. Smith, N. D. Geddes, AFFDL-TR-78-154.)
pub fn criterion_phase_rad(attitude: &BodeCurve) -> Option<f64> {
    const BAND: [f64; 2] = [1.0, 6.0];
    let [(low_db, _), (high_db, _)] = [attitude.at(BAND[0])?, attitude.at(BAND[1])?];
    let slope = (high_db - low_db) / (BAND[1] / BAND[0]).log2();
    let frequency = 6.0 + 0.24 * slope;
    (frequency > 0.0).then(|| attitude.at(frequency)).flatten().map(|(_, phase)| phase)
}

impl Measures {
    /// Adds those of a pitch-rate response to the stick; a delay of `None` is not known, and only what does not depend on it is added.
    pub fn add_pitch_rate(&mut self, rate: &TransferFunction, delay_s: Option<f64>, task: Option<&PilotTask>) {
        let Some(step) = step_response(rate) else { return };
        self.set(Measure::Dropback, step.dropback_s);
        self.set(Measure::PitchRateOvershoot, step.overshoot);
        let Some(delay_s) = delay_s else { return };
        let model = TransferFunction { delay_s, gain: rate.gain.abs(), ..rate.clone() };
        let grid = logarithmic_grid(BAND_RAD_S[0], BAND_RAD_S[1], POINTS);
        let attitude = BodeCurve::of_model(&model, &grid).integrated();
        self.add_pitch_attitude(&attitude, task);
        // Without delay the phase never falls to -180 deg: the gain does not limit the bandwidth, and phase delay and rate are zero.
        if self.get(Measure::PhaseDelay).is_none()
            && delay_s == 0.0
            && let Some(bandwidth) = attitude.frequency_of_phase(-0.75 * PI)
        {
            self.set(Measure::Bandwidth, bandwidth);
            for zero in [Measure::PhaseDelay, Measure::PhaseRate, Measure::AveragePhaseRate] {
                self.set(zero, 0.0);
            }
        }
    }

    /// Adds those of the curve of a pitch attitude by stick, of a model or a measured response: as far as it reaches.
    pub fn add_pitch_attitude(&mut self, attitude: &BodeCurve, task: Option<&PilotTask>) {
        /// Deg/Hz in a phase rate of 1 rad per rad/s.
        const DEG_HZ: f64 = 180.0 / PI * TAU;
        if let Some(found) = attitude.bandwidth() {
            let values = [
                (Measure::Bandwidth, found.bandwidth_rad_s()),
                (Measure::PhaseDelay, found.phase_delay_s),
                (Measure::PhaseRate, found.phase_rate_s.map(|rate| DEG_HZ * rate)),
                (Measure::AveragePhaseRate, found.average_phase_rate_s().map(|rate| DEG_HZ * rate)),
            ];
            for (measure, value) in values {
                value.into_iter().for_each(|value| self.set(measure, value));
            }
        }
        if let Some(phase_rad) = criterion_phase_rad(attitude) {
            self.set(Measure::CriterionPhase, phase_rad.to_degrees());
        }
        if let Some(found) = task.and_then(|task| neal_smith(attitude, task)) {
            self.set(Measure::PilotCompensation, found.compensation_rad.to_degrees());
            self.set(Measure::ClosedLoopResonance, found.resonance_db);
        }
    }
}
