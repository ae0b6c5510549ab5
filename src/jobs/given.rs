//! Documents given by value or by reference.

use biotope_api::error::ErrorCode;
use biotope_api::reference::Given;
use biotope_api::reference::Reference;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;

use crate::jobs::Invalid;
use crate::jobs::Sources;
use crate::jobs::process::inputs_schema;
use crate::jobs::schema::InputCheck;
use crate::jobs::schema::read;

/// The document given at `pointer`.
///
/// # Errors
/// When nothing stands behind the reference, or something else.
pub fn open<T>(given: &Given<T>, pointer: &str, sources: &dyn Sources) -> Result<T, Invalid>
where
    T: JsonSchema + DeserializeOwned + Clone,
{
    match given {
        Given::Value(value) => Ok(value.clone()),
        Given::Reference(reference) => follow(reference, pointer, sources),
    }
}

/// The document behind a reference: JSON, a table as a list of its rows, or CSV. It is checked
/// as if it stood in the request.
///
/// # Errors
/// As [`open`].
pub fn follow<T>(reference: &Reference, pointer: &str, sources: &dyn Sources) -> Result<T, Invalid>
where
    T: JsonSchema + DeserializeOwned,
{
    let source = sources.open(reference).map_err(|error| error.at(pointer))?;
    let document = source.json().map_err(|error| error.at(pointer))?;
    let check = InputCheck::new(&inputs_schema::<T>())
        .map_err(|error| Invalid::new(pointer, ErrorCode::Mismatch, "a document that can be checked", error))?;
    check.check(&document).and_then(|()| read(document)).map_err(|faults| faults.below(pointer))
}
