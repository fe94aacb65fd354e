//! Whole numbers in as few bits as their block needs.
//!
//! A block has [`BLOCK`] numbers, the last one of an array the rest. It is a byte, the width of its numbers in bits (0
//! … 32), and the numbers one behind the other, the lowest bits first, up to a whole byte. A number d is written as 2d,
//! or −2d − 1 if it is negative: so small numbers of both signs take few bits.

use thiserror::Error;

/// The numbers of a block.
pub(super) const BLOCK: usize = 256;

/// The most bytes of a block: its width, its numbers, and room for writing whole words.
const ROOM: usize = 1 + 4 * BLOCK + 16;

/// An error of packed numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub(crate) enum Malformed {
    /// They end too early.
    #[error("packed numbers are cut off")]
    CutOff,
    /// A block has this invalid width.
    #[error("numbers of a block have {0} bits, which is more than 32")]
    Width(u8),
    /// They continue behind the last number.
    #[error("there are bytes behind the last of the packed numbers")]
    TooLong,
}

/// A whole number of either sign as one without a sign.
pub(super) fn unsigned(d: i32) -> u32 {
    ((d << 1) ^ (d >> 31)) as u32
}

/// The whole number that is written as this one.
fn signed(z: u32) -> i32 {
    (z >> 1) as i32 ^ -((z & 1) as i32)
}

/// Appends a block of at most [`BLOCK`] numbers. Inline, so that it has the shifts of the processor.
#[inline(always)]
pub(super) fn pack(block: &[u32], bytes: &mut Vec<u8>) {
    let all = block.iter().fold(0, |all, z| all | z);
    let width = u32::BITS - all.leading_zeros();
    let mut room = [0; ROOM];
    room[0] = width as u8;
    if width <= 16 {
        pack_fours(block, width, &mut room[1..]);
    } else {
        pack_ones(block, width, &mut room[1..]);
    }
    let length = (block.len() * width as usize).div_ceil(8);
    bytes.extend_from_slice(&room[..1 + length]);
}

/// Packs numbers of any width.
#[inline(always)]
fn pack_ones(block: &[u32], width: u32, room: &mut [u8]) {
    let (mut at, mut bits, mut count) = (0, 0_u64, 0);
    for &z in block {
        bits |= u64::from(z) << count;
        count += width;
        if count >= u32::BITS {
            room[at..at + 4].copy_from_slice(&(bits as u32).to_le_bytes());
            at += 4;
            bits >>= u32::BITS;
            count -= u32::BITS;
        }
    }
    room[at..at + 4].copy_from_slice(&(bits as u32).to_le_bytes());
}

/// Packs numbers of at most 16 bits, four of which have room in a word.
#[inline(always)]
fn pack_fours(block: &[u32], width: u32, room: &mut [u8]) {
    let (fours, rest) = block.as_chunks::<4>();
    let mut last = [0; 4];
    last[..rest.len()].copy_from_slice(rest);
    let (mut at, mut bits, mut count) = (0, 0_u64, 0);
    for four in fours.iter().chain([&last]) {
        let [a, b, c, d] = four.map(u64::from);
        let four = a | b << width | (c | d << width) << (2 * width);
        bits |= four << count;
        room[at..at + 8].copy_from_slice(&bits.to_le_bytes());
        let sum = count + 4 * width;
        if sum >= u64::BITS {
            // The bits that had no room. A shift by all 64 leaves none.
            bits = four.checked_shr(u64::BITS - count).unwrap_or(0);
            at += 8;
            count = sum - u64::BITS;
        } else {
            count = sum;
        }
    }
    room[at..at + 8].copy_from_slice(&bits.to_le_bytes());
}

/// Takes a block of at most [`BLOCK`] numbers from the front of these bytes.
pub(super) fn unpack(bytes: &mut &[u8], block: &mut [i32]) -> Result<(), Malformed> {
    let (&width, rest) = bytes.split_first().ok_or(Malformed::CutOff)?;
    if u32::from(width) > u32::BITS {
        return Err(Malformed::Width(width));
    }
    let width = u32::from(width);
    let length = (block.len() * width as usize).div_ceil(8);
    let (packed, rest) = rest.split_at_checked(length).ok_or(Malformed::CutOff)?;
    *bytes = rest;
    let mut words = packed.chunks(4).map(|part| {
        let mut word = [0; 4];
        word[..part.len()].copy_from_slice(part);
        u64::from(u32::from_le_bytes(word))
    });
    let mask = (1_u64 << width) - 1;
    let (mut bits, mut count) = (0_u64, 0);
    for d in block {
        if count < width {
            bits |= words.next().unwrap_or_default() << count;
            count += u32::BITS;
        }
        *d = signed((bits & mask) as u32);
        bits >>= width;
        count -= width;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn packed(numbers: &[i32]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let block: Vec<u32> = numbers.iter().copied().map(unsigned).collect();
        pack(&block, &mut bytes);
        bytes
    }

    fn unpacked(mut bytes: &[u8], count: usize) -> Result<Vec<i32>, Malformed> {
        let mut block = vec![0; count];
        unpack(&mut bytes, &mut block)?;
        assert!(bytes.is_empty());
        Ok(block)
    }

    #[test]
    fn small_numbers_take_few_bits() {
        assert_eq!(packed(&[0; 256]), [0]);
        assert_eq!(packed(&[-1, 0, -1, -1]), [1, 0b1101]);
        assert_eq!(packed(&[1, -2, 0]), [2, 0b00_11_10]);
        assert_eq!(packed(&[4, -5, 7]), [4, 0x98, 0x0e]);
        assert_eq!(packed(&[i32::MIN]), [32, 255, 255, 255, 255]);
        assert_eq!(packed(&[]), [0]);
    }

    #[test]
    fn blocks_that_are_cut_off_or_too_wide_are_errors() {
        let bytes = packed(&[1000; 100]);
        for length in 0..bytes.len() {
            assert_eq!(unpacked(&bytes[..length], 100), Err(Malformed::CutOff));
        }
        let mut wide = bytes;
        wide[0] = 33;
        assert_eq!(unpacked(&wide, 100), Err(Malformed::Width(33)));
    }

    proptest! {
        #[test]
        fn numbers_come_back(
            width in 0..=32_u32,
            numbers in prop::collection::vec(any::<u32>(), 0..=BLOCK),
        ) {
            let numbers: Vec<i32> = numbers
                .into_iter()
                .map(|z| signed((u64::from(z) & ((1 << width) - 1)) as u32))
                .collect();
            let bytes = packed(&numbers);
            prop_assert!(u32::from(bytes[0]) <= width);
            let length = (numbers.len() * usize::from(bytes[0])).div_ceil(8);
            prop_assert_eq!(bytes.len(), 1 + length);
            prop_assert_eq!(unpacked(&bytes, numbers.len()), Ok(numbers));
        }
    }
}
