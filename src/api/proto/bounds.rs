//! Limits of the lists in messages, which are counted before a message is decoded: an index of one byte takes many in
//! memory, and an empty message two.

use prost::Message;
use prost::encoding::{WireType, decode_key, decode_varint};

use crate::api::problem::Problem;
use crate::model::list_limits::EXTRA;
use crate::proto::messages as pb;
use piad_fit::data::MAX_DIMENSION;
use piad_fit::method::{LARGEST, MOST_CONDITIONS};

/// The largest memory of an index until a job or an edit is made of it: as such, as a place that a point goes to, and
/// in a table of those that change.
const INDEX: usize = 160;

/// The corners of triangles that take about as much memory as an index: each is kept twice, in four bytes.
const CORNERS_OF_INDEX: usize = 16;

/// The contents of a field.
#[derive(Clone, Copy, Debug)]
enum Content {
    /// At most one index for each point.
    Indices,
    /// Three indices of points for each triangle of a mesh, at most four triangles for each point.
    Corners,
    /// At most this many numbers for each point, and as many more as knot vectors have.
    Numbers(usize),
    /// The entries of a matrix.
    Matrix,
    /// One message, with fields that are lists or such messages.
    Message(&'static [Part]),
    /// At most this many of them, or one for each point.
    Messages(Option<usize>, &'static [Part]),
}

/// A field that is a list, or a message with such fields.
#[derive(Debug)]
pub(crate) struct Part {
    tag: u32,
    name: &'static str,
    content: Content,
}

/// Messages in which lists are counted.
pub(crate) trait Bounded: Message + Default {
    /// Their position.
    const PARTS: &'static [Part];
}

const fn part(tag: u32, name: &'static str, content: Content) -> Part {
    Part { tag, name, content }
}

use Content::{Corners, Indices, Matrix, Message as One, Messages as Many, Numbers};

/// A number for each point, and vectors of as many coordinates as there are for each point.
const NUMBERS: Content = Numbers(1);
const VECTORS: Content = Numbers(MAX_DIMENSION);

const BASIS: &[Part] = &[part(4, "knots", NUMBERS)];
const PARAMETERS: &[Part] = &[part(2, "values", NUMBERS)];
const END: &[Part] = &[
    part(2, "derivatives", VECTORS),
    part(3, "tangents", VECTORS),
];
const ENDS: &[Part] = &[part(1, "start", One(END)), part(2, "end", One(END))];
const INDICES: &[Part] = &[part(1, "indices", Indices)];
const CORNERS: &[Part] = &[part(1, "at", One(INDICES))];
const CURVE: &[Part] = &[
    part(2, "points", VECTORS),
    part(3, "basis", One(BASIS)),
    part(4, "parameters", One(PARAMETERS)),
    part(5, "weights", NUMBERS),
    part(7, "ends", One(ENDS)),
    part(8, "corners", One(CORNERS)),
];
const DIRECTION: &[Part] = &[
    part(1, "basis", One(BASIS)),
    part(2, "parameters", One(PARAMETERS)),
    part(4, "weights", NUMBERS),
    part(5, "ends", One(ENDS)),
    part(6, "creases", Indices),
];
const SCATTERED: &[Part] = &[
    part(2, "values", Numbers(2)),
    part(4, "axis", NUMBERS),
    part(5, "center", NUMBERS),
    part(8, "sections", Indices),
    part(10, "triangles", Corners),
];
const SURFACE: &[Part] = &[
    part(4, "points", VECTORS),
    part(5, "missing", Indices),
    part(6, "u", One(DIRECTION)),
    part(7, "v", One(DIRECTION)),
    part(8, "weights", NUMBERS),
    part(9, "scattered", One(SCATTERED)),
];
const LOCAL: &[Part] = &[part(1, "indices", Indices)];
const ADAPTIVE: &[Part] = &[part(3, "thresholds", NUMBERS)];
const CUSTOM: &[Part] = &[
    part(1, "transform_u", Matrix),
    part(2, "transform_v", Matrix),
];
const VECTOR: &[Part] = &[part(1, "coordinates", VECTORS)];
const DERIVATIVE: &[Part] = &[part(3, "vector", One(VECTOR))];
const ACROSS: &[Part] = &[part(2, "control_points", Many(None, VECTOR))];
const CONSTRAINT: &[Part] = &[
    part(6, "derivative", One(DERIVATIVE)),
    part(7, "tangent", One(VECTOR)),
    part(8, "across", One(ACROSS)),
];
const LEAST_SQUARES: &[Part] = &[
    part(7, "data_weights", NUMBERS),
    part(10, "constraints", Many(Some(MOST_CONDITIONS), CONSTRAINT)),
];
const METHOD: &[Part] = &[
    part(3, "local", One(LOCAL)),
    part(4, "adaptive", One(ADAPTIVE)),
    part(10, "least_squares", One(LEAST_SQUARES)),
    part(11, "custom", One(CUSTOM)),
];
const MILESTONES: &[Part] = &[part(1, "distances", NUMBERS)];
const STREAM: &[Part] = &[part(5, "milestones", One(MILESTONES))];
const WEIGHTS: &[Part] = &[
    part(1, "values", NUMBERS),
    part(2, "u", NUMBERS),
    part(3, "v", NUMBERS),
];

impl Bounded for pb::JobInput {
    const PARTS: &'static [Part] = &[
        part(2, "curve", One(CURVE)),
        part(3, "surface", One(SURFACE)),
        part(5, "method", One(METHOD)),
        part(7, "stream", One(STREAM)),
    ];
}

impl Bounded for pb::BatchOptions {
    const PARTS: &'static [Part] = &[part(1, "defaults", One(pb::JobInput::PARTS))];
}

impl Bounded for pb::Edit {
    const PARTS: &'static [Part] = &[
        part(3, "moved", Indices),
        part(4, "points", VECTORS),
        part(5, "weighted", Indices),
        part(6, "point_weights", NUMBERS),
        part(7, "weights", One(WEIGHTS)),
        part(9, "method", One(METHOD)),
        part(11, "stream", One(STREAM)),
    ];
}

