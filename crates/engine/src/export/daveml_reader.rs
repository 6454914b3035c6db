//! A reader of DAVE-ML for models of variable definitions with MathML: enough to evaluate a file's own check cases.

use std::collections::HashMap;

use roxmltree::{Document, Node, ParsingOptions};
use thiserror::Error;

/// What a file can be refused for.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DaveMlError {
    /// Not XML.
    #[error("not an XML file: {0}")]
    Xml(String),
    /// An element that is not there.
    #[error("line {line}: '{element}' has no {what}")]
    Missing { line: u32, element: String, what: &'static str },
    /// A number that is none.
    #[error("line {line}: '{text}' is not a number")]
    Number { line: u32, text: String },
    #[error(
        "line {line}: '{element}' is not read: only variable definitions with MathML of plus, minus, times, divide, power, sin and cos are"
    )]
    Unknown { line: u32, element: String },
    #[error("variable '{0}' has no value: it is not defined, or defined in terms of itself")]
    Undefined(String),
}

/// Depth of nested formulas and of definitions that use each other, beyond which a file is refused.
const MAX_DEPTH: usize = 100;

/// A formula.
#[derive(Clone, Debug, PartialEq)]
enum Expression {
    Number(f64),
    Variable(String),
    Apply(Operator, Vec<Expression>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operator {
    Plus,
    Minus,
    Times,
    Divide,
    Power,
    Sin,
    Cos,
}

/// A variable: where its value comes from.
#[derive(Clone, Debug, PartialEq)]
struct Definition {
    initial: Option<f64>,
    calculation: Option<Expression>,
}

/// A check case: inputs, expected outputs and their tolerances by variable.
#[derive(Clone, Debug, PartialEq)]
struct Case {
    name: String,
    inputs: Vec<(String, f64)>,
    outputs: Vec<(String, f64, f64)>,
}

/// A model as read.
#[derive(Clone, Debug, PartialEq)]
pub struct DaveMl {
    definitions: HashMap<String, Definition>,
    cases: Vec<Case>,
}

/// One output of one check case.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckResult {
    pub case: String,
    /// Variable.
    pub signal: String,
    /// Value in the file.
    pub expected: f64,
    /// Value of the file's own formulas.
    pub found: f64,
    /// Difference allowed.
    pub tolerance: f64,
}

impl CheckResult {
    /// Whether the two agree.
    pub fn passed(&self) -> bool {
        (self.found - self.expected).abs() <= self.tolerance
    }
}

impl DaveMl {
    /// Reads a file.
    pub fn parse(text: &str) -> Result<Self, DaveMlError> {
        let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
        let document = Document::parse_with_options(text, options).map_err(|e| DaveMlError::Xml(e.to_string()))?;
        let mut definitions = HashMap::new();
        let mut by_name = HashMap::new();
        for node in elements(document.root_element()) {
            match node.tag_name().name() {
                "variableDef" => {
                    let id = attribute(node, "varID", "varID")?;
                    let initial = node.attribute("initialValue").map(|text| number(node, text)).transpose()?;
                    let formula = elements(node).find(|child| child.tag_name().name() == "calculation");
                    let calculation = formula.map(calculation).transpose()?;
                    by_name.insert(attribute(node, "name", "name")?.to_owned(), id.to_owned());
                    definitions.insert(id.to_owned(), Definition { initial, calculation });
                }
                "fileHeader" | "checkData" => {}
                other => return Err(DaveMlError::Unknown { line: line(node), element: other.to_owned() }),
            }
        }
        let shots = document.descendants().filter(|node| node.tag_name().name() == "staticShot");
        let cases = shots.map(|shot| case(shot, &by_name)).collect::<Result<_, _>>()?;
        Ok(Self { definitions, cases })
    }

    /// Value of the variable `id` for given inputs.
    pub fn evaluate(&self, id: &str, inputs: &[(String, f64)]) -> Result<f64, DaveMlError> {
        self.value(id, inputs, self.definitions.len().min(MAX_DEPTH))
    }

    /// Evaluates every output of every check case.
    pub fn check(&self) -> Result<Vec<CheckResult>, DaveMlError> {
        let mut results = Vec::new();
        for case in &self.cases {
            for (id, expected, tolerance) in &case.outputs {
                results.push(CheckResult {
                    case: case.name.clone(),
                    signal: id.clone(),
                    expected: *expected,
                    found: self.evaluate(id, &case.inputs)?,
                    tolerance: *tolerance,
                });
            }
        }
        Ok(results)
    }

    /// `depth` bounds the chain of definitions, so that a variable defined by itself ends.
    fn value(&self, id: &str, inputs: &[(String, f64)], depth: usize) -> Result<f64, DaveMlError> {
        if let Some((_, value)) = inputs.iter().find(|(name, _)| name == id) {
            return Ok(*value);
        }
        let undefined = || DaveMlError::Undefined(id.to_owned());
        let definition = self.definitions.get(id).ok_or_else(undefined)?;
        match &definition.calculation {
            Some(formula) => self.formula(formula, inputs, depth.checked_sub(1).ok_or_else(undefined)?),
            None => definition.initial.ok_or_else(undefined),
        }
    }

