//! Polynomials and zeros of transfer functions.

use nalgebra::{Complex, DMatrix};

use super::StateSpace;

impl StateSpace {
    /// Coefficients of the characteristic polynomial `det(s I - A)`, highest power first, and those of the numerator from an input to an
    /// output, by the algorithm of Faddeev and Leverrier. The numerator has as many, its leading ones zero where the output lags.
    pub fn transfer(&self, output: usize, input: usize) -> (Vec<f64>, Vec<f64>) {
        let size = self.a.nrows();
        let (b, c) = (self.b.column(input), self.c.row(output));
        let feedthrough = self.d[(output, input)];
        let (mut denominator, mut numerator) = (vec![1.0], vec![feedthrough]);
        let mut adjugate = DMatrix::<f64>::identity(size, size);
        for k in 1..=size {
            let product = &self.a * &adjugate;
            let next = -product.trace() / k as f64;
            numerator.push((c * &adjugate * b)[0] + feedthrough * next);
            denominator.push(next);
            adjugate = product + DMatrix::identity(size, size) * next;
        }
        (denominator, numerator)
    }

    /// Zeros from an input to an output. Leading coefficients below rounding are left out.
    pub fn zeros(&self, output: usize, input: usize) -> Vec<Complex<f64>> {
        /// What of the largest coefficient counts as rounding.
        const ROUNDING: f64 = 1e-13;
        let (_, numerator) = self.transfer(output, input);
        let largest = numerator.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let first = numerator.iter().position(|value| value.abs() > ROUNDING * largest);
        let Some(kept) = first.map(|first| &numerator[first..]).filter(|kept| kept.len() > 1) else {
            return Vec::new();
        };
        let degree = kept.len() - 1;
        let companion = DMatrix::from_fn(degree, degree, |i, j| {
            if i == 0 {
                -kept[j + 1] / kept[0]
            } else if i == j + 1 {
                1.0
            } else {
                0.0
            }
        });
        let mut zeros = doublet_core::decompose::eigenvalues(companion).unwrap_or_default();
        zeros.sort_by(|a: &Complex<f64>, b| a.norm().total_cmp(&b.norm()));
        zeros
    }
}
