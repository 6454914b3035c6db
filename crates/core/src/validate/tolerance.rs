//! Simulated motion against measured motion inside tolerance bands, as simulators are qualified.

use crate::quantity::named_quantities;

named_quantities! {
    /// A quantity of the motion that is compared.
    Signal;
    Airspeed, "airspeed", Speed, "true airspeed";
    Altitude, "altitude", Length, "altitude above the local origin";
    AngleOfAttack, "alpha", Angle, "angle of attack";
    Sideslip, "beta", Angle, "angle of sideslip";
    BankAngle, "phi", Angle, "bank angle";
    PitchAngle, "theta", Angle, "pitch angle";
    HeadingAngle, "psi", Angle, "heading angle";
    RollRate, "p", AngularRate, "roll rate";
    PitchRate, "q", AngularRate, "pitch rate";
    YawRate, "r", AngularRate, "yaw rate";
    SpecificForceX, "ax", Acceleration, "specific force along body x";
    SpecificForceY, "ay", Acceleration, "specific force along body y";
    NormalAcceleration, "an", Acceleration, "normal acceleration, minus the specific force along body z";
}

/// Histories of all [`Signal`]s at one time vector, SI, in the order of [`Signal::ALL`].
#[derive(Clone, Debug, PartialEq)]
pub struct Histories {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// One column per signal.
    pub columns: [Vec<f64>; Signal::ALL.len()],
}

impl Histories {
    /// Column of a signal.
    pub fn get(&self, signal: Signal) -> &[f64] {
        &self.columns[signal as usize]
    }
}

/// How far the simulation may be from the measurement: the largest of the three at every sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Quantity.
    pub signal: Signal,
    /// Fixed part, SI.
    pub absolute: f64,
    /// Part of the measured value at the sample, a fraction.
    pub of_value: f64,
    /// Part of the largest measured value of the window, a fraction.
    pub of_peak: f64,
}

/// A test: every requirement must be met, each by any one of its tolerances.
#[derive(Clone, Debug, PartialEq)]
pub struct ToleranceTest {
    /// Number in the rule, for example `2.c.10`.
    pub id: String,
    /// Name.
    pub name: String,
    /// Requirements, each a choice of tolerances.
    pub requirements: Vec<Vec<Tolerance>>,
}

/// One tolerance judged.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct BandResult {
    pub tolerance: Tolerance,
    /// Half width of the band about the measurement at each sample, SI.
    pub half_width: Vec<f64>,
    /// Largest difference, as a fraction of the half width there: up to 1 is inside.
    pub worst_ratio: f64,
    /// Difference there, simulated less measured, SI.
    pub worst_error: f64,
    pub worst_time_s: f64,
    /// Share of the samples inside.
    pub share_inside: f64,
}

impl BandResult {
    /// Whether the simulation stays inside throughout.
    pub fn passed(&self) -> bool {
        self.worst_ratio <= 1.0
    }
}

/// A test judged.
#[derive(Clone, Debug, PartialEq)]
pub struct TestResult {
    /// Number in the rule.
    pub id: String,
    /// Name.
    pub name: String,
    /// Bands of each requirement.
    pub requirements: Vec<Vec<BandResult>>,
}

impl TestResult {
    /// Whether every requirement is met by one of its bands.
    pub fn passed(&self) -> bool {
        self.requirements.iter().all(|bands| bands.iter().any(BandResult::passed))
    }
}

/// Judges a simulation of as many samples as the measurement. A value that is not a number is outside.
pub fn judge(test: &ToleranceTest, measured: &Histories, simulated: &Histories) -> TestResult {
    let requirement =
        |choice: &Vec<Tolerance>| choice.iter().map(|tolerance| band(tolerance, measured, simulated)).collect();
    TestResult {
        id: test.id.clone(),
        name: test.name.clone(),
        requirements: test.requirements.iter().map(requirement).collect(),
    }
}

