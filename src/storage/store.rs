use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path as FilePath;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use std::time::SystemTime;

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
use crate::storage::sweep::Pin;
use crate::storage::sweep::Pins;
use crate::storage::sweep::Watch;

/// How much earlier than the clock says a file may seem to have been written.
const CLOCK: Duration = Duration::from_millis(20);

/// Bytes by key, in a local folder or in memory. Clones share one store.
#[derive(Debug, Clone)]
pub struct Store {
    objects: Arc<dyn ObjectStore>,
    pins: Arc<Pins>,
    /// Where a local store lies, and when it was opened.
    folder: Option<(PathBuf, SystemTime)>,
}

impl Store {
    /// A store in `folder`, which is made when absent. Writes reach the disk before they count.
    ///
    /// # Errors
    /// When the folder cannot be made or opened.
    pub fn in_folder(folder: &FilePath) -> Result<Self, StoreError> {
        let refuse = |cause| StoreError::Folder { folder: folder.to_owned(), cause };
        std::fs::create_dir_all(folder).map_err(refuse)?;
        let local = LocalFileSystem::new_with_prefix(folder).map_err(|e| refuse(std::io::Error::other(e)))?;
        let folder = Some((folder.to_owned(), SystemTime::now() - CLOCK));
        Ok(Self { objects: Arc::new(local.with_fsync(true)), pins: Arc::default(), folder })
    }

    /// A store in memory: for tests and for work without a server.
    pub fn in_memory() -> Self {
        Self { objects: Arc::new(InMemory::new()), pins: Arc::default(), folder: None }
    }

    /// Stores `bytes` under their digest; bytes that are there already are not written again.
    /// The blob is held until a row names it and the pin is dropped.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn put_blob(&self, bytes: Bytes) -> Result<Pin, StoreError> {
        let pin = self.pins.hold(Digest::of(&bytes));
        let _not_while_one_is_removed = self.pins.gate.read().await;
        let key = Key::Blob(pin.digest());
        if !self.contains(&key).await? {
            self.put(&key, bytes).await?;
        }
        Ok(pin)
    }

    /// Stores `bytes` under `key`, whole or not at all.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn put(&self, key: &Key, bytes: Bytes) -> Result<(), StoreError> {
        let path = key.path();
        let done = self.objects.put(&path, PutPayload::from_bytes(bytes)).await;
        done.map(drop).map_err(|cause| fault(key, cause))
    }

    /// Stores a stream of bytes under their digest, without holding them all; returns the blob,
    /// held as by [`Store::put_blob`], and its size. A stream that fails leaves nothing behind.
    ///
    /// # Errors
    /// The stream's own error as `Err(Ok(_))`, the store's as `Err(Err(_))`.
    pub async fn put_stream<E>(
        &self,
        mut stream: impl Stream<Item = Result<Bytes, E>> + Unpin,
    ) -> Result<(Pin, u64), Result<E, StoreError>> {
        let upload = Key::Upload(Uuid::new_v4());
        let backend = |cause| Err(fault(&upload, cause));
        let (mut hasher, mut size) = (Sha256::new(), 0);
        let mut writer = BufWriter::new(Arc::clone(&self.objects), upload.path());
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
        let pin = self.pins.hold(Digest::from_hasher(hasher));
        let _not_while_one_is_removed = self.pins.gate.read().await;
        let moved = self.objects.rename(&upload.path(), &Key::Blob(pin.digest()).path()).await;
        moved.map_err(backend)?;
        Ok((pin, size))
    }

    /// The bytes under `key`.
    ///
    /// # Errors
    /// [`StoreError::NotFound`] when there are none; otherwise when the store fails.
    pub async fn get(&self, key: &Key) -> Result<Bytes, StoreError> {
        let found = self.objects.get(&key.path()).await.map_err(|cause| fault(key, cause))?;
        found.bytes().await.map_err(|cause| fault(key, cause))
    }

    /// A part of the bytes under `key`.
    ///
    /// # Errors
    /// As [`Store::get`]; also when the range lies outside.
    pub async fn get_range(&self, key: &Key, range: Range<u64>) -> Result<Bytes, StoreError> {
        self.objects.get_range(&key.path(), range).await.map_err(|cause| fault(key, cause))
    }

    /// The number of bytes under `key`.
    ///
    /// # Errors
    /// As [`Store::get`].
    pub async fn size(&self, key: &Key) -> Result<u64, StoreError> {
        self.objects.head(&key.path()).await.map(|meta| meta.size).map_err(|cause| fault(key, cause))
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
            found.extend(self.objects.list(Some(&prefix)).try_collect::<Vec<_>>().await.map_err(backend)?);
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
            self.objects.delete(&entry.location).await.map_err(backend)?;
            removed += 1;
        }
        Ok(removed)
    }

    /// Begins to sweep: what is stored from here on stays, whatever [`Sweep::keep_only`] is
    /// told. `None` while another sweep is under way.
    pub fn sweep(&self) -> Option<Sweep> {
        self.pins.begin().map(|watch| Sweep { store: self.clone(), watch })
    }

    /// Removes what writes that a crash interrupted have left behind: unfinished files, and
    /// uploads that were never named; returns how many were removed. The store must belong to
    /// this process alone.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub async fn clear_remains(&self) -> Result<usize, StoreError> {
        let Some((folder, opened)) = self.folder.clone() else { return Ok(0) };
        let backend = |cause: std::io::Error| StoreError::Folder { folder: folder.clone(), cause };
        let place = folder.clone();
        let cleared = tokio::task::spawn_blocking(move || remove_remains(&place, opened, false)).await;
        cleared.map_err(std::io::Error::other).and_then(|removed| removed).map_err(backend)
    }

    /// Removes what stands under `key`, if anything.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn remove(&self, key: &Key) -> Result<(), StoreError> {
        match self.objects.delete(&key.path()).await.map_err(|cause| fault(key, cause)) {
            Err(StoreError::NotFound { .. }) => Ok(()),
            other => other,
        }
    }
}

