//! Levels of flying qualities by a low-order equivalent system.

use doublet_dynamics::frequency::{EquivalentSystem, Form, Section, TransferFunction};
use doublet_dynamics::qualities::{
    self, Airplane, Judgement, LevelShares, Limits, Measure, Measures, PilotTask, judge, judge_samples,
};

use super::equivalent::EquivalentStudy;
use crate::session::Level;

/// Models drawn for the probabilities, and the seed of the draws.
const SAMPLES: usize = 2000;
const SEED: u64 = 1;

/// Levels of the criteria that an equivalent system has values for.
#[derive(Clone, Debug)]
pub struct EquivalentLevels {
    /// Name, date and note of the limits.
    pub standard: String,
    pub date: String,
    pub note: String,
    pub airplane: Airplane,
    /// Source of class and category.
    pub airplane_from: String,
    /// Levels of the values of the fit.
    pub judgement: Judgement,
    /// Probability of each level: the share of 2000 models drawn from the covariance of the fit.
    pub shares: Vec<LevelShares>,
    pub sampled: Vec<Measures>,
    /// Worst finding on the system where its verdict is bad: then its criteria have no level.
    pub withdrawn: Option<String>,
}

impl EquivalentLevels {
    /// Judges the criteria that an equivalent system of `output` has values for; none where the poles of its form have no names.
    pub fn judge(
        found: &EquivalentStudy,
        output: &str,
        limits: &Limits,
        (airplane, airplane_from): (&Airplane, &str),
    ) -> Self {
        let fit: &EquivalentSystem = &found.fit;
        let task = limits.pilot_task(airplane);
        let measures_of = |model: &TransferFunction| measures((fit.form, output), model, task.as_ref());
        let mut judgement = judge(limits, airplane, &measures_of(&fit.model));
        judgement.qualities.retain(|quality| quality.level.is_some() || !quality.values.is_empty());
        let sampled: Vec<Measures> = fit.samples(SAMPLES, SEED).iter().map(measures_of).collect();
        let worst = found.verdict.reasons.iter().find(|finding| finding.level == Level::Bad);
        let reason = worst.map_or_else(String::new, |finding| finding.text.to_string());
        Self {
            standard: limits.name.clone(),
            date: limits.date.to_string(),
            note: limits.note.clone(),
            shares: judge_samples(limits, airplane, &sampled),
            airplane: airplane.clone(),
            airplane_from: airplane_from.to_owned(),
            judgement,
            sampled,
            withdrawn: found.is_rejected().then_some(reason),
        }
    }
}

/// What the form says: short period or Dutch roll with zeta and omega, roll mode with `T_R`, the delay of all; with the short period bandwidth,
/// phase delay, dropback and the loop closed by a pilot. A pair of poles that does not
/// oscillate has the damping ratio `c1 / (2 sqrt c0)` above one; without stable poles the damping is negative.
fn measures((form, output): (Form, &str), model: &TransferFunction, task: Option<&PilotTask>) -> Measures {
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
        (Form::Roll, _, [Section::First(rate)], _) => found.set(Measure::RollTimeConstant, roll_time_constant_s(*rate)),
        (Form::Orders { .. }, _, poles, _) if LATERAL.contains(&output) => add_lateral(&mut found, output, poles),
        _ => return found,
    }
    // Without a named mode nothing is known of what the delay belongs to.
    if found.iter().next().is_some() {
        found.set(Measure::EquivalentDelay, model.delay_s);
    }
    found
}

/// Rates of the lateral motion.
const LATERAL: [&str; 2] = ["p", "r"];

/// The Dutch roll where one pair of poles oscillates, and of the roll rate the roll mode where one pole is real.
fn add_lateral(found: &mut Measures, output: &str, poles: &[Section]) {
    let (mut pairs, mut rates) = (Vec::new(), Vec::new());
    for section in poles {
        match *section {
            Section::Second { c1, c0 } if c1 * c1 < 4.0 * c0 => pairs.push((0.5 * c1 / c0.sqrt(), c0.sqrt())),
            // Two real poles: which of them is the roll mode is not known.
            Section::Second { .. } => return,
            Section::First(rate) => rates.push(rate),
        }
    }
    if let [(damping, frequency_rad_s)] = pairs[..] {
        found.add_dutch_roll(damping, frequency_rad_s, None);
    }
    if let ("p", [rate]) = (output, &rates[..]) {
        found.set(Measure::RollTimeConstant, roll_time_constant_s(*rate));
    }
}

/// A pole to the right has no time constant that any level allows.
fn roll_time_constant_s(rate_1_s: f64) -> f64 {
    if rate_1_s > 0.0 { rate_1_s.recip() } else { f64::INFINITY }
}
