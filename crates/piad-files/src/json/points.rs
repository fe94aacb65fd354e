//! The readers of points.

use std::cell::{Cell, RefCell};
use std::fmt;

use piad_fit::data::{Grid, MAX_DIMENSION, MAX_SURFACE_DIMENSION, Points};
use serde::de::{
    DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Unexpected, Visitor,
};
use serde::{Deserialize, Serialize};

use super::limits::{LIMITED_LENGTH, ListLimits};

/// Rows (u) of columns (v) of points, or of heights, which are points of one coordinate; `null` stands
/// for a missing one.
#[derive(Clone, Debug)]
pub struct Rows {
    /// The points, row by row; the values of missing ones are undefined.
    pub points: Points,
    /// The indices of missing points, increasing.
    pub missing: Vec<usize>,
    /// Rows and columns.
    pub grid: Grid,
}

/// Reads a list of points, `[[x, y, z], …]`, each with at most [`MAX_DIMENSION`] coordinates, all alike.
///
/// # Errors
///
/// Anything else, and more points than the limits allow.
pub fn read_points<'de, D: Deserializer<'de>>(
    deserializer: D,
    limits: ListLimits,
) -> Result<Points, D::Error> {
    let gathered = RefCell::new(Gathered::new(limits));
    Row(&gathered, Under::List).deserialize(deserializer)?;
    gathered.into_inner().points()
}

/// Reads rows of points, `[[[x, y, z], …], …]`, or of heights, `[[z, …], …]`, all of the same length.
///
/// # Errors
///
/// Anything else, and more points than the limits allow.
pub fn read_rows<'de, D: Deserializer<'de>>(
    deserializer: D,
    limits: ListLimits,
) -> Result<Rows, D::Error> {
    struct RowsVisitor(ListLimits);

    impl<'de> Visitor<'de> for RowsVisitor {
        type Value = Rows;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("rows of points, [[[x, y, z], …], …], or of heights, [[z, …], …]")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Rows, A::Error> {
            let gathered = RefCell::new(Gathered::new(self.0));
            let (mut rows, mut columns) = (0, None);
            let row = Row(&gathered, Under::Surface);
            while let Some(length) = list.next_element_seed(GridRow(row, columns))? {
                rows += 1;
                columns = Some(length);
            }
            let mut gathered = gathered.into_inner();
            Ok(Rows {
                missing: std::mem::take(&mut gathered.missing),
                points: gathered.points()?,
                grid: Grid {
                    rows,
                    columns: columns.unwrap_or(0),
                },
            })
        }
    }

    deserializer.deserialize_any(RowsVisitor(limits))
}

/// Reads sections, `[[[x, y, z], …], …]`, lists of points that need not be of the same length: all points, and the
/// number of points of each section.
///
/// # Errors
///
/// Anything else, a section without points, and more points than the limits allow.
pub fn read_sections<'de, D: Deserializer<'de>>(
    deserializer: D,
    limits: ListLimits,
) -> Result<(Points, Vec<usize>), D::Error> {
    struct SectionsVisitor(ListLimits);

    impl<'de> Visitor<'de> for SectionsVisitor {
        type Value = (Points, Vec<usize>);

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("sections, [[[x, y, z], …], …]")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
            let gathered = RefCell::new(Gathered::new(self.0));
            let mut counts = Vec::new();
            while let Some(count) = list.next_element_seed(Row(&gathered, Under::Edit))? {
                if count == 0 {
                    let index = counts.len();
                    return Err(A::Error::custom(format_args!(
                        "section {index} has no points"
                    )));
                }
                counts.push(count);
            }
            Ok((gathered.into_inner().points()?, counts))
        }
    }

    deserializer.deserialize_any(SectionsVisitor(limits))
}

/// The coordinates of a point.
#[derive(Clone, Debug, Serialize)]
#[serde(transparent)]
pub struct Coordinates(Vec<f64>);

impl From<&[f64]> for Coordinates {
    fn from(coordinates: &[f64]) -> Self {
        Self(coordinates.to_vec())
    }
}

impl Coordinates {
    /// One after the other.
    pub fn as_slice(&self) -> &[f64] {
        &self.0
    }
}

