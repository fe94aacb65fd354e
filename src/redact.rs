//! Settings without passwords, for `piad config`, errors and the log.

use std::borrow::Cow;

/// The replacement of a secret.
const HIDDEN: &str = "***";

/// The ends of the names of passwords in connection strings and in queries.
const PASSWORDS: [&str; 3] = ["password", "passwd", "pwd"];

/// The value of a setting without its secrets: the user and the password of a URL (`postgres://user:password@host`,
/// also with a mistyped beginning), and all that follows a `password=`, as its end is not certain.
pub(crate) fn redacted(value: &str) -> Cow<'_, str> {
    let cut = match end_of_password_name(value) {
        Some(end) => Cow::Owned(format!("{}{HIDDEN}", value.get(..end).unwrap_or_default())),
        None => Cow::Borrowed(value),
    };
    match user(&cut) {
        Some((begin, end)) => Cow::Owned(format!(
            "{}{HIDDEN}{}",
            cut.get(..begin).unwrap_or_default(),
            cut.get(end..).unwrap_or_default()
        )),
        None => cut,
    }
}

/// Returns true if the value of a setting has a secret in it.
pub(crate) fn has_secret(value: &str) -> bool {
    end_of_password_name(value).is_some() || user(value).is_some()
}

/// The end of the first `password=`, perhaps with blanks before the sign.
fn end_of_password_name(value: &str) -> Option<usize> {
    let lower = value.to_ascii_lowercase();
    let ends = PASSWORDS.into_iter().flat_map(|name| {
        let found = lower.match_indices(name);
        let ends = found.filter_map(|(at, _)| {
            let rest = lower.get(at + name.len()..)?;
            let sign = rest.len() - rest.trim_start().len();
            let is_assigned = rest.trim_start().starts_with('=');
            is_assigned.then_some(at + name.len() + sign + 1)
        });
        ends.collect::<Vec<_>>()
    });
    ends.min()
}

/// The range of the user and the password of a URL. It reaches to the last `@`: a password may contain one, and
/// unescaped characters that end the authority of a URL.
fn user(value: &str) -> Option<(usize, usize)> {
    let end = value.rfind('@')?;
    let before = value.get(..end)?;
    if let Some(begin) = after_scheme(before) {
        return Some((begin, end));
    }
    before.contains(':').then_some((0, end))
}

/// The end of a scheme with its slashes, of which some may be missing.
fn after_scheme(text: &str) -> Option<usize> {
    let (scheme, rest) = text.split_once(":/")?;
    let is_scheme = |c: char| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.');
    if scheme.is_empty() || !scheme.chars().all(is_scheme) {
        return None;
    }
    let slashes = rest.len() - rest.trim_start_matches('/').len();
    Some(scheme.len() + 2 + slashes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passwords_are_hidden_in_every_form() {
        for (value, shown) in [
            ("postgres://u:secret@db/piad", "postgres://***@db/piad"),
            ("POSTGRES://u:secret@db/piad", "POSTGRES://***@db/piad"),
            (
                "postgresql://u:se@cr/et#@db:5432",
                "postgresql://***@db:5432",
            ),
            ("postgres:/u:secret@db/piad", "postgres:/***@db/piad"),
            ("postgres:u:secret@db/piad", "***@db/piad"),
            ("postgres//u:secret@db/piad", "***@db/piad"),
            ("u:secret@db", "***@db"),
            (
                "https://secret@collector:4317",
                "https://***@collector:4317",
            ),
            ("http://u:secret@[::1]:4317/", "http://***@[::1]:4317/"),
            (
                "postgres://db/piad?user=u&password=secret&sslmode=require",
                "postgres://db/piad?user=u&password=***",
            ),
            (
                "postgres://u:secret@db/piad?sslpassword=sec@ret",
                "postgres://***@db/piad?sslpassword=***",
            ),
            (
                "host=db password=secret dbname=piad",
                "host=db password=***",
            ),
            ("host=db password = 'sec ret'", "host=db password =***"),
            (
                "host=db PASSWORD='it\\'s secret' port=5",
                "host=db PASSWORD=***",
            ),
            ("Server=db;Pwd=secret;", "Server=db;Pwd=***"),
        ] {
            assert_eq!(redacted(value), shown, "{value}");
            assert!(
                has_secret(value) && !redacted(value).contains("ret"),
                "{value}"
            );
        }
    }

    #[test]
    fn what_has_no_password_is_shown() {
        for value in [
            "",
            "/srv/me@home/piad-data",
            "./passwords",
            "postgres://db.example/piad?sslmode=verify-full",
            "127.0.0.1:8080",
            "http://localhost:4317",
            "info,piad::job=debug",
        ] {
            assert_eq!(redacted(value), value);
            assert!(!has_secret(value), "{value}");
        }
    }
}
