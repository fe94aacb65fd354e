//! The kind of the points of an input, known before the fit.

use serde_json::Value;

use super::input::{Content, Input};
use super::pointer;
use piad_files::export::Origin;
use piad_files::import::{self, Hints, Kind};

/// The number of coordinates in space.
const SPACE: usize = 3;

/// The kind of geometry, and the number of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PointKind {
    /// True if they are points of a surface.
    pub surface: bool,
    /// The number of coordinates.
    pub dimension: usize,
    /// The origin of the first two, if they were longitudes and latitudes.
    pub origin: Option<Origin>,
}

impl PointKind {
    /// The kind of points of an input with these hints; `None` if it cannot be read, which the
    /// server reports.
    pub(super) fn of(input: &Input, hints: &Hints) -> Option<Self> {
        match input.content {
            Content::Points => {
                // Of several parts the first one: each is written on its own or all are.
                let read = import::read_parts(&input.bytes, hints).ok()?;
                let read = read.into_iter().next()?;
                let surface = hints.kind == Some(Kind::Surface);
                Some(Self {
                    surface: surface
                        || read.grid.is_some()
                        || !read.sections.is_empty()
                        || !read.triangles.is_empty(),
                    dimension: read.points.dimension(),
                    origin: read.origin,
                })
            }
            Content::Job => Self::of_job(input.json(), ""),
            // Of several items also the first one.
            Content::Batch => {
                let first = Self::of_job(input.json(), "/items/0")?;
                let spacing = pointer::value(input.json(), "/defaults/surface/spacing");
                Some(first.placed(spacing.is_some()))
            }
        }
    }

    /// The same after heights are placed in space, if they are.
    pub(super) fn placed(self, is_placed: bool) -> Self {
        match self {
            Self { dimension: 1, .. } if is_placed && self.surface => Self {
                dimension: SPACE,
                ..self
            },
            _ => self,
        }
    }

    /// The kind of points of the job at this path of a JSON text.
    fn of_job(json: &[u8], place: &str) -> Option<Self> {
        let value = |pointer: &str| pointer::value(json, &format!("{place}{pointer}"));
        let lists = [
            ("/curve/points/0", false),
            ("/surface/points/0/0", true),
            ("/surface/scattered/0", true),
            ("/surface/sections/0/0", true),
        ];
        lists.into_iter().find_map(|(first, surface)| {
            let dimension = match value(first)? {
                Value::Array(coordinates) => coordinates.len(),
                Value::Number(_) => 1,
                _ => return None,
            };
            let points = Self {
                surface,
                dimension,
                origin: None,
            };
            Some(points.placed(value("/surface/spacing").is_some()))
        })
    }
}
