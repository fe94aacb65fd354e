//! Origins of pages.

use std::fmt;
use std::str::FromStr;

use axum::http::{HeaderValue, Uri};

/// An origin, as a browser writes it; or any.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// `*`
    Any,
    /// Such as `https://cad.example:8443`.
    One(HeaderValue),
}

impl FromStr for Origin {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "*" {
            return Ok(Self::Any);
        }
        let why = || {
            "not *, and not an origin such as https://cad.example or http://localhost:3000, without a path".to_owned()
        };
        let text = text.to_ascii_lowercase();
        let uri: Uri = text.parse().map_err(|_| why())?;
        let (Some(scheme), Some(authority)) = (uri.scheme_str(), uri.authority()) else {
            return Err(why());
        };
        if format!("{scheme}://{authority}") != text || text.contains(['@', '*']) {
            return Err(why());
        }
        text.parse().map(Self::One).map_err(|_| why())
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => f.write_str("*"),
            Self::One(origin) => f.write_str(origin.to_str().unwrap_or("")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_written_as_browsers_do() {
        for text in [
            "*",
            "https://cad.example",
            "http://localhost:3000",
            "http://[::1]:80",
        ] {
            assert_eq!(text.parse::<Origin>().unwrap().to_string(), text);
        }
        let upper: Origin = "HTTPS://Cad.Example".parse().unwrap();
        assert_eq!(upper.to_string(), "https://cad.example");
        for text in [
            "",
            "cad.example",
            "https://cad.example/",
            "https://cad.example/path",
            "https://*.example",
            "https://a@b.example",
            "null",
            "https://",
        ] {
            assert!(text.parse::<Origin>().is_err(), "{text}");
        }
    }
}
