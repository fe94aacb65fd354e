//! The pieces of the body of a batch: its defaults and its items, each as the bytes that it is.

use bytes::Bytes;

/// A part of a body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Piece {
    /// What items have in common.
    Defaults(Bytes),
    /// A job.
    Item(Bytes),
}

/// How pieces follow each other in a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum BodyForm {
    /// One JSON object with `defaults` and `items`.
    Document,
    /// A JSON object a line.
    Lines,
    /// Messages of gRPC.
    Messages,
}
