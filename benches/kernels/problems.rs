//! The problems of the benches.

use std::f64::consts::TAU;
use std::sync::Arc;

use piad_fit::basis::{BasisChoice, Knots};
use piad_fit::data::{Grid, Points};
use piad_fit::engine::{DirectionChoice, Problem, Request, System, Tolerance};
use piad_fit::method::Method;
use piad_fit::parameters::Parametrization;

/// A rippled spiral in space.
pub(crate) fn spiral(count: usize) -> Points {
    let mut points = Points::new(3);
    for i in 0..count {
        let t = 60.0 * i as f64 / count as f64;
        let r = 1.0 + t / 10.0 + 0.05 * (20.0 * t).sin();
        points.push(&[r * t.cos(), r * t.sin(), 0.3 * t]);
    }
    points
}

/// A rippled height field over a square.
pub(crate) fn field(side: usize) -> Points {
    let mut points = Points::new(3);
    for i in 0..side * side {
        let [x, y] = [i / side, i % side].map(|k| k as f64 / side as f64);
        points.push(&[x, y, (TAU * 3.0 * x).sin() * (TAU * 5.0 * y).cos()]);
    }
    points
}

/// A cubic direction with knots at the data.
fn cubic() -> DirectionChoice {
    DirectionChoice::new(
        BasisChoice::BSpline {
            degree: 3,
            knots: Knots::Data,
        },
        Parametrization::ChordLength,
    )
}

/// Cubic, or bicubic if the grid has more than one column.
pub(crate) fn request(points: impl Into<Arc<Points>>, grid: Grid, method: Method) -> Request {
    Request {
        method,
        tolerance: Some(Tolerance::Absolute(0.0)),
        max_iterations: usize::MAX,
        ..Request::new(points, grid, cubic(), (grid.columns > 1).then(cubic))
    }
}

/// A curve ready to be iterated.
pub(crate) fn curve(count: usize, method: Method) -> Arc<System> {
    let grid = Grid {
        rows: count,
        columns: 1,
    };
    system(request(spiral(count), grid, method))
}

/// A surface ready to be iterated.
pub(crate) fn surface(side: usize, method: Method) -> Arc<System> {
    let grid = Grid {
        rows: side,
        columns: side,
    };
    system(request(field(side), grid, method))
}

fn system(request: Request) -> Arc<System> {
    let problem = Problem::new(request).expect("the problem is valid");
    Arc::new(System::new(Arc::new(problem)))
}
