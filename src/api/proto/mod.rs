//! Requests and answers in protobuf messages (`proto/piad/v1/fitting.proto`).
//!
//! - [`request`], [`edit`]: what messages ask for; [`bounds`]: lists that are too long; [`fields`]: where in a
//!   message a part of the model is;
//! - [`view`], [`geometry`]: answers as messages; [`names`]: their enumerations.

pub mod bounds;
pub mod edit;
pub mod fields;
pub mod geometry;
pub mod names;
pub mod request;
pub mod view;
