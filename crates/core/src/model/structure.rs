//! Structures: which terms each coefficient is a sum of.

use super::{Coefficient, ModelError, Term, Variable};

/// Model structure: each coefficient as a sum of terms, `C = sum over terms of derivative * term`.
#[derive(Clone, Debug, PartialEq, Hash)]
pub struct Structure {
    /// Coefficients with their terms, in the order tables show them.
    pub models: Vec<(Coefficient, Vec<Term>)>,
}

/// Body-axes coefficients of longitudinal motion.
const LONGITUDINAL: [Coefficient; 3] = [Coefficient::CX, Coefficient::CZ, Coefficient::Cm];
/// Body-axes coefficients of lateral motion.
const LATERAL: [Coefficient; 3] = [Coefficient::CY, Coefficient::Cl, Coefficient::Cn];

impl Structure {
    /// Final structure of the thesis (Eq. 3.21-3.22): `CX CZ Cm` of `1, alpha, qc/V, delta_e` and `CY Cl Cn` of
    /// `1, beta, pb/2V, rb/2V, delta_a, delta_r`.
    pub fn thesis() -> Self {
        Self::symmetric_and_lateral(
            &[Variable::Alpha, Variable::PitchRate, Variable::Elevator],
            &[Variable::Beta, Variable::RollRate, Variable::YawRate, Variable::Aileron, Variable::Rudder],
        )
    }

    /// Alternative structure of the thesis (Eq. B.1-B.2): the final one with the rates of the flow angles.
    pub fn alternative() -> Self {
        Self::symmetric_and_lateral(
            &[Variable::Alpha, Variable::AlphaDot, Variable::PitchRate, Variable::Elevator],
            &[
                Variable::Beta,
                Variable::BetaDot,
                Variable::RollRate,
                Variable::YawRate,
                Variable::Aileron,
                Variable::Rudder,
            ],
        )
    }

    /// The thesis structure with `alpha^2` in the longitudinal coefficients (thesis Eq. 3.20, struck out there).
    pub fn quadratic() -> Self {
        let mut structure = Self::thesis();
        structure.extend(&LONGITUDINAL, &Term::product([(Variable::Alpha, 2)]));
        structure
    }

    /// The thesis structure with the pressure rise through the propellers in the longitudinal coefficients (thesis
    /// Eq. 3.20, struck out there because the power is constant within a manoeuvre: it needs windows of different
    /// power, else the fit reports it as dependent on the constant).
    pub fn with_power() -> Self {
        let mut structure = Self::thesis();
        structure.extend(&LONGITUDINAL, &Term::from(Variable::PropellerPressure));
        structure
    }

    /// Terms of `coefficient`, if the structure models it.
    pub fn terms(&self, coefficient: Coefficient) -> Option<&[Term]> {
        self.models.iter().find(|(modelled, _)| *modelled == coefficient).map(|(_, terms)| terms.as_slice())
    }

    /// Names of the derivatives of `coefficient` in the order of its terms; empty where it is not modelled.
    pub fn derivative_names(&self, coefficient: Coefficient) -> Vec<String> {
        let terms = self.terms(coefficient).unwrap_or_default();
        terms.iter().map(|term| term.derivative_name(coefficient)).collect()
    }

    /// Checks that no coefficient has a term twice.
    ///
    /// # Errors
    /// [`ModelError::RepeatedTerm`] with the coefficient and the term.
    pub fn check(&self) -> Result<(), ModelError> {
        for (coefficient, terms) in &self.models {
            for (index, term) in terms.iter().enumerate() {
                if terms[..index].contains(term) {
                    return Err(ModelError::RepeatedTerm { coefficient: coefficient.name(), term: term.to_string() });
                }
            }
        }
        Ok(())
    }

    /// Constant and linear terms for the longitudinal and the lateral coefficients of body axes.
    fn symmetric_and_lateral(longitudinal: &[Variable], lateral: &[Variable]) -> Self {
        let models = Coefficient::ALL[..6].iter().map(|&coefficient| {
            let variables = if LATERAL.contains(&coefficient) { lateral } else { longitudinal };
            (coefficient, Self::terms_with_constant(variables))
        });
        Self { models: models.collect() }
    }

    fn terms_with_constant(variables: &[Variable]) -> Vec<Term> {
        let mut terms = vec![Term::constant()];
        terms.extend(variables.iter().map(|&variable| Term::from(variable)));
        terms
    }

    /// Adds `term` to the given coefficients.
    fn extend(&mut self, coefficients: &[Coefficient], term: &Term) {
        for (coefficient, terms) in &mut self.models {
            if coefficients.contains(coefficient) {
                terms.push(term.clone());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_match_thesis_equations() {
        let thesis = Structure::thesis();
        assert_eq!(thesis.derivative_names(Coefficient::Cm), ["Cm_0", "Cm_alpha", "Cm_q", "Cm_delta_e"]);
        assert_eq!(
            thesis.derivative_names(Coefficient::Cn),
            ["Cn_0", "Cn_beta", "Cn_p", "Cn_r", "Cn_delta_a", "Cn_delta_r"]
        );
        assert_eq!(
            Structure::alternative().derivative_names(Coefficient::CX),
            ["CX_0", "CX_alpha", "CX_alpha_dot", "CX_q", "CX_delta_e"]
        );
        assert_eq!(Structure::quadratic().derivative_names(Coefficient::CZ).last().unwrap(), "CZ_alpha2");
        assert_eq!(Structure::with_power().derivative_names(Coefficient::CX).last().unwrap(), "CX_dpt");
        for preset in [thesis, Structure::alternative(), Structure::quadratic(), Structure::with_power()] {
            assert_eq!(preset.models.len(), 6);
            assert_eq!(preset.check(), Ok(()));
        }
    }

    #[test]
    fn structure_rejects_a_term_given_twice() {
        let terms = vec![Term::parse("alpha*beta").unwrap(), Term::parse("beta*alpha").unwrap()];
        let error = Structure { models: vec![(Coefficient::Cl, terms)] }.check().unwrap_err();
        assert_eq!(error.to_string(), "Cl has the term 'alpha*beta' twice: remove one");
    }
}
