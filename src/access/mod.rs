//! Who may do what: tokens, their tenants and scopes, and tickets for streams.
//!
//! - [`scope`]: what a token is good for; [`secret`]: its text and its hash;
//! - [`file`]: the tokens of a server as they are kept; [`tokens`]: as they are looked up;
//! - [`ticket`]: what opens one stream for a minute, for clients that cannot send headers;
//! - [`denial`]: why somebody is turned away.

pub(crate) mod denial;
pub(crate) mod file;
pub mod scope;
pub(crate) mod secret;
pub(crate) mod ticket;
pub(crate) mod tokens;

/// The variable with a token of all scopes, for the time before there is a file.
pub(crate) const BOOTSTRAP: &str = "PIAD_TOKEN";
