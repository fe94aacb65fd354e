//! Decimal numbers as JSON, with as many digits as are needed to read them back exactly.

use std::array;

/// The buffer size for a number, more than it needs.
pub(super) const ROOM: usize = 40;

/// The most bytes that a number takes.
pub(super) const LONGEST: usize = 2 * HALF + 1;

/// Most numbers have between one and two times this many characters, and none has more.
const HALF: usize = 12;

/// Numbers that are written at a time.
pub(super) const BATCH: usize = 96;

/// The texts of the wanted numbers of a batch, with as many digits as are needed to read them back exactly; `null` for
/// those that are not finite. They are copied once all are there: reading a text that was only just written takes
/// several times as long.
#[inline(always)]
pub(super) fn in_full<R>(
    numbers: &[f64],
    is_wanted: impl Fn(usize) -> bool,
    use_texts: impl FnOnce(&[&str; BATCH]) -> R,
) -> R {
    let mut buffers: [_; BATCH] = array::from_fn(|_| zmij::Buffer::new());
    let mut texts = ["null"; BATCH];
    let places = texts.iter_mut().zip(&mut buffers);
    for (k, ((text, buffer), x)) in places.zip(numbers).enumerate() {
        if is_wanted(k) && x.is_finite() {
            *text = buffer.format_finite(*x);
        }
    }
    use_texts(&texts)
}

/// Writes a text of a number to the start of [`ROOM`] bytes; returns its length.
#[inline(always)]
pub(super) fn copy(text: &str, room: &mut [u8]) -> usize {
    let digits = text.as_bytes();
    let length = digits.len();
    if (HALF..=2 * HALF).contains(&length) {
        // Two overlapping copies of a constant size are faster than one of variable size.
        room[..HALF].copy_from_slice(&digits[..HALF]);
        room[length - HALF..length].copy_from_slice(&digits[length - HALF..]);
    } else {
        room[..length].copy_from_slice(digits);
    }
    length
}
