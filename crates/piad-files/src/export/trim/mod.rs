//! Surfaces that are trimmed to an outline: their edges for CAD systems, and their triangles.

pub(super) mod edges;
pub(super) mod triangles;
