//! Tickets: each opens the stream of one job, for a minute, for clients that cannot send headers, such as the
//! `EventSource` of browsers.
//!
//! A ticket is signed by the hash of the token that it was made with. So any replica that knows the token can
//! check it without having made it, and it ends with its token.

use base64_simd::URL_SAFE_NO_PAD;
use hmac::{Hmac, KeyInit, Mac};
use jiff::{SignedDuration, Timestamp};
use sha2::Sha256;
use uuid::Uuid;

use super::file::Token;

/// How each ticket begins.
const PREFIX: &str = "piad_ticket_";

/// How long a ticket is good for.
const LIFETIME: SignedDuration = SignedDuration::from_secs(60);

/// What tells signatures of tickets from those of anything else.
const PURPOSE: &[u8] = b"piad ticket 1";

const SIGNATURE: usize = 32;

/// What a ticket says, before anybody has checked it.
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
    /// A new ticket for a job, as text, and until when it is good.
    pub(crate) fn issue(token: &Token, job: Uuid) -> (String, Timestamp) {
        let expires = Timestamp::now().saturating_add(LIFETIME);
        let expires = expires.unwrap_or(Timestamp::MAX).as_second();
        let ticket = signer(token, job, expires).finalize().into_bytes();
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

    /// What a text says, if it is one of a ticket.
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

    /// Whether it is a ticket of this token for this job, and still good.
    pub(crate) fn opens(&self, token: &Token, job: Uuid) -> bool {
        let signer = signer(token, self.job, self.expires);
        let is_signed = signer.verify_slice(&self.signature).is_ok();
        let is_of_both = self.token == token.id && self.job == job;
        is_signed && is_of_both && Timestamp::now().as_second() < self.expires
    }
}

fn signer(token: &Token, job: Uuid, expires: i64) -> Hmac<Sha256> {
    // Keys shorter than a block are filled up with zeros (RFC 2104).
    let mut key = [0; 64];
    key[..SIGNATURE].copy_from_slice(token.hash.bytes());
    let mut signer = Hmac::<Sha256>::new(&key.into());
    signer.update(PURPOSE);
    signer.update(job.as_bytes());
    signer.update(&expires.to_be_bytes());
    signer.update(token.id.as_bytes());
    signer
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

    #[test]
    fn a_ticket_opens_one_job_by_one_token_for_a_minute() {
        let (one, other) = (token("one"), token("other"));
        let (job, another) = (Uuid::now_v7(), Uuid::now_v7());
        let (text, expires) = Ticket::issue(&one, job);
        let left = expires.as_second() - Timestamp::now().as_second();
        assert!((59..=60).contains(&left), "{left}");
        let ticket = Ticket::read(&text).unwrap();
        assert_eq!(ticket.token, token("one").id);
        assert!(ticket.opens(&one, job));
        assert!(!ticket.opens(&one, another) && !ticket.opens(&other, job));
        let past = Ticket {
            expires: Timestamp::now().as_second(),
            ..ticket
        };
        assert!(!past.opens(&one, job));
    }

    #[test]
    fn changed_tickets_open_nothing() {
        let (token, job) = (token("one"), Uuid::now_v7());
        let (text, _) = Ticket::issue(&token, job);
        let encoded = text.strip_prefix(PREFIX).unwrap();
        let bytes = URL_SAFE_NO_PAD.decode_to_vec(encoded).unwrap();
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let text = format!("{PREFIX}{}", URL_SAFE_NO_PAD.encode_to_string(flipped));
            assert!(
                Ticket::read(&text).is_none_or(|it| !it.opens(&token, job)),
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
