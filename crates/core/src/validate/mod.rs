//! Fit metrics, residual tests and prediction on data not used.
