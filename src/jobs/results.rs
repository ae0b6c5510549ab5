//! What finished jobs hand out: outputs in the form asked for.

use std::ops::Range;

use bytes::Bytes;

use crate::jobs::Artefact;
use crate::jobs::Digest;
use crate::jobs::Jobs;
use crate::jobs::JobsError;
use crate::jobs::artefact::ENCODERS_VERSION;
use crate::jobs::artefact::Encoded;
use crate::jobs::artefact::Form;
use crate::jobs::artefact::Kind;
use crate::jobs::context::Stored;
use crate::storage::BlockingStore;
use crate::storage::Key;
use crate::storage::StoreError;

/// Bytes that can be handed out in parts.
#[derive(Debug, Clone)]
pub struct Delivery {
    /// Where they stand.
    key: Key,
    /// How many.
    pub size: u64,
    /// Names these bytes among all others; without quotes.
    pub tag: String,
}

impl Jobs {
    /// An output in one of its forms: made when it is first asked for, then kept.
    ///
    /// # Errors
    /// When the store fails or the output cannot be encoded.
    pub async fn deliver(&self, stored: &Stored, form: &Form) -> Result<Delivery, JobsError> {
        let digest = parse(&stored.digest)?;
        let tag = format!("{}-{ENCODERS_VERSION}-{}", digest.hex(), form.name);
        if is_stored_so(&stored.kind, form) {
            return Ok(Delivery { key: Key::Blob(digest), size: stored.size, tag });
        }
        let key = Key::Encoded(digest, format!("{ENCODERS_VERSION}.{}", form.name));
        match self.0.store.size(&key).await {
            Ok(size) => return Ok(Delivery { key, size, tag }),
            Err(StoreError::NotFound { .. }) => {}
            Err(error) => return Err(error.into()),
        }
        let (stored, form, target) = (stored.clone(), form.name.clone(), key.clone());
        let size = self
            .at_desk(move |inner, handle| {
                let (store, _) = inner.at_desk(handle);
                let encoded = inner.desk.install(|| encode(&store, &stored, &form))?;
                store.put(&target, encoded.bytes.clone())?;
                Ok::<_, JobsError>(encoded.bytes.len() as u64)
            })
            .await??;
        Ok(Delivery { key, size, tag })
    }

    /// An uploaded file.
    ///
    /// # Errors
    /// When it is not there or the store fails.
    pub async fn deliver_asset(&self, digest: &str) -> Result<Delivery, JobsError> {
        let digest = parse(digest)?;
        let key = Key::Blob(digest);
        let size = self.0.store.size(&key).await?;
        Ok(Delivery { key, size, tag: digest.hex() })
    }

    /// A part of a delivery.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn read(&self, delivery: &Delivery, range: Range<u64>) -> Result<Bytes, JobsError> {
        if range.is_empty() {
            return Ok(Bytes::new());
        }
        Ok(self.0.store.get_range(&delivery.key, range).await?)
    }

    /// An output in its structured form.
    ///
    /// # Errors
    /// When the store fails or holds something else.
    pub async fn artefact(&self, stored: &Stored) -> Result<Artefact, JobsError> {
        let stored = stored.clone();
        self.at_desk(move |inner, handle| {
            let (store, _) = inner.at_desk(handle);
            inner.desk.install(|| load(&store, &stored))
        })
        .await?
    }
}

/// Reads an output back.
///
/// # Errors
/// When the store fails or holds something else.
pub fn load(store: &BlockingStore, stored: &Stored) -> Result<Artefact, JobsError> {
    let bytes = store.get(&Key::Blob(parse(&stored.digest)?))?;
    Ok(Artefact::from_stored(&stored.kind, bytes)?)
}

/// Reads an output back and encodes it.
///
/// # Errors
/// As [`load`]; and when it cannot be encoded so.
pub fn encode(store: &BlockingStore, stored: &Stored, form: &str) -> Result<Encoded, JobsError> {
    Ok(load(store, stored)?.encode(form)?)
}

/// Whether the stored bytes are those of the form.
fn is_stored_so(kind: &Kind, form: &Form) -> bool {
    match kind {
        Kind::Json | Kind::Picture | Kind::File { .. } => kind.forms().contains(form),
        Kind::Table | Kind::Tables | Kind::Map => false,
    }
}

fn parse(digest: &str) -> Result<Digest, StoreError> {
    Digest::parse(digest).ok_or_else(|| StoreError::NotFound { key: digest.to_owned() })
}
