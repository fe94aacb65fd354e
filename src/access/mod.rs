//! Who may do what: tokens, their tenants and scopes, and tickets for streams.
//!
//! - [`scope`]: what a token is good for; `secret`: its text and its hash;
//! - [`file`]: the tokens of a server as they are kept; `tokens`: as they are looked up;
//! - `ticket`: what opens one stream for a minute, for clients that cannot send headers, and the key that signs it;
//! - `denial`: why somebody is turned away.

pub(crate) mod denial;
pub(crate) mod file;
pub mod scope;
pub(crate) mod secret;
pub(crate) mod ticket;
pub(crate) mod tokens;

use std::sync::Arc;

use ticket::TicketKey;
use tokens::Tokens;

/// What a server checks requests by.
#[derive(Clone, Debug)]
pub(crate) struct Access {
    pub(crate) tokens: Arc<Tokens>,
    pub(crate) tickets: TicketKey,
}
