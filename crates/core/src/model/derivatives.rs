//! A model with numbers: derivatives and the coefficients they give.

use super::{Coefficient, Term, Variable};

/// Values of all [`Variable`]s, in their order.
pub type VariableValues = [f64; Variable::ALL.len()];

/// One derivative of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivative {
    /// Coefficient it belongs to.
    pub coefficient: Coefficient,
    /// Term it multiplies.
    pub term: Term,
    /// Value per unit of the term.
    pub value: f64,
}

/// Derivatives of any number of coefficients, each coefficient the sum of derivative times term, laid out for the inner loop
/// of a simulation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derivatives {
    entries: Vec<Derivative>,
    /// Variable and power of all factors of all entries, one entry after the other.
    factors: Vec<(usize, i32)>,
    /// Where the factors of each entry end.
    ends: Vec<usize>,
    /// Whether the forces of the plane of symmetry are modelled as lift and drag alone.
    by_lift: bool,
}

impl FromIterator<(Coefficient, Term, f64)> for Derivatives {
    fn from_iter<I: IntoIterator<Item = (Coefficient, Term, f64)>>(entries: I) -> Self {
        let mut result = Self::default();
        for (coefficient, term, value) in entries {
            result.factors.extend(term.factors().iter().map(|&(variable, power)| (variable as usize, power)));
            result.ends.push(result.factors.len());
            result.entries.push(Derivative { coefficient, term, value });
        }
        use Coefficient::{CD, CL, CX, CZ};
        result.by_lift = result.has(CL) && result.has(CD) && !result.has(CX) && !result.has(CZ);
        result
    }
}

impl Derivatives {
    /// The derivatives, in the order they were given.
    pub fn entries(&self) -> &[Derivative] {
        &self.entries
    }

    /// Sets the value of the derivative at `index`; does nothing past the last.
    pub fn set(&mut self, index: usize, value: f64) {
        if let Some(entry) = self.entries.get_mut(index) {
            entry.value = value;
        }
    }

    /// Whether `coefficient` has a derivative.
    pub fn has(&self, coefficient: Coefficient) -> bool {
        self.entries.iter().any(|entry| entry.coefficient == coefficient)
    }

    /// The first term that depends on `variable`.
    pub fn term_of(&self, variable: Variable) -> Option<&Term> {
        let depends = |term: &&Term| term.factors().iter().any(|&(factor, _)| factor == variable);
        self.entries.iter().map(|entry| &entry.term).find(depends)
    }

    /// All eight coefficients in the order of [`Coefficient::ALL`]; zero where none is modelled.
    pub fn sums(&self, variables: &VariableValues) -> [f64; 8] {
        let mut sums = [0.0; 8];
        let mut start = 0;
        for (entry, &end) in self.entries.iter().zip(&self.ends) {
            let mut product = entry.value;
            for &(variable, power) in &self.factors[start..end] {
                let value = variables[variable];
                match power {
                    ..0 => product *= value.powi(power),
                    _ => (0..power).for_each(|_| product *= value),
                }
            }
            sums[entry.coefficient as usize] += product;
            start = end;
        }
        sums
    }

    /// Coefficients `CX CY CZ Cl Cm Cn`. Where neither CX nor CZ is modelled but CD and CL are, they follow from these:
    /// `CX = CL sin(alpha) - CD cos(alpha)`, `CZ = -CL cos(alpha) - CD sin(alpha)` (the inverse of `docs/conventions.md`).
    pub fn body_coefficients(&self, variables: &VariableValues) -> [f64; 6] {
        let [cx, cy, cz, cl, cm, cn, drag, lift] = self.sums(variables);
        if !self.by_lift {
            return [cx, cy, cz, cl, cm, cn];
        }
        let (sin, cos) = libm::sincos(variables[Variable::Alpha as usize]);
        [lift * sin - drag * cos, cy, -lift * cos - drag * sin, cl, cm, cn]
    }

