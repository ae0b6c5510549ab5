//! The photo behind a reference.

use biotope_api::error::ErrorCode;
use biotope_api::reference::Reference;

use crate::codec::picture::Image;
use crate::codec::picture::MAX_PIXELS;
use crate::jobs::Invalid;
use crate::jobs::Sources;

/// The picture at `pointer`, upright.
///
/// # Errors
/// When there is none or it cannot be used.
pub fn open(reference: &Reference, pointer: &str, sources: &dyn Sources) -> Result<Image, Invalid> {
    let source = sources.open(reference).map_err(|error| error.at(pointer))?;
    let none = || Invalid::new(pointer, ErrorCode::Unreadable, "a JPEG or PNG picture", "another kind of output");
    let (_, bytes) = source.bytes().ok_or_else(none)?;
    Image::read(bytes, MAX_PIXELS).map_err(|error| {
        let code = ErrorCode::from_code(error.code()).unwrap_or(ErrorCode::Unreadable);
        Invalid::new(pointer, code, error.expected(), error.found())
    })
}
