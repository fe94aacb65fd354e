//! Reads TOML. Errors name the line but do not quote it, as it may hold a secret.

use serde::de::DeserializeOwned;

/// Reads a text.
///
/// # Errors
///
/// The line, if it is known, and the error.
pub(crate) fn parse<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    toml::from_str(text).map_err(|error| {
        let message = without_texts(error.message());
        match error.span() {
            None => message,
            Some(span) => {
                let before = text.get(..span.start).unwrap_or(text);
                let line = 1 + before.matches('\n').count();
                format!("line {line}: {message}")
            }
        }
    })
}

/// A message without the quoted texts of the file.
fn without_texts(message: &str) -> String {
    match (message.split_once('"'), message.rsplit_once('"')) {
        (Some((before, _)), Some((until, after))) if before.len() < until.len() => {
            format!("{before}\"…\"{after}")
        }
        _ => message.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn errors_show_nothing_of_the_text() {
        for text in [
            "a = 'x'\nstore = postgres://u:secret@db",
            "a = 'x'\nstore = \"postgres://u:secret@db",
            "a = 'x'\nstore 'secret'",
            "a = 'x'\nsecret",
            "a = 'x'\nstore = 'secret' 'secret'",
            "a = 'x'\nstore = [\"secret\"",
        ] {
            let error = parse::<toml::Table>(text).unwrap_err();
            assert!(error.starts_with("line 2: "), "{text}: {error}");
            assert!(!error.contains("secret"), "{text}: {error}");
        }
        let error = parse::<BTreeMap<String, u32>>("a = 1\nb = 'a \"secret\"'").unwrap_err();
        assert!(
            error.contains("line 2: invalid type: string \"…\""),
            "{error}"
        );
    }
}