    /// Slopes of all eight coefficients over every variable, by the power rule on each term.
    fn slopes(&self, variables: &VariableValues) -> [VariableValues; 8] {
        let mut slopes = [[0.0; Variable::ALL.len()]; 8];
        let mut start = 0;
        for (entry, &end) in self.entries.iter().zip(&self.ends) {
            let factors = &self.factors[start..end];
            for (place, &(variable, power)) in factors.iter().enumerate() {
                let others = factors.iter().enumerate().filter(|(other, _)| *other != place);
                let product: f64 = others.map(|(_, &(other, power))| variables[other].powi(power)).product();
                let own = f64::from(power) * variables[variable].powi(power - 1);
                slopes[entry.coefficient as usize][variable] += entry.value * own * product;
            }
            start = end;
        }
        slopes
    }

    /// Slopes of the coefficients `CX CY CZ Cl Cm Cn` over every variable: the derivatives of [`Derivatives::body_coefficients`].
    pub fn body_slopes(&self, variables: &VariableValues) -> [VariableValues; 6] {
        let [mut cx, cy, mut cz, cl, cm, cn, drag, lift] = self.slopes(variables);
        if self.by_lift {
            let alpha = Variable::Alpha as usize;
            let (sin, cos) = libm::sincos(variables[alpha]);
            let [.., drag_value, lift_value] = self.sums(variables);
            for ((x, z), (drag, lift)) in cx.iter_mut().zip(&mut cz).zip(drag.iter().zip(&lift)) {
                *x = lift * sin - drag * cos;
                *z = -lift * cos - drag * sin;
            }
            cx[alpha] += lift_value * cos + drag_value * sin;
            cz[alpha] += lift_value * sin - drag_value * cos;
        }
        [cx, cy, cz, cl, cm, cn]
    }

    /// Coefficients of body axes the model does not give.
    pub fn missing(&self) -> Vec<Coefficient> {
        let given = |coefficient: Coefficient| {
            self.has(coefficient) || (self.by_lift && matches!(coefficient, Coefficient::CX | Coefficient::CZ))
        };
        Coefficient::ALL[..6].iter().copied().filter(|&coefficient| !given(coefficient)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(pairs: &[(Variable, f64)]) -> VariableValues {
        let mut values = [0.0; Variable::ALL.len()];
        pairs.iter().for_each(|&(variable, value)| values[variable as usize] = value);
        values
    }

    #[test]
    fn coefficients_are_sums_of_derivative_times_term() {
        let term = |text: &str| Term::parse(text).unwrap();
        let mut model: Derivatives = [
            (Coefficient::Cm, term("1"), 0.1),
            (Coefficient::Cm, term("alpha^2*delta_e"), 3.0),
            (Coefficient::CY, term("beta*V^-1"), 50.0),
        ]
        .into_iter()
        .collect();
        let at = values(&[
            (Variable::Alpha, 0.2),
            (Variable::Elevator, -0.5),
            (Variable::Beta, 0.1),
            (Variable::Airspeed, 50.0),
        ]);
        let [_, cy, _, _, cm, _] = model.body_coefficients(&at);
        assert!((cm - 0.04).abs() < 1e-15 && (cy - 0.1).abs() < 1e-15);
        model.set(0, 0.2);
        assert!((model.sums(&at)[4] - 0.14).abs() < 1e-15);
        assert_eq!(model.missing(), [Coefficient::CX, Coefficient::CZ, Coefficient::Cl, Coefficient::Cn]);
        assert_eq!(model.term_of(Variable::Beta), Some(&term("beta*V^-1")));
    }

    #[test]
    fn lift_and_drag_give_the_body_forces() {
        let model: Derivatives =
            [(Coefficient::CL, Term::constant(), 0.8), (Coefficient::CD, Term::constant(), 0.06)].into_iter().collect();
        let alpha: f64 = 0.15;
        let [cx, _, cz, ..] = model.body_coefficients(&values(&[(Variable::Alpha, alpha)]));
        assert!((-cz * alpha.cos() + cx * alpha.sin() - 0.8).abs() < 1e-15);
        assert!((-cx * alpha.cos() - cz * alpha.sin() - 0.06).abs() < 1e-15);
        assert_eq!(model.missing().len(), 4);
    }
}
