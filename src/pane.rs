//! The panels there are, a row each: title, title on a tab, page of the manual, and what draws it.
//!
//! To add one: its file in the room of its step, a row here, and its place in `layouts.rs` where it stands in the layout of a step.

use serde::{Deserialize, Serialize};

/// Hands the rows to a macro: here to the one that makes [`Pane`], in `panels` to the one that makes what draws them.
macro_rules! each_panel {
    ($then:ident) => {
        $then! {
            Summary: "Summary", page "warnings", results::summary::Summary::default();
            Flight: "Flight", page "tutorial", recording::flight::Flight::default();
            Channels: "Channels", page "own_recording", recording::channels::Channels::default();
            GroundTrack: "Ground track", page "tutorial", recording::ground_track::GroundTrack;
            CrossPlot: "Cross plot", page "tutorial", recording::cross_plot::CrossPlot::default();
            Manoeuvres: "Manoeuvres", page "own_recording", manoeuvres::manoeuvre_list::Manoeuvres::default();
            Gallery: "Gallery", page "own_recording", manoeuvres::gallery::Gallery::default();
            ManoeuvreMap: "Manoeuvre map" tab "Map", page "own_recording", manoeuvres::manoeuvre_map::ManoeuvreMap::default();
            Preprocess: "Preprocess", page "method_path", signals::preprocess::Preprocess::default();
            Sensors: "Sensors", page "method_path", signals::sensors::Sensors::default();
            Noise: "Noise and filter", page "noise", filter::noise::Noise;
            Reconstruction: "Reconstruction", page "method_path", filter::reconstruction::Reconstruction::default();
            Innovations: "Innovations", page "noise", filter::innovations::Innovations::default();
            Model: "Model", page "structure", model::terms::Model::default();
            Derivatives: "Derivatives", page "method_estimation", results::derivatives::Derivatives;
            Experiments: "Experiments", page "structure", model::experiments::Experiments::default();
            Fits: "Fits and residuals" tab "Fits", page "structure", model::fits::Fits::default();
            Match: "Match", page "match", model::match_panel::Match::default();
            Replay: "3-D replay" tab "3-D", page "method_path", recording::replay::Replay::default();
            Propulsion: "Propulsion", page "method_coefficients", aircraft::propulsion::Propulsion::default();
            Correlation: "Correlation", page "structure", results::correlation::Correlation::default();
            Studies: "Studies", page "checks", results::studies::Studies::default();
            Sensitivity: "Sensitivity", page "checks", results::sensitivity::Sensitivity::default();
            Responses: "Frequency response" tab "Frequency", page "checks", results::responses::Responses::default();
            Dynamics: "Modes and levels" tab "Modes", page "dynamics", results::dynamics::Dynamics::default();
            Qualification: "Qualification", page "qualification", report::qualification::Qualification::default();
            Prior: "Prior", page "method_estimation", results::prior::Prior::default();
            Enough: "Enough", page "planning", report::enough::Enough::default();
            Design: "Design", page "planning", report::design::Design::default();
            Airframe: "Airframe", page "method_coefficients", aircraft::airframe::Airframe::default();
            Live: "Live", page "live", recording::live::Live::default();
            Loading: "Loading", page "method_coefficients", aircraft::loading::LoadingPanel::default();
            Report: "Report", page "results", report::contents::Report::default();
            Log: "Log", page "reliability", report::log::Log;
            Shortcuts: "Shortcuts", page "tutorial", shortcuts::Shortcuts;
        }
    };
}

pub(crate) use each_panel;

/// What is known of a panel before it is made.
struct PanelInfo {
    title: &'static str,
    tab: &'static str,
    page: &'static str,
}

macro_rules! panes {
    ($($pane:ident: $title:literal $(tab $tab:literal)?, page $page:literal, $make:expr;)*) => {
        /// The panels there are, in the order in which menus show them.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        pub enum Pane {
            $($pane,)*
        }

        impl Pane {
            pub const ALL: &'static [Self] = &[$(Self::$pane),*];
        }

        const PANELS: &[PanelInfo] = &[$(PanelInfo { title: $title, tab: [$($tab,)? $title][0], page: $page }),*];
    };
}

each_panel!(panes);

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
}
