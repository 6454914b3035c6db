//! Natural modes of a linear model, and modes as recorded.

pub mod measured;
