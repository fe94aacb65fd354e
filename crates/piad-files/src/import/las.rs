//! LAS files of laser scanners: x, y and z of points, which are whole numbers with a scale and an offset.

use super::binary::{Scalar, count_field, field};
use super::cloud::{Cloud, too_few};
use super::error::{FileError, FileErrors};
use super::imported::Hints;
use super::part::Part;

/// The signature.
const SIGNATURE: &[u8] = b"LASF";

/// Flags of the point format of compressed files.
const COMPRESSED: usize = 0b1100_0000;

/// The fewest bytes of a point of each format, from 0.
const LEAST_SIZES: [usize; 11] = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];

/// Offsets of the fields of the header.
mod at {
    pub(super) const VERSION_MAJOR: usize = 24;
    pub(super) const VERSION_MINOR: usize = 25;
    pub(super) const DATA_OFFSET: usize = 96;
    pub(super) const POINT_FORMAT: usize = 104;
    pub(super) const POINT_SIZE: usize = 105;
    pub(super) const POINT_COUNT: usize = 107;
    pub(super) const SCALES: usize = 131;
    pub(super) const OFFSETS: usize = 155;
    /// The end of the header of the first versions.
    pub(super) const END: usize = 227;
    /// The number of points from version 1.4 on.
    pub(super) const LARGE_COUNT: usize = 247;
}

/// The contents of the header.
struct Header {
    version: String,
    data: usize,
    format: usize,
    size: usize,
    count: usize,
    scales: [f64; 3],
    offsets: [f64; 3],
}

/// Returns true if a file is LAS or LAZ.
pub(super) fn is_las(bytes: &[u8]) -> bool {
    bytes.starts_with(SIGNATURE)
}

/// The points of a scan, which have no order.
pub(super) fn read(bytes: &[u8], hints: &Hints) -> Result<Part, FileErrors> {
    let early = || FileError::of_file("the file ends within its header (LAS)");
    let header = Header::read(bytes).ok_or_else(early)?;
    header.check()?;
    let data = bytes.get(header.data..).unwrap_or_default();
    let found = data.len() / header.size;
    if found < header.count {
        return Err(too_few(found, header.count as u64, "points", "LAS").into());
    }
    let mut cloud = Cloud::new(3, header.count, hints.most);
    for record in data.chunks_exact(header.size).take(header.count) {
        cloud.push(&header.point(record), None)?;
    }
    let notice = format!(
        "The points are the {} points of a scan (LAS {}, point format {}); only their coordinates are read.",
        cloud.len(),
        header.version,
        header.format
    );
    Ok(cloud.part(vec![notice])?)
}

impl Header {
    /// `None` if the file ends before.
    fn read(bytes: &[u8]) -> Option<Self> {
        bytes.get(..at::END)?;
        let byte = |at| count_field(bytes, at, Scalar::U8);
        let numbers = |at: usize| [0, 8, 16].map(|by| field(bytes, at + by, Scalar::F64));
        let all = |[x, y, z]: [Option<f64>; 3]| Some([x?, y?, z?]);
        let (major, minor) = (byte(at::VERSION_MAJOR)?, byte(at::VERSION_MINOR)?);
        let large = match (major, minor) {
            (1, 4..) => count_field(bytes, at::LARGE_COUNT, Scalar::U64)?,
            _ => 0,
        };
        let count = match large {
            0 => count_field(bytes, at::POINT_COUNT, Scalar::U32)?,
            count => count,
        };
        Some(Self {
            version: format!("{major}.{minor}"),
            data: count_field(bytes, at::DATA_OFFSET, Scalar::U32)?,
            format: byte(at::POINT_FORMAT)?,
            size: count_field(bytes, at::POINT_SIZE, Scalar::U16)?,
            count,
            scales: all(numbers(at::SCALES))?,
            offsets: all(numbers(at::OFFSETS))?,
        })
    }

    fn check(&self) -> Result<(), FileError> {
        let Self { format, size, .. } = self;
        let detail = if format & COMPRESSED != 0 {
            "this is LAZ, which is compressed LAS and not read: convert it to LAS".to_owned()
        } else if self.data < at::END {
            let data = self.data;
            format!("the points begin within the header, at byte {data} (LAS)")
        } else {
            match LEAST_SIZES.get(*format) {
                None => format!("point format {format} is unknown, those up to 10 are read (LAS)"),
                Some(least) if size < least => {
                    format!(
                        "points of format {format} have {least} bytes or more, not {size} (LAS)"
                    )
                }
                Some(_) => return Ok(()),
            }
        };
        Err(FileError::of_file(detail))
    }

    /// The point of a record.
    fn point(&self, record: &[u8]) -> [f64; 3] {
        let mut point = [0.0; 3];
        let axes = self.scales.iter().zip(&self.offsets);
        for (axis, (x, (scale, offset))) in point.iter_mut().zip(axes).enumerate() {
            let steps = field(record, 4 * axis, Scalar::I32);
            *x = steps.map_or(f64::NAN, |steps| steps * scale + offset);
        }
        point
    }
}

