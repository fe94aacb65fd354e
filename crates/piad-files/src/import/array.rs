//! Points as a JSON array: of points, of rows of points, or of rows of heights.

use piad_fit::data::{Grid, MAX_DIMENSION, MAX_SURFACE_DIMENSION};
use serde_json::de::StrRead;
use serde_json::{Deserializer, Value};

use super::error::FileError;
use super::imported::{Hints, Kind};
use super::part::{Order, Part};
use crate::json::{ListLimits, Rows, read_points, read_rows};

/// The kind of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    /// `[[x, y], …]`.
    Points,
    /// `[[[x, y, z], …], …]`.
    Rows,
    /// `[[z, z, …], …]`, more of them in a row than a point has coordinates.
    Heights,
}

/// Returns true if a text can be no table, but such an array.
pub(super) fn is_array(text: &str) -> bool {
    text.trim_start().starts_with('[')
}

/// Reads an array; errors are located by line.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Part, FileError> {
    let shape = Shape::of(text, hints.kind);
    if shape == Shape::Points {
        let points = parse(text, hints.most, |json, limits| read_points(json, limits))?;
        return Part::new(points, lines(text, shape));
    }
    let Rows {
        points,
        missing,
        grid,
    } = parse(text, hints.most, |json, limits| read_rows(json, limits))?;
    let what = match shape {
        Shape::Heights => "heights, at equal steps",
        _ => "points",
    };
    let Grid { rows, columns } = grid;
    let notice = format!("The file has {rows} rows of {columns} {what}.");
    Ok(Part {
        missing,
        notices: vec![notice],
        ..Part::ordered(points, lines(text, shape), Order::Rows(grid))?
    })
}

impl Shape {
    /// The shape of an array by its first element, and by what is to be fitted; other errors are found on reading.
    fn of(text: &str, kind: Option<Kind>) -> Self {
        let inner = text.trim_start().get(1..).unwrap_or_default();
        let first = Deserializer::from_str(inner).into_iter::<Value>().next();
        let Some(Ok(Value::Array(first))) = first else {
            return Self::Points;
        };
        let most = match kind {
            Some(Kind::Curve) => MAX_DIMENSION,
            _ => MAX_SURFACE_DIMENSION,
        };
        match first.iter().any(Value::is_array) {
            true => Self::Rows,
            false if first.len() > most => Self::Heights,
            false => Self::Points,
        }
    }

    /// The nesting depth of a point.
    fn depth(self) -> usize {
        match self {
            Self::Points => 1,
            Self::Rows | Self::Heights => 2,
        }
    }
}

fn parse<'a, T>(
    text: &'a str,
    most: usize,
    read: impl FnOnce(&mut Deserializer<StrRead<'a>>, ListLimits) -> serde_json::Result<T>,
) -> Result<T, FileError> {
    let mut json = Deserializer::from_str(text);
    let value = read(&mut json, ListLimits::new(text.as_bytes(), most));
    let value = value.and_then(|value| json.end().map(|()| value));
    value.map_err(|error| {
        let message = error.to_string();
        let detail = message.split(" at line ").next().unwrap_or(&message);
        FileError::at(error.line().max(1), detail)
    })
}

