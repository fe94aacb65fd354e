//! Content codings: how the bytes of a body are compressed (RFC 9110, 8.4).
//!
//! gzip is what everybody has. zstd is several times as fast at about the same size; browsers and curl
//! have it, too. zlib-rs, which does the one, is written in Rust; the other is done by the reference
//! implementation in C, as no encoder in Rust is as good, and as the allocator needs a C compiler anyway.

use axum::http::{HeaderMap, header};

use crate::api::problem::{Kind, Problem};
use crate::model::short::quoted;

/// A coding that is understood both ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coding {
    Gzip,
    Zstd,
}

/// The codings that bodies may have, as a header lists them.
pub const UNDERSTOOD: &str = "gzip, zstd";

impl Coding {
    /// What it is called in headers.
    pub fn name(self) -> &'static str {
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
pub fn of_body(headers: &HeaderMap) -> Result<Option<Coding>, Problem> {
    let mut found = None;
    for value in headers.get_all(header::CONTENT_ENCODING) {
        let given = String::from_utf8_lossy(value.as_bytes());
        let plain = |name: &&str| !name.is_empty() && !name.eq_ignore_ascii_case("identity");
        for name in given.split(',').map(str::trim).filter(plain) {
            let refuse = |why: &str| {
                let detail = format!(
                    "the body is encoded as {}{why}; {UNDERSTOOD} and no coding at all are understood",
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

/// The coding of these that a client likes best (RFC 9110, 12.5.3); of those that it likes alike the
/// first. None if it takes none of them, or would rather have the bytes as they are.
pub fn choose(headers: &HeaderMap, available: &[Coding]) -> Option<Coding> {
    let quality = |coding: Coding| {
        let named = |name: &str| Coding::of_name(name) == Some(coding);
        quality(headers, named).or_else(|| quality(headers, |name| name == "*"))
    };
    let mut best = None;
    let mut most = quality_of_identity(headers);
    for &coding in available {
        let quality = quality(coding).unwrap_or(0.0);
        // As good as the bytes as they are is better, as it is shorter.
        if quality > 0.0 && (quality > most || (best.is_none() && quality >= most)) {
            (best, most) = (Some(coding), quality);
        }
    }
    best
}

/// What a client says of bytes as they are: nothing is less than any coding that it takes.
fn quality_of_identity(headers: &HeaderMap) -> f64 {
    quality(headers, |name| name.eq_ignore_ascii_case("identity")).unwrap_or(0.0)
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
        // What is no number is refused rather than sent.
        let quality = quality.map_or(1.0, |value| value.parse().unwrap_or(0.0));
        is_it(name).then_some(quality)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(values: &[&str]) -> Option<Coding> {
        let values = values.iter().map(|value| value.parse().unwrap());
        let headers = values
            .map(|value| (header::ACCEPT_ENCODING, value))
            .collect();
        choose(&headers, &[Coding::Zstd, Coding::Gzip])
    }

    #[test]
    fn clients_get_the_coding_that_they_like_best() {
        let (gzip, zstd) = (Some(Coding::Gzip), Some(Coding::Zstd));
        for (values, expected) in [
            (&[][..], None),
            (&[""], None),
            (&["br, deflate"], None),
            (&["gzip"], gzip),
            (&["x-gzip"], gzip),
            (&["br, GZIP;q=0.5"], gzip),
            (&["br", "zstd"], zstd),
            // What Chromium sends.
            (&["gzip, deflate, br, zstd"], zstd),
            (&["gzip;q=1.0, zstd;q=0.5"], gzip),
            (&["gzip;q=0"], None),
            (&["gzip ; Q = 0.000"], None),
            (&["gzip;q=0, *"], zstd),
            (&["*"], zstd),
            (&["*;q=0"], None),
            (&["*;q=0, gzip;q=0.1"], gzip),
            (&["identity, gzip;q=0.5"], None),
            (&["identity;q=0.5, gzip"], gzip),
            (&["identity, gzip"], gzip),
            (&["gzip;q=much"], None),
            (&["gzip;q=NaN"], None),
        ] {
            assert_eq!(choice(values), expected, "{values:?}");
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
