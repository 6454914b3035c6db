//! The panels there are: their titles, the pages of the manual about them, and what draws them.

use serde::{Deserialize, Serialize};

use super::Panel;

/// The panels there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Pane {
    /// What may be believed.
    Summary,
    /// The whole recording with its windows.
    Flight,
    /// What every channel means.
    Channels,
    /// The track over ground.
    GroundTrack,
    /// One channel against another.
    CrossPlot,
    /// The windows.
    Manoeuvres,
    /// The windows side by side.
    Gallery,
    /// Manoeuvres and candidates over two of their quantities.
    ManoeuvreMap,
    /// Smoothing, resampling, clocks, steady windows.
    Preprocess,
    /// Calibrations of the sensors.
    Sensors,
    /// Settings of the filter.
    Noise,
    /// States and measurements of the chosen window.
    Reconstruction,
    /// Innovations of the chosen window.
    Innovations,
    /// Terms of the aerodynamic model.
    Model,
    /// Derivatives.
    Derivatives,
    /// Configurations kept by name, side by side.
    Experiments,
    /// Coefficients, their fits and residuals.
    Fits,
    /// Validation windows flown again by the model.
    Match,
    /// The flight played: attitude, velocity, wind, controls.
    Replay,
    /// Engines over the flight.
    Propulsion,
    /// Correlation of the parameters.
    Correlation,
    /// Studies on request.
    Studies,
    /// Derivatives against what they were computed with.
    Sensitivity,
    /// Frequency responses and equivalent systems.
    Responses,
    /// Modes of the identified aircraft and levels of its flying qualities.
    Dynamics,
    /// Objective tests of simulators on the identified model.
    Qualification,
    /// An earlier estimate against the flight.
    Prior,
    /// Whether what was flown is enough.
    Enough,
    /// Inputs of the next flight.
    Design,
    /// The aircraft to scale, and its weighing.
    Airframe,
    /// A flight while it is flown.
    Live,
    /// What is on board.
    Loading,
    /// Contents of the report.
    Report,
    /// What was computed, when and why.
    Log,
    /// Every command with its keys.
    Shortcuts,
}

