//! PTS files of laser scanners: the number of points, then their table.

use super::cloud::too_few;
use super::error::FileErrors;
use super::imported::Hints;
use super::line::{line_end, without_comment};
use super::lines;
use super::number_format::Notation;
use super::part::{Order, Part};

/// The head of a file.
struct Head<'a> {
    /// The number of points.
    count: usize,
    /// The lines below it.
    table: &'a str,
    /// The number of lines above these.
    above: usize,
    /// The number of lines that are points.
    found: usize,
}

/// Returns true if a text is a number of points above as many points, or above points of a scan.
pub(super) fn is_pts(text: &str) -> bool {
    head(text).is_some()
}

/// The points: those of a scan have no order.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Part, FileErrors> {
    let (end, empty) = (
        line_end(text),
        Head {
            count: 0,
            table: text,
            above: 0,
            found: 0,
        },
    );
    let head = head(text).unwrap_or(empty);
    if head.found < head.count {
        return Err(too_few(head.found, head.count as u64, "points", "PTS").into());
    }
    if head.found > head.count {
        let beyond = filled_lines(head.table, end).nth(head.count);
        let beyond = beyond.map_or(head.above, |(line, _)| head.above + line);
        let detail = format!(
            "the file says that it has {} points (PTS), and here is one more line",
            head.count
        );
        return Err(super::error::FileError::at(beyond, detail).into());
    }
    let part = lines::read(head.table, hints);
    let mut part = part.map_err(|errors| errors.moved_down(head.above))?;
    part.move_down(head.above);
    part.breaks.clear();
    let count = part.points.len();
    let notice = format!("The first number of the file is that of its points, {count} (PTS).");
    part.notices.insert(0, notice);
    if part.points.dimension() > 2 {
        part.order = Order::None;
    }
    Ok(part)
}

/// The head of a file; `None` if it is not PTS.
fn head(text: &str) -> Option<Head<'_>> {
    let end = line_end(text);
    let (above, first) = filled_lines(text, end).next()?;
    let count = first.parse().ok()?;
    let (_, table) = text.splitn(above + 1, end).enumerate().nth(above)?;
    let (_, point) = filled_lines(table, end).next()?;
    let columns = Notation::of(point)?.fields(point).count();
    let found = filled_lines(table, end).count();
    let is_scan = columns > 2;
    (is_scan || (columns == 2 && found == count)).then_some(Head {
        count,
        table,
        above,
        found,
    })
}

/// The lines that are neither blank nor comments, with their numbers from 1.
fn filled_lines(text: &str, end: char) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.split(end).map(without_comment).enumerate();
    let filled = lines.filter(|(_, line)| !line.is_empty());
    filled.map(|(index, line)| (index + 1, line))
}

#[cfg(test)]
mod tests {
    use crate::import::tests::HINTS;
    use crate::import::{Hints, Imported, Kind, read as read_file};

    fn surface(text: &str) -> Result<Imported, String> {
        let kind = Some(Kind::Surface);
        read_file(text.as_bytes(), &Hints { kind, ..HINTS }).map_err(|errors| errors.to_string())
    }

    #[test]
    fn the_first_number_is_that_of_the_points() {
        for (text, line) in [
            ("3\n1 2 3\n4 5 6\n7 8 10\n", 2),
            (
                "\n 3 \r\n\r\n1 2 3 -700 9 9 9\r\n4 5 6 12 8 8 8\r\n\r\n7 8 10 5 0 0 0",
                4,
            ),
            ("# a scan\r3\r1 2 3 0.5\r4 5 6 0.5\r7 8 10 1\r", 3),
        ] {
            let scan = surface(text).unwrap();
            assert_eq!(scan.points.lane(2), [3.0, 6.0, 10.0], "{text:?}");
            assert_eq!((scan.lines[0], scan.unordered), (line, true));
            let notice = "The first number of the file is that of its points, 3 (PTS).";
            assert_eq!(scan.notices[0], notice);
        }
        // Points of a curve, if their number is the first one.
        let curve = read_file(b"3\n1 2\n4 5\n7 9\n", &HINTS).unwrap();
        assert_eq!(curve.points.lane(0), [1.0, 4.0, 7.0]);
        assert_eq!((curve.lines, curve.unordered), (vec![2, 3, 4], false));
    }

    #[test]
    fn numbers_of_points_match() {
        let few = "the file has 2 points, and says that it has 3 (PTS)";
        assert_eq!(surface("3\n1 2 3\n4 5 6\n").unwrap_err(), few);
        let huge = surface("18446744073709551615\n1 2 3\n4 5 6\n").unwrap_err();
        assert_eq!(
            huge,
            "the file has 2 points, and says that it has 18446744073709551615 (PTS)"
        );
        let more = surface("2\n1 2 3\n\n4 5 6\n1\n7 8 9\n").unwrap_err();
        assert_eq!(
            more,
            "line 5: the file says that it has 2 points (PTS), and here is one more line"
        );
        assert!(
            surface("2\n1 2 3\n4 5 x\n")
                .unwrap_err()
                .starts_with("line 3: column 3")
        );
        let many = Hints { most: 1, ..HINTS };
        let many = read_file(b"2\n1 2 3\n4 5 6\n", &many).unwrap_err();
        assert_eq!(
            many.to_string(),
            "line 3: there are more than 1 points, the limit"
        );
        // Tables of one column, and of two that are not as many.
        assert_eq!(surface("3\n1\n2\n4\n").unwrap().points.len(), 4);
        assert!(
            surface("3\n1 2\n4 5\n")
                .unwrap_err()
                .contains("2 columns here, and 1")
        );
    }
}
