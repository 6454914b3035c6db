//! What the filter computes with: a number or a vector of lanes, three-vectors and 3 x 3 matrices of them.

pub(crate) mod mat3;
pub mod real;
pub(crate) mod vec3;