impl Pane {
    /// Every panel, in the order menus show them.
    pub const ALL: &'static [Self] = &[
        Self::Summary,
        Self::Flight,
        Self::Channels,
        Self::GroundTrack,
        Self::CrossPlot,
        Self::Manoeuvres,
        Self::Gallery,
        Self::ManoeuvreMap,
        Self::Preprocess,
        Self::Sensors,
        Self::Noise,
        Self::Reconstruction,
        Self::Innovations,
        Self::Model,
        Self::Derivatives,
        Self::Experiments,
        Self::Fits,
        Self::Match,
        Self::Replay,
        Self::Propulsion,
        Self::Correlation,
        Self::Studies,
        Self::Sensitivity,
        Self::Responses,
        Self::Dynamics,
        Self::Qualification,
        Self::Prior,
        Self::Enough,
        Self::Design,
        Self::Airframe,
        Self::Live,
        Self::Loading,
        Self::Report,
        Self::Log,
        Self::Shortcuts,
    ];

    /// Its title.
    pub fn title(self) -> &'static str {
        match self {
            Self::Summary => "Summary",
            Self::Flight => "Flight",
            Self::Channels => "Channels",
            Self::GroundTrack => "Ground track",
            Self::CrossPlot => "Cross plot",
            Self::Manoeuvres => "Manoeuvres",
            Self::Gallery => "Gallery",
            Self::ManoeuvreMap => "Manoeuvre map",
            Self::Preprocess => "Preprocess",
            Self::Sensors => "Sensors",
            Self::Noise => "Noise and filter",
            Self::Reconstruction => "Reconstruction",
            Self::Innovations => "Innovations",
            Self::Model => "Model",
            Self::Derivatives => "Derivatives",
            Self::Experiments => "Experiments",
            Self::Fits => "Fits and residuals",
            Self::Match => "Match",
            Self::Replay => "3-D replay",
            Self::Propulsion => "Propulsion",
            Self::Correlation => "Correlation",
            Self::Studies => "Studies",
            Self::Sensitivity => "Sensitivity",
            Self::Responses => "Frequency response",
            Self::Dynamics => "Modes and levels",
            Self::Qualification => "Qualification",
            Self::Prior => "Prior",
            Self::Enough => "Enough",
            Self::Design => "Design",
            Self::Airframe => "Airframe",
            Self::Live => "Live",
            Self::Loading => "Loading",
            Self::Report => "Report",
            Self::Log => "Log",
            Self::Shortcuts => "Shortcuts",
        }
    }

    /// Its title on a tab.
    pub fn short_title(self) -> &'static str {
        match self {
            Self::ManoeuvreMap => "Map",
            Self::Responses => "Frequency",
            Self::Dynamics => "Modes",
            Self::Fits => "Fits",
            Self::Replay => "3-D",
            other => other.title(),
        }
    }

    /// The page of the manual that says more about it.
    pub fn manual_page(self) -> &'static str {
        match self {
            Self::Summary => "warnings",
            Self::Flight | Self::GroundTrack | Self::CrossPlot | Self::Shortcuts => "tutorial",
            Self::Channels | Self::Manoeuvres | Self::Gallery | Self::ManoeuvreMap => "own_recording",
            Self::Preprocess | Self::Reconstruction | Self::Sensors | Self::Replay => "method_path",
            Self::Noise | Self::Innovations => "noise",
            Self::Model | Self::Experiments | Self::Fits | Self::Correlation => "structure",
            Self::Derivatives => "method_estimation",
            Self::Match => "match",
            Self::Propulsion | Self::Airframe | Self::Loading => "method_coefficients",
            Self::Studies | Self::Sensitivity | Self::Responses => "checks",
            Self::Dynamics => "dynamics",
            Self::Qualification => "qualification",
            Self::Prior => "method_estimation",
            Self::Enough | Self::Design => "planning",
            Self::Live => "live",
            Self::Report => "results",
            Self::Log => "reliability",
        }
    }

    /// The panel with this title.
    pub fn from_title(title: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|pane| pane.title() == title)
    }

    /// Makes the panel.
    pub fn build(self) -> Box<dyn Panel> {
        match self {
            Self::Summary => Box::new(super::summary::Summary::default()),
            Self::Flight => Box::new(super::flight::Flight::default()),
            Self::Channels => Box::new(super::channels::Channels::default()),
            Self::GroundTrack => Box::new(super::ground_track::GroundTrack),
            Self::CrossPlot => Box::new(super::cross_plot::CrossPlot::default()),
            Self::Manoeuvres => Box::new(super::manoeuvres::Manoeuvres::default()),
            Self::Gallery => Box::new(super::gallery::Gallery::default()),
            Self::ManoeuvreMap => Box::new(super::manoeuvre_map::ManoeuvreMap::default()),
            Self::Preprocess => Box::new(super::preprocess::Preprocess::default()),
            Self::Sensors => Box::new(super::sensors::Sensors::default()),
            Self::Noise => Box::new(super::noise::Noise),
            Self::Reconstruction => Box::new(super::reconstruction::Reconstruction::default()),
            Self::Innovations => Box::new(super::innovations::Innovations::default()),
            Self::Model => Box::new(super::model::Model::default()),
            Self::Derivatives => Box::new(super::derivatives::Derivatives::default()),
            Self::Experiments => Box::new(super::experiments::Experiments::default()),
            Self::Fits => Box::new(super::fits::Fits::default()),
            Self::Match => Box::new(super::match_panel::Match::default()),
            Self::Replay => Box::new(super::replay::Replay::default()),
            Self::Propulsion => Box::new(super::propulsion::Propulsion::default()),
            Self::Correlation => Box::new(super::correlation::Correlation::default()),
            Self::Studies => Box::new(super::studies::Studies::default()),
            Self::Sensitivity => Box::new(super::sensitivity::Sensitivity::default()),
            Self::Responses => Box::new(super::responses::Responses::default()),
            Self::Dynamics => Box::new(super::dynamics::Dynamics::default()),
            Self::Qualification => Box::new(super::qualification::Qualification::default()),
            Self::Prior => Box::new(super::prior::Prior::default()),
            Self::Enough => Box::new(super::enough::Enough::default()),
            Self::Design => Box::new(super::design::Design::default()),
            Self::Airframe => Box::new(super::airframe::Airframe::default()),
            Self::Live => Box::new(super::live::Live::default()),
            Self::Loading => Box::new(super::loading::LoadingPanel::default()),
            Self::Report => Box::new(super::report::Report::default()),
            Self::Log => Box::new(super::log::Log),
            Self::Shortcuts => Box::new(super::shortcuts::Shortcuts),
        }
    }
}
