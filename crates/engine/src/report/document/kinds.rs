//! The sections of a report: names, headings and the studies they need.

use crate::study::Study;

/// The sections there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SectionKind {
    /// What the flights were for, and the derivatives asked for.
    Purpose,
    /// What was analysed, with what, by which program.
    Overview,
    /// Reference geometry, loading, mass properties.
    Aircraft,
    /// Sensors, channels by role, and clocks.
    Channels,
    /// Manoeuvre windows.
    Windows,
    /// Settings of the filter and its consistency.
    Filter,
    /// Measured channels beside the reconstructed path, biases over time.
    Path,
    /// Wind and biases.
    WindAndBias,
    /// Innovations.
    Innovations,
    /// Structure of the model and correlation of its parameters.
    Model,
    /// Derivatives.
    Derivatives,
    /// Fits and residuals of every manoeuvre.
    Fits,
    /// Prediction of the validation windows.
    Validation,
    /// Validation windows flown again by the model.
    Match,
    /// The flight against an earlier estimate.
    Prior,
    /// Windows again by output error.
    Checks,
    /// Experiments of the session side by side.
    Experiments,
    /// Derivatives against what they were computed with.
    Sensitivity,
    /// Derivatives over the flight condition.
    Condition,
    /// Frequency responses and low-order equivalent systems.
    Responses,
    /// Linear model, modes and levels of flying qualities.
    Dynamics,
    /// Modelled engines against their monitors.
    Engines,
    /// Conclusions from the findings.
    Conclusions,
    /// Everything found on the way.
    Warnings,
}

impl SectionKind {
    /// All of them, in their order.
    pub const ALL: [Self; 24] = [
        Self::Purpose,
        Self::Overview,
        Self::Aircraft,
        Self::Channels,
        Self::Windows,
        Self::Filter,
        Self::Path,
        Self::WindAndBias,
        Self::Innovations,
        Self::Model,
        Self::Derivatives,
        Self::Fits,
        Self::Validation,
        Self::Match,
        Self::Prior,
        Self::Checks,
        Self::Experiments,
        Self::Sensitivity,
        Self::Condition,
        Self::Responses,
        Self::Dynamics,
        Self::Engines,
        Self::Conclusions,
        Self::Warnings,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Purpose => "purpose",
            Self::Overview => "overview",
            Self::Aircraft => "aircraft",
            Self::Channels => "channels",
            Self::Windows => "windows",
            Self::Filter => "filter",
            Self::Path => "path",
            Self::WindAndBias => "wind-and-bias",
            Self::Innovations => "innovations",
            Self::Model => "model",
            Self::Derivatives => "derivatives",
            Self::Fits => "fits",
            Self::Validation => "validation",
            Self::Match => "match",
            Self::Prior => "prior",
            Self::Checks => "checks",
            Self::Experiments => "experiments",
            Self::Sensitivity => "sensitivity",
            Self::Condition => "condition",
            Self::Responses => "responses",
            Self::Dynamics => "dynamics",
            Self::Engines => "engines",
            Self::Conclusions => "conclusions",
            Self::Warnings => "warnings",
        }
    }

    /// The study it shows, as a rule that of its name, which takes longer than the rest and has to be asked for.
    pub fn study(self) -> Option<Study> {
        match self {
            Self::Condition => Some(Study::Manoeuvres),
            other => Study::from_key(other.name()),
        }
    }

    /// Heading.
    pub fn title(self) -> &'static str {
        match self {
            Self::Purpose => "Purpose and derivatives asked for",
            Self::Overview => "Overview",
            Self::Aircraft => "Aircraft and loading",
            Self::Channels => "Instrumentation",
            Self::Windows => "Manoeuvres",
            Self::Filter => "Filter settings and consistency",
            Self::Path => "Flight path",
            Self::WindAndBias => "Wind and biases",
            Self::Innovations => "Innovations",
            Self::Model => "Model structure and correlation",
            Self::Derivatives => "Aerodynamic and control derivatives",
            Self::Fits => "Fits and residuals",
            Self::Validation => "Validation",
            Self::Match => "Proof of match",
            Self::Prior => "Comparison with the earlier estimate",
            Self::Checks => "Independent checks",
            Self::Experiments => "Experiments",
            Self::Sensitivity => "Sensitivity and total error",
            Self::Condition => "Dependence on flight condition",
            Self::Responses => "Frequency responses",
            Self::Dynamics => "Linear model, modes and flying qualities",
            Self::Engines => "Engines",
            Self::Conclusions => "Conclusions",
            Self::Warnings => "Findings",
        }
    }

    /// Heading of its appendix.
    pub(super) fn appendix_title(self) -> &'static str {
        match self {
            Self::Overview => "Recordings",
            Self::Aircraft => "Mass properties",
            Self::Channels => "Signals and clocks",
            Self::Windows => "Manoeuvre times and notes",
            Self::Filter => "Filter settings, noise and consistency",
            Self::Path => "Flight path of each manoeuvre",
            Self::Condition => "Derivatives over airspeed and altitude",
            Self::Innovations => "Innovations of each manoeuvre",
            Self::Derivatives => "Derivatives of each manoeuvre",
            Self::Fits => "Fits of each manoeuvre",
            Self::Validation => "Validation of each manoeuvre",
            Self::Match => "Proof of match of each manoeuvre",
            Self::Checks => "Independent checks of each manoeuvre",
            Self::Experiments => "Derivatives of each experiment",
            Self::Sensitivity => "Sensitivity by group of quantities",
            Self::Engines => "Engines by phase of flight",
            Self::Dynamics => "Paragraphs of the flying-quality criteria",
            other => other.title(),
        }
    }
}
