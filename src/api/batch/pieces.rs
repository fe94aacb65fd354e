//! The parts of the body of a batch: its defaults and its items, unparsed.

use bytes::Bytes;

/// A part of a body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Piece {
    /// Default fields of items.
    Defaults(Bytes),
    /// A job.
    Item(Bytes),
}

/// The format of a batch body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum BodyForm {
    /// One JSON object with `defaults` and `items`.
    Document,
    /// A JSON object a line.
    Lines,
    /// Messages of gRPC.
    Messages,
}
