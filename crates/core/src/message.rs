//! Sentences that keep their numbers and names apart until they are written, so that sentences of one kind can be joined.

use std::borrow::Cow;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};

/// A sentence: fixed words, numbers and names in their order.
#[derive(Clone, Default, PartialEq)]
pub struct Message {
    parts: Vec<Part>,
}

/// A part of a [`Message`].
#[derive(Clone, Debug)]
pub enum Part {
    /// Words that a sentence of the same kind has as well.
    Words(Cow<'static, str>),
    /// A number and how it is written.
    Number(f64, String),
    /// A name, written in quotes.
    Name(String),
    /// A file, by the path it was read from.
    File(PathBuf),
    /// Words that differ between sentences of one kind.
    Detail(String),
}

impl PartialEq for Part {
    /// Whether both are of one kind and written alike.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Words(a), Self::Words(b)) => a == b,
            (Self::Number(_, a), Self::Number(_, b))
            | (Self::Name(a), Self::Name(b))
            | (Self::Detail(a), Self::Detail(b)) => a == b,
            (Self::File(a), Self::File(b)) => a == b,
            _ => false,
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Words(words) => f.write_str(words),
            Self::Number(_, text) | Self::Detail(text) => f.write_str(text),
            Self::Name(name) => write!(f, "'{name}'"),
            Self::File(path) => write!(f, "{}", path.display()),
        }
    }
}

/// What fills a hole `{}` of a template: a number is written by the format of the hole, `{:.2}` or `{:+.2}`.
#[derive(Clone, Debug)]
pub enum Value {
    /// A number.
    Number(f64),
    /// What has its written form already.
    Parts(Vec<Part>),
}

/// A number whose written form is not one of a format, such as one of two significant digits.
pub fn written(value: f64, text: String) -> Value {
    Value::Parts(vec![Part::Number(value, text)])
}

/// A name in quotes.
pub fn quoted(name: impl AsRef<str>) -> Value {
    Value::Parts(vec![Part::Name(name.as_ref().to_owned())])
}

/// A file that was read.
pub fn file(path: &Path) -> Value {
    Value::Parts(vec![Part::File(path.to_owned())])
}

/// Words that differ between sentences of one kind.
pub fn detail(words: &str) -> Value {
    Value::Parts(vec![Part::Detail(words.to_owned())])
}

macro_rules! numbers {
    ($($kind:ty),*) => { $(
        impl From<$kind> for Value {
            fn from(value: $kind) -> Self {
                Self::Number(value as f64)
            }
        }
    )* };
}

numbers!(f64, usize, u64, u32, i64, i32);

impl From<&str> for Value {
    fn from(words: &str) -> Self {
        words.to_owned().into()
    }
}

impl From<&String> for Value {
    fn from(words: &String) -> Self {
        words.clone().into()
    }
}

impl From<String> for Value {
    fn from(words: String) -> Self {
        Self::Parts(vec![Part::Words(words.into())])
    }
}

impl From<Message> for Value {
    fn from(message: Message) -> Self {
        Self::Parts(message.parts)
    }
}

impl From<&Message> for Value {
    fn from(message: &Message) -> Self {
        message.clone().into()
    }
}

/// A [`Message`] from a template and the values of its holes: `message!("{} is stuck for {:.1} s", name, length_s)`. A hole is `{}`,
/// `{:.2}` or `{:+.2}`; text is a word of the sentence, [`quoted`] a name that differs between sentences of one kind.
#[macro_export]
macro_rules! message {
    ($template:literal $(, $value:expr)* $(,)?) => {{
        const { assert!($crate::message::count_holes($template) == 0 $(+ { let _ = stringify!($value); 1 })*) };
        $crate::message::Message::fill($template, vec![$($crate::message::Value::from($value)),*])
    }};
}

