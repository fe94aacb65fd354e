//! The curves of a file with several, before they become parts.

use std::collections::{HashMap, HashSet};

use super::error::{FileError, FileErrors};
use super::part::{NO_POINTS, Order, Part, Parts, check_count};
use crate::wgs84::Origin;
use piad_fit::data::Points;

/// The last point of a closed curve is the first one again if it is no further from it than this part of its size.
const SAME: f64 = 1e-9;

/// The most parts that are left out whose numbers are listed.
const MOST_NUMBERS: usize = 10;

/// Three coordinates; what the third one means for curves of a plane is up to the reader.
pub(super) type Point = [f64; 3];

/// One curve or cloud of a file.
#[derive(Debug, Default)]
pub(super) struct Curve {
    pub(super) name: Option<String>,
    pub(super) points: Vec<Point>,
    /// The line of each point, from 1; empty for files without lines.
    pub(super) lines: Vec<u32>,
    /// True if it is closed according to the file; its first point may be repeated at its end.
    pub(super) closed: bool,
    /// True if, according to the file, the points follow each other along a curve.
    pub(super) ordered: bool,
    /// The time of each point in seconds from the first one.
    pub(super) times: Option<Vec<f64>>,
    pub(super) notices: Vec<String>,
}

/// The curves of a file, in its order, with no more points than the limit.
#[derive(Debug)]
pub(super) struct Curves {
    curves: Vec<Curve>,
    count: usize,
    most: usize,
    /// The origin of the first two coordinates, if they were longitudes and latitudes.
    pub(super) origin: Option<Origin>,
}

impl Curve {
    /// A curve without points yet.
    pub(super) fn new(name: Option<String>) -> Self {
        Self {
            name,
            ordered: true,
            ..Self::default()
        }
    }

    /// A cloud without points yet.
    pub(super) fn cloud(name: Option<String>) -> Self {
        Self {
            name,
            ..Self::default()
        }
    }

    /// Adds a point of this line.
    pub(super) fn push(&mut self, point: Point, line: u32) {
        self.points.push(point);
        self.lines.push(line);
    }

    /// Returns true if there are two points that are not equal.
    fn has_two(&self, dimension: usize) -> bool {
        let first = self.points.first().and_then(|it| it.get(..dimension));
        self.points
            .iter()
            .any(|point| point.get(..dimension) != first)
    }

    /// Returns true if the last point is the first one again, but for rounding.
    pub(super) fn ends_meet(&self) -> bool {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return false;
        };
        let distance = distance(first, last);
        self.points.len() > 1 && (distance == 0.0 || distance <= SAME * size(&self.points))
    }

    /// Removes the first point if it is repeated at the end of a closed curve. Two points are never closed.
    fn close(&mut self) {
        if !self.closed {
            return;
        }
        if self.ends_meet() {
            self.points.pop();
            self.lines.truncate(self.points.len());
            if let Some(times) = &mut self.times {
                times.truncate(self.points.len());
            }
        }
        self.closed = self.points.len() > 2;
    }

    fn part(self, dimension: usize, name: Option<String>) -> Result<Part, FileError> {
        let lane = |c: usize| -> Vec<f64> {
            let of = |point: &Point| point.get(c).copied();
            self.points.iter().filter_map(of).collect()
        };
        let order = match self.ordered {
            true => Order::Curve,
            false => Order::Unsaid,
        };
        let points = Points::from_lanes((0..dimension).map(lane));
        Ok(Part {
            closed: self.closed,
            times: self.times,
            name,
            notices: self.notices,
            ..Part::ordered(points, self.lines, order)?
        })
    }
}

impl Curves {
    /// No curves, with a limit of `most` points in total.
    pub(super) fn new(most: usize) -> Self {
        Self {
            curves: Vec::new(),
            count: 0,
            most,
            origin: None,
        }
    }