    fn formula(&self, formula: &Expression, inputs: &[(String, f64)], depth: usize) -> Result<f64, DaveMlError> {
        match formula {
            Expression::Number(value) => Ok(*value),
            Expression::Variable(id) => self.value(id, inputs, depth),
            Expression::Apply(operator, operands) => {
                let values: Vec<f64> =
                    operands.iter().map(|operand| self.formula(operand, inputs, depth)).collect::<Result<_, _>>()?;
                Ok(operator.apply(&values))
            }
        }
    }
}

impl Operator {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "plus" => Self::Plus,
            "minus" => Self::Minus,
            "times" => Self::Times,
            "divide" => Self::Divide,
            "power" => Self::Power,
            "sin" => Self::Sin,
            "cos" => Self::Cos,
            _ => return None,
        })
    }

    /// Smallest and largest number of operands.
    fn operands(self) -> (usize, usize) {
        match self {
            Self::Plus | Self::Times => (0, usize::MAX),
            Self::Minus => (1, 2),
            Self::Divide | Self::Power => (2, 2),
            Self::Sin | Self::Cos => (1, 1),
        }
    }

    /// The operands were counted when they were read.
    fn apply(self, values: &[f64]) -> f64 {
        match (self, values) {
            (Self::Plus, _) => values.iter().sum(),
            (Self::Times, _) => values.iter().product(),
            (Self::Minus, [a]) => -a,
            (Self::Minus, [a, b]) => a - b,
            (Self::Divide, [a, b]) => a / b,
            (Self::Power, [a, b]) => a.powf(*b),
            (Self::Sin, [a]) => a.sin(),
            (Self::Cos, [a]) => a.cos(),
            _ => f64::NAN,
        }
    }
}

fn elements<'a, 'input>(node: Node<'a, 'input>) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(Node::is_element)
}

fn line(node: Node<'_, '_>) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

fn attribute<'a>(node: Node<'a, '_>, name: &str, what: &'static str) -> Result<&'a str, DaveMlError> {
    let element = || node.tag_name().name().to_owned();
    node.attribute(name).ok_or_else(|| DaveMlError::Missing { line: line(node), element: element(), what })
}

fn number(node: Node<'_, '_>, text: &str) -> Result<f64, DaveMlError> {
    let bad = || DaveMlError::Number { line: line(node), text: text.trim().to_owned() };
    text.trim().parse().map_err(|_| bad())
}

fn calculation(node: Node<'_, '_>) -> Result<Expression, DaveMlError> {
    let missing = || DaveMlError::Missing { line: line(node), element: "calculation".to_owned(), what: "MathML" };
    let math = elements(node).find(|child| child.tag_name().name() == "math").ok_or_else(missing)?;
    expression(elements(math).next().ok_or_else(missing)?, MAX_DEPTH)
}

fn expression(node: Node<'_, '_>, depth: usize) -> Result<Expression, DaveMlError> {
    let text = node.text().unwrap_or_default();
    let unknown =
        |node: Node<'_, '_>| DaveMlError::Unknown { line: line(node), element: node.tag_name().name().to_owned() };
    let inner = depth.checked_sub(1).ok_or_else(|| unknown(node))?;
    match node.tag_name().name() {
        "cn" => Ok(Expression::Number(number(node, text)?)),
        "ci" => Ok(Expression::Variable(text.trim().to_owned())),
        "apply" => {
            let mut parts = elements(node);
            let missing = |what| DaveMlError::Missing { line: line(node), element: "apply".to_owned(), what };
            let name = parts.next().ok_or_else(|| missing("operator"))?;
            let operator = Operator::from_name(name.tag_name().name()).ok_or_else(|| unknown(name))?;
            let operands = parts.map(|part| expression(part, inner)).collect::<Result<Vec<_>, _>>()?;
            let (least, most) = operator.operands();
            if !(least..=most).contains(&operands.len()) {
                return Err(missing("right number of operands"));
            }
            Ok(Expression::Apply(operator, operands))
        }
        _ => Err(unknown(node)),
    }
}

/// A check case; its signals go by the names of variables.
fn case(shot: Node<'_, '_>, by_name: &HashMap<String, String>) -> Result<Case, DaveMlError> {
    let inputs = signals(shot, "checkInputs", by_name)?.into_iter().map(|(id, value, _)| (id, value)).collect();
    Ok(Case {
        name: attribute(shot, "name", "name")?.to_owned(),
        inputs,
        outputs: signals(shot, "checkOutputs", by_name)?,
    })
}

fn signals(
    shot: Node<'_, '_>,
    element: &'static str,
    by_name: &HashMap<String, String>,
) -> Result<Vec<(String, f64, f64)>, DaveMlError> {
    let part = elements(shot).find(|child| child.tag_name().name() == element);
    let signals = part.into_iter().flat_map(elements).filter(|node| node.tag_name().name() == "signal");
    signals.map(|node| signal(node, by_name)).collect()
}

fn signal(signal: Node<'_, '_>, by_name: &HashMap<String, String>) -> Result<(String, f64, f64), DaveMlError> {
    let text = |name: &'static str| {
        let child = elements(signal).find(|child| child.tag_name().name() == name);
        child.and_then(|child| child.text()).map(str::trim)
    };
    let missing = |what| DaveMlError::Missing { line: line(signal), element: "signal".to_owned(), what };
    let name = text("signalName").ok_or_else(|| missing("signalName"))?;
    let id = by_name.get(name).ok_or_else(|| DaveMlError::Undefined(name.to_owned()))?;
    let value = number(signal, text("signalValue").ok_or_else(|| missing("signalValue"))?)?;
    let tolerance = text("tol").map_or(Ok(0.0), |text| number(signal, text))?;
    Ok((id.clone(), value, tolerance))
}
