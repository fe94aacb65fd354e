//! Tickets: each opens the stream of one job, for a minute, for clients that cannot send headers, such as the
//! `EventSource` of browsers.
//!
//! A ticket is signed by a key of the server, which is kept in its store, so that all replicas with one database accept
//! the tickets of each other. It ends with its token: the hash of the token is a part of what is signed.

use std::fmt;

use base64_simd::URL_SAFE_NO_PAD;
use hmac::{Hmac, KeyInit, Mac};
use jiff::{SignedDuration, Timestamp};
use sha2::Sha256;
use uuid::Uuid;

use super::file::Token;
use super::secret;

/// The prefix of each ticket.
const PREFIX: &str = "piad_ticket_";

/// The lifetime of a ticket.
const LIFETIME: SignedDuration = SignedDuration::from_secs(60);

/// The largest difference between the clocks of replicas. A ticket ends after its lifetime and this, whatever it says.
const CLOCK_DIFFERENCE: SignedDuration = SignedDuration::from_secs(5);

/// Separates signatures of tickets from those of anything else.
const PURPOSE: &[u8] = b"piad ticket 2";

const SIGNATURE: usize = 32;

/// Signs the tickets of a server, and of all that share its store.
#[derive(Clone)]
pub(crate) struct TicketKey([u8; SIGNATURE]);

impl TicketKey {
    /// The key with these bytes.
    pub(crate) fn of(bytes: [u8; SIGNATURE]) -> Self {
        Self(bytes)
    }

    /// The bytes of a new key.
    ///
    /// # Errors
    ///
    /// If the system has no random numbers.
    pub(crate) fn random() -> Result<[u8; SIGNATURE], String> {
        secret::random()
    }

    fn signer(&self, token: &Token, job: Uuid, expires: i64) -> Hmac<Sha256> {
        // Keys shorter than a block are filled up with zeros (RFC 2104).
        let mut key = [0; 64];
        key[..SIGNATURE].copy_from_slice(&self.0);
        let mut signer = Hmac::<Sha256>::new(&key.into());
        signer.update(PURPOSE);
        signer.update(token.hash.bytes());
        signer.update(job.as_bytes());
        signer.update(&expires.to_be_bytes());
        signer.update(token.id.as_bytes());
        signer
    }
}

/// Without the key.
impl fmt::Debug for TicketKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a key")
    }
}

/// The contents of a ticket, unverified.
#[derive(Debug)]
pub(crate) struct Ticket {
    /// The id of the token that it was made with.
    token: String,
    job: Uuid,
    /// In seconds since 1970.
    expires: i64,
    signature: [u8; SIGNATURE],
}

impl Ticket {
    /// A new ticket for a job, as text, and the time at which it expires.
    pub(crate) fn issue(key: &TicketKey, token: &Token, job: Uuid) -> (String, Timestamp) {
        let expires = Timestamp::now().saturating_add(LIFETIME);
        let expires = expires.unwrap_or(Timestamp::MAX).as_second();
        let ticket = key.signer(token, job, expires).finalize().into_bytes();
        let bytes = [
            job.as_bytes().as_slice(),
            &expires.to_be_bytes(),
            ticket.as_slice(),
            token.id.as_bytes(),
        ];
        let text = URL_SAFE_NO_PAD.encode_to_string(bytes.concat());
        let at = Timestamp::from_second(expires).unwrap_or(Timestamp::MAX);
        (format!("{PREFIX}{text}"), at)
    }