    /// Adds a curve.
    ///
    /// # Errors
    ///
    /// If there are more points than the limit, or coordinates that are not finite after overflow.
    pub(super) fn push(&mut self, curve: Curve) -> Result<(), FileError> {
        self.check_room(&curve)?;
        let wild = |[x, y, z]: &Point| !x.is_finite() || !y.is_finite() || z.is_infinite();
        if let Some(index) = curve.points.iter().position(wild) {
            let detail = "the coordinates of a point are too large";
            return Err(at(curve.lines.get(index), detail.to_owned()));
        }
        self.count += curve.points.len();
        self.curves.push(curve);
        Ok(())
    }

    /// Refuses a curve with more points than there is room for; the curve need not be complete.
    ///
    /// # Errors
    ///
    /// If there are more points than the limit.
    pub(super) fn check_room(&self, curve: &Curve) -> Result<(), FileError> {
        let room = self.most.saturating_sub(self.count);
        if curve.points.len() <= room {
            return Ok(());
        }
        let detail = format!("there are more than {} points, the limit", self.most);
        Err(at(curve.lines.get(room), detail))
    }

    /// The number of points of all curves.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The points of all curves.
    pub(super) fn points(&self) -> impl Iterator<Item = &Point> {
        self.curves.iter().flat_map(|curve| &curve.points)
    }

    /// The points of all curves, to be changed.
    pub(super) fn points_mut(&mut self) -> impl Iterator<Item = &mut Point> {
        self.curves.iter_mut().flat_map(|curve| &mut curve.points)
    }

    /// The parts of this many coordinates, and notices about the file. Parts with fewer than two different points are
    /// left out, with a notice.
    ///
    /// # Errors
    ///
    /// If nothing remains.
    pub(super) fn finish(
        self,
        dimension: usize,
        mut notices: Vec<String>,
    ) -> Result<Parts, FileErrors> {
        check_count(self.count)?;
        let mut names = Names::default();
        let mut left_out = Vec::new();
        let mut parts = Vec::with_capacity(self.curves.len());
        for (index, mut curve) in self.curves.into_iter().enumerate() {
            if !curve.has_two(dimension) {
                left_out.push(index + 1);
                continue;
            }
            curve.close();
            let name = curve.name.take().and_then(|name| names.of(&name));
            parts.push(Part {
                origin: self.origin,
                ..curve.part(dimension, name)?
            });
        }
        if parts.is_empty() {
            return Err(FileError::of_file(NO_POINTS).into());
        }
        notices.extend(short_parts(&left_out));
        Ok(Parts { parts, notices })
    }
}

/// The notice about parts that are left out.
fn short_parts(numbers: &[usize]) -> Option<String> {
    let listed = numbers.iter().take(MOST_NUMBERS).map(usize::to_string);
    let listed = listed.collect::<Vec<_>>().join(", ");
    match numbers.len() {
        0 => None,
        1 => Some(format!(
            "Part {listed} of the file has fewer than 2 different points, and is left out."
        )),
        count if count <= MOST_NUMBERS => Some(format!(
            "Parts {listed} of the file have fewer than 2 different points, and are left out."
        )),
        count => Some(format!(
            "{count} parts of the file have fewer than 2 different points, and are left out: parts {listed} and others."
        )),
    }
}

/// An error at a line, if there is one.
fn at(line: Option<&u32>, detail: String) -> FileError {
    FileError::new(line.map(|line| *line as usize), detail)
}

/// The distance of two points.
pub(super) fn distance(a: &Point, b: &Point) -> f64 {
    // The third coordinate may be missing, as NaN.
    let depth = |d: f64| if d.is_nan() { 0.0 } else { d };
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], depth(a[2] - b[2])];
    x.hypot(y).hypot(z)
}

