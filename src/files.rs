//! Reads files with a limit of their size: endless ones, such as /dev/zero, would fill the memory.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use bytesize::ByteSize;

/// The largest files of settings, tokens and certificates.
pub(crate) const MAX_SETTINGS_BYTES: u64 = 16 << 20;

/// Reads a file of at most `max_bytes` bytes.
///
/// # Errors
///
/// If it cannot be read, or is larger (`FileTooLarge`).
pub(crate) fn read(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let about = file.metadata()?;
    // Devices and pipes have no length.
    let length = if about.is_file() { about.len() } else { 0 };
    if length > max_bytes {
        return Err(too_large(max_bytes));
    }
    let room = usize::try_from(length).unwrap_or_default();
    read_into(Vec::with_capacity(room), file, max_bytes)
}

/// The text of a file of settings.
///
/// # Errors
///
/// If it cannot be read, is too large or is not UTF-8.
pub(crate) fn read_settings(path: &Path) -> io::Result<String> {
    let bytes = read(path, MAX_SETTINGS_BYTES)?;
    String::from_utf8(bytes).map_err(|_| io::Error::new(ErrorKind::InvalidData, "it is not UTF-8"))
}

/// Reads an input of at most `max_bytes` bytes.
///
/// # Errors
///
/// If it cannot be read, or is larger (`FileTooLarge`).
pub(crate) fn read_from(input: impl Read, max_bytes: u64) -> io::Result<Vec<u8>> {
    read_into(Vec::new(), input, max_bytes)
}

fn read_into(mut bytes: Vec<u8>, input: impl Read, max_bytes: u64) -> io::Result<Vec<u8>> {
    input
        .take(max_bytes.saturating_add(1))
        .read_to_end(&mut bytes)?;
    match bytes.len() as u64 > max_bytes {
        true => Err(too_large(max_bytes)),
        false => Ok(bytes),
    }
}

fn too_large(max_bytes: u64) -> io::Error {
    let reason = format!("larger than {}", ByteSize(max_bytes));
    io::Error::new(ErrorKind::FileTooLarge, reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_read_beyond_the_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, "1234").unwrap();
        assert_eq!(read(&path, 4).unwrap(), b"1234");
        assert_eq!(read(&path, 3).unwrap_err().kind(), ErrorKind::FileTooLarge);
        assert_eq!(read_from(io::repeat(0).take(4), 4).unwrap(), [0; 4]);
        let endless = read_from(io::repeat(0), 1 << 20).unwrap_err();
        assert_eq!(endless.to_string(), "larger than 1.0 MiB");
    }
}
