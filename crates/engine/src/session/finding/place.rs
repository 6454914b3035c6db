//! What a finding is about.

use std::fmt;

use serde::{Serialize, Serializer};

/// The object of a finding.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// A flight, or one of its channels or clocks: `flight 'demo', az`.
    Flight {
        name: String,
        /// The channel or clock.
        part: Option<String>,
    },
    /// A manoeuvre, or one of its channels: `manoeuvre '03 elevator', alpha`.
    Manoeuvre {
        name: String,
        /// The channel.
        part: Option<String>,
    },
    /// A coefficient or derivative: `Cm_q (pooled)` or `Cm_q (manoeuvre '03 elevator')`.
    Derivative {
        name: String,
        /// The manoeuvre it was estimated from; none of the pooled estimate.
        manoeuvre: Option<String>,
    },
    /// Anything else, such as `session`, `gyros`, the key of a setting or the path of a file.
    Named(String),
}

impl Place {
    pub fn flight(name: &str) -> Self {
        Self::Flight { name: name.to_owned(), part: None }
    }

    /// A channel or clock of a flight.
    pub fn in_flight(name: &str, part: impl Into<String>) -> Self {
        Self::Flight { name: name.to_owned(), part: Some(part.into()) }
    }

    pub fn manoeuvre(name: &str) -> Self {
        Self::Manoeuvre { name: name.to_owned(), part: None }
    }

    /// A channel or method in a manoeuvre.
    pub fn in_manoeuvre(name: &str, part: impl Into<String>) -> Self {
        Self::Manoeuvre { name: name.to_owned(), part: Some(part.into()) }
    }

    /// A coefficient or derivative of the pooled estimate, or of that of a manoeuvre.
    pub fn derivative(name: &str, manoeuvre: Option<&str>) -> Self {
        Self::Derivative { name: name.to_owned(), manoeuvre: manoeuvre.map(str::to_owned) }
    }

    /// The coefficient or derivative of the pooled estimate that it is.
    pub fn pooled(&self) -> Option<&str> {
        match self {
            Self::Derivative { name, manoeuvre: None } => Some(name),
            _ => None,
        }
    }

    /// The manoeuvre that it is, is in or was estimated from.
    pub fn manoeuvre_name(&self) -> Option<&str> {
        match self {
            Self::Manoeuvre { name, .. } | Self::Derivative { manoeuvre: Some(name), .. } => Some(name),
            _ => None,
        }
    }

    /// Whether it is called `name`, without a flight, manoeuvre or estimate.
    pub fn is_named(&self, name: &str) -> bool {
        matches!(self, Self::Named(own) if own == name)
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flight { name, part: None } => write!(f, "flight '{name}'"),
            Self::Flight { name, part: Some(part) } => write!(f, "flight '{name}', {part}"),
            Self::Manoeuvre { name, part: None } => write!(f, "manoeuvre '{name}'"),
            Self::Manoeuvre { name, part: Some(part) } => write!(f, "manoeuvre '{name}', {part}"),
            Self::Derivative { name, manoeuvre: None } => write!(f, "{name} (pooled)"),
            Self::Derivative { name, manoeuvre: Some(manoeuvre) } => write!(f, "{name} (manoeuvre '{manoeuvre}')"),
            Self::Named(name) => f.write_str(name),
        }
    }
}

impl From<&str> for Place {
    fn from(name: &str) -> Self {
        Self::Named(name.to_owned())
    }
}

impl From<String> for Place {
    fn from(name: String) -> Self {
        Self::Named(name)
    }
}

impl From<&Place> for Place {
    fn from(place: &Place) -> Self {
        place.clone()
    }
}

impl Serialize for Place {
    /// As it is written.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
