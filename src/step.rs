//! The steps of an analysis.

use serde::{Deserialize, Serialize};

/// The steps of an analysis, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Step {
    /// What was recorded, when, and where.
    Recording,
    /// What every channel means, and whether they fit each other.
    Channels,
    /// Geometry, mass and engines.
    Aircraft,
    /// Clocks, smoothing, sensors.
    Signals,
    Manoeuvres,
    /// Flight path reconstruction.
    Filter,
    /// Terms of the coefficients.
    Model,
    /// Derivatives and what may be believed of them.
    Results,
    /// What is handed on.
    Report,
}

impl Step {
    doublet_core::named_variants! {
        /// Its name.
        pub title:
            Recording "Recording", Channels "Channels", Aircraft "Aircraft", Signals "Signals", Manoeuvres "Manoeuvres",
            Filter "Filter", Model "Model", Results "Results", Report "Report",
    }

    doublet_core::variant_texts! {
        pub done_when:
            Recording "Done when every recording is read", Channels "Done when all channels are consistent",
            Aircraft "Done when mass, inertia and envelope are valid",
            Signals "Done when clocks are fitted and no manoeuvre has a gap",
            Manoeuvres "Done when every manoeuvre is confirmed or ignored",
            Filter "Done when the innovations of every manoeuvre are as predicted",
            Model "Done when every coefficient has a fit with separable terms",
            Results "Done when the verdict is good", Report "Done when the report is up to date",
    }
}
