//! Content codings: compression of bodies (RFC 9110, 8.4).
//!
//! gzip is supported by all clients. zstd is several times as fast at about the same size; browsers and curl support
//! it. zlib-rs for gzip is written in Rust; zstd uses the reference implementation in C, as no encoder in Rust is as
//! good, and the allocator needs a C compiler anyway.

use axum::http::{HeaderMap, header};

use crate::api::problem::{Kind, Problem};
use piad_files::text::quoted;

/// A coding of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coding {
    Gzip,
    Zstd,
}

/// The codings that bodies may have, as a header lists them.
pub(crate) const UNDERSTOOD: &str = "gzip, zstd";

impl Coding {
    /// Its name in headers.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Gzip => "gzip",
            Self::Zstd => "zstd",
        }
    }

    fn of_name(name: &str) -> Option<Self> {
        let is = |known: &str| name.eq_ignore_ascii_case(known);
        match name {
            _ if is("gzip") || is("x-gzip") => Some(Self::Gzip),
            _ if is("zstd") => Some(Self::Zstd),
            _ => None,
        }
    }
}

/// The coding of the body of a request, if it has one.
pub(crate) fn of_body(headers: &HeaderMap) -> Result<Option<Coding>, Problem> {
    let mut found = None;
    for value in headers.get_all(header::CONTENT_ENCODING) {
        let given = String::from_utf8_lossy(value.as_bytes());
        let plain = |name: &&str| !name.is_empty() && !name.eq_ignore_ascii_case("identity");
        for name in given.split(',').map(str::trim).filter(plain) {
            let refuse = |why: &str| {
                let detail = format!(
                    "the body is encoded as {}{why}; {UNDERSTOOD} and no coding at all are supported",
                    quoted(name)
                );
                Problem::new(Kind::UnsupportedEncoding, detail)
            };
            let coding = Coding::of_name(name).ok_or_else(|| refuse(""))?;
            if found.replace(coding).is_some() {
                return Err(refuse(", after another coding"));
            }
        }
    }
    Ok(found)
}

/// Returns true if a client prefers no other coding to this one (RFC 9110, 12.5.3).
pub(crate) fn accepts(headers: &HeaderMap, coding: Coding) -> bool {
    let named = |name: &str| Coding::of_name(name) == Some(coding);
    let plain = quality(headers, |name| name.eq_ignore_ascii_case("identity")).unwrap_or(0.0);
    let quality = quality(headers, named).or_else(|| quality(headers, |name| name == "*"));
    quality.is_some_and(|quality| quality > 0.0 && quality >= plain)
}

/// The quality that Accept-Encoding gives to a name.
fn quality(headers: &HeaderMap, is_it: impl Fn(&str) -> bool) -> Option<f64> {
    let given = headers.get_all(header::ACCEPT_ENCODING).iter();
    let mut codings = given.flat_map(|value| value.to_str().unwrap_or("").split(','));
    codings.find_map(|coding| {
        let mut parts = coding.split(';').map(str::trim);
        let name = parts.next().unwrap_or("");
        let quality = parts.find_map(|part| {
            let (name, value) = part.split_once('=')?;
            name.trim().eq_ignore_ascii_case("q").then(|| value.trim())
        });
        // A quality that is not a number counts as zero.
        let quality = quality.map_or(1.0, |value| value.parse().unwrap_or(0.0));
        is_it(name).then_some(quality)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clients_choose_codings() {
        for (values, expected) in [
            (&[][..], false),
            (&[""], false),
            (&["br, deflate"], false),
            (&["x-gzip"], true),
            (&["br, GZIP;q=0.5"], true),
            (&["br", "gzip"], true),
            (&["gzip;q=0"], false),
            (&["gzip ; Q = 0.000"], false),
            (&["gzip;q=0, *"], false),
            (&["*"], true),
            (&["*;q=0"], false),
            (&["*;q=0, gzip;q=0.1"], true),
            (&["identity, gzip;q=0.5"], false),
            (&["identity;q=0.5, gzip"], true),
            (&["identity, gzip"], true),
            (&["gzip;q=much"], false),
            (&["gzip;q=NaN"], false),
        ] {
            let headers = values.iter().map(|value| value.parse().unwrap());
            let headers = headers.map(|value| (header::ACCEPT_ENCODING, value));
            assert_eq!(
                accepts(&headers.collect(), Coding::Gzip),
                expected,
                "{values:?}"
            );
        }
    }

    #[test]
    fn bodies_have_one_coding_at_most() {
        let coding = |values: &[&str]| {
            let values = values.iter().map(|value| value.parse().unwrap());
            of_body(
                &values
                    .map(|value| (header::CONTENT_ENCODING, value))
                    .collect(),
            )
        };
        for (values, expected) in [
            (&[][..], None),
            (&["identity"], None),
            (&["gzip"], Some(Coding::Gzip)),
            (&["X-GZip"], Some(Coding::Gzip)),
            (&["identity, zstd"], Some(Coding::Zstd)),
        ] {
            assert_eq!(coding(values).unwrap(), expected, "{values:?}");
        }
        for values in [
            &["br"][..],
            &["gzip, gzip"],
            &["gzip", "zstd"],
            &["deflate"],
        ] {
            assert!(coding(values).is_err(), "{values:?}");
        }
    }
}
