//! Roll performance: time to change bank after a step of aileron.

use nalgebra::{DMatrix, DVector};

use super::{Measure, Measures};
use crate::linear::StateSpace;

/// Changes of bank that standards ask for, deg.
const BANKS: [(f64, Measure); 5] = [
    (25.0, Measure::TimeToBank25),
    (30.0, Measure::TimeToBank30),
    (45.0, Measure::TimeToBank45),
    (60.0, Measure::TimeToBank60),
    (90.0, Measure::TimeToBank90),
];
/// Step of the response, s.
const STEP_S: f64 = 0.01;
/// Longest time that is waited for, s.
const LONGEST_S: f64 = 30.0;

/// Time, s, until the bank has changed by each of `banks_rad` (rising, above zero) after a step of aileron of `aileron_rad` (either sign), from
/// the linear model `v p r phi` of the lateral motion with the rudder held: `x(t + h) = exp(A h) x + integral(exp(A s)) B u`, exact for a
/// step, straight between samples of 10 ms. Infinite for a bank that is not reached within 30 s; none without bank or aileron. Valid as far as
/// the derivatives hold at that roll rate and bank; the pull of gravity is that about the trim. (MIL-F-8785C, 3.3.4, time from the first
/// motion of the control.)
pub fn times_to_bank(lateral: &StateSpace, aileron_rad: f64, banks_rad: &[f64]) -> Option<Vec<f64>> {
    let (bank, aileron) = (lateral.state("phi")?, lateral.input("delta_a")?);
    let size = lateral.a.nrows();
    let mut joined = DMatrix::zeros(size + 1, size + 1);
    joined.view_mut((0, 0), (size, size)).copy_from(&lateral.a);
    joined.view_mut((0, size), (size, 1)).copy_from(&lateral.b.column(aileron));
    let step = (joined * STEP_S).exp();
    let mut state = DVector::zeros(size + 1);
    state[size] = aileron_rad;
    let mut times = vec![f64::INFINITY; banks_rad.len()];
    let (mut reached, mut before) = (0, 0.0_f64);
    let mut time_s = 0.0;
    while time_s < LONGEST_S && reached < banks_rad.len() {
        state = &step * state;
        let now = state[bank].abs();
        if !now.is_finite() {
            return None;
        }
        while reached < banks_rad.len() && now >= banks_rad[reached] {
            times[reached] = time_s + STEP_S * (banks_rad[reached] - before) / (now - before);
            reached += 1;
        }
        (before, time_s) = (now, time_s + STEP_S);
    }
    Some(times)
}

impl Measures {
    /// Adds the times to bank with an aileron deflection, rad, and the delay from stick to aileron, s.
    pub fn add_times_to_bank(&mut self, lateral: &StateSpace, aileron_rad: f64, delay_s: f64) {
        let banks = BANKS.map(|(degrees, _)| degrees.to_radians());
        let Some(times) = times_to_bank(lateral, aileron_rad, &banks) else { return };
        BANKS.iter().zip(times).for_each(|((_, measure), time_s)| self.set(*measure, time_s + delay_s));
    }
}
