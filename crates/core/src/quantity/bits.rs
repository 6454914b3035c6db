//! Hashes of settings that hold floating-point numbers.

use std::collections::BTreeMap;
use std::hash::{Hash, Hasher};

/// A value hashed by the bits of its floating-point numbers: 0.0 and -0.0 differ, a NaN equals itself.
pub trait HashBits {
    /// Feeds the value into `state`.
    fn hash_bits<H: Hasher>(&self, state: &mut H);
}

impl HashBits for f64 {
    fn hash_bits<H: Hasher>(&self, state: &mut H) {
        self.to_bits().hash(state);
    }
}

impl<T: HashBits, const N: usize> HashBits for [T; N] {
    fn hash_bits<H: Hasher>(&self, state: &mut H) {
        self.iter().for_each(|value| value.hash_bits(state));
    }
}

impl<T: HashBits> HashBits for Option<T> {
    fn hash_bits<H: Hasher>(&self, state: &mut H) {
        self.is_some().hash(state);
        self.iter().for_each(|value| value.hash_bits(state));
    }
}

impl<K: Hash, V: HashBits> HashBits for BTreeMap<K, V> {
    fn hash_bits<H: Hasher>(&self, state: &mut H) {
        self.len().hash(state);
        self.iter().for_each(|(key, value)| {
            key.hash(state);
            value.hash_bits(state);
        });
    }
}

/// Implements [`Hash`] for a struct, field by field: those behind the semicolon are floating-point numbers and hashed by
/// [`HashBits`]. A field that is not named does not compile.
#[macro_export]
macro_rules! hash_fields {
    ($type:ty { $($field:ident),*; $($number:ident),* }) => {
        impl std::hash::Hash for $type {
            fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
                let Self { $($field,)* $($number),* } = self;
                $(std::hash::Hash::hash($field, state);)*
                $($crate::quantity::HashBits::hash_bits($number, state);)*
            }
        }
    };
}