/// Points beyond the limit are counted up to this multiple of it.
const COUNTED: usize = 2;

/// The error for too many points, if there are.
pub fn check_count(count: usize, most: usize) -> Result<(), String> {
    let counted = most.saturating_mul(COUNTED);
    let points = match count {
        _ if count <= most => return Ok(()),
        _ if count <= counted => format!("{count} points"),
        _ => format!("more than {counted} points"),
    };
    Err(format!("{points} are more than {most}, the limit"))
}

/// The kind of geometry that points belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Under {
    List,
    Surface,
    Edit,
}

impl Under {
    /// The most coordinates of a point.
    fn most_coordinates(self) -> usize {
        match self {
            Self::List | Self::Edit => MAX_DIMENSION,
            Self::Surface => MAX_SURFACE_DIMENSION,
        }
    }
}

/// The kind of a point.
impl fmt::Display for Under {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let most = self.most_coordinates();
        write!(f, "a point: a list of 1 to {most} numbers")
    }
}

/// Points that were read so far. Those beyond the limit are only counted.
struct Gathered {
    limits: ListLimits,
    /// `None` before the first point, which determines the number of coordinates.
    points: Option<Points>,
    /// The coordinates of the point that is read.
    coordinates: Vec<f64>,
    count: usize,
    missing: Vec<usize>,
}

impl Gathered {
    fn new(limits: ListLimits) -> Self {
        Self {
            limits,
            points: None,
            coordinates: Vec::new(),
            count: 0,
            missing: Vec::new(),
        }
    }

    /// All parts, unless there are too many.
    fn points<E: Error>(self) -> Result<Points, E> {
        check_count(self.count, self.limits.points).map_err(E::custom)?;
        let mut points = self.points.unwrap_or_else(|| Points::zeros(1, self.count));
        points.shrink_to_fit();
        Ok(points)
    }

    /// Returns true if the limit is reached.
    fn is_full(&self) -> bool {
        self.count >= self.limits.points
    }

    /// Refuses to count further.
    fn check_counted<E: Error>(&self) -> Result<(), E> {
        match self.count > self.limits.points.saturating_mul(COUNTED) {
            true => check_count(self.count, self.limits.points).map_err(E::custom),
            false => Ok(()),
        }
    }

    /// Appends the point that was read, or that it is missing.
    fn push<E: Error>(&mut self, given: bool) -> Result<(), E> {
        let before = self.count;
        self.count += 1;
        if !given {
            if let Some(points) = &mut self.points {
                points.push(&[0.0; MAX_DIMENSION]);
            }
            self.limits.make_room(&mut self.missing, self.limits.points);
            self.missing.push(before);
            return Ok(());
        }
        let count = self.coordinates.len();
        let points = self
            .points
            .get_or_insert_with(|| Points::zeros(count, before));
        let dimension = points.dimension();
        if points.len() == LIMITED_LENGTH {
            let most = self.limits.points_of(dimension);
            points.make_room(most.saturating_sub(LIMITED_LENGTH));
        }
        if dimension != count {
            return Err(E::custom(format_args!(
                "this point has {count} coordinates, the first has {dimension}: all points must have the same number"
            )));
        }
        points.push(&self.coordinates);
        Ok(())
    }
}

/// Appends a list of points; returns their number.
#[derive(Clone, Copy)]
struct Row<'a>(&'a RefCell<Gathered>, Under);

impl<'de> DeserializeSeed<'de> for Row<'_> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Row<'_> {
    type Value = usize;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.1 {
            Under::List => "a list of points, [[x, y], …]",
            Under::Surface | Under::Edit => "a row of points, [[x, y, z], …]",
        })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<usize, A::Error> {
        let heights = Cell::new(false);
        let mut length = 0;
        while list
            .next_element_seed(PointSeed {
                gathered: self.0,
                under: self.1,
                heights: &heights,
            })?
            .is_some()
        {
            length += 1;
            self.0.borrow().check_counted()?;
        }
        if heights.get() && length <= MAX_SURFACE_DIMENSION {
            return Err(A::Error::custom(format_args!(
                "expected a row of points, found {length} numbers: a list of points is a curve, and \
                 rows of this few heights are written as points, [[z], …]"
            )));
        }
        Ok(length)
    }
}

