//! The name under which browsers and `curl -OJ` save a file: that of its job, made safe for any system
//! (RFC 6266).

use axum::http::{HeaderValue, header};
use axum::response::Response;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};

use crate::job::outline::Outline;

/// The most bytes that are used of a job's name: file systems allow 255 for the whole file name.
const MOST_BYTES: usize = 180;

/// The characters that `filename*` does not percent-encode (`attr-char` of RFC 8187).
const ATTR_CHAR: &AsciiSet = &NON_ALPHANUMERIC
    .remove(b'-')
    .remove(b'.')
    .remove(b'_')
    .remove(b'~');

/// The kind of contents in an answer about a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// The job as it was accepted.
    Input,
    /// The curve or surface of an iteration.
    Iteration(usize),
    /// The result.
    Result,
}

/// The answer with a name for the saved file.
pub(super) fn named(
    mut response: Response,
    outline: &Outline,
    part: Part,
    extension: &str,
) -> Response {
    let name = file_name(outline, part, extension);
    // The value consists of visible ASCII characters, so that this never fails.
    if let Ok(value) = HeaderValue::try_from(disposition(&name)) {
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_DISPOSITION, value);
    }
    response
}

/// The Content-Disposition with the name in ASCII, for old clients, and in UTF-8.
fn disposition(name: &str) -> String {
    // Some clients decode percent signs in the ASCII name, too.
    let plain = |c: char| matches!(c, ' '..='~') && c != '%';
    let ascii: String = name
        .chars()
        .map(|c| if plain(c) { c } else { '_' })
        .collect();
    let exact = utf8_percent_encode(name, ATTR_CHAR);
    format!("inline; filename=\"{ascii}\"; filename*=UTF-8''{exact}")
}

/// The name of a file, such as `naca2412.step`, `naca2412-7.step` of iteration 7, or `naca2412-input.json`.
/// For jobs without a name it has their id.
fn file_name(outline: &Outline, part: Part, extension: &str) -> String {
    let name = outline.label.name.as_deref().unwrap_or_default();
    let stem = stem(name, extension).unwrap_or_else(|| format!("piad-{}", outline.id));
    match part {
        Part::Input => format!("{stem}-input.{extension}"),
        Part::Iteration(k) => format!("{stem}-{k}.{extension}"),
        Part::Result => format!("{stem}.{extension}"),
    }
}

/// A job's name made safe: it cannot be a path or a hidden file, break out of the header, or display as
/// something else. `None` if nothing meaningful is left.
fn stem(name: &str, extension: &str) -> Option<String> {
    let safe = |c| if is_unsafe(c) { '_' } else { c };
    let mut length = 0;
    let fits = |c: &char| {
        length += c.len_utf8();
        length <= MOST_BYTES
    };
    let stem: String = name.chars().map(safe).take_while(fits).collect();
    let stem = trimmed(&stem);
    // A job named wing.step does not become wing.step.step.
    let stem = match stem.rsplit_once('.') {
        Some((before, end)) if end.eq_ignore_ascii_case(extension) => trimmed(before),
        _ => stem,
    };
    let says_something = stem.chars().any(|c| !matches!(c, '_' | ' ' | '.'));
    says_something.then(|| stem.to_owned())
}

fn trimmed(name: &str) -> &str {
    name.trim_matches(|c: char| c == '.' || c.is_whitespace())
}

/// Returns true if a character is a path separator, is reserved on some system, or is an invisible control or
/// formatting character, such as those that change the direction of writing.
fn is_unsafe(c: char) -> bool {
    let reserved = matches!(c, '/' | '\\' | ':' | '*' | '?' | '"' | '<' | '>' | '|');
    let unseen = matches!(
        c,
        '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}'
    );
    reserved || unseen || c.is_control()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn names_are_made_safe() {
        for (name, expected) in [
            ("naca2412", Some("naca2412")),
            ("wing, left (2)", Some("wing, left (2)")),
            ("wing.STEP", Some("wing")),
            ("wing.stl", Some("wing.stl")),
            ("../../etc/passwd", Some("_.._etc_passwd")),
            ("C:\\con\\aux", Some("C__con_aux")),
            ("a\"; filename=\"b", Some("a_; filename=_b")),
            ("a\r\nSet-Cookie: b=c", Some("a__Set-Cookie_ b=c")),
            ("txt.\u{202e}pets", Some("txt._pets")),
            (" .hidden. ", Some("hidden")),
            ("Flügel 翼", Some("Flügel 翼")),
            ("", None),
            ("...", None),
            ("/", None),
            (".step", Some("step")),
        ] {
            assert_eq!(stem(name, "step").as_deref(), expected, "{name:?}");
        }
        let long = stem(&"翼".repeat(500), "step").unwrap();
        assert_eq!(long, "翼".repeat(60));
    }

    #[test]
    fn both_forms_of_a_name() {
        assert_eq!(
            disposition("Flügel 100%.step"),
            "inline; filename=\"Fl_gel 100_.step\"; filename*=UTF-8''Fl%C3%BCgel%20100%25.step"
        );
    }

    proptest! {
        /// For any name of a job, its file has one plain name, and the header is one line.
        #[test]
        fn no_name_breaks_out(name in any::<String>()) {
            let stem = stem(&name, "step").unwrap_or_else(|| "curve".to_owned());
            let file = format!("{stem}.step");
            prop_assert!(!file.starts_with('.') && file.len() <= 255);
            prop_assert_eq!(std::path::Path::new(&file).components().count(), 1);
            let header = disposition(&file);
            prop_assert!(header.bytes().all(|b| (b' '..=b'~').contains(&b)), "{}", header);
            prop_assert_eq!(header.matches('"').count(), 2);
            prop_assert!(!header.contains('\\'));
        }
    }
}
