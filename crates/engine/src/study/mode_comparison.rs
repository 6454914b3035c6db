//! Natural modes by the equivalent systems of the responses, by the free responses and by the identified model, side by side.

use std::f64::consts::LN_2;

use doublet_core::statistics::{NORMAL_95, student_widening};
use doublet_dynamics::frequency::FittedParameter;
use doublet_dynamics::modes::{Figure, MeasuredMode, ModeEstimate};

use super::dynamics::MeasuredWindow;
use super::equivalent::EquivalentStudy;
use crate::notation::significant;
use crate::session::{Finding, Level, Surface};

/// What of a mode is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModeQuantity {
    /// Undamped natural frequency, rad/s.
    Frequency,
    /// Damping ratio.
    Damping,
    /// Time constant of an aperiodic mode, s.
    TimeConstant,
}

impl ModeQuantity {
    doublet_core::variant_texts! {
        /// Name in tables and results.
        pub name: Frequency "frequency", Damping "damping", TimeConstant "time constant"
    }

    doublet_core::variant_texts! {
        /// Its unit.
        pub unit: Frequency "rad/s", Damping "", TimeConstant "s"
    }

    doublet_core::variant_texts! {
        /// Name of the parameter of an equivalent system.
        parameter: Frequency "omega", Damping "zeta", TimeConstant "T_R"
    }

    /// The figure of a mode, and its part in this quantity: a time constant is the time to half over ln 2.
    fn figure(self) -> (Figure, f64) {
        match self {
            Self::Frequency => (Figure::Frequency, 1.0),
            Self::Damping => (Figure::Damping, 1.0),
            Self::TimeConstant => (Figure::Time, LN_2.recip()),
        }
    }

    /// Its value and standard error of a measured mode, real and imaginary part taken as independent; none of a mode of another kind.
    fn measured(self, mode: &MeasuredMode) -> Option<[f64; 2]> {
        let (real, imaginary) = (mode.real_1_s, mode.imaginary_rad_s);
        let natural = mode.frequency_rad_s();
        let oscillates = imaginary > 0.0;
        let (value, by_real, by_imaginary) = match self {
            Self::Frequency if oscillates => (natural, real / natural, imaginary / natural),
            Self::Damping if oscillates => {
                (mode.damping(), -imaginary * imaginary / natural.powi(3), real * imaginary / natural.powi(3))
            }
            Self::TimeConstant if !oscillates => (-real.recip(), real.powi(-2), 0.0),
            _ => return None,
        };
        let error = (by_real * mode.real_error).hypot(by_imaginary * mode.imaginary_error);
        (value.is_finite() && error.is_finite() && error > 0.0).then_some([value, error])
    }
}

/// An estimate with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

/// A quantity of a mode by the ways that give it, of the manoeuvres of one control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeComparison {
    /// Control of the manoeuvres.
    pub surface: Surface,
    pub mode: &'static str,
    pub quantity: ModeQuantity,
    /// By the equivalent system of the response; none where it is rejected or missing.
    pub response: Option<Bounded>,
    /// By the free responses behind the inputs.
    pub free: Option<Bounded>,
    /// By the identified model.
    pub model: Bounded,
    /// Whether the form of the equivalent system fits the response.
    pub is_fitting: bool,
}

impl ModeComparison {
    /// The ways that give a value, by their names.
    pub fn ways(&self) -> impl Iterator<Item = (&'static str, Bounded)> {
        let ways = [("response", self.response), ("free responses", self.free), ("model", Some(self.model))];
        ways.into_iter().filter_map(|(name, found)| Some((name, found?)))
    }