/// A sweep under way.
#[derive(Debug)]
pub struct Sweep {
    store: Store,
    watch: Watch,
}

impl Sweep {
    /// Removes every blob that is not `wanted` and was not stored since the sweep began; returns
    /// how many, and their bytes. What is wanted must have been found out after it began.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn keep_only(self, wanted: &BTreeSet<Digest>) -> Result<(usize, u64), StoreError> {
        let folder = Path::from(Key::BLOBS);
        let backend = |cause| StoreError::Backend { key: Key::BLOBS.to_owned(), cause };
        let mut found = self.store.objects.list(Some(&folder));
        let mut removed = (0, 0);
        while let Some(entry) = found.try_next().await.map_err(backend)? {
            let named = entry.location.filename().and_then(|hex| Digest::parse(&format!("sha256:{hex}")));
            let Some(digest) = named.filter(|digest| !wanted.contains(digest)) else { continue };
            let _not_while_one_is_stored = self.store.pins.gate.write().await;
            if !self.watch.was_held(&digest) {
                self.store.remove(&Key::Blob(digest)).await?;
                removed = (removed.0 + 1, removed.1 + entry.size);
            }
        }
        Ok(removed)
    }
}

/// Removes unfinished files, `<name>#<number>`, and all files in the folder of uploads, that are
/// older than `opened`.
fn remove_remains(folder: &FilePath, opened: SystemTime, all: bool) -> std::io::Result<usize> {
    let mut removed = 0;
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.file_type()?.is_dir() {
            removed += remove_remains(&entry.path(), opened, all || name == Key::UPLOADS)?;
        } else if (all || name.contains('#')) && entry.metadata()?.modified()? < opened {
            std::fs::remove_file(entry.path())?;
            removed += 1;
        }
    }
    Ok(removed)
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
        let blob = store.put_blob(Bytes::from_static(b"kept")).await.unwrap().digest();
        let keys: Vec<_> = [b"a", b"b", b"c"].map(|name| Key::Stage(Digest::of(name))).into();
        for key in &keys {
            store.put(key, Bytes::from_static(b"0123456789")).await.unwrap();
            tokio::time::sleep(Duration::from_millis(2)).await;
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
        let digest = store.put_blob(Bytes::from_static(b"reindeer")).await.unwrap().digest();
        assert_eq!(store.put_blob(Bytes::from_static(b"reindeer")).await.unwrap().digest(), digest);
        let key = Key::Blob(digest);
        assert_eq!(store.get(&key).await.unwrap(), "reindeer");
        assert_eq!(store.get_range(&key, 4..8).await.unwrap(), "deer");
        assert_eq!(store.size(&key).await.unwrap(), 8);
        store.remove(&key).await.unwrap();
        store.remove(&key).await.unwrap();
        assert!(matches!(store.get(&key).await, Err(StoreError::NotFound { .. })));
    }

    #[tokio::test]
    async fn a_sweep_takes_what_nobody_names_or_holds_and_nothing_that_comes_after_it_began() {
        let store = Store::in_memory();
        let put = async |text: &'static str| store.put_blob(Bytes::from_static(text.as_bytes())).await.unwrap();
        let (named, forgotten) = (put("named").await.digest(), put("gone").await.digest());
        let again = put("again").await.digest();
        let held = put("held").await;
        let sweep = store.sweep().unwrap();
        assert!(store.sweep().is_none(), "one at a time");
        drop(put("again").await);
        let late = put("late").await.digest();
        let removed = sweep.keep_only(&BTreeSet::from([named])).await.unwrap();
        assert_eq!(removed, (1, 4));
        for (digest, stays) in [(named, true), (forgotten, false), (again, true), (held.digest(), true), (late, true)] {
            assert_eq!(store.contains(&Key::Blob(digest)).await.unwrap(), stays);
        }
        drop(held);
        let removed = store.sweep().unwrap().keep_only(&BTreeSet::from([named])).await.unwrap();
        assert_eq!(removed.0, 3, "what was spared goes with the next sweep");
    }

    #[tokio::test]
    async fn remains_of_interrupted_writes_go_and_those_under_way_stay() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for place in ["uploads", "blobs/ab"] {
            std::fs::create_dir_all(at(place)).unwrap();
        }
        for name in ["uploads/one", "uploads/two#1", "blobs/ab/cd#1", "blobs/ab/cd"] {
            std::fs::write(at(name), "half").unwrap();
        }
        tokio::time::sleep(Duration::from_millis(30)).await;
        let store = Store::in_folder(folder.path()).unwrap();
        tokio::time::sleep(Duration::from_millis(30)).await;
        std::fs::write(at("blobs/ab/ef#1"), "under way").unwrap();
        assert_eq!(store.clear_remains().await.unwrap(), 3);
        assert!(at("blobs/ab/cd").exists() && at("blobs/ab/ef#1").exists());
    }
}
