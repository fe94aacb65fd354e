//! The curve or surface as CAD kernels store it: B-splines, whatever basis the fit has.

pub(crate) mod derivatives;
pub(crate) mod sampling;

use std::borrow::Cow;

use super::evaluation::Geometry;
use crate::basis::Basis;
use crate::basis::bezier::ToBezier;
use crate::basis::direction::Direction;
use crate::data::points::Points;
use crate::data::vectors::in_space;
use crate::setup::Setup;

/// The B-spline basis of one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct KnotVector {
    /// The degree p.
    pub degree: usize,
    /// Non-decreasing knots, p + 1 more than control points. Clamped, or of a closed direction without corners
    /// the knots of a period, continued by p on both sides.
    pub knots: Vec<f64>,
    /// True if the direction returns to its start.
    pub closed: bool,
}

impl KnotVector {
    /// The knots of a direction; those of Bézier curves for all polynomial bases.
    pub(crate) fn new(direction: &Direction) -> Self {
        let degree = direction.basis.degree();
        let knots = direction.basis.knots().map(Cow::into_owned);
        Self {
            degree,
            knots: knots.unwrap_or_else(|| bezier(degree)),
            closed: direction.is_closed(),
        }
    }

    /// The one function that is constant on [0, 1].
    pub(crate) fn constant() -> Self {
        Self {
            degree: 0,
            knots: vec![0.0, 1.0],
            closed: false,
        }
    }

    /// Returns true if the direction is closed and its knots are not clamped: then the last p control points are the first ones
    /// again.
    pub fn is_periodic(&self) -> bool {
        self.closed && self.knots[0] < self.knots[self.degree]
    }

    /// The number of control points.
    pub fn count(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// The interval on which the curve is defined.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.count()])
    }

    /// The knot spans of the domain that are not empty: `knots[span] < knots[span + 1]`.
    pub fn spans(&self) -> Vec<usize> {
        let spans = self.degree..self.count();
        spans
            .filter(|&span| self.knots[span] < self.knots[span + 1])
            .collect()
    }

    /// The distinct knots with their multiplicities.
    pub fn multiplicities(&self) -> Vec<(f64, usize)> {
        let equal = self.knots.chunk_by(|a, b| a == b);
        equal.map(|knots| (knots[0], knots.len())).collect()
    }
}

/// The knots 0 and 1, p + 1 times each.
fn bezier(degree: usize) -> Vec<f64> {
    let mut knots = vec![0.0; degree + 1];
    knots.resize(2 * (degree + 1), 1.0);
    knots
}

/// A B-spline curve or surface, polynomial or rational (PT97 (4.1), (4.15)).
#[derive(Clone, Debug, PartialEq)]
pub struct Nurbs {
    /// The direction of a curve; of a surface the direction along its columns, from row to row.
    pub u: KnotVector,
    /// The second direction of a surface.
    pub v: Option<KnotVector>,
    /// The complete control net, row by row: Cartesian coordinates, not multiplied by weights.
    pub points: Points,
    /// Their weights, all positive, if the curve or surface is rational.
    pub weights: Option<Vec<f64>>,
}

impl Nurbs {
    /// The B-spline form of a fit: exact, whatever its basis. Weights can be zero or negative, and
    /// points infinite or NaN where they are.
    pub fn of(setup: &Setup, control_points: &Points) -> Self {
        let mut net = ConvertedNet::new(setup, control_points);
        net.leave_ball_bases(setup);
        Self {
            u: KnotVector::new(setup.u()),
            v: setup.v().map(KnotVector::new),
            weights: net.weights(),
            points: net.places(),
        }
    }

    /// The number of control points in the u direction.
    pub fn rows(&self) -> usize {
        self.u.count()
    }

    /// The number of control points in the v direction; one for a curve.
    pub fn columns(&self) -> usize {
        self.v.as_ref().map_or(1, KnotVector::count)
    }