    /// The contents of a text, if it is a ticket.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let text = text.strip_prefix(PREFIX)?;
        let bytes = URL_SAFE_NO_PAD.decode_to_vec(text).ok()?;
        let (job, rest) = bytes.split_first_chunk::<16>()?;
        let (expires, rest) = rest.split_first_chunk()?;
        let (signature, token) = rest.split_first_chunk()?;
        Some(Self {
            token: String::from_utf8(token.to_vec()).ok()?,
            job: Uuid::from_bytes(*job),
            expires: i64::from_be_bytes(*expires),
            signature: *signature,
        })
    }

    /// Returns true if it is a ticket of this token for this job, and has not expired.
    pub(crate) fn opens(&self, key: &TicketKey, token: &Token, job: Uuid) -> bool {
        let signer = key.signer(token, self.job, self.expires);
        let is_signed = signer.verify_slice(&self.signature).is_ok();
        let is_of_both = self.token == token.id && self.job == job;
        is_signed && is_of_both && self.is_in_time()
    }

    /// Returns true if its end lies ahead, and no further than a lifetime.
    fn is_in_time(&self) -> bool {
        let left = self.expires.saturating_sub(Timestamp::now().as_second());
        let most = LIFETIME.as_secs() + CLOCK_DIFFERENCE.as_secs();
        (1..=most).contains(&left)
    }
}

#[cfg(test)]
mod tests {
    use super::super::secret::Hash;
    use super::*;
    use crate::job::tenant::Tenant;

    fn token(text: &str) -> Token {
        Token {
            id: "a1".to_owned(),
            tenant: Tenant::DEFAULT,
            scopes: Default::default(),
            created: Timestamp::now(),
            expires: None,
            note: None,
            hash: Hash::of(text),
        }
    }

    fn key() -> TicketKey {
        TicketKey::of(TicketKey::random().unwrap())
    }

    #[test]
    fn a_ticket_opens_one_job_by_one_token_for_a_minute() {
        let (one, other) = (token("one"), token("other"));
        let (job, another) = (Uuid::now_v7(), Uuid::now_v7());
        let (key, other_key) = (key(), key());
        let (text, expires) = Ticket::issue(&key, &one, job);
        let left = expires.as_second() - Timestamp::now().as_second();
        assert!((59..=60).contains(&left), "{left}");
        let ticket = Ticket::read(&text).unwrap();
        assert_eq!(ticket.token, token("one").id);
        assert!(ticket.opens(&key, &one, job) && !ticket.opens(&other_key, &one, job));
        assert!(!ticket.opens(&key, &one, another) && !ticket.opens(&key, &other, job));
        let past = Ticket {
            expires: Timestamp::now().as_second(),
            ..ticket
        };
        assert!(!past.opens(&key, &one, job));
    }

    #[test]
    fn no_ticket_is_good_for_longer_than_its_lifetime() {
        let (token, job, key) = (token("one"), Uuid::now_v7(), key());
        let opens = |seconds: i64| {
            let expires = Timestamp::now().as_second().saturating_add(seconds);
            let signature = key.signer(&token, job, expires).finalize().into_bytes();
            let ticket = Ticket {
                token: token.id.clone(),
                job,
                expires,
                signature: signature.into(),
            };
            ticket.opens(&key, &token, job)
        };
        assert!(opens(30) && opens(60));
        for seconds in [i64::MIN, -1, 0, 70, 3600, 1 << 62, i64::MAX] {
            assert!(!opens(seconds), "{seconds}");
        }
    }

    #[test]
    fn changed_tickets_open_nothing() {
        let (token, job, key) = (token("one"), Uuid::now_v7(), key());
        let (text, _) = Ticket::issue(&key, &token, job);
        let encoded = text.strip_prefix(PREFIX).unwrap();
        let bytes = URL_SAFE_NO_PAD.decode_to_vec(encoded).unwrap();
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let text = format!("{PREFIX}{}", URL_SAFE_NO_PAD.encode_to_string(flipped));
            assert!(
                Ticket::read(&text).is_none_or(|it| !it.opens(&key, &token, job)),
                "{bit}"
            );
        }
        for wrong in [
            "",
            "piad_ticket_",
            "piad_ticket_AAAA",
            "piad_ticket_?",
            "AAAA",
        ] {
            assert!(Ticket::read(wrong).is_none(), "{wrong}");
        }
    }
}
