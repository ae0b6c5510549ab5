//! Which form of a resource the client reads: `?f=` first, then `Accept`.

use axum::http::HeaderMap;
use axum::http::header;
use biotope_api::error::ErrorCode;

use crate::http::error::ApiError;

/// The media types a client accepts, with their weights, as sent.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Accept(Vec<(String, f32)>);

impl Accept {
    /// What a request accepts.
    pub fn of(headers: &HeaderMap) -> Self {
        let values = headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok());
        Self(values.flat_map(|value| value.split(',')).filter_map(range).collect())
    }

    /// Whether JSON is all it accepts.
    pub fn is_only_json(&self) -> bool {
        matches!(self.0.as_slice(), [(only, _)] if only == "application/json")
    }

    /// Whether a page for people is what it wants most, as browsers do.
    pub fn prefers_html(&self) -> bool {
        let html = self.named("text/html");
        html > 0.0 && html > self.named("application/json")
    }

    /// The first of `offers` among those of the greatest weight; `None` when none is accepted.
    pub fn choose<'a>(&self, offers: impl Iterator<Item = &'a str>) -> Option<usize> {
        let mut best: Option<(usize, f32)> = None;
        for (at, offer) in offers.enumerate() {
            let weight = if self.0.is_empty() { 1.0 } else { self.weight(offer) };
            if weight > 0.0 && best.is_none_or(|(_, other)| weight > other) {
                best = Some((at, weight));
            }
        }
        best.map(|(at, _)| at)
    }

    /// Weight of a media type that is named itself.
    fn named(&self, media_type: &str) -> f32 {
        self.0.iter().find(|(range, _)| range == media_type).map_or(0.0, |(_, weight)| *weight)
    }

    /// Weight of a media type: by the narrowest range that holds it.
    fn weight(&self, media_type: &str) -> f32 {
        let family = media_type.split('/').next().unwrap_or_default();
        let breadth = |range: &str| match range {
            _ if range == media_type => Some(0),
            "*/*" => Some(2),
            _ => (range.strip_suffix("/*") == Some(family)).then_some(1),
        };
        let narrowest = self.0.iter().filter_map(|(range, weight)| Some((breadth(range)?, *weight)));
        narrowest.min_by_key(|(breadth, _)| *breadth).map_or(0.0, |(_, weight)| weight)
    }
}

/// `type/subtype;…;q=0.5` as (type/subtype, 0.5).
fn range(text: &str) -> Option<(String, f32)> {
    let mut parts = text.split(';').map(str::trim);
    let name = parts.next().filter(|name| name.contains('/'))?.to_ascii_lowercase();
    let weight = parts.find_map(|part| part.strip_prefix("q=")).map_or(Some(1.0), |q| q.parse().ok())?;
    Some((name, weight))
}

/// Whether a page for people is wanted of a resource that is JSON otherwise.
///
/// # Errors
/// When `f` is neither `html` nor `json`.
pub fn wants_page(headers: &HeaderMap, f: Option<&str>) -> Result<bool, ApiError> {
    match f {
        None => Ok(Accept::of(headers).prefers_html()),
        Some("html") => Ok(true),
        Some("json") => Ok(false),
        Some(other) => Err(ApiError::parameter(ErrorCode::InvalidParameter, "f", "html or json", other)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    const OFFERS: [&str; 3] = ["image/tiff", "image/png", "application/json"];

    fn accept(text: &'static str) -> Accept {
        Accept::of(&HeaderMap::from_iter([(header::ACCEPT, HeaderValue::from_static(text))]))
    }

    #[test]
    fn the_form_of_the_greatest_weight_is_chosen_and_the_first_among_equals() {
        for (text, expected) in [
            ("*/*", Some(0)),
            ("image/png", Some(1)),
            ("image/*;q=0.5, application/json", Some(2)),
            ("image/tiff;q=0, image/*", Some(1)),
            ("text/csv", None),
            ("IMAGE/PNG ; q=0.2", Some(1)),
        ] {
            assert_eq!(accept(text).choose(OFFERS.into_iter()), expected, "{text}");
        }
        assert_eq!(Accept::default().choose(OFFERS.into_iter()), Some(0));
    }

    #[test]
    fn browsers_get_pages_and_programs_do_not() {
        let browser = "text/html,application/xhtml+xml,application/xml;q=0.9,image/avif,*/*;q=0.8";
        assert!(accept(browser).prefers_html());
        for program in ["*/*", "application/json", "application/json, text/html;q=0.5"] {
            assert!(!accept(program).prefers_html(), "{program}");
        }
        assert!(accept("application/json").is_only_json() && !accept("application/json, */*").is_only_json());
    }
}
