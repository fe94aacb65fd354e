//! Decimal numbers as nested lists.
//!
//! A part may begin and end anywhere in a list. Its bytes are written to a place in the nearest cache, which has
//! room for all of them, and copied from there to where they belong.

use super::decimal::{self, BATCH, LONGEST, ROOM};
use super::rounding::Batch;
use super::shape::NestedShape;

/// The largest output of [`lists`]: numbers with commas, and the brackets around lists.
pub(super) const SCRATCH: usize =
    BATCH * (LONGEST + 1) + (BATCH + 2) * 2 * NestedShape::DEEPEST + ROOM;

/// Writes the numbers from `start` on, at most [`BATCH`], as nested lists, in full or rounded; returns the number of
/// bytes.
pub(super) fn decimals(
    shape: NestedShape,
    start: usize,
    numbers: &[f64],
    rounded: &mut Option<Batch>,
    scratch: &mut [u8; SCRATCH],
) -> usize {
    let count = numbers.len();
    let Some(batch) = rounded else {
        return decimal::in_full(
            numbers,
            |_| true,
            |texts| {
                let write = |k: usize, room: &mut [u8]| decimal::copy(texts[k], room);
                lists(shape, start, count, scratch, write)
            },
        );
    };
    batch.compute(numbers);
    decimal::in_full(
        numbers,
        |k| batch.is_in_full(k),
        |texts| {
            let write = |k: usize, room: &mut [u8]| batch.write(k, numbers[k], texts[k], room);
            lists(shape, start, count, scratch, write)
        },
    )
}

/// Writes this many numbers from `start` on, with the brackets and commas between and after them; returns the number of
/// bytes.
#[inline(always)]
fn lists(
    shape: NestedShape,
    start: usize,
    count: usize,
    scratch: &mut [u8; SCRATCH],
    write: impl Fn(usize, &mut [u8]) -> usize,
) -> usize {
    let (total, innermost) = (shape.count(), shape.innermost());
    let mut room = FixedBuffer {
        bytes: scratch,
        used: 0,
    };
    let mut written = 0;
    let mut edges = shape.edges(start);
    // The number of numbers up to the end of an innermost list.
    let mut run = innermost - start % innermost;
    while written < count {
        let end = count.min(written + run);
        room.repeat(b'[', edges);
        for k in written..end {
            if k > written {
                room.push(b',');
            }
            room.used += write(k, &mut room.bytes[room.used..]);
        }
        written = end;
        run = innermost;
        edges = shape.edges(start + written);
        room.repeat(b']', edges);
        if start + written < total {
            room.push(b',');
        }
    }
    room.used
}

/// Bytes that are filled from the start on.
struct FixedBuffer<'a> {
    bytes: &'a mut [u8],
    used: usize,
}

impl FixedBuffer<'_> {
    #[inline(always)]
    fn push(&mut self, byte: u8) {
        self.bytes[self.used] = byte;
        self.used += 1;
    }

    #[inline(always)]
    fn repeat(&mut self, byte: u8, times: usize) {
        (0..times).for_each(|_| self.push(byte));
    }
}
