//! The gRPC service, on the same port as the HTTP resources.
//!
//! - [`service`]: the calls; [`mount`]: the service next to the resources, with reflection and health;
//! - [`errors`]: problems as gRPC statuses; [`malformed`]: messages that cannot be read;
//! - [`scopes`]: what each call needs.

pub(crate) mod errors;
mod malformed;
pub(crate) mod mount;
pub(in crate::api) mod scopes;
pub(crate) mod service;
