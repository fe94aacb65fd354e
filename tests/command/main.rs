//! `piad fit` and its kin, as programs that are run.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests fail by panicking"
)]

mod broken;
mod door;
mod image;
mod inputs;
mod interrupted;
mod kin;
mod outputs;
mod refused;
mod remote;
mod secure;
mod support;
