//! Bodies of requests: not too large, not too slow.

use std::time::Duration;

use axum::body::Body;
use axum::http::HeaderMap;
use axum::http::header;
use biotope_api::error::ErrorCode;
use bytes::Bytes;
use bytes::BytesMut;
use futures_util::Stream;
use futures_util::StreamExt as _;
use futures_util::stream;

use crate::http::error::ApiError;

/// Bytes of a body that is refused which are still read, so that the client can hear why.
const LINGER_BYTES: u64 = 1 << 30;
/// Longest time spent on that.
const LINGER_TIME: Duration = Duration::from_secs(10);

/// What a body may be.
#[derive(Debug, Clone, Copy)]
pub struct BodyLimits {
    /// Most bytes.
    pub bytes: u64,
    /// Longest time, for the whole of [`read_whole`] or for the next piece of [`pieces`].
    pub time: Duration,
}

/// The whole body.
///
/// # Errors
/// When it is too large, too slow or breaks off.
pub async fn read_whole(headers: &HeaderMap, body: Body, limits: BodyLimits) -> Result<Bytes, ApiError> {
    let mut body = Box::pin(pieces(headers, body, limits));
    let whole = async {
        let mut all = BytesMut::new();
        while let Some(piece) = body.next().await {
            all.extend_from_slice(&piece?);
        }
        Ok(all.freeze())
    };
    tokio::time::timeout(limits.time, whole).await.unwrap_or_else(|_| Err(too_slow(limits)))
}

/// The body piece by piece; ends after the first error.
pub fn pieces(
    headers: &HeaderMap,
    body: Body,
    limits: BodyLimits,
) -> impl Stream<Item = Result<Bytes, ApiError>> + Send + use<> {
    let announced = headers.get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
    let polite = headers.contains_key(header::EXPECT);
    let state = (body.into_data_stream(), 0_u64, false);
    stream::unfold(state, move |(mut body, mut seen, ended)| async move {
        if ended {
            return None;
        }
        if announced.is_some_and(|size| size > limits.bytes) {
            if !polite {
                linger(&mut body).await;
            }
            return Some((Err(too_large(limits)), (body, seen, true)));
        }
        let piece = match tokio::time::timeout(limits.time, body.next()).await {
            Err(_) => Err(too_slow(limits)),
            Ok(None) => return None,
            Ok(Some(Err(error))) => {
                Err(ApiError::new(ErrorCode::BodyUnreadable, format!("The body broke off: {error}.")))
            }
            Ok(Some(Ok(piece))) => {
                seen += piece.len() as u64;
                if seen <= limits.bytes {
                    Ok(piece)
                } else {
                    linger(&mut body).await;
                    Err(too_large(limits))
                }
            }
        };
        let failed = piece.is_err();
        Some((piece, (body, seen, failed)))
    })
    .fuse()
}

/// Reads on for a while and throws away: a client that still writes would otherwise see a broken
/// connection instead of the answer.
async fn linger<E>(body: &mut (impl Stream<Item = Result<Bytes, E>> + Unpin)) {
    let read = async {
        let mut left = LINGER_BYTES;
        while let Some(Ok(piece)) = body.next().await {
            left = left.saturating_sub(piece.len() as u64);
            if left == 0 {
                return;
            }
        }
    };
    let _done_or_not = tokio::time::timeout(LINGER_TIME, read).await;
}

fn too_large(limits: BodyLimits) -> ApiError {
    let most = limits.bytes >> 20;
    ApiError::new(ErrorCode::BodyTooLarge, format!("The body may have at most {most} MiB."))
}

fn too_slow(limits: BodyLimits) -> ApiError {
    let most = limits.time.as_secs();
    ApiError::new(ErrorCode::BodyTooSlow, format!("The body did not arrive within {most} s."))
        .with_header(header::CONNECTION, axum::http::HeaderValue::from_static("close"))
}
