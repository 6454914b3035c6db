//! What flying-quality limits are about, measured on a linear model.

use doublet_core::motion::Mode;
use serde::Deserialize;

use super::{PilotTask, pitch_rate_by_elevator};
use crate::linear::{Linearised, Part, StateSpace};
use crate::modes::{modes, phasors};

/// Declares [`Measure`] with its key in files, its description and its unit.
macro_rules! measures {
    ($($variant:ident, $key:literal, $text:literal, $unit:literal;)*) => {
        /// A measure of the motion.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
        pub enum Measure { $(#[doc = $text] #[serde(rename = $key)] $variant,)* }

        impl Measure {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Key in limits files and results.
            pub fn key(self) -> &'static str { match self { $(Self::$variant => $key,)* } }

            /// What it is.
            pub fn text(self) -> &'static str { match self { $(Self::$variant => $text,)* } }

            /// Unit.
            pub fn unit(self) -> &'static str { match self { $(Self::$variant => $unit,)* } }
        }
    };
}

measures! {
    ShortPeriodDamping, "short_period_damping", "short-period damping", "-";
    ShortPeriodFrequency, "short_period_frequency", "short-period frequency", "rad/s";
    LoadFactorPerAlpha, "load_factor_per_alpha", "n/alpha", "g/rad";
    Cap, "cap", "CAP", "rad/s^2/g";
    PhugoidDamping, "phugoid_damping", "phugoid damping", "-";
    PhugoidTimeToDouble, "phugoid_time_to_double", "time to double of the phugoid", "s";
    SpeedTimeToDouble, "speed_time_to_double", "time to double of an aperiodic divergence of speed", "s";
    DutchRollDamping, "dutch_roll_damping", "Dutch-roll damping", "-";
    DutchRollDampingFrequency, "dutch_roll_damping_frequency", "Dutch-roll zeta omega", "rad/s";
    DutchRollFrequency, "dutch_roll_frequency", "Dutch-roll frequency", "rad/s";
    DutchRollCoupling, "dutch_roll_coupling", "Dutch-roll omega^2 |phi/beta|", "(rad/s)^2";
    RollTimeConstant, "roll_time_constant", "roll time constant", "s";
    SpiralTimeToDouble, "spiral_time_to_double", "time to double of the spiral", "s";
    RollSpiralDampingFrequency, "roll_spiral_damping_frequency", "zeta omega of a coupled roll-spiral", "rad/s";
    LoesDamping, "loes_damping", "zeta", "-";
    EquivalentDelay, "equivalent_delay", "tau", "s";
    LoesOmegaTTheta2, "loes_omega_t_theta2", "wT", "-";
    Bandwidth, "bandwidth", "pitch attitude bandwidth", "rad/s";
    PhaseDelay, "phase_delay", "phase delay", "s";
    PhaseRate, "phase_rate_deg_hz", "phase rate at -180 deg", "deg/Hz";
    AveragePhaseRate, "average_phase_rate_deg_hz", "average phase rate", "deg/Hz";
    CriterionPhase, "criterion_phase_deg", "pitch attitude phase at the criterion frequency", "deg";
    Dropback, "dropback", "dropback over pitch rate", "s";
    PitchRateOvershoot, "pitch_rate_overshoot", "pitch-rate overshoot ratio", "-";
    PilotCompensation, "pilot_compensation_deg", "pilot compensation", "deg";
    ClosedLoopResonance, "closed_loop_resonance_db", "closed-loop resonance", "dB";
    TimeToBank25, "time_to_bank_25", "time to 25 deg of bank", "s";
    TimeToBank30, "time_to_bank_30", "time to 30 deg of bank", "s";
    TimeToBank45, "time_to_bank_45", "time to 45 deg of bank", "s";
    TimeToBank60, "time_to_bank_60", "time to 60 deg of bank", "s";
    TimeToBank90, "time_to_bank_90", "time to 90 deg of bank", "s";
}

impl Measure {
    /// Whether it follows from the change of thrust with airspeed: phugoid and stability of speed.
    pub fn is_of_speed(self) -> bool {
        matches!(self, Self::PhugoidDamping | Self::PhugoidTimeToDouble | Self::SpeedTimeToDouble)
    }

    /// What is needed to judge it where it was not measured.
    pub fn needs(self) -> &'static str {
        match self {
            Self::ShortPeriodDamping | Self::ShortPeriodFrequency => "a model with a short period",
            Self::LoadFactorPerAlpha | Self::Cap => "a model with a short period and an elevator",
            Self::PhugoidDamping | Self::PhugoidTimeToDouble | Self::SpeedTimeToDouble => {
                "the change of thrust with airspeed: recorded thrust or described engines"
            }
            Self::DutchRollDamping
            | Self::DutchRollDampingFrequency
            | Self::DutchRollFrequency
            | Self::DutchRollCoupling => "a model of the lateral motion with a Dutch roll",
            Self::RollTimeConstant => "a model of the lateral motion with a roll mode",
            Self::SpiralTimeToDouble => "a model of the lateral motion with a spiral",
            Self::RollSpiralDampingFrequency => "a coupled roll-spiral (this aircraft has none)",
            Self::LoesDamping | Self::EquivalentDelay | Self::LoesOmegaTTheta2 => {
                "an equivalent system fitted to a recorded stick"
            }
            Self::Bandwidth
            | Self::PhaseDelay
            | Self::PhaseRate
            | Self::AveragePhaseRate
            | Self::CriterionPhase
            | Self::PilotCompensation
            | Self::ClosedLoopResonance => "the delay from stick to elevator, and a stable short period",
            Self::Dropback | Self::PitchRateOvershoot => "a stable short period with an elevator",
            Self::TimeToBank25 | Self::TimeToBank30 | Self::TimeToBank45 | Self::TimeToBank60 | Self::TimeToBank90 => {
                "the available aileron deflection, and a model of the lateral motion"
            }
        }
    }
}

/// Values of measures; what is not there was not measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures {
    values: Vec<(Measure, f64)>,
}

