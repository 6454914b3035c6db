//! Transfer functions in factors, with a delay.

use nalgebra::{Complex, DMatrix};

/// A monic factor of a polynomial in `s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Section {
    /// `s + c0`.
    First(f64),
    /// `s^2 + c1 s + c0`.
    Second {
        /// Twice damping times frequency, 1/s.
        c1: f64,
        /// Square of the frequency, 1/s2.
        c0: f64,
    },
}

impl Section {
    /// Value at `s`.
    fn at(self, s: Complex<f64>) -> Complex<f64> {
        match self {
            Self::First(c0) => s + c0,
            Self::Second { c1, c0 } => s * s + s * c1 + c0,
        }
    }

    /// Phase at `s = j w`, rad, continuous in `w`.
    fn phase_rad(self, omega: f64) -> f64 {
        match self {
            Self::First(c0) => omega.atan2(c0),
            Self::Second { c1, c0 } => (c1 * omega).atan2(c0 - omega * omega),
        }
    }

    /// Its coefficients, the higher power first.
    pub(super) fn coefficients(self) -> Vec<f64> {
        match self {
            Self::First(c0) => vec![c0],
            Self::Second { c1, c0 } => vec![c1, c0],
        }
    }

    /// A factor of the same order from the first coefficients of `values`, which lose them.
    fn take(self, values: &mut impl Iterator<Item = f64>) -> Self {
        let mut next = || values.next().unwrap_or(f64::NAN);
        match self {
            Self::First(_) => Self::First(next()),
            Self::Second { .. } => Self::Second { c1: next(), c0: next() },
        }
    }

    /// Zeros of the factor.
    pub fn roots(self) -> Vec<Complex<f64>> {
        match self {
            Self::First(c0) => vec![Complex::new(-c0, 0.0)],
            Self::Second { c1, c0 } => {
                let root = Complex::new(0.25 * c1 * c1 - c0, 0.0).sqrt();
                vec![root - 0.5 * c1, -root - 0.5 * c1]
            }
        }
    }
}

/// `H(s) = K N(s) / D(s) e^(-tau s)` with monic factors: `K` is the gain at high frequency, in the output's unit over the input's times s to
/// the power of the order by which `N` is below `D`.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    /// Gain `K`.
    pub gain: f64,
    /// Factors of the numerator.
    pub numerator: Vec<Section>,
    /// Factors of the denominator.
    pub denominator: Vec<Section>,
    /// Delay `tau`, s.
    pub delay_s: f64,
}

impl TransferFunction {
    /// Value at `s = j omega`.
    pub fn at(&self, omega_rad_s: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega_rad_s);
        let over: Complex<f64> = self.numerator.iter().map(|section| section.at(s)).product();
        over / self.denominator_at(omega_rad_s)
            * Complex::from_polar(self.gain, 0.0)
            * Complex::from_polar(1.0, -omega_rad_s * self.delay_s)
    }

    /// Phase at `j omega` of the same with a positive gain, rad, continuous in frequency.
    pub fn phase_rad(&self, omega_rad_s: f64) -> f64 {
        let sum = |sections: &[Section]| sections.iter().map(|section| section.phase_rad(omega_rad_s)).sum::<f64>();
        sum(&self.numerator) - sum(&self.denominator) - omega_rad_s * self.delay_s
    }

    /// Zeros, rad/s.
    pub fn zeros(&self) -> Vec<Complex<f64>> {
        self.numerator.iter().flat_map(|section| section.roots()).collect()
    }

    /// Poles, rad/s.
    pub fn poles(&self) -> Vec<Complex<f64>> {
        self.denominator.iter().flat_map(|section| section.roots()).collect()
    }

    /// Gain, coefficients of numerator and denominator, and the delay.
    pub(super) fn parameters(&self) -> Vec<f64> {
        let sections = self.numerator.iter().chain(&self.denominator).flat_map(|section| section.coefficients());
        std::iter::once(self.gain).chain(sections).chain([self.delay_s]).collect()
    }

    /// One of the same factors with these parameters.
    pub(super) fn with_parameters(&self, parameters: &[f64]) -> Self {
        let mut values = parameters.iter().copied();
        let gain = values.next().unwrap_or(f64::NAN);
        let mut sections = |sections: &[Section]| sections.iter().map(|section| section.take(&mut values)).collect();
        let (numerator, denominator) = (sections(&self.numerator), sections(&self.denominator));
        Self { gain, numerator, denominator, delay_s: values.next().unwrap_or(0.0) }
    }

    /// Derivatives of `ln H(j omega)` with respect to every parameter.
    pub(super) fn log_derivatives(&self, omega_rad_s: f64) -> Vec<Complex<f64>> {
        let s = Complex::new(0.0, omega_rad_s);
        let over = self.numerator.iter().flat_map(|section| Self::section_slopes(section, s, 1.0));
        let under = self.denominator.iter().flat_map(|section| Self::section_slopes(section, s, -1.0));
        std::iter::once(Complex::new(self.gain.recip(), 0.0)).chain(over).chain(under).chain([-s]).collect()
    }

    fn section_slopes(section: &Section, s: Complex<f64>, sign: f64) -> Vec<Complex<f64>> {
        let inverse = section.at(s).inv() * sign;
        match section {
            Section::First(_) => vec![inverse],
            Section::Second { .. } => vec![inverse * s, inverse],
        }
    }

    /// Product of the factors of the denominator at `j omega`.
    pub(super) fn denominator_at(&self, omega_rad_s: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega_rad_s);
        self.denominator.iter().map(|section| section.at(s)).product()
    }
}

