//! Levels of flying qualities.
