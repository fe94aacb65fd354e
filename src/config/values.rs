//! Values of settings that are not numbers, and their parsing.

use std::fmt;
use std::net::IpAddr;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::ValueEnum;
use ipnet::IpNet;
use jiff::SignedDuration;

use crate::job::store::StorePlace;
use crate::job::store::shared::Settings;
use crate::redact;

/// The files of certificates, all of them in PEM.
#[derive(Clone, Debug)]
pub(crate) struct TlsFiles {
    /// The certificate of the server, followed by those of the authorities below the root.
    pub(crate) certificate: PathBuf,
    /// Its private key.
    pub(crate) key: PathBuf,
    /// Authorities, one of which must have signed the certificate of each client.
    pub(crate) clients: Option<PathBuf>,
}

/// The addresses of trusted proxies: a network such as 10.0.0.0/8, or one address.
pub fn network(text: &str) -> Result<IpNet, String> {
    let network = text.parse();
    network
        .or_else(|_| text.parse().map(|address: IpAddr| address.into()))
        .map_err(|_| "not a network such as 10.0.0.0/8, or an address".to_owned())
}

/// The path below which clients see a server: empty, or such as `/fits`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BasePath(String);

impl BasePath {
    /// Without a slash at the end.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for BasePath {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let path = text.trim_end_matches('/');
        let plain = |c: char| c.is_ascii_alphanumeric() || "-._~".contains(c);
        let mut parts = path.split('/');
        let begins = parts.next() == Some("");
        let whole = parts
            .all(|part| !part.is_empty() && part != "." && part != ".." && part.chars().all(plain));
        match begins && whole && !text.is_empty() {
            true => Ok(Self(path.to_owned())),
            false => Err("a path such as /fits, of letters, digits, -, ., _ and ~".to_owned()),
        }
    }
}

impl fmt::Display for BasePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_empty() { "/" } else { &self.0 })
    }
}

/// The place of jobs.
#[derive(Clone, PartialEq, Eq)]
pub enum Storage {
    /// In memory: they end with the server.
    Memory,
    /// In a file of this directory.
    Directory(PathBuf),
    /// In the PostgreSQL database of this URL.
    Database(String),
}

impl Storage {
    /// The place of the store; a database is used with these settings.
    pub(crate) fn place(&self, settings: Settings) -> StorePlace<'_> {
        match self {
            Self::Memory => StorePlace::Memory,
            Self::Directory(path) => StorePlace::Directory(path),
            Self::Database(url) => StorePlace::Database(url, settings),
        }
    }
}

/// Without the URL of a database, which may contain a password.
impl fmt::Debug for Storage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Memory => f.write_str(":memory:"),
            Self::Directory(path) => write!(f, "{path:?}"),
            Self::Database(_) => f.write_str("a database"),
        }
    }
}

impl FromStr for Storage {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            ":memory:" => Ok(Self::Memory),
            "" => Err("a directory, :memory: or the URL of a database".to_owned()),
            url if is_database(url) => match ignored_password(url) {
                None => Ok(Self::Database(url.to_owned())),
                Some(key) => Err(format!("the parameter {key} is not supported")),
            },
            text if is_meant_for_database(text) => {
                Err("a database has a URL that begins with postgres://".to_owned())
            }
            path => Ok(Self::Directory(path.into())),
        }
    }
}

fn is_database(text: &str) -> bool {
    let scheme = text.split_once("://").map(|(scheme, _)| scheme);
    let schemes = ["postgres", "postgresql"];
    scheme.is_some_and(|scheme| schemes.iter().any(|it| scheme.eq_ignore_ascii_case(it)))
}

/// A parameter with a password that connections would ignore, and show in the log.
fn ignored_password(url: &str) -> Option<&str> {
    let (_, query) = url.split_once('?')?;
    let mut keys = query
        .split('&')
        .filter_map(|pair| Some(pair.split_once('=')?.0));
    keys.find(|key| *key != "password" && redact::has_secret(&format!("{key}=")))
}

/// Returns true for a mistyped URL and for a connection string such as `host=db user=piad`. As the name of a directory
/// it would be shown with its password.
fn is_meant_for_database(text: &str) -> bool {
    const KEYS: [&str; 5] = ["host", "hostaddr", "user", "dbname", "service"];
    let lower = text.to_ascii_lowercase();
    let is_key = |word: &str| {
        word.split_once('=')
            .is_some_and(|(key, _)| KEYS.contains(&key))
    };
    let is_scheme = ["postgres:", "postgresql:"]
        .iter()
        .any(|it| lower.starts_with(it));
    let is_url = lower.contains("://") || is_scheme;
    is_url || lower.split_whitespace().any(is_key) || redact::has_secret(text)
}

/// The lifetime of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lifetime {
    /// This long.
    For(SignedDuration),
    /// Until it is revoked.
    Never,
}

impl FromStr for Lifetime {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "never" {
            return Ok(Self::Never);
        }
        let time: Result<SignedDuration, _> = text.parse();
        match time {
            Ok(time) if time.is_positive() => Ok(Self::For(time)),
            _ => Err("not a time such as 720h, or never".to_owned()),
        }
    }
}

/// The format of log lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// For people.
    Text,
    /// One JSON object a line.
    Json,
}

/// A name, or all names below one.
pub(super) fn host_name(text: &str) -> Result<String, String> {
    let name = text.strip_prefix("*.").unwrap_or(text);
    match text != "*" && (name.is_empty() || name.contains('*')) {
        true => Err("not a name such as fit.example.org, *.example.org or *".to_owned()),
        false => Ok(text.to_owned()),
    }
}

pub(super) fn duration(text: &str) -> Result<Duration, String> {
    let duration: SignedDuration = text
        .parse()
        .map_err(|_| "not a duration such as 36h or 90m".to_owned())?;
    Duration::try_from(duration).map_err(|_| "a duration is not negative".to_owned())
}

pub(super) fn some_seconds(text: &str) -> Result<Duration, String> {
    match seconds(text)? {
        seconds if seconds < Duration::from_millis(10) => {
            Err("must be at least 0.01 seconds".to_owned())
        }
        seconds => Ok(seconds),
    }
}

pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text
        .parse()
        .map_err(|_| "not a number of seconds".to_owned())?;
    match Duration::try_from_secs_f64(seconds) {
        Ok(duration) if duration <= Duration::from_secs(86_400) => Ok(duration),
        _ => Err("must lie between 0 and 86400 seconds".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn databases_have_urls_and_all_else_is_a_directory() {
        for text in [
            "postgres://db/piad",
            "POSTGRES://u:pw@db",
            "PostgreSQL://db",
        ] {
            assert_eq!(
                text.parse::<Storage>(),
                Ok(Storage::Database(text.to_owned()))
            );
        }
        for text in ["./piad-data", "/srv/postgres", "a=b", "/srv/me@home"] {
            assert_eq!(text.parse::<Storage>(), Ok(Storage::Directory(text.into())));
        }
        for text in [
            "",
            "mysql://db/piad",
            "postgres:/u:pw@db/piad",
            "Postgres:db",
            "postgres//u:pw@db/piad",
            "host=db password=pw",
            "port=5432 user=piad",
            "password='pw'",
            "postgres://db/piad?password=pw&sslpassword=pw",
        ] {
            let refused = text.parse::<Storage>().unwrap_err();
            assert!(!refused.contains("pw"), "{text}: {refused}");
        }
    }
}
