//! Content keys: equal inputs give equal keys, whatever computed them.

use std::path::Path;
use std::sync::LazyLock;

use xxhash_rust::xxh3::{Xxh3, xxh3_128};

/// Identity of a stage's input or output by content (128 bits of a non-cryptographic hash; chance collisions are beyond reach).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(u128);

impl std::fmt::Display for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

/// Builds a [`Key`] from labelled content.
pub struct KeyBuilder(Xxh3);

impl KeyBuilder {
    /// Starts the key of `stage` in its `version`: raise the version when the same inputs give other results.
    pub fn new(stage: &str, version: u32) -> Self {
        let mut hasher = Xxh3::new();
        hasher.update(stage.as_bytes());
        hasher.update(&version.to_le_bytes());
        Self(hasher)
    }

    /// Adds another key.
    #[must_use]
    pub fn key(mut self, key: Key) -> Self {
        self.0.update(&key.0.to_le_bytes());
        self
    }

    /// Adds text, delimited by its length.
    #[must_use]
    pub fn text(mut self, text: &str) -> Self {
        self.0.update(&(text.len() as u64).to_le_bytes());
        self.0.update(text.as_bytes());
        self
    }

    /// Adds a value by its debug form, which for plain parameter structs is canonical: field order is fixed and floats print
    /// so that they parse back to the same bits.
    #[must_use]
    pub fn parameters(self, value: &impl std::fmt::Debug) -> Self {
        self.text(&format!("{value:?}"))
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

    /// Adds a file by path, size and time of change: reading recordings again to hash them would cost more than it saves.
    #[must_use]
    pub fn file(self, path: &Path) -> Self {
        let about = std::fs::metadata(path).ok();
        let changed = about.as_ref().and_then(|about| about.modified().ok());
        self.parameters(&(path, about.map(|about| about.len()), changed))
    }

    /// Adds the running program, by every byte: another build may give other results under the same version.
    #[must_use]
    pub fn program(self) -> Self {
        static PROGRAM: LazyLock<Option<u128>> = LazyLock::new(|| {
            let program = std::fs::read(std::env::current_exe().ok()?).ok()?;
            Some(xxh3_128(&program))
        });
        self.parameters(&(env!("CARGO_PKG_VERSION"), *PROGRAM))
    }

    /// The key.
    pub fn finish(self) -> Key {
        Key(self.0.digest128())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn key(column: &[f64], text: &str) -> Key {
        KeyBuilder::new("test", 1).column(column).text(text).finish()
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
        let one = KeyBuilder::new("test", 1).text("ab").text("c").finish();
        let other = KeyBuilder::new("test", 1).text("a").text("bc").finish();
        assert_ne!(one, other);
    }
}
