//! Least squares with each setting besides numbers of control points and variants.

use super::kinds::{points, size};
use piad_fit::data::Grid;
use piad_fit::invalid::{Axis, Side};
use piad_fit::method::{At, Constraint, EndPoints, Fairness, LeastSquares, Method, Wanted};

/// For data with three coordinates.
pub(super) fn methods(surface: bool) -> Vec<Method> {
    let plain = LeastSquares::new(6, if surface { 5 } else { 6 });
    let with = |change: &dyn Fn(&mut LeastSquares)| {
        let mut settings = plain.clone();
        change(&mut settings);
        settings
    };
    let fair = |value, order| {
        with(&|it| {
            it.fairness = Some(Fairness {
                value,
                order,
                by_data: false,
            })
        })
    };
    let weights = (0..size(surface).count()).map(|i| 0.1 * i as f64);
    let mut settings = vec![
        with(&|it| it.ends = EndPoints::Free),
        with(&|it| it.ends = EndPoints::Interpolated),
        with(&|it| it.data_weights = Some(weights.clone().collect())),
        fair(1e-300, 2),
        fair(0.1, 3),
        fair(0.0, 2),
        with(&|it| it.gap_stiffness = surface.then_some(1e-300)),
    ];
    let constraints = if surface { of_surface() } else { of_curve() };
    let constraints = constraints.into_iter();
    settings.extend(constraints.map(|(at, wanted)| {
        let also = Constraint {
            at: At::Index(8),
            wanted: Wanted::DataPoint,
        };
        let constraints = [Constraint { at, wanted }, also].into();
        with(&|it| it.constraints = std::sync::Arc::clone(&constraints))
    }));
    settings.into_iter().map(Method::LeastSquares).collect()
}

fn derivative(orders: [usize; 2]) -> Wanted {
    Wanted::Derivative {
        orders,
        vector: vec![0.1, -0.0, 1e-300],
    }
}

fn of_curve() -> Vec<(At, Wanted)> {
    let orders = [[0, 0], [1, 0], [2, 0]];
    let mut kinds: Vec<_> = orders
        .map(|orders| (At::Index(5), derivative(orders)))
        .into();
    kinds.push((At::Parameter(0.1), derivative([0, 0])));
    kinds.push((At::Side(Side::Start), derivative([1, 0])));
    let tangent = Wanted::Tangent(vec![-0.0, 2.0, 0.1]);
    kinds.push((At::Side(Side::End), tangent));
    kinds
}

fn of_surface() -> Vec<(At, Wanted)> {
    let across = |order, rows| Wanted::Across {
        order,
        control_points: points(Grid { rows, columns: 1 }, 3),
    };
    let orders = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];
    let mut kinds: Vec<_> = orders
        .map(|orders| (At::Index(15), derivative(orders)))
        .into();
    kinds.push((At::Parameters(0.1, 0.2), derivative([0, 0])));
    for side in [Side::Start, Side::End] {
        kinds.push((At::Boundary(Axis::U, side), across(0, 5)));
        kinds.push((At::Boundary(Axis::V, side), across(1, 6)));
    }
    kinds
}
