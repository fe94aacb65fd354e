//! Notices about parameters that the fit has chosen.

use piad_fit::engine::Problem;
use piad_fit::parameters::{CoordinatePlane, Cylinder, FoldedTriangles, Scattered, Sphere};

/// Notices about parameters that a fit has chosen, and about triangles of a mesh that these turn
/// over.
pub(crate) fn notices(problem: &Problem) -> Vec<String> {
    let Some(chosen) = problem.chosen_parameters() else {
        return Vec::new();
    };
    let folded = problem.folded_triangles().map(|folded| {
        let FoldedTriangles {
            count,
            triangle,
            share,
        } = folded;
        let percent = 100.0 * share;
        format!(
            "{count} triangles of the mesh, with {percent:.2} % of its area, are turned over or have no area by the parameters of their points; the first of them is triangle {triangle}"
        )
    });
    notice(chosen).into_iter().chain(folded).collect()
}

fn notice(chosen: &Scattered) -> Option<String> {
    let place = |place: Option<[f64; 3]>| {
        let [x, y, z] = place.unwrap_or_default();
        format!("({x:.6}, {y:.6}, {z:.6})")
    };
    let surface = match chosen {
        Scattered::Given(_) | Scattered::Auto => return None,
        Scattered::Sections(sections) => {
            let (count, kind) = match sections.closed {
                Some(true) => (sections.counts.len(), "closed"),
                _ => (sections.counts.len(), "open"),
            };
            return Some(format!("the points are {count} {kind} sections"));
        }
        Scattered::Mesh(_) => {
            let notice =
                "the parameters of the points are their mean value coordinates on the mesh";
            return Some(notice.to_owned());
        }
        Scattered::Plane => "the plane nearest to them".to_owned(),
        Scattered::Coordinates(plane) => {
            let axes = match plane {
                CoordinatePlane::Xy => "x and y",
                CoordinatePlane::Xz => "x and z",
                CoordinatePlane::Yz => "y and z",
            };
            format!("the plane of {axes}")
        }
        Scattered::Cylinder(Cylinder { axis, center }) => {
            format!(
                "a cylinder along {} through {}",
                place(*axis),
                place(*center)
            )
        }
        Scattered::Sphere(Sphere { axis, center }) => {
            format!(
                "a sphere around {} with a pole in direction {}",
                place(*center),
                place(*axis)
            )
        }
    };
    Some(format!(
        "the parameters of the points are their places on {surface}"
    ))
}
