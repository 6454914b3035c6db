//! Engine chart, propeller map and thrust.
