use std::future::Future;

use bytes::Bytes;
use tokio::runtime::Handle;
use tokio::task::JoinHandle;

use crate::storage::Key;
use crate::storage::Pin;
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
    pub fn put_blob(&self, bytes: Bytes) -> Result<Pin, StoreError> {
        self.wait(self.store.put_blob(bytes))
    }

    /// See [`Store::put`].
    ///
    /// # Errors
    /// As there.
    pub fn put(&self, key: &Key, bytes: Bytes) -> Result<(), StoreError> {
        self.wait(self.store.put(key, bytes))
    }

    /// Begins a [`Store::put`] that goes on while other work is done.
    pub fn begin_put(&self, key: Key, bytes: Bytes) -> Writing {
        let store = self.store.clone();
        let task = self.handle.spawn(async move { store.put(&key, bytes).await });
        Writing { task, handle: self.handle.clone() }
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

/// A write that was begun. It goes on when this is dropped; only [`Writing::finish`] tells how it
/// ended.
#[derive(Debug)]
pub struct Writing {
    task: JoinHandle<Result<(), StoreError>>,
    handle: Handle,
}

impl Writing {
    /// Waits for the end of the write. Panics where the write panicked.
    ///
    /// # Errors
    /// When the store fails.
    pub fn finish(self) -> Result<(), StoreError> {
        match self.handle.block_on(self.task) {
            Ok(done) => done,
            Err(broken) => std::panic::resume_unwind(broken.into_panic()),
        }
    }
}
