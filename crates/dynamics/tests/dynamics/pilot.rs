//! Pitch response to the stick, the loop closed by a pilot and roll performance against independent computations with scipy: step
//! responses, frequencies on 400,000 points, two equations solved for lead and gain of the pilot, and Runge-Kutta in roll.

use doublet_dynamics::frequency::{BodeCurve, Section, TransferFunction, logarithmic_grid};
use doublet_dynamics::linear::StateSpace;
use doublet_dynamics::qualities::{
    Airplane, Limits, Measure, Measures, PilotTask, QualityLevel, criterion_phase_rad, judge, measure_interval,
    neal_smith, pitch_rate_by_elevator, step_response, times_to_bank,
};
use nalgebra::DMatrix;
use toml::{Table, Value};

use crate::cr_2144::{lateral, level_trim, longitudinal};

/// `K (s + 1/T) exp(-tau s) / (s^2 + 2 zeta omega s + omega^2)`.
fn rate([gain, zero, zeta, omega, delay_s]: [f64; 5]) -> TransferFunction {
    TransferFunction {
        gain,
        numerator: vec![Section::First(zero)],
        denominator: vec![Section::Second { c1: 2.0 * zeta * omega, c0: omega * omega }],
        delay_s,
    }
}

/// The identified pitch response of the Tu-144 report, section 5.1.
const TU_144: [f64; 5] = [1.972, 2.048, 0.607, 2.922, 0.120];

fn task(bandwidth_rad_s: f64) -> PilotTask {
    PilotTask { bandwidth_rad_s, delay_s: 0.3, droop_db: -3.0 }
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found} instead of {expected}");
}

