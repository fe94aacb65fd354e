//! The address of the collector: a flag, or the variables of OpenTelemetry.

use std::env;

use axum::http::Uri;

use crate::redact::redacted;

/// The variables, of which the first that is set counts.
const STANDARD: [&str; 2] = [
    "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT",
    "OTEL_EXPORTER_OTLP_ENDPOINT",
];

/// The expected form of an address.
const SUCH_AS: &str =
    "the address of a collector of OTLP over gRPC is such as http://localhost:4317";

/// The address of a collector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Endpoint(Uri);

impl Endpoint {
    /// The address that is set, by the flag or by a standard variable, if any is.
    ///
    /// # Errors
    ///
    /// If it is invalid; the error names the setting and the reason.
    pub fn find(flag: Option<&str>) -> Result<Option<Self>, String> {
        let flag = flag.map(|url| ("--otlp-endpoint", url.to_owned()));
        let set = |name| Some((name, env::var(name).ok()?)).filter(|(_, url)| !url.is_empty());
        let found = match flag {
            Some(flag) => Some(flag).filter(|(_, url)| !url.is_empty()),
            None if is_disabled() => None,
            None => STANDARD.into_iter().find_map(set),
        };
        let parsed = found.map(|(name, url)| {
            let shown = redacted(&url);
            Self::of(&url).map_err(|reason| format!("{name} {shown:?}: {reason}"))
        });
        parsed.transpose()
    }

    fn of(url: &str) -> Result<Self, String> {
        let uri: Uri = url
            .parse()
            .map_err(|reason| format!("{reason}; {SUCH_AS}"))?;
        if !matches!(uri.scheme_str(), Some("http" | "https")) {
            return Err(format!("neither http:// nor https://; {SUCH_AS}"));
        }
        if uri.path() != "/" || uri.query().is_some() {
            return Err(format!(
                "over gRPC there is no path and no query, which are of OTLP over HTTP; {SUCH_AS}"
            ));
        }
        if uri.authority().is_some_and(|it| it.as_str().contains('@')) {
            return Err("no user: OTEL_EXPORTER_OTLP_HEADERS says who the server is".to_owned());
        }
        // An invalid port is not detected by the parser.
        if uri
            .authority()
            .is_some_and(|it| it.port().is_none() && it.as_str() != it.host())
        {
            return Err(format!("it has no valid port; {SUCH_AS}"));
        }
        Ok(Self(uri))
    }

    pub(super) fn url(&self) -> String {
        self.0.to_string()
    }

    /// Returns true if the connection is encrypted.
    pub(super) fn is_secure(&self) -> bool {
        self.0.scheme_str() == Some("https")
    }
}

/// Returns true if OpenTelemetry is switched off for programs that read its variables.
fn is_disabled() -> bool {
    env::var("OTEL_SDK_DISABLED").is_ok_and(|value| value.eq_ignore_ascii_case("true"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_those_of_grpc() {
        for url in [
            "http://localhost:4317",
            "https://collector.example:4317/",
            "http://[::1]:4317",
            "HTTP://collector.example",
        ] {
            assert!(Endpoint::of(url).is_ok(), "{url}");
        }
        for (url, reason) in [
            ("localhost:4317", "neither http:// nor https://"),
            ("grpc://localhost:4317", "neither http:// nor https://"),
            ("/var/run/collector", "neither http:// nor https://"),
            ("http://", "such as http://localhost:4317"),
            ("http://a b", "such as http://localhost:4317"),
            ("http://localhost:99999", "such as http://localhost:4317"),
            ("http://localhost:4318/v1/traces", "OTLP over HTTP"),
            ("http://localhost:4317/?a=b", "OTLP over HTTP"),
            (
                "http://me:secret@localhost:4317",
                "OTEL_EXPORTER_OTLP_HEADERS",
            ),
        ] {
            let refused = Endpoint::of(url).unwrap_err();
            assert!(refused.contains(reason), "{url}: {refused}");
        }
    }
}