/// Number of holes of a template.
///
/// # Panics
/// When a hole is none of `{}`, `{:.2}` and `{:+.2}` with one digit.
pub const fn count_holes(template: &str) -> usize {
    let bytes = template.as_bytes();
    let (mut at, mut holes) = (0, 0);
    while at < bytes.len() {
        if bytes[at] == b'{' {
            at += 1;
            if bytes[at] == b':' {
                at += if bytes[at + 1] == b'+' { 2 } else { 1 };
                assert!(bytes[at] == b'.' && bytes[at + 1].is_ascii_digit(), "a hole has decimals");
                at += 2;
            }
            assert!(bytes[at] == b'}', "a hole ends behind its format");
            holes += 1;
        }
        at += 1;
    }
    holes
}

impl Message {
    /// Fills the holes of a template; [`message!`](crate::message!) checks their number.
    pub fn fill(template: &'static str, values: Vec<Value>) -> Self {
        let (mut parts, mut rest) = (Vec::with_capacity(2 * values.len() + 1), template);
        for value in values {
            let Some((words, (format, behind))) =
                rest.split_once('{').and_then(|(words, hole)| Some((words, hole.split_once('}')?)))
            else {
                break;
            };
            if !words.is_empty() {
                parts.push(Part::Words(words.into()));
            }
            match value {
                Value::Number(value) => parts.push(Part::Number(value, write_number(value, format))),
                Value::Parts(own) => parts.extend(own),
            }
            rest = behind;
        }
        if !rest.is_empty() {
            parts.push(Part::Words(rest.into()));
        }
        Self { parts }
    }

    /// Messages one behind the other with words between them.
    pub fn join(messages: impl IntoIterator<Item = Self>, between: &'static str) -> Self {
        let mut parts = Vec::new();
        for message in messages {
            if !parts.is_empty() {
                parts.push(Part::Words(between.into()));
            }
            parts.extend(message.parts);
        }
        Self { parts }
    }

    /// Its parts in their order.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Whether two messages differ only in their numbers, names, files and details.
    pub fn is_alike(&self, other: &Self) -> bool {
        let is_alike = |(own, other): (&Part, &Part)| match (own, other) {
            (Part::Words(own), Part::Words(other)) => own == other,
            _ => std::mem::discriminant(own) == std::mem::discriminant(other),
        };
        self.parts.len() == other.parts.len() && self.parts.iter().zip(&other.parts).all(is_alike)
    }
}

/// A number by the format of a hole: `:.2`, `:+.2` or none.
fn write_number(value: f64, format: &str) -> String {
    let decimals = format.bytes().last().map(|digit| usize::from(digit.saturating_sub(b'0')));
    match decimals {
        Some(decimals) if format.contains('+') => format!("{value:+.decimals$}"),
        Some(decimals) => format!("{value:.decimals$}"),
        None => value.to_string(),
    }
}

impl From<&str> for Message {
    fn from(words: &str) -> Self {
        words.to_owned().into()
    }
}

impl From<String> for Message {
    fn from(words: String) -> Self {
        Self { parts: vec![Part::Words(words.into())] }
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.parts.iter().try_for_each(|part| part.fmt(f))
    }
}

impl fmt::Debug for Message {
    /// The sentence as it is written.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.to_string())
    }
}

impl Hash for Message {
    /// By the sentence as it is written.
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.to_string().hash(state);
    }
}

impl Serialize for Message {
    /// The sentence as it is written.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_by_their_holes_and_names_in_quotes() {
        let pause =
            |name: &str, length_s: f64| message!("{} pauses for {:.2} s in {}", "alpha", length_s, quoted(name));
        assert_eq!(pause("a", 0.8).to_string(), "alpha pauses for 0.80 s in 'a'");
        assert_eq!(
            message!("off by {:+.1} m after {} of {} rows", 2.04, 3_usize, 7_usize).to_string(),
            "off by +2.0 m after 3 of 7 rows"
        );
        assert!(pause("a", 0.8).is_alike(&pause("b", 1.9)));
        assert!(!pause("a", 0.8).is_alike(&message!("{} pauses for {:.2} s in {}", "beta", 0.8, quoted("a"))));
        let both = Message::join([message!("{} left", 1.5), message!("{} right", 2.5)], " and ");
        assert_eq!(message!("{}: {}", file(Path::new("a.csv")), both).to_string(), "a.csv: 1.5 left and 2.5 right");
    }
}
