//! The messages of the contract (`proto/piad/v1/fitting.proto`), and their conversion to and from jobs.
//!
//! - [`job`]: a job and its message, both ways; `basis`, [`ends`], [`method`] with `least_squares`, and [`stream`]: parts
//!   of it; [`values`]: numbers, lists and enumerations.
//!
//! Requests, answers and the store use the same messages.

pub(crate) mod basis;
pub(crate) mod ends;
pub(crate) mod job;
mod least_squares;
pub(crate) mod method;
mod scattered;
pub(crate) mod stream;
pub(crate) mod values;

/// Code generated from the contract, which has the documentation.
#[allow(
    dead_code,
    missing_docs,
    unreachable_pub,
    clippy::all,
    clippy::unwrap_used,
    reason = "generated"
)]
pub mod messages {
    tonic::include_proto!("piad.v1");
}

/// The contract as a set of file descriptors, for reflection.
pub(crate) const DESCRIPTORS: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/fitting.bin"));
