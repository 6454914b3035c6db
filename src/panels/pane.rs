//! The panels there are, a row each: title, title on a tab, page of the manual, and what draws it.
//!
//! To add one: its file in the room of its step, a row here, and its place in `layouts.rs` where it stands in the layout of a step.

use serde::{Deserialize, Serialize};

use super::{Panel, aircraft, filter, manoeuvres, model, recording, report, results, shortcuts, signals};

/// What is known of a panel before it is made.
struct PanelInfo {
    title: &'static str,
    tab: &'static str,
    page: &'static str,
    make: fn() -> Box<dyn Panel>,
}

macro_rules! panels {
    ($($(#[$doc:meta])* $pane:ident: $title:literal $(tab $tab:literal)?, page $page:literal, $make:expr;)*) => {
        /// The panels there are, in the order in which menus show them.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        pub enum Pane {
            $($(#[$doc])* $pane,)*
        }

        impl Pane {
            pub const ALL: &'static [Self] = &[$(Self::$pane),*];
        }

        const PANELS: &[PanelInfo] =
            &[$(PanelInfo { title: $title, tab: [$($tab,)? $title][0], page: $page, make: || Box::new($make) }),*];
    };
}

panels! {
    /// What may be believed.
    Summary: "Summary", page "warnings", results::summary::Summary::default();
    /// The whole recording with its windows.
    Flight: "Flight", page "tutorial", recording::flight::Flight::default();
    /// What every channel means.
    Channels: "Channels", page "own_recording", recording::channels::Channels::default();
    /// The track over ground.
    GroundTrack: "Ground track", page "tutorial", recording::ground_track::GroundTrack;
    /// One channel against another.
    CrossPlot: "Cross plot", page "tutorial", recording::cross_plot::CrossPlot::default();
    /// The windows.
    Manoeuvres: "Manoeuvres", page "own_recording", manoeuvres::manoeuvre_list::Manoeuvres::default();
    /// The windows side by side.
    Gallery: "Gallery", page "own_recording", manoeuvres::gallery::Gallery::default();
    /// Manoeuvres and candidates over two of their quantities.
    ManoeuvreMap: "Manoeuvre map" tab "Map", page "own_recording", manoeuvres::manoeuvre_map::ManoeuvreMap::default();
    /// Smoothing, resampling, clocks, steady parts.
    Preprocess: "Preprocess", page "method_path", signals::preprocess::Preprocess::default();
    /// Calibrations of the sensors.
    Sensors: "Sensors", page "method_path", signals::sensors::Sensors::default();
    /// Settings of the filter.
    Noise: "Noise and filter", page "noise", filter::noise::Noise;
    /// States and measurements of the chosen window.
    Reconstruction: "Reconstruction", page "method_path", filter::reconstruction::Reconstruction::default();
    /// Innovations of the chosen window.
    Innovations: "Innovations", page "noise", filter::innovations::Innovations::default();
    /// Terms of the aerodynamic model.
    Model: "Model", page "structure", model::terms::Model::default();
    /// Derivatives.
    Derivatives: "Derivatives", page "method_estimation", results::derivatives::Derivatives;
    /// Configurations kept by name, side by side.
    Experiments: "Experiments", page "structure", model::experiments::Experiments::default();
    /// Coefficients, their fits and residuals.
    Fits: "Fits and residuals" tab "Fits", page "structure", model::fits::Fits::default();
    /// Validation windows flown again by the model.
    Match: "Match", page "match", model::match_panel::Match::default();
    /// The flight played: attitude, velocity, wind, controls.
    Replay: "3-D replay" tab "3-D", page "method_path", recording::replay::Replay::default();
    /// Engines over the flight.
    Propulsion: "Propulsion", page "method_coefficients", aircraft::propulsion::Propulsion::default();
    /// Correlation of the parameters.
    Correlation: "Correlation", page "structure", results::correlation::Correlation::default();
    /// Studies on request.
    Studies: "Studies", page "checks", results::studies::Studies::default();
    /// Derivatives against what they were computed with.
    Sensitivity: "Sensitivity", page "checks", results::sensitivity::Sensitivity::default();
    /// Frequency responses and equivalent systems.
    Responses: "Frequency response" tab "Frequency", page "checks", results::responses::Responses::default();
    /// Modes of the identified aircraft and levels of its flying qualities.
    Dynamics: "Modes and levels" tab "Modes", page "dynamics", results::dynamics::Dynamics::default();
    /// Objective tests of simulators on the identified model.
    Qualification: "Qualification", page "qualification", report::qualification::Qualification::default();
    /// An earlier estimate against the flight.
    Prior: "Prior", page "method_estimation", results::prior::Prior::default();
    /// Whether what was flown is enough.
    Enough: "Enough", page "planning", report::enough::Enough::default();
    /// Inputs of the next flight.
    Design: "Design", page "planning", report::design::Design::default();
    /// The aircraft to scale, and its weighing.
    Airframe: "Airframe", page "method_coefficients", aircraft::airframe::Airframe::default();
    /// A flight while it is flown.
    Live: "Live", page "live", recording::live::Live::default();
    /// What is on board.
    Loading: "Loading", page "method_coefficients", aircraft::loading::LoadingPanel::default();
    /// Contents of the report.
    Report: "Report", page "results", report::contents::Report::default();
    /// What was computed, when and why.
    Log: "Log", page "reliability", report::log::Log;
    /// Every command with its keys.
    Shortcuts: "Shortcuts", page "tutorial", shortcuts::Shortcuts;
}

impl Pane {
    fn info(self) -> &'static PanelInfo {
        &PANELS[self as usize]
    }

    pub fn title(self) -> &'static str {
        self.info().title
    }

    /// Its title on a tab.
    pub fn short_title(self) -> &'static str {
        self.info().tab
    }

    /// The page of the manual that says more about it.
    pub fn manual_page(self) -> &'static str {
        self.info().page
    }

    /// The panel with this title.
    pub fn from_title(title: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|pane| pane.title() == title)
    }

    /// Makes the panel.
    pub fn build(self) -> Box<dyn Panel> {
        (self.info().make)()
    }
}
