//! The contents of a drawing: a curve in pieces, or the parts of a surface.

use super::layout::DrawnData;
use super::scale::Heat;
use super::view::Projected;
use crate::export::nurbs::Nurbs;

/// A cubic Bézier piece.
pub(super) type Cubic = [Projected; 4];

/// The contents of a drawing.
pub(super) enum Scene {
    /// A curve in cubic pieces, and the distance of the data from each, if there are any.
    Curve(Vec<Cubic>, Vec<Heat>),
    /// Parts of a surface, sorted from far to near once they are complete.
    Surface(Vec<SurfacePart>),
}

/// A part of the drawing of a surface.
pub(super) enum SurfacePart {
    /// A cell of a grid on the surface, the light on it, and the distance of the data, if there are any.
    Face([Projected; 4], f64, Option<Heat>),
    /// An edge of the control net.
    Edge([Projected; 2]),
    /// A piece of the outline of a trimmed surface.
    Rim([Projected; 2]),
    /// A data point.
    Dot(Projected),
}

impl Scene {
    /// Adds the dots of a surface, and sorts its parts by distance (the painter's algorithm). Edges and
    /// dots are taken a little nearer than they are, so that those on the surface are visible.
    pub(super) fn finish(&mut self, nurbs: &Nurbs, data: &DrawnData) {
        let Self::Surface(parts) = self else {
            return;
        };
        if data.dots {
            parts.extend(data.places.iter().copied().map(SurfacePart::Dot));
        }
        let lift = nurbs.points.bounding_diagonal() / 100.0;
        parts.sort_by(|a, b| a.depth(lift).total_cmp(&b.depth(lift)));
    }

    /// All places of the curve or of the faces.
    pub(super) fn places(&self) -> impl Iterator<Item = Projected> + '_ {
        let pieces: &[Cubic] = match self {
            Self::Curve(pieces, _) => pieces,
            Self::Surface(_) => &[],
        };
        self.outline().chain(pieces.iter().flatten().copied())
    }

    /// The places that must be on the page: ends of pieces, corners of faces.
    pub(super) fn outline(&self) -> impl Iterator<Item = Projected> + '_ {
        let (pieces, parts): (&[Cubic], &[SurfacePart]) = match self {
            Self::Curve(pieces, _) => (pieces, &[]),
            Self::Surface(parts) => (&[], parts),
        };
        let faces = parts.iter().filter_map(|part| match part {
            SurfacePart::Face(corners, ..) => Some(corners),
            _ => None,
        });
        let ends = pieces.iter().flat_map(|piece| [piece[0], piece[3]]);
        ends.chain(faces.flatten().copied())
    }
}
