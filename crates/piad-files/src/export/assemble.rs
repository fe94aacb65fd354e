//! B-splines from plain data, such as the JSON of a result, with validation.

use thiserror::Error;

use super::nurbs::{KnotVector, Nurbs};
use piad_fit::data::Points;

/// The largest difference between coinciding control points, as a fraction of the size of the net.
const SAME: f64 = 1e-9;

/// The highest degree: that of fits.
const MOST_DEGREE: usize = 1000;

/// One direction of plain data: of a curve the only one.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionData {
    /// The degree, at least 1.
    pub degree: usize,
    /// The complete knots, one more than control points and degree together; `None` of a Bézier curve (the basis
    /// `bernstein`): 0 and 1, each one more than the degree times.
    pub knots: Option<Vec<f64>>,
    /// True if the direction returns to its start. Then either its knots are those of a period, continued by the degree
    /// on both sides, and its last `degree` control points repeat the first ones; or its knots are clamped and its last
    /// control point is the first one.
    pub closed: bool,
}

/// Why plain data are not a B-spline.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{field}: {detail}")]
pub struct InvalidNurbs {
    /// The field: `degree`, `knots`, `control_points`, `weights` or `closed`, of surfaces with `.u` or `.v`.
    pub field: String,
    /// The reason.
    pub detail: String,
}

/// The B-spline curve or, with a second direction, surface of plain data: those that the JSON of a result has.
///
/// The control points are complete, of a surface row by row: the first direction runs from row to row. Weights are
/// those of control points; for a surface whose weights are those of each direction, see [`products`].
///
/// # Errors
///
/// The first error, with its field.
pub fn assemble(
    u: DirectionData,
    v: Option<DirectionData>,
    control_points: Points,
    weights: Option<Vec<f64>>,
) -> Result<Nurbs, InvalidNurbs> {
    let axes = if v.is_some() { ["u", "v"] } else { ["", ""] };
    let u = direction(u, axes[0])?;
    let v = v.map(|v| direction(v, axes[1])).transpose()?;
    let nurbs = Nurbs {
        u,
        v,
        points: control_points,
        weights,
    };
    check_counts(&nurbs)?;
    check_values(&nurbs)?;
    check_closing(&nurbs, axes)?;
    Ok(nurbs)
}

/// The weights of a net, row by row, whose weights are products of those of both directions. A direction without
/// weights has its number of control points.
pub fn products(u: Result<&[f64], usize>, v: Result<&[f64], usize>) -> Vec<f64> {
    let all = |direction: Result<&[f64], usize>| match direction {
        Ok(weights) => weights.to_vec(),
        Err(count) => vec![1.0; count],
    };
    let (u, v) = (all(u), all(v));
    let row = |a: &f64| v.iter().map(|b| a * b).collect::<Vec<f64>>();
    u.iter().flat_map(row).collect()
}

fn invalid(field: &str, axis: &str, detail: String) -> InvalidNurbs {
    let field = match axis {
        "" => field.to_owned(),
        _ => format!("{field}.{axis}"),
    };
    InvalidNurbs { field, detail }
}

