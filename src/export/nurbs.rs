//! The curve or surface as CAD kernels store it, checked: the model that all exact formats write.

use super::error::{ExportError, NetIndex};
use crate::fit::points::Points;
use crate::fit::problem::Problem;

pub use crate::fit::nurbs::{KnotVector, Nurbs};

/// The place of a point in space: points of the plane have z = 0.
pub(super) fn in_space(coordinates: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut place = [0.0; 3];
    for (x, coordinate) in place.iter_mut().zip(coordinates) {
        *x = coordinate;
    }
    place
}

impl Nurbs {
    /// The B-spline form of a fit, if its weights are positive and its control points finite.
    pub fn new(problem: &Problem, control_points: &Points) -> Result<Self, ExportError> {
        let nurbs = Self::of(problem, control_points);
        nurbs.check_weights()?;
        nurbs.check_places()?;
        Ok(nurbs)
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

    fn place_of(&self, index: usize) -> NetIndex {
        NetIndex::new(index, self.v.as_ref().map(KnotVector::count))
    }

    fn check_weights(&self) -> Result<(), ExportError> {
        match self.bad_weight() {
            None => Ok(()),
            Some(index) => Err(ExportError::Weight {
                place: self.place_of(index),
                weight: self.weight(index),
            }),
        }
    }

    fn check_places(&self) -> Result<(), ExportError> {
        match self.bad_coordinate() {
            None => Ok(()),
            Some((coordinate, index)) => Err(ExportError::NotFinite {
                what: "control point",
                place: self.place_of(index),
                coordinate,
                value: self.points.lane(coordinate)[index],
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::fit::basis::knots::Knots;
    use crate::fit::direction::{BasisChoice, DirectionChoice};
    use crate::fit::ends::{End, Ends};
    use crate::fit::method::Method;
    use crate::fit::parameters::Parametrization;
    use crate::fit::points::Grid;
    use crate::fit::problem::{Request, Tolerance, Weights};

    const SQUARE: [[f64; 2]; 5] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 3.0], [0.0, 2.0]];

    fn problem(degree: usize, closed: bool, weights: Option<Vec<f64>>) -> Problem {
        let mut points = Points::new(2);
        SQUARE.iter().for_each(|point| points.push(point));
        let u = DirectionChoice {
            basis: BasisChoice::BSpline {
                degree,
                knots: Knots::Usual,
            },
            parameters: Parametrization::Uniform,
            closed,
            control_points: None,
            ends: (!closed).then(|| Ends::both(End::Repeated)),
            weights,
        };
        Problem::new(Request {
            start_breaks: None,
            grid: Grid {
                rows: points.len(),
                columns: 1,
            },
            points: Arc::new(points),
            missing: Vec::new(),
            u,
            v: None,
            weights: Weights::None,
            method: Method::Global,
            selected: None,
            start: None,
            lambda_min: None,
            scattered: None,
            tolerance: Some(Tolerance::Relative(1e-6)),
            max_iterations: 10,
        })
        .unwrap()
    }

    #[test]
    fn end_copies_are_part_of_the_net() {
        let problem = problem(3, false, None);
        let nurbs = Nurbs::new(&problem, problem.data()).unwrap();
        assert_eq!(nurbs.points.lane(0), [0.0, 0.0, 2.0, 2.0, 1.0, 0.0, 0.0]);
        assert_eq!(nurbs.rows(), 7);
        assert_eq!(nurbs.u.domain(), (0.0, 1.0));
        let expected = [(0.0, 4), (0.25, 1), (0.5, 1), (0.75, 1), (1.0, 4)];
        assert_eq!(nurbs.u.multiplicities(), expected);
        assert_eq!(nurbs.place(3), [2.0, 2.0, 0.0]);
    }

    /// The knots run on over both ends of the period, and the first p control points come again.
    #[test]
    fn closed_curves_repeat_their_first_control_points() {
        for degree in 1..=4 {
            let problem = problem(degree, true, None);
            let nurbs = Nurbs::new(&problem, problem.data()).unwrap();
            assert!(nurbs.u.closed);
            assert_eq!(nurbs.rows(), 5 + degree);
            for lane in nurbs.points.lanes() {
                assert_eq!(lane[..degree], lane[5..]);
            }
            let (low, high) = nurbs.u.domain();
            assert!((high - low - 1.0).abs() < 1e-15);
            assert_eq!(nurbs.u.multiplicities().len(), nurbs.u.knots.len());
        }
    }

    #[test]
    fn weights_of_functions_are_weights_of_control_points() {
        let weights = vec![1.0, 2.0, 3.0, 4.0, 5.0];
        let problem = problem(3, false, Some(weights));
        let nurbs = Nurbs::new(&problem, problem.data()).unwrap();
        let expected = [1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0];
        assert_eq!(nurbs.weights.as_deref(), Some(expected.as_slice()));
        assert_eq!(nurbs.points.lane(1), [0.0, 0.0, 0.0, 2.0, 3.0, 2.0, 2.0]);
    }

    #[test]
    fn small_models_have_a_fine_resolution() {
        let problem = problem(3, false, None);
        let mut nurbs = Nurbs::new(&problem, problem.data()).unwrap();
        assert_eq!(nurbs.resolution(), 1e-7);
        for lane in nurbs.points.lanes_mut() {
            lane.iter_mut().for_each(|x| *x *= 1e-3);
        }
        assert!(nurbs.resolution() < 1e-9);
    }
}
