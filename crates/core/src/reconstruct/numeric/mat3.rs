//! Algebra of 3 x 3 matrices, of which the packed filter's matrices are made.

use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::numeric::vec3::Vec3;

/// A 3 x 3 matrix, row by row.
pub(crate) type Mat3<T> = [[T; 3]; 3];

#[inline(always)]
pub fn zeros<T: Real>() -> Mat3<T> {
    [[T::zero(); 3]; 3]
}

/// `factor` times the identity.
#[inline(always)]
pub(crate) fn scaled_identity<T: Real>(factor: T) -> Mat3<T> {
    let zero = T::zero();
    [[factor, zero, zero], [zero, factor, zero], [zero, zero, factor]]
}

/// `a * factor`.
#[inline(always)]
pub fn scaled<T: Real>(a: &Mat3<T>, factor: T) -> Mat3<T> {
    let mut c = *a;
    for i in 0..3 {
        for j in 0..3 {
            c[i][j] = a[i][j] * factor;
        }
    }
    c
}

/// `a + b`.
#[inline(always)]
pub fn sum<T: Real>(a: &Mat3<T>, b: &Mat3<T>) -> Mat3<T> {
    let mut c = *a;
    for i in 0..3 {
        for j in 0..3 {
            c[i][j] = a[i][j] + b[i][j];
        }
    }
    c
}

#[inline(always)]
pub(crate) fn transposed<T: Real>(a: &Mat3<T>) -> Mat3<T> {
    [[a[0][0], a[1][0], a[2][0]], [a[0][1], a[1][1], a[2][1]], [a[0][2], a[1][2], a[2][2]]]
}

/// `c + a b`.
#[inline(always)]
pub(crate) fn add_product<T: Real>(c: &Mat3<T>, a: &Mat3<T>, b: &Mat3<T>) -> Mat3<T> {
    let mut c = *c;
    for i in 0..3 {
        for k in 0..3 {
            for j in 0..3 {
                c[i][j] = a[i][k].mul_add(b[k][j], c[i][j]);
            }
        }
    }
    c
}

/// `a b`.
#[inline(always)]
pub fn product<T: Real>(a: &Mat3<T>, b: &Mat3<T>) -> Mat3<T> {
    let mut c = zeros();
    for i in 0..3 {
        for j in 0..3 {
            c[i][j] = a[i][2].mul_add(b[2][j], a[i][1].mul_add(b[1][j], a[i][0] * b[0][j]));
        }
    }
    c
}

/// `c - a b`.
#[inline(always)]
pub(crate) fn subtract_product<T: Real>(c: &Mat3<T>, a: &Mat3<T>, b: &Mat3<T>) -> Mat3<T> {
    let mut c = *c;
    for i in 0..3 {
        for k in 0..3 {
            for j in 0..3 {
                c[i][j] = a[i][k].neg_mul_add(b[k][j], c[i][j]);
            }
        }
    }
    c
}

/// `c + a b'`.
#[inline(always)]
pub(crate) fn add_product_transposed<T: Real>(c: &Mat3<T>, a: &Mat3<T>, b: &Mat3<T>) -> Mat3<T> {
    let mut c = *c;
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                c[i][j] = a[i][k].mul_add(b[j][k], c[i][j]);
            }
        }
    }
    c
}

/// `c - a b'`.
#[inline(always)]
pub(crate) fn subtract_product_transposed<T: Real>(c: &Mat3<T>, a: &Mat3<T>, b: &Mat3<T>) -> Mat3<T> {
    let mut c = *c;
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                c[i][j] = a[i][k].neg_mul_add(b[j][k], c[i][j]);
            }
        }
    }
    c
}

/// `a diag(d)`.
#[inline(always)]
pub(crate) fn scaled_columns<T: Real>(a: &Mat3<T>, d: &Vec3<T>) -> Mat3<T> {
    let mut c = *a;
    for i in 0..3 {
        for j in 0..3 {
            c[i][j] = a[i][j] * d[j];
        }
    }
    c
}

/// `diag(d) a`.
#[inline(always)]
pub(crate) fn scaled_rows<T: Real>(a: &Mat3<T>, d: &Vec3<T>) -> Mat3<T> {
    let mut c = *a;
    for i in 0..3 {
        for j in 0..3 {
            c[i][j] = a[i][j] * d[i];
        }
    }
    c
}

/// `c + a b` with a vector `b`.
#[inline(always)]
pub(crate) fn add_times<T: Real>(c: &Vec3<T>, a: &Mat3<T>, b: &Vec3<T>) -> Vec3<T> {
    let mut c = *c;
    for i in 0..3 {
        for k in 0..3 {
            c[i] = a[i][k].mul_add(b[k], c[i]);
        }
    }
    c
}

/// `c - a b` with a vector `b`.
#[inline(always)]
pub(crate) fn subtract_times<T: Real>(c: &Vec3<T>, a: &Mat3<T>, b: &Vec3<T>) -> Vec3<T> {
    let mut c = *c;
    for i in 0..3 {
        for k in 0..3 {
            c[i] = a[i][k].neg_mul_add(b[k], c[i]);
        }
    }
    c
}

