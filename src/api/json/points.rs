//! Reads points from JSON straight into the arrays that are computed with.

use std::cell::{Cell, RefCell};

use serde::de::{MapAccess, SeqAccess};

use super::read::{Anything, Members, Most, Numeral, Of, Read, Reader, Reading};
use crate::fit::points::Points;
use crate::model::edit::Coordinates;
use crate::model::shape::MAX_DIMENSION;

/// A list of points: `[[x, y, z], …]`, each with 1, 2 or 3 coordinates, all alike.
#[derive(Debug)]
pub struct PointList(pub Points);

/// A list of scattered points, each with 1, 2 or 3 coordinates, all alike.
#[derive(Debug)]
pub struct ScatteredPoints(pub Points);

/// Rows (u) of columns (v) of points, or of heights, which are points of one coordinate; `null` stands
/// for a missing one.
#[derive(Debug)]
pub struct PointGrid {
    /// The points, row by row; missing ones at the origin.
    pub points: Points,
    /// The indices of missing points.
    pub missing: Vec<usize>,
    /// The number of rows.
    pub rows: usize,
    /// The number of columns.
    pub columns: usize,
}

impl Reader for Of<PointList> {
    type Value = PointList;

    fn expected(&self) -> String {
        "a list of points, [[x, y], …]".to_owned()
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<PointList>, A::Error> {
        let gathered = RefCell::new(Gathered::default());
        let row = PointRowReader(&gathered, Under::Curve);
        let whole = row.list(list, at)?;
        Ok(whole.map(|_| PointList(gathered.into_inner().points())))
    }
}

impl Reader for Of<ScatteredPoints> {
    type Value = ScatteredPoints;

    fn expected(&self) -> String {
        "a list of points, [[x, y, z], …]".to_owned()
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<ScatteredPoints>, A::Error> {
        let gathered = RefCell::new(Gathered::default());
        let row = PointRowReader(&gathered, Under::Scattered);
        let whole = row.list(list, at)?;
        Ok(whole.map(|_| ScatteredPoints(gathered.into_inner().points())))
    }
}

impl Reader for Of<PointGrid> {
    type Value = PointGrid;

    fn expected(&self) -> String {
        "rows of points, [[[x, y, z], …], …], or of heights, [[z, …], …]".to_owned()
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        rows: A,
        at: &mut Reading,
    ) -> Result<Option<PointGrid>, A::Error> {
        let gathered = RefCell::new(Gathered::default());
        let (mut count, mut columns) = (0, None);
        let most = Most::of(at.limits().points, "rows");
        let row = || PointRowReader(&gathered, Under::Surface);
        let whole = at.elements(rows, most, row, |length, at| {
            count += 1;
            let columns = *columns.get_or_insert(length);
            if columns != length {
                at.wrong(format!("this row has {length} points, the first row has {columns}: all rows must have the same number"));
                return None;
            }
            Some(())
        })?;
        let mut gathered = gathered.into_inner();
        Ok(whole.then(|| PointGrid {
            missing: std::mem::take(&mut gathered.missing),
            points: gathered.points(),
            rows: count,
            columns: columns.unwrap_or(0),
        }))
    }
}

/// What points belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Under {
    Curve,
    Surface,
    Scattered,
    Edit,
}

/// Points that were read so far.
#[derive(Default)]
struct Gathered {
    /// None before the first point, which says how many coordinates there are.
    points: Option<Points>,
    count: usize,
    missing: Vec<usize>,
}

impl Gathered {
    fn points(self) -> Points {
        let mut points = self.points.unwrap_or_else(|| Points::zeros(1, self.count));
        points.shrink_to_fit();
        points
    }

    /// Appends a point, or that it is missing.
    fn push(&mut self, point: Option<Coordinates>, at: &mut Reading) -> Option<()> {
        let before = self.count;
        match point {
            None => {
                if let Some(points) = &mut self.points {
                    points.push(&[0.0; MAX_DIMENSION]);
                }
                self.missing.push(before);
            }
            Some(point) => {
                let count = point.as_slice().len();
                let points = self
                    .points
                    .get_or_insert_with(|| Points::zeros(count, before));
                let dimension = points.dimension();
                if dimension != count {
                    at.wrong(format!("this point has {count} coordinates, the first has {dimension}: all points must have the same number"));
                    return None;
                }
                points.push(point.as_slice());
            }
        }
        self.count += 1;
        Some(())
    }
}

/// Appends a list of points; gives their number.
#[derive(Clone, Copy)]
struct PointRowReader<'a>(&'a RefCell<Gathered>, Under);