/// The diagonal of the box around points.
pub(super) fn size<'a>(points: impl IntoIterator<Item = &'a Point>) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for ((low, high), x) in low.iter_mut().zip(&mut high).zip(point) {
            *low = low.min(*x);
            *high = high.max(*x);
        }
    }
    let side = |low: f64, high: f64| (high - low).max(0.0);
    let [x, y, z] = [0, 1, 2].map(|c| side(low[c], high[c]));
    x.hypot(y).hypot(z)
}

/// Makes names unique: the second part with a name gets a number appended.
#[derive(Default)]
struct Names {
    taken: HashSet<String>,
    /// The number of parts of a name.
    counts: HashMap<String, usize>,
}

impl Names {
    /// The name of the next part with this name; `None` if it is blank.
    fn of(&mut self, name: &str) -> Option<String> {
        // As one line: files wrap long names.
        let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
        if name.is_empty() {
            return None;
        }
        let count = self.counts.entry(name.clone()).or_default();
        loop {
            *count += 1;
            let numbered = match *count {
                1 => name.clone(),
                count => format!("{name} {count}"),
            };
            if self.taken.insert(numbered.clone()) {
                return Some(numbered);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(name: &str, points: &[Point]) -> Curve {
        let mut curve = Curve::new(Some(name.to_owned()));
        for (line, point) in (1..).zip(points) {
            curve.push(*point, line);
        }
        curve
    }

    const SQUARE: [Point; 5] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 1e-12, 0.0],
    ];

    #[test]
    fn closed_curves_have_their_first_point_once() {
        let mut curves = Curves::new(100);
        for closed in [true, false] {
            let square = curve("a", &SQUARE);
            curves.push(Curve { closed, ..square }).unwrap();
        }
        // There and back is no closed curve.
        let back = curve("b", &[SQUARE[0], SQUARE[1], SQUARE[0]]);
        let closed = true;
        curves.push(Curve { closed, ..back }).unwrap();
        let parts = curves.finish(2, Vec::new()).unwrap().parts;
        let found = parts.iter().map(|it| (it.points.len(), it.lines.len()));
        assert_eq!(found.collect::<Vec<_>>(), [(4, 4), (5, 5), (2, 2)]);
        let closed = parts.iter().map(|it| it.closed);
        assert_eq!(closed.collect::<Vec<_>>(), [true, false, false]);
    }

    #[test]
    fn names_are_there_once() {
        let mut names = Names::default();
        let found = ["a", "a 2", "a", "a", " \n", "b\n c"].map(|name| names.of(name));
        let expected = [
            Some("a"),
            Some("a 2"),
            Some("a 3"),
            Some("a 4"),
            None,
            Some("b c"),
        ];
        assert_eq!(found.each_ref().map(Option::as_deref), expected);
    }

    #[test]
    fn parts_of_one_point_are_left_out() {
        let mut curves = Curves::new(100);
        for points in [&SQUARE[..1], &SQUARE[..3], &[SQUARE[1], SQUARE[1]]] {
            curves.push(curve("a", points)).unwrap();
        }
        let parts = curves.finish(2, Vec::new()).unwrap();
        assert_eq!(parts.parts[0].name.as_deref(), Some("a"));
        assert_eq!(parts.parts.len(), 1);
        let notice = "Parts 1, 3 of the file have fewer than 2 different points, and are left out.";
        assert_eq!(parts.notices, [notice]);
        let mut none = Curves::new(100);
        none.push(curve("a", &[SQUARE[1]; 2])).unwrap();
        let error = none.finish(2, Vec::new()).unwrap_err();
        assert_eq!(error.to_string(), NO_POINTS);
    }

    #[test]
    fn all_parts_share_the_limit() {
        let mut curves = Curves::new(8);
        curves.push(curve("a", &SQUARE)).unwrap();
        let error = curves.push(curve("b", &SQUARE)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "line 4: there are more than 8 points, the limit"
        );
        let wild = curve("c", &[SQUARE[0], [f64::INFINITY, 0.0, 0.0]]);
        assert_eq!(curves.push(wild).unwrap_err().line, Some(2));
    }
}
