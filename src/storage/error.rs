use std::path::PathBuf;

/// Why bytes could not be stored or fetched.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// Nothing stands under the key.
    #[error("nothing is stored under {key}")]
    NotFound {
        /// The path of the key.
        key: String,
    },
    /// Another process holds the folder.
    #[error("another process works in {}", folder.display())]
    Held {
        /// The folder.
        folder: PathBuf,
    },
    /// The folder cannot be made or opened.
    #[error("the folder {} cannot be used: {cause}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// The store failed.
    #[error("the store failed at {key}: {cause}")]
    Backend {
        /// The path of the key.
        key: String,
        /// What the store said.
        cause: object_store::Error,
    },
}
