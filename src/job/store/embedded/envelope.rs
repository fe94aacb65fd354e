//! The envelope before each value in the file: its kind, its job, its length, and a checksum of all this.
//!
//! The envelope shows on reading that a bit of a value has changed, and lets values be found in a file whose pages do
//! not lead to them any more ([`salvage`](super::salvage)).

use std::fmt::Display;

use crc32fast::Hasher;
use uuid::Uuid;

use crate::job::store::StoreError;

/// The magic bytes of each envelope.
pub(super) const MAGIC: &[u8; 8] = b"\x89piadjob";

/// The offsets of the parts of an envelope, and its length.
const KIND: usize = MAGIC.len();
const ID: usize = KIND + 1;
const LENGTH: usize = ID + 16;
const CHECKSUM: usize = LENGTH + 8;
pub(super) const BYTES: usize = CHECKSUM + 4;

/// The kind of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub(super) enum Kind {
    Header = b'h',
    Input = b'i',
    Result = b'r',
    Key = b'k',
}

/// The envelope of a value.
pub(super) fn envelope(kind: Kind, id: Uuid, value: &[u8]) -> [u8; BYTES] {
    let mut envelope = [0; BYTES];
    envelope[..KIND].copy_from_slice(MAGIC);
    envelope[KIND] = kind as u8;
    envelope[ID..LENGTH].copy_from_slice(id.as_bytes());
    envelope[LENGTH..CHECKSUM].copy_from_slice(&(value.len() as u64).to_le_bytes());
    let mut checksum = Hasher::new();
    checksum.update(&envelope[..CHECKSUM]);
    checksum.update(value);
    envelope[CHECKSUM..].copy_from_slice(&checksum.finalize().to_le_bytes());
    envelope
}

/// The contents of an envelope, if this is one.
pub(super) fn announced(envelope: &[u8; BYTES]) -> Option<(Kind, Uuid, u64)> {
    if !envelope.starts_with(MAGIC) {
        return None;
    }
    let kinds = [Kind::Header, Kind::Input, Kind::Result, Kind::Key];
    let kind = kinds.into_iter().find(|&it| it as u8 == envelope[KIND])?;
    let id = Uuid::from_slice(&envelope[ID..LENGTH]).ok()?;
    let (length, _) = envelope[LENGTH..].split_first_chunk()?;
    Some((kind, id, u64::from_le_bytes(*length)))
}

/// The value of this job in its envelope, or an error that names the damaged one.
pub(super) fn opened(
    kind: Kind,
    id: Uuid,
    what: impl Display,
    bytes: &[u8],
) -> Result<&[u8], StoreError> {
    let parts = bytes.split_first_chunk::<BYTES>();
    let value = parts
        .filter(|(outside, value)| **outside == envelope(kind, id, value))
        .map(|(_, value)| value);
    value.ok_or_else(|| StoreError::damaged(what, "its checksum is that of another value"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_unchanged_or_damaged() {
        let (id, value) = (Uuid::now_v7(), b"points");
        let sealed = [envelope(Kind::Input, id, value).as_slice(), value].concat();
        let read = |bytes: &[u8]| opened(Kind::Input, id, "it", bytes).map(<[u8]>::to_vec);
        assert_eq!(read(&sealed).unwrap(), value);
        assert!(opened(Kind::Result, id, "it", &sealed).is_err());
        assert!(opened(Kind::Input, Uuid::now_v7(), "it", &sealed).is_err());
        for length in 0..sealed.len() {
            assert!(read(&sealed[..length]).is_err(), "{length}");
        }
        assert!(read(&[&sealed[..], b"s"].concat()).is_err());
        for bit in 0..8 * sealed.len() {
            let mut flipped = sealed.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let error = read(&flipped).unwrap_err().to_string();
            assert!(error.contains("it cannot be read"), "{error}");
        }
    }
}
