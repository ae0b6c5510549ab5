use object_store::path::Path;
use uuid::Uuid;

use crate::storage::Digest;

/// Where bytes stand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Key {
    /// Bytes under the digest of themselves.
    Blob(Digest),
    /// The result of a stage, under the digest of all that it depends on.
    Stage(Digest),
    /// Bytes on their way to a blob.
    Upload(Uuid),
    /// A blob in another form, made on request; may be dropped at any time.
    Encoded(Digest, String),
}

impl Key {
    /// The folder of blobs.
    pub(super) const BLOBS: &'static str = "blobs";
    /// The folder of bytes on their way to a blob.
    pub(super) const UPLOADS: &'static str = "uploads";
    /// The folders of what can be made again.
    pub(super) const REMAKEABLE: [&'static str; 2] = ["stages", "encoded"];

    /// The path of the key in the store.
    pub fn path(&self) -> Path {
        match self {
            Self::Blob(digest) => sharded(Self::BLOBS, digest, ""),
            Self::Stage(digest) => sharded("stages", digest, ""),
            Self::Upload(id) => Path::from(format!("{}/{id}", Self::UPLOADS)),
            Self::Encoded(digest, extension) => sharded("encoded", digest, extension),
        }
    }
}

/// `<folder>/<first two digits>/<digits>[.<extension>]`: folders stay small.
fn sharded(folder: &str, digest: &Digest, extension: &str) -> Path {
    let hex = digest.hex();
    let dot = if extension.is_empty() { "" } else { "." };
    Path::from(format!("{folder}/{}/{hex}{dot}{extension}", &hex[..2]))
}