    /// Pairs of ways whose 95 % intervals do not overlap.
    pub fn contradictions(&self) -> Vec<[&'static str; 2]> {
        let ways: Vec<_> = self.ways().collect();
        let later = |(place, one): (usize, &(&'static str, Bounded))| {
            let (name, own) = *one;
            let apart = ways[place + 1..].iter().filter(move |(_, other)| own.is_apart(other));
            apart.map(|(other, _)| [name, *other]).collect::<Vec<_>>()
        };
        ways.iter().enumerate().flat_map(later).collect()
    }

    /// The contradictions in a sentence; none where all intervals overlap.
    pub fn finding(&self) -> Option<Finding> {
        let pairs = self.contradictions();
        let unit = match self.quantity.unit() {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let way = |(name, found): (&str, Bounded)| {
            format!("{name} {} to {}", significant(found.low, 3), significant(found.high, 3))
        };
        let ways: Vec<String> = self.ways().map(way).collect();
        let text = format!("Contradiction on {} {}: {}{unit}.", self.mode, self.quantity.name(), ways.join(", "));
        let place = format!("{} response", self.surface.name());
        let of_response = pairs.iter().any(|pair| pair.contains(&"response"));
        let fix = match (of_response, self.is_fitting) {
            (true, false) => "Fit a form of higher order to the response first.",
            (true, true) => "Check control delay, response band and free responses.",
            (false, _) => "Check the free response of each manoeuvre and its flight condition.",
        };
        (!pairs.is_empty()).then(|| Finding::new(Level::Caution, "twin", place, text).with_fix_text(fix))
    }
}

impl Bounded {
    /// Whether the intervals do not overlap.
    fn is_apart(&self, other: &Self) -> bool {
        self.high < other.low || other.high < self.low
    }
}

/// Quantities of modes that the manoeuvres of a control show.
fn list_quantities(surface: Surface) -> &'static [(&'static str, ModeQuantity)] {
    match surface {
        Surface::Elevator => &[("short period", ModeQuantity::Frequency), ("short period", ModeQuantity::Damping)],
        Surface::Aileron => &[
            ("roll subsidence", ModeQuantity::TimeConstant),
            ("Dutch roll", ModeQuantity::Frequency),
            ("Dutch roll", ModeQuantity::Damping),
        ],
        Surface::Rudder => &[("Dutch roll", ModeQuantity::Frequency), ("Dutch roll", ModeQuantity::Damping)],
    }
}

/// The modes of the identified model that the manoeuvres of a control show, beside those by the equivalent system of its response, unless
/// that is rejected, and by their free responses.
pub(super) fn compare_modes(
    surface: Surface,
    system: Option<&EquivalentStudy>,
    (free, modes): (&[MeasuredWindow], &[ModeEstimate]),
) -> Vec<ModeComparison> {
    let system = system.filter(|system| !system.is_rejected());
    let is_fitting = system.is_none_or(|system| system.verdict.reasons.iter().all(|reason| reason.code != "form"));
    let quantities = list_quantities(surface).iter();
    let rows = quantities.filter_map(|&(mode, quantity)| {
        let estimate = modes.iter().find(|estimate| estimate.mode.name == mode)?;
        let model = modelled(estimate, quantity)?;
        let response = system.and_then(|system| of_system(system, quantity));
        let found = free.iter().filter(|window| window.surface == surface);
        let found = found.flat_map(|window| window.modes.iter().flatten()).filter(|(name, _)| *name == Some(mode));
        let found: Vec<[f64; 2]> = found.filter_map(|(_, measured)| quantity.measured(measured)).collect();
        let row = ModeComparison { surface, mode, quantity, response, free: combine(&found), model, is_fitting };
        (row.response.is_some() || row.free.is_some()).then_some(row)
    });
    rows.collect()
}

/// Estimates with standard errors as one: their weighted mean with its 95 % interval. From three on, a scatter beyond the errors widens it,
/// by Student's distribution.
fn combine(found: &[[f64; 2]]) -> Option<Bounded> {
    const FEWEST: usize = 3;
    let weights: f64 = found.iter().map(|[_, error]| error.powi(-2)).sum();
    let value = found.iter().map(|[value, error]| value * error.powi(-2)).sum::<f64>() / weights;
    let mut half = NORMAL_95 / weights.sqrt();
    if found.len() >= FEWEST {
        let squares: f64 = found.iter().map(|[own, error]| ((own - value) / error).powi(2)).sum();
        let scatter = (squares / (found.len() - 1) as f64 / weights).sqrt();
        // The quantile of 95 % is twice the widening, which is of two standard deviations.
        half = half.max(2.0 * student_widening(found.len())? * scatter);
    }
    finite(Bounded { value, low: value - half, high: value + half })
}

