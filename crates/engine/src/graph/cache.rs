//! A bounded store of stage outputs by key, the least recently used leaving first.

use std::any::Any;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::Key;

/// Size in memory of a stage output, for the bound of the cache.
pub trait Footprint: Any + Send + Sync {
    /// Bytes held, to within a small factor.
    fn bytes(&self) -> usize;
}

struct Entry {
    value: Arc<dyn Any + Send + Sync>,
    bytes: usize,
    used: u64,
}

#[derive(Default)]
struct Store {
    entries: HashMap<Key, Entry>,
    bytes: usize,
    clock: u64,
}

/// Stage outputs of several generations, so that an undo is instant.
pub struct Cache {
    store: Mutex<Store>,
    limit_bytes: usize,
}

impl Cache {
    /// An empty cache that holds about `limit_bytes`.
    pub fn new(limit_bytes: usize) -> Self {
        Self { store: Mutex::new(Store::default()), limit_bytes }
    }

    /// The output stored under `key`, if it is there and of type `T`.
    pub fn get<T: Footprint>(&self, key: Key) -> Option<Arc<T>> {
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        store.clock += 1;
        let now = store.clock;
        let entry = store.entries.get_mut(&key)?;
        entry.used = now;
        Arc::clone(&entry.value).downcast().ok()
    }

    /// The output stored under `key`, or else what `make` gives, stored.
    ///
    /// # Errors
    /// That of `make`.
    pub fn get_or_try<T: Footprint, E>(&self, key: Key, make: impl FnOnce() -> Result<T, E>) -> Result<Arc<T>, E> {
        match self.get(key) {
            Some(value) => Ok(value),
            None => Ok(self.insert(key, make()?)),
        }
    }

    /// Stores an output and returns it shared.
    pub fn insert<T: Footprint>(&self, key: Key, value: T) -> Arc<T> {
        let bytes = value.bytes();
        let value = Arc::new(value);
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        store.clock += 1;
        let entry = Entry { value: Arc::clone(&value) as Arc<dyn Any + Send + Sync>, bytes, used: store.clock };
        store.bytes += bytes;
        if let Some(old) = store.entries.insert(key, entry) {
            store.bytes -= old.bytes;
        }
        while store.bytes > self.limit_bytes && store.entries.len() > 1 {
            let Some(oldest) = store.entries.iter().min_by_key(|(_, entry)| entry.used).map(|(&key, _)| key) else {
                break;
            };
            if oldest == key {
                break;
            }
            if let Some(gone) = store.entries.remove(&oldest) {
                store.bytes -= gone.bytes;
            }
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::KeyBuilder;

    impl Footprint for Vec<u8> {
        fn bytes(&self) -> usize {
            self.len()
        }
    }

    #[test]
    fn least_recently_used_leaves_first() {
        let cache = Cache::new(250);
        let keys = [1, 2, 3].map(|index| KeyBuilder::new("test", index).finish());
        cache.insert(keys[0], vec![0_u8; 100]);
        cache.insert(keys[1], vec![1_u8; 100]);
        assert!(cache.get::<Vec<u8>>(keys[0]).is_some());
        cache.insert(keys[2], vec![2_u8; 100]);
        assert!(cache.get::<Vec<u8>>(keys[1]).is_none());
        assert_eq!(*cache.get::<Vec<u8>>(keys[0]).unwrap(), vec![0_u8; 100]);
    }
}
