//! Authorization: tokens, their tenants and scopes, and tickets for streams.
//!
//! - [`scope`]: permissions of tokens; `secret`: the text of a token and its hash;
//! - [`file`]: the file of the tokens of a server; `tokens`: its tokens in memory;
//! - `ticket`: short-lived access to one stream, for clients that cannot send headers, and the key that signs it;
//! - `denial`: reasons to deny a request.

pub(crate) mod denial;
pub(crate) mod file;
pub mod scope;
pub(crate) mod secret;
pub(crate) mod ticket;
pub(crate) mod tokens;

use std::sync::Arc;

use ticket::TicketKey;
use tokens::Tokens;

/// The tokens that a server checks requests against.
#[derive(Clone, Debug)]
pub(crate) struct Access {
    pub(crate) tokens: Arc<Tokens>,
    pub(crate) tickets: TicketKey,
}
