//! Natural modes of a linear motion, named by the states that take part in them.

use nalgebra::{Complex, DMatrix, DVector};

use crate::decompose::eigenvalues;

/// What a state of a linear motion is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "names say it")]
pub enum MotionState {
    /// Velocity along body x, or airspeed.
    Speed,
    /// Velocity along body z, or angle of attack.
    Heave,
    /// Velocity along body y, or sideslip.
    Sideslip,
    RollRate,
    PitchRate,
    YawRate,
    /// Bank angle.
    Bank,
    /// Pitch angle.
    Pitch,
    Heading,
    /// Horizontal position.
    Position,
    Altitude,
}

/// A natural mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// `short period`, `phugoid`, `Dutch roll`, `roll subsidence`, `spiral`, `coupled roll-spiral`; with `aperiodic` before it where the
    /// motion that is usually an oscillation has fallen into two real eigenvalues; `heading`, `altitude` or `position` where that state
    /// is most of it.
    pub name: &'static str,
    /// Real part of the eigenvalue, 1/s; negative is stable.
    pub real_1_s: f64,
    /// Imaginary part, not negative, rad/s; zero for an aperiodic mode.
    pub imaginary_rad_s: f64,
    /// Right eigenvector: amplitude and phase of each state, in the order and units of the states, of length 1.
    pub shape: Vec<Complex<f64>>,
    /// Share of each state in the mode, adding up to 1: the magnitude of the product of its entries in the left and the right
    /// eigenvector, which no choice of units changes.
    pub participation: Vec<f64>,
}

impl Mode {
    /// The eigenvalue.
    pub fn eigenvalue(&self) -> Complex<f64> {
        Complex::new(self.real_1_s, self.imaginary_rad_s)
    }

    /// Undamped natural frequency `|s|`, rad/s.
    pub fn frequency_rad_s(&self) -> f64 {
        (self.real_1_s * self.real_1_s + self.imaginary_rad_s * self.imaginary_rad_s).sqrt()
    }

    /// Damping ratio `-Re(s) / |s|`; 1 for a stable, -1 for an unstable aperiodic mode.
    pub fn damping(&self) -> f64 {
        -self.real_1_s / self.frequency_rad_s()
    }

    /// Time constant `-1 / Re(s)`, s; negative when unstable.
    pub fn time_constant_s(&self) -> f64 {
        -1.0 / self.real_1_s
    }

    /// Time to half the amplitude, `-ln 2 / Re(s)`, s; none when unstable.
    pub fn time_to_half_s(&self) -> Option<f64> {
        self.is_stable().then(|| -std::f64::consts::LN_2 / self.real_1_s)
    }

    /// Time to double the amplitude, `ln 2 / Re(s)`, s; none when stable.
    pub fn time_to_double_s(&self) -> Option<f64> {
        (self.real_1_s > 0.0).then(|| std::f64::consts::LN_2 / self.real_1_s)
    }

    /// Period of the damped oscillation, `2 pi / Im(s)`, s; none when aperiodic.
    pub fn period_s(&self) -> Option<f64> {
        self.oscillates().then(|| std::f64::consts::TAU / self.imaginary_rad_s)
    }

    /// True when it dies out.
    pub fn is_stable(&self) -> bool {
        self.real_1_s < 0.0
    }

    /// True when it is an oscillation.
    pub fn oscillates(&self) -> bool {
        self.imaginary_rad_s > 0.0
    }
}

/// All modes of the motion with this system matrix, fastest first; of each conjugate pair one. `states` says what each row is. The
/// order of the states changes neither values nor names. None of a matrix that is empty or not finite.
pub fn natural_modes(matrix: &DMatrix<f64>, states: &[MotionState]) -> Vec<Mode> {
    let values = eigenvalues(matrix.clone()).unwrap_or_default();
    let mut modes: Vec<Mode> = values
        .iter()
        .filter(|value| value.im >= 0.0)
        .map(|&value| {
            let (right, left) = (eigenvector(matrix, value), eigenvector(&matrix.transpose(), value));
            let products: Vec<f64> = right.iter().zip(&left).map(|(right, left)| (right * left).norm()).collect();
            let sum: f64 = products.iter().sum();
            // Of a defective eigenvalue left and right vectors are perpendicular: what is left of them says as much.
            let participation: Vec<f64> = products.iter().map(|product| product / sum).collect();
            let name = name(value.im > 0.0, &participation, states);
            Mode { name, real_1_s: value.re, imaginary_rad_s: value.im, shape: right, participation }
        })
        .collect();
    modes.sort_by(|a, b| b.frequency_rad_s().total_cmp(&a.frequency_rad_s()));
    modes
}

/// Right eigenvector by inverse iteration from near the eigenvalue, of length 1.
fn eigenvector(matrix: &DMatrix<f64>, value: Complex<f64>) -> Vec<Complex<f64>> {
    /// Steps: each shrinks what is not the vector by the distance of the eigenvalues over that of the shift.
    const STEPS: usize = 4;
    let size = matrix.nrows();
    let norm = matrix.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    let shift = value + Complex::new(1e-10 * norm + 1e-8 * value.norm(), 0.0);
    let shifted = DMatrix::from_fn(size, size, |i, j| {
        Complex::new(matrix[(i, j)], 0.0) - if i == j { shift } else { Complex::new(0.0, 0.0) }
    });
    let factors = shifted.lu();
    let mut vector = DVector::from_element(size, Complex::new(1.0, 0.3));
    for _ in 0..STEPS {
        if let Some(next) = factors.solve(&vector) {
            let length = next.norm();
            if length.is_finite() && length > 0.0 {
                vector = next.unscale(length);
            }
        }
    }
    vector.iter().copied().collect()
}

/// Name of a mode from what takes part in it.
fn name(oscillates: bool, participation: &[f64], states: &[MotionState]) -> &'static str {
    use MotionState::{Altitude, Bank, Heading, Heave, Pitch, PitchRate, Position, RollRate, Sideslip, Speed, YawRate};
    let share = |wanted: &[MotionState]| -> f64 {
        let wanted_shares = participation.iter().zip(states).filter(|(_, state)| wanted.contains(state));
        wanted_shares.map(|(share, _)| share).sum()
    };
    for (state, name) in [(Position, "position"), (Heading, "heading"), (Altitude, "altitude")] {
        if share(&[state]) > 0.5 {
            return name;
        }
    }
    let longitudinal = share(&[Speed, Heave, PitchRate, Pitch, Altitude]);
    let lateral = share(&[Sideslip, RollRate, YawRate, Bank, Heading]);
    if longitudinal >= lateral {
        return match (oscillates, share(&[Heave, PitchRate]) >= share(&[Speed, Pitch, Altitude])) {
            (true, true) => "short period",
            (true, false) => "phugoid",
            (false, true) => "aperiodic short period",
            (false, false) => "aperiodic phugoid",
        };
    }
    let (directional, roll, bank) = (share(&[Sideslip, YawRate]), share(&[RollRate]), share(&[Bank, Heading]));
    match oscillates {
        true if directional >= roll + bank => "Dutch roll",
        true => "coupled roll-spiral",
        false if directional > roll.max(bank) => "aperiodic Dutch roll",
        false if roll >= bank => "roll subsidence",
        false => "spiral",
    }
}
