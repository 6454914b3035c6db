//! Tolerance files: which test applies to which window, and how far a simulation may be off.

mod file;

use std::collections::BTreeMap;

use doublet_core::quantity::Dimension;
use doublet_core::validate::{Signal, ToleranceTest};
use serde::{Deserialize, Serialize};

use crate::builtin;
use crate::graph::StageResult;
use crate::session::{Manoeuvre, Surface};

/// The tolerances that come with the program.
const BUILTIN: &str = "part60_2014";

/// A tolerance file: one edition of one rule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tolerances {
    /// Name of the rule.
    pub name: String,
    /// Date of the edition, `YYYY-MM-DD`; empty where the file has none.
    pub edition: String,
    /// Where the rule is printed; empty where the file does not say.
    pub source: String,
    /// How sure the numbers of the file are, in words; empty where the file does not say.
    pub certainty_note: String,
    /// Its tests, in the order of the file.
    pub tests: Vec<ObjectiveTest>,
    /// Tests of the rule that do not apply to a model of the motion in the air.
    pub outside: Vec<OutsideTest>,
}

/// A test of a rule that does not apply to a model of the motion in the air.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutsideTest {
    /// Number in the rule, or the first and last of several.
    pub id: String,
    pub name: String,
    /// Why not.
    pub reason: String,
}

/// How sure the tolerance of a test is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Certainty {
    /// Read in the text of the rule.
    #[default]
    Read,
    /// Taken from a text other than the rule.
    SecondHand,
    /// Not compared with any text.
    Unverified,
}

impl Certainty {
    doublet_core::named_variants! {
        /// Name in files.
        pub name: Read "read", SecondHand "second-hand", Unverified "unverified"
    }

    doublet_core::variant_texts! {
        /// What a page says of it.
        pub words:
            Read "read in the rule", SecondHand "from another text: compare it with the rule",
            Unverified "not compared with the rule: compare it before use",
    }
}

/// What the percentage of a band is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PercentRule {
    /// Of the largest value within the normal operating range, measured from zero (14 CFR Part 60, Appendix A, Attachment 2, paragraph
    /// 2): that of [`Reading::normal_range`], else the largest of the flight in the record.
    #[default]
    NormalRange,
    /// Of the flight's value at each sample, which is stricter.
    Sample,
}

impl PercentRule {
    doublet_core::named_variants! {
        /// Name on the command line and in files.
        pub name: NormalRange "range", Sample "sample"
    }

    doublet_core::variant_texts! {
        /// What it takes the percentage of, in words.
        pub reference_description:
            NormalRange "of the largest value in the normal operating range (default: in the record)",
            Sample "of the flight's value at each sample",
    }
}

/// How the percentages of a file are taken.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    pub percent: PercentRule,
    /// Largest values within the normal operating range, SI.
    pub normal_range: BTreeMap<Signal, f64>,
}

/// A test of a rule, and the windows it is for.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectiveTest {
    /// Number in the rule, for example `2.c.10`.
    pub id: String,
    pub name: String,
    /// Flight condition the rule asks for.
    pub condition: String,
    /// What the test shows.
    pub objective: String,
    /// How it is flown.
    pub procedure: String,
    /// Paragraph as the rule prints it.
    pub paragraph: String,
    /// Page of the source.
    pub page: String,
    /// How sure its tolerance is.
    pub certainty: Certainty,
    /// What of the entry was not at hand when the file was written; empty where it was read in full.
    pub missing: String,
    /// Record the rule asks for.
    pub record: RecordDemand,
    /// Signal whose free response tells period and damping.
    pub read: Option<Signal>,
    /// How it is judged.
    pub judgement: Judgement,
    /// Surface whose manoeuvres it is for.
    pub surface: Option<Surface>,
    /// Words of the kinds of input it is for.
    pub kinds: Vec<String>,
}

/// What a record must hold; zero where the rule says nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RecordDemand {
    /// Steady flight before the input, s.
    pub before_s: f64,
    /// Flight after the input, s.
    pub after_s: f64,
    /// Whole record, s.
    pub least_s: f64,
    /// Cycles of the free response.
    pub cycles: f64,
}

/// How a test is judged.
#[derive(Clone, Debug, PartialEq)]
pub enum Judgement {
    /// Bands about the flight over the whole record.
    History(ToleranceTest),
    /// The model's own trim against the recorded one.
    Snapshot(Vec<Vec<ValueTolerance>>),
    /// How much the model's own trim differs from that at another speed or load, against the recorded ones.
    TrimChange(Vec<Vec<ValueTolerance>>),
    /// Values some time after the controls came to rest.
    Value {
        /// The time, s.
        at_s: f64,
        /// Whether the direction of the change must be the flight's.
        trend: bool,
        requirements: Vec<Vec<ValueTolerance>>,
        /// The same tolerances as bands over the whole record.
        bands: ToleranceTest,
    },
    /// Period and damping of the free response.
    FreeResponse {
        /// Signals between whose peaks a lag is read.
        lag: Option<[Signal; 2]>,
        requirements: Vec<Vec<ValueTolerance>>,
    },
}

impl Judgement {
    /// Name in files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::History(_) => "time history",
            Self::Snapshot(_) => "snapshot",
            Self::TrimChange(_) => "trim change",
            Self::Value { .. } => "value",
            Self::FreeResponse { .. } => "period and damping",
        }
    }
}

/// How far one number of the model may be from that of the flight: the larger of the two parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueTolerance {
    pub quantity: Quantity,
    /// Fixed part, SI.
    pub absolute: f64,
    /// Part of the flight's value, a fraction.
    pub of_value: f64,
}