/// The parts of the message of a call.
fn parts_of(path: &str) -> &'static [Part] {
    const JOB: &[Part] = &[part(1, "input", One(pb::JobInput::PARTS))];
    const EDIT: &[Part] = &[part(2, "edit", One(pb::Edit::PARTS))];
    match path.rsplit('/').next() {
        Some("CreateJob" | "Fit") => JOB,
        Some("EditJob") => EDIT,
        _ => &[],
    }
}

/// The message of a call, which follows a byte and its length.
fn message_of(body: &[u8]) -> &[u8] {
    body.get(5..).unwrap_or(&[])
}

/// Refuses a message whose lists are longer than `most` points allow.
pub(crate) fn check<M: Bounded>(body: &[u8], most: usize) -> Result<(), Problem> {
    check_parts(body, M::PARTS, most)
}

/// The same of the message of a call.
pub(crate) fn check_call(path: &str, body: &[u8], most: usize) -> Result<(), Problem> {
    check_parts(message_of(body), parts_of(path), most)
}

fn check_parts(message: &[u8], parts: &'static [Part], most: usize) -> Result<(), Problem> {
    let mut counts = Count::of(parts);
    add(&mut counts, message, most);
    match counts.iter().find_map(|count| count.excess(most)) {
        None => Ok(()),
        Some((path, detail)) => Err(Problem::at_field(path, detail)),
    }
}

/// The memory of the indices of a message until it is read, in addition to its bytes.
pub(crate) fn memory<M: Bounded>(body: &[u8]) -> usize {
    memory_of_parts(body, M::PARTS)
}

/// The same of the message of a call.
pub(crate) fn memory_of_call(path: &str, body: &[u8]) -> usize {
    memory_of_parts(message_of(body), parts_of(path))
}

fn memory_of_parts(message: &[u8], parts: &'static [Part]) -> usize {
    let mut counts = Count::of(parts);
    add(&mut counts, message, usize::MAX);
    let small = counts.iter().map(Count::small).sum::<usize>();
    small.saturating_mul(INDEX)
}

/// The size of a part over all of its occurrences, which are merged when they are decoded.
struct Count {
    part: &'static Part,
    count: usize,
    within: Vec<Count>,
}