impl Measures {
    /// The value of a measure.
    pub fn get(&self, measure: Measure) -> Option<f64> {
        self.values.iter().find(|(known, _)| *known == measure).map(|(_, value)| *value)
    }

    /// Sets the value of a measure.
    pub fn set(&mut self, measure: Measure, value: f64) {
        self.values.retain(|(known, _)| *known != measure);
        self.values.push((measure, value));
    }

    /// Leaves out what follows from the change of thrust with airspeed.
    pub fn remove_speed(&mut self) {
        self.values.retain(|(measure, _)| !measure.is_of_speed());
    }

    /// All values.
    pub fn iter(&self) -> impl Iterator<Item = (Measure, f64)> + '_ {
        self.values.iter().copied()
    }

    /// Adds those of a low-order equivalent system of pitch rate by stick.
    pub fn add_equivalent_system(&mut self, system: &EquivalentSystem) {
        self.set(Measure::LoesDamping, system.damping);
        self.set(Measure::EquivalentDelay, system.delay_s);
        self.set(Measure::LoesOmegaTTheta2, system.frequency_rad_s / system.inverse_t_theta2_1_s);
    }

    /// Adds those of a Dutch roll: damping, frequency and the ratio `|phi/beta|`.
    pub fn add_dutch_roll(&mut self, damping: f64, frequency_rad_s: f64, phi_over_beta: Option<f64>) {
        self.set(Measure::DutchRollDamping, damping);
        self.set(Measure::DutchRollDampingFrequency, damping * frequency_rad_s);
        self.set(Measure::DutchRollFrequency, frequency_rad_s);
        if let Some(ratio) = phi_over_beta {
            self.set(Measure::DutchRollCoupling, frequency_rad_s * frequency_rad_s * ratio);
        }
    }

    /// Adds those of a short period: damping, frequency and, where known, n/alpha in g per rad.
    pub fn add_short_period(&mut self, damping: f64, frequency_rad_s: f64, load_factor_per_alpha: Option<f64>) {
        self.set(Measure::ShortPeriodDamping, damping);
        self.set(Measure::ShortPeriodFrequency, frequency_rad_s);
        if let Some(per_alpha) = load_factor_per_alpha {
            self.set(Measure::LoadFactorPerAlpha, per_alpha);
            self.set(Measure::Cap, frequency_rad_s * frequency_rad_s / per_alpha);
        }
    }
}

/// Low-order equivalent system `K (s + 1/T_theta2) exp(-tau s) / (s^2 + 2 zeta omega s + omega^2)` of pitch rate by stick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct EquivalentSystem {
    /// Damping ratio.
    pub damping: f64,
    pub frequency_rad_s: f64,
    pub inverse_t_theta2_1_s: f64,
    /// Equivalent delay, s.
    pub delay_s: f64,
}

/// What is known of the controls and the task of the pilot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Controls {
    /// Delay from stick to surface, s.
    pub stick_delay_s: Option<f64>,
    /// Aileron deflection available from the trim, rad.
    pub aileron_rad: Option<f64>,
    /// Task of the pilot in the loop of pitch attitude.
    pub task: Option<PilotTask>,
}

