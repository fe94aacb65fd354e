//! An entity of DXF with its groups, and its own coordinate system.

use super::pairs::Pair;
use crate::import::curves::Point;
use crate::import::error::FileError;
use crate::text::quoted;

/// An entity, from its name up to the next one.
#[derive(Debug)]
pub(super) struct Entity<'a> {
    pub(super) name: &'a str,
    /// The line of its name.
    pub(super) line: u32,
    pub(super) groups: Vec<Pair<'a>>,
}

impl<'a> Entity<'a> {
    pub(super) fn new(pair: Pair<'a>) -> Self {
        Self {
            name: pair.value,
            line: pair.line,
            groups: Vec::new(),
        }
    }

    /// The value of the first group of a code.
    fn first(&self, code: i32) -> Option<&Pair<'a>> {
        self.groups.iter().find(|pair| pair.code == code)
    }

    /// The layer, which names parts.
    pub(super) fn layer(&self) -> &'a str {
        self.first(8).map_or("0", |pair| pair.value)
    }

    /// A text; empty if it is not there.
    pub(super) fn text(&self, code: i32) -> &'a str {
        self.first(code).map_or("", |pair| pair.value)
    }

    /// A number; 0 if it is not there.
    ///
    /// # Errors
    ///
    /// If it is no number.
    pub(super) fn number(&self, code: i32) -> Result<f64, FileError> {
        Ok(self.optional(code)?.unwrap_or(0.0))
    }

    /// A number, if it is there.
    ///
    /// # Errors
    ///
    /// If it is no number.
    pub(super) fn optional(&self, code: i32) -> Result<Option<f64>, FileError> {
        self.first(code).map(number).transpose()
    }

    /// Flags, or a small number; 0 if it is not there.
    ///
    /// # Errors
    ///
    /// If it is no number.
    pub(super) fn flags(&self, code: i32) -> Result<u32, FileError> {
        let number = self.number(code)?;
        Ok(if number >= 0.0 { number as u32 } else { 0 })
    }

    /// A point, by the code of its x.
    ///
    /// # Errors
    ///
    /// If x or y is missing, or one is no number.
    pub(super) fn point(&self, code: i32) -> Result<Point, FileError> {
        let missing = |what: &str| {
            let detail = format!("this {} has no {what} (group {code})", self.name);
            FileError::at(self.line as usize, detail)
        };
        let x = self.optional(code)?.ok_or_else(|| missing("x"))?;
        let y = self.optional(code + 10)?;
        let y = y.ok_or_else(|| missing("y"))?;
        Ok([x, y, self.number(code + 20)?])
    }

    /// All points by the code of their x, each with its line.
    ///
    /// # Errors
    ///
    /// If a coordinate is no number.
    pub(super) fn points(&self, code: i32) -> Result<Vec<(Point, u32)>, FileError> {
        let mut points: Vec<(Point, u32)> = Vec::new();
        for pair in &self.groups {
            if pair.code == code {
                points.push(([number(pair)?, 0.0, 0.0], pair.line));
            } else if let Some((point, _)) = points.last_mut() {
                match pair.code - code {
                    10 => point[1] = number(pair)?,
                    20 => point[2] = number(pair)?,
                    _ => {}
                }
            }
        }
        Ok(points)
    }

    /// All numbers of a code.
    ///
    /// # Errors
    ///
    /// If one is no number.
    pub(super) fn numbers(&self, code: i32) -> Result<Vec<f64>, FileError> {
        let groups = self.groups.iter().filter(|pair| pair.code == code);
        groups.map(number).collect()
    }

    /// The coordinate system of its plane.
    ///
    /// # Errors
    ///
    /// If the direction is no direction.
    pub(super) fn system(&self) -> Result<System, FileError> {
        let Some(x) = self.optional(210)? else {
            return Ok(System::WORLD);
        };
        let normal = [x, self.number(220)?, self.number(230)?];
        System::of(normal).ok_or_else(|| {
            let detail = format!("the extrusion direction of this {} is zero", self.name);
            FileError::at(self.line as usize, detail)
        })
    }
}

/// The finite number of a group.
pub(super) fn number(pair: &Pair<'_>) -> Result<f64, FileError> {
    let number = pair.value.parse().ok();
    number.filter(|it: &f64| it.is_finite()).ok_or_else(|| {
        let detail = format!(
            "{} is not a number (group {})",
            quoted(pair.value),
            pair.code
        );
        FileError::at(pair.line as usize, detail)
    })
}

/// The coordinate system of entities in a plane: its axes in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct System([Point; 3]);

impl System {
    pub(super) const WORLD: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// The axes by the direction of the third one, as DXF has them ("arbitrary axis algorithm").
    fn of(normal: Point) -> Option<Self> {
        let z = unit(normal)?;
        // The axis of the world that is not near to it.
        let near = |x: f64| x.abs() < 1.0 / 64.0;
        let world = match near(z[0]) && near(z[1]) {
            true => [0.0, 1.0, 0.0],
            false => [0.0, 0.0, 1.0],
        };
        let x = unit(cross(world, z))?;
        Some(Self([x, cross(z, x), z]))
    }

    /// A point or a direction of the system in the world.
    pub(super) fn in_world(&self, point: Point) -> Point {
        let axes = self.0.iter().zip(point);
        axes.fold([0.0; 3], |sum, (axis, x)| {
            crate::import::sampled::along(sum, *axis, x)
        })
    }

    /// The direction of the third axis.
    pub(super) fn normal(&self) -> Point {
        self.0[2]
    }
}

fn unit(vector: Point) -> Option<Point> {
    let [x, y, z] = vector;
    let length = x.hypot(y).hypot(z);
    (length > 0.0 && length.is_finite()).then(|| vector.map(|x| x / length))
}

/// The vector that is perpendicular to two others.
pub(super) fn cross(a: Point, b: Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