    /// The weight of a control point.
    pub fn weight(&self, index: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |weights| weights[index])
    }

    /// The place of a control point in space; curves and surfaces of the plane have z = 0.
    pub fn place(&self, index: usize) -> [f64; 3] {
        in_space(self.points.point(index))
    }

    /// The length below which differences are meaningless, which CAD systems call the accuracy of a model:
    /// 10⁻⁷ of the extent, but at most 10⁻⁷, the usual value.
    pub fn resolution(&self) -> f64 {
        let extent = self.points.bounding_diagonal();
        if extent > 0.0 && extent < 1.0 {
            1e-7 * extent
        } else {
            1e-7
        }
    }

    /// The first control point with a weight that is not a positive number: the curve or surface may
    /// leave the convex hull of its control points, or have a pole.
    pub fn bad_weight(&self) -> Option<usize> {
        let weights = self.weights.as_deref().unwrap_or_default();
        weights.iter().position(|w| !(*w > 0.0 && w.is_finite()))
    }

    /// The first coordinate that is infinite or NaN, and the first control point with one there.
    pub fn bad_coordinate(&self) -> Option<(usize, usize)> {
        let mut lanes = self.points.lanes().iter().enumerate();
        lanes.find_map(|(coordinate, lane)| {
            let index = lane.iter().position(|x| !x.is_finite())?;
            Some((coordinate, index))
        })
    }
}

/// The complete control net while it is converted to Cartesian points and weights.
struct ConvertedNet {
    rows: usize,
    columns: usize,
    /// Coordinates, multiplied by the weights if there are some.
    lanes: Vec<Vec<f64>>,
    weights: Option<Vec<f64>>,
    /// Weights of the basis functions, by which the coordinates are not multiplied.
    fixed: Option<Vec<f64>>,
}

impl ConvertedNet {
    fn new(setup: &Setup, control_points: &Points) -> Self {
        let geometry = Geometry::new(setup, control_points);
        let (rows, columns) = (geometry.rows(), geometry.columns().unwrap_or(1));
        let mut lanes = geometry.net();
        let weights = if setup.is_homogeneous() {
            lanes.pop()
        } else {
            None
        };
        Self {
            rows,
            columns,
            lanes,
            weights,
            fixed: fixed_weights(setup, rows, columns),
        }
    }

    /// Converts directions with a Ball basis to Bézier form; rational fits in homogeneous coordinates, in
    /// which they are polynomial.
    fn leave_ball_bases(&mut self, setup: &Setup) {
        let u = to_bezier(setup.u());
        let v = setup.v().and_then(to_bezier);
        if u.is_none() && v.is_none() {
            return;
        }
        if let Some(fixed) = self.fixed.take() {
            let own = self.weights.iter_mut();
            for lane in self.lanes.iter_mut().chain(own) {
                lane.iter_mut().zip(&fixed).for_each(|(x, w)| *x *= w);
            }
            self.weights.get_or_insert(fixed);
        }
        for lane in self.lanes.iter_mut().chain(&mut self.weights) {
            if let Some(matrix) = &u {
                (0..self.columns).for_each(|column| matrix.convert(lane, column, self.columns));
            }
            if let Some(matrix) = &v {
                (0..self.rows).for_each(|row| matrix.convert(lane, row * self.columns, 1));
            }
        }
    }

    /// The weights of a CAD kernel: the products of the weights of control points and of basis functions.
    fn weights(&self) -> Option<Vec<f64>> {
        match (&self.weights, &self.fixed) {
            (Some(own), Some(fixed)) => Some(own.iter().zip(fixed).map(|(a, b)| a * b).collect()),
            (own, fixed) => own.clone().or_else(|| fixed.clone()),
        }
    }

    fn places(mut self) -> Points {
        if let Some(weights) = &self.weights {
            for lane in &mut self.lanes {
                lane.iter_mut().zip(weights).for_each(|(x, w)| *x /= w);
            }
        }
        Points::from_lanes(self.lanes)
    }
}

/// The weights of the basis functions; those of a surface are products of both directions.
fn fixed_weights(setup: &Setup, rows: usize, columns: usize) -> Option<Vec<f64>> {
    if !setup.directions().any(Direction::is_rational) {
        return None;
    }
    let of = |direction: Option<&Direction>, j: usize| {
        let weights = direction.and_then(Direction::weights);
        weights.map_or(1.0, |weights| weights[j])
    };
    let row = |i| (0..columns).map(move |j| of(Some(setup.u()), i) * of(setup.v(), j));
    Some((0..rows).flat_map(row).collect())
}

fn to_bezier(direction: &Direction) -> Option<ToBezier> {
    match &direction.basis {
        Basis::Polynomial { kind, degree } => ToBezier::new(*kind, *degree),
        Basis::BSpline { .. } => None,
    }
}
