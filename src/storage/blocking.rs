use std::future::Future;

use bytes::Bytes;
use tokio::runtime::Handle;

use crate::storage::Digest;
use crate::storage::Key;
use crate::storage::Store;
use crate::storage::StoreError;

/// A [`Store`] for synchronous code that runs outside the async threads. Calling it on an async
/// thread panics.
#[derive(Debug, Clone)]
pub struct BlockingStore {
    store: Store,
    handle: Handle,
}

impl BlockingStore {
    /// `store`, its work done on the runtime of `handle`.
    pub fn new(store: Store, handle: Handle) -> Self {
        Self { store, handle }
    }

    /// The store itself.
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// See [`Store::put_blob`].
    ///
    /// # Errors
    /// As there.
    pub fn put_blob(&self, bytes: Bytes) -> Result<Digest, StoreError> {
        self.wait(self.store.put_blob(bytes))
    }

    /// See [`Store::put`].
    ///
    /// # Errors
    /// As there.
    pub fn put(&self, key: &Key, bytes: Bytes) -> Result<(), StoreError> {
        self.wait(self.store.put(key, bytes))
    }

    /// See [`Store::get`].
    ///
    /// # Errors
    /// As there.
    pub fn get(&self, key: &Key) -> Result<Bytes, StoreError> {
        self.wait(self.store.get(key))
    }

    /// The bytes under `key`, or `None` when there are none.
    ///
    /// # Errors
    /// When the store fails.
    pub fn find(&self, key: &Key) -> Result<Option<Bytes>, StoreError> {
        match self.get(key) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(StoreError::NotFound { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Waits for a future of the store's runtime.
    pub fn wait<T>(&self, future: impl Future<Output = T>) -> T {
        self.handle.block_on(future)
    }
}