impl Reader for PointRowReader<'_> {
    type Value = usize;

    fn expected(&self) -> String {
        "a row of points, [[x, y, z], …]".to_owned()
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<usize>, A::Error> {
        let Self(gathered, under) = self;
        let most = Most::of(at.limits().points, "points").after(gathered.borrow().count);
        let (mut length, heights) = (0, Cell::new(false));
        let whole = at.elements(
            list,
            most,
            || PointReader {
                under,
                heights: Some(&heights),
            },
            |point, at| {
                length += 1;
                gathered.borrow_mut().push(point, at)
            },
        )?;
        if whole && heights.get() && length <= MAX_DIMENSION {
            at.wrong(format!(
                "expected a row of points, found {length} numbers: a list of points is a curve, and rows of so few \
                 heights are written as points, [[z], …]"
            ));
            return Ok(None);
        }
        Ok(whole.then_some(length))
    }
}

/// A point; none if it is missing.
struct PointReader<'a> {
    under: Under,
    /// Whether there was a number instead of a point.
    heights: Option<&'a Cell<bool>>,
}

impl PointReader<'_> {
    fn of_edit() -> Self {
        Self {
            under: Under::Edit,
            heights: None,
        }
    }
}

impl Reader for PointReader<'_> {
    type Value = Option<Coordinates>;

    fn expected(&self) -> String {
        format!("a point: a list of 1, 2 or {MAX_DIMENSION} numbers")
    }

    fn null(self, at: &mut Reading) -> Option<Option<Coordinates>> {
        if self.under == Under::Surface {
            return Some(None);
        }
        at.mismatch(&self.expected(), "null");
        None
    }

    fn number(self, value: Numeral, at: &mut Reading) -> Option<Option<Coordinates>> {
        if let (Under::Surface, Some(heights)) = (self.under, self.heights) {
            heights.set(true);
            return Some(Coordinates::of(&[value.real()]));
        }
        at.wrong(format!("expected {}, found {value}", self.expected()));
        None
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Option<Coordinates>>, A::Error> {
        let mut values = [0.0; MAX_DIMENSION];
        let mut count = 0;
        let reader = || CoordinateReader(self.under);
        let whole = at.elements(list, Most::any(), reader, |x, _| {
            if let Some(place) = values.get_mut(count) {
                *place = x;
            }
            count += 1;
            Some(())
        })?;
        if !whole {
            return Ok(None);
        }
        let given = values.get(..count).filter(|given| !given.is_empty());
        let point = given.and_then(Coordinates::of);
        if point.is_none() {
            let expected = self.expected();
            at.wrong(format!("expected {expected}, found {count} of them"));
        }
        Ok(point.map(Some))
    }

    fn object<'de, A: MapAccess<'de>>(
        self,
        members: Members<A>,
        at: &mut Reading,
    ) -> Result<Option<Option<Coordinates>>, A::Error> {
        at.wrong("expected a point as a list, [x, y] or [x, y, z], found an object");
        Anything.object(members, at)?;
        Ok(None)
    }
}

/// A coordinate of a point.
struct CoordinateReader(Under);

impl Reader for CoordinateReader {
    type Value = f64;

    fn expected(&self) -> String {
        f64::reader().expected()
    }

    fn null(self, at: &mut Reading) -> Option<f64> {
        f64::reader().null(at)
    }

    fn number(self, value: Numeral, _: &mut Reading) -> Option<f64> {
        Some(value.real())
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<f64>, A::Error> {
        at.wrong(match self.0 {
            Under::Curve => "expected a number, found a list: rows of points are fitted by a \"surface\", not by a \"curve\"",
            Under::Scattered => "expected a number, found a list: rows of points are \"points\", scattered points have none",
            Under::Surface | Under::Edit => "expected a number, found a list",
        });
        Anything.list(list, at)?;
        Ok(None)
    }
}

impl Reader for Of<Coordinates> {
    type Value = Coordinates;

    fn expected(&self) -> String {
        PointReader::of_edit().expected()
    }

    fn number(self, value: Numeral, at: &mut Reading) -> Option<Coordinates> {
        PointReader::of_edit().number(value, at).flatten()
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Coordinates>, A::Error> {
        Ok(PointReader::of_edit().list(list, at)?.flatten())
    }

    fn object<'de, A: MapAccess<'de>>(
        self,
        members: Members<A>,
        at: &mut Reading,
    ) -> Result<Option<Coordinates>, A::Error> {
        Ok(PointReader::of_edit().object(members, at)?.flatten())
    }
}
