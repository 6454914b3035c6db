//! The sections of a report: names, headings and the studies they need.

use crate::study::Study;

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
    Windows,
    /// Settings of the filter and its consistency.
    Filter,
    /// Measured channels beside the reconstructed path, biases over time.
    Path,
    /// Wind and biases.
    WindAndBias,
    Innovations,
    /// Structure of the model and correlation of its parameters.
    Model,
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
    doublet_core::named_variants! {
        /// Name on the command line.
        pub name:
            Purpose "purpose", Overview "overview", Aircraft "aircraft", Channels "channels", Windows "windows", Filter "filter",
            Path "path", WindAndBias "wind-and-bias", Innovations "innovations", Model "model",
            Derivatives "derivatives", Fits "fits", Validation "validation", Match "match", Prior "prior",
            Checks "checks", Experiments "experiments", Sensitivity "sensitivity", Condition "condition",
            Responses "responses", Dynamics "dynamics", Engines "engines", Conclusions "conclusions",
            Warnings "warnings",
    }

    /// The study it shows, as a rule that of its name, which takes longer than the rest and has to be asked for.
    pub fn study(self) -> Option<Study> {
        match self {
            Self::Condition => Some(Study::Manoeuvres),
            other => Study::from_key(other.name()),
        }
    }

    doublet_core::variant_texts! {
        /// Heading.
        pub title:
            Purpose "Purpose and derivatives asked for", Overview "Overview", Aircraft "Aircraft and loading", Channels "Instrumentation", Windows "Manoeuvres",
            Filter "Filter settings and consistency", Path "Flight path", WindAndBias "Wind and biases",
            Innovations "Innovations", Model "Model structure and correlation",
            Derivatives "Aerodynamic and control derivatives", Fits "Fits and residuals", Validation "Validation",
            Match "Proof of match", Prior "Comparison with the earlier estimate", Checks "Independent checks",
            Experiments "Experiments", Sensitivity "Sensitivity to stated quantities",
            Condition "Dependence on flight condition", Responses "Frequency responses",
            Dynamics "Linear model, modes and flying qualities", Engines "Engines", Conclusions "Conclusions",
            Warnings "Findings",
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
            Self::Responses => "Equivalent systems of the responses",
            Self::Dynamics => "State matrices and paragraphs of the criteria",
            other => other.title(),
        }
    }
}
