//! Algebra of vectors of three numbers.

use crate::reconstruct::numeric::real::Real;

/// Three numbers: a vector, or the diagonal of a matrix.
pub(crate) type Vec3<T> = [T; 3];

/// `a + factor b`.
#[inline(always)]
pub(crate) fn add_scaled<T: Real>(a: &Vec3<T>, b: &Vec3<T>, factor: T) -> Vec3<T> {
    [b[0].mul_add(factor, a[0]), b[1].mul_add(factor, a[1]), b[2].mul_add(factor, a[2])]
}

/// `a - b`.
#[inline(always)]
pub fn difference<T: Real>(a: &Vec3<T>, b: &Vec3<T>) -> Vec3<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
