//! Levels of flying qualities by a low-order equivalent system.

use doublet_dynamics::frequency::{EquivalentSystem, Form, Section, TransferFunction};
use doublet_dynamics::qualities::{
    self, Airplane, Limits, Measure, Measures, PilotTask, QualityLevel, judge, judge_samples,
};

use super::dynamics::{QualitiesRow, probabilities, quality_row};

/// Models drawn for the probabilities, and the seed of the draws.
const SAMPLES: usize = 2000;
const SEED: u64 = 1;

/// Levels of the criteria that an equivalent system tells about, each with its probability: the share of 2000 models drawn from the
/// covariance of the fit. None of them for a form of free orders, whose poles have no names.
pub fn equivalent_levels(fit: &EquivalentSystem, limits: &Limits, airplane: &Airplane) -> QualitiesRow {
    let task = limits.pilot_task(airplane);
    let measures_of = |model: &TransferFunction| measures(fit.form, model, task.as_ref());
    let mut judgement = judge(limits, airplane, &measures_of(&fit.model));
    judgement.qualities.retain(|quality| quality.level.is_some() || !quality.values.is_empty());
    let samples: Vec<Measures> = fit.samples(SAMPLES, SEED).iter().map(measures_of).collect();
    let shares = judge_samples(limits, airplane, &samples);
    QualitiesRow {
        standard: limits.name.clone(),
        date: limits.date.to_string(),
        class: airplane.class,
        category: airplane.category,
        airplane_from: format!("class {} and category {} as stated", airplane.class, airplane.category),
        level: judgement.level.map(QualityLevel::name),
        probabilities: probabilities(&shares, "all"),
        criteria: judgement.qualities.iter().map(|quality| quality_row(quality, &shares, &samples, None)).collect(),
        stick_delay_s: None,
        aileron_rad: None,
        note: limits.note.clone(),
        map: Vec::new(),
    }
}

/// What the form says: short period or Dutch roll with zeta and omega, roll mode with `T_R`, the delay of all; with the short period bandwidth,
/// phase delay, dropback and the loop closed by a pilot. A pair of poles that does not
/// oscillate has the damping ratio `c1 / (2 sqrt c0)` above one; without stable poles the damping is negative.
fn measures(form: Form, model: &TransferFunction, task: Option<&PilotTask>) -> Measures {
    let mut found = Measures::default();
    let pair = model.denominator.iter().find_map(|section| match section {
        Section::Second { c1, c0 } if *c0 > 0.0 => Some((0.5 * c1 / c0.sqrt(), c0.sqrt())),
        _ => None,
    });
    match (form, pair, model.denominator.as_slice(), model.numerator.as_slice()) {
        (Form::ShortPeriod, Some((damping, frequency_rad_s)), _, [Section::First(inverse_t_theta2_1_s)]) => {
            let delay_s = model.delay_s;
            let inverse_t_theta2_1_s = *inverse_t_theta2_1_s;
            let system = qualities::EquivalentSystem { damping, frequency_rad_s, inverse_t_theta2_1_s, delay_s };
            found.add_equivalent_system(&system);
            found.add_short_period(damping, frequency_rad_s, None);
            found.add_pitch_rate(model, Some(delay_s), task);
        }
        (Form::Yaw, Some((damping, frequency_rad_s)), ..) => found.add_dutch_roll(damping, frequency_rad_s, None),
        // A pole to the right has no time constant that any level allows.
        (Form::Roll, _, [Section::First(rate)], _) => {
            found.set(Measure::RollTimeConstant, if *rate > 0.0 { rate.recip() } else { f64::INFINITY });
        }
        _ => return found,
    }
    found.set(Measure::EquivalentDelay, model.delay_s);
    found
}
