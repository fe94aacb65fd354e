//! The answer to a batch in messages.

use bytes::{BufMut, Bytes, BytesMut};
use prost::Message;
use prost::encoding::{WireType, encode_key, encode_varint, encoded_len_varint};

use super::geometry::{self, ResultHead};
use super::names;
use super::view::problem;
use crate::api::problem::Problem;
use crate::job::content::Content;
use crate::job::frame::Frame;
use crate::job::state::State;
use crate::model::stream::form::Form;
use crate::proto::messages::{self as pb, fit_batch_response::Part};

/// The field of a `FitBatchResponse` that is an item, and that of the item that is its result.
const ITEM: u32 = 1;
const RESULT: u32 = 2;

/// The result of an item.
pub(crate) struct ItemEnd<'a> {
    pub index: usize,
    pub name: Option<&'a str>,
    /// Notices about its points.
    pub notices: &'a [String],
    pub state: State,
    /// Why it has not converged.
    pub problem: Option<&'a Problem>,
}

/// The message of an item, framed for gRPC; with the geometry of its last level, if there is one.
pub(crate) fn item(item: &ItemEnd<'_>, shown: Option<(&Frame, &Form)>) -> Content {
    let message = pb::BatchItem {
        index: item.index as u64,
        result: None,
        problem: item.problem.map(problem),
        name: item.name.map(str::to_owned),
        state: names::state(item.state).into(),
    };
    let result = shown.map(|(frame, form)| {
        let head = ResultHead {
            id: None,
            name: item.name,
            notices: item.notices,
            state: item.state,
        };
        with_length(geometry::result(&head, frame, form.view))
    });
    let mut fields = BytesMut::from(&*message.encode_to_vec());
    let Some((result, length)) = result else {
        return framed(fields, Bytes::new().into(), 0);
    };
    encode_key(RESULT, WireType::LengthDelimited, &mut fields);
    encode_varint(length as u64, &mut fields);
    framed(fields, result, length)
}

/// An item of these fields, the last of which ends with the first `length` bytes of `rest`.
fn framed(fields: BytesMut, mut rest: Content, length: usize) -> Content {
    let inner = fields.len() + length;
    let mut head = BytesMut::with_capacity(fields.len() + rest.head.len() + 32);
    // The key of the item takes a byte.
    put_prefix(&mut head, 1 + encoded_len_varint(inner as u64) + inner);
    encode_key(ITEM, WireType::LengthDelimited, &mut head);
    encode_varint(inner as u64, &mut head);
    head.extend_from_slice(&fields);
    head.extend_from_slice(&rest.head);
    rest.head = head.freeze();
    rest
}

/// A content, and its number of bytes.
fn with_length(content: Content) -> (Content, usize) {
    match content.length() {
        Some(length) => (content, length),
        None => {
            let whole = content.whole();
            let length = whole.len();
            (whole.into(), length)
        }
    }
}

/// The message of the totals, framed for gRPC.
pub(crate) fn totals(items: usize, converged: usize, seconds: f64) -> Bytes {
    let message = pb::FitBatchResponse {
        part: Some(Part::Totals(pb::BatchTotals {
            items: items as u64,
            converged: converged as u64,
            failed: (items - converged) as u64,
            seconds,
        })),
    };
    let mut bytes = BytesMut::new();
    put_prefix(&mut bytes, message.encoded_len());
    bytes.put_slice(&message.encode_to_vec());
    bytes.freeze()
}

/// The prefix of a message of this length: that it is not compressed, and the length.
fn put_prefix(bytes: &mut BytesMut, length: usize) {
    bytes.put_u8(0);
    bytes.put_u32(u32::try_from(length).unwrap_or(u32::MAX));
}
