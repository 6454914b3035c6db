//! Enums whose variants have a name, a dimension and a description.

use std::fmt;

use serde::Deserializer;
use serde::de::{DeserializeSeed, EnumAccess, Error, VariantAccess, Visitor};

/// Index among `names` of the name that is read; to the reader `set` is an enum of these names, hence in schemas too.
///
/// # Errors
/// That of the reader for a name that is not among them.
pub(crate) fn deserialize_name<'de, D: Deserializer<'de>>(
    deserializer: D,
    set: &'static str,
    names: &'static [&'static str],
) -> Result<usize, D::Error> {
    deserializer.deserialize_enum(set, names, OneOf(names))
}

#[derive(Clone, Copy)]
struct OneOf(&'static [&'static str]);

impl<'de> DeserializeSeed<'de> for OneOf {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl<'de> Visitor<'de> for OneOf {
    type Value = usize;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "one of {}", self.0.join(", "))
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<usize, E> {
        self.0.iter().position(|known| *known == name).ok_or_else(|| E::unknown_variant(name, self.0))
    }

    fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<usize, A::Error> {
        let (index, variant) = data.variant_seed(self)?;
        variant.unit_variant()?;
        Ok(index)
    }
}

/// Declares inside the `impl` of an enum its `ALL`, in the order of the table, and a text of each variant; where that is its `name`,
/// `from_name` too: `named_variants! { pub name: First "first", Second "second" }`.
#[macro_export]
macro_rules! named_variants {
    ($(#[$doc:meta])* pub name: $($variant:ident $text:literal),* $(,)?) => {
        $crate::named_variants! { $(#[$doc])* (pub) name: $($variant $text),* }

        /// The one called `name`.
        pub fn from_name(name: &str) -> Option<Self> { Self::ALL.into_iter().find(|one| one.name() == name) }
    };
    ($(#[$doc:meta])* ($vis:vis) $text_of:ident: $($variant:ident $text:literal),*) => {
        /// All of them, in their order.
        pub const ALL: [Self; [$($text),*].len()] = [$(Self::$variant),*];
        $crate::variant_texts! { $(#[$doc])* $vis $text_of: $($variant $text),* }
    };
    ($(#[$doc:meta])* $vis:vis $text_of:ident: $($variant:ident $text:literal),* $(,)?) => {
        $crate::named_variants! { $(#[$doc])* ($vis) $text_of: $($variant $text),* }
    };
}

/// Declares inside the `impl` of an enum a text of each variant: `variant_texts! { pub unit: Speed "m/s", Angle "rad" }`.
#[macro_export]
macro_rules! variant_texts {
    ($(#[$doc:meta])* $vis:vis $text_of:ident: $($variant:ident $text:literal),* $(,)?) => {
        $(#[$doc])*
        $vis fn $text_of(self) -> &'static str { match self { $(Self::$variant => $text),* } }
    };
}

/// Declares an enum of quantities from a table `Variant, "name", Dimension, "description";`, with `ALL`, `name`, `dimension`,
/// `description` and `from_name`.
macro_rules! named_quantities {
    ($(#[$doc:meta])* $set:ident; $($variant:ident, $name:literal, $dimension:ident, $text:literal;)*) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(usize)]
        pub enum $set { $(#[doc = $text] $variant,)* }

        impl $set {
            /// All of them, in order of their index.
            pub const ALL: [Self; [$($name,)*].len()] = [$(Self::$variant,)*];

            /// Name in channel maps, tables and files.
            pub fn name(self) -> &'static str { match self { $(Self::$variant => $name,)* } }

            /// Dimension of the values, hence their SI unit.
            pub fn dimension(self) -> $crate::quantity::Dimension {
                match self { $(Self::$variant => $crate::quantity::Dimension::$dimension,)* }
            }

            /// One-line description.
            pub fn description(self) -> &'static str { match self { $(Self::$variant => $text,)* } }

            /// The one called `name`.
            pub fn from_name(name: &str) -> Option<Self> { Self::ALL.into_iter().find(|item| item.name() == name) }
        }

        impl serde::Serialize for $set {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> serde::Deserialize<'de> for $set {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                const NAMES: &[&str] = &[$($name,)*];
                let name = $crate::quantity::deserialize_name(deserializer, stringify!($set), NAMES)?;
                Ok(Self::ALL[name])
            }
        }
    };
}

pub(crate) use named_quantities;
