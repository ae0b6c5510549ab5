//! References into this service: uploads and the outputs of other jobs.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::PoisonError;

use biotope_api::error::ErrorCode;
use biotope_api::reference::Href;
use biotope_api::reference::Reference;
use serde_json::Value;

use crate::jobs::Artefact;
use crate::jobs::Digest;
use crate::jobs::queue::JobId;
use crate::jobs::queue::Outcome;
use crate::jobs::queue::Queue;
use crate::jobs::sources::Content;
use crate::jobs::sources::Source;
use crate::jobs::sources::SourceError;
use crate::jobs::sources::Sources;
use crate::jobs::sources::data_address;
use crate::jobs::sources::inline;
use crate::storage::BlockingStore;
use crate::storage::Key;

/// Uploads, outputs of other jobs, and data by value.
pub struct StoredSources {
    store: BlockingStore,
    queue: Arc<dyn Queue>,
}

impl StoredSources {
    /// References into `store`, by the rows of `queue`.
    pub fn new(store: BlockingStore, queue: Arc<dyn Queue>) -> Self {
        Self { store, queue }
    }

    fn link(&self, link: &Href) -> Result<Source, SourceError> {
        let (path, query) = link.href.split_once('?').unwrap_or((&link.href, ""));
        if link.href.starts_with("data:") {
            data_address(&link.href)
        } else if let Some(digest) = path.strip_prefix("/assets/") {
            self.asset(digest, link)
        } else if let Some((job, output)) = path.strip_prefix("/jobs/").and_then(|rest| rest.split_once("/results/")) {
            let form = query.split('&').find_map(|pair| pair.strip_prefix("f="));
            self.output(job, output, form)
        } else {
            let allowed = "/assets/sha256:<hex>, /jobs/<id>/results/<output> or a data: address";
            Err(SourceError::new(ErrorCode::HrefNotAllowed, allowed, link.href.as_str()))
        }
    }

    fn asset(&self, digest: &str, link: &Href) -> Result<Source, SourceError> {
        let missing = || not_found("an uploaded asset", &link.href);
        let digest = Digest::parse(digest).ok_or_else(missing)?;
        let row = self.store.wait(self.queue.asset(&digest.to_string())).map_err(unavailable)?.ok_or_else(missing)?;
        let bytes = self.store.find(&Key::Blob(digest)).map_err(unavailable)?.ok_or_else(missing)?;
        let media_type = link.media_type.clone().unwrap_or(row.media_type);
        Ok(Source { digest, content: Content::Encoded { media_type, bytes } })
    }

    fn output(&self, job: &str, output: &str, form: Option<&str>) -> Result<Source, SourceError> {
        let id = JobId::parse(job).ok_or_else(|| not_found("a job of this service", job))?;
        let row = self.store.wait(self.queue.get(id)).map_err(unavailable)?;
        let row = row.ok_or_else(|| not_found("a job of this service", job))?;
        let Some(Outcome::Success { outputs, .. }) = &row.outcome else {
            return Err(not_found("a job that has succeeded", row.state.as_str()));
        };
        let stored = outputs.get(output).ok_or_else(|| not_found("an output the job has kept", output))?;
        let missing = || not_found("a kept output", output);
        let digest = Digest::parse(&stored.digest).ok_or_else(missing)?;
        let bytes = self.store.find(&Key::Blob(digest)).map_err(unavailable)?.ok_or_else(missing)?;
        let artefact = Artefact::from_stored(&stored.kind, bytes).map_err(unavailable)?;
        let Some(form) = form else { return Ok(Source { digest, content: Content::Artefact(artefact) }) };
        let encoded = artefact.encode(form).map_err(|_| not_found("a form the output can be had in", form))?;
        Ok(Source::encoded(encoded.form.media_type, encoded.bytes))
    }
}

impl Sources for StoredSources {
    fn open(&self, reference: &Reference) -> Result<Source, SourceError> {
        match reference {
            Reference::Inline(value) => inline(value),
            Reference::Link(link) => self.link(link),
        }
    }
}

fn not_found(expected: &str, found: &str) -> SourceError {
    SourceError::new(ErrorCode::HrefNotFound, expected, found)
}

fn unavailable(error: impl std::fmt::Display) -> SourceError {
    tracing::error!(%error, "a reference could not be followed");
    SourceError::new(ErrorCode::Internal, "a store that answers", "a fault of the service")
}

/// Remembers the digest of everything that is opened, for the manifest.
pub struct Recorder<'a> {
    inner: &'a dyn Sources,
    seen: Mutex<BTreeMap<String, Digest>>,
}

impl<'a> Recorder<'a> {
    /// Opens through `inner`.
    pub fn new(inner: &'a dyn Sources) -> Self {
        Self { inner, seen: Mutex::default() }
    }

    /// `parameters` with every reference that was opened replaced by the digest of what stood
    /// there: a manifest names contents, not places.
    pub fn settle(&self, parameters: Value) -> Value {
        match parameters {
            Value::Array(items) => items.into_iter().map(|item| self.settle(item)).collect(),
            Value::Object(fields) => match self.digest_of(&fields) {
                Some(digest) => serde_json::json!({ "digest": digest.to_string() }),
                None => Value::Object(fields.into_iter().map(|(name, field)| (name, self.settle(field))).collect()),
            },
            other => other,
        }
    }

    fn digest_of(&self, fields: &serde_json::Map<String, Value>) -> Option<Digest> {
        if !fields.contains_key("href") && !fields.contains_key("value") {
            return None;
        }
        let reference = serde_json::from_value(Value::Object(fields.clone())).ok()?;
        self.seen.lock().unwrap_or_else(PoisonError::into_inner).get(&name_of(&reference)).copied()
    }
}

impl Sources for Recorder<'_> {
    fn open(&self, reference: &Reference) -> Result<Source, SourceError> {
        let source = self.inner.open(reference)?;
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        seen.insert(name_of(reference), source.digest);
        Ok(source)
    }
}

fn name_of(reference: &Reference) -> String {
    serde_json::to_string(reference).unwrap_or_default()
}

/// Every reference by address among `inputs`, so that a caller can replace it.
pub fn each_href(inputs: &mut Value, change: &mut dyn FnMut(&mut String)) {
    match inputs {
        Value::Array(items) => items.iter_mut().for_each(|item| each_href(item, change)),
        Value::Object(fields) => {
            let alone = fields.keys().all(|name| name == "href" || name == "type");
            match fields.get_mut("href") {
                Some(Value::String(href)) if alone => change(href),
                _ => fields.values_mut().for_each(|field| each_href(field, change)),
            }
        }
        _ => {}
    }
}
