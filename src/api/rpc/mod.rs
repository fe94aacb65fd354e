//! The same model in protobuf messages (`proto/piad/v1/fitting.proto`): as a gRPC service, and as
//! bodies of the REST resources.
//!
//! - [`request`], [`edit`], [`stream`]: messages become what their JSON would have become, so that there
//!   is one validation and one kind of job; [`fields`]: where in a message an error is;
//! - [`view`], [`geometry`], [`input`]: answers as messages; [`names`]: their enumerations;
//! - [`encoded`]: messages that are made once for all readers;
//! - [`errors`]: problems as gRPC statuses; [`malformed`]: messages that cannot be read;
//!   [`bounds`]: lists that are too long;
//! - [`service`]: the calls; [`mount`]: the service next to REST, with reflection and health.

pub mod bounds;
pub mod edit;
pub mod encoded;
pub mod errors;
pub mod fields;
pub mod geometry;
pub mod input;
pub mod malformed;
pub mod mount;
pub mod names;
pub mod request;
pub mod service;
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
