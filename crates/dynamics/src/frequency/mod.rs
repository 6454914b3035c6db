//! Frequency responses from records and low-order equivalent systems.
//!
//! [`responses`] estimates the response of an output to one or several inputs, conditioned on each other, with coherence and the random
//! error of gain and phase; [`fit_response`] and [`fit_records`] fit a [`TransferFunction`] to responses or to the records themselves;
//! [`BodeCurve`] gives bandwidth, phase delay and margins of either; [`state_space_response`] is the response of a linear model. Angular frequencies in rad/s, phases in rad, `exp(+j w t)`.

mod bode;
mod composite;
mod error;
mod fit;
mod form;
mod levenberg;
mod output_error;
mod record;
mod response;
mod start;
mod state_space;
mod transfer;
mod transform;

pub use bode::{Bandwidth, BodeCurve, Margins};
pub use error::FrequencyError;
pub use fit::{EquivalentSystem, FitSettings, FittedParameter, Mismatch, fit_response};
pub use form::Form;
pub use output_error::{OutputErrorBand, fit_records};
pub use record::{FrequencyRecord, logarithmic_grid};
pub use response::{FrequencyResponse, ResponsePoint, SpectralSettings, responses};
pub use state_space::state_space_response;
pub use transfer::{Delay, Section, TransferFunction};
pub use transform::ChirpZ;
