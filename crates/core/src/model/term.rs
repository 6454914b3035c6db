//! Terms: products of integer powers of variables.

use std::fmt;

use super::{Coefficient, ModelError, Variable};

/// A regressor: a product of integer powers of [`Variable`]s. The empty product is the constant 1.
///
/// Two terms are equal when they are the same product, however they were written.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Term {
    /// Variable and power, in the order of [`Variable::ALL`]; no power is zero, no variable appears twice.
    factors: Vec<(Variable, i32)>,
}

impl Term {
    /// The constant 1.
    pub fn constant() -> Self {
        Self::default()
    }

    /// The product of the given powers; repeated variables are merged, zero powers dropped.
    pub fn product(factors: impl IntoIterator<Item = (Variable, i32)>) -> Self {
        let mut merged = std::collections::BTreeMap::new();
        for (variable, power) in factors {
            *merged.entry(variable).or_insert(0) += power;
        }
        Self { factors: merged.into_iter().filter(|&(_, power)| power != 0).collect() }
    }

    /// Variables of the product with their powers.
    pub fn factors(&self) -> &[(Variable, i32)] {
        &self.factors
    }

    /// True for the constant 1.
    pub fn is_constant(&self) -> bool {
        self.factors.is_empty()
    }

    /// Reads a term such as `1`, `alpha`, `alpha^2*delta_e` or `qc/V`. Variables go by their name in terms or by their
    /// suffix in derivative names.
    ///
    /// # Errors
    /// [`ModelError::UnknownVariable`] lists the variables there are; [`ModelError::BadPower`] for a power that is not
    /// an integer.
    pub fn parse(text: &str) -> Result<Self, ModelError> {
        let compact: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        if compact == "1" {
            return Ok(Self::constant());
        }
        let mut factors = Vec::new();
        let mut rest = compact.as_str();
        loop {
            let (variable, after) = leading_variable(rest).ok_or_else(|| ModelError::UnknownVariable {
                term: text.to_owned(),
                rest: rest.to_owned(),
                known: Variable::ALL.iter().map(|variable| variable.name()).collect(),
            })?;
            let (power, after) = leading_power(after, text)?;
            factors.push((variable, power));
            match after.strip_prefix('*') {
                Some(next) => rest = next,
                None => return Ok(Self::product(factors)),
            }
        }
    }

    /// Name of the derivative of `coefficient` with respect to this term: `CX_0`, `Cm_q`, `CX_alpha2`,
    /// `Cm_alpha2_delta_e`.
    pub fn derivative_name(&self, coefficient: Coefficient) -> String {
        let mut name = coefficient.name().to_owned();
        if self.is_constant() {
            name.push_str("_0");
        }
        for &(variable, power) in &self.factors {
            name.push('_');
            name.push_str(variable.suffix());
            if power != 1 {
                name.push_str(&power.to_string());
            }
        }
        name
    }

    /// Value of the term from the values of its variables.
    pub fn value(&self, of: impl Fn(Variable) -> f64) -> f64 {
        self.factors.iter().map(|&(variable, power)| of(variable).powi(power)).product()
    }
}

impl From<Variable> for Term {
    fn from(variable: Variable) -> Self {
        Self { factors: vec![(variable, 1)] }
    }
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_constant() {
            return f.write_str("1");
        }
        for (index, &(variable, power)) in self.factors.iter().enumerate() {
            if index > 0 {
                f.write_str("*")?;
            }
            f.write_str(variable.name())?;
            if power != 1 {
                write!(f, "^{power}")?;
            }
        }
        Ok(())
    }
}

impl std::str::FromStr for Term {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        Self::parse(text)
    }
}

/// The variable `text` begins with and what follows it; the longest name wins, and a name ends where a power, a
/// product or the text does.
fn leading_variable(text: &str) -> Option<(Variable, &str)> {
    Variable::ALL
        .iter()
        .flat_map(|&variable| [(variable, variable.name()), (variable, variable.suffix())])
        .chain([(Variable::PropellerPressure, "dp_t/q")])
        .filter_map(|(variable, name)| text.strip_prefix(name).map(|rest| (variable, rest)))
        .filter(|(_, rest)| rest.is_empty() || rest.starts_with(['*', '^']))
        .min_by_key(|(_, rest)| rest.len())
}

/// The power after a variable (1 where none is written) and what follows it.
fn leading_power<'a>(rest: &'a str, term: &str) -> Result<(i32, &'a str), ModelError> {
    let Some(digits) = rest.strip_prefix('^') else { return Ok((1, rest)) };
    let end = digits.find('*').unwrap_or(digits.len());
    let power = digits[..end]
        .parse()
        .map_err(|_| ModelError::BadPower { term: term.to_owned(), power: digits[..end].to_owned() })?;
    Ok((power, &digits[end..]))
}

/// Whether a parameter is a constant by its name: `CZ_0`, or `CZ_0[window]` of one window.
pub fn is_constant_name(name: &str) -> bool {
    name.ends_with("_0") || name.ends_with(']')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn term_of_any_variable_pair_roundtrips() {
        for &first in Variable::ALL {
            for &second in Variable::ALL {
                for power in [-1, 1, 2, 3] {
                    let term = Term::product([(first, 1), (second, power)]);
                    assert_eq!(Term::parse(&term.to_string()), Ok(term));
                }
            }
        }
    }

    #[test]
    fn term_is_one_product_however_it_is_written() {
        let term = Term::parse(" delta_e * alpha ^ 2 ").unwrap();
        assert_eq!(term, Term::parse("alpha*delta_e*alpha").unwrap());
        assert_eq!(term.to_string(), "alpha^2*delta_e");
        assert_eq!(term.derivative_name(Coefficient::Cm), "Cm_alpha2_delta_e");
        assert_eq!(Term::parse("q").unwrap(), Term::parse("qc/V").unwrap());
        assert_eq!(Term::parse("alpha_dot").unwrap(), Term::parse("alpha_dot*c/V").unwrap());
        assert_eq!(Term::parse("qc/V").unwrap().derivative_name(Coefficient::Cm), "Cm_q");
        assert_eq!(Term::parse("alpha^2").unwrap().derivative_name(Coefficient::CX), "CX_alpha2");
        assert_eq!(Term::parse("1").unwrap().derivative_name(Coefficient::CX), "CX_0");
        assert_eq!(["CX_0", "CX_0[w]", "CX_alpha2"].map(super::is_constant_name), [true, true, false]);
        assert_eq!(Term::parse("alpha^0").unwrap(), Term::constant());
    }

    #[test]
    fn term_rejects_unknown_variable_and_lists_the_known() {
        let message = Term::parse("alpha*gamma").unwrap_err().to_string();
        assert!(message.contains("'gamma'") && message.contains("delta_e") && message.contains("qc/V"), "{message}");
        assert!(matches!(Term::parse(""), Err(ModelError::UnknownVariable { .. })));
        assert!(matches!(Term::parse("alpha^x"), Err(ModelError::BadPower { .. })));
        assert!(matches!(Term::parse("alphabet"), Err(ModelError::UnknownVariable { .. })));
    }
}
