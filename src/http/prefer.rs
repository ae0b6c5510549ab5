//! The `Prefer` header (RFC 7240) of an execution.

use std::time::Duration;

use axum::http::HeaderMap;

/// Longest time an answer is held back for a client that waits.
const WAIT_LIMIT: Duration = Duration::from_secs(60);

/// How a client would like an execution to be answered. What is not known is ignored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Prefer {
    /// By a job.
    pub asynchronous: bool,
    /// By the results, if they are there in that time.
    pub wait: Option<Duration>,
}

impl Prefer {
    /// The preferences of a request.
    pub fn of(headers: &HeaderMap) -> Self {
        let values = headers.get_all("prefer").iter().filter_map(|value| value.to_str().ok());
        let mut prefer = Self::default();
        for token in values.flat_map(|value| value.split([',', ';'])).map(str::trim) {
            match token.split_once('=').map(|(name, value)| (name.trim(), value.trim().trim_matches('"'))) {
                None if token.eq_ignore_ascii_case("respond-async") => prefer.asynchronous = true,
                Some((name, value)) if name.eq_ignore_ascii_case("wait") => {
                    prefer.wait = value.parse().ok().map(|s| Duration::from_secs(s).min(WAIT_LIMIT));
                }
                _ => {}
            }
        }
        prefer
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn prefer(text: &'static str) -> Prefer {
        Prefer::of(&HeaderMap::from_iter([("prefer".parse().unwrap(), HeaderValue::from_static(text))]))
    }

    #[test]
    fn preferences_are_read_in_the_forms_clients_send() {
        let wait = Some(Duration::from_secs(5));
        assert_eq!(prefer("respond-async "), Prefer { asynchronous: true, wait: None });
        assert_eq!(prefer("respond-async, wait=5"), Prefer { asynchronous: true, wait });
        assert_eq!(prefer("respond-async; wait=\"5\"; foo"), Prefer { asynchronous: true, wait });
        for ignored in ["respond-sync", "return=minimal", "wait=soon", ""] {
            assert_eq!(prefer(ignored), Prefer::default(), "{ignored}");
        }
        assert_eq!(prefer("wait=99999").wait, Some(WAIT_LIMIT));
    }
}