/// Appends a row of a grid, which has as many points as the one before.
struct GridRow<'a>(Row<'a>, Option<usize>);

impl<'de> DeserializeSeed<'de> for GridRow<'_> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        let length = self.0.deserialize(deserializer)?;
        match self.1.filter(|columns| *columns != length) {
            None => Ok(length),
            Some(columns) => Err(D::Error::custom(format_args!(
                "this row has {length} points, the first row has {columns}: all rows must have the same number"
            ))),
        }
    }
}

/// Appends a point, or that it is missing.
struct PointSeed<'a> {
    gathered: &'a RefCell<Gathered>,
    under: Under,
    /// True if there was a number instead of a point.
    heights: &'a Cell<bool>,
}

impl<'de> DeserializeSeed<'de> for PointSeed<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        if self.gathered.borrow().is_full() {
            IgnoredAny::deserialize(deserializer)?;
            self.gathered.borrow_mut().count += 1;
            return Ok(());
        }
        let mut coordinates = std::mem::take(&mut self.gathered.borrow_mut().coordinates);
        coordinates.clear();
        let given = deserializer.deserialize_any(PointVisitor {
            under: self.under,
            heights: self.heights,
            coordinates: &mut coordinates,
        })?;
        let mut gathered = self.gathered.borrow_mut();
        gathered.coordinates = coordinates;
        gathered.push(given)
    }
}

/// Appends the coordinates of a point; returns true if there is one, false if it is missing.
struct PointVisitor<'a> {
    under: Under,
    heights: &'a Cell<bool>,
    coordinates: &'a mut Vec<f64>,
}

impl PointVisitor<'_> {
    fn height<E: Error>(self, x: f64, found: Unexpected<'_>) -> Result<bool, E> {
        if self.under != Under::Surface {
            return Err(E::invalid_type(found, &self));
        }
        self.heights.set(true);
        self.coordinates.push(x);
        Ok(true)
    }
}

impl<'de> Visitor<'de> for PointVisitor<'_> {
    type Value = bool;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.under, f)
    }

    fn visit_unit<E: Error>(self) -> Result<bool, E> {
        match self.under {
            Under::Surface => Ok(false),
            _ => Err(E::invalid_type(Unexpected::Unit, &self)),
        }
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<bool, E> {
        self.height(x, Unexpected::Float(x))
    }

    fn visit_u64<E: Error>(self, x: u64) -> Result<bool, E> {
        self.height(x as f64, Unexpected::Unsigned(x))
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<bool, E> {
        self.height(x as f64, Unexpected::Signed(x))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<bool, A::Error> {
        let most = self.under.most_coordinates();
        let mut count = 0;
        while let Some(x) = list.next_element_seed(Coordinate(self.under))? {
            if count < most {
                self.coordinates.push(x);
            }
            count += 1;
        }
        match (1..=most).contains(&count) {
            true => Ok(true),
            false => Err(A::Error::custom(format_args!(
                "expected {}, found {count} of them",
                self.under
            ))),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, _: A) -> Result<bool, A::Error> {
        let detail = "expected a point as a list, [x, y] or [x, y, z], found an object";
        Err(A::Error::custom(detail))
    }
}

/// A coordinate of a point.
#[derive(Clone, Copy)]
struct Coordinate(Under);

impl<'de> DeserializeSeed<'de> for Coordinate {
    type Value = f64;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<f64, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Coordinate {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number")
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<f64, E> {
        Ok(x)
    }

    fn visit_u64<E: Error>(self, x: u64) -> Result<f64, E> {
        Ok(x as f64)
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<f64, E> {
        Ok(x as f64)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, _: A) -> Result<f64, A::Error> {
        Err(A::Error::custom(match self.0 {
            Under::List => {
                "expected a number, found a list: rows of points are the \"points\" of a \"surface\""
            }
            Under::Surface | Under::Edit => "expected a number, found a list",
        }))
    }
}

impl<'de> Deserialize<'de> for Coordinates {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut coordinates = Vec::new();
        deserializer.deserialize_any(PointVisitor {
            under: Under::Edit,
            heights: &Cell::new(false),
            coordinates: &mut coordinates,
        })?;
        Ok(Self(coordinates))
    }
}
