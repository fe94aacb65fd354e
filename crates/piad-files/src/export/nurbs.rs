//! The curve or surface as CAD kernels store it, with validation: the model that all exact formats
//! write.

use super::error::{ExportError, NetIndex};
use piad_fit::data::Points;
use piad_fit::engine::Problem;

pub use super::assemble::{DirectionData, InvalidNurbs, assemble, products};
pub use piad_fit::geometry::{KnotVector, Nurbs};

/// The B-spline form of a fit, if its weights are positive and its control points finite.
///
/// # Errors
///
/// The first control point that violates this.
pub fn checked(problem: &Problem, control_points: &Points) -> Result<Nurbs, ExportError> {
    let nurbs = Nurbs::of(problem, control_points);
    check(&nurbs)?;
    Ok(nurbs)
}

/// Refuses weights that are not positive and control points that are not finite.
pub(super) fn check(nurbs: &Nurbs) -> Result<(), ExportError> {
    let place = |index| NetIndex::new(index, nurbs.v.as_ref().map(KnotVector::count));
    if let Some(index) = nurbs.bad_weight() {
        return Err(ExportError::Weight {
            place: place(index),
            weight: nurbs.weight(index),
        });
    }
    if let Some((coordinate, index)) = nurbs.bad_coordinate() {
        return Err(ExportError::NotFinite {
            what: "control point",
            place: place(index),
            coordinate,
            value: nurbs.points.lane(coordinate)[index],
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {

    use super::*;
    use piad_fit::basis::BasisChoice;
    use piad_fit::basis::Knots;
    use piad_fit::basis::{End, Ends};
    use piad_fit::data::Grid;
    use piad_fit::engine::DirectionChoice;
    use piad_fit::engine::{Request, Tolerance};
    use piad_fit::parameters::Parametrization;

    const SQUARE: [[f64; 2]; 5] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 3.0], [0.0, 2.0]];

    fn problem(degree: usize, closed: bool, weights: Option<Vec<f64>>) -> Problem {
        let mut points = Points::new(2);
        SQUARE.iter().for_each(|point| points.push(point));
        let u = DirectionChoice {
            closed,
            ends: (!closed).then(|| Ends::both(End::Repeated)),
            weights,
            ..DirectionChoice::new(
                BasisChoice::BSpline {
                    degree,
                    knots: Knots::Usual,
                },
                Parametrization::Uniform,
            )
        };
        Problem::new(Request {
            tolerance: Some(Tolerance::Relative(1e-6)),
            max_iterations: 10,
            ..Request::new(
                points,
                Grid {
                    rows: SQUARE.len(),
                    columns: 1,
                },
                u,
                None,
            )
        })
        .unwrap()
    }

    #[test]
    fn end_copies_are_part_of_the_net() {
        let problem = problem(3, false, None);
        let nurbs = checked(&problem, problem.data()).unwrap();
        assert_eq!(nurbs.points.lane(0), [0.0, 0.0, 2.0, 2.0, 1.0, 0.0, 0.0]);
        assert_eq!(nurbs.rows(), 7);
        assert_eq!(nurbs.u.domain(), (0.0, 1.0));
        let expected = [(0.0, 4), (0.25, 1), (0.5, 1), (0.75, 1), (1.0, 4)];
        assert_eq!(nurbs.u.multiplicities(), expected);
        assert_eq!(nurbs.place(3), [2.0, 2.0, 0.0]);
    }

    /// The knots run on over both ends of the period, and the first p control points are repeated.
    #[test]
    fn closed_curves_repeat_their_first_control_points() {
        for degree in 1..=4 {
            let problem = problem(degree, true, None);
            let nurbs = checked(&problem, problem.data()).unwrap();
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
        let nurbs = checked(&problem, problem.data()).unwrap();
        let expected = [1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0];
        assert_eq!(nurbs.weights.as_deref(), Some(expected.as_slice()));
        assert_eq!(nurbs.points.lane(1), [0.0, 0.0, 0.0, 2.0, 3.0, 2.0, 2.0]);
    }

    #[test]
    fn small_models_have_a_fine_resolution() {
        let problem = problem(3, false, None);
        let mut nurbs = checked(&problem, problem.data()).unwrap();
        assert_eq!(nurbs.resolution(), 1e-7);
        for lane in nurbs.points.lanes_mut() {
            lane.iter_mut().for_each(|x| *x *= 1e-3);
        }
        assert!(nurbs.resolution() < 1e-9);
    }
}
