//! The encodings of requests and answers, and the framing of the events of a stream.

/// The media type of JSON.
pub(super) const JSON: &str = "application/json";
/// The media type of server-sent events.
pub(super) const SSE: &str = "text/event-stream";
/// The media type of a JSON object a line.
pub(super) const NDJSON: &str = "application/x-ndjson";
/// Protobuf messages.
pub(super) const PROTOBUF: &str = "application/x-protobuf";

/// The framing of the events of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Framing {
    /// Server-sent events.
    Sse,
    /// One JSON object a line.
    Ndjson,
    /// Protobuf messages, each after its length.
    Protobuf,
}

impl Framing {
    /// Returns true if events are protobuf messages.
    pub(crate) fn is_protobuf(self) -> bool {
        self == Self::Protobuf
    }

    /// The media type of such a stream.
    pub(super) fn media_type(self) -> &'static str {
        match self {
            Self::Sse => SSE,
            Self::Ndjson => NDJSON,
            Self::Protobuf => PROTOBUF,
        }
    }
}

/// The encoding of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Language {
    Json,
    /// A protobuf message.
    Protobuf,
}

impl Language {
    /// Its media type.
    pub(crate) fn media_type(self) -> &'static str {
        match self {
            Self::Json => JSON,
            Self::Protobuf => PROTOBUF,
        }
    }

    /// The file name extension.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::Json => "json",
            Self::Protobuf => "binpb",
        }
    }
}
