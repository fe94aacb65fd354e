//! Protobuf messages around geometry that is already encoded.
//!
//! Geometry is encoded once for all clients, over gRPC or REST. Only the bytes around it differ:
//! the field of the response, and the fields of a single stream.

use bytes::{Buf, BufMut, Bytes, BytesMut};
use prost::encoding::{
    DecodeContext, WireType, bool, double, encode_key, encode_varint, skip_field,
};
use prost::{DecodeError, Message};

use super::feed::Event;
use crate::job::content::Content;

/// A message with one field that is a message itself, whose bytes are shared.
#[derive(Debug)]
pub(crate) struct Encoded {
    /// The bytes before the shared ones.
    head: Bytes,
    body: Content,
    /// The number of bytes of the body.
    length: usize,
}

impl Encoded {
    /// The response whose field 1 is the message with these bytes.
    pub(crate) fn response(message: Content) -> Self {
        Self::with_field(BytesMut::with_capacity(24), 1, message)
    }

    /// An event as `WatchJobResponse` or `FitResponse`; `None` for events that have no message.
    pub(crate) fn event(event: Event) -> Option<Self> {
        let mut head = BytesMut::with_capacity(24);
        let (tag, data) = match event {
            Event::Job { data, again } => {
                if again {
                    bool::encode(5, &again, &mut head);
                }
                (1, data)
            }
            Event::Iteration {
                milestone, data, ..
            } => {
                if let Some(milestone) = milestone {
                    double::encode(4, &milestone, &mut head);
                }
                (2, data)
            }
            Event::End(data) => (3, data),
            Event::Quiet | Event::Stopping => return None,
        };
        Some(Self::with_field(head, tag, data))
    }

    fn with_field(mut head: BytesMut, tag: u32, content: Content) -> Self {
        let (body, length) = match content.length() {
            Some(length) => (content, length),
            None => {
                let whole = content.whole();
                let length = whole.len();
                (whole.into(), length)
            }
        };
        encode_key(tag, WireType::LengthDelimited, &mut head);
        encode_varint(length as u64, &mut head);
        Self {
            head: head.freeze(),
            body,
            length,
        }
    }

    /// The message in two parts, of which the second is shared.
    pub(crate) fn parts(self) -> (Bytes, Content) {
        (self.head, self.body)
    }
}

impl Message for Encoded {
    fn encode_raw(&self, buffer: &mut impl BufMut) {
        buffer.put_slice(&self.head);
        buffer.put_slice(&self.body.head);
        if let Some(rest) = &self.body.rest {
            (0..rest.count()).for_each(|index| buffer.put(rest.make(index)));
        }
    }

    /// Skips all fields: the server never decodes these messages.
    fn merge_field(
        &mut self,
        tag: u32,
        wire_type: WireType,
        buffer: &mut impl Buf,
        context: DecodeContext,
    ) -> Result<(), DecodeError> {
        skip_field(wire_type, tag, buffer, context)
    }

    fn encoded_len(&self) -> usize {
        self.head.len() + self.length
    }

    fn clear(&mut self) {
        *self = Self {
            head: Bytes::new(),
            body: Bytes::new().into(),
            length: 0,
        };
    }
}