/// Matrix of the cross product: `cross(a) b = a x b`.
#[inline(always)]
pub fn cross<T: Real>(a: &Vec3<T>) -> Mat3<T> {
    let zero = T::zero();
    [[zero, -a[2], a[1]], [a[2], zero, -a[0]], [-a[1], a[0], zero]]
}

/// Square of a cross-product matrix: `cross(a) cross(a) = a a' - (a'a) I`.
#[inline(always)]
pub(crate) fn cross_squared<T: Real>(a: &Vec3<T>) -> Mat3<T> {
    let (xx, yy, zz) = (a[0] * a[0], a[1] * a[1], a[2] * a[2]);
    let (xy, xz, yz) = (a[0] * a[1], a[0] * a[2], a[1] * a[2]);
    [[-(yy + zz), xy, xz], [xy, -(xx + zz), yz], [xz, yz, -(xx + yy)]]
}

/// Cholesky factor of a symmetric 3 x 3 matrix, the diagonal held as its inverse.
#[derive(Clone, Copy)]
pub struct Factor<T> {
    lower: Mat3<T>,
    /// Reciprocals of the diagonal; zero for a pivot that is not positive.
    pub inverse_diagonal: Vec3<T>,
    /// Smallest pivot: not positive where the matrix is not positive definite.
    pub pivot: T,
}

impl<T: Real> Factor<T> {
    /// Factor of `s`, of which the lower triangle is read. A pivot that is not positive counts as infinite, which leaves
    /// its row out of every solution: right for a state known exactly.
    #[inline(always)]
    pub fn new(s: &Mat3<T>) -> Self {
        let one = T::splat(1.0);
        let zero = T::zero();
        let d0 = s[0][0];
        let i0 = d0.select_above(zero, one / d0.sqrt(), zero);
        let (l10, l20) = (s[1][0] * i0, s[2][0] * i0);
        let d1 = l10.neg_mul_add(l10, s[1][1]);
        let i1 = d1.select_above(zero, one / d1.sqrt(), zero);
        let l21 = l20.neg_mul_add(l10, s[2][1]) * i1;
        let d2 = l21.neg_mul_add(l21, l20.neg_mul_add(l20, s[2][2]));
        let i2 = d2.select_above(zero, one / d2.sqrt(), zero);
        Self {
            lower: [[zero, zero, zero], [l10, zero, zero], [l20, l21, zero]],
            inverse_diagonal: [i0, i1, i2],
            pivot: d0.lesser(d1).lesser(d2),
        }
    }

    /// `b L'^-1`: rows of `b` whitened.
    #[inline(always)]
    pub(crate) fn whiten_rows(&self, b: &Mat3<T>) -> Mat3<T> {
        let (l, d) = (&self.lower, &self.inverse_diagonal);
        let mut w = *b;
        for i in 0..3 {
            w[i][0] = b[i][0] * d[0];
            w[i][1] = w[i][0].neg_mul_add(l[1][0], b[i][1]) * d[1];
            w[i][2] = w[i][1].neg_mul_add(l[2][1], w[i][0].neg_mul_add(l[2][0], b[i][2])) * d[2];
        }
        w
    }

    /// `L^-1 b` for a vector.
    #[inline(always)]
    pub(crate) fn whiten(&self, b: &Vec3<T>) -> Vec3<T> {
        let (l, d) = (&self.lower, &self.inverse_diagonal);
        let w0 = b[0] * d[0];
        let w1 = w0.neg_mul_add(l[1][0], b[1]) * d[1];
        let w2 = w1.neg_mul_add(l[2][1], w0.neg_mul_add(l[2][0], b[2])) * d[2];
        [w0, w1, w2]
    }

    /// `L^-1 b`: columns of `b` whitened.
    #[inline(always)]
    pub fn solve(&self, b: &Mat3<T>) -> Mat3<T> {
        transposed(&self.whiten_rows(&transposed(b)))
    }

    /// `L'^-1 b`.
    #[inline(always)]
    pub(crate) fn solve_transposed(&self, b: &Mat3<T>) -> Mat3<T> {
        let (l, d) = (&self.lower, &self.inverse_diagonal);
        let mut x = *b;
        for j in 0..3 {
            x[2][j] = b[2][j] * d[2];
            x[1][j] = l[2][1].neg_mul_add(x[2][j], b[1][j]) * d[1];
            x[0][j] = l[1][0].neg_mul_add(x[1][j], l[2][0].neg_mul_add(x[2][j], b[0][j])) * d[0];
        }
        x
    }
}

/// Inverse of a matrix near the identity, by cofactors.
#[inline(always)]
pub fn inverse<T: Real>(a: &Mat3<T>) -> Mat3<T> {
    let mut cofactors = *a;
    for i in 0..3 {
        let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
        for j in 0..3 {
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            cofactors[j][i] = a[i1][j1].mul_add(a[i2][j2], -(a[i1][j2] * a[i2][j1]));
        }
    }
    let determinant = a[0][0].mul_add(cofactors[0][0], a[0][1].mul_add(cofactors[1][0], a[0][2] * cofactors[2][0]));
    scaled(&cofactors, T::splat(1.0) / determinant)
}
