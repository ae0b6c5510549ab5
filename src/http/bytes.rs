//! Files: whole, in ranges, or not at all when the client holds them already.

use std::ops::Range;

use axum::body::Body;
use axum::http::HeaderMap;
use axum::http::HeaderValue;
use axum::http::StatusCode;
use axum::http::header;
use axum::response::Response;
use biotope_api::error::ErrorCode;
use futures_util::StreamExt as _;
use futures_util::stream;

use crate::http::document::holds;
use crate::http::error::Answer;
use crate::http::error::ApiError;
use crate::jobs::Jobs;
use crate::jobs::results::Delivery;

/// Bytes read from the store at a time.
const PIECE: u64 = 1 << 20;

/// What is said of a file beside its bytes.
#[derive(Debug, Clone)]
pub struct FileHead {
    /// Its media type.
    pub media_type: String,
    /// The name under which a browser saves it.
    pub name: String,
    /// Whether these bytes stand at this address for ever.
    pub immutable: bool,
}

/// Hands out a file.
pub fn serve(jobs: &Jobs, headers: &HeaderMap, delivery: Delivery, head: &FileHead) -> Answer {
    let tag = format!("\"{}\"", delivery.tag);
    let mut answer = Response::new(Body::empty());
    describe(answer.headers_mut(), &tag, head)?;
    if holds(headers, &tag) {
        *answer.status_mut() = StatusCode::NOT_MODIFIED;
        return Ok(answer);
    }
    let size = delivery.size;
    let range = match wanted(headers, &tag, size) {
        Wanted::Whole => 0..size,
        Wanted::Part(range) => {
            *answer.status_mut() = StatusCode::PARTIAL_CONTENT;
            let part = format!("bytes {}-{}/{size}", range.start, range.end.saturating_sub(1));
            insert(answer.headers_mut(), header::CONTENT_RANGE, &part)?;
            range
        }
        Wanted::Nothing => {
            let whole = HeaderValue::from_str(&format!("bytes */{size}"));
            let error = ApiError::new(ErrorCode::RangeNotSatisfiable, format!("The file has {size} bytes."));
            return Err(match whole {
                Ok(whole) => error.with_header(header::CONTENT_RANGE, whole),
                Err(_) => error,
            });
        }
    };
    insert(answer.headers_mut(), header::CONTENT_LENGTH, &(range.end - range.start).to_string())?;
    *answer.body_mut() = stream_of(jobs.clone(), delivery, range);
    Ok(answer)
}

fn describe(out: &mut HeaderMap, tag: &str, head: &FileHead) -> Result<(), ApiError> {
    let keep = if head.immutable { "public, max-age=31536000, immutable" } else { "no-cache" };
    insert(out, header::ETAG, tag)?;
    insert(out, header::CONTENT_TYPE, &head.media_type)?;
    insert(out, header::CONTENT_DISPOSITION, &format!("inline; filename=\"{}\"", head.name))?;
    insert(out, header::CACHE_CONTROL, keep)?;
    insert(out, header::ACCEPT_RANGES, "bytes")?;
    insert(out, header::X_CONTENT_TYPE_OPTIONS, "nosniff")?;
    insert(out, header::CONTENT_SECURITY_POLICY, "default-src 'none'; sandbox")?;
    insert(out, header::VARY, "Accept")
}

fn insert(out: &mut HeaderMap, name: header::HeaderName, value: &str) -> Result<(), ApiError> {
    let value =
        HeaderValue::from_str(value).map_err(|_| ApiError::new(ErrorCode::Internal, "A header cannot be written."))?;
    out.insert(name, value);
    Ok(())
}

/// The part of a file that a request wants.
#[derive(Debug, PartialEq, Eq)]
enum Wanted {
    Whole,
    Part(Range<u64>),
    Nothing,
}

/// Reads `Range` and `If-Range`. More than one range, or one of another unit, gives the whole.
fn wanted(headers: &HeaderMap, tag: &str, size: u64) -> Wanted {
    let text = |name| headers.get(name).and_then(|value: &HeaderValue| value.to_str().ok());
    let Some(range) = text(header::RANGE).and_then(|range| range.strip_prefix("bytes=")) else { return Wanted::Whole };
    if text(header::IF_RANGE).is_some_and(|held| held != tag) {
        return Wanted::Whole;
    }
    let Some((first, last)) = range.split_once('-').map(|(a, b)| (a.trim(), b.trim())) else { return Wanted::Whole };
    let range = match (first.parse::<u64>(), last.parse::<u64>()) {
        (Ok(first), Ok(last)) if first <= last => first..last.saturating_add(1).min(size),
        (Ok(first), Err(_)) if last.is_empty() => first..size,
        (Err(_), Ok(length)) if first.is_empty() => size.saturating_sub(length)..size,
        _ => return Wanted::Whole,
    };
    if range.is_empty() { Wanted::Nothing } else { Wanted::Part(range) }
}

fn stream_of(jobs: Jobs, delivery: Delivery, range: Range<u64>) -> Body {
    // Fused: the compression asks once more after the end.
    let pieces = stream::unfold(range.start, move |from| {
        let (jobs, delivery, to) = (jobs.clone(), delivery.clone(), range.end.min(from + PIECE));
        async move {
            if from >= to {
                return None;
            }
            let piece = jobs.read(&delivery, from..to).await;
            if let Err(error) = &piece {
                tracing::error!(%error, "a file broke off");
            }
            Some((piece, to))
        }
    });
    Body::from_stream(pieces.fuse())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(text: &str) -> Wanted {
        let value = HeaderValue::from_str(text).unwrap();
        wanted(&HeaderMap::from_iter([(header::RANGE, value)]), "\"t\"", 10)
    }

    #[test]
    fn ranges_are_cut_to_the_file() {
        for (text, expected) in [
            ("bytes=2-4", Wanted::Part(2..5)),
            ("bytes=2-", Wanted::Part(2..10)),
            ("bytes=-3", Wanted::Part(7..10)),
            ("bytes=-30", Wanted::Part(0..10)),
            ("bytes=5-99", Wanted::Part(5..10)),
            ("bytes=10-", Wanted::Nothing),
            ("bytes=-0", Wanted::Nothing),
            ("bytes=4-2", Wanted::Whole),
            ("bytes=0-1,3-4", Wanted::Whole),
            ("lines=1-2", Wanted::Whole),
            ("bytes=0-18446744073709551615", Wanted::Part(0..10)),
        ] {
            assert_eq!(range(text), expected, "{text}");
        }
    }

    #[test]
    fn a_range_of_other_bytes_gives_the_whole_file() {
        let value = |text| HeaderValue::from_static(text);
        let headers = HeaderMap::from_iter([(header::RANGE, value("bytes=2-4")), (header::IF_RANGE, value("\"old\""))]);
        assert_eq!(wanted(&headers, "\"new\"", 10), Wanted::Whole);
    }
}
