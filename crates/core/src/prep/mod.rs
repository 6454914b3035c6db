//! Signal preparation: smoothing, differentiation, sensor positions.
