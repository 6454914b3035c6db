//! Least-squares estimation of derivatives, its covariance and diagnostics.
