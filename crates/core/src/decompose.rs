//! Singular values and eigenvalues by iterations that end: none for a matrix that is empty or not finite, or that does not converge.
//!
//! Where they converge they are those of `nalgebra`'s own constructors, bit for bit; those iterate for ever on a matrix that overflows.

use nalgebra::{Complex, DMatrix, Dyn, SVD, Schur, SymmetricEigen};

/// Iterations per value: implicit QR takes two to three (Golub and Van Loan 2013, sections 7.5 and 8.6).
const PER_VALUE: usize = 100;

/// Singular value decomposition, largest value first; `left` and `right` ask for the vectors.
pub fn singular(matrix: DMatrix<f64>, left: bool, right: bool) -> Option<SVD<f64, Dyn, Dyn>> {
    /// Relative size at which an off-diagonal entry counts as zero.
    const TOLERANCE: f64 = 5.0 * f64::EPSILON;
    let values = matrix.nrows().min(matrix.ncols());
    is_regular(&matrix).then(|| SVD::try_new(matrix, left, right, TOLERANCE, PER_VALUE * values)).flatten()
}

/// Eigenvalues of a square matrix.
pub fn eigenvalues(matrix: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let size = matrix.nrows();
    let decomposition = (matrix.is_square() && is_regular(&matrix))
        .then(|| Schur::try_new(matrix, f64::EPSILON, PER_VALUE * size))
        .flatten()?;
    Some(decomposition.complex_eigenvalues().iter().copied().collect())
}

/// Eigenvalues and eigenvectors of a symmetric matrix.
pub fn symmetric(matrix: DMatrix<f64>) -> Option<SymmetricEigen<f64, Dyn>> {
    let size = matrix.nrows();
    (matrix.is_square() && is_regular(&matrix))
        .then(|| SymmetricEigen::try_new(matrix, f64::EPSILON, PER_VALUE * size))
        .flatten()
}

fn is_regular(matrix: &DMatrix<f64>) -> bool {
    !matrix.is_empty() && matrix.iter().all(|value| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An entry, one of each kind that once was iterated on for ever, in a matrix of otherwise ordinary size.
    fn with(entry: f64) -> DMatrix<f64> {
        DMatrix::from_fn(4, 4, |i, j| if (i, j) == (2, 1) { entry } else { 1.0 / (1.0 + i as f64 + 2.0 * j as f64) })
    }

    #[test]
    fn decompositions_of_what_is_empty_or_not_finite_end() {
        for matrix in [DMatrix::zeros(0, 0), with(f64::NAN), with(f64::INFINITY)] {
            assert!(singular(matrix.clone(), true, true).is_none());
            assert!(eigenvalues(matrix.clone()).is_none());
            assert!(symmetric(matrix).is_none());
        }
        // An overflow on the way ends too, with or without values.
        let _ = (singular(with(1e308), true, true), eigenvalues(with(1e308)), symmetric(with(1e308)));
    }

    #[test]
    fn decompositions_equal_those_without_a_bound() {
        let matrix = with(3.0);
        let ours = singular(matrix.clone(), true, true).unwrap();
        let theirs = matrix.clone().svd(true, true);
        assert_eq!((ours.singular_values, ours.u, ours.v_t), (theirs.singular_values, theirs.u, theirs.v_t));
        let theirs: Vec<_> = matrix.clone().complex_eigenvalues().iter().copied().collect();
        assert_eq!(eigenvalues(matrix.clone()).unwrap(), theirs);
        let square = &matrix * matrix.transpose();
        let (ours, theirs) = (symmetric(square.clone()).unwrap(), SymmetricEigen::new(square));
        assert_eq!((ours.eigenvalues, ours.eigenvectors), (theirs.eigenvalues, theirs.eigenvectors));
    }
}
