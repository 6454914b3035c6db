//! Channels by expression: text to a short program of operations, and what it makes of samples.
//!
//! The language has numbers, roles, channels by name, `+ - * / ^`, brackets, a few functions and two constants. It has no
//! assignment, no loop and no text, so a program ends after as many operations as it has, at most [`LONGEST`].

use std::f64::consts::{PI, TAU};

use thiserror::Error;

use super::stretches;
use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::quantity::Role;
use crate::series::{Series, gap_threshold_s};

/// Longest text of an expression, bytes.
pub const LONGEST: usize = 1000;
/// Deepest nesting of brackets, signs and powers.
const DEEPEST: usize = 50;

/// What a function makes of one value.
type OfOne = fn(f64) -> f64;
/// What a function or an operator makes of two values.
type OfTwo = fn(f64, f64) -> f64;

/// Functions of one value.
const UNARY: [(&str, OfOne); 10] = [
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sqrt", f64::sqrt),
    ("abs", f64::abs),
    ("exp", f64::exp),
    ("ln", f64::ln),
];
/// Functions of two values.
const BINARY: [(&str, OfTwo); 3] = [("atan2", f64::atan2), ("min", smaller), ("max", larger)];
/// Constants: `g0` in m/s².
const CONSTANTS: [(&str, f64); 2] = [("pi", PI), ("g0", STANDARD_GRAVITY_M_S2)];

/// The smaller of two values; no number where either is none.
fn smaller(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.min(b) }
}

