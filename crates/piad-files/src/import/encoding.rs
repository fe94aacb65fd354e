//! Text in UTF-16, as some programs of Windows write it, becomes UTF-8.

use std::borrow::Cow;

use super::error::FileError;
use crate::text::without_mark;

/// The number of bytes examined to detect that a text without a byte-order mark is UTF-16.
const LOOKED_AT: usize = 64;

/// The least number of bytes that shows it.
const LEAST: usize = 8;

/// The error for UTF-32.
const UTF_32: &str = "this is text in UTF-32: save it as UTF-8";

/// A file without a byte-order mark, converted to UTF-8 if it was text in UTF-16; all others are unchanged.
///
/// # Errors
///
/// If it is text in UTF-32.
pub(super) fn as_utf8(file: &[u8]) -> Result<Cow<'_, [u8]>, FileError> {
    match file {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Err(FileError::of_file(UTF_32)),
        [0xff, 0xfe, text @ ..] => Ok(decoded(text, u16::from_le_bytes)),
        [0xfe, 0xff, text @ ..] => Ok(decoded(text, u16::from_be_bytes)),
        _ if zeros(file, &[1, 2, 3]) || zeros(file, &[0, 1, 2]) => Err(FileError::of_file(UTF_32)),
        _ if zeros(file, &[1, 3]) => Ok(decoded(file, u16::from_le_bytes)),
        _ if zeros(file, &[0, 2]) => Ok(decoded(file, u16::from_be_bytes)),
        _ => Ok(Cow::Borrowed(without_mark(file))),
    }
}

/// Returns true if of each four bytes that a file begins with exactly these are zero.
fn zeros(file: &[u8], places: &[usize]) -> bool {
    let start = file.get(..LOOKED_AT).unwrap_or(file);
    let mut bytes = start.iter().enumerate();
    start.len() >= LEAST && bytes.all(|(index, byte)| places.contains(&(index % 4)) == (*byte == 0))
}

/// A text in UTF-16. Invalid characters become replacement characters.
fn decoded(text: &[u8], unit: fn([u8; 2]) -> u16) -> Cow<'_, [u8]> {
    let (units, _) = text.as_chunks::<2>();
    let characters = char::decode_utf16(units.iter().map(|it| unit(*it)));
    let text: String = characters
        .map(|it| it.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect();
    Cow::Owned(text.into_bytes())
}

#[cfg(test)]
mod tests {
    use crate::import::tests::HINTS;
    use crate::import::{Imported, read as read_file};

    fn read(bytes: &[u8]) -> Result<Imported, String> {
        read_file(bytes, &HINTS).map_err(|errors| errors.to_string())
    }

    #[test]
    fn text_may_be_utf_16() {
        let text = "Flügel 𝄞\r\n1 2\r\n3 4.5\r\n";
        let plain = read(text.as_bytes()).unwrap();
        assert_eq!(plain.name.as_deref(), Some("Flügel 𝄞"));
        for mark in ["\u{feff}", ""] {
            // Without a mark the text begins with letters of one byte.
            let text = match mark {
                "" => text.replace('ü', "ue").replace('𝄞', "G"),
                _ => text.to_owned(),
            };
            let units: Vec<u16> = format!("{mark}{text}").encode_utf16().collect();
            let little: Vec<u8> = units.iter().flat_map(|it| it.to_le_bytes()).collect();
            let big: Vec<u8> = units.iter().flat_map(|it| it.to_be_bytes()).collect();
            for bytes in [little, big] {
                let found = read(&bytes).unwrap();
                assert_eq!(found.points, plain.points);
                assert_eq!(found.name.as_deref(), text.lines().next());
            }
        }
        // Half a character, and an invalid one.
        assert_eq!(
            read(b"\xff\xfe1\0\n\x002\0\n\0\x00").unwrap().points.len(),
            2
        );
        assert!(read(b"\xff\xfe\x00\xd8 \0\x001\0\n\x00").is_err());
        assert!(read(b"\xff\xfe").unwrap_err().contains("no points"));
    }

    #[test]
    fn utf_32_is_named() {
        for mark in ["\u{feff}", ""] {
            let text = format!("{mark}1 2\n3 4\n");
            let little: Vec<u8> = text
                .chars()
                .flat_map(|c| u32::from(c).to_le_bytes())
                .collect();
            let big: Vec<u8> = text
                .chars()
                .flat_map(|c| u32::from(c).to_be_bytes())
                .collect();
            for bytes in [little, big] {
                assert_eq!(read(&bytes).unwrap_err(), super::UTF_32);
            }
        }
    }
}