#[cfg(test)]
mod tests {
    use crate::import::tests::HINTS;
    use crate::import::{Hints, Imported, Kind, read as read_file};

    fn surface(bytes: &[u8]) -> Result<Imported, String> {
        let kind = Some(Kind::Surface);
        read_file(bytes, &Hints { kind, ..HINTS }).map_err(|errors| errors.to_string())
    }

    fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
        bytes[at..at + value.len()].copy_from_slice(value);
    }

    /// Three points of a version and a format, with bytes between the header and them.
    fn file(minor: u8, format: u8, size: u16) -> Vec<u8> {
        let mut bytes = vec![0; 400];
        put(&mut bytes, 0, b"LASF");
        put(&mut bytes, 24, &[1, minor]);
        put(&mut bytes, 96, &400_u32.to_le_bytes());
        put(&mut bytes, 104, &[format]);
        put(&mut bytes, 105, &size.to_le_bytes());
        match minor {
            4 => put(&mut bytes, 247, &3_u64.to_le_bytes()),
            _ => put(&mut bytes, 107, &3_u32.to_le_bytes()),
        }
        for (axis, (scale, offset)) in [(0.01, 4e5), (0.01, 5e6), (0.001, -10.0)]
            .iter()
            .enumerate()
        {
            put(&mut bytes, 131 + 8 * axis, &f64::to_le_bytes(*scale));
            put(&mut bytes, 155 + 8 * axis, &f64::to_le_bytes(*offset));
        }
        for point in [[100, 200, 3000], [-100, 0, i32::MAX], [7, 8, 9_i32]] {
            let mut record: Vec<u8> = point.iter().flat_map(|x| x.to_le_bytes()).collect();
            record.resize(size.into(), 0xff);
            bytes.extend(record);
        }
        bytes
    }

    #[test]
    fn points_have_a_scale_and_an_offset() {
        for (minor, format, size) in [(0, 0, 20), (1, 1, 28), (2, 3, 40), (3, 5, 63), (4, 10, 67)] {
            let scan = surface(&file(minor, format, size)).unwrap();
            assert_eq!(scan.points.lane(0), [400_001.0, 399_999.0, 400_000.07]);
            assert_eq!(scan.points.lane(2)[..2], [-7.0, 2_147_483.647 - 10.0]);
            assert!(scan.unordered && scan.lines.is_empty());
            assert_eq!(
                scan.notices[0],
                format!(
                    "The points are the 3 points of a scan (LAS 1.{minor}, point format {format}); only their coordinates are read."
                )
            );
        }
        // Bytes after the points, such as records of version 1.4, are skipped.
        let more = [&file(4, 6, 30)[..], &[0; 100]].concat();
        assert_eq!(surface(&more).unwrap().points.len(), 3);
    }

    #[test]
    fn errors_name_the_reason() {
        let changed = |at: usize, value: &[u8]| {
            let mut bytes = file(2, 1, 28);
            put(&mut bytes, at, value);
            surface(&bytes).unwrap_err()
        };
        assert_eq!(
            changed(104, &[0x81]),
            "this is LAZ, which is compressed LAS and not read: convert it to LAS"
        );
        assert_eq!(
            changed(104, &[11]),
            "point format 11 is unknown, those up to 10 are read (LAS)"
        );
        assert_eq!(
            changed(105, &[0, 0]),
            "points of format 1 have 28 bytes or more, not 0 (LAS)"
        );
        assert_eq!(
            changed(96, &[7, 0, 0, 0]),
            "the points begin within the header, at byte 7 (LAS)"
        );
        for offset in [u32::MAX, 2000] {
            assert_eq!(
                changed(96, &offset.to_le_bytes()),
                "the file has 0 points, and says that it has 3 (LAS)"
            );
        }
        assert_eq!(
            changed(107, &u32::MAX.to_le_bytes()),
            "the file has 3 points, and says that it has 4294967295 (LAS)"
        );
        assert_eq!(
            changed(131, &f64::NAN.to_le_bytes()),
            "none of the 3 points of the file has coordinates"
        );
        let whole = file(4, 6, 30);
        assert_eq!(
            surface(&whole[..whole.len() - 1]).unwrap_err(),
            "the file has 2 points, and says that it has 3 (LAS)"
        );
        for length in [4, 226] {
            let early = surface(&whole[..length]).unwrap_err();
            assert_eq!(early, "the file ends within its header (LAS)");
        }
        let mut huge = whole.clone();
        put(&mut huge, 247, &u64::MAX.to_le_bytes());
        let huge = surface(&huge).unwrap_err();
        assert!(
            huge.starts_with("the file has 3 points, and says that it has 1844674407"),
            "{huge}"
        );
        let few = Hints { most: 2, ..HINTS };
        let many = read_file(&whole, &few).unwrap_err();
        assert_eq!(many.to_string(), "there are more than 2 points, the limit");
    }
}
