//! Drives a server over HTTP, as a client does; one file for each capability.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    missing_docs,
    unreachable_pub,
    reason = "tests fail by panicking, and nobody links to them"
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
