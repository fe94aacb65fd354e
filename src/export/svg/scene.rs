//! What is drawn: a curve in pieces, or the parts of a surface.

use super::view::Projected;

/// A cubic Bézier piece.
pub(super) type Cubic = [Projected; 4];

/// What is drawn.
pub(super) enum Scene {
    /// A curve in cubic pieces.
    Curve(Vec<Cubic>),
    /// Parts of a surface, the far ones first.
    Surface(Vec<SurfacePart>),
}

/// A part of the drawing of a surface.
pub(super) enum SurfacePart {
    /// A cell of a grid on the surface, and the light on it.
    Face([Projected; 4], f64),
    /// An edge of the control net.
    Edge([Projected; 2]),
    /// A data point.
    Dot(Projected),
}

impl Scene {
    /// All places of the curve or of the faces.
    pub(super) fn places(&self) -> impl Iterator<Item = Projected> + '_ {
        let pieces: &[Cubic] = match self {
            Self::Curve(pieces) => pieces,
            Self::Surface(_) => &[],
        };
        self.outline().chain(pieces.iter().flatten().copied())
    }

    /// The places that must be on the page: ends of pieces, corners of faces.
    pub(super) fn outline(&self) -> impl Iterator<Item = Projected> + '_ {
        let (pieces, parts): (&[Cubic], &[SurfacePart]) = match self {
            Self::Curve(pieces) => (pieces, &[]),
            Self::Surface(parts) => (&[], parts),
        };
        let faces = parts.iter().filter_map(|part| match part {
            SurfacePart::Face(corners, _) => Some(corners),
            _ => None,
        });
        let ends = pieces.iter().flat_map(|piece| [piece[0], piece[3]]);
        ends.chain(faces.flatten().copied())
    }
}
