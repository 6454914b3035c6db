//! A bounded store of stage outputs by key, the least recently used of those that nobody holds leaving first.

use std::any::Any;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::Key;

/// Size in memory of a stage output, for the bound of the cache.
pub trait Footprint: Any + Send + Sync {
    /// Bytes held, to within a small factor.
    fn bytes(&self) -> usize;

    /// Identity of its content, where outputs that came about otherwise may be equal: what follows from them is then the same.
    fn content(&self) -> Option<Key> {
        None
    }
}

struct Entry {
    value: Arc<dyn Any + Send + Sync>,
    bytes: usize,
    used: u64,
}

#[derive(Default)]
struct Store {
    entries: HashMap<Key, Entry>,
    places: HashMap<Key, Vec<PathBuf>>,
    bytes: usize,
    clock: u64,
}

/// Stage outputs of several generations, so that an undo is instant.
pub struct Cache {
    store: Mutex<Store>,
    limit_bytes: usize,
}

impl Cache {
    /// An empty cache that holds about `limit_bytes`, or all that is in use where that is more.
    pub fn new(limit_bytes: usize) -> Self {
        Self { store: Mutex::new(Store::default()), limit_bytes }
    }

    /// The output stored under `key`, if it is there and of type `T`.
    pub fn get<T: Footprint>(&self, key: Key) -> Option<Arc<T>> {
        let mut store = self.lock();
        store.clock += 1;
        let now = store.clock;
        let entry = store.entries.get_mut(&key)?;
        entry.used = now;
        Arc::clone(&entry.value).downcast().ok()
    }

    /// Files and folders a stage read when it last ran.
    pub(super) fn places(&self, stage: Key) -> Vec<PathBuf> {
        self.lock().places.get(&stage).cloned().unwrap_or_default()
    }

    /// States what a stage read.
    pub(super) fn set_places(&self, stage: Key, places: Vec<PathBuf>) {
        self.lock().places.insert(stage, places);
    }

    fn lock(&self) -> MutexGuard<'_, Store> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stores an output and returns it shared.
    pub fn insert<T: Footprint>(&self, key: Key, value: T) -> Arc<T> {
        let bytes = value.bytes();
        let value = Arc::new(value);
        let mut store = self.lock();
        store.clock += 1;
        let entry = Entry { value: Arc::clone(&value) as Arc<dyn Any + Send + Sync>, bytes, used: store.clock };
        store.bytes += bytes;
        if let Some(old) = store.entries.insert(key, entry) {
            store.bytes -= old.bytes;
        }
        while store.bytes > self.limit_bytes {
            // what somebody holds frees no memory when it leaves, and would be computed again at the next edit
            let unused = store.entries.iter().filter(|(_, entry)| Arc::strong_count(&entry.value) == 1);
            let Some(oldest) = unused.min_by_key(|(_, entry)| entry.used).map(|(&key, _)| key) else { break };
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
        let keys = [1, 2, 3].map(|index| KeyBuilder::new("test").with(&index).finish());
        cache.insert(keys[0], vec![0_u8; 100]);
        cache.insert(keys[1], vec![1_u8; 100]);
        assert!(cache.get::<Vec<u8>>(keys[0]).is_some());
        cache.insert(keys[2], vec![2_u8; 100]);
        assert!(cache.get::<Vec<u8>>(keys[1]).is_none());
        assert_eq!(*cache.get::<Vec<u8>>(keys[0]).unwrap(), vec![0_u8; 100]);
    }

    #[test]
    fn what_is_in_use_stays_and_what_is_not_leaves_for_it() {
        let cache = Cache::new(150);
        let keys = [1, 2, 3].map(|index| KeyBuilder::new("test").with(&index).finish());
        let held = cache.insert(keys[0], vec![0_u8; 100]);
        cache.insert(keys[1], vec![1_u8; 100]);
        let also = cache.insert(keys[2], vec![2_u8; 100]);
        assert!(cache.get::<Vec<u8>>(keys[1]).is_none());
        assert_eq!([held, also].map(|kept| kept[0]), [0, 2]);
        assert!(keys.map(|key| cache.get::<Vec<u8>>(key).is_some()) == [true, false, true]);
    }
}
