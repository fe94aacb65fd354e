//! PCD files of the Point Cloud Library, as text, binary and compressed: x, y and z of points; other fields are not read.
//!
//! - `header`: the fields of a point and how they are stored;
//! - `lzf`: the compression.

mod header;
mod lzf;

use super::binary::{Endian, Scalar, count_field};
use super::byte_lines::{number, text, words};
use super::cloud::{Cloud, not_read, too_few, too_many};
use super::error::{FileError, FileErrors};
use super::imported::Hints;
use super::part::Part;
use crate::text::quoted;
use header::{Coordinate, Data, Header};

pub(super) use header::is_pcd;

/// The points of a cloud, without an order, even if they form rows.
pub(super) fn read(bytes: &[u8], hints: &Hints) -> Result<Part, FileErrors> {
    let header = Header::read(bytes)?;
    let coordinates = header.coordinates()?;
    let cloud = match header.data {
        Data::Text => lines(&header, &coordinates, hints)?,
        Data::Binary => records(&header, &coordinates, hints)?,
        Data::Compressed => compressed(&header, &coordinates, hints)?,
    };
    let count = cloud.len();
    let mut notices = vec![format!(
        "The points are the {count} points of a cloud (PCD)."
    )];
    let names = header.fields.iter().map(|field| field.name.as_str());
    let is_other = |name: &&str| coordinates.iter().all(|it| it.name != *name) && *name != "_";
    notices.extend(not_read("Fields", names.filter(is_other)));
    Ok(cloud.part(notices)?)
}

fn lines(
    header: &Header<'_>,
    coordinates: &[Coordinate<'_>],
    hints: &Hints,
) -> Result<Cloud, FileError> {
    let mut lines = header.body.clone();
    let columns = header.fields.iter().map(|field| field.count);
    let columns = columns.fold(0, usize::saturating_add);
    let room = lines.rest().len() / 4;
    let mut cloud = Cloud::new(coordinates.len(), room.min(header.count), hints.most);
    let mut point = vec![0.0; coordinates.len()];
    for found in 0..header.count {
        let Some(line) = lines.next_filled() else {
            return Err(too_few(found, header.count as u64, "points", "PCD"));
        };
        let width = words(line).count();
        if width != columns {
            let detail =
                format!("{width} values here, and the fields of a point have {columns} (PCD)");
            return Err(FileError::at(lines.number, detail));
        }
        for (x, coordinate) in point.iter_mut().zip(coordinates) {
            let word = words(line).nth(coordinate.column).unwrap_or_default();
            *x = number(word).ok_or_else(|| {
                let detail = format!("{}: {} is no number", coordinate.name, quoted(&text(word)));
                FileError::at(lines.number, detail)
            })?;
        }
        cloud.push(&point, Some(lines.number))?;
    }
    Ok(cloud)
}

/// The points of a file with one record after the other.
fn records(
    header: &Header<'_>,
    coordinates: &[Coordinate<'_>],
    hints: &Hints,
) -> Result<Cloud, FileError> {
    let data = header.body.rest();
    let size = header.record_size()?;
    let found = data.len() / size;
    if found < header.count {
        return Err(too_few(found, header.count as u64, "points", "PCD"));
    }
    let mut cloud = Cloud::new(coordinates.len(), header.count, hints.most);
    let mut point = vec![0.0; coordinates.len()];
    for record in data.chunks_exact(size).take(header.count) {
        for (x, coordinate) in point.iter_mut().zip(coordinates) {
            let bytes = record.get(coordinate.offset..).unwrap_or_default();
            *x = coordinate
                .kind
                .read(bytes, Endian::Little)
                .unwrap_or(f64::NAN);
        }
        cloud.push(&point, None)?;
    }
    Ok(cloud)
}

/// The points of a compressed file, which has one field after the other. Only the coordinates are kept of the
/// decompressed data, which may be a hundred times as large as the file.
fn compressed(
    header: &Header<'_>,
    coordinates: &[Coordinate<'_>],
    hints: &Hints,
) -> Result<Cloud, FileError> {
    if header.count > hints.most {
        return Err(FileError::of_file(too_many(hints.most)));
    }
    let data = header.body.rest();
    let early = || FileError::of_file("the file ends within its compressed data (PCD)");
    let compressed = count_field(data, 0, Scalar::U32).ok_or_else(early)?;
    let said = count_field(data, 4, Scalar::U32).ok_or_else(early)?;
    let data = data
        .get(8..)
        .and_then(|it| it.get(..compressed))
        .ok_or_else(early)?;
    let size = header.record_size()?.checked_mul(header.count);
    if size != Some(said) {
        let detail = format!(
            "the compressed data have {said} bytes, which are not {} points (PCD)",
            header.count
        );
        return Err(FileError::of_file(detail));
    }
    let columns = decompressed(data, said, header.count, coordinates)
        .ok_or_else(|| FileError::of_file("the compressed data are damaged (PCD)"))?;
    let mut cloud = Cloud::new(coordinates.len(), header.count, hints.most);
    let mut point = vec![0.0; coordinates.len()];
    for index in 0..header.count {
        for (x, (column, coordinate)) in point.iter_mut().zip(columns.iter().zip(coordinates)) {
            let bytes = column
                .get(index * coordinate.kind.size()..)
                .unwrap_or_default();
            *x = coordinate
                .kind
                .read(bytes, Endian::Little)
                .unwrap_or(f64::NAN);
        }
        cloud.push(&point, None)?;
    }
    Ok(cloud)
}

/// The bytes of each coordinate of all points; `None` if the data are damaged.
fn decompressed(
    data: &[u8],
    size: usize,
    count: usize,
    coordinates: &[Coordinate<'_>],
) -> Option<Vec<Vec<u8>>> {
    let mut columns = vec![Vec::new(); coordinates.len()];
    let mut passed = 0;
    lzf::decompress(data, size, |bytes| {
        for (column, coordinate) in columns.iter_mut().zip(coordinates) {
            let start = coordinate.offset * count;
            let end = start + coordinate.kind.size() * count;
            let within = |place: usize| place.saturating_sub(passed).min(bytes.len());
            column.extend_from_slice(bytes.get(within(start)..within(end)).unwrap_or_default());
        }
        passed += bytes.len();
    })?;
    Some(columns)
}

#[cfg(test)]
mod tests;