impl Count {
    /// Nothing yet of these.
    fn of(parts: &'static [Part]) -> Vec<Self> {
        let count = |part: &'static Part| Self {
            part,
            count: 0,
            within: match part.content {
                One(parts) | Many(_, parts) => Self::of(parts),
                Indices | Corners | Numbers(_) | Matrix => Vec::new(),
            },
        };
        parts.iter().map(count).collect()
    }

    /// The limit of its size, and its name.
    fn most(&self, points: usize) -> (usize, &'static str) {
        match self.part.content {
            Indices => (points, "indices"),
            Corners => (points.saturating_mul(12), "indices"),
            Numbers(each) => (points.saturating_mul(each).saturating_add(EXTRA), "numbers"),
            Matrix => (LARGEST * LARGEST, "numbers"),
            One(_) => (usize::MAX, "messages"),
            Many(most, _) => (most.unwrap_or(points), self.part.name),
        }
    }

    /// The field within this one that is too long, and the error.
    fn excess(&self, points: usize) -> Option<(String, String)> {
        let name = self.part.name;
        let (most, things) = self.most(points);
        if self.count > most {
            let detail = format!("more than {most} {things}, the limit here");
            return Some((name.to_owned(), detail));
        }
        let inner = self.within.iter().find_map(|count| count.excess(points))?;
        Some((format!("{name}.{}", inner.0), inner.1))
    }

    /// The parts that are smaller in a message than in memory.
    fn small(&self) -> usize {
        let own = match self.part.content {
            Indices | Many(..) => self.count,
            Corners => self.count.div_ceil(CORNERS_OF_INDEX),
            Numbers(_) | Matrix | One(_) => 0,
        };
        own + self.within.iter().map(Self::small).sum::<usize>()
    }
}

/// Counts the contents of a message, until a limit is exceeded. Invalid messages are left to the decoder.
fn add(counts: &mut [Count], mut message: &[u8], points: usize) -> bool {
    while !message.is_empty() {
        let Ok((tag, wire_type)) = decode_key(&mut message) else {
            return true;
        };
        let Some((value, rest)) = split(message, wire_type) else {
            return true;
        };
        message = rest;
        let Some(count) = counts.iter_mut().find(|it| it.part.tag == tag) else {
            continue;
        };
        count.count += match count.part.content {
            // The last byte of each number is below 128.
            Indices | Corners => value.iter().filter(|byte| **byte < 0x80).count(),
            Numbers(_) | Matrix => value.len() / size_of::<f64>(),
            One(_) | Many(..) => 1,
        };
        let fits = count.count <= count.most(points).0 && add(&mut count.within, value, points);
        if !fits {
            return false;
        }
    }
    true
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

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use prost_types::field_descriptor_proto::{Label, Type};
    use prost_types::{DescriptorProto, FileDescriptorSet};

    use super::*;
    use crate::proto::DESCRIPTORS;

    /// The message with this name and those within it.
    fn collect(name: &str, message: DescriptorProto, all: &mut HashMap<String, DescriptorProto>) {
        for within in message.nested_type.clone() {
            collect(&format!("{name}.{}", within.name()), within, all);
        }
        all.insert(name.to_owned(), message);
    }

    /// Every list of numbers in these messages is counted, at the number that its field has in the contract.
    fn check(parts: &[Part], name: &str, all: &HashMap<String, DescriptorProto>) {
        let fields = &all[name].field;
        for part in parts {
            let field = fields.iter().find(|it| it.number() == part.tag as i32);
            let field = field.unwrap_or_else(|| panic!("{name} has no field {}", part.tag));
            assert_eq!(field.name(), part.name, "{name}");
            if let One(parts) | Many(_, parts) = part.content {
                check(parts, field.type_name(), all);
            }
        }
        let is_list = |label: Label, kind: Type| {
            label == Label::Repeated && !matches!(kind, Type::Message | Type::String)
        };
        for field in fields {
            let is_counted = parts.iter().any(|part| part.name == field.name());
            match field.r#type() {
                Type::Message if !is_counted => check(&[], field.type_name(), all),
                kind if is_list(field.label(), kind) => {
                    assert!(is_counted, "{name}.{} is not counted", field.name());
                }
                _ => {}
            }
        }
    }

    #[test]
    fn lists_are_counted_by_the_numbers_of_the_contract() {
        let described = FileDescriptorSet::decode(DESCRIPTORS).unwrap();
        let mut all = HashMap::new();
        for file in described.file {
            let package = file.package().to_owned();
            for message in file.message_type {
                collect(&format!(".{package}.{}", message.name()), message, &mut all);
            }
        }
        check(pb::JobInput::PARTS, ".piad.v1.JobInput", &all);
        check(pb::BatchOptions::PARTS, ".piad.v1.BatchOptions", &all);
        check(pb::Edit::PARTS, ".piad.v1.Edit", &all);
    }
}
