use std::ops::Range;
use std::path::Path as FilePath;
use std::sync::Arc;

use bytes::Bytes;
use futures_util::Stream;
use futures_util::StreamExt as _;
use futures_util::TryStreamExt as _;
use object_store::ObjectStore;
use object_store::ObjectStoreExt as _;
use object_store::PutPayload;
use object_store::buffered::BufWriter;
use object_store::local::LocalFileSystem;
use object_store::memory::InMemory;
use object_store::path::Path;
use sha2::Digest as _;
use sha2::Sha256;
use tokio::io::AsyncWriteExt as _;
use uuid::Uuid;

use crate::storage::Digest;
use crate::storage::Key;
use crate::storage::StoreError;

/// Bytes by key, in a local folder or in memory. Clones share one store.
#[derive(Debug, Clone)]
pub struct Store(Arc<dyn ObjectStore>);

impl Store {
    /// A store in `folder`, which is made when absent. Writes reach the disk before they count.
    ///
    /// # Errors
    /// When the folder cannot be made or opened.
    pub fn in_folder(folder: &FilePath) -> Result<Self, StoreError> {
        let refuse = |cause| StoreError::Folder { folder: folder.to_owned(), cause };
        std::fs::create_dir_all(folder).map_err(refuse)?;
        let local = LocalFileSystem::new_with_prefix(folder).map_err(|e| refuse(std::io::Error::other(e)))?;
        Ok(Self(Arc::new(local.with_fsync(true))))
    }

    /// A store in memory: for tests and for work without a server.
    pub fn in_memory() -> Self {
        Self(Arc::new(InMemory::new()))
    }

    /// Stores `bytes` under their digest; bytes that are there already are not written again.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn put_blob(&self, bytes: Bytes) -> Result<Digest, StoreError> {
        let digest = Digest::of(&bytes);
        let key = Key::Blob(digest);
        if !self.contains(&key).await? {
            self.put(&key, bytes).await?;
        }
        Ok(digest)
    }

    /// Stores `bytes` under `key`, whole or not at all.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn put(&self, key: &Key, bytes: Bytes) -> Result<(), StoreError> {
        let path = key.path();
        let done = self.0.put(&path, PutPayload::from_bytes(bytes)).await;
        done.map(drop).map_err(|cause| fault(key, cause))
    }

    /// Stores a stream of bytes under their digest, without holding them all; returns the digest
    /// and the size. A stream that fails leaves nothing behind.
    ///
    /// # Errors
    /// The stream's own error as `Err(Ok(_))`, the store's as `Err(Err(_))`.
    pub async fn put_stream<E>(
        &self,
        mut stream: impl Stream<Item = Result<Bytes, E>> + Unpin,
    ) -> Result<(Digest, u64), Result<E, StoreError>> {
        let upload = Key::Upload(Uuid::new_v4());
        let backend = |cause| Err(fault(&upload, cause));
        let (mut hasher, mut size) = (Sha256::new(), 0);
        let mut writer = BufWriter::new(Arc::clone(&self.0), upload.path());
        while let Some(piece) = stream.next().await {
            let piece = match piece {
                Ok(piece) => piece,
                Err(error) => {
                    let _nothing_was_published = writer.abort().await;
                    return Err(Ok(error));
                }
            };
            hasher.update(&piece);
            size += piece.len() as u64;
            writer.put(piece).await.map_err(backend)?;
        }
        writer
            .shutdown()
            .await
            .map_err(|error| backend(object_store::Error::Generic { store: "upload", source: error.into() }))?;
        let digest = Digest::from_hasher(hasher);
        let moved = self.0.rename(&upload.path(), &Key::Blob(digest).path()).await;
        moved.map_err(backend)?;
        Ok((digest, size))
    }

    /// The bytes under `key`.
    ///
    /// # Errors
    /// [`StoreError::NotFound`] when there are none; otherwise when the store fails.
    pub async fn get(&self, key: &Key) -> Result<Bytes, StoreError> {
        let found = self.0.get(&key.path()).await.map_err(|cause| fault(key, cause))?;
        found.bytes().await.map_err(|cause| fault(key, cause))
    }

    /// A part of the bytes under `key`.
    ///
    /// # Errors
    /// As [`Store::get`]; also when the range lies outside.
    pub async fn get_range(&self, key: &Key, range: Range<u64>) -> Result<Bytes, StoreError> {
        self.0.get_range(&key.path(), range).await.map_err(|cause| fault(key, cause))
    }

    /// The number of bytes under `key`.
    ///
    /// # Errors
    /// As [`Store::get`].
    pub async fn size(&self, key: &Key) -> Result<u64, StoreError> {
        self.0.head(&key.path()).await.map(|meta| meta.size).map_err(|cause| fault(key, cause))
    }

    /// Whether anything stands under `key`.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn contains(&self, key: &Key) -> Result<bool, StoreError> {
        match self.size(key).await {
            Ok(_) => Ok(true),
            Err(StoreError::NotFound { .. }) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Removes the oldest results of stages and encoded forms until those left take at most
    /// `limit` bytes; returns how many were removed. All of them can be made again.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn trim(&self, limit: u64) -> Result<usize, StoreError> {
        let mut found = Vec::new();
        for folder in Key::REMAKEABLE {
            let prefix = Path::from(folder);
            let backend = |cause| StoreError::Backend { key: folder.to_owned(), cause };
            found.extend(self.0.list(Some(&prefix)).try_collect::<Vec<_>>().await.map_err(backend)?);
        }
        found.sort_by_key(|entry| std::cmp::Reverse(entry.last_modified));
        let mut kept = 0;
        let spare = found.into_iter().filter(|entry| {
            kept += entry.size;
            kept > limit
        });
        let mut removed = 0;
        for entry in spare {
            let backend = |cause| StoreError::Backend { key: entry.location.to_string(), cause };
            self.0.delete(&entry.location).await.map_err(backend)?;
            removed += 1;
        }
        Ok(removed)
    }

    /// Removes what stands under `key`, if anything.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn remove(&self, key: &Key) -> Result<(), StoreError> {
        match self.0.delete(&key.path()).await.map_err(|cause| fault(key, cause)) {
            Err(StoreError::NotFound { .. }) => Ok(()),
            other => other,
        }
    }
}

