//! The shape of a surface.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;

use super::extremes::{Curvatures, ExtremesView, finite};
use crate::api::json::view::arrays::{NumberArray, PointArray};
use crate::api::json::view::document::Document;
use piad_fit::engine::curvature::{KnotLine, SurfaceShape};

/// The shape of a surface.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "SurfaceShape", extend("examples" = [surface_example()]))]
pub(crate) struct SurfaceShapeView {
    /// That of a surface.
    kind: SurfaceKind,
    /// The number of the iteration.
    iteration: usize,
    /// The area of the surface.
    area: Option<f64>,
    /// The places where the principal, Gaussian and mean curvatures are least and largest.
    curvature: SurfaceExtremes,
    /// Parameters at which there is no normal, and near which curvatures may be unbounded: up to 100 of those examined.
    degenerate: Vec<[f64; 2]>,
    /// The continuity across the lines at inner knots, and where a closed direction returns to its start.
    continuity: Lines,
    /// Points with their curvatures.
    samples: SurfaceSamplesView,
}

/// The extremes of the curvatures of a surface.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [surface_example()["curvature"].clone()]))]
struct SurfaceExtremes {
    /// Of the larger principal curvature.
    k1: ExtremesView,
    /// Of the smaller principal curvature.
    k2: ExtremesView,
    /// Of the Gaussian curvature, k1 k2.
    gaussian: ExtremesView,
    /// Of the mean curvature, (k1 + k2) / 2.
    mean: ExtremesView,
}

/// The kind of what has this shape.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
enum SurfaceKind {
    Surface,
}

/// The continuity of a surface across its knot lines in each direction.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "SurfaceContinuity", extend("examples" = [surface_example()["continuity"].clone()]))]
struct Lines {
    /// The lines at knots of u.
    u: LinesView,
    /// The lines at knots of v.
    v: LinesView,
}

/// The lines at knots of one direction.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "KnotLines", extend("examples" = [surface_example()["continuity"]["u"].clone()]))]
struct LinesView {
    /// The number of these lines.
    count: usize,
    /// The lines in their order; of more than 10,000 those that guarantee least.
    knots: Vec<LineView>,
}

/// The continuity of a surface across the line at a knot.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "KnotLine", extend("examples" = [surface_example()["continuity"]["u"]["knots"][0].clone()]))]
struct LineView {
    /// The knot.
    parameter: f64,
    /// The multiplicity of the knot.
    multiplicity: usize,
    /// The order that the multiplicity m guarantees: C^(p − m) with the degree p; −1 allows a gap.
    guaranteed: i64,
    /// If the multiplicity guarantees no tangent plane: the largest angle between the normals of both sides at samples
    /// of the line, in degrees.
    angle: Option<f64>,
}

/// Points of a surface with their curvatures, in rows.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "SurfaceCurvatureSamples", extend("examples" = [surface_example()["samples"].clone()]))]
struct SurfaceSamplesView {
    /// The parameters of the rows and of the columns.
    parameters: GridParameters,
    /// The points.
    points: PointArray,
    /// The larger principal curvature. Curvatures are positive where the surface bends towards its normal, the product of
    /// the derivatives by u and by v.
    k1: Curvatures,
    /// The smaller principal curvature.
    k2: Curvatures,
    /// The Gaussian curvature, k1 k2.
    gaussian: Curvatures,
    /// The mean curvature, (k1 + k2) / 2.
    mean: Curvatures,
}

/// The parameters of rows (u) and of columns (v).
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"u": [0.0, 1.0], "v": [0.0, 1.0]}]))]
struct GridParameters {
    /// Of the rows.
    u: NumberArray,
    /// Of the columns.
    v: NumberArray,
}

impl SurfaceShapeView {
    pub(super) fn new(document: &mut Document, iteration: usize, shape: SurfaceShape) -> Self {
        let [k1, k2, gaussian, mean] = shape.extremes.map(ExtremesView::new);
        let [lines_u, lines_v] = shape.lines;
        let [count_u, count_v] = shape.line_counts;
        let samples = shape.samples;
        let [u, v] = samples.parameters;
        let counts = [u.len(), v.len()];
        let dimension = samples.points.len() / (u.len() * v.len()).max(1);
        let [larger, smaller] = samples.principal;
        let each = |make: fn(f64, f64) -> f64| -> Vec<f64> {
            let pairs = larger.iter().zip(&smaller);
            pairs.map(|(k1, k2)| make(*k1, *k2)).collect()
        };
        let (products, means) = (each(|k1, k2| k1 * k2), each(|k1, k2| 0.5 * (k1 + k2)));
        let mut curvatures = |values| Curvatures(document.weights(&counts, values));
        let samples = SurfaceSamplesView {
            k1: curvatures(larger),
            k2: curvatures(smaller),
            gaussian: curvatures(products),
            mean: curvatures(means),
            parameters: GridParameters {
                u: document.numbers(u.len(), u),
                v: document.numbers(v.len(), v),
            },
            points: document.points(&[counts[0], counts[1], dimension], samples.points),
        };
        Self {
            kind: SurfaceKind::Surface,
            iteration,
            area: finite(shape.area),
            curvature: SurfaceExtremes {
                k1,
                k2,
                gaussian,
                mean,
            },
            degenerate: shape.degenerate,
            continuity: Lines {
                u: LinesView::new(lines_u, count_u),
                v: LinesView::new(lines_v, count_v),
            },
            samples,
        }
    }
}

impl LinesView {
    fn new(lines: Vec<KnotLine>, count: usize) -> Self {
        let knots = lines.into_iter().map(|line| LineView {
            parameter: line.parameter,
            multiplicity: line.multiplicity,
            guaranteed: line.guaranteed,
            angle: line.angle.map(f64::to_degrees),
        });
        Self {
            count,
            knots: knots.collect(),
        }
    }
}

/// The shape of a roof of two planes.
fn surface_example() -> serde_json::Value {
    let extremes = json!({
        "smallest": {"parameter": [0.0, 0.0], "point": [0.0, 0.0, 0.0], "value": 0.0},
        "largest": {"parameter": [0.0, 0.0], "point": [0.0, 0.0, 0.0], "value": 0.0},
    });
    let zeros = json!([[0.0, 0.0], [0.0, 0.0]]);
    json!({
        "kind": "surface", "iteration": 0, "area": 14.1421,
        "curvature": {"k1": extremes, "k2": extremes, "gaussian": extremes, "mean": extremes},
        "degenerate": [],
        "continuity": {
            "u": {"count": 1, "knots": [{"parameter": 1.0, "multiplicity": 1, "guaranteed": 0, "angle": 90.0}]},
            "v": {"count": 0, "knots": []},
        },
        "samples": {
            "parameters": {"u": [0.0, 2.0], "v": [0.0, 1.0]},
            "points": [[[0.0, 0.0, 0.0], [0.0, 5.0, 0.0]], [[2.0, 0.0, 0.0], [2.0, 5.0, 0.0]]],
            "k1": zeros, "k2": zeros, "gaussian": zeros, "mean": zeros,
        },
    })
}
