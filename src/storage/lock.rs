use std::fs::File;
use std::fs::TryLockError;
use std::path::Path;

use crate::storage::StoreError;

/// Holds a folder for this process alone, until dropped or until the process ends, however it
/// ends.
#[derive(Debug)]
pub struct FolderLock {
    _held: File,
}

impl FolderLock {
    /// Takes `folder`, which is made when absent.
    ///
    /// # Errors
    /// [`StoreError::Held`] when another process has it.
    pub fn take(folder: &Path) -> Result<Self, StoreError> {
        let refuse = |cause| StoreError::Folder { folder: folder.to_owned(), cause };
        std::fs::create_dir_all(folder).map_err(refuse)?;
        let file = File::create(folder.join("lock")).map_err(refuse)?;
        match file.try_lock() {
            Ok(()) => Ok(Self { _held: file }),
            Err(TryLockError::WouldBlock) => Err(StoreError::Held { folder: folder.to_owned() }),
            Err(TryLockError::Error(cause)) => Err(refuse(cause)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_held_once_and_free_again_when_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let first = FolderLock::take(folder.path()).unwrap();
        assert!(matches!(FolderLock::take(folder.path()), Err(StoreError::Held { .. })));
        drop(first);
        FolderLock::take(folder.path()).unwrap();
    }
}
