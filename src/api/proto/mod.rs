//! Requests and answers in protobuf messages (`proto/piad/v1/fitting.proto`).
//!
//! - [`request`], [`edit`]: requests in messages; [`bounds`]: limits of lists; [`fields`]: locations of the parts of
//!   the model in a message;
//! - [`view`], [`geometry`], [`batch`]: answers as messages; [`names`]: their enumerations.

pub(crate) mod batch;
pub(crate) mod bounds;
pub(crate) mod edit;
pub(crate) mod fields;
pub(crate) mod geometry;
pub(crate) mod names;
pub(crate) mod request;
pub(crate) mod view;
