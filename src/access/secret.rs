//! The text of a token, which only its owner has, and the hash that the server keeps.

use std::fmt;

use base64_simd::URL_SAFE_NO_PAD;
use rustls::crypto::ring;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use sha2::{Digest, Sha256};
use subtle::ConstantTimeEq;

/// The prefix of each token, by which people and secret scanners recognise it.
const PREFIX: &str = "piad_";

/// The number of its random bytes.
const RANDOM: usize = 32;

/// A new token.
///
/// # Errors
///
/// If the system has no random numbers.
pub(crate) fn generate() -> Result<String, String> {
    let bytes = random()?;
    Ok(format!(
        "{PREFIX}{}",
        URL_SAFE_NO_PAD.encode_to_string(bytes)
    ))
}

/// Random bytes.
///
/// # Errors
///
/// If the system has none.
pub(crate) fn random() -> Result<[u8; RANDOM], String> {
    let mut bytes = [0; RANDOM];
    let random = ring::default_provider().secure_random;
    let filled = random.fill(&mut bytes);
    filled.map_err(|_| "the system gives no random numbers".to_owned())?;
    Ok(bytes)
}

/// The SHA-256 of a token. Tokens are random, so they cannot be found by trial.
#[derive(Clone, Copy)]
pub(crate) struct Hash([u8; 32]);

impl Hash {
    /// The hash of a token.
    pub(crate) fn of(token: &str) -> Self {
        Self(Sha256::digest(token).into())
    }

    /// Returns true if they are equal, in constant time.
    pub(crate) fn is(&self, other: &Self) -> bool {
        self.0.ct_eq(&other.0).into()
    }

    /// Its bytes.
    pub(crate) fn bytes(&self) -> &[u8; 32] {
        &self.0
    }
}

/// Without the hash: it grants no access, but is not for logs.
impl fmt::Debug for Hash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a hash")
    }
}

impl Serialize for Hash {
    fn serialize<S: Serializer>(&self, output: S) -> Result<S::Ok, S::Error> {
        output.serialize_str(&URL_SAFE_NO_PAD.encode_to_string(self.0))
    }
}

impl<'de> Deserialize<'de> for Hash {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        let text = String::deserialize(input)?;
        let bytes = URL_SAFE_NO_PAD.decode_to_vec(text);
        let hash = bytes.ok().and_then(|bytes| bytes.try_into().ok());
        hash.map(Self)
            .ok_or_else(|| de::Error::custom("not the SHA-256 of a token, in base64url"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_differ_and_their_hashes_are_written_and_read() {
        let (one, other) = (generate().unwrap(), generate().unwrap());
        assert!(one.starts_with("piad_") && one.len() == 48 && one != other);
        let hash = Hash::of(&one);
        let text = serde_json::to_string(&hash).unwrap();
        assert!(!text.contains(&one));
        let read: Hash = serde_json::from_str(&text).unwrap();
        assert!(read.is(&Hash::of(&one)) && !read.is(&Hash::of(&other)));
        for wrong in ["\"\"", "\"a b\"", "\"AAAA\"", "5"] {
            assert!(serde_json::from_str::<Hash>(wrong).is_err(), "{wrong}");
        }
    }
}
