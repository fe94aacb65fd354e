//! Trimmed surfaces: faces with edges, in open shells (ISO 10303-42, `advanced_face`).
//!
//! An edge has a curve of space that is within the accuracy of the file of the surface, and a curve in (u, v) (`pcurve`) with
//! the same parameter, which is its exact place.

use super::instances::{CONTEXT, ORIGIN, SHAPE, knots, real};
use crate::export::nurbs::Nurbs;
use crate::export::text::Text;
use crate::export::trim::edges::Edge;
use piad_fit::engine::vectors::in_space;
use piad_fit::geometry::Face;

/// A trimmed surface.
pub(super) struct Trimmed<'a> {
    /// The number of the surface.
    pub surface: usize,
    /// The edges of each loop.
    pub edges: Vec<Vec<Edge>>,
    pub faces: &'a [Face],
}

/// Writes an instance with the next number, which it returns.
fn put(text: &mut Text, next: &mut usize, write: impl FnOnce(&mut Text)) -> usize {
    let number = *next;
    *next += 1;
    text.put(format_args!("#{number}="));
    write(text);
    text.push(";\n");
    number
}

fn references(text: &mut Text, numbers: &[usize]) {
    text.list(numbers, |text, number| text.put(format_args!("#{number}")));
}

impl Trimmed<'_> {
    /// Writes it as shells of one face each, and returns the number of the model that has them.
    pub(super) fn write(&self, text: &mut Text, next: &mut usize) -> usize {
        let plane = put(text, next, |text| {
            text.push(
                "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()\
                 REPRESENTATION_CONTEXT('2D SPACE',''))",
            );
        });
        let loops = self
            .edges
            .iter()
            .map(|edges| self.edge_loop(edges, plane, text, next));
        let loops: Vec<usize> = loops.collect();
        let surface = self.surface;
        let mut shells = Vec::with_capacity(self.faces.len());
        for face in self.faces {
            let bounds = face.loops().map(|index| {
                let kind = if index == face.outer {
                    "FACE_OUTER_BOUND"
                } else {
                    "FACE_BOUND"
                };
                put(text, next, |text| {
                    text.put(format_args!("{kind}('',#{},.T.)", loops[index]));
                })
            });
            let bounds: Vec<usize> = bounds.collect();
            let face = put(text, next, |text| {
                text.push("ADVANCED_FACE('',");
                references(text, &bounds);
                text.put(format_args!(",#{surface},.T.)"));
            });
            shells.push(put(text, next, |text| {
                text.put(format_args!("OPEN_SHELL('',(#{face}))"));
            }));
        }
        put(text, next, |text| {
            text.push("SHELL_BASED_SURFACE_MODEL('',");
            references(text, &shells);
            text.push(")");
        })
    }

    fn edge_loop(&self, edges: &[Edge], plane: usize, text: &mut Text, next: &mut usize) -> usize {
        let vertices: Vec<usize> = edges
            .iter()
            .map(|edge| {
                let point = point(text, next, in_space(edge.in_space.points.point(0)), 3);
                put(text, next, |text| {
                    text.put(format_args!("VERTEX_POINT('',#{point})"))
                })
            })
            .collect();
        let mut oriented = Vec::with_capacity(edges.len());
        for (k, edge) in edges.iter().enumerate() {
            let (from, to) = (vertices[k], vertices[(k + 1) % vertices.len()]);
            let curve = self.curve(edge, plane, text, next);
            let edge = put(text, next, |text| {
                text.put(format_args!("EDGE_CURVE('',#{from},#{to},#{curve},.T.)"));
            });
            oriented.push(put(text, next, |text| {
                text.put(format_args!("ORIENTED_EDGE('',*,*,#{edge},.T.)"));
            }));
        }
        put(text, next, |text| {
            text.push("EDGE_LOOP('',");
            references(text, &oriented);
            text.push(")");
        })
    }

    /// The curve of space with that in the parameters of the surface.
    fn curve(&self, edge: &Edge, plane: usize, text: &mut Text, next: &mut usize) -> usize {
        let surface = self.surface;
        let in_space = spline(&edge.in_space, 3, text, next);
        let in_plane = spline(&edge.in_plane, 2, text, next);
        let definition = put(text, next, |text| {
            text.put(format_args!(
                "DEFINITIONAL_REPRESENTATION('',(#{in_plane}),#{plane})"
            ));
        });
        let pcurve = put(text, next, |text| {
            text.put(format_args!("PCURVE('',#{surface},#{definition})"));
        });
        put(text, next, |text| {
            text.put(format_args!(
                "SURFACE_CURVE('',#{in_space},(#{pcurve}),.PCURVE_S1.)"
            ));
        })
    }
}

fn point(text: &mut Text, next: &mut usize, place: [f64; 3], dimension: usize) -> usize {
    put(text, next, |text| {
        text.push("CARTESIAN_POINT('',");
        text.list(place.into_iter().take(dimension), real);
        text.push(")");
    })
}

/// A curve with points of this number of coordinates.
fn spline(curve: &Nurbs, dimension: usize, text: &mut Text, next: &mut usize) -> usize {
    let places = (0..curve.points.len()).map(|k| curve.place(k));
    let points: Vec<usize> = places.map(|it| point(text, next, it, dimension)).collect();
    put(text, next, |text| {
        text.put(format_args!(
            "B_SPLINE_CURVE_WITH_KNOTS('',{},",
            curve.u.degree
        ));
        references(text, &points);
        text.push(",.UNSPECIFIED.,.U.,.U.,");
        knots(text, &[&curve.u]);
        text.push(")");
    })
}

/// The representation of faces, and its tie to the product.
pub(super) fn representation(text: &mut Text, models: &[usize], mut next: usize) {
    let shape = put(text, &mut next, |text| {
        text.push("MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',");
        let items: Vec<usize> = std::iter::once(ORIGIN)
            .chain(models.iter().copied())
            .collect();
        references(text, &items);
        text.put(format_args!(",#{CONTEXT})"));
    });
    put(text, &mut next, |text| {
        text.put(format_args!(
            "SHAPE_DEFINITION_REPRESENTATION(#{SHAPE},#{shape})"
        ));
    });
}
