//! LZF, a compression of bytes: runs of bytes, and references to bytes that are at most 8 KiB back.

/// The farthest that a reference reaches back.
const WINDOW: usize = 8192;

/// The number of bytes that are decompressed at a time.
const PIECE: usize = 64 * 1024;

/// Decompresses data to this many bytes, and passes them on piece by piece; `None` if the data are damaged.
pub(super) fn decompress(mut data: &[u8], size: usize, mut put: impl FnMut(&[u8])) -> Option<()> {
    let mut out: Vec<u8> = Vec::with_capacity(PIECE + WINDOW);
    // The number of bytes of `out` that were passed on, and of those before it.
    let (mut given, mut before) = (0, 0_usize);
    while !data.is_empty() {
        step(&mut data, &mut out)?;
        if before + out.len() > size {
            return None;
        }
        if out.len() >= PIECE + WINDOW {
            put(out.get(given..)?);
            let kept = out.len() - WINDOW;
            out.drain(..kept);
            before += kept;
            given = WINDOW;
        }
    }
    put(out.get(given..)?);
    (before + out.len() == size).then_some(())
}

/// Appends a run of bytes or the bytes of a reference.
fn step(data: &mut &[u8], out: &mut Vec<u8>) -> Option<()> {
    let control = usize::from(next(data)?);
    let Some(length) = Some(control >> 5).filter(|length| *length > 0) else {
        let (run, rest) = data.split_at_checked(control + 1)?;
        out.extend_from_slice(run);
        *data = rest;
        return Some(());
    };
    let more = match length {
        7 => usize::from(next(data)?),
        _ => 0,
    };
    let back = ((control & 0x1f) << 8) + usize::from(next(data)?) + 1;
    let start = out.len().checked_sub(back)?;
    // The bytes may be those that are appended here.
    for index in start..start + length + more + 2 {
        out.push(*out.get(index)?);
    }
    Some(())
}

fn next(data: &mut &[u8]) -> Option<u8> {
    let (first, rest) = data.split_first()?;
    *data = rest;
    Some(*first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(data: &[u8], size: usize) -> Option<Vec<u8>> {
        let mut all = Vec::new();
        decompress(data, size, |piece| all.extend_from_slice(piece))?;
        Some(all)
    }

    #[test]
    fn runs_and_references() {
        assert_eq!(bytes(&[], 0).unwrap(), b"");
        assert_eq!(bytes(&[2, b'a', b'b', b'c'], 3).unwrap(), b"abc");
        // Three bytes from two bytes back, and nine more of one byte.
        let data = [1, b'a', b'b', 0x20, 1, 0xe0, 0, 0];
        assert_eq!(bytes(&data, 14).unwrap(), b"ababaaaaaaaaaa");
        // Damaged: other sizes, cut off, too far back.
        assert_eq!(bytes(&data, 13), None);
        assert_eq!(bytes(&data, 15), None);
        for end in 1..data.len() {
            assert_eq!(bytes(&data[..end], 14), None, "{end}");
        }
        assert_eq!(bytes(&[0, b'a', 0x20, 1], 4), None);
    }

    #[test]
    fn much_is_decompressed_in_pieces() {
        // 1,000 bytes that are not alike, and then 3,000 times 264 bytes from 1,000 and from 8,192 bytes back.
        let start: Vec<u8> = (0..1000_u32).map(|i| (i * i / 7) as u8).collect();
        let mut data = Vec::new();
        for run in start.chunks(32) {
            data.push(run.len() as u8 - 1);
            data.extend_from_slice(run);
        }
        let mut expected = start;
        for i in 0..3000 {
            let back: usize = if i < 100 { 1000 } else { WINDOW };
            data.extend([0xe0 | ((back - 1) >> 8) as u8, 255, (back - 1) as u8]);
            for _ in 0..264 {
                expected.push(expected[expected.len() - back]);
            }
        }
        assert_eq!(bytes(&data, expected.len()).unwrap(), expected);
    }
}
