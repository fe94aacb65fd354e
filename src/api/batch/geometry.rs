//! The B-spline of a fitted curve or surface, from its JSON.

use serde::Deserialize;

use crate::job::trim::{TrimLoop, Trimmed, TrimmedFace};
use piad_files::export::Nurbs;
use piad_files::export::nurbs::{DirectionData, assemble, products};
use piad_fit::data::Points;
use piad_fit::geometry::{Face, Outline};

/// A fitted curve or surface.
#[derive(Debug, Deserialize)]
pub(crate) struct Geometry {
    basis: Each<String>,
    degree: Each<usize>,
    closed: Each<bool>,
    knots: Each<Option<Vec<f64>>>,
    control_points: Net,
    weights: Option<Weights>,
    trim: Option<Trimmed>,
}

/// A value of both directions, or one of each.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Each<T> {
    Pair { u: T, v: T },
    Both(T),
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Net {
    Curve(Vec<Vec<f64>>),
    Surface(Vec<Vec<Vec<f64>>>),
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Weights {
    Curve(Vec<f64>),
    Surface(Vec<Vec<f64>>),
    Fixed {
        u: Option<Vec<f64>>,
        v: Option<Vec<f64>>,
    },
}

impl<T> Each<T> {
    fn u(&self) -> &T {
        match self {
            Self::Pair { u, .. } | Self::Both(u) => u,
        }
    }

    fn v(&self) -> &T {
        match self {
            Self::Pair { v, .. } | Self::Both(v) => v,
        }
    }
}

impl Geometry {
    /// The number of control points, in each direction.
    pub(crate) fn counts(&self) -> String {
        match &self.control_points {
            Net::Curve(points) => points.len().to_string(),
            Net::Surface(rows) => format!("{} × {}", rows.len(), columns(rows)),
        }
    }

    /// Returns true for a surface.
    pub(super) fn is_surface(&self) -> bool {
        matches!(self.control_points, Net::Surface(_))
    }

    /// The B-spline, if its basis has one.
    pub(super) fn nurbs(&self) -> Result<Nurbs, String> {
        let ball = [self.basis.u(), self.basis.v()]
            .into_iter()
            .find(|basis| basis.ends_with("_ball"));
        if let Some(basis) = ball {
            return Err(format!(
                "results with the basis {basis} are written one at a time: ask for the lines of a batch, or for one part"
            ));
        }
        let direction = |degree: &usize, closed: &bool, knots: &Option<Vec<f64>>| DirectionData {
            degree: *degree,
            closed: *closed,
            knots: knots.clone(),
        };
        let u = direction(self.degree.u(), self.closed.u(), self.knots.u());
        let (points, v) = match &self.control_points {
            Net::Curve(points) => (flat(points.iter()), None),
            Net::Surface(rows) => {
                let v = direction(self.degree.v(), self.closed.v(), self.knots.v());
                (flat(rows.iter().flatten()), Some(v))
            }
        };
        assemble(u, v, points, self.weights()).map_err(|reason| reason.to_string())
    }

    /// The outline of a trimmed surface.
    pub(super) fn outline(&self) -> Result<Option<Outline>, String> {
        let Some(trim) = &self.trim else {
            return Ok(None);
        };
        let curve = |it: &TrimLoop| {
            let direction = DirectionData {
                degree: it.degree,
                knots: Some(it.knots.clone()),
                closed: true,
            };
            let points = Points::from_flat(2, it.control_points.as_flattened());
            assemble(direction, None, points, None).map_err(|reason| reason.to_string())
        };
        let loops: Vec<Nurbs> = trim.loops.iter().map(curve).collect::<Result<_, _>>()?;
        let face = |it: &TrimmedFace| {
            let first = it.outer + 1;
            let holes = first..first + it.holes.len();
            let is_known = holes.end <= loops.len() && holes.clone().eq(it.holes.iter().copied());
            let outer = it.outer;
            let wrong = "the holes of a piece of a trimmed surface follow its outer loop";
            is_known
                .then_some(Face { outer, holes })
                .ok_or_else(|| wrong.to_owned())
        };
        let faces = trim.faces.iter().map(face).collect::<Result<_, _>>()?;
        Ok(Some(Outline {
            loops,
            faces,
            distance: trim.distance,
        }))
    }

    /// The weights of all control points, row by row.
    fn weights(&self) -> Option<Vec<f64>> {
        Some(match self.weights.as_ref()? {
            Weights::Curve(weights) => weights.clone(),
            Weights::Surface(rows) => rows.concat(),
            Weights::Fixed { u, v } => {
                let (rows, columns) = match &self.control_points {
                    Net::Curve(points) => (points.len(), 1),
                    Net::Surface(rows) => (rows.len(), columns(rows)),
                };
                products(u.as_deref().ok_or(rows), v.as_deref().ok_or(columns))
            }
        })
    }
}

fn columns(rows: &[Vec<Vec<f64>>]) -> usize {
    rows.first().map_or(0, Vec::len)
}

fn flat<'a>(points: impl Iterator<Item = &'a Vec<f64>> + Clone) -> Points {
    let mut flat = Points::new(points.clone().next().map_or(0, Vec::len));
    points.for_each(|point| flat.push(point));
    flat
}
