//! The model in protobuf messages (`proto/piad/v1/fitting.proto`).
//!
//! - [`request`], [`edit`], [`stream`]: what messages ask for; [`method`]: methods; [`bounds`]: lists that are too long;
//!   [`fields`]: where in a message an error is;
//! - [`view`], [`geometry`], [`input`]: answers as messages; [`names`]: their enumerations.

pub mod bounds;
pub mod edit;
pub mod fields;
pub mod geometry;
pub mod input;
pub mod method;
pub mod names;
pub mod request;
pub mod stream;
pub mod view;

/// What is generated from the contract; the contract documents it.
#[allow(
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
pub const DESCRIPTORS: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/fitting.bin"));