/// Measures of an aircraft about a trim.
pub fn measures(linearised: &Linearised, controls: &Controls) -> Measures {
    let trim = &linearised.trim;
    let motion = linearised.motion();
    let found = modes(&motion);
    let mut measures = Measures::default();
    let short = linearised.part(Part::ShortPeriod);
    let per_alpha = load_factor_per_alpha(&short, trim.condition.airspeed_m_s, trim.condition.gravity_m_s2);
    if let Some((damping, frequency)) = pair(&found, "short period") {
        measures.add_short_period(damping, frequency, per_alpha);
    }
    if let Some(rate) = pitch_rate_by_elevator(&short, 0.0) {
        measures.add_pitch_rate(&rate, controls.stick_delay_s, controls.task.as_ref());
    }
    let has_lateral = Part::Lateral.within(trim.motion);
    if let Some(aileron_rad) = controls.aileron_rad.filter(|_| has_lateral) {
        let delay_s = controls.stick_delay_s.unwrap_or(0.0);
        measures.add_times_to_bank(&linearised.part(Part::Lateral), aileron_rad, delay_s);
    }
    // An aperiodic phugoid of which one part diverges is the instability of speed.
    let double = |mode: &Mode| mode.time_to_double_s().unwrap_or(f64::INFINITY);
    let aperiodic = found.iter().filter(|mode| mode.name == "aperiodic phugoid").map(double);
    measures.set(Measure::SpeedTimeToDouble, aperiodic.fold(f64::INFINITY, f64::min));
    if let Some(phugoid) = found.iter().find(|mode| mode.name == "phugoid") {
        measures.set(Measure::PhugoidDamping, phugoid.damping());
        measures.set(Measure::PhugoidTimeToDouble, double(phugoid));
    } else if let Some((damping, _)) = pair(&found, "phugoid") {
        measures.set(Measure::PhugoidDamping, damping);
    }
    if let Some(dutch) = found.iter().find(|mode| mode.name == "Dutch roll") {
        let ratio = phi_over_beta(&motion, dutch, trim.condition.airspeed_m_s);
        measures.add_dutch_roll(dutch.damping(), dutch.frequency_rad_s(), ratio);
    } else if let Some((damping, frequency)) = pair(&found, "Dutch roll") {
        measures.add_dutch_roll(damping, frequency, None);
    }
    for mode in &found {
        match mode.name {
            "roll subsidence" => {
                let constant = if mode.is_stable() { mode.time_constant_s() } else { f64::INFINITY };
                measures.set(Measure::RollTimeConstant, constant);
            }
            "spiral" => measures.set(Measure::SpiralTimeToDouble, double(mode)),
            "coupled roll-spiral" => {
                measures.set(Measure::RollSpiralDampingFrequency, -mode.real_1_s);
            }
            _ => {}
        }
    }
    measures
}

/// Damping ratio and frequency of an oscillation, or of the two real eigenvalues it has fallen into: those of their second-order
/// system, and a damping of -1 where one diverges.
fn pair(modes: &[Mode], name: &str) -> Option<(f64, f64)> {
    if let Some(mode) = modes.iter().find(|mode| mode.name == name) {
        return Some((mode.damping(), mode.frequency_rad_s()));
    }
    let parts: Vec<&Mode> = modes.iter().filter(|mode| mode.name.strip_prefix("aperiodic ") == Some(name)).collect();
    let [first, second] = parts.as_slice() else { return None };
    let frequency = (first.real_1_s * second.real_1_s).abs().sqrt();
    let stable = first.is_stable() && second.is_stable();
    Some((if stable { -(first.real_1_s + second.real_1_s) / (2.0 * frequency) } else { -1.0 }, frequency))
}

/// Steady load factor per angle of attack of a step of elevator at constant speed, g per rad (MIL-F-8785C, paragraph 6.2): from
/// the model `w q` in its steady state, `n = V q / g` and `alpha = w / V`; none without elevator or with no steady state.
pub fn load_factor_per_alpha(short_period: &StateSpace, airspeed_m_s: f64, gravity_m_s2: f64) -> Option<f64> {
    let (w, q) = (short_period.state("w")?, short_period.state("q")?);
    let elevator = short_period.input("delta_e")?;
    let steady = short_period.a.clone().lu().solve(&short_period.b.column(elevator).into_owned())?;
    let value = airspeed_m_s * airspeed_m_s * steady[q] / (gravity_m_s2 * steady[w]);
    value.is_finite().then_some(value)
}

/// Ratio of bank to sideslip in a mode, both in rad.
pub fn phi_over_beta(motion: &StateSpace, mode: &Mode, airspeed_m_s: f64) -> Option<f64> {
    let bank = motion.state("phi")?;
    if let Some(beta) = motion.state("beta") {
        return Some(phasors(mode, beta)[bank].norm());
    }
    Some(phasors(mode, motion.state("v")?)[bank].norm() * airspeed_m_s)
}
