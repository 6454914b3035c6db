//! What may be believed, and why: levels, findings and the verdicts made of them.
//!
//! Everything that looks for faults, of a recording, a session or its results, says what it found as a [`Finding`]. A [`Verdict`]
//! is the worst of the findings about one thing.

pub(crate) mod accelerometer;
mod biased;
mod calibration;
mod delay;
mod density;
mod dependence;
mod derivative;
mod effect;
mod findings;
mod fit;
mod fixes;
mod flight;
mod fold;
mod gravity;
mod gust_bias;
mod judge;
mod judged_flights;
mod late_force;
mod loading;
mod made_of;
pub(crate) mod mounting;
mod noise;
mod plausible;
mod propulsion;
mod remedies;
mod sampling;
mod saturated;
mod session;
pub(crate) mod shape;
mod sideslip;
mod spoilt;
mod stalls;
mod stated_quantity;
mod stuck;
mod studies;
mod vane;
mod weigh;
mod window;

pub use crate::session::{Finding, Level, PlausibleRange, Verdict};
pub use crate::snapshot::{
    Cause, Consequence, DerivativeVerdict, Effect, FitVerdict, VerdictCounts, Verdicts, WindowVerdict,
};
pub use crate::stage::CONDITION_LIMIT;
pub use calibration::{CaseCounts, calibrate_levels};
pub use dependence::{Dependence, dependences};
pub use findings::{findings, folded};
pub use fixes::fixes;
pub use fold::{Folded, fold, list_failures, list_places};
pub(crate) use judge::NO_WINDOW;
pub use judge::judge;
pub use judged_flights::{JudgedFlights, fly_and_judge, judged_flights};
use stated_quantity::mean_mass;
pub use stated_quantity::{StatedQuantity, stated_quantity};
pub(crate) use studies::{TWIN_CAUTION, TWIN_PART, compare_twins};
