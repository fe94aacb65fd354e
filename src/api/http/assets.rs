//! Files for browsers that are part of the program: the viewer, and the API reference.
//!
//! Browsers cache them, and revalidate them on each use: the next version of the program has others under the same
//! names. That costs one answer without a body (304).

use std::io::{self, Read as _};
use std::sync::OnceLock;

use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use flate2::read::GzDecoder;

use super::coding::{self, Coding};
use crate::api::problem::{Kind, Problem};
use piad_files::text::quoted;

/// A file, as `build.rs` lists it.
pub(crate) struct Asset {
    /// Its name.
    pub name: &'static str,
    /// A hash of its bytes.
    hash: &'static str,
    /// Its bytes, compressed, which keeps the program two megabytes smaller.
    gzip: &'static [u8],
    /// Its uncompressed bytes, once a client has needed them.
    plain: OnceLock<Bytes>,
}

impl Asset {
    /// A file that has not been requested yet.
    pub(crate) const fn new(name: &'static str, hash: &'static str, gzip: &'static [u8]) -> Self {
        let plain = OnceLock::new();
        Self {
            name,
            hash,
            gzip,
            plain,
        }
    }

    /// Its bytes.
    fn plain(&self) -> io::Result<Bytes> {
        if let Some(plain) = self.plain.get() {
            return Ok(plain.clone());
        }
        let mut plain = Vec::new();
        GzDecoder::new(self.gzip).read_to_end(&mut plain)?;
        Ok(self.plain.get_or_init(|| plain.into()).clone())
    }

    /// The media type, by the ending of the name.
    fn media_type(&self) -> &'static str {
        match self.name.rsplit_once('.').map(|(_, ending)| ending) {
            Some("html") => "text/html; charset=utf-8",
            Some("js") => "text/javascript; charset=utf-8",
            Some("css") => "text/css; charset=utf-8",
            Some("svg") => "image/svg+xml",
            Some("png") => "image/png",
            Some("ico") => "image/x-icon",
            Some("json") => "application/json",
            Some("webmanifest") => "application/manifest+json",
            Some("woff2") => "font/woff2",
            Some("wasm") => "application/wasm",
            _ => "text/plain; charset=utf-8",
        }
    }
}

/// The files of a page.
pub(crate) struct Site {
    /// The name of the page.
    pub name: &'static str,
    /// All of them.
    pub files: &'static [Asset],
    /// The file that browsers open. Its addresses are relative.
    pub root: &'static str,
    /// Its Content-Security-Policy.
    pub policy: &'static str,
}

impl Site {
    /// Answers with the file that browsers open.
    pub(crate) fn root(&self, headers: &HeaderMap) -> Result<Response, Problem> {
        self.answer(headers, self.root, |_| true)
    }

    /// Answers with one of the others.
    pub(crate) fn part(&self, headers: &HeaderMap, name: &str) -> Result<Response, Problem> {
        self.answer(headers, name, |name| name != self.root)
    }

    fn answer(
        &self,
        headers: &HeaderMap,
        name: &str,
        may: impl Fn(&str) -> bool,
    ) -> Result<Response, Problem> {
        let mut files = self.files.iter();
        let Some(file) = files.find(|file| file.name == name && may(name)) else {
            let detail = format!("{} has no {}", self.name, quoted(name));
            return Err(Problem::new(Kind::NotFound, detail));
        };
        answer(headers, file, self.policy)
            .map_err(|error| Problem::new(Kind::Internal, error.to_string()))
    }
}

/// The file as an answer to a request with these headers, under this Content-Security-Policy.
fn answer(headers: &HeaderMap, asset: &Asset, policy: &'static str) -> io::Result<Response> {
    let packed = coding::accepts(headers, Coding::Gzip);
    let tag = match packed {
        true => format!("\"{}-gzip\"", asset.hash),
        false => format!("\"{}\"", asset.hash),
    };
    let fixed = [
        (header::CACHE_CONTROL, "no-cache"),
        (header::CONTENT_SECURITY_POLICY, policy),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::VARY, "accept-encoding"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    ];
    let fixed = fixed.map(|(name, value): (HeaderName, _)| (name, HeaderValue::from_static(value)));
    let known = is_known(headers, &tag);
    let mut response = match (known, packed) {
        (true, _) => StatusCode::NOT_MODIFIED.into_response(),
        (false, true) => Bytes::from_static(asset.gzip).into_response(),
        (false, false) => asset.plain()?.into_response(),
    };
    let headers = response.headers_mut();
    headers.extend(fixed);
    // The hash is ASCII, so that this never fails.
    headers.extend(
        HeaderValue::try_from(tag)
            .ok()
            .map(|tag| (header::ETAG, tag)),
    );
    if !known {
        let media_type = HeaderValue::from_static(asset.media_type());
        headers.insert(header::CONTENT_TYPE, media_type);
        if packed {
            let coding = HeaderValue::from_static("gzip");
            headers.insert(header::CONTENT_ENCODING, coding);
        }
    }
    Ok(response)
}

/// Returns true if the client has the representation with this tag (`If-None-Match`, RFC 9110, 13.1.2).
fn is_known(headers: &HeaderMap, tag: &str) -> bool {
    let given = headers.get_all(header::IF_NONE_MATCH).iter();
    let mut tags = given.flat_map(|value| value.to_str().unwrap_or("").split(','));
    tags.any(|known| {
        let known = known.trim();
        known == "*" || known.strip_prefix("W/").unwrap_or(known) == tag
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(name: HeaderName, values: &[&str]) -> HeaderMap {
        let values = values.iter().map(|value| value.parse().unwrap());
        values.map(|value| (name.clone(), value)).collect()
    }

    #[test]
    fn tags_are_compared_weakly() {
        for (values, expected) in [
            (&[][..], false),
            (&["\"a\""], true),
            (&["W/\"a\""], true),
            (&["\"b\", \"a\""], true),
            (&["\"b\"", "\"a\""], true),
            (&["\"b\""], false),
            (&["*"], true),
            (&["a"], false),
        ] {
            let headers = headers(header::IF_NONE_MATCH, values);
            assert_eq!(is_known(&headers, "\"a\""), expected, "{values:?}");
        }
    }
}