impl ValueTolerance {
    /// Half width of the band about the flight's value, SI.
    pub fn half_width(&self, flight: f64) -> f64 {
        self.absolute.max(self.of_value * flight.abs())
    }

    /// Whether `model` is inside; what is not a number is not.
    pub fn holds(&self, flight: f64, model: f64) -> bool {
        (model - flight).abs() <= self.half_width(flight)
    }
}

/// A quantity compared as one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Of the motion.
    Signal(Signal),
    /// Deflection of a surface.
    Surface(Surface),
    /// Deflection of the trim surface.
    TrimSurface,
    /// Period of the free response.
    Period,
    DampingRatio,
    /// Its time to half or, undamped, to double amplitude.
    HalfOrDouble,
    /// Time from the peaks of one signal to those of the other.
    PeakLag,
    /// Sum of the thrusts.
    NetThrust,
    ClimbRate,
}

impl Quantity {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Signal(signal) => signal.name(),
            Self::Surface(surface) => surface.name(),
            Self::TrimSurface => "trim surface",
            Self::Period => "period",
            Self::DampingRatio => "damping ratio",
            Self::HalfOrDouble => "time to half or double",
            Self::PeakLag => "peak lag",
            Self::NetThrust => "net thrust",
            Self::ClimbRate => "rate of climb",
        }
    }

    /// Dimension, hence SI unit.
    pub fn dimension(self) -> Dimension {
        match self {
            Self::Signal(signal) => signal.dimension(),
            Self::Surface(_) | Self::TrimSurface => Dimension::Angle,
            Self::Period | Self::HalfOrDouble | Self::PeakLag => Dimension::Time,
            Self::DampingRatio => Dimension::Dimensionless,
            Self::NetThrust => Dimension::Force,
            Self::ClimbRate => Dimension::Speed,
        }
    }

    pub fn all() -> impl Iterator<Item = Self> {
        let surfaces = Surface::ALL.into_iter().map(Self::Surface);
        let others = [
            Self::TrimSurface,
            Self::Period,
            Self::DampingRatio,
            Self::HalfOrDouble,
            Self::PeakLag,
            Self::NetThrust,
            Self::ClimbRate,
        ];
        Signal::ALL.into_iter().map(Self::Signal).chain(surfaces).chain(others)
    }

    /// The one called `name`.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|quantity| quantity.name() == name)
    }
}

impl Tolerances {
    /// Those that come with the program.
    ///
    /// # Errors
    /// One line; never for a program as built.
    pub fn builtin() -> StageResult<Self> {
        Self::builtin_by(&Reading::default())
    }

    /// Those that come with the program, percentages taken as asked.
    pub fn builtin_by(reading: &Reading) -> StageResult<Self> {
        let text = builtin::text("tolerances", BUILTIN).ok_or_else(|| format!("tolerances '{BUILTIN}' not found"))?;
        Self::parse_by(text, reading)
    }

    /// Reads the text of a file.
    pub fn parse(text: &str) -> StageResult<Self> {
        Self::parse_by(text, &Reading::default())
    }

    /// Reads the text of a file, percentages taken as asked.
    pub fn parse_by(text: &str, reading: &Reading) -> StageResult<Self> {
        file::parse(text, reading)
    }

    /// Bands that apply to a window.
    pub fn tests(&self, window: &Manoeuvre) -> Vec<&ToleranceTest> {
        self.tests.iter().filter(|test| test.applies_to(window)).filter_map(ObjectiveTest::bands).collect()
    }

    /// The test called `id`.
    pub fn test(&self, id: &str) -> Option<&ObjectiveTest> {
        self.tests.iter().find(|test| test.id == id)
    }

    /// The same tests with tolerances so many times as wide.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.tests.iter_mut().for_each(|test| test.scale(factor));
        self
    }
}

impl ObjectiveTest {
    /// Whether the test is for the window: by the surface that moved, or a word of its kind of input.
    pub(crate) fn applies_to(&self, window: &Manoeuvre) -> bool {
        let kind = window.kind.to_lowercase();
        (self.surface.is_some() && self.surface == window.surface)
            || self.kinds.iter().any(|word| kind.contains(word.as_str()))
    }

    /// Bands over the whole record, where it has any.
    pub fn bands(&self) -> Option<&ToleranceTest> {
        match &self.judgement {
            Judgement::History(bands) | Judgement::Value { bands, .. } => Some(bands),
            Judgement::Snapshot(_) | Judgement::TrimChange(_) | Judgement::FreeResponse { .. } => None,
        }
    }

    fn scale(&mut self, factor: f64) {
        match &mut self.judgement {
            Judgement::History(test) => Self::scale_bands(test, factor),
            Judgement::Snapshot(requirements)
            | Judgement::TrimChange(requirements)
            | Judgement::FreeResponse { requirements, .. } => Self::scale_values(requirements, factor),
            Judgement::Value { requirements, bands: test, .. } => {
                Self::scale_values(requirements, factor);
                Self::scale_bands(test, factor);
            }
        }
    }

    fn scale_values(requirements: &mut [Vec<ValueTolerance>], factor: f64) {
        requirements.iter_mut().flatten().for_each(|value| {
            value.absolute *= factor;
            value.of_value *= factor;
        });
    }

    fn scale_bands(test: &mut ToleranceTest, factor: f64) {
        test.requirements.iter_mut().flatten().for_each(|band| {
            band.absolute *= factor;
            band.of_value *= factor;
            band.of_peak *= factor;
        });
    }
}

#[cfg(test)]
mod tests;