fn fault(key: &Key, cause: object_store::Error) -> StoreError {
    let key = key.path().to_string();
    match cause {
        object_store::Error::NotFound { .. } => StoreError::NotFound { key },
        cause => StoreError::Backend { key, cause },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn trimming_takes_the_oldest_of_what_can_be_made_again_and_nothing_else() {
        let store = Store::in_memory();
        let blob = store.put_blob(Bytes::from_static(b"kept")).await.unwrap();
        let keys: Vec<_> = [b"a", b"b", b"c"].map(|name| Key::Stage(Digest::of(name))).into();
        for key in &keys {
            store.put(key, Bytes::from_static(b"0123456789")).await.unwrap();
            tokio::time::sleep(std::time::Duration::from_millis(2)).await;
        }
        assert_eq!(store.trim(25).await.unwrap(), 1);
        assert!(!store.contains(&keys[0]).await.unwrap() && store.contains(&keys[2]).await.unwrap());
        assert_eq!(store.trim(0).await.unwrap(), 2);
        assert!(store.contains(&Key::Blob(blob)).await.unwrap());
    }

    #[tokio::test]
    async fn the_same_bytes_are_stored_once_and_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::in_folder(folder.path()).unwrap();
        let digest = store.put_blob(Bytes::from_static(b"reindeer")).await.unwrap();
        assert_eq!(store.put_blob(Bytes::from_static(b"reindeer")).await.unwrap(), digest);
        let key = Key::Blob(digest);
        assert_eq!(store.get(&key).await.unwrap(), "reindeer");
        assert_eq!(store.get_range(&key, 4..8).await.unwrap(), "deer");
        assert_eq!(store.size(&key).await.unwrap(), 8);
        store.remove(&key).await.unwrap();
        store.remove(&key).await.unwrap();
        assert!(matches!(store.get(&key).await, Err(StoreError::NotFound { .. })));
    }
}
