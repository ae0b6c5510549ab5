//! Bytes by key. Knows neither JSON nor rasters nor jobs.
//!
//! Everything is written whole or not at all: a write goes to a temporary place, reaches the
//! disk, and is then published under its key. Contents are named by their digest, so the same
//! bytes are stored once and a published key never changes. A sweep removes what nobody names.

mod blocking;
mod digest;
mod error;
mod key;
mod lock;
mod store;
mod sweep;

pub use blocking::BlockingStore;
pub use blocking::Writing;
pub use digest::Digest;
pub use digest::Hasher;
pub use error::StoreError;
pub use key::Key;
pub use lock::FolderLock;
pub use store::Store;
pub use store::Sweep;
pub use sweep::Pin;
