//! `piad fit` and its kin, as programs that are run.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    unreachable_pub,
    reason = "tests fail by panicking, and have no users"
)]

mod broken;
mod cli_metadata;
mod image;
mod inputs;
mod interrupted;
mod odd_files;
mod outputs;
mod parts;
mod refused;
mod remote;
mod secure;
mod support;
mod terminal;
mod tls_proxy;