/// The larger of two values; no number where either is none.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// What is wrong with an expression. Positions count characters from 1.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum ExpressionError {
    #[error("the expression has {bytes} bytes: write at most {LONGEST}")]
    TooLong { bytes: usize },
    #[error("at character {position}: more than {DEEPEST} brackets, signs and powers within each other: split it")]
    TooDeep { position: usize },
    /// Something else should stand here.
    #[error("at character {position}: {found} where {expected} should be")]
    Unexpected { position: usize, found: String, expected: &'static str },
    /// Neither a role, nor a constant, nor a function.
    #[error("at character {position}: no {kind} is called '{name}': {hint}")]
    Unknown { position: usize, kind: &'static str, name: String, hint: String },
    /// A function of another number of values.
    #[error("at character {position}: {function} takes {needed}, not {found}")]
    Arguments { position: usize, function: &'static str, needed: usize, found: usize },
    #[error("it names no channel, so it has no samples: name a role, or a channel in quotes")]
    NoChannel,
}

/// What an expression takes its samples from.
#[derive(Clone, Debug, PartialEq)]
pub enum Operand {
    /// The channel that plays a role, SI.
    Role(Role),
    /// A channel by `source/name`, or by its name where only one is called so; in the unit it is listed in.
    Channel(String),
}

/// One operation on a stack of values.
#[derive(Clone, Copy, Debug)]
enum Operation {
    Number(f64),
    Operand(usize),
    Negate,
    One(OfOne),
    Two(OfTwo),
}

/// An expression that was understood.
#[derive(Clone, Debug)]
pub struct Expression {
    operations: Vec<Operation>,
    operands: Vec<(Operand, usize)>,
}

impl Expression {
    /// Understands `text`. `-x^2` is `-(x^2)`, `a^b^c` is `a^(b^c)`; channels stand in `"quotes"` or `{braces}`.
    ///
    /// # Errors
    /// [`ExpressionError`], one line with the position.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        Self::parse_with(text, None)
    }

    /// Understands `text` whose operands are `names` in the place of roles: each is an [`Operand::Channel`]. `kind` says in errors what
    /// they are. A name that is no word of letters, digits and underscores stands in quotes or braces.
    ///
    /// # Errors
    /// [`ExpressionError`], one line with the position.
    pub fn parse_names(text: &str, kind: &'static str, names: &[&str]) -> Result<Self, ExpressionError> {
        let made = Self::parse_with(text, Some((kind, names)))?;
        for (operand, position) in &made.operands {
            if let Operand::Channel(name) = operand
                && !names.contains(&name.as_str())
            {
                return Err(unknown(*position, kind, name, names.iter().copied()));
            }
        }
        Ok(made)
    }

    fn parse_with(text: &str, names: Option<(&'static str, &[&str])>) -> Result<Self, ExpressionError> {
        if text.len() > LONGEST {
            return Err(ExpressionError::TooLong { bytes: text.len() });
        }
        let made = Self { operations: Vec::new(), operands: Vec::new() };
        let mut parser = Parser { text: text.chars().collect(), at: 0, depth: 0, made, names };
        parser.expression(0)?;
        if parser.peek().is_some() {
            return Err(parser.unexpected("an operator or the end"));
        }
        if parser.made.operands.is_empty() {
            return Err(ExpressionError::NoChannel);
        }
        Ok(parser.made)
    }

    /// What it takes its samples from, in the order first named, each with its position in the text. There is at least one.
    pub fn operands(&self) -> &[(Operand, usize)] {
        &self.operands
    }

    /// Value for one sample of each operand. Not a number where it has none: `0/0`, `ln` below zero, an operand without a value.
    pub fn value(&self, operands: impl Fn(usize) -> f64, stack: &mut Vec<f64>) -> f64 {
        stack.clear();
        for operation in &self.operations {
            let mut pop = || stack.pop().unwrap_or(f64::NAN);
            let value = match *operation {
                Operation::Number(number) => number,
                Operation::Operand(index) => operands(index),
                Operation::Negate => -pop(),
                Operation::One(function) => function(pop()),
                Operation::Two(function) => {
                    let right = pop();
                    function(pop(), right)
                }
            };
            stack.push(value);
        }
        stack.pop().unwrap_or(f64::NAN)
    }
}

/// Values of a signal at `at_s` by straight lines between its own samples. No number before the first, after the last, and in
/// gaps: intervals longer than `max_gap_s`, or than a few of its own where that is `None`. Samples that are not finite do not
/// count. An angle that `wraps` (rad) goes the short way round and stays in its range, -pi to pi or 0 to 2 pi.
pub fn between_samples(series: &Series, at_s: &[f64], max_gap_s: Option<f64>, wraps: bool) -> Vec<f64> {
    let Series { time_s: time, values } = series.finite();
    let lowest = if values.iter().all(|value| *value >= 0.0) { 0.0 } else { -PI };
    let mut found = vec![f64::NAN; at_s.len()];
    for range in stretches(&time, max_gap_s.unwrap_or_else(|| gap_threshold_s(&time))) {
        let (own, values) = (&time[range.clone()], &values[range]);
        let (Some(&start_s), Some(&end_s)) = (own.first(), own.last()) else { continue };
        let first = at_s.partition_point(|&t| t < start_s);
        let mut right = 0;
        for (value, &t) in found[first..].iter_mut().zip(&at_s[first..]).take_while(|(_, t)| **t <= end_s) {
            right += own[right..].iter().take_while(|sample| **sample < t).count();
            if own[right] == t {
                *value = values[right];
                continue;
            }
            let fraction = (t - own[right - 1]) / (own[right] - own[right - 1]);
            let step = values[right] - values[right - 1];
            *value = if wraps {
                let turned = values[right - 1] + fraction * ((step + PI).rem_euclid(TAU) - PI);
                lowest + (turned - lowest).rem_euclid(TAU)
            } else {
                values[right - 1] + fraction * step
            };
        }
    }
    found
}

/// The names nearest to `name`, for the end of an error: at most three, none where all are quite different.
fn nearest_names<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let wanted: String = name.to_lowercase().chars().take(100).collect();
    let letters = wanted.chars().count();
    let likely = letters / 2 + 1;
    // What was cut short counts as near.
    let rate = |other: &str| {
        if letters > 1 && other.starts_with(&wanted) { 1 } else { strsim::levenshtein(&wanted, other) }
    };
    let mut rated: Vec<(usize, &str)> = known.map(|other| (rate(&other.to_lowercase()), other)).collect();
    rated.retain(|(count, _)| *count <= likely);
    rated.sort_by_key(|(count, _)| *count);
    rated.dedup_by(|a, b| a.1 == b.1);
    rated.into_iter().take(3).map(|(_, other)| other).collect()
}

/// Left and right strength of an operator, and what it does. A right strength below the left one groups from the right.
fn operator(sign: char) -> Option<(u8, u8, OfTwo)> {
    Some(match sign {
        '+' => (1, 2, |a, b| a + b),
        '-' => (1, 2, |a, b| a - b),
        '*' => (3, 4, |a, b| a * b),
        '/' => (3, 4, |a, b| a / b),
        '^' => (8, 7, f64::powf),
        _ => return None,
    })
}

/// Strength of a sign before a value: above products, below powers.
const SIGN: u8 = 5;

struct Parser<'n> {
    text: Vec<char>,
    at: usize,
    depth: usize,
    made: Expression,
    /// What operands are called and of which kind they are, where they are no roles.
    names: Option<(&'static str, &'n [&'n str])>,
}

/// The error of a name that is not known.
fn unknown<'a>(
    position: usize,
    kind: &'static str,
    name: &str,
    known: impl Iterator<Item = &'a str>,
) -> ExpressionError {
    let hint = did_you_mean(name, known, "no similar name found");
    ExpressionError::Unknown { position, kind, name: name.to_owned(), hint }
}

impl Parser<'_> {
    /// The next character that is no space.
    fn peek(&mut self) -> Option<char> {
        while self.text.get(self.at).is_some_and(|letter| letter.is_whitespace()) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn unexpected(&self, expected: &'static str) -> ExpressionError {
        let found = self.text.get(self.at).map_or_else(|| "the end".to_owned(), |letter| format!("{letter:?}"));
        ExpressionError::Unexpected { position: self.at + 1, found, expected }
    }

    /// Characters from here on for which `holds`.
    fn take(&mut self, holds: impl Fn(char) -> bool) -> String {
        let taken: String = self.text[self.at..].iter().take_while(|letter| holds(**letter)).collect();
        self.at += taken.chars().count();
        taken
    }

    fn push(&mut self, operation: Operation) {
        self.made.operations.push(operation);
    }

    /// A value and all operators behind it that bind at least as strongly as `least`.
    fn expression(&mut self, least: u8) -> Result<(), ExpressionError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(ExpressionError::TooDeep { position: self.at + 1 });
        }
        self.operand()?;
        while let Some((left, right, function)) = self.peek().and_then(operator) {
            if left < least {
                break;
            }
            self.at += 1;
            self.expression(right)?;
            self.push(Operation::Two(function));
        }
        self.depth -= 1;
        Ok(())
    }

    fn operand(&mut self) -> Result<(), ExpressionError> {
        match self.peek() {
            Some('(') => {
                self.at += 1;
                self.expression(0)?;
                self.close("an operator or ')'")
            }
            Some(sign @ ('-' | '+')) => {
                self.at += 1;
                self.expression(SIGN)?;
                if sign == '-' {
                    self.push(Operation::Negate);
                }
                Ok(())
            }
            Some('"') => self.channel('"', "a channel and '\"'"),
            Some('{') => self.channel('}', "a channel and '}'"),
            Some(letter) if letter.is_ascii_digit() || letter == '.' => self.number(),
            Some(letter) if letter.is_ascii_alphabetic() => self.name(),
            _ => Err(self.unexpected("a number, a role, a channel in quotes, a function or '('")),
        }
    }

    fn close(&mut self, expected: &'static str) -> Result<(), ExpressionError> {
        if self.peek() != Some(')') {
            return Err(self.unexpected(expected));
        }
        self.at += 1;
        Ok(())
    }

    fn number(&mut self) -> Result<(), ExpressionError> {
        let start = self.at;
        let mut digits = self.take(|letter| letter.is_ascii_digit() || letter == '.');
        if let Some(letter @ ('e' | 'E')) = self.text.get(self.at).copied() {
            self.at += 1;
            digits.push(letter);
            if let Some(sign @ ('+' | '-')) = self.text.get(self.at).copied() {
                self.at += 1;
                digits.push(sign);
            }
            digits += &self.take(|letter| letter.is_ascii_digit());
        }
        match digits.parse::<f64>() {
            Ok(number) if number.is_finite() => self.push(Operation::Number(number)),
            _ => {
                let (position, found) = (start + 1, format!("'{digits}'"));
                return Err(ExpressionError::Unexpected { position, found, expected: "a number" });
            }
        }
        Ok(())
    }

    /// A channel between its signs, the first of which is next.
    fn channel(&mut self, end: char, expected: &'static str) -> Result<(), ExpressionError> {
        let position = self.at + 1;
        self.at += 1;
        let name = self.take(|letter| letter != end && !letter.is_control());
        if self.text.get(self.at) != Some(&end) || name.trim().is_empty() {
            return Err(self.unexpected(expected));
        }
        self.at += 1;
        self.operate_on(Operand::Channel(name.trim().to_owned()), position);
        Ok(())
    }

    fn operate_on(&mut self, operand: Operand, position: usize) {
        let known = self.made.operands.iter().position(|(other, _)| *other == operand);
        let index = known.unwrap_or_else(|| {
            self.made.operands.push((operand, position));
            self.made.operands.len() - 1
        });
        self.push(Operation::Operand(index));
    }

    /// A function with its values, a constant or a role.
    fn name(&mut self) -> Result<(), ExpressionError> {
        let position = self.at + 1;
        let name = self.take(|letter| letter.is_ascii_alphanumeric() || letter == '_');
        if self.peek() == Some('(') {
            return self.function(&name, position);
        }
        if let Some((_, number)) = CONSTANTS.iter().find(|(known, _)| *known == name) {
            self.push(Operation::Number(*number));
            return Ok(());
        }
        if let Some((kind, names)) = self.names {
            if !names.contains(&name.as_str()) {
                return Err(unknown(position, kind, &name, names.iter().copied()));
            }
            self.operate_on(Operand::Channel(name), position);
            return Ok(());
        }
        if let Some(role) = Role::from_name(&name) {
            self.operate_on(Operand::Role(role), position);
            return Ok(());
        }
        let known = CONSTANTS.iter().map(|(known, _)| *known).chain(Role::ALL.iter().map(|role| role.name()));
        let hint = did_you_mean(&name, known, "a recorded channel is written in quotes, as in \"source/name\"");
        Err(ExpressionError::Unknown { position, kind: "role", name, hint })
    }

    fn function(&mut self, name: &str, position: usize) -> Result<(), ExpressionError> {
        let one = UNARY.iter().find(|(known, _)| *known == name);
        let two = BINARY.iter().find(|(known, _)| *known == name);
        let (function, operation, needed) = match (one, two) {
            (Some((known, function)), _) => (*known, Operation::One(*function), 1),
            (_, Some((known, function))) => (*known, Operation::Two(*function), 2),
            _ => {
                let known = || UNARY.iter().map(|(known, _)| *known).chain(BINARY.iter().map(|(known, _)| *known));
                let all = format!("use one of {}", known().collect::<Vec<_>>().join(", "));
                let hint = did_you_mean(name, known(), &all);
                return Err(ExpressionError::Unknown { position, kind: "function", name: name.to_owned(), hint });
            }
        };
        self.at += 1;
        let mut found = 1;
        self.expression(0)?;
        while self.peek() == Some(',') {
            self.at += 1;
            self.expression(0)?;
            found += 1;
        }
        self.close("an operator, ',' or ')'")?;
        if found != needed {
            return Err(ExpressionError::Arguments { position, function, needed, found });
        }
        self.push(operation);
        Ok(())
    }
}

/// The end of an error about a name that is not known: the nearest names there are, or what to do `otherwise`.
pub fn did_you_mean<'a>(name: &str, known: impl Iterator<Item = &'a str>, otherwise: &str) -> String {
    let nearest = nearest_names(name, known);
    if nearest.is_empty() { otherwise.to_owned() } else { format!("did you mean {}?", nearest.join(", ")) }
}

#[cfg(test)]
mod tests;
