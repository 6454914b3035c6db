//! Command line of doublet.
