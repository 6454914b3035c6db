//! Enums whose variants have a name, a dimension and a description.

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
    };
}

pub(crate) use named_quantities;