/// Whether the delay of a model is searched for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Delay {
    /// From zero up.
    Free,
    /// Known, s.
    Fixed(f64),
}

/// Factors of the monic polynomial `s^n + p[n-1] s^(n-1) + .. + p[0]`: pairs of conjugate roots, real roots two by two in rising size, and
/// one left over.
pub(super) fn factors(coefficients: &[f64]) -> Vec<Section> {
    match coefficients {
        [] => Vec::new(),
        [c0] => vec![Section::First(*c0)],
        [c0, c1] => vec![Section::Second { c1: *c1, c0: *c0 }],
        _ => {
            let order = coefficients.len();
            let companion = DMatrix::from_fn(order, order, |row, column| match (row, column) {
                (0, column) => -coefficients[order - 1 - column],
                (row, column) if row == column + 1 => 1.0,
                _ => 0.0,
            });
            let roots = companion.complex_eigenvalues();
            let tolerance = 1e-9 * roots.iter().map(|root| root.norm()).fold(0.0, f64::max);
            let pairs = roots.iter().filter(|root| root.im > tolerance);
            let mut sections: Vec<Section> =
                pairs.map(|root| Section::Second { c1: -2.0 * root.re, c0: root.norm_sqr() }).collect();
            let real = roots.iter().filter(|root| root.im.abs() <= tolerance);
            let mut real: Vec<f64> = real.map(|root| root.re).collect();
            real.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
            sections.extend(real.chunks(2).map(|pair| match pair {
                [a, b] => Section::Second { c1: -(a + b), c0: a * b },
                _ => Section::First(-pair[0]),
            }));
            sections
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_have_the_roots_of_their_product() {
        // (s + 0.5)(s + 3)(s^2 + 1.2 s + 4)(s - 0.1) expanded by hand: s^2 + 3.5 s + 1.5, times s^2 + 1.2 s + 4, times s - 0.1.
        let quartic = [6.0, 15.8, 9.7, 4.7];
        let mut quintic = vec![-0.1 * quartic[0]];
        quintic.extend((1..4).map(|k| quartic[k - 1] - 0.1 * quartic[k]));
        quintic.push(quartic[3] - 0.1);
        let sections = factors(&quintic);
        assert_eq!(sections.len(), 3);
        let mut roots: Vec<Complex<f64>> = sections.iter().flat_map(|section| section.roots()).collect();
        roots.sort_by(|a, b| a.re.total_cmp(&b.re));
        let imaginary = (4.0f64 - 0.36).sqrt();
        for (found, (re, im)) in
            roots.iter().zip([(-3.0, 0.0), (-0.6, imaginary), (-0.6, imaginary), (-0.5, 0.0), (0.1, 0.0)])
        {
            assert!((found.re - re).abs() < 1e-9 && (found.im.abs() - im).abs() < 1e-9, "{roots:?}");
        }
    }

    #[test]
    fn derivatives_of_the_logarithm_match_differences() {
        let model = TransferFunction {
            gain: -2.0,
            numerator: vec![Section::First(0.7)],
            denominator: vec![Section::Second { c1: 1.4, c0: 5.0 }, Section::First(9.0)],
            delay_s: 0.07,
        };
        let parameters = model.parameters();
        for omega in [0.2, 2.0, 11.0] {
            let exact = model.log_derivatives(omega);
            for (index, exact) in exact.iter().enumerate() {
                let moved = |step: f64| {
                    let mut parameters = parameters.clone();
                    parameters[index] += step;
                    model.with_parameters(&parameters).at(omega)
                };
                let step = 1e-6;
                let difference = (moved(step) - moved(-step)) / (2.0 * step) / model.at(omega);
                assert!((difference - exact).norm() < 1e-8, "{omega} {index}: {difference} {exact}");
            }
            let direct = (-model.at(omega)).arg();
            let turns = (model.phase_rad(omega) - direct) / std::f64::consts::TAU;
            assert!((turns - turns.round()).abs() < 1e-12);
        }
    }
}
