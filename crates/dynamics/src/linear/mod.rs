//! Linear models about a trim.
