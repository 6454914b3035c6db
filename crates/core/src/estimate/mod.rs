//! Least-squares estimation of derivatives, its covariance and diagnostics.

mod error;
mod fit;
mod least_squares;
mod triangle;

pub use error::{Dependence, EstimateError};
pub use fit::{Fit, FitQuality};
pub use least_squares::least_squares;
