//! Everything that is wrong with a client's input.

use std::fmt;

use biotope_api::error::ErrorCode;
use biotope_api::error::FieldError;
use serde_json::Value;

/// Longest text shown of what was found, in characters.
const FOUND_LIMIT: usize = 120;

/// One or more faults in a client's input, each with its place.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Invalid {
    /// The faults; pointers are relative to the inputs until [`Invalid::below`] moves them.
    pub errors: Vec<FieldError>,
}

impl Invalid {
    /// One fault at `pointer`.
    pub fn new(
        pointer: impl Into<String>,
        code: ErrorCode,
        expected: impl Into<String>,
        found: impl fmt::Display,
    ) -> Self {
        let mut all = Self::default();
        all.push(pointer, code, expected, found);
        all
    }

    /// Adds a fault at `pointer`.
    pub fn push(
        &mut self,
        pointer: impl Into<String>,
        code: ErrorCode,
        expected: impl Into<String>,
        found: impl fmt::Display,
    ) {
        self.errors.push(FieldError {
            pointer: pointer.into(),
            code: code.code().to_owned(),
            expected: expected.into(),
            found: shortened(&found.to_string()),
        });
    }

    /// Takes over the faults of `other`.
    pub fn extend(&mut self, other: Self) {
        self.errors.extend(other.errors);
    }

    /// Keeps the value of `result`, or its faults.
    pub fn keep<T>(&mut self, result: Result<T, Self>) -> Option<T> {
        result.map_err(|faults| self.extend(faults)).ok()
    }

    /// `Ok` when there are no faults.
    ///
    /// # Errors
    /// The faults.
    pub fn into_result(self) -> Result<(), Self> {
        if self.errors.is_empty() { Ok(()) } else { Err(self) }
    }

    /// The same faults with `prefix` before every pointer.
    pub fn below(mut self, prefix: &str) -> Self {
        for error in &mut self.errors {
            error.pointer.insert_str(0, prefix);
        }
        self
    }
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, error) in self.errors.iter().enumerate() {
            let FieldError { pointer, expected, found, .. } = error;
            let place = if pointer.is_empty() { "the body" } else { pointer };
            write!(f, "{}{place}: expected {expected}, found {found}", if i > 0 { "; " } else { "" })?;
        }
        Ok(())
    }
}

/// `value` as it is shown in a fault.
pub fn shown(value: &Value) -> String {
    match value {
        Value::Array(items) if items.len() > 8 => format!("a list of {}", items.len()),
        Value::Object(fields) if fields.len() > 8 => format!("an object of {} fields", fields.len()),
        other => shortened(&other.to_string()),
    }
}

fn shortened(text: &str) -> String {
    match text.char_indices().nth(FOUND_LIMIT) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