fn band(tolerance: &Tolerance, measured: &Histories, simulated: &Histories) -> BandResult {
    let (measurement, simulation) = (measured.get(tolerance.signal), simulated.get(tolerance.signal));
    let peak = measurement.iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
    let width = |value: f64| tolerance.absolute.max(tolerance.of_value * value.abs()).max(tolerance.of_peak * peak);
    let half_width: Vec<f64> = measurement.iter().map(|&value| width(value)).collect();
    let (mut worst, mut inside) = ((0.0_f64, 0), 0_usize);
    for (k, ((z, y), width)) in measurement.iter().zip(simulation).zip(&half_width).enumerate() {
        let ratio = (y - z).abs() / width;
        let ratio = if ratio.is_nan() { f64::INFINITY } else { ratio };
        if ratio > worst.0 {
            worst = (ratio, k);
        }
        inside += usize::from(ratio <= 1.0);
    }
    let (worst_ratio, at) = worst;
    BandResult {
        tolerance: *tolerance,
        worst_ratio,
        worst_error: simulation.get(at).zip(measurement.get(at)).map_or(f64::NAN, |(y, z)| y - z),
        worst_time_s: measured.time_s.get(at).copied().unwrap_or(f64::NAN),
        share_inside: inside as f64 / measurement.len().max(1) as f64,
        half_width,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn histories(rate: impl Fn(f64) -> f64, pitch: impl Fn(f64) -> f64) -> Histories {
        let time_s: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.1).collect();
        let mut columns: [Vec<f64>; Signal::ALL.len()] = std::array::from_fn(|_| vec![0.0; 100]);
        columns[Signal::PitchRate as usize] = time_s.iter().map(|&t| rate(t)).collect();
        columns[Signal::PitchAngle as usize] = time_s.iter().map(|&t| pitch(t)).collect();
        Histories { time_s, columns }
    }

    fn tolerance(signal: Signal, absolute: f64) -> Tolerance {
        Tolerance { signal, absolute, of_value: 0.0, of_peak: 0.0 }
    }

    #[test]
    fn test_passes_by_any_choice_and_needs_every_requirement() {
        let measured = histories(f64::sin, |_| 0.1);
        let simulated = histories(|t| t.sin() + 0.03, |t| if t > 5.0 { 0.2 } else { 0.1 });
        let mut test = ToleranceTest {
            id: "x".into(),
            name: "x".into(),
            requirements: vec![vec![tolerance(Signal::PitchAngle, 0.05), tolerance(Signal::PitchRate, 0.04)]],
        };
        let result = judge(&test, &measured, &simulated);
        assert!(result.passed());
        let pitch = &result.requirements[0][0];
        assert!(!pitch.passed() && (pitch.worst_ratio - 2.0).abs() < 1e-12 && (pitch.worst_error - 0.1).abs() < 1e-12);
        assert!((pitch.worst_time_s - 5.1).abs() < 1e-9 && (pitch.share_inside - 0.51).abs() < 1e-12);
        test.requirements.push(vec![tolerance(Signal::PitchRate, 0.02)]);
        assert!(!judge(&test, &measured, &simulated).passed());
    }

    #[test]
    fn band_is_the_widest_of_its_parts() {
        let measured = histories(|t| if t < 5.0 { 0.1 } else { -1.0 }, |_| 0.0);
        let simulated = histories(|t| if t < 5.0 { 0.14 } else { -1.09 }, |_| 0.0);
        let at = |absolute, of_value, of_peak| Tolerance { signal: Signal::PitchRate, absolute, of_value, of_peak };
        let passed = |tolerance| {
            let test = ToleranceTest { id: String::new(), name: String::new(), requirements: vec![vec![tolerance]] };
            judge(&test, &measured, &simulated).passed()
        };
        assert!(passed(at(0.05, 0.1, 0.0)));
        assert!(!passed(at(0.05, 0.0, 0.0)) && !passed(at(0.0, 0.1, 0.0)));
        assert!(passed(at(0.0, 0.0, 0.1)));
        let mut broken = simulated.clone();
        broken.columns[Signal::PitchRate as usize][3] = f64::NAN;
        let test =
            ToleranceTest { id: String::new(), name: String::new(), requirements: vec![vec![at(9.0, 0.0, 0.0)]] };
        assert!(!judge(&test, &measured, &broken).passed());
    }
}
