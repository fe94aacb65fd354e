//! A batch in gRPC messages: each `FitBatchRequest` follows a byte and its length.

use bytes::{Buf, Bytes, BytesMut};
use prost::encoding::{WireType, decode_key, decode_varint, skip_field};

use super::pieces::Piece;
use crate::api::problem::{Kind, Problem};

/// The bytes before a message: whether it is compressed, and its length.
pub(super) const PREFIX: usize = 5;

/// The fields of a `FitBatchRequest`.
const OPTIONS: u32 = 1;
const ITEM: u32 = 2;

/// The state of the parser.
#[derive(Default)]
pub(super) struct Messages {
    /// The first message was read, which alone may have options.
    begun: bool,
}

impl Messages {
    /// The next message, if all of it is there; messages that are longer than `limit` are refused before they arrive.
    pub(super) fn next(
        &mut self,
        bytes: &mut BytesMut,
        limit: usize,
    ) -> Result<Option<Piece>, Problem> {
        let Some((prefix, rest)) = bytes.split_at_checked(PREFIX) else {
            return Ok(None);
        };
        if prefix.first() != Some(&0) {
            return Err(unreadable("messages are not compressed here"));
        }
        let length = prefix.get(1..).unwrap_or_default().get_u32() as usize;
        if length > limit {
            let detail =
                format!("a message is larger than {limit} bytes, the limit of this server");
            return Err(Problem::new(Kind::BodyTooLarge, detail));
        }
        if rest.len() < length {
            return Ok(None);
        }
        bytes.advance(PREFIX);
        let message = bytes.split_to(length).freeze();
        self.piece(message).map(Some)
    }

    /// The error for a stream that has ended within a message.
    pub(super) fn finish(bytes: &[u8]) -> Result<(), Problem> {
        match bytes.is_empty() {
            true => Ok(()),
            false => Err(unreadable("the stream ends within a message")),
        }
    }

    fn piece(&mut self, message: Bytes) -> Result<Piece, Problem> {
        let is_first = !std::mem::replace(&mut self.begun, true);
        match part(message)? {
            Some((ITEM, item)) => Ok(Piece::Item(item)),
            Some((_, options)) if is_first => Ok(Piece::Defaults(options)),
            Some(_) => {
                let detail = "they are in the first message alone";
                Err(Problem::at_field("options", detail))
            }
            None => Err(Problem::at_field("item", "it is missing")),
        }
    }
}

/// The part of a `FitBatchRequest`, with its field; the last one, if there are several.
fn part(mut message: Bytes) -> Result<Option<(u32, Bytes)>, Problem> {
    let mut part = None;
    while message.has_remaining() {
        let (tag, wire_type) = decode_key(&mut message).map_err(broken)?;
        if wire_type != WireType::LengthDelimited || !matches!(tag, OPTIONS | ITEM) {
            skip_field(wire_type, tag, &mut message, Default::default()).map_err(broken)?;
            continue;
        }
        let length = decode_varint(&mut message).map_err(broken)?;
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        if length > message.len() {
            return Err(unreadable("it ends too soon"));
        }
        part = Some((tag, message.split_to(length)));
    }
    Ok(part)
}

fn broken(_: prost::DecodeError) -> Problem {
    unreadable("it is no FitBatchRequest")
}

fn unreadable(why: &str) -> Problem {
    let detail = format!("a message of the call cannot be read: {why}");
    Problem::new(Kind::NotProtobuf, detail)
}
