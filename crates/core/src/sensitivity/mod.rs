//! Sensitivity of results to their inputs.
