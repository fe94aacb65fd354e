//! The gRPC service, on the same port as the HTTP resources.
//!
//! - [`service`]: the calls; [`batch`]: the call whose messages are read as they arrive; [`mount`]: the service next to
//!   the resources, with reflection and health;
//! - [`errors`]: problems as gRPC statuses; [`malformed`]: messages that cannot be decoded;
//! - [`scopes`]: the authorization of each call.

mod batch;
pub(crate) mod errors;
mod malformed;
pub(crate) mod mount;
pub(in crate::api) mod scopes;
pub(crate) mod service;
