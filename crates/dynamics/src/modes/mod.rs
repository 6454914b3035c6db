//! Natural modes of a linear model.