/// The line of each point, from 1, in a text that is such an array.
fn lines(text: &str, shape: Shape) -> Vec<u32> {
    let around = shape.depth();
    let (mut lines, mut line, mut depth) = (Vec::new(), 1_u32, 0);
    // True if a point begins with the next value.
    let mut expected = false;
    for byte in text.bytes() {
        match byte {
            b'\n' => line = line.saturating_add(1),
            b' ' | b'\t' | b'\r' => {}
            b',' => expected = depth == around,
            b']' => {
                expected = false;
                depth -= 1;
            }
            _ => {
                if expected {
                    lines.push(line);
                }
                depth += usize::from(byte == b'[');
                expected = byte == b'[' && !expected && depth == around;
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::tests::HINTS;
    use crate::import::{Imported, read as read_file};

    fn read(text: &str, hints: &Hints) -> Result<Imported, FileError> {
        read_file(text.as_bytes(), hints).map_err(|mut errors| errors.0.remove(0))
    }

    fn grid(rows: usize, columns: usize) -> Option<Grid> {
        Some(Grid { rows, columns })
    }

    #[test]
    fn arrays_are_points_or_rows_with_their_lines() {
        let list = read("\n[[0, 1],\n [2,\n 3], [4, 5]]", &HINTS).unwrap();
        assert_eq!(list.points.lane(0), [0.0, 2.0, 4.0]);
        assert_eq!((list.grid, list.lines), (None, vec![2, 3, 4]));
        let rows = "[[[0,0,1],[0,1,2]],\n[[1,0,3],\n[1,1.5,1]]]";
        let rows = read(rows, &HINTS).unwrap();
        assert_eq!((rows.grid, rows.lines), (grid(2, 2), vec![1, 1, 2, 3]));
        assert_eq!(rows.points.lane(1), [0.0, 1.0, 0.0, 1.5]);
        let heights = read("[[1, 2, null, 4],\n[5, 6,\n-7e-1, 8]]", &HINTS).unwrap();
        assert_eq!(heights.grid, grid(2, 4));
        assert_eq!(heights.lines, [1, 1, 1, 1, 2, 2, 3, 3]);
        assert_eq!((heights.missing, heights.points.dimension()), (vec![2], 1));
        assert!(heights.notices[0].contains("2 rows of 4 heights"));
        // A list of points that form a grid is treated like a table.
        let lattice = read("[[0,0,1],[0,1,2],[1,0,3],[1,1,1]]", &HINTS).unwrap();
        assert_eq!(lattice.grid, grid(2, 2));
    }

    #[test]
    fn arrays_that_are_none_of_these_are_refused_at_their_lines() {
        let surface = |size| Hints { size, ..HINTS };
        let curve = Hints {
            kind: Some(Kind::Curve),
            ..HINTS
        };
        for (text, hints, line, detail) in [
            ("[]", HINTS, None, "there are no points in the file"),
            ("[[1, 2]]", HINTS, None, "there is one point"),
            ("[1, 2, 3]", HINTS, Some(1), "invalid type"),
            (
                "[[1, 2],\n[3]]",
                HINTS,
                Some(2),
                "this point has 1 coordinates",
            ),
            (
                "[[1, 2],\n[3, 4",
                HINTS,
                Some(2),
                "EOF while parsing a list",
            ),
            (
                "[[1, 2],\n[3, 1e999]]",
                HINTS,
                Some(2),
                "number out of range",
            ),
            (
                "[[[1], [2]],\n[[3]]]",
                HINTS,
                Some(2),
                "this row has 1 points",
            ),
            ("[[[1],[2]],[[5],[6]]]", curve, None, "these are rows"),
            (
                "[[1,2,3,4],[5,6,7,8]]",
                surface(grid(4, 2)),
                None,
                "the file has 2 rows of 4",
            ),
        ] {
            let error = read(text, &hints).unwrap_err();
            assert_eq!(error.line, line, "{text}: {error:?}");
            assert!(error.detail.starts_with(detail), "{text}: {error:?}");
        }
        let few = Hints { most: 2, ..HINTS };
        let many = read("[[1, 2], [3, 4], [5, 6]]", &few).unwrap_err();
        assert!(many.detail.contains("limit"), "{many:?}");
    }

    #[test]
    fn outlines_close_as_those_of_tables_do() {
        let outline = "[[2,0],[3,1],[3,2],[2,3],[1,3],[0,2],[0,1],[1,0],[2,2.4e-16]]";
        let read_as = |closed| read(outline, &Hints { closed, ..HINTS }).unwrap();
        for (closed, expected) in [(None, true), (Some(true), true), (Some(false), false)] {
            let imported = read_as(closed);
            let count = 9 - usize::from(expected);
            assert_eq!((imported.closed, imported.points.len()), (expected, count));
            assert_eq!(imported.lines.len(), count);
            assert!(imported.notices[0].contains("The last point equals the first"));
        }
        let open = outline.replace("2.4e-16", "1e-6");
        assert!(!read(&open, &HINTS).unwrap().closed);
    }
}
