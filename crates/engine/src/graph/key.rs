//! Content keys: equal inputs give equal keys, whatever computed them.

use std::hash::Hash;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use xxhash_rust::xxh3::{Xxh3, xxh3_128};

/// Identity of a stage's input or output by content (128 bits of a non-cryptographic hash; chance collisions are beyond reach).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(u128);

impl std::fmt::Display for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl Key {
    /// A key that no other equals.
    pub fn unique() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        KeyBuilder::new("unique").with(&NEXT.fetch_add(1, Ordering::Relaxed)).finish()
    }
}

/// Builds a [`Key`] from content.
pub struct KeyBuilder(Xxh3);

impl KeyBuilder {
    /// Starts a key of this name.
    pub fn new(name: &str) -> Self {
        Self(Xxh3::new()).with(name)
    }

    /// Adds a value, field by field.
    #[must_use]
    pub fn with(mut self, value: &(impl Hash + ?Sized)) -> Self {
        value.hash(&mut self.0);
        self
    }

    /// Adds the bits of a column.
    #[must_use]
    pub fn column(mut self, values: &[f64]) -> Self {
        self.0.update(&(values.len() as u64).to_le_bytes());
        for chunk in values.chunks(512) {
            let mut bytes = [0_u8; 4096];
            for (slot, value) in bytes.chunks_exact_mut(8).zip(chunk) {
                slot.copy_from_slice(&value.to_bits().to_le_bytes());
            }
            self.0.update(&bytes[..8 * chunk.len()]);
        }
        self
    }

    /// Adds the running program, by every byte: another build may give other results under the same version.
    #[must_use]
    pub fn program(self) -> Self {
        static PROGRAM: LazyLock<Option<u128>> = LazyLock::new(|| {
            let program = std::fs::read(std::env::current_exe().ok()?).ok()?;
            Some(xxh3_128(&program))
        });
        self.with(&(env!("CARGO_PKG_VERSION"), *PROGRAM))
    }

    pub fn finish(self) -> Key {
        Key(self.0.digest128())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn key(column: &[f64], text: &str) -> Key {
        KeyBuilder::new("test").column(column).with(text).finish()
    }

    proptest! {
        #[test]
        fn key_changes_exactly_when_an_input_does(
            column in prop::collection::vec(-1e6..1e6_f64, 1..1100), index in 0_usize..1100, text in ".{0,12}"
        ) {
            prop_assert_eq!(key(&column, &text), key(&column.clone(), &text));
            let mut other = column.clone();
            let index = index % other.len();
            other[index] = f64::from_bits(other[index].to_bits() ^ 1);
            prop_assert_ne!(key(&column, &text), key(&other, &text));
            prop_assert_ne!(key(&column, &text), key(&column, &format!("{text}x")));
        }
    }

    #[test]
    fn content_does_not_leak_across_its_delimiters() {
        let one = KeyBuilder::new("test").with("ab").with("c").finish();
        let other = KeyBuilder::new("test").with("a").with("bc").finish();
        assert_ne!(one, other);
    }
}
