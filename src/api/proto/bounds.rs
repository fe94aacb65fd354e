//! Lists of indices in messages: each of them may be a single byte that becomes four in memory, so
//! they are counted before a message is decoded.

use prost::Message;
use prost::encoding::{WireType, decode_key, decode_varint};

use crate::api::problem::Problem;
use crate::proto::messages as pb;

/// A field that has a list of indices, or a message with such fields.
#[derive(Debug)]
pub(crate) struct Part {
    tag: u32,
    name: &'static str,
    /// The fields of the message; none of a list.
    within: &'static [Part],
}

/// Messages in which lists are counted.
pub(crate) trait Bounded: Message + Default {
    /// Where they are.
    const PARTS: &'static [Part];
}

const fn part(tag: u32, name: &'static str, within: &'static [Part]) -> Part {
    Part { tag, name, within }
}

const LOCAL: &[Part] = &[part(1, "indices", &[])];
const METHOD: &[Part] = &[part(3, "local", LOCAL)];
const SURFACE: &[Part] = &[part(5, "missing", &[])];

impl Bounded for pb::JobInput {
    const PARTS: &'static [Part] = &[part(3, "surface", SURFACE), part(5, "method", METHOD)];
}

impl Bounded for pb::Edit {
    const PARTS: &'static [Part] = &[
        part(3, "moved", &[]),
        part(5, "weighted", &[]),
        part(9, "method", METHOD),
    ];
}

/// The parts of the message of a call.
fn parts_of(call: &str) -> &'static [Part] {
    const JOB: &[Part] = &[part(1, "input", pb::JobInput::PARTS)];
    const EDIT: &[Part] = &[part(2, "edit", pb::Edit::PARTS)];
    match call {
        "CreateJob" | "Fit" => JOB,
        "EditJob" => EDIT,
        _ => &[],
    }
}

/// Refuses a message with more indices in a list than there can be points.
pub(crate) fn check<M: Bounded>(body: &[u8], most: usize) -> Result<(), Problem> {
    count(body, M::PARTS, most, &mut vec![])
}

/// The same of the message of a call, which follows a byte and its length.
pub(crate) fn check_call(path: &str, body: &[u8], most: usize) -> Result<(), Problem> {
    let call = path.rsplit('/').next().unwrap_or("");
    let message = body.get(5..).unwrap_or(&[]);
    count(message, parts_of(call), most, &mut vec![])
}

/// Counts what is in the lists. What is no message is left to the one who decodes it.
fn count(
    mut message: &[u8],
    parts: &[Part],
    most: usize,
    path: &mut Vec<&'static str>,
) -> Result<(), Problem> {
    let mut counts = vec![0; parts.len()];
    while !message.is_empty() {
        let Ok((tag, wire_type)) = decode_key(&mut message) else {
            return Ok(());
        };
        let Some((value, rest)) = split(message, wire_type) else {
            return Ok(());
        };
        message = rest;
        let known = parts.iter().zip(&mut counts).find(|(it, _)| it.tag == tag);
        let Some((part, counted)) = known else {
            continue;
        };
        path.push(part.name);
        if part.within.is_empty() {
            // The last byte of each number is below 128.
            *counted += value.iter().filter(|byte| **byte < 0x80).count();
            if *counted > most {
                let detail = format!("more than {most} indices, the limit here");
                return Err(Problem::at_field(path.join("."), detail));
            }
        } else {
            count(value, part.within, most, path)?;
        }
        path.pop();
    }
    Ok(())
}

/// The value of a field, and what follows it.
fn split(mut message: &[u8], wire_type: WireType) -> Option<(&[u8], &[u8])> {
    let whole = message;
    let length = match wire_type {
        WireType::Varint => {
            decode_varint(&mut message).ok()?;
            whole.len() - message.len()
        }
        WireType::SixtyFourBit => 8,
        WireType::ThirtyTwoBit => 4,
        WireType::LengthDelimited => {
            let length = decode_varint(&mut message).ok()?;
            usize::try_from(length).ok()?
        }
        WireType::StartGroup | WireType::EndGroup => 0,
    };
    let start = if wire_type == WireType::LengthDelimited {
        message
    } else {
        whole
    };
    start.split_at_checked(length)
}