fn direction(data: DirectionData, axis: &str) -> Result<KnotVector, InvalidNurbs> {
    let degree = data.degree;
    if !(1..=MOST_DEGREE).contains(&degree) {
        let detail = format!("{degree} is out of range; expected 1 to {MOST_DEGREE}");
        return Err(invalid("degree", axis, detail));
    }
    let bezier = || [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat();
    let knots = KnotVector {
        degree,
        knots: data.knots.unwrap_or_else(bezier),
        closed: data.closed,
    };
    check_knots(&knots).map_err(|detail| invalid("knots", axis, detail))?;
    Ok(knots)
}

fn check_knots(vector: &KnotVector) -> Result<(), String> {
    let KnotVector { degree, knots, .. } = vector;
    let least = 2 * (degree + 1);
    if knots.len() < least {
        let count = knots.len();
        return Err(format!(
            "{count} given; degree {degree} needs at least {least}"
        ));
    }
    if let Some(index) = knots.iter().position(|x| !x.is_finite()) {
        return Err(format!("number {index} is {}", knots[index]));
    }
    if let Some(index) = knots.windows(2).position(|pair| pair[0] > pair[1]) {
        return Err(format!(
            "number {} is less than the one before it",
            index + 1
        ));
    }
    let (low, high) = vector.domain();
    if low >= high {
        return Err(format!(
            "the curve starts and ends at {low}, so that it is empty"
        ));
    }
    let is_inside = |knot: f64| knot > low && knot < high;
    for (knot, times) in vector.multiplicities() {
        let most = if is_inside(knot) { *degree } else { degree + 1 };
        if times > most {
            return Err(format!(
                "{knot} occurs {times} times; at most {most} are allowed"
            ));
        }
    }
    Ok(())
}

fn check_counts(nurbs: &Nurbs) -> Result<(), InvalidNurbs> {
    let expected = nurbs.rows() * nurbs.columns();
    let found = nurbs.points.len();
    if nurbs.points.dimension() == 0 || found != expected {
        let detail = match &nurbs.v {
            None => format!(
                "there are {found}, and the knots and the degree are those of {expected}: control points are complete, \
                 on closed curves with the first ones repeated behind the last"
            ),
            Some(_) => format!(
                "there are {found}, and the knots and degrees are those of {} x {}",
                nurbs.rows(),
                nurbs.columns()
            ),
        };
        return Err(invalid("control_points", "", detail));
    }
    match &nurbs.weights {
        Some(weights) if weights.len() != expected => {
            let count = weights.len();
            let detail = format!("there are {count}, and {expected} control points");
            Err(invalid("weights", "", detail))
        }
        _ => Ok(()),
    }
}

fn check_values(nurbs: &Nurbs) -> Result<(), InvalidNurbs> {
    if let Some((coordinate, index)) = nurbs.bad_coordinate() {
        let value = nurbs.points.lane(coordinate)[index];
        let detail = format!("coordinate {coordinate} of number {index} is {value}");
        return Err(invalid("control_points", "", detail));
    }
    if let Some(index) = nurbs.bad_weight() {
        let weight = nurbs.weight(index);
        let detail = format!("number {index} is {weight}, and only positive ones can be written");
        return Err(invalid("weights", "", detail));
    }
    Ok(())
}

/// Closed directions return to their start.
fn check_closing(nurbs: &Nurbs, axes: [&str; 2]) -> Result<(), InvalidNurbs> {
    let (rows, columns) = (nurbs.rows(), nurbs.columns());
    let tolerance = SAME * nurbs.points.bounding_diagonal();
    let is_same = |i: usize, j: usize| {
        let (a, b) = (nurbs.weight(i), nurbs.weight(j));
        nurbs.points.distance(i, j) <= tolerance && (a - b).abs() <= SAME * a.max(b)
    };
    if let Some(repeated) = repeated(&nurbs.u) {
        let all = (0..repeated).flat_map(|i| (0..columns).map(move |j| (i, j)));
        let first = rows - repeated;
        for (i, j) in all {
            if !is_same(i * columns + j, (first + i) * columns + j) {
                return Err(open_end(axes[0], repeated));
            }
        }
    }
    if let Some(repeated) = nurbs.v.as_ref().and_then(repeated) {
        let all = (0..rows).flat_map(|i| (0..repeated).map(move |j| (i, j)));
        let first = columns - repeated;
        for (i, j) in all {
            if !is_same(i * columns + j, i * columns + first + j) {
                return Err(open_end(axes[1], repeated));
            }
        }
    }
    Ok(())
}

/// The number of control points of a closed direction that are repeated at its end.
fn repeated(knots: &KnotVector) -> Option<usize> {
    let count = if knots.is_periodic() { knots.degree } else { 1 };
    (knots.closed && count < knots.count()).then_some(count)
}

fn open_end(axis: &str, repeated: usize) -> InvalidNurbs {
    let detail = match repeated {
        1 => "the last control point is not the first one".to_owned(),
        _ => format!("the last {repeated} control points are not the first ones again"),
    };
    invalid("closed", axis, detail)
}
