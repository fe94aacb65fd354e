//! Binary STL: 80 bytes of anything, the number of triangles, and 50 bytes for each: normal, corners, and two more.

use super::super::binary::{Endian, Scalar, count_field, field};
use super::super::cloud::too_few;
use super::super::error::{FileError, FileErrors};
use super::super::imported::Hints;
use super::super::part::Part;
use super::Corners;

/// The bytes above the number of triangles.
const TITLE: usize = 80;

/// The bytes above the triangles.
const HEAD: usize = TITLE + 4;

/// The bytes of a triangle.
const TRIANGLE: usize = 50;

/// The bytes of its normal.
const NORMAL: usize = 12;

/// Coordinates of damaged files are distinguished from other data by this range.
const PLAUSIBLE: std::ops::Range<f64> = 1e-12..1e12;

/// Returns true if a file is binary STL. The title may be anything, also `solid` as in text: the size of the file
/// identifies it, or the first triangle of a file of the wrong size.
pub(in super::super) fn is_binary(bytes: &[u8]) -> bool {
    let size = triangles(bytes).and_then(|count| count.checked_mul(TRIANGLE)?.checked_add(HEAD));
    size.is_some_and(|size| size == bytes.len()) || is_damaged(bytes)
}

/// Returns true if a file of another size begins as such files do: with a title in letters, and a triangle with a
/// normal.
fn is_damaged(bytes: &[u8]) -> bool {
    let is_title = |title: &[u8]| {
        let mut bytes = title.iter();
        bytes.all(|byte| matches!(byte, 0 | b' '..=b'~'))
    };
    let Some(head) = bytes.get(..HEAD + TRIANGLE).filter(|it| it.contains(&0)) else {
        return false;
    };
    let numbers = (HEAD..HEAD + 48).step_by(4);
    let numbers: Vec<f64> = numbers
        .filter_map(|at| field(head, at, Scalar::F32))
        .collect();
    let (normal, corners) = numbers.split_at(3);
    let length = normal.iter().map(|x| x * x).sum::<f64>();
    let is_number = |x: &f64| *x == 0.0 || PLAUSIBLE.contains(&x.abs());
    head.get(..TITLE).is_some_and(is_title)
        && triangles(bytes).is_some_and(|count| count > 0)
        && (length == 0.0 || (length - 1.0).abs() < 0.01)
        && corners.iter().all(is_number)
        && corners.iter().any(|x| *x != 0.0)
}

/// The number of triangles according to the file.
fn triangles(bytes: &[u8]) -> Option<usize> {
    count_field(bytes, TITLE, Scalar::U32)
}

/// The corners of the triangles, which have no order.
pub(in super::super) fn read_binary(bytes: &[u8], hints: &Hints) -> Result<Part, FileErrors> {
    let said = triangles(bytes).unwrap_or_default();
    let (found, rest) = bytes
        .get(HEAD..)
        .unwrap_or_default()
        .as_chunks::<TRIANGLE>();
    if found.len() < said {
        return Err(too_few(found.len(), said as u64, "triangles", "STL").into());
    }
    let beyond = (found.len() - said) * TRIANGLE + rest.len();
    if beyond > 0 {
        let detail = format!("the file has {beyond} bytes below its {said} triangles (STL)");
        return Err(FileError::of_file(detail).into());
    }
    let mut corners = Corners::new(hints.most);
    for triangle in found {
        for corner in triangle
            .get(NORMAL..)
            .unwrap_or_default()
            .chunks_exact(12)
            .take(3)
        {
            let coordinate = |at: usize| {
                let x = corner.get(at..)?;
                Scalar::F32.read(x, Endian::Little)
            };
            let corner = [0, 4, 8].map(|at| coordinate(at).unwrap_or(f64::NAN));
            corners.push(corner, None)?;
        }
    }
    Ok(corners.part(said)?)
}
