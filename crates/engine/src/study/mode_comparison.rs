//! Natural modes by the equivalent systems of the responses beside those of the identified model.

use std::f64::consts::LN_2;

use doublet_dynamics::modes::{Figure, ModeEstimate};

use super::equivalent::EquivalentStudy;
use crate::notation::significant;
use crate::session::{Finding, Level, Surface};

/// What of a mode both ways give.
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
}

/// An estimate with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

/// A quantity of a mode by the response and by the identified model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeComparison {
    /// Control of the response.
    pub surface: Surface,
    pub mode: &'static str,
    pub quantity: ModeQuantity,
    /// By the equivalent system.
    pub response: Bounded,
    /// By the identified model.
    pub model: Bounded,
    /// Whether the form of the equivalent system fits the response.
    pub is_fitting: bool,
}

impl ModeComparison {
    /// Whether the 95 % intervals do not overlap.
    pub fn is_contradiction(&self) -> bool {
        self.response.high < self.model.low || self.model.high < self.response.low
    }

    /// Value of the response over that of the model, less one, per cent.
    pub fn difference_percent(&self) -> f64 {
        100.0 * (self.response.value / self.model.value - 1.0)
    }

    /// The contradiction in a sentence; none where the intervals overlap.
    pub fn finding(&self) -> Option<Finding> {
        let Self { surface, mode, quantity, response, model, is_fitting } = self;
        let unit = match quantity.unit() {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let text = format!(
            "Contradiction on {mode} {}: response {} to {}, model {} to {}{unit}.",
            quantity.name(),
            significant(response.low, 4),
            significant(response.high, 4),
            significant(model.low, 4),
            significant(model.high, 4)
        );
        let found = Finding::new(Level::Caution, "twin", format!("{} response", surface.name()), text);
        let fix = if *is_fitting {
            "Check control delay, response band and free responses."
        } else {
            "Fit a form of higher order to the response first."
        };
        self.is_contradiction().then(|| found.with_fix_text(fix))
    }
}

/// Quantities of modes that the response to a control shows.
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

/// What the equivalent system of the response to a control and the modes of the identified model both give with an interval.
pub(super) fn compare_modes(surface: Surface, system: &EquivalentStudy, modes: &[ModeEstimate]) -> Vec<ModeComparison> {
    let is_fitting = system.verdict.reasons.iter().all(|reason| reason.code != "form");
    let quantities = list_quantities(surface).iter();
    let rows = quantities.filter_map(|&(mode, quantity)| {
        let estimate = modes.iter().find(|estimate| estimate.mode.name == mode)?;
        let (response, model) = (measured(system, quantity)?, modelled(estimate, quantity)?);
        Some(ModeComparison { surface, mode, quantity, response, model, is_fitting })
    });
    rows.collect()
}

fn measured(system: &EquivalentStudy, quantity: ModeQuantity) -> Option<Bounded> {
    let mut all = system.fit.parameters.iter().chain(&system.derived);
    let found = all.find(|parameter| parameter.name == quantity.parameter())?;
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

    #[test]
    fn intervals_that_do_not_overlap_contradict_each_other() {
        let compared = |low: f64, high: f64| ModeComparison {
            surface: Surface::Aileron,
            mode: "roll subsidence",
            quantity: ModeQuantity::TimeConstant,
            response: Bounded { value: 0.25, low: 0.2, high: 0.3 },
            model: Bounded { value: 0.5 * (low + high), low, high },
            is_fitting: true,
        };
        for (low, high, contradicts) in [(0.31, 0.4, true), (0.1, 0.19, true), (0.3, 0.4, false), (0.1, 0.5, false)] {
            let found = compared(low, high).finding().map(|found| (found.level, found.code));
            assert_eq!(found, contradicts.then_some((Level::Caution, "twin")), "{low} to {high}");
        }
    }
}
