//! Least-squares estimation of derivatives, its covariance and diagnostics.

mod covariance;
pub mod diagnostics;
mod error;
mod fit;
mod least_squares;
mod pooled;
mod triangle;

pub use covariance::{Coloured, Taper, autocorrelation, coloured_covariance};
pub use error::{Dependence, EstimateError};
pub use fit::{Fit, FitQuality};
pub use least_squares::least_squares;
pub use pooled::{PooledFit, PooledWindow, pooled};
