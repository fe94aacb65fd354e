//! Drives a server over HTTP, as a client does; one file for each capability.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    missing_docs,
    reason = "tests fail by panicking"
)]

mod bad_requests;
mod data;
mod examples;
mod goldens;
mod http;
mod jobs;
mod large;
mod process;
mod streams;
mod support;