fn limits(name: &str) -> Limits {
    let path = format!("{}/../../assets/flying_qualities/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Limits::parse(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn models() -> Option<Table> {
    let path = crate::shared::shared("reference/flying/linear_models.toml")?;
    Some(std::fs::read_to_string(path).unwrap().parse().unwrap())
}

#[test]
fn dropback_and_overshoot_match_step_responses() {
    // Underdamped, aperiodic with and without overshoot; the last two columns from scipy's step response and its integral.
    for (system, overshoot, dropback) in [
        (TU_144, 1.314_408, 0.072_812),
        ([5.0, 0.8, 0.9, 3.0, 0.05], 1.830_494, 0.65),
        ([5.0, 1.25, 1.4, 2.0, 0.05], 1.0, -0.6),
        ([5.0, 1.25, 0.69, 4.9, 0.05], 2.240_265, 0.518_367),
    ] {
        let found = step_response(&rate(system)).unwrap();
        close(found.overshoot, overshoot, 2e-6, "overshoot");
        close(found.dropback_s, dropback, 1e-6, "dropback");
    }
    // Aperiodic with overshoot: zeta 1.2, omega 2, T 1.5 s against the sum of two exponentials sampled finely.
    let (zeta, omega, t): (f64, f64, f64) = (1.2, 2.0, 1.5);
    let [fast, slow] = [1.0, -1.0].map(|sign| -zeta * omega - sign * omega * (zeta * zeta - 1.0).sqrt());
    let part = |pole: f64, other: f64| omega * omega * (t * pole + 1.0) / (pole * (pole - other));
    let at = |time: f64| 1.0 + part(fast, slow) * (fast * time).exp() + part(slow, fast) * (slow * time).exp();
    let greatest = (0..40_000).map(|k| at(1e-4 * f64::from(k))).fold(0.0, f64::max);
    let found = step_response(&rate([1.0, 1.0 / t, zeta, omega, 0.0])).unwrap();
    assert!(greatest > 1.1);
    close(found.overshoot, greatest, 1e-7, "aperiodic overshoot");
    // Neither an unstable short period nor a zero to the right has them.
    assert_eq!(step_response(&rate([1.0, 1.0, -0.1, 2.0, 0.0])), None);
    assert_eq!(step_response(&rate([1.0, -1.0, 0.5, 2.0, 0.0])), None);
}

#[test]
fn phase_rates_and_bandwidth_match_those_of_the_reference_system() {
    let mut measures = Measures::default();
    measures.add_pitch_rate(&rate(TU_144), Some(TU_144[4]), Some(&task(2.5)));
    let of = |measure: Measure| measures.get(measure).unwrap();
    close(of(Measure::Bandwidth), 2.5939, 2e-4, "bandwidth");
    close(of(Measure::PhaseDelay), 0.09768, 4e-5, "phase delay");
    close(of(Measure::AveragePhaseRate), 720.0 * 0.09768, 0.03, "average phase rate");
    // Slope at the point itself; ours spans 5 % to either side.
    close(of(Measure::PhaseRate), 110.543, 0.3, "phase rate");
    // Without delay the phase stays above -180 deg; what limits the bandwidth is the phase margin.
    let mut quick = Measures::default();
    quick.add_pitch_rate(&rate(TU_144), Some(0.0), None);
    let undelayed = rate([TU_144[0], TU_144[1], TU_144[2], TU_144[3], 0.0]);
    let omega = quick.get(Measure::Bandwidth).unwrap();
    let phase = undelayed.phase_rad(omega) - std::f64::consts::FRAC_PI_2;
    close(phase.to_degrees(), -135.0, 0.01, "phase at the bandwidth");
    assert_eq!(quick.get(Measure::PhaseDelay), Some(0.0));
    // An unknown delay leaves open what depends on it.
    let mut open = Measures::default();
    open.add_pitch_rate(&rate(TU_144), None, Some(&task(2.5)));
    assert!(open.get(Measure::Dropback).is_some() && open.get(Measure::Bandwidth).is_none());
    assert!(open.get(Measure::ClosedLoopResonance).is_none());
}

#[test]
fn pilot_of_neal_and_smith_matches_two_equations_solved_for_lead_and_gain() {
    // System, bandwidth; compensation deg, gain, resonance dB by scipy's fsolve.
    for (system, bandwidth, compensation, gain, resonance) in [
        (TU_144, 1.5, 4.81753, 1.421_114, -2.884_38),
        (TU_144, 2.5, 42.46485, 1.792_343, 0.734_588),
        (TU_144, 3.5, 67.363_90, 1.959_291, 10.000_59),
        ([5.0, 0.8, 0.9, 3.0, 0.05], 1.5, -18.851_94, 1.188_708, -1.943_01),
        ([5.0, 0.8, 0.9, 3.0, 0.05], 3.5, 45.860_51, 1.903_098, 2.167_215),
        ([5.0, 1.25, 1.4, 2.0, 0.05], 2.5, 50.532_61, 0.931_609, -3.0),
        ([5.0, 1.25, 0.69, 4.9, 0.05], 1.5, -30.418_91, 2.471_558, -3.0),
        ([5.0, 1.25, 0.69, 4.9, 0.05], 3.5, 13.087_02, 3.732_016, 5.308_745),
    ] {
        let curve = BodeCurve::of_model(&rate(system), &logarithmic_grid(0.02, 100.0, 1500)).integrated();
        let found = neal_smith(&curve, &task(bandwidth)).unwrap();
        close(found.compensation_rad.to_degrees(), compensation, 0.03, "compensation");
        close(found.gain / gain, 1.0, 1e-3, "gain");
        close(found.resonance_db, resonance, 5e-3, "resonance");
    }
    // A bandwidth no lead below 90 deg reaches, and one beyond the curve.
    let curve = BodeCurve::of_model(&rate(TU_144), &logarithmic_grid(0.02, 100.0, 500)).integrated();
    assert_eq!(neal_smith(&curve, &task(8.0)), None);
    assert_eq!(neal_smith(&curve, &task(150.0)), None);
}

/// Models `w q` and `beta p r phi` of a condition of CR-2144.
fn boeing(condition: &Value) -> (StateSpace, StateSpace) {
    let trim = level_trim(condition);
    let pitch = longitudinal(condition).state_space(&trim).unwrap();
    (pitch.part("short_period", &["w", "q"], &["delta_e"], &["w", "q"]), lateral(condition).state_space(&trim))
}

#[test]
fn boeing_747_has_the_worked_pitch_response_and_times_to_bank() {
    let Some(models) = models() else { return };
    let conditions = models["cr2144"]["condition"].as_array().unwrap();
    // FC1, FC2 and FC9 with 0.1 s from stick to elevator: frequency, damping, zero, bandwidth, phase delay, dropback, overshoot,
    // compensation and resonance at 1.5 rad/s, times to 25, 30 and 45 deg with 20 deg of aileron.
    for (index, pitch, pilot, times) in [
        (
            0,
            [0.760_231, 0.618_717, 0.500_756, 0.842_52, 0.077_244, 0.369_276, 1.332_997],
            [67.3797, -3.0],
            [11.732_76, 16.225, 29.914_3],
        ),
        (
            1,
            [0.902_593, 0.630_557, 0.603_123, 0.984_71, 0.077_418, 0.260_823, 1.312_038],
            [61.0371, -3.0],
            [8.188_778, 9.800_9, 16.728_08],
        ),
        (
            8,
            [0.957_72, 0.390_075, 0.303_025, 1.134_24, 0.078_808, 2.485_475, 2.552_367],
            [39.4540, 3.5581],
            [7.498_209, 8.615_16, 12.306_94],
        ),
    ] {
        let (short, lateral) = boeing(&conditions[index]);
        let model = pitch_rate_by_elevator(&short, 0.0).unwrap();
        let ([Section::First(zero)], [Section::Second { c1, c0 }]) = (&model.numerator[..], &model.denominator[..])
        else {
            unreachable!("a zero over two poles");
        };
        let mut measures = Measures::default();
        measures.add_pitch_rate(&model, Some(0.1), Some(&task(1.5)));
        let of = |measure: Measure| measures.get(measure).unwrap();
        let found = [
            c0.sqrt(),
            0.5 * c1 / c0.sqrt(),
            *zero,
            of(Measure::Bandwidth),
            of(Measure::PhaseDelay),
            of(Measure::Dropback),
            of(Measure::PitchRateOvershoot),
        ];
        for (found, expected) in found.into_iter().zip(pitch) {
            close(found / expected, 1.0, 2e-4, &format!("condition {index}"));
        }
        close(of(Measure::PilotCompensation), pilot[0], 0.1, "compensation");
        close(of(Measure::ClosedLoopResonance), pilot[1], 0.02, "resonance");
        let banks = [25.0_f64, 30.0, 45.0, 170.0].map(f64::to_radians);
        // The step to the other side takes as long.
        for aileron in [20.0_f64, -20.0] {
            let found = times_to_bank(&lateral, aileron.to_radians(), &banks).unwrap();
            for (found, expected) in found.iter().zip(times) {
                close(*found, expected, 2e-3, "time to bank");
            }
            assert_eq!(found[3], f64::INFINITY);
        }
    }
}

#[test]
fn fighter_banks_in_the_time_of_an_independent_integration() {
    let Some(models) = models() else { return };
    let matrix =
        |value: &Value| -> Vec<f64> { value.as_array().unwrap().iter().map(|v| v.as_float().unwrap()).collect() };
    let rows: Vec<f64> = models["f4c"]["A_computed"].as_array().unwrap().iter().flat_map(matrix).collect();
    let aileron = matrix(&models["f4c"]["B_computed"]["aileron"]);
    let (a, b) = (DMatrix::from_row_slice(5, 5, &rows), DMatrix::from_column_slice(5, 1, &aileron));
    let model = StateSpace::of_states("lateral", &["v", "p", "r", "phi", "psi"], &[("delta_a", "rad")], a, b);
    let mut measures = Measures::default();
    measures.add_times_to_bank(&model, 10f64.to_radians(), 0.0);
    for (measure, expected) in [
        (Measure::TimeToBank25, 1.349_117),
        (Measure::TimeToBank30, 1.556_338),
        (Measure::TimeToBank45, 2.238_672),
        (Measure::TimeToBank60, 2.873_186),
        (Measure::TimeToBank90, 3.773_250),
    ] {
        close(measures.get(measure).unwrap(), expected, 2e-4, measure.text());
    }
    // Class IV in category B has 1.7, 2.5 and 3.4 s to 90 deg.
    let judgement = judge(&limits("mil_f_8785c"), &Airplane::new("IV", "B").unwrap(), &measures);
    let roll = judgement.quality("roll performance").unwrap();
    assert_eq!(roll.level, Some(QualityLevel::WorseThanThree));
    assert_eq!(roll.reasons[0].to_string(), "time to 90 deg of bank > 3.4");
    assert_eq!(roll.standard, "MIL-F-8785C (1980-11-05)");
}

fn with(values: &[(Measure, f64)]) -> Measures {
    let mut measures = Measures::default();
    values.iter().for_each(|(measure, value)| measures.set(*measure, *value));
    measures
}

#[test]
fn boundaries_over_two_measures_are_straight_between_points_and_end_at_the_last() {
    let (standard, guidance) = (limits("mil_std_1797a"), limits("gibson"));
    let airplane = Airplane::new("I", "A").unwrap();
    let bandwidth = |bandwidth: f64, delay: f64| {
        let measures = with(&[(Measure::Bandwidth, bandwidth), (Measure::PhaseDelay, delay)]);
        judge(&standard, &airplane, &measures).quality("bandwidth and phase delay").unwrap().clone()
    };
    for (omega, delay, level) in [
        (6.5, 0.0, QualityLevel::One),
        (6.49, 0.0, QualityLevel::Two),
        // Halfway between (0.045, 7.08) and (0.05, 7.6).
        (7.34, 0.0475, QualityLevel::One),
        (7.33, 0.0475, QualityLevel::Two),
        (20.0, 0.061, QualityLevel::Two),
        (0.99, 0.05, QualityLevel::Three),
        (20.0, 0.151, QualityLevel::Three),
    ] {
        assert_eq!(bandwidth(omega, delay).level, Some(level), "{omega} rad/s, {delay} s");
    }
    // It does not count, as nobody has confirmed the points.
    assert!(!bandwidth(3.0, 0.05).counts);
    assert_eq!(bandwidth(6.4, 0.0).reasons[0].bound, 6.5);
    // The bandwidth alone says nothing where the boundary needs the delay.
    let alone = judge(&standard, &airplane, &with(&[(Measure::Bandwidth, 9.0)]));
    let alone = alone.quality("bandwidth and phase delay").unwrap();
    assert_eq!(alone.level, None);
    assert!(alone.needed.as_deref().unwrap().contains("delay from stick"));
    // Category B has no boundary: listed with the value and what is needed.
    let measures = with(&[(Measure::Bandwidth, 3.0), (Measure::PhaseDelay, 0.1)]);
    let open = judge(&standard, &Airplane::new("I", "B").unwrap(), &measures);
    let open = open.quality("bandwidth and phase delay").unwrap();
    assert_eq!((open.level, open.values.len()), (None, 2));
    let drop = |dropback: f64, overshoot: f64| {
        let measures = with(&[(Measure::Dropback, dropback), (Measure::PitchRateOvershoot, overshoot)]);
        let judgement = judge(&guidance, &airplane, &measures);
        assert_eq!(judgement.level, None, "guidance does not count");
        judgement.quality("dropback and overshoot").unwrap().level
    };
    for (dropback, overshoot, level) in [
        (0.0, 1.2, QualityLevel::One),
        (-0.01, 1.2, QualityLevel::Two),
        (0.175, 2.0, QualityLevel::One),
        (0.176, 2.0, QualityLevel::Two),
        (0.01, 3.1, QualityLevel::Two),
    ] {
        assert_eq!(drop(dropback, overshoot), Some(level), "{dropback} s, {overshoot}");
    }
    // The figure of Neal and Smith goes from -30 to 90 deg: outside it nothing is judged, and the reason is stated.
    let loop_closed = |compensation: f64, resonance: f64| {
        let measures = with(&[(Measure::PilotCompensation, compensation), (Measure::ClosedLoopResonance, resonance)]);
        judge(&standard, &airplane, &measures).quality("pilot in the loop (Neal-Smith)").unwrap().clone()
    };
    assert_eq!(loop_closed(-30.0, -5.0).level, Some(QualityLevel::One));
    assert_eq!(loop_closed(-30.0, -4.9).level, Some(QualityLevel::Two));
    for compensation in [-36.0, 90.1] {
        let outside = loop_closed(compensation, -10.0);
        assert_eq!((outside.level, outside.values.len()), (None, 2), "{compensation} deg");
        let needed = outside.needed.unwrap();
        assert!(needed.contains("-30 to 90 deg") && needed.contains(&format!("{compensation:.1}")), "{needed}");
    }
    let tasks = ["A", "B", "C"].map(|category| standard.pilot_task(&Airplane::new("I", category).unwrap()).unwrap());
    assert_eq!(tasks.map(|task| task.bandwidth_rad_s), [3.5, 1.5, 2.5]);
    let points = "[[0.02, 6.5], [0.03, 6.54]";
    let text = std::fs::read_to_string(format!(
        "{}/../../assets/flying_qualities/mil_std_1797a.toml",
        env!("CARGO_MANIFEST_DIR")
    ));
    let message = Limits::parse(&text.unwrap().replace(points, "[[0.04, 6.5], [0.03, 6.54]")).unwrap_err().to_string();
    assert!(message.contains("do not rise"), "{message}");
}

#[test]
fn phase_at_the_criterion_frequency_is_that_of_hand_calculation() {
    // Attitude exp(-0.1 s) / (s (s + 2)): 20 log10 sqrt(5) = 6.990 dB and 20 log10 (6 sqrt(40)) = 31.584 dB down at 1 and 6 rad/s, -9.515 dB
    // per octave, criterion frequency 3.7165 rad/s; phase -90 - atan(3.7165 / 2) - 0.1 * 3.7165 rad = -173.01 deg.
    let model = TransferFunction {
        gain: 1.0,
        numerator: Vec::new(),
        denominator: vec![Section::First(0.0), Section::First(2.0)],
        delay_s: 0.1,
    };
    let attitude = BodeCurve::of_model(&model, &logarithmic_grid(0.1, 50.0, 800));
    close(criterion_phase_rad(&attitude).unwrap().to_degrees(), -173.01, 0.02, "phase");
    let low = BodeCurve::of_model(&model, &logarithmic_grid(0.1, 5.0, 100));
    assert_eq!(criterion_phase_rad(&low), None);
    let mut measures = Measures::default();
    measures.set(Measure::CriterionPhase, -173.01);
    let judged = judge(&limits("smith_geddes"), &Airplane::new("I", "B").unwrap(), &measures);
    let quality = judged.quality("pilot-induced oscillation, Smith-Geddes").unwrap();
    assert_eq!((quality.level, quality.counts), (Some(QualityLevel::Two), false));
    measures.set(Measure::PhaseDelay, 0.15);
    let judged = judge(&limits("pio_phase_delay"), &Airplane::new("I", "B").unwrap(), &measures);
    assert_eq!(judged.qualities[0].level, Some(QualityLevel::Two));
}

#[test]
fn files_joined_keep_their_edition_and_intervals_need_most_samples() {
    let joined = limits("mil_f_8785c").with(limits("mil_std_1797a")).with(limits("gibson"));
    let judgement = judge(&joined, &Airplane::new("I", "A").unwrap(), &Measures::default());
    let standard = |criterion: &str| judgement.quality(criterion).unwrap().standard.clone();
    assert_eq!(standard("spiral"), "MIL-F-8785C (1980-11-05)");
    assert_eq!(standard("bandwidth and phase delay"), "MIL-STD-1797A (1990-01-30)");
    assert_eq!(standard("dropback and overshoot"), "Gibson, pitch (1982-06-01)");
    // Nothing was measured: every criterion says what it needs.
    assert!(judgement.qualities.iter().all(|quality| quality.level.is_none() && quality.needed.is_some()));
    let samples: Vec<Measures> = (0..100).map(|k| with(&[(Measure::Bandwidth, f64::from(k))])).collect();
    let found = measure_interval(&samples, Measure::Bandwidth).unwrap();
    assert!(found.low < 4.0 && found.high > 95.0 && (found.standard_error - 29.01).abs() < 0.01);
    assert_eq!(measure_interval(&samples, Measure::Cap), None);
}