fn of_system(system: &EquivalentStudy, quantity: ModeQuantity) -> Option<Bounded> {
    let named = |name: &str| system.fit.parameters.iter().chain(&system.derived).find(|own| own.name == name);
    let found = named(quantity.parameter())?;
    // The damping of an oscillation without a frequency says nothing.
    let oscillates = named("omega").is_none_or(FittedParameter::is_determined);
    if quantity == ModeQuantity::Damping && !oscillates {
        return None;
    }
    finite(Bounded { value: found.value, low: found.low, high: found.high })
}

fn modelled(estimate: &ModeEstimate, quantity: ModeQuantity) -> Option<Bounded> {
    let (figure, part) = quantity.figure();
    let found = estimate.figure(figure)?;
    let interval = found.sampled.or(found.delta)?;
    finite(Bounded { value: part * found.value, low: part * interval.low, high: part * interval.high })
}

fn finite(bounded: Bounded) -> Option<Bounded> {
    [bounded.value, bounded.low, bounded.high].iter().all(|number| number.is_finite()).then_some(bounded)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounded(low: f64, high: f64) -> Bounded {
        Bounded { value: 0.5 * (low + high), low, high }
    }

    #[test]
    fn intervals_that_do_not_overlap_contradict_each_other() {
        let compared = |response, free, model| ModeComparison {
            surface: Surface::Aileron,
            mode: "roll subsidence",
            quantity: ModeQuantity::TimeConstant,
            response,
            free,
            model,
            is_fitting: true,
        };
        let response = Some(bounded(0.2, 0.3));
        for (low, high, contradicts) in [(0.31, 0.4, true), (0.1, 0.19, true), (0.3, 0.4, false), (0.1, 0.5, false)] {
            let found = compared(response, None, bounded(low, high)).finding();
            let found = found.map(|found| (found.level, found.code));
            assert_eq!(found, contradicts.then_some((Level::Caution, "twin")), "{low} to {high}");
        }
        let all = compared(response, Some(bounded(0.4, 0.5)), bounded(0.25, 0.6));
        assert_eq!(all.contradictions(), [["response", "free responses"]]);
        let rejected = compared(None, Some(bounded(0.4, 0.5)), bounded(0.2, 0.3));
        assert_eq!(rejected.contradictions(), [["free responses", "model"]]);
    }

    #[test]
    fn measured_modes_give_frequency_and_damping_with_their_errors() {
        let mode = MeasuredMode {
            real_1_s: -0.6,
            imaginary_rad_s: 0.8,
            real_error: 0.03,
            imaginary_error: 0.04,
            amplitude: 1.0,
        };
        let [frequency, error] = ModeQuantity::Frequency.measured(&mode).unwrap();
        assert!((frequency - 1.0).abs() < 1e-12 && (error - 0.018_f64.hypot(0.032)).abs() < 1e-12);
        let [damping, error] = ModeQuantity::Damping.measured(&mode).unwrap();
        assert!((damping - 0.6).abs() < 1e-12 && (error - 0.0192_f64.hypot(0.0192)).abs() < 1e-12);
        assert!(ModeQuantity::TimeConstant.measured(&mode).is_none());
        let roll = MeasuredMode { real_1_s: -2.0, imaginary_rad_s: 0.0, real_error: 0.1, ..mode };
        assert_eq!(ModeQuantity::TimeConstant.measured(&roll), Some([0.5, 0.025]));
    }

    #[test]
    fn a_scatter_beyond_the_errors_widens_the_combined_interval() {
        let alone = combine(&[[2.0, 0.1]]).unwrap();
        assert!((alone.high - alone.value - 0.1 * NORMAL_95).abs() < 1e-12);
        let agreeing = combine(&[[2.0, 0.1], [2.01, 0.1], [1.99, 0.1]]).unwrap();
        assert!((agreeing.high - agreeing.value - 0.1 * NORMAL_95 / 3.0_f64.sqrt()).abs() < 1e-12);
        // Student's quantile with two degrees of freedom is 4.303; the scatter is 1, its mean's 1 / sqrt(3).
        let apart = combine(&[[1.0, 0.1], [2.0, 0.1], [3.0, 0.1]]).unwrap();
        assert!((apart.high - apart.value - 4.3027 / 3.0_f64.sqrt()).abs() < 1e-3, "{apart:?}");
        assert!(combine(&[]).is_none());
    }
}
